"""A vehicle of no autopilot in particular: standard modes, take-off and landing as commands, targets of every kind."""

import math

import pytest
from ground import ACCEPTED, FAILED, GUIDED, LOITER
from pymavlink.dialects.v20 import ardupilotmega as mavlink

LAND, TAKEOFF = 9, 13
NAN = float("nan")


@pytest.fixture
def start_generic(start_vehicles, scenario):
    def start(*options, speed=5):
        return start_vehicles(scenario(personality="generic"), "--speed", speed, *options).connect()[0]

    return start


@pytest.fixture
def generic(start_generic):
    """In the air, in GUIDED, at 10 m/s north and 50 m."""
    return start_generic()


def local_target(craft, mask, place=(0, 0, 0), velocity=(0, 0, 0)):
    craft.link.mav.set_position_target_local_ned_send(
        0, craft.system, craft.component, mavlink.MAV_FRAME_LOCAL_NED, mask, *place, *velocity, 0, 0, 0, 0, 0
    )


def test_it_says_what_its_modes_mean(generic):
    heartbeat = generic.wait(["HEARTBEAT"])
    assert heartbeat.autopilot == mavlink.MAV_AUTOPILOT_GENERIC
    assert heartbeat.custom_mode == GUIDED
    assert heartbeat.base_mode & mavlink.MAV_MODE_FLAG_GUIDED_ENABLED
    assert not heartbeat.base_mode & (mavlink.MAV_MODE_FLAG_AUTO_ENABLED | mavlink.MAV_MODE_FLAG_MANUAL_INPUT_ENABLED)


@pytest.mark.parametrize(
    ("standard", "custom"),
    [(mavlink.MAV_STANDARD_MODE_SAFE_RECOVERY, 11), (mavlink.MAV_STANDARD_MODE_CRUISE, 7),
     (mavlink.MAV_STANDARD_MODE_LAND, LAND), (mavlink.MAV_STANDARD_MODE_TAKEOFF, TAKEOFF)],
)  # fmt: skip
def test_standard_modes_are_set(generic, standard, custom):
    assert generic.command_long(mavlink.MAV_CMD_DO_SET_STANDARD_MODE, standard) == ACCEPTED
    assert generic.mode() == custom
    current = generic.request(436, "CURRENT_MODE")
    assert (current.custom_mode, current.standard_mode) == (custom, standard)


@pytest.mark.parametrize("standard", [0, mavlink.MAV_STANDARD_MODE_POSITION_HOLD, 99])
def test_a_standard_mode_that_it_has_not_is_refused(generic, standard):
    assert generic.command_long(mavlink.MAV_CMD_DO_SET_STANDARD_MODE, standard) == FAILED
    assert generic.text().text == f"No standard mode {standard}"
    assert generic.mode() == GUIDED


def test_each_mode_is_told_by_its_index(generic):
    assert generic.command_long(mavlink.MAV_CMD_REQUEST_MESSAGE, 435, 99) == FAILED
    first = generic.request(435, "AVAILABLE_MODES")
    generic.link.mav.command_long_send(
        generic.system, generic.component, mavlink.MAV_CMD_REQUEST_MESSAGE, 0, 435, first.number_modes, 0, 0, 0, 0, 0
    )
    last = generic.wait(["AVAILABLE_MODES"], lambda mode: mode.mode_index == mode.number_modes)
    assert (last.custom_mode, last.mode_name) == (GUIDED, "GUIDED")


@pytest.mark.parametrize(
    ("mask", "fields", "expected"),
    [
        (0xDE7, {"velocity": (0, 12, 0)}, (12, math.pi / 2, 50)),
        (0xDE3, {"place": (0, 0, -70), "velocity": (0, 12, 0)}, (12, math.pi / 2, 70)),
        (0xDFB, {"place": (0, 0, -60)}, (10, 0, 60)),
    ],
)  # fmt: skip
def test_velocities_and_altitudes_are_followed(generic, mask, fields, expected):
    local_target(generic, mask, **fields)
    *_, last = generic.samples(25)
    assert (last.speed_mps, last.course_rad, last.altitude_m) == pytest.approx(expected, abs=0.1)


