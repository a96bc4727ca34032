"""Arming and disarming."""

import pytest
from ground import ACCEPTED, FAILED
from pymavlink.dialects.v20 import ardupilotmega as mavlink

FORCE = 21196


@pytest.fixture
def waiting(start_vehicles, scenario):
    """A vehicle that is not armed."""
    return start_vehicles(scenario(armed=False), "--speed", 5).connect()[0]


def arm(craft, arm=1, force=0):
    return craft.command_long(mavlink.MAV_CMD_COMPONENT_ARM_DISARM, arm, force)


def test_a_vehicle_waits_where_it_starts_until_it_is_armed(waiting):
    heartbeat = waiting.wait(["HEARTBEAT"])
    assert not heartbeat.base_mode & mavlink.MAV_MODE_FLAG_SAFETY_ARMED
    assert heartbeat.system_status == mavlink.MAV_STATE_STANDBY
    before = waiting.samples(3)
    assert {(at.x_m, at.y_m, at.altitude_m, at.speed_mps) for at in before} == {(0, 0, 50, 0)}

    assert arm(waiting) == ACCEPTED
    heartbeat = waiting.wait(["HEARTBEAT"])
    assert heartbeat.base_mode & mavlink.MAV_MODE_FLAG_SAFETY_ARMED
    assert heartbeat.system_status == mavlink.MAV_STATE_ACTIVE
    first, *_, last = waiting.samples(2)
    assert last.speed_mps == pytest.approx(10, abs=1e-3)
    assert last.x_m - first.x_m == pytest.approx(10 * (last.t_s - first.t_s), abs=1e-2)


def test_disarmed_it_can_be_disarmed_again(waiting):
    assert arm(waiting, 0) == ACCEPTED


def test_arming_twice_changes_nothing(craft):
    assert arm(craft) == ACCEPTED
    first, *_, last = craft.samples(1)
    assert last.x_m - first.x_m == pytest.approx(10 * (last.t_s - first.t_s), abs=1e-2)


@pytest.mark.parametrize("force", [0, FORCE])
def test_in_the_air_it_is_not_disarmed_even_by_force(craft, force):
    assert arm(craft, 0, force) == FAILED
    assert craft.text().severity == mavlink.MAV_SEVERITY_WARNING
    assert craft.wait(["HEARTBEAT"]).base_mode & mavlink.MAV_MODE_FLAG_SAFETY_ARMED
    assert craft.sample().speed_mps == pytest.approx(10, abs=1e-3)
