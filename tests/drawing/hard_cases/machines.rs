//! Equal bytes on every machine, at a cost in proportion to the visible pixels.

use super::textures::noise;
use super::*;

/// Returns a scene with one of everything: floor and loose triangles, textures, lights of each
/// kind, glass, fog.
fn everything() -> Scene {
    let mut r = fbptr::truth::scenes::Random::new(2026);
    let mut floor = terrain(9, 12.0, || r.real(-0.1, 0.1));
    floor.positions.iter_mut().for_each(|p| *p = DVec3::new(p.x * 9.0, p.y - 1.0, p.z * 9.0 - 3.0));
    let soup: Vec<DVec3> = (0..60).map(|_| r.point(-2.5, 2.5) - 4.0 * DVec3::Z).collect();
    let faces: Vec<[u32; 3]> = (0..20).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    let shiny = Material { ka: DVec3::ONE, ks: DVec3::splat(0.7), n: 37.0, ..Material::default() };
    let glass = Material { transparency: 0.4, model: LightingModel::Blinn, ..shiny.clone() };
    let sampling = Sampling { filter: Filter::Trilinear, ..Sampling::default() };
    let spot = LightKind::X3dSpot {
        position: DVec3::new(-1.0, 3.0, -3.0),
        direction: DVec3::new(0.2, -1.0, -0.3),
        beam_width_rad: 0.3,
        cut_off_rad: 0.7,
        attenuation: Attenuation { c: 0.2, l: 0.1, q: 0.01 },
        radius: 20.0,
    };
    let turn = matrix::rotate(DVec3::new(1.0, 2.0, 3.0), 0.7).unwrap();
    let objects = vec![
        Object { texture: Some((noise(37, 16), sampling)), ..both_sides(floor, shiny.clone()) },
        both_sides(Mesh::from_triangles(soup, &faces), glass),
        Object {
            model: matrix::translate(DVec3::new(0.5, 0.0, -4.0)) * turn,
            shade: Some(ShadeMode::Gouraud),
            ..object("box", fbptr::truth::scenes::box_mesh(DVec3::new(0.9, 0.6, 0.7)))
        },
    ];
    let mut s = scene(eye_at_origin(0.1, 60.0), objects);
    let direction = DVec3::new(0.4, -1.0, -0.8);
    s.lights.push(Light { kind: spot, clamp_attenuation: true, ..lamp(DVec3::ZERO) });
    s.lights.push(Light {
        kind: LightKind::Directional { direction },
        color: DVec3::new(0.1, 0.3, 0.6),
        ..lamp(DVec3::ZERO)
    });
    s.fog =
        Some(Fog { color: DVec3::new(0.5, 0.6, 0.7), kind: FogKind::Exponential, visibility_range: 30.0 });
    s.background.color = Some(DVec3::new(0.05, 0.1, 0.2));
    s
}

#[test]
fn the_same_bytes_every_time_and_on_every_machine() {
    let s = everything();
    let mut hasher = crc32fast::Hasher::new();
    for format in DepthFormat::ALL {
        for shade in [ShadeMode::Flat, ShadeMode::Phong] {
            let drawn = draw(&s, 96, format, &Settings { shade, ..Settings::default() });
            hasher.update(drawn.memory.bytes());
            (0..96 * 96).for_each(|i| hasher.update(&drawn.depth.as_ref().unwrap().word(i).to_le_bytes()));
        }
    }
    // Not compared with the truth: this is the checksum of the code on x86-64, which any machine
    // must give.
    assert_eq!(hasher.finalize(), 3_312_621_451);
    draw_right(&s, 64, &Settings::default());
}

#[test]
fn a_draw_of_a_whole_frame_takes_time_by_its_pixels() {
    // 64 layers of the whole frame, each nearer: the cost is in the pixels, so in a test build it
    // is a few hundred ns per pixel.
    let geometry = Geometry {
        mesh: triangle([[-9.0, -9.0, -2.0], [9.0, -9.0, -2.0], [0.0, 18.0, -2.0]]),
        textures: Vec::new(),
    };
    let material = glowing(DVec3::ONE);
    let mut memory = VideoMemory::new(128, 128).unwrap();
    let mut depth = None;
    let mut target =
        Target { memory: &mut memory, depth: &mut depth, depth_format: DepthFormat::F32, ids: None };
    let mut written = 0;
    for layer in 0..64 {
        let call = DrawCall {
            camera: eye_at_origin(0.1, 50.0),
            model: matrix::translate(DVec3::Z * (layer as f64 / 100.0)),
            ..DrawCall::new(&geometry, &material, 128, 128)
        };
        written += pipeline::draw(&mut target, &call).unwrap().pixels_written;
    }
    assert_eq!(written, 64 * 128 * 128);
}

/// Returns a number at the limits of f64.
fn wild(r: &mut fbptr::truth::scenes::Random) -> f64 {
    let far =
        [0.0, -0.0, 5e-324, 1e-200, -1e-30, 1e30, -1e150, 1e308, f64::NAN, f64::INFINITY, f64::NEG_INFINITY];
    r.pick(&far)
}

#[test]
fn no_number_anywhere_makes_a_draw_panic() {
    for seed in 0..400 {
        let mut r = fbptr::truth::scenes::Random::new(seed);
        let case = fbptr::truth::scenes::random(seed);
        let mut s = case.scene;
        for object in &mut s.objects {
            let mut geometry = (*object.geometry).clone();
            let mesh = &mut geometry.mesh;
            for _ in 0..3 {
                let (p, v) = (r.below(mesh.positions.len() as u32) as usize, wild(&mut r));
                mesh.positions[p][r.below(3) as usize] = v;
                if !mesh.texcoords.is_empty() {
                    let t = r.below(mesh.texcoords.len() as u32) as usize;
                    mesh.texcoords[t].x = wild(&mut r);
                }
                if !mesh.normals.is_empty() {
                    let n = r.below(mesh.normals.len() as u32) as usize;
                    mesh.normals[n].y = wild(&mut r);
                }
            }
            mesh.lines.push([0, mesh.corners.len() as u32 - 1]);
            mesh.points.push(1);
            object.geometry = Arc::new(geometry);
            object.material.n = wild(&mut r);
            object.material.kd.x = wild(&mut r);
            object.material.ks.y = wild(&mut r);
            object.material.transparency = wild(&mut r);
            if r.one_in(4) {
                object.model.w_axis.y = wild(&mut r);
                object.model.x_axis.x = wild(&mut r);
            }
        }
        for light in &mut s.lights {
            light.color.z = wild(&mut r);
            if let LightKind::Point { position, attenuation, .. } = &mut light.kind {
                position.x = wild(&mut r);
                attenuation.q = wild(&mut r);
            }
        }
        if let Some(camera) = s.camera.as_mut().filter(|_| r.one_in(3)) {
            camera.look_at.eye.x = wild(&mut r);
        }
        let mut memory = VideoMemory::new(16, 16).unwrap();
        let mut depth = None;
        let mut target =
            Target { memory: &mut memory, depth: &mut depth, depth_format: case.format, ids: None };
        let mut options = SceneOptions::new(16, 16);
        options.shade = r.pick(ShadeMode::ALL);
        options.hide = case.settings.hide;
        options.interp = case.settings.interpolation;
        // Refused or drawn: in both cases the depths are numbers.
        let _ = pipeline::draw_scene(&mut target, &s, &options);
        if let Some(depth) = depth {
            assert!((0..256).all(|i| (0.0..=1.0).contains(&depth.z(i % 16, i / 16).unwrap())), "seed {seed}");
        }
    }
}
