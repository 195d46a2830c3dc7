//! The N-dimensional eye: scenes of R^N on screens of M dimensions.
// Indices are axes and vertices here, named as in the formulas.
#![allow(clippy::needless_range_loop)]

mod blit;
mod bounds;
mod bvh;
mod error;
mod eye_space;
mod fibre;
mod frame;
mod frame_light;
mod json;
mod lights;
mod method;
mod occluder;
mod picture;
mod plan;
mod pose;
mod render;
mod scene;
pub mod shapes;
#[cfg(test)]
mod test_scenes;
mod tile;
mod validate;

pub use blit::{ContactSheet, blit, contact_sheet, nearest};
pub use error::EyeError;
pub use json::json_bytes;
pub use method::{Fibre, MAX_FAN_RAYS};
pub use picture::{Differences, EyePicture, MISS};
pub use plan::{EyePlan, ObstaclePlan};
pub use pose::{Pose, Rotation, sin_cos_deg};
pub use render::{plan, render, render_with};
pub use scene::{
    EyeLight, EyeLightKind, EyeScene, Facet, Falloff, MAX_DIM, MAX_FLAGS, MAX_PIXELS, SceneParts,
};
