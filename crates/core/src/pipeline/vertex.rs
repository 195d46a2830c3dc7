//! Stage 2: transforms each position once, from object space to clip space and the screen.
//!
//! In: object-space positions. Out: a [`Vertex`] with its clip-space position, screen position in
//! pixels and view depth. Nothing is clipped here: a vertex behind the eye has no screen position.

use super::viewport::ViewportTransform;
use crate::scene::CameraMatrices;
use glam::{DMat4, DVec3, DVec4};

/// A transformed vertex.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Vertex {
    /// Object-space position.
    pub position: DVec3,
    /// Clip-space position.
    pub clip: DVec4,
    /// w - z in clip space, computed without cancellation.
    pub complement: f64,
    /// View-space z, negative in front of the eye.
    pub view_z: f64,
    /// Screen position in pixels, y down; not finite where w <= 0.
    pub screen: [f64; 2],
}

/// Matrices and viewport that transform a position.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Transform {
    /// Object to world space.
    pub model: DMat4,
    /// World to view to clip space.
    pub camera: CameraMatrices,
    /// NDC to pixels.
    pub screen: ViewportTransform,
}

impl Transform {
    /// Transforms an object-space position to clip space and the screen.
    pub fn vertex(&self, position: DVec3) -> Vertex {
        let view = self.camera.view * (self.model * position.extend(1.0));
        let clip = self.camera.projection * view;
        Vertex {
            position,
            clip,
            complement: self.camera.one_minus_z_row.dot(view),
            view_z: view.z,
            screen: self.on_screen(clip),
        }
    }

    /// Returns the screen position of a clip-space point in pixels; NaN where w <= 0.
    pub fn on_screen(&self, clip: DVec4) -> [f64; 2] {
        if self.camera.is_parallel {
            // w is 1: no division is needed.
            self.screen.of_ndc([clip.x, clip.y])
        } else if clip.w > 0.0 {
            self.screen.of_ndc([clip.x / clip.w, clip.y / clip.w])
        } else {
            [f64::NAN; 2]
        }
    }

    /// Transforms an object-space position to world space.
    pub fn world(&self, position: DVec3) -> DVec3 {
        (self.model * position.extend(1.0)).truncate()
    }
}
