"""Changing the mode."""

import math

import pytest
from ground import ACCEPTED, CRUISE, DENIED, FAILED, GUIDED, LOITER, RTL
from pymavlink.dialects.v20 import ardupilotmega as mavlink

LOITER_RADIUS_M = 60


@pytest.mark.parametrize("mode", [LOITER, CRUISE, RTL])
def test_a_mode_is_taken_and_left_again(craft, mode):
    assert craft.set_mode(mode) == ACCEPTED
    assert craft.mode() == mode
    assert craft.set_mode(GUIDED) == ACCEPTED
    assert craft.mode() == GUIDED


def test_the_older_message_changes_the_mode_too(craft):
    craft.link.set_mode("LOITER")
    assert craft.wait(["HEARTBEAT"], lambda heartbeat: heartbeat.custom_mode == LOITER)
    assert craft.link.flightmode == "LOITER"


@pytest.mark.parametrize(("mode", "text"), [(10, "Auto: no mission"), (13, "Mode TAKEOFF is not simulated"), (99, "No such mode 99")])
def test_an_unknown_mode_is_refused_in_words(craft, mode, text):
    assert craft.set_mode(mode) == FAILED
    assert craft.text().text == text
    assert craft.mode() == GUIDED


def test_only_custom_modes_are_known(craft):
    armed_and_guided = mavlink.MAV_MODE_GUIDED_ARMED & ~mavlink.MAV_MODE_FLAG_CUSTOM_MODE_ENABLED
    assert craft.command_long(mavlink.MAV_CMD_DO_SET_MODE, armed_and_guided, 0) == DENIED
    assert craft.mode() == GUIDED


def test_loiter_circles_where_it_was_entered(start_vehicles, scenario):
    craft = start_vehicles(scenario(), "--speed", 20).connect()[0]
    assert craft.set_mode(LOITER) == ACCEPTED
    entry = craft.sample()
    *_, last = craft.samples(60)
    # From the entry to the first sample after it the vehicle flies at 10 m/s for a few tenths of a second.
    assert math.dist((last.x_m, last.y_m), (entry.x_m, entry.y_m)) == pytest.approx(LOITER_RADIUS_M, abs=4)
    assert last.altitude_m == pytest.approx(50, abs=1e-2)
    assert last.speed_mps == pytest.approx(10, abs=1e-2)


def test_cruise_holds_its_course_and_takes_no_setpoint(craft):
    assert craft.set_mode(CRUISE) == ACCEPTED
    craft.setpoint(13, math.radians(60), 60)
    assert craft.text().text.startswith("Setpoint refused")
    *_, last = craft.samples(4)
    assert (last.speed_mps, last.course_rad, last.altitude_m) == pytest.approx((10, 0, 50), abs=1e-2)
