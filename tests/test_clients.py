"""Many clients at once: fifty, each with a vehicle of its own, and several ground stations on one vehicle."""

import threading
import time

import pytest
from ground import Craft, connection
from lists import Lists
from pymavlink.dialects.v20 import ardupilotmega as mavlink

CLIENTS = 50
PEERS_MAX = 64
# What is not answered by then is said again.
AGAIN_S = 0.25


def plan(craft, seq):
    """Item `seq` of a mission that is this vehicle's only."""
    return mavlink.MAVLink_mission_item_int_message(
        craft.system, craft.component, seq, mavlink.MAV_FRAME_GLOBAL_RELATIVE_ALT_INT, mavlink.MAV_CMD_NAV_WAYPOINT,
        0, 1, 0, 20, 0, 0, 399_800_000 + 1_000 * seq, 1_163_400_000 + 1_000 * craft.system, 60,
    )  # fmt: skip


def insist(craft, say, kinds, where=lambda message: True):
    """Says something until it is answered: either may be lost."""
    for _ in range(200):
        say()
        until = time.monotonic() + AGAIN_S
        while (left := until - time.monotonic()) > 0:
            message = craft.link.recv_match(type=kinds, blocking=True, timeout=left)
            if message is not None and where(message):
                return message
    raise TimeoutError(f"no {kinds} from vehicle {craft.system}")


def upload(craft, count):
    mav, target = craft.link.mav, (craft.system, craft.component)
    asked = ["MISSION_REQUEST", "MISSION_REQUEST_INT", "MISSION_ACK"]
    answer = insist(craft, lambda: mav.mission_count_send(*target, count), asked)
    while answer.get_type() != "MISSION_ACK":
        seq = answer.seq
        answer = insist(
            craft, lambda: mav.send(plan(craft, seq)), asked, lambda answer: getattr(answer, "seq", -1) != seq
        )
    return answer.type


def download(craft):
    mav, target = craft.link.mav, (craft.system, craft.component)
    count = insist(craft, lambda: mav.mission_request_list_send(*target), ["MISSION_COUNT"]).count
    items = [
        insist(
            craft,
            lambda: mav.mission_request_int_send(*target, seq),
            ["MISSION_ITEM_INT"],
            lambda item: item.seq == seq,
        )
        for seq in range(count)
    ]
    mav.mission_ack_send(*target, mavlink.MAV_MISSION_ACCEPTED)
    return items


def work(row, results):
    """What one client does: all parameters, a mission up and down, and telemetry of its own vehicle meanwhile."""
    craft = Craft(row)
    try:
        lists = Lists(craft.link, [craft.system])
        lists.fetch()
        uploaded = upload(craft, 10)
        items = download(craft)
        position = craft.wait(["LOCAL_POSITION_NED"])
        results[row["vehicle"]] = {
            "parameters": {value.param_id: value.param_value for value in lists.found[craft.system].values()},
            "uploaded": uploaded,
            "places": [(item.x, item.y) for item in items[1:]],
            "heard": position.get_srcSystem(),
        }
    finally:
        craft.close()


@pytest.mark.parametrize(("grouped", "loss"), [(1, 0), (10, 0), (1, 0.3)])
def test_fifty_clients_at_once(start_vehicles, grouped, loss):
    # Whoever greets a group hears all of it, and fifty clients in one Python cannot read so much.
    slow = [] if grouped == 1 else [f"--param={name}=1" for name in ("MAV1_POSITION", "MAV1_EXTRA1", "MAV1_EXTRA2")]
    rows = start_vehicles("--count", CLIENTS, "--per-port", grouped, "--loss", loss, *slow).rows
    results = {}
    clients = [threading.Thread(target=work, args=(row, results)) for row in rows]
    for client in clients:
        client.start()
    for client in clients:
        client.join()
    assert sorted(results) == [row["vehicle"] for row in rows]
    for row in rows:
        result, system = results[row["vehicle"]], row["system_id"]
        assert result["parameters"]["MAV_SYSID"] == system
        assert len(result["parameters"]) == len(results[1]["parameters"])
        assert result["uploaded"] == mavlink.MAV_MISSION_ACCEPTED
        east = 1_163_400_000 + 1_000 * system
        assert result["places"] == [(399_800_000 + 1_000 * seq, east) for seq in range(1, 10)]
        assert grouped > 1 or result["heard"] == system


def test_each_ground_station_has_rates_and_replies_of_its_own(start_vehicles, scenario):
    row = start_vehicles(scenario(), "--speed", 5).rows[0]
    one, other = Craft(row), Craft(row)
    assert one.set_rate(mavlink.MAVLINK_MSG_ID_ATTITUDE, 20) == mavlink.MAV_RESULT_ACCEPTED
    assert other.set_rate(mavlink.MAVLINK_MSG_ID_ATTITUDE, 2) == mavlink.MAV_RESULT_ACCEPTED
    intervals = []
    for craft in (one, other):
        craft.collect([], 0.5)
        stamps = [message.time_boot_ms for message in craft.collect(["ATTITUDE"], 3)]
        intervals.append({after - before for before, after in zip(stamps, stamps[1:])})
    assert intervals == [{50}, {500}]
    # An answer goes to who has asked: the other hears the end of its own question before anything of this one.
    one.command_long(mavlink.MAV_CMD_REQUEST_MESSAGE, mavlink.MAVLINK_MSG_ID_AUTOPILOT_VERSION)
    other.link.mav.ping_send(0, 7, 0, 0)
    heard = other.wait(["PING", "AUTOPILOT_VERSION", "COMMAND_ACK"])
    assert (heard.get_type(), heard.seq) == ("PING", 7)
    for craft in (one, other):
        craft.close()


def test_the_65th_peer_displaces_the_most_silent(start_vehicles, scenario):
    # The ground station that is told unasked is a peer too, and stays.
    vehicles = start_vehicles(scenario())
    peers = [Craft(vehicles.rows[0]) for _ in range(PEERS_MAX - 1)]
    for craft in peers[1:]:
        craft.heartbeat()
        craft.link.mav.ping_send(0, 1, 0, 0)
        craft.wait(["PING"])
    newest = Craft(vehicles.rows[0])
    newest.collect([], 1)
    drain(peers[0])
    newest.collect([], 1)
    assert peers[0].link.recv_match(blocking=False) is None
    assert peers[1].link.recv_match(type="LOCAL_POSITION_NED", blocking=True, timeout=5)
    for craft in [*peers, newest]:
        craft.close()


def drain(craft):
    while craft.link.recv_match(blocking=False) is not None:
        pass


def test_who_has_spoken_to_one_of_a_group_hears_that_one(start_vehicles):
    rows = start_vehicles("--count", 2, "--per-port", 2).rows
    link = connection(rows[0]["address"])
    link.mav.param_request_read_send(2, 1, b"MAV_SYSID", -1)
    systems = set()
    for _ in range(50):
        message = link.recv_match(blocking=True, timeout=10)
        systems.add(message.get_srcSystem())
    assert systems == {2}
    link.close()
