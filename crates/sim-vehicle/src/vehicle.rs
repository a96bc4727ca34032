//! The simulated autopilot: datagrams and times in, datagrams and states out.

use crate::autopilot::failsafe::Failsafes;
use crate::autopilot::fence::Fence;
use crate::autopilot::flight::Flight;
use crate::autopilot::manual_control::Channels;
use crate::autopilot::mission::{Mission, Progress};
use crate::autopilot::rally::Rally;
use crate::counters::VehicleCounters;
use crate::firmware::Personality;
use crate::firmware::px4;
use crate::host::system_ids::SystemIds;
use crate::links::Links;
use crate::links::PeerId;
use crate::links::Transmit;
use crate::lockstep::Lockstep;
use crate::mode::Mode;
use crate::parameters::{Parameter, Parameters};
use crate::protocol::mission::{PlanKind, Uploads};
use crate::protocol::parameter::{Listings, Pace};
use crate::settings::{LockstepSettings, SettingsError, VehicleSettings};
use crate::telemetry::streams::Stream;
use crate::world::World;
use flight_model::{Setpoint, State};
use mavlink_bridge::{Counters, Incoming, SetpointError, incoming};
use std::sync::Arc;
use std::time::Duration;

/// One simulated autopilot that speaks MAVLink as ArduPlane does.
///
/// It does no I/O and knows no clock. There are two times, both counted from the start: *vehicle time*, which only
/// [`advance`](Self::advance) moves, in whole integration steps, and *host time* (the arguments called `now`), which
/// tells when to ask again and which peers have fallen silent. In real time the host lets them run together.
///
/// ```
/// use sim_vehicle::{Vehicle, VehicleSettings};
/// use std::time::Duration;
///
/// let mut vehicle = Vehicle::new(VehicleSettings { ground: None, ..VehicleSettings::default() })?;
/// let mut track = Vec::new();
/// vehicle.advance(Duration::from_secs(1), &mut track);
/// assert_eq!(track.len(), 100);
/// assert!((vehicle.state().x_m - 10.0).abs() < 1e-9);
/// # Ok::<(), sim_vehicle::SettingsError>(())
/// ```
#[derive(Debug)]
pub struct Vehicle {
    pub(crate) settings: VehicleSettings,
    pub(crate) flight: Flight,
    pub(crate) links: Links,
    pub(crate) time: Duration,
    pub(crate) lockstep: Option<Lockstep>,
    pub(crate) host_now: Duration,
    pub(crate) failsafes: Failsafes,
    pub(crate) world: World,
    pub(crate) parameters: Parameters,
    pub(crate) parameters_changed: bool,
    pub(crate) listings: Listings,
    pub(crate) pace: Arc<Pace>,
    /// The system ids behind its port, and its place among them.
    pub(crate) ids: Arc<SystemIds>,
    pub(crate) place: usize,
    pub(crate) mission: Mission,
    pub(crate) progress: Progress,
    pub(crate) fence: Fence,
    pub(crate) rally: Rally,
    pub(crate) uploads: Uploads,
    pub(crate) plans_changed: [bool; PlanKind::ALL.len()],
    pub(crate) plan_totals: [f32; PlanKind::ALL.len()],
    /// Vehicle time before which no further refused setpoint is put into words.
    pub(crate) quiet_until: Duration,
    pub(crate) channels: Channels,
    /// What stood against arming when it was last looked at, and when that is said again, vehicle time.
    pub(crate) arming_reason: Option<String>,
    pub(crate) arming_reason_due: Duration,
    /// Vehicle time at which it last flew.
    pub(crate) flown_at: Duration,
    /// Whether somebody has set home: then arming leaves it.
    pub(crate) home_is_set: bool,
    pub(crate) px4: px4::State,
    pub(crate) counters: VehicleCounters,
    wire: Counters,
}

/// Why a setpoint is not flown.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum SetpointRefused {
    /// The vehicle follows setpoints only in GUIDED.
    #[error("mode is {0}")]
    NotGuided(Mode),
    /// The setpoint itself cannot be flown.
    #[error(transparent)]
    Setpoint(#[from] SetpointError),
}

impl Vehicle {
    /// A vehicle whose time follows the host's.
    pub fn new(settings: VehicleSettings) -> Result<Self, SettingsError> {
        settings.validate()?;
        Self::start(settings, None)
    }

    /// A vehicle whose time moves on by one control period for each setpoint that carries its stamp. It first says where
    /// it is at time zero.
    pub fn in_lockstep(settings: VehicleSettings, lockstep: LockstepSettings) -> Result<Self, SettingsError> {
        settings.validate()?;
        lockstep.validate(settings.step)?;
        Self::start(settings, Some(Lockstep::new(lockstep)))
    }

