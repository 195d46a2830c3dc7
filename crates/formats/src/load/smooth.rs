//! Vertex normals for faces without normals: smooth across edges that are not sharp.
//!
//! In: a mesh, the smoothing group of each polygon, and the crease angle, the largest angle between
//! the normals of two faces that are smoothed together, or none: then it is chosen by the mesh's own
//! angles. Out: one normal for each group of smooth corners; and whether backs of its faces can be
//! seen. Runs on the thread that reads the file; sums are taken in the file's order, so the same file
//! gives the same bits.
//!
//! Equal positions are one vertex (files split them where texture coordinates differ). Corners of a
//! vertex are smoothed together if their faces meet at an edge whose angle is no larger than the
//! limit and, if the file has smoothing groups (`s`), both are in the same one; `s off` joins
//! nothing. Faces joined by a chain of such edges form one group; its normal is the mean of the
//! faces' unit normals weighted by the faces' angles at the vertex (Thurmer and Wuthrich 1998:
//! independent of how faces are triangulated). An error would show as a seam on the teapot or as a
//! rounded box (`tests/files/smoothing.rs`).

use fbptr_core::math::matrix::unit;
use fbptr_core::pipeline::polygon_normal;
use fbptr_core::scene::{Corner, Mesh, NONE, Polygon};
use glam::DVec3;
use std::cmp::Reverse;
use std::collections::HashMap;
use std::f64::consts::TAU;
use std::ops::Range;

/// Smoothing group of faces before the first `s`: the angle alone decides.
pub(super) const UNGROUPED: u32 = u32::MAX;

/// Number of faces at one edge up to which all pairs are compared; beyond it, each face only with
/// the one before it.
const MAX_FACES_AT_EDGE: usize = 16;

/// Bytes of the tables per corner, and per position.
const CORNER_BYTES: u64 = 96;
const POSITION_BYTES: u64 = 32;

/// Bytes per position while equal ones are found, before the other tables exist: the hash table has
/// up to 16/7 entries of 33 bytes for each, the result 4.
const WELDING_BYTES: u64 = 80;

/// Returns the working memory in bytes that smoothing a mesh needs.
pub(super) fn working_bytes(mesh: &Mesh) -> u64 {
    let of_corners = (mesh.corners.len() + mesh.polygons.len()) as u64 * CORNER_BYTES;
    let positions = mesh.positions.len() as u64;
    (positions * WELDING_BYTES).max(of_corners + positions * POSITION_BYTES)
}

/// One side of a polygon: its two vertices, the lower index first, and the corners at them.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Edge {
    vertices: [u32; 2],
    polygon: u32,
    corners: [u32; 2],
    /// Set if the polygon runs from the lower index to the higher.
    is_forward: bool,
}

/// Crease angle in degrees of a mesh that has no edge near it: sides of a cylinder of 13 or more are
/// smooth, an icosahedron (42 degrees) and chamfers of 45 degrees are not.
const USUAL_DEG: usize = 30;
/// Crease angles in degrees that may be chosen.
const CHOICE_DEG: Range<usize> = 27..39;
/// Angle in degrees by which edges are to differ from the crease angle: those of one round body
/// differ among each other by what the file's numbers have been rounded by, and more.
const APART_DEG: usize = 2;

/// Returns whether the faces at one edge are those of a surface with an inside: as many run along
/// it one way as the other. A single face is a rim; two that run the same way have one of them
/// turned inside out.
fn is_balanced(faces: &[Edge]) -> bool {
    2 * faces.iter().filter(|edge| edge.is_forward).count() == faces.len()
}

/// Returns whether the volume that the faces enclose is negative: all are turned inside out. Taken
/// relative to one of their points, so that coordinates far from the origin keep their digits.
fn is_inside_out(mesh: &Mesh) -> bool {
    let Some(origin) = mesh.corners.first().map(|c| mesh.positions[c.position as usize]) else {
        return false;
    };
    let at = |corner: u32| mesh.positions[mesh.corners[corner as usize].position as usize] - origin;
    let volumes = mesh.triangles.iter().map(|t| t.map(at)).map(|[a, b, c]| a.dot(b.cross(c)));
    let (sum, size) = volumes.fold((0.0, 0.0), |(sum, size): (f64, f64), v| (sum + v, size + v.abs()));
    // Faces that enclose nothing leave a rounding error.
    sum < -1e-9 * size
}

