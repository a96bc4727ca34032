"""A vehicle that passes for a PX4, as a stranger's client sees it."""

import math
import struct

import pytest
from ground import ACCEPTED, DENIED, UNSUPPORTED, connection
from lists import Lists
from plans import Uploader, item
from pymavlink.dialects.v20 import ardupilotmega as mavlink

TEMPORARILY_REJECTED = mavlink.MAV_RESULT_TEMPORARILY_REJECTED
# MAV_PARAM_ERROR_TYPE_MISMATCH, which pymavlink has not yet in every release.
TYPE_MISMATCH = 7
NAN = float("nan")

CUSTOM = mavlink.MAV_MODE_FLAG_CUSTOM_MODE_ENABLED
AUTO, TAKEOFF, HOLD, MISSION, RETURN, LAND, COURSE = 4, 2, 3, 4, 5, 6, 19
POSITION, OFFBOARD = (3, 0), (6, 0)

VELOCITY, VELOCITY_AND_ALTITUDE, PLACE = 0xDC7, 0xDE3, 0xDF8


def number(main, sub=0):
    return main << 16 | sub << 24


def in_auto(sub):
    return number(AUTO, sub)


@pytest.fixture
def start_px4(start_vehicles, scenario):
    def start(*options, speed=5, **autopilot):
        return start_vehicles(scenario(**autopilot), "--personality", "px4", "--speed", speed, *options).connect()[0]

    return start


@pytest.fixture
def px4(start_px4):
    """In the air, in Hold, at 10 m/s and 50 m, which is 100 m above the sea."""
    return start_px4()


def set_mode(craft, main, sub=0):
    return craft.command_long(mavlink.MAV_CMD_DO_SET_MODE, 1, main, sub)


def wait_mode(craft, custom_mode):
    return craft.wait(["HEARTBEAT"], lambda heartbeat: heartbeat.custom_mode == custom_mode)


def target(craft, mask, place=(0, 0, 0), velocity=(0, 0, 0), frame=mavlink.MAV_FRAME_LOCAL_NED):
    craft.link.mav.set_position_target_local_ned_send(
        0, craft.system, craft.component, frame, mask, *place, *velocity, 0, 0, 0, 0, 0
    )


def stream(craft, seconds, mask, **fields):
    """Streams a target at every position that the vehicle tells, over so many seconds of its time; gives the last
    one."""
    first = craft.sample()
    while True:
        target(craft, mask, **fields)
        sample = craft.sample()
        if sample.t_s > first.t_s + seconds:
            return sample


def fly_offboard(craft, seconds, mask, **fields):
    target(craft, mask, **fields)
    assert set_mode(craft, *OFFBOARD) == ACCEPTED
    return stream(craft, seconds, mask, **fields)


# Who it is


def test_it_says_that_it_is_a_px4(px4):
    heartbeat = px4.wait(["HEARTBEAT"])
    assert heartbeat.autopilot == mavlink.MAV_AUTOPILOT_PX4
    assert heartbeat.type == mavlink.MAV_TYPE_FIXED_WING
    assert (heartbeat.custom_mode, heartbeat.base_mode) == (in_auto(HOLD), 157)
    version = px4.request(mavlink.MAVLINK_MSG_ID_AUTOPILOT_VERSION, "AUTOPILOT_VERSION")
    assert version.flight_sw_version >> 8 == 0x011200
    assert version.capabilities & mavlink.MAV_PROTOCOL_CAPABILITY_PARAM_ENCODE_BYTEWISE
    assert not version.capabilities & mavlink.MAV_PROTOCOL_CAPABILITY_PARAM_ENCODE_C_CAST


def test_it_tells_its_modes_and_the_standard_ones_among_them(px4):
    px4.link.mav.command_long_send(px4.system, px4.component, mavlink.MAV_CMD_REQUEST_MESSAGE, 0, 435, 0, 0, 0, 0, 0, 0)
    modes = [px4.wait(["AVAILABLE_MODES"])]
    while len(modes) < modes[0].number_modes:
        modes.append(px4.wait(["AVAILABLE_MODES"]))
    named = {mode.mode_name: mode for mode in modes}
    assert named["Guided Course"].custom_mode == in_auto(COURSE)
    assert named["Return"].standard_mode == mavlink.MAV_STANDARD_MODE_SAFE_RECOVERY
    assert px4.command_long(mavlink.MAV_CMD_DO_SET_STANDARD_MODE, mavlink.MAV_STANDARD_MODE_SAFE_RECOVERY) == ACCEPTED
    current = px4.request(436, "CURRENT_MODE")
    assert (current.custom_mode, current.standard_mode) == (in_auto(RETURN), mavlink.MAV_STANDARD_MODE_SAFE_RECOVERY)


