"""A talk with any ArduPlane, real or ours, step by step: what a stranger says, and what is answered.

Of each step stay the answers that matter, in their order and without times. `scenes.py` has what is said; nothing in
either knows who answers. `test_differential.py` compares.
"""

import math
import time
from contextlib import contextmanager

from pymavlink import mavutil
from pymavlink.dialects.v20 import ardupilotmega as mavlink

# How long nothing at all may come from the vehicle, in real time.
SILENCE_S = 30.0
METRES_PER_DEGREE = 111_319.5
RELATIVE = mavlink.MAV_FRAME_GLOBAL_RELATIVE_ALT
MISSION, FENCE, RALLY = mavlink.MAV_MISSION_TYPE_MISSION, mavlink.MAV_MISSION_TYPE_FENCE, mavlink.MAV_MISSION_TYPE_RALLY
TAKEOFF, LOITER = 13, 12
PLANS = {MISSION: "mission", FENCE: "fence", RALLY: "rally"}
ARMED = mavlink.MAV_MODE_FLAG_SAFETY_ARMED


def name_of(enum, value):
    """The enumeration's own word without its first part: MAV_RESULT_DENIED is DENIED; else the number."""
    entry = mavlink.enums[enum].get(value)
    prefix = {"MAV_CMD": "MAV_CMD_", "MAV_RESULT": "MAV_RESULT_", "MAV_MISSION_RESULT": "MAV_MISSION_"}.get(
        enum, enum + "_"
    )
    return entry.name.removeprefix(prefix) if entry and entry.name != f"{enum}_ENUM_END" else str(value)


