//! Generated normals for OBJ files without any, and the pictures drawn with them.

use crate::support::draw;
use fbptr::load::{LoadMemory, LoadedMesh, Smoothing, obj};
use fbptr::scene::{Mesh, NONE, Scene, shapes};
use glam::DVec3;
use std::fmt::Write;
use std::sync::Arc;

const SIXTY: Smoothing = Smoothing::Angle(std::f64::consts::FRAC_PI_3);

fn read(text: &str, smoothing: Smoothing) -> LoadedMesh {
    let memory = &mut LoadMemory::unlimited();
    obj::parse_smooth(text.as_bytes(), &mut |_| None, "m.obj", memory, smoothing).unwrap()
}

/// Returns a mesh's polygons as OBJ text, each with its own positions.
fn parted(mesh: &Mesh) -> String {
    let mut text = String::new();
    for p in 0..mesh.polygons.len() {
        let corners = mesh.polygon_corners(p);
        for c in corners {
            let at = mesh.positions[c.position as usize];
            writeln!(text, "v {:?} {:?} {:?}", at.x, at.y, at.z).unwrap();
        }
        let count = corners.len();
        text += "f";
        (0..count).for_each(|k| write!(text, " -{}", count - k).unwrap());
        text += "\n";
    }
    text
}

/// Returns each corner's position and normal.
fn corners(mesh: &Mesh) -> impl Iterator<Item = (DVec3, DVec3)> {
    let normal = |n: u32| if n == NONE { DVec3::ZERO } else { mesh.normals[n as usize] };
    mesh.corners.iter().map(move |c| (mesh.positions[c.position as usize], normal(c.normal)))
}

#[test]
fn a_sphere_in_pieces_is_round_again() {
    let text = parted(&shapes::sphere(1.0).unwrap());
    let round = read(&text, SIXTY);
    assert!(!round.is_open);
    let worst = corners(&round.geometry.mesh).map(|(p, n)| p.normalize().dot(n)).fold(1.0, f64::min);
    assert!(worst > 0.999, "a normal is {} degrees off", worst.acos().to_degrees());
    // Equal positions have equal normals: no seam.
    let mut all: Vec<_> = corners(&round.geometry.mesh).map(|(p, n)| (p.to_array(), n.to_array())).collect();
    all.sort_by(|a, b| a.partial_cmp(b).unwrap());
    let seams = all.windows(2).filter(|w| w[0].0 == w[1].0 && w[0].1 != w[1].1).count();
    assert_eq!(seams, 0);
    assert!(all.len() > 500, "{} corners", all.len());
}

#[test]
fn a_cube_keeps_its_edges_whether_its_faces_share_positions_or_not() {
    let cube = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n\
        f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";
    let shared = read(cube, SIXTY);
    let apart = read(&parted(&shared.geometry.mesh), SIXTY);
    for loaded in [&shared, &apart] {
        assert!(!loaded.is_open);
        for (_, n) in corners(&loaded.geometry.mesh) {
            assert_eq!(n.abs().max_element(), 1.0, "along an axis: {n}");
        }
    }
    // At 100 degrees the corners are smooth: every normal points along a diagonal.
    let round = read(cube, Smoothing::Angle(100_f64.to_radians()));
    for (p, n) in corners(&round.geometry.mesh) {
        assert!(n.dot((p - DVec3::splat(0.5)).normalize()) > 1.0 - 1e-12, "{n}");
    }
}

#[test]
fn a_cylinder_of_triangles_is_lit_like_one_of_squares() {
    let side = |i: u32| {
        let angle = f64::from(i) * std::f64::consts::TAU / 12.0;
        let (x, y) = (libm::cos(angle), libm::sin(angle));
        format!("v {x:?} {y:?} 0\nv {x:?} {y:?} 1\n")
    };
    let positions: String = (0..12).map(side).collect();
    let (mut squares, mut triangles) = (positions.clone(), positions);
    for i in 0..12 {
        let [a, b, c, d] = [2 * i, 2 * ((i + 1) % 12), 2 * ((i + 1) % 12) + 1, 2 * i + 1].map(|k| k + 1);
        writeln!(squares, "f {a} {b} {c} {d}").unwrap();
        writeln!(triangles, "f {a} {b} {c}\nf {a} {c} {d}").unwrap();
    }
    for text in [squares, triangles] {
        let tube = read(&text, SIXTY);
        assert!(tube.is_open, "its ends are");
        for (p, n) in corners(&tube.geometry.mesh) {
            assert!((n - DVec3::new(p.x, p.y, 0.0)).length() < 1e-12, "{n} at {p}");
        }
    }
}