# Parameters


def read(craft, name):
    craft.link.mav.param_request_read_send(craft.system, craft.component, name.encode(), -1)
    return craft.wait(["PARAM_VALUE"], lambda value: value.param_id == name)


def write(craft, name, value, kind):
    craft.link.mav.param_set_send(craft.system, craft.component, name.encode(), value, kind)
    return craft.wait(["PARAM_VALUE"], lambda value: value.param_id == name)


def bytewise(integer):
    return struct.unpack("<f", struct.pack("<i", integer))[0]


def as_integer(value):
    return struct.unpack("<i", struct.pack("<f", value.param_value))[0]


def test_parameters_have_px4s_names_and_all_are_listed(px4):
    px4.link.mav.param_request_list_send(px4.system, px4.component)
    listed, count = {}, None
    while len(listed) != count:
        value = px4.wait(["PARAM_VALUE"])
        listed[value.param_index], count = value.param_id, value.param_count
    names = set(listed.values())
    assert sorted(listed) == list(range(count)) and len(names) == count
    assert {
        "MAV_SYS_ID",
        "FW_AIRSPD_TRIM",
        "NAV_LOITER_RAD",
        "MIS_TAKEOFF_ALT",
        "COM_OF_LOSS_T",
        "NAV_DLL_ACT",
    } <= names
    assert not {"MAV_SYSID", "AIRSPEED_CRUISE", "WP_LOITER_RAD", "FS_GCS_ENABL"} & names


def test_integers_are_written_by_their_bytes(px4):
    value = read(px4, "MAV_SYS_ID")
    assert (value.param_type, as_integer(value)) == (mavlink.MAV_PARAM_TYPE_INT32, px4.system)
    assert as_integer(write(px4, "COM_OBL_RC_ACT", bytewise(5), mavlink.MAV_PARAM_TYPE_INT32)) == 5
    assert write(px4, "NAV_LOITER_RAD", 80.0, mavlink.MAV_PARAM_TYPE_REAL32).param_value == 80


def fly_two_points(craft, leg_m=600):
    """A mission northwards, then eastwards, whose items have a radius of their own."""
    items = [item(mavlink.MAV_CMD_NAV_WAYPOINT, *at, 60, p2=1000) for at in ((leg_m, 0), (leg_m, leg_m))]
    assert Uploader(craft.link, craft.system).upload(items) == mavlink.MAV_MISSION_ACCEPTED
    assert craft.command_long(mavlink.MAV_CMD_MISSION_START) == ACCEPTED
    return items


def test_a_waypoint_is_reached_where_a_px4_turns_to_the_next(px4):
    """2.24 s before it (NPFG's period, damping and switch distance); the item's own radius is a multicopter's."""
    point, _ = fly_two_points(px4)
    place = None
    while True:
        message = px4.wait(["GLOBAL_POSITION_INT", "MISSION_ITEM_REACHED"])
        if message.get_type() == "MISSION_ITEM_REACHED":
            break
        place = message
    left_m = (point[5] - place.lat) * 1e-7 * 111_319.5
    speed_mps = math.hypot(place.vx, place.vy) / 100
    # It has been told up to 0.2 s before, and is not yet there.
    assert 2.24 * speed_mps - 0.1 <= left_m <= (2.24 + 0.25) * speed_mps


def test_what_is_reached_is_told_again_and_a_mission_is_paused_from_then_on(px4):
    fly_two_points(px4, leg_m=200)
    state = px4.wait(["MISSION_CURRENT"], lambda told: told.mission_state == mavlink.MISSION_STATE_ACTIVE)
    assert state.mission_mode == 1
    assert [px4.wait(["MISSION_ITEM_REACHED"]).seq for _ in range(3)] == [0, 0, 0]
    assert set_mode(px4, AUTO, HOLD) == ACCEPTED
    px4.wait(["MISSION_CURRENT"], lambda told: told.mission_state == mavlink.MISSION_STATE_PAUSED)


