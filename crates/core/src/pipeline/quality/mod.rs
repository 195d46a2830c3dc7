//! The error budget: cheaper settings that keep a picture within a given error.
//!
//! In: a scene or one draw, and E, the largest allowed 99.9th percentile of the colour error, in
//! 1/255 steps over the pixels that are drawn on. Out: a [`Choice`] for the scene, or
//! [`QualitySettings`] for the draw: the shading mode of every object, and its lights. Coverage and
//! depth are not changed. What is chosen is proven (`bounds`) from the angles between a mesh's
//! normals and from the lights, for any camera; nothing is drawn to find out. With a shift S above 0
//! also a level of detail (`levels`), for the camera of the draw (`detail`): then coverage and depth
//! may differ as far as points move.
//!
//! Exact settings are always a candidate, and win unless the calibration table (`costs`) says that
//! others are plainly cheaper. A mesh is measured once ([`MeshShapes`]), and only where that costs
//! at most two exact frames by the same table. Nothing reads a clock: a stream of commands gets the
//! same choices with every number of threads, vector width and machine.

mod bounds;
mod choice;
mod costs;
mod detail;
mod levels;
mod proof;
mod settings;
mod shapes;

pub use bounds::{MeshAngles, MeshBox};
pub use choice::Choice;
pub use detail::{Detail, WholeReason};
pub use levels::{Change, Level, build_bytes, make_levels};
pub use proof::prove;
#[doc(hidden)]
pub use proof::settings_of;
pub use settings::QualitySettings;
pub use shapes::MeshShapes;

use super::draw_call::{DrawCall, SceneOptions};
use crate::scene::{HiddenSurface, MaxError, Scene};

/// Input of a choice: the scene, how it is drawn, and the allowed error.
#[derive(Clone, Copy, Debug)]
pub struct Budget<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// Options of the exact drawing.
    pub options: &'a SceneOptions,
    /// The allowed error: E in 1/255 steps, and S in pixels.
    pub max_error: MaxError,
}

impl Budget<'_> {
    /// Returns why nothing but exact drawing is possible, if so.
    fn exact_reason(&self) -> Option<&'static str> {
        if self.scene.objects.is_empty() {
            return Some("there are no objects");
        }
        exact_reason(self.options.hide, self.max_error.steps)
    }
}

/// Returns why nothing but exact drawing is possible for any draw, if so.
fn exact_reason(hide: HiddenSurface, max_error: f64) -> Option<&'static str> {
    if max_error < 1.0 {
        return Some("under one step nothing but exact is sure");
    }
    (hide == HiddenSurface::Painter).then_some("the painter's algorithm is drawn exactly")
}

/// Steps by which a picture may differ from what its formulas say: 1, and 2 where it is textured.
fn steps_of_rounding(call: &DrawCall) -> f64 {
    let is_textured = call.texture.is_some()
        || call.geometry.textures.iter().any(Option::is_some)
        || call.stages.is_some()
        || call.maps.is_some();
    if is_textured { 2.0 } else { 1.0 }
}

#[cfg(test)]
mod tests;
