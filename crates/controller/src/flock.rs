//! Algorithm 2: the flock's tick, for every vehicle at once.

use crate::forecast::{Craft, Forecast, LawContext};
use crate::neighbours::Neighbours;
use crate::pilot::{Pilot, Surroundings};
use crate::{Decision, FlockError, FlockSettings, ForecastKind, Insight, Obstacle};
use flight_model::{State, Wind};
use rayon::prelude::*;
use std::time::Duration;

/// The ground controller of a flock. It knows no sockets, no clock and no MAVLink.
///
/// Make it once with [`Flock::new`], then call [`Flock::tick`] once per control period with the states of all vehicles.
pub struct Flock {
    settings: FlockSettings,
    pilots: Vec<Pilot>,
    outlook: Outlook,
    decisions: Vec<Decision>,
    crafts: Vec<Craft>,
    /// The headings that the last commands asked for, rad.
    last_headings_rad: Vec<Option<f64>>,
}

/// What a flock sees at a tick beside the states.
#[derive(Default)]
struct Outlook {
    neighbours: Neighbours,
    forecast: Forecast,
    margins_m: Vec<f64>,
    reference_speeds_mps: Vec<f64>,
    winds: Vec<Wind>,
}

impl Outlook {
    fn around<'a>(&'a self, settings: &'a FlockSettings, states: &'a [State]) -> Surroundings<'a> {
        let Self { neighbours, forecast, margins_m, reference_speeds_mps, winds } = self;
        Surroundings { settings, states, neighbours, forecast, margins_m, reference_speeds_mps, winds }
    }
}

impl Flock {
    /// The controller of a flock of `vehicles` vehicles.
    ///
    /// # Errors
    /// The first setting that is out of its range; [`FlockSettings::check`] finds all of them.
    pub fn new(settings: FlockSettings, vehicles: usize) -> Result<Self, FlockError> {
        if let Some(error) = settings.check().into_iter().next() {
            return Err(FlockError::Setting(error));
        }
        let given = settings.dynamics.len();
        if given != 1 && given != vehicles {
            return Err(FlockError::Dynamics { given, vehicles });
        }
        let pilots = (0..vehicles)
            .map(|vehicle| Pilot::new(&settings, vehicle))
            .collect::<Result<_, optimizer::SettingsError>>()?;
        let craft =
            |vehicle| Craft::new(&settings.controller.law, &settings.dynamics_of(vehicle), settings.control_period_s);
        Ok(Self {
            crafts: (0..vehicles).map(craft).collect(),
            last_headings_rad: vec![None; vehicles],
            settings,
            pilots,
            outlook: Outlook::default(),
            // Before the first solve the forecast flies the law with all weights one.
            decisions: vec![Decision { weights: [1.0; 3], ..Decision::default() }; vehicles],
        })
    }

    /// Replaces the obstacles: those that move are given anew before each tick.
    pub fn set_obstacles(&mut self, obstacles: Vec<Obstacle>) {
        self.settings.obstacles = obstacles;
    }

    /// Says how far off the positions of the next ticks may be, m, one for each vehicle: both constraints of the
    /// look-ahead want so much more distance. None given: the positions are exact.
    pub fn set_margins(&mut self, margins_m: &[f64]) {
        self.outlook.margins_m.clear();
        self.outlook.margins_m.extend_from_slice(margins_m);
    }

    /// Gives the speeds to which Eq. 2 adds at the next ticks, m/s, one for each vehicle: a slow estimate settles where
    /// the measured speed, which the vehicle's own loop moves, would keep both loops busy. None given: those of the
    /// states.
    pub fn set_reference_speeds(&mut self, speeds_mps: &[f64]) {
        self.outlook.reference_speeds_mps.clear();
        self.outlook.reference_speeds_mps.extend_from_slice(speeds_mps);
    }

    /// Gives the winds around the vehicles at the next ticks, one for each: they turn and speed up in the air, and are
    /// carried with it. None given: the air is still.
    pub fn set_winds(&mut self, winds: impl IntoIterator<Item = Wind>) {
        self.outlook.winds.clear();
        self.outlook.winds.extend(winds);
    }

    /// Of which vehicles the next ticks tell what their optimiser had to choose from; none by default. Decisions are
    /// the same with and without.
    pub fn watch(&mut self, vehicles: &[usize]) {
        for (vehicle, pilot) in self.pilots.iter_mut().enumerate() {
            pilot.watch(vehicles.contains(&vehicle));
        }
    }

    /// What the optimisers of the watched vehicles had to choose from at the last tick, with the vehicles' indices.
    pub fn insights(&self) -> impl Iterator<Item = (usize, &Insight)> {
        self.pilots.iter().enumerate().filter_map(|(vehicle, pilot)| Some((vehicle, pilot.insight()?)))
    }

