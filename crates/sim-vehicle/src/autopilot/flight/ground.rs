//! What bears the vehicle, and what happens between it and the ground.

/// What bears the vehicle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Contact {
    /// The launch rail, where it starts: in the air, motionless.
    Rail,
    Ground,
    Air,
}

/// The vehicle has come down onto the ground. At a greater rate than it bears it has stopped there, disarmed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct TouchDown {
    /// Rate of descent at which it hit the ground, m/s.
    pub sink_mps: f64,
}

/// Acceleration of the run before a take-off, m/s2.
pub(super) const RUN_MPS2: f64 = 3.0;
/// Deceleration of a vehicle that rolls without its engine, m/s2.
pub(super) const BRAKE_MPS2: f64 = 2.0;
/// Greatest rate of descent that a touch-down bears, m/s.
pub(super) const SINK_BORNE_MPS: f64 = 3.0;
