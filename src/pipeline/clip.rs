//! The clipper of source 000: polygons and lines against the six planes of clip space, before the division.
//!
//! In: vertices (x, y, z, h) in homogeneous clip space with any number of varyings (colours, normals, texture coordinates).
//! Out: the part inside -h<=x<=h, -h<=y<=h, 0<=z<=h, points on a plane inside, all h > 0. A new vertex lies at
//! a + t (b - a), t = f(a) / (f(a) - f(b)), varyings with the same t; `a` is always the end inside, so faces that share an
//! edge get it bit for bit, whichever way they run along it. Source: Sutherland, Hodgman, "Reentrant polygon clipping"
//! (1974); Liang, Barsky (1984) for lines.
//!
//! Filled faces need none of this (their coverage makes no new vertices); lines and outlines do.

use glam::DVec4;

/// A vertex in clip space with `N` numbers that vary over the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClipVertex<const N: usize> {
    /// x, y, z, h.
    pub pos_clip: DVec4,
    /// Colours, normals, texture coordinates.
    pub varyings: [f64; N],
}

/// The six planes as f >= 0: x+h, h-x, y+h, h-y, z, h-z.
const PLANES: [DVec4; 6] = [
    DVec4::new(1.0, 0.0, 0.0, 1.0),
    DVec4::new(-1.0, 0.0, 0.0, 1.0),
    DVec4::new(0.0, 1.0, 0.0, 1.0),
    DVec4::new(0.0, -1.0, 0.0, 1.0),
    DVec4::new(0.0, 0.0, 1.0, 0.0),
    DVec4::new(0.0, 0.0, -1.0, 1.0),
];

/// f of one plane: two of the coordinates, added.
fn distance(plane: usize, p: DVec4) -> f64 {
    PLANES[plane].dot(p)
}

impl<const N: usize> ClipVertex<N> {
    /// The point `t` of the way from this vertex to `b`.
    fn towards(&self, b: &Self, t: f64) -> Self {
        ClipVertex {
            pos_clip: self.pos_clip + (b.pos_clip - self.pos_clip) * t,
            varyings: std::array::from_fn(|i| self.varyings[i] + (b.varyings[i] - self.varyings[i]) * t),
        }
    }

    /// Where the edge from this vertex, which is inside, to `b`, which is not, meets a plane.
    fn cut(&self, b: &Self, plane: usize) -> Self {
        let (fa, fb) = (distance(plane, self.pos_clip), distance(plane, b.pos_clip));
        let mut v = self.towards(b, fa / (fa - fb));
        // On the plane to the last bit, so that nothing lies outside after the division.
        let h = v.pos_clip.w;
        match plane {
            0 => v.pos_clip.x = -h,
            1 => v.pos_clip.x = h,
            2 => v.pos_clip.y = -h,
            3 => v.pos_clip.y = h,
            4 => v.pos_clip.z = 0.0,
            _ => v.pos_clip.z = h,
        }
        v
    }
}

/// The part of a convex polygon inside all six planes, in the same direction; empty when there is none.
///
/// A corner that is not finite makes the polygon empty.
pub fn clip_polygon<const N: usize>(polygon: &[ClipVertex<N>]) -> Vec<ClipVertex<N>> {
    if polygon.iter().any(|v| !v.pos_clip.is_finite()) {
        return Vec::new();
    }
    let mut ring = polygon.to_vec();
    for plane in 0..PLANES.len() {
        let mut kept: Vec<ClipVertex<N>> = Vec::with_capacity(ring.len() + 1);
        for (i, a) in ring.iter().enumerate() {
            let b = &ring[(i + 1) % ring.len()];
            let (a_in, b_in) = (distance(plane, a.pos_clip) >= 0.0, distance(plane, b.pos_clip) >= 0.0);
            if a_in {
                kept.push(*a);
            }
            match (a_in, b_in) {
                (true, false) => kept.push(a.cut(b, plane)),
                (false, true) => kept.push(b.cut(a, plane)),
                _ => {}
            }
        }
        // A corner on the plane gives itself twice.
        kept.dedup();
        if kept.len() > 1 && kept.first() == kept.last() {
            kept.pop();
        }
        ring = kept;
    }
    // Only the eye itself has h = 0 and is inside every plane.
    ring.retain(|v| v.pos_clip.w > 0.0);
    ring
}

/// The part of a line inside all six planes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClippedLine<const N: usize> {
    /// How far along the line the part begins and ends, 0..1.
    pub t: [f64; 2],
    /// Its ends.
    pub ends: [ClipVertex<N>; 2],
}

/// The part of the line from `a` to `b` inside all six planes, or `None`. It is the same bit for bit backwards.
pub fn clip_line<const N: usize>(a: ClipVertex<N>, b: ClipVertex<N>) -> Option<ClippedLine<N>> {
    if !(a.pos_clip.is_finite() && b.pos_clip.is_finite()) {
        return None;
    }
    // Always worked in one direction, so that an edge is cut alike from both sides.
    let (pa, pb) = (a.pos_clip.to_array(), b.pos_clip.to_array());
    let order = (0..4).map(|i| pa[i].total_cmp(&pb[i])).find(|o| o.is_ne());
    if order.is_some_and(|o| o.is_gt()) {
        let back = clip_line(b, a)?;
        let [t0, t1] = back.t;
        return Some(ClippedLine { t: [1.0 - t1, 1.0 - t0], ends: [back.ends[1], back.ends[0]] });
    }
    let (mut t0, mut t1) = (0.0f64, 1.0f64);
    // The plane at which the part begins, and at which it ends.
    let (mut first, mut last) = (None, None);
    for plane in 0..PLANES.len() {
        let (fa, fb) = (distance(plane, a.pos_clip), distance(plane, b.pos_clip));
        match (fa >= 0.0, fb >= 0.0) {
            (false, false) => return None,
            (false, true) => {
                let t = fa / (fa - fb);
                if t > t0 || first.is_none() {
                    (t0, first) = (t, Some(plane));
                }
            }
            (true, false) => {
                let t = fa / (fa - fb);
                if t < t1 || last.is_none() {
                    (t1, last) = (t, Some(plane));
                }
            }
            (true, true) => {}
        }
    }
    if t0 > t1 {
        return None;
    }
    let end = |whole: ClipVertex<N>, t: f64| {
        if t == 0.0 {
            a
        } else if t == 1.0 {
            b
        } else {
            whole
        }
    };
    let ends = [end(a.towards(&b, t0), t0), end(a.towards(&b, t1), t1)];
    ends.iter().all(|v| v.pos_clip.w > 0.0).then_some(ClippedLine { t: [t0, t1], ends })
}

#[cfg(test)]
mod tests;