    /// Algorithm 2 for one control period: a decision for each vehicle, in the order of `states`.
    ///
    /// `tick` counts the control periods from 0; with the seed and the vehicle's index it is the key of all random
    /// numbers, so that the same tick with the same states gives the same decisions. `states` must hold one state per
    /// vehicle: states beyond the number of vehicles are ignored, and a vehicle without a state keeps its last
    /// decision. `clock` only measures the time of the solves, and may return zero.
    ///
    /// Vehicles are solved in parallel on rayon's current pool; the result does not depend on the size of the pool.
    /// After the first ticks nothing is allocated.
    ///
    /// ```
    /// use controller::{Expected, Flock, FlockSettings, Obstacle};
    /// use flight_model::{Autopilot, Dynamics, State};
    /// use std::time::Duration;
    ///
    /// let expected = Expected { speed_mps: 10.0, course_rad: 0.0, altitude_m: 50.0 };
    /// let settings = FlockSettings {
    ///     obstacles: vec![Obstacle { x_m: 70.0, y_m: 0.0, radius_m: 8.0 }],
    ///     ..FlockSettings::new(expected)
    /// };
    /// let period_s = settings.control_period_s;
    ///
    /// // Three vehicles abreast, 10 m apart, a little slower than expected.
    /// let start = |y_m| State { y_m, altitude_m: 50.0, speed_mps: 9.0, ..State::default() };
    /// let mut states = [-10.0, 0.0, 10.0].map(start);
    /// let mut flock = Flock::new(settings, states.len())?;
    ///
    /// // Each vehicle follows its setpoint for one control period of 0.5 s.
    /// let autopilot = Autopilot::new(&Dynamics::default(), period_s);
    /// for tick in 0..24 {
    ///     let decisions = flock.tick(tick, &states, &|| Duration::ZERO);
    ///     for (state, decision) in states.iter_mut().zip(decisions) {
    ///         *state = autopilot.step(state, &decision.setpoint);
    ///     }
    /// }
    /// assert!(states.iter().all(|state| state.x_m > 90.0), "all are past the obstacle");
    /// # Ok::<(), controller::FlockError>(())
    /// ```
    pub fn tick(&mut self, tick: u64, states: &[State], clock: &(dyn Fn() -> Duration + Sync)) -> &[Decision] {
        self.look_around(states);
        let around = self.outlook.around(&self.settings, states);
        self.pilots
            .par_iter_mut()
            .zip(&mut self.decisions)
            .zip(states)
            .enumerate()
            .for_each(|(vehicle, ((pilot, decision), _))| *decision = pilot.decide(&around, vehicle, tick, clock));
        if self.settings.controller.look_ahead.evasion {
            self.deconflict(states);
        }
        for ((pilot, decision), heading_rad) in
            self.pilots.iter_mut().zip(&self.decisions).zip(&mut self.last_headings_rad)
        {
            *heading_rad = Some(pilot.commit(decision));
        }
        &self.decisions
    }

    /// The part of [`tick`](Self::tick) for one vehicle alone: its decision before all decisions are checked together.
    /// None if there is no such vehicle or no state of it.
    pub fn decide(
        &mut self,
        tick: u64,
        vehicle: usize,
        states: &[State],
        clock: &(dyn Fn() -> Duration + Sync),
    ) -> Option<Decision> {
        self.look_around(states);
        let around = self.outlook.around(&self.settings, states);
        states.get(vehicle)?;
        Some(self.pilots.get_mut(vehicle)?.decide(&around, vehicle, tick, clock))
    }

    fn look_around(&mut self, states: &[State]) {
        let settings = &self.settings;
        let steps = settings.controller.look_ahead.steps(settings.control_period_s);
        self.outlook.neighbours.update(states);
        match settings.controller.look_ahead.forecast {
            ForecastKind::Straight => self.outlook.forecast.extrapolate(states, steps, settings.control_period_s),
            ForecastKind::Law => {
                let weights = |vehicle: usize| self.decisions.get(vehicle).map_or([1.0; 3], |last| last.weights);
                let context = context(settings, &self.crafts, &self.outlook.winds, &self.last_headings_rad);
                self.outlook.forecast.fly_the_law(&context, states, weights, |_| None, steps);
            }
        }
    }

    /// Checks all commands together before they are sent: each was chosen without knowledge of the others, and two
    /// vehicles that evade each other may turn into each other. One by one, in their order, vehicles that would come
    /// too near change their command, knowing those of all others.
    fn deconflict(&mut self, states: &[State]) {
        let settings = &self.settings;
        let steps = settings.controller.look_ahead.steps(settings.control_period_s);
        let context = context(settings, &self.crafts, &self.outlook.winds, &self.last_headings_rad);
        let weights = |vehicle: usize| self.decisions.get(vehicle).map_or([1.0; 3], |decision| decision.weights);
        let first = |vehicle: usize| self.decisions.get(vehicle).map(|decision| decision.setpoint);
        self.outlook.forecast.fly_the_law(&context, states, weights, first, steps);
        for (vehicle, (pilot, decision)) in self.pilots.iter_mut().zip(&mut self.decisions).enumerate() {
            let around = self.outlook.around(settings, states);
            if let (Some(changed), Some(state)) = (pilot.reconsider(&around, vehicle, *decision), states.get(vehicle)) {
                *decision = changed;
                self.outlook.forecast.fly_again(&context, vehicle, state, changed.setpoint, changed.weights);
                pilot.evaded(self.outlook.forecast.vehicle(vehicle));
            }
        }
    }
}

fn context<'a>(
    settings: &'a FlockSettings,
    crafts: &'a [Craft],
    winds: &'a [Wind],
    last_headings_rad: &'a [Option<f64>],
) -> LawContext<'a> {
    LawContext {
        law: &settings.controller.law,
        expected: &settings.expected,
        crafts,
        winds,
        last_headings_rad,
        obstacles: &settings.obstacles,
        neighbours_max: settings.controller.look_ahead.neighbours_max,
    }
}
