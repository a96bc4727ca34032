//! The ground station: from the ground to the ground with real autopilots.
//!
//! [`Station`] is sans-I/O: it takes the frames that arrive and the time, and gives the messages to send. A flight goes
//! through phases, a file each: [connect], [preflight], [arm_takeoff], [gather_phase], [handover], [fly], [end]. What
//! is said of the flight rests on telemetry alone ([judge]), and is told once ([told]). The sockets, the terminal and
//! the files are in [shell] and [record].

pub mod arm_takeoff;
pub mod connect;
mod control;
pub mod end;
pub mod fly;
pub mod frames;
pub mod gather;
pub mod gather_phase;
pub mod handover;
pub mod judge;
pub mod limits;
pub mod operator;
pub mod outcome;
pub mod peers;
pub mod preflight;
pub mod record;
pub mod shell;
pub mod table;
pub mod telemetry;
pub mod told;
pub mod track;
pub mod vehicle;
mod words;

use crate::config::Scenario;
use crate::identify::flight::StepFlight;
use controller::Obstacle;
use flight_model::{Limits, LocalFrame, Setpoint, State};
use frames::Origin;
use mavlink_bridge::dialect::{COMMAND_ACK_DATA, MavAutopilot, MavCmd, MavResult, MavType, Message};
use mavlink_bridge::kind::{AtEnd, Situation};
use mavlink_bridge::telemetry::ground_heartbeat;
use mavlink_bridge::{Counters, Frame, Header, SequenceTracker};
use operator::Verb;
use std::collections::BTreeSet;
use std::time::Duration;
use told::{Told, Weight};
use vehicle::{Order, Route, Trust, Vehicle};

/// MAVLink ids of a ground station (MAV_COMP_ID_MISSIONPLANNER), as autopilots expect them.
pub const GROUND: (u8, u8) = (255, 190);
/// The station's heartbeat, and its question for the time.
const BEAT: Duration = Duration::from_secs(1);
/// An order that is not followed is given again after this.
const ORDER_AGAIN: Duration = Duration::from_millis(1000);
/// A vehicle whose last position is older than this is stale: nobody knows where it is, s.
pub const STALE_S: f64 = 1.5;
/// A vehicle that is not heard for so long is lost, s.
pub const LOST_S: f64 = 4.0;

/// What the station is told beside the scenario.
#[derive(Clone, Debug)]
pub struct Settings {
    /// What vehicles do when the flight is over.
    pub at_end: AtEnd,
    /// Does all but command.
    pub dry_run: bool,
    /// System ids in the order of the scenario's vehicles; none: in their own order.
    pub system_ids: Option<Vec<u8>>,
    /// Where the scenario's frame is put.
    pub origin: Origin,
    /// Whether the scenario names its origin.
    pub origin_is_named: bool,
    /// How long to wait for the first word of every vehicle.
    pub connect_patience: Duration,
    /// How long to wait until all are ready, and until all have taken off.
    pub ready_patience: Duration,
    /// Names of the links.
    pub links: Vec<String>,
    /// Bytes a second that each link carries; none where that is no limit.
    pub capacities: Vec<Option<f64>>,
    /// Ways to speak before anybody was heard.
    pub calls: Vec<Route>,
    /// Steps that are flown in the place of what a flock would decide.
    pub steps: Option<StepFlight>,
}

/// Messages for a route.
#[derive(Clone, Debug, PartialEq)]
pub struct Outgoing {
    /// Where.
    pub route: Route,
    /// What.
    pub messages: Vec<Message>,
}

/// Times how long the optimiser takes.
pub type SolveClock = Box<dyn Fn() -> Duration + Sync + Send>;

