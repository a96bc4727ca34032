//! The simulated autopilot: datagrams and times in, datagrams and states out.

#[cfg(test)]
use crate::autopilot::Autopilot;
use crate::autopilot::plan::{PlanKind, Plans};
use crate::counters::VehicleCounters;
use crate::error::{SetpointError, Severity};
use crate::links::{Links, PeerId, Transmit};
use crate::lockstep::Lockstep;
use crate::mode::Mode;
use crate::parameters::defaults::shape_limits;
use crate::parameters::table::Parameter;
use crate::protocol::Services;
use crate::protocol::parameter::ParameterService;
use crate::settings::{LockstepSettings, SettingsError, VehicleSettings};
use crate::telemetry::announce::{Component, Kept};
use flight_model::{LocalFrame, Setpoint, State};
use mavlink_bridge::{Counters, Incoming, PlanItem, incoming};
use std::sync::Arc;
use std::time::Duration;

/// One simulated vehicle that speaks MAVLink as its autopilot does.
///
/// It does no I/O and knows no clock. There are two times, both counted from the start: *vehicle time*, which only
/// [`advance`](Self::advance) moves, in whole integration steps, and *host time* (the arguments called `now`), which
/// tells when to ask again and which peers are silent. In real time the host lets them run together.
///
/// # Which calls, in which order
///
/// The caller owns the sockets and the clock, and calls, as often as it likes:
///
/// 1. [`handle`](Self::handle) for each datagram that comes, with the host time and the address of its sender.
/// 2. [`handle_timeout`](Self::handle_timeout) when the host time has come that [`poll_timeout`](Self::poll_timeout)
///    gave, and at least once a second in real time: lists of parameters, uploads and repeats go on by it. An early
///    call does no harm. A call of 1, 2 or 3 may change that time: ask for it again.
/// 3. [`advance`](Self::advance) to let it fly. In real time `until` is the vehicle time that the clock has come to; in
///    lockstep it is [`released_until`](Self::released_until), and there is nothing to fly while that is none.
/// 4. [`poll_transmit`](Self::poll_transmit) after each of 1, 2 and 3, until it gives none. What is not fetched is not
///    lost, but its receiver waits for it. Frames to one peer are packed together: poll after a batch of inputs, not
///    between them.
///
/// Times never run backwards: a host time before the last one counts as the last one. Nothing that a peer sends makes a
/// call fail or panic.
///
/// # Examples
///
/// Without peers, a second of flight:
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
///
/// With a peer, which is told who and where the vehicle is as soon as it says anything:
///
/// ```
/// use mavlink_bridge::{Encoder, telemetry::ground_heartbeat};
/// use sim_vehicle::{PeerId, Vehicle, VehicleSettings};
/// use std::time::Duration;
///
/// let mut vehicle = Vehicle::new(VehicleSettings { ground: None, ..VehicleSettings::default() })?;
/// let peer = PeerId::from(([127, 0, 0, 1], 14550));
/// let mut datagram = Vec::new();
/// Encoder::new(255, 190).encode(&ground_heartbeat(), &mut datagram);
/// vehicle.handle(Duration::ZERO, &datagram, peer);
///
/// let answer = vehicle.poll_transmit().expect("a new peer is answered");
/// assert_eq!(answer.to, peer);
/// assert!(vehicle.poll_transmit().is_none());
/// # Ok::<(), sim_vehicle::SettingsError>(())
/// ```
#[derive(Debug)]
pub struct Vehicle {
    component: Component,
    services: Services,
    lockstep: Option<Lockstep>,
    wire: Counters,
    /// What it was told before it flew, for a reset.
    at_start: Arc<VehicleSettings>,
}

impl Vehicle {
    /// A vehicle whose time follows the host's.
    ///
    /// # Errors
    /// A setting is out of its range, a parameter is not the vehicle's or out of its range, or a plan makes no sense.
    pub fn new(settings: VehicleSettings) -> Result<Self, SettingsError> {
        settings.validate()?;
        Self::start(settings, None)
    }

