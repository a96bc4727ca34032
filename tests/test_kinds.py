"""Kinds of things that scripts for real autopilots do: who is addressed, which rates, what a reboot forgets, where a
loiter is over, which values a parameter takes. What is right was confirmed on a real ArduPlane and PX4, or stands in
their sources."""

import math

import pytest
from ground import ACCEPTED, DENIED, FAILED, UNSUPPORTED
from plans import Uploader, item
from pymavlink.dialects.v20 import all as mavlink

MISSION, FENCE = mavlink.MAV_MISSION_TYPE_MISSION, mavlink.MAV_MISSION_TYPE_FENCE
REBOOT, SET_HOME, INTERVAL, REQUEST = 246, 179, 511, 512
BY_FORCE = 20190226
AUTO, GUIDED, FBWA = 10, 15, 5
ERROR = mavlink.MAV_MISSION_ERROR

FAST = """
[scenario]
name = "fast"
duration_s = 3600.0

[flock]
expected_speed_mps = 22.0
expected_altitude_m = 100.0

[dynamics]
speed_min_mps = 9.0
speed_max_mps = 30.0

[vehicles]
count = 1
"""


@pytest.fixture
def start(start_vehicles):
    def begin(*options, personality="arduplane", on_ground=True):
        where = ["--on-ground"] if on_ground else []
        return start_vehicles("--count", 1, "--personality", personality, *where, *options).connect()[0]

    return begin


def long(craft, command, *params, component=None):
    """Sends a COMMAND_LONG with all its params."""
    component = craft.component if component is None else component
    craft.link.mav.command_long_send(craft.system, component, command, 0, *params, *[0] * (7 - len(params)))


def asked(craft, command, *params):
    long(craft, command, *params)
    return craft.acknowledged(command)


def hears_nothing(craft, kinds, seconds=0.5):
    return not craft.collect(kinds, seconds)


# Who is addressed.


def test_a_px4_is_silent_to_what_is_for_another_component(start):
    craft = start(personality="px4")
    mav, system = craft.link.mav, craft.system
    long(craft, REQUEST, 148, component=55)
    mav.param_request_read_send(system, 55, b"MAV_SYS_ID", -1)
    mav.mission_request_list_send(system, 55, MISSION)
    mav.mission_request_list_send(0, 1, MISSION)
    mav.param_request_read_send(0, 1, b"MAV_SYS_ID", -1)
    assert hears_nothing(craft, ["COMMAND_ACK", "PARAM_VALUE", "MISSION_COUNT", "AUTOPILOT_VERSION"])
    # To all components, to the mission planner's, and to all systems.
    mav.mission_request_list_send(system, 190, MISSION)
    assert craft.wait(["MISSION_COUNT"])
    mav.param_request_read_send(system, 0, b"MAV_SYS_ID", -1)
    assert craft.wait(["PARAM_VALUE"])
    mav.command_long_send(0, 0, REQUEST, 0, 148, 0, 0, 0, 0, 0, 0)
    assert craft.acknowledged(REQUEST) == ACCEPTED


def test_an_arduplane_hears_what_is_for_any_component(start):
    craft = start()
    long(craft, REQUEST, 148, component=55)
    assert craft.acknowledged(REQUEST) == ACCEPTED


# Rates.


def test_a_px4_takes_any_rate(start):
    craft = start(personality="px4", on_ground=False)
    assert asked(craft, INTERVAL, mavlink.MAVLINK_MSG_ID_HIGHRES_IMU, 5_000) == ACCEPTED
    craft.collect(["HIGHRES_IMU"], 0.2)
    assert len(craft.collect(["HIGHRES_IMU"], 1.0)) > 50


@pytest.mark.parametrize(
    "params", [(30, 1e5, 1), (30, 1e5, 0, 1), (30, 1e5, 0, 0, 0, 0, 1), (0, -1), (12345, 1e5)], ids=str
)
def test_a_px4_fails_a_rate_that_it_has_no_room_for(start, params):
    craft = start(personality="px4")
    assert asked(craft, INTERVAL, *params) == FAILED
    assert craft.wait(["HEARTBEAT"])


def test_a_rate_of_an_arduplane_has_no_third_param(start):
    craft = start()
    assert asked(craft, INTERVAL, 30, 1e6, 1) == DENIED


# What is acknowledged comes.

