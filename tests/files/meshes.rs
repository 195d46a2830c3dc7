//! Meshes from other projects: each loads with the expected counts, or is refused with file, line
//! and reason.

use fbptr::load::obj;
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

/// Expected result of a file: used positions, polygons, triangles, line segments, materials,
/// warnings; or the refusal.
enum Outcome {
    Loads([usize; 6]),
    Refused(&'static str),
}
use Outcome::{Loads, Refused};

const EXPECTED: &[(&str, Outcome)] = &[
    ("assimp/box.obj", Loads([8, 6, 12, 0, 0, 1])),
    ("assimp/box_longline.obj", Loads([8, 6, 944, 0, 0, 1])),
    ("assimp/box_without_lineending.obj", Loads([8, 6, 12, 0, 0, 1])),
    ("assimp/concave_polygon.obj", Loads([64, 1, 64, 0, 1, 0])),
    ("assimp/cube_usemtl.obj", Loads([8, 12, 12, 0, 2, 1])),
    ("assimp/cube_with_vertexcolors.obj", Loads([8, 12, 12, 0, 0, 0])),
    ("assimp/empty.obj", Loads([0, 0, 0, 0, 0, 1])),
    ("assimp/malformed.obj", Loads([8, 4, 8, 0, 0, 2])),
    ("assimp/multiple_spaces.obj", Loads([3, 1, 1, 0, 0, 0])),
    ("assimp/number_formats.obj", Loads([3, 1, 1, 0, 0, 1])),
    ("made/clamped.obj", Loads([6, 2, 4, 0, 2, 0])),
    ("spot/spot_control_mesh.obj", Loads([188, 180, 372, 0, 0, 0])),
    ("suzanne-sphere/Esfera.obj", Loads([482, 960, 960, 0, 0, 0])),
    ("suzanne-sphere/monkey_head2.obj", Loads([507, 968, 968, 0, 0, 0])),
    ("tinyobjloader/cornell_box.obj", Loads([72, 18, 36, 0, 5, 0])),
    ("tinyobjloader/cornell_box_multimaterial.obj", Loads([72, 18, 36, 0, 5, 0])),
    ("tinyobjloader/cube-vertexcol.obj", Loads([8, 6, 12, 0, 3, 0])),
    ("tinyobjloader/cube.obj", Loads([8, 6, 12, 0, 3, 0])),
    (
        "tinyobjloader/invalid-face-definition.obj",
        Refused("invalid-face-definition.obj:15: a face has at least 3 corners, found \"1\""),
    ),
    (
        "tinyobjloader/invalid-relative-vertex-index.obj",
        Refused("invalid-relative-vertex-index.obj:1: position index -4 names none of the 0 there are"),
    ),
    (
        "tinyobjloader/issue-140-zero-face-idx.obj",
        Refused("issue-140-zero-face-idx.obj:16: position index 0 names none of the 4 there are"),
    ),
    ("tinyobjloader/issue-235-usemtl-then-o.obj", Loads([6, 2, 2, 0, 2, 0])),
    ("tinyobjloader/issue-319-002.obj", Loads([20, 3, 14, 0, 0, 0])),
    ("tinyobjloader/line-prim.obj", Loads([8, 0, 0, 6, 1, 0])),
    ("tinyobjloader/missing_material_file.obj", Loads([72, 18, 36, 0, 0, 5])),
    ("tinyobjloader/no_material.obj", Loads([72, 18, 36, 0, 0, 0])),
    ("tinyobjloader/smoothing-normal.obj", Loads([8, 3, 6, 0, 1, 0])),
    ("tinyobjloader/test-nan.obj", Loads([68, 17, 34, 0, 5, 1])),
    ("tinyobjloader/texture-filename-with-whitespace.obj", Loads([8, 6, 12, 0, 3, 2])),
    ("tobj/cornell_box.obj", Loads([72, 18, 36, 0, 5, 12])),
    ("tobj/empty_name_triangle.obj", Loads([3, 1, 1, 0, 0, 0])),
    ("tobj/invalid_index.obj", Loads([3, 1, 1, 0, 0, 1])),
    ("tobj/lines.obj", Loads([3, 0, 0, 3, 0, 0])),
    ("tobj/quad.obj", Loads([4, 4, 5, 0, 0, 0])),
    ("tobj/quad_colored_merge.obj", Loads([6, 2, 2, 0, 0, 0])),
    ("tobj/triangle.obj", Loads([3, 1, 1, 0, 0, 0])),
    ("tobj/triangle_colored.obj", Loads([3, 1, 1, 0, 0, 0])),
];

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/meshes")
}

