//! The reference against the worked numbers of the sources (tests/data/golden).

use super::camera::{Sight, transform};
use super::texture::{Footprint, Pyramid};
use super::wide::{Wide, Wide4};
use super::{Settings, TruthPicture, render};
use crate::memory::DepthFormat;
use crate::scene::{
    Camera, Corner, Cull, Geometry, Light, LightKind, LightingModel, LookAt, Material, Mesh, NONE, Object,
    ObliqueKind, Projection, Scene, Texture, Viewport, ViewportRule,
};
use glam::{DMat4, DVec3, DVec4};
use serde_json::Value;
use std::sync::Arc;

fn golden(name: &str) -> Value {
    let path = format!("{}/tests/data/golden/{name}.json", env!("CARGO_MANIFEST_DIR"));
    serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
}

fn number(v: &Value) -> f64 {
    v.as_f64().unwrap_or_else(|| panic!("not a number: {v}"))
}

fn numbers(v: &Value) -> Vec<f64> {
    v.as_array().unwrap_or_else(|| panic!("not a list: {v}")).iter().map(number).collect()
}

fn vector(v: &Value) -> DVec3 {
    DVec3::from_slice(&numbers(v))
}

fn near(found: f64, expected: &Value, tolerance: f64) {
    let expected = number(expected);
    let off = (found - expected).abs();
    assert!(off <= tolerance * expected.abs().max(1.0), "found {found}, expected {expected}");
}

fn all_near(found: &[f64], expected: &Value, tolerance: f64) {
    let expected = expected.as_array().unwrap();
    assert_eq!(found.len(), expected.len());
    found.iter().zip(expected).for_each(|(f, e)| near(*f, e, tolerance));
}

fn point4(v: &Value) -> Wide4 {
    let n = numbers(v);
    [n[0], n[1], n[2], n.get(3).copied().unwrap_or(1.0)].map(Wide::new)
}

fn narrow(p: Wide4) -> [f64; 4] {
    p.map(Wide::to_f64)
}

fn corners_viewport(width: u32, height: u32) -> Viewport {
    Viewport { x: 0, y: 0, width, height, rule: ViewportRule::Corners }
}

fn look_at(eye: &Value, reference: &Value, up: &Value) -> LookAt {
    LookAt { eye: vector(eye), reference: vector(reference), up: vector(up) }
}

#[test]
fn camera_matrix_of_004() {
    for case in golden("seed004_camera_matrix")["expected"].as_array().unwrap() {
        let look_at = look_at(&case["eye"], &case["ref"], &case["vup"]);
        let camera = Camera { look_at, ..Camera::default() };
        let sight = Sight::new(&camera, &corners_viewport(4, 3)).unwrap();
        for (row, expected) in sight.view.iter().zip(case["C"].as_array().unwrap()) {
            all_near(&narrow(*row), expected, 1e-13);
        }
    }
}

#[test]
fn view_plane_distance_of_001() {
    for case in golden("seed001_pipeline_matrices")["expected"].as_array().unwrap() {
        let i = &case["inputs"];
        let (width, height) = (number(&i["width"]) as u32, number(&i["height"]) as u32);
        let projection = Projection::Plane { d: number(&i["d"]), near: 0.5, far: 20.0 };
        let camera = Camera { look_at: look_at(&i["eye"], &i["lookat"], &i["up"]), projection };
        let viewport = Viewport { rule: ViewportRule::Centres, ..corners_viewport(width, height) };
        let sight = Sight::new(&camera, &viewport).unwrap();
        let (sin, cos) = libm::sincos(number(&i["model_rotation_y"]));
        for p in case["points"].as_array().unwrap() {
            let o = numbers(&p["object"]);
            let turned = [o[0] * cos + o[2] * sin, o[1], -o[0] * sin + o[2] * cos, 1.0].map(Wide::new);
            let clip = transform(&sight.projection, transform(&sight.view, turned));
            let ndc = [clip[0] / clip[3], clip[1] / clip[3]];
            all_near(&ndc.map(Wide::to_f64), &Value::from(numbers(&p["canonical"])[..2].to_vec()), 1e-12);
            // The source's whole numbers are pixel centres; here they lie at .5.
            let screen = sight.to_screen(ndc[0], ndc[1]).map(|c| c.to_f64() - 0.5);
            all_near(&screen, &Value::from(numbers(&p["screen"])[..2].to_vec()), 1e-12);
        }
    }
}

