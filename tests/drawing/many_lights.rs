//! Many lights of bounded reach, of which each tile has its own list, against the plain path, which
//! goes through all lights at each pixel; over vector widths and threads.
//!
//! Guards against a light that is left out where it shines, at the border of a radius, of a cone, of
//! a tile.

use super::fast_forms::{Shot, plain, renderer};
use fbptr::memory::DepthFormat;
use fbptr::pipeline::RenderPath;
use fbptr::scene::{Attenuation, HiddenSurface, Light, LightKind, ShadeMode};
use fbptr::simd::Level;
use fbptr::truth::scenes::Random;
use glam::DVec3;

/// Returns a light near the scene, of one of all kinds.
fn light(r: &mut Random, i: usize) -> Light {
    let (position, direction) = (r.point(-4.0, 4.0), r.point(-1.0, 1.0));
    let attenuation = Attenuation { c: 1.0, l: r.real(0.0, 0.5), q: r.real(0.2, 2.0) };
    let radius =
        [r.real(0.5, 4.0), f64::INFINITY, 0.0, -1.0][if i.is_multiple_of(9) { i / 9 % 4 } else { 0 }];
    let angle = r.real(0.1, 1.7);
    let kind = match i % 4 {
        0 | 1 => LightKind::Point { position, attenuation, radius },
        2 => {
            let exponent = f64::from(i as u32 % 3) * 2.0;
            LightKind::Spot { position, direction, angle_rad: angle, exponent, attenuation }
        }
        _ => {
            let (beam_width_rad, cut_off_rad) = (angle * r.real(0.1, 0.9), angle);
            LightKind::X3dSpot { position, direction, beam_width_rad, cut_off_rad, attenuation, radius }
        }
    };
    let ambient = if i.is_multiple_of(5) { r.point(0.0, 0.1) } else { DVec3::ZERO };
    Light { kind, color: r.point(0.2, 1.0), ambient, clamp_attenuation: i.is_multiple_of(2) }
}

#[test]
fn many_lights_shine_as_by_the_plain_path_at_every_level() {
    let levels: Vec<_> = Level::ALL.into_iter().filter(|level| level.is_available()).collect();
    let (mut seen, mut differing, mut apart) = (0, 0, 0);
    for seed in 0..24 {
        let mut r = Random::new(seed + 1);
        let mut shot = Shot::random(seed, [(290, 70), (131, 140)][seed as usize % 2]);
        (shot.format, shot.options.hide) = (DepthFormat::F32, HiddenSurface::ZBuffer);
        shot.options.shade = [ShadeMode::Phong, ShadeMode::Phong, ShadeMode::Gouraud][seed as usize % 3];
        let dark = shot.draw(&mut plain()).bytes;
        let count = [7, 24, 70][seed as usize / 2 % 3];
        shot.scene.lights = (0..count).map(|i| light(&mut r, i)).collect();
        let (truth, own) =
            (shot.draw(&mut plain()), shot.draw(&mut renderer(levels[0], 1, RenderPath::Fast)));
        seen += truth.bytes.iter().zip(&dark).filter(|(a, b)| a != b).count();
        differing += own.bytes.iter().zip(&truth.bytes).filter(|(a, b)| a != b).count();
        apart += own.bytes.iter().zip(&truth.bytes).filter(|(a, b)| a.abs_diff(**b) > 1).count();
        for (i, level) in levels.iter().enumerate() {
            let other = shot.draw(&mut renderer(*level, 1 + i, RenderPath::Fast));
            assert!(own.bytes == other.bytes, "seed {seed}: {level:?} and {:?} differ", levels[0]);
        }
    }
    println!("{seen} bytes are lit, {differing} differ, {apart} by more than 1");
    // A radius and a cone end at once: at their borders f32 and f64 may decide otherwise.
    assert!(seen > 100_000 && apart * 20_000 < seen && differing * 200 < seen, "{seen} {differing} {apart}");
}
