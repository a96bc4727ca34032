"""The scenes of the differential run: each on a vehicle fresh from its start, on the ground and disarmed."""

from differential import MISSION, scene
from pymavlink.dialects.v20 import ardupilotmega as mavlink

MANUAL, FBWA, CRUISE, AUTO, RTL, LOITER, GUIDED = 0, 5, 7, 10, 11, 12, 15
SPEED, ALTITUDE, HEADING = (
    mavlink.MAV_CMD_GUIDED_CHANGE_SPEED,
    mavlink.MAV_CMD_GUIDED_CHANGE_ALTITUDE,
    mavlink.MAV_CMD_GUIDED_CHANGE_HEADING,
)
WAYPOINT, REPOSITION, HOME, INTERVAL = (
    mavlink.MAV_CMD_NAV_WAYPOINT,
    mavlink.MAV_CMD_DO_REPOSITION,
    mavlink.MAV_CMD_DO_SET_HOME,
    mavlink.MAV_CMD_SET_MESSAGE_INTERVAL,
)
FRAMES = {
    "GLOBAL": 0, "LOCAL_NED": 1, "MISSION": 2, "GLOBAL_RELATIVE_ALT": 3, "GLOBAL_INT": 5, "GLOBAL_RELATIVE_ALT_INT": 6,
    "BODY_NED": 8, "GLOBAL_TERRAIN_ALT": 10, "GLOBAL_TERRAIN_ALT_INT": 11, "99": 99,
}  # fmt: skip
# Messages that pymavlink's dialect does not have.
NUMBERS = {
    "PROTOCOL_VERSION": 300, "COMPONENT_INFORMATION": 395, "COMPONENT_METADATA": 397, "AVAILABLE_MODES": 435, "CURRENT_MODE": 436,
}  # fmt: skip
# Inside everybody's limits; below everybody's; above everybody's.
FAIR_MPS, SLOW_MPS, FAST_MPS = 12, 4, 40


@scene
def connection(talk):
    beat = talk.newest["HEARTBEAT"]
    with talk.step("who it is"):
        talk.answers.append(f"type {beat.type} autopilot {beat.autopilot} status {beat.system_status} flags {beat.base_mode}")
    for name in (
        "AUTOPILOT_VERSION PROTOCOL_VERSION HOME_POSITION GPS_GLOBAL_ORIGIN EXTENDED_SYS_STATE SYS_STATUS SYSTEM_TIME GPS_RAW_INT "
        "BATTERY_STATUS WIND SCALED_PRESSURE RAW_IMU SCALED_IMU2 SERVO_OUTPUT_RAW RC_CHANNELS NAV_CONTROLLER_OUTPUT POWER_STATUS "
        "MEMINFO VIBRATION EKF_STATUS_REPORT ATTITUDE ATTITUDE_QUATERNION LOCAL_POSITION_NED GLOBAL_POSITION_INT VFR_HUD "
        "POSITION_TARGET_GLOBAL_INT MISSION_CURRENT HIGHRES_IMU ALTITUDE FENCE_STATUS TERRAIN_REPORT AOA_SSA HWSTATUS "
        "AIRSPEED AHRS AHRS2 RPM HIGH_LATENCY2 CAMERA_INFORMATION GIMBAL_MANAGER_INFORMATION COMPONENT_METADATA "
        "COMPONENT_INFORMATION ODOMETRY WIND_COV UTM_GLOBAL_POSITION OPEN_DRONE_ID_LOCATION AVAILABLE_MODES CURRENT_MODE"
    ).split():
        with talk.step(f"asked for {name}"):
            talk.request(NUMBERS.get(name) or getattr(mavlink, f"MAVLINK_MSG_ID_{name}"))
    with talk.step("asked for a message that nobody knows"):
        talk.request(12_999)
    with talk.step("asked for AUTOPILOT_VERSION, and it comes", also=["AUTOPILOT_VERSION"]):
        talk.request(mavlink.MAVLINK_MSG_ID_AUTOPILOT_VERSION)
    version = talk.newest.get("AUTOPILOT_VERSION")
    with talk.step("its version"):
        talk.answers.append(f"{version.flight_sw_version >> 24}.{version.flight_sw_version >> 16 & 255}")
    flags = mavlink.enums["MAV_PROTOCOL_CAPABILITY"].items()
    with talk.step("its capabilities"):
        talk.answers += [
            flag.name.removeprefix("MAV_PROTOCOL_CAPABILITY_") for bit, flag in flags if bit & version.capabilities and not flag.name.endswith("ENUM_END")
        ]
    with talk.step("the older request for capabilities", also=["AUTOPILOT_VERSION"]):
        talk.long(mavlink.MAV_CMD_REQUEST_AUTOPILOT_CAPABILITIES, 1)
    with talk.step("the older request for the protocol's version", also=["PROTOCOL_VERSION"]):
        talk.long(mavlink.MAV_CMD_REQUEST_PROTOCOL_VERSION, 1)
    with talk.step("PING", also=["PING"]):
        talk.mav.ping_send(1, 7, 0, 0)
    with talk.step("logs", also=["LOG_ENTRY"]):
        talk.mav.log_request_list_send(talk.system, talk.component, 0, 0xFFFF)
    with talk.step("a file that is not there", also=["FILE_TRANSFER_PROTOCOL"]):
        path = b"@NOT/there"
        payload = [0, 0, 0, 4, len(path), 0, 0, 0, 0, 0, 0, 0, *path]
        talk.mav.file_transfer_protocol_send(0, talk.system, talk.component, payload + [0] * (251 - len(payload)))


