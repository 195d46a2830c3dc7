//! Measurements of speed against error: experiments that compare alternatives for one stage.
//!
//! An [`Experiment`] is data: its description, its error columns, and a function that computes its
//! [`Row`]s. A row is one alternative on one subject; its errors come from the same output that was
//! timed, compared with a reference in f64 or wider, and are identical to the digit on every
//! machine. Times are taken only if [`Effort`] has a time budget, and a row outside its bounds
//! shows none. The report's writers are in [`mod@write`].
//!
//! ```text
//!   experiments() -> Experiment { columns, rows(&effort) } -> Report
//!       -> Markdown | JSON | one HTML page
//! ```
#![forbid(unsafe_code)]
#![deny(missing_docs)]
// `unwrap` is for tests: code says why a value cannot be missing.
#![cfg_attr(not(test), deny(clippy::unwrap_used))]

mod all_stages;
mod approximations;
pub mod bench;
mod bill;
mod clock;
mod coverage;
mod coverage_drawn;
pub mod decide;
mod depth;
pub mod difference;
mod experiment;
mod eye;
mod fibre_fan;
mod frame_times;
mod goals;
mod hard;
mod hidden_surfaces;
mod interpolation;
mod lines;
mod memory;
mod peers;
mod picture;
mod pictures;
pub mod pixels;
mod report;
mod scaling;
mod scaling_studies;
mod shading;
mod stages;
mod textures;
mod threads;
pub mod write;

pub use all_stages::all_stages;
pub use bill::{Bill, BillItem, bill};
pub use clock::Timing;
pub use experiment::{Bound, Check, Effort, Experiment, Picture, Row, Standing, Truth};
pub use frame_times::FrameTimes;
pub use goals::{Goal, eye_goals};
pub use hard::{HardRow, hard};
pub use peers::peers_of;
pub use picture::{Drawn, draw_case};
pub use pictures::speed_of;
pub use report::{Report, ScalingStudy, Section, experiments, run, scaling_studies};
pub use scaling::{Scaling, ScalingPoint};
pub use stages::{Saving, savings};