#[test]
fn viewing_transformation_of_000() {
    for case in golden("seed000_viewing_transformation")["expected"].as_array().unwrap() {
        let i = &case["inputs"];
        let n = |k: &str| number(&i[k]);
        let projection = Projection::Window {
            vrp: vector(&i["VRP"]),
            p: vector(&i["P"]),
            vup: vector(&i["VUP"]),
            center: [n("CU"), n("CV")],
            half: [n("SU"), n("SV")],
            dp: n("DP"),
            near: n("near"),
            far: n("far"),
        };
        let v = |k: &str| number(&i["viewport"][k]) as i32;
        let viewport = Viewport {
            x: v("umin"),
            y: v("vmin"),
            width: (v("umax") - v("umin") + 1) as u32,
            height: (v("vmax") - v("vmin") + 1) as u32,
            rule: ViewportRule::Centres,
        };
        let camera = Camera { projection, ..Camera::default() };
        let sight = Sight::new(&camera, &viewport).unwrap();
        let m1 = super::camera::multiply(&sight.projection, &sight.view);
        for (row, expected) in m1.iter().zip(case["matrices"]["M1"].as_array().unwrap()) {
            all_near(&narrow(*row), expected, 1e-12);
        }
        for p in case["points"].as_array().unwrap() {
            let clip = transform(&m1, point4(&p["world"]));
            all_near(&narrow(clip), &p["clip"], 1e-12);
            let screen = sight.to_screen(clip[0] / clip[3], clip[1] / clip[3]).map(Wide::to_f64);
            all_near(&screen, &Value::from(numbers(&p["screen"])[..2].to_vec()), 1e-12);
        }
        for c in case["view_volume_corners"].as_array().unwrap() {
            let clip = transform(&m1, point4(&c["world"]));
            all_near(&[0, 1, 2].map(|k| (clip[k] / clip[3]).to_f64()), &c["ndc"], 1e-12);
        }
    }
}

/// The goldens keep the picture's own units; a window of half extents 1 makes NDC of them.
#[test]
fn parallel_projections_of_004() {
    let (window, near_far) = ([-1.0, 1.0, -1.0, 1.0], (-10.0, 10.0));
    let (near, far) = near_far;
    for case in golden("seed004_parallel_projections")["expected"].as_array().unwrap() {
        let name = case["name"].as_str().unwrap();
        let oblique = |kind, degrees: f64| Projection::Oblique {
            kind,
            angle_rad: degrees.to_radians(),
            window,
            near,
            far,
        };
        // The oblique goldens shear about z = 0: a camera at z = 1 that looks at the origin.
        let projection = match name {
            "plan_xy" => Projection::Ortho { window, near, far },
            "cavalier_45" => oblique(ObliqueKind::Cavalier, 45.0),
            "cavalier_60" => oblique(ObliqueKind::Cavalier, 60.0),
            "cabinet_45" => oblique(ObliqueKind::Cabinet, 45.0),
            "cabinet_60" => oblique(ObliqueKind::Cabinet, 60.0),
            "isometric" => Projection::Isometric { window, near, far },
            "pseudo_isometric_30" => Projection::PseudoIsometric { window, near, far },
            // Elevations are plans of a turned camera.
            "elevation_xz" | "elevation_zy" => continue,
            other => panic!("unknown golden {other}"),
        };
        let look_at = LookAt { eye: DVec3::Z, reference: DVec3::ZERO, up: DVec3::Y };
        let sight = Sight::new(&Camera { look_at, projection }, &corners_viewport(8, 8)).unwrap();
        let turns = name.contains("isometric");
        for p in case["unit_cube"].as_array().unwrap() {
            // The turns are about the eye, which the golden has at the origin.
            let mut world = point4(&p["p"]);
            if turns {
                world[2] += Wide::ONE;
            }
            let clip = transform(&sight.projection, transform(&sight.view, world));
            all_near(&[clip[0].to_f64(), clip[1].to_f64()], &p["projected"], 1e-12);
        }
    }
}

