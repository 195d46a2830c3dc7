//! Odd OBJ and MTL files, each with the mesh, or the error with file, line and reason, that it must
//! give.

mod materials;

use super::*;
use fbptr_core::error::Code;
use fbptr_core::scene::{Corner, Mesh};
use glam::{DVec2, DVec3, DVec4};
use proptest::prelude::*;

fn load_with(obj: impl AsRef<[u8]>, files: &[(&str, &[u8])]) -> Result<LoadedMesh, LoadError> {
    let mut find = |name: &str| files.iter().find(|f| f.0 == name).map(|f| f.1.to_vec());
    parse(obj.as_ref(), &mut find, "m.obj")
}

fn load(obj: impl AsRef<[u8]>) -> LoadedMesh {
    load_with(obj, &[]).expect("loads")
}

fn mesh(obj: impl AsRef<[u8]>) -> Mesh {
    load(obj).geometry.mesh
}

fn refusal(obj: impl AsRef<[u8]>) -> String {
    let error = load_with(obj, &[]).expect_err("is refused");
    assert_eq!(error.code(), Code::Format);
    error.to_string()
}

fn warnings(loaded: &LoadedMesh) -> Vec<String> {
    loaded.warnings.iter().map(|w| w.to_string()).collect()
}

/// Asserts that every index is in range, and that triangles cover their polygons' corners.
fn assert_sound(mesh: &Mesh) {
    let good = |index: u32, len: usize| index == NONE || (index as usize) < len;
    for c in &mesh.corners {
        assert!((c.position as usize) < mesh.positions.len());
        assert!(good(c.normal, mesh.normals.len()) && good(c.texcoord, mesh.texcoords.len()));
        assert!(good(c.color, mesh.colors.len()));
    }
    assert_eq!(mesh.triangles.len(), mesh.triangle_polygon.len());
    assert_eq!(
        mesh.triangles.len(),
        mesh.polygons.iter().map(|p| p.corner_count as usize - 2).sum::<usize>()
    );
    let corner = |i: u32| (i as usize) < mesh.corners.len();
    assert!(mesh.triangles.iter().flatten().all(|i| corner(*i)));
    assert!(mesh.lines.iter().flatten().chain(&mesh.points).all(|i| corner(*i)));
    assert!(mesh.polygons.iter().all(|p| good(p.material, mesh.materials.len())));
    assert!(mesh.positions.iter().chain(&mesh.normals).all(|v| v.is_finite()));
    assert!(mesh.texcoords.iter().all(|t| t.is_finite()) && mesh.colors.iter().all(|c| c.is_finite()));
}

const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";

#[test]
fn polygons_keep_their_corners_and_the_files_indices() {
    let m = mesh(
        "v 9 9 9\nv 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nvn 0 0 2\n\
         f 5/4/1 2/1/1 3/2/1 4/3/1\nf 4 3 2",
    );
    // The unused position is left out; the others keep the file's order.
    assert_eq!(m.positions[0], DVec3::ZERO);
    assert_eq!(m.positions.len(), 4);
    assert_eq!(m.normals, [DVec3::new(0.0, 0.0, 2.0)], "normals keep their length");
    let corner = |position, texcoord, normal| Corner { position, texcoord, normal, color: NONE };
    assert_eq!(m.corners[..4], [corner(3, 3, 0), corner(0, 0, 0), corner(1, 1, 0), corner(2, 2, 0)]);
    assert_eq!(m.corners[4..], [corner(2, NONE, NONE), corner(1, NONE, NONE), corner(0, NONE, NONE)]);
    assert_eq!(m.texcoords[2], DVec2::ONE);
    assert_eq!(m.polygons.iter().map(|p| p.corner_count).collect::<Vec<_>>(), [4, 3]);
    assert_eq!(m.triangles, [[0, 1, 2], [0, 2, 3], [4, 5, 6]]);
    assert_eq!(m.triangle_polygon, [0, 0, 1]);
    assert_sound(&m);
}

