//! Colours: tables of small pictures, interpolation across a face, mip levels, light.

use super::*;
use crate::texture::{MipChain, UvFootprint};
use crate::{Settings, TruthPicture, render};
use fbptr_core::memory::DepthFormat;
use fbptr_core::scene::{
    Camera, Corner, Cull, Geometry, Light, LightKind, LightingModel, Material, Mesh, NONE, Object,
    Projection, Scene, Texture,
};
use glam::{DMat4, DVec4};
use std::sync::Arc;

fn triangle_object(name: &str, points: [DVec3; 3], material: Material) -> Object {
    let mesh = Mesh::from_triangles(points.to_vec(), &[[0, 1, 2]]);
    Object {
        name: name.into(),
        geometry: Arc::new(Geometry { mesh, textures: Vec::new() }),
        model: DMat4::IDENTITY,
        material,
        back_material: None,
        cull: Cull::Back,
        two_sided_lighting: false,
        shade: None,
        texture: None,
        lights: None,
        light_error: None,
        style: Default::default(),
    }
}

fn unlit(color: DVec3, transparency: f64) -> Material {
    Material { emissive: color, transparency, model: LightingModel::Unlit, ..Material::default() }
}

/// Returns the scene of a table: its camera, and its triangles in order.
fn table_scene(inputs: &Value) -> Scene {
    let eye = vector(&inputs["eye"]);
    let projection = Projection::Perspective {
        fov_rad: std::f64::consts::FRAC_PI_4,
        near: number(&inputs["near"]),
        far: number(&inputs["far"]),
        on_smaller_side: true,
    };
    let camera = Camera { look_at: LookAt { eye, reference: DVec3::ZERO, up: DVec3::Y }, projection };
    let objects = inputs["objects_in_order"].as_array().unwrap().iter().map(|o| {
        let points: Vec<DVec3> = o["points"].as_array().unwrap().iter().map(vector).collect();
        let mut object = triangle_object(
            o["name"].as_str().unwrap(),
            [points[0], points[1], points[2]],
            unlit(vector(&o["emissive"]), number(&o["transparency"])),
        );
        object.model = DMat4::from_translation(vector(&o["translation"]));
        object
    });
    Scene { camera: Some(camera), objects: objects.collect(), ..Scene::default() }
}

fn table_picture(scene: &Scene) -> TruthPicture {
    render(scene, 12, 10, DepthFormat::F32, &Settings::default()).unwrap()
}

fn assert_colors(picture: &TruthPicture, expected: &Value) {
    for (y, row) in expected.as_array().unwrap().iter().enumerate() {
        for (x, cell) in row.as_array().unwrap().iter().enumerate() {
            let states = picture.states(x as u32, y as u32);
            assert_eq!(states.len(), 1, "({x},{y})");
            all_near(&states[0].real[0].to_array(), cell, 1e-6);
        }
    }
}

#[test]
fn the_opaque_tables_of_003() {
    let g = golden("seed003_tables_opaque");
    let scene = table_scene(&g["inputs"]);
    let e = &g["expected"];
    let assert_depths = |picture: &TruthPicture, expected: &Value| {
        let cells = expected.as_array().unwrap().iter().flat_map(|r| r.as_array().unwrap());
        picture.depths().iter().zip(cells).for_each(|(z, cell)| near(*z, cell, 1e-6));
    };
    let red = Scene { objects: scene.objects[..1].to_vec(), ..scene.clone() };
    assert_depths(&table_picture(&red), &e["depth_red"]);
    let both = table_picture(&scene);
    assert_depths(&both, &e["depth_both"]);
    assert_colors(&both, &e["colour_with_zbuffer"]);
    let settings = Settings { hide: fbptr_core::scene::HiddenSurface::None, ..Settings::default() };
    let without = render(&scene, 12, 10, DepthFormat::F32, &settings).unwrap();
    assert_colors(&without, &e["colour_without_zbuffer"]);
}

#[test]
fn the_transparent_tables_of_003() {
    let g = golden("seed003_tables_transparent");
    let scene = table_scene(&g["inputs"]);
    let blue = Scene { objects: scene.objects[..1].to_vec(), ..scene.clone() };
    assert_colors(&table_picture(&blue), &g["expected"]["colour_after_blue"]);
    let both = table_picture(&scene);
    assert_colors(&both, &g["expected"]["colour_after_green"]);
    let rows = g["expected"]["colour_after_green_u8_round"].as_array().unwrap();
    let cells: Vec<f64> = rows.iter().flat_map(|r| r.as_array().unwrap()).flat_map(numbers).collect();
    let found: Vec<f64> = both.bytes().chunks(4).flat_map(|p| [p[0], p[1], p[2]]).map(f64::from).collect();
    assert_eq!(found, cells);
}

/// Returns the worked triangle of 003: screen corners, distances Z, and a value at each corner.
fn worked_triangle(inputs: &Value, z: &Value, corner: impl Fn(usize, &mut Mesh) -> Corner) -> Scene {
    let z = numbers(z);
    let mut mesh = Mesh::default();
    for (i, key) in ["P0", "P1", "P2"].iter().enumerate() {
        let p = numbers(&inputs[*key]);
        let ndc = [p[0] / 32.0 - 1.0, 1.0 - p[1] / 32.0];
        mesh.positions.push(DVec3::new(ndc[0] * z[i], ndc[1] * z[i], -z[i]));
    }
    let corners: Vec<Corner> = (0..3).map(|i| corner(i, &mut mesh)).collect();
    mesh.push_polygon(&corners, NONE);
    let mut object = triangle_object("worked", [DVec3::ZERO; 3], unlit(DVec3::ONE, 0.0));
    object.geometry = Arc::new(Geometry { mesh, textures: Vec::new() });
    let look_at = LookAt { eye: DVec3::ZERO, reference: DVec3::NEG_Z, up: DVec3::Y };
    let projection = Projection::Frustum { window: [-1.0, 1.0, -1.0, 1.0], near: 1.0, far: 100.0 };
    Scene { camera: Some(Camera { look_at, projection }), objects: vec![object], ..Scene::default() }
}

