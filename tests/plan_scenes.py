"""The scenes of plans: missions, fences and rally points, and whole flights along them."""

from command_scenes import AUTO, FRAMES, GUIDED, LOITER, MANUAL, WAYPOINT
from differential import FENCE, MISSION, RALLY, scene
from pymavlink.dialects.v20 import ardupilotmega as mavlink

TAKEOFF, LAND, RETURN, JUMP = (
    mavlink.MAV_CMD_NAV_TAKEOFF,
    mavlink.MAV_CMD_NAV_LAND,
    mavlink.MAV_CMD_NAV_RETURN_TO_LAUNCH,
    mavlink.MAV_CMD_DO_JUMP,
)
INCLUSION, EXCLUSION, INSIDE, OUTSIDE, RALLY_POINT = (
    mavlink.MAV_CMD_NAV_FENCE_POLYGON_VERTEX_INCLUSION,
    mavlink.MAV_CMD_NAV_FENCE_POLYGON_VERTEX_EXCLUSION,
    mavlink.MAV_CMD_NAV_FENCE_CIRCLE_INCLUSION,
    mavlink.MAV_CMD_NAV_FENCE_CIRCLE_EXCLUSION,
    mavlink.MAV_CMD_NAV_RALLY_POINT,
)
RADIUS_M = 60


def ended(talk):
    """Whether a transfer has been acknowledged in this step."""
    words = ("mission ", "fence ", "rally ")
    return lambda: any(a.startswith(words) and "wants" not in a and "count" not in a for a in talk.answers)


def upload(talk, name, items, kind=MISSION, beats=25, **how):
    with talk.step(name, until=ended(talk), beats=beats):
        talk.upload(items, kind, **how)


def download(talk, name, kind=MISSION):
    with talk.step(name):
        talk.mav.mission_request_list_send(talk.system, talk.component, kind)
        talk.settle()
        for seq in range(talk.newest["MISSION_COUNT"].count):
            talk.mav.mission_request_int_send(talk.system, talk.component, seq, kind)
            talk.settle()


def short(talk):
    """Home and four waypoints."""
    places = ((0, 0), (300, 0), (300, 300), (0, 300), (0, 100))
    return [talk.item(WAYPOINT, *place, p2=RADIUS_M) for place in places]


def ten(talk):
    """A take-off, waypoints, a speed, a circle, and a landing."""
    return [
        talk.item(WAYPOINT),
        talk.item(TAKEOFF, 0, 0, 50, p1=12),
        talk.item(WAYPOINT, 300, 0, 60, p2=RADIUS_M),
        talk.item(mavlink.MAV_CMD_DO_CHANGE_SPEED, 0, 0, 0, p1=0, p2=12, p3=-1),
        talk.item(WAYPOINT, 500, 200, 70, p2=RADIUS_M),
        talk.item(WAYPOINT, 300, 450, 70, p2=RADIUS_M),
        talk.item(mavlink.MAV_CMD_NAV_LOITER_TURNS, 0, 450, 70, p1=1, p3=80),
        talk.item(mavlink.MAV_CMD_NAV_LOITER_TIME, -200, 300, 60, p1=5, p3=80),
        talk.item(WAYPOINT, -500, 300, 45, p2=RADIUS_M),
        talk.item(WAYPOINT, -500, 0, 25, p2=RADIUS_M),
        talk.item(LAND, 0, 0, 0),
    ]


