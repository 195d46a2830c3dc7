//! Tube around the (2,3) torus knot: the mesh of the benchmarks.
//!
//! The knot's curve winds 2 times around z and 3 times around the torus's tube, for u in [0, 4 pi):
//!
//! ```text
//! c(u) = R/2 ( (2 + cos(3u/2)) cos u,  (2 + cos(3u/2)) sin u,  sin(3u/2) )        R = 1
//! ```
//!
//! The frame across the curve is computed as in most knot generators, from a chord:
//!
//! ```text
//! T = c(u + 0.01) - c(u)    S = c(u + 0.01) + c(u)    B = T x S    N = B x T, both normalised
//! point at angle v of the tube = c(u) - r cos(v) N + r sin(v) B, r = 0.3
//! ```
//!
//! The normal is the direction from c(u) to the point. Texture coordinates repeat 8 times along the
//! knot and twice around the tube.

use super::{Counts, MAX_FACES, ShapeError, corner};
use crate::math::matrix::unit;
use crate::scene::{Corner, Mesh, NONE};
use glam::{DVec2, DVec3};
use std::f64::consts::PI;

const TUBE_RADIUS: f64 = 0.3;
const CHORD_RAD: f64 = 0.01;

fn curve(u: f64) -> DVec3 {
    let (sin, cos) = libm::sincos(1.5 * u);
    let reach = (2.0 + cos) * 0.5;
    DVec3::new(reach * libm::cos(u), reach * libm::sin(u), sin * 0.5)
}

/// Returns the lengths of the arrays of a knot's mesh.
fn counts(nu: u32, nv: u32) -> Counts {
    let [nu, nv] = [nu, nv].map(u64::from);
    let quads = nu.saturating_mul(nv);
    Counts {
        positions: quads,
        normals: quads,
        texcoords: (nu + 1).saturating_mul(nv + 1),
        corners: quads.saturating_mul(6),
        polygons: quads.saturating_mul(2),
        triangles: quads.saturating_mul(2),
    }
}

/// Returns the bytes that [`knot`] allocates: the mesh, whose arrays are created at their full
/// size.
pub fn knot_bytes(nu: u32, nv: u32) -> u64 {
    counts(nu, nv).bytes()
}

/// Creates the torus knot (2,3) with R = 1 and tube radius 0.3, `nu` steps along the knot and `nv`
/// around the tube: 2 nu nv triangles.
///
/// # Errors
/// If either count is below 3, or there are more than [`MAX_FACES`] triangles.
pub fn knot(nu: u32, nv: u32) -> Result<Mesh, ShapeError> {
    for (what, value) in [("knot nu", nu), ("knot nv", nv)] {
        if value < 3 {
            return Err(ShapeError::TooCoarse { what, value, least: 3 });
        }
    }
    let faces = (u64::from(nu) * u64::from(nv)).saturating_mul(2);
    if faces > MAX_FACES {
        return Err(ShapeError::TooFine { faces });
    }
    let mut mesh = counts(nu, nv).empty_mesh();
    for i in 0..nu {
        let u = f64::from(i) / f64::from(nu) * 4.0 * PI;
        let (here, ahead) = (curve(u), curve(u + CHORD_RAD));
        let tangent = ahead - here;
        // The chord is never 0 and never parallel to the mean radius: the curve stays 0.5 away from
        // the z axis.
        let across = unit(tangent.cross(ahead + here)).expect("the chord and the radius span a plane");
        let outward = unit(across.cross(tangent)).expect("two vectors at right angles");
        for j in 0..nv {
            let (sin, cos) = libm::sincos(f64::from(j) / f64::from(nv) * 2.0 * PI);
            let offset = outward * (-TUBE_RADIUS * cos) + across * (TUBE_RADIUS * sin);
            mesh.positions.push(here + offset);
            mesh.normals.push(unit(offset).expect("an offset is 0.3 long"));
        }
    }
    for i in 0..=nu {
        let s = f64::from(i) / f64::from(nu) * 8.0;
        mesh.texcoords.extend((0..=nv).map(|j| DVec2::new(s, f64::from(j) / f64::from(nv) * 2.0)));
    }
    let at = |i: u32, j: u32| -> Corner {
        let vertex = (i % nu) * nv + j % nv;
        corner(vertex, i * (nv + 1) + j, vertex)
    };
    for i in 0..nu {
        for j in 0..nv {
            let (a, b, c, d) = (at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
            mesh.push_polygon(&[a, b, d], NONE);
            mesh.push_polygon(&[b, c, d], NONE);
        }
    }
    Ok(mesh)
}
