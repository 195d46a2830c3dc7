//! The scenes themselves, made by fixed rules and a fixed seed.

use super::pieces::{box_of, material, perspective, texture, textured, turned};
use crate::scene::{
    Attenuation, Corner, Cull, Filter, Geometry, Light, LightKind, Mesh, NONE, Object, Scene, ShadeMode,
    shapes,
};
use crate::truth::scenes::{Random, object};
use glam::{DMat4, DVec3};
use std::sync::Arc;

/// S1: walls, floor and ceiling around the eye, a beam, a rail and a carpet that run through the eye's plane, columns, and a knot
/// in the middle; four lights of three kinds.
pub(super) fn room(divisor: u32) -> Scene {
    let tiles = texture(256);
    let mut objects = Vec::new();
    let mut add = |name: &str, mesh: Mesh, at: [f64; 3], kd: [f64; 3]| {
        let mut thing = object(name, mesh);
        thing.model = DMat4::from_translation(DVec3::from(at));
        thing.material = material(DVec3::from(kd));
        objects.push(thing);
        objects.len() - 1
    };
    let walls =
        add("walls", box_of(DVec3::new(12.0, 4.0, 10.0), 3.0, true), [0.0, 2.0, 0.0], [0.8, 0.75, 0.7]);
    let carpet =
        add("carpet", box_of(DVec3::new(7.0, 0.05, 9.0), 6.0, false), [0.0, 0.03, 0.0], [0.9, 0.9, 0.9]);
    add("beam", box_of(DVec3::new(0.4, 0.4, 9.9), 1.0, false), [2.0, 3.5, 0.0], [0.5, 0.3, 0.2]);
    add("rail", box_of(DVec3::new(11.0, 0.1, 0.2), 1.0, false), [0.0, 1.0, 3.9], [0.3, 0.5, 0.3]);
    for i in 0..12 {
        let (sin, cos) = libm::sincos(f64::from(i) * 0.55);
        let at = [5.2 * cos, 1.9, 4.2 * sin];
        add("column", box_of(DVec3::new(0.4, 3.7, 0.4), 1.0, false), at, [0.4, 0.45, 0.6]);
    }
    let mesh = shapes::knot((500 / divisor).max(16), 40).expect("a knot of 40,000 faces");
    add("knot", mesh, [-0.5, 1.5, -1.0], [0.8, 0.4, 0.2]);
    objects[walls].texture = textured(&tiles, Filter::Trilinear);
    objects[carpet].texture = textured(&tiles, Filter::Bilinear);
    let fading = Attenuation { c: 0.6, l: 0.1, q: 0.02 };
    let point_light =
        |at: [f64; 3]| LightKind::Point { position: at.into(), attenuation: fading, radius: 30.0 };
    let spot = LightKind::Spot {
        position: DVec3::new(0.0, 3.8, 0.0),
        direction: DVec3::new(-0.1, -1.0, -0.2),
        angle_rad: 0.7,
        exponent: 4.0,
        attenuation: fading,
    };
    let light = |kind, color| Light { kind, color, ambient: DVec3::ZERO, clamp_attenuation: true };
    Scene {
        camera: Some(perspective(DVec3::new(1.2, 1.6, 3.4), DVec3::new(-1.0, 1.2, -2.0), 0.05, 50.0)),
        ambient: DVec3::splat(0.4),
        lights: vec![
            light(point_light([3.0, 3.4, 2.0]), DVec3::new(0.5, 0.45, 0.4)),
            light(point_light([-3.5, 3.4, -2.5]), DVec3::new(0.3, 0.4, 0.5)),
            light(spot, DVec3::splat(0.5)),
            Light::directional(DVec3::new(0.3, -1.0, -0.4), DVec3::splat(0.15)),
        ],
        objects,
        ..Scene::default()
    }
}

/// S2: quads of half the frame and more before each other, each lit at its pixels, far to near.
pub(super) fn layers(count: u32) -> Scene {
    let mut random = Random::new(64);
    let quad = |i: u32| {
        let half = DVec3::new(random.real(1.6, 3.4), random.real(0.9, 1.8), 0.0);
        let mesh = {
            let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
            let positions = corners.map(|[x, y]| DVec3::new(x, y, 0.0) * half).to_vec();
            Mesh::from_triangles(positions, &[[0, 1, 2], [0, 2, 3]])
        };
        let mut layer = object("layer", mesh);
        let z = 4.0 * f64::from(i) / f64::from(count) - 2.0;
        let at = DVec3::new(random.real(-1.0, 1.0), random.real(-0.6, 0.6), z);
        layer.model = DMat4::from_translation(at) * turned(random.point(-1.0, 1.0) + DVec3::X, 0.15);
        layer.material = material(random.point(0.2, 1.0));
        layer.material.transparency = random.real(0.6, 0.95);
        layer
    };
    let objects = (0..count).map(quad).collect();
    Scene {
        camera: Some(perspective(DVec3::new(0.0, 0.0, 5.0), DVec3::ZERO, 0.5, 20.0)),
        ambient: DVec3::splat(0.5),
        lights: vec![Light::point(DVec3::new(3.0, 4.0, 5.0), DVec3::ONE)],
        objects,
        ..Scene::default()
    }
}