def test_what_it_does_is_said_in_its_own_words(start_px4):
    craft = start_px4(speed=10, on_ground=True)
    assert craft.command_long(mavlink.MAV_CMD_NAV_TAKEOFF, p7=NAN) == ACCEPTED
    assert craft.command_long(mavlink.MAV_CMD_COMPONENT_ARM_DISARM, 1) == ACCEPTED
    wait_mode(craft, in_auto(HOLD))
    fly_two_points(craft, leg_m=200)
    wait_mode(craft, in_auto(MISSION))
    wait_mode(craft, in_auto(HOLD))
    assert craft.command_long(mavlink.MAV_CMD_NAV_LAND) == ACCEPTED
    craft.wait(["HEARTBEAT"], lambda told: not told.base_mode & mavlink.MAV_MODE_FLAG_SAFETY_ARMED, patience_s=30)
    said = [text.text for text in craft.texts]
    assert said == [
        "Using default takeoff altitude: 25.0 m", "Armed by external command", "Takeoff detected", "Executing Mission",
        "Mission finished, loitering", "Landing at current position", "Landing detected", "Disarmed by landing",
    ]  # fmt: skip


def test_an_item_comes_back_as_a_px4_keeps_it(px4):
    frame = mavlink.MAV_FRAME_GLOBAL_RELATIVE_ALT
    loiter = item(mavlink.MAV_CMD_NAV_LOITER_TIME, 200, p1=5, p2=7, p3=-60, frame=frame)
    uploader = Uploader(px4.link, px4.system)
    assert uploader.upload([item(mavlink.MAV_CMD_NAV_WAYPOINT, 100, p1=1, p2=2, frame=frame), loiter]) == 0
    kept = uploader.download()
    assert [one.frame for one in kept] == [mavlink.MAV_FRAME_GLOBAL_RELATIVE_ALT_INT] * 2
    assert [(one.param1, one.param2) for one in kept] == [(1, 2), (5, 1)]


def test_another_type_than_the_parameters_is_refused(px4):
    px4.link.mav.param_set_send(px4.system, px4.component, b"COM_OBL_RC_ACT", 5.0, mavlink.MAV_PARAM_TYPE_REAL32)
    error = px4.wait(["PARAM_ERROR"])
    assert error.error == TYPE_MISMATCH
    assert as_integer(read(px4, "COM_OBL_RC_ACT")) == 0


# Modes


@pytest.mark.parametrize(
    ("main", "sub", "text"),
    [(4, 7, "Unsupported auto mode"), (9, 0, "Unsupported main mode"),
     (3, 0, "Switching to Position is currently not available"),
     (4, 4, "Switching to Mission is currently not available"),
     (6, 0, "Switching to Offboard is currently not available")],
)  # fmt: skip
def test_a_mode_that_cannot_be_flown_is_rejected_for_now(px4, main, sub, text):
    assert set_mode(px4, main, sub) == TEMPORARILY_REJECTED
    assert px4.text().text == text
    assert px4.mode() == in_auto(HOLD)


def test_an_unused_param_must_be_zero_or_nan(px4):
    assert px4.command_long(mavlink.MAV_CMD_DO_CHANGE_SPEED, 0, 12, -1, 1) == DENIED
    assert px4.text().text == "Command: param 4 is not supported"
    assert px4.command_long(mavlink.MAV_CMD_DO_CHANGE_SPEED, 0, 12, -1, NAN) == ACCEPTED


@pytest.mark.parametrize(
    "command",
    [mavlink.MAV_CMD_GUIDED_CHANGE_SPEED, mavlink.MAV_CMD_GUIDED_CHANGE_ALTITUDE, mavlink.MAV_CMD_NAV_LOITER_UNLIM],
)
def test_what_px4_does_not_know_is_unsupported(px4, command):
    assert px4.command_int(command, z=60) == UNSUPPORTED


# Guided Course