@scene
def missions(talk):
    download(talk, "there is none at first")
    upload(talk, "a good one", short(talk))
    download(talk, "and back")
    with talk.step("the number of items, by the older messages"):
        talk.mav.mission_request_list_send(talk.system, talk.component)
    with talk.step("one item, by the older message", also=["MISSION_ITEM"]):
        talk.mav.mission_request_send(talk.system, talk.component, 1)
    with talk.step("an item beyond the end"):
        talk.mav.mission_request_int_send(talk.system, talk.component, 50, MISSION)
    with talk.step("current is 2"):
        talk.mav.mission_set_current_send(talk.system, talk.component, 2)
    with talk.step("current is 3, by command"):
        talk.long(mavlink.MAV_CMD_DO_SET_MISSION_CURRENT, 3)
    with talk.step("current is beyond the end"):
        talk.mav.mission_set_current_send(talk.system, talk.component, 50)
    with talk.step("current is beyond the end, by command"):
        talk.long(mavlink.MAV_CMD_DO_SET_MISSION_CURRENT, 50)
    with talk.step("current is below zero, by command"):
        talk.long(mavlink.MAV_CMD_DO_SET_MISSION_CURRENT, -1)
    with talk.step("current is 0"):
        talk.mav.mission_set_current_send(talk.system, talk.component, 0)
    with talk.step("current is 1, from the beginning"):
        talk.long(mavlink.MAV_CMD_DO_SET_MISSION_CURRENT, 1, 1)

    # Half a mission, and what comes of the one before.
    with talk.step("an item that nobody asked for"):
        talk.send_item(1, short(talk)[1])
    with talk.step("an upload that stops", until=ended(talk), beats=25):
        talk.upload(short(talk)[:2], count=4)
    download(talk, "after it the one before is there, or not")
    with talk.step("an upload that is cancelled", until=ended(talk), beats=25):
        talk.upload(short(talk)[:2], count=4)
        talk.settle()
        talk.mav.mission_ack_send(talk.system, talk.component, mavlink.MAV_MISSION_OPERATION_CANCELLED, MISSION)
    with talk.step("an upload with a gap", until=ended(talk), beats=25):
        talk.upload(short(talk)[:1], count=4)
        talk.settle()
        talk.send_item(3, short(talk)[3])
    with talk.step("an upload within an upload", until=ended(talk), beats=25):
        talk.upload(short(talk)[:1], count=4)
        talk.settle()
        talk.upload(short(talk))
    upload(talk, "nothing at all", [])
    upload(talk, "more than there is room for", [], count=65_000, beats=3)
    with talk.step("clear"):
        talk.mav.mission_clear_all_send(talk.system, talk.component, MISSION)
    download(talk, "there is none any more")


@scene
def mission_parts(talk):
    items = short(talk)
    upload(talk, "a good one", items)
    new = talk.item(WAYPOINT, 400, 400, 80, p2=RADIUS_M)
    with talk.step("a part of it", until=ended(talk), beats=25):
        talk.items = [*items[:2], new, new, *items[4:]]
        talk.mav.mission_write_partial_list_send(talk.system, talk.component, 2, 3, MISSION)
    download(talk, "and back")
    for name, first, last in (("beyond the end", 3, 9), ("backwards", 3, 2), ("below zero", -1, 2)):
        with talk.step(f"a part {name}", until=ended(talk), beats=3):
            talk.mav.mission_write_partial_list_send(talk.system, talk.component, first, last, MISSION)
    with talk.step("a list of a part", also=["MISSION_ITEM_INT"]):
        talk.mav.mission_request_partial_list_send(talk.system, talk.component, 1, 2, MISSION)


@scene
def mission_items(talk):
    """What may be in one: each command, each frame, and fields that are none."""
    numbers = sorted(number for number in mavlink.enums["MAV_CMD"] if number < 1000)
    for number in numbers:
        name = mavlink.enums["MAV_CMD"][number].name.removeprefix("MAV_CMD_")
        upload(talk, f"with {name}", [talk.item(WAYPOINT), talk.item(number, 100, 100)], beats=3)
    for name, frame in FRAMES.items():
        upload(talk, f"in frame {name}", [talk.item(WAYPOINT), talk.item(WAYPOINT, 100, 100, frame=frame)], beats=3)
    for name, item in {
        "a latitude that is none": (3, WAYPOINT, (0, 0, 0, 0), (910_000_000, 0), 50),
        "a longitude that is none": (3, WAYPOINT, (0, 0, 0, 0), (400_000_000, 1_810_000_000), 50),
        "latitude and longitude of zero": (3, WAYPOINT, (0, 0, 0, 0), (0, 0), 50),
        "an altitude out of this world": talk.item(WAYPOINT, 100, 100, 1e6),
        "param 1 not a number": talk.item(WAYPOINT, 100, 100, p1=float("nan")),
        "param 2 below zero": talk.item(WAYPOINT, 100, 100, p2=-5),
        "param 2 too large": talk.item(WAYPOINT, 100, 100, p2=1e6),
        "a jump beyond the end": talk.item(JUMP, p1=9, p2=1),
        "a jump to itself": talk.item(JUMP, p1=1, p2=1),
        "half a turn": talk.item(mavlink.MAV_CMD_NAV_LOITER_TURNS, 100, 100, p1=0.5, p3=80),
        "a circle anticlockwise": talk.item(mavlink.MAV_CMD_NAV_LOITER_TURNS, 100, 100, p1=2, p3=-90),
        "time on a circle": talk.item(mavlink.MAV_CMD_NAV_LOITER_TIME, 100, 100, p1=30, p3=-90),
        "a speed": talk.item(mavlink.MAV_CMD_DO_CHANGE_SPEED, p1=0, p2=12, p3=-1),
    }.items():
        upload(talk, f"with {name}", [talk.item(WAYPOINT), item], beats=3)
        download(talk, f"and back: {name}")


