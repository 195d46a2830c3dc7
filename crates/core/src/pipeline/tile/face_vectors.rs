//! Vectors of faces at set-up: their corners, classes, pixel boxes, edge functions and depth
//! planes, a face in each lane.
//!
//! In: screen vertices and three indices a face. Out: masks of the faces to be drawn, and the fields
//! of their set-up. Promise: the decisions of the plain path, or a lane of `by_plain` where f32 and
//! i32 do not reach. All functions are inlined into the kernel of [`super::setup`].

use super::bins::{SMALL_SIDE, TINY_SIDE, Winding};
use super::close_depths::{MOST_SPREAD, THIN};
use super::edges::{bounds3, corner, count_of, coverage, edge, pixels, snapped, sort_corners};
use super::vertex::{Outcode, ScreenVertex};
use crate::math::coverage::PixelRect;
use crate::pipeline::draw_call::DrawStats;
use crate::simd::{F32, I32, Simd};

/// Largest range of depth over a face, times its slenderness (longest side squared over doubled
/// area): the rounding of the slope then moves depth by less than 6e-8 over the face.
const STEEPEST: f32 = 1.0 / 2.0;

/// Largest slenderness for barycentrics in f32: longest side squared over doubled area.
const SLENDEREST: f32 = 4096.0;

/// Smallest thickness of a face in pixels. Snapping covers centres up to 1/360 pixel beside the
/// unsnapped face; there, the depth errors of its corners, 9e-8 at most, are amplified
/// 1 + 2 / (360 thickness) times: here 2.4 times.
const THINNEST: f32 = 1.0 / 256.0;

/// Largest depth slope per pixel for positions in 1/65536 pixel: an error below 1e-7.
const STEEPEST_SLOPE: f32 = 1.0 / 128.0;

/// Corners of a vector of faces.
pub(super) struct FaceCorners<S: Simd> {
    /// Lanes that hold a face.
    live: S::M,
    /// Screen vertices of each corner.
    records: [[S::F; 4]; 3],
    /// Snapped position of each corner, in 1/256 pixel.
    snapped: [(S::I, S::I); 3],
    /// Least and greatest snapped x and y.
    x_range: (S::I, S::I),
    y_range: (S::I, S::I),
    /// Least and greatest depth.
    z_range: (S::F, S::F),
}

/// Decisions about a vector of faces.
pub(super) struct FaceClasses<S: Simd> {
    /// Faces whose drawn side is seen and that are set up here.
    pub seen: S::M,
    /// Faces that the plain path sets up.
    pub by_plain: S::M,
    /// Faces whose corners run counterclockwise.
    pub is_counter: S::M,
}

/// Pixels whose centres lie within the bounds of each face, half-open.
pub(super) struct PixelBoxes<S: Simd> {
    pub left: S::I,
    pub top: S::I,
    pub right: S::I,
    pub bottom: S::I,
    /// Width and height.
    pub size: (S::I, S::I),
    /// Centre of the first pixel, in 1/256 pixel.
    pub center: (S::I, S::I),
}

/// Edge functions at the first pixel's centre, and their steps by a pixel in x and y; not negative
/// inside.
pub(super) struct EdgeFunctions<S: Simd> {
    pub e: [S::I; 3],
    pub steps_x: [S::I; 3],
    pub steps_y: [S::I; 3],
}

/// Depth of each face at the first pixel's centre, and its steps by a pixel.
pub(super) struct DepthPlanes<S: Simd> {
    pub z: S::F,
    pub zx: S::F,
    pub zy: S::F,
    /// (rise L / det)^2, and the rough faces: see [`super::close_depths`].
    pub spread: S::F,
    pub is_rough: S::M,
    /// Faces for which f32 is enough.
    pub is_gentle: S::M,
}

impl<S: Simd> FaceCorners<S> {
    /// Gathers the corners of `count` faces, whose indices begin at `start` of each list.
    #[inline(always)]
    pub fn gather(
        s: S,
        screen_vertices: &[ScreenVertex],
        corners: [&[i32]; 3],
        start: usize,
        count: usize,
    ) -> Self {
        let live = s.mask(u32::MAX >> (32 - count));
        let all = s.mask(u32::MAX);
        let c0 = s.load_i(&corners[0][start..start + S::LANES]);
        let c1 = s.load_i(&corners[1][start..start + S::LANES]);
        let c2 = s.load_i(&corners[2][start..start + S::LANES]);
        let r0 = s.gather4(all, screen_vertices, c0);
        let r1 = s.gather4(all, screen_vertices, c1);
        let r2 = s.gather4(all, screen_vertices, c2);
        let (z0, z1, z2) = (r0[2], r1[2], r2[2]);
        let ((x0, y0), (x1, y1), (x2, y2)) = (snapped(s, r0), snapped(s, r1), snapped(s, r2));
        FaceCorners {
            live,
            records: [r0, r1, r2],
            snapped: [(x0, y0), (x1, y1), (x2, y2)],
            x_range: bounds3::<S>(x0, x1, x2),
            y_range: bounds3::<S>(y0, y1, y2),
            z_range: (z0.min(z1).min(z2), z0.max(z1).max(z2)),
        }
    }

