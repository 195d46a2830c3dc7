//! PLY files, each with the mesh, or the error with its place and reason, that it must give.

use super::*;
use fbptr_core::memory::MemoryBudget;
use fbptr_core::scene::{Mesh, NONE};
use glam::{DVec2, DVec3, DVec4, Vec3Swizzles};

const XYZ: &str = "property float x\nproperty float y\nproperty float z\n";

fn load(bytes: impl AsRef<[u8]>) -> Result<LoadedMesh, String> {
    let memory = &mut LoadMemory::unlimited();
    parse(bytes.as_ref(), "m.ply", memory, Smoothing::Indices).map_err(|e| e.to_string())
}

fn mesh(text: &str) -> Mesh {
    load(text).unwrap_or_else(|e| panic!("{e}\n{text}")).geometry.mesh
}

/// Returns a text with this header and body.
fn text(elements: &str, body: &str) -> String {
    format!("ply\nformat ascii 1.0\ncomment made by hand\n{elements}end_header\n{body}")
}

/// Returns a square as a text: four vertices, and `rest`.
fn square(rest: &str, body: &str) -> String {
    text(&format!("element vertex 4\n{XYZ}{rest}"), &format!("0 0 0\n1 0 0\n1 1 0\n0 1 0\n{body}"))
}

const FACES: &str = "property list uchar int vertex_indices\n";

#[test]
fn polygons_of_any_size_are_read() {
    let m = mesh(&square(&format!("element face 3\n{FACES}"), "4 0 1 2 3\n3 2 1 0\n2 0 1"));
    assert_eq!(m.polygons.iter().map(|p| p.corner_count).collect::<Vec<_>>(), [4, 3]);
    assert_eq!(m.triangles.len(), 3);
    assert_eq!(m.positions[2], DVec3::new(1.0, 1.0, 0.0));
    assert!(m.corners.iter().all(|c| [c.normal, c.texcoord, c.color] == [NONE; 3]));
}

#[test]
fn the_three_encodings_give_the_same_mesh() {
    let elements = "element vertex 3\nproperty double x\nproperty float y\nproperty short z\n\
        property uchar red\nproperty uchar green\nproperty uchar blue\nproperty uchar alpha\n\
        element face 1\nproperty list uint ushort vertex_index\n";
    let vertices = [(0.0f64, 0.5, 0, [255, 0, 51, 255]), (1.25, 0.0, -3, [0; 4]), (0.0, 1.0, 9, [255; 4])];
    let rows: String =
        vertices.iter().map(|(x, y, z, [r, g, b, a])| format!("{x} {y} {z} {r} {g} {b} {a}\n")).collect();
    let plain = mesh(&text(elements, &format!("{rows}3 0 1 2\n")));
    let whole = |little: bool| {
        let order = if little { "little" } else { "big" };
        let mut bytes = format!("ply\nformat binary_{order}_endian 1.0\n{elements}end_header\n").into_bytes();
        macro_rules! put {
            ($value:expr) => {
                bytes.extend(if little { $value.to_le_bytes() } else { $value.to_be_bytes() })
            };
        }
        for (x, y, z, color) in vertices {
            put!(x);
            put!((y as f32));
            put!((z as i16));
            bytes.extend(color.map(|c: i32| c as u8));
        }
        put!(3_u32);
        (0..3_u16).for_each(|i| put!(i));
        mesh_of(&bytes)
    };
    assert_eq!(plain.colors[0], DVec4::new(1.0, 0.0, 0.2, 1.0));
    assert_eq!(plain.corners[1].color, 1);
    assert_eq!(whole(true), plain);
    assert_eq!(whole(false), plain);
}

fn mesh_of(bytes: &[u8]) -> Mesh {
    load(bytes).expect("loads").geometry.mesh
}

