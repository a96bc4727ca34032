"""A pilot's receiver that fails, arming by the rudder stick, how long overrides hold, and ArduPilot's port for
sticks."""

import socket
import struct

import pytest
from ground import ACCEPTED, GUIDED, LOITER, RTL
from pymavlink.dialects.v20 import ardupilotmega as mavlink
from test_failsafes import words
from test_ports import ask, connect, free_instance, heard, run  # noqa: F401
from test_sticks import hold

MANUAL, CIRCLE, FBWA, FBWB = 0, 1, 5, 6
ALONE = 65535
RECEIVER = mavlink.MAV_SYS_STATUS_SENSOR_RC_RECEIVER


@pytest.fixture
def craft(start_vehicles, scenario):
    """One that needs no stream of setpoints, five times as fast as the clock, and has seen its switches."""
    craft = start_vehicles(scenario(setpoint_timeout_s=0), "--speed", 5).connect()[0]
    craft.samples(2)
    return craft


@pytest.fixture
def grounded(start_vehicles, scenario):
    return start_vehicles(scenario(on_ground=True), "--speed", 5).connect()[0]


def in_mode(craft, number):
    craft.wait(["HEARTBEAT"], lambda beat: beat.custom_mode == number)


def override(craft, **held):
    """Channels by their names, as throttle=1000."""
    names = ("roll", "pitch", "throttle", "rudder")
    craft.link.mav.rc_channels_override_send(craft.system, 1, *(held.get(name, ALONE) for name in names), *[ALONE] * 4)


def test_a_throttle_below_its_range_circles_at_once_and_then_returns(craft):
    assert craft.set_mode(MANUAL) == ACCEPTED
    craft.set_parameter("SIM_RC_FAIL", 2)
    assert words(craft, "Throttle").text == "Throttle failsafe on"
    assert words(craft, "RC").text == "RC Short Failsafe: switched to CIRCLE"
    status = craft.wait(["SYS_STATUS"], lambda status: not status.onboard_control_sensors_health & RECEIVER)
    assert status.onboard_control_sensors_present & RECEIVER
    assert craft.request(mavlink.MAVLINK_MSG_ID_RC_CHANNELS, "RC_CHANNELS").chan3_raw == 950
    assert words(craft, "RC").text == "RC Long Failsafe On: switched to RTL"
    in_mode(craft, RTL)
    # Its last pulses stay, until the transmitter is heard again or overridden.
    craft.set_parameter("SIM_RC_FAIL", 0)
    override(craft, throttle=1000)
    assert words(craft, "Throttle").text == "Throttle failsafe off"
    assert words(craft, "RC").text == "RC Long Failsafe Cleared"
    # Centred is another position of the mode switch than before.
    in_mode(craft, FBWA)


def test_without_pulses_a_short_failsafe_ends_in_the_mode_before(craft):
    assert craft.set_mode(FBWA) == ACCEPTED
    craft.set_parameter("FS_SHORT_ACTN", 4)
    craft.set_parameter("FS_LONG_TIMEOUT", 60)
    craft.set_parameter("SIM_RC_FAIL", 1)
    assert words(craft, "RC").text == "RC Short Failsafe: switched to FBWB"
    in_mode(craft, FBWB)
    craft.set_parameter("SIM_RC_FAIL", 0)
    assert words(craft, "RC").text == "RC Short Failsafe Cleared"
    assert words(craft, "Flight").text == "Flight mode FBWA restored"
    in_mode(craft, FBWA)


def test_a_mode_that_somebody_sets_meanwhile_stays(craft):
    craft.set_parameter("FS_SHORT_ACTN", 1)
    craft.set_parameter("FS_LONG_TIMEOUT", 60)
    craft.set_parameter("SIM_RC_FAIL", 1)
    in_mode(craft, CIRCLE)
    assert craft.set_mode(LOITER) == ACCEPTED
    craft.set_parameter("SIM_RC_FAIL", 0)
    assert words(craft, "RC Short Failsafe C").text == "RC Short Failsafe Cleared"
    assert craft.mode() == LOITER


@pytest.mark.parametrize(("name", "value"), [("THR_FAILSAFE", 0), ("THR_FAILSAFE", 2), ("FS_SHORT_ACTN", 3)])
def test_what_is_switched_off_does_nothing_at_once(craft, name, value):
    craft.set_parameter(name, value)
    craft.set_parameter("FS_LONG_TIMEOUT", 60)
    assert craft.set_mode(FBWA) == ACCEPTED
    craft.set_parameter("SIM_RC_FAIL", 1)
    craft.samples(4)
    assert craft.mode() == FBWA


def test_guided_goes_on_by_default_and_says_so(craft):
    craft.set_parameter("SIM_RC_FAIL", 1)
    assert words(craft, "RC").text == "RC Short Failsafe On"
    assert words(craft, "RC").text == "RC Long Failsafe On: switched to GUIDED"
    assert craft.mode() == GUIDED
    assert craft.wait(["HEARTBEAT"]).system_status == mavlink.MAV_STATE_CRITICAL


