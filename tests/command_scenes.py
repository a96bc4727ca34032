"""The scenes of commands: arming, modes, what is told in GUIDED, and every command there is."""

from differential import MISSION, scene
from pymavlink.dialects.v20 import ardupilotmega as mavlink

MANUAL, FBWA, CRUISE, AUTO, RTL, LOITER, GUIDED = 0, 5, 7, 10, 11, 12, 15
SPEED, ALTITUDE, HEADING = (
    mavlink.MAV_CMD_GUIDED_CHANGE_SPEED,
    mavlink.MAV_CMD_GUIDED_CHANGE_ALTITUDE,
    mavlink.MAV_CMD_GUIDED_CHANGE_HEADING,
)
WAYPOINT, REPOSITION = mavlink.MAV_CMD_NAV_WAYPOINT, mavlink.MAV_CMD_DO_REPOSITION
FRAMES = {
    "GLOBAL": 0,
    "LOCAL_NED": 1,
    "MISSION": 2,
    "GLOBAL_RELATIVE_ALT": 3,
    "GLOBAL_INT": 5,
    "GLOBAL_RELATIVE_ALT_INT": 6,
    "BODY_NED": 8,
    "GLOBAL_TERRAIN_ALT": 10,
    "GLOBAL_TERRAIN_ALT_INT": 11,
    "99": 99,
}
# Inside everybody's limits; below everybody's; above everybody's.
FAIR_MPS, SLOW_MPS, FAST_MPS = 12, 4, 40


@scene
def arming(talk):
    with talk.step("disarm when disarmed"):
        talk.arm(False)
    with talk.step("neither arm nor disarm"):
        talk.long(mavlink.MAV_CMD_COMPONENT_ARM_DISARM, 2)
    with talk.step("a mission is begun unarmed"):
        talk.long(mavlink.MAV_CMD_MISSION_START)
    with talk.step("back to MANUAL"):
        talk.mode(MANUAL)
    with talk.step("arm"):
        talk.arm()
    with talk.step("arm when armed"):
        talk.arm()
    with talk.step("disarm on the ground"):
        talk.arm(False)
    with talk.step("arm with force"):
        talk.arm(True, 2989)
    with talk.step("disarm with force"):
        talk.arm(False, 21196)
    with talk.step("arm by COMMAND_INT"):
        talk.int(mavlink.MAV_CMD_COMPONENT_ARM_DISARM, 1)
    with talk.step("disarm by COMMAND_INT"):
        talk.int(mavlink.MAV_CMD_COMPONENT_ARM_DISARM, 0)
    with talk.step("ask for the checks"):
        talk.long(mavlink.MAV_CMD_RUN_PREARM_CHECKS)
    for number, name in ((FBWA, "FBWA"), (CRUISE, "CRUISE"), (LOITER, "LOITER"), (RTL, "RTL"), (GUIDED, "GUIDED")):
        with talk.step(f"to {name}"):
            talk.mode(number)
        with talk.step(f"arm in {name}"):
            talk.arm()
        with talk.step(f"disarm in {name}"):
            talk.arm(False)
    with talk.step("to AUTO"):
        talk.mode(AUTO)
    with talk.step("arm in AUTO without a mission"):
        talk.arm()
    with talk.step("disarm in AUTO"):
        talk.arm(False)
    with talk.step("to MANUAL"):
        talk.mode(MANUAL)
    with talk.step("for another component"):
        talk.long(mavlink.MAV_CMD_COMPONENT_ARM_DISARM, 1, component=99)


@scene
def modes_on_the_ground(talk):
    for number in (*range(28), 255):
        with talk.step(f"mode {number}"):
            talk.mode(number)
    with talk.step("without the flag of custom modes"):
        talk.long(mavlink.MAV_CMD_DO_SET_MODE, 0, FBWA)
    with talk.step("with other flags too"):
        talk.long(mavlink.MAV_CMD_DO_SET_MODE, 217, FBWA)
    with talk.step("by COMMAND_INT"):
        talk.int(mavlink.MAV_CMD_DO_SET_MODE, 1, CRUISE)
    with talk.step("by SET_MODE"):
        talk.mav.set_mode_send(talk.system, 1, LOITER)
    with talk.step("by SET_MODE, one that is not there"):
        talk.mav.set_mode_send(talk.system, 1, 99)
    with talk.step("a broken number"):
        talk.long(mavlink.MAV_CMD_DO_SET_MODE, 1, 5.5)


@scene
def modes_in_the_air(talk):
    talk.take_off()
    for number in (*range(28), 255):
        with talk.step(f"mode {number}"):
            talk.mode(number)
        talk.mode(LOITER)
        talk.settle()
    with talk.step("the mode that it has"):
        talk.mode(LOITER)
    with talk.step("disarm in the air"):
        talk.arm(False)
    with talk.step("arm in the air"):
        talk.arm()