#[test]
fn a_vertex_is_a_position_across_groups_objects_and_materials() {
    let parts = format!("{TRIANGLE}v 1 1 0\no a\nusemtl x\nf 1 2 3\ng b\no c\nusemtl y\ns 1\nf 3 2 4\n");
    let m = mesh(parts);
    assert_eq!((m.positions.len(), m.polygons.len()), (4, 2));
    assert_eq!(m.corners.iter().map(|c| c.position).collect::<Vec<_>>(), [0, 1, 2, 2, 1, 3]);
}

#[test]
fn lines_and_points_stay_what_they_are() {
    let m = mesh(format!("{TRIANGLE}vt 0 0\nl 1/1 2/1 3/1\np 1 3\nl -1 -2\nf 1 2 3"));
    assert_eq!(m.lines, [[0, 1], [1, 2], [5, 6]]);
    assert_eq!(m.points, [3, 4]);
    assert!(m.line_materials.is_empty() && m.point_materials.is_empty());
    assert_eq!(m.corners[4].position, 2);
    assert_eq!(m.triangles, [[7, 8, 9]]);
    assert_eq!((m.corners[0].texcoord, m.corners[5].texcoord), (0, NONE));
    assert_sound(&m);
}

#[test]
fn lines_and_points_have_the_material_in_use() {
    let statements = "p 1\nusemtl a\nl 1 2 3\nusemtl none\np 1\nusemtl b\nl 2 3\np 1 2\nusemtl a\np 3";
    let library = "newmtl a\nKd 1 0 0\nnewmtl b\nKd 0 1 0";
    let loaded =
        load_with(format!("mtllib l.mtl\n{TRIANGLE}{statements}"), &[("l.mtl", library.as_bytes())]).unwrap();
    let m = &loaded.geometry.mesh;
    assert_eq!(m.materials.iter().map(|m| m.kd).collect::<Vec<_>>(), [DVec3::X, DVec3::Y]);
    assert_eq!(m.line_materials, [0, 0, 1]);
    assert_eq!(m.point_materials, [NONE, NONE, 1, 1, 0]);
    assert_sound(m);
}

#[test]
fn indices_may_be_relative_or_name_what_comes_later() {
    let m = mesh("v 0 0 0\nv 1 0 0\nv 0 1 0\nf -3 -2 -1\nv 5 5 5\nf 5 -1 1\nv 6 6 6");
    assert_eq!(m.corners.iter().map(|c| c.position).collect::<Vec<_>>(), [0, 1, 2, 4, 3, 0]);
    assert_eq!(m.positions[4], DVec3::splat(6.0));
}

#[test]
fn colours_weights_and_depths_of_vertices() {
    let loaded =
        load("v 0 0 0 1 0 0.5\nv 1 0 0\nv 0 1 0 .25 1e1 0 9\nvt 0.5\nvt 0.25 0.75 0.5\nf 1/1 2/2 3/1\n");
    let m = &loaded.geometry.mesh;
    assert_eq!(m.colors[0], DVec4::new(1.0, 0.0, 0.5, 1.0));
    assert_eq!((m.colors[1], m.colors[2]), (DVec4::ONE, DVec4::new(0.25, 10.0, 0.0, 1.0)));
    assert_eq!(m.corners[2].color, 2);
    assert_eq!(m.texcoords, [DVec2::new(0.5, 0.0), DVec2::new(0.25, 0.75)]);
    assert_eq!(loaded.warnings.len(), 2, "{:?}", warnings(&loaded));
    let m = mesh("v 2 4 8 2\nv 1 0 0\nv 0 1 0 1.0\nf 1 2 3");
    assert_eq!(m.positions[0], DVec3::new(1.0, 2.0, 4.0));
    let m = mesh("v 2 4 8 2\nv 1 0 0 1 1 1\nv 0 1 0 1.0\nf 1 2 3");
    assert_eq!((m.positions[0], m.colors[0]), (DVec3::new(1.0, 2.0, 4.0), DVec4::ONE));
}

#[test]
fn numbers_are_read_as_f64_in_every_form() {
    let m = mesh("v 0.1 +1. -.5\nv 1e2 2.E1 -3.5e-3\nv 16777217 -0 1e300\nf 1 2 3");
    let p =
        [DVec3::new(0.1, 1.0, -0.5), DVec3::new(100.0, 20.0, -0.0035), DVec3::new(16_777_217.0, -0.0, 1e300)];
    assert_eq!(m.positions, p);
}

