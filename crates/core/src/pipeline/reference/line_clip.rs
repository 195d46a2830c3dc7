//! Clipping of a line in space against the six planes, before it is projected.
//!
//! A line of which all is inside stays as it is. Any other is transformed again with two f64 a number
//! and cut there: an end at 10^16 units would be cut some units off in f64.

use crate::math::double_double::DoubleDouble;
use crate::pipeline::clip::ClipVertex;
use crate::pipeline::vertex::{Transform, Vertex};
use crate::pipeline::wide_vertex::WideVertex;
use glam::DVec4;

/// Varyings of a line: w - z, world x y z, colour r g b a.
pub(super) type LineVertex = ClipVertex<8>;

/// End of a line before it is clipped.
#[derive(Clone, Copy)]
pub(super) struct LineEnd {
    /// The transformed position.
    pub vertex: Vertex,
    /// Clip-space position and varyings.
    pub clip: LineVertex,
}

/// Clip coordinates and varyings with two f64 a number.
type Wide = [DoubleDouble; 12];

/// Returns the distances from the six planes, not negative inside.
fn distances(x: DoubleDouble, y: DoubleDouble, z: DoubleDouble, w: DoubleDouble) -> [DoubleDouble; 6] {
    [w + x, w - x, w + y, w - y, z, w - z]
}

fn wide_of(t: &Transform, end: &LineEnd) -> (Wide, [DoubleDouble; 6]) {
    let WideVertex { clip, complement } = WideVertex::of(t, &end.vertex);
    let world = WideVertex::world_of(t, &end.vertex);
    let mut wide = [DoubleDouble::default(); 12];
    wide[..4].copy_from_slice(&clip);
    wide[4] = complement;
    wide[5..8].copy_from_slice(&world);
    for (to, from) in wide[8..].iter_mut().zip(&end.clip.varyings[4..]) {
        *to = (*from).into();
    }
    let mut all = distances(clip[0], clip[1], clip[2], clip[3]);
    // w - z without cancellation.
    all[5] = complement;
    (wide, all)
}

/// Returns the ends of the part of a line inside all six planes, or `None`.
pub(super) fn clip_ends(t: &Transform, ends: [&LineEnd; 2]) -> Option<[LineVertex; 2]> {
    if !ends.iter().all(|e| e.clip.pos_clip.is_finite() && e.clip.varyings[0].is_finite()) {
        return None;
    }
    let is_inside = |e: &LineEnd| {
        let DVec4 { x, y, z, w } = e.clip.pos_clip;
        x.abs() <= w && y.abs() <= w && z >= 0.0 && e.clip.varyings[0] >= 0.0 && w > 0.0
    };
    if ends.iter().all(|e| is_inside(e)) {
        return Some(ends.map(|e| e.clip));
    }
    // Always in one direction, so that a line has the same ends whichever comes first.
    let position = |e: &LineEnd| e.vertex.position.to_array();
    if position(ends[0]) > position(ends[1]) {
        let [a, b] = clip_ends(t, [ends[1], ends[0]])?;
        return Some([b, a]);
    }
    let [(a, from_a), (b, from_b)] = ends.map(|e| wide_of(t, e));
    let [mut first, mut last] = [DoubleDouble::default(), DoubleDouble::from(1.0)];
    for (fa, fb) in from_a.into_iter().zip(from_b) {
        match (fa.hi < 0.0, fb.hi < 0.0) {
            (true, true) => return None,
            (true, false) => first = first.max(fa / (fa - fb)),
            (false, true) => last = last.min(fa / (fa - fb)),
            (false, false) => {}
        }
    }
    if (last - first).hi < 0.0 {
        return None;
    }
    let at = |along: DoubleDouble| {
        let v: [f64; 12] = std::array::from_fn(|k| (a[k] + (b[k] - a[k]) * along).hi);
        ClipVertex {
            pos_clip: DVec4::new(v[0], v[1], v[2], v[3]),
            varyings: std::array::from_fn(|k| v[k + 4]),
        }
    };
    let cut = [at(first), at(last)];
    cut.iter().all(|v| v.pos_clip.w > 0.0 && v.pos_clip.is_finite()).then_some(cut)
}