#[test]
fn attributes_belong_to_vertices_or_to_faces() {
    let of_vertices = mesh(&text(
        &format!(
            "element vertex 3\n{XYZ}property float nx\nproperty float ny\nproperty float nz\n\
            property float s\nproperty float t\nelement face 1\n{FACES}"
        ),
        "0 0 0 0 0 1 0 0\n1 0 0 0 0 1 1 0\n0 1 0 0 1 0 0 1\n3 0 1 2\n",
    ));
    assert_eq!((of_vertices.normals[2], of_vertices.texcoords[1]), (DVec3::Y, DVec2::X));
    assert_eq!((of_vertices.corners[1].normal, of_vertices.corners[1].texcoord), (1, 1));
    let of_faces = mesh(&square(
        &format!(
            "element face 2\n{FACES}property list uchar float texcoord\nproperty uchar red\n\
            property uchar green\nproperty uchar blue\nproperty int flags\n"
        ),
        "3 0 1 2 6 0 0 1 0 1 1 255 0 0 7\n3 0 2 3 0 0 0 255 7\n",
    ));
    assert_eq!(of_faces.texcoords, [DVec2::ZERO, DVec2::X, DVec2::ONE]);
    assert_eq!(of_faces.corners.iter().map(|c| c.texcoord).collect::<Vec<_>>(), [0, 1, 2, NONE, NONE, NONE]);
    assert_eq!(of_faces.corners.iter().map(|c| c.color).collect::<Vec<_>>(), [0, 0, 0, 1, 1, 1]);
    assert_eq!(of_faces.colors, [DVec4::new(1.0, 0.0, 0.0, 1.0), DVec4::new(0.0, 0.0, 1.0, 1.0)]);
}

#[test]
fn strips_edges_and_clouds_are_read() {
    let strips = mesh(&square(&format!("element tristrips 1\n{FACES}"), "8 0 1 3 2 -1 0 1 2\n"));
    let triangles: Vec<Vec<u32>> =
        (0..3).map(|p| strips.polygon_corners(p).iter().map(|c| c.position).collect()).collect();
    assert_eq!(triangles, [[0, 1, 3], [3, 1, 2], [0, 1, 2]]);
    let edges = mesh(&square("element edge 1\nproperty int vertex1\nproperty int vertex2\n", "3 0\n"));
    assert_eq!((edges.lines.len(), edges.corners[0].position, edges.points.len()), (1, 3, 0));
    let cloud = mesh(&square("", ""));
    assert_eq!((cloud.points.len(), cloud.polygons.len()), (4, 0));
    // Rows of unknown elements are passed over.
    let other = "element range_grid 2\nproperty list uchar int vertex_indices\nproperty float q\n";
    assert_eq!(mesh(&square(other, "1 0 nan\n0 1e9\n")).points.len(), 4);
    // Faces may come before the vertices.
    let early = format!("element face 1\n{FACES}element vertex 3\n{XYZ}");
    assert_eq!(mesh(&text(&early, "3 0 1 2\n0 0 0 1 0 0\n0 1 0")).triangles.len(), 1);
}

#[test]
fn broken_files_are_refused_with_place_and_reason() {
    let face = format!("element face 1\n{FACES}");
    let vertices = format!("element vertex 4000000000\n{XYZ}");
    for (text, expected) in [
        ("ply\n".to_owned(), "m.ply:1: not a readable PLY: the header has no end_header"),
        (text("element vertex x\n", ""), "m.ply:4: expected a number of rows, found \"element vertex x\""),
        (
            text("element vertex 1\nproperty half x\n", ""),
            "m.ply:5: expected property TYPE NAME or property list TYPE TYPE NAME, found \"property half x\"",
        ),
        (
            text("property float x\n", ""),
            "m.ply:4: expected an element before its properties, found \"property float x\"",
        ),
        (
            text(&vertices, "0 0 0\n"),
            "m.ply:9: not a readable PLY: 4000000000 rows of \"vertex\" need 8000000000 bytes or more, and 6 are left",
        ),
        (
            text("element vertex 9\n", "0 0 0\n"),
            "m.ply:6: not a readable PLY: the 9 rows of \"vertex\" have no properties",
        ),
        (square(&face, "3 0 1 4\n"), "m.ply:15: vertex index 4 names none of the 4 there are"),
        (square(&face, "3 0 -1 2\n"), "m.ply:15: vertex index -1 names none of the 4 there are"),
        (
            square(&face, "3 0 one 2\n"),
            "m.ply:15: a vertex index must be a finite number, found \"another word\"",
        ),
        (
            square(&face, "200 0 1 2\n"),
            "m.ply:15: not a readable PLY: a row of \"face\" with fewer values than its properties take",
        ),
        (
            square(&face.replace("face 1", "face 3"), "3 0 1 2\n"),
            "m.ply:16: not a readable PLY: the file ends in row 2 of 3 of \"face\"",
        ),
        (
            text("element vertex 1\nproperty float x\n", "1\n"),
            "m.ply:6: not a readable PLY: a vertex has no x, y and z",
        ),
    ] {
        let found = load(&text).map(|l| l.geometry.mesh.corners.len()).unwrap_err();
        assert_eq!(found, expected, "{text}");
    }
    let mut bytes =
        format!("ply\nformat binary_little_endian 1.0\nelement vertex 1\n{XYZ}end_header\n").into_bytes();
    let start = bytes.len();
    bytes.extend([0; 8]);
    assert_eq!(
        load(&bytes).unwrap_err(),
        format!(
            "m.ply:byte {start}: not a readable PLY: 1 rows of \"vertex\" need 12 bytes or more, and 8 are left"
        )
    );
    bytes.extend(f32::NAN.to_le_bytes());
    assert_eq!(
        load(&bytes).unwrap_err(),
        format!("m.ply:byte {start}: a position must be a finite number, found \"NaN\"")
    );
}

