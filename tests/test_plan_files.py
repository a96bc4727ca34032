"""`.plan` files of QGroundControl, as it sends them, on an ArduPlane and a PX4: taken, or refused as by the real
one."""

import pytest
from plan_file import fence, mission, rally, upload
from plans import FENCE, MISSION, RALLY, place
from pymavlink.dialects.v20 import ardupilotmega as mavlink

INVALID_PARAM3, UNSUPPORTED = mavlink.MAV_MISSION_INVALID_PARAM3, mavlink.MAV_MISSION_UNSUPPORTED
ERROR = mavlink.MAV_MISSION_ERROR
# What an ArduPlane answers, and a PX4; (the result, the item) where it is refused.
TAKEN = (0, 0)


def at(north_m, east_m):
    latitude_e7, longitude_e7 = place(north_m, east_m)
    return latitude_e7 / 1e7, longitude_e7 / 1e7


def simple(number, command, params, frame=3):
    item = {"type": "SimpleItem", "command": command, "frame": frame, "params": params}
    return {**item, "doJumpId": number, "autoContinue": True}


def way(number, north_m, east_m=0, p=(0, 0, 0, None)):
    return simple(number, mavlink.MAV_CMD_NAV_WAYPOINT, [*p, *at(north_m, east_m), 60])


def takeoff(p=(15, 0, 0, None)):
    return simple(1, mavlink.MAV_CMD_NAV_TAKEOFF, [*p, *at(100, 0), 60])


def survey(number):
    trigger = simple(number + 1, mavlink.MAV_CMD_DO_SET_CAM_TRIGG_DIST, [25, 0, 1, 0, 0, 0, 0], 2)
    end = simple(number + 3, mavlink.MAV_CMD_DO_SET_CAM_TRIGG_DIST, [0, 0, 1, 0, 0, 0, 0], 2)
    items = [way(number, 300), trigger, way(number + 2, 300, 300), end]
    return {"type": "ComplexItem", "complexItemType": "survey", "TransectStyleComplexItem": {"Items": items}}


def plan(*items, polygons=(), circles=(), points=(), **fence_too):
    return {
        "fileType": "Plan",
        "mission": {"items": list(items), "plannedHomePosition": [*at(0, 0), 50]},
        "geoFence": {"polygons": list(polygons), "circles": list(circles), **fence_too},
        "rallyPoints": {"points": list(points)},
    }


def polygon(size_m, inclusion=True):
    corners = [at(north_m, east_m) for north_m, east_m in ((-size_m, -size_m), (-size_m, size_m), (size_m, 0))]
    return {"inclusion": inclusion, "polygon": corners}


def circle(radius_m, inclusion=True):
    return {"inclusion": inclusion, "circle": {"center": at(0, 0), "radius": radius_m}}


LANDING = simple(4, mavlink.MAV_CMD_NAV_LAND, [0, 0, 0, None, *at(900, 0), 0])
JUMP = simple(3, mavlink.MAV_CMD_DO_JUMP, [2, 1, 0, 0, 0, 0, 0], 2)
MISSIONS = {
    "a take-off, a waypoint and a landing": (plan(takeoff(), way(2, 400), LANDING), TAKEN),
    "a survey with a camera": (plan(takeoff(), survey(2)), TAKEN),
    "a jump, by the number of its item": (plan(takeoff(), way(2, 400), JUMP, way(4, 500)), TAKEN),
    "a speed and a region of interest": (
        plan(
            takeoff(), simple(2, mavlink.MAV_CMD_DO_CHANGE_SPEED, [1, 12, -1, 0, 0, 0, 0], 2),
            simple(3, mavlink.MAV_CMD_DO_SET_ROI_LOCATION, [0, 0, 0, 0, *at(200, 0), 0]), way(4, 500),
        ),
        TAKEN,
    ),
    "a param that a take-off does not use": (plan(takeoff((15, 0, 1, None)), way(2, 400)), (0, (INVALID_PARAM3, 0))),
    "a servo, of which a PX4 knows nothing": (
        plan(takeoff(), simple(2, mavlink.MAV_CMD_DO_SET_SERVO, [9, 1900, 0, 0, 0, 0, 0], 2), way(3, 400)),
        (0, (UNSUPPORTED, 1)),
    ),
    "a waypoint that is passed by at 30 m": (
        plan(takeoff(), way(2, 400, p=(0, 0, 30, None))), (0, (INVALID_PARAM3, 1)),
    ),
}  # fmt: skip
FENCES = {
    "a polygon to stay in and one to stay out of": (plan(polygons=[polygon(800), polygon(60, False)]), TAKEN),
    "circles": (plan(circles=[circle(900), circle(20, False)]), TAKEN),
    "a polygon with a place to return to": (plan(polygons=[polygon(800)], breachReturn=[*at(50, 0), 60]), TAKEN),
    "a polygon of two corners": (
        plan(polygons=[{"inclusion": True, "polygon": [at(0, 0), at(90, 0)]}]), ((ERROR, 1), (ERROR, 0)),
    ),
}  # fmt: skip


@pytest.mark.parametrize("number, personality", list(enumerate(["arduplane", "px4"])))
def test_plan_files_are_answered_as_by_the_real_one(number, personality, start_vehicles, scenario):
    craft = start_vehicles(scenario(on_ground=True), "--personality", personality).connect()[0]
    answers, expected = {}, {}
    for name, (file, results) in MISSIONS.items():
        items = mission(file, has_home=personality == "arduplane")
        answers[name], expected[name] = upload(craft, items, MISSION), results[number]
    for name, (file, results) in FENCES.items():
        answers[name], expected[name] = upload(craft, fence(file), FENCE), results[number]
    file = plan(points=[[*at(100, 100), 50], [*at(-100, 0), 40]])
    answers["rally"], expected["rally"] = upload(craft, rally(file), RALLY), 0
    assert answers == expected
