//! Files as exporters write them, against their specifications: each is drawn, with one warning.

use crate::support::{area, check, draw, warnings};
use fbptr::load::gltf;
use fbptr::load::{LoadedMesh, MeshFormat, Smoothing, x3d};
use fbptr::memory::VideoMemory;
use fbptr::scene::{Cull, Scene};
use std::path::PathBuf;
use std::sync::Arc;

fn folder() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/data/formats/strangers")
}

fn bytes(name: &str) -> Vec<u8> {
    std::fs::read(folder().join(name)).expect("readable")
}

fn beside(name: &str) -> Option<Vec<u8>> {
    std::fs::read(folder().join(name)).ok()
}

/// Reads a mesh, with the words of its warnings.
fn mesh(name: &str) -> (LoadedMesh, Vec<String>) {
    let (bytes, memory) = (bytes(name), &mut fbptr::load::LoadMemory::unlimited());
    let loaded = MeshFormat::of(&bytes).parse(&bytes, &mut beside, name, memory, Smoothing::Angle(1.0));
    let loaded = loaded.unwrap_or_else(|e| panic!("{e}"));
    let warnings = loaded.warnings.iter().map(ToString::to_string).collect();
    (loaded, warnings)
}

fn picture(scene: &Scene) -> VideoMemory {
    check(scene);
    draw(scene, 90, 90)
}

/// Returns the part of the pixels that are not the background's.
fn covered(memory: &VideoMemory) -> f64 {
    let pixels = memory.bytes().as_chunks::<4>().0;
    pixels.iter().filter(|p| **p != pixels[0]).count() as f64 / pixels.len() as f64
}

#[test]
fn meshes_are_drawn_without_what_cannot_be_read() {
    for (name, polygons, expected) in [
        ("s5_nannormal.stl", 4, ""),
        ("s5c_ind.stl", 4, ""),
        ("cube_some_inverted.stl", 12, ""),
        ("o5_nan.obj", 1, "o5_nan.obj:5: warning: a position must be a finite number"),
        (
            "o7_two.obj",
            1,
            "o7_two.obj:5: warning: a face has at least 3 corners, found \"1 2\": the element is left out",
        ),
        ("o8_dollar.obj", 1, "o8_dollar.obj:1: warning: \"$\" is not an OBJ statement: it is skipped"),
        ("o8b_slashslash.obj", 1, "o8b_slashslash.obj:1: warning: \"//\" is not an OBJ statement"),
        ("o8c_garbage.obj", 1, "o8c_garbage.obj:6: warning: \"end\" is skipped"),
        ("o4b_col255.obj", 1, "o4b_col255.obj: warning: vertex colours above 1 are read as 0 to 255"),
        ("a18_kd0.obj", 1, "a18_kd0.mtl:3: warning: Kd 0 0 0 of material \"m\" is read as 1 1 1"),
        ("p8_texfile.ply", 2, ""),
        ("p12_nanpts.ply", 0, "p12_nanpts.ply:9: warning: a position must be a finite number, found \"NaN\""),
    ] {
        let (loaded, said) = mesh(name);
        assert_eq!(loaded.geometry.mesh.polygons.len(), polygons, "{name}: {said:?}");
        assert_eq!(said.is_empty(), expected.is_empty(), "{name}: {said:?}");
        assert!(expected.is_empty() || said[0].starts_with(expected), "{said:?}");
        let is_textured = matches!(name, "a18_kd0.obj" | "p8_texfile.ply");
        assert_eq!(loaded.geometry.textures.iter().any(Option::is_some), is_textured, "{name}");
        let is_open = loaded.is_open;
        let memory = picture(&Scene::of_mesh(Arc::new(loaded.geometry), name, 1.0, is_open));
        assert!(covered(&memory) > if polygons == 0 { 0.0 } else { 0.1 }, "{name}");
    }
}

