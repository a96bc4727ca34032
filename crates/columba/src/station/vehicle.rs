//! One autopilot as the station hears it.

use super::limits::narrow;
use super::telemetry::Stream;
use super::track::{Sample, Track};
use controller::Present;
use flight_model::{Dynamics, Geodetic, LocalFrame, State, wrap_pi};
use mavlink_bridge::Target;
use mavlink_bridge::dialect::{
    AUTOPILOT_VERSION_DATA, COMMAND_ACK_DATA, EXTENDED_SYS_STATE_DATA, GLOBAL_POSITION_INT_DATA,
    GPS_GLOBAL_ORIGIN_DATA, HEARTBEAT_DATA, HOME_POSITION_DATA, LOCAL_POSITION_NED_DATA, MavLandedState, MavModeFlag,
    MavState, MavSysStatusSensor, Message, PARAM_VALUE_DATA, STATUSTEXT_DATA, SYS_STATUS_DATA,
};
use mavlink_bridge::kind::{AtEnd, AutopilotKind, Driver, Seen, SoftwareVersion, UnflyableKind, VehicleLimits};
use mavlink_bridge::link::{Peer, VehicleClock};
use std::collections::{BTreeMap, VecDeque};
use std::time::Duration;

/// A way by which a vehicle is reached.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Route {
    /// Index of the link.
    pub link: usize,
    /// Who is at the other end.
    pub peer: Peer,
}

/// What is known of a route.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RouteState {
    /// When a frame of the vehicle last came by it.
    pub heard: Duration,
    /// Whether what comes by it is taken for the vehicle's own.
    pub trust: Trust,
    /// The last round trip by it.
    pub round_trip: Option<Duration>,
}

/// Whether a route leads to the vehicle, or to another autopilot with the same system id.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Trust {
    /// It is the vehicle's: it was there before the take-off, or its positions are the vehicle's.
    Own,
    /// It is new in flight: nothing by it is taken before its positions have shown whose it is.
    New,
    /// Another autopilot's, by its positions: nothing by it is taken.
    Other,
}

/// An order that was given and is not answered yet.
#[derive(Clone, Debug)]
pub struct Order {
    /// The command's number.
    pub command: u32,
    /// When it was last sent.
    pub sent: Duration,
    /// How often.
    pub tries: u32,
    /// The answer, if one came.
    pub answer: Option<String>,
    /// The message, to be sent again.
    pub message: Message,
}

/// An order to hold has reached the vehicle, or never will, after this.
const HOLD_SETTLES: Duration = Duration::from_secs(1);
/// So many ways to a vehicle are remembered: addresses are easily forged, and each is spoken to.
const ROUTES_MAX: usize = 16;
/// Words of a vehicle are remembered for so long.
const TEXTS_KEPT: usize = 8;

