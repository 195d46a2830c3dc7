//! The background over the viewport, painted before anything else of a scene.
//!
//! In: one colour, or a sky and its camera. Out: the bytes of every pixel of the viewport on the
//! frame; depth is unchanged. A pixel's colour is that of the ray through its centre: with M =
//! projection * view without its translation (the sky is infinitely far away) and p(z) = M^-1
//! (x_ndc, y_ndc, z, 1), the ray has the direction p(0.5) - p(0), each divided by its w. All rays
//! of a parallel projection run along the view axis. The executor's threads share the rows. Each
//! pixel is computed independently, so the bytes do not depend on the threads. A cancelled executor
//! leaves rows out.

use super::draw_call::Target;
use super::preemption::Preemption;
use super::viewport::ViewportTransform;
use crate::executor::Executor;
use crate::memory::{blend, opaque};
use crate::scene::{Camera, CameraMatrices, Sky, Viewport};
use glam::{DMat4, DVec3, DVec4};

/// Fills the viewport with one colour.
pub(super) fn paint(target: &mut Target, viewport: Viewport, color: DVec3) {
    let width = target.memory.width();
    let clip = ViewportTransform::on(viewport, target.memory).clip;
    if clip.is_empty() {
        return;
    }
    let pixels = target.memory.bytes_mut().as_chunks_mut::<4>().0;
    for y in clip.y0..clip.y1 {
        let row = width as usize * y as usize;
        pixels[row + clip.x0 as usize..row + clip.x1 as usize].fill(opaque(color));
    }
    target.memory.mark_rows(clip.y0 as u32..clip.y1 as u32);
}

/// Paints a sky over the viewport as the camera sees it; nothing if the camera makes no picture.
pub(super) fn paint_sky(
    target: &mut Target,
    viewport: Viewport,
    camera: &Camera,
    sky: &Sky,
    executor: &Executor,
    preemption: &Preemption,
) {
    let width = target.memory.width();
    let screen = ViewportTransform::on(viewport, target.memory);
    let clip = screen.clip;
    let aspect = f64::from(viewport.width.max(1)) / f64::from(viewport.height.max(1));
    let Ok(matrices) = camera.matrices(aspect) else { return };
    let rays = Rays::new(&matrices);
    if clip.is_empty() {
        return;
    }
    let width = width as usize;
    let paint_row = |y: i32, row: &mut [[u8; 4]]| {
        for x in clip.x0..clip.x1 {
            let color = sky.color(rays.at(screen.ndc_of_pixel(x, y)));
            let pixel = &mut row[x as usize];
            match sky.opacity >= 1.0 {
                true => *pixel = opaque(color),
                false => blend(pixel, color, sky.opacity),
            }
        }
    };
    let rows_at_once = match preemption.is_possible() {
        true => (PIXELS_AT_ONCE / width).max(1),
        false => (clip.y1 - clip.y0) as usize,
    };
    for first in (clip.y0..clip.y1).step_by(rows_at_once) {
        let end = clip.y1.min(first + rows_at_once as i32);
        let pixels = target.memory.bytes_mut().as_chunks_mut::<4>().0;
        let rows = &mut pixels[width * first as usize..width * end as usize];
        executor.run(|| executor.chunks(rows, width, |j, row| paint_row(first + j as i32, row)));
        target.memory.mark_rows(first as u32..end as u32);
        preemption.point(target);
    }
}

/// Pixels of a sky between two preemption points.
const PIXELS_AT_ONCE: usize = 1 << 16;

/// World-space directions of the rays through NDC points.
struct Rays {
    to_world: DMat4,
}

impl Rays {
    /// Creates the rays of a camera, without its translation.
    fn new(matrices: &CameraMatrices) -> Rays {
        let turn = DMat4 { w_axis: DVec4::W, ..matrices.view };
        Rays { to_world: (matrices.projection * turn).inverse() }
    }

    /// Returns the ray's direction at an NDC point, not normalized.
    fn at(&self, [x, y]: [f64; 2]) -> DVec3 {
        let [near, far] = [0.0, 0.5].map(|z| self.to_world * DVec4::new(x, y, z, 1.0));
        let along = far.truncate() * near.w - near.truncate() * far.w;
        if near.w * far.w < 0.0 { -along } else { along }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{LookAt, Projection};

    fn camera(projection: Projection) -> Camera {
        let look_at =
            LookAt { eye: DVec3::new(1e6, 2.0, 3.0), reference: DVec3::new(0.0, 2.0, 3.0), up: DVec3::Y };
        Camera { look_at, projection }
    }

    #[test]
    fn rays_run_through_the_pixels_whatever_the_place_of_the_eye() {
        let fov_rad = std::f64::consts::FRAC_PI_2;
        let perspective = Projection::Perspective { fov_rad, near: 0.1, far: 100.0, on_smaller_side: false };
        let rays = Rays::new(&camera(perspective).matrices(2.0).unwrap());
        // Looking along -x, right is -z. At 90 degrees over the height the upper edge is 45 degrees
        // up.
        for (ndc, expected) in [
            ([0.0, 0.0], DVec3::NEG_X),
            ([0.0, 1.0], DVec3::new(-1.0, 1.0, 0.0)),
            ([0.5, -1.0], DVec3::new(-1.0, -1.0, -1.0)),
        ] {
            let found = rays.at(ndc).normalize();
            assert!((found - expected.normalize()).length() < 1e-12, "{ndc:?}: {found}");
        }
        let window = [-1.0, 1.0, -1.0, 1.0];
        let ortho = Projection::Ortho { window, near: 0.1, far: 100.0 };
        let rays = Rays::new(&camera(ortho).matrices(1.0).unwrap());
        for ndc in [[0.0, 0.0], [0.9, -0.7]] {
            assert!((rays.at(ndc).normalize() - DVec3::NEG_X).length() < 1e-12);
        }
    }
}
