"""The questions that QGroundControl and MAVProxy ask when they connect: each has an answer or a refusal."""

import pytest
from ground import ACCEPTED, FAILED, UNSUPPORTED
from pymavlink.dialects.v20 import ardupilotmega as mavlink

PLANS = [mavlink.MAV_MISSION_TYPE_MISSION, mavlink.MAV_MISSION_TYPE_FENCE, mavlink.MAV_MISSION_TYPE_RALLY]


@pytest.mark.parametrize(
    "kind",
    ["AUTOPILOT_VERSION", "HOME_POSITION", "GPS_GLOBAL_ORIGIN", "GPS_RAW_INT", "BATTERY_STATUS", "EXTENDED_SYS_STATE"],
)  # fmt: skip
def test_a_message_is_sent_on_request(craft, kind):
    assert craft.request(getattr(mavlink, f"MAVLINK_MSG_ID_{kind}"), kind)


def test_the_version_is_arduplanes_and_promises_what_there_is(craft):
    version = craft.request(mavlink.MAVLINK_MSG_ID_AUTOPILOT_VERSION, "AUTOPILOT_VERSION")
    assert version.flight_sw_version >> 16 == 4 << 8 | 7
    assert version.capabilities & mavlink.MAV_PROTOCOL_CAPABILITY_PARAM_ENCODE_C_CAST
    assert version.capabilities & mavlink.MAV_PROTOCOL_CAPABILITY_MISSION_FENCE
    assert version.capabilities & mavlink.MAV_PROTOCOL_CAPABILITY_MISSION_RALLY
    assert not version.capabilities & mavlink.MAV_PROTOCOL_CAPABILITY_FTP


def test_the_old_commands_are_answered(craft):
    assert craft.command_long(mavlink.MAV_CMD_REQUEST_AUTOPILOT_CAPABILITIES, 1) == ACCEPTED
    assert craft.command_long(mavlink.MAV_CMD_REQUEST_PROTOCOL_VERSION, 1) == ACCEPTED
    assert craft.command_long(mavlink.MAV_CMD_GET_HOME_POSITION) == ACCEPTED


def test_a_camera_that_is_not_there_is_accepted_and_said_to_be_missing(craft):
    message_id = mavlink.MAVLINK_MSG_ID_CAMERA_INFORMATION
    assert craft.command_long(mavlink.MAV_CMD_REQUEST_MESSAGE, message_id) == ACCEPTED
    assert craft.text().text == "There is no camera"


@pytest.mark.parametrize("kind", ["COMPONENT_METADATA", "COMPONENT_INFORMATION"])
def test_what_only_other_components_know_is_refused(craft, kind):
    message_id = getattr(mavlink, f"MAVLINK_MSG_ID_{kind}", 397)
    assert craft.command_long(mavlink.MAV_CMD_REQUEST_MESSAGE, message_id) == FAILED
    assert craft.text().text == f"Message {message_id} is not available"


@pytest.mark.parametrize("kind", ["CAMERA_INFORMATION", "CAMERA_SETTINGS", "STORAGE_INFORMATION"])
def test_an_old_request_to_a_camera_is_unsupported(craft, kind):
    assert craft.command_long(getattr(mavlink, f"MAV_CMD_REQUEST_{kind}"), 1) == UNSUPPORTED


@pytest.mark.parametrize("plan", PLANS)
def test_every_plan_is_empty(craft, plan):
    craft.link.mav.mission_request_list_send(craft.system, craft.component, plan)
    count = craft.wait(["MISSION_COUNT"])
    # ArduPlane counts home before anything is uploaded.
    assert (count.count, count.mission_type) == (int(plan == mavlink.MAV_MISSION_TYPE_MISSION), plan)


def test_mavproxys_stream_rate(craft):
    craft.link.mav.request_data_stream_send(craft.system, craft.component, mavlink.MAV_DATA_STREAM_ALL, 4, 1)
    craft.wait(["SYSTEM_TIME"])
    stamps = [message.time_boot_ms for message in craft.collect(["ATTITUDE"], 3)]
    assert {after - before for before, after in zip(stamps, stamps[1:])} == {250}


def test_a_receiver_with_a_fix_is_where_the_vehicle_is(craft):
    receiver = craft.wait(["GPS_RAW_INT"])
    place = craft.wait(["GLOBAL_POSITION_INT"])
    assert receiver.fix_type >= mavlink.GPS_FIX_TYPE_3D_FIX
    assert receiver.alt == pytest.approx(place.alt, abs=10)
    assert receiver.vel == pytest.approx(1000, abs=1)


def test_files_are_refused_at_once(craft):
    list_directory = bytes([1, 0, 0, 3]) + bytes(247)
    craft.link.mav.file_transfer_protocol_send(0, craft.system, craft.component, list_directory)
    answer = craft.wait(["FILE_TRANSFER_PROTOCOL"])
    assert (answer.payload[0], answer.payload[3], answer.payload[5], answer.payload[12]) == (2, 129, 3, 7)


REQUEST, INTERVAL = mavlink.MAV_CMD_REQUEST_MESSAGE, mavlink.MAV_CMD_SET_MESSAGE_INTERVAL
# Messages that this dialect of pymavlink does not name.
PROTOCOL_VERSION, COMPONENT_INFORMATION, COMPONENT_METADATA, AVAILABLE_MODES, CURRENT_MODE = 300, 395, 397, 435, 436
FTP_TERMINATE, FTP_RESET, FTP_LIST, FTP_OPEN, FTP_NAK, FTP_BURST = 1, 2, 3, 4, 129, 15


