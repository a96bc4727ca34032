//! The autopilot: how it flies, what it watches over and what it does about it.
//!
//! It names no message. What others are to be told it puts into a queue of [`Event`](event::Event)s, from which the
//! vehicle makes messages. Its parts own their fields: who watches over something proposes, and the [`arbiter`] alone
//! acts.

mod arbiter;
pub(crate) mod arming;
mod attitude;
mod automation;
pub(crate) mod calibration;
pub(crate) mod event;
pub(crate) mod failsafe;
pub(crate) mod fence;
pub(crate) mod flight;
mod guided;
pub(crate) mod habits;
pub(crate) mod home;
pub(crate) mod input;
pub(crate) mod manual_control;
pub(crate) mod mission;
pub(crate) mod outputs;
mod parachute;
pub(crate) mod pilot;
pub(crate) mod plan;
pub(crate) mod rally;
mod session;
pub(crate) mod situation;
mod step;
pub(crate) mod switches;
pub(crate) mod timer;
mod transmitter;

use crate::counters::VehicleCounters;
use crate::error::{CommandError, ParameterError, PlanError, SetpointError, Severity};
use crate::firmware::rules::Rules;
use crate::mode::Mode;
use crate::parameters::Parameters;
use crate::parameters::table::{Effect, Parameter};
use crate::settings::VehicleSettings;
use crate::world::World;
use event::{Event, Events};
use failsafe::setpoints;
use failsafe::streams::has_offboard_stream;
use fence::Fence;
use fence::kinds::Kinds;
use fence::monitor::FenceReport;
use flight::Flight;
use flight::guidance::RallyPlace;
use flight::tuning::Tuning;
use flight_model::{LocalFrame, Setpoint};
use home::{Home, Reference};
use input::check_finite;
use mavlink_bridge::{PartialSetpoint, PlanItem};
use mission::Mission;
use mission::progress::Progress;
use plan::PlanKind;
use rally::Rally;
use session::Session;
use situation::Situation;
use std::time::Duration;
use timer::Timer;

/// Why a mission is over that has been flown.
pub(crate) const MISSION_COMPLETE: &str = "Mission complete";

/// One autopilot in its aircraft and its world. It knows vehicle time alone.
#[derive(Debug)]
pub(crate) struct Autopilot {
    rules: &'static Rules,
    frame: LocalFrame,
    /// Integration step.
    step: Duration,
    /// The mode that it is in when it is switched on.
    boot_mode: Mode,
    loiter_radius_m: f64,
    /// Whether its time stands still between setpoints.
    is_in_lockstep: bool,
    time: Duration,
    /// How often it has been switched on.
    boots: u16,
    pub flight: Flight,
    pub world: World,
    pub parameters: Parameters,
    mission: Mission,
    fence: Fence,
    rally: Rally,
    pub session: Session,
    counters: VehicleCounters,
    events: Events,
}

impl Autopilot {
    pub fn new(settings: &VehicleSettings, is_in_lockstep: bool) -> Self {
        Self::with_rules(settings.personality.rules(), settings, is_in_lockstep)
    }

    /// The same, with the rules of an autopilot that may be none of [`Personality`](crate::Personality).
    pub fn with_rules(rules: &'static Rules, settings: &VehicleSettings, is_in_lockstep: bool) -> Self {
        let parameters = Parameters::with_rules(rules, settings);
        let first = if settings.on_ground { Mode::Manual } else { settings.mode };
        Self {
            rules,
            frame: settings.frame,
            step: settings.step,
            boot_mode: (rules.first_mode)(first, is_in_lockstep),
            loiter_radius_m: settings.loiter_radius_m,
            is_in_lockstep,
            time: Duration::ZERO,
            boots: 1,
            flight: Flight::new(settings),
            world: World::new(settings, &parameters),
            parameters,
            mission: Mission::new(rules.first_mission_item),
            fence: Fence::default(),
            rally: Rally::default(),
            session: Session::default(),
            counters: VehicleCounters::default(),
            events: Events::default(),
        }
    }

