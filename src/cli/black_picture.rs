//! Pictures of `fbptr render` on which all that was drawn is black.
//!
//! In: a scene with lights, and its picture. Out: true if no light reaches what the camera sees.
//! Costs one pass over the black pixels before the first other one, and a second drawing where the
//! picture has no colour but black and that of its background.

use crate::measure::pixels;
use crate::memory::{DepthFormat, Rgba, VideoMemory};
use crate::pipeline::{Renderer, SceneOptions, Target, reflects_light};
use crate::scene::{Background, Scene};
use glam::DVec3;

/// A picture that shows something of its scene, which may be black.
pub(super) struct BlackPicture<'a> {
    pub scene: &'a Scene,
    pub options: &'a SceneOptions,
    pub memory: &'a VideoMemory,
    /// Colour of the frame before the scene was drawn.
    pub background: Rgba,
}

impl BlackPicture<'_> {
    /// Returns whether all that was drawn is black although it reflects light.
    pub fn is_unlit(&self, renderer: &mut Renderer) -> bool {
        // Beside a sky nothing black can be told from what was drawn: only what hides it all.
        let is_on_black = self.scene.sky.is_some()
            || match self.scene.background.color {
                Some(color) => color == DVec3::ZERO,
                None => self.background[..3] == [0; 3],
            };
        let other = if is_on_black { None } else { pixels::first_not_black(self.memory) };
        pixels::is_all_black(self.memory, other)
            && reflects_light(self.scene, self.options)
            && (other.is_none() || self.is_black_on_black(renderer))
    }

    /// Draws the scene again on a black frame, and returns whether that stays black.
    fn is_black_on_black(&self, renderer: &mut Renderer) -> bool {
        let Ok(mut memory) = VideoMemory::new(self.memory.width(), self.memory.height()) else {
            return false;
        };
        let scene = Scene { background: Background::default(), ..self.scene.clone() };
        let depth_format = DepthFormat::default();
        let mut target = Target { memory: &mut memory, depth: &mut None, depth_format, ids: None };
        renderer.draw_scene(&mut target, &scene, self.options).is_ok() && pixels::is_all_black(&memory, None)
    }
}
