//! Clusters: sixteen consecutive faces, culled as one if none of them can be visible.
//!
//! In: the bounds of a mesh's clusters ([`Clusters`]), a draw's matrices and its clip rectangle. Out:
//! the visibility of each cluster, which is culled only if [`super::setup`] would cull every one of
//! its faces:
//!
//! - outside: the sphere lies beyond one side of the clip rectangle by more than a pixel, before
//!   near, beyond far or behind the eye;
//! - culled: the sphere lies inside the view volume and every face is turned away by more than
//!   snapping could turn it back.
//!
//! With (X, Y, W) = Q p + q the clip coordinates and G(p) = det(Q) p + G0 their cofactors, a face
//! with doubled normal N has on the screen the doubled area hx hy N.G(p0) / (W0 W1 W2), in every
//! projection. A corner snaps by at most 1/512 pixel in each axis, so the doubled area of a face no
//! longer than L changes by at most 4 L / 256 + 2 / 256^2.
//!
//! Verified by `tests`, which compare every face of a culled cluster with the set-up of single faces.

use super::bins::Winding;
use super::vertex::{ROUNDINGS, ToScreen, WIDTH};
use crate::math::coverage::PixelRect;
use crate::pipeline::indexed_mesh::Clusters;
use crate::simd::{Kernel, Simd};
use glam::{DMat4, DVec4};
use std::sync::atomic::{AtomicU8, Ordering::Relaxed};

/// Values for the visibility of a cluster, as culling decides it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Visibility;

impl Visibility {
    /// Its faces are tested one by one.
    pub const OPEN: u8 = 0;
    /// All of its faces are culled.
    pub const CULLED: u8 = 1;
    /// All of its faces are outside.
    pub const OUTSIDE: u8 = 2;
}

/// View volume and cofactors of a draw in object space, for culling clusters.
#[derive(Clone, Copy, Debug)]
pub struct CullView {
    /// Planes with unit normals and their distances: inside is >= 0. Left, right, top, bottom,
    /// near, far.
    planes: [[f64; 4]; 6],
    /// The first four planes, moved outwards by more than a pixel.
    beyond: [[f64; 4]; 4],
    /// W as a row, and the length of its gradient.
    w: [f64; 4],
    w_slope: f64,
    /// det(Q) and G0, with the sign that gives culled faces positive areas.
    spread: f64,
    cofactor: [f64; 3],
    /// Pixels^2 of a doubled area of 1 at W = 1; with 0 no face is culled.
    area_scale: f64,
    /// Bound on the pixels that an edge of length 1 covers at W = 1.
    edge_scale: f64,
    /// Magnitude of the numbers in planes and cofactors: rounding errors are relative to it.
    reach: f64,
    /// Distance in object space by which the plain path's rounding moves a point relative to a
    /// plane or the eye.
    object_error: f64,
    /// Pixels by which rounding moves a corner on the screen, at W = 1.
    screen_error: f64,
}