COMING = {
    "arduplane": [
        35,
        36,
        83,
        108,
        116,
        125,
        129,
        136,
        137,
        152,
        163,
        164,
        165,
        178,
        192,
        235,
        241,
        264,
        295,
        376,
        11020,
    ],
    "px4": [4, 36, 69, 83, 93, 111, 132, 192, 230, 241, 261, 264, 375],
}


@pytest.mark.parametrize("personality", COMING)
def test_a_message_that_is_acknowledged_comes(start, personality):
    craft = start(personality=personality)
    for message_id in COMING[personality]:
        name = mavlink.mavlink_map[message_id].msgname
        long(craft, REQUEST, message_id)
        heard = {}
        while len(heard) < 2:
            said = craft.wait([name, "COMMAND_ACK"])
            heard.setdefault(said.get_type(), said)
        assert heard["COMMAND_ACK"].result == ACCEPTED
        # ArduPilot's own tests wait for the acknowledgement, and for the message after that.
        assert personality != "arduplane" or list(heard) == ["COMMAND_ACK", name]


def test_what_comes_has_sensible_content(start):
    craft = start(on_ground=False)
    truth = craft.request(mavlink.MAVLINK_MSG_ID_SIM_STATE, "SIM_STATE")
    place = craft.wait(["GLOBAL_POSITION_INT"])
    assert abs(truth.lat_int - place.lat) < 5000 and abs(truth.alt - place.alt / 1000) < 2
    summary = craft.request(mavlink.MAVLINK_MSG_ID_HIGH_LATENCY2, "HIGH_LATENCY2")
    assert abs(summary.latitude - place.lat) < 5000 and summary.custom_mode == GUIDED
    hud = craft.wait(["VFR_HUD"])
    assert abs(summary.groundspeed / 5 - hud.groundspeed) < 0.5 and abs(summary.altitude - place.alt / 1000) < 2
    outputs = craft.request(mavlink.MAVLINK_MSG_ID_SERVO_OUTPUT_RAW, "SERVO_OUTPUT_RAW")
    assert 1100 < outputs.servo3_raw <= 2000


# Plans of a PX4.


def fence_round(place, size=1000):
    corners = [(-size, -size), (size, -size), (size, size), (-size, size)]
    return [(5001, 4, place.lat + north, place.lon + east) for north, east in corners]


def upload(craft, plan, kind):
    mav = craft.link.mav
    mav.mission_count_send(craft.system, 1, len(plan), kind)
    while True:
        said = craft.wait(["MISSION_REQUEST_INT", "MISSION_REQUEST", "MISSION_ACK"])
        if said.get_type() == "MISSION_ACK":
            return said.type
        command, p1, x, y = plan[said.seq]
        frame = mavlink.MAV_FRAME_GLOBAL_INT
        mav.mission_item_int_send(craft.system, 1, said.seq, frame, command, 0, 1, p1, 0, 0, 0, x, y, 0, kind)


def test_a_px4_takes_a_fence_of_which_a_part_does_not_count(start):
    craft = start(personality="px4")
    place = craft.wait(["GLOBAL_POSITION_INT"])
    assert upload(craft, [*fence_round(place), (5003, 0, 0, 0)], FENCE) == ACCEPTED
    assert craft.text().text == "Geofence invalid, doesn't contain Home position"
    assert upload(craft, [(5001, 2, place.lat, place.lon)] * 2, FENCE) == ERROR


def test_a_px4_takes_a_mission_that_it_does_not_fly(start):
    craft = start(personality="px4")
    place = craft.wait(["GLOBAL_POSITION_INT"])
    mission = [(16, 0, place.lat, place.lon), (22, 0, place.lat, place.lon)]
    assert upload(craft, mission, MISSION) == ACCEPTED
    assert asked(craft, mavlink.MAV_CMD_MISSION_START) == DENIED


# Params that modify a command.


def test_an_armed_arduplane_reboots_by_force_alone(start):
    craft = start(on_ground=False)
    assert asked(craft, REBOOT, 1) == FAILED
    assert asked(craft, REBOOT, 1, 0, 0, 0, 0, BY_FORCE) == ACCEPTED
    craft.wait(["HEARTBEAT"], lambda beat: not beat.base_mode & mavlink.MAV_MODE_FLAG_SAFETY_ARMED)
    assert asked(craft, REBOOT, 2) == UNSUPPORTED


