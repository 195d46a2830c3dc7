//! Hard cases of surfaces: lights, textures, models, viewports.

use super::{case, colored, triangles, v, with_camera};
use crate::scenes::{Case, box_mesh, object, terrain};

use fbptr_core::math::matrix;
use fbptr_core::scene::{
    Attenuation, Camera, Cull, Filter, LightKind, LightingModel, LookAt, Material, Projection, Sampling,
    ShadeMode, Texture, Viewport, ViewportRule, Wrap,
};
use glam::{DMat4, DVec2, DVec3};
use std::sync::Arc;

pub(super) fn lighting(cases: &mut Vec<Case>) {
    let p = [v(-2.0, -1.5, 0.0), v(2.0, -1.5, 0.2), v(0.1, 1.9, -0.3)];
    let point =
        |position| LightKind::Point { position, attenuation: Attenuation::NONE, radius: f64::INFINITY };
    let inverse_square = Attenuation { c: 0.0, l: 0.0, q: 1.0 };
    let kinds = [
        ("a light on the surface", point(p[0])),
        ("a light behind the surface", point(v(0.0, 0.0, -3.0))),
        ("a light at the eye", point(v(0.0, 0.0, 5.0))),
        (
            "a light a hair above the surface, 1/d^2",
            LightKind::Point {
                position: v(0.0, 0.0, 0.05),
                attenuation: inverse_square,
                radius: f64::INFINITY,
            },
        ),
        (
            "a spot whose edge crosses the face",
            LightKind::Spot {
                position: v(0.3, 0.2, 2.0),
                direction: -DVec3::Z,
                angle_rad: 0.4,
                exponent: 3.0,
                attenuation: Attenuation::NONE,
            },
        ),
    ];
    for (name, kind) in kinds {
        for shade in [ShadeMode::Flat, ShadeMode::Gouraud, ShadeMode::Phong] {
            let mut o = triangles("face", &p, &[[0, 1, 2]]);
            o.material.ks = DVec3::splat(0.5);
            o.material.n = 20.0;
            let mut c = case(&format!("{name}, {}", shade.as_str()), vec![o]);
            c.scene.lights[0].kind = kind;
            c.settings.shade = shade;
            cases.push(c);
        }
    }
    for n in [0.0, 1e-3, 1.0, 1000.0, 1e6] {
        for model in [LightingModel::Phong, LightingModel::Blinn] {
            let mut ball = object("ball", box_mesh(v(1.0, 1.0, 1.0)));
            ball.material = Material { ks: DVec3::splat(0.9), n, model, ..Material::default() };
            ball.model = matrix::rotate(v(0.2, 1.0, 0.1), 0.5).unwrap_or(DMat4::IDENTITY);
            let mut c = case(&format!("exponent {n:e}, {model:?}"), vec![ball]);
            c.scene.lights[0].kind = LightKind::Directional { direction: v(0.0, 0.0, -1.0) };
            cases.push(c);
        }
    }
    let mut bright = triangles("bright", &p, &[[0, 1, 2]]);
    bright.material.kd = DVec3::splat(40.0);
    bright.material.transparency = 0.5;
    cases.push(case("colours far above 1 under transparency", vec![bright]));
}

/// Returns a texture whose texels differ from all their neighbours.
fn noise(width: u32, height: u32) -> Arc<Texture> {
    let bytes: Vec<u8> = (0..width * height)
        .flat_map(|i| [(i * 97 % 256) as u8, (i * 57 % 251) as u8, (i * 31 % 241) as u8, 255])
        .collect();
    Arc::new(Texture::new(width, height, bytes).expect("small sides and as many bytes"))
}

