"""What a real PX4 answered when plans were transferred and judged, message by message, and what ours answers.

`reference/px4-plans.json` was recorded from a PX4 1.18 (SIH, a fixed wing on the ground, disarmed). A real one
answers some things again after 0.25 s: the request for an item and the count of a download are compared only where
they are new. `reference/px4-flight.json` is the same PX4 in the air."""

import json
import math
from pathlib import Path

import pytest
from ground import ACCEPTED
from plans import item
from pymavlink.dialects.v20 import ardupilotmega as mavlink

RECORDED = json.loads((Path(__file__).parent / "reference/px4-plans.json").read_text())
REPLIES = ["MISSION_REQUEST_INT", "MISSION_ACK", "MISSION_COUNT", "MISSION_ITEM_INT", "STATUSTEXT"]
MISSION, FENCE = mavlink.MAV_MISSION_TYPE_MISSION, mavlink.MAV_MISSION_TYPE_FENCE
AGAIN = ("REQUEST", "COUNT")


def way(north_m, altitude_m=50, command=16, p1=0):
    return item(command, north_m, 0, altitude_m, p1=p1)


POINTS = [way(200 * n) for n in range(3)]
TAKEOFF, LANDING = way(100, command=22), way(1000, 0, command=21)
# A mission, and MIS_TKO_LAND_REQ.
JUDGED = {
    "req 0 bad slope": ([TAKEOFF, way(600, 90), LANDING], 0),
    "not above": ([TAKEOFF, way(600, 0), LANDING], 0),
    "unsupported entrance": ([TAKEOFF, way(600, 30, 17), LANDING], 0),
    "takeoff late": ([way(0), TAKEOFF], 0),
    "5000": ([way(0), way(100, 0, 5000)], 0),
    "starts with landing": ([way(0, 0, 21), way(0)], 0),
    "takeoff low": ([way(100, 0, 22), way(300)], 0),
    "far": ([way(20_000)], 0),
    "req1": ([way(100)], 1),
    "req2": ([TAKEOFF, way(100)], 2),
    "req3": ([TAKEOFF, way(101)], 3),
    "req4": ([TAKEOFF, way(102)], 4),
    "req5": ([TAKEOFF, way(103)], 5),
    "vtol": ([way(100, command=84), way(103)], 0),
}


class Talk:
    def __init__(self, craft):
        self.craft, self.mav, self.stamp = craft, craft.link.mav, 0

    def count(self, count, plan=MISSION):
        self.mav.mission_count_send(self.craft.system, 1, count, plan)

    def item(self, seq, fields=POINTS[0], current=0, plan=MISSION):
        frame, command, p1, p2, p3, x, y, z = fields
        self.mav.mission_item_int_send(
            self.craft.system, 1, seq, frame, command, current, 1, p1, p2, p3, 0, x, y, z, plan
        )

    def list(self, plan=MISSION):
        self.mav.mission_request_list_send(self.craft.system, 1, plan)

    def request(self, seq):
        self.mav.mission_request_int_send(self.craft.system, 1, seq, MISSION)

    def ack(self, result=0, plan=MISSION):
        self.mav.mission_ack_send(self.craft.system, 1, result, plan)

    def clear(self, plan=MISSION):
        self.mav.mission_clear_all_send(self.craft.system, 1, plan)

    def choose(self, seq):
        self.mav.mission_set_current_send(self.craft.system, 1, seq)

    def answers(self):
        """All that comes before the answer to a TIMESYNC."""
        self.stamp += 1
        self.mav.timesync_send(0, self.stamp)
        said = []
        while True:
            message = self.craft.wait([*REPLIES, "TIMESYNC"])
            if message.get_type() == "TIMESYNC":
                if message.ts1 == self.stamp:
                    return said
            elif (line := told(message)) not in said:
                said.append(line)

    def upload(self, items, plan=MISSION, current=None):
        self.count(len(items), plan)
        while (said := self.craft.wait(REPLIES[:2])).get_type() != "MISSION_ACK":
            self.item(said.seq, items[said.seq], int(said.seq == current), plan)
        return said.type


def told(message):
    kind = message.get_type()
    if kind == "MISSION_ACK":
        return f"ACK {message.type} t{message.mission_type}"
    if kind == "MISSION_REQUEST_INT":
        return f"REQUEST_INT {message.seq}"
    if kind == "MISSION_COUNT":
        return f"COUNT {message.count} t{message.mission_type}"
    if kind == "MISSION_ITEM_INT":
        params = [
            round(value, 2) for value in (message.param1, message.param2, message.param3, message.param4, message.z)
        ]
        return f"ITEM_INT {message.seq} cmd {message.command} cur {message.current} frame {message.frame} {params}"
    return f"TEXT {message.text}"


@pytest.fixture
def talk(start_vehicles):
    vehicles = start_vehicles("--count", 1, "--personality", "px4", "--on-ground", "--param", "MIS_TKO_LAND_REQ=2")
    return Talk(vehicles.connect()[0])


def without_repeats(answers):
    return sorted(line for line in answers if not line.startswith(AGAIN))


