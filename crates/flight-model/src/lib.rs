//! The vehicle of Ruan and Duan's paper: a UAV behind Mach-, course- and altitude-hold autopilots (Eq. 1-3), and the
//! local frame it flies in.
//!
//! Everything here is a pure function of its arguments and uses [`libm`] for transcendental functions, so that a flight
//! has the same bits on every platform.
//!
//! ```
//! use flight_model::{Autopilot, Dynamics, Setpoint, State};
//!
//! let autopilot = Autopilot::new(&Dynamics::default(), 0.01);
//! let mut state = State { altitude_m: 50.0, speed_mps: 9.0, ..State::default() };
//! let setpoint = Setpoint { speed_mps: 10.0, course_rad: 0.1, altitude_m: 50.0 };
//! for _ in 0..1000 {
//!     state = autopilot.step(&state, &setpoint);
//! }
//! assert!((state.speed_mps - 10.0).abs() < 1e-3);
//! ```

mod airframe;
mod angle;
mod atmosphere;
mod autopilot;
mod dynamics;
mod frame;
mod gusts;
mod plant;
mod range;
mod state;
mod wind;

pub use airframe::Airframe;
pub use angle::wrap_pi;
pub use atmosphere::{
    air_density_kgpm3, air_pressure_pa, air_temperature_k, mach, speed_of_sound_mps, true_airspeed_ratio,
};
pub use autopilot::Autopilot;
pub use dynamics::{Dynamics, Limits, Response, TimeConstants};
pub use frame::{Geodetic, LocalFrame};
pub use gusts::Gusts;
pub use plant::{
    AltitudeLoopSettings, CourseLoopSettings, Delay, PitchSettings, Plant, PlantSettings, SetpointDelay,
    SpeedLoopSettings,
};
pub use range::{Range, RangeError, Ranges};
pub use state::{Setpoint, State, course_vector};
pub use wind::Wind;
