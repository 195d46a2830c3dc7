//! Large faces whose light is computed at the corners of cells and interpolated between them, against
//! the plain path, which lights each pixel; over vector widths, threads, and parts that hide each
//! other.
//!
//! Guards against light that is interpolated where it is not nearly linear: near lights, highlights,
//! the borders of radii, cones, faces and cells.

use super::fast_forms::{Drawn, Shot, plain, renderer};
use fbptr::memory::DepthFormat;
use fbptr::pipeline::{RenderPath, SceneOptions};
use fbptr::scene::{
    Attenuation, Camera, Cull, Light, LightKind, LightingModel, LookAt, Material, Mesh, Object, Projection,
    Scene, ShadeMode, Viewport,
};
use fbptr::simd::Level;
use fbptr::truth::scenes::{Random, object};
use glam::{DVec2, DVec3};
use std::sync::Arc;

/// Returns a light of one of all kinds, somewhere in the room.
fn light(r: &mut Random, i: u32) -> Light {
    let (position, direction) = (r.point(-5.0, 5.0), r.point(-1.0, 1.0));
    let fading = Attenuation { c: 1.0, l: r.real(0.0, 0.3), q: r.real(0.0, 0.1) };
    let attenuation = if r.one_in(2) { fading } else { Attenuation::NONE };
    let radius = if r.one_in(3) { r.real(2.0, 8.0) } else { f64::INFINITY };
    let angle = r.real(0.3, 1.3);
    let kind = match i % 5 {
        0 => LightKind::Directional { direction },
        1 => {
            let exponent = f64::from(r.below(4));
            LightKind::Spot { position, direction, angle_rad: angle, exponent, attenuation }
        }
        2 => {
            let cut_off_rad = if r.one_in(3) { r.real(1.6, 3.3) } else { angle };
            let beam_width_rad = cut_off_rad * r.real(0.1, 1.2);
            LightKind::X3dSpot { position, direction, beam_width_rad, cut_off_rad, attenuation, radius }
        }
        _ => LightKind::Point { position, attenuation, radius },
    };
    let ambient = if r.one_in(4) { r.point(0.0, 0.2) } else { DVec3::ZERO };
    Light { kind, color: r.point(0.1, 0.7), ambient, clamp_attenuation: r.one_in(2) }
}

/// Returns two large triangles, flat or with a normal of its own at each corner.
fn wall(r: &mut Random) -> Object {
    let (middle, across, up) = (r.point(-1.0, 1.0), r.point(-9.0, 9.0), r.point(-9.0, 9.0));
    let corners =
        vec![middle - across - up, middle + across - up, middle + across + up, middle - across + up];
    let mut mesh = Mesh::from_triangles(corners, &[[0, 1, 2], [0, 2, 3]]);
    if r.one_in(2) {
        let normal = across.cross(up).normalize();
        mesh.normals = (0..4).map(|_| (normal + 0.4 * r.point(-1.0, 1.0)).normalize()).collect();
        mesh.corners.iter_mut().for_each(|corner| corner.normal = corner.position);
    }
    let shine = if r.one_in(3) { 0.0 } else { r.real(0.1, 0.6) };
    let material = Material {
        kd: r.point(0.2, 0.9),
        ks: DVec3::splat(shine),
        n: r.pick(&[1.0, 2.0, 5.0, 12.8, 40.0, 200.0]),
        model: r.pick(&[LightingModel::Phong, LightingModel::Blinn]),
        ..Material::default()
    };
    Object { material, cull: Cull::None, two_sided_lighting: r.one_in(2), ..object("wall", mesh) }
}

/// Returns one mesh of many large faces that cut each other.
fn louvre(r: &mut Random) -> Object {
    let mut corners = Vec::new();
    for _ in 0..11 {
        let middle = r.point(-0.3, 0.3);
        corners.extend([0; 3].map(|_| middle + r.point(-9.0, 9.0)));
    }
    let faces: Vec<[u32; 3]> = (0..11).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    Object { cull: Cull::None, ..object("louvre", Mesh::from_triangles(corners, &faces)) }
}

