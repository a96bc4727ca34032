"""A vehicle without setpoints loiters, and can be taken back."""

import math

import pytest
from ground import ACCEPTED, GUIDED, LOITER
from pymavlink.dialects.v20 import ardupilotmega as mavlink

TIMEOUT_S = 2


@pytest.fixture
def craft(start_vehicles, scenario):
    return start_vehicles(scenario(setpoint_timeout_s=TIMEOUT_S), "--speed", 4).connect()[0]


def test_without_setpoints_it_loiters_and_says_so(craft):
    craft.setpoint(11, 0, 50)
    text = craft.text()
    assert text.severity == mavlink.MAV_SEVERITY_CRITICAL
    assert text.text == "Failsafe: no setpoint for 2 s, LOITER"
    heartbeat = craft.wait(["HEARTBEAT"])
    assert (heartbeat.custom_mode, heartbeat.system_status) == (LOITER, mavlink.MAV_STATE_CRITICAL)

    craft.setpoint(14, math.radians(30), 60)
    assert craft.text().text == "Setpoint refused: mode is LOITER"

    assert craft.set_mode(GUIDED) == ACCEPTED
    craft.setpoint(14, math.radians(30), 50)
    heartbeat = craft.wait(["HEARTBEAT"])
    assert (heartbeat.custom_mode, heartbeat.system_status) == (GUIDED, mavlink.MAV_STATE_ACTIVE)
    follows = craft.wait(["LOCAL_POSITION_NED"], lambda at: math.hypot(at.vx, at.vy) > 13)
    assert math.atan2(follows.vy, follows.vx) == pytest.approx(math.radians(30), abs=0.3)


def test_a_stream_of_setpoints_keeps_it_in_guided(craft):
    first = craft.sample()
    while craft.sample().t_s < first.t_s + 3 * TIMEOUT_S:
        craft.setpoint(12, 0, 50)
    assert craft.mode() == GUIDED
    assert craft.sample().speed_mps == pytest.approx(12, abs=0.1)
