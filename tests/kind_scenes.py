"""Scenes of the kinds of faults that other people's scripts found: params that modify a command, selectors, value sets,
which item is current, which bits of a mask count."""

import math

from differential import scene
from pymavlink.dialects.v20 import ardupilotmega as mavlink

INTERVAL, REBOOT, SPEED = (
    mavlink.MAV_CMD_SET_MESSAGE_INTERVAL,
    mavlink.MAV_CMD_PREFLIGHT_REBOOT_SHUTDOWN,
    mavlink.MAV_CMD_DO_CHANGE_SPEED,
)
GUIDED, AUTO, RTL = 15, 10, 11
FRAMES = range(22)
TAG = 600


@scene
def params_that_modify(talk):
    for name, params in {
        "an interval with a third param": (INTERVAL, mavlink.MAVLINK_MSG_ID_ATTITUDE, 1_000_000, 1),
        "a reboot of neither kind": (REBOOT, 2),
        "a parachute is released": (mavlink.MAV_CMD_DO_PARACHUTE, 2),
        "something else is done with a parachute": (mavlink.MAV_CMD_DO_PARACHUTE, 3),
        "an auxiliary function at a place that there is not": (mavlink.MAV_CMD_DO_AUX_FUNCTION, 41, 3),
        "an image by a camera below 0": (mavlink.MAV_CMD_IMAGE_START_CAPTURE, -1),
        "no image by the first camera": (mavlink.MAV_CMD_IMAGE_STOP_CAPTURE, 1),
        "neither with nor without high latency": (mavlink.MAV_CMD_CONTROL_HIGH_LATENCY, 2),
        "a safety switch in a third position": (mavlink.MAV_CMD_DO_SET_SAFETY_SWITCH_STATE, 2),
        "the first source of the EKF": (mavlink.MAV_CMD_SET_EKF_SOURCE_SET, 1),
        "the fourth source of the EKF": (mavlink.MAV_CMD_SET_EKF_SOURCE_SET, 4),
        "wind of a negative speed": (43_004, -1),
        "wind from beyond all directions": (43_004, 3, 0, 361),
        "a tag of more than 16 bits": (mavlink.MAV_CMD_DO_JUMP_TAG, 70_000),
        "the protocol's version, without param 1": (mavlink.MAV_CMD_REQUEST_PROTOCOL_VERSION, 0),
        "the capabilities, without param 1": (mavlink.MAV_CMD_REQUEST_AUTOPILOT_CAPABILITIES, 0),
        "the first item of a mission that is started": (mavlink.MAV_CMD_MISSION_START, 1),
        "a fence in a fourth way": (mavlink.MAV_CMD_DO_FENCE_ENABLE, 3),
    }.items():
        with talk.step(name):
            talk.long(*params)
    with talk.step("a take-off in a frame of its own"):
        talk.int(mavlink.MAV_CMD_NAV_TAKEOFF, z=-50, frame=mavlink.MAV_FRAME_LOCAL_OFFSET_NED)
    with talk.step("a take-off above home"):
        talk.int(mavlink.MAV_CMD_NAV_TAKEOFF, z=50)
    with talk.step("a place from outside, with an altitude"):
        talk.int(mavlink.MAV_CMD_EXTERNAL_POSITION_ESTIMATE, z=50, frame=mavlink.MAV_FRAME_GLOBAL)


@scene
def value_sets(talk):
    for name, values in {
        "FS_LONG_ACTN": range(6),
        "BATT_FS_LOW_ACT": range(8),
        "BATT_FS_CRT_ACT": range(8),
        "RTL_AUTOLAND": range(5),
        "FS_GCS_ENABL": range(4),
        "FENCE_ACTION": (0, 1, 6, 7, 8),
        "FENCE_AUTOENABLE": range(4),
        "FENCE_OPTIONS": range(8),
    }.items():
        for value in values:
            with talk.step(f"{name} {value}"):
                talk.set(name, value)


@scene
def kinds_of_speed(talk):
    talk.take_off()
    talk.mode(GUIDED)
    talk.settle()
    for kind in range(5):
        with talk.step(f"a speed of kind {kind}"):
            talk.long(SPEED, kind, 12, 0)
        with talk.step(f"a throttle beside a speed of kind {kind} that nothing flies"):
            talk.long(SPEED, kind, 1000, 50)
    with talk.step("the usual speed"):
        talk.long(SPEED, 0, -2, 0)
    with talk.step("a speed of no size"):
        talk.long(SPEED, 0, 0, 0)
    for kind in range(4):
        with talk.step(f"a heading of kind {kind}"):
            talk.long(mavlink.MAV_CMD_GUIDED_CHANGE_HEADING, kind, 90, 20)


