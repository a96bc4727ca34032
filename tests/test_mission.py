"""Missions: uploaded and downloaded as a stranger does it, over a bad link too, refused, and flown to every item."""

import math

import pytest
from ground import ACCEPTED, GUIDED, RTL, connection
from plans import METRES_PER_DEGREE, Uploader, item, place
from pymavlink.dialects.v20 import ardupilotmega as mavlink

AUTO = 10
WAYPOINT, TURNS, SPEED, JUMP, TAKEOFF = (
    mavlink.MAV_CMD_NAV_WAYPOINT,
    mavlink.MAV_CMD_NAV_LOITER_TURNS,
    mavlink.MAV_CMD_DO_CHANGE_SPEED,
    mavlink.MAV_CMD_DO_JUMP,
    mavlink.MAV_CMD_NAV_TAKEOFF,
)
RADIUS_M = 8


TEN = [
    item(WAYPOINT),
    item(TAKEOFF, altitude_m=60),
    item(WAYPOINT, 150, 0, p2=RADIUS_M),
    item(SPEED, p2=12),
    item(WAYPOINT, 250, 120, 70, p2=RADIUS_M),
    item(WAYPOINT, 150, 220, 70, p2=RADIUS_M),
    item(TURNS, 0, 220, 70, p1=1, p3=40),
    item(WAYPOINT, -100, 150, 55, p2=RADIUS_M),
    item(WAYPOINT, -100, 0, 55, p2=RADIUS_M),
    item(WAYPOINT, 0, -80, 60, p2=RADIUS_M),
    item(mavlink.MAV_CMD_NAV_RETURN_TO_LAUNCH),
]


@pytest.fixture
def uploader(craft):
    return Uploader(craft.link, craft.system)


def test_what_is_uploaded_is_downloaded(uploader):
    assert uploader.upload(TEN) == mavlink.MAV_MISSION_ACCEPTED
    back = uploader.download()
    # The place of what has none is not kept.
    placeless = (SPEED, mavlink.MAV_CMD_NAV_RETURN_TO_LAUNCH)
    expected = [(i[1], *((0, 0, 0) if i[1] in placeless else i[5:8])) for i in TEN[1:]]
    assert [(item.command, item.x, item.y, item.z) for item in back[1:]] == expected


def test_ten_items_are_flown_and_reached_within_their_radius(start_vehicles, scenario):
    craft = start_vehicles(scenario(), "--speed", 20).connect()[0]
    assert Uploader(craft.link, craft.system).upload(TEN) == mavlink.MAV_MISSION_ACCEPTED
    assert craft.set_mode(AUTO) == ACCEPTED
    reached, nearest = [], {}
    while True:
        message = craft.wait(["MISSION_ITEM_REACHED", "LOCAL_POSITION_NED", "HEARTBEAT"])
        if message.get_type() == "MISSION_ITEM_REACHED":
            reached.append(message.seq)
        elif message.get_type() == "HEARTBEAT":
            if message.custom_mode == RTL:
                break
        else:
            for seq, (_, command, *_rest) in enumerate(TEN):
                if command == WAYPOINT:
                    north_m, east_m = (TEN[seq][5] - TEN[0][5]), (TEN[seq][6] - TEN[0][6])
                    away = math.hypot(
                        message.x - north_m * 1e-7 * METRES_PER_DEGREE,
                        message.y - east_m * 1e-7 * METRES_PER_DEGREE * math.cos(math.radians(39.98)),
                    )
                    nearest[seq] = min(away, nearest.get(seq, away))
    assert reached == list(range(1, 10))
    # Positions come every 0.1 s: the nearest of them may be 0.6 m off, and the vehicle turns away at the radius.
    assert all(nearest[seq] < RADIUS_M + 2 for seq in reached if seq in nearest), nearest


@pytest.mark.parametrize(
    ("bad", "code"),
    [
        (item(mavlink.MAV_CMD_NAV_SPLINE_WAYPOINT), mavlink.MAV_MISSION_UNSUPPORTED),
        (item(WAYPOINT, frame=mavlink.MAV_FRAME_LOCAL_NED), mavlink.MAV_MISSION_UNSUPPORTED_FRAME),
        (item(WAYPOINT, p1=math.nan), mavlink.MAV_MISSION_INVALID_PARAM1),
        (item(WAYPOINT, altitude_m=math.nan), mavlink.MAV_MISSION_INVALID_PARAM7),
        (item(59_999), mavlink.MAV_MISSION_UNSUPPORTED),
    ],
)
def test_a_bad_item_is_refused_and_the_old_mission_stays(uploader, bad, code):
    uploader.upload(TEN[:4])
    assert uploader.upload([*TEN[:2], bad, TEN[3]]) == code
    assert len(uploader.download()) == 4
    assert uploader.words[-1].startswith("Mission refused: ")


