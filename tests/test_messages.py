"""Every message that is asked for and accepted comes, at a rate too, and what is in it makes sense.

An ArduPlane accepts some for which it has nothing to say: then a text says what is missing."""

import math
import time
from collections import Counter
from pathlib import Path

import pytest
from ground import ACCEPTED
from pymavlink.dialects.v20 import all as mavlink
from pymavlink.dialects.v20 import ardupilotmega

REQUEST, INTERVAL = mavlink.MAV_CMD_REQUEST_MESSAGE, mavlink.MAV_CMD_SET_MESSAGE_INTERVAL
# Those that our client can read; HEARTBEAT comes anyhow, and MESSAGE_INTERVAL tells of another message.
MESSAGES = [number for number in sorted(ardupilotmega.mavlink_map) if 0 < number < 13_000 and number != 244]
# Fields that may have no number where nothing is known.
UNKNOWN = {
    "q",
    "pose_covariance",
    "velocity_covariance",
    "covariance",
    "thrust_body",
    "approach_x",
    "approach_y",
    "approach_z",
}
PATIENCE_S = 30.0
PAGE = Path(__file__).parent.parent / "docs/mavlink.md"


@pytest.fixture(params=["arduplane", "px4"])
def craft(request, start_vehicles, scenario):
    return start_vehicles(scenario(), "--personality", request.param, "--speed", 5).connect()[0]


def ask(craft, command, *params):
    craft.link.mav.command_long_send(craft.system, craft.component, command, 0, *params, *[0] * (7 - len(params)))


def answer(craft, number):
    """The result of a request, and the message; none where a text says that there is nothing to tell."""
    name = mavlink.mavlink_map[number].msgname
    ask(craft, REQUEST, number)
    result, found, text = None, None, None
    end = time.monotonic() + PATIENCE_S
    while result is None or (result == ACCEPTED and found is None and text is None):
        said = craft.wait([name, "COMMAND_ACK", "STATUSTEXT"], patience_s=end - time.monotonic())
        if said.get_type() == "COMMAND_ACK" and said.command == REQUEST:
            result = said.result
        elif said.get_type() == name:
            found = said
        elif said.get_type() == "STATUSTEXT" and said.text.startswith("There is no"):
            text = said.text
    return result, found


def is_near(place, field, value):
    """A latitude or longitude in 1e-7 degrees or in degrees."""
    degrees = value / 1e7 if isinstance(value, int) else value
    here = (place.lat if field.startswith("lat") else place.lon) / 1e7
    return abs(degrees - here) < 0.05


def faults(message, place):
    """What makes no sense in a message."""
    fields = {field: getattr(message, field) for field in message.get_fieldnames()}
    for field, value in fields.items():
        values = value if isinstance(value, list) else [value]
        if any(isinstance(one, float) and math.isinf(one) for one in values):
            yield f"{field} is infinite"
        if field not in UNKNOWN and any(isinstance(one, float) and math.isnan(one) for one in values):
            yield f"{field} is no number"
        if field in ("lat", "lon", "lat_int", "lon_int", "latitude", "longitude") and not is_near(place, field, value):
            yield f"{field} is {value}"
        if field == "time_boot_ms" and not 0 <= value - place.time_boot_ms < 600_000:
            yield f"{field} is {value}"
        if field in ("roll", "pitch", "yaw") and isinstance(value, float) and abs(value) > 360:
            yield f"{field} is {value}"
    if not any(fields.values()):
        yield "all is zero"


# What is at rest in still air, north, without a fence, sticks or relays: it may be all zero.
MAY_BE_ZERO = {
    "AHRS", "AOA_SSA", "FENCE_STATUS", "MAG_CAL_REPORT", "MANUAL_CONTROL", "MISSION_CURRENT", "NAV_CONTROLLER_OUTPUT",
    "RELAY_STATUS", "VIBRATION", "WIND",
}  # fmt: skip


def test_what_is_accepted_comes_and_makes_sense(craft):
    place = craft.wait(["GLOBAL_POSITION_INT"])
    found = {}
    for number in MESSAGES:
        result, message = answer(craft, number)
        if result == ACCEPTED and message is not None:
            found[number] = message
    assert len(found) > 30
    wrong = {
        message.get_type(): why
        for message in found.values()
        if (why := [fault for fault in faults(message, place)])
        and not (why == ["all is zero"] and message.get_type() in MAY_BE_ZERO)
    }
    assert not wrong
    # The same at a rate. One at a time: each is waited for twice. A fence is told of while it is enabled.
    found.pop(mavlink.MAVLINK_MSG_ID_FENCE_STATUS, None)
    for number, message in found.items():
        ask(craft, INTERVAL, number, 200_000)
        assert craft.acknowledged(INTERVAL) == ACCEPTED, message.get_type()
        for _ in range(2):
            craft.wait([message.get_type()], patience_s=PATIENCE_S)
        ask(craft, INTERVAL, number, -1)
        assert craft.acknowledged(INTERVAL) in (ACCEPTED, mavlink.MAV_RESULT_FAILED)


