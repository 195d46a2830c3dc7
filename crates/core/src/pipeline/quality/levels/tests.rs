use super::*;
use crate::cancel::{CancelToken, NEVER};
use crate::scene::{Corner, Material, NONE, shapes};
use crate::truth::scenes::Random;
use glam::{DVec3, DVec4};

/// Side of the sheet, in squares.
const SIDE: u32 = 56;

/// Returns an open, wavy sheet with a crease in the middle, where positions have two normals, vertex
/// colours, and two materials.
fn sheet(r: &mut Random) -> Mesh {
    let waves: [f64; 4] = std::array::from_fn(|_| r.real(0.5, 2.0));
    let mut mesh = Mesh { materials: vec![Material::default(); 2], ..Mesh::default() };
    let place = |i: u32| f64::from(i) / f64::from(SIDE);
    for j in 0..=SIDE {
        for i in 0..=SIDE {
            let (x, y) = (place(i), place(j));
            let height = 0.02 * (libm::sin(waves[0] * 6.0 * x) + libm::sin(waves[1] * 6.0 * y + waves[2]));
            let noise = if i % 7 == 3 { 1e-4 * r.real(-1.0, 1.0) } else { 0.0 };
            mesh.positions.push(DVec3::new(x, y, height + noise + 0.1 * (x - 0.5).abs()));
            let slope = |d: f64| {
                let dx = 0.12 * waves[0] * libm::cos(waves[0] * 6.0 * x) + 0.1 * d;
                let dy = 0.12 * waves[1] * libm::cos(waves[1] * 6.0 * y + waves[2]);
                DVec3::new(-dx, -dy, 1.0).normalize()
            };
            mesh.normals.extend([slope(-1.0), slope(1.0)]);
            mesh.colors.push(DVec4::new(0.5 + 0.01 * waves[3] * x, 0.5, 0.5 - 0.01 * y, 1.0));
        }
    }
    for j in 0..SIDE {
        for i in 0..SIDE {
            let side = u32::from(i >= SIDE / 2);
            let corner = |i: u32, j: u32| {
                let at = j * (SIDE + 1) + i;
                Corner { position: at, normal: 2 * at + side, texcoord: NONE, color: at }
            };
            let [a, b, c, d] = [corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)];
            mesh.push_polygon(&[a, b, c, d], u32::from(j >= SIDE / 2));
        }
    }
    mesh
}

fn triangles(mesh: &Mesh) -> Vec<[DVec3; 3]> {
    let at = |c: &u32| mesh.positions[mesh.corners[*c as usize].position as usize];
    mesh.triangles.iter().map(|t| [at(&t[0]), at(&t[1]), at(&t[2])]).collect()
}

/// Returns the distance of a point from a triangle (C. Ericson, "Real-Time Collision Detection", 2005,
/// section 5.1.5, by its edges and its plane).
fn distance(p: DVec3, [a, b, c]: [DVec3; 3]) -> f64 {
    let normal = (b - a).cross(c - a);
    let inside = [(a, b), (b, c), (c, a)].iter().all(|(s, e)| (*e - *s).cross(p - *s).dot(normal) >= 0.0);
    if inside {
        return (p - a).dot(normal).abs() / normal.length();
    }
    let to_edge = |s: DVec3, e: DVec3| {
        let part = ((p - s).dot(e - s) / (e - s).length_squared()).clamp(0.0, 1.0);
        p.distance(s + (e - s) * part)
    };
    to_edge(a, b).min(to_edge(b, c)).min(to_edge(c, a))
}

/// Returns the largest distance of points of one surface from the other.
fn farthest(r: &mut Random, from: &[[DVec3; 3]], to: &[[DVec3; 3]]) -> f64 {
    let mut far = 0.0f64;
    for _ in 0..150 {
        let [a, b, c] = from[((r.real(0.0, 1.0) * from.len() as f64) as usize).min(from.len() - 1)];
        let (s, t) = (r.real(0.0, 1.0), r.real(0.0, 1.0));
        let (s, t) = if s + t > 1.0 { (1.0 - s, 1.0 - t) } else { (s, t) };
        let p = a + (b - a) * s + (c - a) * t;
        far = far.max(to.iter().map(|triangle| distance(p, *triangle)).fold(f64::INFINITY, f64::min));
    }
    far
}