pub(super) fn textures(cases: &mut Vec<Case>) {
    let floor = |repeats: f64, shift: f64| {
        let mut mesh = terrain(1, repeats, || 0.0);
        for p in &mut mesh.positions {
            *p = v(p.x * 40.0, -1.0, p.z * 40.0);
        }
        for t in &mut mesh.texcoords {
            *t += DVec2::splat(shift);
        }
        let mut o = object("floor", mesh);
        o.cull = Cull::None;
        colored(o, DVec3::ONE)
    };
    let sizes = [(1, 1), (1, 7), (9, 1), (5, 3), (16, 16)];
    for (k, filter) in Filter::ALL.iter().copied().enumerate() {
        for (name, repeats, shift) in [
            ("a horizon at a grazing angle", 30.0, 0.25),
            ("negative texture coordinates", 4.0, -7.3),
            ("texture coordinates of 1e7", 20.0, 1e7),
            ("texture coordinates of 1e8", 2.0, 1e8),
        ] {
            let (w, h) = sizes[(k + name.len()) % sizes.len()];
            let mut o = floor(repeats, shift);
            let wrap_t = if k % 2 == 0 { Wrap::Repeat } else { Wrap::Clamp };
            o.texture = Some((noise(w, h), Sampling { filter, wrap_s: Wrap::Repeat, wrap_t }));
            cases.push(case(&format!("{name}, {} of {w}x{h}", filter.as_str()), vec![o]));
        }
    }
    for (w, h) in sizes {
        let mut mesh = terrain(1, 1.0, || 0.0);
        mesh.positions.iter_mut().for_each(|p| *p = v(p.x * 1.5, -p.z * 1.5, 0.0));
        let mut o = colored(object("card", mesh), DVec3::ONE);
        o.cull = Cull::None;
        let sampling = Sampling { filter: Filter::Trilinear, wrap_s: Wrap::Clamp, wrap_t: Wrap::Clamp };
        o.texture = Some((noise(w, h), sampling));
        cases.push(case(&format!("a {w}x{h} texture on a card"), vec![o]));
    }
}

pub(super) fn models(cases: &mut Vec<Case>) {
    let box_with = |name: &str, model: DMat4| {
        let mut o = object(name, box_mesh(v(0.9, 0.7, 0.8)));
        o.model = model * matrix::rotate(v(0.3, 1.0, 0.2), 0.7).unwrap_or(DMat4::IDENTITY);
        o
    };
    for (name, model) in [
        ("a mirrored model", matrix::scale(v(-1.0, 1.0, 1.0))),
        ("a model mirrored thrice", matrix::scale(v(-1.0, -1.2, -0.8))),
        ("a flattened model", matrix::scale(v(1.0, 1.0, 0.0))),
        ("a sheared model", matrix::shear(0.5, 0.2, 0.0, 0.0, -0.3, 0.4)),
    ] {
        for shade in [ShadeMode::Flat, ShadeMode::Phong] {
            let mut c = case(&format!("{name}, {}", shade.as_str()), vec![box_with("box", model)]);
            c.settings.shade = shade;
            cases.push(c);
        }
    }
    for scale in [1e-6, 1e6] {
        let mut c = case(
            &format!("everything times {scale:e}"),
            vec![box_with("box", matrix::scale(DVec3::splat(scale)))],
        );
        let look_at = LookAt { eye: v(0.0, 0.0, 5.0 * scale), reference: DVec3::ZERO, up: DVec3::Y };
        let projection =
            Projection::Perspective { fov_rad: 0.7, near: scale, far: 10.0 * scale, on_smaller_side: false };
        c = with_camera(c, look_at, projection);
        cases.push(c);
    }
    for far in [1e4, 1e7] {
        let shift = v(far, -0.5 * far, 0.7 * far);
        let mut c = case(
            &format!("camera and scene {far:e} from the origin"),
            vec![box_with("box", matrix::translate(shift))],
        );
        c.scene.objects[0].model = matrix::translate(shift) * box_with("", DMat4::IDENTITY).model;
        let look_at = LookAt { eye: v(0.0, 0.0, 5.0) + shift, reference: shift, up: DVec3::Y };
        c.scene.camera = Some(Camera { look_at, ..Camera::default() });
        cases.push(c);
    }
}

pub(super) fn views(cases: &mut Vec<Case>) {
    let turned = || {
        let mut o = object("box", box_mesh(v(1.0, 0.8, 0.9)));
        o.model = matrix::rotate(v(1.0, 0.7, 0.2), 0.9).unwrap_or(DMat4::IDENTITY);
        o
    };
    let at = |x, y, width, height, rule| Viewport { x, y, width, height, rule };
    for viewport in [
        at(-20, -10, 60, 40, ViewportRule::Corners),
        at(30, 20, 60, 40, ViewportRule::Centres),
        at(5, 7, 1, 1, ViewportRule::Corners),
        at(5, 7, 1, 9, ViewportRule::Centres),
        at(0, 0, 48, 36, ViewportRule::Centres),
        at(100, 100, 10, 10, ViewportRule::Corners),
    ] {
        let mut c = case(&format!("viewport {viewport:?}"), vec![turned()]);
        c.settings.viewport = Some(viewport);
        cases.push(c);
    }
}
