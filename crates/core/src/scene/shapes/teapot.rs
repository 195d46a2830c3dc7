//! Newell's teapot, tessellated from its Bezier patches.
//!
//! A patch with control points p[i][j] is S(s,t) = sum B_i(s) B_j(t) p[i][j], with the cubic
//! Bernstein polynomials B. In Newell's order dS/dt x dS/ds points outwards, in every patch. Where
//! the whole edge s = 0 is one point (the top of the lid's knob, the middle of the base) dS/dt
//! vanishes along it, and near it grows as s d2S/dsdt: the normal's limit is d2S/dsdt x dS/ds.
//! Newell's z is up; here y is: (x, y, z) -> (x, z, -y), so that the spout points to +x, the base
//! lies at y = 0, and the lid ends at y = 3.15.

use super::newell::{PATCHES, POINTS};
use super::{Counts, ShapeError, corner};
use crate::math::matrix::unit;
use crate::scene::{Corner, Mesh, NONE};
use glam::{DVec2, DVec3};
use std::collections::HashMap;

/// Default number of steps along each side of a patch.
pub const DEFAULT_TEAPOT_LEVEL: u32 = 10;
/// Largest level: 32 patches of 256 x 256 quads.
pub const MAX_TEAPOT_LEVEL: u32 = 256;

/// Number of Newell's patches.
const PATCH_COUNT: u64 = 32;
/// Number of curves that bound the patches: one between two patches counts once, a pole not at all.
const CURVES: u64 = 68;
/// Number of points that these curves join.
const JOINTS: u64 = 37;
/// Number of patch sides that are a pole.
const POLES: u64 = 8;

/// Returns the lengths of the arrays of the mesh of `level`.
fn counts(level: u32) -> Counts {
    let (level, inside) = (u64::from(level), u64::from(level.saturating_sub(1)));
    let squares = level.saturating_mul(level).saturating_mul(PATCH_COUNT);
    let grid = (level + 1).saturating_mul(level + 1);
    let at_poles = POLES * level;
    Counts {
        positions: inside
            .saturating_mul(inside)
            .saturating_mul(PATCH_COUNT)
            .saturating_add(CURVES * inside + JOINTS),
        normals: grid.saturating_mul(PATCH_COUNT),
        texcoords: grid,
        corners: squares.saturating_mul(4).saturating_sub(at_poles),
        polygons: squares,
        triangles: squares.saturating_mul(2).saturating_sub(at_poles),
    }
}

/// Returns the bytes that [`teapot`] allocates: the mesh, whose arrays are created at their full
/// size, the points of one patch, and the points of all curves, in tables that may have twice their
/// capacity and be copied while they grow.
pub fn teapot_bytes(level: u32) -> u64 {
    let grid = (u64::from(level) + 1).saturating_mul(u64::from(level) + 1);
    let on_curves = CURVES.saturating_mul(level.into()) + JOINTS;
    let beside = grid
        .saturating_mul(3 * size_of::<Corner>() as u64)
        .saturating_add(on_curves.saturating_mul(4 * size_of::<(SharedVertex, u32)>() as u64));
    counts(level).bytes().saturating_add(beside).saturating_add(4096)
}

/// Returns the four Bernstein polynomials of degree 3 at `t`.
fn bernstein(t: f64) -> [f64; 4] {
    let s = 1.0 - t;
    [s * s * s, 3.0 * s * s * t, 3.0 * s * t * t, t * t * t]
}

/// Returns the derivatives of the Bernstein polynomials at `t`.
fn bernstein_slope(t: f64) -> [f64; 4] {
    let s = 1.0 - t;
    [-3.0 * s * s, 3.0 * s * s - 6.0 * s * t, 6.0 * s * t - 3.0 * t * t, 3.0 * t * t]
}

/// Returns the first number of an equal point: where parts meet, Newell's table repeats points
/// under new numbers.
fn first_number(number: u16) -> u16 {
    let point = POINTS[number as usize - 1];
    let first = POINTS.iter().position(|p| *p == point).expect("a point equals itself");
    first as u16 + 1
}

type Control = [[DVec3; 4]; 4];

fn control_points(patch: &[u16; 16]) -> Control {
    let point = |number: u16| {
        let [x, y, z] = POINTS[number as usize - 1];
        // Not -y: a zero keeps its sign.
        DVec3::new(x, z, 0.0 - y)
    };
    std::array::from_fn(|i| std::array::from_fn(|j| point(patch[4 * i + j])))
}

fn sum(control: &Control, a: [f64; 4], b: [f64; 4]) -> DVec3 {
    let row =
        |i: usize| control[i][0] * b[0] + control[i][1] * b[1] + control[i][2] * b[2] + control[i][3] * b[3];
    row(0) * a[0] + row(1) * a[1] + row(2) * a[2] + row(3) * a[3]
}

