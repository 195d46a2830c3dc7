//! SPEED AGAINST ERROR: experiments, each a set of alternatives for one stage, measured together.
//!
//! An [`Experiment`] is data: what it asks, which error columns it has, and a function that makes its [`Row`]s. Every row
//! is one alternative on one subject; its errors come from the very output that was timed, held to a truth in f64 or wider, and
//! are the same to the digit on every machine. Times are taken only where [`Effort`] carries a clock, and a row outside its
//! stated bound shows none. The report's writers are in [`mod@write`].
//!
//! ```text
//!   experiments() -> Experiment { columns, rows(&effort) } -> Report -> Markdown | JSON | one HTML page
//! ```

mod approximations;
pub mod bench;
mod clock;
mod coverage;
mod depth;
mod experiment;
mod eye;
mod fibre_fan;
mod goals;
mod hard;
mod hidden_surfaces;
mod interpolation;
mod lines;
mod memory;
mod picture;
mod report;
mod scaling;
mod scaling_studies;
mod shading;
mod textures;
mod threads;
pub mod write;

pub use clock::Timing;
pub use experiment::{Bound, Effort, Experiment, Picture, Row};
pub use goals::{Goal, eye_goals};
pub use hard::{HardRow, hard};
pub use picture::{Drawn, draw_case};
pub use report::{Report, ScalingStudy, Section, experiments, run, scaling_studies};
pub use scaling::{Scaling, ScalingPoint};
