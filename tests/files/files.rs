//! Every test scene is loaded, or refused with file, line, column and reason.

use crate::support::{check, data, draw, load};
use std::collections::BTreeSet;
use std::path::Path;

/// Expected result of a file: the number of objects and the lines of the warnings, or the text of
/// the refusal.
enum Outcome {
    Read(usize, &'static [u32]),
    Refused(&'static str),
}
use Outcome::{Read, Refused};

const FILES: &[(&str, Outcome)] = &[
    (
        "lecture-003/asprinted_mipmap_malformed.x3d",
        Refused(
            ":12:3: expected </IndexedFaceSet> first, which closes <IndexedFaceSet> of line 5, found \"</Shape>\"",
        ),
    ),
    (
        "lecture-003/asprinted_transparent_v1_malformed.x3d",
        Refused(":24:1: expected </Viewpoint> first, which closes <Viewpoint> of line 2, found \"</Scene>\""),
    ),
    (
        "lecture-003/asprinted_transparent_v2_malformed.x3d",
        Refused(":24:1: expected </Viewpoint> first, which closes <Viewpoint> of line 2, found \"</Scene>\""),
    ),
    (
        "lecture-003/asprinted_two_triangles_malformed.x3d",
        Refused(":23:1: expected </Viewpoint> first, which closes <Viewpoint> of line 2, found \"</Scene>\""),
    ),
    ("lecture-003/colour_triangle.x3d", Read(1, &[])),
    ("lecture-003/mipmap.x3d", Read(1, &[12])),
    ("lecture-003/transparent.x3d", Read(2, &[])),
    ("lecture-003/transparent_v1_lines565.x3d", Read(2, &[])),
    ("lecture-003/two_triangles.x3d", Read(2, &[])),
    ("x3d-cpp/demos/anim_color.x3d", Read(1, &[])),
    ("x3d-cpp/demos/anim_dvd.x3d", Read(1, &[])),
    ("x3d-cpp/demos/anim_orientation.x3d", Read(1, &[7])),
    ("x3d-cpp/demos/anim_position.x3d", Read(1, &[7])),
    ("x3d-cpp/hero_primitives.x3d", Read(4, &[6, 7, 8, 9])),
    ("x3d-cpp/inline/animated_child.x3d", Read(1, &[])),
    ("x3d-cpp/inline/animated_parent.x3d", Read(1, &[])),
    ("x3d-cpp/inline/child.x3d", Read(1, &[])),
    (
        "x3d-cpp/inline/cycle_a.x3d",
        Refused("x3d-cpp/inline/cycle_b.x3d:3:11: expected no Inline of \"cycle_a.x3d\""),
    ),
    (
        "x3d-cpp/inline/cycle_b.x3d",
        Refused("x3d-cpp/inline/cycle_a.x3d:3:11: expected no Inline of \"cycle_b.x3d\""),
    ),
    (
        "x3d-cpp/inline/cycle_containment.x3d",
        Refused(":4:16: expected USE to name a node that is complete, but \"A\" holds this one"),
    ),
    ("x3d-cpp/inline/parent.x3d", Read(1, &[])),
    ("x3d-cpp/lit_scene.x3d", Read(3, &[])),
    ("x3d-cpp/raster_smoke.x3d", Read(5, &[])),
    ("x3d-cpp/transparent_scene.x3d", Read(3, &[])),
    ("x3d-cpp/triangle.x3d", Read(1, &[])),
    ("x_ite/EnvironmentalEffects/FogScale.x3d", Read(2, &[])),
    ("x_ite/Extrusion/Scales.x3d", Read(1, &[])),
    ("x_ite/Extrusion/extrude1.x3d", Read(1, &[])),
    ("x_ite/Geometry3D/box.x3d", Read(1, &[])),
    ("x_ite/Grouping/StaticGroupClones.x3d", Read(8, &[])),
    ("x_ite/Interpolation/CoordinateInterpolator.x3d", Read(1, &[])),
    ("x_ite/Interpolation/Cube.x3d", Read(1, &[])),
    ("x_ite/Navigation/OrthoViewAll.x3d", Read(3, &[])),
    ("x_ite/Rendering/IndexedLineSet.x3d", Read(2, &[])),
    ("x_ite/Rendering/IndexedTriangleSetSphere.x3d", Read(2, &[])),
    ("x_ite/Rendering/Normals.x3d", Read(4, &[])),
    ("x_ite/Shape/TwoSidedMaterial.x3d", Read(2, &[])),
    ("x_ite/Texturing/PixelTexture.x3d", Read(4, &[])),
];

/// Returns the names of the files that load.
pub fn readable() -> impl Iterator<Item = &'static str> {
    FILES.iter().filter(|(_, o)| matches!(o, Read(..))).map(|(name, _)| *name)
}

fn on_disk(dir: &Path, found: &mut BTreeSet<String>) {
    for path in std::fs::read_dir(dir).unwrap().map(|e| e.unwrap().path()) {
        match path.is_dir() {
            // These have a table of their own, in `made.rs`.
            true if path.ends_with("made") => {}
            true => on_disk(&path, found),
            false if path.extension().is_some_and(|e| e == "x3d") => {
                let name = path.strip_prefix(data()).unwrap().components();
                found.insert(name.map(|c| c.as_os_str().to_str().unwrap()).collect::<Vec<_>>().join("/"));
            }
            false => {}
        }
    }
}

#[test]
fn the_list_is_of_all_files() {
    let mut found = BTreeSet::new();
    on_disk(&data(), &mut found);
    assert_eq!(found, FILES.iter().map(|(name, _)| name.to_string()).collect());
}

#[test]
fn every_file_is_read_or_refused_at_its_place() {
    for (name, outcome) in FILES {
        match (load(name), outcome) {
            (Ok(document), Read(objects, lines)) => {
                let scene = document.at(0.0);
                check(&scene);
                assert_eq!(scene.objects.len(), *objects, "{name}");
                let found: Vec<u32> = document.warnings().iter().map(|w| w.place.line).collect();
                assert_eq!(found, *lines, "{name}: {:#?}", document.warnings());
                assert!(document.warnings().iter().all(|w| w.place.file == *name));
            }
            (Err(error), Refused(reason)) => {
                let text = error.to_string();
                let file = if reason.starts_with(':') { name } else { "" };
                assert!(text.starts_with(&format!("{file}{reason}")), "{text}");
            }
            (Ok(_), Refused(_)) => panic!("{name} was read"),
            (Err(error), Read(..)) => panic!("{error}"),
        }
    }
}

#[test]
fn every_file_shows_something() {
    for name in readable() {
        let scene = load(name).unwrap().at(0.0);
        let sky = scene.background.color.unwrap_or_default();
        let sky = sky.to_array().map(|c| (255.0 * c + 0.5).floor() as u8);
        let memory = draw(&scene, 64, 48);
        let seen = memory.bytes().chunks(4).filter(|p| p[..3] != sky).count();
        // Four points of a file are four pixels; the two bands of a flat colour may differ little
        // from the sky.
        assert!(seen >= 4, "{name}: {seen} pixels differ from the background");
    }
}