    /// Returns the faces that lie more than a pixel beyond a side of the clip rectangle, before
    /// near or beyond far.
    #[inline(always)]
    fn is_outside(&self, s: S, view: &PixelRect) -> S::M {
        let [r0, r1, r2] = self.records;
        let (min_fx, max_fx) = bounds3::<S>(r0[0].bits(), r1[0].bits(), r2[0].bits());
        let (min_fy, max_fy) = bounds3::<S>(r0[1].bits(), r1[1].bits(), r2[1].bits());
        let (z_min, z_max) = self.z_range;
        let is_beyond = s.splat_i((view.x0 - 1) << 16).gt(max_fx)
            | min_fx.gt(s.splat_i((view.x1 + 1) << 16))
            | s.splat_i((view.y0 - 1) << 16).gt(max_fy)
            | min_fy.gt(s.splat_i((view.y1 + 1) << 16));
        is_beyond | z_max.lt(s.splat(0.0)) | s.splat(1.0).lt(z_min)
    }

    /// Decides what becomes of each face, and counts as the plain path does.
    #[inline(always)]
    pub fn classify(
        &self,
        s: S,
        view: &PixelRect,
        winding: Winding,
        stats: &mut DrawStats,
    ) -> FaceClasses<S> {
        let none = s.splat_i(0);
        let [r0, r1, r2] = self.records;
        // A screen vertex without 1/w can only be placed by the plain path.
        let (odd0, odd1, odd2) = (r0[3].bits().eq(none), r1[3].bits().eq(none), r2[3].bits().eq(none));
        let is_odd = self.live & (odd0 | odd1 | odd2);
        let fits = self.live & !is_odd;
        // In f32 these depths do not tell the side of the far plane.
        let (z_min, z_max) = self.z_range;
        let is_at_far = fits & s.splat(1.0).le(z_max) & z_min.le(s.splat(1.0 + 4.0 * f32::EPSILON));
        let outside = fits & !is_at_far & self.is_outside(s, view);
        // The sign of the area is exact in i32 for boxes of SMALL_SIDE; larger faces go to the
        // plain set-up.
        let side = s.splat_i((SMALL_SIDE + 1) * 256);
        let is_small = side.gt(self.x_range.1 - self.x_range.0) & side.gt(self.y_range.1 - self.y_range.0);
        let [(x0, y0), (x1, y1), (x2, y2)] = self.snapped;
        let (ux, uy, vx, vy) = (x1 - x0, y1 - y0, x2 - x0, y2 - y0);
        let area = ux * vy - vx * uy;
        let is_clockwise = area.gt(none);
        let is_counter = none.gt(area);
        let kept = match winding {
            Winding::CounterClockwise => is_counter,
            Winding::Clockwise => is_clockwise,
            Winding::Both => is_counter | is_clockwise,
        };
        let inside = fits & !outside;
        let sized = inside & is_small & !is_at_far;
        let large = inside & (!is_small | is_at_far);
        let seen = sized & kept;
        let (n_outside, n_seen) = (count_of::<S>(outside), count_of::<S>(seen));
        let n_empty = count_of::<S>(sized & !(is_counter | is_clockwise));
        stats.faces_outside += n_outside;
        stats.faces_drawn += n_seen;
        stats.faces_empty += n_empty;
        stats.faces_culled += count_of::<S>(sized) - n_seen - n_empty;
        stats.faces += count_of::<S>(outside | sized);
        // Behind the eye with all corners, or beyond one plane: the outcode is in place of the
        // position.
        let flags = r0[0].bits() & r1[0].bits() & r2[0].bits();
        let is_all_odd = odd0 & odd1 & odd2;
        let gone = is_odd & is_all_odd & !(flags & s.splat_i(Outcode::OUTSIDE)).eq(none);
        let n_gone = count_of::<S>(gone);
        stats.faces += n_gone;
        stats.faces_outside += n_gone;
        FaceClasses { seen, by_plain: large | (is_odd & !gone), is_counter }
    }

    /// Returns the pixels of the clip rectangle that each face may cover.
    #[inline(always)]
    pub fn pixel_boxes(&self, s: S, view: &PixelRect) -> PixelBoxes<S> {
        let ((min_x, max_x), (min_y, max_y)) = (self.x_range, self.y_range);
        // Centres lie at 128 mod 256: the first at or after the low side, the last at or before
        // the high one.
        let left = (min_x + s.splat_i(127)).sar::<8>().max(s.splat_i(view.x0));
        let top = (min_y + s.splat_i(127)).sar::<8>().max(s.splat_i(view.y0));
        let right = (max_x + s.splat_i(128)).sar::<8>().min(s.splat_i(view.x1));
        let bottom = (max_y + s.splat_i(128)).sar::<8>().min(s.splat_i(view.y1));
        let size = (right - left, bottom - top);
        let center = (left.shl::<8>() + s.splat_i(128), top.shl::<8>() + s.splat_i(128));
        PixelBoxes { left, top, right, bottom, size, center }
    }

