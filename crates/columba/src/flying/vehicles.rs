//! The simulated vehicles of a scenario.

use crate::config::Scenario;
use mavlink_bridge::LinkSettings;
use sim_vehicle::{
    Clock, HostSettings, LockstepSettings, NETWORK_VEHICLES_MAX, Personality, PortLayout, VehicleSettings, port_index,
};
use std::net::{IpAddr, Ipv4Addr, Ipv6Addr, SocketAddr};
use std::time::{Duration, SystemTime};

/// Time zero of a flight in simulated time, in microseconds since the Unix epoch: 2026-01-01, so that a flight's log is
/// the same whenever it is flown.
pub const LOCKSTEP_EPOCH_US: u64 = 1_767_225_600_000_000;

/// The system id of the vehicle of an index: in each network they begin again at one.
pub fn system_id(index: usize) -> u8 {
    (index % NETWORK_VEHICLES_MAX) as u8 + 1
}

/// The MAVLink network of the vehicle of an index, counted from one.
pub fn network(index: usize) -> usize {
    index / NETWORK_VEHICLES_MAX + 1
}

/// The address at which a client on this machine finds a socket that is bound to `address`: that of all interfaces is
/// none to send to.
pub fn reachable(address: SocketAddr) -> SocketAddr {
    let host = match address.ip() {
        IpAddr::V4(host) if host.is_unspecified() => IpAddr::V4(Ipv4Addr::LOCALHOST),
        IpAddr::V6(host) if host.is_unspecified() => IpAddr::V6(Ipv6Addr::LOCALHOST),
        host => host,
    };
    SocketAddr::new(host, address.port())
}

/// How many UDP ports the vehicles of a scenario have.
pub fn ports(scenario: &Scenario) -> usize {
    let last = scenario.starts.len().checked_sub(1);
    last.map_or(0, |last| port_index(last, scenario.link.vehicles_per_port) + 1)
}

/// How many sockets the vehicles of a scenario open, without those of TCP clients.
pub fn sockets(scenario: &Scenario) -> usize {
    let multicast = if scenario.link.multicast.is_some() { 2 } else { 0 };
    match scenario.link.layout {
        PortLayout::Columba => ports(scenario) * (1 + multicast),
        PortLayout::ArduPilot { .. } => scenario.starts.len() * (5 + multicast),
        PortLayout::Px4 { .. } => scenario.starts.len() * (2 + multicast),
    }
}

/// Settings of every vehicle of the scenario; telemetry goes to `ground` unasked.
pub fn vehicle_settings(scenario: &Scenario, ground: Option<SocketAddr>, clock_epoch_us: u64) -> Vec<VehicleSettings> {
    let autopilot = &scenario.autopilot;
    let parameters: Vec<(String, f32)> =
        scenario.parameters.iter().map(|(name, value)| (name.clone(), *value)).collect();
    let (files, _) = scenario.parameter_files.renamed_for(autopilot.personality);
    let parameter_files = if scenario.starts.len() > 1 { files.without_system_id() } else { files };
    let vehicle = |(index, start): (usize, &flight_model::State)| VehicleSettings {
        seed: scenario.seed,
        number: index as u64,
        system_id: system_id(index),
        personality: autopilot.personality,
        dynamics: scenario.dynamics_of(index),
        plant: scenario.plant_of(index),
        step: scenario.integration_step,
        start: *start,
        frame: scenario.frame,
        armed: autopilot.armed,
        on_ground: autopilot.on_ground,
        rates: autopilot.rates(),
        setpoint_timeout_s: autopilot.setpoint_timeout_s,
        loiter_radius_m: scenario.airframe_of(index).map_or(autopilot.loiter_radius_m, |own| own.loiter_radius_m),
        cruise_speed_mps: scenario
            .airframe_of(index)
            .map_or(autopilot.cruise_speed_mps, |own| Some(own.cruise_speed_mps)),
        files_shape_limits: scenario.files_shape_limits,
        clock_epoch_us,
        ground,
        stock_parameters: scenario.stock_parameters,
        parameter_files: parameter_files.clone(),
        default_parameters: parameters.clone(),
        ..VehicleSettings::default()
    };
    scenario.starts.iter().enumerate().map(vehicle).collect()
}