    fn start(settings: VehicleSettings, lockstep: Option<Lockstep>) -> Result<Self, SettingsError> {
        let parameters = Parameters::new(&settings);
        let mut vehicle = Self {
            world: World::new(&settings, &parameters),
            flight: Flight::new(&settings),
            links: Links::new(&settings),
            time: Duration::ZERO,
            lockstep,
            host_now: Duration::ZERO,
            failsafes: Failsafes::new(),
            parameters,
            parameters_changed: false,
            listings: Listings::default(),
            pace: Arc::default(),
            ids: Arc::default(),
            place: 0,
            mission: Mission::new(settings.personality.first_mission_item()),
            progress: Progress::default(),
            fence: Fence::default(),
            rally: Rally::default(),
            uploads: Uploads::default(),
            plans_changed: Default::default(),
            plan_totals: Default::default(),
            quiet_until: Duration::ZERO,
            channels: Channels::default(),
            arming_reason: None,
            arming_reason_due: Duration::ZERO,
            flown_at: Duration::ZERO,
            home_is_set: false,
            px4: px4::State::default(),
            counters: VehicleCounters::default(),
            wire: Counters::default(),
            settings,
        };
        vehicle.start_parameters()?;
        let plans = std::mem::take(&mut vehicle.settings.plans);
        vehicle.restore_plans(plans)?;
        vehicle.parameters_changed = false;
        let in_lockstep = vehicle.lockstep.is_some();
        let first_mode = vehicle.settings.personality.first_mode(vehicle.mode(), in_lockstep);
        vehicle.flight.set_mode(first_mode);
        vehicle.reconfigure_fence(Parameter::FenceEnable);
        vehicle.restart_setpoint_timeout();
        (0..vehicle.links.len()).for_each(|link| vehicle.announce(link));
        Ok(vehicle)
    }

    /// Lets vehicles that may have the same peers share the pace at which these are sent lists of parameters.
    pub(crate) fn keep_pace(&mut self, pace: Arc<Pace>) {
        self.pace = pace;
    }

    /// Tells a vehicle whom it shares a port with.
    pub(crate) fn share_port(&mut self, ids: Arc<SystemIds>, place: usize) {
        (self.ids, self.place) = (ids, place);
    }

    /// Takes a datagram that came from a peer at host time `now`. What cannot be read is counted and has no effect.
    pub fn handle(&mut self, now: Duration, datagram: &[u8], from: PeerId) {
        let mut wire = self.wire;
        for request in incoming(datagram, &mut wire) {
            self.handle_incoming(now, &request, from);
        }
        self.wire = wire;
    }

    /// Takes one frame, decoded already; for hosts that serve many vehicles on one port.
    pub fn handle_incoming(&mut self, now: Duration, incoming: &Incoming, from: PeerId) {
        self.note_host_time(now);
        let ours = self.settings.personality.hears(incoming, self.settings.system_id, self.settings.component_id);
        // A companion computer has our system id and a component id of its own: it is heard.
        let from_ourselves = incoming.header.system_id == self.settings.system_id
            && incoming.header.component_id == self.settings.component_id;
        if !ours || from_ourselves {
            self.counters.frames_for_others += 1;
            return;
        }
        let (link, is_new) = self.links.hear(from, incoming.header.version, self.host_now, self.time);
        if is_new {
            self.announce(link);
        }
        self.serve(link, incoming);
    }

    /// Follows a setpoint, as if it had come in a SET_POSITION_TARGET_LOCAL_NED: for runs in memory.
    pub fn command(&mut self, setpoint: &Setpoint) -> Result<(), SetpointRefused> {
        self.check_guided()?;
        if !setpoint.is_finite() {
            return Err(SetpointError::NotFinite.into());
        }
        self.flight.set_ground_speed(setpoint.speed_mps);
        self.flight.set_course(setpoint.course_rad, f64::INFINITY);
        self.flight.set_altitude(setpoint.altitude_m, f64::INFINITY);
        self.restart_setpoint_timeout();
        Ok(())
    }

    /// Flies until vehicle time `until`, in whole integration steps, and appends the state after each of them to `track`.
    /// Telemetry that falls due on the way is queued. In lockstep it goes no further than
    /// [`released_until`](Self::released_until).
    pub fn advance(&mut self, until: Duration, track: &mut Vec<State>) {
        let Some(lockstep) = &self.lockstep else {
            self.integrate(until, track);
            return;
        };
        let Some(tick_end) = lockstep.released_until(self.time).filter(|tick_end| *tick_end <= until) else { return };
        self.links.begin_batch(None);
        self.integrate(tick_end.saturating_sub(self.settings.step), track);
        self.step_to(tick_end, track);
        self.with_instruments(Links::send_due_and_position);
        self.links.end_batch();
        if let Some(lockstep) = &mut self.lockstep {
            lockstep.wait_from(self.host_now);
        }
    }