def test_a_rate_of_climb_is_held(generic):
    local_target(generic, 0xDC7, velocity=(10, 0, -2))
    *_, last = generic.samples(15)
    assert last.climb_mps == pytest.approx(2, abs=0.1)


def test_a_place_on_the_globe_is_flown_over(generic):
    here = generic.wait(["GLOBAL_POSITION_INT"])
    there = (here.lat + 18_000, here.lon + 9_000)
    generic.link.mav.set_position_target_global_int_send(
        0, generic.system, generic.component, mavlink.MAV_FRAME_GLOBAL_RELATIVE_ALT, 0xDF8, *there, 60,
        0, 0, 0, 0, 0, 0, 0, 0,
    )  # fmt: skip
    metres = [
        math.hypot(
            (position.lat - there[0]) * 0.01113, (position.lon - there[1]) * 0.01113 * math.cos(math.radians(40))
        )
        for position in generic.collect(["GLOBAL_POSITION_INT"], 30)
    ]
    assert min(metres) < 5


@pytest.mark.parametrize(
    ("mask", "velocity", "text"),
    [(0xDEF, (0, 12, 0), "Setpoint refused: mask 0xdef is not followed"),
     (0xFFF, (0, 0, 0), "Setpoint refused: mask 0xfff is not followed"),
     (0xDE7, (NAN, 12, 0), "Setpoint refused: mask 0xde7 is not followed")],
)  # fmt: skip
def test_a_target_that_asks_for_nothing_whole_is_refused_in_words(generic, mask, velocity, text):
    local_target(generic, mask, velocity=velocity)
    assert generic.text().text == text
    assert generic.sample().course_rad == pytest.approx(0, abs=1e-6)


def test_targets_are_for_guided(generic):
    assert generic.set_mode(LOITER) == ACCEPTED
    local_target(generic, 0xDE7, velocity=(0, 12, 0))
    assert generic.text().text == "Setpoint refused: mode is LOITER"


@pytest.mark.parametrize(
    ("main", "sub", "custom"), [(4, 3, LOITER), (4, 5, 11), (4, 6, LAND), (4, 2, TAKEOFF), (6, 0, GUIDED)]
)
def test_modes_are_taken_in_px4s_numbers_as_mavsdk_sends_them(generic, main, sub, custom):
    generic.set_mode(7)
    assert generic.command_long(mavlink.MAV_CMD_DO_SET_MODE, 1, main, sub) == ACCEPTED
    assert generic.mode() == custom


def test_no_parameter_depends_on_how_whole_numbers_are_encoded(generic):
    generic.link.mav.param_request_list_send(generic.system, generic.component)
    first = generic.wait(["PARAM_VALUE"])
    kinds = {generic.wait(["PARAM_VALUE"]).param_type for _ in range(first.param_count - 1)}
    assert kinds == {mavlink.MAV_PARAM_TYPE_REAL32}


def test_items_are_asked_for_as_the_guide_says(generic):
    generic.link.mav.mission_count_send(generic.system, generic.component, 1)
    assert generic.wait(["MISSION_REQUEST_INT", "MISSION_REQUEST"]).get_type() == "MISSION_REQUEST_INT"


def test_it_takes_off_and_lands_by_command(start_generic):
    generic = start_generic("--on-ground", speed=10)
    take_off = mavlink.MAV_CMD_NAV_TAKEOFF
    assert generic.command_long(take_off, p7=40) == FAILED
    assert generic.text().text == "Takeoff: not armed"
    assert generic.command_long(mavlink.MAV_CMD_COMPONENT_ARM_DISARM, 1) == ACCEPTED
    assert generic.command_long(take_off, p7=40) == ACCEPTED
    *_, last = generic.samples(60)
    assert last.altitude_m == pytest.approx(40, abs=1)
    assert generic.command_long(mavlink.MAV_CMD_NAV_LAND) == ACCEPTED
    assert generic.mode() == LAND
    generic.wait(["EXTENDED_SYS_STATE"], lambda state: state.landed_state == mavlink.MAV_LANDED_STATE_ON_GROUND)
    generic.wait(["HEARTBEAT"], lambda heartbeat: not heartbeat.base_mode & mavlink.MAV_MODE_FLAG_SAFETY_ARMED)