def test_guided_course_follows_course_altitude_and_speed(px4):
    assert px4.command_long(mavlink.MAV_CMD_GUIDED_CHANGE_HEADING, 0, 60) == DENIED
    assert set_mode(px4, AUTO, COURSE) == ACCEPTED
    assert px4.command_long(mavlink.MAV_CMD_GUIDED_CHANGE_HEADING, 1, 60) == DENIED
    assert px4.command_long(mavlink.MAV_CMD_GUIDED_CHANGE_HEADING, 0, NAN) == DENIED
    assert px4.command_long(mavlink.MAV_CMD_GUIDED_CHANGE_HEADING, 0, 60) == ACCEPTED
    assert px4.command_long(mavlink.MAV_CMD_DO_CHANGE_ALTITUDE, 130, mavlink.MAV_FRAME_GLOBAL_RELATIVE_ALT) == ACCEPTED
    assert px4.command_long(mavlink.MAV_CMD_DO_CHANGE_SPEED, 0, 13, -1) == ACCEPTED
    *_, last = px4.samples(30)
    # 130 m above the sea are 80 m above home, whatever the frame.
    assert (last.speed_mps, last.altitude_m) == pytest.approx((13, 80), abs=0.1)
    assert last.course_rad == pytest.approx(math.radians(60), abs=1e-3)
    assert px4.mode() == in_auto(COURSE)


def test_altitudes_are_for_hold_and_guided_course(px4):
    assert px4.command_long(mavlink.MAV_CMD_DO_CHANGE_ALTITUDE, 120) == ACCEPTED
    assert px4.command_long(mavlink.MAV_CMD_NAV_RETURN_TO_LAUNCH) == ACCEPTED
    assert px4.text().text == "Returning to launch"
    assert px4.text().text.startswith("RTL: start return at ")
    assert px4.command_long(mavlink.MAV_CMD_DO_CHANGE_ALTITUDE, 120) == TEMPORARILY_REJECTED
    assert px4.text().text == "Altitude: mode is Return"


def test_a_return_climbs_comes_down_over_home_and_says_so(start_px4):
    """As a real one from 60 m: RTL_RETURN_ALT is the least altitude on the way, RTL_DESCEND_ALT the one at its end."""
    px4 = start_px4(speed=10)
    write(px4, "RTL_DESCEND_ALT", 70.0, mavlink.MAV_PARAM_TYPE_REAL32)
    assert read(px4, "RTL_RETURN_ALT").param_value == 100
    assert set_mode(px4, AUTO, RETURN) == ACCEPTED
    # Home is 50 m above the sea.
    assert px4.text().text == "RTL: start return at 150 m (100 m above destination)"
    assert px4.text().text == "RTL: completed, loitering"
    heights = [sample.altitude_m for sample in px4.samples(20)]
    assert heights[-1] == pytest.approx(70, abs=0.5)
    # From higher up it does not come down on the way.
    assert set_mode(px4, AUTO, HOLD) == ACCEPTED
    write(px4, "RTL_RETURN_ALT", 30.0, mavlink.MAV_PARAM_TYPE_REAL32)
    assert set_mode(px4, AUTO, RETURN) == ACCEPTED
    assert px4.text().text == "RTL: start return at 120 m (70 m above destination)"


def test_limits_round_and_above_home_are_told_in_px4s_words(px4):
    """GF_MAX_HOR_DIST and GF_MAX_VER_DIST; 0, as at first, is none."""
    reals = {name: read(px4, name).param_value for name in ("GF_MAX_HOR_DIST", "GF_MAX_VER_DIST")}
    assert reals == {"GF_MAX_HOR_DIST": 0, "GF_MAX_VER_DIST": 0}
    assert set_mode(px4, AUTO, RETURN) == ACCEPTED
    assert px4.text().text.startswith("RTL: start return at ")
    write(px4, "GF_MAX_VER_DIST", 40.0, mavlink.MAV_PARAM_TYPE_REAL32)
    said = [px4.text() for _ in range(2)]
    assert [text.text for text in said] == ["Geofence: exceeding maximum altitude above Home", "Failsafe activated"]
    assert {text.severity for text in said} == {mavlink.MAV_SEVERITY_CRITICAL}
    assert px4.mode() == in_auto(HOLD), "GF_ACTION is 2"
    write(px4, "GF_MAX_VER_DIST", 0.0, mavlink.MAV_PARAM_TYPE_REAL32)
    write(px4, "GF_MAX_HOR_DIST", 400.0, mavlink.MAV_PARAM_TYPE_REAL32)
    place = px4.wait(["GLOBAL_POSITION_INT"])
    px4.link.mav.command_int_send(
        px4.system, px4.component, mavlink.MAV_FRAME_GLOBAL, mavlink.MAV_CMD_DO_REPOSITION, 0, 0,
        -1, 1, 0, NAN, place.lat + 60_000, place.lon, 120,
    )  # fmt: skip
    assert px4.text().text == "Reposition is outside geofence"