    /// What the settings have set is there: it begins to fly.
    pub fn start(&mut self) {
        self.flight.set_mode(self.boot_mode);
        self.session.fence.reconfigure(Parameter::FenceEnable, &self.parameters);
        self.restart_setpoint_timeout();
    }

    /// As it was switched on: parameters and plans are kept, and all that has been told it since is gone, its home too.
    /// A vehicle that started on the ground stands at its start again, as in the autopilots' own simulators; any other
    /// stays where it is. Its time goes on, for the clock does.
    pub fn reboot(&mut self) {
        self.boots = self.boots.saturating_add(1);
        if self.flight.is_armed() {
            self.disarm(arming::Cause::Command);
        }
        self.session = Session::default();
        self.flight.stand_at_start();
        self.set_mode(self.boot_mode);
        if self.flight.is_on_ground() {
            self.set_home_here();
        } else {
            self.set_home(Home::default());
        }
        self.flight.set_speed(f64::from(self.parameters.get(Parameter::AirspeedCruise)), f64::INFINITY);
        self.flight.set_least_ground_speed(0.0);
        let capacity_mah = f64::from(self.parameters.get(Parameter::BatteryCapacity));
        self.world.reset_battery(&self.parameters, capacity_mah, 1.0);
        self.session.progress = Progress::at_beginning(&self.mission);
        self.session.fence.reconfigure(Parameter::FenceEnable, &self.parameters);
    }

    /// The same aircraft anew, as of a vehicle time: for a reset, over which time goes on.
    pub fn go_on_at(&mut self, time: Duration, counters: VehicleCounters) {
        self.time = time;
        self.counters = counters;
    }

    // What it is and how it stands.

