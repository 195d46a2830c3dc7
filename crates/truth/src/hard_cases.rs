//! The specification's table of hard cases as scenes, each with the name of its case.
//!
//! The reference defines the correct picture of each. In addition there must be no panic, no NaN,
//! and no pixel outside the viewport. A case about a promise that one picture cannot show (coplanar
//! faces in any order) has a scene for each side of it.

mod conformance;
mod surfaces;

use super::scenes::{Case, box_mesh, object};
use super::{Settings, Transparency};
use fbptr_core::math::matrix;
use fbptr_core::memory::DepthFormat;
use fbptr_core::scene::{
    Camera, Corner, Cull, HiddenSurface, Light, LightingModel, LookAt, Material, Mesh, NONE, Object,
    Projection, Scene, ShadeMode, TransparencyOrder,
};
use glam::{DMat4, DVec3};
use std::sync::Arc;

/// Returns all hard cases.
pub fn hard_cases() -> Vec<Case> {
    let mut cases = Vec::new();
    eye_plane(&mut cases);
    extents(&mut cases);
    degenerate(&mut cases);
    depths(&mut cases);
    surfaces::lighting(&mut cases);
    surfaces::textures(&mut cases);
    surfaces::models(&mut cases);
    surfaces::views(&mut cases);
    conformance::all(&mut cases);
    cases
}

fn v(x: f64, y: f64, z: f64) -> DVec3 {
    DVec3::new(x, y, z)
}

/// Returns a case with the initial camera and modes, 48 x 36 pixels, and one light from above the
/// eye.
fn case(name: &str, objects: Vec<Object>) -> Case {
    let light = Light::directional(v(0.2, -0.5, -1.0), DVec3::ONE);
    let scene = Scene {
        camera: Some(Camera::default()),
        ambient: DVec3::splat(0.3),
        lights: vec![light],
        objects,
        ..Scene::default()
    };
    let settings = Settings::default();
    Case { name: name.into(), scene, settings, format: DepthFormat::F32, width: 48, height: 36 }
}

fn triangles(name: &str, positions: &[DVec3], faces: &[[u32; 3]]) -> Object {
    let mut o = object(name, Mesh::from_triangles(positions.to_vec(), faces));
    o.cull = Cull::None;
    o.material.ka = DVec3::new(0.5, 0.4, 0.3);
    o.material.kd = DVec3::new(0.6, 0.55, 0.5);
    o
}

fn colored(mut o: Object, color: DVec3) -> Object {
    o.material = Material { emissive: color, model: LightingModel::Unlit, ..Material::default() };
    o
}

fn with_camera(mut c: Case, look_at: LookAt, projection: Projection) -> Case {
    c.scene.camera = Some(Camera { look_at, projection });
    c
}

fn ortho(mut c: Case, half: f64) -> Case {
    let window = [-half, half, -half * 0.75, half * 0.75];
    let look_at = LookAt { eye: v(0.0, 0.0, 5.0), reference: DVec3::ZERO, up: DVec3::Y };
    c.scene.camera = Some(Camera { look_at, projection: Projection::Ortho { window, near: 1.0, far: 9.0 } });
    c
}