@scene
def parameters(talk):
    with talk.step("read one"):
        talk.read("WP_RADIUS")
    with talk.step("read one that is not there"):
        talk.read("NOT_THERE")
    with talk.step("read by an index that is not there"):
        talk.mav.param_request_read_send(talk.system, talk.component, b"", 30_000)
    for name, value in {
        "WP_RADIUS": 33, "WP_LOITER_RAD": -70, "RTL_RADIUS": 90, "RTL_ALTITUDE": 75, "TKOFF_ALT": 60, "FS_GCS_ENABL": 1, "FS_LONG_ACTN": 1,
        "FS_LONG_TIMEOUT": 7, "AIRSPEED_CRUISE": 12, "ROLL_LIMIT_DEG": 45, "MAV_GCS_SYSID": 255, "MAV1_POSITION": 4, "FENCE_ENABLE": 0,
        "FENCE_ACTION": 1, "FENCE_ALT_MAX": 90, "FENCE_RADIUS": 400, "BATT_LOW_VOLT": 10.5, "BATT_CAPACITY": 5000, "SIM_WIND_SPD": 6,
        "SIM_WIND_DIR": 90, "SIM_GPS1_ENABLE": 1, "SIM_ENGINE_FAIL": 0, "RALLY_LIMIT_KM": 4, "ARMING_CHECK": 1,
        "LAND_DISARMDELAY": 20, "FENCE_AUTOENABLE": 0, "SCHED_LOOP_RATE": 50, "STAB_PITCH_DOWN": 2,
    }.items():  # fmt: skip
        with talk.step(f"set {name}"):
            talk.set(name, value)
            talk.settle()
            # The type in the echo of a default is another than that of the parameter.
            talk.answers[:] = [" ".join(answer.split()[::2]) for answer in talk.answers]
        with talk.step(f"read {name}"):
            talk.read(name)
    with talk.step("set a whole number to a broken one"):
        talk.set("WP_LOITER_RAD", 61.6)
    with talk.step("set in another type", also=["PARAM_VALUE"]):
        talk.set("WP_LOITER_RAD", 64, mavlink.MAV_PARAM_TYPE_INT16)
    with talk.step("set one that is not there"):
        talk.set("NOT_THERE", 1)
    for name, value in {"WP_RADIUS": -5, "FS_GCS_ENABL": 9, "MAV_GCS_SYSID": 999, "TKOFF_ALT": 100_000, "ROLL_LIMIT_DEG": -1}.items():
        with talk.step(f"set {name} to {value}, out of its range"):
            talk.set(name, value)
    with talk.step("set one that is read only"):
        talk.set("STAT_BOOTCNT", 77)
    with talk.step("set to the value it has"):
        talk.set("RTL_RADIUS", 90)
    with talk.step("read for another system"):
        talk.mav.param_request_read_send(77, talk.component, b"WP_RADIUS", -1)
    with talk.step("set for another system"):
        talk.mav.param_set_send(77, talk.component, b"WP_RADIUS", 20, mavlink.MAV_PARAM_TYPE_REAL32)


