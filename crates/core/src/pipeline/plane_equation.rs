//! Plane equation of a face: depth and barycentrics over the screen.
//!
//! In: three clip-space corners, unsnapped, some of which may have w <= 0. Out: at any NDC point
//! (X, Y) the corners' weights and the depth. The form is homogeneous (Olano, Greer, "Triangle scan
//! conversion using 2D homogeneous coordinates", 1997), relative to one corner so that small faces
//! far from the axis keep their precision:
//!
//! ```text
//! q = (X, Y, 1) = b0 v0 + b1 v1 + b2 v2      with v = (x, y, w) of a corner
//! b1 = det(v0, q, v2) / det(v0, v1, v2)      1/w of the pixel = b0 + b1 + b2
//! z/w of the pixel = b0 z0 + b1 z1 + b2 z2
//! ```
//!
//! b / sum(b) are the perspective-correct barycentrics, b_i w_i those linear on the screen. The
//! only division by a corner's w is by that of the reference corner, which is the one nearest the
//! middle of the view. The corners are sorted by their positions alone, so a face's depth has the
//! same bits in any corner order.

mod far;

use super::vertex::Vertex;
use super::viewport::ViewportTransform;
use crate::math::sort3;
use crate::scene::Interpolation;

/// A face's plane over the screen.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FacePlane {
    /// NDC position of the reference corner, or of the middle of the view if that corner is far.
    origin: [f64; 2],
    /// Its 1/w, z/w and (w-z)/w.
    inv_w: f64,
    z: f64,
    complement: f64,
    /// The other two corners: gradient with b = base + gradient . (X - X0, Y - Y0), w, and the
    /// increments of z/w and (w-z)/w per b.
    others: [Corner; 2],
    /// w of the reference corner.
    w: f64,
    /// Indices of the reference corner and the other two among the caller's corners.
    order: [usize; 3],
    /// True if all w are positive, so that the weights can be clamped on the screen.
    in_front: bool,
}

/// Depth and weights of a face as linear functions of the pixel position.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PlaneEquation {
    /// Position of the reference corner in pixels.
    pub origin: [f64; 2],
    /// z at the origin, and its step per column and per row.
    pub z: [f64; 3],
    /// 1 - z in the same form, computed without cancellation.
    pub complement: [f64; 3],
    /// For each corner in the caller's order: b at the origin, and its step per column and per row.
    pub barycentrics: [[f64; 3]; 3],
}

impl PlaneEquation {
    /// Evaluates a linear function at the centre of pixel (x, y).
    #[inline]
    pub fn at(&self, [base, dx, dy]: [f64; 3], x: i32, y: i32) -> f64 {
        base + (dx * (x as f64 + 0.5 - self.origin[0]) + dy * (y as f64 + 0.5 - self.origin[1]))
    }

    /// Returns z at the centre of pixel (x, y).
    #[inline]
    pub fn z_at(&self, x: i32, y: i32) -> f64 {
        self.at(self.z, x, y)
    }

    /// Returns whether the face lies between near (inclusive) and far (exclusive) at the centre of
    /// pixel (x, y). A z extrapolated beyond the face is clamped to `z_range`, the range of z at
    /// its corners.
    #[inline]
    pub fn is_between_near_and_far(&self, z_range: [f64; 2], x: i32, y: i32) -> bool {
        (0.0..1.0).contains(&self.z_at(x, y).max(z_range[0]).min(z_range[1]))
    }

    /// Returns b of a corner at the centre of pixel (x, y).
    #[inline]
    pub fn barycentric_at(&self, corner: usize, x: i32, y: i32) -> f64 {
        self.at(self.barycentrics[corner], x, y)
    }
}

/// A corner relative to the reference corner; see [`FacePlane::others`].
#[derive(Clone, Copy, Debug, Default)]
struct Corner {
    gradient: [f64; 2],
    /// b at the plane's origin: 0 if that is the reference corner.
    base: f64,
    w: f64,
    z: f64,
    complement: f64,
}

/// Corner weights b of the module's formula at one point.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Weights {
    /// In the caller's corner order.
    b: [f64; 3],
    /// In the plane's own order, reference corner first.
    own: [f64; 3],
}

impl Weights {
    /// Returns the weights in the caller's order; their sum is 1/w.
    pub fn values(&self) -> [f64; 3] {
        self.b
    }
}

