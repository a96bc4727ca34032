//! The flock's tick: Algorithm 2 for every vehicle at once.

use crate::forecast::Forecast;
use crate::neighbours::Neighbours;
use crate::pilot::{Pilot, Surroundings};
use crate::{ControllerSettings, Expected, Obstacle};
use flight_model::{Dynamics, Setpoint, State};
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
}

impl Flock {
    /// A flock of `vehicles`.
    ///
    /// # Errors
    /// When the optimiser's settings make no sense.
    pub fn new(settings: FlockSettings, vehicles: usize) -> Result<Self, optimizer::SettingsError> {
        let pilots = (0..vehicles).map(|_| Pilot::new(&settings)).collect::<Result<_, _>>()?;
        Ok(Self {
            settings,
            pilots,
            neighbours: Neighbours::default(),
            forecast: Forecast::default(),
            decisions: vec![Decision::default(); vehicles],
        })
    }

    /// One control period: a setpoint for each of `states`, in their order.
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
            .enumerate()
            .for_each(|(vehicle, (pilot, decision))| *decision = pilot.decide(&around, vehicle, tick, clock));
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
        Some(self.pilots.get_mut(vehicle)?.decide(&around, vehicle, tick, clock))
    }

    fn look_around(&mut self, states: &[State]) {
        let settings = &self.settings;
        let steps = settings.controller.look_ahead.steps(settings.control_period_s);
        self.neighbours.update(states);
        self.forecast.extrapolate(states, steps, settings.control_period_s);
    }
}
