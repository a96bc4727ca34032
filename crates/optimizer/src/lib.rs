//! Multi-objective pigeon-inspired optimisation of problems that are evaluated a generation at a time.
//!
//! [`Mslpio`] is the paper's optimiser; [`Mpio`] and [`Nsga2`] are the two that the paper compares it with, and
//! [`Slpio`] is its single-objective ancestor. By default each spends at most 651 evaluations. [`suites`] and
//! [`indicators`] measure how good they are.
//!
//! A [`Problem`] has any number of dimensions and objectives, and evaluates a whole generation in one call. An
//! [`Optimizer`] minimises it and returns the [`Front`] of candidates that no other candidate dominates; [`selection`]
//! picks one of them. Everything is deterministic: the same problem, settings and [`Stream`] give the same bits on
//! every platform. After the first solve of a problem's size, a solve allocates nothing.
//!
//! | equation | file |
//! |---|---|
//! | Eq. 13 | `factors.rs` |
//! | Eq. 14, 15 | `slpio.rs` |
//! | Eq. 16 | `dominance.rs` |
//! | Eq. 17 | `crowding.rs` |
//! | Eq. 18, Algorithm 1 | `mslpio.rs`, `pareto_flock.rs` |
//!
//! The example `1_own_problem` optimises a problem of one's own with every optimiser:
//! `cargo run --release -p optimizer --example 1_own_problem`. In short:
//!
//! ```
//! use optimizer::selection::nearest_to_ideal;
//! use optimizer::{Bounds, Candidates, Evaluations, Mslpio, MslpioSettings, Optimizer, Problem, stream};
//!
//! /// As near to 1 and as near to 2 as possible, but not below 1.2.
//! struct BetweenOneAndTwo([Bounds; 1]);
//!
//! impl Problem for BetweenOneAndTwo {
//!     fn bounds(&self) -> &[Bounds] {
//!         &self.0
//!     }
//!     fn objectives(&self) -> usize {
//!         2
//!     }
//!     fn evaluate(&mut self, candidates: &Candidates<'_>, evaluations: &mut Evaluations<'_>) {
//!         let ([to_one, to_two], violation) = evaluations.objectives_and_violation();
//!         for (i, x) in candidates.coordinate(0).iter().enumerate() {
//!             to_one[i] = (x - 1.0) * (x - 1.0);
//!             to_two[i] = (x - 2.0) * (x - 2.0);
//!             violation[i] = (1.2 - x).max(0.0);
//!         }
//!     }
//! }
//!
//! let mut mslpio = Mslpio::new(MslpioSettings::default())?;
//! let mut problem = BetweenOneAndTwo([Bounds::new(0.0, 3.0)]);
//! let front = mslpio.minimise(&mut problem, &mut stream(1, 0, 0))?;
//! let chosen = front.position(nearest_to_ideal(&front), 0);
//! assert!((1.5..1.7).contains(&chosen));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod algorithm;
pub mod archive;
pub mod crowding;
pub mod dominance;
mod factors;
pub mod indicators;
mod mpio;
mod mslpio;
mod nsga2;
mod optimizer;
mod pareto_flock;
mod population;
mod problem;
mod random;
pub mod selection;
mod settings;
mod slpio;
mod stream;
pub mod suites;
mod sum;
mod variation;

pub use algorithm::{Algorithm, OptimizerSettings};
pub use mpio::{Mpio, MpioSettings};
pub use mslpio::{Mslpio, MslpioSettings};
pub use nsga2::{Nsga2, Nsga2Settings};
pub use optimizer::{Front, FrontBuffer, OptimizeError, Optimizer, SettingsError};
pub use problem::{Bounds, Candidates, Evaluations, Problem};
pub use random::{Random, RandomSettings};
pub use slpio::{Slpio, SlpioSettings};
pub use stream::{Stream, stream};
