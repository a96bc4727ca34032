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


@pytest.mark.parametrize("kind", ["CAMERA_INFORMATION", "COMPONENT_METADATA", "COMPONENT_INFORMATION"])
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
    assert (count.count, count.mission_type) == (0, plan)


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
