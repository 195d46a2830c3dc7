//! The 3-D pipeline: object space to bytes in numbered stages, in f64 - the plain path that is the project's exact answer.

mod call;

pub use call::{DepthUse, DrawCall, DrawStats, PipelineError, SceneOptions, Target};
