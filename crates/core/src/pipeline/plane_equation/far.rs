//! The plane of a face with far corners, from corners of two f64 a number.
//!
//! The formulas are those of [`FacePlane::new`]. Where the reference corner itself is far, the plane
//! is stated at the middle of the view: the difference of two pixels would otherwise be lost in the
//! distance to the corner.

use super::{Corner, FacePlane, canonical_order};
use crate::math::double_double::DoubleDouble;
use crate::pipeline::vertex::Vertex;
use crate::pipeline::wide_vertex::WideVertex;

/// Distance of the reference corner from the middle of the view, in NDC, up to which differences from
/// it keep the digits that depth needs.
const NEAR_NDC: f64 = 1024.0;

impl FacePlane {
    /// Creates the plane through three corners, at least one of which has w > 0. Returns `None` for
    /// a face without area, or if a coefficient is not finite.
    pub fn of_wide(corners: [&Vertex; 3], wide: &[WideVertex; 3]) -> Option<Self> {
        let order = canonical_order(corners)?;
        let [v0, v1, v2] = order.map(|i| &wide[i]);
        let [x0, y0, z0, w0] = v0.clip;
        if !w0.is_positive() {
            return None;
        }
        let edge = |v: &WideVertex| {
            let [x, y, z, w] = v.clip;
            let along = |at: DoubleDouble, start: DoubleDouble| w0 * (at - start) - start * (w - w0);
            let depths = [along(z, z0) / w0, along(v.complement, v0.complement) / w0];
            ([along(x, x0), along(y, y0)], depths)
        };
        let ([g1, depths1], [g2, depths2]) = (edge(v1).into(), edge(v2).into());
        let det = (g1[0] * g2[1] - g1[1] * g2[0]) / w0;
        let minus = |v: DoubleDouble| DoubleDouble::default() - v;
        let gradients = [[g2[1] / det, minus(g2[0] / det)], [minus(g1[1] / det), g1[0] / det]];
        let middle = [x0 / w0, y0 / w0];
        let is_near = middle.iter().all(|v| v.hi.abs() < NEAR_NDC);
        let base = gradients.map(|g| match is_near {
            true => 0.0,
            false => minus(g[0] * middle[0] + g[1] * middle[1]).hi,
        });
        let other = |k: usize, v: &WideVertex, [z, complement]: [DoubleDouble; 2]| Corner {
            gradient: gradients[k].map(|g| g.hi),
            base: base[k],
            w: v.clip[3].hi,
            z: z.hi,
            complement: complement.hi,
        };
        let plane = FacePlane {
            origin: if is_near { middle.map(|v| v.hi) } else { [0.0; 2] },
            inv_w: 1.0 / w0.hi,
            z: (z0 / w0).hi,
            complement: (v0.complement / w0).hi,
            others: [other(0, v1, depths1), other(1, v2, depths2)],
            w: w0.hi,
            order,
            in_front: wide.iter().all(|v| v.clip[3].is_positive()),
        };
        (det.hi != 0.0 && plane.is_finite()).then_some(plane)
    }
}