/// One autopilot.
pub struct Vehicle {
    /// Its system and autopilot component.
    pub target: Target,
    /// Where it stands in the scenario; none for a stranger.
    pub slot: Option<usize>,
    /// How it is commanded, or why it cannot be.
    pub driver: Option<Result<Driver, UnflyableKind>>,
    /// Version of its software.
    pub version: Option<SoftwareVersion>,
    /// The hardware's own number.
    pub uid: u64,
    /// The ways by which it is heard.
    pub routes: BTreeMap<Route, RouteState>,
    /// When its first heartbeat came.
    pub first_heartbeat: Option<Duration>,
    /// When its last heartbeat came.
    pub heartbeat: Option<Duration>,
    /// Whether it is armed.
    pub armed: bool,
    /// HEARTBEAT.custom_mode.
    pub custom_mode: u32,
    /// Whether its system status says failsafe or emergency.
    pub critical: bool,
    /// EXTENDED_SYS_STATE.
    pub landed_state: Option<MavLandedState>,
    /// Above its home, m.
    pub height_m: f64,
    /// Where it was.
    pub track: Track,
    /// Which time its stamps mean.
    pub clock: VehicleClock,
    /// Where it is, and will be when a command acts.
    pub present: Present,
    /// Its home.
    pub home: Option<Geodetic>,
    /// GPS_GLOBAL_ORIGIN.
    pub origin: Option<Geodetic>,
    /// Altitude of its local origin above mean sea level, m.
    pub local_origin_amsl_m: Option<f64>,
    /// The last LOCAL_POSITION_NED: stamp, north, east, down.
    local: Option<(u32, [f64; 3])>,
    /// By which route and when the last position came.
    global_came: Option<(Route, Duration)>,
    /// The last GLOBAL_POSITION_INT, before it is brought into a frame.
    pub global: Option<GLOBAL_POSITION_INT_DATA>,
    /// Battery, percent.
    pub battery_percent: Option<i8>,
    /// Whether its pre-arm checks pass, where it tells.
    pub prearm_ok: Option<bool>,
    /// Its last words, with their time.
    pub texts: VecDeque<(Duration, String)>,
    /// Parameters that were read; none: it does not have it.
    pub parameters: BTreeMap<String, Option<f64>>,
    /// Orders by their purpose.
    pub orders: BTreeMap<&'static str, Order>,
    /// What comes of it, by message id.
    pub streams: BTreeMap<u32, Stream>,
    /// When telemetry was last asked for, and how often.
    pub asked: Option<(Duration, u32)>,
    /// Limits that its parameters set, once they are read.
    pub limits: Option<VehicleLimits>,
    /// Whether it has been in the mode in which it follows our setpoints.
    pub entered: bool,
    held: Option<Duration>,
    mode_heard: Option<Duration>,
    /// How often in a row it has refused each command of a setpoint.
    pub refusals: [u32; 3],
    /// Why it is flown no more; it is a neighbour to be avoided then.
    pub released: Option<String>,
    /// Whether the operator keeps it out.
    pub dropped: bool,
    /// What it does then.
    pub dropped_to: AtEnd,
    /// Whether the operator has paused it alone.
    pub paused: bool,
    /// What it was told last, and when.
    pub setpoint: Option<flight_model::Setpoint>,
    /// When its setpoint was last sent.
    pub setpoint_sent: Option<Duration>,
    /// Whether two autopilots speak with this system id.
    pub is_doubled: bool,
    /// Frames that never came, and frames that came.
    pub frames: [u64; 2],
    /// When a frame came that no other had overtaken.
    newest_heard: Option<Duration>,
}

impl Vehicle {
    /// An autopilot of which nothing is heard yet.
    pub fn new(system_id: u8, component_id: u8) -> Self {
        Self {
            target: Target { system_id, component_id },
            slot: None,
            driver: None,
            version: None,
            uid: 0,
            routes: BTreeMap::new(),
            first_heartbeat: None,
            heartbeat: None,
            armed: false,
            custom_mode: 0,
            critical: false,
            landed_state: None,
            height_m: 0.0,
            track: Track::default(),
            clock: VehicleClock::default(),
            present: Present::new(&Dynamics::default()),
            home: None,
            origin: None,
            local_origin_amsl_m: None,
            local: None,
            global_came: None,
            global: None,
            battery_percent: None,
            prearm_ok: None,
            texts: VecDeque::new(),
            parameters: BTreeMap::new(),
            orders: BTreeMap::new(),
            streams: BTreeMap::new(),
            asked: None,
            limits: None,
            entered: false,
            held: None,
            mode_heard: None,
            refusals: [0; 3],
            released: None,
            dropped: false,
            dropped_to: AtEnd::Loiter,
            paused: false,
            setpoint: None,
            setpoint_sent: None,
            is_doubled: false,
            frames: [0; 2],
            newest_heard: None,
        }
    }

    /// How the controller reckons that it flies: a model, within the vehicle's own limits.
    pub fn flies_by(&mut self, mut dynamics: Dynamics, expected_speed_mps: f64) {
        if let Some(own) = &self.limits {
            narrow(&mut dynamics.limits, own, expected_speed_mps);
        }
        let kind = self.driver().map(Driver::kind);
        let is_plane = matches!(kind, Some(AutopilotKind::ArduPlane | AutopilotKind::Px4FixedWing));
        self.present.set_dynamics(&dynamics);
        self.present.set_holds_ground_speed(!is_plane);
        self.present.set_settles_slowly(is_plane);
    }

    /// Its system id.
    pub fn id(&self) -> u8 {
        self.target.system_id
    }

    /// How it is commanded, where it can be.
    pub fn driver(&self) -> Option<&Driver> {
        self.driver.as_ref()?.as_ref().ok()
    }

    /// Whether the station may command it: its mode has not been changed by others.
    pub fn is_ours(&self) -> bool {
        self.slot.is_some() && self.released.is_none() && !self.dropped
    }

    /// Whether it is in the mode in which it follows setpoints.
    pub fn follows(&self) -> bool {
        self.driver().is_some_and(|driver| driver.follows_setpoints(self.custom_mode))
    }

