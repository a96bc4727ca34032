//! What parameters change of a flight.

/// What parameters change of the way it flies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Tuning {
    /// Radius of a circle, m; below zero it is flown anticlockwise.
    pub loiter_radius_m: f64,
    /// The same for the circle round home.
    pub rtl_radius_m: f64,
    /// Altitude of the way home, m above it; none: the present one.
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
}

/// ArduPlane's default of TKOFF_ALT, m.
pub(crate) const TAKEOFF_ALTITUDE_M: f64 = 50.0;
/// A take-off is over when the vehicle is so near to its altitude, m.
pub(crate) const TAKEOFF_TOLERANCE_M: f64 = 2.0;
