"""Fences: uploaded, downloaded, refused, breached, obeyed, kept over a restart."""

import math
import subprocess

import pytest
from ground import ACCEPTED, CRUISE, FAILED, GUIDED, RTL, connection
from plans import FENCE, RELATIVE, Uploader, item
from pymavlink.dialects.v20 import ardupilotmega as mavlink

STAY_IN, STAY_OUT, RETURN = (
    mavlink.MAV_CMD_NAV_FENCE_POLYGON_VERTEX_INCLUSION,
    mavlink.MAV_CMD_NAV_FENCE_CIRCLE_EXCLUSION,
    mavlink.MAV_CMD_NAV_FENCE_RETURN_POINT,
)


def square(half_m):
    corners = [(-half_m, -half_m), (-half_m, half_m), (half_m, half_m), (half_m, -half_m)]
    return [item(STAY_IN, north, east, 0, p1=4) for north, east in corners]


def write(craft, name, value):
    kind = mavlink.MAV_PARAM_TYPE_REAL32
    craft.link.mav.param_set_send(craft.system, 1, name.encode(), value, kind)
    assert craft.wait(["PARAM_VALUE"], lambda read: read.param_id == name).param_value == value


def wait_for_text(craft, words):
    while (text := craft.text().text) != words:
        assert "ailed" not in text, text


@pytest.fixture
def fenced(start_vehicles, scenario):
    """A vehicle on its way out of a fence, ten times as fast."""
    craft = start_vehicles(scenario(), "--speed", 10).connect()[0]
    assert Uploader(craft.link, craft.system, FENCE).upload(square(150)) == mavlink.MAV_MISSION_ACCEPTED
    return craft


def test_what_is_uploaded_is_downloaded(craft):
    uploader = Uploader(craft.link, craft.system, FENCE)
    items = [*square(200), item(STAY_OUT, 50, 50, 0, p1=20), item(RETURN, 10, 0, 0)]
    assert uploader.upload(items) == mavlink.MAV_MISSION_ACCEPTED
    assert [(read.frame, read.command, read.param1, read.x, read.y) for read in uploader.download()] == [
        (mavlink.MAV_FRAME_GLOBAL, command, p1, x, y) for _, command, p1, _, _, x, y, _ in items
    ]
    craft.link.mav.param_request_read_send(craft.system, 1, b"FENCE_TOTAL", -1)
    assert craft.wait(["PARAM_VALUE"]).param_value == 7  # as in ArduPlane: corners, circles, and two
    assert uploader.upload([]) == mavlink.MAV_MISSION_ACCEPTED
    assert uploader.download() == []


@pytest.mark.parametrize(
    ("items", "code", "words"),
    [
        (square(100)[:2], mavlink.MAV_MISSION_ERROR, "Incorrect item count"),
        ([item(STAY_IN, p1=2), item(STAY_IN, p1=2)], mavlink.MAV_MISSION_ERROR, "Invalid vertex count (2)"),
        ([item(STAY_OUT, p1=0)], mavlink.MAV_MISSION_ERROR, "Non-positive circle radius"),
        ([item(RETURN), item(RETURN)], mavlink.MAV_MISSION_ERROR, "Multiple return points"),
        (
            [item(STAY_OUT, p1=math.nan)],
            mavlink.MAV_MISSION_INVALID_PARAM1,
            "Fence refused: invalid param1, item 0 (5004)",
        ),
        (
            [item(mavlink.MAV_CMD_NAV_WAYPOINT)],
            mavlink.MAV_MISSION_UNSUPPORTED,
            "Fence refused: unsupported, item 0 (16)",
        ),
        (
            [item(RETURN, frame=mavlink.MAV_FRAME_LOCAL_NED)],
            mavlink.MAV_MISSION_UNSUPPORTED_FRAME,
            "Fence refused: unsupported frame, item 0 (5000)",
        ),
        ([(RELATIVE, RETURN, 0, 0, 0, 2**31 - 1, 0, 0)], mavlink.MAV_MISSION_ERROR, "Bad lat or lon"),
        (square(100) * 64, mavlink.MAV_MISSION_NO_SPACE, "Only 84 items are supported"),
    ],
)
def test_a_bad_fence_is_refused_and_the_old_one_stays(craft, items, code, words):
    uploader = Uploader(craft.link, craft.system, FENCE)
    assert uploader.upload(square(200)) == mavlink.MAV_MISSION_ACCEPTED
    assert uploader.upload(items) == code
    assert uploader.words[-1] == words
    assert len(uploader.download()) == 4


def test_a_breach_is_announced_leads_home_and_ends(fenced):
    write(fenced, "FENCE_ENABLE", 1)
    wait_for_text(fenced, "Polygon fence breached")
    status = fenced.wait(["FENCE_STATUS"], lambda status: status.breach_status == 1)
    assert (status.breach_count, status.breach_type) == (1, mavlink.FENCE_BREACH_BOUNDARY)
    assert fenced.mode() == RTL
    wait_for_text(fenced, "Fence breach cleared")
    bit = mavlink.MAV_SYS_STATUS_GEOFENCE
    healthy = fenced.wait(["SYS_STATUS"], lambda status: status.onboard_control_sensors_health & bit)
    assert healthy.onboard_control_sensors_present & healthy.onboard_control_sensors_enabled & bit
    assert fenced.set_mode(GUIDED) == ACCEPTED
    assert fenced.mode() == GUIDED


