"""DO_CHANGE_ALTITUDE and DO_CHANGE_SPEED, as ArduPlane takes them."""

import pytest
from ground import ACCEPTED, CRUISE, DENIED, FAILED, GUIDED, LOITER
from pymavlink.dialects.v20 import ardupilotmega as mavlink

RELATIVE = mavlink.MAV_FRAME_GLOBAL_RELATIVE_ALT
ALTITUDE, SPEED = mavlink.MAV_CMD_DO_CHANGE_ALTITUDE, mavlink.MAV_CMD_DO_CHANGE_SPEED


@pytest.fixture
def fast(start_vehicles, scenario):
    return start_vehicles(scenario(), "--speed", 10).connect()[0]


@pytest.mark.parametrize("mode", [GUIDED, LOITER])
@pytest.mark.parametrize("ask", ["command_long", "command_int"])
def test_the_altitude_is_changed(fast, mode, ask):
    assert fast.set_mode(mode) == ACCEPTED
    assert getattr(fast, ask)(ALTITUDE, 60, RELATIVE) == ACCEPTED
    *_, last = fast.samples(25)
    assert last.altitude_m == pytest.approx(60, abs=0.1)
    assert fast.mode() == mode


def test_a_guided_altitude_has_precedence_until_the_mode_changes(fast):
    assert fast.change_altitude(70) == ACCEPTED
    assert fast.command_long(ALTITUDE, 60, RELATIVE) == ACCEPTED
    *_, last = fast.samples(25)
    assert last.altitude_m == pytest.approx(70, abs=0.1)
    assert fast.set_mode(LOITER) == ACCEPTED
    assert fast.command_long(ALTITUDE, 60, RELATIVE) == ACCEPTED
    *_, last = fast.samples(25)
    assert last.altitude_m == pytest.approx(60, abs=0.1)


@pytest.mark.parametrize("frame", [0, 3, 5, 6, 10, 11])
def test_a_global_frame_is_accepted(craft, frame):
    assert craft.command_int(ALTITUDE, 60, frame) == ACCEPTED


@pytest.mark.parametrize("frame", [1, 2, 8, 99, -1, 1e10])
def test_another_frame_is_denied(craft, frame):
    assert craft.command_long(ALTITUDE, 60, frame) == DENIED
    assert craft.text().text.endswith("is not accepted")


def test_by_hand_an_altitude_is_accepted_and_has_no_effect(fast):
    # GCS_MAVLink_Plane.cpp: handle_command_int_DO_CHANGE_ALTITUDE asks for no mode.
    before, *_ = fast.samples(1)
    assert fast.set_mode(CRUISE) == ACCEPTED
    assert fast.command_long(ALTITUDE, 60, RELATIVE) == ACCEPTED
    *_, last = fast.samples(20)
    assert last.altitude_m == pytest.approx(before.altitude_m, abs=0.5)


def test_the_usual_speed_comes_back(fast):
    assert fast.command_long(SPEED, 0, 12) == ACCEPTED
    *_, last = fast.samples(20)
    assert last.speed_mps == pytest.approx(12, abs=0.01)
    assert fast.command_long(SPEED, 0, -2) == ACCEPTED
    *_, last = fast.samples(20)
    assert last.speed_mps == pytest.approx(10, abs=0.01)


def test_a_throttle_is_accepted_and_changes_nothing(fast):
    assert fast.command_long(SPEED, 0, -1, 60) == ACCEPTED
    *_, last = fast.samples(10)
    assert last.speed_mps == pytest.approx(10, abs=0.01)
    assert fast.command_long(SPEED, 0, -1, -1) == FAILED


def test_a_frame_that_nobody_knows_is_refused_after_the_mode(craft):
    unknown = 99
    assert craft.command_int(mavlink.MAV_CMD_GUIDED_CHANGE_ALTITUDE, z=60, frame=unknown) == DENIED
    assert craft.command_int(mavlink.MAV_CMD_DO_REPOSITION, -1, z=60, frame=unknown) == DENIED
    assert craft.set_mode(LOITER) == ACCEPTED
    assert craft.command_int(mavlink.MAV_CMD_GUIDED_CHANGE_ALTITUDE, z=60, frame=unknown) == FAILED


def test_latitude_and_longitude_of_zero_are_no_place(craft):
    assert craft.command_int(mavlink.MAV_CMD_DO_REPOSITION, -1, z=60) == DENIED
    assert craft.text().text == "Reposition: no such place"
    assert craft.mode() == GUIDED