def guided_commands(talk, where):
    """Each guided command, good and bad, as it is answered here."""
    for name, params in {
        "speed": (0, FAIR_MPS),
        "speed too slow": (0, SLOW_MPS),
        "speed too fast": (0, FAST_MPS),
        "speed over ground": (1, FAIR_MPS),
        "speed of another kind": (2, FAIR_MPS),
        "speed at a rate": (0, 11, 0.5),
        "speed below zero": (0, -5),
    }.items():
        with talk.step(f"{where}: {name}"):
            talk.int(SPEED, *params)
    with talk.step(f"{where}: speed by COMMAND_LONG"):
        talk.long(SPEED, 0, FAIR_MPS)
    for name, params in {
        "course": (0, 90, 10),
        "heading": (1, 45, 10),
        "neither any more": (2, 0, 0),
        "course of a full circle": (0, 360, 10),
        "course below zero": (0, -1, 10),
        "course of another kind": (3, 90, 10),
        "course 359.9": (0, 359.9, 10),
    }.items():
        with talk.step(f"{where}: {name}"):
            talk.int(HEADING, *params)
    with talk.step(f"{where}: course by COMMAND_LONG"):
        talk.long(HEADING, 0, 180, 10)
    for name, frame in FRAMES.items():
        with talk.step(f"{where}: altitude in frame {name}"):
            talk.int(ALTITUDE, z=70, frame=frame)
    for z in (-1, 5000):
        with talk.step(f"{where}: altitude {z} m"):
            talk.int(ALTITUDE, z=z)
    with talk.step(f"{where}: altitude by COMMAND_LONG"):
        talk.long(ALTITUDE, 0, 0, 0, 0, 0, 0, 65)


@scene
def guided_commands_on_the_ground(talk):
    guided_commands(talk, "on the ground")


@scene
def guided_commands_in_the_air(talk):
    talk.take_off()
    guided_commands(talk, "in LOITER")
    with talk.step("to GUIDED"):
        talk.mode(GUIDED)
    guided_commands(talk, "in GUIDED")


@scene
def reposition(talk):
    where = talk.place(150, 150)
    with talk.step("on the ground"):
        talk.int(REPOSITION, -1, 0, 0, 0, *where, 60)
    talk.take_off()
    with talk.step("in LOITER, without leave to change the mode"):
        talk.int(REPOSITION, -1, 0, 0, 0, *where, 60)
    with talk.step("in LOITER, by COMMAND_LONG"):
        talk.long(REPOSITION, -1, 1, 0, 0, where[0] / 1e7, where[1] / 1e7, 60)
    with talk.step("in LOITER, with leave"):
        talk.int(REPOSITION, -1, 1, 0, 0, *where, 60)
    with talk.step("in GUIDED"):
        talk.int(REPOSITION, -1, 0, 0, 0, *where, 70)
    for name, frame in FRAMES.items():
        with talk.step(f"in frame {name}"):
            talk.int(REPOSITION, -1, 0, 0, 0, *where, 70, frame)
    with talk.step("a latitude that is none"):
        talk.int(REPOSITION, -1, 0, 0, 0, 910_000_000, where[1], 60)
    with talk.step("a longitude that is none"):
        talk.int(REPOSITION, -1, 0, 0, 0, where[0], 1_810_000_000, 60)
    with talk.step("where it is: latitude and longitude of zero"):
        talk.int(REPOSITION, -1, 0, 0, 0, 0, 0, 60)
    with talk.step("with a radius"):
        talk.int(REPOSITION, -1, 0, 90, 0, *where, 60)
    with talk.step("with a speed"):
        talk.int(REPOSITION, FAIR_MPS, 0, 0, 0, *where, 60)
    with talk.step("anticlockwise"):
        talk.int(REPOSITION, -1, 0, 90, 1, *where, 60)
    with talk.step("by a mission item that is current 2"):
        frame, command, params, place, z = talk.item(WAYPOINT, 100, 100)
        talk.mav.mission_item_int_send(
            talk.system, talk.component, 0, frame, command, 2, 1, *params, *place, z, MISSION
        )
    with talk.step("altitude by a mission item that is current 3"):
        talk.mav.mission_item_int_send(
            talk.system, talk.component, 0, frame, command, 3, 1, *params, *place, z, MISSION
        )


