//! The forecast of all vehicles during a look-ahead.

use crate::command::Commander;
use crate::law::{Flown, command};
use crate::neighbours::Neighbours;
use crate::terms::Neighbour;
use crate::{Expected, LawSettings, Obstacle};
use flight_model::{Autopilot, Dynamics, Setpoint, State, Wind};
use nalgebra::Vector2;

/// A vehicle at one instant of a forecast.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Passage {
    /// North, m.
    pub x_m: f64,
    /// East, m.
    pub y_m: f64,
    /// Northward, m/s.
    pub vx_mps: f64,
    /// Eastward, m/s.
    pub vy_mps: f64,
}

/// Forecasts of a whole flock, vehicle-major: `1 + 2 * steps` passages each, half a control period apart.
#[derive(Clone, Debug, Default)]
pub struct Forecast {
    passages: Vec<Passage>,
    instants: usize,
    now: Vec<State>,
    next: Vec<State>,
    /// The headings that the commands at hand ask for, rad.
    headings_rad: Vec<Option<f64>>,
    index: Neighbours,
    found: Vec<(f64, u32)>,
    near: Vec<Neighbour>,
}

/// One vehicle as the forecast flies it.
#[derive(Clone, Copy, Debug)]
pub struct Craft {
    commander: Commander,
    /// The vehicle model at half a control period.
    half_period: Autopilot,
}

/// What the flocking law needs besides the states.
pub struct LawContext<'a> {
    pub law: &'a LawSettings,
    pub expected: &'a Expected,
    /// The vehicles; states beyond their number are flown as the first one.
    pub crafts: &'a [Craft],
    /// The winds around them; calm where there is none.
    pub winds: &'a [Wind],
    /// The headings that their last commands asked for, rad.
    pub last_headings_rad: &'a [Option<f64>],
    pub obstacles: &'a [Obstacle],
    pub neighbours_max: usize,
}

impl Craft {
    pub fn new(law: &LawSettings, dynamics: &Dynamics, control_period_s: f64) -> Self {
        Self {
            commander: Commander::new(law, dynamics, control_period_s),
            half_period: Autopilot::new(dynamics, 0.5 * control_period_s),
        }
    }

    /// The states half a control period later and a whole one, on a setpoint of airspeed and heading.
    fn fly(&self, state: &State, setpoint: &Setpoint, wind: &Wind) -> [State; 2] {
        let middle = self.half_period.step_in_wind(state, setpoint, wind);
        [middle, self.half_period.step_in_wind(&middle, setpoint, wind)]
    }
}

impl LawContext<'_> {
    fn setpoint(&self, flown: &Flown<'_>, neighbours: &[Neighbour], weights: [f64; 3]) -> Setpoint {
        command(self.law, self.expected, flown, neighbours, self.obstacles, weights)
    }

    fn wind(&self, vehicle: usize) -> &Wind {
        self.winds.get(vehicle).unwrap_or(&Wind::CALM)
    }

    /// A vehicle; none in a flock of none.
    fn craft(&self, vehicle: usize) -> Option<&Craft> {
        self.crafts.get(vehicle).or(self.crafts.first())
    }
}

impl Forecast {
    /// Every vehicle keeps its velocity (reading 11: neighbours are extrapolated).
    pub fn extrapolate(&mut self, states: &[State], steps: usize, control_period_s: f64) {
        self.instants = 1 + 2 * steps;
        self.passages.clear();
        for state in states {
            let now = Passage::of(state);
            self.passages.extend((0..self.instants).map(|instant| {
                let time_s = 0.5 * control_period_s * instant as f64;
                Passage { x_m: now.x_m + now.vx_mps * time_s, y_m: now.y_m + now.vy_mps * time_s, ..now }
            }));
        }
    }

