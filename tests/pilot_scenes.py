"""Scenes of a pilot's receiver, of plans point by point, and of the commands on the way of a mission."""

from command_scenes import AUTO, GUIDED, LOITER, MANUAL, WAYPOINT
from differential import FENCE, RALLY, scene
from plan_scenes import RADIUS_M, download, upload
from pymavlink.dialects.v20 import ardupilotmega as mavlink

RTL, CIRCLE, FBWA = 11, 1, 5
ALONE = 65535
CORNERS = ((0, -300), (300, 300), (-300, 300))


def write_fence(talk, points, count=None, indices=None):
    for index, (north_m, east_m) in zip(indices or range(len(points)), points, strict=False):
        x, y = talk.place(north_m, east_m)
        total = len(points) if count is None else count
        talk.mav.fence_point_send(talk.system, talk.component, index, total, x / 1e7, y / 1e7)
        talk.settle()


@scene
def fences_by_points(talk):
    points = [(0, 50), *CORNERS, CORNERS[0]]
    with talk.step("one before there is a total"):
        write_fence(talk, points[:1], count=5)
    with talk.step("fetched before there is a total"):
        talk.mav.fence_fetch_point_send(talk.system, talk.component, 0)
    with talk.step("a total of four"):
        talk.set("FENCE_TOTAL", 4)
    with talk.step("fetched with a total of four"):
        talk.mav.fence_fetch_point_send(talk.system, talk.component, 0)
    with talk.step("a total of five"):
        talk.set("FENCE_TOTAL", 5)
    with talk.step("fetched before there is any"):
        talk.mav.fence_fetch_point_send(talk.system, talk.component, 1)
    with talk.step("a return point"):
        write_fence(talk, points[:1], count=5)
    download(talk, "the return point alone", FENCE)
    with talk.step("two corners"):
        write_fence(talk, points[1:3], count=5, indices=(1, 2))
    download(talk, "with two corners", FENCE)
    with talk.step("all of them"):
        write_fence(talk, points)
    download(talk, "all back", FENCE)
    for index in (0, 1, 4, 5):
        with talk.step(f"fetched: {index}"):
            talk.mav.fence_fetch_point_send(talk.system, talk.component, index)
    for name, index, count in (("of another number", 1, 6), ("beyond the end", 5, 5)):
        with talk.step(f"one {name}"):
            write_fence(talk, points[:1], count=count, indices=(index,))
    with talk.step("enabled"):
        talk.long(mavlink.MAV_CMD_DO_FENCE_ENABLE, 1)
    with talk.step("a total of zero"):
        talk.set("FENCE_TOTAL", 0)
    download(talk, "cleared by it", FENCE)
    upload(talk, "a circle", [talk.item(mavlink.MAV_CMD_NAV_FENCE_CIRCLE_INCLUSION, p1=400)], FENCE)
    with talk.step("a total again"):
        talk.set("FENCE_TOTAL", 5)
    with talk.step("fetched of a circle"):
        talk.mav.fence_fetch_point_send(talk.system, talk.component, 0)


@scene
def rally_points_one_by_one(talk):
    def write(index, count, north_m=100, flags=0):
        x, y = talk.place(north_m, 50)
        talk.mav.rally_point_send(talk.system, talk.component, index, count, x, y, 70, 40, 9000, flags)

    with talk.step("one before there is a total"):
        write(0, 1)
    with talk.step("a total of two"):
        talk.set("RALLY_TOTAL", 2)
    download(talk, "before there are any", RALLY)
    with talk.step("fetched before there is any"):
        talk.mav.rally_fetch_point_send(talk.system, talk.component, 0)
    with talk.step("the first"):
        write(0, 2)
    with talk.step("the second, above sea level"):
        write(1, 2, 200, 4)
    for name, index, count in (("beyond the end", 2, 2), ("of another number", 1, 3)):
        with talk.step(f"one {name}"):
            write(index, count)
    download(talk, "both back", RALLY)
    for index in range(4):
        with talk.step(f"fetched: {index}"):
            talk.mav.rally_fetch_point_send(talk.system, talk.component, index)
    with talk.step("a total of one"):
        talk.set("RALLY_TOTAL", 1)
    download(talk, "one back", RALLY)
    with talk.step("a total of two again"):
        talk.set("RALLY_TOTAL", 2)
    download(talk, "both there again", RALLY)


def fly_in(talk, number):
    talk.take_off()
    talk.mode(number)
    talk.settle()


@scene
def a_receiver_that_is_silent(talk):
    fly_in(talk, LOITER)
    with talk.step("in LOITER", until=talk.in_mode(RTL), beats=20):
        talk.set("SIM_RC_FAIL", 1)
    with talk.step("heard again"):
        talk.set("SIM_RC_FAIL", 0)
        talk.rest(3)
    talk.set("FS_SHORT_ACTN", 1)
    talk.set("FS_LONG_TIMEOUT", 20)
    talk.mode(GUIDED)
    talk.settle()
    with talk.step("in GUIDED", until=talk.in_mode(CIRCLE), beats=20):
        talk.set("SIM_RC_FAIL", 1)
    with talk.step("heard again in time", until=talk.in_mode(GUIDED), beats=20):
        talk.set("SIM_RC_FAIL", 0)
    with talk.step("in GUIDED again", until=talk.in_mode(CIRCLE), beats=20):
        talk.set("SIM_RC_FAIL", 1)
    with talk.step("LOITER meanwhile"):
        talk.mode(LOITER)
    with talk.step("heard again after that"):
        talk.set("SIM_RC_FAIL", 0)
        talk.rest(3)
    for value in range(5):
        talk.set("FS_SHORT_ACTN", value)
        for number in (FBWA, AUTO, RTL):
            talk.mode(number)
            talk.settle()
            with talk.step(f"FS_SHORT_ACTN {value} in mode {number}"):
                talk.set("SIM_RC_FAIL", 1)
                talk.rest(4)
            talk.set("SIM_RC_FAIL", 0)
            talk.rest(3)