#[test]
fn line_ends_comments_continuations_and_odd_bytes() {
    let plain = mesh(format!("{TRIANGLE}f 1 2 3\n"));
    for odd in [
        "\u{feff}v 0 0 0\r\nv 1 0 0\r\nv 0 1 0\r\nf 1 2 3".as_bytes(),
        b"v 0 0 0\rv 1 0 0\rv 0 1 0\rf 1 2 3\r",
        b"v 0 0 \\\n0\nv 1 0 0\nv 0 \\\r\n 1 \\\n0\nf 1 \\\n 2 3",
        b"# caf\xe9 \xff\xfe\\\nv 0 0 0#x\nv\t1  0 0   # y\n\n   v 0 1 0\n  f 1 2   3 # z\ng caf\xe9\nusemtl \xe9",
        b"v 0 0 0\nv 1 0 0\nv 0 1 0\nfo 1// 2/ 3//",
    ] {
        assert_eq!(mesh(odd), plain, "{:?}", String::from_utf8_lossy(odd));
    }
    let long = format!("# {}\n{TRIANGLE}f 1 2 3{}\n", "x".repeat(1 << 20), " ".repeat(1 << 20));
    assert_eq!(mesh(long), plain);
}

#[test]
fn an_empty_file_is_an_empty_mesh_and_says_so() {
    for empty in ["", "\n\n# nothing\n", "\u{feff}", "o a\ng b\n", "vn 0 0 1\nvt 0 0\n"] {
        let loaded = load(empty);
        assert_eq!(loaded.geometry.mesh, Mesh::default());
        assert_eq!(warnings(&loaded), ["m.obj: warning: no faces, lines or points: nothing is drawn"]);
    }
}

#[test]
fn what_is_malformed_is_refused_with_its_line() {
    let after = |rest: &str| refusal(format!("{TRIANGLE}{rest}"));
    for (rest, reason) in [
        ("f 1 2 4", "m.obj:4: position index 4 names none of the 3 there are"),
        ("f 0 1 2", "m.obj:4: position index 0 names none of the 3 there are"),
        ("\nf 1 2 -4", "m.obj:5: position index -4 names none of the 3 there are"),
        ("f -4 1 2\nv 0 0 0\n", "m.obj:4: position index -4 names none of the 3 there are"),
        ("vt 0 0\nf 1/-2 2/1 3/1", "m.obj:5: texture coordinate index -2 names none of the 1 there are"),
        ("vn 0 0 1\nf 1//1 2//2 3//1", "m.obj:5: normal index 2 names none of the 1 there are"),
        ("f 1/0 2/0 3/0", "m.obj:4: texture coordinate index 0 names none of the 0 there are"),
        (
            "f 1 2 99999999999999999999999",
            "m.obj:4: position index 9223372036854775807 names none of the 3 there are",
        ),
        (
            "f -9223372036854775808 1 2",
            "m.obj:4: position index -9223372036854775807 names none of the 3 there are",
        ),
        ("f 1 2", "m.obj:4: a face has at least 3 corners, found \"1 2\""),
        ("f", "m.obj:4: a face has at least 3 corners, found \"\""),
        ("l 1", "m.obj:4: a line has at least 2 points, found \"1\""),
        ("p", "m.obj:4: a point element has at least 1 point, found \"\""),
        ("f 1 2 3.5", "m.obj:4: an index is a whole number, found \"3.5\""),
        ("f 1 2 /3", "m.obj:4: a corner is v, v/vt, v//vn or v/vt/vn, found \"/3\""),
        ("f 1 2 3/1/1/1", "m.obj:4: a corner is v, v/vt, v//vn or v/vt/vn, found \"3/1/1/1\""),
        ("f 1 2 -", "m.obj:4: an index is a whole number, found \"-\""),
        ("v nan 0 0", "m.obj:4: a coordinate must be a finite number, found \"nan\""),
        ("v 0 -inf 0", "m.obj:4: a coordinate must be a finite number, found \"-inf\""),
        ("vt infinity 0", "m.obj:4: a coordinate must be a finite number, found \"infinity\""),
        ("vn 0 0 1e999", "m.obj:4: a coordinate must be a finite number, found \"1e999\""),
        ("v 1,5 0 0", "m.obj:4: a coordinate must be a finite number, found \"1,5\""),
        ("v 1 2", "m.obj:4: a position has 3 numbers, 4 with a weight, 6 with a colour, found \"1 2\""),
        (
            "v 1 2 3 4 5",
            "m.obj:4: a position has 3 numbers, 4 with a weight, 6 with a colour, found \"1 2 3 4 5\"",
        ),
        ("v 1 2 3 0", "m.obj:4: a position divided by its weight must be a finite number, found \"1 2 3 0\""),
        (
            "v 1e300 2 3 1e-300",
            "m.obj:4: a position divided by its weight must be a finite number, found \"1e300 2 3 1e-300\"",
        ),
        ("vt", "m.obj:4: a texture coordinate has 1 to 3 numbers, found \"\""),
        ("vn 0 0", "m.obj:4: a normal has 3 numbers, found \"0 0\""),
        ("f 1 \\\n2 \\\n9\n", "m.obj:4: position index 9 names none of the 3 there are"),
        ("1 2 3", "m.obj:4: expected an OBJ statement, found \"1\""),
        ("\0\0\0", "m.obj:4: expected an OBJ statement, found \"\\0\\0\\0\""),
    ] {
        assert_eq!(after(rest), reason);
    }
    assert_eq!(refusal("<html>\n"), "m.obj:1: expected an OBJ statement, found \"<html>\"");
    assert_eq!(
        refusal("hello world\nthis is text"),
        "m.obj:1: expected an OBJ statement such as v or f, found \"hello\""
    );
    // A polygon whose triangulation would take minutes.
    let huge = format!("{TRIANGLE}f{}", " 1 2 3".repeat(30_000));
    assert_eq!(load_with(huge, &[]).unwrap_err().code(), Code::TooBig);
}