#[test]
fn a_closed_surface_with_inverted_facets_has_no_holes() {
    let (loaded, _) = mesh("cube_some_inverted.stl");
    assert!(loaded.is_open, "its backs can be seen");
    let geometry = Arc::new(loaded.geometry);
    let scene = Scene::of_mesh(Arc::clone(&geometry), "c", 1.0, true);
    assert_eq!((scene.objects[0].cull, scene.objects[0].two_sided_lighting), (Cull::None, true));
    // Whichever way facets are turned, the same are seen.
    let mut culled = scene.clone();
    culled.objects[0].cull = Cull::Back;
    assert!(covered(&picture(&scene)) > 1.05 * covered(&picture(&culled)), "holes");
}

#[test]
fn gltf_of_exporters_is_drawn() {
    let read = |name: &str| {
        let document = gltf::parse(&bytes(name), name, &mut beside).unwrap_or_else(|e| panic!("{e}"));
        let said: Vec<String> = document.warnings().iter().map(ToString::to_string).collect();
        (document.at(0.0, 1.0), said)
    };
    let (scene, said) = read("g1_nonroot.gltf");
    let expected =
        "g1_nonroot.gltf#/scenes/0/nodes/0: warning: node 1 has a parent, and is no root of a scene";
    assert_eq!(said, [expected]);
    assert!(covered(&picture(&scene)) > 0.1);
    // The half below the cutoff is cut away.
    let (cut, said) = read("g5c_valpha_mask.gltf");
    assert_eq!(said, [""; 0]);
    assert!(covered(&picture(&cut)) > 0.05);
    let [part, whole] = [&cut, &scene].map(|scene| area(&scene.objects[0].geometry.mesh).length());
    assert!((part / whole - 0.5).abs() < 1e-9, "{part} of {whole}");
    let (textured, said) = read("g9b_webp_req.gltf");
    assert_eq!(said, [""; 0]);
    let (texture, _) = textured.objects[0].texture.clone().expect("decoded");
    assert_eq!((texture.width(), texture.height()), (64, 64));
}

#[test]
fn a_scene_in_kilometres_looks_as_in_metres() {
    let read = |name: &str| {
        let document = x3d::parse(&bytes(name), name, &mut beside).unwrap();
        assert_eq!(warnings(&document), [""; 0]);
        picture(&document.at(0.0))
    };
    let (metres, kilometres) = (read("unit0.x3d"), read("unit1.x3d"));
    assert!(covered(&metres) > 0.01);
    let other = metres.bytes().iter().zip(kilometres.bytes()).filter(|(a, b)| a.abs_diff(**b) > 1).count();
    assert_eq!(other, 0);
}

#[test]
fn points_have_the_size_that_point_properties_state() {
    let covered = |properties: &str| {
        let text = format!(
            "<X3D><Scene><Viewpoint position='0 0 10'/><Shape><Appearance><Material emissiveColor='1 1 1'/>{properties}\
             </Appearance><PointSet><Coordinate point='0 0 0'/></PointSet></Shape></Scene></X3D>"
        );
        let document = x3d::parse(text.as_bytes(), "p.x3d", &mut |_| None).unwrap();
        assert_eq!(warnings(&document), [""; 0]);
        let memory = picture(&document.at(0.0));
        memory.bytes().as_chunks::<4>().0.iter().filter(|p| p[0] == 255).count()
    };
    for (properties, pixels) in [
        ("", 1),
        ("<PointProperties/>", 1),
        ("<PointProperties pointSizeScaleFactor='3'/>", 9),
        ("<PointProperties pointSizeScaleFactor='9' pointSizeMaxValue='4'/>", 16),
        ("<PointProperties pointSizeMinValue='2' pointSizeMaxValue='4'/>", 4),
        ("<PointProperties pointSizeScaleFactor='-1e9'/>", 1),
        ("<PointProperties pointSizeScaleFactor='1e9'/>", 64 * 64),
    ] {
        assert_eq!(covered(properties), pixels, "{properties}");
    }
}
