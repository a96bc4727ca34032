"""Changing the mode."""

import math

import pytest
from ground import ACCEPTED, CRUISE, DENIED, FAILED, GUIDED, LOITER, RTL, UNSUPPORTED
from pymavlink.dialects.v20 import ardupilotmega as mavlink

LOITER_RADIUS_M = 60
TAKEOFF = 13


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


@pytest.mark.parametrize(("mode", "text"), [(14, "Mode AVOID_ADSB is not simulated"), (99, "No such mode 99")])
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


def test_takeoff_climbs_straight_on_and_circles(start_vehicles, scenario):
    craft = start_vehicles(scenario(armed=False), "--speed", 20).connect()[0]
    craft.link.mav.param_set_send(craft.system, 1, b"TKOFF_ALT", 90, mavlink.MAV_PARAM_TYPE_REAL32)
    craft.wait(["PARAM_VALUE"])
    assert craft.set_mode(TAKEOFF) == ACCEPTED
    assert craft.command_long(mavlink.MAV_CMD_COMPONENT_ARM_DISARM, 1) == ACCEPTED
    track = craft.samples(120)
    assert track[-1].altitude_m == pytest.approx(90, abs=0.1)
    up = next(at for at in track if at.altitude_m > 88)
    assert abs(up.y_m) < 20 and up.x_m > 40, "it climbs on its course"
    assert math.dist((track[-1].x_m, track[-1].y_m), (up.x_m, up.y_m)) == pytest.approx(LOITER_RADIUS_M, abs=6)
    assert craft.mode() == TAKEOFF


def test_a_place_is_flown_to_and_circled(start_vehicles, scenario):
    craft = start_vehicles(scenario(), "--speed", 20).connect()[0]
    north = round((39.98 + 400 / 111_030) * 1e7), round(116.34 * 1e7)

    def reposition(place, z, change_mode=1, radius=0):
        craft.link.mav.command_int_send(
            craft.system, 1, mavlink.MAV_FRAME_GLOBAL_RELATIVE_ALT, mavlink.MAV_CMD_DO_REPOSITION, 0, 0,
            -1, change_mode, radius, math.nan, *place, z,
        )  # fmt: skip
        return craft.acknowledged(mavlink.MAV_CMD_DO_REPOSITION)

    assert craft.set_mode(CRUISE) == ACCEPTED
    assert reposition(north, 70, change_mode=0) == FAILED
    assert reposition((2**31 - 1, 0), 70) == DENIED
    assert reposition(north, math.nan) == DENIED
    assert craft.command_long(mavlink.MAV_CMD_DO_REPOSITION, -1, 1) == UNSUPPORTED
    assert craft.mode() == CRUISE
    assert reposition(north, 70, radius=40) == ACCEPTED
    *_, last = craft.samples(120)
    assert craft.mode() == GUIDED, "no time-out"
    assert math.dist((last.x_m, last.y_m), (400, 0)) == pytest.approx(40, abs=2)
    assert last.altitude_m == pytest.approx(70, abs=0.1)
