"""Commands that are refused: with which result, and that nothing changes."""

import math

import pytest
from ground import ACCEPTED, DENIED, FAILED, LOITER, UNSUPPORTED
from pymavlink.dialects.v20 import ardupilotmega as mavlink

NAN, INFINITY = math.nan, math.inf

REFUSED = {
    "a speed above the limit": (lambda craft: craft.change_speed(15.1), FAILED),
    "a speed below the limit": (lambda craft: craft.change_speed(4.9), FAILED),
    "a speed that is not a number": (lambda craft: craft.change_speed(NAN), DENIED),
    "an infinite speed": (lambda craft: craft.change_speed(INFINITY), DENIED),
    "a ground speed": (lambda craft: craft.command_int(mavlink.MAV_CMD_GUIDED_CHANGE_SPEED, 1, 12), DENIED),
    "a heading of a full circle": (lambda craft: craft.change_heading(360), DENIED),
    "a negative heading": (lambda craft: craft.change_heading(-1), DENIED),
    "a heading that is not a number": (lambda craft: craft.change_heading(NAN), DENIED),
    "an altitude that is not a number": (lambda craft: craft.change_altitude(NAN), DENIED),
    "an altitude of zero": (lambda craft: craft.change_altitude(0), DENIED),
    "an altitude of minus one": (lambda craft: craft.change_altitude(-1), DENIED),
    "a take-off": (lambda craft: craft.command_long(mavlink.MAV_CMD_NAV_TAKEOFF, p7=100), FAILED),
    "a command of another trade": (lambda craft: craft.command_long(mavlink.MAV_CMD_DO_ORBIT, 80), UNSUPPORTED),
    "a servo that is not there": (lambda craft: craft.command_long(mavlink.MAV_CMD_DO_SET_SERVO, 1, 1500), FAILED),
    "a command that nobody knows": (lambda craft: craft.command_long(59_999, 1, 2), UNSUPPORTED),
    "the same in the other message": (lambda craft: craft.command_int(59_999, 1, 2), UNSUPPORTED),
}


@pytest.mark.parametrize("name", REFUSED)
def test_it_is_refused_and_nothing_changes(craft, name):
    send, result = REFUSED[name]
    assert send(craft) == result
    *_, last = craft.samples(3)
    assert (last.speed_mps, last.course_rad, last.altitude_m) == pytest.approx((10, 0, 50), abs=1e-2)


@pytest.mark.parametrize(
    "change",
    [
        lambda craft: craft.change_speed(12),
        lambda craft: craft.change_altitude(60),
        lambda craft: craft.change_heading(90),
    ],
    ids=["speed", "altitude", "heading"],
)
def test_outside_guided_a_guided_command_fails(craft, change):
    assert craft.set_mode(LOITER) == ACCEPTED
    assert change(craft) == FAILED
    assert craft.text().text.endswith("mode is LOITER")


def test_a_setpoint_that_it_cannot_fly_is_refused_in_words(craft):
    craft.setpoint(NAN, 0, 50)
    assert craft.text().text == "Setpoint refused: a field is not a finite number"
    *_, last = craft.samples(3)
    assert (last.speed_mps, last.course_rad, last.altitude_m) == pytest.approx((10, 0, 50), abs=1e-2)


def test_a_command_for_somebody_else_is_not_answered(craft):
    craft.link.mav.command_long_send(craft.system + 1, 1, mavlink.MAV_CMD_DO_SET_MODE, 0, 1, LOITER, 0, 0, 0, 0, 0)
    kinds = [message.get_type() for message in craft.collect(["COMMAND_ACK", "HEARTBEAT"], 3)]
    assert "HEARTBEAT" in kinds and "COMMAND_ACK" not in kinds
