//! X3D's Sphere, Cone and Cylinder: bodies of revolution about y, with smooth normals.
//!
//! The texture of the side begins at the back (-z) and runs counter-clockwise seen from above: u =
//! a / 2 pi at x = -sin a, z = -cos a; v runs from the bottom, 0, to the top, 1.

use super::{ShapeError, corner, length};
use crate::scene::{Corner, Mesh, NONE};
use glam::{DVec2, DVec3};
use std::f64::consts::PI;

/// Steps around the axis. The outline deviates by at most 0.06 % of the radius (1 - cos(pi / 96)).
const SLICES: u32 = 96;
/// Steps of the sphere from pole to pole.
const STACKS: u32 = 48;

/// Parts of a cone or cylinder to create (X3D's `side`, `bottom`, `top`; a cone has no top).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct RevolvedParts {
    /// True if the round side exists.
    pub side: bool,
    /// True if the cap at the lower end exists.
    pub bottom: bool,
    /// True if the cap at the upper end exists.
    pub top: bool,
}

impl RevolvedParts {
    /// All parts.
    pub const ALL: RevolvedParts = RevolvedParts { side: true, bottom: true, top: true };
}

/// Returns sine and cosine of 2 pi k / n, n a multiple of 4: exact on the axes, and symmetric in
/// all quadrants.
fn circle(k: u32, n: u32) -> (f64, f64) {
    let (quadrant, rest) = (k / (n / 4) % 4, k % (n / 4));
    let (sin, cos) = libm::sincos(2.0 * PI * f64::from(rest) / f64::from(n));
    match quadrant {
        0 => (sin, cos),
        1 => (cos, -sin),
        2 => (-sin, -cos),
        _ => (-cos, sin),
    }
}

/// Returns the horizontal unit vector at slice `k` of `n`, from the back, counter-clockwise seen
/// from above.
fn around(k: u32, n: u32) -> DVec3 {
    let (sin, cos) = circle(k, n);
    DVec3::new(-sin, 0.0, -cos)
}

/// Creates a sphere of `radius` about the origin.
///
/// # Errors
/// If the radius is not positive and finite.
pub fn sphere(radius: f64) -> Result<Mesh, ShapeError> {
    let radius = length("sphere radius", radius)?;
    let mut mesh = Mesh::default();
    // Ring j runs from the lower pole (0) to the upper one (STACKS); a pole is one position.
    let ring_start = |j: u32| if j == 0 { 0 } else { 1 + (j - 1) * SLICES };
    for j in 0..=STACKS {
        let (sin, cos) = circle(j, 2 * STACKS);
        match j {
            0 => mesh.normals.push(DVec3::NEG_Y),
            STACKS => mesh.normals.push(DVec3::Y),
            _ => mesh.normals.extend((0..SLICES).map(|i| around(i, SLICES) * sin - DVec3::Y * cos)),
        }
    }
    mesh.positions = mesh.normals.iter().map(|n| *n * radius).collect();
    for j in 0..=STACKS {
        // At a pole every slice has the u of its own middle; elsewhere slice SLICES closes the
        // ring.
        let shift = if j == 0 || j == STACKS { 0.5 } else { 0.0 };
        let v = f64::from(j) / f64::from(STACKS);
        mesh.texcoords
            .extend((0..=SLICES).map(|i| DVec2::new((f64::from(i) + shift) / f64::from(SLICES), v)));
    }
    let at = |j: u32, i: u32| -> Corner {
        let is_pole = j == 0 || j == STACKS;
        let position = ring_start(j) + if is_pole { 0 } else { i % SLICES };
        corner(position, j * (SLICES + 1) + i, position)
    };
    for j in 0..STACKS {
        for i in 0..SLICES {
            let quad = [at(j, i), at(j, i + 1), at(j + 1, i + 1), at(j + 1, i)];
            match j {
                0 => mesh.push_polygon(&[quad[0], quad[2], quad[3]], NONE),
                _ if j + 1 == STACKS => mesh.push_polygon(&[quad[0], quad[1], quad[3]], NONE),
                _ => mesh.push_polygon(&quad, NONE),
            }
        }
    }
    Ok(mesh)
}

/// Creates a whole cone: see [`cone_parts`].
pub fn cone(bottom_radius: f64, height: f64) -> Result<Mesh, ShapeError> {
    cone_parts(bottom_radius, height, RevolvedParts::ALL)
}

