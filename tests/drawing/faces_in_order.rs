//! Faces drawn in submission order whose light f32 carries badly: their bytes are the plain path's.
//!
//! Each kind of light loses digits in its own way: sharp highlights, narrow spots, bright lights at a
//! grazing angle, faces whose corners are far from the lamp above them, lights that fade early.
//! Guards against a pixel that f32 decides though its error reaches beyond a byte's boundary.

use super::fast_forms::{Shot, from_env, plain};
use fbptr::memory::DepthFormat;
use fbptr::pipeline::{Renderer, SceneOptions};
use fbptr::scene::{
    Attenuation, Cull, Fog, FogKind, Light, LightKind, LightingModel, Material, Scene, ShadeMode,
    TransparencyOrder,
};
use fbptr::truth::scenes::{Random, object, terrain};
use glam::{DMat4, DVec3};

/// Kinds of light that f32 carries badly.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Hard {
    Highlights,
    NarrowSpot,
    BrightLight,
    FarCorners,
    FarCornersInFog,
    FadedLights,
    SmallExponent,
}

const KINDS: [Hard; 7] = [
    Hard::Highlights,
    Hard::NarrowSpot,
    Hard::BrightLight,
    Hard::FarCorners,
    Hard::FarCornersInFog,
    Hard::FadedLights,
    Hard::SmallExponent,
];

/// Returns a point light.
fn lamp(position: DVec3, color: DVec3, attenuation: Attenuation) -> Light {
    let kind = LightKind::Point { position, attenuation, radius: f64::INFINITY };
    Light { kind, color, ambient: DVec3::ZERO, clamp_attenuation: false }
}

/// Returns the rotation of a kind's ground: where it is along an axis, its normals lose no digits.
fn tilt(kind: Hard) -> DMat4 {
    DMat4::from_rotation_x(if kind == Hard::BrightLight { 0.3 } else { 0.0 })
}

/// Returns lights of a kind over the ground around the origin.
fn lights(kind: Hard, r: &mut Random) -> Vec<Light> {
    let white = DVec3::splat(r.real(0.7, 1.2));
    let above = DVec3::new(r.real(-1.5, 1.5), r.real(1.0, 3.0), r.real(-1.5, 1.5));
    match kind {
        Hard::NarrowSpot => {
            let beam_width_rad = r.real(0.03, 0.1);
            let kind = LightKind::X3dSpot {
                position: above * 4.0,
                direction: r.point(-0.5, 0.5) - above * 4.0,
                beam_width_rad,
                cut_off_rad: beam_width_rad + 0.01,
                attenuation: Attenuation::NONE,
                radius: f64::INFINITY,
            };
            vec![Light { kind, color: white, ambient: DVec3::ZERO, clamp_attenuation: false }]
        }
        Hard::BrightLight => {
            let along = DVec3::new(1.0, -r.real(0.00003, 0.0003), 0.3);
            let kind = LightKind::Directional { direction: tilt(kind).transform_vector3(along) };
            vec![Light { kind, color: white * 3000.0, ambient: DVec3::ZERO, clamp_attenuation: false }]
        }
        Hard::FadedLights => {
            let mut faded =
                || lamp(r.point(-2.0, 2.0), DVec3::splat(9.0), Attenuation { c: 1.0, l: 0.0, q: 3e3 });
            let mut lights: Vec<_> = (0..5).map(|_| faded()).collect();
            lights.push(lamp(above, white, Attenuation::NONE));
            lights
        }
        _ => vec![lamp(above, white, Attenuation::NONE)],
    }
}

/// Returns a scene of a kind: ground of few faces or many, seen from above.
fn shot(kind: Hard, seed: u64) -> Shot {
    let mut r = Random::new(seed);
    let is_far = matches!(kind, Hard::FarCorners | Hard::FarCornersInFog);
    let (faces, size) = if is_far { (1, r.pick(&[1e3, 1e4, 1e5])) } else { (5, 2.0) };
    let roughness = match kind {
        Hard::FarCorners | Hard::FarCornersInFog => 0.0,
        Hard::BrightLight => 0.00005,
        _ => r.pick(&[0.0, 0.01, 0.3]),
    };
    let mut heights = Random::new(seed + 1);
    let mut ground = object("ground", terrain(faces, 1.0, || heights.real(0.0, 1.0) * roughness));
    ground.model = tilt(kind)
        * DMat4::from_rotation_y(r.real(0.0, 3.0))
        * DMat4::from_scale(DVec3::new(size, 1.0, size));
    let (ks, n) = match kind {
        Hard::Highlights => (0.9, r.pick(&[32.0, 128.0, 400.0, 1000.0])),
        Hard::SmallExponent => (0.9, r.pick(&[0.4, 0.5, 0.9])),
        Hard::FarCorners => (0.5, 32.0),
        _ => (0.0, 1.0),
    };
    ground.material = Material {
        ka: DVec3::ZERO,
        kd: r.point(0.3, 0.9),
        ks: DVec3::splat(ks),
        n,
        model: r.pick(&[LightingModel::Phong, LightingModel::Blinn]),
        transparency: r.pick(&[0.02, 0.3]),
        ..Material::default()
    };
    ground.cull = Cull::None;
    let mut scene = Scene { lights: lights(kind, &mut r), objects: vec![ground], ..Scene::default() };
    if kind == Hard::FarCornersInFog {
        scene.fog =
            Some(Fog { color: DVec3::ONE, kind: FogKind::Linear, visibility_range: r.real(8.0, 30.0) });
    }
    let size = (120, 90);
    let mut options = SceneOptions::new(size.0, size.1);
    (options.shade, options.transparency) = (ShadeMode::Phong, TransparencyOrder::FileOrder);
    options.camera.look_at.eye = DVec3::new(r.real(-1.0, 1.0), r.real(1.5, 3.0), 3.0);
    Shot { scene, options, format: DepthFormat::F32, size }
}

#[test]
fn faces_in_order_have_the_plain_paths_bytes_where_f32_loses_digits() {
    let mut fast = Renderer::default();
    let first = from_env("SEED", 1);
    for kind in KINDS {
        let (mut bytes, mut lit, mut unlike) = (0, 0, Vec::new());
        for seed in first..first + from_env("SCENES", 150) / 3 {
            let shot = shot(kind, seed);
            let (own, same) = (shot.draw(&mut fast), shot.draw(&mut plain()));
            let pixels = own.bytes.iter().zip(&same.bytes);
            let count = pixels.filter(|(a, b)| a != b).count();
            bytes += own.bytes.len();
            lit += own.bytes.chunks(4).filter(|p| p[..3].iter().any(|c| (1..255).contains(c))).count();
            if count > 0 {
                unlike.push((seed, count));
            }
        }
        let off: usize = unlike.iter().map(|(_, count)| count).sum();
        println!("{kind:?}: {off} of {bytes} bytes, {lit} pixels lit, {unlike:?}");
        assert!(lit * 50 > bytes, "{kind:?}: {lit} of {} pixels are lit", bytes / 4);
        // The error is estimated, not bounded: a byte of five million may be decided wrongly.
        assert!(off * 5_000_000 <= bytes, "{kind:?}: {off} of {bytes} bytes, {unlike:?}");
    }
}