@scene
def commands_in_the_air(talk):
    talk.take_off()
    change_speed, change_altitude = mavlink.MAV_CMD_DO_CHANGE_SPEED, mavlink.MAV_CMD_DO_CHANGE_ALTITUDE
    for mode, word in ((LOITER, "LOITER"), (GUIDED, "GUIDED")):
        with talk.step(f"to {word}"):
            talk.mode(mode)
        for name, params in {
            "airspeed": (0, FAIR_MPS, -1),
            "ground speed": (1, FAIR_MPS, -1),
            "climb speed": (2, 3, -1),
            "airspeed too fast": (0, FAST_MPS, -1),
            "airspeed too slow": (0, SLOW_MPS, -1),
            "throttle": (0, -1, 60),
            "the default": (0, -2, -1),
            "no change": (0, -1, -1),
        }.items():
            with talk.step(f"{word}: DO_CHANGE_SPEED, {name}"):
                talk.long(change_speed, *params)
        with talk.step(f"{word}: DO_CHANGE_SPEED by COMMAND_INT"):
            talk.int(change_speed, 0, FAIR_MPS, -1)
        for name, frame in FRAMES.items():
            with talk.step(f"{word}: DO_CHANGE_ALTITUDE in frame {name}"):
                talk.int(change_altitude, 70, frame)
        with talk.step(f"{word}: DO_CHANGE_ALTITUDE by COMMAND_LONG"):
            talk.long(change_altitude, 70, mavlink.MAV_FRAME_GLOBAL_RELATIVE_ALT)
    for name, command, params in (
        ("NAV_TAKEOFF", mavlink.MAV_CMD_NAV_TAKEOFF, (0, 0, 0, 0, 0, 0, 50)),
        ("NAV_LAND", mavlink.MAV_CMD_NAV_LAND, ()),
        ("NAV_LOITER_UNLIM", mavlink.MAV_CMD_NAV_LOITER_UNLIM, ()),
        ("NAV_RETURN_TO_LAUNCH", mavlink.MAV_CMD_NAV_RETURN_TO_LAUNCH, ()),
        ("DO_LAND_START without one", mavlink.MAV_CMD_DO_LAND_START, ()),
        ("DO_GO_AROUND", mavlink.MAV_CMD_DO_GO_AROUND, ()),
        ("MISSION_START without a mission", mavlink.MAV_CMD_MISSION_START, ()),
        ("DO_SET_MISSION_CURRENT without a mission", mavlink.MAV_CMD_DO_SET_MISSION_CURRENT, (3,)),
        ("DO_PAUSE_CONTINUE", mavlink.MAV_CMD_DO_PAUSE_CONTINUE, ()),
        ("PREFLIGHT_CALIBRATION", mavlink.MAV_CMD_PREFLIGHT_CALIBRATION, (1,)),
        ("PREFLIGHT_REBOOT_SHUTDOWN", mavlink.MAV_CMD_PREFLIGHT_REBOOT_SHUTDOWN, (1,)),
        ("DO_FLIGHTTERMINATION of zero", mavlink.MAV_CMD_DO_FLIGHTTERMINATION, (0,)),
        ("CONDITION_YAW", mavlink.MAV_CMD_CONDITION_YAW, (90,)),
        ("DO_ORBIT", mavlink.MAV_CMD_DO_ORBIT, (50,)),
    ):
        with talk.step(name):
            talk.long(command, *params)


@scene
def every_command(talk):
    """On the ground, all parameters 0, in both messages; not those that start something long, or end the simulator."""
    left_out = {
        mavlink.MAV_CMD_DO_CHANGE_ALTITUDE,
        mavlink.MAV_CMD_DO_START_MAG_CAL,
        mavlink.MAV_CMD_FIXED_MAG_CAL_YAW,
        mavlink.MAV_CMD_DO_MOTOR_TEST,
        mavlink.MAV_CMD_ACCELCAL_VEHICLE_POS,
        mavlink.MAV_CMD_DO_SEND_BANNER,
        mavlink.MAV_CMD_FLASH_BOOTLOADER,
        mavlink.MAV_CMD_PREFLIGHT_CALIBRATION,
        mavlink.MAV_CMD_DO_SET_HOME,
        mavlink.MAV_CMD_REQUEST_MESSAGE,
        # It depends on whether scripts were built in.
        mavlink.MAV_CMD_DO_FOLLOW,
    }
    for number in sorted(mavlink.enums["MAV_CMD"]):
        name = mavlink.enums["MAV_CMD"][number].name.removeprefix("MAV_CMD_")
        if number in left_out or name == "ENUM_END" or name.startswith(("WAYPOINT_USER", "SPATIAL_USER", "USER_")):
            continue
        with talk.step(name):
            talk.long(number)
            talk.int(number)
        talk.mode(MANUAL)
        talk.settle()
    with talk.step("one that nobody knows"):
        talk.long(59_999, 1, 2)
    with talk.step("one that nobody knows, by COMMAND_INT"):
        talk.int(59_999, 1, 2)