    /// Whether it is in the mode in which it holds where it is.
    pub fn holds(&self) -> bool {
        self.driver().is_some_and(|driver| driver.end_mode(AtEnd::Loiter) == Some(self.custom_mode))
    }

    /// Notes that it was told to hold.
    pub fn was_told_to_hold(&mut self, now: Duration) {
        self.held = Some(now);
    }

    /// Whether it follows setpoints, and no order to hold that is still under way can change that: its mode was heard
    /// well after the last such order.
    pub fn follows_for_good(&self) -> bool {
        let is_settled = match (self.held, self.mode_heard) {
            (None, _) => true,
            (Some(held), Some(heard)) => heard >= held + HOLD_SETTLES,
            (Some(_), None) => false,
        };
        self.follows() && is_settled
    }

    /// The autopilot's own name of its mode.
    pub fn mode_name(&self) -> String {
        self.driver().map_or_else(|| format!("mode {}", self.custom_mode), |driver| driver.mode_name(self.custom_mode))
    }

    /// Whether it stands on the ground, as far as anybody knows.
    pub fn on_ground(&self) -> bool {
        match self.landed_state {
            // Columba's vehicles can wait in the air, disarmed.
            Some(MavLandedState::MAV_LANDED_STATE_ON_GROUND) => self.height_m < 10.0,
            Some(MavLandedState::MAV_LANDED_STATE_IN_AIR | MavLandedState::MAV_LANDED_STATE_TAKEOFF) => false,
            _ => {
                let speed_mps = self.track.last().map_or(0.0, |sample| sample.state.speed_mps);
                self.height_m < 3.0 && speed_mps < 3.0
            }
        }
    }

    /// What a driver needs to see of it.
    pub fn seen(&self) -> Seen {
        Seen {
            armed: self.armed,
            custom_mode: self.custom_mode,
            on_ground: self.on_ground(),
            height_m: self.height_m,
            climb_mps: self.track.last().map_or(0.0, |sample| sample.state.climb_mps),
        }
    }

    /// The freshest way to it.
    pub fn route(&self) -> Option<Route> {
        let own = self.routes.iter().filter(|(_, state)| state.trust == Trust::Own);
        own.max_by_key(|(_, state)| state.heard).map(|(route, _)| *route)
    }

    /// Whether a message that came by a route is the vehicle's own. A second autopilot with the same system id that
    /// comes up in flight is none of the vehicle: neither its positions nor its modes count. Before the take-off that
    /// is a fault (`is_doubled`).
    pub fn owns(&mut self, message: &Message, route: Route, is_flying: bool, now: Duration) -> bool {
        const SILENT: Duration = Duration::from_millis(1500);
        let speaks = self.routes.iter().any(|(other, state)| {
            *other != route && state.trust == Trust::Own && now.saturating_sub(state.heard) < SILENT
        });
        // A vehicle that is heard by no other way has a new address, and is itself.
        let first = if is_flying && speaks { Trust::New } else { Trust::Own };
        self.make_room_for(route);
        let state = self.routes.entry(route).or_insert(RouteState { heard: now, trust: first, round_trip: None });
        state.heard = now;
        let mut trust = if speaks || state.trust == Trust::Other { state.trust } else { Trust::Own };
        if let Message::GLOBAL_POSITION_INT(data) = message {
            match (self.contradicts_another_way(data, route, now), is_flying) {
                (true, false) => self.is_doubled = true,
                (true, true) if trust == Trust::New => trust = Trust::Other,
                (false, _) if trust == Trust::New => trust = Trust::Own,
                _ => {}
            }
        }
        if let Some(state) = self.routes.get_mut(&route) {
            state.trust = trust;
        }
        trust == Trust::Own
    }

    /// Whether newer frames came before this one, a moment ago. After a longer pause nobody can tell: of numbers from 0
    /// to 255 the one half is older than the other.
    pub fn is_overtaken(&mut self, is_newest: bool, now: Duration) -> bool {
        const MOMENT: Duration = Duration::from_secs(1);
        if is_newest {
            self.newest_heard = Some(now);
            return false;
        }
        self.newest_heard.is_some_and(|heard| now.saturating_sub(heard) < MOMENT)
    }

    /// One way too many displaces another: before all one that is not known to be the vehicle's, else the one that was
    /// silent longest.
    fn make_room_for(&mut self, route: Route) {
        if self.routes.len() < ROUTES_MAX || self.routes.contains_key(&route) {
            return;
        }
        let least = self.routes.iter().min_by_key(|(_, state)| (state.trust == Trust::Own, state.heard));
        if let Some(least) = least.map(|(route, _)| *route) {
            self.routes.remove(&least);
        }
    }