/// Computes normals for the corners that have none; without a crease angle one is chosen. Returns
/// whether backs of faces can be seen: the surface is open, or faces of it are turned inside out.
pub(super) fn smooth(mesh: &mut Mesh, groups: &[u32], max_angle_rad: Option<f64>) -> bool {
    let vertices = welded(&mesh.positions);
    let edges = edges(mesh, &vertices);
    let is_open = !edges.chunk_by(|a, b| a.vertices == b.vertices).all(is_balanced) || is_inside_out(mesh);
    let normals: Vec<Option<DVec3>> = mesh.polygons.iter().map(|p| normal_of(mesh, p)).collect();
    let max_angle_rad = max_angle_rad.unwrap_or_else(|| crease_angle(&edges, &normals));
    let mut joined: Vec<u32> = (0..mesh.corners.len() as u32).collect();
    // cos falls as the angle grows; the margin of a rounding error keeps edges at exactly the limit
    // smooth.
    let least_cos = libm::cos(max_angle_rad) - 1e-12;
    let is_smooth = |a: &Edge, b: &Edge| {
        let [a, b] = [a.polygon, b.polygon].map(|p| p as usize);
        let group = groups.get(a).copied().unwrap_or(UNGROUPED);
        let is_grouped = group != 0 && group == groups.get(b).copied().unwrap_or(UNGROUPED);
        match (normals[a], normals[b]) {
            (Some(a), Some(b)) => is_grouped && a.dot(b) >= least_cos,
            _ => false,
        }
    };
    for faces in edges.chunk_by(|a, b| a.vertices == b.vertices) {
        for (i, a) in faces.iter().enumerate() {
            let others = if faces.len() > MAX_FACES_AT_EDGE {
                i + 1..(i + 2).min(faces.len())
            } else {
                i + 1..faces.len()
            };
            // The normal of a face that is turned inside out is no neighbour's.
            let is_neighbour =
                |b: &&Edge| (faces.len() > 2 || a.is_forward != b.is_forward) && is_smooth(a, b);
            for b in faces[others].iter().filter(is_neighbour) {
                (0..2).for_each(|end| join(&mut joined, a.corners[end], b.corners[end]));
            }
        }
    }
    give_normals(mesh, &normals, &mut joined);
    is_open
}

/// Returns the crease angle in radians, of whole degrees, from which the fewest edges of two faces
/// differ by less than [`APART_DEG`]; of several the one nearest to [`USUAL_DEG`], the greater one of
/// two.
fn crease_angle(edges: &[Edge], normals: &[Option<DVec3>]) -> f64 {
    // Number of edges by whole degrees.
    let mut counts = [0u64; CHOICE_DEG.end + APART_DEG];
    for faces in edges.chunk_by(|a, b| a.vertices == b.vertices) {
        let [a, b] = faces else { continue };
        if let (Some(a), Some(b)) = (normals[a.polygon as usize], normals[b.polygon as usize]) {
            let degrees = libm::acos(a.dot(b).clamp(-1.0, 1.0)).to_degrees();
            if let Some(count) = counts.get_mut(degrees as usize) {
                *count += 1;
            }
        }
    }
    let near = |deg: &usize| -> u64 { counts[deg - APART_DEG..deg + APART_DEG].iter().sum() };
    let best = CHOICE_DEG.min_by_key(|deg| (near(deg), deg.abs_diff(USUAL_DEG), Reverse(*deg)));
    (best.unwrap_or(USUAL_DEG) as f64).to_radians()
}

/// Returns the vertex of each position: the lowest index of an equal position.
fn welded(positions: &[DVec3]) -> Vec<u32> {
    let mut first = HashMap::with_capacity(positions.len());
    // Adding 0 turns -0 into 0.
    let key = |p: &DVec3| (*p + DVec3::ZERO).to_array().map(f64::to_bits);
    (0..).zip(positions).map(|(i, p)| *first.entry(key(p)).or_insert(i)).collect()
}

fn corners_of<'a>(mesh: &'a Mesh, polygon: &Polygon) -> &'a [Corner] {
    &mesh.corners[polygon.first_corner as usize..][..polygon.corner_count as usize]
}

