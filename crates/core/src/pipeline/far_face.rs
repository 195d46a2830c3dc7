//! Faces with a corner so far away that f64 loses what of them is seen.
//!
//! In: the three transformed vertices of a face. Out: its outline and its plane, computed again from
//! the object-space positions with two f64 a number ([`DoubleDouble`]) where that is needed: a corner
//! beyond 2^40 pixels is off by 1/256 pixel or more in f64 (at 10^15 by 1/8 pixel, at 10^17 by the
//! width of an edge), and one 2^28 times as far from the eye as the near plane leaves no digits for
//! the depth in front of it.
//!
//! A corner is placed by its own coordinates alone, and an edge through the eye plane cut by its two
//! ends alone, so neighbours of a far face share their edges with it bit for bit.

use super::plane_equation::FacePlane;
use super::vertex::{Transform, Vertex};
use super::wide_vertex::WideVertex;
use crate::math::coverage::SnappedTriangle;
use crate::math::double_double::DoubleDouble;
use glam::DVec4;
use std::cmp::Ordering;

/// Distance in pixels beyond which corners are placed with two f64 a number.
const FAR_PIXELS: f64 = (1u64 << 40) as f64;

/// Clip coordinates, in units of w on the near plane, beyond which planes are computed so.
const FAR_CLIP: f64 = (1u64 << 28) as f64;

/// A face with a far corner.
pub(crate) struct FarFace<'v> {
    corners: [&'v Vertex; 3],
    wide: [WideVertex; 3],
}

/// Returns the screen position of a clip-space point with w > 0.
fn on_screen(t: &Transform, [x, y, _, w]: [DoubleDouble; 4]) -> [DoubleDouble; 2] {
    let (origin, half) = t.screen.map();
    let ndc = if t.camera.is_parallel { [x, y] } else { [x / w, y / w] };
    [0, 1].map(|axis| DoubleDouble::from(origin[axis]) + ndc[axis] * half[axis].into())
}

/// Returns whether f64 places a vertex less exactly than coverage needs.
fn is_off_screen(v: &Vertex) -> bool {
    v.screen.iter().any(|s| s.abs() > FAR_PIXELS)
}

/// Returns whether f64 loses the near plane at a vertex.
fn is_far_away(t: &Transform, v: &Vertex) -> bool {
    !t.camera.is_parallel && v.clip.abs().max_element() > FAR_CLIP * t.camera.w_near
}

impl<'v> FarFace<'v> {
    /// Returns the face if one of its corners is far.
    pub fn of(t: &Transform, corners: [&'v Vertex; 3]) -> Option<Self> {
        if !corners.iter().any(|v| is_off_screen(v) || is_far_away(t, v)) {
            return None;
        }
        Some(FarFace { corners, wide: corners.map(|v| WideVertex::of(t, v)) })
    }

    /// Returns the face's plane.
    pub fn plane(&self) -> Option<FacePlane> {
        FacePlane::of_wide(self.corners, &self.wide)
    }

    /// Returns the outlines of the part in front of the eye. `cut_edge` cuts an edge without far ends.
    pub fn outlines(
        &self,
        t: &Transform,
        cut_edge: impl Fn(DVec4, DVec4) -> [f64; 2],
    ) -> [Option<SnappedTriangle>; 2] {
        let mut ring = Vec::with_capacity(6);
        for i in 0..3 {
            let j = (i + 1) % 3;
            let (a_in, b_in) = (self.corners[i].clip.w > 0.0, self.corners[j].clip.w > 0.0);
            if a_in {
                ring.push(self.corner(t, i));
            }
            match (a_in, b_in) {
                (true, false) => ring.push(self.cut(t, [i, j], &cut_edge)),
                (false, true) => ring.push(self.cut(t, [j, i], &cut_edge)),
                _ => {}
            }
        }
        let mut outlines = [None, None];
        for (piece, at) in outlines.iter_mut().zip(1..ring.len().saturating_sub(1)) {
            let triangle = SnappedTriangle::of_wide([ring[0], ring[at], ring[at + 1]]);
            *piece = Some(triangle).filter(|t| t.orientation() != Ordering::Equal);
        }
        // As for other faces: a fold is thinner than a snapping step.
        if let [Some(a), Some(b)] = &outlines
            && a.orientation() != b.orientation()
        {
            outlines[1] = None;
        }
        outlines
    }

    /// Returns the place of a corner in front of the eye.
    fn corner(&self, t: &Transform, i: usize) -> [DoubleDouble; 2] {
        let v = self.corners[i];
        match is_off_screen(v) && self.wide[i].clip[3].is_positive() {
            true => on_screen(t, self.wide[i].clip),
            false => v.screen.map(From::from),
        }
    }

    /// Returns the place at which the edge from a corner in front to one behind the eye is cut.
    fn cut(
        &self,
        t: &Transform,
        [front, behind]: [usize; 2],
        cut_edge: impl Fn(DVec4, DVec4) -> [f64; 2],
    ) -> [DoubleDouble; 2] {
        let ends = [self.corners[front], self.corners[behind]];
        let [a, b] = [front, behind].map(|i| self.wide[i].clip);
        let is_far = ends.iter().any(|v| is_off_screen(v) || is_far_away(t, v));
        if !(is_far && a[3].is_positive()) || b[3].is_positive() {
            return cut_edge(ends[0].clip, ends[1].clip).map(From::from);
        }
        let w = DoubleDouble::from(0.5 * t.camera.w_near.min(a[3].hi));
        let along = (a[3] - w) / (a[3] - b[3]);
        let mut cut = [0, 1, 2, 3].map(|k| a[k] + (b[k] - a[k]) * along);
        cut[3] = w;
        on_screen(t, cut)
    }
}