#[test]
fn perspective_correct_and_affine_colours_of_003() {
    let (weights, perspective) = (golden("seed003_barycentric"), golden("seed003_perspective_interp"));
    let scene = worked_triangle(&weights["inputs"], &perspective["inputs"]["Z"], |i, mesh| {
        mesh.colors
            .push(DVec4::from_array(std::array::from_fn(|k| if k == i || k == 3 { 1.0 } else { 0.0 })));
        Corner { position: i as u32, normal: NONE, texcoord: NONE, color: i as u32 }
    });
    for (interpolation, expected) in [
        (fbptr_core::scene::Interpolation::Perspective, &perspective["expected"]["colour"]),
        (fbptr_core::scene::Interpolation::Affine, &weights["expected"]["colour_affine"]),
    ] {
        let settings = Settings { interpolation, ..Settings::default() };
        let picture = render(&scene, 64, 64, DepthFormat::F32, &settings).unwrap();
        let states = picture.states(28, 22);
        assert_eq!(states.len(), 1);
        all_near(&states[0].real[0].to_array(), expected, 1e-12);
        let z = number(&perspective["expected"]["Z"]);
        assert!((states[0].z[0].to_f64() - 100.0 * (z - 1.0) / (z * 99.0)).abs() < 1e-14);
    }
}

#[test]
fn the_mip_level_of_003() {
    let g = golden("seed003_mip_level");
    let e = &g["expected"]["perspective_correct"];
    let size = number(&g["inputs"]["texture_size"]) as u32;
    let texture = Texture::new(size, size, vec![255; (size * size * 4) as usize]).unwrap();
    let uv = |k: &str| numbers(&e["uv"][k]);
    let step = |k: &str| [0, 1].map(|i| uv(k)[i] - uv("p00")[i]);
    let d = MipChain::new(&texture).level_of(UvFootprint::Steps([step("p10"), step("p01")]));
    near(d, &e["D"], 1e-12);
    // In a complete render, too: u is red, v is green, level 2 of a ramp of 32 texels.
    let ramp: Vec<u8> =
        (0..32 * 32).flat_map(|i| [(i % 32 * 8) as u8, ((31 - i / 32) * 8) as u8, 0, 255]).collect();
    let ramp = Arc::new(Texture::new(32, 32, ramp).unwrap());
    let mut scene = worked_triangle(&g["inputs"], &g["inputs"]["Z"], |i, mesh| {
        mesh.texcoords.push(glam::DVec2::from_slice(&numbers(&g["inputs"]["uv"][i])));
        Corner { position: i as u32, normal: NONE, texcoord: i as u32, color: NONE }
    });
    let filter = fbptr_core::scene::Filter::Mipmap;
    scene.objects[0].texture = Some((ramp, fbptr_core::scene::Sampling { filter, ..Default::default() }));
    let picture = render(&scene, 64, 64, DepthFormat::F32, &Settings::default()).unwrap();
    let states = picture.states(28, 22);
    assert_eq!(states.len(), 1);
    // Level 2 has 8 texels of mean 12 + 32 k; u = 0.247 lies between the centres of texels 1 and 2
    // (bilinear).
    let at = |t: f64| (12.0 + 32.0 * (t * 8.0 - 0.5)) / 255.0;
    let u = uv("p00");
    near(states[0].real[0].x, &Value::from(at(u[0])), 1e-12);
    near(states[0].real[0].y, &Value::from(at(u[1])), 1e-12);
}

#[test]
fn lighting_of_x3d() {
    for case in golden("extra_x3d_lighting")["expected"].as_array().unwrap() {
        let i = &case["inputs"];
        let n = |k: &str| number(&i[k]);
        let material = Material {
            ka: vector(&i["Od"]) * n("Oa"),
            kd: vector(&i["Od"]),
            ks: vector(&i["Os"]),
            n: 128.0 * n("sh"),
            emissive: vector(&i["Oe"]),
            model: LightingModel::Blinn,
            ..Material::default()
        };
        let light = Light {
            kind: LightKind::Directional { direction: -vector(&i["L"]) },
            color: vector(&i["Il"]) * n("Ii"),
            ambient: vector(&i["Il"]) * n("Iia"),
            clamp_attenuation: true,
        };
        let lighting = crate::light::ObjectLighting {
            ambient: DVec3::ZERO,
            lights: vec![&light],
            viewer: crate::ViewerPosition::Axis(vector(&i["Vv"])),
        };
        let lit = crate::light::light_point(&material, DVec3::ONE, DVec3::ZERO, vector(&i["N"]), &lighting);
        assert_eq!(lit.len(), 1, "{}", case["name"]);
        all_near(&(lit[0].diffuse_ambient + lit[0].specular_emissive).to_array(), &case["colour"], 1e-12);
    }
}