/// Returns the unit normal of a polygon; `None` if it has no area.
fn normal_of(mesh: &Mesh, polygon: &Polygon) -> Option<DVec3> {
    polygon_normal(corners_of(mesh, polygon).iter().map(|c| mesh.positions[c.position as usize]))
}

/// Returns the sides of all polygons, sorted by edge. A side between equal positions is left out.
fn edges(mesh: &Mesh, vertices: &[u32]) -> Vec<Edge> {
    let mut edges = Vec::with_capacity(mesh.corners.len());
    for (polygon, p) in (0..).zip(&mesh.polygons) {
        for k in 0..p.corner_count {
            let corners = [k, (k + 1) % p.corner_count].map(|k| p.first_corner + k);
            let [a, b] = corners.map(|c| vertices[mesh.corners[c as usize].position as usize]);
            match a.cmp(&b) {
                std::cmp::Ordering::Less => {
                    edges.push(Edge { vertices: [a, b], polygon, corners, is_forward: true });
                }
                std::cmp::Ordering::Greater => {
                    let corners = [corners[1], corners[0]];
                    edges.push(Edge { vertices: [b, a], polygon, corners, is_forward: false });
                }
                std::cmp::Ordering::Equal => {}
            }
        }
    }
    edges.sort_unstable();
    edges
}

/// Returns the representative of a corner's group (union-find with path halving).
fn group_of(joined: &mut [u32], mut corner: u32) -> u32 {
    while joined[corner as usize] != corner {
        let next = joined[joined[corner as usize] as usize];
        joined[corner as usize] = next;
        corner = next;
    }
    corner
}

/// Joins the groups of two corners; the lowest corner represents them.
fn join(joined: &mut [u32], a: u32, b: u32) {
    let (a, b) = (group_of(joined, a), group_of(joined, b));
    joined[a.max(b) as usize] = a.min(b);
}

/// Sums the faces' normals over each group of corners, and stores the means in the mesh.
fn give_normals(mesh: &mut Mesh, normals: &[Option<DVec3>], joined: &mut [u32]) {
    let needs = |c: &Corner| c.normal == NONE;
    let mut sums = vec![DVec3::ZERO; mesh.corners.len()];
    for (p, normal) in mesh.polygons.iter().zip(normals) {
        let (Some(normal), count) = (*normal, p.corner_count as usize) else { continue };
        let corners = corners_of(mesh, p);
        let at = |k: usize| mesh.positions[corners[k % count].position as usize];
        for k in 0..count {
            let group = group_of(joined, p.first_corner + k as u32);
            sums[group as usize] += normal * angle(at(k), at(k + count - 1), at(k + 1), normal);
        }
    }
    let mut number_of = vec![NONE; mesh.corners.len()];
    for (p, normal) in mesh.polygons.iter().zip(normals) {
        let Some(normal) = *normal else { continue };
        for c in p.first_corner..p.first_corner + p.corner_count {
            if !needs(&mesh.corners[c as usize]) {
                continue;
            }
            let group = group_of(joined, c) as usize;
            if number_of[group] == NONE {
                number_of[group] = mesh.normals.len() as u32;
                mesh.normals.push(unit(sums[group]).unwrap_or(normal));
            }
            mesh.corners[c as usize].normal = number_of[group];
        }
    }
}