    /// A vehicle whose time moves on by one control period for each setpoint that carries its stamp. It first says
    /// where it is at time zero.
    ///
    /// # Errors
    /// The same, and a control period that is not a whole number of milliseconds and of integration steps.
    pub fn in_lockstep(settings: VehicleSettings, lockstep: LockstepSettings) -> Result<Self, SettingsError> {
        settings.validate()?;
        lockstep.validate(settings.step)?;
        Self::start(settings, Some(Lockstep::new(lockstep)))
    }

    fn start(mut settings: VehicleSettings, lockstep: Option<Lockstep>) -> Result<Self, SettingsError> {
        let at_start = Arc::new(settings.clone());
        shape_limits(&mut settings);
        let plans = std::mem::take(&mut settings.plans);
        let mut vehicle = Self {
            component: Component::new(settings, lockstep.is_some()),
            services: Services::default(),
            lockstep,
            wire: Counters::default(),
            at_start,
        };
        vehicle.services.parameters.start(&mut vehicle.component)?;
        vehicle.services.missions.restore(&mut vehicle.component, plans)?;
        vehicle.services.parameters.take_changed();
        vehicle.component.autopilot.start();
        (0..vehicle.component.peers().len()).for_each(|link| vehicle.component.announce(link));
        Ok(vehicle)
    }

    /// What vehicles share that have peers or a port in common.
    pub(crate) fn parameter_service(&mut self) -> &mut ParameterService {
        &mut self.services.parameters
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
        self.component.note_host_time(now);
        let settings = &self.component.settings;
        let commands = settings.personality.rules().commands;
        let ours = commands.hears(incoming, settings.system_id, settings.component_id);
        // A companion computer has our system id and a component id of its own: it is heard.
        let from_ourselves = incoming.header.system_id == self.component.settings.system_id
            && incoming.header.component_id == self.component.settings.component_id;
        if !ours || from_ourselves {
            self.component.counters.frames_for_others += 1;
            return;
        }
        let (link, is_new) = self.component.hear(from, incoming.header.version);
        if is_new {
            self.component.announce(link);
        }
        self.services.serve(&mut self.component, self.lockstep.as_mut(), link, incoming);
        if let Some(kept) = self.component.reset_wanted.take() {
            self.reset(kept);
        }
    }

    /// Takes what a pilot's transmitter sends, as ArduPilot's simulator does: 8 or 16 channels, microseconds, 16 bits
    /// each, the lower byte first; 0 leaves a channel. Other lengths have no effect.
    pub fn receive(&mut self, datagram: &[u8]) {
        if matches!(datagram.len(), 16 | 32) {
            let pulses_us: Vec<u16> =
                datagram.chunks_exact(2).map(|two| u16::from_le_bytes([two[0], two[1]])).collect();
            self.component.autopilot.receive_channels(&pulses_us);
        }
    }

    /// A peer has connected at host time `now`, over a line that tells when it is gone: it gets telemetry from now on,
    /// until [`disconnect`](Self::disconnect).
    pub fn connect(&mut self, now: Duration, peer: PeerId) {
        self.component.note_host_time(now);
        self.component.connect(peer);
    }

    /// A peer that has connected is gone.
    pub fn disconnect(&mut self, peer: PeerId) {
        self.component.links().disconnect(peer);
    }

    /// How fast its clock is to run, if a client has set SIM_SPEEDUP since this was last asked: the host's, and so that
    /// of all its vehicles.
    pub fn take_speedup(&mut self) -> Option<f64> {
        self.services.parameters.take_speedup()
    }

    /// How fast its clock runs, for SIM_SPEEDUP.
    pub fn note_speedup(&mut self, speedup: f64) {
        let parameters = &mut self.component.autopilot.parameters;
        // Out of range it is told as the nearest that clients can set.
        let speedup = speedup.clamp(0.01, 100.0) as f32;
        if parameters.get(Parameter::Speedup) != speedup {
            let _ = parameters.set(Parameter::Speedup, speedup);
        }
    }

