//! One autopilot as the station knows it, a part of it in each file: the ways to it ([routes]), what it has told
//! ([heard]), where it was ([track], [velocity]), what it was asked for ([requests]) and told to do ([orders]), and
//! whose it is ([custody]).

pub mod custody;
pub mod heard;
mod limits;
pub mod orders;
pub mod place;
pub mod requests;
pub mod routes;
pub mod track;
pub mod velocity;

use controller::{Estimate, Present};
use custody::Custody;
use flight_model::{Dynamics, LocalFrame, Setpoint};
use heard::Heard;
pub use limits::narrow;
use mavlink_bridge::Target;
use mavlink_bridge::dialect::{AUTOPILOT_VERSION_DATA, GLOBAL_POSITION_INT_DATA, MavLandedState, Message};
use mavlink_bridge::kind::{AtEnd, AutopilotKind, Driver, Seen, SoftwareVersion, UnflyableKind, VehicleLimits};
use mavlink_bridge::link::VehicleClock;
use nalgebra::Vector2;
use orders::{ModeHeard, Orders, Refusal};
use requests::{Carried, Known, Requests};
use routes::{Route, Routes};
use std::time::Duration;
use track::{Sample, Track};
use velocity::VelocityOffset;

/// On the ground there is no airspeed, and a sensor tells its noise: below this ground speed none is taken, m/s.
const AIRSPEED_FROM_MPS: f64 = 3.0;

