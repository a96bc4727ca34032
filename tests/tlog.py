"""A flight as its log tells it."""

import math

from ground import Sample
from pymavlink import mavutil

GROUND = 255


def messages(path):
    """Every message of a log, in order."""
    log = mavutil.mavlink_connection(str(path))
    try:
        while (message := log.recv_match()) is not None:
            yield message
    finally:
        log.close()


def tracks(path):
    """Every vehicle's samples by system id and time_boot_ms. What was sent again is read once."""
    by_vehicle = {}
    for message in messages(path):
        if message.get_type() == "LOCAL_POSITION_NED":
            track = by_vehicle.setdefault(message.get_srcSystem(), {})
            track[message.time_boot_ms] = Sample.of(message)
    return by_vehicle


def velocity(at):
    return at.speed_mps * math.cos(at.course_rad), at.speed_mps * math.sin(at.course_rad)
