"""A `.plan` file of QGroundControl as it sends it: mission, fence and rally points as items to upload.

<https://docs.qgroundcontrol.com/master/en/qgc-dev-guide/file_formats/plan.html>. A param that is null is NaN; surveys
and their kin have their items within; an ArduPlane gets home as item 0, and jumps lead to the items that were meant."""

import math
from dataclasses import dataclass

from pymavlink.dialects.v20 import ardupilotmega as mavlink

GLOBAL, RELATIVE = mavlink.MAV_FRAME_GLOBAL, mavlink.MAV_FRAME_GLOBAL_RELATIVE_ALT
PLACED = (GLOBAL, RELATIVE)
INT32_MIN = -(2**31)


@dataclass(frozen=True)
class Item:
    command: int
    frame: int
    params: tuple
    goes_on: bool = True

    def send(self, link, system, seq, plan):
        params = [math.nan if param is None else param for param in self.params]
        scale = 1e7 if self.frame in PLACED else 1
        # What is no number becomes the least whole one, as a C++ program makes it on x86.
        x, y = (INT32_MIN if math.isnan(param) else round(param * scale) for param in params[4:6])
        link.mav.mission_item_int_send(
            system, 1, seq, self.frame, self.command, int(seq == 0), int(self.goes_on),
            *params[:4], x, y, params[6], plan,
        )  # fmt: skip


def mission(file, has_home):
    plan = file["mission"]
    rows = []
    for row in plan["items"]:
        rows += row["TransectStyleComplexItem"]["Items"] if "TransectStyleComplexItem" in row else [row]
    seq_of = {row["doJumpId"]: seq + has_home for seq, row in enumerate(rows)}
    items = [Item(mavlink.MAV_CMD_NAV_WAYPOINT, GLOBAL, (0, 0, 0, 0, *plan["plannedHomePosition"]))] if has_home else []
    for row in rows:
        params = list(row["params"])
        if row["command"] == mavlink.MAV_CMD_DO_JUMP:
            params[0] = seq_of[params[0]]
        items.append(Item(row["command"], row["frame"], tuple(params), row["autoContinue"]))
    return items


def fence(file):
    items = []
    for polygon in file["geoFence"]["polygons"]:
        corners = polygon["polygon"]
        command = mavlink.MAV_CMD_NAV_FENCE_POLYGON_VERTEX_INCLUSION + (not polygon["inclusion"])
        items += [Item(command, GLOBAL, (len(corners), 0, 0, 0, *corner, 0), False) for corner in corners]
    for circle in file["geoFence"]["circles"]:
        command = mavlink.MAV_CMD_NAV_FENCE_CIRCLE_INCLUSION + (not circle["inclusion"])
        place, radius_m = circle["circle"]["center"], circle["circle"]["radius"]
        items.append(Item(command, GLOBAL, (radius_m, 0, 0, 0, *place, 0), False))
    if "breachReturn" in file["geoFence"]:
        place = file["geoFence"]["breachReturn"]
        items.append(Item(mavlink.MAV_CMD_NAV_FENCE_RETURN_POINT, RELATIVE, (0, 0, 0, 0, *place), False))
    return items


def rally(file):
    points = file["rallyPoints"]["points"]
    return [Item(mavlink.MAV_CMD_NAV_RALLY_POINT, RELATIVE, (0, 0, 0, 0, *point)) for point in points]


def upload(craft, items, plan):
    """The result of an upload: with the item that was asked for last where it is refused."""
    link, system = craft.link, craft.system
    link.mav.mission_count_send(system, 1, len(items), plan)
    asked = 0
    while True:
        kinds = ["MISSION_REQUEST", "MISSION_REQUEST_INT", "MISSION_ACK"]
        message = craft.wait(kinds, lambda message: message.mission_type == plan)
        if message.get_type() == "MISSION_ACK":
            return (message.type, asked) if message.type else 0
        asked = message.seq
        items[asked].send(link, system, asked, plan)
