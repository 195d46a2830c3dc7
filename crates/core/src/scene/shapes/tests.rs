//! Properties of all generated meshes, and the shape of each.

use super::*;
use crate::math::polygon::newell_normal;
use std::collections::HashMap;

/// Checks that every index is valid, normals are unit vectors on the outside of their faces, and
/// every position is used.
fn check(mesh: &Mesh) {
    let mut used = vec![false; mesh.positions.len()];
    for (t, polygon) in mesh.triangles.iter().zip(&mesh.triangle_polygon) {
        let corners = t.map(|c| mesh.corners[c as usize]);
        assert!(corners.iter().all(|c| (c.texcoord as usize) < mesh.texcoords.len()));
        let n = newell_normal(&corners.map(|c| mesh.positions[c.position as usize]));
        for c in corners {
            used[c.position as usize] = true;
            let given = mesh.normals[c.normal as usize];
            assert!((given.length() - 1.0).abs() < 1e-14, "{given}");
            assert!(n.dot(given) > 0.0, "polygon {polygon}: face {n}, corner {given}");
        }
    }
    assert!(used.iter().all(|u| *u), "a position that no face uses");
}

/// Counts the uses of each directed edge between positions.
fn edges(mesh: &Mesh) -> HashMap<(u32, u32), u32> {
    let mut edges = HashMap::new();
    for p in &mesh.polygons {
        let at = |k: u32| mesh.corners[(p.first_corner + k % p.corner_count) as usize].position;
        for k in 0..p.corner_count {
            *edges.entry((at(k), at(k + 1))).or_insert(0) += 1;
        }
    }
    edges
}

/// Returns whether the surface is closed: every edge is used once in each direction.
fn is_closed(mesh: &Mesh) -> bool {
    let edges = edges(mesh);
    edges.iter().all(|(&(a, b), &n)| n == 1 && edges.get(&(b, a)) == Some(&1))
}

fn volume(mesh: &Mesh) -> f64 {
    mesh.triangles
        .iter()
        .map(|t| {
            let [a, b, c] = t.map(|i| mesh.positions[mesh.corners[i as usize].position as usize]);
            a.dot(b.cross(c)) / 6.0
        })
        .sum()
}

/// Returns the texture coordinate of the corners at `p` with this normal, all of which must agree.
fn at(mesh: &Mesh, p: DVec3, normal: DVec3) -> DVec2 {
    let found: Vec<DVec2> = mesh
        .corners
        .iter()
        .filter(|c| (mesh.positions[c.position as usize] - p).length() < 1e-12)
        .filter(|c| (mesh.normals[c.normal as usize] - normal).length() < 1e-12)
        .map(|c| mesh.texcoords[c.texcoord as usize])
        .collect();
    assert!(!found.is_empty() && found.iter().all(|t| (*t - found[0]).length() < 1e-12), "{p}: {found:?}");
    found[0]
}

#[test]
fn solids_are_closed_outward_and_of_the_right_volume() {
    use std::f64::consts::PI;
    let bodies = [
        (cuboid(DVec3::new(1.0, 2.0, 3.0)), 6.0, 12),
        (sphere(2.0), 4.0 / 3.0 * PI * 8.0, 2 * 96 * 47),
        (cone(1.0, 3.0), PI, 96 + 94),
        (cylinder(2.0, 3.0), 12.0 * PI, 2 * 96 + 2 * 94),
    ];
    for (mesh, exact, faces) in bodies {
        let mesh = mesh.unwrap();
        check(&mesh);
        assert!(is_closed(&mesh));
        assert_eq!(mesh.triangles.len(), faces);
        assert!((volume(&mesh) / exact - 1.0).abs() < 2e-3, "{} for {exact}", volume(&mesh));
    }
    let thin = cone(1e300, 1e-300).unwrap();
    assert!(thin.normals.iter().all(|n| (n.length() - 1.0).abs() < 1e-14));
}