/// The station.
pub struct Station {
    /// What is flown.
    pub scenario: Scenario,
    /// Settings.
    pub settings: Settings,
    /// The scenario's frame, where the vehicles are.
    pub frame: LocalFrame,
    /// Limits within which the whole flock flies, narrowed to what every vehicle allows.
    pub limits: Limits,
    /// The scenario's vehicles in their order, then strangers.
    pub vehicles: Vec<Vehicle>,
    /// What was told.
    pub told: Told,
    /// Lines of the record that wait to be written.
    pub journal: Vec<serde_json::Value>,
    phase: Phase,
    stop: Option<Stop>,
    verbs: Vec<Verb>,
    outbox: Vec<Outgoing>,
    beat: Option<Duration>,
    polled: Option<Duration>,
    /// Until then what a stalled machine has not read yet is waited for.
    catching_up_until: Duration,
    clock: SolveClock,
    /// Indices of the vehicles whose choices are told.
    watched: Vec<usize>,
}

/// Why a flight is to end before its time.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Stop {
    /// In words.
    pub why: String,
    /// Whether someone wished it.
    pub wished: bool,
}

/// Where the flight is.
#[allow(clippy::large_enum_variant)] // there is one
pub enum Phase {
    /// Waits for vehicles.
    Connect(connect::Connect),
    /// Waits until they are ready.
    Preflight(preflight::Preflight),
    /// Arms them, and lets them take off.
    TakeOff(arm_takeoff::TakeOff),
    /// Brings them to their starts.
    Gather(gather_phase::GatherPhase),
    /// Brings them into the mode in which they follow setpoints.
    HandOver(handover::HandOver),
    /// The flock flies.
    Fly(Box<fly::Fly>),
    /// Leaves every vehicle as it is to be left.
    End(Box<end::End>),
    /// All is said.
    Over(Option<Box<fly::Fly>>),
}

impl Phase {
    /// Its name.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Connect(_) => "connect",
            Self::Preflight(_) => "pre-flight",
            Self::TakeOff(_) => "take-off",
            Self::Gather(_) => "gather",
            Self::HandOver(_) => "hand over",
            Self::Fly(_) => "fly",
            Self::End(_) => "end",
            Self::Over(_) => "over",
        }
    }
}

impl Station {
    /// A station for a scenario; nobody is heard yet. `clock` only times the solves.
    pub fn new(scenario: Scenario, settings: Settings, clock: SolveClock) -> Self {
        Self {
            frame: scenario.frame,
            limits: scenario.dynamics.limits,
            scenario,
            settings,
            vehicles: Vec::new(),
            told: Told::default(),
            journal: Vec::new(),
            phase: Phase::Connect(connect::Connect::default()),
            stop: None,
            verbs: Vec::new(),
            outbox: Vec::new(),
            beat: None,
            polled: None,
            catching_up_until: Duration::ZERO,
            clock,
            watched: Vec::new(),
        }
    }

    /// Where the flight is.
    pub fn phase(&self) -> &Phase {
        &self.phase
    }

    /// Whether all is said.
    pub fn is_over(&self) -> bool {
        matches!(self.phase, Phase::Over(_))
    }

    /// The flight is to end.
    pub fn stop(&mut self, why: impl Into<String>, wished: bool) {
        self.stop.get_or_insert(Stop { why: why.into(), wished });
    }

    /// Why the flight is to end before its time, if it is.
    pub fn stopped(&self) -> Option<&Stop> {
        self.stop.as_ref()
    }

    /// Takes a verb of the operator; `from` says how it came, as "from the terminal". Who said what when is told.
    pub fn operate(&mut self, verb: Verb, from: &str) {
        let now_s = self.polled.unwrap_or_default().as_secs_f64();
        self.told.tell(now_s, None, Weight::Note, format!("the operator says {verb} ({from})"));
        match verb {
            Verb::Abort(at_end) => {
                self.settings.at_end = at_end.unwrap_or(self.settings.at_end);
                self.stop("aborted by the operator", true);
            }
            other => self.verbs.push(other),
        }
    }

