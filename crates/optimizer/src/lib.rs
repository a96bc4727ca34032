//! Multi-objective pigeon-inspired optimisation of problems that are evaluated a generation at a time.
//!
//! A [`Problem`] has any number of dimensions and objectives, and judges a whole generation in one call. An [`Optimizer`]
//! minimises it and returns the [`Front`] of candidates that none other dominates; [`selection`] picks one of them.
//! Everything is deterministic: the same problem, settings and [`Stream`] give the same bits on every platform.
//! After the first solve of a problem's size, nothing is allocated.

pub mod archive;
pub mod crowding;
pub mod dominance;
mod mslpio;
mod optimizer;
mod population;
mod problem;
pub mod selection;
mod stream;

pub use mslpio::{Mslpio, MslpioSettings, SettingsError};
pub use optimizer::{Front, FrontBuffer, OptimizeError, Optimizer};
pub use problem::{Bounds, Candidates, Evaluations, Problem};
pub use stream::{Stream, stream};