    /// Age of its last position, s.
    pub fn age_s(&self, now_s: f64) -> Option<f64> {
        self.track.last().map(|last| (now_s - last.at_s).max(0.0))
    }

    /// Its last words since a time.
    pub fn words_since(&self, since: Duration) -> Option<&str> {
        self.texts.iter().rev().find(|(at, _)| *at >= since).map(|(_, text)| text.as_str())
    }

    /// Takes a message that came by a route; says whether its position changed.
    pub fn hear(&mut self, message: &Message, now: Duration, frame: &LocalFrame) -> bool {
        match message {
            Message::HEARTBEAT(data) => self.hear_heartbeat(data, now),
            Message::CURRENT_MODE(data) => self.hear_mode(data.custom_mode, now),
            Message::AUTOPILOT_VERSION(data) => self.hear_version(data),
            Message::GLOBAL_POSITION_INT(data) => return self.hear_global(data, now, frame),
            Message::ATTITUDE(data) => {
                if let Some(at_s) = self.flown_at_s(data.time_boot_ms, now) {
                    self.present.hear_heading(at_s, f64::from(data.yaw));
                }
            }
            Message::LOCAL_POSITION_NED(data) => self.hear_local(data),
            Message::EXTENDED_SYS_STATE(EXTENDED_SYS_STATE_DATA { landed_state, .. }) => {
                self.landed_state = Some(*landed_state);
            }
            Message::SYS_STATUS(data) => self.hear_status(data),
            Message::HOME_POSITION(data) => self.home = Some(home(data)),
            Message::GPS_GLOBAL_ORIGIN(data) => self.origin = Some(origin(data)),
            Message::VFR_HUD(data) => self.hear_airspeed(f64::from(data.airspeed), now),
            Message::STATUSTEXT(data) => self.hear_text(data, now),
            Message::PARAM_VALUE(data) => self.hear_parameter(data),
            Message::COMMAND_ACK(data) => self.hear_answer(data),
            _ => {}
        }
        false
    }

    fn hear_mode(&mut self, custom_mode: u32, now: Duration) {
        self.custom_mode = custom_mode;
        self.mode_heard = Some(now);
    }

    fn hear_heartbeat(&mut self, data: &HEARTBEAT_DATA, now: Duration) {
        self.first_heartbeat.get_or_insert(now);
        self.heartbeat = Some(now);
        self.armed = data.base_mode.contains(MavModeFlag::MAV_MODE_FLAG_SAFETY_ARMED);
        self.hear_mode(data.custom_mode, now);
        self.critical = matches!(data.system_status, MavState::MAV_STATE_CRITICAL | MavState::MAV_STATE_EMERGENCY);
        if self.driver.is_none() {
            self.driver = Some(Driver::for_autopilot(data.autopilot, data.mavtype, self.version));
        }
    }

    fn hear_version(&mut self, data: &AUTOPILOT_VERSION_DATA) {
        let version = SoftwareVersion::from_wire(data.flight_sw_version);
        if self.version != Some(version) {
            self.version = Some(version);
            if let Some(driver) = self.driver() {
                self.driver = Some(Ok(Driver::new(driver.kind(), Some(version))));
            }
        }
        self.uid = data.uid;
    }

    fn hear_global(&mut self, data: &GLOBAL_POSITION_INT_DATA, now: Duration, frame: &LocalFrame) -> bool {
        // Before its estimator has a fix, ArduPilot tells places within metres of 0, 0.
        if data.lat.abs() < 10_000 && data.lon.abs() < 10_000 {
            return false;
        }
        let at_s = self.flown_at_s(data.time_boot_ms, now);
        self.height_m = f64::from(data.relative_alt) * 1e-3;
        if let Some((stamp, [_, _, down_m])) = self.local
            && data.time_boot_ms.abs_diff(stamp) <= 250
            && self.driver().is_some_and(|driver| driver.kind() != AutopilotKind::ArduPlane)
        {
            self.local_origin_amsl_m = Some(f64::from(data.alt) * 1e-3 + down_m);
        }
        self.global = Some(data.clone());
        let Some(at_s) = at_s else { return false };
        let state = state(data, frame);
        self.present.set_command_delay_s(self.clock.command_delay_s().unwrap_or(0.0));
        self.present.hear(at_s, &state);
        self.track.push(Sample { at_s, state })
    }