fn eye_plane(cases: &mut Vec<Case>) {
    // The default eye is (0,0,5), looking along -z.
    let ground = [v(-30.0, -1.0, 20.0), v(30.0, -1.0, 20.0), v(0.0, -1.0, -60.0)];
    cases.push(case("a face through the eye plane", vec![triangles("ground", &ground, &[[0, 1, 2]])]));
    let all = [v(-500.0, -90.0, 90.0), v(400.0, -80.0, 30.0), v(-20.0, 400.0, -300.0)];
    cases.push(case("all six planes at once", vec![triangles("wall", &all, &[[0, 1, 2]])]));
    let at_eye = [v(0.0, 0.0, 5.0), v(2.0, -1.0, 0.0), v(-2.0, 1.5, 0.0)];
    cases.push(case("a corner at the eye", vec![triangles("cone", &at_eye, &[[0, 1, 2]])]));
    let w_zero = [v(3.0, 0.5, 5.0), v(-2.0, -1.5, 0.0), v(-1.0, 2.0, 1.0)];
    cases.push(case("a corner with w = 0", vec![triangles("w0", &w_zero, &[[0, 1, 2]])]));
    for (name, z) in [
        ("w = 1e-12", 5.0 - 1e-12),
        ("w = an ulp of the eye's distance", f64::from_bits(5.0f64.to_bits() - 1)),
    ] {
        let tiny = [v(3.0, 0.5, z), v(-2.0, -1.5, 0.0), v(-1.0, 2.0, 1.0)];
        cases.push(case(name, vec![triangles("tiny w", &tiny, &[[0, 1, 2]])]));
    }
    let behind = [v(-3.0, -3.0, 9.0), v(3.0, -3.0, 9.0), v(0.0, 3.0, 30.0)];
    cases.push(case("wholly behind the eye", vec![triangles("behind", &behind, &[[0, 1, 2]])]));
    let mut room = object("room", box_mesh(v(6.0, 4.0, 9.0)));
    room.cull = Cull::Front;
    cases.push(case("a room from inside, its walls through the eye plane", vec![room]));
}

fn extents(cases: &mut Vec<Case>) {
    // 48 pixels over 2 units: 24 pixels per unit. 1e-6 px is 4e-8 units, 1e9 px is 4e7 units.
    let thin = [v(-4e7, -1e7, 0.0), v(4e7, 1e7, 0.0), v(0.0, 4e-8, 0.0)];
    cases.push(ortho(
        case("a sliver 1e-6 px thin and 1e9 px long", vec![triangles("thin", &thin, &[[0, 1, 2]])]),
        1.0,
    ));
    let far = [v(-1e30, -1e30, 0.0), v(1e30, -0.9e30, 0.5), v(0.1e30, 1e30, -0.5)];
    cases.push(ortho(case("corners at 1e30", vec![triangles("huge", &far, &[[0, 1, 2]])]), 1.0));
    let half = [v(-1e30, -1e30, 0.0), v(1e30, 1e30, 0.0), v(-1e30, 1e30, 0.0), v(1e30, -1e30, 0.0)];
    let halves = triangles("halves", &half, &[[0, 1, 2], [0, 3, 1]]);
    cases.push(ortho(case("two half planes of 1e30 that share an edge", vec![halves]), 1.0));
    let tiny: Vec<DVec3> = (0..9).map(|i| v((i % 3) as f64, (i / 3) as f64, 0.0) * 1e-8).collect();
    let faces = [[0, 1, 4], [0, 4, 3], [1, 2, 5], [1, 5, 4], [3, 4, 7], [3, 7, 6], [4, 5, 8], [4, 8, 7]];
    cases.push(ortho(case("shared edges at a tiny scale", vec![triangles("tiny", &tiny, &faces)]), 1e-8));
    let mut fan = vec![v(0.05, 0.03, 0.0)];
    fan.extend((0..=40).map(|i| {
        let (sin, cos) = libm::sincos(i as f64 * 0.157);
        v(0.9 * cos, 0.7 * sin, 0.1 * cos)
    }));
    let faces: Vec<[u32; 3]> = (1..=40).map(|i| [0, i, i + 1]).collect();
    cases.push(ortho(case("a fan of thin faces about one point", vec![triangles("fan", &fan, &faces)]), 1.0));
    let denormal = [v(-1e-310, -1e-310, -0.0), v(1e-310, -1e-310, 0.0), v(0.0, 1e-310, -0.0)];
    cases.push(case(
        "subnormal and negative zero coordinates",
        vec![triangles("dust", &denormal, &[[0, 1, 2]])],
    ));
}