@pytest.mark.parametrize(("kind", "result"), [(0, ACCEPTED), (1, ACCEPTED), (2, FAILED), (3, FAILED)])
def test_the_type_of_a_speed_is_read(start, kind, result):
    craft = start(on_ground=False)
    assert asked(craft, mavlink.MAV_CMD_DO_CHANGE_SPEED, kind, 12, 0) == result


# What a reboot forgets.


def test_a_reboot_forgets_a_home_that_was_set(start):
    craft = start()
    at = craft.wait(["GLOBAL_POSITION_INT"])
    craft.link.mav.command_int_send(craft.system, 1, 0, SET_HOME, 0, 0, 0, 0, 0, 0, at.lat, at.lon, at.alt / 1000 + 40)
    assert craft.acknowledged(SET_HOME) == ACCEPTED
    craft.wait(["GLOBAL_POSITION_INT"], lambda now: now.relative_alt < -39_000)
    assert asked(craft, REBOOT, 1) == ACCEPTED
    craft.wait(["GLOBAL_POSITION_INT"], lambda now: abs(now.relative_alt) < 1000)


# Where a loiter is over.


def test_a_loiter_of_no_turns_is_over_on_its_circle(start_vehicles, tmp_path):
    path = tmp_path / "fast.toml"
    path.write_text(FAST)
    craft = start_vehicles(path, "--speed", 10).connect()[0]
    relative = mavlink.MAV_FRAME_GLOBAL_RELATIVE_ALT
    centres = {1: (600, 600), 2: (600, -600)}
    mission = [
        item(16),
        item(18, 600, 600, 100, p3=-100, frame=relative),
        item(18, 600, -600, 100, p3=100, frame=relative),
    ]
    mission.append(item(16, altitude_m=100, frame=relative))
    assert Uploader(craft.link).upload(mission) == ACCEPTED
    craft.set_mode(AUTO)
    least, done = dict.fromkeys(centres, math.inf), 0
    while done < 2:
        said = craft.wait(["LOCAL_POSITION_NED", "MISSION_ITEM_REACHED"], patience_s=60)
        if said.get_type() == "MISSION_ITEM_REACHED":
            done = max(done, said.seq)
            continue
        for seq, (north, east) in centres.items():
            least[seq] = min(least[seq], math.hypot(said.x - north, said.y - east))
    assert max(least.values()) <= 110


# Values of parameters.


@pytest.mark.parametrize(("name", "most"), [("FS_LONG_ACTN", 5), ("BATT_FS_LOW_ACT", 7), ("BATT_FS_CRT_ACT", 7)])
def test_a_parameter_takes_the_values_that_arduplane_has_and_refuses_others_in_words(start, name, most):
    craft = start()
    for value in range(most + 1):
        assert craft.set_parameter(name, value).param_value == value
    craft.texts.clear()
    craft.link.mav.param_set_send(craft.system, craft.component, name.encode(), most + 1, mavlink.MAV_PARAM_TYPE_REAL32)
    assert craft.wait(["PARAM_VALUE"], lambda answer: answer.param_id == name).param_value == most
    assert name in craft.text().text


# A PX4's calibration and failures on purpose.


def test_a_px4_tells_how_far_a_calibration_has_come(start):
    craft = start("--speed", 5, personality="px4")
    assert asked(craft, mavlink.MAV_CMD_PREFLIGHT_CALIBRATION, 1) == ACCEPTED
    texts = []
    while "[cal] calibration done: gyro" not in texts:
        texts.append(craft.text().text)
    assert "[cal] calibration started: 2 gyro" in texts and "[cal] progress <60>" in texts


def test_a_px4_loses_its_gps_on_purpose(start):
    craft = start(personality="px4")
    fails = mavlink.MAV_CMD_INJECT_FAILURE
    assert asked(craft, fails, 4, 1, 0) == ACCEPTED
    craft.wait(["GPS_RAW_INT"], lambda gps: gps.fix_type < 2)
    assert asked(craft, fails, 4, 0, 0) == ACCEPTED
    craft.wait(["GPS_RAW_INT"], lambda gps: gps.fix_type >= 3)
    assert asked(craft, fails, 104, 1, 0) == UNSUPPORTED


def test_a_px4_obeys_no_failure_that_is_switched_off(start):
    craft = start("--param", "SYS_FAILURE_EN=0", personality="px4")
    assert asked(craft, mavlink.MAV_CMD_INJECT_FAILURE, 4, 1, 0) == DENIED
