"""Every command, message, interval and mission item, one after another: what an autopilot answers to each.

    python tests/sweep.py udpout:127.0.0.1:14600 [ANSWERS.json [air]]

The vehicle stands on the ground, disarmed, fresh from its start, or (`air`) flies in its guided mode. The labels are
those of `reference/answers-*.json`, which real autopilots gave. An answer depends a little on those before it: always
play the whole sweep. `test_sweep.py` compares.
"""

import json
import math
import sys
import time

from pymavlink import mavutil
from pymavlink.dialects.v20 import all as mavlink

ARDUPILOT, PX4 = mavlink.MAV_AUTOPILOT_ARDUPILOTMEGA, mavlink.MAV_AUTOPILOT_PX4
# Restarts, calibrations and resets, which would spoil what follows.
LEFT_OUT = {11, 12, 43, 44, 45, 185, 241, 242, 243, 245, 246, 247, 2510, 2511}
LEFT_OUT |= {40001, 42424, 42425, 42426, 42501, 42650, 42651}
USER_COMMANDS = range(31000, 31015)
COMMANDS = [
    number
    for number in sorted(mavlink.enums["MAV_CMD"])
    if number < 60_000 and number not in LEFT_OUT and number not in USER_COMMANDS
]
# Without HEARTBEAT, which comes anyhow.
MESSAGES = [number for number in sorted(mavlink.mavlink_map) if 0 < number < 13_000]
# Commands that begin a flight: they are taken back.
THAT_ARM = (22, 84, 176, 300, 400)
# Commands that lead somewhere else: in the air they are taken back by the guided mode.
THAT_LEAD = (16, 17, 18, 19, 20, 21, 22, 34, 84, 85, 176, 189, 191, 192, 193, 195, 252, 300, 43_003)
PROBED_ITEMS = (16, 17, 18, 19, 20, 21, 22, 31, 93, 112, 178, 177, 206, 201)
SET_MODE, ARM_DISARM, SET_INTERVAL, REQUEST, WAYPOINT = 176, 400, 511, 512, 16
SILENCE_S = 0.8


def play(link, in_air=False):
    """Plays the sweep with the vehicle at the other end of a link: label -> answer, None for silence."""
    return Sweep(link).play(in_air)