def test_a_gap_and_an_oversize_are_refused(craft, uploader):
    craft.link.mav.mission_count_send(craft.system, 1, 3)
    craft.wait(["MISSION_REQUEST"])
    uploader.send_item(2, TEN[2])
    assert craft.wait(["MISSION_ACK"]).type == mavlink.MAV_MISSION_INVALID_SEQUENCE
    # As in ArduPlane, the upload goes on with what was asked for.
    uploader.send_item(0, TEN[0])
    assert craft.wait(["MISSION_REQUEST"], lambda request: request.seq > 0).seq == 1
    craft.link.mav.mission_count_send(craft.system, 1, 1313)
    assert craft.wait(["MISSION_ACK"]).type == mavlink.MAV_MISSION_NO_SPACE


def test_without_a_mission_auto_returns(craft):
    """As ArduPlane does: accepted, and RTL."""
    for start in (lambda: craft.set_mode(AUTO), lambda: craft.command_long(mavlink.MAV_CMD_MISSION_START)):
        assert craft.set_mode(GUIDED) == ACCEPTED
        assert start() == ACCEPTED
        assert craft.text().text == "Mission complete, changing mode to RTL"
        assert craft.mode() == RTL


def test_the_old_messages_work_too(craft):
    """MISSION_ITEM and MISSION_REQUEST, floats throughout."""
    x, y = (degrees / 1e7 for degrees in place(50, 50))
    craft.link.mav.mission_count_send(craft.system, 1, 2)
    for _ in range(2):
        seq = craft.wait(["MISSION_REQUEST", "MISSION_REQUEST_INT"]).seq
        craft.link.mav.mission_item_send(
            craft.system, 1, seq, mavlink.MAV_FRAME_GLOBAL_RELATIVE_ALT, WAYPOINT, 0, 1, 0, 0, 0, 0, x, y, 60
        )
    assert craft.wait(["MISSION_ACK"]).type == mavlink.MAV_MISSION_ACCEPTED
    craft.link.mav.mission_request_send(craft.system, 1, 1)
    assert craft.wait(["MISSION_ITEM"]).x == pytest.approx(x, abs=1e-5)


def test_transfers_complete_over_a_link_that_loses_a_third_each_way(start_vehicles, scenario):
    row = start_vehicles(scenario(), "--loss", 0.3).rows[0]
    link = connection(row["address"])
    uploader = Uploader(link, row["system_id"])
    assert uploader.upload(TEN) == mavlink.MAV_MISSION_ACCEPTED
    assert len(uploader.download()) == len(TEN)
    link.close()


def test_mission_items_without_an_upload_steer_in_guided(craft):
    """As dronekit's simple_goto does: 2 in `current` means "fly there now"."""
    frame, command, *_, x, y, z = item(WAYPOINT, 200, 100, 80)
    craft.link.mav.mission_item_int_send(craft.system, 1, 0, frame, command, 2, 0, 0, 0, 0, 0, x, y, z)
    assert craft.wait(["MISSION_ACK"]).type == mavlink.MAV_MISSION_ACCEPTED
    assert craft.set_mode(RTL) == ACCEPTED
    craft.link.mav.mission_item_int_send(craft.system, 1, 0, frame, command, 2, 0, 0, 0, 0, 0, x, y, z)
    assert craft.wait(["MISSION_ACK"]).type == mavlink.MAV_MISSION_ERROR
    assert craft.text().text == "Guided item: mode is RTL"


def test_two_writers_at_once(craft, uploader):
    other = connection(f"127.0.0.1:{craft.port}", source_system=254)
    craft.link.mav.mission_count_send(craft.system, 1, 2)
    craft.wait(["MISSION_REQUEST"])
    assert Uploader(other, craft.system).upload(TEN) == mavlink.MAV_MISSION_DENIED
    # Of another plan they do not disturb each other.
    point = item(mavlink.MAV_CMD_NAV_RALLY_POINT, 10, 20)
    assert Uploader(other, craft.system, mavlink.MAV_MISSION_TYPE_RALLY).upload([point]) == mavlink.MAV_MISSION_ACCEPTED
    assert uploader.upload(TEN) == mavlink.MAV_MISSION_ACCEPTED
    other.close()
