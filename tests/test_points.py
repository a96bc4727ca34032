"""Fences and rally points by ArduPilot's older messages, one point in each, as MAVProxy's and dronekit's scripts of
old."""

import pytest
from plans import FENCE, RALLY, Uploader, item, place
from pymavlink.dialects.v20 import ardupilotmega as mavlink
from test_fence import write

CORNERS = [(-150, -150), (-150, 150), (150, 0)]


def degrees(north_m, east_m):
    x, y = place(north_m, east_m)
    return x / 1e7, y / 1e7


def write_fence(craft, points):
    write(craft, "FENCE_TOTAL", len(points))
    for index, (north_m, east_m) in enumerate(points):
        craft.link.mav.fence_point_send(craft.system, 1, index, len(points), *degrees(north_m, east_m))


def fetch_fence(craft, index):
    craft.link.mav.fence_fetch_point_send(craft.system, 1, index)
    return craft.wait(["FENCE_POINT"])


def test_a_fence_of_points_is_written_read_and_a_fence_like_any_other(craft):
    points = [(10, 20), *CORNERS, CORNERS[0]]
    write_fence(craft, points)
    for index, (north_m, east_m) in enumerate(points):
        read = fetch_fence(craft, index)
        assert (read.idx, read.count, read.target_system) == (index, 5, craft.link.mav.srcSystem)
        # Single precision: 4 m.
        assert (read.lat, read.lng) == pytest.approx(degrees(north_m, east_m), abs=1e-5)
    items = Uploader(craft.link, craft.system, FENCE).download()
    corner = mavlink.MAV_CMD_NAV_FENCE_POLYGON_VERTEX_INCLUSION
    assert [(read.command, read.param1) for read in items] == [
        (mavlink.MAV_CMD_NAV_FENCE_RETURN_POINT, 0), *[(corner, 3)] * 3
    ]  # fmt: skip
    assert craft.command_long(mavlink.MAV_CMD_DO_FENCE_ENABLE, 1) == mavlink.MAV_RESULT_ACCEPTED
    write(craft, "FENCE_TOTAL", 0)
    assert Uploader(craft.link, craft.system, FENCE).download() == []


def test_refusals_of_fence_points_are_in_arduplanes_words(craft):
    write(craft, "FENCE_TOTAL", 4)
    craft.link.mav.fence_point_send(craft.system, 1, 0, 4, *degrees(0, 0))
    assert craft.text().text == "Invalid FENCE_TOTAL"
    write(craft, "FENCE_TOTAL", 5)
    for index, count, lat, words in [
        (0, 6, 0, "Invalid fence point, bad count (6 vs 5)"),
        (5, 5, 0, "Invalid fence point, index past total (5 >= 5)"),
        (0, 5, 91, "Invalid fence point, bad lat or lng"),
    ]:
        craft.link.mav.fence_point_send(craft.system, 1, index, count, lat, 0)
        assert craft.text().text == words
    craft.link.mav.fence_fetch_point_send(craft.system, 1, 5)
    assert craft.text().text == "Invalid fence point, index past total(5 >= 5)"
    circle = item(mavlink.MAV_CMD_NAV_FENCE_CIRCLE_INCLUSION, p1=400)
    assert Uploader(craft.link, craft.system, FENCE).upload([circle]) == mavlink.MAV_MISSION_ACCEPTED
    craft.link.mav.fence_fetch_point_send(craft.system, 1, 0)
    assert craft.text().text == "Vehicle contains advanced fences"


def test_rally_points_are_written_read_and_like_any_others(craft):
    write(craft, "RALLY_TOTAL", 2)
    for index, (north_m, east_m, altitude_m) in enumerate([(300, 200, 80), (-900, 0, 70)]):
        x, y = place(north_m, east_m)
        craft.link.mav.rally_point_send(craft.system, 1, index, 2, x, y, altitude_m, 40, 9000, 2)
    craft.link.mav.rally_fetch_point_send(craft.system, 1, 1)
    read = craft.wait(["RALLY_POINT"])
    assert (read.idx, read.count, read.lat, read.lng) == (1, 2, *place(-900, 0))
    assert (read.alt, read.break_alt, read.land_dir, read.flags) == (70, 40, 9000, 2)
    items = Uploader(craft.link, craft.system, RALLY).download()
    assert [(read.frame, read.x, read.y, read.z) for read in items] == [
        (mavlink.MAV_FRAME_GLOBAL_RELATIVE_ALT, *place(300, 200), 80),
        (mavlink.MAV_FRAME_GLOBAL_RELATIVE_ALT, *place(-900, 0), 70),
    ]
    craft.link.mav.rally_point_send(craft.system, 1, 2, 2, 0, 0, 0, 0, 0, 0)
    assert craft.text().text == "Bad rally point ID"
    craft.link.mav.rally_point_send(craft.system, 1, 1, 3, 0, 0, 0, 0, 0, 0)
    assert craft.text().text == "Bad rally point count"
    craft.link.mav.rally_fetch_point_send(craft.system, 1, 2)
    assert craft.text().text == "Failed to get rally point"
    # What is uploaded says above what its altitude is.
    point = item(mavlink.MAV_CMD_NAV_RALLY_POINT, 100, 0, 70, frame=mavlink.MAV_FRAME_GLOBAL)
    assert Uploader(craft.link, craft.system, RALLY).upload([point]) == mavlink.MAV_MISSION_ACCEPTED
    craft.link.mav.rally_fetch_point_send(craft.system, 1, 0)
    assert craft.wait(["RALLY_POINT"]).flags == 4


@pytest.mark.parametrize("personality", ["px4", "generic"])
def test_others_pass_them_over(start_vehicles, scenario, personality):
    craft = start_vehicles(scenario(), "--personality", personality).connect()[0]
    craft.link.mav.fence_fetch_point_send(craft.system, 1, 0)
    craft.link.mav.rally_fetch_point_send(craft.system, 1, 0)
    name = b"MAV_SYS_ID" if personality == "px4" else b"MAV_SYSID"
    craft.link.mav.param_request_read_send(craft.system, 1, name, -1)
    answer = craft.wait(["FENCE_POINT", "RALLY_POINT", "PARAM_VALUE"])
    assert answer.get_type() == "PARAM_VALUE"