/// S7: walls over the whole frame, each of a thousand faces that run up and down, behind one another.
pub(super) fn walls(divisor: u32) -> Scene {
    let (across, up) = ((40 / divisor).max(4), 14);
    let wall = |i: u32| {
        let mut mesh = Mesh::default();
        for y in 0..=up {
            for x in 0..=across {
                let at =
                    [f64::from(x) / f64::from(across), f64::from(y) / f64::from(up)].map(|t| 2.0 * t - 1.0);
                let height = if (x + y + i).is_multiple_of(2) { 0.03 } else { -0.03 };
                mesh.positions.push(DVec3::new(at[0] * 3.4, at[1] * 2.0, height));
            }
        }
        for y in 0..up {
            for x in 0..across {
                let first = y * (across + 1) + x;
                let corners = [first, first + 1, first + across + 2, first + across + 1];
                let corner = |position| Corner { position, normal: NONE, texcoord: NONE, color: NONE };
                mesh.push_polygon(&corners.map(corner), NONE);
            }
        }
        let mut thing = object("wall", mesh);
        thing.model = DMat4::from_translation(DVec3::new(0.0, 0.0, 2.5 - 0.1 * f64::from(i)));
        thing.material = material(DVec3::new(0.9, 0.2 + 0.02 * f64::from(i), 0.5));
        thing
    };
    Scene {
        camera: Some(perspective(DVec3::new(0.0, 0.0, 5.0), DVec3::ZERO, 0.5, 20.0)),
        ambient: DVec3::splat(0.3),
        lights: vec![Light::point(DVec3::new(3.0, 4.0, 6.0), DVec3::ONE)],
        objects: (0..32).map(wall).collect(),
        ..Scene::default()
    }
}

/// S3: boxes on a lattice, each with its own model, and other modes than its neighbour's. Half of them share one geometry.
pub(super) fn boxes(count: u32) -> Scene {
    let mut random = Random::new(10_000);
    let side = libm::ceil(libm::cbrt(f64::from(count))).max(1.0);
    let step = 6.0 / side;
    let shared = Arc::new(Geometry { mesh: box_of(DVec3::ONE, 1.0, false), textures: Vec::new() });
    let skin = texture(64);
    let thing = |i: u32| -> Object {
        let at = [1.0, side, side * side].map(|d| libm::floor(f64::from(i) / d) % side);
        let mut thing = object("box", Mesh::default());
        thing.geometry = match i % 2 {
            0 => Arc::clone(&shared),
            _ => Arc::new(Geometry::clone(&shared)),
        };
        let place = (DVec3::from(at) + 0.5) * step - 3.0;
        let size = DVec3::splat(step * random.real(0.3, 0.7));
        thing.model = DMat4::from_translation(place)
            * turned(random.point(-1.0, 1.0) + DVec3::X * 1.5, random.real(0.0, 6.0))
            * DMat4::from_scale(size);
        thing.material = material(random.point(0.2, 1.0));
        thing.shade = Some([ShadeMode::Phong, ShadeMode::Gouraud, ShadeMode::Flat][i as usize % 3]);
        thing.cull = if i.is_multiple_of(4) { Cull::None } else { Cull::Back };
        thing.texture = textured(&skin, Filter::Bilinear).filter(|_| i.is_multiple_of(5));
        thing.lights = i.is_multiple_of(7).then(|| vec![i % 2]);
        thing
    };
    let objects = (0..count).map(thing).collect();
    Scene {
        camera: Some(perspective(DVec3::new(2.0, 2.5, 7.5), DVec3::ZERO, 0.5, 30.0)),
        ambient: DVec3::splat(0.5),
        lights: vec![
            Light::point(DVec3::new(3.0, 4.0, 9.0), DVec3::splat(0.7)),
            Light::directional(DVec3::new(-1.0, -0.5, -0.7), DVec3::splat(0.4)),
        ],
        objects,
        ..Scene::default()
    }
}

/// A knot of about so many faces, eight times as many around its core as across.
pub(super) fn mesh_of(faces: u32) -> Mesh {
    let across = libm::round(libm::sqrt(f64::from(faces) / 16.0)).max(5.0) as u32;
    shapes::knot((8 * across).max(16), across).expect("a knot of at most 4 million faces")
}

pub(super) fn knot(mesh: Mesh) -> Scene {
    let mut thing = object("knot", mesh);
    thing.model = turned(DVec3::X, 0.3) * turned(DVec3::Y, 0.4);
    thing.material = material(DVec3::new(0.8, 0.4, 0.2));
    Scene {
        camera: Some(perspective(DVec3::new(0.0, 0.0, 3.6), DVec3::ZERO, 0.5, 10.0)),
        ambient: DVec3::splat(0.3),
        lights: vec![Light::point(DVec3::new(3.0, 4.0, 5.0), DVec3::ONE)],
        objects: vec![thing],
        ..Scene::default()
    }
}

/// S6: the knot among so many lights.
pub(super) fn lit_knot(mesh: Mesh, count: u32) -> Scene {
    let share = DVec3::splat(1.5 / f64::from(count));
    let light = |i: u32| {
        let (sin, cos) = libm::sincos(f64::from(i) * 2.4);
        let at = DVec3::new(4.0 * cos, 4.0 * sin, 2.0 + f64::from(i % 4));
        if i.is_multiple_of(4) { Light::directional(-at, share) } else { Light::point(at, share) }
    };
    Scene { lights: (0..count).map(light).collect(), ..knot(mesh) }
}