/// Returns a room of walls that cut each other under some lights.
fn room(seed: u64, size: (u32, u32)) -> Shot {
    let mut r = Random::new(seed + 77);
    let mut objects: Vec<Object> = (0..1 + seed % 3).map(|_| wall(&mut r)).collect();
    if seed.is_multiple_of(5) {
        objects.push(louvre(&mut r));
    }
    let lights = (0..[1, 2, 9][seed as usize % 3]).map(|i| light(&mut r, i + seed as u32)).collect();
    let look_at = LookAt { eye: r.point(-4.0, 4.0), reference: r.point(-2.0, 2.0), up: DVec3::Y };
    let projection = match r.one_in(4) {
        true => Projection::Ortho { window: [-4.0, 4.0, -3.0, 3.0], near: -20.0, far: 20.0 },
        false => Projection::Perspective { fov_rad: 0.9, near: 0.1, far: 50.0, on_smaller_side: false },
    };
    let scene = Scene { objects, lights, camera: Some(Camera { look_at, projection }), ..Scene::default() };
    let mut options = SceneOptions::new(size.0, size.1);
    options.shade = ShadeMode::Phong;
    if seed % 2 == 1 {
        // The first row of tiles does not begin at a multiple of a cell.
        options.viewport = Viewport { x: 3, y: 5, width: size.0, height: size.1, ..options.viewport };
    }
    Shot { scene, options, format: DepthFormat::F32, size }
}

/// Draws a shot at every level, on one thread and more; returns the one drawing that all are.
fn at_every_level(shot: &Shot, seed: u64) -> Drawn {
    let mut levels = Level::ALL.into_iter().filter(|level| level.is_available());
    let first = levels.next().expect("a level");
    let own = shot.draw(&mut renderer(first, 1, RenderPath::Fast));
    for (i, level) in levels.enumerate() {
        let other = shot.draw(&mut renderer(level, 2 + i, RenderPath::Fast));
        assert!(own.bytes == other.bytes, "seed {seed}: {level:?} and {first:?} differ");
    }
    own
}

#[test]
fn interpolated_light_is_that_of_the_plain_path_at_every_level() {
    let (mut lit, mut apart, mut changed, mut too_far) = (0, 0, [0; 2], 0);
    for seed in 0..30 {
        let mut shot = room(seed, [(590, 310), (403, 190), (250, 131)][seed as usize % 3]);
        let truth = shot.draw(&mut plain());
        let own = at_every_level(&shot, seed);
        lit += truth.bytes.chunks_exact(4).filter(|pixel| pixel[..3] != [0; 3]).count();
        apart += own.bytes.iter().zip(&truth.bytes).filter(|(a, b)| a.abs_diff(**b) > 1).count();
        // Without interpolation, and within an error that can be seen, at every level alike.
        let mut within = |error| {
            shot.scene.objects.iter_mut().for_each(|object| object.light_error = Some(error));
            at_every_level(&shot, seed)
        };
        let (none, rough) = (within(0.0), within(6.0));
        changed[0] += none.bytes.iter().zip(&own.bytes).filter(|(a, b)| a != b).count();
        changed[1] += rough.bytes.iter().zip(&own.bytes).filter(|(a, b)| a != b).count();
        too_far += rough.bytes.iter().zip(&truth.bytes).filter(|(a, b)| a.abs_diff(**b) > 7).count();
    }
    println!(
        "{lit} pixels are lit; {apart} bytes differ by more than 1, {too_far} by more than 7; {changed:?} changed"
    );
    // A radius and a cone end at once: at their borders f32 and f64 may decide otherwise.
    assert!(lit > 250_000 && changed[0] > 200 && changed[1] > 200, "{lit} {changed:?}");
    assert!(apart * 100_000 < lit && too_far * 100_000 < lit, "{apart} {too_far} of {lit}");
}

#[test]
fn what_hides_a_part_of_a_face_does_not_change_the_rest() {
    let mut floor = room(4, (320, 200));
    floor.scene.objects.truncate(1);
    let mut mesh = Mesh::from_triangles(
        vec![DVec3::new(-40.0, -1.0, 5.0), DVec3::new(40.0, -1.0, 5.0), DVec3::new(0.0, -1.0, -60.0)],
        &[[0, 1, 2]],
    );
    mesh.texcoords = vec![DVec2::ZERO];
    floor.scene.objects[0] = Object { cull: Cull::None, ..object("floor", mesh) };
    floor.scene.objects[0].material.ks = DVec3::splat(0.3);
    floor.scene.lights = vec![Light::point(DVec3::new(1.0, 2.0, -4.0), DVec3::splat(0.9))];
    let look_at = LookAt { eye: DVec3::ZERO, reference: DVec3::new(0.0, -0.4, -1.0), up: DVec3::Y };
    let projection = Projection::Perspective { fov_rad: 1.0, near: 0.1, far: 90.0, on_smaller_side: false };
    floor.scene.camera = Some(Camera { look_at, projection });
    let alone = floor.draw(&mut renderer(Level::best(), 1, RenderPath::Fast));
    let mut hidden = floor.scene.clone();
    let leaf = |x: f64, z: f64| {
        let at = DVec3::new(x, -0.3, z);
        let corners = vec![at, at + DVec3::new(0.07, 0.0, 0.0), at + DVec3::new(0.0, 0.09, 0.0)];
        let mut leaf =
            Object { cull: Cull::None, ..object("leaf", Mesh::from_triangles(corners, &[[0, 1, 2]])) };
        leaf.material.emissive = DVec3::new(1.0, 0.0, 1.0);
        leaf
    };
    hidden.objects.extend((0..90).map(|i| leaf(f64::from(i % 15) * 0.3 - 2.0, -1.0 - f64::from(i / 15))));
    let seen = Shot { scene: hidden, ..floor }.draw(&mut renderer(Level::best(), 2, RenderPath::Fast));
    let pixels = alone.bytes.chunks_exact(4).zip(seen.bytes.chunks_exact(4));
    let (mut leaves, mut rest) = (0, 0);
    for (alone, seen) in pixels {
        match seen[0] == 255 && seen[2] == 255 {
            true => leaves += 1,
            false => {
                assert_eq!(alone, seen);
                rest += 1;
            }
        }
    }
    assert!(leaves > 500 && rest > 20_000, "{leaves} pixels of leaves, {rest} others");
}