def qgroundcontrol():
    """What QGroundControl sends when it meets a vehicle, in its order: its initial connect state machine, then its
    camera, gimbal, storage and video managers and the streams of its settings. Each with the answer that comes.

    Sources: InitialConnectStateMachine.cc, StandardModes.cc, ComponentInformationManager.cc, ParameterManager.cc,
    PlanManager.cc, QGCCameraManager.cc, GimbalController.cc of <https://github.com/mavlink/qgroundcontrol>.
    """
    yield "version", command(REQUEST, mavlink.MAVLINK_MSG_ID_AUTOPILOT_VERSION), ("AUTOPILOT_VERSION", ACCEPTED)
    yield "version, older", command(mavlink.MAV_CMD_REQUEST_AUTOPILOT_CAPABILITIES, 1), ("AUTOPILOT_VERSION", ACCEPTED)
    yield "protocol", command(REQUEST, PROTOCOL_VERSION), (None, ACCEPTED)
    yield "standard modes", command(REQUEST, AVAILABLE_MODES, 1), ("COMMAND_ACK", None)
    yield "current mode", command(REQUEST, CURRENT_MODE), ("COMMAND_ACK", None)
    yield "metadata", command(REQUEST, COMPONENT_METADATA), (None, FAILED)
    yield "metadata, older", command(REQUEST, COMPONENT_INFORMATION), (None, FAILED)
    yield "parameters as a file", ftp(FTP_OPEN, b"@PARAM/param.pck?withdefaults=1"), ("FILE_TRANSFER_PROTOCOL", None)
    yield "sessions", ftp(FTP_RESET), ("FILE_TRANSFER_PROTOCOL", None)
    yield "files", ftp(FTP_LIST, b"@MAV_LOG"), ("FILE_TRANSFER_PROTOCOL", None)
    yield "a burst", ftp(FTP_BURST), ("FILE_TRANSFER_PROTOCOL", None)
    yield "a session's end", ftp(FTP_TERMINATE), ("FILE_TRANSFER_PROTOCOL", None)
    yield "PX4's checksum", lambda mav, to: mav.param_request_read_send(*to, b"_HASH_CHECK", -1), ("PARAM_ERROR", None)
    yield "parameters", lambda mav, to: mav.param_request_list_send(*to), ("PARAM_VALUE", None)
    for plan in PLANS:
        yield (
            f"plan {plan}",
            lambda mav, to, plan=plan: mav.mission_request_list_send(*to, plan),
            ("MISSION_COUNT", None),
        )
    yield "home", command(mavlink.MAV_CMD_GET_HOME_POSITION), ("HOME_POSITION", ACCEPTED)
    # A real one accepts them, and nothing comes.
    for kind in ("CAMERA_INFORMATION", "GIMBAL_MANAGER_INFORMATION", "VIDEO_STREAM_INFORMATION"):
        yield kind, command(REQUEST, getattr(mavlink, f"MAVLINK_MSG_ID_{kind}")), (None, ACCEPTED)
    yield "storage", command(REQUEST, mavlink.MAVLINK_MSG_ID_STORAGE_INFORMATION), (None, FAILED)
    for number in range(521, 528):
        yield f"command {number}", command(number, 1), (None, UNSUPPORTED)
    for kind in ("GIMBAL_MANAGER_STATUS", "GIMBAL_DEVICE_ATTITUDE_STATUS"):
        yield f"rate of {kind}", command(INTERVAL, getattr(mavlink, f"MAVLINK_MSG_ID_{kind}"), 1e6), (None, ACCEPTED)
    yield "rate of home", command(INTERVAL, mavlink.MAVLINK_MSG_ID_HOME_POSITION, 1e6), ("HOME_POSITION", ACCEPTED)
    yield "rate", command(INTERVAL, mavlink.MAVLINK_MSG_ID_EXTENDED_SYS_STATE, 1e6), ("EXTENDED_SYS_STATE", ACCEPTED)
    yield "logs", lambda mav, to: mav.log_request_list_send(*to, 0, 0xFFFF), ("LOG_ENTRY", None)
    yield "time", lambda mav, to: mav.timesync_send(0, 1), ("TIMESYNC", None)
    yield "ping", lambda mav, to: mav.ping_send(0, 1, 0, 0), ("PING", None)
    yield "a vendor's command", command(42_001), (None, UNSUPPORTED)


def command(number, p1=0, p2=0):
    return lambda mav, to: mav.command_long_send(*to, number, 0, p1, p2, 0, 0, 0, 0, 0)


def ftp(opcode, data=b""):
    payload = (bytes([1, 0, 0, opcode, len(data), 0, 0, 0, 0, 0, 0, 0]) + data).ljust(251, b"\0")
    return lambda mav, to: mav.file_transfer_protocol_send(0, *to, payload)


def test_each_question_of_qgroundcontrol_is_answered_at_once(craft):
    mav, to = craft.link.mav, (craft.system, craft.component)
    for name, ask, (kind, result) in qgroundcontrol():
        ask(mav, to)
        waiting = {kind, None if result is None else "COMMAND_ACK"} - {None}
        while waiting:
            message = craft.wait([*waiting], patience_s=5)
            waiting.discard(message.get_type())
            if message.get_type() == "COMMAND_ACK" and result is not None:
                assert message.result == result, name
            if message.get_type() == "FILE_TRANSFER_PROTOCOL":
                assert message.payload[3] == FTP_NAK, name
    assert all(text.text for text in craft.texts), "a refusal has words"