class Sweep:
    def __init__(self, link):
        self.link, self.answers = link, {}
        self.beat_due = 0.0
        self.keep_alive()
        self.system = None
        heartbeat = self.wait(["HEARTBEAT"], 60.0)
        self.system, self.autopilot = heartbeat.get_srcSystem(), heartbeat.autopilot

    def play(self, in_air):
        place = self.place()
        for command in COMMANDS:
            self.command(command, place)
            if in_air and command in THAT_LEAD:
                self.long(SET_MODE, 1, *((15, 0) if self.autopilot == ARDUPILOT else (4, 19)))
            if not in_air and command in THAT_ARM:
                self.long(ARM_DISARM, 0)
        for message in MESSAGES:
            self.answers[f"request {message}"] = self.long(REQUEST, message)
        for message in MESSAGES:
            self.answers[f"interval {message}"] = self.long(SET_INTERVAL, message, 500_000)
            self.long(SET_INTERVAL, message, 0)
        self.items()
        return self.answers

    def place(self):
        """Latitude and longitude, 1e-7 degrees."""
        self.long(SET_INTERVAL, mavlink.MAVLINK_MSG_ID_GLOBAL_POSITION_INT, 250_000)
        position = self.wait(["GLOBAL_POSITION_INT"], 20.0)
        return position.lat, position.lon

    def command(self, command, place):
        # A place of zeros ends ArduPlane's simulation.
        x, y, z = (*place, 60) if self.autopilot == ARDUPILOT else (0, 0, 0)
        self.answers[f"long {command}"] = self.long(command, 0, 0, 0, 0, x / 1e7, y / 1e7, z)
        self.forget()
        frame = mavlink.MAV_FRAME_GLOBAL_RELATIVE_ALT
        self.link.mav.command_int_send(self.system, 1, frame, command, 0, 0, 0, 0, 0, 0, x, y, z)
        self.answers[f"int {command}"] = self.result(command)

    def long(self, command, *params):
        self.forget()
        self.link.mav.command_long_send(self.system, 1, command, 0, *params, *[0] * (7 - len(params)))
        return self.result(command)

    def result(self, command):
        ack = self.wait(["COMMAND_ACK"], SILENCE_S, lambda ack: ack.command == command)
        return None if ack is None else name("MAV_RESULT", ack.result)

    def items(self):
        latitude, longitude = self.place()
        for command in COMMANDS:
            self.answers[f"item {command}"] = self.upload(item(command, x=latitude + 2000, y=longitude))
        for frame in range(22):
            at = item(WAYPOINT, frame=frame, x=latitude + 2000, y=longitude)
            self.answers[f"item frame {frame}"] = self.upload(at)
        for param in range(1, 8):
            for value in (1.0, -1.0, math.nan):
                if param > 4 and math.isnan(value):
                    continue
                for command in PROBED_ITEMS:
                    probe = item(command, x=latitude + 2000, y=longitude)
                    probe[["p1", "p2", "p3", "p4", "x", "y", "z"][param - 1]] = int(value) if param in (5, 6) else value
                    self.answers[f"item {command} p{param}={value}"] = self.upload(probe)
        self.link.mav.mission_clear_all_send(self.system, 1, 0)
        self.wait(["MISSION_ACK"], 2.0)

    def upload(self, only):
        """Uploads a mission of one item, behind home where home is part of it."""
        return self.upload_all([only] if self.autopilot == PX4 else [item(WAYPOINT, frame=0, z=50.0), only])

    def upload_all(self, items, plan=0):
        """Uploads a plan of a MAV_MISSION_TYPE, and gives the name of its acknowledgement; none for silence."""
        self.forget()
        self.link.mav.mission_count_send(self.system, 1, len(items), plan)
        while True:
            said = self.wait(["MISSION_REQUEST_INT", "MISSION_REQUEST", "MISSION_ACK"], 4.0)
            if said is None or said.get_type() == "MISSION_ACK":
                return None if said is None else name("MAV_MISSION_RESULT", said.type)
            at = items[said.seq]
            self.link.mav.mission_item_int_send(
                self.system, 1, said.seq, at["frame"], at["command"], 0, 1,
                at["p1"], at["p2"], at["p3"], at["p4"], at["x"], at["y"], at["z"], plan,
            )  # fmt: skip

    def wait(self, types, patience_s, fits=lambda message: True):
        end = time.monotonic() + patience_s
        while time.monotonic() < end:
            self.keep_alive()
            message = self.link.recv_match(type=types, blocking=True, timeout=0.1)
            if message is not None and self.system in (None, message.get_srcSystem()) and fits(message):
                return message
        return None

    def forget(self):
        while self.link.recv_msg() is not None:
            pass

    def keep_alive(self):
        if time.monotonic() >= self.beat_due:
            self.link.mav.heartbeat_send(mavlink.MAV_TYPE_GCS, mavlink.MAV_AUTOPILOT_INVALID, 0, 0, 0)
            self.beat_due = time.monotonic() + SILENCE_S


def item(command, frame=3, x=0, y=0, z=50.0):
    return {"command": command, "frame": frame, "p1": 0, "p2": 0, "p3": 0, "p4": 0, "x": x, "y": y, "z": z}


def name(enum, number):
    """The enumeration's own word without its prefix; the number where it has none."""
    known = mavlink.enums[enum].get(number)
    return known.name.split("_", 2)[-1] if known else str(number)


if __name__ == "__main__":
    link = mavutil.mavlink_connection(sys.argv[1], source_system=255, source_component=190)
    found = play(link, in_air=sys.argv[3:] == ["air"])
    text = json.dumps(found, indent=0)
    if len(sys.argv) > 2:
        with open(sys.argv[2], "w") as file:
            file.write(text + "\n")
    else:
        print(text)
