"""Steps in speed, course and altitude against the closed form of the paper's Eq. 1.

When a vehicle takes a command is not in its telemetry, but its first motion is: the command was taken at or after the
last sample that does not move yet and before the first that does, at a whole integration step. Of these few instants,
two at the rate that is asked for here, the one that fits best is taken; then every sample has to lie within 2 % of
the step.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

import pytest
from ground import ACCEPTED
from pymavlink.dialects.v20 import ardupilotmega as mavlink

SPEED_S, COURSE_S, ALTITUDE_S = 1.0, 0.75, (1 / 3, 3.0)  # tau_V, tau_phi, (tau_a, tau_b) of section 4
STEP_S = 0.01
RATE_HZ = 50
TOLERANCE = 0.02


def first_order(tau_s):
    """What is left of a step after t, of a loop with one pole."""
    return lambda t_s: math.exp(-t_s / tau_s)


def second_order(a_s, b_s):
    """The same of a loop with poles at -1/a and -1/b that starts level."""
    return lambda t_s: (b_s * math.exp(-t_s / b_s) - a_s * math.exp(-t_s / a_s)) / (b_s - a_s)


@dataclass(frozen=True)
class Loop:
    """One of the three loops: its value in a sample, whether the sample shows motion, and its closed form."""

    value: Callable
    moves: Callable
    remainder: Callable


SPEED = Loop(lambda at: at.speed_mps, lambda at: abs(at.speed_mps - 10) > 1e-6, first_order(SPEED_S))
COURSE = Loop(lambda at: at.course_rad, lambda at: abs(at.course_rad) > 1e-7, first_order(COURSE_S))
ALTITUDE = Loop(lambda at: at.altitude_m, lambda at: abs(at.climb_mps) > 1e-7, second_order(*ALTITUDE_S))


@pytest.fixture
def craft(craft):
    assert craft.set_rate(mavlink.MAVLINK_MSG_ID_LOCAL_POSITION_NED, RATE_HZ) == ACCEPTED
    return craft


def fly(craft, command, seconds):
    """Commands, and gives the samples from the last that does not move yet on."""
    craft.sample()
    before = craft.samples(0.2)
    assert command() in (ACCEPTED, None)
    return before + craft.samples(seconds)


def worst_error(samples, loop, target, taken_s):
    """The greatest difference to the closed form, as a share of the step, for a command taken at an instant."""
    start = loop.value(samples[0])
    error = 0.0
    for at in samples:
        remainder = loop.remainder(at.t_s - taken_s) if at.t_s > taken_s else 1.0
        error = max(error, abs(loop.value(at) - (target + (start - target) * remainder)))
    return error / abs(target - start)


def check(samples, loop, target):
    """Compares every sample with the closed form; gives the greatest difference as a share of the step."""
    first = next(index for index, at in enumerate(samples) if loop.moves(at))
    assert first > 0, "the vehicle moved before it was asked to"
    earliest_s, latest_s = samples[first - 1].t_s, samples[first].t_s
    candidates = [earliest_s + STEP_S * step for step in range(round((latest_s - earliest_s) / STEP_S))]
    error = min(worst_error(samples, loop, target, taken_s) for taken_s in candidates)
    assert error < TOLERANCE, f"off by {error:.2%} of the step"
    assert abs(loop.value(samples[-1]) - target) < TOLERANCE * abs(target - loop.value(samples[0]))
    return error


@pytest.mark.parametrize("speed_mps", [13.0, 6.5])
def test_speed(craft, speed_mps):
    check(fly(craft, lambda: craft.change_speed(speed_mps), 6), SPEED, speed_mps)


@pytest.mark.parametrize("course_deg", [30, 300])
def test_course(craft, course_deg):
    target_rad = math.remainder(math.radians(course_deg), math.tau)
    check(fly(craft, lambda: craft.change_heading(course_deg), 5), COURSE, target_rad)


@pytest.mark.parametrize("altitude_m", [58.0, 45.0])
def test_altitude(craft, altitude_m):
    check(fly(craft, lambda: craft.change_altitude(altitude_m), 16), ALTITUDE, altitude_m)


def test_all_three_by_one_setpoint(craft):
    samples = fly(craft, lambda: craft.setpoint(12.5, math.radians(-25), 55.0), 16)
    check(samples, SPEED, 12.5)
    check(samples, COURSE, math.radians(-25))
    check(samples, ALTITUDE, 55.0)


def test_a_change_at_an_acceleration_is_a_ramp(craft):
    samples = fly(craft, lambda: craft.change_speed(14, acceleration_mps2=0.5), 6)
    # Behind the ramp the loop lags by its time constant: after 4 s it flies at the ramp's own acceleration.
    early, late = samples[-50], samples[-1]
    assert (late.speed_mps - early.speed_mps) / (late.t_s - early.t_s) == pytest.approx(0.5, rel=0.05)
