//! The studio: how a model stands in the window of the viewer. A camera at three quarters, three
//! lights, a quiet gradient behind, and a grid under the model with a soft contact shadow.
//!
//! In: a mesh, or a scene whose author left these things out. Out: cameras and lights in world
//! space, and the pixels that the model is drawn over.
//!
//! Promises: the larger side of the drawn model's box is 80 % of the frame's; every pixel
//! depends on its own position alone, so the bytes are the same for any number of threads. A
//! picture without the studio is the one that `fbptr render` makes.

mod contact_shadow;
mod framing;
mod ground;
mod jitter;

#[cfg(test)]
pub(super) use framing::FILL;
pub(super) use framing::{framed_mesh, framed_scene, world_mesh};
pub(super) use ground::Ground;
pub(super) use jitter::{SUBFRAMES, shifted};

use fbptr_core::draw2d::look::PAPER;
use fbptr_core::memory::{Rgba, VideoMemory};
use fbptr_core::scene::{Camera, Light, Material, Object, PointShape, Scene};
use glam::DVec3;

/// Colour of the gradient at the top of the frame: the paper of docs/look.md.
const TOP: [f64; 3] = [PAPER[0] as f64, PAPER[1] as f64, PAPER[2] as f64];
/// Colour of the gradient at the bottom.
const BOTTOM: [f64; 3] = [46.0, 58.0, 82.0];

/// Returns the three lights of the studio, which follow the camera: a warm key from the upper left,
/// a cool fill from the right, and a rim from behind.
pub(super) fn lights(camera: &Camera) -> Vec<Light> {
    let (eye, reference) = (camera.look_at.eye, camera.look_at.reference);
    let ahead = (reference - eye).normalize_or(DVec3::NEG_Z);
    let right = ahead.cross(camera.look_at.up).normalize_or(DVec3::X);
    let up = right.cross(ahead);
    let light = |along: [f64; 3], color: [f64; 3]| {
        Light::directional(right * along[0] + up * along[1] + ahead * along[2], DVec3::from(color))
    };
    vec![
        light([0.7, -0.75, 1.0], [0.92, 0.88, 0.80]),
        light([-1.0, -0.1, 0.7], [0.16, 0.22, 0.34]),
        light([-0.35, -0.7, -0.9], [0.42, 0.48, 0.60]),
    ]
}

/// Lights a scene of one mesh, whose file has no lights: those of the studio about `camera`.
pub(super) fn light(scene: &mut Scene, camera: &Camera) {
    scene.lights = lights(camera);
    scene.ambient = DVec3::splat(0.13);
}

/// Sides in pixels between which the studio's points are.
const POINT_SIDES: [f64; 2] = [2.0, 6.0];

/// Enlarges points of one pixel, so that a cloud is seen as a surface: discs that would cover a
/// sixth of a frame of `size` between them, of 2 to 6 pixels at the middle of the scene, larger before
/// it and smaller behind. Points that have a size keep it.
pub(super) fn enlarge_points(scene: &mut Scene, size: [u32; 2]) {
    let is_dot = |object: &Object| object.style.point_size <= 1 && !object.geometry.mesh.points.is_empty();
    let count: usize = scene.objects.iter().filter(|o| is_dot(o)).map(|o| o.geometry.mesh.points.len()).sum();
    let area = f64::from(size[0]) * f64::from(size[1]) / 6.0;
    let [least, most] = POINT_SIDES;
    let side = (area / count.max(1) as f64).sqrt().round().clamp(least, most) as u32;
    let (Some(camera), Some((low, high))) = (scene.camera, scene.bounds()) else { return };
    let Ok(matrices) = camera.matrices(f64::from(size[0]) / f64::from(size[1])) else { return };
    let middle = matrices.projection * matrices.view * ((low + high) / 2.0).extend(1.0);
    // An eye inside a cloud sees its middle nowhere near.
    let at_w = if middle.w > matrices.w_near { middle.w } else { low.distance(high) / 2.0 };
    for object in scene.objects.iter_mut().filter(|o| is_dot(o)) {
        object.style.point_size = side;
        object.style.point_shape = PointShape::Disc { at_w };
    }
}

/// Returns the material of a mesh that has none: ivory with a faint shine.
pub(super) fn material() -> Material {
    Material {
        ka: DVec3::splat(0.8),
        kd: DVec3::new(0.86, 0.80, 0.71),
        ks: DVec3::splat(0.2),
        n: 36.0,
        ..Material::default()
    }
}

/// The gradient behind a model, kept for frames of one size.
#[derive(Default)]
pub(super) struct Backdrop {
    size: [u32; 2],
    bytes: Vec<u8>,
}

impl Backdrop {
    /// Fills the frame with the gradient.
    pub fn paint(&mut self, memory: &mut VideoMemory) {
        let size = [memory.width(), memory.height()];
        if self.size != size {
            self.size = size;
            self.bytes = (0..size[1])
                .flat_map(|y| (0..size[0]).map(move |x| (x, y)))
                .flat_map(|(x, y)| gradient(x, y, size[1]))
                .collect();
        }
        memory.bytes_mut().copy_from_slice(&self.bytes);
    }
}

/// Returns the gradient's colour at a pixel. Steps between two bytes are dithered by Bayer's 4x4
/// matrix, so that no bands are seen.
fn gradient(x: u32, y: u32, height: u32) -> Rgba {
    const BAYER: [[u8; 4]; 4] = [[0, 8, 2, 10], [12, 4, 14, 6], [3, 11, 1, 9], [15, 7, 13, 5]];
    let part = (f64::from(y) + 0.5) / f64::from(height);
    let threshold = (f64::from(BAYER[y as usize % 4][x as usize % 4]) + 0.5) / 16.0;
    let channel = |i: usize| (TOP[i] + (BOTTOM[i] - TOP[i]) * part * part + threshold) as u8;
    [channel(0), channel(1), channel(2), 255]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_gradient_goes_from_top_to_bottom_without_a_band() {
        let mut memory = VideoMemory::new(8, 256).expect("small");
        Backdrop::default().paint(&mut memory);
        let mean = |y: u32| {
            let rows = memory.bytes()[(y * 32) as usize..][..4 * 32].as_chunks::<4>().0;
            rows.iter().map(|p| f64::from(p[2])).sum::<f64>() / 32.0
        };
        assert!((mean(0) - TOP[2]).abs() < 0.6 && (mean(252) - BOTTOM[2]).abs() < 1.5);
        for y in (0..248).step_by(4) {
            let part = f64::from(y + 2) / 256.0;
            let exact = TOP[2] + (BOTTOM[2] - TOP[2]) * part * part;
            assert!((mean(y) - exact).abs() < 0.4, "{y}: {} for {exact}", mean(y));
        }
    }

    #[test]
    fn the_lights_follow_the_camera_and_shine_from_three_sides() {
        let camera = Camera::default();
        let from: Vec<DVec3> = lights(&camera)
            .iter()
            .map(|light| match light.kind {
                fbptr_core::scene::LightKind::Directional { direction } => -direction,
                _ => panic!("a directional light"),
            })
            .collect();
        // The default camera looks along -z with y up.
        assert!(from[0].x < 0.0 && from[0].y > 0.0 && from[0].z > 0.0, "key from the upper left");
        assert!(from[1].x > 0.0 && from[1].z > 0.0, "fill from the right");
        assert!(from[2].z < 0.0 && from[2].y > 0.0, "rim from behind");
    }
}