/// One autopilot.
pub struct Vehicle {
    target: Target,
    /// Where it stands in the scenario; none for a stranger.
    slot: Option<usize>,
    /// How it is commanded, or why it cannot be.
    driver: Option<Result<Driver, UnflyableKind>>,
    version: Option<SoftwareVersion>,
    uid: u64,
    heard: Heard,
    routes: Routes,
    /// Which time its stamps mean.
    clock: VehicleClock,
    /// Where it was.
    track: Track,
    velocity_offset: VelocityOffset,
    /// Where it is, and will be when a command acts.
    present: Present,
    requests: Requests,
    orders: Orders,
    custody: Custody,
    /// Frames that never came, and frames that came.
    frames: [u64; 2],
    /// When a frame came that no newer one had overtaken.
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
            heard: Heard::default(),
            routes: Routes::default(),
            clock: VehicleClock::default(),
            track: Track::default(),
            velocity_offset: VelocityOffset::default(),
            present: Present::new(&Dynamics::default()),
            requests: Requests::default(),
            orders: Orders::default(),
            custody: Custody::default(),
            frames: [0; 2],
            newest_heard: None,
        }
    }

    /// Its system id.
    pub fn id(&self) -> u8 {
        self.target.system_id
    }

    /// Its system and autopilot component.
    pub fn target(&self) -> Target {
        self.target
    }

    /// Where it stands in the scenario; none for a stranger.
    pub fn slot(&self) -> Option<usize> {
        self.slot
    }

    /// Gives it a place in the scenario.
    pub fn take_slot(&mut self, slot: Option<usize>) {
        self.slot = slot;
    }

    /// How it is commanded, where it can be.
    pub fn driver(&self) -> Option<&Driver> {
        self.driver.as_ref()?.as_ref().ok()
    }

    /// How it is commanded, or why it cannot be; none before its first heartbeat.
    pub fn flyable(&self) -> Option<&Result<Driver, UnflyableKind>> {
        self.driver.as_ref()
    }

    /// Version of its software.
    pub fn version(&self) -> Option<SoftwareVersion> {
        self.version
    }

    /// The hardware's own number.
    pub fn uid(&self) -> u64 {
        self.uid
    }

    /// What it has told.
    pub fn heard(&self) -> &Heard {
        &self.heard
    }

    /// The ways to it.
    pub fn routes(&self) -> &Routes {
        &self.routes
    }

    /// Which time its stamps mean.
    pub fn clock(&self) -> &VehicleClock {
        &self.clock
    }

    /// Where it was.
    pub fn track(&self) -> &Track {
        &self.track
    }

    /// With which velocity its position moves, less the velocity that it tells and holds (north, east), m/s.
    pub fn drift_mps(&self) -> Vector2<f64> {
        self.velocity_offset.drift_mps()
    }

    /// Where it is, and will be when a command acts.
    pub fn present(&self) -> &Present {
        &self.present
    }

    /// Where it will be at a time on the ground's clock, s; remembered, so that it can be judged by what comes.
    pub fn foresee(&mut self, at_s: f64) -> Option<Estimate> {
        self.present.foresee(at_s)
    }

    /// Limits that its parameters set, once they are read.
    pub fn limits(&self) -> Option<VehicleLimits> {
        self.requests.limits()
    }

    /// How often its telemetry was asked for.
    pub fn times_asked(&self) -> u32 {
        self.requests.times()
    }

    /// What it was told.
    pub fn orders(&self) -> &Orders {
        &self.orders
    }

    /// Takes note of an order that is to be given for a purpose now; whether it is due ([`Orders::give`]). By `all_at`
    /// all that vehicles told is read.
    pub fn is_due(&mut self, purpose: &'static str, message: &Message, all_at: Duration, now: Duration) -> bool {
        self.orders.give(purpose, message, ModeHeard { last: self.heard.mode_heard, all_at }, now)
    }

    /// Forgets an order that was followed.
    pub fn has_followed(&mut self, purpose: &str) {
        self.orders.forget(purpose);
    }

    /// Whose it is.
    pub fn custody(&self) -> &Custody {
        &self.custody
    }

    /// Whose it is, to be changed.
    pub fn custody_mut(&mut self) -> &mut Custody {
        &mut self.custody
    }

    /// Frames of it that came, and frames that never did.
    pub fn frames(&self) -> (u64, u64) {
        (self.frames[1], self.frames[0])
    }

    /// Takes note of a frame that came, and of so many before it that did not.
    pub fn count_frame(&mut self, lost: u64) {
        self.frames[0] += lost;
        self.frames[1] += 1;
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

    /// How the controller reckons that it flies: a model, within the vehicle's own limits.
    pub fn flies_by(&mut self, mut dynamics: Dynamics, expected_speed_mps: f64) {
        if let Some(own) = &self.limits() {
            narrow(&mut dynamics.limits, own, expected_speed_mps);
        }
        let kind = self.driver().map(Driver::kind);
        let is_plane = matches!(kind, Some(AutopilotKind::ArduPlane | AutopilotKind::Px4FixedWing));
        self.present.set_dynamics(&dynamics);
        self.present.set_holds_ground_speed(!is_plane);
        self.present.set_settles_slowly(is_plane);
    }

    /// Whether the station may command it: it is one of the scenario's, and neither others nor the operator have it.
    pub fn is_ours(&self) -> bool {
        self.slot.is_some() && self.custody.is_ours()
    }

    /// Whether it is in the mode in which it follows setpoints.
    pub fn follows(&self) -> bool {
        self.driver().is_some_and(|driver| driver.follows_setpoints(self.heard.custom_mode))
    }

    /// Whether it follows setpoints, and no order to hold that is still under way can change that.
    pub fn follows_for_good(&self) -> bool {
        self.follows() && self.custody.is_settled(self.heard.mode_heard)
    }

    /// Whether it is in the mode in which it holds where it is.
    pub fn holds(&self) -> bool {
        self.driver().is_some_and(|driver| driver.end_mode(AtEnd::Loiter) == Some(self.heard.custom_mode))
    }

    /// The autopilot's own name of its mode.
    pub fn mode_name(&self) -> String {
        let mode = self.heard.custom_mode;
        self.driver().map_or_else(|| format!("mode {mode}"), |driver| driver.mode_name(mode))
    }

    /// Whether it stands on the ground, as far as anybody knows.
    pub fn on_ground(&self) -> bool {
        match self.heard.landed_state {
            // Columba's vehicles can wait in the air, disarmed.
            Some(MavLandedState::MAV_LANDED_STATE_ON_GROUND) => self.heard.height_m < 10.0,
            Some(MavLandedState::MAV_LANDED_STATE_IN_AIR | MavLandedState::MAV_LANDED_STATE_TAKEOFF) => false,
            _ => {
                let speed_mps = self.track.last().map_or(0.0, |sample| sample.state.speed_mps);
                self.heard.height_m < 3.0 && speed_mps < 3.0
            }
        }
    }

    /// What a driver needs to see of it.
    pub fn seen(&self) -> Seen {
        Seen {
            armed: self.heard.armed,
            custom_mode: self.heard.custom_mode,
            on_ground: self.on_ground(),
            height_m: self.heard.height_m,
            climb_mps: self.track.last().map_or(0.0, |sample| sample.state.climb_mps),
        }
    }

    /// Age of its last position, s.
    pub fn age_s(&self, now_s: f64) -> Option<f64> {
        self.track.last().map(|last| (now_s - last.at_s).max(0.0))
    }

    /// Whether a message that came by a route is the vehicle's own ([`Routes::owns`]).
    pub fn owns(&mut self, message: &Message, route: Route, is_flying: bool, now: Duration) -> bool {
        self.routes.owns(message, route, is_flying, now)
    }

    /// Takes a message of its own.
    pub fn hear(&mut self, message: &Message, now: Duration, frame: &LocalFrame) {
        self.heard.hear(message, now);
        match message {
            Message::HEARTBEAT(data) if self.driver.is_none() => {
                self.driver = Some(Driver::for_autopilot(data.autopilot, data.mavtype, self.version));
            }
            Message::AUTOPILOT_VERSION(data) => self.hear_version(data),
            Message::GLOBAL_POSITION_INT(data) => self.hear_position(data, now, frame),
            Message::ATTITUDE(data) => {
                if let Some(at_s) = self.flown_at_s(data.time_boot_ms, now) {
                    self.present.hear_heading(at_s, f64::from(data.yaw));
                    self.track.push_heading(at_s, f64::from(data.yaw));
                }
            }
            Message::VFR_HUD(data)
                if self.track.last().is_some_and(|sample| sample.state.speed_mps > AIRSPEED_FROM_MPS) =>
            {
                self.present.hear_airspeed(now.as_secs_f64(), f64::from(data.airspeed));
            }
            Message::TIMESYNC(data) => {
                if let Some(trip) = requests::round_trip(data, now) {
                    self.clock.round_trip(trip, now);
                }
            }
            Message::PARAM_VALUE(data) => {
                let kind = self.driver().map(Driver::kind);
                let is_px4 = matches!(kind, Some(AutopilotKind::Px4FixedWing | AutopilotKind::Px4Multicopter));
                self.requests.hear(data, is_px4);
            }
            Message::COMMAND_ACK(data) => self.orders.hear(data),
            _ => {}
        }
    }

    /// Takes a message of its own without its time: nothing is kept of where it was when.
    pub fn hear_without_clock(&mut self, message: &Message, now: Duration) {
        self.heard.hear(message, now);
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

    fn hear_position(&mut self, data: &GLOBAL_POSITION_INT_DATA, now: Duration, frame: &LocalFrame) {
        if !place::is_known(data) {
            return;
        }
        let Some(at_s) = self.flown_at_s(data.time_boot_ms, now) else { return };
        let kind = self.driver().map(Driver::kind);
        let (boot_s, clock_drift) = (1e-3 * f64::from(data.time_boot_ms), self.clock.drift().unwrap_or(0.0));
        let state = self.velocity_offset.take(kind, boot_s, clock_drift, place::state(data, frame));
        self.present.set_command_delay_s(self.clock.command_delay_s().unwrap_or(0.0));
        self.present.hear(at_s, &state);
        self.track.push(Sample { at_s, state });
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

    /// Forgets where it was: its places were told in another frame.
    pub fn forget_track(&mut self) {
        self.track.clear();
    }

    /// Takes note that a message of a kind came.
    pub fn count_message(&mut self, message_id: u32) {
        self.requests.count(message_id);
    }

    /// What is to be asked of it now, by a link that carries so much.
    pub fn ask(&mut self, carried: Carried, now: Duration) -> Vec<Message> {
        let now_s = now.as_secs_f64();
        let comes = self.comes_at(carried.position_hz, now_s) && self.age_s(now_s).is_some_and(|age_s| age_s < 1.0);
        let known = Known {
            comes,
            version: self.version.is_some(),
            home: self.heard.home.is_some(),
            origin: self.heard.origin.is_some(),
        };
        let Some(Ok(driver)) = &self.driver else { return Vec::new() };
        self.requests.ask(self.target, driver, known, carried, now)
    }

    /// Whether its positions come at about this rate, but for what the link loses.
    pub fn comes_at(&self, position_hz: f64, now_s: f64) -> bool {
        let rate = self.track.sent_hz(now_s, requests::RATE_WINDOW_S);
        rate.is_some_and(|rate| rate >= requests::RATE_SHARE * position_hz)
    }

    /// Takes note of a setpoint that is sent to it now, in these messages.
    pub fn steered(&mut self, setpoint: &Setpoint, messages: &[Message], now: Duration) {
        self.present.command(now.as_secs_f64(), setpoint);
        let is_answered = self.driver().is_some_and(Driver::acknowledges_setpoints);
        self.orders.sent(setpoint, if is_answered { messages } else { &[] }, now);
    }

    /// The commands of its last setpoint that are to be sent again, and the last of them that was refused.
    pub fn watch_answers(&mut self, now: Duration) -> (Vec<Message>, Option<Refusal>) {
        let (again, refused) = self.orders.watch(now);
        if let Some(setpoint) = self.orders.setpoint().filter(|_| !again.is_empty()) {
            self.present.command(now.as_secs_f64(), &setpoint);
        }
        (again, refused)
    }
}
