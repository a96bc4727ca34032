"""SET_ATTITUDE_TARGET: an ArduPlane flies by it in GUIDED, each axis for three seconds; a PX4 in Offboard, by a
stream."""

import math

import pytest
from ground import ACCEPTED, GUIDED
from pymavlink.dialects.v20 import all as mavlink

OFFBOARD = 6
IGNORE = mavlink.ATTITUDE_TARGET_TYPEMASK_ATTITUDE_IGNORE
# Only the attitude and the thrust count; only the thrust.
ATTITUDE, THRUST = 0x07, 0xBF
LEVEL = (0.0, 0.0, 0.0)


@pytest.fixture
def start(start_vehicles, scenario):
    """One in the air at 10 m/s. At the pace of the clock: what it forgets is timed."""

    def begin(personality):
        return start_vehicles(scenario(), "--personality", personality).connect()[0]

    return begin


def quaternion(*roll_pitch_yaw_deg):
    halves = [math.radians(angle) / 2 for angle in roll_pitch_yaw_deg]
    (cr, cp, cy), (sr, sp, sy) = map(math.cos, halves), map(math.sin, halves)
    return [
        cr * cp * cy + sr * sp * sy,
        sr * cp * cy - cr * sp * sy,
        cr * sp * cy + sr * cp * sy,
        cr * cp * sy - sr * sp * cy,
    ]


def send(craft, mask, attitude_deg=LEVEL, rates=LEVEL, thrust=0.0):
    q = quaternion(*attitude_deg)
    craft.link.mav.set_attitude_target_send(0, craft.system, craft.component, mask, q, *rates, thrust)


def stream_until(craft, where, kinds=("ATTITUDE",), **target):
    """Sends a target at each attitude that the vehicle tells until a message is as wanted; gives that one."""
    while True:
        said = craft.wait(["ATTITUDE", *kinds])
        if said.get_type() == "ATTITUDE":
            send(craft, **target)
        if said.get_type() in kinds and where(said):
            return said


def is_at(roll_deg, pitch_deg=None):
    def check(said):
        pitch_fits = pitch_deg is None or abs(math.degrees(said.pitch) - pitch_deg) < 1.0
        return abs(math.degrees(said.roll) - roll_deg) < 1.0 and pitch_fits

    return check


def test_an_arduplane_holds_an_attitude_for_three_seconds(start):
    craft = start("arduplane")
    last = stream_until(craft, is_at(20, 5), mask=ATTITUDE, attitude_deg=(20, 5, 0), thrust=0.6)
    assert last.yawspeed > 0.2
    craft.wait(["VFR_HUD"], lambda hud: hud.throttle == 60)
    send(craft, ATTITUDE, (20, 5, 0), thrust=0.6)
    level = craft.wait(["ATTITUDE"], is_at(0), patience_s=30)
    # Not sooner; later where this machine was busy when it was last set.
    assert 3000 <= level.time_boot_ms - last.time_boot_ms < 30_000
    assert craft.mode() == GUIDED


def test_an_arduplane_takes_each_axis_by_itself(start):
    craft = start("arduplane")
    fast = stream_until(craft, lambda hud: hud.airspeed > 13, kinds=["VFR_HUD"], mask=THRUST, thrust=1.0)
    assert abs(fast.climb) < 0.5
    # With the attitude left out the roll rate's bit chooses the bank.
    stream_until(craft, is_at(-15), mask=IGNORE | 0x46, attitude_deg=(-15, 10, 0))
    assert abs(craft.wait(["ATTITUDE"]).pitch) < math.radians(5)


def test_an_arduplane_hears_of_no_attitude_outside_guided(start):
    craft = start("arduplane")
    craft.set_mode(7)
    send(craft, ATTITUDE, (30, 0, 0), thrust=0.5)
    assert all(abs(said.roll) < 0.02 for said in craft.collect(["ATTITUDE"], 1))


@pytest.mark.parametrize(
    ("mask", "counts"),
    [(ATTITUDE, True), (0x00, True), (IGNORE, True), (0x47, False), (IGNORE | 0x02, False), (THRUST, False)],
    ids=hex,
)
def test_a_px4_enters_offboard_by_the_masks_that_count(start, mask, counts):
    craft = start("px4")
    for _ in range(3):
        send(craft, mask, thrust=0.5)
        result = craft.command_long(mavlink.MAV_CMD_DO_SET_MODE, 1, OFFBOARD)
        # A busy machine may have taken a second.
        if counts and result == ACCEPTED:
            return
        assert counts or result == mavlink.MAV_RESULT_TEMPORARILY_REJECTED
    assert not counts


def is_in(mode):
    return lambda beat: beat.custom_mode >> 16 == mode


def fly_offboard(craft, where, **target):
    """Streams a target in Offboard until an attitude is as wanted."""
    send(craft, **target)
    craft.link.mav.command_long_send(
        craft.system, craft.component, mavlink.MAV_CMD_DO_SET_MODE, 0, 1, OFFBOARD, 0, 0, 0, 0, 0
    )
    return stream_until(craft, where, **target)


def test_a_px4_flies_by_attitudes_returns_without_them_and_comes_back(start):
    craft = start("px4")
    target = {"mask": ATTITUDE, "attitude_deg": (-20, 4, 0), "thrust": 0.5}
    fly_offboard(craft, is_at(-20, 4), **target)
    craft.wait(["HEARTBEAT"], is_in(0x0504))
    stream_until(craft, is_in(OFFBOARD), kinds=["HEARTBEAT"], **target)
    assert stream_until(craft, is_at(-20, 4), **target)


def test_a_px4_turns_by_rates(start):
    craft = start("px4")
    target = {"mask": IGNORE, "rates": (0.3, 0.0, 0.0), "thrust": 0.5}
    fly_offboard(craft, lambda said: said.roll > math.radians(15), **target)
    stream_until(craft, lambda said: said.roll > math.radians(40), **target)
