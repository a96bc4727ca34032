"""Failsafes: loss, announcement, action, recovery."""

import math

import pytest
from ground import ACCEPTED, GUIDED, LOITER, RTL
from pymavlink.dialects.v20 import ardupilotmega as mavlink

TIMEOUT_S = 2

ACTIVE, CRITICAL = mavlink.MAV_STATE_ACTIVE, mavlink.MAV_STATE_CRITICAL


@pytest.fixture
def craft(start_vehicles, scenario):
    """One that needs no stream of setpoints, five times as fast as the clock."""
    return start_vehicles(scenario(setpoint_timeout_s=0), "--speed", 5).connect()[0]


@pytest.fixture
def led(start_vehicles, scenario):
    """One that waits for setpoints."""
    return start_vehicles(scenario(setpoint_timeout_s=TIMEOUT_S), "--speed", 4).connect()[0]


def status(craft):
    craft.heartbeat()
    heartbeat = craft.wait(["HEARTBEAT"])
    return heartbeat.custom_mode, heartbeat.system_status


def words(craft, start):
    """The next STATUSTEXT that begins so."""
    while True:
        text = craft.text()
        if text.text.startswith(start):
            return text


def test_without_setpoints_it_loiters_and_says_so(led):
    led.setpoint(11, 0, 50)
    text = led.text()
    assert text.severity == mavlink.MAV_SEVERITY_CRITICAL
    assert text.text == "Failsafe: no setpoint for 2 s, LOITER"
    heartbeat = led.wait(["HEARTBEAT"])
    assert (heartbeat.custom_mode, heartbeat.system_status) == (LOITER, mavlink.MAV_STATE_CRITICAL)

    led.setpoint(14, math.radians(30), 60)
    assert led.text().text == "Setpoint refused: mode is LOITER"

    assert led.set_mode(GUIDED) == ACCEPTED
    led.setpoint(14, math.radians(30), 50)
    heartbeat = led.wait(["HEARTBEAT"])
    assert (heartbeat.custom_mode, heartbeat.system_status) == (GUIDED, mavlink.MAV_STATE_ACTIVE)
    follows = led.wait(["LOCAL_POSITION_NED"], lambda at: math.hypot(at.vx, at.vy) > 13)
    assert math.atan2(follows.vy, follows.vx) == pytest.approx(math.radians(30), abs=0.3)


def test_a_stream_of_setpoints_keeps_it_in_guided(led):
    first = led.sample()
    while led.sample().t_s < first.t_s + 3 * TIMEOUT_S:
        led.setpoint(12, 0, 50)
    assert led.mode() == GUIDED
    assert led.sample().speed_mps == pytest.approx(12, abs=0.1)


def test_setpoints_are_not_missed_on_the_ground(start_vehicles, scenario):
    craft = start_vehicles(scenario(on_ground=True, setpoint_timeout_s=TIMEOUT_S), "--speed", 5).connect()[0]
    assert craft.set_mode(GUIDED) == ACCEPTED
    assert craft.command_long(mavlink.MAV_CMD_COMPONENT_ARM_DISARM, 1) == ACCEPTED
    craft.samples(3 * TIMEOUT_S)
    assert craft.mode() == GUIDED


def test_a_low_battery_returns_and_a_good_one_lets_go_on(craft):
    for name, value in {"BATT_LOW_VOLT": 11, "BATT_LOW_TIMER": 3, "BATT_FS_LOW_ACT": 1}.items():
        craft.set_parameter(name, value)
    craft.set_parameter("SIM_BATT_VOLTAGE", 10.8)
    text = words(craft, "Battery 1 is low")
    assert text.severity == mavlink.MAV_SEVERITY_WARNING
    assert status(craft) == (RTL, CRITICAL)
    assert not craft.wait(["SYS_STATUS"]).onboard_control_sensors_health & mavlink.MAV_SYS_STATUS_SENSOR_BATTERY
    low = craft.wait(["BATTERY_STATUS"])
    assert low.charge_state == mavlink.MAV_BATTERY_CHARGE_STATE_LOW

    craft.set_parameter("SIM_BATT_VOLTAGE", 12.6)
    words(craft, "Battery 1 is ok")
    assert status(craft) == (RTL, ACTIVE)
    assert craft.set_mode(GUIDED) == ACCEPTED
    assert status(craft) == (GUIDED, ACTIVE)


def test_a_critical_battery_has_an_action_of_its_own(craft):
    for name, value in {"BATT_LOW_MAH": 3000, "BATT_CRT_MAH": 2000, "BATT_FS_CRT_ACT": 1}.items():
        craft.set_parameter(name, value)
    craft.set_parameter("BATT_CAPACITY", 2900)
    words(craft, "Battery 1 is low")
    assert status(craft) == (GUIDED, CRITICAL)
    craft.set_parameter("BATT_CAPACITY", 1500)
    words(craft, "Battery 1 is critical")
    assert status(craft) == (RTL, CRITICAL)
    # Back to GUIDED in the failsafe, which is announced once.
    assert craft.set_mode(GUIDED) == ACCEPTED
    assert status(craft) == (GUIDED, CRITICAL)
    craft.set_parameter("BATT_CAPACITY", 4000)
    words(craft, "Battery 1 is ok")
    assert status(craft) == (GUIDED, ACTIVE)