    /// Why a verb cannot be carried out, if it cannot.
    pub fn refuses(&self, verb: Verb) -> Option<String> {
        match verb {
            _ if self.is_over() || matches!(self.phase, Phase::End(_)) => Some("the flight is over".to_owned()),
            Verb::Drop(vehicle, _) | Verb::Take(vehicle) | Verb::PauseOne(vehicle) | Verb::ResumeOne(vehicle)
                if vehicle > self.scenario.starts.len() =>
            {
                Some(format!("there is no vehicle {vehicle}"))
            }
            _ => None,
        }
    }

    /// Sets of which vehicles it is told what there was to choose from; decisions are the same.
    pub fn watch(&mut self, vehicles: Vec<usize>) {
        self.watched = vehicles;
    }

    /// Indices of the vehicles of which that is told.
    pub fn watched(&self) -> &[usize] {
        &self.watched
    }

    /// The verbs that nobody has carried out yet.
    pub fn take_verbs(&mut self) -> Vec<Verb> {
        std::mem::take(&mut self.verbs)
    }

    /// Takes a frame that arrived by a route at a time since the station started, and whether it is the newest of its
    /// sender ([`Self::count`]).
    pub fn hear(&mut self, frame: &Frame<'_>, is_newest: bool, route: Route, now: Duration) {
        let header = frame.header;
        let Ok(message) = frame.message() else { return };
        if let Some((command, verb)) = self.commanded(&header, &message) {
            self.answer_operator(&header, command, verb, route);
            return;
        }
        let Some(index) = self.recognise(&header, &message, now) else { return };
        let local_frame = self.frame;
        let is_flying = !matches!(self.phase, Phase::Connect(_) | Phase::Preflight(_));
        let Some(vehicle) = self.vehicles.get_mut(index) else { return };
        if header.component_id != vehicle.target.component_id {
            return; // a camera, a gimbal, a companion computer
        }
        let was = (vehicle.armed, vehicle.custom_mode);
        if !vehicle.owns(&message, route, is_flying, now) {
            let text = "another autopilot speaks with its system id, by another way: nothing of that is taken";
            if vehicle.routes.get(&route).is_some_and(|state| state.trust == Trust::Other) {
                self.tell_once(index, "doubled", Weight::Warning, text, now);
            }
            return;
        }
        vehicle.streams.entry(header.message_id).or_default().heard += 1;
        if vehicle.is_overtaken(is_newest, now) && has_no_time(&message) {
            return;
        }
        match &message {
            Message::TIMESYNC(data) => {
                if let Some(trip) = telemetry::round_trip(data, now) {
                    if let Some(state) = vehicle.routes.get_mut(&route) {
                        state.round_trip = Some(trip);
                    }
                    vehicle.clock.round_trip(trip, now);
                }
            }
            message => {
                vehicle.hear(message, now, &local_frame);
            }
        }
        if let (Message::STATUSTEXT(_), Some((_, text))) = (&message, vehicle.texts.back()) {
            let (number, text) = (vehicle.slot.map(number), text.clone());
            if let Some(weight) = words::of_failsafe(&text) {
                self.told.once(now.as_secs_f64(), number, &text, weight, format!("says: {text}"));
            }
        }
        let vehicle = &self.vehicles[index];
        if was != (vehicle.armed, vehicle.custom_mode) {
            tracing::debug!(system = vehicle.id(), armed = vehicle.armed, mode = vehicle.mode_name(), "state");
        }
    }

    /// Takes note of the sequence number of a frame of a vehicle's autopilot. Other senders are not counted: routers
    /// pass on only a part of what others say, so that gaps in their numbers are no losses. Gives whether no newer frame
    /// of its sender came before it, as far as was counted.
    pub fn count(&mut self, frame: &Frame<'_>, sequence: &mut SequenceTracker, counters: &mut Counters) -> bool {
        let header = &frame.header;
        let is_sender = |vehicle: &&mut Vehicle| {
            (vehicle.id(), vehicle.target.component_id) == (header.system_id, header.component_id)
        };
        let Some(vehicle) = self.vehicles.iter_mut().find(is_sender) else { return true };
        let before = counters.lost;
        let is_newest = sequence.observe(frame, counters) == mavlink_bridge::Order::Newer;
        vehicle.frames[0] += counters.lost - before;
        vehicle.frames[1] += 1;
        is_newest
    }

