//! Verifies faces and lines whose ends lie so far away that f64 has no digits left for a pixel.
//!
//! Guards against corners placed, edges cut and planes computed in f64 beyond 2^40 pixels. All are
//! compared with the reference, which accepts two results only within 1/256 pixel of an edge.

use fbptr::measure::draw_case;
use fbptr::memory::DepthFormat;
use fbptr::scene::{
    Camera, Corner, Cull, HiddenSurface, LightingModel, LookAt, Mesh, NONE, Object, Projection, Scene,
};
use fbptr::truth::scenes::{Case, Random, object};
use fbptr::truth::{Settings, compare, render};
use glam::DVec3;

/// Returns an unlit object that is seen from both sides.
fn glowing(name: &str, mesh: Mesh, color: DVec3) -> Object {
    let mut own = object(name, mesh);
    own.material.model = LightingModel::Unlit;
    own.material.emissive = color;
    own.cull = Cull::None;
    own
}

fn case(name: &str, camera: Camera, objects: Vec<Object>, hide: HiddenSurface) -> Case {
    Case {
        name: name.to_owned(),
        scene: Scene { camera: Some(camera), objects, ..Scene::default() },
        settings: Settings { hide, ..Settings::default() },
        format: DepthFormat::F32,
        width: 64,
        height: 48,
    }
}

/// Draws a case, compares it, and returns the numbers of lit pixels and of those with two results.
fn check(case: &Case) -> (usize, usize) {
    let truth = render(&case.scene, case.width, case.height, case.format, &case.settings).unwrap();
    let found = draw_case(case);
    let report = compare(&found.memory, found.depth.as_ref(), &truth);
    assert!(report.is_right(), "{}\n{report}", case.name);
    let lit = found.memory.bytes().chunks_exact(4).filter(|p| p[..3] != [0; 3]).count();
    (lit, report.turns)
}

/// Returns a camera at the origin that looks along -z, or a turned one.
fn camera(r: &mut Random, projection: Projection) -> Camera {
    let reference = if r.one_in(2) { -DVec3::Z } else { r.point(-1.0, 1.0) - DVec3::Z * 2.0 };
    Camera { look_at: LookAt { eye: DVec3::ZERO, reference, up: DVec3::Y }, projection }
}

/// Returns a point in the plane z = -2 or so, at this distance.
fn far_point(r: &mut Random, far: f64) -> DVec3 {
    let turn = r.real(0.0, std::f64::consts::TAU);
    DVec3::new(far * libm::cos(turn), far * libm::sin(turn), r.real(-4.0, -1.0))
}

const DISTANCES: [f64; 5] = [1e13, 1e15, 2.3e16, 5e16, 1e30];

#[test]
fn faces_with_all_corners_far_out_cover_what_the_reference_says() {
    let mut r = Random::new(51);
    let projection = Projection::Ortho { window: [-2.0, 2.0, -1.5, 1.5], near: 0.1, far: 10.0 };
    let (mut lit, mut turns) = (0, 0);
    for far in DISTANCES {
        let objects = (0..8).map(|i| {
            let positions = (0..3).map(|_| far_point(&mut r, far)).collect();
            let mesh = Mesh::from_triangles(positions, &[[0, 1, 2]]);
            glowing(&format!("face {i}"), mesh, r.point(0.2, 1.0))
        });
        let objects = objects.collect();
        let mut case = case(&format!("faces at {far}"), Camera::default(), objects, HiddenSurface::None);
        case.scene.camera = Some(camera(&mut r, projection));
        case.scene.camera.as_mut().unwrap().look_at.reference = -DVec3::Z;
        let found = check(&case);
        (lit, turns) = (lit + found.0, turns + found.1);
    }
    assert!(lit > 5_000 && turns < 100, "{lit} pixels, {turns} either way");
}

#[test]
fn grounds_that_reach_far_out_are_drawn() {
    let mut r = Random::new(52);
    let projection = Projection::Perspective { fov_rad: 1.0, near: 0.1, far: 50.0, on_smaller_side: false };
    for far in [1e13, 1e15, 2.3e16, 5e16, 1e20] {
        for corners in [[[-1.0, -1.0], [1.0, -1.0], [0.0, 0.0]], [[-1.0, -1.0], [1.0, -1.0], [0.0, 1.0]]] {
            for hide in [HiddenSurface::ZBuffer, HiddenSurface::None] {
                let positions = corners.map(|[x, z]| DVec3::new(x * far, -1.0, z * far)).to_vec();
                let mesh = Mesh::from_triangles(positions, &[[0, 1, 2]]);
                let camera = camera(&mut r, projection);
                let own = vec![glowing("ground", mesh, DVec3::ONE)];
                let case = case(&format!("ground of {far}"), camera, own, hide);
                let (lit, turns) = check(&case);
                assert!(lit > 50 && turns < 150, "{far} {corners:?}: {lit} pixels, {turns} either way");
            }
        }
    }
}

#[test]
fn lines_from_far_to_far_lie_on_their_segments() {
    let mut r = Random::new(53);
    let (mut lit, mut turns) = (0, 0);
    for far in [3.0, 1e6, 1e13, 1e16] {
        for projection in [
            Projection::Ortho { window: [-2.0, 2.0, -1.5, 1.5], near: 0.1, far: 10.0 },
            Projection::Perspective { fov_rad: 1.0, near: 0.1, far: 50.0, on_smaller_side: false },
        ] {
            let mut mesh = Mesh::default();
            for i in 0..24u32 {
                // Through a point in the view, and equally far to both sides.
                let middle = r.point(-0.7, 0.7) - DVec3::Z * 2.0;
                let along = r.point(-1.0, 1.0) * DVec3::new(far, far, 0.5);
                mesh.positions.extend([middle - along, middle + along * r.pick(&[1.0, 0.3, 1e-3])]);
                mesh.lines.push([2 * i, 2 * i + 1]);
            }
            mesh.corners = (0..mesh.positions.len() as u32)
                .map(|position| Corner { position, normal: NONE, texcoord: NONE, color: NONE })
                .collect();
            let mut own = glowing("lines", mesh, DVec3::ONE);
            own.material.emissive = DVec3::new(0.9, 0.8, 0.2);
            let camera = Camera {
                look_at: LookAt { eye: DVec3::ZERO, reference: -DVec3::Z, up: DVec3::Y },
                projection,
            };
            let found = check(&case(&format!("lines of {far}"), camera, vec![own], HiddenSurface::ZBuffer));
            (lit, turns) = (lit + found.0, turns + found.1);
        }
    }
    assert!(lit > 3_000 && turns * 20 < lit, "{lit} pixels, {turns} either way");
}