    pub fn rules(&self) -> &'static Rules {
        self.rules
    }

    pub fn time(&self) -> Duration {
        self.time
    }

    pub fn frame(&self) -> &LocalFrame {
        &self.frame
    }

    #[inline]
    pub fn mode(&self) -> Mode {
        self.flight.mode()
    }

    /// The present mode, as the autopilot calls it.
    pub fn mode_name(&self) -> &'static str {
        (self.rules.mode_name)(self.mode())
    }

    pub fn mission(&self) -> &Mission {
        &self.mission
    }

    /// Whether something is amiss.
    pub fn is_in_failsafe(&self) -> bool {
        self.session.failsafes.is_any()
    }

    /// What it has counted: failsafes and setpoints.
    pub fn counters(&self) -> VehicleCounters {
        self.counters
    }

    pub fn fence_report(&self) -> FenceReport {
        self.session.fence.report(&self.fence, &self.parameters)
    }

    /// How things stand.
    #[inline]
    pub fn situation(&self) -> Situation<'_> {
        Situation {
            time: self.time,
            rules: self.rules,
            flight: &self.flight,
            fence: &self.fence,
            parameters: &self.parameters,
            world: &self.world,
            is_in_lockstep: self.is_in_lockstep,
        }
    }

    /// How things stand, beside what watches over them.
    #[inline]
    fn split(&mut self) -> (Situation<'_>, &mut Session, &mut Events) {
        let now = Situation {
            time: self.time,
            rules: self.rules,
            flight: &self.flight,
            fence: &self.fence,
            parameters: &self.parameters,
            world: &self.world,
            is_in_lockstep: self.is_in_lockstep,
        };
        (now, &mut self.session, &mut self.events)
    }

    /// What turns places and altitudes of requests into those that are flown.
    pub fn reference(&self) -> Reference<'_> {
        Reference { frame: &self.frame, home: self.flight.home() }
    }

    // What it tells.

    pub fn say(&mut self, severity: Severity, text: &str) {
        self.events.say(severity, text);
    }

    /// What has happened and is not yet told.
    pub fn events(&mut self) -> &mut Events {
        &mut self.events
    }

    // Modes and home.

    pub fn set_mode(&mut self, mode: Mode) {
        let is_new = mode != self.mode();
        if mode == Mode::Auto && is_new {
            self.session.progress.begin(&self.mission);
        }
        if mode == Mode::Rtl && is_new {
            let rally = self.best_rally();
            self.flight.set_rally(rally);
            self.session.progress.look_for_landing_again();
        }
        self.flight.set_mode(mode);
        if is_new {
            self.begin_return();
        }
        if is_new && self.flight.is_armed() {
            match mode {
                Mode::Auto => self.tell_mission_begins(),
                Mode::Rtl => self.tell_return(),
                _ => {}
            }
        }
        if is_new {
            let session = &mut self.session;
            session.fence.mode_changed(self.rules, self.time, &mut session.timers, &mut self.events);
        }
        self.session.failsafes.mode_set();
        self.restart_setpoint_timeout();
        if is_new && self.rules.tells_mode_at_once {
            self.events.push(Event::ModeChanged);
        }
    }

    /// The rally point to return to from here; none means home.
    fn best_rally(&self) -> Option<RallyPlace> {
        self.rally.best(&self.flight, &self.reference(), &self.parameters)
    }

    /// Makes where it is its home.
    pub fn set_home_here(&mut self) {
        let state = self.flight.state();
        self.set_home(Home::new(state.position_m(), state.altitude_m));
    }

    /// Everybody is told of a new home, as ArduPlane does.
    pub fn set_home(&mut self, home: Home) {
        self.flight.set_home(home);
        self.events.push(Event::HomeMoved);
    }

    // Setpoints.

    pub fn restart_setpoint_timeout(&mut self) {
        let (now, session, _) = self.split();
        setpoints::restart(&now, &mut session.timers);
    }

    /// Nothing is waited for until the next guided command.
    pub fn stop_setpoint_timeout(&mut self) {
        self.session.timers.clear(Timer::SetpointTimeout);
    }

    pub fn check_guided(&self) -> Result<(), SetpointError> {
        match self.flight.mode() {
            Mode::Guided => Ok(()),
            other => Err(SetpointError::NotGuided(other)),
        }
    }

    /// Follows a setpoint of all three.
    pub fn command(&mut self, setpoint: &Setpoint) -> Result<(), SetpointError> {
        self.check_guided()?;
        if !setpoint.is_finite() {
            return Err(mavlink_bridge::SetpointError::NotFinite.into());
        }
        self.flight.set_ground_speed(setpoint.speed_mps);
        self.flight.set_course(setpoint.course_rad, f64::INFINITY);
        self.flight.set_altitude(setpoint.altitude_m, f64::INFINITY);
        self.restart_setpoint_timeout();
        Ok(())
    }

    /// Follows a setpoint that may leave out speed and course, or the altitude; what it leaves out stays as it is.
    pub fn follow(&mut self, setpoint: &PartialSetpoint) {
        self.count_setpoint();
        let full = setpoint.over(&self.flight.state().hold());
        if let Some(velocity) = setpoint.velocity {
            self.flight.set_ground_speed(full.speed_mps);
            // A velocity of zero has no direction: the course stays.
            if velocity.norm_squared() > 0.0 {
                self.flight.set_course(full.course_rad, f64::INFINITY);
            }
        }
        if setpoint.altitude.is_some() {
            self.flight.set_altitude(full.altitude_m, f64::INFINITY);
        }
        self.restart_setpoint_timeout();
    }

    /// Counts a setpoint that is followed.
    pub fn count_setpoint(&mut self) {
        self.counters.setpoints_accepted += 1;
    }

    /// Counts a setpoint that is not followed, and says why: setpoints come in streams, one word in five seconds is
    /// enough.
    pub fn refuse_setpoint(&mut self, severity: Severity, text: &str) {
        self.counters.setpoints_refused += 1;
        if !self.session.timers.is_running(Timer::QuietSetpoints, self.time) {
            self.session.timers.set(Timer::QuietSetpoints, self.time + Duration::from_secs(5));
            self.say(severity, text);
        }
    }

    /// A setpoint has come that counts for the offboard stream.
    pub fn hear_offboard_setpoint(&mut self) {
        self.session.timers.set(Timer::OffboardStream, self.time);
    }

    /// Whether setpoints have come of late.
    pub fn has_offboard_stream(&self) -> bool {
        has_offboard_stream(&self.situation(), &self.session.timers)
    }

    /// Whether somebody holds the sticks.
    pub fn are_sticks_held(&self) -> bool {
        self.session.channels.are_held(self.time)
    }

    /// A heartbeat of a system: of the ground station that is listened for, and of nobody else.
    pub fn hear_heartbeat(&mut self, system_id: u8, is_ground_station: bool) {
        let counts = if self.rules.any_ground_station {
            is_ground_station
        } else {
            f32::from(system_id) == self.parameters.get(Parameter::GroundSystemId)
        };
        if counts {
            let (now, session, events) = self.split();
            session.failsafes.ground_station.hear(&now, &mut session.timers, events);
        }
    }

    // Parameters and plans.

    /// Takes a value of a parameter, and does what it means to the flight.
    pub fn set_parameter(&mut self, parameter: Parameter, value: f32) -> Result<(), ParameterError> {
        // Simulated time is its controller's, and the points of older protocols are ArduPilot's.
        let is_told_only = parameter == Parameter::Speedup && self.is_in_lockstep
            || parameter.row().effect == Effect::Points && !self.rules.has_ardupilot_commands;
        if is_told_only {
            return Err(ParameterError::ReadOnly(self.parameters.name(parameter).into()));
        }
        self.parameters.set(parameter, value)?;
        match parameter.row().effect {
            Effect::Tuning => self.flight.retune(Tuning::of(&self.parameters, self.loiter_radius_m)),
            Effect::Battery => self.world.replace_battery(),
            Effect::Fence => self.session.fence.reconfigure(parameter, &self.parameters),
            // In range, so it fits.
            Effect::Points if parameter == Parameter::FenceTotal => self.fence.set_total(value as u8),
            Effect::Points => self.rally.set_total(value as u16),
            Effect::SetpointTimeout => self.restart_setpoint_timeout(),
            Effect::SystemId | Effect::Rates(_) | Effect::RadioLoss | Effect::Speedup => {}
            Effect::LookedUp | Effect::ReadOnly => {}
        }
        Ok(())
    }

    /// What a parameter is now.
    pub fn parameter_value(&self, parameter: Parameter) -> f32 {
        match parameter {
            Parameter::RunTime => self.time.as_secs() as f32,
            Parameter::BootCount => f32::from(self.boots),
            Parameter::MissionTotal => self.mission.items().len() as f32,
            Parameter::FenceTotal => f32::from(self.fence.total()),
            Parameter::RallyTotal => self.rally.items().len() as f32,
            other => self.parameters.get(other),
        }
    }

    /// The items of a plan.
    pub fn plan(&self, kind: PlanKind) -> &[PlanItem] {
        match kind {
            PlanKind::Mission => self.mission.items(),
            PlanKind::Fence => self.fence.items(),
            PlanKind::Rally => self.rally.items(),
        }
    }

    /// The fence and the rally points, for the older protocols that write them point by point.
    pub fn points(&mut self) -> (&mut Fence, &mut Rally, &LocalFrame) {
        (&mut self.fence, &mut self.rally, &self.frame)
    }

    /// Takes a plan whose items have been checked one by one, or says why it makes no sense as a whole. `anew` tells
    /// that it is another one, and not the old one with some items changed.
    pub fn replace_plan(&mut self, kind: PlanKind, items: Vec<PlanItem>, anew: bool) -> Result<(), PlanError> {
        match kind {
            PlanKind::Mission => {
                let is_feasible = !self.rules.judges_plans_as_px4 || self.judge_mission(&items, false);
                self.mission.replace(items, is_feasible);
                self.session.progress.mission_changed(&self.mission, anew, self.rules.resumes_after_upload);
                // An ArduPlane whose mission is replaced by nothing flies on where it was led.
                let ends = !self.mission.is_flyable() && !self.mission.is_without_home();
                if self.mode() == Mode::Auto && self.flight.is_armed() && ends {
                    self.end_mission("Mission cleared");
                }
            }
            PlanKind::Fence if self.rules.judges_plans_as_px4 => {
                self.replace_fence_parts(&items);
                self.judge_mission_anew();
            }
            PlanKind::Fence => self.fence.replace(&items, &self.frame)?,
            PlanKind::Rally => self.rally.replace(&items),
        }
        Ok(())
    }

    /// A mission has been cleared, which was not flown: an ArduPlane does not stay in AUTO.
    pub fn have_cleared_mission(&mut self) {
        if self.rules.returns_without_mission && self.mode() == Mode::Auto {
            self.set_mode(self.rules.mode_after_mission);
            self.say(Severity::Info, "Aircraft in auto without a running mission");
        }
    }

    /// Whether a PX4 flies a mission; says why not, and what it thinks of one that it flies unless that is known.
    fn judge_mission(&mut self, items: &[PlanItem], is_silent_if_flyable: bool) -> bool {
        let (reference, here) = (self.reference(), self.flight.here());
        let get = |parameter: Parameter| self.parameters.get(parameter);
        let verdict = mission::feasibility::judge(
            items,
            &mission::feasibility::Conditions {
                is_landed: !self.flight.is_flying(),
                requirements: get(Parameter::MissionRequirements) as u8,
                landing_angle_deg: f64::from(get(Parameter::LandingAngle)),
                first_distance_max_m: f64::from(get(Parameter::FirstWaypointDistance)),
                home: reference.home.at(),
                place: &|item| reference.place_of(item, here),
                above_home_m: &|item| reference.altitude_of(item) - reference.home.altitude_m,
                is_outside: &|item| {
                    let place = reference.place_of(item, here);
                    self.session.fence.is_outside(&self.situation(), place, reference.altitude_of(item))
                },
            },
        );
        if !is_silent_if_flyable || !verdict.is_flyable {
            verdict.texts.iter().for_each(|text| self.say(Severity::Critical, text));
        }
        verdict.is_flyable
    }

    /// The fence or what is asked for may have changed: a PX4 judges the mission on board anew.
    pub(crate) fn judge_mission_anew(&mut self) {
        if self.rules.judges_plans_as_px4 && !self.mission.items().is_empty() {
            let items = self.mission.items().to_vec();
            let is_feasible = self.judge_mission(&items, true);
            self.mission.set_feasible(is_feasible);
        }
    }

    fn replace_fence_parts(&mut self, items: &[PlanItem]) {
        let acts = self.parameters.get(Parameter::FenceAction) != 0.0 && self.flight.is_flying();
        let flying = acts.then(|| self.flight.here());
        for text in self.fence.replace_parts(items, &self.frame, self.flight.home().at(), flying) {
            self.say(Severity::Critical, text);
        }
    }

    fn tell_return(&mut self) {
        if let Some(words) = self.rules.words.returns {
            let altitude_m = self.flight.target_altitude_m();
            let above_sea_m = self.frame.origin().altitude_amsl_m + altitude_m;
            let above_home_m = altitude_m - self.flight.home().altitude_m;
            let text = words(above_sea_m.ceil() as i64, above_home_m.ceil() as i64);
            self.say(Severity::Info, &text);
        }
    }

    /// A mission is flown from now on.
    fn tell_mission_begins(&mut self) {
        if let Some(text) = self.rules.words.mission_begins.filter(|_| self.mission.is_flyable()) {
            self.say(Severity::Info, text);
        }
    }

    /// A mission is over.
    pub(crate) fn end_mission(&mut self, text: &str) {
        let mode = self.rules.mode_after_mission;
        let name = (self.rules.mode_name)(mode);
        let text = (self.rules.words.mission_ends)(text, !self.flight.is_flying(), name);
        self.say(Severity::Info, &text);
        self.set_mode(mode);
    }

    /// DO_FENCE_ENABLE. Param 1: 0 off, 1 on, 2 only the least altitude off. Param 2: which kinds, 0 for all.
    pub fn enable_fence(&mut self, [action, kinds]: [f32; 2]) -> Result<(), CommandError> {
        check_finite("Fence", &[action, kinds])?;
        self.session.fence.switch(action as i64, kinds as Kinds, &self.fence, &self.parameters)
    }
}
