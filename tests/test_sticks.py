"""Flying by the sticks: RC_CHANNELS_OVERRIDE and MANUAL_CONTROL."""

import math

import pytest
from ground import ACCEPTED, CRUISE, GUIDED
from pymavlink.dialects.v20 import ardupilotmega as mavlink

FBWA = 5
LEFT_ALONE = 65535


def override(craft, roll=LEFT_ALONE, pitch=LEFT_ALONE, throttle=LEFT_ALONE):
    rest = [LEFT_ALONE] * 5
    craft.link.mav.rc_channels_override_send(craft.system, 1, roll, pitch, throttle, *rest)


def hold(craft, seconds, **sticks):
    """Holds the sticks for so many seconds of the vehicle's time, and gives where it was."""
    track, end_s = [], None
    while end_s is None or track[-1].t_s < end_s:
        override(craft, **sticks)
        track.append(craft.sample())
        end_s = end_s or track[0].t_s + seconds
    return track


@pytest.mark.parametrize("mode", [FBWA, CRUISE])
def test_roll_turns_pitch_climbs_throttle_speeds_up(craft, mode):
    assert craft.set_mode(mode) == ACCEPTED
    right = hold(craft, 2, roll=1700)
    assert 0.3 < right[-1].course_rad - right[0].course_rad < 3
    assert right[-1].altitude_m == pytest.approx(50, abs=0.1)
    up = hold(craft, 4, roll=1500, pitch=2000)
    assert up[-1].climb_mps > 1.5
    fast = hold(craft, 6, roll=1500, pitch=1500, throttle=2000)
    assert fast[-1].speed_mps == pytest.approx(15, abs=0.1)


def test_sticks_let_go_hold_what_is_flown(craft):
    assert craft.set_mode(CRUISE) == ACCEPTED
    hold(craft, 2, roll=1900)
    override(craft, roll=0)
    first, *_, last = craft.samples(6)[20:]
    assert math.remainder(last.course_rad - first.course_rad, math.tau) == pytest.approx(0, abs=1e-2)


def test_an_override_ends_after_three_seconds(craft):
    assert craft.set_mode(CRUISE) == ACCEPTED
    override(craft, roll=1900)
    message = craft.request(mavlink.MAVLINK_MSG_ID_RC_CHANNELS, "RC_CHANNELS")
    assert (message.chan1_raw, message.chan2_raw, message.chan3_raw) == (1900, 1500, 1000)
    first, *_, last = craft.samples(8)[45:]
    assert math.remainder(last.course_rad - first.course_rad, math.tau) == pytest.approx(0, abs=1e-2)
    assert craft.request(mavlink.MAVLINK_MSG_ID_RC_CHANNELS, "RC_CHANNELS").chan1_raw == 1500


def test_in_guided_and_from_others_sticks_move_nothing(craft):
    track = hold(craft, 2, roll=1900, pitch=1900)
    assert craft.mode() == GUIDED
    assert track[-1].course_rad == pytest.approx(0, abs=1e-6)


def test_manual_control_is_sticks_too(craft):
    assert craft.set_mode(FBWA) == ACCEPTED
    for _ in range(20):
        craft.link.mav.manual_control_send(craft.system, -500, 300, 1000, 0, 0)
        last = craft.sample()
    assert last.climb_mps > 0.5 and last.speed_mps > 11 and last.course_rad != 0


def test_by_hand_from_the_ground(start_vehicles, scenario):
    craft = start_vehicles(scenario(), "--on-ground", "--speed", 5).connect()[0]
    assert craft.command_long(mavlink.MAV_CMD_COMPONENT_ARM_DISARM, 1) == ACCEPTED
    assert hold(craft, 2, pitch=1500, throttle=1000)[-1].speed_mps == 0
    rolls = hold(craft, 4, pitch=1500, throttle=1600)
    assert rolls[-1].altitude_m == 0 and rolls[-1].speed_mps > 5
    assert hold(craft, 4, pitch=1800, throttle=1600)[-1].altitude_m > 2