def test_reposition_holds_elsewhere(px4):
    px4.command_long(mavlink.MAV_CMD_NAV_RETURN_TO_LAUNCH)
    assert px4.command_int(mavlink.MAV_CMD_DO_REPOSITION, -1, 0, 0, NAN, z=120) == DENIED
    place = px4.wait(["GLOBAL_POSITION_INT"])
    px4.link.mav.command_int_send(
        px4.system, px4.component, mavlink.MAV_FRAME_GLOBAL, mavlink.MAV_CMD_DO_REPOSITION, 0, 0,
        12, 1, 70, NAN, place.lat + 20_000, place.lon, 120,
    )  # fmt: skip
    assert px4.acknowledged(mavlink.MAV_CMD_DO_REPOSITION) == ACCEPTED
    assert px4.mode() == in_auto(HOLD)
    *_, last = px4.samples(60)
    assert (last.speed_mps, last.altitude_m) == pytest.approx((12, 70), abs=0.1)


# Offboard


@pytest.mark.parametrize(
    ("mask", "fields"),
    [(VELOCITY, {"velocity": (0, 12, 0)}), (VELOCITY_AND_ALTITUDE, {"place": (0, 0, -50), "velocity": (0, 12, 0)}),
     (0x9C7, {"velocity": (0, 12, 0)})],
)  # fmt: skip
def test_offboard_follows_velocities(px4, mask, fields):
    last = fly_offboard(px4, 10, mask, **fields)
    assert (last.speed_mps, last.course_rad, last.altitude_m) == pytest.approx((12, math.pi / 2, 50), abs=0.1)
    assert px4.mode() == number(*OFFBOARD)


def test_offboard_climbs_at_a_rate(px4):
    last = fly_offboard(px4, 15, VELOCITY, velocity=(12, 0, -2))
    assert last.climb_mps == pytest.approx(2, abs=0.1)


def test_a_body_velocity_turns_with_the_vehicle(px4):
    before = px4.sample()
    after = fly_offboard(px4, 2, VELOCITY, velocity=(12, 0, 0), frame=mavlink.MAV_FRAME_BODY_NED)
    assert after.speed_mps > before.speed_mps


def test_offboard_flies_over_a_place(px4):
    target(px4, PLACE, place=(200, 60, -60))
    assert set_mode(px4, *OFFBOARD) == ACCEPTED
    nearest = min(
        math.hypot(sample.x_m - 200, sample.y_m - 60)
        for sample in (stream(px4, 0.2, PLACE, place=(200, 60, -60)) for _ in range(150))
    )
    assert nearest < 10


@pytest.mark.parametrize("mask", [0xDE7, 0xDDF, 0xDCF, 0xDFC])
def test_half_a_target_is_a_stream_but_is_not_followed(px4, mask):
    target(px4, mask, velocity=(0, 12, 0))
    assert set_mode(px4, *OFFBOARD) == ACCEPTED
    stream(px4, 4, mask, velocity=(0, 12, 0))
    assert px4.text().text == f"Offboard: mask {mask:#05x} is not followed"
    assert px4.mode() == number(*OFFBOARD)


def test_a_target_of_nothing_is_no_stream(px4):
    target(px4, 0xFFF)
    assert px4.text().text == "SET_POSITION_TARGET invalid"
    target(px4, VELOCITY, velocity=(0, 12, 0), frame=mavlink.MAV_FRAME_BODY_FRD)
    assert set_mode(px4, *OFFBOARD) == TEMPORARILY_REJECTED


def test_without_setpoints_it_returns_and_with_them_it_is_back(px4):
    fly_offboard(px4, 3, VELOCITY, velocity=(0, 12, 0))
    lost = wait_mode(px4, in_auto(RETURN))
    assert lost.system_status == mavlink.MAV_STATE_CRITICAL
    assert "Failsafe activated: no offboard signal" in (px4.text().text, px4.text().text)
    stream(px4, 2, VELOCITY, velocity=(0, 12, 0))
    back = px4.wait(["HEARTBEAT"])
    assert (back.custom_mode, back.system_status) == (number(*OFFBOARD), mavlink.MAV_STATE_ACTIVE)


