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
    let stray = "m.stl:10: warning: expected a keyword of STL, found \"between\": other words of its line are left out";
    assert_eq!(warnings(&two), [stray]);
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
        (
            format!("solid a\n{FACET}endsolid a").replace("1 0 0\n", "1 0 nan\n"),
            "m.stl:5: a facet's corner must be a finite number, found \"nan\"",
        ),
        (
            format!("solid a\n\n{FACET}endsolid a").replace("vertex 0 1 0", "vertex 0 1"),
            "m.stl:7: a facet's corner must be a finite number, found \"endloop\"",
        ),
        (
            "solid a\nfacet normal 0 0 1\nvertex 0 0 0\nvertex 1 0 0\nendfacet".into(),
            "m.stl:2: expected 3 corners in a facet, found \"2\"",
        ),
        ("hello\nworld".into(), "m.stl:1: expected a keyword of STL, found \"hello\""),
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
            binary(1, &[[f32::INFINITY; 9]]),
            "m.stl:byte 84: a facet's corner must be a finite number, found \"inf\"",
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
fn what_programs_write_is_read_and_what_is_odd_is_warned_of() {
    let one_line = format!("solid a b {FACET}{FACET} endsolid a").replace('\n', " ");
    let several = format!("{one_line} solid c {} endsolid", FACET.replace('\n', " "));
    for (text, facets, warned) in [
        (format!("\u{feff}solid a\n{FACET}endsolid a"), 1, 0),
        (format!("solid a\r{}endsolid a\r", FACET.replace('\n', "\r")), 1, 0),
        (one_line, 2, 0),
        (several, 3, 0),
        (format!("solid a\n{FACET}"), 1, 1),
        (format!("solid a\n{FACET}{}", &FACET[..60]), 1, 2),
        (format!("solid a\n{}", FACET.trim_end().trim_end_matches("endfacet")), 1, 1),
        (FACET.to_owned(), 1, 0),
        (format!("; by hand\nsolid a\n# b\n{FACET}endsolid a"), 1, 0),
        (format!("solid a\n{FACET}endsolid a").replace("0 0 1\n outer", "nan -1.#IND 1.#QNAN\n outer"), 1, 0),
        (format!("solid a\n{FACET}endsolid a").replace("0 0 1\n outer", "\n outer"), 1, 0),
        (
            format!("solid a\n{FACET}endsolid a")
                .replace("outer loop", "OuterLoop")
                .replace("endloop", "End Loop"),
            1,
            0,
        ),
        (format!("solid a\n{FACET}{FACET}end solid a").replacen("1 0 0\n", "nan 0 0\n", 1), 1, 1),
        (format!("solid a\n{FACET}endsolid a").replace(" endloop", " vertex 1 1 1\n endloop"), 1, 1),
        (format!("solid a\n{FACET}color 1 0 0\nendsolid a"), 1, 1),
        (format!("solid a facet of it\n{FACET}endsolid solid"), 1, 0),
        (format!("solid a\n{FACET}endsolid a\n\0\0"), 1, 0),
    ] {
        let loaded = load(&text).unwrap_or_else(|e| panic!("{e}\n{text}"));
        let found = (loaded.geometry.mesh.polygons.len(), loaded.warnings.len());
        assert_eq!(found, (facets, warned), "{text}\n{:?}", warnings(&loaded));
    }
    let some = load(binary(3, &[RIGHT, [f32::NAN; 9], RIGHT])).unwrap();
    assert_eq!((some.geometry.mesh.polygons.len(), some.warnings.len()), (2, 1));
    for stated in [0, u32::MAX] {
        let uncounted = load(binary(stated, &[RIGHT, RIGHT])).unwrap();
        assert_eq!((uncounted.geometry.mesh.polygons.len(), uncounted.warnings.len()), (2, 1));
    }
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