    /// It is as it was when the program started; its peers stay, and its time goes on.
    fn reset(&mut self, kept: Kept) {
        let mut settings = (*self.at_start).clone();
        if kept == Kept::Stored {
            settings.kept_parameters = self.set_parameters().map(|(name, value)| (name.to_owned(), value)).collect();
            let [mission, fence, rally] = PlanKind::ALL.map(|kind| self.plan(kind).to_vec());
            settings.plans = Plans { mission, fence, rally };
        }
        // Another vehicle behind the port may have its first system id by now.
        if self.services.parameters.is_taken(settings.system_id) {
            settings.system_id = self.component.settings.system_id;
        }
        match Self::start(settings, None) {
            Ok(fresh) => {
                self.services.parameters.begin_anew(fresh.component.settings.system_id);
                self.services.missions.begin_anew();
                self.component.begin_anew(fresh.component);
                self.component.say(Severity::Info, "Reset to the start");
            }
            Err(error) => self.component.say(Severity::Warning, &format!("Reset: {error}")),
        }
    }

    /// Follows a setpoint, as if it had come in a SET_POSITION_TARGET_LOCAL_NED: for runs in memory.
    ///
    /// # Errors
    /// The mode is not GUIDED, or the setpoint is not finite: then nothing is changed.
    pub fn command(&mut self, setpoint: &Setpoint) -> Result<(), SetpointError> {
        self.component.autopilot.command(setpoint)
    }

    /// Keeps the vehicle where it is while its time and its telemetry go on, or lets it fly on, with the velocity that
    /// it had: so a flight does not begin before a ground station is ready.
    pub fn hold(&mut self, is_held: bool) {
        self.component.autopilot.flight.hold(is_held);
    }

    /// Flies until vehicle time `until`, in whole integration steps, and appends the state after each of them to
    /// `track`. Telemetry that falls due on the way is queued. In lockstep it goes no further than
    /// [`released_until`](Self::released_until).
    pub fn advance(&mut self, until: Duration, track: &mut Vec<State>) {
        let Some(lockstep) = &self.lockstep else {
            self.integrate(until, track);
            return;
        };
        let Some(tick_end) =
            lockstep.released_until(self.component.autopilot.time()).filter(|tick_end| *tick_end <= until)
        else {
            return;
        };
        self.component.links().begin_batch(None);
        self.integrate(tick_end.saturating_sub(self.component.settings.step), track);
        self.step_to(tick_end, track);
        self.component.with_instruments(Links::send_due_and_position);
        self.component.links().end_batch();
        if let Some(lockstep) = &mut self.lockstep {
            lockstep.wait_from(self.component.host_now);
        }
    }

    /// In lockstep, the vehicle time to which the setpoint in hand lets it fly; none while it waits for one, and none
    /// in real time.
    pub fn released_until(&self) -> Option<Duration> {
        self.lockstep.as_ref()?.released_until(self.component.autopilot.time())
    }

    /// The host time at which [`handle_timeout`](Self::handle_timeout) wants to be called, if any.
    pub fn poll_timeout(&self) -> Option<Duration> {
        if self.component.peers().is_empty() {
            return None;
        }
        let resend_at = self.lockstep.as_ref().and_then(Lockstep::resend_at);
        [resend_at, self.services.parameters.next_due(), self.services.missions.next_due()].into_iter().flatten().min()
    }

    /// Tells the vehicle the host time: it forgets silent peers, goes on with lists and uploads, and in lockstep asks
    /// again if it waits for too long.
    pub fn handle_timeout(&mut self, now: Duration) {
        self.component.note_host_time(now);
        if self.lockstep.as_mut().is_some_and(|lockstep| lockstep.take_resend(now)) {
            self.component.links().resend_batch();
            self.component.counters.resends += 1;
        }
        self.services.parameters.send_listings(&mut self.component);
        self.services.missions.check_uploads(&mut self.component);
    }

    /// The next datagram to send. Frames of one peer are packed together: poll after each input, until none is left.
    pub fn poll_transmit(&mut self) -> Option<Transmit> {
        self.component.links().poll()
    }

