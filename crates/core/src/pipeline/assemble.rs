//! Stages 4 and 5: facing, culling, and clipping in front of the eye.
//!
//! In: three vertices. Out: the snapped outlines of the visible part, and the face's plane. The
//! four sides of the view never cut; near and far are tested per pixel. Only a face with some w <=
//! 0 is cut, between the eye and the near plane, where nothing is visible. Each such edge is cut at
//! a point that depends on that edge alone, computed from its end in front, so neighbouring faces
//! share it bit for bit. Corners beyond 2^40 pixels, and planes through corners so far from the eye
//! that f64 loses the near ones, take two f64 a number ([`super::far_face`]).

use super::draw_call::DrawStats;
use super::far_face::FarFace;
use super::plane_equation::{FacePlane, PlaneEquation, Weights};
use super::vertex::{Transform, Vertex};
use super::viewport::ViewportTransform;
use crate::math::coverage::SnappedTriangle;
use crate::scene::{Cull, Interpolation};
use glam::DVec4;
use std::cmp::Ordering;

/// Side of a face that is seen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Facing {
    /// The counter-clockwise side in the mesh's own order of corners.
    Front,
    /// The clockwise side.
    Back,
}

/// A face on the screen.
#[derive(Clone, Debug)]
pub(crate) struct Face {
    /// Visible side.
    pub side: Facing,
    /// Unsnapped plane, for depth and attributes.
    pub plane: FacePlane,
    /// True if 0 <= z < 1 at every corner, so that no pixel needs a near/far test.
    pub wholly_between_near_and_far: bool,
    /// Minimum and maximum z/w of the corners; infinite if some w <= 0.
    pub z_range: [f64; 2],
    /// Outlines to rasterize: the face, or the rest of a cut one, as up to two triangles.
    pub outlines: [Option<SnappedTriangle>; 2],
}

/// Sets up faces: facing, culling, clipping in front of the eye.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Assembler {
    pub transform: Transform,
    pub cull: Cull,
    /// True if the model or the window, but not both, mirrors: front faces are then clockwise on
    /// the screen.
    pub mirrored: bool,
}

impl Face {
    /// Returns the plane equation of a face that crosses near or far, for testing each pixel by
    /// [`PlaneEquation::is_between_near_and_far`] with [`Self::z_range`]; `None` if no test is
    /// needed.
    pub fn crossing(&self, screen: &ViewportTransform) -> Option<PlaneEquation> {
        let is_crossing = !self.wholly_between_near_and_far;
        is_crossing.then(|| self.plane.plane_equation(screen, Interpolation::Perspective))
    }

    /// Stage 7: returns the weights at the centre of a pixel, with z and 1 - z in 0..=1; `None` if
    /// the face has no point there between near and far. `crossing` is [`Self::crossing`].
    #[inline(always)]
    pub fn point_at(
        &self,
        [x, y]: [i32; 2],
        screen: &ViewportTransform,
        crossing: Option<&PlaneEquation>,
    ) -> Option<(Weights, f64, f64)> {
        let weights = self.plane.clamped(self.plane.weights_at(screen.ndc_of_pixel(x, y)))?;
        if crossing.is_some_and(|plane| !plane.is_between_near_and_far(self.z_range, x, y)) {
            return None;
        }
        let (z, complement) = self.plane.depth(&weights);
        Some((weights, z.clamp(0.0, 1.0), complement.clamp(0.0, 1.0)))
    }
}

/// Returns [`Face::z_range`].
fn z_range(corners: [&Vertex; 3]) -> [f64; 2] {
    if !corners.iter().all(|v| v.clip.w > 0.0) {
        return [f64::NEG_INFINITY, f64::INFINITY];
    }
    let [a, b, c] = corners.map(|v| v.clip.z / v.clip.w);
    [a.min(b).min(c), a.max(b).max(c)]
}

