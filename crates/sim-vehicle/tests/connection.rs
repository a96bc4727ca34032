//! What ground stations ask when they connect, and that each question has its answer.
#![allow(clippy::panic, clippy::unwrap_used, deprecated)]

mod common;

use common::{Client, TARGET, acknowledgement, long, quiet, texts};
use mavlink_bridge::dialect::*;
use sim_vehicle::VehicleSettings;

fn is(id: u32) -> impl Fn(&&Message) -> bool {
    move |message| message.message_id() == id
}

#[test]
fn versions_and_states_are_told_on_request_and_by_the_old_commands() {
    let mut client = Client::new(quiet());
    for id in [24, 49, 147, 148, 242, 245, 300] {
        let answer = client.ask(&long(TARGET, MavCmd::MAV_CMD_REQUEST_MESSAGE, [id as f32, 0.0, 0.0]));
        assert_eq!(answer.iter().filter(is(id)).count(), 1, "{id}");
        assert_eq!(acknowledgement(&answer).unwrap().result, MavResult::MAV_RESULT_ACCEPTED);
    }
    // The second of them ArduPlane 4.7 knows no more: what it answers is recorded.
    for (command, id, otherwise) in [
        (MavCmd::MAV_CMD_REQUEST_AUTOPILOT_CAPABILITIES, 148, MavResult::MAV_RESULT_FAILED),
        (MavCmd::MAV_CMD_REQUEST_PROTOCOL_VERSION, 300, MavResult::MAV_RESULT_UNSUPPORTED),
    ] {
        let answer = client.ask(&long(TARGET, command, [1.0, 0.0, 0.0]));
        assert_eq!(answer.iter().filter(is(id)).count(), 1);
        assert_eq!(acknowledgement(&answer).unwrap().result, MavResult::MAV_RESULT_ACCEPTED);
        assert_eq!(client.command_long(command, [0.0; 3]), Some(otherwise));
    }
}

#[test]
fn the_version_promises_no_more_than_there_is() {
    let mut client = Client::new(quiet());
    let answer = client.ask(&long(TARGET, MavCmd::MAV_CMD_REQUEST_MESSAGE, [148.0, 0.0, 0.0]));
    let Some(Message::AUTOPILOT_VERSION(version)) = answer.iter().find(is(148)) else { panic!() };
    assert_eq!(version.flight_sw_version >> 16, 0x0407);
    assert_eq!(version.uid, u64::from(TARGET));
    assert!(version.capabilities.contains(MavProtocolCapability::MAV_PROTOCOL_CAPABILITY_PARAM_ENCODE_C_CAST));
    assert!(version.capabilities.contains(MavProtocolCapability::MAV_PROTOCOL_CAPABILITY_MISSION_FENCE));
    assert!(version.capabilities.contains(MavProtocolCapability::MAV_PROTOCOL_CAPABILITY_MISSION_RALLY));
    assert!(!version.capabilities.contains(MavProtocolCapability::MAV_PROTOCOL_CAPABILITY_FTP));
}

#[test]
fn it_is_on_the_ground_until_it_is_armed() {
    let mut client = Client::new(VehicleSettings { armed: false, ..quiet() });
    let landed = |client: &mut Client| {
        let answer = client.ask(&long(TARGET, MavCmd::MAV_CMD_REQUEST_MESSAGE, [245.0, 0.0, 0.0]));
        let Some(Message::EXTENDED_SYS_STATE(state)) = answer.iter().find(is(245)) else { panic!() };
        state.landed_state
    };
    assert_eq!(landed(&mut client), MavLandedState::MAV_LANDED_STATE_ON_GROUND);
    client.command_long(MavCmd::MAV_CMD_COMPONENT_ARM_DISARM, [1.0, 0.0, 0.0]);
    assert_eq!(landed(&mut client), MavLandedState::MAV_LANDED_STATE_IN_AIR);
}

#[test]
fn every_type_of_plan_is_empty_and_can_be_cleared_and_uploaded() {
    let mut client = Client::new(quiet());
    for mission_type in [
        MavMissionType::MAV_MISSION_TYPE_MISSION,
        MavMissionType::MAV_MISSION_TYPE_FENCE,
        MavMissionType::MAV_MISSION_TYPE_RALLY,
    ] {
        let to = MISSION_REQUEST_LIST_DATA { target_system: TARGET, target_component: 1, mission_type };
        let answer = client.ask(&Message::MISSION_REQUEST_LIST(to));
        let Some(Message::MISSION_COUNT(count)) = answer.iter().find(is(44)) else { panic!() };
        assert_eq!(
            (count.count, count.mission_type, count.target_system, count.target_component),
            // An ArduPlane counts home until something is uploaded or cleared.
            (u16::from(mission_type == MavMissionType::MAV_MISSION_TYPE_MISSION), mission_type, 255, 190)
        );

        let clear = MISSION_CLEAR_ALL_DATA { target_system: TARGET, target_component: 1, mission_type };
        let answer = client.ask(&Message::MISSION_CLEAR_ALL(clear));
        assert!(matches!(answer.as_slice(), [Message::MISSION_ACK(ack), ..]
            if ack.mavtype == MavMissionResult::MAV_MISSION_ACCEPTED && ack.mission_type == mission_type));

        let upload =
            MISSION_COUNT_DATA { count: 3, target_system: TARGET, mission_type, ..MISSION_COUNT_DATA::DEFAULT };
        let answer = client.ask(&Message::MISSION_COUNT(upload));
        assert!(matches!(answer.as_slice(), [Message::MISSION_REQUEST(request)]
            if request.seq == 0 && request.mission_type == mission_type));
    }
}

