//! What parameters of a mode's habits change: FLIGHT_OPTIONS, RTL_CLIMB_MIN, LEVEL_ROLL_LIMIT.

use super::Flight;
use crate::parameters::Parameters;
use crate::parameters::table::Parameter;
use flight_model::Setpoint;

/// Bits of FLIGHT_OPTIONS (`defines.h` of ArduPlane). The others are for surfaces, trims and checks that there are not,
/// or ask for what is done anyway.
const CENTRED_THROTTLE_CRUISES: u32 = 1 << 1;
const THROTTLE_CRUISES: u32 = 1 << 3;
const CLIMB_BEFORE_TURN: u32 = 1 << 4;
const STICK_CLIMBS_IN_LOITER: u32 = 1 << 12;

/// What they make of the modes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Options {
    throttle: Throttle,
    /// Whether the pitch stick climbs in LOITER.
    pub(super) climbs_in_loiter: bool,
    /// Whether a return climbs to its altitude before it turns.
    climbs_before_turn: bool,
    /// How far a return climbs before it turns otherwise, m.
    climb_min_m: f64,
    /// Greatest bank meanwhile, rad.
    climbing_bank_rad: f64,
}

/// What the throttle stick asks for in FBWB and CRUISE.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
enum Throttle {
    /// From the least to the greatest airspeed.
    #[default]
    Share,
    /// The same, with AIRSPEED_CRUISE, m/s, in the middle.
    CruiseInTheMiddle(f64),
    /// AIRSPEED_CRUISE, m/s, wherever it is.
    Cruise(f64),
}

impl Options {
    pub fn of(parameters: &Parameters) -> Self {
        let get = |parameter| f64::from(parameters.get(parameter));
        let bits = parameters.get(Parameter::FlightOptions) as u32;
        let has = |bit: u32| bits & bit != 0;
        let cruise_mps = get(Parameter::AirspeedCruise);
        Self {
            throttle: match (has(THROTTLE_CRUISES), has(CENTRED_THROTTLE_CRUISES)) {
                (true, _) => Throttle::Cruise(cruise_mps),
                (false, true) => Throttle::CruiseInTheMiddle(cruise_mps),
                (false, false) => Throttle::Share,
            },
            climbs_in_loiter: has(STICK_CLIMBS_IN_LOITER),
            climbs_before_turn: has(CLIMB_BEFORE_TURN),
            climb_min_m: get(Parameter::ReturnClimb),
            climbing_bank_rad: get(Parameter::LevelRollLimit).to_radians(),
        }
    }
}

/// The climb that a return begins with.
#[derive(Clone, Copy, Debug)]
pub(super) struct FirstClimb {
    /// It is over above this altitude, m above the origin.
    until_m: f64,
    /// What is asked for until then.
    demand_m: f64,
}

impl Flight {
    /// The airspeed that the throttle stick, 0 to 1, asks for, m/s.
    pub(super) fn speed_by_throttle_mps(&self, throttle: f64) -> f64 {
        let limits = self.dynamics.limits;
        let (least_mps, most_mps) = (limits.speed_min_mps, limits.speed_max_mps);
        match self.tuning.options.throttle {
            Throttle::Cruise(cruise_mps) if self.mode.holds_speed() => cruise_mps,
            Throttle::CruiseInTheMiddle(cruise_mps) if self.mode.holds_speed() => {
                let (from_mps, to_mps, share) = if throttle <= 0.5 {
                    (least_mps, cruise_mps, 2.0 * throttle)
                } else {
                    (cruise_mps, most_mps, 2.0 * throttle - 1.0)
                };
                from_mps + share * (to_mps - from_mps)
            }
            _ => least_mps + throttle * (most_mps - least_mps),
        }
    }

    /// The throttle stick sets the airspeed; without one a mode that is told to cruise does.
    pub(super) fn follow_throttle(&mut self) {
        let throttle = self.sticks.and_then(|sticks| sticks.throttle);
        let cruises = self.mode.holds_speed() && matches!(self.tuning.options.throttle, Throttle::Cruise(_));
        if let Some(throttle) = throttle.or(cruises.then_some(0.0)) {
            self.set_speed(self.speed_by_throttle_mps(throttle), f64::INFINITY);
        }
    }

    /// A return begins, with a climb if it is told so (`ModeRTL::update`): to its own altitude, or by so much.
    pub(super) fn climb_first(&mut self) {
        // Beyond what is wanted, so that it climbs at its full rate.
        const BEYOND_M: f64 = 10.0;
        let options = self.tuning.options;
        let (here_m, return_m) = (self.state.altitude_m, self.altitude.target);
        let until_m = if options.climbs_before_turn {
            return_m
        } else if options.climb_min_m > 0.0 {
            here_m + options.climb_min_m
        } else {
            return;
        };
        if here_m <= until_m {
            let demand_m = return_m.max(here_m) + options.climb_min_m + BEYOND_M;
            self.first_climb = Some(FirstClimb { until_m, demand_m });
            self.limit_lateral_acceleration(self.lateral_limit_mps2);
        }
    }

    /// A setpoint with the altitude of that climb, until it is over.
    pub(super) fn with_first_climb(&mut self, setpoint: Setpoint) -> Setpoint {
        let Some(climb) = self.first_climb else { return setpoint };
        if self.state.altitude_m > climb.until_m {
            self.end_first_climb();
            return setpoint;
        }
        Setpoint { altitude_m: climb.demand_m, ..setpoint }
    }

    pub(super) fn end_first_climb(&mut self) {
        if self.first_climb.take().is_some() {
            self.limit_lateral_acceleration(self.lateral_limit_mps2);
        }
    }

    /// The greatest horizontal acceleration of that climb, as a multiple of gravity; none while there is none.
    pub(super) fn first_climb_overload(&self) -> Option<f64> {
        self.first_climb.map(|_| libm::tan(self.tuning.options.climbing_bank_rad))
    }
}