impl FacePlane {
    /// Creates the plane through three corners, at least one of which has w > 0. Returns `None` for
    /// a face without area, or if a coefficient is not finite.
    pub fn new(corners: [&Vertex; 3]) -> Option<Self> {
        let order = canonical_order(corners)?;
        let [v0, v1, v2] = order.map(|i| corners[i]);
        let c0 = v0.clip;
        let inv_w = 1.0 / c0.w;
        // Differences first: equal corners give exactly 0, so a face of constant depth has one
        // depth.
        let edge = |v: &Vertex| {
            let e = v.clip - c0;
            let ec = v.complement - v0.complement;
            Corner {
                gradient: [c0.w * e.x - c0.x * e.w, c0.w * e.y - c0.y * e.w],
                base: 0.0,
                w: v.clip.w,
                z: (c0.w * e.z - c0.z * e.w) * inv_w,
                complement: (c0.w * ec - v0.complement * e.w) * inv_w,
            }
        };
        let (e1, e2) = (edge(v1), edge(v2));
        let det = (e1.gradient[0] * e2.gradient[1] - e1.gradient[1] * e2.gradient[0]) * inv_w;
        let k = 1.0 / det;
        let b1 = [e2.gradient[1] * k, -e2.gradient[0] * k];
        let b2 = [-e1.gradient[1] * k, e1.gradient[0] * k];
        let plane = FacePlane {
            origin: [c0.x / c0.w, c0.y / c0.w],
            inv_w,
            z: c0.z / c0.w,
            complement: v0.complement / c0.w,
            others: [Corner { gradient: b1, ..e1 }, Corner { gradient: b2, ..e2 }],
            w: c0.w,
            order,
            in_front: corners.iter().all(|v| v.clip.w > 0.0),
        };
        (det != 0.0 && plane.is_finite()).then_some(plane)
    }

    /// Returns whether every coefficient is finite.
    fn is_finite(&self) -> bool {
        [self.origin[0], self.origin[1], self.z, self.complement]
            .iter()
            .chain(
                self.others
                    .iter()
                    .flat_map(|o| [&o.z, &o.complement, &o.base, &o.gradient[0], &o.gradient[1]]),
            )
            .all(|v| v.is_finite())
    }

    /// Returns the plane equation in pixels: depth, and the weights b, or b w if `interp` is
    /// affine.
    pub fn plane_equation(&self, screen: &ViewportTransform, interp: Interpolation) -> PlaneEquation {
        let scale = screen.ndc_per_pixel();
        let [o1, o2] = &self.others;
        let z = [0, 1].map(|axis| (o1.gradient[axis] * o1.z + o2.gradient[axis] * o2.z) * scale[axis]);
        let complement = [0, 1].map(|axis| {
            (o1.gradient[axis] * o1.complement + o2.gradient[axis] * o2.complement) * scale[axis]
        });
        let own = [0, 1, 2].map(|i| match i {
            0 => {
                let slope = |axis: usize| {
                    -(o1.gradient[axis] * o1.w + o2.gradient[axis] * o2.w) * self.inv_w * scale[axis]
                };
                [self.inv_w * (1.0 - o1.base * o1.w - o2.base * o2.w), slope(0), slope(1)]
            }
            _ => {
                let o = &self.others[i - 1];
                [o.base, o.gradient[0] * scale[0], o.gradient[1] * scale[1]]
            }
        });
        let mut barycentrics = [[0.0; 3]; 3];
        for (i, &at) in self.order.iter().enumerate() {
            let w = if i == 0 { self.w } else { self.others[i - 1].w };
            let factor = if interp == Interpolation::Affine { w } else { 1.0 };
            barycentrics[at] = own[i].map(|v| v * factor);
        }
        PlaneEquation {
            origin: screen.of_ndc(self.origin),
            z: [self.z + (o1.base * o1.z + o2.base * o2.z), z[0], z[1]],
            complement: [
                self.complement + (o1.base * o1.complement + o2.base * o2.complement),
                complement[0],
                complement[1],
            ],
            barycentrics,
        }
    }

    /// Returns the weights at an NDC point; outside the face some are negative.
    #[inline]
    pub fn weights_at(&self, ndc: [f64; 2]) -> Weights {
        let (dx, dy) = (ndc[0] - self.origin[0], ndc[1] - self.origin[1]);
        let b = self.others.map(|o| o.base + (dx * o.gradient[0] + dy * o.gradient[1]));
        let b0 = (1.0 - b[0] * self.others[0].w - b[1] * self.others[1].w) * self.inv_w;
        self.weights([b0, b[0], b[1]])
    }

    /// Returns the weights in both orders from those in the plane's own order.
    fn weights(&self, own: [f64; 3]) -> Weights {
        let mut b = [0.0; 3];
        for (i, &at) in self.order.iter().enumerate() {
            b[at] = own[i];
        }
        Weights { b, own }
    }

    /// Returns the weights clamped to the face, for a pixel that snapping put up to 1/256 pixel
    /// outside it. Returns `None` where the plane has no point in front of the eye.
    #[inline]
    pub fn clamped(&self, weights: Weights) -> Option<Weights> {
        let own = weights.own;
        if own[0] >= 0.0 && own[1] >= 0.0 && own[2] >= 0.0 {
            return Some(weights);
        }
        let w = [self.w, self.others[0].w, self.others[1].w];
        // With all corners in front of the eye clamp the weights on the screen, otherwise those in
        // space.
        let scale = if self.in_front { 1.0 } else { 1.0 / (own[0] + own[1] + own[2]) };
        let share = |i: usize| (own[i] * scale * if self.in_front { w[i] } else { 1.0 }).clamp(0.0, 1.0);
        let s = [share(0), share(1), share(2)];
        let own = if self.in_front {
            let sum = s[0] + s[1] + s[2];
            [s[0] / (sum * w[0]), s[1] / (sum * w[1]), s[2] / (sum * w[2])]
        } else {
            let depth = s[0] * w[0] + s[1] * w[1] + s[2] * w[2];
            s.map(|p| p / depth)
        };
        let sum = own[0] + own[1] + own[2];
        (scale > 0.0 && sum > 0.0 && sum.is_finite()).then(|| self.weights(own))
    }

