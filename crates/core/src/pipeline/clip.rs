//! Clipping of polygons and lines against the six planes of clip space, before the division (notes
//! 000).
//!
//! In: vertices (x, y, z, h) in homogeneous clip space with any number of varyings (colours,
//! normals, texture coordinates). Out: the part inside -h<=x<=h, -h<=y<=h, 0<=z<=h, with all h > 0;
//! points on a plane are inside. A new vertex lies at a + t (b - a), t = f(a) / (f(a) - f(b)),
//! varyings with the same t. `a` is always the end inside, so faces that share an edge get the same
//! vertex bit for bit, in either direction. Source: Sutherland, Hodgman, "Reentrant polygon
//! clipping" (1974); Liang, Barsky (1984) for lines.
//!
//! Filled faces are not clipped here (their coverage makes no new vertices); lines and outlines
//! are.

use glam::DVec4;

/// Vertex in clip space with `N` varyings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClipVertex<const N: usize> {
    /// Homogeneous position x, y, z, h.
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

/// Returns f of one plane: the sum of two coordinates.
fn distance(plane: usize, p: DVec4) -> f64 {
    PLANES[plane].dot(p)
}

impl<const N: usize> ClipVertex<N> {
    /// Returns the point at parameter `t` from this vertex to `b`.
    fn towards(&self, b: &Self, t: f64) -> Self {
        ClipVertex {
            pos_clip: self.pos_clip + (b.pos_clip - self.pos_clip) * t,
            varyings: std::array::from_fn(|i| self.varyings[i] + (b.varyings[i] - self.varyings[i]) * t),
        }
    }

    /// Returns the intersection with a plane of the edge from this vertex, which is inside, to `b`,
    /// which is outside.
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

/// Returns the part of a convex polygon inside all six planes, with the same orientation; empty if
/// there is none.
///
/// A corner that is not finite makes the result empty.
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
        // A corner on the plane is added twice.
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

/// Part of a line inside all six planes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClippedLine<const N: usize> {
    /// Parameters along the line where the part begins and ends, in 0..1.
    pub t: [f64; 2],
    /// End points.
    pub ends: [ClipVertex<N>; 2],
}

/// Returns the part of the line from `a` to `b` inside all six planes, or `None`. Swapping the ends
/// gives the same points bit for bit.
pub fn clip_line<const N: usize>(a: ClipVertex<N>, b: ClipVertex<N>) -> Option<ClippedLine<N>> {
    if !(a.pos_clip.is_finite() && b.pos_clip.is_finite()) {
        return None;
    }
    // Always computed in one direction, so that both faces cut a shared edge alike.
    let (pa, pb) = (a.pos_clip.to_array(), b.pos_clip.to_array());
    let order = (0..4).map(|i| pa[i].total_cmp(&pb[i])).find(|o| o.is_ne());
    if order.is_some_and(|o| o.is_gt()) {
        let back = clip_line(b, a)?;
        let [t0, t1] = back.t;
        return Some(ClippedLine { t: [1.0 - t1, 1.0 - t0], ends: [back.ends[1], back.ends[0]] });
    }
    let (mut t0, mut t1) = (0.0f64, 1.0f64);
    // Planes at which the part begins and ends.
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
