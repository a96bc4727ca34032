//! The flocking law of Ruan and Duan (Eq. 4-12), its look-ahead, and the tick of a flock (Algorithm 2).
//!
//! Sans-I/O: [`Flock::tick`] takes the states of the vehicles and returns a setpoint for each. It knows no MAVLink, no
//! socket and no clock, and the same states, seed and tick give the same bits on any number of threads.
//!
//! [`Flock::tick`] has a short example. The example `1_own_loop` flies the paper's flock in a loop of one's own:
//! `cargo run --release -p controller --example 1_own_loop`.
//!
//! | equation | file |
//! |---|---|
//! | Eq. 2 | `command.rs` |
//! | Eq. 4 | `law.rs` |
//! | Eq. 5 | `terms/formation.rs` |
//! | Eq. 6 | `terms/collision_avoidance.rs` |
//! | Eq. 7 | `terms/obstacle_avoidance.rs` |
//! | Eq. 8 | `terms/velocity_consensus.rs` |
//! | Eq. 9 and 10 | `terms/vertical.rs` |
//! | Eq. 11, 12 and the constraints | `look_ahead/mod.rs`, `rollout.rs` |
//! | Algorithm 2 | `flock.rs`, `pilot.rs` |
//!
//! Eq. 1 and 3 are in the crate `flight_model`, Eq. 13 to 18 and Algorithm 1 in the crate `optimizer`.

mod closest_approach;
mod command;
mod decision;
mod evasion;
mod field;
mod flock;
mod forecast;
mod insight;
mod law;
mod look_ahead;
mod neighbours;
mod pilot;
mod polynomial;
mod present;
mod rollout;
mod settings;
pub mod terms;

pub use decision::{Decision, FlockError, FlockSettings};
pub use field::{Expected, Obstacle};
pub use flock::Flock;
pub use insight::{Insight, Member};
pub use present::{Estimate, Present};
pub use settings::{
    AltitudeLaw, ControllerSettings, CourseLaw, ForecastKind, LawSettings, LookAheadSettings, ObstacleRule, SideRule,
    WeightKind, WeightSettings,
};
