"""Plans of a PX4: how it transfers them, one at a time, item after item, and which missions it takes and does not
fly."""

import pytest
from ground import ACCEPTED, DENIED
from plans import FENCE, MISSION, item
from pymavlink.dialects.v20 import ardupilotmega as mavlink

AUTO_MISSION = 4 << 16 | 4 << 24
ERROR, CANCELLED = mavlink.MAV_MISSION_ERROR, mavlink.MAV_MISSION_OPERATION_CANCELLED
REPLIES = ["MISSION_REQUEST_INT", "MISSION_REQUEST", "MISSION_ACK", "MISSION_COUNT", "MISSION_ITEM_INT", "MISSION_ITEM"]
POINTS = [item(16, 200 * n, 0) for n in range(3)]
START = mavlink.MAV_CMD_MISSION_START


class Planner:
    """Sends the messages of the protocol one by one, whether they make sense or not."""

    def __init__(self, craft, plan=MISSION):
        self.craft, self.plan, self.mav = craft, plan, craft.link.mav

    def count(self, count):
        self.mav.mission_count_send(self.craft.system, 1, count, self.plan)

    def item(self, seq, fields, current=0):
        frame, command, p1, p2, p3, x, y, z = fields
        self.mav.mission_item_int_send(
            self.craft.system, 1, seq, frame, command, current, 1, p1, p2, p3, 0, x, y, z, self.plan
        )

    def request_list(self):
        self.mav.mission_request_list_send(self.craft.system, 1, self.plan)

    def request(self, seq):
        self.mav.mission_request_int_send(self.craft.system, 1, seq, self.plan)

    def ack(self, result=mavlink.MAV_MISSION_ACCEPTED):
        self.mav.mission_ack_send(self.craft.system, 1, result, self.plan)

    def hears(self):
        """The next message of the protocol."""
        return self.craft.wait(REPLIES)

    def hears_nothing(self):
        """Nothing but what it had asked for and asks for again."""
        asks = ("MISSION_REQUEST_INT", "MISSION_COUNT")
        return not [said for said in self.craft.collect(REPLIES, 1) if said.get_type() not in asks]

    def upload(self, items, current=None):
        self.count(len(items))
        while (said := self.hears()).get_type() != "MISSION_ACK":
            self.item(said.seq, items[said.seq], current=int(said.seq == current))
        return said.type


@pytest.fixture
def start(start_vehicles):
    def begin(*options):
        return start_vehicles("--count", 1, "--personality", "px4", "--on-ground", *options).connect()[0]

    return begin


@pytest.fixture
def planner(start):
    return Planner(start())


# Transfers


def test_items_that_nobody_has_listed_are_not_told(planner):
    assert planner.upload(POINTS) == ACCEPTED
    planner.request(0)
    assert planner.hears_nothing()
    planner.request_list()
    assert planner.hears().count == 3
    planner.request(0)
    assert planner.hears().seq == 0
    # The same again, and no other than the next.
    planner.request(0)
    assert planner.hears().seq == 0
    planner.request(2)
    assert planner.hears().type == ERROR
    planner.request(1)
    assert planner.hears_nothing()


def test_one_transfer_goes_on_at_a_time(planner):
    planner.count(3)
    assert planner.hears().seq == 0
    planner.item(0, POINTS[0])
    planner.craft.wait(["MISSION_REQUEST_INT"], lambda asked: asked.seq == 1)
    planner.count(2)
    assert planner.craft.wait(["MISSION_ACK"]).type == ERROR
    assert planner.craft.text().text == "WPM: REJ. CMD: Busy"
    # Another item than the one that was asked for is passed over, and the upload goes on.
    planner.item(2, POINTS[2])
    planner.item(1, POINTS[1])
    planner.craft.wait(["MISSION_REQUEST_INT"], lambda asked: asked.seq == 2)
    planner.item(2, POINTS[2])
    assert planner.craft.wait(["MISSION_ACK"]).type == ACCEPTED
    # The last item again: the acknowledgement was lost.
    planner.item(2, POINTS[2])
    assert planner.craft.wait(["MISSION_ACK"]).type == ACCEPTED
    planner.item(0, POINTS[0])
    assert planner.craft.wait(["MISSION_ACK"]).type == ERROR