#[test]
fn rows_that_cannot_be_used_are_left_out_and_counted() {
    let faces = format!("element face 3\n{FACES}");
    for (text, [polygons, points], said) in [
        (
            square("", "").replace("1 1 0", "1 inf 0"),
            [0, 3],
            "m.ply:11: warning: a position must be a finite number, found \"inf\": the vertex and what uses it are left out",
        ),
        (square("", "").replace("1 1 0", "-1.#IND nan 0"), [0, 3], ""),
        (square(&faces, "3 0 1 2\n3 0 1 2\n3 0 1 3\n").replace("1 1 0", "1 inf 0"), [1, 0], ""),
        (
            square(&faces, "3 0 1 2\n3 0 1 4\n3 0 1 -5\n"),
            [1, 0],
            "m.ply:16: warning: vertex index 4 names none of the 4 there are: its row is left out, 2 times in all",
        ),
        // A line that is longer or shorter than its row, and one with a comment.
        (
            square(&faces, "3 0 1 2\n3 0 2 3 9 1 1\n3 0 1 2\n"),
            [3, 0],
            "m.ply:16: warning: not a readable PLY: a row of \"face\" with more values than its properties take: they are left out",
        ),
        (square(&faces, "3 0 1 2\n3 0 2\n3 0 1 2\n"), [2, 0], ""),
        (square(&faces, "3 0 1 2\n-3 0 2 3\n3 0 1 2\n"), [2, 0], ""),
        (square("", "").replace("1 0 0\n", "1 0 0 7 8\n"), [0, 4], ""),
        (square("", "").replace("1 0 0\n", "1 0\n"), [0, 3], ""),
    ] {
        let loaded = load(&text).unwrap_or_else(|e| panic!("{e}\n{text}"));
        let mesh = &loaded.geometry.mesh;
        assert_eq!([mesh.polygons.len(), mesh.points.len()], [polygons, points], "{text}");
        assert_eq!(loaded.warnings.len(), 1, "{text}\n{:?}", loaded.warnings);
        assert!(said.is_empty() || loaded.warnings[0].to_string() == said, "{}", loaded.warnings[0]);
        assert!(mesh.bounds().unwrap().1.max_element() <= 1.0, "{text}");
    }
}

#[test]
fn spellings_of_real_programs_are_read_without_a_warning() {
    let plain = square(&format!("element face 2\n{FACES}"), "3 0 1 2\n3 0 2 3\n");
    let upper = plain.replace("ply", "PLY").replace("element", "ELEMENT").replace("format", "Format");
    let commented = plain.replace("1 1 0\n", "comment of a row\n\n1 1 0\n# another\n");
    // Rows in one line, and a row in several.
    let joined = plain.replace("1 0 0\n1 1 0\n", "1 0 0 1 1 0\n");
    let parted = plain.replace("3 0 2 3", "3 0\n2 3");
    let named = plain
        .replace("vertex 4", "VERTEX 4")
        .replace("float x", "FLOAT X")
        .replace("uchar int", "uint8 int64");
    for text in [
        plain.clone(),
        format!("\u{feff}{plain}"),
        plain.replace('\n', "\r"),
        plain.replace('\n', "\r\n"),
        upper,
        commented,
        joined,
        parted,
        named,
        plain.trim_end().to_owned(),
        plain.replace("comment made by hand", "obj_info made by hand"),
    ] {
        let loaded = load(&text).unwrap_or_else(|e| panic!("{e}\n{text:?}"));
        assert!(loaded.warnings.is_empty(), "{text:?}\n{:?}", loaded.warnings);
        assert_eq!(loaded.geometry.mesh, mesh(&plain), "{text:?}");
    }
    // The first byte of binary rows is no line end, whatever it is.
    for end in ["\n", "\r", "\r\n"] {
        let header = format!("ply\nformat binary_big_endian 1.0\nelement vertex 1\n{XYZ}end_header\n");
        let mut bytes = header.replace('\n', end).into_bytes();
        let start = bytes.len();
        bytes.extend([1.0_f32; 3].iter().flat_map(|x| x.to_be_bytes()));
        bytes[start + 3] = b'\n';
        let x = f32::from_be_bytes([bytes[start], bytes[start + 1], bytes[start + 2], b'\n']);
        assert_eq!(mesh_of(&bytes).positions[0], DVec3::new(f64::from(x), 1.0, 1.0), "{end:?}");
        bytes[start] = b'\n';
        assert_eq!(mesh_of(&bytes).positions[0].yz(), DVec2::ONE, "{end:?}");
    }
}