#[test]
fn what_is_skipped_is_said_once_with_its_line() {
    let loaded = load(format!(
        "{TRIANGLE}frobnicate 1\nfrobnicate 2\ncurv 0 1 2\ncall x.obj\nf 1/1 2/1 3/1\nvn 0 0 1\nf 1//1 2 3\nmtllib a b.mtl\nusemtl z"
    ));
    assert_eq!(
        warnings(&loaded),
        [
            "m.obj:4: warning: \"frobnicate\" is not an OBJ statement: it is skipped",
            "m.obj:6: warning: \"curv\" is skipped: free-form curves and surfaces are not drawn",
            "m.obj:7: warning: \"call\" is skipped: other files and programs are not run",
            "m.obj:8: warning: \"vt\" is named by corners and stands nowhere in the file: it is left out",
            "m.obj:10: warning: some corners have a normal and others none: the element has none",
            "m.obj:11: warning: material file \"a\" cannot be found: it is left out",
            "m.obj:11: warning: material file \"b.mtl\" cannot be found: it is left out",
        ]
    );
    assert_eq!(loaded.geometry.mesh.polygons.len(), 2);
    let many = load(format!("{TRIANGLE}{}", (0..500).map(|i| format!("w{i} x\n")).collect::<String>()));
    assert_eq!(many.warnings.len(), 101);
    assert_eq!(many.warnings[100].message, "400 more warnings are not shown");
}

#[test]
fn a_file_of_vertices_alone_is_a_cloud_of_points() {
    let m = mesh(format!("vn 0 0 1\n{TRIANGLE}vt 0 0\n"));
    assert_eq!((m.points.as_slice(), m.positions.len()), (&[0, 1, 2][..], 3));
    assert!(m.corners.iter().all(|c| [c.normal, c.texcoord, c.color] == [NONE; 3]));
    assert_sound(&m);
    // More than one element of the decoder, with colours and a material.
    let vertices: String = (0..200).map(|i| format!("v {i} 0 0 0 1 0\n")).collect();
    let obj = format!("mtllib l.mtl\nusemtl a\n{vertices}");
    let loaded = load_with(obj, &[("l.mtl", b"newmtl a\nKd 1 0 0")]).unwrap();
    let m = &loaded.geometry.mesh;
    assert_eq!(
        (m.points.len(), m.corners[199].color, m.colors[199]),
        (200, 199, DVec4::new(0.0, 1.0, 0.0, 1.0))
    );
    assert_eq!((m.positions[199].x, m.corners[199].position), (199.0, 199));
    assert_eq!((m.point_materials.len(), warnings(&loaded)), (200, vec![]));
    assert_sound(m);
}