    /// Returns the edge functions; edge k runs from corner k+1 to k+2. Signs are flipped so that
    /// the inside is >= 0.
    #[inline(always)]
    pub fn edges(&self, s: S, is_counter: S::M, boxes: &PixelBoxes<S>) -> EdgeFunctions<S> {
        let [p0, p1, p2] = self.snapped;
        let (e0, sx0, sy0) = edge(s, is_counter, p1, p2, boxes.center);
        let (e1, sx1, sy1) = edge(s, is_counter, p2, p0, boxes.center);
        let (e2, sx2, sy2) = edge(s, is_counter, p0, p1, boxes.center);
        EdgeFunctions { e: [e0, e1, e2], steps_x: [sx0, sx1, sx2], steps_y: [sy0, sy1, sy2] }
    }

    /// Returns the depth planes of the unsnapped faces, from their corners in canonical order, so
    /// that faces with equal corners in any order get equal planes.
    #[inline(always)]
    pub fn depth_planes(&self, s: S, boxes: &PixelBoxes<S>) -> DepthPlanes<S> {
        let [r0, r1, r2] = self.records;
        let [a, b, c] = sort_corners(s, [corner::<S>(r0), corner::<S>(r1), corner::<S>(r2)]);
        let (bx, by, cx, cy) =
            (pixels(s, a[0], b[0]), pixels(s, a[1], b[1]), pixels(s, a[0], c[0]), pixels(s, a[1], c[1]));
        let (za, zb, zc) = (a[2].as_f32(), b[2].as_f32(), c[2].as_f32());
        let (bz, cz) = (zb - za, zc - za);
        let det = bx * cy - cx * by;
        let (zx, zy) = ((bz * cy - cz * by) / det, (cz * bx - bz * cx) / det);
        let half_unit = s.splat(0.5 / 65536.0);
        let (px, py) = boxes.center;
        let from_a = (pixels(s, a[0], px.shl::<8>()) - half_unit, pixels(s, a[1], py.shl::<8>()) - half_unit);
        let z = za + (zx * from_a.0 + zy * from_a.1);
        // f32 is enough where the roundings of the slope, times the box, stay below 6e-8.
        let reach2 =
            (bx * bx + by * by).max(cx * cx + cy * cy).max((cx - bx) * (cx - bx) + (cy - by) * (cy - by));
        let rise = bz.abs().max(cz.abs()).max((cz - bz).abs());
        let is_gentle = reach2.le(det.abs() * s.splat(SLENDEREST))
            & reach2.le(det * det * s.splat(1.0 / (THINNEST * THINNEST)))
            & (rise * reach2).le(det.abs() * s.splat(STEEPEST))
            & s.splat(0.0).lt(det.abs())
            & (zx.abs() + zy.abs()).le(s.splat(STEEPEST_SLOPE));
        let (z_min, z_max) = self.z_range;
        let is_between = s.splat(0.0).le(z_min) & z_max.lt(s.splat(1.0));
        let det2 = det * det;
        let spread = rise * (rise * reach2) / det2;
        let is_smooth = spread.le(s.splat(MOST_SPREAD)) & reach2.le(det2 * s.splat(1.0 / (THIN * THIN)));
        DepthPlanes { z, zx, zy, spread, is_rough: !is_smooth, is_gentle: is_gentle & is_between }
    }
}

impl<S: Simd> PixelBoxes<S> {
    /// Returns the faces of `work` that are at most [`TINY_SIDE`] pixels wide and high.
    #[inline(always)]
    pub fn is_tiny(&self, s: S, work: S::M) -> S::M {
        let tiny_side = s.splat_i(TINY_SIDE + 1);
        work & tiny_side.gt(self.size.0) & tiny_side.gt(self.size.1)
    }

    /// Returns the tiny faces of `rough`, of coverage `covered`, that cover a pixel less than 1/362
    /// pixel inside an edge.
    #[inline(always)]
    pub fn has_edge_pixels(
        &self,
        s: S,
        rough: S::M,
        edges: &EdgeFunctions<S>,
        (low, high): (S::I, S::I),
    ) -> S::M {
        let none = s.splat_i(0);
        let size = |v: S::I| v.max(none - v);
        let mut inner = edges.e;
        for (k, e) in inner.iter_mut().enumerate() {
            // E is the distance in pixels times the edge's length in 1/256 pixel, which is at most the
            // sum of its extents; 3/1024 is more than 1/362.
            let extents = size(edges.steps_x[k]) + size(edges.steps_y[k]);
            *e = *e - ((extents * s.splat_i(3)).shr::<10>() + s.splat_i(1));
        }
        let (inner_low, inner_high) = coverage(s, rough, self.size, inner, edges.steps_x, edges.steps_y);
        rough & !((low ^ inner_low) | (high ^ inner_high)).eq(none)
    }

    /// Returns the covered pixels of tiny faces, as the low and the high word of a bit each.
    #[inline(always)]
    pub fn coverage(&self, s: S, is_tiny: S::M, edges: &EdgeFunctions<S>) -> (S::I, S::I) {
        coverage(s, is_tiny, self.size, edges.e, edges.steps_x, edges.steps_y)
    }
}