def test_on_the_way_back_the_mode_is_locked(start_vehicles, scenario):
    craft = start_vehicles(scenario()).connect()[0]
    # It starts outside, and is a while on the way.
    away = item(mavlink.MAV_CMD_NAV_FENCE_CIRCLE_INCLUSION, -2000, 0, 0, p1=50)
    assert Uploader(craft.link, craft.system, FENCE).upload([away]) == mavlink.MAV_MISSION_ACCEPTED
    write(craft, "FENCE_ENABLE", 1)
    wait_for_text(craft, "Polygon fence breached")
    assert craft.set_mode(CRUISE) == FAILED
    wait_for_text(craft, "Mode change to CRUISE denied, in fence recovery")
    write(craft, "FENCE_OPTIONS", 0)
    assert craft.set_mode(CRUISE) == ACCEPTED
    assert craft.mode() == CRUISE


def test_a_breach_may_only_be_told_or_lead_to_the_return_point(start_vehicles, scenario):
    craft = start_vehicles(scenario(), "--speed", 20).connect()[0]
    items = [*square(150), item(RETURN, -30, 40, 0)]
    assert Uploader(craft.link, craft.system, FENCE).upload(items) == mavlink.MAV_MISSION_ACCEPTED
    write(craft, "FENCE_ACTION", 0)
    write(craft, "FENCE_ENABLE", 1)
    assert craft.set_mode(CRUISE) == ACCEPTED
    wait_for_text(craft, "Polygon fence breached")
    assert craft.mode() == CRUISE
    write(craft, "FENCE_ENABLE", 0)
    write(craft, "FENCE_ACTION", 6)
    write(craft, "FENCE_ENABLE", 1)
    wait_for_text(craft, "Polygon fence breached")
    assert craft.mode() == GUIDED
    wait_for_text(craft, "Fence breach cleared")
    samples = craft.samples(120)
    assert abs(math.hypot(samples[-1].x_m + 30, samples[-1].y_m - 40) - 60) < 1
    assert samples[-1].altitude_m == pytest.approx(45, abs=0.1)  # between FENCE_ALT_MIN and FENCE_ALT_MAX


def test_altitudes_and_a_circle_round_home_by_parameters_alone(start_vehicles, scenario):
    craft = start_vehicles(scenario(), "--speed", 10).connect()[0]
    write(craft, "FENCE_TYPE", 3)
    write(craft, "FENCE_ALT_MAX", 70)
    write(craft, "FENCE_ACTION", 0)
    write(craft, "FENCE_ENABLE", 1)
    assert craft.change_altitude(90) == ACCEPTED
    wait_for_text(craft, "Max Alt fence breached")
    assert craft.change_altitude(50) == ACCEPTED
    wait_for_text(craft, "Fence breach cleared")
    write(craft, "FENCE_RADIUS", 100)
    assert craft.change_heading(0) == ACCEPTED
    wait_for_text(craft, "Circle fence breached")
    assert craft.command_long(mavlink.MAV_CMD_DO_FENCE_ENABLE, 0) == ACCEPTED
    assert craft.command_long(mavlink.MAV_CMD_DO_FENCE_ENABLE, 7) == FAILED


def test_transfers_complete_over_a_link_that_loses_a_third_each_way(start_vehicles, scenario):
    row = start_vehicles(scenario(), "--loss", 0.3).rows[0]
    link = connection(row["address"])
    uploader = Uploader(link, row["system_id"], FENCE)
    items = [item(STAY_IN, 100 * math.cos(a), 100 * math.sin(a), 0, p1=12) for a in range(12)]
    assert uploader.upload(items, patience_s=60) == mavlink.MAV_MISSION_ACCEPTED
    assert len(uploader.download()) == len(items)
    link.close()


def test_plans_survive_a_restart_when_asked_for(start_vehicles, scenario, tmp_path):
    folder = tmp_path / "state"
    first = start_vehicles(scenario(count=2), "--state-folder", folder)
    craft = first.connect()[1]
    assert Uploader(craft.link, craft.system, FENCE).upload(square(200)) == mavlink.MAV_MISSION_ACCEPTED
    before = [(read.x, read.y, read.param1) for read in Uploader(craft.link, craft.system, FENCE).download()]
    first.stop()
    assert [path.name for path in folder.iterdir()] == ["vehicle-2-fence.txt"]
    again = start_vehicles(scenario(count=2), "--state-folder", folder).connect()
    uploaders = [Uploader(craft.link, craft.system, FENCE) for craft in again]
    assert uploaders[0].download() == []
    assert [(read.x, read.y, read.param1) for read in uploaders[1].download()] == before


def test_a_file_of_nonsense_is_named(program, scenario, tmp_path):
    (tmp_path / "vehicle-1-fence.txt").write_text("QGC WPL 110\n0 0 3 5001 2 0 0 0 40 116 0 1\n")
    command = [program, "vehicles", scenario(), "--vehicle-port", 0, "--ground-port", 0, "--state-folder", tmp_path]
    done = subprocess.run([str(word) for word in command], stderr=subprocess.PIPE, text=True, timeout=30)
    assert done.returncode == 2
    assert "vehicle-1-fence.txt:2: Fence refused: Invalid vertex count (2)" in done.stderr
