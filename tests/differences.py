"""Where ours answers otherwise than a real ArduPlane: by the sentence of docs/mavlink.md that says so, scenes and
steps.

`test_differential.py` fails at a difference that is not here, and at one here that is no more.
"""

KNOWN = {
    "AVOID_ADSB, LOITER_ALT_QLAND and AUTOLAND are not simulated.": {
        "modes on the ground": ["mode 14", "mode 25"],
        "modes in the air": ["mode 14", "mode 25", "mode 26"],
    },
    "PROTOCOL_VERSION, CURRENT_MODE, ALTITUDE, ODOMETRY, PING and WIND_COV are answered.": {
        "connection": [
            "asked for PROTOCOL_VERSION",
            "asked for WIND_COV",
            "asked for CURRENT_MODE",
            "asked for ALTITUDE",
            "asked for ODOMETRY",
            "the older request for the protocol's version",
            "PING",
        ],
    },
    "Nothing warns of a safety switch or of scripts that are not there.": {
        "every command": ["DO_SET_SAFETY_SWITCH_STATE", "SCRIPTING"],
    },
    "Some warnings of ArduPlane are not there: of older messages and of terrain.": {
        "every command": ["one that nobody knows"],
        "missions": ["one item, by the older message"],
        "mission items": ["in frame GLOBAL_TERRAIN_ALT"],
    },
    "PARAM_VALUE has the type of the parameter; ArduPlane answers a PARAM_SET that changes nothing in the type "
    "that it came with.": {
        "value sets": ["BATT_FS_LOW_ACT 0", "BATT_FS_CRT_ACT 0", "FENCE_AUTOENABLE 0"],
    },
    "Sticks are not mixed into modes that fly by themselves (STICK_MIXING).": {
        "an altitude in loiter by the stick": ["the pitch stick at * with options 0"],
    },
    "FENCE_AUTOENABLE 1 is taken without a warning.": {
        "value sets": ["FENCE_AUTOENABLE 1"],
    },
    "MISSION_CURRENT is the item that is flown, never home, and every item that is flown is reached once, "
    "NAV_LAND on the ground too.": {
        "missions": ["current is 0", "nothing at all", "clear"],
        "mission commands": ["start", "start when started", "current is 0"],
        "a whole flight": [
            "disarm in the air",
            "to the last waypoint",
            "down, and disarmed",
        ],
    },
    "An upload that stops is given up after 8 s of the clock on the wall, at any speed of the simulation, and a "
    "gap is asked for again after 0.4 s.": {
        "missions": ["an upload that stops", "an upload with a gap", "an upload that is cancelled"],
    },
    "An upload that is refused or given up leaves the plan before it whole; ArduPlane cuts the old one at its "
    "beginning.": {
        "missions": ["after it the one before is there, or not"],
        "rally points": ["and back: a waypoint", "and back: a latitude that is none"],
    },
    "NAV_ALTITUDE_WAIT, NAV_VTOL_TAKEOFF, NAV_VTOL_LAND, NAV_PAYLOAD_PLACE and NAV_SET_YAW_SPEED are "
    "UNSUPPORTED in missions.": {
        "mission items": [
            "with NAV_ALTITUDE_WAIT",
            "with NAV_VTOL_TAKEOFF",
            "with NAV_VTOL_LAND",
            "with NAV_PAYLOAD_PLACE",
            "with NAV_SET_YAW_SPEED",
        ],
    },
    "A fence of fewer than three corners and circles stays; ArduPlane 4.7-dev loses it when it replaces a "
    "larger one.": {
        "fences": ["and back: a circle to keep in"],
    },
    "MISSION_CLEAR_ALL of type 255 clears everything; ArduPlane says UNSUPPORTED.": {
        "fences": ["all kinds cleared"],
    },
    "The capabilities are those that are there: no files, terrain or calibration, but local setpoints.": {
        "connection": ["its capabilities"],
    },
    "MISSION_CURRENT is never behind the end of the mission on board.": {
        "current items": ["a shorter mission", "cleared"],
    },
    "WP_RADIUS is 15 m at first.": {
        "parameters": ["read one"],
    },
    "A parameter that is not there, or a value out of its range, is refused in words; ArduPlane says nothing, "
    "and takes any number.": {
        "parameters": [
            "read one that is not there",
            "read by an index that is not there",
            "set one that is not there",
            "set WP_RADIUS to -5, out of its range",
            "set FS_GCS_ENABL to 9, out of its range",
            "set MAV_GCS_SYSID to 999, out of its range",
            "set TKOFF_ALT to 100000, out of its range",
            "set ROLL_LIMIT_DEG to -1, out of its range",
            "set one that is read only",
        ],
    },
    "Parameters that would change nothing are not there.": {
        "parameters": [
            "set SCHED_LOOP_RATE",
            "read SCHED_LOOP_RATE",
            "set STAB_PITCH_DOWN",
            "read STAB_PITCH_DOWN",
        ],
    },
}