def test_another_mode_ends_the_loss_for_good(px4):
    write(px4, "COM_OBL_RC_ACT", bytewise(5), mavlink.MAV_PARAM_TYPE_INT32)
    fly_offboard(px4, 3, VELOCITY, velocity=(0, 12, 0))
    wait_mode(px4, in_auto(HOLD))
    assert set_mode(px4, AUTO, COURSE) == ACCEPTED
    stream(px4, 2, VELOCITY, velocity=(0, 12, 0))
    assert px4.mode() == in_auto(COURSE)


def test_the_loss_of_setpoints_waits_as_long_as_it_is_told(px4):
    write(px4, "COM_OF_LOSS_T", 5.0, mavlink.MAV_PARAM_TYPE_REAL32)
    last = fly_offboard(px4, 3, VELOCITY, velocity=(0, 12, 0))
    wait_mode(px4, in_auto(RETURN))
    assert 5 <= px4.sample().t_s - last.t_s < 8


# The ground station


def test_without_a_ground_station_it_holds_and_then_returns(px4):
    write(px4, "NAV_DLL_ACT", bytewise(2), mavlink.MAV_PARAM_TYPE_INT32)
    px4.heartbeat()
    assert set_mode(px4, AUTO, COURSE) == ACCEPTED
    wait_mode(px4, in_auto(HOLD))
    assert px4.text().text == "Failsafe activated: entering Hold for 5 seconds"
    lost = wait_mode(px4, in_auto(RETURN))
    assert lost.system_status == mavlink.MAV_STATE_CRITICAL
    px4.heartbeat()
    assert px4.mode() == in_auto(RETURN)
    assert set_mode(px4, AUTO, HOLD) == ACCEPTED
    px4.heartbeat()
    assert px4.wait(["HEARTBEAT"]).system_status == mavlink.MAV_STATE_ACTIVE


# From the ground and back


def test_it_takes_off_holds_lands_and_disarms(start_px4):
    px4 = start_px4("--on-ground", speed=10)
    assert px4.mode() == in_auto(HOLD)
    write(px4, "MIS_TAKEOFF_ALT", 40.0, mavlink.MAV_PARAM_TYPE_REAL32)
    assert px4.command_long(mavlink.MAV_CMD_COMPONENT_ARM_DISARM, 1) == ACCEPTED
    assert px4.command_long(mavlink.MAV_CMD_NAV_TAKEOFF, 0, 0, 0, NAN, p7=NAN) == ACCEPTED
    wait_mode(px4, in_auto(TAKEOFF))
    wait_mode(px4, in_auto(HOLD))
    *_, last = px4.samples(10)
    assert last.altitude_m == pytest.approx(40, abs=1)
    assert px4.command_long(mavlink.MAV_CMD_COMPONENT_ARM_DISARM, 0) == TEMPORARILY_REJECTED
    assert px4.command_long(mavlink.MAV_CMD_NAV_LAND, 0, 0, 0, NAN, p7=NAN) == ACCEPTED
    px4.wait(["EXTENDED_SYS_STATE"], lambda state: state.landed_state == mavlink.MAV_LANDED_STATE_ON_GROUND)
    landed = px4.wait(["HEARTBEAT"], lambda heartbeat: not heartbeat.base_mode & mavlink.MAV_MODE_FLAG_SAFETY_ARMED)
    # It is armable again.
    assert landed.custom_mode == in_auto(HOLD)


def test_on_the_ground_any_mode_is_taken_and_arming_is_refused(start_px4):
    px4 = start_px4("--on-ground")
    assert set_mode(px4, *OFFBOARD) == ACCEPTED
    assert px4.command_long(mavlink.MAV_CMD_COMPONENT_ARM_DISARM, 1) == TEMPORARILY_REJECTED
    assert px4.text().text == "Arming denied: No offboard signal"
    target(px4, VELOCITY, velocity=(12, 0, 0))
    assert px4.command_long(mavlink.MAV_CMD_COMPONENT_ARM_DISARM, 1) == ACCEPTED