fn degenerate(cases: &mut Vec<Case>) {
    let p = [v(-1.0, -1.0, 0.0), v(1.0, -1.0, 0.0), v(0.0, 1.0, 0.0), v(0.0, -1.0, 0.0)];
    let flat = triangles("flat", &p, &[[0, 3, 1], [0, 0, 1], [2, 2, 2]]);
    cases.push(case("zero-area faces and repeated vertices", vec![flat.clone()]));
    let mixed = triangles("mixed", &p, &[[0, 1, 2], [0, 3, 1], [1, 1, 2]]);
    cases.push(case("zero-area faces beside a good one", vec![mixed]));
    let mut zero_normal = object("zero", Mesh { positions: p.to_vec(), ..Mesh::default() });
    let mesh = &mut Arc::make_mut(&mut zero_normal.geometry).mesh;
    mesh.normals = vec![DVec3::ZERO, v(0.0, 0.3, 1.0), v(0.0, -0.3, -1.0)];
    let corners = [(0, 0), (1, 1), (2, 2)].map(|(position, normal)| Corner {
        position,
        normal,
        texcoord: NONE,
        color: NONE,
    });
    mesh.push_polygon(&corners, NONE);
    cases.push(case("a zero normal and opposite ones in the file", vec![zero_normal]));
    // The two sides of a sheet share their vertices: their mean normals cancel.
    let sheet = triangles("sheet", &p[..3], &[[0, 1, 2], [0, 2, 1]]);
    for shade in [ShadeMode::Gouraud, ShadeMode::Phong] {
        let mut c = case(&format!("opposite normals that cancel, {}", shade.as_str()), vec![sheet.clone()]);
        c.settings.shade = shade;
        c.settings.cull = Some(Cull::Back);
        cases.push(c);
    }
    cases.push(case("an empty mesh", vec![object("empty", Mesh::default())]));
    let mut star = Mesh::default();
    let corners: Vec<Corner> = (0..10)
        .map(|i| {
            let (sin, cos) = libm::sincos(i as f64 * std::f64::consts::PI / 5.0);
            let r = if i % 2 == 0 { 1.5 } else { 0.5 };
            star.positions.push(v(r * cos, r * sin, 0.2 * cos));
            Corner { position: i, normal: NONE, texcoord: NONE, color: NONE }
        })
        .collect();
    star.push_polygon(&corners, NONE);
    cases.push(case("a concave n-gon", vec![object("star", star)]));
}