#[test]
fn the_inside_of_an_open_surface_is_lit() {
    // Half a pipe, seen from inside.
    let mut text = String::new();
    for i in 0..=8 {
        let angle = f64::from(i) * std::f64::consts::PI / 8.0;
        writeln!(
            text,
            "v {:?} -1 {:?}\nv {:?} 1 {:?}",
            libm::cos(angle),
            -libm::sin(angle),
            libm::cos(angle),
            -libm::sin(angle)
        )
        .unwrap();
    }
    for i in 0..8 {
        let a = 2 * i + 1;
        writeln!(text, "f {} {} {} {}", a, a + 1, a + 3, a + 2).unwrap();
    }
    // With the winding reversed from the same first corner, so that squares are triangulated alike.
    let turn = |line: &str| match line.split(' ').collect::<Vec<_>>()[..] {
        ["f", a, b, c, d] => format!("f {a} {d} {c} {b}\n"),
        _ => format!("{line}\n"),
    };
    let turned: String = text.lines().map(turn).collect();
    let scene = |text: &str| {
        let loaded = read(text, SIXTY);
        Scene::of_mesh(Arc::new(loaded.geometry), "pipe", 1.0, loaded.is_open)
    };
    // Both with one camera and one light: a mesh is framed from its front.
    let (first, mut second) = (scene(&text), scene(&turned));
    (second.camera, second.lights) = (first.camera, first.lights.clone());
    let (one, other) = (draw(&first, 48, 48), draw(&second, 48, 48));
    let lit = one.bytes().chunks(4).filter(|p| p[0] > 20).count();
    assert!(lit > 400, "{lit} pixels are lit");
    let worst = one.bytes().iter().zip(other.bytes()).map(|(a, b)| a.abs_diff(*b)).max();
    assert!(worst <= Some(2), "whichever side its faces look to: {worst:?} steps differ");
}

/// Returns the share of a mesh's corners whose normal is that of their own face.
fn flat_share(text: &str) -> f64 {
    let mesh = &read(text, Smoothing::Automatic).geometry.mesh;
    let (mut flat, mut all) = (0, 0);
    for p in 0..mesh.polygons.len() {
        let corners = mesh.polygon_corners(p);
        let at = |k: usize| mesh.positions[corners[k].position as usize];
        let normal = (at(1) - at(0)).cross(at(2) - at(0)).normalize();
        all += corners.len();
        flat += corners.iter().filter(|c| mesh.normals[c.normal as usize].dot(normal) > 1.0 - 1e-6).count();
    }
    flat as f64 / all as f64
}

/// Returns a prism of `sides` sides and two ends as OBJ text, its numbers rounded to 32 bits.
fn prism(sides: u32) -> String {
    let mut text = String::new();
    for i in 0..sides {
        let angle = f64::from(i) * std::f64::consts::TAU / f64::from(sides);
        let (x, y) = (libm::cos(angle) as f32, libm::sin(angle) as f32);
        writeln!(text, "v {x:?} {y:?} 0\nv {x:?} {y:?} 1").unwrap();
    }
    for i in 0..sides {
        let [a, b] = [i, (i + 1) % sides].map(|i| 2 * i + 1);
        writeln!(text, "f {a} {b} {} {}", b + 1, a + 1).unwrap();
    }
    let ends = |first: u32| (0..sides).map(move |i| format!(" {}", 2 * i + first));
    text + "f" + &ends(1).rev().collect::<String>() + "\nf" + &ends(2).collect::<String>() + "\n"
}

#[test]
fn by_default_round_bodies_are_smooth_and_edges_crisp() {
    // Smooth: only the corners of the two ends are those of a flat face.
    for (sides, is_round) in [(6, false), (8, false), (12, true), (13, true), (32, true)] {
        let expected = if is_round { 2.0 / 6.0 } else { 1.0 };
        let found = flat_share(&prism(sides));
        assert!((found - expected).abs() < 1e-9, "{sides} sides: {found}");
    }
    for (what, mesh) in [("sphere", shapes::sphere(1.0)), ("knot", shapes::knot(200, 20))] {
        let found = flat_share(&parted(&mesh.unwrap()));
        assert!(found < 0.05, "{what}: {found} flat");
    }
    let icosahedron = {
        let g = f64::midpoint(1.0, 5f64.sqrt());
        let mut text = String::new();
        for (a, b) in [(-1.0, g), (1.0, g), (-1.0, -g), (1.0, -g)] {
            writeln!(text, "v {a:?} {b:?} 0").unwrap();
        }
        for (a, b) in [(-1.0, g), (1.0, g), (-1.0, -g), (1.0, -g)] {
            writeln!(text, "v 0 {a:?} {b:?}").unwrap();
        }
        for (a, b) in [(g, -1.0), (g, 1.0), (-g, -1.0), (-g, 1.0)] {
            writeln!(text, "v {a:?} 0 {b:?}").unwrap();
        }
        text + "f 1 12 6\nf 1 6 2\nf 1 2 8\nf 1 8 11\nf 1 11 12\nf 2 6 10\nf 6 12 5\nf 12 11 3\nf 11 8 7\n\
            f 8 2 9\nf 4 10 5\nf 4 5 3\nf 4 3 7\nf 4 7 9\nf 4 9 10\nf 5 10 6\nf 3 5 12\nf 7 3 11\nf 9 7 8\nf 10 9 2\n"
    };
    assert_eq!(flat_share(&icosahedron), 1.0, "an icosahedron is no ball");
    // A block whose upper edges are cut off at 45 degrees.
    let chamfered = "v 0 0 0\nv 4 0 0\nv 4 4 0\nv 0 4 0\nv 0 0 3\nv 4 0 3\nv 4 4 3\nv 0 4 3\n\
        v 1 1 4\nv 3 1 4\nv 3 3 4\nv 1 3 4\nf 4 3 2 1\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n\
        f 5 6 10 9\nf 6 7 11 10\nf 7 8 12 11\nf 8 5 9 12\nf 9 10 11 12\n";
    assert_eq!(flat_share(chamfered), 1.0, "a chamfer has no shade of its neighbours");
}
