//! STL files, each with the mesh, or the error with its place and reason, that it must give.

use super::*;
use fbptr_core::memory::MemoryBudget;

const FACET: &str = "facet normal 0 0 1\n outer loop\n  vertex 0 0 0\n  vertex 1 0 0\n  vertex 0 1 0\n \
    endloop\nendfacet\n";

fn load(bytes: impl AsRef<[u8]>) -> Result<LoadedMesh, String> {
    let memory = &mut LoadMemory::unlimited();
    parse(bytes.as_ref(), "m.stl", memory, Smoothing::Angle(1.0)).map_err(|e| e.to_string())
}

fn warnings(loaded: &LoadedMesh) -> Vec<String> {
    loaded.warnings.iter().map(LoadWarning::to_string).collect()
}

/// Returns a binary file that states `count` facets and has these.
fn binary(count: u32, facets: &[[f32; 9]]) -> Vec<u8> {
    let mut bytes = [b's'; 80].to_vec();
    bytes[..6].copy_from_slice(b"solid ");
    bytes.extend(count.to_le_bytes());
    for facet in facets {
        bytes.extend([0; 12]);
        bytes.extend(facet.iter().flat_map(|x| x.to_le_bytes()));
        bytes.extend([7, 7]);
    }
    bytes
}

const RIGHT: [f32; 9] = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];

#[test]
fn text_and_binary_give_the_same_mesh() {
    let text = load(format!("solid a\n{FACET}endsolid a\n")).unwrap();
    let records = load(binary(1, &[RIGHT])).unwrap();
    assert_eq!(text.geometry.mesh, records.geometry.mesh);
    assert_eq!((warnings(&text), text.is_open), (vec![], true));
    let mesh = &text.geometry.mesh;
    assert_eq!(mesh.positions, [DVec3::ZERO, DVec3::X, DVec3::Y]);
    assert!(mesh.corners.iter().all(|c| mesh.normals[c.normal as usize] == DVec3::Z));
}

#[test]
fn spellings_of_real_programs_are_read() {
    let upper = format!("SOLID\r\n{}ENDSOLID\r\n", FACET.to_uppercase().replace('\n', "\r\n"));
    for text in [
        upper,
        format!("\n solid caf\u{e9} \u{1f980}\n\n{FACET}\n\nendsolid"),
        format!("solid\n{FACET}endsolid"),
        format!("solid a\n{FACET}end solid\n").replace("end solid", "endsolid of it"),
    ] {
        assert_eq!(load(&text).map(|l| l.geometry.mesh.triangles.len()), Ok(1), "{text}");
    }
    let two =
        load(format!("solid a\n{FACET}endsolid a\nbetween\nsolid b\n{FACET}{FACET}endsolid b\n")).unwrap();
    assert_eq!(two.geometry.mesh.triangles.len(), 3);
    assert_eq!(warnings(&two), ["m.stl:10: warning: text outside of a solid is left out"]);
    let none = load("solid nothing\nendsolid nothing").unwrap();
    assert_eq!(warnings(&none), ["m.stl: warning: no facets: nothing is drawn"]);
}

#[test]
fn equal_positions_are_one_vertex_of_a_smooth_surface() {
    // Two facets that share an edge at a small angle.
    let bent = [RIGHT, [1.0, 0.0, 0.0, 1.0, 1.0, 0.1, 0.0, 1.0, 0.0]];
    let smooth = load(binary(2, &bent)).unwrap().geometry.mesh;
    let at = |i: usize| smooth.normals[smooth.corners[i].normal as usize];
    assert_eq!(at(1), at(3), "both facets have one normal at (1, 0, 0)");
    assert_ne!(at(0), at(1));
    let memory = &mut LoadMemory::unlimited();
    let flat = parse(&binary(2, &bent), "m.stl", memory, Smoothing::Indices).unwrap();
    assert_eq!((flat.geometry.mesh.normals.len(), flat.is_open), (0, false));
}

#[test]
fn broken_files_are_refused_with_place_and_reason() {
    for (text, expected) in [
        (format!("solid a\n{FACET}"), "m.stl:8: not a readable STL: EOF while expecting facet or endsolid."),
        (
            format!("solid a\n{FACET}endsolid a").replace("1 0 0\n", "1 0 nan\n"),
            "m.stl:5: not a readable STL: expected finite f32, got NaN which is Nan",
        ),
        (
            format!("solid a\n{FACET}endsolid a").replace("outer", "inner"),
            "m.stl:3: not a readable STL: expected [\"outer\", \"loop\"], got [\"inner\", \"loop\"]",
        ),
        (
            format!("solid a\n\n{FACET}endsolid a").replace("vertex 0 1 0", "vertex 0 1"),
            "m.stl:7: not a readable STL: vertex f32 f32 f32, got [\"vertex\", \"0\", \"1\"]",
        ),
    ] {
        assert_eq!(load(text).unwrap_err(), expected);
    }
    for (bytes, expected) in [
        (vec![], "m.stl:byte 0: not a readable STL: a binary file has 84 bytes before its facets"),
        (
            binary(3, &[RIGHT]),
            "m.stl:byte 80: not a readable STL: 3 facets need 234 bytes, and the file has 134",
        ),
        (
            [&[0; 80], &u32::MAX.to_le_bytes()[..], &[0; 60]].concat(),
            "m.stl:byte 80: not a readable STL: 4294967295 facets need 214748364834 bytes, and the file has 144",
        ),
        (
            binary(2, &[RIGHT, [f32::INFINITY; 9]]),
            "m.stl:byte 134: a facet's corner must be a finite number, found \"inf\"",
        ),
    ] {
        assert_eq!(load(bytes).unwrap_err(), expected);
    }
    let long = load([&[0; 80], &1_u32.to_le_bytes()[..], &[0; 60]].concat()).unwrap();
    assert_eq!(
        warnings(&long),
        ["m.stl:byte 134: warning: 10 bytes after the last of 1 facets are left out"]
    );
}

#[test]
fn memory_is_reserved_before_it_is_used() {
    let bytes = binary(1000, &[RIGHT; 1000]);
    let memory = &mut LoadMemory::new(&MemoryBudget::new(100_000), u64::MAX);
    let error = parse(&bytes, "m.stl", memory, Smoothing::Indices).unwrap_err();
    assert_eq!(error.code(), fbptr_core::error::Code::Quota, "{error}");
    let text = format!("solid a\n{}endsolid a", FACET.repeat(1000));
    let error = parse(text.as_bytes(), "m.stl", memory, Smoothing::Indices).unwrap_err();
    assert_eq!(error.code(), fbptr_core::error::Code::Quota, "{error}");
}
