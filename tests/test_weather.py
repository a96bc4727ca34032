"""Wind, noise and faults by ArduPilot's SIM_ parameters, as a stranger sees them."""

import math

import pytest
from ground import ACCEPTED
from pymavlink.dialects.v20 import ardupilotmega as mavlink


def settle(craft, seconds):
    craft.collect(["LOCAL_POSITION_NED"], seconds)


def off_deg(sample, course_deg):
    return abs((math.degrees(sample.course_rad) - course_deg + 180) % 360 - 180)


@pytest.fixture
def craft(start_vehicles, scenario):
    """One that needs no stream of setpoints, ten times as fast as the clock."""
    return start_vehicles(scenario(setpoint_timeout_s=0), "--speed", 10).connect()[0]


@pytest.fixture
def windy(craft):
    """North at 10 m/s in 6 m/s of wind from the east, with gusts and noise."""
    for name, value in {
        "SIM_WIND_DIR": 90,
        "SIM_WIND_SPD": 6,
        "SIM_WIND_TURB": 0.5,
        "SIM_GPS1_NOISE": 1.5,
        "SIM_ACC1_RND": 0.3,
        "SIM_GYR1_RND": 0.5,
        "SIM_BARO_RND": 0.2,
        "SIM_ARSPD_RND": 2,
    }.items():
        craft.set_parameter(name, value)
    assert craft.change_speed(10) == ACCEPTED
    assert craft.change_heading(0) == ACCEPTED
    settle(craft, 40)
    return craft


def test_the_course_is_held_across_the_wind_and_the_wind_is_known(windy):
    worst = max(off_deg(sample, 0) for sample in windy.samples(20))
    assert worst < 1

    wind = windy.wait(["WIND"])
    assert wind.speed == pytest.approx(6, rel=0.1)
    assert wind.direction == pytest.approx(90, abs=6)
    cov = windy.request(mavlink.MAVLINK_MSG_ID_WIND_COV, "WIND_COV")
    assert (cov.wind_x, cov.wind_y) == pytest.approx((0, -6), abs=0.6)

    hud, attitude = windy.wait(["VFR_HUD"]), windy.wait(["ATTITUDE"])
    assert hud.groundspeed == pytest.approx(8, abs=1.5)
    assert hud.airspeed == pytest.approx(10, abs=1.5)
    # The nose is held into the wind: 37 degrees by the triangle of 6, 8 and 10.
    assert hud.heading == pytest.approx(37, abs=6)
    assert math.degrees(attitude.yaw) == pytest.approx(37, abs=6)
    position = windy.wait(["GLOBAL_POSITION_INT"])
    assert position.hdg / 100 == pytest.approx(37, abs=6)
    assert position.vx / 100 > 5 and abs(position.vy) < 30


def test_another_course_in_wind_is_reached_and_held(windy):
    assert windy.change_heading(225) == ACCEPTED
    settle(windy, 15)
    assert max(off_deg(sample, 225) for sample in windy.samples(10)) < 1


def test_still_again_after_the_wind(windy):
    for name in ("SIM_WIND_SPD", "SIM_WIND_TURB"):
        windy.set_parameter(name, 0)
    settle(windy, 60)
    sample, attitude = windy.samples(1)[-1], windy.wait(["ATTITUDE"])
    assert sample.speed_mps == pytest.approx(10, abs=0.01)
    assert math.degrees(attitude.yaw) == pytest.approx(0, abs=0.1)
    assert windy.wait(["WIND"]).speed == pytest.approx(0, abs=0.01)


