//! Sub-frames: one camera, moved by parts of a pixel.
//!
//! In: a camera, and a shift in pixels. Out: a camera whose picture is that of the first, moved by
//! the shift. The mean of the 16 sub-frames of [`SUBFRAMES`] is a picture of 4x4 samples a pixel.
//!
//! A shift of (dx, dy) pixels is one of s = (2 dx / width, -2 dy / height) in NDC. It moves the
//! window of a projection by -s times half its extents; projections without a window first become
//! the frustum or the box that they are.

use fbptr_core::scene::{Camera, Projection, contain};

/// Sample positions in pixels from the pixel's centre: a grid of 4x4, in an order in which every
/// first half is spread over the pixel (Bayer's matrix).
pub(in crate::viewer) const SUBFRAMES: [[f64; 2]; 16] = {
    const ORDER: [[usize; 2]; 16] = [
        [0, 0],
        [2, 2],
        [2, 0],
        [0, 2],
        [1, 1],
        [3, 3],
        [3, 1],
        [1, 3],
        [1, 0],
        [3, 2],
        [3, 0],
        [1, 2],
        [0, 1],
        [2, 3],
        [2, 1],
        [0, 3],
    ];
    const PLACES: [f64; 4] = [-0.375, -0.125, 0.125, 0.375];
    let mut all = [[0.0; 2]; 16];
    let mut i = 0;
    while i < 16 {
        all[i] = [PLACES[ORDER[i][0]], PLACES[ORDER[i][1]]];
        i += 1;
    }
    all
};

/// Returns `camera` with its picture moved by `by` pixels, right and down, on a frame of `size`.
pub(in crate::viewer) fn shifted(camera: Camera, by: [f64; 2], size: [u32; 2]) -> Camera {
    let [width, height] = size.map(f64::from);
    let s = [2.0 * by[0] / width, -2.0 * by[1] / height];
    let moved = |[l, r, b, t]: [f64; 4]| {
        let [x, y] = [s[0] * (r - l) / 2.0, s[1] * (t - b) / 2.0];
        [l - x, r - x, b - y, t - y]
    };
    let aspect = width / height;
    let projection = match camera.projection {
        Projection::Perspective { fov_rad, near, far, on_smaller_side } => {
            let side = near * libm::tan(fov_rad / 2.0);
            let [x, y] = match on_smaller_side && aspect < 1.0 {
                true => [side, side / aspect],
                false => [side * aspect, side],
            };
            Projection::Frustum { window: moved([-x, x, -y, y]), near, far }
        }
        Projection::Plane { d, near, far } => {
            let half = near / d;
            Projection::Frustum { window: moved([-half, half, -half, half]), near, far }
        }
        Projection::Frustum { window, near, far } => Projection::Frustum { window: moved(window), near, far },
        Projection::Ortho { window, near, far } => Projection::Ortho { window: moved(window), near, far },
        Projection::OrthoContain { window, near, far } => {
            Projection::Ortho { window: moved(contain(window, aspect)), near, far }
        }
        Projection::Oblique { kind, angle_rad, window, near, far } => {
            Projection::Oblique { kind, angle_rad, window: moved(window), near, far }
        }
        Projection::Isometric { window, near, far } => {
            Projection::Isometric { window: moved(window), near, far }
        }
        Projection::PseudoIsometric { window, near, far } => {
            Projection::PseudoIsometric { window: moved(window), near, far }
        }
        Projection::Window { vrp, p, vup, center, half, dp, near, far } => {
            let center = [center[0] - s[0] * half[0], center[1] - s[1] * half[1]];
            Projection::Window { vrp, p, vup, center, half, dp, near, far }
        }
    };
    Camera { projection, ..camera }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fbptr_core::scene::ObliqueKind;
    use glam::DVec3;

    #[test]
    fn every_projection_moves_by_the_shift() {
        let (window, near, far) = ([-1.5, 2.0, -1.0, 1.2], 0.5, 40.0);
        let projections = [
            Projection::Perspective { fov_rad: 0.9, near, far, on_smaller_side: false },
            Projection::Perspective { fov_rad: 0.9, near, far, on_smaller_side: true },
            Projection::Plane { d: 2.0, near, far },
            Projection::Frustum { window, near, far },
            Projection::Ortho { window, near, far },
            Projection::OrthoContain { window, near, far },
            Projection::Oblique { kind: ObliqueKind::Cabinet, angle_rad: 0.6, window, near, far },
            Projection::Isometric { window, near, far },
            Projection::PseudoIsometric { window, near, far },
            Projection::Window {
                vrp: DVec3::ZERO,
                p: DVec3::new(1.0, 2.0, 5.0),
                vup: DVec3::Y,
                center: [0.1, -0.2],
                half: [1.0, 0.8],
                dp: 4.0,
                near,
                far,
            },
        ];
        for size in [[320_u32, 200_u32], [90, 240]] {
            let aspect = f64::from(size[0]) / f64::from(size[1]);
            for projection in projections {
                let camera = Camera { projection, ..Camera::default() };
                let moved = shifted(camera, [0.375, -0.125], size);
                for p in [DVec3::new(0.3, 0.2, 0.1), DVec3::new(-1.0, 0.7, -2.0)] {
                    let place = |camera: &Camera| {
                        let m = camera.matrices(aspect).expect("a camera");
                        let clip = m.projection * (m.view * p.extend(1.0));
                        let ndc = clip / clip.w;
                        [ndc.x * f64::from(size[0]) / 2.0, -ndc.y * f64::from(size[1]) / 2.0, ndc.z]
                    };
                    let (a, b) = (place(&camera), place(&moved));
                    let off = [b[0] - a[0] - 0.375, b[1] - a[1] + 0.125, b[2] - a[2]];
                    assert!(off.iter().all(|d| d.abs() < 1e-9), "{projection:?} on {size:?}: {off:?}");
                }
            }
        }
    }

    #[test]
    fn the_samples_are_a_grid_of_four_by_four() {
        let mut places = SUBFRAMES.map(|p| p.map(|v| (v * 8.0) as i32));
        places.sort_unstable();
        let grid: Vec<[i32; 2]> =
            [-3, -1, 1, 3].iter().flat_map(|&x| [-3, -1, 1, 3].map(|y| [x, y])).collect();
        assert_eq!(places.to_vec(), grid);
        // The first four lie in the four quarters, so that a half-done mean is even.
        let quarters: std::collections::HashSet<_> =
            SUBFRAMES[..4].iter().map(|[x, y]| (*x > 0.0, *y > 0.0)).collect();
        assert_eq!(quarters.len(), 4);
    }
}
