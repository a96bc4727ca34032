"""Scenes of what parameters change of modes: how a return begins, what the throttle and the pitch stick mean."""

import math

from differential import METRES_PER_DEGREE, scene
from pilot_scenes import override
from pymavlink.dialects.v20 import ardupilotmega as mavlink

CRUISE, RTL, LOITER = 7, 11, 12
CLIMB_BEFORE_TURN, CENTRED_IS_CRUISE, ALWAYS_CRUISE, LOITER_BY_STICK = 1 << 4, 1 << 1, 1 << 3, 1 << 12


def distance_m(talk):
    """How far it is from home."""
    position = talk.newest["GLOBAL_POSITION_INT"]
    lat, lon = talk.home
    north_m = (position.lat / 1e7 - lat) * METRES_PER_DEGREE
    east_m = (position.lon / 1e7 - lon) * METRES_PER_DEGREE * math.cos(math.radians(lat))
    return math.hypot(north_m, east_m)


def fly_away(talk, to_m):
    """Straight on until it is so far from home, with no note of it."""
    talk.mode(CRUISE)
    talk.settle()
    assert talk.wait_for(lambda: distance_m(talk) > to_m, 200), "it does not fly away"
    talk.forget()


def returns(talk, name, climb_m):
    """RTL, until it is so much higher: whether it has come nearer."""
    fly_away(talk, 500)
    away_m, height_m = distance_m(talk), talk.height()
    with talk.step(name):
        talk.mode(RTL)
        talk.wait_for(lambda: talk.height() > height_m + climb_m, 120)
        talk.answers.append("farther away" if distance_m(talk) > away_m else "nearer")
    with talk.step(f"{name}: home"):
        talk.wait_for(lambda: distance_m(talk) < 200, 200)
        talk.rest(20)
        talk.answers.append(f"at {10 * round(talk.height() / 10)} m")


@scene
def returns_that_climb_first(talk):
    talk.set("RTL_ALTITUDE", 100)
    talk.take_off()
    returns(talk, "a return", 30)
    talk.set("FLIGHT_OPTIONS", CLIMB_BEFORE_TURN)
    talk.set("RTL_ALTITUDE", 150)
    returns(talk, "a return that climbs before it turns", 40)
    talk.set("FLIGHT_OPTIONS", 0)
    talk.set("RTL_ALTITUDE", 100)
    talk.set("RTL_CLIMB_MIN", 30)
    returns(talk, "a return from above that climbs first", 28)


@scene
def speeds_by_the_throttle(talk):
    for name in ("AIRSPEED_MIN", "AIRSPEED_MAX"):
        talk.read(name)
    talk.settle()
    least, most = (talk.newest_value(name) for name in ("AIRSPEED_MIN", "AIRSPEED_MAX"))
    cruise = least + 0.7 * (most - least)
    talk.set("AIRSPEED_CRUISE", cruise)
    talk.take_off()
    speeds = {
        "half way between the least and the greatest": (least + most) / 2,
        "cruise": cruise,
        "half way from the least to cruise": (least + cruise) / 2,
        "half way from cruise to the greatest": (cruise + most) / 2,
    }
    talk.mode(CRUISE)
    for options in (0, CENTRED_IS_CRUISE, ALWAYS_CRUISE):
        talk.set("FLIGHT_OPTIONS", options)
        for throttle in (1500, 1250, 1750):
            with talk.step(f"the throttle at {throttle} with options {options}"):
                override(talk, throttle=throttle, beats=40)
                airspeed = talk.newest["VFR_HUD"].airspeed
                talk.answers.append(min(speeds, key=lambda name: abs(speeds[name] - airspeed)))


@scene
def an_altitude_in_loiter_by_the_stick(talk):
    talk.take_off()
    for options in (0, LOITER_BY_STICK):
        talk.set("FLIGHT_OPTIONS", options)
        talk.settle()
        for pitch in (1900, 1500, 1100):
            talk.rest(5)
            before_m = talk.height()
            with talk.step(f"the pitch stick at {pitch} with options {options}"):
                override(talk, pitch=pitch, beats=10)
                by_m = talk.height() - before_m
                talk.answers.append("climbs" if by_m > 8 else "sinks" if by_m < -8 else "holds")
        override(talk, pitch=0)


@scene
def a_parachute(talk):
    PARACHUTE = mavlink.MAV_CMD_DO_PARACHUTE
    with talk.step("released where there is none"):
        talk.long(PARACHUTE, 2)
    talk.take_off()
    with talk.step("released where there is none, in the air"):
        talk.long(PARACHUTE, 2)
    with talk.step("enabled"):
        talk.long(PARACHUTE, 1)
    with talk.step("disabled, and released"):
        talk.long(PARACHUTE, 0)
        talk.long(PARACHUTE, 2)
    with talk.step("enabled again"):
        talk.long(PARACHUTE, 1)
    with talk.step("its parameter"):
        talk.read("CHUTE_ENABLED")
    with talk.step("released"):
        talk.long(PARACHUTE, 2)
    with talk.step("released again"):
        talk.long(PARACHUTE, 2)
    with talk.step("enabled after it"):
        talk.long(PARACHUTE, 1)
    with talk.step("armed again"):
        talk.arm()