@scene
def mission_commands(talk):
    """What a mission in the air is told."""
    with talk.step("AUTO without a mission, on the ground"):
        talk.mode(AUTO)
    talk.mode(MANUAL)
    talk.settle()
    talk.take_off()
    with talk.step("AUTO without a mission"):
        talk.mode(AUTO)
    with talk.step("back to LOITER"):
        talk.mode(LOITER)
    # Far enough that none is reached while it is told where to go.
    far = [talk.item(WAYPOINT, 2000 * seq, 0) for seq in range(1, 7)]
    far[4] = talk.item(JUMP, p1=2, p2=2)
    upload(talk, "a mission", [talk.item(WAYPOINT), *far])
    with talk.step("start"):
        talk.long(mavlink.MAV_CMD_MISSION_START)
    with talk.step("start when started"):
        talk.long(mavlink.MAV_CMD_MISSION_START)
    with talk.step("from item 3 to item 4"):
        talk.long(mavlink.MAV_CMD_MISSION_START, 3, 4)
    for seq in (3, 5, 6, 50, 0):
        with talk.step(f"current is {seq}"):
            talk.mav.mission_set_current_send(talk.system, talk.component, seq)
    with talk.step("out of AUTO and in again"):
        talk.mode(LOITER)
        talk.settle()
        talk.mode(AUTO)
    with talk.step("cleared while it flies"):
        talk.mav.mission_clear_all_send(talk.system, talk.component, MISSION)
    with talk.step("another one while it flies", until=ended(talk), beats=20):
        talk.upload([talk.item(WAYPOINT), *far[:3]])


def polygon(talk, command=INCLUSION, half_m=400, p1=4):
    corners = ((-1, -1), (-1, 1), (1, 1), (1, -1))
    return [talk.item(command, half_m * north, half_m * east, 0, p1=p1) for north, east in corners]


@scene
def fences(talk):
    download(talk, "there is none at first", FENCE)
    with talk.step("enabled without one"):
        talk.long(mavlink.MAV_CMD_DO_FENCE_ENABLE, 1)
    with talk.step("disabled"):
        talk.long(mavlink.MAV_CMD_DO_FENCE_ENABLE, 0)
    for name, items in {
        "a polygon": polygon(talk),
        "a polygon and a circle to keep out of": [*polygon(talk), talk.item(OUTSIDE, 200, 200, 0, p1=30)],
        "a circle to keep in": [talk.item(INSIDE, 0, 0, 0, p1=300)],
        "a polygon to keep out of": polygon(talk, EXCLUSION, 50),
        "a return point": [talk.item(mavlink.MAV_CMD_NAV_FENCE_RETURN_POINT, 0, 0, 0), *polygon(talk)],
        "a polygon of two corners": polygon(talk, p1=2)[:2],
        "a polygon with a corner missing": polygon(talk)[:3],
        "a polygon whose corners disagree": [*polygon(talk)[:2], *polygon(talk, p1=5)[2:]],
        "a circle of no radius": [talk.item(INSIDE, 0, 0, 0, p1=0)],
        "a circle of a radius below zero": [talk.item(INSIDE, 0, 0, 0, p1=-5)],
        "a waypoint": [talk.item(WAYPOINT, 0, 0, 0)],
        "a latitude that is none": [(3, INSIDE, (50, 0, 0, 0), (910_000_000, 0), 0)],
        "a local frame": [talk.item(INSIDE, 0, 0, 0, p1=50, frame=1)],
        "nothing": [],
    }.items():
        upload(talk, name, items, FENCE, beats=8)
        download(talk, f"and back: {name}", FENCE)
    upload(talk, "more than there is room for", [], FENCE, count=65_000, beats=3)
    upload(talk, "a polygon again", polygon(talk), FENCE)
    with talk.step("enabled"):
        talk.long(mavlink.MAV_CMD_DO_FENCE_ENABLE, 1)
    with talk.step("FENCE_ENABLE is"):
        talk.read("FENCE_ENABLE")
    with talk.step("neither enabled nor disabled"):
        talk.long(mavlink.MAV_CMD_DO_FENCE_ENABLE, 5)
    with talk.step("only the floor"):
        talk.long(mavlink.MAV_CMD_DO_FENCE_ENABLE, 2)
    with talk.step("cleared"):
        talk.mav.mission_clear_all_send(talk.system, talk.component, FENCE)
    with talk.step("cleared for another system"):
        talk.mav.mission_clear_all_send(77, talk.component, FENCE)
    with talk.step("all kinds cleared"):
        talk.mav.mission_clear_all_send(talk.system, talk.component, 255)


