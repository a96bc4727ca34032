"""Rally points: uploaded, refused, and where RTL goes."""

import math

import pytest
from ground import ACCEPTED, RTL
from plans import RALLY, Uploader, item
from pymavlink.dialects.v20 import ardupilotmega as mavlink

POINT = mavlink.MAV_CMD_NAV_RALLY_POINT


def test_what_is_uploaded_is_downloaded_and_counted(craft):
    uploader = Uploader(craft.link, craft.system, RALLY)
    points = [item(POINT, 100, 0, 70), item(POINT, 0, 100, 80)]
    assert uploader.upload(points) == mavlink.MAV_MISSION_ACCEPTED
    assert [(read.command, read.x, read.y, read.z) for read in uploader.download()] == [
        (POINT, x, y, z) for *_, x, y, z in points
    ]
    craft.link.mav.param_request_read_send(craft.system, 1, b"RALLY_TOTAL", -1)
    assert craft.wait(["PARAM_VALUE"]).param_value == 2


@pytest.mark.parametrize(
    ("bad", "code"),
    [
        (item(mavlink.MAV_CMD_NAV_WAYPOINT), mavlink.MAV_MISSION_UNSUPPORTED),
        (item(POINT, altitude_m=math.nan), mavlink.MAV_MISSION_INVALID_PARAM7),
        (item(POINT, frame=mavlink.MAV_FRAME_LOCAL_NED), mavlink.MAV_MISSION_UNSUPPORTED_FRAME),
        ((*item(POINT)[:5], 2**31 - 1, 0, 60), mavlink.MAV_MISSION_INVALID_PARAM5_X),
    ],
)
def test_a_bad_point_is_refused_and_the_old_ones_stay(craft, bad, code):
    uploader = Uploader(craft.link, craft.system, RALLY)
    assert uploader.upload([item(POINT)]) == mavlink.MAV_MISSION_ACCEPTED
    assert uploader.upload([item(POINT), bad]) == code
    assert len(uploader.download()) == 1
    assert uploader.upload([item(POINT)] * 51) == mavlink.MAV_MISSION_NO_SPACE


def test_rtl_goes_to_the_nearest_point_at_its_altitude(start_vehicles, scenario):
    craft = start_vehicles(scenario(), "--speed", 20).connect()[0]
    points = [item(POINT, -900, 0, 70), item(POINT, 300, 200, 80)]
    assert Uploader(craft.link, craft.system, RALLY).upload(points) == mavlink.MAV_MISSION_ACCEPTED
    assert craft.set_mode(RTL) == ACCEPTED
    end = craft.samples(150)[-1]
    assert abs(math.hypot(end.x_m - 300, end.y_m - 200) - 60) < 1
    assert end.altitude_m == pytest.approx(80, abs=0.1)
