//! The simulated autopilot: datagrams and times in, datagrams and states out.

use crate::autopilot::Autopilot;
use crate::autopilot::plan::PlanKind;
use crate::counters::VehicleCounters;
use crate::host::system_ids::SystemIds;
use crate::links::Links;
use crate::links::PeerId;
use crate::links::Transmit;
use crate::lockstep::Lockstep;
use crate::mode::Mode;
use crate::protocol::mission::Uploads;
use crate::protocol::parameter::{Listings, Pace};
use crate::settings::{LockstepSettings, SettingsError, VehicleSettings};
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
    pub(crate) autopilot: Autopilot,
    /// By [`links`](Self::links): what is not yet told goes first.
    pub(crate) raw_links: Links,
    pub(crate) lockstep: Option<Lockstep>,
    pub(crate) host_now: Duration,
    pub(crate) parameters_changed: bool,
    pub(crate) listings: Listings,
    pub(crate) pace: Arc<Pace>,
    /// The system ids behind its port, and its place among them.
    pub(crate) ids: Arc<SystemIds>,
    pub(crate) place: usize,
    pub(crate) uploads: Uploads,
    pub(crate) plans_changed: [bool; PlanKind::ALL.len()],
    pub(crate) plan_totals: [f32; PlanKind::ALL.len()],
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

    fn start(mut settings: VehicleSettings, lockstep: Option<Lockstep>) -> Result<Self, SettingsError> {
        let plans = std::mem::take(&mut settings.plans);
        let mut vehicle = Self {
            raw_links: Links::new(&settings),
            autopilot: Autopilot::new(settings, lockstep.is_some()),
            lockstep,
            host_now: Duration::ZERO,
            parameters_changed: false,
            listings: Listings::default(),
            pace: Arc::default(),
            ids: Arc::default(),
            place: 0,
            uploads: Uploads::default(),
            plans_changed: Default::default(),
            plan_totals: Default::default(),
            wire: Counters::default(),
        };
        vehicle.start_parameters()?;
        vehicle.restore_plans(plans)?;
        vehicle.parameters_changed = false;
        vehicle.autopilot.start();
        (0..vehicle.raw_links.len()).for_each(|link| vehicle.announce(link));
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
        let ours = [0, self.autopilot.settings.system_id].contains(&incoming.target.system_id);
        // A companion computer has our system id and a component id of its own: it is heard.
        let from_ourselves = incoming.header.system_id == self.autopilot.settings.system_id
            && incoming.header.component_id == self.autopilot.settings.component_id;
        if !ours || from_ourselves {
            self.autopilot.counters.frames_for_others += 1;
            return;
        }
        let (link, is_new) = self.raw_links.hear(from, incoming.header.version, self.host_now, self.autopilot.time);
        if is_new {
            self.announce(link);
        }
        self.serve(link, incoming);
    }

    /// Follows a setpoint, as if it had come in a SET_POSITION_TARGET_LOCAL_NED: for runs in memory.
    pub fn command(&mut self, setpoint: &Setpoint) -> Result<(), SetpointRefused> {
        self.autopilot.command(setpoint)
    }

    /// Flies until vehicle time `until`, in whole integration steps, and appends the state after each of them to `track`.
    /// Telemetry that falls due on the way is queued. In lockstep it goes no further than
    /// [`released_until`](Self::released_until).
    pub fn advance(&mut self, until: Duration, track: &mut Vec<State>) {
        let Some(lockstep) = &self.lockstep else {
            self.integrate(until, track);
            return;
        };
        let Some(tick_end) = lockstep.released_until(self.autopilot.time).filter(|tick_end| *tick_end <= until) else {
            return;
        };
        self.links().begin_batch(None);
        self.integrate(tick_end.saturating_sub(self.autopilot.settings.step), track);
        self.step_to(tick_end, track);
        self.with_instruments(Links::send_due_and_position);
        self.links().end_batch();
        if let Some(lockstep) = &mut self.lockstep {
            lockstep.wait_from(self.host_now);
        }
    }

    /// In lockstep, the vehicle time to which the setpoint in hand lets it fly; none while it waits for one, and none in
    /// real time.
    pub fn released_until(&self) -> Option<Duration> {
        self.lockstep.as_ref()?.released_until(self.autopilot.time)
    }

    /// The host time at which [`handle_timeout`](Self::handle_timeout) wants to be called, if any.
    pub fn poll_timeout(&self) -> Option<Duration> {
        if self.raw_links.is_empty() {
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
            self.links().resend_batch();
            self.autopilot.counters.resends += 1;
        }
        self.send_listings();
        self.check_uploads();
    }

    /// The next datagram to send. Frames of one peer are packed together: poll after each input, until none is left.
    pub fn poll_transmit(&mut self) -> Option<Transmit> {
        self.links().poll()
    }

    /// Where it is.
    pub fn state(&self) -> &State {
        self.autopilot.flight.state()
    }

    /// Vehicle time.
    pub fn time(&self) -> Duration {
        self.autopilot.time
    }

    /// Its flight mode.
    pub fn mode(&self) -> Mode {
        self.autopilot.flight.mode()
    }

    /// Whether it is armed.
    pub fn is_armed(&self) -> bool {
        self.autopilot.flight.is_armed()
    }

    /// Whether something is amiss: the lack of setpoints took it out of GUIDED and nobody has set a mode since, its ground
    /// station or its GPS is missing, its battery is low, its engine has failed.
    pub fn is_in_failsafe(&self) -> bool {
        self.autopilot.is_in_failsafe()
    }

    /// The parameters that have been set, by name; all others have their initial values.
    pub fn set_parameters(&self) -> impl Iterator<Item = (&str, f64)> {
        self.autopilot.parameters.kept()
    }

    /// Names of the parameters that come from a parameter file and change nothing: clients list, read and set them.
    pub fn inert_parameters(&self) -> impl Iterator<Item = &str> {
        self.autopilot.parameters.inert_names()
    }

    /// Whether a parameter has been set since this was last asked.
    pub fn take_parameters_changed(&mut self) -> bool {
        std::mem::take(&mut self.parameters_changed)
    }

    /// Its settings.
    pub fn settings(&self) -> &VehicleSettings {
        &self.autopilot.settings
    }

    /// What it has done so far.
    pub fn counters(&self) -> VehicleCounters {
        self.autopilot.counters
    }

    /// What [`handle`](Self::handle) has read so far.
    pub fn wire_counters(&self) -> Counters {
        self.wire
    }

    fn integrate(&mut self, until: Duration, track: &mut Vec<State>) {
        let step = self.autopilot.settings.step;
        while self.autopilot.time + step <= until {
            self.step_to(self.autopilot.time + step, track);
            if self.autopilot.time >= self.raw_links.next_due() {
                self.with_instruments(Links::send_due);
            }
        }
    }

    fn step_to(&mut self, time: Duration, track: &mut Vec<State>) {
        self.autopilot.step(time, track);
        self.tell_events();
    }

    /// The links, on which everything that is not yet told has gone out.
    pub(crate) fn links(&mut self) -> &mut Links {
        self.tell_events();
        &mut self.raw_links
    }

    /// The links as they are, to be looked at.
    pub(crate) fn peers(&self) -> &Links {
        &self.raw_links
    }

    fn note_host_time(&mut self, now: Duration) {
        self.host_now = self.host_now.max(now);
        self.raw_links.drop_silent(self.host_now);
    }
}