#[test]
fn what_is_drawn_before_a_face_does_not_change_the_rest_of_it() {
    let mut rest = 0;
    for seed in 0..90 {
        let mut r = Random::new(seed + 501);
        let mut alone = room(seed, (403, 190));
        alone.scene.objects.truncate(1);
        // So much that cells differ from what is lit at each pixel.
        alone.scene.objects[0].light_error = Some([2.0, 6.0, 20.0][seed as usize % 3]);
        let own = alone.draw(&mut renderer(Level::best(), 1, RenderPath::Fast));
        // Long thin triangles before the eye, whose edges cut strips of pixels at small angles.
        let camera = alone.scene.camera.expect("a room has one").look_at;
        let ahead = camera.eye + 0.3 * (camera.reference - camera.eye).normalize();
        let mut blade = || {
            let corners = [0; 3].map(|_| ahead + r.point(-0.3, 0.3)).to_vec();
            let mesh = Mesh::from_triangles(corners, &[[0, 1, 2]]);
            let mut blade = Object { cull: Cull::None, ..object("blade", mesh) };
            blade.material = Material { emissive: DVec3::new(1.0, 0.0, 1.0), ..Material::default() };
            blade.material.model = LightingModel::Unlit;
            blade
        };
        let mut scene = alone.scene.clone();
        scene.objects.splice(0..0, [0; 9].map(|_| blade()));
        let cut = Shot { scene, ..alone }.draw(&mut renderer(Level::best(), 2, RenderPath::Fast));
        for (own, cut) in own.bytes.chunks_exact(4).zip(cut.bytes.chunks_exact(4)) {
            if cut[..3] != [255, 0, 255] {
                assert_eq!(own, cut, "seed {seed}");
                rest += usize::from(own[..3] != [0; 3]);
            }
        }
    }
    assert!(rest > 200_000, "{rest} pixels");
}

#[test]
fn matte_faces_under_directional_lights_have_the_same_bytes_at_every_level() {
    let (mut lit, mut apart) = (0, 0);
    for seed in 0..24 {
        let mut r = Random::new(seed + 901);
        let mut shot = room(seed, [(403, 190), (250, 131)][seed as usize % 2]);
        for (i, object) in shot.scene.objects.iter_mut().enumerate() {
            object.material.ks = DVec3::ZERO;
            if (seed as usize + i).is_multiple_of(2) {
                let mut mesh = object.geometry.mesh.clone();
                mesh.colors = (0..4).map(|_| r.point(0.2, 1.0).extend(1.0)).collect();
                mesh.corners.iter_mut().for_each(|corner| corner.color = corner.position % 4);
                object.geometry = Arc::new(mesh.into());
            }
        }
        let sun = |i: u32, r: &mut Random| {
            let ambient = if i == 1 { r.point(0.0, 0.2) } else { DVec3::ZERO };
            Light { ambient, ..Light::directional(r.point(-1.0, 1.0), r.point(0.1, 0.7)) }
        };
        shot.scene.lights = (0..1 + seed as u32 % 4).map(|i| sun(i, &mut r)).collect();
        let truth = shot.draw(&mut plain());
        let own = at_every_level(&shot, seed);
        lit += truth.bytes.chunks_exact(4).filter(|pixel| pixel[..3] != [0; 3]).count();
        apart += own.bytes.iter().zip(&truth.bytes).filter(|(a, b)| a.abs_diff(**b) > 1).count();
    }
    assert!(lit > 200_000 && apart * 100_000 < lit, "{apart} of {lit}");
}