/// The same for a flight that our own controller leads: it leads ArduPlanes.
pub fn led_vehicle_settings(
    scenario: &Scenario,
    ground: Option<SocketAddr>,
    clock_epoch_us: u64,
) -> Vec<VehicleSettings> {
    let personality = Personality::ArduPlane;
    let vehicles = vehicle_settings(scenario, ground, clock_epoch_us).into_iter();
    let led = |settings: VehicleSettings| {
        let led_acceleration_mps2 = told_acceleration_mps2(&settings);
        VehicleSettings { personality, led_acceleration_mps2, ..settings }
    };
    vehicles.map(led).collect()
}

/// How fast a plant may change its speed by what a real autopilot is told with each setpoint; neither memory nor
/// SET_POSITION_TARGET_LOCAL_NED has a field for it. One that does not do more by itself is not told.
fn told_acceleration_mps2(settings: &VehicleSettings) -> f64 {
    let told_mps2 = settings.dynamics.response.acceleration_max_mps2;
    let is_told = settings.plant.is_some_and(|plant| told_mps2 < plant.speed.acceleration_max_mps2);
    if is_told { told_mps2 } else { f64::INFINITY }
}

/// The clock of a scenario's vehicles and what it shows at time zero, in microseconds since the Unix epoch: `speed`
/// times the wall clock, or simulated time where there is no speed.
pub fn clock(scenario: &Scenario, speed: Option<f64>) -> (Clock, u64) {
    match speed {
        Some(speed) => (Clock::RealTime { speed, tick: Duration::from_millis(5) }, unix_us()),
        None => {
            let lockstep = LockstepSettings { period: scenario.control_period, ..LockstepSettings::default() };
            (Clock::Lockstep(lockstep), LOCKSTEP_EPOCH_US)
        }
    }
}

/// The wall clock, in microseconds since the Unix epoch.
pub fn unix_us() -> u64 {
    SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).map_or(0, |time| time.as_micros() as u64)
}

/// The host of a scenario's vehicles.
pub fn host_settings(scenario: &Scenario, clock: Clock, base_port: u16, link: LinkSettings) -> HostSettings {
    let vehicles_per_port = scenario.link.vehicles_per_port;
    HostSettings { bind: scenario.link.host, base_port, vehicles_per_port, clock, link, ..HostSettings::default() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use flight_model::Airframe;

    #[test]
    fn a_plant_changes_its_speed_as_a_real_autopilot_is_told() {
        let told = |airframe: Airframe, told_mps2: f64| {
            let mut settings =
                VehicleSettings { dynamics: airframe.dynamics, plant: airframe.plant, ..VehicleSettings::default() };
            settings.dynamics.response.acceleration_max_mps2 = told_mps2;
            told_acceleration_mps2(&settings)
        };
        assert_eq!(told(Airframe::plane(), 0.4), 0.4);
        assert_eq!(told(Airframe::plane(), f64::INFINITY), f64::INFINITY, "at once");
        assert_eq!(told(Airframe::px4_plane(), 2.5), f64::INFINITY, "by itself");
        assert_eq!(told(Airframe::paper(), 0.4), f64::INFINITY, "Eq. 1");
    }

    #[test]
    fn a_socket_on_all_interfaces_is_found_on_loopback() {
        for (bound, found) in [
            ("0.0.0.0:14600", "127.0.0.1:14600"),
            ("[::]:14600", "[::1]:14600"),
            ("127.0.0.1:5", "127.0.0.1:5"),
            ("192.0.2.1:5", "192.0.2.1:5"),
        ] {
            assert_eq!(reachable(bound.parse().unwrap()), found.parse().unwrap());
        }
    }
}
