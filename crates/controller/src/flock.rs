//! The flock's tick: Algorithm 2 for every vehicle at once.

use crate::command::Commander;
use crate::forecast::{Crew, Forecast};
use crate::neighbours::Neighbours;
use crate::pilot::{Pilot, Surroundings};
use crate::{ControllerSettings, Expected, ForecastKind, Obstacle};
use flight_model::{Autopilot, Dynamics, Setpoint, State};
use optimizer::MslpioSettings;
use rayon::prelude::*;
use std::time::Duration;

/// What a flock needs to know before its first tick.
#[derive(Clone, Debug)]
pub struct FlockSettings {
    /// The flocking law, its weights and look-ahead.
    pub controller: ControllerSettings,
    /// The optimiser that picks the weights.
    pub optimizer: MslpioSettings,
    /// Key of every random number, with the vehicle's index and the tick.
    pub seed: u64,
    /// T, s.
    pub control_period_s: f64,
    /// What the flock is to do.
    pub expected: Expected,
    /// What it is to avoid.
    pub obstacles: Vec<Obstacle>,
    /// How its vehicles fly.
    pub dynamics: Dynamics,
}

impl FlockSettings {
    /// The paper's settings in an empty field, T = 0.5 s.
    pub fn new(expected: Expected) -> Self {
        Self {
            controller: ControllerSettings::default(),
            optimizer: MslpioSettings::default(),
            seed: 1,
            control_period_s: 0.5,
            expected,
            obstacles: Vec::new(),
            dynamics: Dynamics::default(),
        }
    }
}

/// What one vehicle is told at one tick, and how that came about.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Decision {
    /// The inputs of the three autopilots (Eq. 2).
    pub setpoint: Setpoint,
    /// alpha_f, alpha_o, alpha_nv.
    pub weights: [f64; 3],
    /// Whether the chosen weights keep both constraints over the horizon.
    pub feasible: bool,
    /// How long the optimiser took.
    pub solve: Duration,
}

/// The ground controller of a flock. It knows no sockets, no clock and no MAVLink.
pub struct Flock {
    settings: FlockSettings,
    pilots: Vec<Pilot>,
    neighbours: Neighbours,
    forecast: Forecast,
    decisions: Vec<Decision>,
    commander: Commander,
    half_period: Autopilot,
}

impl Flock {
    /// A flock of `vehicles`.
    ///
    /// # Errors
    /// When the optimiser's settings make no sense.
    pub fn new(settings: FlockSettings, vehicles: usize) -> Result<Self, optimizer::SettingsError> {
        let pilots = (0..vehicles).map(|_| Pilot::new(&settings)).collect::<Result<_, _>>()?;
        Ok(Self {
            half_period: Autopilot::new(&settings.dynamics, 0.5 * settings.control_period_s),
            commander: Commander::new(&settings.controller.law, &settings.dynamics, settings.control_period_s),
            settings,
            pilots,
            neighbours: Neighbours::default(),
            forecast: Forecast::default(),
            // Before the first solve the forecast flies the law with all weights one.
            decisions: vec![Decision { weights: [1.0; 3], ..Decision::default() }; vehicles],
        })
    }

    /// One control period: a setpoint for each of `states`, in their order. There must be as many as vehicles: of any
    /// further ones, or of vehicles without a state, the decision stays what it was.
    ///
    /// Vehicles are solved in parallel on rayon's current pool; the result does not depend on its size. `clock` only
    /// times the solves.
    pub fn tick(&mut self, tick: u64, states: &[State], clock: &(dyn Fn() -> Duration + Sync)) -> &[Decision] {
        self.look_around(states);
        let around =
            Surroundings { settings: &self.settings, states, neighbours: &self.neighbours, forecast: &self.forecast };
        self.pilots
            .par_iter_mut()
            .zip(&mut self.decisions)
            .zip(states)
            .enumerate()
            .for_each(|(vehicle, ((pilot, decision), _))| *decision = pilot.decide(&around, vehicle, tick, clock));
        &self.decisions
    }

    /// The part of a tick that concerns one vehicle: what it would decide by itself, having heard the others.
    pub fn decide(
        &mut self,
        tick: u64,
        vehicle: usize,
        states: &[State],
        clock: &(dyn Fn() -> Duration + Sync),
    ) -> Option<Decision> {
        self.look_around(states);
        let around =
            Surroundings { settings: &self.settings, states, neighbours: &self.neighbours, forecast: &self.forecast };
        states.get(vehicle)?;
        Some(self.pilots.get_mut(vehicle)?.decide(&around, vehicle, tick, clock))
    }

    fn look_around(&mut self, states: &[State]) {
        let settings = &self.settings;
        let steps = settings.controller.look_ahead.steps(settings.control_period_s);
        self.neighbours.update(states);
        match settings.controller.look_ahead.forecast {
            ForecastKind::Straight => self.forecast.extrapolate(states, steps, settings.control_period_s),
            ForecastKind::Law => {
                let law = &settings.controller.law;
                let crew = Crew {
                    law,
                    expected: &settings.expected,
                    commander: &self.commander,
                    obstacles: &settings.obstacles,
                    half_period: &self.half_period,
                    neighbours_max: settings.controller.look_ahead.neighbours_max,
                };
                self.forecast.fly_the_law(
                    &crew,
                    states,
                    |vehicle| self.decisions.get(vehicle).map_or([1.0; 3], |last| last.weights),
                    steps,
                );
            }
        }
    }
}