/// Returns the interior angle of a face at `p`, between the sides to `before` and `after`, in
/// radians; more than half a turn at a reflex corner.
fn angle(p: DVec3, before: DVec3, after: DVec3, normal: DVec3) -> f64 {
    let (Some(a), Some(b)) = (unit(after - p), unit(before - p)) else { return 0.0 };
    let across = a.cross(b);
    let angle = libm::atan2(across.length(), a.dot(b));
    if across.dot(normal) < 0.0 { TAU - angle } else { angle }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::FRAC_PI_3;

    /// Returns a strip of squares along x, each turned from the one before by `turns` about z;
    /// corners have positions of their own.
    fn strip(turns: &[f64]) -> Mesh {
        let mut mesh = Mesh::default();
        let (mut at, mut heading) = (DVec3::ZERO, 0.0);
        for turn in std::iter::once(&0.0).chain(turns) {
            heading += turn;
            let next = at + DVec3::new(libm::cos(heading), libm::sin(heading), 0.0);
            let first = mesh.positions.len() as u32;
            mesh.positions.extend([at + DVec3::Z, next + DVec3::Z, next, at]);
            let corner = |k| Corner { position: first + k, normal: NONE, texcoord: NONE, color: NONE };
            mesh.push_polygon(&[0, 1, 2, 3].map(corner), NONE);
            at = next;
        }
        mesh
    }

    /// Returns the number of distinct normals at the corners of a mesh.
    fn count(mesh: &Mesh) -> usize {
        let used: std::collections::BTreeSet<u32> = mesh.corners.iter().map(|c| c.normal).collect();
        used.len()
    }

    #[test]
    fn edges_up_to_the_angle_are_smooth_and_sharper_ones_are_not() {
        for (turn, expected) in [(0.5, 6), (FRAC_PI_3, 6), (FRAC_PI_3 + 1e-6, 8), (-0.5, 6), (3.0, 8)] {
            let mut mesh = strip(&[turn]);
            // Two squares share an edge, which joins two pairs of the eight corners.
            assert!(smooth(&mut mesh, &[], Some(FRAC_PI_3)));
            assert_eq!(count(&mesh), expected, "{turn}");
        }
        let mut mesh = strip(&[0.5]);
        smooth(&mut mesh, &[], Some(FRAC_PI_3));
        let [a, b] = [1, 4].map(|c| mesh.normals[mesh.corners[c].normal as usize]);
        assert_eq!(a, b);
        assert!((a - DVec3::new(-libm::sin(0.25), libm::cos(0.25), 0.0)).length() < 1e-12, "{a}");
        assert_eq!(mesh.normals[mesh.corners[0].normal as usize], DVec3::Y);
    }

    #[test]
    fn a_crease_angle_is_chosen_where_the_mesh_has_few_edges() {
        let normals = |turns: &[f64]| {
            let mut mesh = strip(&turns.iter().map(|t: &f64| t.to_radians()).collect::<Vec<_>>());
            smooth(&mut mesh, &[], None);
            count(&mesh)
        };
        // Smooth edges leave two normals fewer each.
        let flat = |edges: usize| 4 * (edges + 1);
        assert_eq!(normals(&[29.0]), flat(1) - 2);
        assert_eq!(normals(&[32.5]), flat(1), "near 30, and above it");
        assert_eq!(normals(&[45.0, 45.0]), flat(2), "a chamfer");
        // The sides of a cylinder of 12, as far as numbers of 32 bits have rounded them.
        assert_eq!(normals(&[30.0, 29.999, 30.001, 30.0, 90.0]), flat(5) - 8);
        assert_eq!(normals(&[41.8, 41.8]), flat(2), "an icosahedron");
        // A surface with edges of all angles.
        assert!(normals(&(1..170).map(f64::from).collect::<Vec<_>>()) < flat(169) - 2 * 25);
    }

    #[test]
    fn smoothing_groups_part_what_the_angle_would_join() {
        for (groups, expected) in
            [([1, 1], 6), ([1, 2], 8), ([0, 0], 8), ([UNGROUPED, UNGROUPED], 6), ([UNGROUPED, 1], 8)]
        {
            let mut mesh = strip(&[0.5]);
            smooth(&mut mesh, &groups, Some(FRAC_PI_3));
            assert_eq!(count(&mesh), expected, "{groups:?}");
        }
        // A group does not smooth an edge sharper than the limit.
        let mut mesh = strip(&[1.5]);
        smooth(&mut mesh, &[1, 1], Some(FRAC_PI_3));
        assert_eq!(count(&mesh), 8);
    }

    #[test]
    fn a_mean_does_not_depend_on_how_faces_are_cut() {
        let corner = |position| Corner { position, normal: NONE, texcoord: NONE, color: NONE };
        let positions =
            [[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 0.], [0., 0., -1.], [1., 0., -1.]];
        let normal_at_0 = |faces: &[&[u32]]| {
            let mut mesh = Mesh { positions: positions.map(DVec3::from).to_vec(), ..Mesh::default() };
            faces
                .iter()
                .for_each(|f| mesh.push_polygon(&f.iter().map(|p| corner(*p)).collect::<Vec<_>>(), NONE));
            assert!(smooth(&mut mesh, &[], Some(2.0)));
            let at = mesh.corners.iter().find(|c| c.position == 0).unwrap();
            mesh.normals[at.normal as usize]
        };
        let whole = normal_at_0(&[&[0, 1, 2, 3], &[0, 4, 5, 1]]);
        for cut in [[[0, 1, 2], [0, 2, 3]], [[0, 1, 3], [1, 2, 3]]] {
            let found = normal_at_0(&[&cut[0], &cut[1], &[0, 4, 5, 1]]);
            assert!((found - whole).length() < 1e-12, "{found} is not {whole}");
        }
    }

    #[test]
    fn a_box_is_closed_and_keeps_its_edges() {
        let mut mesh = fbptr_core::scene::shapes::cuboid(DVec3::ONE).unwrap();
        mesh.normals.clear();
        mesh.corners.iter_mut().for_each(|c| c.normal = NONE);
        assert!(!smooth(&mut mesh, &[], Some(FRAC_PI_3)), "closed");
        for p in 0..mesh.polygons.len() {
            let normal = normal_of(&mesh, &mesh.polygons[p]).unwrap();
            assert!(mesh.polygon_corners(p).iter().all(|c| mesh.normals[c.normal as usize] == normal));
        }
    }

    #[test]
    fn a_face_turned_inside_out_shows_its_back() {
        let cuboid = || {
            let mut mesh = fbptr_core::scene::shapes::cuboid(DVec3::ONE).unwrap();
            mesh.normals.clear();
            mesh.corners.iter_mut().for_each(|c| c.normal = NONE);
            mesh
        };
        let reversed = |faces: &[usize]| {
            let whole = cuboid();
            let mut mesh = Mesh { positions: whole.positions.clone(), ..Mesh::default() };
            for p in 0..whole.polygons.len() {
                let mut corners = whole.polygon_corners(p).to_vec();
                if faces.contains(&p) {
                    corners.reverse();
                }
                mesh.push_polygon(&corners, NONE);
            }
            mesh
        };
        assert!(!smooth(&mut reversed(&[]), &[], Some(FRAC_PI_3)));
        for faces in [&[0][..], &[5], &[1, 2], &[0, 1, 2, 3, 4, 5]] {
            assert!(smooth(&mut reversed(faces), &[], Some(FRAC_PI_3)), "{faces:?}");
        }
        // Also far from the origin, where products of coordinates lose all their digits.
        let mut far = reversed(&[]);
        far.positions.iter_mut().for_each(|p| *p += DVec3::splat(1e7));
        assert!(!smooth(&mut far, &[], Some(FRAC_PI_3)));
    }

    #[test]
    fn many_faces_at_one_edge_take_time_by_their_number() {
        let corner = |position| Corner { position, normal: NONE, texcoord: NONE, color: NONE };
        let mut mesh = Mesh { positions: vec![DVec3::ZERO, DVec3::X], ..Mesh::default() };
        for i in 0..200_000 {
            mesh.positions.push(DVec3::new(0.0, 1.0, f64::from(i) * 1e-6));
            mesh.push_polygon(&[0, 1, i + 2].map(corner), NONE);
        }
        // All pairs would be 4e10: the test would hang.
        assert!(smooth(&mut mesh, &[], Some(FRAC_PI_3)));
        assert_eq!(mesh.corners[0].normal, mesh.corners[300_000].normal);
    }

    #[test]
    fn faces_without_area_get_no_normal_and_normals_of_the_file_stay() {
        let mut mesh = strip(&[0.1]);
        let p = mesh.positions.len() as u32;
        mesh.positions.extend([DVec3::ZERO, DVec3::X, DVec3::X * 2.0]);
        let corner = |position| Corner { position, normal: NONE, texcoord: NONE, color: NONE };
        mesh.push_polygon(&[p, p + 1, p + 2].map(corner), NONE);
        mesh.normals.push(DVec3::NEG_X);
        mesh.corners[0].normal = 0;
        smooth(&mut mesh, &[], Some(FRAC_PI_3));
        assert_eq!(mesh.normals[mesh.corners[0].normal as usize], DVec3::NEG_X);
        assert!(mesh.corners[8..].iter().all(|c| c.normal == NONE));
        assert!(mesh.corners[1..8].iter().all(|c| c.normal != NONE));
    }
}