def test_sensors_measure_what_is_until_they_are_spoilt(craft):
    imu = craft.wait(["RAW_IMU"])
    assert (imu.xacc, imu.yacc, imu.zacc) == (0, 0, -1000)
    assert (imu.xgyro, imu.ygyro, imu.zgyro) == (0, 0, 0)
    pressure = craft.wait(["SCALED_PRESSURE"])
    # ISO 2533 at 100 m.
    assert pressure.press_abs == pytest.approx(1001.29, abs=0.05)
    highres = craft.request(mavlink.MAVLINK_MSG_ID_HIGHRES_IMU, "HIGHRES_IMU")
    assert highres.pressure_alt == pytest.approx(100, abs=0.01)
    assert highres.temperature == pytest.approx(14.35, abs=0.01)

    for name, value in {"SIM_ACC1_BIAS_X": 2, "SIM_BARO_RND": 3, "SIM_ACC1_RND": 0.5, "SIM_ARSPD_FAIL": 4}.items():
        craft.set_parameter(name, value)
    craft.set_rate(mavlink.MAVLINK_MSG_ID_RAW_IMU, 20)
    craft.set_rate(mavlink.MAVLINK_MSG_ID_SCALED_PRESSURE, 20)
    heard = craft.collect(["RAW_IMU", "SCALED_PRESSURE"], 5)
    ahead = [message.xacc for message in heard if message.get_type() == "RAW_IMU"]
    assert sum(ahead) / len(ahead) == pytest.approx(200, abs=30)
    assert len(set(ahead)) > 20
    assert len({message.press_abs for message in heard if message.get_type() == "SCALED_PRESSURE"}) > 20
    assert craft.wait(["VFR_HUD"], lambda hud: hud.airspeed == 4).groundspeed == pytest.approx(10, abs=0.01)


def test_a_lag_and_an_error_of_the_gps(craft):
    settle(craft, 2)
    craft.set_rate(mavlink.MAVLINK_MSG_ID_GPS_RAW_INT, 10)
    craft.set_rate(mavlink.MAVLINK_MSG_ID_GLOBAL_POSITION_INT, 10)

    def behind(seconds):
        heard = craft.collect(["GPS_RAW_INT", "GLOBAL_POSITION_INT"], seconds)
        place = {m.time_boot_ms: m for m in heard if m.get_type() == "GLOBAL_POSITION_INT"}
        pairs = [(place.get(m.time_usec // 1000), m) for m in heard if m.get_type() == "GPS_RAW_INT"]
        # A unit of latitude is 1.11 cm.
        return [(true.lat - gps.lat) * 0.0111 for true, gps in pairs if true]

    assert behind(2) and all(abs(metres) < 0.02 for metres in behind(2))
    craft.set_parameter("SIM_GPS1_LAG_MS", 500)
    settle(craft, 2)
    assert all(metres == pytest.approx(5, abs=0.1) for metres in behind(2))
    craft.set_parameter("SIM_GPS1_LAG_MS", 0)
    craft.set_parameter("SIM_GPS1_NOISE", 3)
    settle(craft, 1)
    errors = behind(20)
    assert math.sqrt(sum(metres**2 for metres in errors) / len(errors)) == pytest.approx(3, rel=0.3)


def test_the_battery_drains(craft):
    status = craft.wait(["SYS_STATUS"])
    assert status.voltage_battery / 1000 == pytest.approx(12.4, abs=0.1)
    assert status.current_battery > 500
    assert status.onboard_control_sensors_health & mavlink.MAV_SYS_STATUS_SENSOR_BATTERY
    first = craft.wait(["BATTERY_STATUS"])
    assert craft.change_speed(15) == ACCEPTED
    settle(craft, 20)
    last = craft.wait(["BATTERY_STATUS"])
    # 30 A at full power: 8.3 mAh a second.
    assert 120 < last.current_consumed - first.current_consumed < 180
    assert last.current_battery > 2 * first.current_battery
    craft.set_parameter("BATT_CAPACITY", 500)
    assert craft.wait(["SYS_STATUS"], lambda status: status.battery_remaining < 80).battery_remaining > 20


def test_a_bad_radio_loses_frames_and_nothing_else(craft):
    craft.set_parameter("SIM_UART_LOSS", 30)
    craft.set_rate(mavlink.MAVLINK_MSG_ID_ATTITUDE, 50)
    heard = craft.collect(["ATTITUDE"], 20)
    assert 0.6 < len(heard) / 1000 < 0.8
    # What is lost is asked for again.
    for _ in range(40):
        craft.link.mav.param_set_send(craft.system, 1, b"SIM_UART_LOSS", 0, mavlink.MAV_PARAM_TYPE_REAL32)
    craft.wait(["PARAM_VALUE"], lambda value: value.param_id == "SIM_UART_LOSS" and value.param_value == 0)
    assert len(craft.collect(["ATTITUDE"], 4)) >= 198
