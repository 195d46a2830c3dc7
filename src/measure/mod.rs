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

pub mod bench;
mod clock;
mod coverage;
mod depth;
mod experiment;
mod eye;
mod fan;
mod growing;
mod growth;
mod hard;
mod hidden;
mod interpolation;
mod lines;
mod memory;
mod picture;
mod report;
mod rsqrt;
mod shading;
mod target;
mod textures;
mod threads;
pub mod write;

pub use clock::Timing;
pub use experiment::{Bound, Effort, Experiment, Picture, Row};
pub use growth::{Growth, GrowthPoint};
pub use hard::{HardRow, hard};
pub use picture::{Drawn, draw_case};
pub use report::{GrowthStudy, Report, Section, experiments, growth_studies, run};
pub use target::{Target, eye_targets};
