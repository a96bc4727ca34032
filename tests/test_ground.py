"""Vehicles that start on the ground: standing, taking off, landing, home."""

import math

import pytest
from ground import ACCEPTED, DENIED, FAILED, GUIDED, LOITER, RTL
from pymavlink.dialects.v20 import ardupilotmega as mavlink

MANUAL, AUTO, TAKEOFF = 0, 10, 13
ON_GROUND, IN_AIR = mavlink.MAV_LANDED_STATE_ON_GROUND, mavlink.MAV_LANDED_STATE_IN_AIR


@pytest.fixture
def grounded(start_vehicles, scenario):
    return start_vehicles(scenario(), "--on-ground", "--speed", 20).connect()[0]


def arm(craft, arm=1):
    return craft.command_long(mavlink.MAV_CMD_COMPONENT_ARM_DISARM, arm)


def landed_state(craft):
    return craft.request(mavlink.MAVLINK_MSG_ID_EXTENDED_SYS_STATE, "EXTENDED_SYS_STATE").landed_state


def home(craft):
    at = craft.request(mavlink.MAVLINK_MSG_ID_HOME_POSITION, "HOME_POSITION")
    return at.latitude, at.longitude, at.altitude


def upload(craft, items):
    """Items as (command, params, north m, east m, altitude m), after one for home."""
    rows = [(mavlink.MAV_CMD_NAV_WAYPOINT, (0, 0, 0, 0), 0, 0, 0), *items]
    craft.link.mav.mission_count_send(craft.system, 1, len(rows))
    while True:
        message = craft.wait(["MISSION_REQUEST", "MISSION_ACK"])
        if message.get_type() == "MISSION_ACK":
            return message.type
        command, params, north, east, altitude = rows[message.seq]
        craft.link.mav.mission_item_int_send(
            craft.system, 1, message.seq, mavlink.MAV_FRAME_GLOBAL_RELATIVE_ALT_INT, command, 0, 1, *params,
            *place(north, east), altitude,
        )  # fmt: skip


def place(north, east):
    """1e-7 degrees of a place near the scenario's origin, m; 0 and 0 for none."""
    if (north, east) == (0, 0):
        return 0, 0
    return round((39.98 + north / 111_033) * 1e7), round((116.34 + east / 85_421) * 1e7)


def test_it_stands_disarmed_in_manual_and_at_home(grounded):
    heartbeat = grounded.wait(["HEARTBEAT"])
    assert (heartbeat.base_mode, heartbeat.custom_mode) == (81, MANUAL)
    assert heartbeat.system_status == mavlink.MAV_STATE_STANDBY
    assert landed_state(grounded) == ON_GROUND
    assert {(at.x_m, at.y_m, at.altitude_m, at.speed_mps) for at in grounded.samples(5)} == {(0, 0, 0, 0)}
    assert grounded.wait(["GLOBAL_POSITION_INT"]).relative_alt == 0


@pytest.mark.parametrize("mode", [MANUAL, GUIDED, LOITER])
def test_armed_it_stays_on_the_ground_until_a_mode_takes_off(grounded, mode):
    assert grounded.set_mode(mode) == ACCEPTED
    assert arm(grounded) == ACCEPTED
    assert {(at.altitude_m, at.speed_mps) for at in grounded.samples(5)} == {(0, 0)}
    assert arm(grounded, 0) == ACCEPTED


def test_mode_takeoff_takes_off(grounded):
    grounded.set_rate(mavlink.MAVLINK_MSG_ID_EXTENDED_SYS_STATE, 5)
    assert grounded.set_mode(TAKEOFF) == ACCEPTED
    assert arm(grounded) == ACCEPTED
    states = [message.landed_state for message in grounded.collect(["EXTENDED_SYS_STATE"], 60)]
    assert list(dict.fromkeys(states)) == [ON_GROUND, mavlink.MAV_LANDED_STATE_TAKEOFF, IN_AIR]
    assert grounded.sample().altitude_m == pytest.approx(50, abs=0.1)
    assert grounded.wait(["HEARTBEAT"]).system_status == mavlink.MAV_STATE_ACTIVE
    assert arm(grounded, 0) == FAILED