@scene
def message_intervals(talk):
    attitude = mavlink.MAVLINK_MSG_ID_ATTITUDE
    for name, params in {
        "10 Hz": (attitude, 100_000), "far too fast": (attitude, 100), "off": (attitude, -1), "the default": (attitude, 0),
        "a message that nobody knows": (12_999, 100_000), "a message that is not sent": (mavlink.MAVLINK_MSG_ID_COMMAND_LONG, 100_000),
        "less than off": (attitude, -2), "the heartbeat": (mavlink.MAVLINK_MSG_ID_HEARTBEAT, 1_000_000),
        "of BATTERY_STATUS": (mavlink.MAVLINK_MSG_ID_BATTERY_STATUS, 500_000), "of WIND": (mavlink.MAVLINK_MSG_ID_WIND, 500_000),
        "of EXTENDED_SYS_STATE": (mavlink.MAVLINK_MSG_ID_EXTENDED_SYS_STATE, 500_000), "of HOME_POSITION": (mavlink.MAVLINK_MSG_ID_HOME_POSITION, 5_000_000),
    }.items():  # fmt: skip
        with talk.step(name):
            talk.long(INTERVAL, *params)
    with talk.step("5 Hz, by COMMAND_INT"):
        talk.int(INTERVAL, attitude, 200_000)
    with talk.step("what it is"):
        talk.long(mavlink.MAV_CMD_GET_MESSAGE_INTERVAL, attitude)
    with talk.step("what it is, by REQUEST_MESSAGE"):
        talk.request(mavlink.MAVLINK_MSG_ID_MESSAGE_INTERVAL, attitude)
    with talk.step("what it is of a message that nobody knows"):
        talk.long(mavlink.MAV_CMD_GET_MESSAGE_INTERVAL, 12_999)
    with talk.step("REQUEST_DATA_STREAM"):
        talk.mav.request_data_stream_send(talk.system, talk.component, mavlink.MAV_DATA_STREAM_ALL, 2, 1)


@scene
def arming(talk):
    with talk.step("disarm when disarmed"):
        talk.arm(False)
    with talk.step("neither arm nor disarm"):
        talk.long(mavlink.MAV_CMD_COMPONENT_ARM_DISARM, 2)
    with talk.step("a mission is begun unarmed"):
        talk.long(mavlink.MAV_CMD_MISSION_START)
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
        "speed": (0, FAIR_MPS), "speed too slow": (0, SLOW_MPS), "speed too fast": (0, FAST_MPS), "speed over ground": (1, FAIR_MPS),
        "speed of another kind": (2, FAIR_MPS), "speed at a rate": (0, 11, 0.5), "speed below zero": (0, -5),
    }.items():  # fmt: skip
        with talk.step(f"{where}: {name}"):
            talk.int(SPEED, *params)
    with talk.step(f"{where}: speed by COMMAND_LONG"):
        talk.long(SPEED, 0, FAIR_MPS)
    for name, params in {
        "course": (0, 90, 10), "heading": (1, 45, 10), "neither any more": (2, 0, 0), "course of a full circle": (0, 360, 10), "course below zero": (0, -1, 10),
        "course of another kind": (3, 90, 10), "course 359.9": (0, 359.9, 10),
    }.items():  # fmt: skip
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
        talk.mav.mission_item_int_send(talk.system, talk.component, 0, frame, command, 2, 1, *params, *place, z, MISSION)
    with talk.step("altitude by a mission item that is current 3"):
        talk.mav.mission_item_int_send(talk.system, talk.component, 0, frame, command, 3, 1, *params, *place, z, MISSION)


