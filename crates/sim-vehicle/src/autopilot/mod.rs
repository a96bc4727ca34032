//! The autopilot: how it flies, what it watches over and what it does about it.
//!
//! It names no message. What others are to be told it puts into a queue of [`Event`](event::Event)s, from which the vehicle
//! makes messages.

pub(crate) mod arming;
pub(crate) mod event;
pub(crate) mod failsafe;
pub(crate) mod fence;
pub(crate) mod flight;
pub(crate) mod guided;
pub(crate) mod home;
pub(crate) mod manual_control;
pub(crate) mod mission;
pub(crate) mod plan;
pub(crate) mod rally;

use crate::autopilot::event::{Event, Events};
use crate::autopilot::failsafe::Failsafes;
use crate::autopilot::fence::Fence;
use crate::autopilot::flight::Flight;
use crate::autopilot::manual_control::Channels;
use crate::autopilot::mission::{Mission, Progress};
use crate::autopilot::rally::Rally;
use crate::counters::VehicleCounters;
use crate::error::Severity;
use crate::firmware::{Personality, px4};
use crate::mode::Mode;
use crate::parameters::{Effect, Parameter, ParameterRefused, Parameters};
use crate::settings::VehicleSettings;
use crate::vehicle::SetpointRefused;
use crate::world::World;
use flight_model::{Setpoint, State};
use mavlink_bridge::SetpointError;
use std::time::Duration;

/// One autopilot in its aircraft and its world. It knows vehicle time alone.
#[derive(Debug)]
pub(crate) struct Autopilot {
    pub settings: VehicleSettings,
    pub flight: Flight,
    pub time: Duration,
    /// Whether its time stands still between setpoints.
    pub is_in_lockstep: bool,
    pub failsafes: Failsafes,
    pub world: World,
    pub parameters: Parameters,
    pub mission: Mission,
    pub progress: Progress,
    pub fence: Fence,
    pub rally: Rally,
    /// Vehicle time before which no further refused setpoint is put into words.
    pub quiet_until: Duration,
    pub channels: Channels,
    /// What stood against arming when it was last looked at, and when that is said again, vehicle time.
    pub arming_reason: Option<String>,
    pub arming_reason_due: Duration,
    /// Vehicle time at which it last flew.
    pub flown_at: Duration,
    /// Whether somebody has set home: then arming leaves it.
    pub home_is_set: bool,
    pub px4: px4::State,
    pub counters: VehicleCounters,
    pub events: Events,
}

impl Autopilot {
    pub fn new(settings: VehicleSettings, is_in_lockstep: bool) -> Self {
        let parameters = Parameters::new(&settings);
        Self {
            world: World::new(&settings, &parameters),
            flight: Flight::new(&settings),
            time: Duration::ZERO,
            is_in_lockstep,
            failsafes: Failsafes::new(),
            parameters,
            mission: Mission::new(settings.personality.first_mission_item()),
            progress: Progress::default(),
            fence: Fence::default(),
            rally: Rally::default(),
            quiet_until: Duration::ZERO,
            channels: Channels::default(),
            arming_reason: None,
            arming_reason_due: Duration::ZERO,
            flown_at: Duration::ZERO,
            home_is_set: false,
            px4: px4::State::default(),
            counters: VehicleCounters::default(),
            events: Events::default(),
            settings,
        }
    }

    /// What the settings have set is there: it begins to fly.
    pub fn start(&mut self) {
        let first_mode = self.settings.personality.first_mode(self.mode(), self.is_in_lockstep);
        self.flight.set_mode(first_mode);
        self.reconfigure_fence(Parameter::FenceEnable);
        self.restart_setpoint_timeout();
    }

    /// One integration step, which ends at `time`, and all that is looked at after it.
    pub fn step(&mut self, time: Duration, track: &mut Vec<State>) {
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

    /// As it was switched on, where it stands: parameters and plans are kept, and all that has been told it since is gone.
    /// Its time goes on, for the clock does.
    pub fn reboot(&mut self) {
        let first = if self.settings.on_ground { Mode::Manual } else { self.settings.mode };
        let mode = self.settings.personality.first_mode(first, self.is_in_lockstep);
        self.failsafes = Failsafes::new();
        self.channels = Channels::default();
        self.px4 = px4::State::default();
        self.quiet_until = Duration::ZERO;
        self.home_is_set = false;
        self.set_mode(mode);
        self.reset_mission();
        self.fence.forget_breaches();
        self.reconfigure_fence(Parameter::FenceEnable);
    }

    pub fn mode(&self) -> Mode {
        self.flight.mode()
    }

    /// Whether something is amiss.
    pub fn is_in_failsafe(&self) -> bool {
        self.failsafes.is_any() || self.px4.failsafe.is_some()
    }

    pub fn say(&mut self, severity: Severity, text: &str) {
        self.events.say(severity, text);
    }

    /// Takes a value of a parameter, and does what it means to the flight.
    pub fn set_parameter(&mut self, parameter: Parameter, value: f32) -> Result<(), ParameterRefused> {
        self.parameters.set(parameter, value)?;
        match parameter.row().effect {
            Effect::Tuning => self.flight.retune(self.parameters.tuning(&self.settings)),
            Effect::Battery => self.world.battery.replace(),
            Effect::Fence => self.reconfigure_fence(parameter),
            Effect::SetpointTimeout => self.restart_setpoint_timeout(),
            Effect::SystemId | Effect::Rates(_) | Effect::RadioLoss | Effect::LookedUp | Effect::ReadOnly => {}
        }
        Ok(())
    }

    /// What a parameter is now.
    pub fn parameter_value(&self, parameter: Parameter) -> f32 {
        match parameter {
            Parameter::RunTime => self.time.as_secs() as f32,
            Parameter::MissionTotal => self.mission.items.len() as f32,
            Parameter::FenceTotal => self.fence.total() as f32,
            Parameter::RallyTotal => self.rally.items.len() as f32,
            other => self.parameters.get(other),
        }
    }

    pub fn set_mode(&mut self, mode: Mode) {
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
            self.events.push(Event::ModeChanged);
        }
    }

    pub fn check_guided(&self) -> Result<(), SetpointRefused> {
        match self.flight.mode() {
            Mode::Guided => Ok(()),
            other => Err(SetpointRefused::NotGuided(other)),
        }
    }

    /// Follows a setpoint of all three.
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

    /// Counts a setpoint that is not followed, and says why: setpoints come in streams, one word in five seconds is enough.
    pub fn refuse_setpoint(&mut self, severity: Severity, text: &str) {
        self.counters.setpoints_refused += 1;
        if self.time >= self.quiet_until {
            self.quiet_until = self.time + Duration::from_secs(5);
            self.say(severity, text);
        }
    }
}