def test_a_takeoff_as_a_command_fails_and_names_the_way(grounded):
    assert grounded.command_long(mavlink.MAV_CMD_NAV_TAKEOFF, p7=50) == FAILED
    assert "mode TAKEOFF" in grounded.text().text


def test_a_mission_from_the_ground_to_the_ground(grounded):
    passed = [(200, 100), (350, -80), (150, -200)]
    items = [
        (mavlink.MAV_CMD_NAV_TAKEOFF, (15, 0, 0, math.nan), 0, 0, 40),
        (mavlink.MAV_CMD_DO_SET_CAM_TRIGG_DIST, (25, 0, 1, 0), 0, 0, 0),
        *[(mavlink.MAV_CMD_NAV_WAYPOINT, (0, 10, 0, math.nan), *at, 40) for at in passed],
        (mavlink.MAV_CMD_DO_CHANGE_SPEED, (0, 12, -1, 0), 0, 0, 0),
        (mavlink.MAV_CMD_NAV_LAND, (0, 0, 0, math.nan), 20, 30, 0),
    ]
    assert upload(grounded, items) == mavlink.MAV_MISSION_ACCEPTED
    assert grounded.set_mode(AUTO) == ACCEPTED
    assert arm(grounded) == ACCEPTED
    track, reached = [], []
    while not reached or reached[-1] != len(items):
        message = grounded.wait(["LOCAL_POSITION_NED", "MISSION_ITEM_REACHED"])
        if message.get_type() == "MISSION_ITEM_REACHED":
            reached.append(message.seq)
        else:
            track.append((message.x, message.y))
    # The camera is the mission library's own affair, and is not told.
    assert reached == [1, 3, 4, 5, 6, 7]
    for at in passed:
        assert min(math.dist(at, seen) for seen in track) <= 10
    assert math.dist(track[-1], (20, 30)) < 20
    disarmed = grounded.wait(["HEARTBEAT"], lambda message: not message.base_mode & mavlink.MAV_MODE_FLAG_SAFETY_ARMED)
    assert disarmed.custom_mode == AUTO
    assert landed_state(grounded) == ON_GROUND
    at = grounded.sample()
    assert (at.altitude_m, at.speed_mps) == (0, 0)


def test_home_is_where_it_is_armed_unless_somebody_sets_it(grounded):
    first = home(grounded)
    assert first == (399800000, 1163400000, 50000)
    grounded.link.mav.command_int_send(
        grounded.system, 1, mavlink.MAV_FRAME_GLOBAL, mavlink.MAV_CMD_DO_SET_HOME, 0, 0, 0, 0, 0, 0, *place(300, 0), 60
    )
    assert grounded.acknowledged(mavlink.MAV_CMD_DO_SET_HOME) == ACCEPTED
    assert home(grounded) == (*place(300, 0), 60000)
    assert arm(grounded) == ACCEPTED
    assert home(grounded) == (*place(300, 0), 60000)
    assert grounded.wait(["GLOBAL_POSITION_INT"]).relative_alt == -10000
    assert grounded.set_mode(TAKEOFF) == ACCEPTED
    grounded.samples(30)
    assert grounded.set_mode(RTL) == ACCEPTED
    *_, last = grounded.samples(120)
    assert math.dist((last.x_m, last.y_m), (300, 0)) == pytest.approx(60, abs=2)
    assert grounded.command_long(mavlink.MAV_CMD_DO_SET_HOME, 1) == ACCEPTED
    assert home(grounded) != (*place(300, 0), 60000)


@pytest.mark.parametrize(("p1", "z", "result"), [(2, 60, FAILED), (0, math.nan, DENIED), (0, 1e5, DENIED)])
def test_a_home_that_is_none_is_refused(grounded, p1, z, result):
    before = home(grounded)
    grounded.link.mav.command_int_send(
        grounded.system, 1, mavlink.MAV_FRAME_GLOBAL, mavlink.MAV_CMD_DO_SET_HOME, 0, 0, p1, 0, 0, 0, *place(300, 0), z
    )
    assert grounded.acknowledged(mavlink.MAV_CMD_DO_SET_HOME) == result
    assert grounded.text().text.startswith("Home: ")
    assert home(grounded) == before