    /// Where it is.
    pub fn state(&self) -> &State {
        self.component.autopilot.flight.state()
    }

    /// Vehicle time.
    pub fn time(&self) -> Duration {
        self.component.autopilot.time()
    }

    /// Its flight mode.
    pub fn mode(&self) -> Mode {
        self.component.autopilot.flight.mode()
    }

    /// Whether it is armed.
    pub fn is_armed(&self) -> bool {
        self.component.autopilot.flight.is_armed()
    }

    /// Whether it stands on the ground.
    pub fn is_on_ground(&self) -> bool {
        self.component.autopilot.flight.is_on_ground()
    }

    /// Whether something is amiss: the lack of setpoints took it out of GUIDED and nobody has set a mode since, its
    /// ground station or its GPS is missing, its battery is low, its engine has failed.
    pub fn is_in_failsafe(&self) -> bool {
        self.component.autopilot.is_in_failsafe()
    }

    /// The parameters that have been set, by name; all others have their initial values.
    pub fn set_parameters(&self) -> impl Iterator<Item = (&str, f64)> {
        self.component.autopilot.parameters.kept()
    }

    /// Names of the parameters that change nothing and that files, settings or clients have named: clients list, read
    /// and set them.
    pub fn inert_parameters(&self) -> impl Iterator<Item = &str> {
        self.component.autopilot.parameters.inert_names()
    }

    /// How many parameters change nothing, with those of the stock autopilot that nobody has named.
    pub fn inert_parameter_count(&self) -> usize {
        self.component.autopilot.parameters.inert_count()
    }

    /// Whether a parameter has been set since this was last asked.
    pub fn take_parameters_changed(&mut self) -> bool {
        self.services.parameters.take_changed()
    }

    /// The plans that have been changed since this was last asked, to be kept.
    pub(crate) fn take_changed_plans(&mut self) -> Vec<PlanKind> {
        self.services.missions.take_changed()
    }

    /// The items of its mission, of its fence, and its rally points, as they are on board.
    pub fn plan_items(&self) -> [&[PlanItem]; 3] {
        PlanKind::ALL.map(|kind| self.plan(kind))
    }

    /// Its home: north, east and up of the origin of its local frame, m.
    pub fn home_m(&self) -> [f64; 3] {
        let home = self.component.autopilot.flight.home();
        [home.x_m, home.y_m, home.altitude_m]
    }

    /// Its local frame.
    pub fn frame(&self) -> &LocalFrame {
        self.component.autopilot.frame()
    }

    /// The items of a plan.
    pub(crate) fn plan(&self, kind: PlanKind) -> &[PlanItem] {
        self.component.autopilot.plan(kind)
    }

    /// Its settings.
    pub fn settings(&self) -> &VehicleSettings {
        &self.component.settings
    }

    /// What it has done so far.
    pub fn counters(&self) -> VehicleCounters {
        let (own, flown) = (self.component.counters, self.component.autopilot.counters());
        let mut all = own;
        all += flown;
        all
    }

    /// What [`handle`](Self::handle) has read so far.
    pub fn wire_counters(&self) -> Counters {
        self.wire
    }

    #[cfg(test)]
    pub(crate) fn autopilot(&self) -> &Autopilot {
        &self.component.autopilot
    }

    #[cfg(test)]
    pub(crate) fn autopilot_mut(&mut self) -> &mut Autopilot {
        &mut self.component.autopilot
    }

    fn integrate(&mut self, until: Duration, track: &mut Vec<State>) {
        let step = self.component.settings.step;
        while self.component.autopilot.time() + step <= until {
            self.step_to(self.component.autopilot.time() + step, track);
            if self.component.autopilot.time() >= self.component.peers().next_due() {
                self.component.with_instruments(Links::send_due);
            }
        }
    }

    fn step_to(&mut self, time: Duration, track: &mut Vec<State>) {
        self.component.autopilot.step(time, track);
        self.component.tell_events();
        self.component.follow_command();
    }
}