def test_transfers_are_answered_as_by_a_real_px4(talk):
    said = {}

    def step(name, act):
        act()
        said[name] = talk.answers()

    step("ack from nobody", lambda: talk.ack())
    step("request without list", lambda: talk.request(0))
    step("item from nobody", lambda: talk.item(0))
    step("guided item", lambda: talk.item(0, current=2))
    step("partial", lambda: talk.mav.mission_write_partial_list_send(talk.craft.system, 1, 0, 0, MISSION))
    step("clear", lambda: talk.clear())
    assert talk.upload(POINTS) == ACCEPTED
    talk.answers()
    step("list", lambda: talk.list())
    step("0", lambda: talk.request(0))
    step("0 again", lambda: talk.request(0))
    step("2, out of order", lambda: talk.request(2))
    step("1 after the end", lambda: talk.request(1))
    step("list anew", lambda: talk.list())
    step("count while downloading", lambda: talk.count(2))
    step("clear while downloading", lambda: talk.clear())
    step("set current while downloading", lambda: talk.choose(1))
    step("ack", lambda: talk.ack())
    step("count", lambda: talk.count(3))
    step("item 0", lambda: talk.item(0))
    step("count while uploading", lambda: talk.count(2))
    step("item 2 early", lambda: talk.item(2))
    step("clear while uploading", lambda: talk.clear())
    step("ack ERROR", lambda: talk.ack(1))
    step("item 1", lambda: talk.item(1, POINTS[1]))
    step("item 2", lambda: talk.item(2, POINTS[2]))
    step("item 2 again", lambda: talk.item(2, POINTS[2]))
    step("item 0 late", lambda: talk.item(0))
    step("count again", lambda: talk.count(3))
    step("cancel", lambda: talk.ack(15))
    step("item after cancel", lambda: talk.item(0))
    step("count of type 9", lambda: talk.count(5, 9))
    step("count 0 of type 9", lambda: talk.count(0, 9))
    step("list of 255", lambda: talk.list(255))
    step("ack 255", lambda: talk.ack(0, 255))
    step("clear 255", lambda: talk.clear(255))
    step("set current 7 of none", lambda: talk.choose(7))
    real = RECORDED["transfers"]
    assert list(said) == list(real)
    assert {name: without_repeats(lines) for name, lines in said.items()} == {
        name: without_repeats(lines) for name, lines in real.items()
    }
    for name in ("list", "count", "item 0", "item 1", "count again", "list of 255"):
        assert set(real[name]) <= set(said[name]), name


def test_missions_are_judged_as_by_a_real_px4(talk):
    started = {}
    for name, (items, requirement) in JUDGED.items():
        # By its bytes: a whole number of a PX4.
        talk.mav.param_set_send(
            talk.craft.system, 1, b"MIS_TKO_LAND_REQ", requirement * 2**-149, mavlink.MAV_PARAM_TYPE_INT32
        )
        talk.craft.wait(["PARAM_VALUE"], lambda value: value.param_id == "MIS_TKO_LAND_REQ")
        assert talk.upload(items) == ACCEPTED
        started[name] = talk.craft.command_long(mavlink.MAV_CMD_MISSION_START)
        talk.craft.command_long(mavlink.MAV_CMD_COMPONENT_ARM_DISARM, 0, 21196)
    assert started == RECORDED["started"]


FLIGHT = json.loads((Path(__file__).parent / "reference/px4-flight.json").read_text())
# Command, params 1 and 2, metres north and east, height above home; param 4 of a loiter to an altitude is 1.
FLOWN = [
    (22, 0, 0, 300, 0, 60), (16, 0, 0, 900, 0, 60), (16, 0, 200, 900, 600, 60), (19, 5, 1, 300, 600, 60),
    (16, 0, 0, 300, -300, 80), (31, 1, 0, -300, -300, 60), (16, 0, 0, -300, 300, 60),
]  # fmt: skip


def test_a_mission_is_flown_and_told_as_by_a_real_px4(start_vehicles):
    """Which items, states, modes and texts come in which order, and how many seconds before a waypoint it is
    reached."""
    craft = start_vehicles("--count", 1, "--personality", "px4", "--on-ground", "--speed", 20).connect()[0]
    talk = Talk(craft)
    items = [item(command, north, east, height, p1=p1, p2=p2) for command, p1, p2, north, east, height in FLOWN]
    assert talk.upload(items, current=0) == ACCEPTED
    assert craft.command_long(mavlink.MAV_CMD_MISSION_START) == ACCEPTED
    told, place, seconds_before = [text.text for text in craft.texts], None, {}
    craft.texts.clear()
    kinds = ["STATUSTEXT", "MISSION_CURRENT", "MISSION_ITEM_REACHED", "GLOBAL_POSITION_INT", "HEARTBEAT"]
    while not told or not told[-1].startswith("MODE 4,3"):
        message = craft.wait(kinds)
        kind = message.get_type()
        if kind == "GLOBAL_POSITION_INT":
            place = message
            continue
        line = event(message)
        if kind == "MISSION_ITEM_REACHED" and line not in told and message.seq in (1, 2, 4):
            seconds_before[message.seq] = distance_m(place, items[message.seq]) / (math.hypot(place.vx, place.vy) / 100)
        if line not in told:
            told.append(line)
    assert sorted(told) == sorted(FLIGHT["events"])
    reached = [line for line in told if line.startswith(("REACHED", "CURRENT"))]
    assert reached == [line for line in FLIGHT["events"] if line.startswith(("REACHED", "CURRENT"))]
    for seq in (2, 4):
        assert seconds_before[seq] == pytest.approx(FLIGHT["seconds_before"][str(seq)], abs=0.3)


def event(message):
    kind = message.get_type()
    if kind == "STATUSTEXT":
        return message.text
    if kind == "HEARTBEAT":
        return f"MODE {message.custom_mode >> 16 & 255},{message.custom_mode >> 24} state {message.system_status}"
    if kind == "MISSION_ITEM_REACHED":
        return f"REACHED {message.seq}"
    return f"CURRENT {message.seq} of {message.total} state {message.mission_state} mode {message.mission_mode}"


def distance_m(place, fields):
    north_m = (fields[5] - place.lat) * 1e-7 * 111_200
    east_m = (fields[6] - place.lon) * 1e-7 * 111_200 * math.cos(math.radians(39.98))
    return math.hypot(north_m, east_m)
