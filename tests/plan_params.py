"""What a PX4 answers to every param of every item that it flies, to fences and rally points, and to parameters that are
asked for and set in odd ways.

    python tests/plan_params.py udpout:127.0.0.1:18570 [ANSWERS.json]

The vehicle stands on the ground, disarmed, fresh from its start. The labels are those of
`reference/plan-params-px4.json`, which a real one gave. `test_params.py` compares.
"""

import math
import struct
import sys

from params import tell
from pymavlink import mavutil
from pymavlink.dialects.v20 import all as mavlink
from sweep import Sweep, item

FLOWN = (
    16, 17, 19, 20, 21, 22, 31, 80, 84, 85, 93, 112, 114, 176, 177, 178, 179, 187, 189, 195, 196, 197, 200, 201, 203,
    204, 205, 206, 211, 212, 214, 260, 420, 530, 531, 532, 534, 1000, 1001, 2000, 2001, 2003, 2500, 2501, 3000, 4501,
    42600,
)  # fmt: skip
FIELDS = ("p1", "p2", "p3", "p4", "x", "y", "z")
# A param that leaves it out is the last one of each row.
VALUES = dict.fromkeys(FIELDS, (1.0, -1.0, math.nan)) | dict.fromkeys(("x", "y"), (7, 0x7FFF_FFFF))
FENCE, RALLY = mavlink.MAV_MISSION_TYPE_FENCE, mavlink.MAV_MISSION_TYPE_RALLY
INSIDE, OUTSIDE, ROUND_IN, ROUND_OUT, RETURN_POINT = 5001, 5002, 5003, 5004, 5000
CORNERS = ((5000, -5000), (5000, 5000), (-5000, 5000), (-5000, -5000))
REAL32, INT32 = mavlink.MAV_PARAM_TYPE_REAL32, mavlink.MAV_PARAM_TYPE_INT32
# Name, index.
READS = [
    ("MAV_SYS_ID", -1), ("NAV_ACC_RAD", -1), ("nav_acc_rad", -1), ("NOT_THERE", -1), ("", 0), ("NAV_ACC_RAD", 32_000),
]  # fmt: skip
# Name, value, type, and whether the value is a whole number by its bytes.
WRITES = [
    ("NAV_ACC_RAD", 12.5, REAL32, False), ("NAV_ACC_RAD", 12, INT32, True), ("NAV_ACC_RAD", math.nan, REAL32, False),
    ("NAV_ACC_RAD", -5.0, REAL32, False), ("NAV_ACC_RAD", 1e6, REAL32, False), ("NAV_ACC_RAD", 10.0, REAL32, False),
    ("NAV_DLL_ACT", 2, INT32, True), ("NAV_DLL_ACT", 2.0, REAL32, False), ("NAV_DLL_ACT", 99, INT32, True),
    ("NAV_DLL_ACT", -3, INT32, True), ("NAV_DLL_ACT", 0, INT32, True),
    ("NAV_DLL_ACT", 1, mavlink.MAV_PARAM_TYPE_INT8, True), ("NOT_THERE", 1.0, REAL32, False),
    ("nav_acc_rad", 11.0, REAL32, False), ("RTL_RETURN_ALT", 100.0, REAL32, False),
    ("RTL_RETURN_ALT", -1.0, REAL32, False), ("RTL_RETURN_ALT", 60.0, REAL32, False), ("GF_ACTION", 4, INT32, True),
    ("GF_ACTION", 6, INT32, True), ("GF_ACTION", 2, INT32, True), ("MIS_TKO_LAND_REQ", 9, INT32, True),
    ("MIS_TKO_LAND_REQ", 2, INT32, True), ("FW_AIRSPD_MAX", 0.5, REAL32, False),
    ("FW_AIRSPD_MAX", 20.0, REAL32, False), ("FW_AIRSPD_TRIM", 500.0, REAL32, False),
    ("FW_AIRSPD_TRIM", 15.0, REAL32, False), ("MIS_TAKEOFF_ALT", -4.0, REAL32, False),
    ("MIS_TAKEOFF_ALT", 30.0, REAL32, False), ("COM_OF_LOSS_T", 1000.0, REAL32, False),
    ("COM_OF_LOSS_T", 1.0, REAL32, False),
]  # fmt: skip


def play(link):
    """Plays all of them with the vehicle at the other end of a link: label -> answer, None for silence."""
    return PlanParams(link).play_plans()