#[test]
fn textures_lie_as_the_standard_says() {
    let b = cuboid(DVec3::splat(2.0)).unwrap();
    let p = DVec3::new;
    // Upright on the sides, seen from outside; the top with its upper edge at the back, the bottom
    // at the front.
    assert_eq!(at(&b, p(-1., -1., 1.), DVec3::Z), DVec2::ZERO);
    assert_eq!(at(&b, p(1., 1., -1.), DVec3::NEG_Z), DVec2::Y);
    assert_eq!(at(&b, p(1., -1., 1.), DVec3::X), DVec2::ZERO);
    assert_eq!(at(&b, p(-1., 1., 1.), DVec3::NEG_X), DVec2::ONE);
    assert_eq!(at(&b, p(-1., 1., -1.), DVec3::Y), DVec2::Y);
    assert_eq!(at(&b, p(1., -1., 1.), DVec3::NEG_Y), DVec2::ONE);
    // The sphere's seam is at the back; u runs to the right seen from the front.
    let s = sphere(3.0).unwrap();
    assert_eq!(at(&s, p(0., 0., 3.), DVec3::Z), DVec2::new(0.5, 0.5));
    assert_eq!(at(&s, p(3., 0., 0.), DVec3::X), DVec2::new(0.75, 0.5));
    // Caps have the inscribed circle: -z up on the top, +z up on the bottom.
    let c = cylinder(2.0, 2.0).unwrap();
    assert_eq!(at(&c, p(0., 1., 2.), DVec3::Y), DVec2::new(0.5, 0.0));
    assert_eq!(at(&c, p(2., 1., 0.), DVec3::Y), DVec2::new(1.0, 0.5));
    assert_eq!(at(&c, p(0., -1., 2.), DVec3::NEG_Y), DVec2::new(0.5, 1.0));
    assert_eq!(at(&c, p(-2., 1., 0.), DVec3::NEG_X), DVec2::new(0.25, 1.0));
    let k = cone(2.0, 2.0).unwrap();
    assert_eq!(at(&k, p(2., -1., 0.), DVec3::NEG_Y), DVec2::new(1.0, 0.5));
    let slope = DVec3::new(0.0, 1.0, 1.0).normalize();
    assert_eq!(at(&k, p(0., -1., 2.), slope), DVec2::new(0.5, 0.0));
}

#[test]
fn parts_can_be_left_out() {
    let none = RevolvedParts { side: false, bottom: false, top: false };
    assert!(cone_parts(1.0, 1.0, none).unwrap().triangles.is_empty());
    for (parts, faces) in [
        (RevolvedParts { side: true, ..none }, 192),
        (RevolvedParts { bottom: true, ..none }, 94),
        (RevolvedParts { top: true, ..none }, 94),
    ] {
        let mesh = cylinder_parts(1.0, 1.0, parts).unwrap();
        check(&mesh);
        assert_eq!(mesh.triangles.len(), faces);
    }
    assert_eq!(cone_parts(1.0, 1.0, RevolvedParts { side: true, ..none }).unwrap().triangles.len(), 96);
}

#[test]
fn the_teapot_is_newells() {
    for level in [1, 2, 3, 10, 33] {
        let mesh = teapot(level).unwrap();
        assert_eq!(mesh.triangles.len() as u32, 64 * level * level - 8 * level);
        assert!(mesh.normals.iter().all(|n| (n.length() - 1.0).abs() < 1e-14));
        // At lower levels the handle's inner and outer chords coincide.
        if level < 3 {
            continue;
        }
        if level > 9 {
            check(&mesh);
        }
        // No edge is used twice in one direction: all faces have the same orientation, and none is
        // drawn twice.
        assert!(edges(&mesh).values().all(|n| *n == 1));
    }
    let mesh = teapot(10).unwrap();
    let (lo, hi) = mesh.bounds().unwrap();
    assert_eq!((lo, DVec3::new(0.0, hi.y, hi.z)), (DVec3::new(-3.0, 0.0, -2.0), DVec3::new(0.0, 3.15, 2.0)));
    assert!((hi.x - 3.434).abs() < 1e-3);
    // Body, lid and base have their axis at x = z = 0; the normals at the poles are vertical.
    for (y, n) in [(3.15, DVec3::Y), (0.0, DVec3::NEG_Y)] {
        let pole = DVec3::new(0.0, y, 0.0);
        let poles: Vec<_> =
            mesh.corners.iter().filter(|c| mesh.positions[c.position as usize] == pole).collect();
        assert_eq!(poles.len(), 40);
        assert!(poles.iter().all(|c| (mesh.normals[c.normal as usize] - n).length() < 1e-15));
    }
    // The only open edges are the rims of the parts: body, lid, base, both ends of handle and
    // spout.
    let open = |mesh: &Mesh| {
        let edges = edges(mesh);
        edges.keys().filter(|&&(a, b)| !edges.contains_key(&(b, a))).count()
    };
    assert_eq!(open(&mesh), 10 * (4 + 4 + 2 + 2 + 2 + 2));
}

