//! Parts of random scenes: lights, materials, textures, meshes, objects.

use super::{Random, box_mesh, object, terrain};
use fbptr_core::math::matrix;
use fbptr_core::scene::{
    Attenuation, Corner, Cull, Filter, Light, LightKind, LightingModel, Material, Mesh, NONE, Object,
    Sampling, ShadeMode, Texture, Wrap,
};
use glam::{DMat4, DVec2, DVec3, DVec4};
use std::sync::Arc;

pub(super) fn random_light(r: &mut Random) -> Light {
    let position = r.point(-5.0, 5.0);
    let direction = r.point(-1.0, 1.0);
    let attenuation = r.pick(&[
        Attenuation::NONE,
        Attenuation { c: 0.5, l: 0.1, q: 0.02 },
        Attenuation { c: 0.0, l: 0.0, q: 0.1 },
    ]);
    let radius = if r.one_in(4) { r.real(2.0, 8.0) } else { f64::INFINITY };
    let kind = match r.below(4) {
        0 => LightKind::Directional { direction },
        1 => LightKind::Point { position, attenuation, radius },
        2 => LightKind::Spot {
            position,
            direction: -position + r.point(-1.0, 1.0),
            angle_rad: r.real(0.1, 1.0),
            exponent: r.pick(&[0.0, 1.0, 10.0]),
            attenuation,
        },
        _ => LightKind::X3dSpot {
            position,
            direction: -position + r.point(-1.0, 1.0),
            beam_width_rad: r.real(0.05, 0.8),
            cut_off_rad: r.real(0.1, 0.8),
            attenuation,
            radius,
        },
    };
    let color = r.point(0.2, 1.6);
    let ambient = if r.one_in(3) { color * 0.2 } else { DVec3::ZERO };
    Light { kind, color, ambient, clamp_attenuation: r.one_in(2) }
}

fn random_material(r: &mut Random) -> Material {
    let model =
        r.pick(&[LightingModel::Phong, LightingModel::Phong, LightingModel::Blinn, LightingModel::Unlit]);
    Material {
        ka: r.point(0.0, 1.0),
        kd: r.point(0.0, 1.0),
        ks: if r.one_in(2) { r.point(0.0, 0.8) } else { DVec3::ZERO },
        n: r.pick(&[0.0, 1.0, 5.0, 32.0, 128.0, 1000.0]),
        emissive: if model == LightingModel::Unlit || r.one_in(3) { r.point(0.0, 0.9) } else { DVec3::ZERO },
        transparency: if r.one_in(4) { r.real(0.0, 1.0) } else { 0.0 },
        model: r.pick(&[
            LightingModel::Phong,
            LightingModel::Phong,
            LightingModel::Blinn,
            LightingModel::Unlit,
        ]),
        texture: None,
        name: String::new(),
    }
}

fn random_texture(r: &mut Random) -> (Arc<Texture>, Sampling) {
    let (width, height) = (r.pick(&[1, 2, 5, 16, 33]), r.pick(&[1, 3, 8, 16, 20]));
    let see_through = r.one_in(4);
    let bytes: Vec<u8> = (0..width * height)
        .flat_map(|_| {
            let b = r.bits().to_le_bytes();
            [b[0], b[1], b[2], if see_through { b[3] } else { 255 }]
        })
        .collect();
    let texture = Texture::new(width, height, bytes).expect("sides of 1 to 33 and as many bytes");
    let wrap = [Wrap::Repeat, Wrap::Clamp];
    let sampling = Sampling { filter: r.pick(Filter::ALL), wrap_s: r.pick(&wrap), wrap_t: r.pick(&wrap) };
    (Arc::new(texture), sampling)
}

/// Returns a mesh of a random kind, most within about [-2,2]^3.
fn random_mesh(r: &mut Random) -> Mesh {
    match r.below(6) {
        0 => box_mesh(r.point(0.3, 1.5)),
        1 => {
            let n = 2 + r.below(6);
            let mut dice = r.clone();
            let mut mesh = terrain(n, r.real(0.5, 8.0), || dice.real(-0.4, 0.4));
            mesh.positions.iter_mut().for_each(|p| *p *= 2.0);
            mesh
        }
        2 => triangle_soup(r, 12, 2.0),
        // Through the eye plane and far behind it.
        3 => triangle_soup(r, 6, 15.0),
        4 => slivers(r),
        _ => star(r),
    }
}