    /// Does what is due; call it every few hundredths of a second.
    pub fn poll(&mut self, now: Duration) {
        self.watch_the_machine(now);
        self.keep_house(now);
        let phase = std::mem::replace(&mut self.phase, Phase::Over(None));
        let before = phase.name();
        self.phase = match phase {
            Phase::Connect(phase) => phase.step(self, now),
            Phase::Preflight(phase) => phase.step(self, now),
            Phase::TakeOff(phase) => phase.step(self, now),
            Phase::Gather(phase) => phase.step(self, now),
            Phase::HandOver(phase) => phase.step(self, now),
            Phase::Fly(phase) => phase.step(self, now),
            Phase::End(phase) => phase.step(self, now),
            Phase::Over(fly) => Phase::Over(fly),
        };
        if self.phase.name() != before {
            self.journal.push(serde_json::json!({"phase": self.phase.name(), "at_s": now.as_secs_f64()}));
        }
    }

    /// A machine that stalls leaves telemetry unread: no vehicle is called silent for that.
    fn watch_the_machine(&mut self, now: Duration) {
        const STALL: Duration = Duration::from_millis(700);
        let stalled = self.polled.replace(now).map_or(Duration::ZERO, |polled| now.saturating_sub(polled));
        if stalled > STALL {
            self.catching_up_until = now + Duration::from_secs(1);
            let text = format!("this machine stalled for {:.1} s: it cannot keep up", stalled.as_secs_f64());
            self.told.once(now.as_secs_f64(), None, "stalled", Weight::Warning, text);
        }
    }

    /// What is to be sent.
    pub fn take_outgoing(&mut self) -> Vec<Outgoing> {
        std::mem::take(&mut self.outbox)
    }

    /// The indices of the scenario's vehicles.
    pub fn crew(&self) -> std::ops::Range<usize> {
        0..self.vehicles.iter().take_while(|vehicle| vehicle.slot.is_some()).count()
    }

    /// The operator's command in a message, if it is for the station.
    fn commanded(&self, header: &Header, message: &Message) -> Option<(MavCmd, Option<Verb>)> {
        let (command, verb) = operator::commanded(message)?;
        let target = match message {
            Message::COMMAND_LONG(data) => (data.target_system, data.target_component),
            Message::COMMAND_INT(data) => (data.target_system, data.target_component),
            _ => return None,
        };
        let is_ours = target.0 == GROUND.0 && (target.1 == 0 || target.1 == GROUND.1);
        let is_stranger = self.vehicles.iter().all(|vehicle| vehicle.id() != header.system_id);
        (is_ours && is_stranger).then_some((command, verb))
    }

    fn answer_operator(&mut self, header: &Header, command: MavCmd, verb: Option<Verb>, route: Route) {
        let result = if verb.is_some() { MavResult::MAV_RESULT_ACCEPTED } else { MavResult::MAV_RESULT_UNSUPPORTED };
        if let Some(verb) = verb {
            self.operate(verb, &format!("by MAVLink, system {}", header.system_id));
        }
        let answer = Message::COMMAND_ACK(COMMAND_ACK_DATA {
            command,
            result,
            target_system: header.system_id,
            target_component: header.component_id,
            ..COMMAND_ACK_DATA::DEFAULT
        });
        self.outbox.push(Outgoing { route, messages: vec![answer] });
    }