    /// Every vehicle flies the flocking law with its `weights`, all at once. Where a vehicle has a `first` command
    /// already, it follows that for the first control period.
    pub fn fly_the_law(
        &mut self,
        context: &LawContext<'_>,
        states: &[State],
        weights: impl Fn(usize) -> [f64; 3],
        first: impl Fn(usize) -> Option<Setpoint>,
        steps: usize,
    ) {
        self.instants = 1 + 2 * steps;
        self.passages.clear();
        self.passages.resize(self.instants * states.len(), Passage::default());
        self.now.clear();
        self.now.extend_from_slice(states);
        self.headings_rad.clear();
        self.headings_rad.extend_from_slice(context.last_headings_rad);
        self.headings_rad.resize(states.len(), None);
        let range_m = context.law.communication_distance_m.max(context.law.safe_distance_m);
        for step in 0..=steps {
            for (vehicle, state) in self.now.iter().enumerate() {
                self.passages[vehicle * self.instants + 2 * step] = Passage::of(state);
            }
            if step == steps {
                break;
            }
            self.index.update(&self.now);
            self.next.clear();
            for (vehicle, state) in self.now.iter().enumerate() {
                let Some(craft) = context.craft(vehicle) else { continue };
                let wind = context.wind(vehicle);
                let setpoint = match first(vehicle).filter(|_| step == 0) {
                    Some(first) => first,
                    None => {
                        self.index.nearest(&self.now, vehicle, range_m, context.neighbours_max, &mut self.found);
                        self.near.clear();
                        self.near.extend(self.found.iter().map(|&(_, other)| Neighbour::of(&self.now[other as usize])));
                        let last_heading_rad = self.headings_rad[vehicle];
                        let flown = Flown { commander: &craft.commander, state, wind, last_heading_rad };
                        context.setpoint(&flown, &self.near, weights(vehicle))
                    }
                };
                let setpoint = craft.commander.in_air(&setpoint, wind);
                self.headings_rad[vehicle] = Some(setpoint.course_rad);
                let [middle, end] = craft.fly(state, &setpoint, wind);
                self.passages[vehicle * self.instants + 2 * step + 1] = Passage::of(&middle);
                self.next.push(end);
            }
            std::mem::swap(&mut self.now, &mut self.next);
        }
    }

    /// Forecasts one vehicle again with another first command; the forecast of the others stays.
    pub fn fly_again(
        &mut self,
        context: &LawContext<'_>,
        vehicle: usize,
        start: &State,
        first: Setpoint,
        weights: [f64; 3],
    ) {
        let Some(craft) = context.craft(vehicle) else { return };
        let range_m = context.law.communication_distance_m.max(context.law.safe_distance_m);
        let (mut state, wind) = (*start, context.wind(vehicle));
        let mut setpoint = craft.commander.in_air(&first, wind);
        for step in 0..self.instants / 2 {
            if step > 0 {
                self.near.clear();
                for other in (0..self.passages.len() / self.instants).filter(|&other| other != vehicle) {
                    let there = self.passages[other * self.instants + 2 * step];
                    if (there.position_m() - state.position_m()).norm_squared() <= range_m * range_m {
                        self.near.push(Neighbour {
                            position_m: there.position_m(),
                            velocity_mps: Vector2::new(there.vx_mps, there.vy_mps),
                        });
                    }
                }
                let last_heading_rad = Some(setpoint.course_rad);
                let flown = Flown { commander: &craft.commander, state: &state, wind, last_heading_rad };
                setpoint = craft.commander.in_air(&context.setpoint(&flown, &self.near, weights), wind);
            }
            let [middle, end] = craft.fly(&state, &setpoint, wind);
            state = end;
            self.passages[vehicle * self.instants + 2 * step + 1] = Passage::of(&middle);
            self.passages[vehicle * self.instants + 2 * step + 2] = Passage::of(&state);
        }
    }

    /// The forecast of one vehicle.
    pub fn vehicle(&self, index: usize) -> &[Passage] {
        &self.passages[index * self.instants..(index + 1) * self.instants]
    }
}

impl Passage {
    /// (North, east), m.
    #[inline]
    pub fn position_m(&self) -> Vector2<f64> {
        Vector2::new(self.x_m, self.y_m)
    }

    fn of(state: &State) -> Self {
        let velocity_mps = state.velocity_mps();
        Self { x_m: state.x_m, y_m: state.y_m, vx_mps: velocity_mps.x, vy_mps: velocity_mps.y }
    }
}