@scene
def commands_in_the_air(talk):
    talk.take_off()
    change_speed, change_altitude = mavlink.MAV_CMD_DO_CHANGE_SPEED, mavlink.MAV_CMD_DO_CHANGE_ALTITUDE
    for mode, word in ((LOITER, "LOITER"), (GUIDED, "GUIDED")):
        with talk.step(f"to {word}"):
            talk.mode(mode)
        for name, params in {
            "airspeed": (0, FAIR_MPS, -1), "ground speed": (1, FAIR_MPS, -1), "climb speed": (2, 3, -1), "airspeed too fast": (0, FAST_MPS, -1),
            "airspeed too slow": (0, SLOW_MPS, -1), "throttle": (0, -1, 60), "the default": (0, -2, -1), "no change": (0, -1, -1),
        }.items():  # fmt: skip
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
    """On the ground, all parameters 0, in both messages; but for those that start something long, or end the program."""
    long_ones = {
        mavlink.MAV_CMD_DO_START_MAG_CAL, mavlink.MAV_CMD_FIXED_MAG_CAL_YAW, mavlink.MAV_CMD_DO_MOTOR_TEST, mavlink.MAV_CMD_ACCELCAL_VEHICLE_POS,
        mavlink.MAV_CMD_DO_SEND_BANNER, mavlink.MAV_CMD_FLASH_BOOTLOADER, mavlink.MAV_CMD_PREFLIGHT_CALIBRATION, HOME, mavlink.MAV_CMD_REQUEST_MESSAGE,
    }  # fmt: skip
    for number in sorted(mavlink.enums["MAV_CMD"]):
        name = mavlink.enums["MAV_CMD"][number].name.removeprefix("MAV_CMD_")
        if number in long_ones or name == "ENUM_END" or name.startswith(("WAYPOINT_USER", "SPATIAL_USER", "USER_")):
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


@scene
def home(talk):
    with talk.step("asked for by GET_HOME_POSITION", also=["HOME_POSITION"]):
        talk.long(mavlink.MAV_CMD_GET_HOME_POSITION)
    with talk.step("asked for by REQUEST_MESSAGE", also=["HOME_POSITION"]):
        talk.request(mavlink.MAVLINK_MSG_ID_HOME_POSITION)
    x, y = talk.place(50, 20)
    with talk.step("set to a place", also=["HOME_POSITION"]):
        talk.int(HOME, 0, 0, 0, 0, x, y, 100, 0)
    with talk.step("set to a place by COMMAND_LONG", also=["HOME_POSITION"]):
        talk.long(HOME, 0, 0, 0, 0, x / 1e7, y / 1e7, 100)
    with talk.step("set to a latitude that is none"):
        talk.int(HOME, 0, 0, 0, 0, 910_000_000, y, 100, 0)
    with talk.step("set to zeros"):
        talk.int(HOME, 0, 0, 0, 0, 0, 0, 0, 0)
    with talk.step("set in a local frame"):
        talk.int(HOME, 0, 0, 0, 0, x, y, 100, 1)
    with talk.step("set to where it is", also=["HOME_POSITION"]):
        talk.long(HOME, 1)
    with talk.step("set to where it is, neither 0 nor 1"):
        talk.long(HOME, 2)
    with talk.step("by SET_HOME_POSITION", also=["HOME_POSITION"]):
        talk.mav.set_home_position_send(talk.system, x, y, 100_000, 0, 0, 0, [1, 0, 0, 0], 0, 0, 0)
    with talk.step("an origin, which is there already", also=["GPS_GLOBAL_ORIGIN"]):
        talk.mav.set_gps_global_origin_send(talk.system, x, y, 100_000)


@scene
def whom_it_is_for(talk):
    mode = mavlink.MAV_CMD_DO_SET_MODE
    with talk.step("a command for another system"):
        talk.long(mode, 1, FBWA, system=77)
    with talk.step("a command for all systems"):
        talk.long(mode, 1, FBWA, system=0)
    with talk.step("a command for all components"):
        talk.long(mode, 1, CRUISE, component=0)
    with talk.step("a command for another component"):
        talk.long(mode, 1, LOITER, component=55)
    with talk.step("COMMAND_INT for another system"):
        talk.int(mode, 1, RTL, system=77)
    with talk.step("COMMAND_INT for another component"):
        talk.int(mode, 1, RTL, component=55)
    with talk.step("the number of items, for another system"):
        talk.mav.mission_count_send(77, 1, 3, MISSION)
    with talk.step("the number of items, for another component"):
        talk.mav.mission_count_send(talk.system, 55, 0, MISSION)
    with talk.step("the list of a mission, for another system"):
        talk.mav.mission_request_list_send(77, 1, MISSION)