    /// The ground's time at which a stamp of the vehicle was put on, s.
    fn flown_at_s(&mut self, boot_ms: u32, now: Duration) -> Option<f64> {
        let reboots = self.clock.reboots();
        self.clock.hear(boot_ms, now);
        if self.clock.reboots() != reboots {
            self.track.clear();
            self.present.clear();
        }
        self.clock.ground_time_s(boot_ms)
    }

    /// Whether a position by one route contradicts the last one by another: two autopilots speak with one system id
    /// then.
    fn contradicts_another_way(&mut self, data: &GLOBAL_POSITION_INT_DATA, route: Route, now: Duration) -> bool {
        let before = self.global_came.replace((route, now));
        let (Some(last), Some((other, heard))) = (&self.global, before) else { return false };
        let since_s = now.saturating_sub(heard).as_secs_f64();
        if other == route || since_s > 1.0 {
            return false;
        }
        const METRES_PER_UNIT: f64 = 0.011_132;
        let north_m = f64::from(data.lat.abs_diff(last.lat)) * METRES_PER_UNIT;
        let east_m =
            f64::from(data.lon.abs_diff(last.lon)) * METRES_PER_UNIT * libm::cos(place(data).latitude_deg.to_radians());
        let speed_mps = 0.01 * libm::hypot(f64::from(data.vx), f64::from(data.vy));
        let moved_m = 5.0 + 2.0 * speed_mps * since_s.max(0.5);
        let stamps_s = 1e-3 * f64::from(data.time_boot_ms.abs_diff(last.time_boot_ms));
        libm::hypot(north_m, east_m) > moved_m || stamps_s > 3.0
    }

    fn hear_local(&mut self, data: &LOCAL_POSITION_NED_DATA) {
        self.local = Some((data.time_boot_ms, [data.x, data.y, data.z].map(f64::from)));
    }

    fn hear_status(&mut self, data: &SYS_STATUS_DATA) {
        self.battery_percent = (data.battery_remaining >= 0).then_some(data.battery_remaining);
        let prearm = MavSysStatusSensor::MAV_SYS_STATUS_PREARM_CHECK;
        if data.onboard_control_sensors_present.contains(prearm) {
            self.prearm_ok = Some(data.onboard_control_sensors_health.contains(prearm));
        }
    }

    /// On the ground there is no airspeed, and a sensor tells its noise.
    fn hear_airspeed(&mut self, airspeed_mps: f64, now: Duration) {
        if self.track.last().is_some_and(|sample| sample.state.speed_mps > 3.0) {
            self.present.hear_airspeed(now.as_secs_f64(), airspeed_mps);
        }
    }

    fn hear_text(&mut self, data: &STATUSTEXT_DATA, now: Duration) {
        let text = data.text.to_str().unwrap_or("").trim().to_owned();
        if text.is_empty() {
            return;
        }
        self.texts.push_back((now, text));
        if self.texts.len() > TEXTS_KEPT {
            self.texts.pop_front();
        }
    }

    fn hear_parameter(&mut self, data: &PARAM_VALUE_DATA) {
        use mavlink_bridge::dialect::MavParamType;
        let Ok(name) = data.param_id.to_str() else { return };
        let is_px4 = self
            .driver()
            .is_some_and(|driver| matches!(driver.kind(), AutopilotKind::Px4FixedWing | AutopilotKind::Px4Multicopter));
        let value = match data.param_type {
            MavParamType::MAV_PARAM_TYPE_INT32 if is_px4 => f64::from(data.param_value.to_bits() as i32),
            _ => f64::from(data.param_value),
        };
        if let Some(known) = self.parameters.get_mut(name) {
            *known = Some(value);
        }
    }

    fn hear_answer(&mut self, data: &COMMAND_ACK_DATA) {
        let command = data.command as u32;
        let result = format!("{:?}", data.result);
        let result = result.strip_prefix("MAV_RESULT_").unwrap_or(&result).to_owned();
        for order in self.orders.values_mut().filter(|order| order.command == command) {
            order.answer = Some(result.clone());
        }
    }

    /// By how much its own two positions contradict each other, m: the global one, and the local one from its own
    /// origin.
    pub fn contradiction_m(&self) -> Option<f64> {
        let (stamp, [north_m, east_m, _]) = self.local?;
        let (global, origin) = (self.global.as_ref()?, self.origin?);
        if global.time_boot_ms.abs_diff(stamp) > 250 || (north_m == 0.0 && east_m == 0.0) {
            return None;
        }
        let state = state(global, &LocalFrame::new(origin));
        let moved_m = 0.25 * state.speed_mps;
        let off_m = libm::hypot(state.x_m - north_m, state.y_m - east_m);
        Some((off_m - moved_m).max(0.0))
    }