@scene
def altitude_frames(talk):
    talk.take_off()
    talk.mode(GUIDED)
    talk.settle()
    here = talk.place(0, 0)
    for frame in FRAMES:
        with talk.step(f"a guided altitude in frame {frame}"):
            talk.int(mavlink.MAV_CMD_GUIDED_CHANGE_ALTITUDE, z=70, frame=frame)
    talk.mode(RTL)
    talk.mode(GUIDED)
    talk.settle()
    for frame in FRAMES:
        with talk.step(f"an altitude in frame {frame}"):
            talk.long(mavlink.MAV_CMD_DO_CHANGE_ALTITUDE, 70, frame)
        with talk.step(f"a place in frame {frame}"):
            talk.int(mavlink.MAV_CMD_DO_REPOSITION, -1, 0, 0, 0, *here, 70, frame=frame)


@scene
def current_items(talk):
    points = [talk.item(16, 0, 0), talk.item(TAG, p1=7), *(talk.item(16, 300 * n, 300) for n in range(1, 4))]
    with talk.step("a mission"):
        talk.upload([talk.item(16), *points])
    for name, command in {
        "the third item": (mavlink.MAV_CMD_DO_SET_MISSION_CURRENT, 3),
        "an item beyond the end": (mavlink.MAV_CMD_DO_SET_MISSION_CURRENT, 9),
        "home": (mavlink.MAV_CMD_DO_SET_MISSION_CURRENT, 0),
        "an item below 0": (mavlink.MAV_CMD_DO_SET_MISSION_CURRENT, -1),
        "the fourth item, and its jumps anew": (mavlink.MAV_CMD_DO_SET_MISSION_CURRENT, 4, 1),
        "the tag": (mavlink.MAV_CMD_DO_JUMP_TAG, 7),
        "a tag that there is not": (mavlink.MAV_CMD_DO_JUMP_TAG, 8),
    }.items():
        with talk.step(f"by a command: {name}"):
            talk.long(*command)
    for seq in (2, 9, 5):
        with talk.step(f"by a message: {seq}"):
            talk.mav.mission_set_current_send(talk.system, talk.component, seq)
    with talk.step("a shorter mission"):
        talk.upload([talk.item(16), *points[:2]])
    with talk.step("cleared"):
        talk.mav.mission_clear_all_send(talk.system, talk.component, 0)


@scene
def attitudes(talk):
    talk.take_off()
    talk.mode(GUIDED)
    talk.settle()
    for mask in (0x00, 0x07, 0x47, 0x80, 0xC0, 0xC6, 0xC5, 0xC3, 0xC7, 0xBF, 0x87):
        with talk.step(f"an attitude with the mask {mask:#04x}"):
            talk.answers += flown(talk, mask)
        # Forgotten after 3 s.
        talk.rest(5)


def flown(talk, mask, roll_deg=-25, pitch_deg=14, thrust=0.55):
    """What of an attitude that is sent again and again is flown. A real plane does not keep up a pitch without
    throttle."""
    (sr, cr), (sp, cp) = ((math.sin(a), math.cos(a)) for a in (math.radians(roll_deg) / 2, math.radians(pitch_deg) / 2))
    rolls, pitches = [], []
    end = talk.beats + 6
    while talk.beats < end:
        talk.mav.set_attitude_target_send(
            0, talk.system, talk.component, mask, [cr * cp, sr * cp, cr * sp, -sr * sp], 0, 0, 0, thrust
        )
        if talk.hear().get_type() == "ATTITUDE":
            rolls.append(math.degrees(talk.newest["ATTITUDE"].roll))
            pitches.append(math.degrees(talk.newest["ATTITUDE"].pitch))
    follows = {
        "banks": min(rolls) < 0.7 * roll_deg,
        "pitches": max(pitches) > 0.7 * pitch_deg,
        "throttles": talk.newest["VFR_HUD"].throttle == round(100 * thrust),
    }
    return [word for word, is_so in follows.items() if is_so]