class Conversation:
    """One ground station's talk with one vehicle. Its clock is the vehicle's heartbeat, one a second."""

    def __init__(self, link, system=1, component=1):
        self.link, self.system, self.component = link, system, component
        self.mav = link.mav
        self.steps = {}
        self.beats = 0
        self.silent = False
        self.last_mode = self.last_armed = self.last_current = None
        self.newest, self.values = {}, {}
        self.forget()
        self.items, self.kind = [], MISSION

    # What is said.

    def long(self, command, *params, system=None, component=None):
        params = [*params, *[0] * (7 - len(params))]
        self.mav.command_long_send(
            self.to(system), self.component if component is None else component, command, 0, *params
        )

    def int(self, command, p1=0, p2=0, p3=0, p4=0, x=0, y=0, z=0, frame=RELATIVE, system=None, component=None):
        component = self.component if component is None else component
        self.mav.command_int_send(self.to(system), component, frame, command, 0, 0, p1, p2, p3, p4, x, y, z)

    def to(self, system):
        return self.system if system is None else system

    def mode(self, number):
        self.long(mavlink.MAV_CMD_DO_SET_MODE, 1, number)

    def arm(self, yes=True, force=0):
        self.long(mavlink.MAV_CMD_COMPONENT_ARM_DISARM, 1 if yes else 0, force)

    def read(self, name):
        self.asked.add(name)
        self.mav.param_request_read_send(self.system, self.component, name.encode(), -1)

    def set(self, name, value, kind=mavlink.MAV_PARAM_TYPE_REAL32):
        self.asked.add(name)
        self.mav.param_set_send(self.system, self.component, name.encode(), value, kind)

    def request(self, message, *params):
        self.long(mavlink.MAV_CMD_REQUEST_MESSAGE, message, *params)

    def upload(self, items, kind=MISSION, count=None):
        """Says how many items there are; those that are asked for from then on are sent."""
        self.items, self.kind = items, kind
        self.mav.mission_count_send(self.system, self.component, len(items) if count is None else count, kind)

    def send_item(self, seq, item, kind=MISSION, system=None):
        frame, command, params, (x, y), z = item
        self.mav.mission_item_int_send(
            self.to(system), self.component, seq, frame, command, 0, 1, *params, x, y, z, kind
        )  # fmt: skip

    def place(self, north_m, east_m):
        """So far from home, as a message has it."""
        lat, lon = self.home
        return (
            round((lat + north_m / METRES_PER_DEGREE) * 1e7),
            round((lon + east_m / METRES_PER_DEGREE / math.cos(math.radians(lat))) * 1e7),
        )

    def item(self, command, north_m=0, east_m=0, z=60, p1=0, p2=0, p3=0, p4=0, frame=RELATIVE):
        return frame, command, (p1, p2, p3, p4), self.place(north_m, east_m), z

    def newest_value(self, name):
        """What a parameter was said to be last."""
        return self.values[name]

    # What is heard.

    @contextmanager
    def step(self, name, until=None, beats=120, also=()):
        """What is sent inside is one step. It ends after a question of ours has been answered, with the next
        heartbeats.

        With `until` it ends when that holds, and after `beats` heartbeats at the latest. Of the messages of the kinds
        in `also` it counts whether they come.
        """
        assert name not in self.steps, name
        self.forget()
        self.also = also
        yield
        self.settle()
        if until is not None:
            self.wait_for(until, beats)
        record = {
            "answers": self.answers,
            "comes": sorted(self.came),
            "states": self.states,
            "progress": self.progress,
            "warned": self.warned,
        }
        self.steps[name] = {key: value for key, value in record.items() if value}
        self.forget()

    def forget(self):
        self.answers, self.came, self.states, self.progress, self.warned = [], set(), [], [], False
        self.asked, self.also = set(), ()

    def settle(self):
        """Until what was sent before has been answered, and the heartbeat has shown what came of it."""
        stamp = self.beats + 1
        answered = False
        self.mav.timesync_send(0, stamp)
        start = self.beats
        while not answered and self.beats < start + 10:
            message = self.hear()
            answered = message.get_type() == "TIMESYNC" and message.ts1 == stamp
        self.rest(2)

    def rest(self, beats):
        end = self.beats + beats
        while self.beats < end:
            self.hear()

    def wait_for(self, holds, beats):
        """Whether it came to hold within so many heartbeats."""
        end = self.beats + beats
        while not holds():
            if self.beats >= end:
                self.answers.append("what was waited for did not come")
                return False
            self.hear()
        return True

    def hear(self):
        """The next message, taken down."""
        deadline = time.monotonic() + SILENCE_S
        while time.monotonic() < deadline:
            message = self.link.recv_match(blocking=True, timeout=1)
            if message is None or message.get_type() == "BAD_DATA" or message.get_srcSystem() != self.system:
                continue
            if message.get_srcComponent() != self.component:
                continue
            self.take_down(message)
            return message
        raise TimeoutError(f"the vehicle has said nothing for {SILENCE_S:.0f} s")

    def take_down(self, message):
        kind = message.get_type()
        self.newest[kind] = message
        listener = getattr(self, f"on_{kind.lower()}", None)
        if listener is not None:
            listener(message)
        elif kind in self.also:
            self.came.add(kind)

    def on_heartbeat(self, beat):
        self.beats += 1
        if not self.silent:
            self.mav.heartbeat_send(mavlink.MAV_TYPE_GCS, mavlink.MAV_AUTOPILOT_INVALID, 0, 0, 0)
        mode, armed = beat.custom_mode, bool(beat.base_mode & ARMED)
        if mode != self.last_mode:
            self.states.append(mavutil.mode_mapping_apm.get(mode, f"mode {mode}"))
        if armed != self.last_armed:
            self.states.append("armed" if armed else "disarmed")
        self.last_mode, self.last_armed = mode, armed

    def on_command_ack(self, ack):
        self.answers.append(f"{name_of('MAV_CMD', ack.command)} {name_of('MAV_RESULT', ack.result)}")

    def on_mission_ack(self, ack):
        self.answers.append(
            f"{PLANS.get(ack.mission_type, ack.mission_type)} {name_of('MAV_MISSION_RESULT', ack.type)}"
        )

    def on_mission_count(self, count):
        self.answers.append(f"{PLANS[count.mission_type]} count {count.count}")

    def on_mission_request(self, request):
        word = f"{PLANS[request.mission_type]} wants {request.seq}"
        if word not in self.answers[-1:]:
            self.answers.append(word)
        if request.seq < len(self.items):
            self.send_item(request.seq, self.items[request.seq], self.kind)

    on_mission_request_int = on_mission_request

    def on_mission_item_int(self, item):
        params = " ".join(f"{param:g}" for param in (item.param1, item.param2, item.param3, item.param4))
        lat, lon = self.home
        north_m = (item.x / 1e7 - lat) * METRES_PER_DEGREE
        east_m = (item.y / 1e7 - lon) * METRES_PER_DEGREE * math.cos(math.radians(lat))
        where = f"{round(north_m)} {round(east_m)}" if item.x or item.y else "nowhere"
        body = f"{name_of('MAV_CMD', item.command)} frame {item.frame}, {params}, {where}, {round(item.z)}"
        if item.seq == 0 and item.mission_type == MISSION:
            body = "home"
        self.answers.append(f"{PLANS[item.mission_type]} {item.seq}: {body}")

    def on_fence_point(self, point):
        self.answers.append(f"fence point {point.idx} of {point.count}: {self.near(point.lat, point.lng)}")

    def on_rally_point(self, point):
        where = self.near(point.lat / 1e7, point.lng / 1e7)
        rest = f"{point.alt} {point.break_alt} {point.land_dir} {point.flags}"
        self.answers.append(f"rally point {point.idx} of {point.count}: {where}, {rest}")

    def near(self, lat, lon):
        """How far from home, in tens of metres: single precision tells places apart by a few."""
        if not lat and not lon:
            return "nowhere"
        north_m = (lat - self.home[0]) * METRES_PER_DEGREE
        east_m = (lon - self.home[1]) * METRES_PER_DEGREE * math.cos(math.radians(self.home[0]))
        return f"{round(north_m / 10)} {round(east_m / 10)}"

    def on_mission_current(self, current):
        if current.seq != self.last_current:
            self.progress.append(f"current {current.seq}")
        self.last_current = current.seq

    def on_mission_item_reached(self, reached):
        word = f"reached {reached.seq}"
        # Item 0 is home, which no mission flies to: ArduPlane says so of the point of GUIDED.
        if reached.seq and word not in self.progress[-1:]:
            self.progress.append(word)

    def on_param_value(self, value):
        self.values[value.param_id] = value.param_value
        # An autopilot may tell of others that it has changed by itself.
        if value.param_id in self.asked:
            kind = name_of("MAV_PARAM_TYPE", value.param_type)
            self.answers.append(f"{value.param_id} {kind} {value.param_value:g}")

    def on_param_error(self, error):
        self.answers.append(f"{error.param_id} {name_of('MAV_PARAM_ERROR', error.error)}")

    def on_statustext(self, text):
        self.warned |= text.severity <= mavlink.MAV_SEVERITY_WARNING

    def on_message_interval(self, interval):
        self.answers.append(f"message {interval.message_id} every {interval.interval_us} us")

    # What stands before a scene.

    def ready(self):
        """Until the vehicle says that it can be armed, and where it is."""

        def can_be_armed():
            status = self.newest.get("SYS_STATUS")
            return status and status.onboard_control_sensors_health & mavlink.MAV_SYS_STATUS_PREARM_CHECK

        def knows_where():
            position = self.newest.get("GLOBAL_POSITION_INT")
            return position and position.lat

        self.hear()
        assert self.wait_for(lambda: can_be_armed() and knows_where(), 90), "it does not get ready"
        position = self.newest["GLOBAL_POSITION_INT"]
        self.home = position.lat / 1e7, position.lon / 1e7
        self.rest(2)
        self.answers.clear()

    def take_off(self):
        """Into the air by the mode of that name, and into LOITER, with no note of it."""
        self.mode(TAKEOFF)
        self.settle()
        self.arm()
        assert self.wait_for(lambda: self.height() > 40, 120), "it does not take off"
        self.mode(LOITER)
        self.settle()

    def height(self):
        return self.newest["GLOBAL_POSITION_INT"].relative_alt / 1e3

    def in_mode(self, number):
        return lambda: self.last_mode == number

    def disarmed(self):
        return self.last_armed is False


SCENES = {}


def scene(act):
    """Registers a scene by its name."""
    SCENES[act.__name__.replace("_", " ")] = act
    return act


def play(name, link):
    """Plays one scene with a vehicle that has just started, and gives what was answered, step by step."""
    talk = Conversation(link)
    talk.ready()
    SCENES[name](talk)
    return talk.steps