    /// Where it last said that it was, WGS-84.
    pub fn place(&self) -> Option<Geodetic> {
        self.global.as_ref().map(place)
    }
}

/// The place of a GLOBAL_POSITION_INT.
fn place(data: &GLOBAL_POSITION_INT_DATA) -> Geodetic {
    Geodetic {
        latitude_deg: f64::from(data.lat) * 1e-7,
        longitude_deg: f64::from(data.lon) * 1e-7,
        altitude_amsl_m: f64::from(data.alt) * 1e-3,
    }
}

/// GLOBAL_POSITION_INT in a local frame, at full precision
/// (<https://mavlink.io/en/messages/common.html#GLOBAL_POSITION_INT>). A vehicle that stands has the course of its
/// nose.
pub fn state(data: &GLOBAL_POSITION_INT_DATA, frame: &LocalFrame) -> State {
    let (x_m, y_m, altitude_m) = frame.to_local(&place(data));
    let (north_mps, east_mps) = (0.01 * f64::from(data.vx), 0.01 * f64::from(data.vy));
    let speed_mps = (north_mps * north_mps + east_mps * east_mps).sqrt();
    let course_rad = if speed_mps < 0.3 && data.hdg != u16::MAX {
        (0.01 * f64::from(data.hdg)).to_radians()
    } else {
        libm::atan2(east_mps, north_mps)
    };
    State { x_m, y_m, altitude_m, speed_mps, course_rad: wrap_pi(course_rad), climb_mps: -0.01 * f64::from(data.vz) }
}

fn home(data: &HOME_POSITION_DATA) -> Geodetic {
    geodetic(data.latitude, data.longitude, data.altitude)
}

fn origin(data: &GPS_GLOBAL_ORIGIN_DATA) -> Geodetic {
    geodetic(data.latitude, data.longitude, data.altitude)
}

fn geodetic(latitude: i32, longitude: i32, altitude_mm: i32) -> Geodetic {
    Geodetic {
        latitude_deg: f64::from(latitude) * 1e-7,
        longitude_deg: f64::from(longitude) * 1e-7,
        altitude_amsl_m: f64::from(altitude_mm) * 1e-3,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use mavlink_bridge::dialect::{MavAutopilot, MavType};

    #[test]
    fn forged_addresses_do_not_displace_the_way_to_it() {
        let beat = Message::HEARTBEAT(HEARTBEAT_DATA::DEFAULT);
        let way = |port: u16| Route { link: 0, peer: Peer::Address(([127, 0, 0, 1], port).into()) };
        let mut vehicle = Vehicle::new(1, 1);
        assert!(vehicle.owns(&beat, way(1), false, Duration::ZERO));
        for port in 1000..5000 {
            let now = Duration::from_millis(u64::from(port));
            vehicle.owns(&beat, way(1), true, now);
            assert!(!vehicle.owns(&beat, way(port), true, now), "nobody knows whose that is");
        }
        assert_eq!(vehicle.routes.len(), ROUTES_MAX);
        assert_eq!(vehicle.route(), Some(way(1)));
    }

    #[test]
    fn a_mode_heard_before_an_order_to_hold_arrived_proves_nothing() {
        let guided = |vehicle: &mut Vehicle, at_s: f64| {
            let heartbeat = HEARTBEAT_DATA {
                custom_mode: 15,
                autopilot: MavAutopilot::MAV_AUTOPILOT_ARDUPILOTMEGA,
                mavtype: MavType::MAV_TYPE_FIXED_WING,
                ..HEARTBEAT_DATA::DEFAULT
            };
            vehicle.hear(
                &Message::HEARTBEAT(heartbeat),
                Duration::from_secs_f64(at_s),
                &LocalFrame::new(Geodetic { latitude_deg: 39.98, longitude_deg: 116.34, altitude_amsl_m: 50.0 }),
            );
        };
        let mut vehicle = Vehicle::new(1, 1);
        guided(&mut vehicle, 10.0);
        assert!(vehicle.follows_for_good());
        vehicle.was_told_to_hold(Duration::from_secs_f64(10.1));
        assert!(vehicle.follows() && !vehicle.follows_for_good());
        guided(&mut vehicle, 10.9);
        assert!(!vehicle.follows_for_good());
        guided(&mut vehicle, 11.2);
        assert!(vehicle.follows_for_good());
    }
}