#[test]
fn colors_of_splats_and_of_bytes_in_real_types_are_seen() {
    let colors = |properties: &str, row: &str| {
        let names = properties.split(' ').map(|name| format!("property float {name}\n")).collect::<String>();
        let loaded =
            load(text(&format!("element vertex 1\n{XYZ}{names}"), &format!("0 0 0 {row}\n"))).unwrap();
        (loaded.geometry.mesh.colors[0].truncate(), loaded.warnings.len())
    };
    let (splat, warned) = colors("f_dc_0 f_dc_1 f_dc_2 opacity", "0 1 -9 3");
    assert!((splat - DVec3::new(0.5, 0.5 + 0.282_094_791_773_878_14, 0.0)).length() < 1e-15, "{splat}");
    assert_eq!(warned, 0);
    assert_eq!(colors("red green blue", "255 51 0"), (DVec3::new(1.0, 0.2, 0.0), 1));
    assert_eq!(colors("red green blue", "1 0.2 0"), (DVec3::new(1.0, 0.2, 0.0), 0));
}

#[test]
fn the_texture_that_a_comment_names_is_shown() {
    let faces = format!("element face 1\n{FACES}property list uchar float texcoord\n");
    let plain = square(&faces, "3 0 1 2 6 0 0 1 0 1 1\n");
    let named =
        |name: &str| plain.replacen("comment made by hand", &format!("comment TextureFile {name}"), 1);
    let read = |text: &str| {
        let mut beside = |name: &str| (name == "t/a b.ppm").then(|| b"P6 1 1 255\n\x01\x02\x03".to_vec());
        let memory = &mut LoadMemory::unlimited();
        let loaded = parse_textured(text.as_bytes(), &mut beside, "m.ply", memory, Smoothing::Indices);
        let loaded = loaded.unwrap();
        let warnings: Vec<String> = loaded.warnings.iter().map(LoadWarning::to_string).collect();
        (loaded.geometry, warnings)
    };
    let (geometry, said) = read(&named("t\\a b.ppm"));
    assert_eq!(said, [""; 0]);
    assert_eq!(geometry.textures[0].as_ref().unwrap().bytes(), [1, 2, 3, 255]);
    assert_eq!((geometry.mesh.polygons[0].material, geometry.mesh.materials[0].kd), (0, DVec3::ONE));
    let (geometry, said) = read(&named("D:\\w\\t\\a b.ppm"));
    assert!(geometry.textures[0].is_some() && said[0].contains("of another machine"), "{said:?}");
    let (geometry, said) = read(&named("gone.png"));
    assert!(geometry.textures[0].is_none());
    assert_eq!(said, ["m.ply:3: warning: texture \"gone.png\" cannot be found: it is left out"]);
    let (_, said) = read(&square("", "").replacen("comment made by hand", "comment TextureFile a.png", 1));
    assert_eq!(said, ["m.ply: warning: its texture is not shown: there are no texture coordinates"]);
}

#[test]
fn memory_is_reserved_before_it_is_used() {
    let rows = "0 0 0\n".repeat(1000);
    let text = text(&format!("element vertex 1000\n{XYZ}"), &rows);
    let memory = &mut LoadMemory::new(&MemoryBudget::new(100_000), u64::MAX);
    let error = parse(text.as_bytes(), "m.ply", memory, Smoothing::Indices).unwrap_err();
    assert_eq!(error.code(), fbptr_core::error::Code::Quota, "{error}");
}