const WHOLE: &[u8] = b"\xef\xbb\xbf# c\nmtllib l.mtl\nv 0 0 0 1 0 0\nv 1.5e0 0 0 0 1 0\nv 0 1 -.5 0 0 1\nv 1 1 \\\n1 1 1 1\nvt 0 0\nvt 1 0\nvn 0 0 1\n\
    g a\nusemtl a b\nf 1/1/1 2/2/1 4/-1/-1 3/1/1\nl 1/1 2/2\np -1\r\nusemtl c\nf 1//1 2//1 3//1\n";
const WHOLE_MTL: &[u8] = b"newmtl a b\nKa 1 1 1\nKd 0.5 0.5 0.5\nNs 5\nd 1\nillum 2\nmap_Kd -s 1 1 1 x y.png\nnewmtl c\nKd 1\nTr 0\n";

#[test]
fn a_file_cut_at_any_byte_loads_or_is_refused() {
    for cut in 0..=WHOLE.len() {
        if let Ok(loaded) = load_with(&WHOLE[..cut], &[("l.mtl", WHOLE_MTL)]) {
            assert_sound(&loaded.geometry.mesh);
        }
    }
    for cut in 0..=WHOLE_MTL.len() {
        if let Ok(loaded) = load_with(WHOLE, &[("l.mtl", &WHOLE_MTL[..cut])]) {
            assert_sound(&loaded.geometry.mesh);
        }
    }
    assert_eq!(load_with(WHOLE, &[("l.mtl", WHOLE_MTL)]).unwrap().geometry.mesh.materials.len(), 2);
}

/// Generates pieces of statements, valid and invalid.
fn piece() -> impl Strategy<Value = String> {
    let words = [
        "v",
        "vt",
        "vn",
        "f",
        "l",
        "p",
        "usemtl",
        "mtllib",
        "newmtl",
        "Kd",
        "map_Kd",
        "illum",
        "d",
        "\n",
        "\r\n",
        " ",
        "\\\n",
        "/",
        "//",
        "1",
        "2",
        "-1",
        "-2",
        "0",
        "1.5",
        "1e400",
        "nan",
        "-9999999999999999999",
        "4294967296",
        "#",
        "x",
        "\u{e9}",
        "\0",
        "\u{feff}",
        "v 1 2 3\n",
        "v 0 0 1\n",
        "vt 0 0\n",
        "vn 0 0 1\n",
        "f 1 2 3\n",
        "f 1/1/1 2/1/1 3/1/1 1/1/1\n",
        "l.mtl",
    ];
    prop::sample::select(words.map(String::from).to_vec())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn no_bytes_make_it_panic(obj in prop::collection::vec(any::<u8>(), 0..60), mtl in prop::collection::vec(any::<u8>(), 0..60)) {
        let obj = [b"mtllib l.mtl\n", &obj[..]].concat();
        let _ = load_with(obj, &[("l.mtl", &mtl)]);
    }

    #[test]
    fn no_mixture_of_statements_makes_it_panic(
        obj in prop::collection::vec(piece(), 0..40),
        mtl in prop::collection::vec(piece(), 0..20),
    ) {
        // With blanks between the pieces as well as without.
        for between in ["", " "] {
            let obj = ["mtllib l.mtl\n", &obj.join(between)].concat();
            match load_with(obj, &[("l.mtl", mtl.join(between).as_bytes())]) {
                Ok(loaded) => assert_sound(&loaded.geometry.mesh),
                // Only an error that the check did not foresee has no line.
                Err(error) => prop_assert!(error.place.line > 0, "{}", error),
            }
        }
    }

    #[test]
    fn a_file_with_wrong_bytes_loads_or_is_refused(
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..4),
    ) {
        let mut obj = WHOLE.to_vec();
        for (at, byte) in changes {
            obj[at.index(WHOLE.len())] = byte;
        }
        match load_with(&obj, &[("l.mtl", WHOLE_MTL)]) {
            Ok(loaded) => assert_sound(&loaded.geometry.mesh),
            Err(error) => prop_assert!(error.place.line > 0, "{}", error),
        }
    }
}