impl Assembler {
    /// Creates an assembler, and determines whether model and window mirror.
    pub fn new(transform: Transform, cull: Cull) -> Self {
        let model = transform.model;
        let turns = |m: glam::DMat4| glam::DMat3::from_mat4(m).determinant() < 0.0;
        let p = transform.camera.projection;
        let window_turns = (p.x_axis.x < 0.0) != (p.y_axis.y < 0.0);
        Assembler { transform, cull, mirrored: turns(scaled(model)) != window_turns }
    }

    /// Returns the face with these corners. Returns `None` if nothing of it is drawn, and counts
    /// the reason in `stats`.
    pub fn face(&self, corners: [&Vertex; 3], stats: &mut DrawStats) -> Option<Face> {
        stats.faces += 1;
        if corners.iter().any(|v| !(v.clip.is_finite() && v.complement.is_finite())) {
            stats.faces_empty += 1;
            return None;
        }
        if self.is_outside(corners) {
            stats.faces_outside += 1;
            return None;
        }
        let on_screen = |v: &&Vertex| v.screen[0].is_finite() && v.screen[1].is_finite();
        let cut = !corners.iter().all(on_screen);
        let far = FarFace::of(&self.transform, corners);
        let outlines = match (&far, cut) {
            (Some(far), _) => far.outlines(&self.transform, |a, b| self.cut_edge(a, b)),
            (None, false) => [outline(corners.map(|v| v.screen)), None],
            (None, true) => self.cut(corners),
        };
        let Some(winding) = outlines.iter().flatten().map(SnappedTriangle::orientation).next() else {
            stats.faces_empty += 1;
            return None;
        };
        let counter_clockwise = winding == Ordering::Less;
        let side = if counter_clockwise != self.mirrored { Facing::Front } else { Facing::Back };
        match (self.cull, side) {
            (Cull::Back, Facing::Back) | (Cull::Front, Facing::Front) => {
                stats.faces_culled += 1;
                return None;
            }
            _ => {}
        }
        let plane = far.as_ref().map_or_else(|| FacePlane::new(corners), FarFace::plane);
        let Some(plane) = plane else {
            stats.faces_empty += 1;
            return None;
        };
        stats.faces_cut += cut as u64;
        stats.faces_drawn += 1;
        let between = |v: &&Vertex| v.clip.z >= 0.0 && v.complement > 1e-9 * v.clip.w && v.clip.w > 0.0;
        Some(Face {
            side,
            plane,
            wholly_between_near_and_far: corners.iter().all(between),
            z_range: z_range(corners),
            outlines,
        })
    }

    /// Returns the visible side of a face, whether it is culled or not; `None` without area on the
    /// screen.
    pub fn side(&self, corners: [&Vertex; 3]) -> Option<Facing> {
        let on_screen = corners.iter().all(|v| v.screen[0].is_finite() && v.screen[1].is_finite());
        let outlines = match (FarFace::of(&self.transform, corners), on_screen) {
            (Some(far), _) => far.outlines(&self.transform, |a, b| self.cut_edge(a, b)),
            (None, true) => [outline(corners.map(|v| v.screen)), None],
            (None, false) => self.cut(corners),
        };
        let winding = outlines.iter().flatten().map(SnappedTriangle::orientation).next()?;
        Some(if (winding == Ordering::Less) != self.mirrored { Facing::Front } else { Facing::Back })
    }

    /// Returns whether all corners are beyond one side of the view, far enough that snapping cannot
    /// bring them back.
    fn is_outside(&self, corners: [&Vertex; 3]) -> bool {
        let all = |beyond: fn(DVec4) -> bool| corners.iter().all(|v| beyond(v.clip));
        if all(|c| c.w <= 0.0) || all(|c| c.z < 0.0) || corners.iter().all(|v| v.complement < 0.0) {
            return true;
        }
        let clip = self.transform.screen.clip;
        if clip.is_empty() {
            return true;
        }
        let beyond = |axis: usize, low: i32, high: i32| {
            corners.iter().all(|v| v.screen[axis] < low as f64 - 1.0)
                || corners.iter().all(|v| v.screen[axis] > high as f64 + 1.0)
        };
        // Corners behind the eye are not finite, so they compare as beyond no side.
        beyond(0, clip.x0, clip.x1) || beyond(1, clip.y0, clip.y1)
    }