class PlanParams(Sweep):
    def play_plans(self):
        latitude, longitude = self.place()
        self.here = latitude, longitude
        for command in FLOWN:
            at = {"x": latitude + 2000, "y": longitude}
            self.answers[f"item {command}"] = self.upload(item(command, **at))
            for field, values in VALUES.items():
                for value in values:
                    self.answers[f"item {command} {field}={value}"] = self.upload(item(command, **at) | {field: value})
        self.fences()
        for READ in READS:
            self.read(*READ)
        for write in WRITES:
            self.write(*write)
        self.link.mav.mission_clear_all_send(self.system, 1, 255)
        return self.answers

    def fences(self):
        def corners(command, count=4, said=None, **fields):
            return [
                self.at(command, north, east, p1=count if said is None else said, **fields)
                for north, east in CORNERS[:count]
            ]

        for label, items in {
            "none": [],
            "four corners": corners(INSIDE),
            "four corners to stay out of": corners(OUTSIDE),
            "two corners": corners(INSIDE, 2),
            "two corners that say three": corners(INSIDE, 2, 3),
            "three corners that say four": corners(INSIDE, 3, 4),
            "four corners that say three": corners(INSIDE, 4, 3),
            "four corners that say 3.5": corners(INSIDE, 4, 3.5),
            "corners of two kinds": corners(INSIDE, 2, 4) + corners(OUTSIDE, 2, 4),
            "a circle": [self.at(ROUND_IN, p1=200)],
            "a circle without radius": [self.at(ROUND_IN, p1=0)],
            "a circle below 0": [self.at(ROUND_IN, p1=-5)],
            "a circle of no number": [self.at(ROUND_IN, p1=math.nan)],
            "a circle to stay out of, far away": [self.at(ROUND_OUT, 90_000, p1=50)],
            "a circle to stay out of, round home": [self.at(ROUND_OUT, p1=50)],
            "a circle that home is outside of": [self.at(ROUND_IN, 90_000, p1=50)],
            "a return point": [self.at(RETURN_POINT)],
            "a waypoint": [self.at(16)],
            "an altitude": corners(INSIDE, z=50.0),
            "above home, by integers": corners(INSIDE, frame=6),
            "a local frame": corners(INSIDE, frame=1),
            "above terrain": corners(INSIDE, frame=10),
            "param 2": corners(INSIDE, p2=1),
            "a circle's param 2": [self.at(ROUND_IN, p1=200, p2=1)],
            "a circle's param 4": [self.at(ROUND_IN, p1=200, p4=1)],
            "a circle's altitude": [self.at(ROUND_IN, p1=200, z=50.0)],
            "nowhere": [self.at(ROUND_IN, p1=200) | {"x": 0x7FFF_FFFF}],
            "more than fit": corners(INSIDE) * 17,
        }.items():
            self.answers[f"fence {label}"] = self.upload_all(items, FENCE)
        for label, items in {
            "one": [self.at(5100, z=50.0)],
            "above sea level": [self.at(5100, z=500.0, frame=0)],
            "by integers": [self.at(5100, z=50.0, frame=6)],
            "above terrain": [self.at(5100, z=50.0, frame=10)],
            "param 1": [self.at(5100, z=50.0, p1=1)],
            "a waypoint": [self.at(16, z=50.0)],
            "no altitude": [self.at(5100, z=math.nan)],
            "33": [self.at(5100, z=50.0)] * 33,
        }.items():
            self.answers[f"rally {label}"] = self.upload_all(items, RALLY)

    def at(self, command, north=0, east=0, z=0.0, **fields):
        return item(command, x=self.here[0] + north, y=self.here[1] + east, z=z) | fields

    def read(self, param, index):
        self.forget()
        self.link.mav.param_request_read_send(self.system, 1, param.encode(), index)
        self.answers[f"read {param!r} {index}"] = self.told(param)

    def write(self, param, value, kind, is_whole):
        number = struct.unpack("<f", struct.pack("<i", value))[0] if is_whole else value
        self.forget()
        self.link.mav.param_set_send(self.system, 1, param.encode(), number, kind)
        self.answers[f"write {param} {value} type {kind}"] = self.told(param)

    def told(self, param):
        """The value that is told, in its own type; of a parameter by its index only that one comes."""
        said = self.wait(["PARAM_VALUE", "PARAM_ERROR"], 0.8, lambda said: said.param_id in (param, "") or not param)
        if said is None:
            return None
        if said.get_type() == "PARAM_ERROR":
            return f"error {said.error}"
        if not param:
            return "a value"
        value = said.param_value
        if said.param_type == INT32:
            value = struct.unpack("<i", struct.pack("<f", value))[0]
        return f"{value:g} type {said.param_type}"


if __name__ == "__main__":
    found = play(mavutil.mavlink_connection(sys.argv[1], source_system=255, source_component=190))
    tell(found, *sys.argv[2:])
