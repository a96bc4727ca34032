"""A ground station of a few lines: what anybody's script does with pymavlink."""

import collections
import math
import time
from dataclasses import dataclass

from pymavlink.dialects.v20 import ardupilotmega as mavlink
from pytest_columba import connection

ACCEPTED = mavlink.MAV_RESULT_ACCEPTED
DENIED = mavlink.MAV_RESULT_DENIED
FAILED = mavlink.MAV_RESULT_FAILED
UNSUPPORTED = mavlink.MAV_RESULT_UNSUPPORTED

MANUAL, CRUISE, RTL, LOITER, GUIDED = 0, 7, 11, 12, 15

# SET_POSITION_TARGET_LOCAL_NED: vx, vy and z count, all else is ignored.
VELOCITY_AND_ALTITUDE = 0x0DE3

PATIENCE_S = 10.0
TEXT_MAX = 50


@dataclass(frozen=True)
class Sample:
    """One LOCAL_POSITION_NED, in the words of the paper."""

    t_s: float
    x_m: float
    y_m: float
    altitude_m: float
    speed_mps: float
    course_rad: float
    climb_mps: float

    @classmethod
    def of(cls, message):
        return cls(
            t_s=message.time_boot_ms / 1e3,
            x_m=message.x,
            y_m=message.y,
            altitude_m=-message.z,
            speed_mps=math.hypot(message.vx, message.vy),
            course_rad=math.atan2(message.vy, message.vx),
            climb_mps=-message.vz,
        )


class Craft:
    """A connection to one vehicle at its own port."""

    def __init__(self, row):
        self.system = row["system_id"]
        self.component = row["component_id"]
        self.port = row["port"]
        self.texts = collections.deque()
        self.link = connection(row["address"])
        self.greet()

    def greet(self):
        """A vehicle tells a new peer at once who and where it is, beside what is due. The greeting may be lost."""
        for last in [False] * 9 + [True]:
            self.heartbeat()
            try:
                self.wait(["HEARTBEAT"], self.is_ours, patience_s=1)
                self.wait(["LOCAL_POSITION_NED"], self.is_ours, patience_s=1)
                return
            except TimeoutError:
                if last:
                    raise

    def is_ours(self, message):
        """Others may stand behind the same port."""
        return message.get_srcSystem() == self.system

    def close(self):
        self.link.close()

    def heartbeat(self):
        self.link.mav.heartbeat_send(mavlink.MAV_TYPE_GCS, mavlink.MAV_AUTOPILOT_INVALID, 0, 0, 0)

    def wait(self, kinds, where=lambda message: True, patience_s=PATIENCE_S):
        """The next message of a kind, or of several, for which `where` holds. Words on the way are kept for `text`."""
        deadline = time.monotonic() + patience_s
        while (left := deadline - time.monotonic()) > 0:
            message = self.link.recv_match(blocking=True, timeout=left)
            if message is None:
                continue
            if message.get_type() == "STATUSTEXT":
                self.texts.append(message)
            if message.get_type() in kinds and where(message):
                return message
        raise TimeoutError(f"no {kinds} from vehicle {self.system} within {patience_s} s")

    def text(self):
        """The next STATUSTEXT that nobody has read: a refusal's reason comes before its acknowledgement."""
        text = self._next_text()
        # One that is longer than a message comes in chunks, of which the last is not full.
        chunk = text
        while chunk.id and len(chunk.text) == TEXT_MAX:
            chunk = self._next_text()
            text.text += chunk.text
        return text

    def _next_text(self):
        if not self.texts:
            self.wait(["STATUSTEXT"])
        return self.texts.popleft()

    def collect(self, kinds, seconds):
        """All messages of some kinds, in order, over so many seconds of the vehicle's own time."""
        messages, end_ms = [], None
        while True:
            message = self.wait([*kinds, "LOCAL_POSITION_NED"])
            if message.get_type() == "LOCAL_POSITION_NED":
                end_ms = end_ms or message.time_boot_ms + 1000 * seconds
                if message.time_boot_ms > end_ms:
                    return messages
            if message.get_type() in kinds:
                messages.append(message)

    def sample(self):
        return Sample.of(self.wait(["LOCAL_POSITION_NED"]))

    def samples(self, seconds):
        return [Sample.of(message) for message in self.collect(["LOCAL_POSITION_NED"], seconds)]

    def mode(self):
        """The mode in the next heartbeat that the vehicle sends after what it was told."""
        return self.wait(["HEARTBEAT"]).custom_mode

    def acknowledged(self, command):
        return self.wait(["COMMAND_ACK"], lambda ack: ack.command == command).result

    def command_int(self, command, p1=0.0, p2=0.0, p3=0.0, p4=0.0, z=0.0, frame=mavlink.MAV_FRAME_GLOBAL_RELATIVE_ALT):
        """Sends a COMMAND_INT and gives the result of its acknowledgement."""
        self.link.mav.command_int_send(self.system, self.component, frame, command, 0, 0, p1, p2, p3, p4, 0, 0, z)
        return self.acknowledged(command)

    def command_long(self, command, p1=0.0, p2=0.0, p3=0.0, p4=0.0, p7=0.0):
        """Sends a COMMAND_LONG and gives the result of its acknowledgement."""
        self.link.mav.command_long_send(self.system, self.component, command, 0, p1, p2, p3, p4, 0, 0, p7)
        return self.acknowledged(command)

    def request(self, message_id, kind):
        """Asks for one message; whether it or the acknowledgement comes first is left open."""
        self.link.mav.command_long_send(
            self.system, self.component, mavlink.MAV_CMD_REQUEST_MESSAGE, 0, message_id, 0, 0, 0, 0, 0, 0
        )
        return self.wait([kind])

    def set_parameter(self, name, value):
        """Writes a parameter, and waits until it has the value."""
        self.link.mav.param_set_send(self.system, self.component, name.encode(), value, mavlink.MAV_PARAM_TYPE_REAL32)
        return self.wait(
            ["PARAM_VALUE"], lambda answer: answer.param_id == name and abs(answer.param_value - value) < 1e-5
        )

    def set_mode(self, number):
        return self.command_long(mavlink.MAV_CMD_DO_SET_MODE, 1, number)

    def change_speed(self, speed_mps, acceleration_mps2=0.0):
        return self.command_int(mavlink.MAV_CMD_GUIDED_CHANGE_SPEED, 0, speed_mps, acceleration_mps2)

    def change_altitude(self, altitude_m, rate_mps=0.0):
        return self.command_int(mavlink.MAV_CMD_GUIDED_CHANGE_ALTITUDE, p3=rate_mps, z=altitude_m)

    def change_heading(self, course_deg, lateral_mps2=50.0):
        return self.command_int(mavlink.MAV_CMD_GUIDED_CHANGE_HEADING, 0, course_deg, lateral_mps2)

    def setpoint(self, speed_mps, course_rad, altitude_m):
        """SET_POSITION_TARGET_LOCAL_NED, which is not acknowledged."""
        vx, vy = speed_mps * math.cos(course_rad), speed_mps * math.sin(course_rad)
        self.link.mav.set_position_target_local_ned_send(
            0, self.system, self.component, mavlink.MAV_FRAME_LOCAL_NED, VELOCITY_AND_ALTITUDE,
            0, 0, -altitude_m, vx, vy, 0, 0, 0, 0, 0, 0,
        )  # fmt: skip

    def set_rate(self, message_id, hz):
        return self.command_long(mavlink.MAV_CMD_SET_MESSAGE_INTERVAL, message_id, 1e6 / hz)