def test_armed_and_idle_it_disarms(start_px4):
    px4 = start_px4("--on-ground", "--param", "COM_DISARM_PRFLT=10")
    assert px4.command_long(mavlink.MAV_CMD_COMPONENT_ARM_DISARM, 1) == ACCEPTED
    armed = px4.sample()
    px4.wait(["HEARTBEAT"], lambda heartbeat: not heartbeat.base_mode & mavlink.MAV_MODE_FLAG_SAFETY_ARMED)
    assert 9 < px4.sample().t_s - armed.t_s < 13


def test_it_takes_off_by_setpoints_alone(start_px4):
    px4 = start_px4("--on-ground", speed=10)
    high = {"place": (0, 0, -40), "velocity": (12, 0, 0)}
    target(px4, VELOCITY_AND_ALTITUDE, **high)
    assert set_mode(px4, *OFFBOARD) == ACCEPTED
    assert px4.command_long(mavlink.MAV_CMD_COMPONENT_ARM_DISARM, 1) == ACCEPTED
    level = stream(px4, 3, VELOCITY_AND_ALTITUDE, place=(0, 0, 0), velocity=(12, 0, 0))
    assert (level.speed_mps, level.altitude_m) == (0, 0)
    last = stream(px4, 60, VELOCITY_AND_ALTITUDE, **high)
    assert (last.speed_mps, last.altitude_m) == pytest.approx((12, 40), abs=0.5)
    assert px4.mode() == number(*OFFBOARD)


@pytest.mark.parametrize(
    ("main", "sub", "words"),
    [
        (AUTO, MISSION, "No valid mission available"),
        (AUTO, RETURN, "Mode not armable"),
        (AUTO, LAND, "Mode not armable"),
    ],
)
def test_it_says_why_it_does_not_arm(start_px4, main, sub, words):
    px4 = start_px4("--on-ground")
    assert set_mode(px4, main, sub) == ACCEPTED
    assert px4.command_long(mavlink.MAV_CMD_COMPONENT_ARM_DISARM, 1) == TEMPORARILY_REJECTED
    assert px4.text().text == f"Arming denied: {words}"


# A bad link


def test_transfers_complete_over_a_link_that_loses_a_third_each_way(start_vehicles, scenario):
    row = start_vehicles(scenario(), "--personality", "px4", "--loss", 0.3).rows[0]
    link = connection(row["address"])
    Lists(link, [row["system_id"]]).fetch()
    waypoints = [item(mavlink.MAV_CMD_NAV_WAYPOINT, north_m) for north_m in range(100, 1100, 100)]
    uploader = Uploader(link, row["system_id"])
    assert uploader.upload(waypoints) == mavlink.MAV_MISSION_ACCEPTED
    assert len(uploader.download()) == len(waypoints)
    link.close()


# Missions


def test_the_first_item_of_a_mission_is_flown_and_hold_follows(px4):
    place = px4.wait(["GLOBAL_POSITION_INT"])
    points = [(place.lat + 15_000, place.lon), (place.lat + 15_000, place.lon + 15_000)]
    px4.link.mav.mission_count_send(px4.system, px4.component, len(points))
    for lat, lon in points:
        asked = px4.wait(["MISSION_REQUEST_INT"]).seq
        px4.link.mav.mission_item_int_send(
            px4.system, px4.component, asked, mavlink.MAV_FRAME_GLOBAL_RELATIVE_ALT_INT, mavlink.MAV_CMD_NAV_WAYPOINT,
            int(asked == 0), 1, 0, 20, 0, NAN, lat, lon, 60,
        )  # fmt: skip
    assert px4.wait(["MISSION_ACK"]).type == mavlink.MAV_MISSION_ACCEPTED
    assert px4.command_long(mavlink.MAV_CMD_MISSION_START) == ACCEPTED
    for seq in range(len(points)):
        # The one before is told again once a second.
        assert px4.wait(["MISSION_ITEM_REACHED"], lambda reached: reached.seq >= seq).seq == seq
    wait_mode(px4, in_auto(HOLD))
    px4.link.mav.mission_request_list_send(px4.system, px4.component)
    assert px4.wait(["MISSION_COUNT"]).count == len(points)
    px4.link.mav.mission_request_int_send(px4.system, px4.component, 0)
    first = px4.wait(["MISSION_ITEM_INT"])
    assert (first.x, first.y) == points[0]