impl CullView {
    /// Prepares the culling of a draw of positions whose coordinates are at most `farthest` in
    /// size; `complement` is w - z as a row over view space.
    pub fn new(
        t: &ToScreen,
        to_view: &DMat4,
        farthest: [f64; 3],
        complement: [f64; 4],
        view: &PixelRect,
        winding: Winding,
    ) -> Self {
        let back = to_view.transpose();
        let clip = [t.projection[0], t.projection[1], t.projection[2], complement, t.projection[3]];
        let [x, y, z, rest, w] = clip.map(|row| back * DVec4::from_array(row));
        let ([hx, hy], [cx, cy]) = (t.half, t.center);
        let sides = |margin: f64| {
            let [x0, y0] = [view.x0 as f64 - margin, view.y0 as f64 - margin];
            let [x1, y1] = [view.x1 as f64 + margin, view.y1 as f64 + margin];
            [x * hx + w * (cx - x0), w * (x1 - cx) - x * hx, y * hy + w * (cy - y0), w * (y1 - cy) - y * hy]
        };
        let [left, right, top, bottom] = sides(0.0);
        let planes = [left, right, top, bottom, z, rest].map(plane);
        // Sums of absolute terms for each of the planes, and for w: rounding errors remain where
        // they cancel.
        let far = t.sizes_in_view(farthest);
        let [far_x, far_y, far_z, far_rest, far_w] = clip.map(|row| DVec4::from_array(row).abs().dot(far));
        let sums = [0, 1].map(|axis| {
            let [low, high] = t.sides[axis].map(f64::abs);
            let span = t.center[axis].abs() + low.max(high);
            t.half[axis].abs() * [far_x, far_y][axis] + span * far_w
        });
        let object_error = [(left, sums[0]), (right, sums[0]), (top, sums[1]), (bottom, sums[1])]
            .into_iter()
            .chain([(z, far_z), (rest, far_rest), (w, far_w)])
            .map(|(row, sum)| (row.truncate().length(), sum))
            .filter(|(slope, _)| *slope > 0.0)
            .map(|(slope, sum)| if sum.is_finite() { ROUNDINGS * sum / slope } else { f64::INFINITY })
            .fold(0.0, f64::max);
        let [gx, gy, gw] = [x, y, w].map(|row| row.truncate());
        let turn = match winding {
            Winding::CounterClockwise => (hx * hy).signum(),
            Winding::Clockwise => -(hx * hy).signum(),
            Winding::Both => 0.0,
        };
        let spread = gx.cross(gy).dot(gw) * turn;
        let cofactor = (gy.cross(gw) * x.w + gw.cross(gx) * y.w + gx.cross(gy) * w.w) * turn;
        let across = (view.x0 as f64 - cx).abs().max((view.x1 as f64 - cx).abs());
        let down = (view.y0 as f64 - cy).abs().max((view.y1 as f64 - cy).abs());
        let slope = gw.length();
        let offsets =
            planes.iter().map(|p| p[3].abs()).chain([cofactor.length() / spread.abs(), w.w.abs() / slope]);
        CullView {
            planes,
            beyond: sides(1.01).map(plane),
            w: w.to_array(),
            w_slope: slope,
            spread,
            cofactor: cofactor.to_array(),
            area_scale: (hx * hy * turn).abs(),
            edge_scale: (hx.abs() * gx.length() + across * slope).max(hy.abs() * gy.length() + down * slope),
            reach: offsets.filter(|o| o.is_finite()).fold(0.0, f64::max),
            object_error,
            screen_error: ROUNDINGS * sums[0].max(sums[1]),
        }
    }
}

/// Returns a row as a plane with a unit normal; a row without gradient is infinitely far, on one
/// side or the other.
fn plane(row: DVec4) -> [f64; 4] {
    match row.truncate().length() {
        0.0 => [0.0, 0.0, 0.0, row.w.signum() * f64::INFINITY],
        length => (row / length).to_array(),
    }
}

/// Decides the visibility of a run of clusters.
pub struct ClusterKernel<'a> {
    /// Clusters of the mesh.
    pub clusters: &'a Clusters,
    /// Index of the run's first cluster; a multiple of [`WIDTH`].
    pub first: usize,
    /// View volume of the draw.
    pub cull_view: &'a CullView,
    /// Output: the [`Visibility`] of each cluster of the run.
    pub visibilities: &'a mut [u8],
    /// Output: one byte for each block of vertices, set to 1 if an open cluster uses it. Empty if
    /// all are transformed anyway.
    pub marks: &'a [AtomicU8],
}

type Lanes = [f64; WIDTH];