    /// In lockstep, the vehicle time to which the setpoint in hand lets it fly; none while it waits for one, and none in
    /// real time.
    pub fn released_until(&self) -> Option<Duration> {
        self.lockstep.as_ref()?.released_until(self.time)
    }

    /// The host time at which [`handle_timeout`](Self::handle_timeout) wants to be called, if any.
    pub fn poll_timeout(&self) -> Option<Duration> {
        if self.links.is_empty() {
            return None;
        }
        let resend_at = self.lockstep.as_ref().and_then(Lockstep::resend_at);
        [resend_at, self.listings.next_due(), self.uploads.due()].into_iter().flatten().min()
    }

    /// Tells the vehicle the host time: it forgets silent peers, goes on with lists and uploads, and in lockstep asks
    /// again if it waits for too long.
    pub fn handle_timeout(&mut self, now: Duration) {
        self.note_host_time(now);
        if self.lockstep.as_mut().is_some_and(|lockstep| lockstep.take_resend(now)) {
            self.links.resend_batch();
            self.counters.resends += 1;
        }
        self.send_listings();
        self.check_uploads();
    }

    /// The next datagram to send. Frames of one peer are packed together: poll after each input, until none is left.
    pub fn poll_transmit(&mut self) -> Option<Transmit> {
        self.links.poll()
    }

    /// Where it is.
    pub fn state(&self) -> &State {
        self.flight.state()
    }

    /// Vehicle time.
    pub fn time(&self) -> Duration {
        self.time
    }

    /// Its flight mode.
    pub fn mode(&self) -> Mode {
        self.flight.mode()
    }

    /// Whether it is armed.
    pub fn is_armed(&self) -> bool {
        self.flight.is_armed()
    }

    /// Whether something is amiss: the lack of setpoints took it out of GUIDED and nobody has set a mode since, its ground
    /// station or its GPS is missing, its battery is low, its engine has failed.
    pub fn is_in_failsafe(&self) -> bool {
        self.failsafes.is_any() || self.px4.failsafe.is_some()
    }

    /// The parameters that have been set, by name; all others have their initial values.
    pub fn set_parameters(&self) -> impl Iterator<Item = (&str, f64)> {
        self.parameters.kept()
    }

    /// Names of the parameters that come from a parameter file and change nothing: clients list, read and set them.
    pub fn inert_parameters(&self) -> impl Iterator<Item = &str> {
        self.parameters.inert_names()
    }

    /// Whether a parameter has been set since this was last asked.
    pub fn take_parameters_changed(&mut self) -> bool {
        std::mem::take(&mut self.parameters_changed)
    }

    /// Its settings.
    pub fn settings(&self) -> &VehicleSettings {
        &self.settings
    }

    /// What it has done so far.
    pub fn counters(&self) -> VehicleCounters {
        self.counters
    }

    /// What [`handle`](Self::handle) has read so far.
    pub fn wire_counters(&self) -> Counters {
        self.wire
    }

    fn integrate(&mut self, until: Duration, track: &mut Vec<State>) {
        let step = self.settings.step;
        while self.time + step <= until {
            self.step_to(self.time + step, track);
            if self.time >= self.links.next_due() {
                self.with_instruments(Links::send_due);
            }
        }
    }

    /// One integration step, and all that is looked at after it but telemetry.
    fn step_to(&mut self, time: Duration, track: &mut Vec<State>) {
        self.live();
        self.step_flight();
        self.time = time;
        track.push(*self.flight.state());
        self.check_failsafes();
        self.check_fence();
        self.follow_mission();
        self.follow_personality();
        self.tell_what_is_against_arming();
    }

    pub(crate) fn set_mode(&mut self, mode: Mode) {
        if mode == Mode::Auto && self.mode() != Mode::Auto {
            self.begin_mission();
        }
        let is_new = mode != self.mode();
        if mode == Mode::Rtl && is_new {
            let rally = self.best_rally();
            self.flight.set_rally(rally);
            self.progress.has_looked_for_landing = false;
        }
        self.flight.set_mode(mode);
        if is_new {
            self.mode_changes_fence();
        }
        self.failsafes.setpoints_lost = false;
        self.px4.failsafe = None;
        self.restart_setpoint_timeout();
        // A PX4 does not tell before its next heartbeat.
        if is_new && self.settings.personality != Personality::Px4 {
            self.send_stream_to_all(Stream::Heartbeat);
        }
    }

    pub(crate) fn check_guided(&self) -> Result<(), SetpointRefused> {
        match self.flight.mode() {
            Mode::Guided => Ok(()),
            other => Err(SetpointRefused::NotGuided(other)),
        }
    }

    fn note_host_time(&mut self, now: Duration) {
        self.host_now = self.host_now.max(now);
        self.links.drop_silent(self.host_now);
    }
}