#[test]
fn frustum_to_box_of_004() {
    for case in golden("seed004_frustum_to_box")["expected"].as_array().unwrap() {
        let (near, far) = (number(&case["near"]), number(&case["far"]));
        let window = [-1.0, 1.0, -1.0, 1.0];
        let projection = Projection::Frustum { window, near, far };
        let look_at = LookAt { eye: DVec3::ZERO, reference: DVec3::NEG_Z, up: DVec3::Y };
        let sight = Sight::new(&Camera { look_at, projection }, &corners_viewport(8, 8)).unwrap();
        for p in case["points"].as_array().unwrap() {
            let clip = transform(&sight.projection, transform(&sight.view, point4(&p["eye"])));
            let [x, y, z] = [0, 1, 2].map(|k| (clip[k] / clip[3]).to_f64());
            // The source's box keeps -near..-far; here it is 0..1.
            let boxed = [x, y, -(near + z * (far - near))];
            all_near(&boxed, &p["P"]["projected"], 1e-12);
        }
    }
}

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
    }
}

fn unlit(color: DVec3, transparency: f64) -> Material {
    Material { emissive: color, transparency, model: LightingModel::Unlit, ..Material::default() }
}

/// The scene of a table: its camera, and its triangles in order.
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
    let settings = Settings { hide: crate::scene::HiddenSurface::None, ..Settings::default() };
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

#[test]
fn depth_values_of_003() {
    for case in golden("seed003_depth_values")["expected"].as_array().unwrap() {
        let (near_plane, far) = (number(&case["near"]), number(&case["far"]));
        let projection = Projection::Frustum { window: [-1.0, 1.0, -1.0, 1.0], near: near_plane, far };
        let look_at = LookAt { eye: DVec3::ZERO, reference: DVec3::NEG_Z, up: DVec3::Y };
        let sight = Sight::new(&Camera { look_at, projection }, &corners_viewport(8, 8)).unwrap();
        let p = [0.0, 0.0, -number(&case["view_distance"]), 1.0].map(Wide::new);
        let clip = transform(&sight.projection, transform(&sight.view, p));
        let z = clip[2] / clip[3];
        near(z.to_f64(), &case["normalised"], 1e-15);
        for (format, key) in [(DepthFormat::U16, "u16"), (DepthFormat::U32, "u32")] {
            use super::picture::StoredDepth;
            let word = case[key].as_u64().unwrap();
            assert_eq!(format.words_around([z, z]), [word, word], "{key}");
            assert_eq!(format.encode(z.to_f64(), 1.0 - z.to_f64()) as u64, word);
        }
    }
}

/// The worked triangle of 003: screen corners, distances Z, and a value at each corner.
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
        (crate::scene::Interpolation::Perspective, &perspective["expected"]["colour"]),
        (crate::scene::Interpolation::Affine, &weights["expected"]["colour_affine"]),
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
    let d = Pyramid::new(&texture).level_of(Footprint::Steps([step("p10"), step("p01")]));
    near(d, &e["D"], 1e-12);
    // And through a whole render: u goes to red, v to green, level 2 of a ramp of 32 texels.
    let ramp: Vec<u8> =
        (0..32 * 32).flat_map(|i| [(i % 32 * 8) as u8, ((31 - i / 32) * 8) as u8, 0, 255]).collect();
    let ramp = Arc::new(Texture::new(32, 32, ramp).unwrap());
    let mut scene = worked_triangle(&g["inputs"], &g["inputs"]["Z"], |i, mesh| {
        mesh.texcoords.push(glam::DVec2::from_slice(&numbers(&g["inputs"]["uv"][i])));
        Corner { position: i as u32, normal: NONE, texcoord: i as u32, color: NONE }
    });
    let filter = crate::scene::Filter::Mipmap;
    scene.objects[0].texture = Some((ramp, crate::scene::Sampling { filter, ..Default::default() }));
    let picture = render(&scene, 64, 64, DepthFormat::F32, &Settings::default()).unwrap();
    let states = picture.states(28, 22);
    assert_eq!(states.len(), 1);
    // Level 2 has 8 texels of mean 12 + 32 k; u = 0.247 lies between the centres of texels 1 and 2 (bilinear).
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
        let lighting = super::light::Lighting {
            ambient: DVec3::ZERO,
            lights: vec![&light],
            viewer: super::Viewer::Axis(vector(&i["Vv"])),
        };
        let lit = super::light::light_point(&material, DVec3::ONE, DVec3::ZERO, vector(&i["N"]), &lighting);
        assert_eq!(lit.len(), 1, "{}", case["name"]);
        all_near(&(lit[0].base + lit[0].extra).to_array(), &case["colour"], 1e-12);
    }
}