def test_overrides_stand_in_for_a_receiver(craft):
    assert craft.set_mode(FBWA) == ACCEPTED
    craft.set_parameter("SIM_RC_FAIL", 1)
    hold(craft, 5, roll=1500, pitch=1500, throttle=1500)
    assert craft.mode() == FBWA
    assert words(craft, "Throttle").text == "Throttle failsafe on"


def test_on_the_ground_a_failed_receiver_stands_against_arming(grounded):
    grounded.set_parameter("SIM_RC_FAIL", 1)
    words(grounded, "Throttle failsafe on")
    in_mode(grounded, RTL)
    assert grounded.set_mode(MANUAL) == ACCEPTED
    assert grounded.command_long(mavlink.MAV_CMD_COMPONENT_ARM_DISARM, 1) == mavlink.MAV_RESULT_FAILED
    assert words(grounded, "Arm").text == "Arm: Radio failsafe on"


def hold_rudder(craft, pulse_us, seconds=4):
    end_ms = None
    while end_ms is None or craft.wait(["LOCAL_POSITION_NED"]).time_boot_ms < end_ms:
        override(craft, throttle=1000, rudder=pulse_us)
        end_ms = end_ms or craft.wait(["LOCAL_POSITION_NED"]).time_boot_ms + 1000 * seconds
    override(craft, rudder=1500)


def is_armed(craft):
    return bool(craft.wait(["HEARTBEAT"]).base_mode & mavlink.MAV_MODE_FLAG_SAFETY_ARMED)


def test_the_rudder_stick_arms_and_with_2_disarms(grounded):
    hold_rudder(grounded, 2000, 1)
    assert not is_armed(grounded)
    hold_rudder(grounded, 2000)
    assert words(grounded, "Throttle").text == "Throttle armed"
    hold_rudder(grounded, 1000)
    assert is_armed(grounded)
    grounded.set_parameter("ARMING_RUDDER", 2)
    hold_rudder(grounded, 1000)
    assert words(grounded, "Throttle").text == "Throttle disarmed"
    grounded.set_parameter("ARMING_RUDDER", 0)
    hold_rudder(grounded, 2000)
    assert not is_armed(grounded)


@pytest.mark.parametrize(("stick", "words_of_it"), [("roll", "Roll (RC1)"), ("throttle", "Throttle (RC3)")])
def test_sticks_that_are_not_neutral_stand_against_arming(grounded, stick, words_of_it):
    override(grounded, **{stick: 1700})
    grounded.samples(0.5)
    assert grounded.command_long(mavlink.MAV_CMD_COMPONENT_ARM_DISARM, 1) == mavlink.MAV_RESULT_FAILED
    assert words(grounded, "Arm").text == f"Arm: {words_of_it} is not neutral"


def roll_us(craft):
    return craft.request(mavlink.MAVLINK_MSG_ID_RC_CHANNELS, "RC_CHANNELS").chan1_raw


def test_overrides_hold_as_long_as_they_may(craft):
    craft.set_parameter("RC_OVERRIDE_TIME", -1)
    override(craft, roll=1700)
    craft.samples(6)
    assert roll_us(craft) == 1700
    craft.set_parameter("RC_OVERRIDE_TIME", 1)
    craft.samples(0.5)
    assert roll_us(craft) == 1500
    craft.set_parameter("RC_OVERRIDE_TIME", 0)
    override(craft, roll=1700)
    craft.samples(0.5)
    assert roll_us(craft) == 1500


def test_sticks_come_through_ardupilots_own_port(run):
    instance = free_instance(14_550, 5_760, 10)
    run("--count", "1", "--ports", "ardupilot", "--instance", str(instance))
    link = connect(f"tcp:127.0.0.1:{5_760 + 10 * instance}")
    assert heard(link)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as transmitter:
        for channels, expected in [
            ([1700, 1500, 1200, 1500, 1800, 1000, 1000, 1800], (1700, 1200)),
            # 0 leaves a channel.
            ([0, 1500, 1300, *[1500] * 13], (1700, 1300)),
        ]:
            transmitter.sendto(struct.pack(f"<{len(channels)}H", *channels), ("127.0.0.1", 5_501 + 10 * instance))
            assert any(shown(link) == expected for _ in range(20)), expected
    link.close()


def shown(link):
    ask(link, mavlink.MAVLINK_MSG_ID_RC_CHANNELS)
    message = heard(link, "RC_CHANNELS")
    return message.chan1_raw, message.chan3_raw


def test_a_closed_throttle_glides_in_fbwa_and_not_in_fbwb(craft):
    for mode, sinks in ((FBWA, True), (FBWB, False)):
        assert craft.set_mode(mode) == ACCEPTED
        track = hold(craft, 6, roll=1500, pitch=1500, throttle=1000)
        assert (track[-1].altitude_m < track[0].altitude_m - 1) == sinks, track[-1]
        assert track[-1].speed_mps < 6