    /// Returns the depth z in [0,1] at these weights, and 1 - z computed without cancellation.
    #[inline]
    pub fn depth(&self, weights: &Weights) -> (f64, f64) {
        let [_, b1, b2] = weights.own;
        let [o1, o2] = &self.others;
        (self.z + (b1 * o1.z + b2 * o2.z), self.complement + (b1 * o1.complement + b2 * o2.complement))
    }

    /// Returns z and 1 - z, if they are the same everywhere.
    pub fn only_depth(&self) -> Option<[f64; 2]> {
        let is_level = self.others.iter().all(|o| o.z == 0.0 && o.complement == 0.0);
        is_level.then_some([self.z, self.complement])
    }

    /// Returns whether it has the depths of another plane, bit by bit: where both were made of the same
    /// corners, in any order.
    pub fn has_depths_of(&self, other: &FacePlane) -> bool {
        let numbers = |plane: &FacePlane| {
            let of_corner = |o: &Corner| [o.gradient[0], o.gradient[1], o.base, o.w, o.z, o.complement];
            let [a, b] = [0, 1].map(|i| of_corner(&plane.others[i]));
            ([plane.origin[0], plane.origin[1], plane.inv_w, plane.z, plane.complement, plane.w], a, b)
        };
        self.in_front == other.in_front && numbers(self) == numbers(other)
    }

    /// Returns z and 1 - z at weights that may lie outside the face, clamped to the depths of its
    /// corners in front of the eye. The far limit applies only if all corners are in front.
    pub fn depth_within(&self, weights: &Weights) -> (f64, f64) {
        let at = |b: [f64; 3]| self.depth(&self.weights(b));
        let mut ends = vec![(self.z, self.complement)];
        let others = &self.others;
        ends.extend((0..2).filter(|&i| others[i].w > 0.0).map(|i| {
            let mut b = [0.0; 3];
            b[i + 1] = 1.0 / others[i].w;
            at(b)
        }));
        let (mut z, mut complement) = self.depth(weights);
        let near = ends.iter().copied().fold((f64::INFINITY, 0.0), |a, b| if b.0 < a.0 { b } else { a });
        let far = ends.iter().copied().fold((f64::NEG_INFINITY, 0.0), |a, b| if b.0 > a.0 { b } else { a });
        if z.is_nan() || z < near.0 {
            (z, complement) = near;
        } else if z > far.0 && self.in_front {
            (z, complement) = far;
        }
        (z, complement)
    }

    /// Returns the corners' barycentrics, which add up to 1; `None` beyond the horizon of the
    /// plane. `divide` is false if w is 1 everywhere.
    #[inline]
    pub fn barycentrics(&self, weights: &Weights, interp: Interpolation, divide: bool) -> Option<[f64; 3]> {
        let b = weights.b;
        match interp {
            // With w = 1 everywhere both kinds equal the weights.
            _ if !divide => Some(b),
            Interpolation::Perspective => {
                let inv_w = b[0] + b[1] + b[2];
                (inv_w > 0.0).then(|| b.map(|b| b / inv_w))
            }
            Interpolation::Affine => {
                let mut w = [0.0; 3];
                w[self.order[0]] = self.w;
                w[self.order[1]] = self.others[0].w;
                w[self.order[2]] = self.others[1].w;
                Some([b[0] * w[0], b[1] * w[1], b[2] * w[2]])
            }
        }
    }
}

/// Returns the corners' order: first the reference corner, which has w > 0 and is nearest the
/// middle of the view, then the others by their coordinates.
fn canonical_order(corners: [&Vertex; 3]) -> Option<[usize; 3]> {
    let away = |v: &Vertex| {
        let c = v.clip;
        if c.w > 0.0 { c.x.abs().max(c.y.abs()) / c.w } else { f64::INFINITY }
    };
    let by_position = |a: &Vertex, b: &Vertex| {
        let (a, b) = (a.clip, b.clip);
        a.w.total_cmp(&b.w).then(a.z.total_cmp(&b.z)).then(a.x.total_cmp(&b.x)).then(a.y.total_cmp(&b.y))
    };
    let mut order = [0, 1, 2];
    sort3(&mut order, |&a, &b| by_position(corners[a], corners[b]).is_lt());
    let first = (0..3).min_by(|&a, &b| away(corners[order[a]]).total_cmp(&away(corners[order[b]])))?;
    order[..=first].rotate_right(1);
    (corners[order[0]].clip.w > 0.0).then_some(order)
}

#[cfg(test)]
mod tests;
