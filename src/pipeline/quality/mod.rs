//! The error budget: cheaper settings that keep a picture within a given error.
//!
//! In: a scene, and E, the largest allowed 99.9th percentile of the colour error, in 1/255 steps
//! over the pixels that are drawn on. Out: a [`Choice`]: for every object its shading mode, texture
//! filter and lights. Coverage and depth are not changed. There are two grounds for a choice:
//!
//! ```text
//! proof   prove    bounds from a mesh's normals and the lights, for any camera; draws nothing
//! trial   try_out  the exact picture and one cheaper picture of the same state, compared at every
//!                  pixel; for that state alone, after TRY_AFTER draws of it
//! ```
//!
//! Exact settings are always a candidate, and win unless the calibration table (`costs`) says that
//! others are plainly cheaper. Nothing reads a clock: a stream of commands gets the same choices with
//! every number of threads, vector width and machine.

mod bounds;
mod cache;
mod choice;
mod costs;
mod proof;
mod settings;
mod trial;

pub use bounds::MeshShape;
pub use cache::{ChoiceCache, MOST_FACES, Search, TRY_AFTER};
pub use choice::{Choice, Trial};
pub use proof::prove;
pub use settings::QualitySettings;
pub use trial::{trial_bytes, try_out};

use super::draw_call::SceneOptions;
use crate::memory::DepthFormat;
use crate::scene::{HiddenSurface, Object, Scene};

/// Input of a choice: the scene, how it is drawn, and the allowed error.
#[derive(Clone, Copy, Debug)]
pub struct Budget<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// Options of the exact drawing.
    pub options: &'a SceneOptions,
    /// A scene, or single draws with transparent faces among the others.
    pub kind: BudgetKind,
    /// Format of the depth memory.
    pub depth_format: DepthFormat,
    /// Width of the frame in pixels.
    pub width: u32,
    /// Height of the frame in pixels.
    pub height: u32,
    /// E, the allowed error in 1/255 steps.
    pub max_error: f64,
}

/// The kind of drawing that a budget is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum BudgetKind {
    /// A scene: transparent faces after the opaque ones.
    #[default]
    Scene,
    /// Single draws, one per object, in order.
    Draws,
}

impl Budget<'_> {
    /// Returns why nothing but exact drawing is possible, if so.
    fn exact_reason(&self) -> Option<&'static str> {
        if self.max_error < 1.0 {
            return Some("under one step nothing but exact is sure");
        }
        if self.scene.objects.is_empty() {
            return Some("there are no objects");
        }
        (self.options.hide == HiddenSurface::Painter).then_some("the painter's algorithm is drawn exactly")
    }
}

/// Steps by which a picture may differ from what its formulas say: 1, and 2 where it is textured.
fn steps_of_rounding(object: &Object) -> f64 {
    let is_textured = object.texture.is_some()
        || object.geometry.textures.iter().any(Option::is_some)
        || object.style.stages.is_some();
    if is_textured { 2.0 } else { 1.0 }
}

#[cfg(test)]
mod tests;
