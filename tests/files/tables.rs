//! The lecture's 12 x 10 tables, cell by cell, from its repaired X3D files (source 003).

use crate::support::load;
use fbptr::memory::{DepthFormat, VideoMemory};
use fbptr::pipeline::{DepthUse, SceneOptions, Target, draw_scene};
use fbptr::scene::{HiddenSurface, Projection, Scene};
use serde_json::Value;
use std::fs;
use std::path::Path;

fn golden(name: &str) -> Value {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/golden").join(name);
    serde_json::from_str(&fs::read_to_string(path).unwrap()).unwrap()
}

/// Returns the scene of a file with the table's near and far.
fn scene(file: &str) -> Scene {
    let mut scene = load(&format!("lecture-003/{file}")).unwrap().at(0.0);
    let camera = scene.camera.as_mut().unwrap();
    match &mut camera.projection {
        Projection::Perspective { near, far, .. } => (*near, *far) = (5.0, 10.0),
        other => panic!("{other:?}"),
    }
    scene
}

fn draw(scene: &Scene, hide: HiddenSurface) -> (VideoMemory, Option<Vec<f64>>) {
    let mut memory = VideoMemory::new(12, 10).unwrap();
    let mut depth = None;
    let options = SceneOptions { hide, depth_use: DepthUse::Keep, ..SceneOptions::new(12, 10) };
    let depth_format = DepthFormat::F32;
    let mut target = Target { memory: &mut memory, depth: &mut depth, depth_format, ids: None };
    draw_scene(&mut target, scene, &options).unwrap();
    let depth = depth.map(|d| (0..120).map(|i| d.z(i % 12, i / 12).unwrap()).collect());
    (memory, depth)
}

fn numbers(table: &Value) -> Vec<f64> {
    match table {
        Value::Array(cells) => cells.iter().flat_map(numbers).collect(),
        cell => vec![cell.as_f64().unwrap()],
    }
}

fn assert_colors(memory: &VideoMemory, table: &Value) {
    let expected = numbers(table);
    assert_eq!(expected.len(), 360);
    for (i, c) in expected.iter().enumerate() {
        let byte = (255.0 * c + 0.5).floor() as u8;
        let (cell, channel) = (i / 3, i % 3);
        assert_eq!(
            memory.bytes()[cell * 4 + channel],
            byte,
            "cell ({}, {}) channel {channel}",
            cell % 12,
            cell / 12
        );
    }
}

#[test]
fn the_opaque_tables_come_out() {
    let expected = &golden("seed003_tables_opaque.json")["expected"];
    let both = scene("two_triangles.x3d");
    let depths = |scene: &Scene, table: &str| {
        let found = draw(scene, HiddenSurface::ZBuffer).1.unwrap();
        let expected = numbers(&expected[table]);
        assert_eq!(expected.len(), 120);
        for (i, (a, b)) in found.iter().zip(&expected).enumerate() {
            assert!((a - b).abs() <= 1e-6, "{table}: cell ({}, {}) is {a}, not {b}", i % 12, i / 12);
        }
    };
    let mut red = both.clone();
    red.objects.truncate(1);
    depths(&red, "depth_red");
    depths(&both, "depth_both");
    assert_colors(&draw(&both, HiddenSurface::ZBuffer).0, &expected["colour_with_zbuffer"]);
    assert_colors(&draw(&both, HiddenSurface::None).0, &expected["colour_without_zbuffer"]);
}

#[test]
fn the_transparent_tables_come_out() {
    let expected = &golden("seed003_tables_transparent.json")["expected"];
    let both = scene("transparent.x3d");
    let mut blue = both.clone();
    blue.objects.truncate(1);
    assert_colors(&draw(&blue, HiddenSurface::ZBuffer).0, &expected["colour_after_blue"]);
    assert_colors(&draw(&both, HiddenSurface::ZBuffer).0, &expected["colour_after_green"]);
    // The scene as printed, with its translations exchanged.
    let variant = scene("transparent_v1_lines565.x3d");
    assert_colors(&draw(&variant, HiddenSurface::ZBuffer).0, &expected["variant_lines_564_589"]["colour"]);
}