    /// The vehicle that speaks; a new one at its first heartbeat.
    fn recognise(&mut self, header: &Header, message: &Message, now: Duration) -> Option<usize> {
        if let Some(index) = self.vehicles.iter().position(|vehicle| vehicle.id() == header.system_id) {
            return Some(index);
        }
        let Message::HEARTBEAT(heartbeat) = message else { return None };
        let is_autopilot = heartbeat.autopilot != MavAutopilot::MAV_AUTOPILOT_INVALID
            && !matches!(
                heartbeat.mavtype,
                MavType::MAV_TYPE_GCS
                    | MavType::MAV_TYPE_ONBOARD_CONTROLLER
                    | MavType::MAV_TYPE_GIMBAL
                    | MavType::MAV_TYPE_ADSB
            );
        if !is_autopilot || header.system_id == GROUND.0 {
            return None;
        }
        tracing::debug!(system = header.system_id, at_s = now.as_secs_f64(), "first heard");
        self.vehicles.push(Vehicle::new(header.system_id, header.component_id));
        Some(self.vehicles.len() - 1)
    }

    /// Heartbeats, questions for the time, requests for telemetry.
    fn keep_house(&mut self, now: Duration) {
        if self.beat.is_none_or(|beat| now.saturating_sub(beat) >= BEAT) {
            self.beat = Some(now);
            let mut routes: BTreeSet<Route> = self.settings.calls.iter().copied().collect();
            routes.extend(self.vehicles.iter().flat_map(|vehicle| vehicle.routes.keys().copied()));
            for route in routes {
                let mut messages = vec![ground_heartbeat()];
                let here = self.vehicles.iter().filter(|vehicle| vehicle.routes.contains_key(&route));
                messages.extend(here.map(|vehicle| telemetry::time_request(vehicle, now)));
                self.outbox.push(Outgoing { route, messages });
            }
        }
        for index in 0..self.vehicles.len() {
            let Some(route) = self.vehicles[index].route() else { continue };
            let capacity = self.settings.capacities.get(route.link).copied().flatten();
            let sharing = self.vehicles.iter().filter(|vehicle| vehicle.routes.contains_key(&route)).count();
            let position_hz = telemetry::position_hz(capacity, sharing);
            let messages = telemetry::ask(&mut self.vehicles[index], position_hz, capacity.is_some(), now);
            if !messages.is_empty() {
                if capacity.is_some() {
                    let vehicle = self.vehicles[index].slot.map(number);
                    let text = "its link is slow: streams that are not needed are silenced";
                    self.told.once(now.as_secs_f64(), vehicle, "silenced", Weight::Note, text);
                }
                if position_hz < telemetry::POSITION_HZ {
                    let vehicle = self.vehicles[index].slot.map(number);
                    let text = format!("positions at {position_hz:.1} Hz: that is what its link carries");
                    self.told.once(now.as_secs_f64(), vehicle, "slow link", Weight::Note, text);
                }
                self.outbox.push(Outgoing { route, messages });
            }
        }
    }

    /// The rate at which positions of a vehicle are to come, Hz.
    pub fn position_hz(&self, index: usize) -> f64 {
        let Some(route) = self.vehicles.get(index).and_then(Vehicle::route) else { return telemetry::POSITION_HZ };
        let capacity = self.settings.capacities.get(route.link).copied().flatten();
        let sharing = self.vehicles.iter().filter(|vehicle| vehicle.routes.contains_key(&route)).count();
        telemetry::position_hz(capacity, sharing)
    }

    /// Sends messages to a vehicle by its freshest way.
    pub fn send(&mut self, index: usize, messages: Vec<Message>) {
        if let Some(route) = self.vehicles.get(index).and_then(Vehicle::route)
            && !messages.is_empty()
        {
            self.outbox.push(Outgoing { route, messages });
        }
    }