/// Returns the outward unit normal.
fn normal(control: &Control, s: f64, t: f64) -> DVec3 {
    let along_s = sum(control, bernstein_slope(s), bernstein(t));
    let is_pole = s == 0.0 && control[0].iter().all(|p| *p == control[0][0]);
    let b = if is_pole { bernstein_slope(s) } else { bernstein(s) };
    let along_t = sum(control, b, bernstein_slope(t));
    unit(along_t.cross(along_s))
        .expect("the patches have a tangent plane at each of their points, the poles included")
}

/// Key of a vertex on an edge, by which the adjacent patch finds it.
#[derive(PartialEq, Eq, Hash)]
enum SharedVertex {
    /// Control point with this number.
    Corner(u16),
    /// Step k along the edge with these control points, from its lower-numbered end.
    Edge([u16; 4], u32),
}

/// Returns the grid point (i, j) of `level`, with its key if it lies on an edge of its patch.
fn place(patch: &[u16; 16], control: &Control, i: u32, j: u32, level: u32) -> (Option<SharedVertex>, DVec3) {
    let f = |k: u32| f64::from(k) / f64::from(level);
    let (edge, mut k) = match (i, j) {
        (0, k) => ([0, 1, 2, 3], k),
        (i, k) if i == level => ([12, 13, 14, 15], k),
        (k, 0) => ([0, 4, 8, 12], k),
        (k, j) if j == level => ([3, 7, 11, 15], k),
        _ => return (None, sum(control, bernstein(f(i)), bernstein(f(j)))),
    };
    let mut numbers: [u16; 4] = edge.map(|e: usize| patch[e]);
    let mut points: [DVec3; 4] = edge.map(|e| control[e / 4][e % 4]);
    if numbers.iter().all(|n| *n == numbers[0]) {
        return (Some(SharedVertex::Corner(numbers[0])), points[0]);
    }
    // The same direction for both patches at an edge, so that both compute the same bits.
    if numbers[0] > numbers[3] {
        numbers.reverse();
        points.reverse();
        k = level - k;
    }
    if k == 0 {
        (Some(SharedVertex::Corner(numbers[0])), points[0])
    } else if k == level {
        (Some(SharedVertex::Corner(numbers[3])), points[3])
    } else {
        let b = bernstein(f(k));
        let point = points[0] * b[0] + points[1] * b[1] + points[2] * b[2] + points[3] * b[3];
        (Some(SharedVertex::Edge(numbers, k)), point)
    }
}

/// Creates the teapot, each of its 32 patches cut into `level` x `level` quads (triangles where an
/// edge is a point): 64 level^2 - 8 level triangles.
///
/// Normals are those of the patches. Each patch has the whole texture once, upright on the body.
///
/// # Errors
/// If `level` is not in 1..=[`MAX_TEAPOT_LEVEL`].
pub fn teapot(level: u32) -> Result<Mesh, ShapeError> {
    if level == 0 {
        return Err(ShapeError::TooCoarse { what: "teapot level", value: level, least: 1 });
    }
    if level > MAX_TEAPOT_LEVEL {
        return Err(ShapeError::TooFine { faces: u64::from(level).pow(2).saturating_mul(64) });
    }
    let mut mesh = counts(level).empty_mesh();
    let mut on_edges: HashMap<SharedVertex, u32> = HashMap::new();
    let f = |k: u32| f64::from(k) / f64::from(level);
    for i in 0..=level {
        mesh.texcoords.extend((0..=level).map(|j| DVec2::new(1.0 - f(j), 1.0 - f(i))));
    }
    let mut grid = Vec::new();
    for patch in &PATCHES {
        let patch = &patch.map(first_number);
        let control = control_points(patch);
        grid.clear();
        for i in 0..=level {
            for j in 0..=level {
                let (key, position) = place(patch, &control, i, j, level);
                let next = mesh.positions.len() as u32;
                let vertex = key.map_or(next, |key| *on_edges.entry(key).or_insert(next));
                if vertex == next {
                    mesh.positions.push(position);
                }
                grid.push(corner(vertex, i * (level + 1) + j, mesh.normals.len() as u32));
                mesh.normals.push(normal(&control, f(i), f(j)));
            }
        }
        let at = |i: u32, j: u32| grid[(i * (level + 1) + j) as usize];
        for i in 0..level {
            for j in 0..level {
                let quad = [at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)];
                // At a pole the first two corners are one vertex: normal and texture coordinate
                // come from the first.
                match quad[0].position == quad[1].position {
                    true => mesh.push_polygon(&[quad[0], quad[2], quad[3]], NONE),
                    false => mesh.push_polygon(&quad, NONE),
                }
            }
        }
    }
    Ok(mesh)
}