#[test]
fn the_knot_has_the_benchmarks_faces() {
    let mesh = knot(500, 70).unwrap();
    assert_eq!((mesh.triangles.len(), mesh.positions.len()), (70_000, 35_000));
    check(&mesh);
    assert!(is_closed(&mesh));
    assert_eq!(mesh.texcoords.last(), Some(&DVec2::new(8.0, 2.0)));
    // Computed from the formulas in another program, with another sine: steps (i, j), position,
    // normal.
    let worked = [
        (
            (0, 0),
            [1.2000091873831065, -0.0020999635629196808, -0.001049999281065043],
            [-0.9999693753896454, -0.006999878543065603, -0.0034999976035501434],
        ),
        (
            (123, 17),
            [-0.8253382927586732, -0.053497624052407766, -0.74594494425966],
            [0.45260943865144665, -0.3394985674665731, -0.8245516470978438],
        ),
        (
            (499, 69),
            [1.2005271609444899, -0.041294414568616336, 0.009417236719051508],
            [-0.9954799049894397, -0.0120273307126254, 0.09420776018006581],
        ),
    ];
    for ((i, j), position, normal) in worked {
        let vertex = i * 70 + j;
        assert!((mesh.positions[vertex] - DVec3::from_array(position)).length() < 1e-12);
        assert!((mesh.normals[vertex] - DVec3::from_array(normal)).length() < 1e-12);
    }
    // The tube has its radius everywhere: every point is 0.3 from the curve's point of its ring.
    for ring in mesh.positions.chunks(70) {
        let centre = ring.iter().fold(DVec3::ZERO, |sum, p| sum + *p) / 70.0;
        assert!(ring.iter().all(|p| ((*p - centre).length() - 0.3).abs() < 1e-12));
    }
}

#[test]
fn what_cannot_be_made_is_refused() {
    use crate::error::Code;
    for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert_eq!(cuboid(DVec3::new(1.0, 1.0, bad)).unwrap_err().code(), Code::Range);
        assert_eq!(sphere(bad).unwrap_err().code(), Code::Range);
        assert_eq!(cone(1.0, bad).unwrap_err().code(), Code::Range);
        assert_eq!(cylinder(bad, 1.0).unwrap_err().code(), Code::Range);
    }
    assert_eq!(teapot(0).unwrap_err().code(), Code::Range);
    assert_eq!(teapot(u32::MAX).unwrap_err().code(), Code::TooBig);
    assert_eq!(knot(2, 9).unwrap_err().code(), Code::Range);
    assert_eq!(knot(u32::MAX, u32::MAX).unwrap_err().code(), Code::TooBig);
    assert_eq!(teapot(257).unwrap_err().to_string(), "4227136 faces are over the limit of 4194304");
}

#[test]
fn the_arrays_of_large_shapes_are_made_as_long_as_they_become() {
    let held = |mesh: &Mesh| mesh.size_bytes() as u64;
    for (nu, nv) in [(3, 3), (40, 12), (7, 100)] {
        let mut knot = knot(nu, nv).unwrap();
        assert_eq!(held(&knot), knot_bytes(nu, nv), "{nu} x {nv}");
        knot.shrink_to_fit();
        assert_eq!(held(&knot), knot_bytes(nu, nv), "{nu} x {nv}");
    }
    for level in [1, 2, 3, 10] {
        let mut teapot = teapot(level).unwrap();
        let made = held(&teapot);
        assert!(made <= teapot_bytes(level), "{made} bytes at level {level}");
        teapot.shrink_to_fit();
        assert_eq!((teapot.positions.len(), held(&teapot)), (teapot.positions.capacity(), made), "{level}");
    }
}

#[test]
fn what_a_shape_takes_is_counted_to_the_end_of_the_numbers() {
    for levels in [[8, 9], [1 << 16, 1 << 17], [u32::MAX - 1, u32::MAX]] {
        let [fine, finer] = levels.map(teapot_bytes);
        // The mesh alone has more than this per each of its 32 n^2 squares.
        let least = u64::from(levels[0]).pow(2).saturating_mul(32 * 100);
        assert!(fine >= least && finer >= fine, "{levels:?}: {fine}, {finer}");
        let [fine, finer] = levels.map(|n| knot_bytes(n, n));
        assert!(fine >= u64::from(levels[0]).pow(2).saturating_mul(100) && finer >= fine, "{levels:?}");
    }
}
