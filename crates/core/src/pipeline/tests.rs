//! The 12x10 tables of notes 003 as pictures, and other small pictures as text.

use super::*;
use crate::memory::{DepthFormat, DepthMemory, PickBuffer, VideoMemory};
use crate::scene::*;
use glam::{DMat4, DVec3};
use serde_json::Value;
use std::sync::Arc;

fn number(v: &Value) -> f64 {
    v.as_f64().unwrap_or_else(|| panic!("not a number: {v}"))
}

fn vec3(v: &Value) -> DVec3 {
    DVec3::from_array(std::array::from_fn(|i| number(&v[i])))
}

/// Returns an object of a mesh with a material.
fn object(name: &str, mesh: Mesh, material: Material) -> Object {
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

/// Returns the scene that a table's inputs describe: emissive triangles, seen from (0, 0, 8).
fn table_scene(inputs: &Value) -> Scene {
    let objects = inputs["objects_in_order"].as_array().unwrap().iter().map(|o| {
        let points = (0..3).map(|i| vec3(&o["points"][i])).collect();
        let material = Material {
            emissive: vec3(&o["emissive"]),
            transparency: number(&o["transparency"]),
            ..Material::default()
        };
        let mut object =
            object(o["name"].as_str().unwrap(), Mesh::from_triangles(points, &[[0, 1, 2]]), material);
        object.model = crate::math::matrix::translate(vec3(&o["translation"]));
        object
    });
    Scene {
        camera: Some(Camera {
            look_at: LookAt { eye: vec3(&inputs["eye"]), reference: DVec3::ZERO, up: DVec3::Y },
            projection: Projection::Perspective {
                fov_rad: std::f64::consts::FRAC_PI_4,
                near: number(&inputs["near"]),
                far: number(&inputs["far"]),
                on_smaller_side: true,
            },
        }),
        objects: objects.collect(),
        ..Scene::default()
    }
}

/// Draws a scene on 12x10 pixels.
fn draw_table(scene: &Scene, format: DepthFormat, hide: HiddenSurface) -> (VideoMemory, Option<DepthMemory>) {
    let mut memory = VideoMemory::new(12, 10).unwrap();
    let mut depth = None;
    let mut target = Target { memory: &mut memory, depth: &mut depth, depth_format: format, ids: None };
    draw_scene(&mut target, scene, &SceneOptions { hide, ..SceneOptions::new(12, 10) }).unwrap();
    (memory, depth)
}

fn assert_colors(memory: &VideoMemory, table: &Value, what: &str) {
    for (x, y) in (0..120).map(|i| (i % 12, i / 12)) {
        let wanted = [0, 1, 2].map(|c| (number(&table[y][x][c]) * 255.0).round() as u8);
        assert_eq!(memory.get_pixel(x as i32, y as i32).unwrap()[..3], wanted, "{what} at ({x},{y})");
    }
}

#[test]
fn golden_opaque_tables_in_every_format() {
    let g = golden("seed003_tables_opaque");
    let tolerance = number(&g["tolerance"]["depth"]);
    let scene = table_scene(&g["inputs"]);
    let red = Scene { objects: scene.objects[..1].to_vec(), ..scene.clone() };
    for format in DepthFormat::ALL {
        for (scene, table) in [(&red, "depth_red"), (&scene, "depth_both")] {
            let (_, depth) = draw_table(scene, format, HiddenSurface::ZBuffer);
            let depth = depth.unwrap();
            for (x, y) in (0..120).map(|i| (i % 12, i / 12)) {
                let (found, wanted) =
                    (depth.z(x, y).unwrap(), number(&g["expected"][table][y as usize][x as usize]));
                let step = if format == DepthFormat::U16 { 0.501 / 65535.0 } else { 0.0 };
                assert!(
                    (found - wanted).abs() <= tolerance + step,
                    "{table} {format:?} at ({x},{y}): {found}"
                );
            }
        }
        let (memory, _) = draw_table(&scene, format, HiddenSurface::ZBuffer);
        assert_colors(&memory, &g["expected"]["colour_with_zbuffer"], "with zbuffer");
        let (memory, depth) = draw_table(&scene, format, HiddenSurface::None);
        assert!(depth.is_none(), "HIDE none makes no depth");
        assert_colors(&memory, &g["expected"]["colour_without_zbuffer"], "without zbuffer");
    }
    // The painter draws blue first, which is farther: the result equals the z-buffer's.
    let (memory, _) = draw_table(&scene, DepthFormat::F32, HiddenSurface::Painter);
    assert_colors(&memory, &g["expected"]["colour_with_zbuffer"], "painter");
}

#[test]
fn golden_transparent_tables() {
    let g = golden("seed003_tables_transparent");
    let scene = table_scene(&g["inputs"]);
    let blue = Scene { objects: scene.objects[..1].to_vec(), ..scene.clone() };
    for (scene, table) in [(&blue, "colour_after_blue"), (&scene, "colour_after_green")] {
        let (memory, _) = draw_table(scene, DepthFormat::F32, HiddenSurface::ZBuffer);
        assert_colors(&memory, &g["expected"][table], table);
    }
    let (memory, depth) = draw_table(&scene, DepthFormat::F32, HiddenSurface::ZBuffer);
    for (x, y) in (0..120).map(|i| (i % 12, i / 12)) {
        let wanted = &g["expected"]["colour_after_green_u8_round"][y as usize][x as usize];
        assert_eq!(
            memory.get_pixel(x, y).unwrap()[..3],
            [0, 1, 2].map(|c| number(&wanted[c]) as u8),
            "({x},{y})"
        );
    }
    // Green is tested against depth but writes none: only blue's depth is stored.
    let (_, alone) = draw_table(&blue, DepthFormat::F32, HiddenSurface::ZBuffer);
    let (depth, alone) = (depth.unwrap(), alone.unwrap());
    assert!((0..120).all(|i| depth.word(i) == alone.word(i)));
    let mut swapped = scene.clone();
    (swapped.objects[0].model, swapped.objects[1].model) = (scene.objects[1].model, scene.objects[0].model);
    let (memory, _) = draw_table(&swapped, DepthFormat::F32, HiddenSurface::ZBuffer);
    assert_colors(&memory, &g["expected"]["variant_lines_564_589"]["colour"], "the scene as printed");
}

#[test]
fn each_position_is_transformed_once_and_counted() {
    // A knot's positions are shared by six triangles each.
    let mesh = shapes::knot(30, 8).unwrap();
    let positions = mesh.positions.len() as u64;
    let mut scene = table_scene(&golden("seed003_tables_opaque")["inputs"]);
    scene.objects.push(object("knot", mesh, Material::default()));
    let mut memory = VideoMemory::new(12, 10).unwrap();
    let mut depth = None;
    let mut target =
        Target { memory: &mut memory, depth: &mut depth, depth_format: DepthFormat::F32, ids: None };
    let stats = draw_scene(&mut target, &scene, &SceneOptions::new(12, 10)).unwrap();
    assert_eq!(stats.vertices, 2 * 3 + positions);
}

#[test]
fn golden_depth_values() {
    let g = golden("seed003_depth_values");
    let cases = g["expected"].as_array().unwrap();
    assert!(cases.len() >= 4);
    for case in cases {
        let d = number(&case["view_distance"]);
        let (near, far) = (number(&case["near"]), number(&case["far"]));
        // A face perpendicular to the view axis, at distance d from an eye at z = 8.
        let z = 8.0 - d;
        let mesh = Mesh::from_triangles(
            vec![DVec3::new(-9.0, -9.0, z), DVec3::new(9.0, -9.0, z), DVec3::new(0.0, 9.0, z)],
            &[[0, 1, 2]],
        );
        let mut scene =
            Scene { objects: vec![object("face", mesh, Material::default())], ..Scene::default() };
        let projection = Projection::Perspective { fov_rad: 0.5, near, far, on_smaller_side: false };
        let look_at = LookAt { eye: DVec3::Z * 8.0, reference: DVec3::ZERO, up: DVec3::Y };
        scene.camera = Some(Camera { look_at, projection });
        let word = |format| draw_table(&scene, format, HiddenSurface::ZBuffer).1.unwrap().word(5 * 12 + 6);
        assert_eq!(word(DepthFormat::U16) as f64, number(&case["u16"]), "{case}");
        assert_eq!(word(DepthFormat::U32) as f64, number(&case["u32"]), "{case}");
        let exact = number(&case["normalised"]);
        assert_eq!(f32::from_bits(word(DepthFormat::F32)), exact as f32, "{case}");
        assert_eq!(word(DepthFormat::U24) as f64, (exact * 16_777_215.0).round(), "{case}");
        let reversed = f32::from_bits(!word(DepthFormat::Reversed)) as f64;
        assert!((reversed - (1.0 - exact)).abs() < 1e-7 * (1.0 - exact), "{case}");
    }
}

/// Returns a frame as letters: `.` black, `r`, `g`, `b` by the brightest channel, `w` for grey.
fn letters(memory: &VideoMemory) -> String {
    let letter = |p: &[u8; 4]| match p {
        [0, 0, 0, _] => '.',
        [r, g, b, _] if r == g && g == b => 'w',
        [r, g, b, _] if r >= g && r >= b => 'r',
        [_, g, b, _] if g >= b => 'g',
        _ => 'b',
    };
    let rows = memory.bytes().as_chunks::<4>().0.chunks(memory.width() as usize);
    rows.map(|r| r.iter().map(letter).collect::<String>() + "\n").collect()
}

/// Returns a box of half size `h` made of quads, counter-clockwise from outside.
fn box_mesh(h: f64) -> Mesh {
    let mut mesh = Mesh::default();
    for i in 0..8 {
        let side = |bit: u32| if i & bit != 0 { h } else { -h };
        mesh.positions.push(DVec3::new(side(1), side(2), side(4)));
    }
    for quad in [[4, 5, 7, 6], [1, 0, 2, 3], [5, 1, 3, 7], [0, 4, 6, 2], [6, 7, 3, 2], [0, 1, 5, 4]] {
        mesh.push_polygon(
            &quad.map(|position| Corner { position, normal: NONE, texcoord: NONE, color: NONE }),
            NONE,
        );
    }
    mesh
}

fn wire_cube(hide: HiddenSurface, cull: Cull, size: u32) -> (VideoMemory, DrawStats) {
    let geometry = Geometry { mesh: box_mesh(1.0), textures: Vec::new() };
    let material = Material::default();
    let mut memory = VideoMemory::new(size, size).unwrap();
    let mut depth = None;
    let mut target =
        Target { memory: &mut memory, depth: &mut depth, depth_format: DepthFormat::F32, ids: None };
    let mut camera = Camera::default();
    camera.look_at.eye = DVec3::new(2.0, 1.6, 3.4);
    let call = DrawCall {
        camera,
        cull,
        hide,
        shade: ShadeMode::Wire,
        ..DrawCall::new(&geometry, &material, size, size)
    };
    let stats = draw(&mut target, &call).unwrap();
    (memory, stats)
}

#[test]
fn a_wire_cube_has_12_edges_and_depth_hides_three() {
    let (all, stats) = wire_cube(HiddenSurface::None, Cull::None, 30);
    assert_eq!(stats.lines_drawn, 12);
    let (front, stats) = wire_cube(HiddenSurface::None, Cull::Back, 30);
    assert_eq!(stats.lines_drawn, 9, "three edges belong to no face that is seen");
    assert_eq!(letters(&front), HIDDEN_CUBE, "\n{}", letters(&front));
    let (hidden, _) = wire_cube(HiddenSurface::ZBuffer, Cull::Back, 30);
    assert_eq!(letters(&hidden), HIDDEN_CUBE, "\n{}", letters(&hidden));
    // With every face drawn, depth alone hides the three edges, except for the pixel where one ends
    // on the outline.
    let (hidden, stats) = wire_cube(HiddenSurface::ZBuffer, Cull::None, 30);
    assert_eq!(stats.lines_drawn, 12);
    let off = |m: &VideoMemory| letters(m).bytes().zip(HIDDEN_CUBE.bytes()).filter(|(a, b)| a != b).count();
    assert!(off(&hidden) <= 1 && off(&all) > 12, "{}\n{}\n{}", off(&all), letters(&hidden), letters(&all));
}

#[test]
fn lines_and_points_are_hidden_by_depth_and_keep_their_colours() {
    let mut mesh = Mesh::from_triangles(
        vec![DVec3::new(-0.6, -0.6, 0.0), DVec3::new(0.6, -0.6, 0.0), DVec3::new(0.6, 0.9, 0.0)],
        &[[0, 1, 2]],
    );
    for (x, y, z) in [(-0.9, 0.0, -1.0), (0.9, 0.0, 0.6), (0.0, 0.8, 0.0), (0.4, -0.4, -0.5)] {
        let position = mesh.positions.len() as u32;
        mesh.positions.push(DVec3::new(x, y, z));
        mesh.corners.push(Corner { position, normal: NONE, texcoord: NONE, color: NONE });
    }
    mesh.lines.push([3, 4]);
    mesh.points.extend([5, 6]);
    let geometry = Geometry { mesh, textures: Vec::new() };
    let material = Material { kd: DVec3::X, ..Material::default() };
    let mut memory = VideoMemory::new(16, 12).unwrap();
    let mut depth = None;
    let mut target =
        Target { memory: &mut memory, depth: &mut depth, depth_format: DepthFormat::F32, ids: None };
    let window = [-1.0, 1.0, -1.0, 1.0];
    let camera =
        Camera { projection: Projection::Ortho { window, near: 1.0, far: 9.0 }, ..Camera::default() };
    let call = DrawCall { camera, ambient: DVec3::ONE, ..DrawCall::new(&geometry, &material, 16, 12) };
    // With Ka 0 the face is black, and the line is in front of it only on its right half.
    draw(&mut target, &call).unwrap();
    assert_eq!(letters(&memory), LINE_AND_POINT, "\n{}", letters(&memory));
}

#[test]
fn pick_remembers_the_last_face_that_wrote_depth() {
    let geometry = Geometry { mesh: box_mesh(0.8), textures: Vec::new() };
    let (solid, glass) = (Material::default(), Material { transparency: 0.5, ..Material::default() });
    let mut memory = VideoMemory::new(20, 20).unwrap();
    let (mut depth, mut ids) = (None, PickBuffer::new(20, 20));
    let mut shot = |material: &Material, name, model, hide| {
        let mut target = Target {
            memory: &mut memory,
            depth: &mut depth,
            depth_format: DepthFormat::U24,
            ids: Some(&mut ids),
        };
        let call = DrawCall { name, model, hide, ..DrawCall::new(&geometry, material, 20, 20) };
        draw(&mut target, &call).unwrap();
        ids.get(9, 9)
    };
    let nearer = crate::math::matrix::translate(DVec3::Z);
    // Polygon 0 is the front of the box: triangles 0 and 1.
    assert!(matches!(shot(&solid, 7, DMat4::IDENTITY, HiddenSurface::ZBuffer), Some((7, 0 | 1))));
    assert!(matches!(shot(&glass, 8, nearer, HiddenSurface::ZBuffer), Some((7, _))), "glass writes no depth");
    assert!(matches!(shot(&solid, 9, nearer, HiddenSurface::None), Some((7, _))), "HIDE none writes none");
    assert!(matches!(shot(&solid, 10, nearer, HiddenSurface::ZBuffer), Some((10, _))));
}

#[test]
fn a_small_face_stores_the_clears_of_its_own_cells_alone() {
    let corners = vec![DVec3::ZERO, DVec3::new(0.05, 0.0, 0.0), DVec3::new(0.0, 0.05, 0.0)];
    let geometry = Geometry { mesh: Mesh::from_triangles(corners, &[[0, 1, 2]]), textures: Vec::new() };
    let glass = Material { transparency: 0.5, emissive: DVec3::ONE, ..Material::default() };
    let solid = Material { emissive: DVec3::ONE, ..Material::default() };
    let (width, height) = (1024, 256);
    for depth_format in [DepthFormat::F32, DepthFormat::U16] {
        for (material, shade) in
            [(&solid, ShadeMode::Wire), (&glass, ShadeMode::Phong), (&solid, ShadeMode::Phong)]
        {
            let mut memory = VideoMemory::new(width, height).unwrap();
            let (mut depth, mut ids) = (None, PickBuffer::new(width, height));
            let mut target =
                Target { memory: &mut memory, depth: &mut depth, depth_format, ids: Some(&mut ids) };
            let call = DrawCall { shade, ..DrawCall::new(&geometry, material, width, height) };
            assert!(draw(&mut target, &call).unwrap().pixels_written > 0);
            let stored = |words: &[u128]| words.iter().filter(|word| **word != u128::MAX).count();
            let rows =
                [stored(depth.unwrap().cells_mut().pending_clear), stored(ids.cells_mut().pending_clear)];
            assert!(rows.iter().all(|rows| *rows <= 40), "{rows:?} {shade:?} {depth_format:?}");
        }
    }
}

#[test]
fn a_refused_draw_leaves_the_memories_untouched() {
    let geometry = Geometry { mesh: box_mesh(1.0), textures: Vec::new() };
    let material = Material::default();
    let mut bad_mesh = box_mesh(1.0);
    bad_mesh.corners[5].position = 99;
    let bad = Geometry { mesh: bad_mesh, textures: Vec::new() };
    let good = DrawCall::new(&geometry, &material, 8, 8);
    let mut perspective_model = DMat4::IDENTITY;
    perspective_model.x_axis.w = 0.5;
    let calls = [
        DrawCall { model: perspective_model, ..good.clone() },
        DrawCall { model: DMat4::from_diagonal(glam::DVec4::new(f64::NAN, 1.0, 1.0, 1.0)), ..good.clone() },
        DrawCall { geometry: &bad, ..good.clone() },
        DrawCall {
            camera: Camera {
                look_at: LookAt { eye: DVec3::ZERO, reference: DVec3::ZERO, up: DVec3::Y },
                ..Camera::default()
            },
            ..good.clone()
        },
    ];
    for call in &calls {
        let mut memory = VideoMemory::new(8, 8).unwrap();
        memory.take_damage();
        let mut depth = None;
        let mut target =
            Target { memory: &mut memory, depth: &mut depth, depth_format: DepthFormat::F32, ids: None };
        let error = draw(&mut target, call).unwrap_err();
        assert_eq!(error.code(), crate::error::Code::Range, "{error}");
        assert!(!memory.is_damaged() && depth.is_none());
    }
}

const HIDDEN_CUBE: &str = "\
..............................
..............................
..............................
..............................
............ww................
......wwwwww..wwwwwwwwwwwww...
.wwwww...................ww...
.wwwwwwwww.............ww.w...
.w........wwwwwwww..www...w...
.w................ww......w...
.w.................w......w...
.w.................w......w...
.w.................w.....w....
.w.................w.....w....
..w................w.....w....
..w................w.....w....
..w................w.....w....
..w................w.....w....
..w................w.....w....
..w................w.....w....
..w................w....ww....
...w...............w....w.....
...w...............w...w......
...w...............w...w......
....ww.............w..w.......
......ww...........w..w.......
........www........w.w........
...........ww.....w.w.........
.............ww...w.w.........
...............wwwww..........
";
const LINE_AND_POINT: &str = "\
................
........r.......
................
................
................
................
rrrrrrr...rrrrrr
................
................
................
................
................
";
