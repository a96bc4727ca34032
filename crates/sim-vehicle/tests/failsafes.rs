//! The battery's and the GPS's failsafes, to the second; the ground station's by its modes.
#![allow(clippy::unwrap_used)]

mod common;

use common::{Client, quiet, set_parameter, texts};
use mavlink_bridge::dialect::{HEARTBEAT_DATA, MavCmd, Message};
use sim_vehicle::{Mode, VehicleSettings};

fn client(parameters: &[(&str, f32)]) -> Client {
    let parameters = parameters.iter().map(|(name, value)| ((*name).to_owned(), *value)).collect();
    let mut client =
        Client::new(VehicleSettings { default_parameters: parameters, setpoint_timeout_s: 0.0, ..quiet() });
    client.ask(&Message::HEARTBEAT(HEARTBEAT_DATA::DEFAULT));
    client
}

/// Flies on, and gives the words of these seconds.
fn words(client: &mut Client, seconds: f64) -> Vec<String> {
    client.collect();
    client.fly(seconds);
    texts(&client.collect())
}

fn set(client: &mut Client, name: &str, value: f32) {
    client.ask(&set_parameter(name, value));
}

#[test]
fn a_low_voltage_counts_after_its_timer_and_a_dip_does_not() {
    let mut client = client(&[("BATT_LOW_VOLT", 11.0), ("BATT_LOW_TIMER", 5.0), ("BATT_FS_LOW_ACT", 1.0)]);
    set(&mut client, "SIM_BATT_VOLTAGE", 10.5);
    assert!(words(&mut client, 4.9).is_empty());
    set(&mut client, "SIM_BATT_VOLTAGE", 12.6);
    assert!(words(&mut client, 1.0).is_empty());
    set(&mut client, "SIM_BATT_VOLTAGE", 10.5);
    assert!(words(&mut client, 4.9).is_empty());
    let said = words(&mut client, 0.3);
    assert!(said.len() == 1 && said[0].starts_with("Battery 1 is low 10.2"), "{said:?}");
    assert!(client.vehicle.mode() == Mode::Rtl && client.vehicle.is_in_failsafe());
    assert!(words(&mut client, 60.0).is_empty(), "it is said once");
}

#[test]
fn without_a_timer_or_a_monitor_nothing_counts() {
    for parameters in
        [[("BATT_LOW_TIMER", 0.0), ("BATT_LOW_VOLT", 11.0)], [("BATT_MONITOR", 0.0), ("BATT_LOW_VOLT", 11.0)]]
    {
        let mut client = client(&parameters);
        set(&mut client, "SIM_BATT_VOLTAGE", 10.0);
        assert!(words(&mut client, 60.0).is_empty());
        assert!(!client.vehicle.is_in_failsafe());
    }
}

#[test]
fn flying_empties_a_battery_that_holds_something() {
    let mut client = client(&[("SIM_BATT_CAP_AH", 0.5), ("BATT_CAPACITY", 500.0), ("BATT_CRT_MAH", 100.0)]);
    let said = words(&mut client, 600.0);
    assert!(said[0].starts_with("Battery 1 is critical"), "{said:?}");
    assert!(client.vehicle.mode() == Mode::Guided && client.vehicle.is_in_failsafe());
}

#[test]
fn the_ground_stations_loss_is_by_modes_as_in_arduplane() {
    for (enabled, action, mode, after) in [
        (1.0, 0.0, Mode::Guided, Mode::Guided),
        (1.0, 1.0, Mode::Guided, Mode::Rtl),
        (1.0, 0.0, Mode::Loiter, Mode::Rtl),
        (2.0, 0.0, Mode::Cruise, Mode::Rtl),
        (3.0, 1.0, Mode::Loiter, Mode::Loiter),
        (0.0, 1.0, Mode::Loiter, Mode::Loiter),
    ] {
        let mut client = client(&[("FS_GCS_ENABL", enabled), ("FS_LONG_ACTN", action)]);
        let set_mode = [1.0, mode.number() as f32, 0.0];
        client.command_long(MavCmd::MAV_CMD_DO_SET_MODE, set_mode);
        let said = words(&mut client, 10.0);
        assert_eq!(client.vehicle.mode(), after, "{enabled} {action} {mode}");
        let is_said = said.iter().any(|text| text.starts_with("GCS Failsafe On"));
        assert_eq!(is_said, enabled == 1.0 || enabled == 2.0, "{said:?}");
    }
}

#[test]
fn a_gps_lost_and_found_is_said_and_the_mode_stays() {
    let mut client = client(&[]);
    set(&mut client, "SIM_GPS1_NUMSATS", 3.0);
    assert_eq!(words(&mut client, 1.0), ["GPS 1: no fix, Dead Reckoning started"]);
    assert!(client.vehicle.mode() == Mode::Guided && client.vehicle.is_in_failsafe());
    set(&mut client, "SIM_GPS1_NUMSATS", 10.0);
    assert_eq!(words(&mut client, 1.0), ["GPS 1: fix again, Dead Reckoning stopped"]);
    assert!(!client.vehicle.is_in_failsafe());
}

#[test]
fn without_its_engine_it_glides_and_with_it_goes_on() {
    let mut client = client(&[("SIM_ENGINE_MUL", 0.1)]);
    set(&mut client, "SIM_ENGINE_FAIL", 4.0);
    assert_eq!(words(&mut client, 10.0), ["Engine failed, gliding"]);
    assert!(client.vehicle.is_in_failsafe());
    let low_m = client.vehicle.state().altitude_m;
    assert!(low_m < 48.0, "{low_m}");
    // A third of the power is more than 10 m/s need.
    set(&mut client, "SIM_ENGINE_MUL", 0.33);
    assert_eq!(words(&mut client, 20.0), ["Engine runs again"]);
    assert!((client.vehicle.state().altitude_m - 50.0).abs() < 0.5);
    assert!(!client.vehicle.is_in_failsafe());
}

#[test]
fn a_gps_and_a_battery_stand_against_arming() {
    for (name, value, reason) in [
        ("SIM_GPS_FAIL", 1.0, "Arm: GPS 1: Bad fix"),
        ("BATT_LOW_VOLT", 13.0, "Arm: Battery 1 low voltage failsafe"),
        ("BATT_CRT_MAH", 3500.0, "Arm: Battery 1 critical capacity failsafe"),
    ] {
        let parameters = vec![(name.to_owned(), value)];
        let mut client = Client::new(VehicleSettings { default_parameters: parameters, armed: false, ..quiet() });
        client.ask(&Message::HEARTBEAT(HEARTBEAT_DATA::DEFAULT));
        let said = client.ask(&common::long(common::TARGET, MavCmd::MAV_CMD_COMPONENT_ARM_DISARM, [1.0, 0.0, 0.0]));
        assert_eq!(texts(&said), [reason]);
        assert!(!client.vehicle.is_armed());
        client.command_long(MavCmd::MAV_CMD_COMPONENT_ARM_DISARM, [1.0, 21196.0, 0.0]);
        assert!(client.vehicle.is_armed());
    }
}