# What a PX4 sends to ground stations and companion computers by itself (`configure_streams_to_default` of
# mavlink_main.cpp), in the air, as far as there is such a thing here.
UNASKED = """
    ALTITUDE ATTITUDE ATTITUDE_QUATERNION ATTITUDE_TARGET BATTERY_STATUS ESTIMATOR_STATUS EXTENDED_SYS_STATE
    GLOBAL_POSITION_INT GPS_GLOBAL_ORIGIN GPS_RAW_INT HIGHRES_IMU HOME_POSITION LOCAL_POSITION_NED NAV_CONTROLLER_OUTPUT
    ODOMETRY POSITION_TARGET_GLOBAL_INT POSITION_TARGET_LOCAL_NED SCALED_PRESSURE SERVO_OUTPUT_RAW SYS_STATUS
    SYSTEM_TIME VFR_HUD VIBRATION WIND_COV
""".split()


def test_a_px4_tells_a_gimbal_and_a_simulator_where_it_is(start_vehicles, scenario):
    craft = start_vehicles(scenario(), "--personality", "px4", "--speed", 5).connect()[0]
    place = craft.wait(["GLOBAL_POSITION_INT"])
    result, hil = answer(craft, ardupilotmega.MAVLINK_MSG_ID_HIL_STATE_QUATERNION)
    assert result == ACCEPTED
    speed = math.hypot(hil.vx, hil.vy)
    assert (speed, hil.ind_airspeed, hil.true_airspeed) == pytest.approx((1000, 1000, 1000), abs=20)
    assert hil.alt == pytest.approx(place.alt, abs=500) and math.hypot(*hil.attitude_quaternion) == pytest.approx(1)
    # At rest in the air, up is felt as one g.
    assert hil.zacc < -900
    result, gimbal = answer(craft, mavlink.MAVLINK_MSG_ID_AUTOPILOT_STATE_FOR_GIMBAL_DEVICE)
    assert result == ACCEPTED
    assert math.hypot(gimbal.vx, gimbal.vy) == pytest.approx(10, abs=0.2) and math.hypot(*gimbal.q) == pytest.approx(1)
    assert (gimbal.landed_state, gimbal.target_system) == (mavlink.MAV_LANDED_STATE_IN_AIR, 0)
    assert gimbal.estimator_status and gimbal.time_boot_us > 0


def test_a_px4_tells_unasked_what_a_real_one_does(start_vehicles, scenario):
    craft = start_vehicles(scenario(), "--personality", "px4", "--speed", 5).connect()[0]
    missing = set(UNASKED)
    end = time.monotonic() + PATIENCE_S
    while missing and time.monotonic() < end:
        missing.discard(craft.wait(UNASKED).get_type())
    assert not missing


# What an ArduPlane's own simulator sends on every link once a second, in GUIDED, asked for nothing.
EVERY_SECOND = """
    AHRS AHRS2 AIRSPEED AOA_SSA ATTITUDE BATTERY_STATUS EKF_STATUS_REPORT ESC_TELEMETRY_1_TO_4 GLOBAL_POSITION_INT
    GPS_RAW_INT LOCAL_POSITION_NED MEMINFO MISSION_CURRENT NAV_CONTROLLER_OUTPUT POSITION_TARGET_GLOBAL_INT POWER_STATUS
    RAW_IMU RC_CHANNELS SCALED_IMU2 SCALED_IMU3 SCALED_PRESSURE SCALED_PRESSURE2 SERVO_OUTPUT_RAW SIMSTATE SYSTEM_TIME
    SYS_STATUS TERRAIN_REPORT VFR_HUD VIBRATION WIND
""".split()
NOW_AND_THEN = {"HEARTBEAT", "GPS_GLOBAL_ORIGIN", "HOME_POSITION", "STATUSTEXT", "PARAM_VALUE"}


def test_an_arduplanes_ports_have_the_rates_of_its_simulator(start_vehicles):
    craft = start_vehicles("--count", 1, "--ports", "ardupilot", "--speed", 2, ground_port=0).connect()[0]
    for name in ("MAV1_EXTRA1", "MAV1_POSITION", "MAV1_EXTRA2"):
        craft.link.param_fetch_one(name)
        assert craft.wait(["PARAM_VALUE"], lambda value, name=name: value.param_id == name).param_value == 1, name
    seen = Counter()
    craft.wait(["HEARTBEAT"])
    while seen["HEARTBEAT"] < 6:
        seen[craft.link.recv_match(blocking=True, timeout=PATIENCE_S).get_type()] += 1
    assert {name: seen[name] for name in EVERY_SECOND if not 5 <= seen[name] <= 7} == {}
    assert set(seen) - set(EVERY_SECOND) <= NOW_AND_THEN


def test_a_px4_sends_nothing_that_a_px4_has_not(start_vehicles, scenario):
    craft = start_vehicles(scenario(), "--personality", "px4", "--speed", 5).connect()[0]
    seen = Counter()
    while seen["HEARTBEAT"] < 6:
        seen[craft.link.recv_match(blocking=True, timeout=PATIENCE_S).get_type()] += 1
    assert not set(seen) & {"RAW_IMU", "WIND", "EKF_STATUS_REPORT", "FENCE_STATUS"}


def test_what_there_is_no_device_for_is_told_and_nothing_else(start_vehicles, scenario):
    """Every accepted request of an ArduPlane comes, but where the page says that there is nothing."""
    craft = start_vehicles(scenario(), "--speed", 5).connect()[0]
    silent = set()
    for number in MESSAGES:
        result, message = answer(craft, number)
        if result == ACCEPTED and message is None:
            silent.add(mavlink.mavlink_map[number].msgname)
    row = next(line for line in PAGE.read_text().splitlines() if line.startswith("| PARAM_VALUE, "))
    assert silent == set(row.split("|")[1].replace(",", " ").split())
