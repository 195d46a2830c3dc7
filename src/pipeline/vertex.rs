//! Stage 2: every position once from object space to clip space and the screen.

use super::viewport::ViewportTransform;
use crate::scene::CameraMatrices;
use glam::{DMat4, DVec3, DVec4};

/// One position on its way.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Vertex {
    /// Clip space.
    pub clip: DVec4,
    /// w - z of clip space, free of cancellation.
    pub complement: f64,
    /// View space z: negative in front of the eye.
    pub view_z: f64,
    /// Pixels, y down; not finite where w <= 0.
    pub screen: [f64; 2],
}

/// What takes a position there.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Transform {
    pub model: DMat4,
    pub camera: CameraMatrices,
    pub screen: ViewportTransform,
}

impl Transform {
    pub fn vertex(&self, position: DVec3) -> Vertex {
        let view = self.camera.view * (self.model * position.extend(1.0));
        let clip = self.camera.projection * view;
        Vertex {
            clip,
            complement: self.camera.one_minus_z_row.dot(view),
            view_z: view.z,
            screen: self.on_screen(clip),
        }
    }

    /// Pixels of a clip space point; not finite where it has none.
    pub fn on_screen(&self, clip: DVec4) -> [f64; 2] {
        if self.camera.is_parallel {
            // w is 1: there is nothing to divide by.
            self.screen.of_ndc([clip.x, clip.y])
        } else if clip.w > 0.0 {
            self.screen.of_ndc([clip.x / clip.w, clip.y / clip.w])
        } else {
            [f64::NAN; 2]
        }
    }

    pub fn world(&self, position: DVec3) -> DVec3 {
        (self.model * position.extend(1.0)).truncate()
    }
}