@scene
def a_receiver_on_the_ground(talk):
    with talk.step("silent", until=talk.in_mode(RTL), beats=20):
        talk.set("SIM_RC_FAIL", 1)
    with talk.step("to MANUAL"):
        talk.mode(MANUAL)
    with talk.step("armed"):
        talk.arm()
    with talk.step("heard again"):
        talk.set("SIM_RC_FAIL", 0)
        talk.rest(3)
    with talk.step("without its failsafe, silent"):
        talk.set("THR_FAILSAFE", 0)
        talk.set("SIM_RC_FAIL", 1)
        talk.rest(4)
    talk.set("SIM_RC_FAIL", 0)
    talk.set("THR_FAILSAFE", 1)
    talk.rest(3)
    with talk.step("with a throttle that is lost", until=talk.in_mode(RTL), beats=20):
        talk.set("SIM_RC_FAIL", 2)
    with talk.step("well again, but nobody moves its sticks"):
        talk.set("SIM_RC_FAIL", 0)
        talk.rest(3)
    with talk.step("to MANUAL again"):
        talk.mode(MANUAL)


def override(talk, roll=ALONE, pitch=ALONE, throttle=ALONE, rudder=ALONE, beats=1):
    end = talk.beats + beats
    while talk.beats < end:
        talk.mav.rc_channels_override_send(talk.system, talk.component, roll, pitch, throttle, rudder, *[ALONE] * 4)
        talk.hear()


@scene
def sticks_and_arming(talk):
    for name, stick in (("roll", "roll"), ("pitch", "pitch"), ("throttle", "throttle"), ("rudder", "rudder")):
        override(talk, **{stick: 1700})
        with talk.step(f"armed with the {name} held"):
            talk.arm()
        override(talk, **{stick: 1000 if stick == "throttle" else 1500})
        talk.rest(4)
    for value in range(3):
        talk.set("ARMING_RUDDER", value)
        with talk.step(f"ARMING_RUDDER {value}, to the right"):
            override(talk, throttle=1000, rudder=2000, beats=6)
        override(talk, rudder=1500, beats=2)
        with talk.step(f"ARMING_RUDDER {value}, to the left"):
            override(talk, throttle=1000, rudder=1000, beats=6)
        override(talk, rudder=1500, beats=2)
        talk.arm(False)
        talk.settle()


@scene
def commands_on_the_way(talk):
    talk.take_off()
    servo, relay = mavlink.MAV_CMD_DO_SET_SERVO, mavlink.MAV_CMD_DO_SET_RELAY
    upload(
        talk,
        "a mission",
        [
            talk.item(WAYPOINT),
            talk.item(WAYPOINT, 300, 0, p2=RADIUS_M),
            talk.item(servo, p1=6, p2=1500),
            talk.item(mavlink.MAV_CMD_DO_CHANGE_SPEED, p1=0, p2=14),
            talk.item(relay, p1=0, p2=1),
            talk.item(WAYPOINT, 300, 300, p2=RADIUS_M),
            talk.item(mavlink.MAV_CMD_CONDITION_DELAY, p1=3),
            talk.item(mavlink.MAV_CMD_DO_CHANGE_SPEED, p1=0, p2=16),
            talk.item(WAYPOINT, -200, 300, p2=RADIUS_M),
            talk.item(mavlink.MAV_CMD_CONDITION_DELAY, p1=500),
            talk.item(mavlink.MAV_CMD_DO_CHANGE_SPEED, p1=0, p2=12),
            talk.item(WAYPOINT, -200, 0, p2=RADIUS_M),
            talk.item(mavlink.MAV_CMD_CONDITION_DISTANCE, p1=150),
            talk.item(mavlink.MAV_CMD_DO_CHANGE_SPEED, p1=0, p2=15),
            talk.item(600, p1=7),
            talk.item(WAYPOINT, 200, 0, p2=RADIUS_M),
            talk.item(mavlink.MAV_CMD_DO_JUMP, p1=11, p2=1),
            talk.item(mavlink.MAV_CMD_NAV_LOITER_UNLIM, 200, 200),
        ],
    )
    for name, seq, beats in (("first", 1, 120), ("second", 5, 120), ("third", 8, 150), ("fourth", 11, 120)):
        with talk.step(f"to the {name} place", until=lambda seq=seq: f"reached {seq}" in talk.progress, beats=beats):
            if seq == 1:
                talk.mode(AUTO)
    with talk.step("round once and to the end", until=lambda: "current 17" in talk.progress, beats=400):
        pass