@scene
def rally_points(talk):
    download(talk, "there is none at first", RALLY)
    point = talk.item(RALLY_POINT, 100, 50, 60)
    for name, items in {
        "one": [point],
        "three": [point, talk.item(RALLY_POINT, -100, 50, 70), talk.item(RALLY_POINT, 0, 200, 80)],
        "a waypoint": [talk.item(WAYPOINT, 100, 50)],
        "a latitude that is none": [(3, RALLY_POINT, (0, 0, 0, 0), (910_000_000, 0), 60)],
        "above sea level": [talk.item(RALLY_POINT, 100, 50, 700, frame=0)],
        "a local frame": [talk.item(RALLY_POINT, 100, 50, 60, frame=1)],
        "nothing": [],
    }.items():
        upload(talk, name, items, RALLY, beats=8)
        download(talk, f"and back: {name}", RALLY)
    upload(talk, "more than there is room for", [], RALLY, count=65_000, beats=3)
    with talk.step("cleared"):
        talk.mav.mission_clear_all_send(talk.system, talk.component, RALLY)


@scene
def a_whole_flight(talk):
    upload(talk, "ten items", ten(talk))
    with talk.step("to AUTO"):
        talk.mode(AUTO)
    with talk.step("armed it takes off", until=lambda: talk.height() > 40, beats=90):
        talk.arm()
    with talk.step("disarm in the air"):
        talk.arm(False)
    with talk.step("to the last waypoint", until=lambda: "reached 9" in talk.progress, beats=600):
        pass
    with talk.step("down, and disarmed", until=talk.disarmed, beats=300):
        pass


@scene
def home_by_rtl(talk):
    with talk.step("to TAKEOFF"):
        talk.mode(13)
    with talk.step("armed it takes off", until=lambda: talk.height() > 40, beats=90):
        talk.arm()
    with talk.step("to RTL"):
        talk.mode(11)
    with talk.step("to GUIDED"):
        talk.mode(GUIDED)


@scene
def fence_breach(talk):
    # Only the polygon, whose breach means RTL.
    for name, value in (("FENCE_ACTION", 1), ("FENCE_AUTOENABLE", 0), ("FENCE_TYPE", 4)):
        talk.set(name, value)
        talk.settle()
    upload(talk, "a polygon", polygon(talk), FENCE)
    talk.take_off()
    with talk.step("enabled"):
        talk.long(mavlink.MAV_CMD_DO_FENCE_ENABLE, 1)
    with talk.step("to GUIDED"):
        talk.mode(GUIDED)
    with talk.step("a place outside"):
        talk.int(mavlink.MAV_CMD_DO_REPOSITION, -1, 0, 0, 0, *talk.place(900, 0), 60)
    with talk.step("a course out of it", until=talk.in_mode(11), beats=120):
        talk.int(mavlink.MAV_CMD_GUIDED_CHANGE_HEADING, 0, 0, 20)
    with talk.step("to GUIDED while outside"):
        talk.mode(GUIDED)


@scene
def ground_station_lost(talk):
    for name, value in (("FS_GCS_ENABL", 1), ("FS_LONG_ACTN", 1), ("FS_LONG_TIMEOUT", 5)):
        with talk.step(f"set {name}"):
            talk.set(name, value)
    talk.take_off()
    with talk.step("to GUIDED"):
        talk.mode(GUIDED)
    with talk.step("silence", until=talk.in_mode(11), beats=30):
        talk.silent = True
    with talk.step("to GUIDED while nobody is heard"):
        talk.mode(GUIDED)
    with talk.step("heard again"):
        talk.silent = False
        talk.rest(5)
    with talk.step("to GUIDED again"):
        talk.mode(GUIDED)