#[test]
fn utf_16_is_read_with_and_without_its_mark() {
    let text = format!("{TRIANGLE}mtllib l.mtl\nusemtl \u{e9}\nf 1 2 3\n");
    let mtl = "newmtl \u{e9}\nKd 1 0 0\n";
    let plain = load_with(&text, &[("l.mtl", mtl.as_bytes())]).unwrap();
    assert_eq!((plain.geometry.mesh.materials.len(), plain.warnings.len()), (1, 0));
    let little = |t: &str| t.encode_utf16().flat_map(u16::to_le_bytes).collect::<Vec<u8>>();
    let big = |t: &str| t.encode_utf16().flat_map(u16::to_be_bytes).collect::<Vec<u8>>();
    for mark in ["", "\u{feff}"] {
        for encode in [little as fn(&str) -> Vec<u8>, big] {
            let [obj, mtl] = [&text, mtl].map(|t| encode(&format!("{mark}{t}")));
            let loaded = load_with(&obj, &[("l.mtl", &mtl)]).unwrap();
            assert_eq!(loaded.geometry.mesh, plain.geometry.mesh);
        }
    }
}

#[test]
fn an_empty_usemtl_is_no_material() {
    let files: [(&str, &[u8]); 1] = [("l.mtl", b"newmtl a\nKd 1 0 0\n")];
    let loaded = load_with(
        format!(
            "mtllib l.mtl\n{TRIANGLE}usemtl a\nf 1 2 3\nusemtl\nf 1 2 3\nusemtl  \nf 1 2 3\nusemtl a\nf 1 2 3"
        ),
        &files,
    );
    let loaded = loaded.unwrap();
    let materials: Vec<u32> = loaded.geometry.mesh.polygons.iter().map(|p| p.material).collect();
    assert_eq!((materials, loaded.warnings), (vec![0, NONE, NONE, 0], vec![]));
}

#[test]
fn smoothing_gives_normals_where_the_file_has_none() {
    let smooth = |obj: &str| {
        let angle = Smoothing::Angle(60_f64.to_radians());
        let memory = &mut LoadMemory::unlimited();
        parse_smooth(obj.as_bytes(), &mut |_| None, "m.obj", memory, angle).unwrap()
    };
    // Two squares that meet at 30 degrees; the second has positions of its own.
    let roof =
        "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 1 0\nv 1 1 0\nv 1 1.8660254 -0.5\nv 0 1.8660254 -0.5\n";
    let faces = "f 1 2 3 4\n{}f 5 6 7 8\n";
    let normals_meet = |between: &str, before: &str| {
        let loaded = smooth(&format!("{roof}{before}{}", faces.replace("{}", between)));
        assert!(loaded.is_open);
        assert_sound(&loaded.geometry.mesh);
        let corners = &loaded.geometry.mesh.corners;
        corners[3].normal == corners[4].normal
    };
    assert!(normals_meet("", ""), "equal positions are one vertex");
    assert!(normals_meet("", "s 1\n"));
    assert!(normals_meet("s 4294967296\n", "s 4294967296\n"), "a number beyond 32 bits");
    assert!(!normals_meet("s 2\n", "s 1\n"), "another group");
    assert!(!normals_meet("", "s off\n") && !normals_meet("", "s 0\n"), "no group");
    // Normals of the file stay, and such a mesh is not reported as open.
    let given = smooth("v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 2\nf 1//1 2//1 3//1\n");
    assert_eq!((given.geometry.mesh.normals.len(), given.is_open), (1, false));
    // The specification's rule adds no normals.
    assert_eq!(load(format!("{roof}{}", faces.replace("{}", ""))).geometry.mesh.normals, []);
}
