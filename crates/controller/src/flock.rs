//! Algorithm 2: the flock's tick, for every vehicle at once.

use crate::command::Commander;
use crate::forecast::{Forecast, LawContext};
use crate::neighbours::Neighbours;
use crate::pilot::{Pilot, Surroundings};
use crate::{Decision, FlockSettings, ForecastKind};
use flight_model::{Autopilot, State};
use rayon::prelude::*;
use std::time::Duration;

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
        if self.settings.controller.look_ahead.evasion {
            self.deconflict(states);
        }
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
                let weights = |vehicle: usize| self.decisions.get(vehicle).map_or([1.0; 3], |last| last.weights);
                let context = context(settings, &self.commander, &self.half_period);
                self.forecast.fly_the_law(&context, states, weights, |_| None, steps);
            }
        }
    }

    /// Looks at all commands together before they go out: each was decided without knowledge of the others, and two that
    /// dodge each other may dodge into each other. One by one, in their order, vehicles that would come too near change
    /// their command, knowing those of all others.
    fn deconflict(&mut self, states: &[State]) {
        let settings = &self.settings;
        let steps = settings.controller.look_ahead.steps(settings.control_period_s);
        let context = context(settings, &self.commander, &self.half_period);
        let weights = |vehicle: usize| self.decisions.get(vehicle).map_or([1.0; 3], |decision| decision.weights);
        let first = |vehicle: usize| self.decisions.get(vehicle).map(|decision| decision.setpoint);
        self.forecast.fly_the_law(&context, states, weights, first, steps);
        for (vehicle, (pilot, decision)) in self.pilots.iter_mut().zip(&mut self.decisions).enumerate() {
            let around = Surroundings { settings, states, neighbours: &self.neighbours, forecast: &self.forecast };
            if let (Some(changed), Some(state)) = (pilot.reconsider(&around, vehicle, *decision), states.get(vehicle)) {
                *decision = changed;
                self.forecast.fly_again(&context, vehicle, state, changed.setpoint, changed.weights);
            }
        }
    }
}

fn context<'a>(settings: &'a FlockSettings, commander: &'a Commander, half_period: &'a Autopilot) -> LawContext<'a> {
    LawContext {
        law: &settings.controller.law,
        expected: &settings.expected,
        commander,
        obstacles: &settings.obstacles,
        half_period,
        neighbours_max: settings.controller.look_ahead.neighbours_max,
    }
}
