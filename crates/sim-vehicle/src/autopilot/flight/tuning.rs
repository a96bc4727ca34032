//! What parameters change of a flight.

use super::manual::BANK_MAX_RAD;
use super::options::Options;
use crate::parameters::Parameters;
use crate::parameters::table::Parameter;

/// What parameters change of the way it flies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Tuning {
    /// Radius of a circle, m; below zero it is flown anticlockwise.
    pub loiter_radius_m: f64,
    /// The same for the circle round home.
    pub rtl_radius_m: f64,
    /// Altitude of the way home, m above it; none: the present one, or the one that it climbs to by itself.
    pub rtl_altitude_m: Option<f64>,
    /// Altitude to which TAKEOFF climbs, m above home.
    pub takeoff_altitude_m: f64,
    /// Speed of LOITER and RTL, m/s; none: the present one.
    pub cruise_speed_mps: Option<f64>,
    /// Fastest climb and descent, m/s, beside the flight model's own.
    pub climb_max_mps: f64,
    /// The same downwards, above zero.
    pub sink_max_mps: f64,
    /// Greatest horizontal acceleration, as a multiple of gravity, beside the flight model's own.
    pub lateral_overload_max: f64,
    /// Greatest bank that a stick asks for, rad.
    pub stick_bank_max_rad: f64,
    pub options: Options,
}

impl Tuning {
    /// What the parameters make of the flight; what nobody has set stays as the settings have it, to the last bit.
    pub fn of(parameters: &Parameters, loiter_radius_m: f64) -> Self {
        let set = |parameter: Parameter| parameters.when_set(parameter);
        let loiter_radius_m = set(Parameter::LoiterRadius).unwrap_or(loiter_radius_m);
        Self {
            loiter_radius_m,
            rtl_radius_m: set(Parameter::RtlRadius).filter(|radius_m| *radius_m != 0.0).unwrap_or(loiter_radius_m),
            rtl_altitude_m: set(Parameter::RtlAltitude)
                .filter(|altitude_m| *altitude_m >= 0.0 && !parameters.rules().climbs_to_return),
            takeoff_altitude_m: f64::from(parameters.get(Parameter::TakeoffAltitude)),
            cruise_speed_mps: set(Parameter::AirspeedCruise).or(parameters.cruise_speed_mps()),
            climb_max_mps: set(Parameter::ClimbMax).unwrap_or(f64::INFINITY),
            sink_max_mps: set(Parameter::SinkMax).unwrap_or(f64::INFINITY),
            lateral_overload_max: set(Parameter::RollLimit)
                .map_or(f64::INFINITY, |limit_deg| libm::tan(limit_deg.to_radians())),
            stick_bank_max_rad: set(Parameter::RollLimit).map_or(BANK_MAX_RAD, f64::to_radians),
            options: Options::of(parameters),
        }
    }
}

/// A take-off is over when the vehicle is so near to its altitude, m.
pub(crate) const TAKEOFF_TOLERANCE_M: f64 = 2.0;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::VehicleSettings;

    #[test]
    fn nothing_set_tunes_nothing() {
        let settings = VehicleSettings { loiter_radius_m: 60.5, ..VehicleSettings::default() };
        let tuning = Tuning::of(&Parameters::new(&settings), settings.loiter_radius_m);
        assert_eq!((tuning.loiter_radius_m, tuning.rtl_radius_m), (60.5, 60.5));
        assert_eq!(
            (tuning.rtl_altitude_m, tuning.cruise_speed_mps, tuning.lateral_overload_max),
            (None, None, f64::INFINITY)
        );
    }
}
