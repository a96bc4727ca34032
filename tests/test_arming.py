"""Arming and disarming."""

import pytest
from ground import ACCEPTED, FAILED, GUIDED, MANUAL, RTL
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


def test_in_the_air_it_is_not_disarmed(craft):
    assert arm(craft, 0) == FAILED
    assert craft.text().severity == mavlink.MAV_SEVERITY_WARNING
    assert craft.wait(["HEARTBEAT"]).base_mode & mavlink.MAV_MODE_FLAG_SAFETY_ARMED
    assert craft.sample().speed_mps == pytest.approx(10, abs=1e-3)


def test_by_force_it_is_disarmed_in_the_air_and_glides(craft):
    assert arm(craft, 0, FORCE) == ACCEPTED
    assert not craft.wait(["HEARTBEAT"]).base_mode & mavlink.MAV_MODE_FLAG_SAFETY_ARMED
    *_, last = craft.samples(12)
    assert (last.speed_mps, last.climb_mps) == pytest.approx((5, -0.5), abs=0.02)
    assert arm(craft) == ACCEPTED
    *_, last = craft.samples(12)
    assert (last.speed_mps, last.altitude_m) == pytest.approx((10, 50), abs=0.5)


def test_in_rtl_it_is_not_armed(waiting):
    assert waiting.set_mode(RTL) == ACCEPTED
    assert arm(waiting) == FAILED
    assert waiting.text().text == "Arm: RTL mode not armable"
    assert waiting.command_long(mavlink.MAV_CMD_RUN_PREARM_CHECKS) == ACCEPTED
    assert waiting.text().text == "PreArm: RTL mode not armable"
    status = waiting.wait(["SYS_STATUS"])
    assert not status.onboard_control_sensors_health & mavlink.MAV_SYS_STATUS_PREARM_CHECK
    assert arm(waiting, 1, FORCE) == ACCEPTED
    assert waiting.command_long(mavlink.MAV_CMD_RUN_PREARM_CHECKS) == mavlink.MAV_RESULT_TEMPORARILY_REJECTED


def test_a_reboot_starts_anew_where_it_stands_and_keeps_parameters(start_vehicles, scenario):
    craft = start_vehicles(scenario(on_ground=True), "--speed", 5).connect()[0]
    reboot = mavlink.MAV_CMD_PREFLIGHT_REBOOT_SHUTDOWN
    craft.set_parameter("WP_LOITER_RAD", 75)
    assert craft.set_mode(GUIDED) == ACCEPTED
    assert craft.command_long(mavlink.MAV_CMD_COMPONENT_ARM_DISARM, 1) == ACCEPTED
    assert craft.command_long(reboot, 1) == FAILED
    assert craft.command_long(mavlink.MAV_CMD_COMPONENT_ARM_DISARM, 0) == ACCEPTED
    assert craft.command_long(reboot, 1) == ACCEPTED
    craft.heartbeat()
    assert craft.mode() == MANUAL
    craft.link.mav.param_request_read_send(craft.system, craft.component, b"WP_LOITER_RAD", -1)
    assert craft.wait(["PARAM_VALUE"], lambda value: value.param_id == "WP_LOITER_RAD").param_value == 75


def test_what_is_too_long_for_one_message_is_said_whole(craft):
    assert craft.command_long(mavlink.MAV_CMD_NAV_TAKEOFF) == FAILED
    assert craft.text().text == "Takeoff: set mode TAKEOFF, or AUTO with NAV_TAKEOFF"