/// Creates a cone about y: its base of `bottom_radius` at -height/2, its apex at +height/2.
/// `parts.top` is ignored.
///
/// The normal of the side at angle a is (height * around(a) + radius * y), normalised; at the apex
/// each face uses the normal at its own middle.
///
/// # Errors
/// If a length is not positive and finite.
pub fn cone_parts(bottom_radius: f64, height: f64, parts: RevolvedParts) -> Result<Mesh, ShapeError> {
    let (r, h) = (length("cone radius", bottom_radius)?, length("cone height", height)?);
    let mut mesh = Mesh::default();
    let half = h / 2.0;
    if parts.side {
        // Scaled first, so that no square overflows or underflows.
        let larger = r.max(h);
        let (rise, run) = (r / larger, h / larger);
        let norm = (rise * rise + run * run).sqrt();
        let slope = |out: DVec3| (out * run + DVec3::Y * rise) / norm;
        mesh.positions.extend((0..SLICES).map(|i| around(i, SLICES) * r - DVec3::Y * half));
        mesh.positions.push(DVec3::Y * half);
        mesh.normals.extend((0..SLICES).map(|i| slope(around(i, SLICES))));
        mesh.normals.extend((0..SLICES).map(|i| slope(around(2 * i + 1, 2 * SLICES))));
        let u = |i: u32, shift: f64| (f64::from(i) + shift) / f64::from(SLICES);
        mesh.texcoords.extend((0..=SLICES).map(|i| DVec2::new(u(i, 0.0), 0.0)));
        mesh.texcoords.extend((0..SLICES).map(|i| DVec2::new(u(i, 0.5), 1.0)));
        for i in 0..SLICES {
            let next = (i + 1) % SLICES;
            let face =
                [corner(i, i, i), corner(next, i + 1, next), corner(SLICES, SLICES + 1 + i, SLICES + i)];
            mesh.push_polygon(&face, NONE);
        }
    }
    if parts.bottom {
        cap(&mut mesh, r, -half);
    }
    Ok(mesh)
}

/// Creates a whole cylinder: see [`cylinder_parts`].
pub fn cylinder(radius: f64, height: f64) -> Result<Mesh, ShapeError> {
    cylinder_parts(radius, height, RevolvedParts::ALL)
}

/// Creates a cylinder of `radius` about y, from -height/2 to +height/2.
///
/// # Errors
/// If a length is not positive and finite.
pub fn cylinder_parts(radius: f64, height: f64, parts: RevolvedParts) -> Result<Mesh, ShapeError> {
    let (r, h) = (length("cylinder radius", radius)?, length("cylinder height", height)?);
    let mut mesh = Mesh::default();
    let half = h / 2.0;
    if parts.side {
        mesh.normals.extend((0..SLICES).map(|i| around(i, SLICES)));
        for y in [-half, half] {
            mesh.positions.extend((0..SLICES).map(|i| around(i, SLICES) * r + DVec3::Y * y));
        }
        for v in [0.0, 1.0] {
            mesh.texcoords.extend((0..=SLICES).map(|i| DVec2::new(f64::from(i) / f64::from(SLICES), v)));
        }
        for i in 0..SLICES {
            let next = (i + 1) % SLICES;
            let face = [
                corner(i, i, i),
                corner(next, i + 1, next),
                corner(SLICES + next, SLICES + 1 + i + 1, next),
                corner(SLICES + i, SLICES + 1 + i, i),
            ];
            mesh.push_polygon(&face, NONE);
        }
    }
    if parts.top {
        cap(&mut mesh, r, half);
    }
    if parts.bottom {
        cap(&mut mesh, r, -half);
    }
    Ok(mesh)
}

/// Adds a disc at height `y`, facing away from the origin, with the inscribed circle of the
/// texture. Texture up is -z on the upper cap, +z on the lower one. The disc shares the positions
/// of the side's rim if there are any.
fn cap(mesh: &mut Mesh, r: f64, y: f64) {
    let up = if y > 0.0 { -1.0 } else { 1.0 };
    let normal = mesh.normals.len() as u32;
    mesh.normals.push(DVec3::Y * y.signum());
    let first_texcoord = mesh.texcoords.len() as u32;
    mesh.texcoords.extend((0..SLICES).map(|i| {
        let d = around(i, SLICES);
        DVec2::new(0.5 + d.x / 2.0, 0.5 + up * d.z / 2.0)
    }));
    let rim = around(0, SLICES) * r + DVec3::Y * y;
    let first = match mesh.positions.iter().position(|p| *p == rim) {
        Some(first) => first as u32,
        None => {
            let first = mesh.positions.len() as u32;
            mesh.positions.extend((0..SLICES).map(|i| around(i, SLICES) * r + DVec3::Y * y));
            first
        }
    };
    let mut polygon: Vec<Corner> =
        (0..SLICES).map(|i| corner(first + i, first_texcoord + i, normal)).collect();
    if y < 0.0 {
        polygon.reverse();
    }
    mesh.push_polygon(&polygon, NONE);
}