impl Kernel for ClusterKernel<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, _: S) {
        let c = self.clusters;
        let [s, n] = [&c.spheres, &c.cones];
        for (i, visibilities) in self.visibilities.chunks_mut(WIDTH).enumerate() {
            let at = self.first + i * WIDTH;
            let lists = [
                lanes(&s[0], at),
                lanes(&s[1], at),
                lanes(&s[2], at),
                lanes(&s[3], at),
                lanes(&n[0], at),
                lanes(&n[1], at),
                lanes(&n[2], at),
                lanes(&n[3], at),
                lanes(&c.least_areas, at),
                lanes(&c.longest_edges, at),
            ];
            let decided = decide(self.cull_view, &lists);
            visibilities.copy_from_slice(&decided[..visibilities.len()]);
            if self.marks.is_empty() {
                continue;
            }
            for (k, _) in visibilities.iter().enumerate().filter(|(_, f)| **f == Visibility::OPEN) {
                for &block in c.blocks_of(at + k) {
                    self.marks[block as usize].store(1, Relaxed);
                }
            }
        }
    }
}

/// Loads a vector of a list from `at` on.
#[allow(clippy::needless_range_loop, reason = "lanes of several arrays go together")]
#[inline(always)]
fn lanes(list: &[f32], at: usize) -> Lanes {
    let (from, mut to) = (&list[at..at + WIDTH], [0.0; WIDTH]);
    for i in 0..WIDTH {
        to[i] = from[i] as f64;
    }
    to
}

/// Returns the visibilities of clusters, given their spheres, cones, areas and edges, a list each.
#[allow(clippy::needless_range_loop, reason = "lanes of several arrays go together")]
#[inline(always)]
fn decide(o: &CullView, [x, y, z, radius, ax, ay, az, cosine, area, edge]: &[Lanes; 10]) -> [u8; WIDTH] {
    let mut visibilities = [Visibility::OPEN; WIDTH];
    for i in 0..WIDTH {
        // Rounding errors are far below this margin.
        let far = (x[i].abs() + y[i].abs()) + z[i].abs();
        let r = (radius[i] + 1e-12 * (far + o.reach)) + o.object_error;
        let (mut inside, mut outside) = (true, false);
        for p in &o.planes {
            inside &= ((p[0] * x[i] + p[1] * y[i]) + p[2] * z[i]) + p[3] >= r;
        }
        for p in [&o.beyond[0], &o.beyond[1], &o.beyond[2], &o.beyond[3], &o.planes[4], &o.planes[5]] {
            outside |= ((p[0] * x[i] + p[1] * y[i]) + p[2] * z[i]) + p[3] < -r;
        }
        let w = ((o.w[0] * x[i] + o.w[1] * y[i]) + o.w[2] * z[i]) + o.w[3];
        let (w_min, w_max) = (w - o.w_slope * r, w + o.w_slope * r);
        let is_before = w_min > 1e-9 * w_max;
        let g = [
            o.cofactor[0] + o.spread * x[i],
            o.cofactor[1] + o.spread * y[i],
            o.cofactor[2] + o.spread * z[i],
        ];
        let along = (ax[i] * g[0] + ay[i] * g[1]) + az[i] * g[2];
        let length2 = (g[0] * g[0] + g[1] * g[1]) + g[2] * g[2];
        let aside = (length2 - along * along).max(0.0).sqrt();
        let sine = (1.0 - cosine[i] * cosine[i]).max(0.0).sqrt();
        // Lower bound on N.G(p) for a unit N of the cone at a point of the sphere.
        let least = (along * cosine[i] - aside * sine) - o.spread.abs() * r;
        let doubled_area = least * area[i] * o.area_scale;
        let pixels = o.edge_scale * edge[i];
        // Both sides times w_max^3; snapping 4 L / 256, with a margin of one percent.
        let moved = (0.0158 * pixels / w_min + 1e-4) * (w_max * w_max * w_max);
        // Rounding must be negligible beside snapping.
        let flip_normal = (doubled_area > moved) & (o.screen_error <= 1e-5 * w_min);
        let gone = (outside & is_before) | (w_max < 0.0);
        let culled = inside & is_before & flip_normal & !gone;
        visibilities[i] = (culled as u8 * Visibility::CULLED) | (gone as u8 * Visibility::OUTSIDE);
    }
    visibilities
}

#[cfg(test)]
mod tests;