    /// Returns the part in front of the eye of a face that crosses the eye plane, as up to two
    /// triangles.
    fn cut(&self, corners: [&Vertex; 3]) -> [Option<SnappedTriangle>; 2] {
        let (mut ring, mut count) = ([[0.0; 2]; 6], 0);
        let mut push = |point| (ring[count], count) = (point, count + 1);
        for i in 0..3 {
            let (a, b) = (corners[i], corners[(i + 1) % 3]);
            let (a_in, b_in) = (a.clip.w > 0.0, b.clip.w > 0.0);
            if a_in {
                push(a.screen);
            }
            match (a_in, b_in) {
                (true, false) => push(self.cut_edge(a.clip, b.clip)),
                (false, true) => push(self.cut_edge(b.clip, a.clip)),
                _ => {}
            }
        }
        let mut outlines = [None, None];
        for (piece, at) in outlines.iter_mut().zip(1..count.saturating_sub(1)) {
            *piece = outline([ring[0], ring[at], ring[at + 1]]);
        }
        // Rounding may fold the second triangle over the first; the fold is thinner than a snapping
        // step.
        if let [Some(a), Some(b)] = &outlines
            && a.orientation() != b.orientation()
        {
            outlines[1] = None;
        }
        outlines
    }

    /// Returns the screen point at which the edge from `a` in front to `b` behind is cut: nearer to
    /// the eye than the near plane and than `a`.
    fn cut_edge(&self, a: DVec4, b: DVec4) -> [f64; 2] {
        let w = 0.5 * self.transform.camera.w_near.min(a.w);
        let t = (a.w - w) / (a.w - b.w);
        let mut cut = a + (b - a) * t;
        cut.w = w;
        self.transform.on_screen(cut)
    }
}

/// Returns the snapped triangle, if it has an area.
fn outline(points: [[f64; 2]; 3]) -> Option<SnappedTriangle> {
    Some(SnappedTriangle::new(points)).filter(|t| t.orientation() != Ordering::Equal)
}

/// Returns the model scaled so that its largest entry is 1 and its determinant neither over- nor
/// underflows.
fn scaled(m: glam::DMat4) -> glam::DMat4 {
    let a = glam::DMat3::from_mat4(m).to_cols_array().iter().fold(0.0f64, |a, v| a.max(v.abs()));
    if a > 0.0 && (1.0 / a) > 0.0 && (1.0 / a).is_finite() { m * (1.0 / a) } else { m }
}

#[cfg(test)]
mod tests {
    use super::scaled;
    use glam::{DMat3, DMat4, DVec4};

    #[test]
    fn a_scaled_model_has_1_as_its_largest_entry_and_the_same_handedness() {
        // Slightly rotated, and mirrored for one of the two.
        for side in [1.0, -1.0] {
            let columns = [[0.5, 0.25, 0.0], [-0.25, 0.75, 0.125], [0.0, -0.125, side]];
            for exponent in [-1000, -500, -200, -1, 0, 1, 200, 500, 1000] {
                let size = libm::exp2(f64::from(exponent));
                let column = |i: usize| DVec4::from((glam::DVec3::from(columns[i]) * size, 0.0));
                let model = DMat4::from_cols(column(0), column(1), column(2), DVec4::new(3.0, 4.0, 5.0, 1.0));
                let part = DMat3::from_mat4(scaled(model));
                let largest = part.to_cols_array().iter().fold(0.0f64, |m, x| m.max(x.abs()));
                assert_eq!(largest, 1.0, "2^{exponent}");
                assert_eq!(part.determinant().signum(), side, "2^{exponent}");
            }
        }
        // No scale exists.
        assert_eq!(scaled(DMat4::ZERO), DMat4::ZERO);
    }
}