fn depths(cases: &mut Vec<Case>) {
    let quad = |z: f64, s: f64| [v(-s, -s, z), v(s, -s, z), v(s, s, z), v(-s, s, z)];
    let square = |name: &str, z: f64, s: f64, color| {
        colored(triangles(name, &quad(z, s), &[[0, 1, 2], [0, 2, 3]]), color)
    };
    let (red, blue) = (v(1.0, 0.2, 0.1), v(0.1, 0.3, 1.0));
    for format in DepthFormat::ALL {
        let mut c = case(
            &format!("near/far .01/1000 in {}", format.as_str()),
            vec![square("near", 0.0, 1.0, red), square("far", -0.4, 1.5, blue)],
        );
        c.format = format;
        let look_at = Camera::default().look_at;
        let wide = Projection::Perspective { fov_rad: 0.8, near: 0.01, far: 1000.0, on_smaller_side: false };
        cases.push(with_camera(c.clone(), look_at, wide));
        c.name = format!("near/far 1:1e9 in {}", format.as_str());
        let wider = Projection::Perspective { fov_rad: 0.8, near: 1e-3, far: 1e6, on_smaller_side: false };
        cases.push(with_camera(c.clone(), look_at, wider));
        c.name = format!("faces that cross, in {}", format.as_str());
        let leaning = [v(-1.5, -1.0, -1.0), v(1.5, -1.0, 1.0), v(0.0, 1.4, 0.1)];
        c.scene.objects =
            vec![square("wall", 0.0, 1.2, red), colored(triangles("lean", &leaning, &[[0, 1, 2]]), blue)];
        cases.push(c);
    }
    let p = [v(-1.5, -1.0, -1.0), v(1.5, -1.0, 1.0), v(0.0, 1.4, 0.1)];
    for (k, order) in [[0, 1, 2], [1, 2, 0], [2, 1, 0]].into_iter().enumerate() {
        let both = vec![
            colored(triangles("first", &p, &[[0, 1, 2]]), red),
            colored(triangles("second", &p, &[order]), blue),
        ];
        cases.push(case(&format!("coplanar: equal positions, corner order {k}: the first stays"), both));
    }
    let level = vec![square("first", 0.25, 1.0, red), square("second", 0.25, 1.3, blue)];
    cases.push(case("coplanar: faces of one constant depth: the first stays", level));
    // The default near plane is at z = 4.9.
    let ramp = [v(-0.1, -0.05, 4.95), v(0.1, -0.05, 4.95), v(0.0, 0.6, 4.0)];
    cases.push(case("a face through the near plane", vec![triangles("ramp", &ramp, &[[0, 1, 2]])]));
    let long = [v(-20.0, -2.0, 0.0), v(20.0, -2.0, 0.0), v(0.0, 40.0, -200.0)];
    cases.push(case("a face through the far plane", vec![triangles("long", &long, &[[0, 1, 2]])]));
    let mut layers: Vec<Object> = (0..16)
        .map(|i| {
            let t = i as f64 / 16.0;
            let mut o = square("layer", -t, 1.6 - t, v(t, 0.5, 1.0 - t));
            o.material.transparency = 0.6;
            o
        })
        .collect();
    cases.push(case("16 transparent layers at once", layers.clone()));
    layers.push(square("wall", -0.5, 0.7, blue));
    for order in [TransparencyOrder::FileOrder, TransparencyOrder::Sorted] {
        let mut c = case(&format!("transparent layers after the opaque, {order:?}"), layers.clone());
        c.settings.transparency = Transparency::AfterOpaque(order);
        cases.push(c);
    }
    for hide in [HiddenSurface::Painter, HiddenSurface::None] {
        let mut c = case(&format!("hide {}", hide.as_str()), vec![object("box", box_mesh(v(1.0, 0.8, 0.9)))]);
        c.scene.objects[0].model = matrix::rotate(v(1.0, 0.7, 0.2), 0.9).unwrap_or(DMat4::IDENTITY);
        c.scene.objects[0].cull = Cull::None;
        c.settings.hide = hide;
        cases.push(c);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// No result of the reference is infinite, NaN, or outside the viewport.
    #[test]
    fn every_case_has_finite_answers_inside_the_viewport() {
        for c in hard_cases() {
            let truth = crate::render(&c.scene, c.width, c.height, c.format, &c.settings)
                .unwrap_or_else(|e| panic!("{}: {e}", c.name));
            for (x, y) in (0..c.height).flat_map(|y| (0..c.width).map(move |x| (x, y))) {
                for s in truth.states(x, y) {
                    assert!(s.z.iter().all(|z| z.is_finite()), "{} ({x},{y}) {s:?}", c.name);
                    assert!(s.real.iter().all(|r| !r.is_nan()), "{} ({x},{y}) {s:?}", c.name);
                    let inside = c.settings.viewport.is_none_or(|v| {
                        (v.x as i64..v.x as i64 + v.width as i64).contains(&(x as i64))
                            && (v.y as i64..v.y as i64 + v.height as i64).contains(&(y as i64))
                    });
                    assert!(inside || s.drawn.is_none(), "{} ({x},{y})", c.name);
                }
            }
        }
    }

    fn picture_of(name: &str) -> crate::TruthPicture {
        let c = hard_cases().into_iter().find(|c| c.name.starts_with(name)).unwrap();
        crate::render(&c.scene, c.width, c.height, c.format, &c.settings).unwrap()
    }

    #[test]
    fn of_coplanar_faces_the_first_stays() {
        for k in 0..3 {
            let p = picture_of(&format!("coplanar: equal positions, corner order {k}"));
            let states = p.states(24, 18);
            assert_eq!(states.len(), 1);
            assert_eq!(states[0].lo, [255, 51, 26]);
        }
        let p = picture_of("coplanar: faces of one constant depth");
        assert_eq!((p.states(24, 18).len(), p.states(24, 18)[0].lo), (1, [255, 51, 26]));
    }

    #[test]
    fn half_planes_fill_the_frame_and_zero_area_nothing() {
        let p = picture_of("two half planes");
        let seen = (0..48 * 36).filter(|i| p.states(i % 48, i / 48)[0].drawn.is_some()).count();
        assert_eq!(seen, 48 * 36);
        let p = picture_of("zero-area faces and");
        assert!((0..48 * 36).all(|i| p.states(i % 48, i / 48).iter().all(|s| s.drawn.is_none())));
    }
}