fn load(path: &Path) -> Result<fbptr::load::LoadedMesh, fbptr::load::LoadError> {
    let folder = path.parent().expect("a file lies in a folder");
    let name = path.file_name().expect("a file has a name").to_string_lossy();
    obj::parse(&fs::read(path).expect("readable"), &mut |side| fs::read(folder.join(side)).ok(), &name)
}

fn obj_files(dir: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(dir).expect("readable").map(|e| e.expect("an entry").path()) {
        match entry.is_dir() {
            true => obj_files(&entry, found),
            false if entry.extension().is_some_and(|e| e == "obj") => found.push(entry),
            false => {}
        }
    }
}

#[test]
fn every_mesh_loads_as_what_it_is_or_is_refused_with_its_line() {
    let expected: BTreeMap<PathBuf, &Outcome> = EXPECTED.iter().map(|(n, o)| (root().join(n), o)).collect();
    let mut files = Vec::new();
    obj_files(&root(), &mut files);
    files.sort();
    assert_eq!(
        files,
        expected.keys().cloned().collect::<Vec<_>>(),
        "each file has its outcome, and is there"
    );
    let mut failures = Vec::new();
    for (file, outcome) in expected {
        let name = file.display();
        match (load(&file), outcome) {
            (Ok(loaded), Loads(counts)) => {
                let m = &loaded.geometry.mesh;
                let found = [
                    m.positions.len(),
                    m.polygons.len(),
                    m.triangles.len(),
                    m.lines.len(),
                    m.materials.len(),
                    loaded.warnings.len(),
                ];
                if found != *counts {
                    failures.push(format!("{name}: {found:?}, {:?}", loaded.warnings));
                }
            }
            (Err(error), Refused(reason)) if error.to_string() == *reason => {}
            (Ok(loaded), Refused(reason)) => {
                let m = &loaded.geometry.mesh;
                let counts = [m.positions.len(), m.polygons.len(), m.triangles.len(), m.lines.len()];
                failures.push(format!("{name} loads ({counts:?}, {:?}): {reason}", loaded.warnings));
            }
            (Err(error), _) => failures.push(error.to_string()),
        }
    }
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}

#[test]
fn every_prefix_and_every_lost_line_of_a_real_file_is_survived() {
    for name in ["tobj/quad.obj", "assimp/cube_usemtl.obj", "tinyobjloader/issue-140-zero-face-idx.obj"] {
        let bytes = fs::read(root().join(name)).expect("readable");
        let folder = root().join(name).parent().expect("a folder").to_owned();
        let mut side = |file: &str| fs::read(folder.join(file)).ok();
        for cut in 0..bytes.len() {
            if let Err(error) = obj::parse(&bytes[..cut], &mut side, name) {
                assert!(error.place.line > 0, "cut at {cut}: {error}");
            }
        }
        let lines: Vec<&[u8]> = bytes.split_inclusive(|b| *b == b'\n').collect();
        for lost in 0..lines.len() {
            let rest: Vec<&[u8]> =
                lines.iter().enumerate().filter(|(i, _)| *i != lost).map(|(_, l)| *l).collect();
            if let Err(error) = obj::parse(&rest.concat(), &mut side, name) {
                assert!(error.place.line > 0, "without line {}: {error}", lost + 1);
            }
        }
    }
}
