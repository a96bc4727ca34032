//! The ground station: from the ground to the ground with real autopilots.
//!
//! [`Station`] is sans-I/O: it takes the frames that arrive and the time, and gives the messages to send. A flight goes
//! through phases ([phase]), which share how a vehicle is steered (`control.rs`). What is known of a vehicle, and only
//! that, is in [vehicle]. What is said of the flight rests on telemetry alone ([judge]), and is told once ([told]). The
//! sockets, the terminal and the files are in [shell] and [record].

mod control;
pub mod frames;
pub mod judge;
pub mod operator;
pub mod outcome;
pub mod peers;
pub mod phase;
pub mod record;
pub mod shell;
pub mod table;
mod telemetry;
pub mod told;
pub mod vehicle;
mod words;

use crate::config::Scenario;
use crate::identify::flight::StepFlight;
use controller::Obstacle;
use flight_model::{Limits, LocalFrame};
use frames::Origin;
use mavlink_bridge::dialect::{COMMAND_ACK_DATA, MavCmd, MavResult, Message};
use mavlink_bridge::kind::AtEnd;
use mavlink_bridge::{Counters, Frame, Header, SequenceTracker, is_autopilot};
use operator::Verb;
use phase::Phase;
use phase::connect::Connect;
use phase::fly::Flown;
use std::time::Duration;
use told::{Told, Weight};
use vehicle::Vehicle;
use vehicle::routes::Route;

/// MAVLink ids of a ground station (MAV_COMP_ID_MISSIONPLANNER), as autopilots expect them.
pub const GROUND: (u8, u8) = (255, 190);
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
    frame: LocalFrame,
    /// Limits within which the whole flock flies, narrowed to what every vehicle allows.
    limits: Limits,
    /// The scenario's vehicles in their order, then strangers.
    vehicles: Vec<Vehicle>,
    /// What was told.
    pub told: Told,
    /// Lines of the record that wait to be written.
    journal: Vec<serde_json::Value>,
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
            phase: Phase::Connect(Connect::default()),
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

    /// The scenario's vehicles in their order, then strangers.
    pub fn vehicles(&self) -> &[Vehicle] {
        &self.vehicles
    }

    /// Puts the scenario's frame where the vehicles are: positions in another one mean nothing any more.
    fn set_frame(&mut self, frame: LocalFrame) {
        if frame != self.frame {
            self.frame = frame;
            self.vehicles.iter_mut().for_each(Vehicle::forget_track);
        }
    }

    /// Keeps a line for the record.
    fn write(&mut self, line: serde_json::Value) {
        self.journal.push(line);
    }

    /// The lines of the record that wait to be written.
    pub fn take_journal(&mut self) -> Vec<serde_json::Value> {
        std::mem::take(&mut self.journal)
    }

    /// Whether all is said.
    pub fn is_over(&self) -> bool {
        matches!(self.phase, Phase::Over(_))
    }

    /// The flight of which all is said, if there was one.
    fn take_flown(&mut self) -> Option<Flown> {
        match std::mem::replace(&mut self.phase, Phase::Over(None)) {
            Phase::Over(fly) => fly.map(|fly| fly.into_flown()),
            _ => None,
        }
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
        let is_flying = !self.phase.is_before_take_off();
        let Some(vehicle) = self.vehicles.get_mut(index) else { return };
        if header.component_id != vehicle.target().component_id {
            return; // a camera, a gimbal, a companion computer
        }
        if !vehicle.owns(&message, route, is_flying, now) {
            if vehicle.routes().is_anothers(route) {
                let text = "another autopilot speaks with its system id, by another way: nothing of that is taken";
                self.tell_once(index, "doubled", Weight::Warning, text, now);
            }
            return;
        }
        if vehicle.is_overtaken(is_newest, now) && has_no_time(&message) {
            return;
        }
        let was = (vehicle.heard().armed, vehicle.heard().custom_mode);
        vehicle.count_message(header.message_id);
        vehicle.hear(&message, now, &local_frame);
        if was != (vehicle.heard().armed, vehicle.heard().custom_mode) {
            let (armed, mode) = (vehicle.heard().armed, vehicle.mode_name());
            tracing::debug!(system = vehicle.id(), armed, mode, "state");
        }
        if let (Message::STATUSTEXT(_), Some(text)) = (&message, vehicle.heard().last_words())
            && let Some(weight) = words::of_failsafe(text)
        {
            let number = vehicle.slot().map(number);
            self.told.once(now.as_secs_f64(), number, text, weight, format!("says: {text}"));
        }
    }

    /// Takes note of the sequence number of a frame of a vehicle's autopilot. Other senders are not counted: routers
    /// pass on only a part of what others say, so that gaps in their numbers are no losses. Gives whether no newer
    /// frame of its sender came before it, as far as was counted.
    pub fn count(&mut self, frame: &Frame<'_>, sequence: &mut SequenceTracker, counters: &mut Counters) -> bool {
        let header = &frame.header;
        let is_sender = |vehicle: &&mut Vehicle| {
            (vehicle.id(), vehicle.target().component_id) == (header.system_id, header.component_id)
        };
        let Some(vehicle) = self.vehicles.iter_mut().find(is_sender) else { return true };
        let before = counters.lost;
        let is_newest = sequence.observe(frame, counters) == mavlink_bridge::Order::Newer;
        vehicle.count_frame(counters.lost - before);
        is_newest
    }

    /// Does what is due; call it every few hundredths of a second.
    pub fn poll(&mut self, now: Duration) {
        self.watch_the_machine(now);
        self.keep_house(now);
        let phase = std::mem::replace(&mut self.phase, Phase::Over(None));
        let before = phase.name();
        self.phase = phase.step(self, now);
        if self.phase.name() != before {
            self.write(serde_json::json!({"phase": self.phase.name(), "at_s": now.as_secs_f64()}));
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
        0..self.vehicles.iter().take_while(|vehicle| vehicle.slot().is_some()).count()
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
        if !is_autopilot(heartbeat) || header.system_id == GROUND.0 {
            return None;
        }
        tracing::debug!(system = header.system_id, at_s = now.as_secs_f64(), "first heard");
        self.vehicles.push(Vehicle::new(header.system_id, header.component_id));
        Some(self.vehicles.len() - 1)
    }

    /// Tells something about a vehicle once.
    pub fn tell_once(&mut self, index: usize, what: &str, weight: Weight, text: impl Into<String>, now: Duration) {
        let slot = self.vehicles.get(index).and_then(Vehicle::slot).map(number);
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
    matches!(
        message,
        Message::HEARTBEAT(_) | Message::CURRENT_MODE(_) | Message::EXTENDED_SYS_STATE(_) | Message::SYS_STATUS(_)
    )
}

/// The number under which people know the vehicle of a slot.
pub fn number(slot: usize) -> u32 {
    crate::flight::vehicle_number(slot)
}