#[test]
fn no_point_of_either_surface_is_farther_from_the_other_than_the_bound() {
    let mut r = Random::new(3);
    let (mut checked, mut widest) = (0, 0.0f64);
    for mesh in [sheet(&mut r), sheet(&mut r), shapes::knot(90, 30).unwrap()] {
        let whole = triangles(&mesh);
        for level in make_levels(&mesh, &NEVER) {
            let coarse = triangles(&level.geometry.mesh);
            let far = farthest(&mut r, &whole, &coarse).max(farthest(&mut r, &coarse, &whole));
            assert!(far <= level.change.distance, "{far} of {:?}", level.change);
            widest = widest.max(far / level.change.distance);
            checked += 1;
        }
    }
    assert!(checked >= 4 && widest > 0.1, "{checked} levels, {widest} of the bound");
}

#[test]
fn borders_creases_and_materials_stay() {
    let mesh = sheet(&mut Random::new(8));
    let levels = make_levels(&mesh, &NEVER);
    let level = &levels.last().unwrap().geometry.mesh;
    assert!(level.triangles.len() * 2 < mesh.triangles.len(), "{}", level.triangles.len());
    let is_there = |p: &DVec3| level.positions.contains(p);
    for (i, p) in mesh.positions.iter().enumerate() {
        let (x, y) = (i as u32 % (SIDE + 1), i as u32 / (SIDE + 1));
        let stays = [x, y].iter().any(|v| *v == 0 || *v == SIDE) || x == SIDE / 2 || y == SIDE / 2;
        assert!(!stays || is_there(p), "{x} {y}");
    }
    // Each triangle has the material and lies on the side of the crease of the one that it was.
    let origins = &levels.last().unwrap().origins;
    for (t, origin) in origins.iter().enumerate() {
        let of = |mesh: &Mesh, t: usize| {
            let corners = mesh.triangles[t].map(|c| mesh.corners[c as usize].position as usize);
            let middle = corners.iter().map(|c| mesh.positions[*c]).sum::<DVec3>() / 3.0;
            (mesh.polygons[mesh.triangle_polygon[t] as usize].material, middle.x - 0.5)
        };
        let ((material, x), (whole, whole_x)) = (of(level, t), of(&mesh, *origin as usize));
        // A face between corners of the crease alone is on neither side.
        assert!(material == whole && (x * whole_x > 0.0 || x == 0.0), "{t}: {x} {whole_x}");
    }
}

#[test]
fn levels_are_the_same_every_time_and_get_coarser() {
    let mesh = sheet(&mut Random::new(2));
    let (levels, again) = (make_levels(&mesh, &NEVER), make_levels(&mesh, &NEVER));
    assert_eq!(levels.len(), again.len());
    for (a, b) in levels.iter().zip(&again) {
        assert!(a.geometry.mesh == b.geometry.mesh && a.change == b.change && a.origins == b.origins);
    }
    for pair in levels.windows(2) {
        assert!(pair[0].geometry.mesh.triangles.len() > pair[1].geometry.mesh.triangles.len());
        assert!(pair[0].change.is_within(pair[1].change), "{:?} {:?}", pair[0].change, pair[1].change);
    }
}

#[test]
fn nothing_is_made_of_meshes_that_are_small_broken_flat_or_cancelled() {
    let sheet = sheet(&mut Random::new(4));
    let count = |change: &dyn Fn(&mut Mesh)| {
        let mut mesh = sheet.clone();
        change(&mut mesh);
        make_levels(&mesh, &NEVER).len()
    };
    assert!(count(&|_| {}) > 0);
    assert_eq!(count(&|m| m.corners[7].position = 1 << 30), 0);
    assert_eq!(count(&|m| m.triangle_polygon[7] = 1 << 30), 0);
    assert_eq!(count(&|m| m.polygons[7].first_corner = u32::MAX), 0);
    assert_eq!(count(&|m| m.positions[7].x = f64::NAN), 0);
    assert_eq!(count(&|m| m.positions.iter_mut().for_each(|p| *p *= 1e308)), 0);
    assert_eq!(count(&|m| m.positions.iter_mut().for_each(|p| *p = DVec3::ONE)), 0);
    assert_eq!(count(&|m| m.lines.push([0, 1])), 0);
    assert_eq!(count(&|m| m.triangles.truncate(100)), 0);
    let cancel = CancelToken::new();
    cancel.cancel();
    assert_eq!(make_levels(&sheet, &cancel).len(), 0);
}