@pytest.mark.parametrize("name, off, on", [("SIM_GPS_FAIL", 1, 0), ("SIM_GPS1_ENABLE", 0, 1)])
def test_without_a_gps_it_reckons_on(craft, name, off, on):
    craft.set_parameter(name, off)
    text = words(craft, "GPS 1: no fix")
    assert text.severity == mavlink.MAV_SEVERITY_CRITICAL
    assert status(craft) == (GUIDED, CRITICAL)
    gps = craft.wait(["GPS_RAW_INT"])
    assert (gps.fix_type, gps.satellites_visible) == (mavlink.GPS_FIX_TYPE_NO_FIX, 3)
    assert not craft.wait(["SYS_STATUS"]).onboard_control_sensors_health & mavlink.MAV_SYS_STATUS_SENSOR_GPS
    assert not craft.wait(["EKF_STATUS_REPORT"]).flags & mavlink.EKF_POS_HORIZ_ABS

    craft.set_parameter(name, on)
    words(craft, "GPS 1: fix again")
    assert status(craft) == (GUIDED, ACTIVE)
    assert craft.wait(["GPS_RAW_INT"]).fix_type >= mavlink.GPS_FIX_TYPE_3D_FIX
    assert craft.wait(["EKF_STATUS_REPORT"]).flags & mavlink.EKF_POS_HORIZ_ABS


def test_without_a_gps_it_may_return(craft):
    craft.set_parameter("FS_DR_ENABLE", 2)
    craft.set_parameter("SIM_GPS_FAIL", 1)
    words(craft, "GPS 1: no fix")
    assert status(craft) == (RTL, CRITICAL)
    craft.set_parameter("SIM_GPS_FAIL", 0)
    words(craft, "GPS 1: fix again")
    assert status(craft) == (RTL, ACTIVE)
    assert craft.set_mode(GUIDED) == ACCEPTED


def test_reckoning_goes_astray_by_the_wind_that_it_does_not_see(craft):
    assert craft.change_heading(0) == ACCEPTED
    craft.set_parameter("SIM_GPS_FAIL", 1)
    words(craft, "GPS 1: no fix")
    craft.set_parameter("SIM_WIND_DIR", 270)
    craft.set_parameter("SIM_WIND_SPD", 4)
    # It believes to hold its course, and that there is no wind.
    start_m = craft.sample().y_m
    believed = craft.samples(30)[-1]
    assert abs(believed.course_rad) < 0.01 and abs(believed.y_m - start_m) < 5
    assert craft.wait(["WIND"]).speed == pytest.approx(0, abs=0.01)
    craft.set_parameter("SIM_GPS_FAIL", 0)
    words(craft, "GPS 1: fix again")
    # 4 m/s over half a minute, less what the wind needs to come up.
    found = craft.samples(1)[-1]
    assert 60 < found.y_m - start_m < 140
    settled = craft.samples(30)[-1]
    assert math.degrees(abs(settled.course_rad)) < 1
    assert craft.wait(["WIND"]).speed == pytest.approx(4, rel=0.1)


def test_without_its_engine_it_glides_down_and_goes_on_with_it(craft):
    craft.set_parameter("SIM_ENGINE_FAIL", 4)
    assert words(craft, "Engine failed").severity == mavlink.MAV_SEVERITY_CRITICAL
    assert status(craft) == (GUIDED, CRITICAL)
    sinking = craft.wait(["VFR_HUD"], lambda hud: hud.climb < -0.3)
    assert sinking.throttle == 0
    craft.set_parameter("SIM_ENGINE_FAIL", 0)
    words(craft, "Engine runs again")
    assert status(craft) == (GUIDED, ACTIVE)
    craft.wait(["LOCAL_POSITION_NED"], lambda at: abs(at.z + 50) < 0.5)


def test_a_missing_ground_station_is_missed_and_its_return_is_said(craft):
    craft.heartbeat()
    for name, value in {"FS_GCS_ENABL": 1, "FS_LONG_ACTN": 1, "FS_LONG_TIMEOUT": 5}.items():
        craft.set_parameter(name, value)
    craft.heartbeat()
    text = words(craft, "GCS Failsafe On")
    assert text.text == "GCS Failsafe On: switched to RTL"
    heartbeat = craft.wait(["HEARTBEAT"])
    assert (heartbeat.custom_mode, heartbeat.system_status) == (RTL, CRITICAL)
    craft.heartbeat()
    words(craft, "GCS Failsafe Cleared")
    assert status(craft) == (RTL, ACTIVE)
    assert craft.set_mode(GUIDED) == ACCEPTED


def test_an_action_that_has_nothing_to_act_with_is_said(craft):
    for name, value in {"FS_GCS_ENABL": 1, "FS_LONG_ACTN": 3, "FS_LONG_TIMEOUT": 5}.items():
        craft.set_parameter(name, value)
    craft.heartbeat()
    assert words(craft, "GCS Failsafe On").text == "GCS Failsafe On: no parachute, stays in GUIDED"
    assert craft.mode() == GUIDED
