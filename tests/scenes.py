"""The scenes of the differential run: each on a vehicle fresh from its start, on the ground and disarmed."""

from differential import MISSION, scene
from pymavlink.dialects.v20 import ardupilotmega as mavlink

FBWA, CRUISE, RTL, LOITER = 5, 7, 11, 12
HOME, INTERVAL = mavlink.MAV_CMD_DO_SET_HOME, mavlink.MAV_CMD_SET_MESSAGE_INTERVAL
MESSAGES = """
    AUTOPILOT_VERSION PROTOCOL_VERSION HOME_POSITION GPS_GLOBAL_ORIGIN EXTENDED_SYS_STATE SYS_STATUS SYSTEM_TIME
    GPS_RAW_INT BATTERY_STATUS WIND SCALED_PRESSURE RAW_IMU SCALED_IMU2 SERVO_OUTPUT_RAW RC_CHANNELS
    NAV_CONTROLLER_OUTPUT POWER_STATUS MEMINFO VIBRATION EKF_STATUS_REPORT ATTITUDE ATTITUDE_QUATERNION
    LOCAL_POSITION_NED GLOBAL_POSITION_INT VFR_HUD POSITION_TARGET_GLOBAL_INT MISSION_CURRENT HIGHRES_IMU ALTITUDE
    FENCE_STATUS TERRAIN_REPORT AOA_SSA HWSTATUS AIRSPEED AHRS AHRS2 RPM HIGH_LATENCY2 CAMERA_INFORMATION
    GIMBAL_MANAGER_INFORMATION COMPONENT_METADATA COMPONENT_INFORMATION ODOMETRY WIND_COV UTM_GLOBAL_POSITION
    OPEN_DRONE_ID_LOCATION AVAILABLE_MODES CURRENT_MODE
"""
# Those that pymavlink's dialect does not have.
NUMBERS = {
    "PROTOCOL_VERSION": 300,
    "COMPONENT_INFORMATION": 395,
    "COMPONENT_METADATA": 397,
    "AVAILABLE_MODES": 435,
    "CURRENT_MODE": 436,
}


@scene
def connection(talk):
    beat = talk.newest["HEARTBEAT"]
    with talk.step("who it is"):
        talk.answers.append(
            f"type {beat.type} autopilot {beat.autopilot} status {beat.system_status} flags {beat.base_mode}"
        )
    for name in MESSAGES.split():
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
            flag.name.removeprefix("MAV_PROTOCOL_CAPABILITY_")
            for bit, flag in flags
            if bit & version.capabilities and not flag.name.endswith("ENUM_END")
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
        "WP_RADIUS": 33,
        "WP_LOITER_RAD": -70,
        "RTL_RADIUS": 90,
        "RTL_ALTITUDE": 75,
        "TKOFF_ALT": 60,
        "FS_GCS_ENABL": 1,
        "FS_LONG_ACTN": 1,
        "FS_LONG_TIMEOUT": 7,
        "AIRSPEED_CRUISE": 12,
        "ROLL_LIMIT_DEG": 45,
        "MAV_GCS_SYSID": 255,
        "MAV1_POSITION": 4,
        "FENCE_ENABLE": 0,
        "FENCE_ACTION": 1,
        "FENCE_ALT_MAX": 90,
        "FENCE_RADIUS": 400,
        "BATT_LOW_VOLT": 10.5,
        "BATT_CAPACITY": 5000,
        "SIM_WIND_SPD": 6,
        "SIM_WIND_DIR": 90,
        "SIM_GPS1_ENABLE": 1,
        "SIM_ENGINE_FAIL": 0,
        "RALLY_LIMIT_KM": 4,
        "ARMING_CHECK": 1,
        "LAND_DISARMDELAY": 20,
        "FENCE_AUTOENABLE": 0,
        "SCHED_LOOP_RATE": 50,
        "STAB_PITCH_DOWN": 2,
    }.items():
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
    for name, value in {
        "WP_RADIUS": -5,
        "FS_GCS_ENABL": 9,
        "MAV_GCS_SYSID": 999,
        "TKOFF_ALT": 100_000,
        "ROLL_LIMIT_DEG": -1,
    }.items():
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
        "10 Hz": (attitude, 100_000),
        "far too fast": (attitude, 100),
        "off": (attitude, -1),
        "the default": (attitude, 0),
        "a message that nobody knows": (12_999, 100_000),
        "a message that is not sent": (mavlink.MAVLINK_MSG_ID_COMMAND_LONG, 100_000),
        "less than off": (attitude, -2),
        "the heartbeat": (mavlink.MAVLINK_MSG_ID_HEARTBEAT, 1_000_000),
        "of BATTERY_STATUS": (mavlink.MAVLINK_MSG_ID_BATTERY_STATUS, 500_000),
        "of WIND": (mavlink.MAVLINK_MSG_ID_WIND, 500_000),
        "of EXTENDED_SYS_STATE": (mavlink.MAVLINK_MSG_ID_EXTENDED_SYS_STATE, 500_000),
        "of HOME_POSITION": (mavlink.MAVLINK_MSG_ID_HOME_POSITION, 5_000_000),
    }.items():
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
def home(talk):
    # Ours sends it unasked: only what a step brings about is to count.
    talk.long(INTERVAL, mavlink.MAVLINK_MSG_ID_HOME_POSITION, -1)
    talk.settle()
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
