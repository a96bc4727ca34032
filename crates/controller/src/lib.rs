//! The flocking law of Ruan and Duan (Eq. 4-12), its look-ahead, and the tick of a flock (Algorithm 2).
//!
//! Sans-I/O: [`Flock::tick`] takes the states of the vehicles and gives a setpoint for each. It knows no MAVLink, no
//! socket and no clock, and the same states, seed and tick give the same bits on any number of threads.
//!
//! | equation | file |
//! |---|---|
//! | 2 | `command.rs` |
//! | 4 | `law.rs` |
//! | 5, 6, 8, 9, 10 | `terms.rs` |
//! | 7 | `steering.rs`, `terms.rs` |
//! | 11, 12 and the constraints | `look_ahead.rs` |
//! | Algorithm 2 | `flock.rs` |

mod closest_approach;
mod command;
mod decision;
mod evasion;
mod field;
mod flights;
mod flock;
mod forecast;
mod law;
mod look_ahead;
mod neighbours;
mod pilot;
mod polynomial;
mod settings;
pub mod steering;
pub mod terms;

pub use decision::{Decision, FlockSettings};
pub use field::{Expected, Obstacle};
pub use flock::Flock;
pub use settings::{
    AltitudeLaw, ControllerSettings, ForecastKind, LawSettings, LookAheadSettings, ObstacleRule, WeightKind,
    WeightSettings,
};