    /// Gives an order for a purpose, and again while it is not followed; never in a dry run.
    pub fn order(&mut self, index: usize, purpose: &'static str, message: Message, now: Duration) {
        if self.settings.dry_run {
            return;
        }
        let Some(vehicle) = self.vehicles.get_mut(index) else { return };
        let is_due = vehicle
            .orders
            .get(purpose)
            .is_none_or(|order| order.message != message || now.saturating_sub(order.sent) >= ORDER_AGAIN);
        if !is_due {
            return;
        }
        let command = match &message {
            Message::COMMAND_LONG(data) => data.command as u32,
            Message::COMMAND_INT(data) => data.command as u32,
            _ => 0,
        };
        let before = vehicle.orders.get(purpose).filter(|order| order.message == message);
        let (tries, answer) = before.map_or((0, None), |order| (order.tries, order.answer.clone()));
        vehicle
            .orders
            .insert(purpose, Order { command, sent: now, tries: tries + 1, answer, message: message.clone() });
        self.send(index, vec![message]);
    }

    /// Where a vehicle is now: its last position, moved on at its velocity; none when that is stale.
    pub fn state_now(&self, index: usize, now: Duration) -> Option<State> {
        let now_s = now.as_secs_f64();
        let (state, age_s) = self.vehicles.get(index)?.track.carried_to(now_s, STALE_S)?;
        (age_s <= STALE_S).then_some(state)
    }

    /// The speed to be sent for a setpoint, with wind and thin air, and the nearest one that the vehicle takes, m/s.
    fn speeds_to_send_mps(&self, index: usize, setpoint: &Setpoint) -> (f64, f64) {
        let Some(vehicle) = self.vehicles.get(index) else { return (setpoint.speed_mps, setpoint.speed_mps) };
        let asked_mps = vehicle.present.speed_to_send_mps(setpoint);
        let limits = vehicle.limits.unwrap_or_default();
        match (limits.speed_min_mps, limits.speed_max_mps) {
            (Some(least), Some(greatest)) if limits.speeds_are_air && least <= greatest => {
                (asked_mps, asked_mps.clamp(least, greatest))
            }
            _ => (asked_mps, asked_mps),
        }
    }

    /// The messages that ask a vehicle for a setpoint, by its kind's encoder.
    pub fn encode(&self, index: usize, setpoint: &Setpoint, now: Duration) -> Option<Vec<Message>> {
        let vehicle = self.vehicles.get(index)?;
        let (_, speed_mps) = self.speeds_to_send_mps(index, setpoint);
        let situation = Situation {
            state: self.state_now(index, now)?,
            frame: &self.frame,
            local_origin_amsl_m: vehicle.local_origin_amsl_m,
            dynamics: vehicle.present.dynamics(),
            airspeed_excess_mps: speed_mps - setpoint.speed_mps,
            now,
        };
        match vehicle.driver()?.setpoint(vehicle.target, setpoint, &situation) {
            Ok(messages) => Some(messages),
            Err(error) => {
                tracing::debug!(system = vehicle.id(), %error, "setpoint not sent");
                None
            }
        }
    }

    /// Tells something about a vehicle once.
    pub fn tell_once(&mut self, index: usize, what: &str, weight: Weight, text: impl Into<String>, now: Duration) {
        let slot = self.vehicles.get(index).and_then(|vehicle| vehicle.slot).map(number);
        self.told.once(now.as_secs_f64(), slot, what, weight, text);
    }

    /// Times solves.
    pub fn clock(&self) -> &(dyn Fn() -> Duration + Sync) {
        &*self.clock
    }

    /// The circles of the scenario.
    pub fn obstacles(&self) -> Vec<Obstacle> {
        self.scenario.obstacles.clone()
    }
}

/// Whether a message tells a state of the vehicle without the time at which the vehicle was in that state.
fn has_no_time(message: &Message) -> bool {
    matches!(message, Message::HEARTBEAT(_) | Message::EXTENDED_SYS_STATE(_) | Message::SYS_STATUS(_))
}

/// The number under which people know the vehicle of a slot.
pub fn number(slot: usize) -> u32 {
    crate::flight::vehicle_number(slot)
}