def test_a_download_blocks_an_upload_until_it_is_acknowledged(planner):
    assert planner.upload(POINTS[:1]) == ACCEPTED
    planner.request_list()
    assert planner.hears().count == 1
    planner.count(2)
    assert planner.craft.wait(["MISSION_ACK"]).type == ERROR
    planner.ack()
    assert planner.upload(POINTS) == ACCEPTED


def test_only_a_cancellation_breaks_an_upload_off(planner):
    planner.count(3)
    assert planner.hears().seq == 0
    planner.ack(ERROR)
    planner.item(0, POINTS[0])
    planner.craft.wait(["MISSION_REQUEST_INT"], lambda asked: asked.seq == 1)
    planner.ack(CANCELLED)
    assert planner.upload(POINTS[:1]) == ACCEPTED


def test_a_silent_writer_is_given_up(planner):
    planner.count(3)
    assert planner.hears().seq == 0
    while planner.craft.text().text != "Mission sync timeout":
        pass
    assert planner.upload(POINTS) == ACCEPTED


def test_what_a_px4_does_not_know_is_silence(planner):
    planner.mav.mission_write_partial_list_send(planner.craft.system, 1, 0, 0, MISSION)
    assert planner.hears_nothing()
    planner.item(0, POINTS[0], current=2)
    assert planner.hears_nothing()


def test_a_mission_begins_with_the_item_that_came_as_the_current_one(planner):
    def current():
        return planner.craft.wait(["MISSION_CURRENT"]).seq

    assert planner.upload(POINTS, current=1) == ACCEPTED
    planner.craft.wait(["MISSION_CURRENT"], lambda told: told.seq == 1)
    # Without one it stays where it was.
    assert planner.upload([*POINTS, item(16, 900, 0)]) == ACCEPTED
    assert [current() for _ in range(3)] == [1, 1, 1]
    assert planner.upload([item(16, 800, 0)]) == ACCEPTED
    planner.craft.wait(["MISSION_CURRENT"], lambda told: told.seq == 0)


# Which missions are flown


TAKEOFF = item(22, 100, 0)
WAY, HIGH, LANDING = item(16, 600, 0, 30), item(16, 600, 0, 90), item(21, 1000, 0, 0)


@pytest.mark.parametrize(
    ("requirement", "items", "text"),
    [
        (0, [TAKEOFF, WAY, LANDING], None),
        (0, [WAY], None),
        (
            0,
            [TAKEOFF, HIGH, LANDING],
            "Mission rejected: the landing glide slope is steeper than the vehicle setting of 5.0 degrees.",
        ),
        (0, [WAY, TAKEOFF], "Mission rejected: takeoff not first waypoint item"),
        (1, [WAY], "Mission rejected: Takeoff waypoint required."),
        (2, [TAKEOFF, WAY], "Mission rejected: Landing waypoint/pattern required."),
        (4, [TAKEOFF, WAY], "Mission rejected: Add Landing item or remove Takeoff."),
    ],
)  # fmt: skip
def test_a_mission_is_taken_and_judged(start, requirement, items, text):
    craft = start("--param", f"MIS_TKO_LAND_REQ={requirement}")
    assert Planner(craft).upload(items) == ACCEPTED
    if text is None:
        assert craft.command_long(START) == ACCEPTED
        return
    assert craft.text().text == text
    assert craft.command_long(START) == DENIED
    # Disarmed every mode is taken; it does not arm in it.
    craft.command_long(mavlink.MAV_CMD_DO_SET_MODE, 1, 4, 4)
    craft.wait(["HEARTBEAT"], lambda beat: beat.custom_mode == AUTO_MISSION)
    assert craft.command_long(mavlink.MAV_CMD_COMPONENT_ARM_DISARM, 1) == mavlink.MAV_RESULT_TEMPORARILY_REJECTED


def test_a_fence_forbids_a_mission_that_leaves_it(start):
    craft = start()
    assert Planner(craft).upload([WAY]) == ACCEPTED
    circle = (mavlink.MAV_FRAME_GLOBAL_INT, 5003, 300, 0, 0, *item(16)[5:7], 0)
    assert Planner(craft, FENCE).upload([circle]) == ACCEPTED
    assert craft.text().text == "Geofence violation for waypoint 1"
    assert craft.command_long(START) == DENIED
