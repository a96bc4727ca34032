"""Writes the parameters of a real autopilot as the simulated ones have them at the start: `firmware/*/stock.params` of
sim-vehicle, in QGroundControl's form.

    python tests/stock_parameters.py tcp:127.0.0.1:5762 "ArduPlane 4.7.0-dev, as its simulator has them" > FILE

The simulator should be new, at the start place that is its own, and not armed.
"""

import os
import struct
import sys
import textwrap
from datetime import date

os.environ["MAVLINK20"] = "1"

from lists import Lists
from pymavlink import mavutil
from pymavlink.dialects.v20 import ardupilotmega as mavlink

REAL32 = mavlink.MAV_PARAM_TYPE_REAL32


def listed(link):
    """Every parameter by its index, once its values have come to rest."""
    heartbeat = None
    while heartbeat is None:
        link.mav.heartbeat_send(mavlink.MAV_TYPE_GCS, mavlink.MAV_AUTOPILOT_INVALID, 0, 0, 0)
        heartbeat = link.recv_match(type="HEARTBEAT", blocking=True, timeout=1)
    system = heartbeat.get_srcSystem()
    lists = Lists(link, [system])
    lists.fetch()
    found = lists.found[system]
    return heartbeat.autopilot, [found[index] for index in sorted(found)]


def value(message, is_px4):
    """In digits that give the same number in single precision; a PX4 has whole numbers by their bytes."""
    if message.param_type == REAL32:
        digits = next(
            digits for digits in range(6, 10) if single(f"{message.param_value:.{digits}g}") == message.param_value
        )
        return f"{message.param_value:.{digits}g}"
    if is_px4:
        return str(struct.unpack("<i", struct.pack("<f", message.param_value))[0])
    return str(int(message.param_value))


def single(text):
    return struct.unpack("<f", struct.pack("<f", float(text)))[0]


if __name__ == "__main__":
    address, source = sys.argv[1:]
    autopilot, messages = listed(mavutil.mavlink_connection(address))
    head = f"The parameters of {source}. Facts, recorded over MAVLink by tests/stock_parameters.py on {date.today()}."
    print(textwrap.fill(head, 120, initial_indent="# ", subsequent_indent="# "))
    print("#\n# system\tcomponent\tname\tvalue\ttype")
    for message in messages:
        own = value(message, autopilot == mavlink.MAV_AUTOPILOT_PX4)
        print(f"1\t1\t{message.param_id}\t{own}\t{message.param_type}")