/// Returns separate triangles with texture coordinates, some with their own normals and colours.
fn triangle_soup(r: &mut Random, count: u32, reach: f64) -> Mesh {
    let mut mesh = Mesh::default();
    let (normals, colors) = (r.one_in(3), r.one_in(3));
    for _ in 0..count {
        let corners: [Corner; 3] = std::array::from_fn(|_| {
            let i = mesh.positions.len() as u32;
            mesh.positions.push(r.point(-reach, reach));
            mesh.texcoords.push(DVec2::new(r.real(-2.0, 3.0), r.real(-2.0, 3.0)));
            mesh.normals.push(r.point(-1.0, 1.0));
            mesh.colors.push(r.point(0.0, 1.3).extend(1.0));
            let or_none = |on: bool| if on { i } else { NONE };
            Corner { position: i, normal: or_none(normals), texcoord: i, color: or_none(colors) }
        });
        mesh.push_polygon(&corners, NONE);
    }
    mesh
}

/// Returns triangles as thin as 1e-6 of their length, as fans with shared edges.
fn slivers(r: &mut Random) -> Mesh {
    let mut positions = vec![r.point(-1.5, 1.5)];
    let (a, mut b) = (r.point(-2.0, 2.0), r.point(-2.0, 2.0));
    let mut triangles = Vec::new();
    for i in 0..10u32 {
        positions.push(b);
        let thin = r.pick(&[1e-1, 1e-2, 1e-3, 1e-6]);
        b += (a - b) * thin;
        if i > 0 {
            triangles.push([0, i, i + 1]);
        }
    }
    Mesh::from_triangles(positions, &triangles)
}

/// Returns a concave star polygon in a tilted plane.
fn star(r: &mut Random) -> Mesh {
    let mut mesh = Mesh::default();
    let tilt = r.point(-0.5, 0.5);
    let points = 4 + r.below(4);
    let corners: Vec<Corner> = (0..2 * points)
        .map(|i| {
            let (sin, cos) = libm::sincos(std::f64::consts::PI * i as f64 / points as f64);
            let radius = if i % 2 == 0 { 1.8 } else { 0.7 };
            let (x, y) = (radius * cos, radius * sin);
            mesh.positions.push(DVec3::new(x, y, tilt.x * x + tilt.y * y + tilt.z));
            mesh.texcoords.push(DVec2::new(x, y));
            mesh.colors.push(DVec4::new(cos.abs(), sin.abs(), 1.0, 1.0));
            Corner { position: i, normal: NONE, texcoord: i, color: i }
        })
        .collect();
    mesh.push_polygon(&corners, NONE);
    mesh
}

pub(super) fn random_object(r: &mut Random, index: u32, lights: u32) -> Object {
    let mesh = random_mesh(r);
    let turn = matrix::rotate(r.point(-1.0, 1.0), r.real(0.0, 6.0)).unwrap_or(DMat4::IDENTITY);
    let mut size = r.point(0.6, 1.6);
    if r.one_in(4) {
        size.x = -size.x;
    }
    let mut model = matrix::translate(r.point(-1.0, 1.0)) * turn * matrix::scale(size);
    if r.one_in(5) {
        model *= matrix::shear(r.real(-0.5, 0.5), 0.0, 0.2, 0.0, r.real(-0.5, 0.5), 0.1);
    }
    Object {
        model,
        material: random_material(r),
        back_material: r.one_in(6).then(|| random_material(r)),
        cull: r.pick(&[Cull::Back, Cull::Back, Cull::None, Cull::None, Cull::Front]),
        two_sided_lighting: r.one_in(3),
        shade: r.one_in(5).then(|| r.pick(&[ShadeMode::Flat, ShadeMode::Gouraud, ShadeMode::Phong])),
        texture: r.one_in(3).then(|| random_texture(r)),
        lights: (lights > 0 && r.one_in(5)).then(|| (0..lights).filter(|i| i % 2 == 0).collect()),
        ..object(&format!("object {index}"), mesh)
    }
}