#[test]
fn data_streams_are_set_for_the_asking_link_and_cut_to_what_it_can() {
    let mut client = Client::new(quiet());
    let request = |req_stream_id, req_message_rate, start_stop| {
        Message::REQUEST_DATA_STREAM(REQUEST_DATA_STREAM_DATA {
            req_message_rate,
            target_system: TARGET,
            target_component: 1,
            req_stream_id,
            start_stop,
        })
    };
    client.ask(&request(MavDataStream::MAV_DATA_STREAM_POSITION, 10, 1));
    client.fly(2.0);
    let received = client.collect();
    assert_eq!([32, 33].map(|id| received.iter().filter(is(id)).count()), [20, 20]);
    assert_eq!(received.len(), 40);

    client.ask(&request(MavDataStream::MAV_DATA_STREAM_POSITION, 0, 0));
    client.ask(&request(MavDataStream::MAV_DATA_STREAM_EXTRA1, 1000, 1));
    client.fly(2.0);
    let received = client.collect();
    assert!(received.iter().all(|message| message.message_id() == 30));
    // At most 80 Hz, and only at whole steps of 10 ms.
    assert!((100..=160).contains(&received.len()), "{}", received.len());
    client.ask(&request(MavDataStream::MAV_DATA_STREAM_ALL, 1, 1));
    client.fly(1.0);
    let mut ids: Vec<u32> = client.collect().iter().map(Message::message_id).collect();
    ids.sort_unstable();
    // Beside them those of ArduPilot's own dialect.
    let expected = [1, 2, 24, 27, 29, 30, 32, 33, 36, 42, 62, 65, 74, 87, 116, 125, 129, 136, 137, 147, 241, 295];
    assert_eq!(ids, expected);
}

#[test]
fn the_fence_that_is_not_there_is_not_breached() {
    let mut client = Client::new(quiet());
    let answer = client.ask(&long(TARGET, MavCmd::MAV_CMD_REQUEST_MESSAGE, [1.0, 0.0, 0.0]));
    let Some(Message::SYS_STATUS(status)) = answer.iter().find(is(1)) else { panic!() };
    let fence = MavSysStatusSensor::MAV_SYS_STATUS_GEOFENCE;
    assert!(!status.onboard_control_sensors_present.contains(fence));
    assert!(status.onboard_control_sensors_health.contains(fence));
}

#[test]
fn files_and_logs_are_refused_at_once() {
    let mut client = Client::new(quiet());
    let mut payload = [0; 251];
    payload[..4].copy_from_slice(&[0xFF, 0xFF, 3, 4]);
    let ask = FILE_TRANSFER_PROTOCOL_DATA { target_system: TARGET, payload, ..FILE_TRANSFER_PROTOCOL_DATA::DEFAULT };
    let answer = client.ask(&Message::FILE_TRANSFER_PROTOCOL(ask));
    let Some(Message::FILE_TRANSFER_PROTOCOL(nak)) = answer.iter().find(is(110)) else { panic!() };
    assert_eq!((&nak.payload[..6], nak.payload[12]), ([0, 0, 3, 129, 1, 4].as_slice(), 7));
    assert_eq!(client.ask(&Message::FILE_TRANSFER_PROTOCOL(nak.clone())), [], "an answer is not answered");

    let logs = LOG_REQUEST_LIST_DATA { target_system: TARGET, ..LOG_REQUEST_LIST_DATA::DEFAULT };
    let answer = client.ask(&Message::LOG_REQUEST_LIST(logs));
    assert!(matches!(answer.as_slice(), [Message::LOG_ENTRY(entry)] if entry.num_logs == 0));
}

#[test]
fn what_other_components_would_know_is_refused() {
    let mut client = Client::new(quiet());
    // CAMERA_INFORMATION and GIMBAL_MANAGER_INFORMATION: as by a real one they are accepted, and nothing comes but
    // words.
    for (id, what) in [(259.0, "camera"), (280.0, "gimbal")] {
        let answer = client.ask(&long(TARGET, MavCmd::MAV_CMD_REQUEST_MESSAGE, [id, 0.0, 0.0]));
        assert_eq!(acknowledgement(&answer).unwrap().result, MavResult::MAV_RESULT_ACCEPTED);
        assert_eq!(texts(&answer), [format!("There is no {what}")]);
    }
    // COMPONENT_METADATA, COMPONENT_INFORMATION.
    for id in [397.0, 395.0] {
        let answer = client.ask(&long(TARGET, MavCmd::MAV_CMD_REQUEST_MESSAGE, [id, 0.0, 0.0]));
        assert_eq!(acknowledgement(&answer).unwrap().result, MavResult::MAV_RESULT_FAILED);
        assert_eq!(texts(&answer), [format!("Message {id} is not available")]);
    }
    for command in [MavCmd::MAV_CMD_REQUEST_CAMERA_INFORMATION, MavCmd::MAV_CMD_REQUEST_STORAGE_INFORMATION] {
        assert_eq!(client.command_long(command, [1.0, 0.0, 0.0]), Some(MavResult::MAV_RESULT_UNSUPPORTED));
    }
}
