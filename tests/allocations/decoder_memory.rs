//! Memory taken by file loaders, by a counting allocator: never more than was reserved in the
//! budget.
//!
//! Guards against a small file that takes much memory because its estimate is too low or missing.

use crate::TURN;
use crate::counting::{most_held, most_held_here};
use fbptr::error::Code;
use fbptr::load::{LoadContext, LoadError, LoadMemory, MeshFormat, Smoothing, gltf, obj, texture, x3d};
use fbptr::memory::{MemoryBudget, MemoryUse};
use fbptr::scene::{Mesh, shapes};
use flate2::Compression;
use flate2::write::GzEncoder;
use image::{ExtendedColorType, ImageEncoder};
use std::io::Write;
use std::path::Path;
use std::sync::PoisonError;

/// Reads something within ever larger budgets, and checks that each attempt stays within its
/// budget: the refused ones, and the first that succeeds. Returns the budget of that one. The
/// caller must hold [`TURN`] since before it made the files, whose bytes would count as well.
fn least_budget<T>(what: &str, read: impl Fn(&mut LoadMemory) -> Result<T, LoadError>) -> u64 {
    // Tables that are made once per process are no part of the file's memory.
    drop(read(&mut LoadMemory::unlimited()));
    for limit in std::iter::successors(Some(64u64 << 10), |limit| Some(limit + limit / 3)).take(60) {
        let budget = MemoryBudget::new(limit);
        let (result, held) = most_held(|| {
            let mut memory = LoadMemory::new(&budget, u64::MAX);
            let result = read(&mut memory);
            (result.is_ok(), result.map(drop).err(), memory.kept_bytes())
        });
        let (is_read, error, kept) = result;
        println!("{what}: {held} bytes held of {limit}, {kept} kept, {error:?}");
        assert!(held <= limit + (32 << 10), "{what}: {held} bytes held with a budget of {limit}");
        assert_eq!(budget.used(), 0, "{what}: everything is given back");
        if is_read {
            return limit;
        }
        assert_eq!(error.map(|e| e.code()), Some(Code::Quota), "{what}");
    }
    panic!("{what}: no budget is enough")
}

#[test]
fn meshes_and_scenes_of_the_test_data_are_read_within_their_budget() {
    let _turn = TURN.lock().unwrap_or_else(PoisonError::into_inner);
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/formats");
    for folder in ["gltf", "gltf/beside", "stl", "ply"] {
        let names = std::fs::read_dir(data.join(folder)).unwrap().map(|entry| entry.unwrap().path());
        for path in names.filter(|path| path.is_file() && !path.to_string_lossy().contains("broken")) {
            let bytes = std::fs::read(&path).unwrap();
            let what = path.display().to_string();
            match path.extension().and_then(|ending| ending.to_str()) {
                Some("gltf" | "glb") => {
                    least_budget(&what, |memory| {
                        let opener = &mut |name: &str| std::fs::read(path.parent().unwrap().join(name)).ok();
                        gltf::parse_in(&bytes, "f", LoadContext { folder: "", opener, memory })
                    });
                }
                Some(ending @ ("stl" | "ply")) => {
                    least_budget(&what, |memory| {
                        let smoothing = Smoothing::Angle(1.0);
                        // Bytes after the last facet hide what a binary file is.
                        let format = if ending == "stl" { MeshFormat::Stl } else { MeshFormat::Ply };
                        format.parse(&bytes, &mut |_| None, "f", memory, smoothing)
                    });
                }
                _ => {}
            }
        }
    }
}

#[test]
fn long_meshes_are_read_within_their_budget() {
    let _turn = TURN.lock().unwrap_or_else(PoisonError::into_inner);
    let side = 120_u32;
    let at = |i: u32| [f64::from(i % side), f64::from(i / side), f64::from(i % 7)];
    let faces: Vec<[u32; 3]> = (0..side * (side - 1) - 1).map(|i| [i, i + 1, i + side]).collect();
    let mut text = b"solid a\n".to_vec();
    let mut binary = [&[0; 80][..], &(faces.len() as u32).to_le_bytes()].concat();
    let xyz = "property float x\nproperty float y\nproperty float z\n";
    let (vertices, count) = (side * side, faces.len());
    let elements = format!(
        "element vertex {vertices}\n{xyz}element face {count}\nproperty list uchar int vertex_indices\nend_header\n"
    );
    let mut ply = format!("ply\nformat ascii 1.0\n{elements}").into_bytes();
    let mut little = format!("ply\nformat binary_little_endian 1.0\n{elements}").into_bytes();
    for [x, y, z] in (0..vertices).map(at) {
        writeln!(ply, "{x} {y} {z}").unwrap();
        little.extend([x, y, z].iter().flat_map(|c| (*c as f32).to_le_bytes()));
    }
    for face in &faces {
        text.extend(b"facet normal 0 0 1\nouter loop\n");
        binary.extend([0; 12]);
        for [x, y, z] in face.map(at) {
            writeln!(text, "vertex {x} {y} {z}").unwrap();
            binary.extend([x, y, z].iter().flat_map(|c| (*c as f32).to_le_bytes()));
        }
        text.extend(b"endloop\nendfacet\n");
        binary.extend([0; 2]);
        writeln!(ply, "3 {} {} {}", face[0], face[1], face[2]).unwrap();
        little.push(3);
        little.extend(face.iter().flat_map(|i| i.to_le_bytes()));
    }
    text.extend(b"endsolid a\n");
    for (what, file) in
        [("STL text", text), ("STL binary", binary), ("PLY text", ply), ("PLY binary", little)]
    {
        for smoothing in [Smoothing::Indices, Smoothing::Angle(1.0)] {
            let limit = least_budget(what, |memory| {
                MeshFormat::of(&file).parse(&file, &mut |_| None, "f", memory, smoothing)
            });
            assert!(limit < 64 << 20, "{what}: {limit} bytes for {} of text", file.len());
        }
    }
}

fn png(width: u32, height: u32, color: ExtendedColorType) -> Vec<u8> {
    let mut out = Vec::new();
    let bytes = (u64::from(width) * u64::from(height) * u64::from(color.bits_per_pixel()) / 8) as usize;
    image::codecs::png::PngEncoder::new(&mut out).write_image(&vec![0; bytes], width, height, color).unwrap();
    out
}

#[test]
fn pictures_are_unpacked_within_what_their_headers_ask_for() {
    let _turn = TURN.lock().unwrap_or_else(PoisonError::into_inner);
    let side = 700;
    for color in [ExtendedColorType::Rgba8, ExtendedColorType::L8, ExtendedColorType::Rgba16] {
        let file = png(side, side, color);
        let limit =
            least_budget(&format!("PNG {color:?}"), |memory| texture::decode_within(&file, "t", memory));
        assert!(limit < 48 << 20, "{limit} bytes for a picture of 2 MB");
    }
    let pixels: Vec<u8> = (0..side * side * 3).map(|i| (i.wrapping_mul(2_654_435_761) >> 24) as u8).collect();
    let mut jpeg = Vec::new();
    image::codecs::jpeg::JpegEncoder::new(&mut jpeg)
        .write_image(&pixels, side, side, ExtendedColorType::Rgb8)
        .unwrap();
    least_budget("JPEG", |memory| texture::decode_within(&jpeg, "t", memory));
    let mut gif = Vec::new();
    let picture = image::RgbaImage::from_fn(side, side, |x, y| image::Rgba([x as u8, y as u8, 7, 255]));
    image::codecs::gif::GifEncoder::new(&mut gif).encode_frame(image::Frame::new(picture.clone())).unwrap();
    least_budget("GIF", |memory| texture::decode_within(&gif, "t", memory));
    for (name, format) in [("t.bmp", image::ImageFormat::Bmp), ("t.tga", image::ImageFormat::Tga)] {
        let mut file = std::io::Cursor::new(Vec::new());
        picture.write_to(&mut file, format).unwrap();
        least_budget(name, |memory| texture::decode_within(file.get_ref(), name, memory));
    }
    let pnm = [b"P6 700 700 255\n", &pixels[..]].concat();
    least_budget("PNM", |memory| texture::decode_within(&pnm, "t", memory));
}

#[test]
fn a_picture_is_refused_before_a_pixel_is_unpacked() {
    let _turn = TURN.lock().unwrap_or_else(PoisonError::into_inner);
    // 64 MB of pixels, 85 MB more of smaller levels.
    let file = png(4096, 4096, ExtendedColorType::Rgba8);
    let unlimited = MemoryBudget::unlimited();
    let (result, held) =
        most_held(|| texture::decode_within(&file, "t", &mut LoadMemory::new(&unlimited, 10_000_000)));
    let error = result.map(drop).unwrap_err();
    assert_eq!(
        (error.code(), error.to_string().contains("the quota leaves 10000000")),
        (Code::Quota, true),
        "{error}"
    );
    assert!(held < 1 << 20, "{held} bytes were held");
    let budget = MemoryBudget::new(50 << 20);
    let (result, held) =
        most_held(|| texture::decode_within(&file, "t", &mut LoadMemory::new(&budget, u64::MAX)));
    assert_eq!(result.map(drop).unwrap_err().code(), Code::Quota);
    assert!(held < 1 << 20, "{held} bytes were held");
}

#[test]
fn obj_files_are_read_within_what_their_text_asks_for() {
    let _turn = TURN.lock().unwrap_or_else(PoisonError::into_inner);
    let many = |line: &str, count: usize| line.repeat(count);
    let vertices = "v 1 2 3\n".repeat(1000);
    let cases = [
        ("positions", many("v 0 0 0\n", 30_000)),
        ("long numbers", many("v 1e15 1e15 1e15 1 1 1\n", 20_000)),
        (
            "all of a vertex",
            many("v 0 0 1\nvt 0 0\nvn 0 0 1\n", 10_000) + &many("f -1/-1/-1 -2/-2/-2 -3/-3/-3\n", 9_000),
        ),
        ("triangles", vertices.clone() + &many("f 1 2 3\n", 40_000)),
        ("squares of three", vertices.clone() + &many("f 1 2 3 4\n", 30_000)),
        ("one polygon", vertices.clone() + "f" + &" 1 2 3".repeat(300) + "\n"),
        ("points", vertices.clone() + &many("p 1\n", 66_000)),
        ("lines", vertices.clone() + &many("l 1 2\n", 33_000)),
        ("blank lines", many("\n", 400_000)),
        ("comments", many("#\n", 200_000)),
        ("joined lines", vertices.clone() + "f 1 2 3" + &many("\\\n", 100_000) + "\n"),
        ("unknown statements", vertices.clone() + &(0..9000).map(|i| format!("a{i}\n")).collect::<String>()),
        (
            "material names",
            vertices + &(0..9000).map(|i| format!("usemtl {i}\nf 1 2 3\n")).collect::<String>(),
        ),
    ];
    for (name, text) in cases {
        let limit =
            least_budget(name, |memory| obj::parse_within(text.as_bytes(), &mut |_| None, "m", memory));
        assert!(
            limit < 600 * text.len() as u64 + (1 << 20),
            "{name}: {limit} bytes for {} of text",
            text.len()
        );
    }
}

/// Content of a scene, with its name in messages.
type Content = (&'static str, String);

fn shape(geometry: &str) -> String {
    format!("<Shape>{geometry}</Shape>")
}

/// Returns scenes of many nodes.
fn many_nodes() -> Vec<Content> {
    vec![
        ("groups", "<Group/>".repeat(20_000)),
        ("blanks", "<a/> ".repeat(33_000)),
        ("unknown nodes", "<a/>".repeat(20_000)),
        ("attributes", "<Group a='1' b='2' c='3' d='4'/>".repeat(8_000)),
        ("names", (0..9_000).map(|i| format!("<Group DEF='a{i}'/>")).collect()),
        ("lines", "\n".repeat(300_000)),
        ("boxes", shape("<Box/>").repeat(4_000)),
        ("extrusions", shape("<Extrusion spine='0 0 0 0 1 0 0 2 0 0 3 0'/>").repeat(300)),
        (
            "one long extrusion",
            shape(&format!(
                "<Extrusion spine='{}'/>",
                (0..2000).map(|i| format!("0 {i} 0 ")).collect::<String>()
            )),
        ),
    ]
}

/// Returns scenes of one large geometry.
fn large_geometries() -> Vec<Content> {
    let numbers = "0 0 1 ".repeat(20_000);
    vec![
        ("points", shape(&format!("<PointSet><Coordinate point='{numbers}'/></PointSet>"))),
        (
            "lines of points",
            shape(&format!("<LineSet vertexCount='20000'><Coordinate point='{numbers}'/></LineSet>")),
        ),
        (
            "a face set",
            shape(&format!(
                "<IndexedFaceSet coordIndex='{}'><Coordinate point='0 0 0 1 0 0 0 1 0'/></IndexedFaceSet>",
                "0 1 2 -1 ".repeat(20_000)
            )),
        ),
        (
            "triangles",
            shape(&format!(
                "<IndexedTriangleSet index='{}'><Coordinate point='0 0 0 1 0 0 0 1 0'/></IndexedTriangleSet>",
                "0 1 2 ".repeat(20_000)
            )),
        ),
        (
            "a triangle fan",
            shape(&format!(
                "<IndexedTriangleFanSet index='{}'><Coordinate point='0 0 0 1 0 0 0 1 0'/></IndexedTriangleFanSet>",
                "0 1 2 ".repeat(10_000)
            )),
        ),
        (
            "a grid",
            shape(&format!(
                "<ElevationGrid xDimension='150' zDimension='150' height='{}'/>",
                "1 ".repeat(22_500)
            )),
        ),
        ("text", shape(&format!("<Text string='\"{}\"'/>", "W".repeat(4_000)))),
    ]
}

/// Returns scenes with pictures inside.
fn pictures() -> Vec<Content> {
    let file = png(600, 600, ExtendedColorType::Rgba8);
    let hex: String = file.iter().map(|b| format!("%{b:02x}")).collect();
    let texture =
        format!("<Shape><Appearance><ImageTexture url='\"data:,{hex}\"'/></Appearance><Box/></Shape>");
    vec![
        ("a texture", texture),
        ("a background's picture", format!("<Background frontUrl='\"data:,{hex}\"'/>")),
        (
            "a pixel texture",
            format!(
                "<Shape><Appearance><PixelTexture image='200 200 1 {}'/></Appearance><Box/></Shape>",
                "1 ".repeat(40_000)
            ),
        ),
    ]
}

/// Returns scenes of prototypes.
fn prototypes() -> Vec<Content> {
    vec![
        ("instances of a prototype", PROTO.to_owned() + &"<ProtoInstance name='P'/>".repeat(4_000)),
        ("instances with names", {
            let named = |i| {
                format!(
                    "<ProtoInstance name='P' DEF='i{i}'><fieldValue name='f' value='{i} 0 0'/></ProtoInstance>"
                )
            };
            PROTO.to_owned() + &(0..3_000).map(named).collect::<String>()
        }),
        (
            "prototypes that double",
            (1..12).fold(PROTO.to_owned(), |text, i| {
                let inner = if i == 1 { "P".to_owned() } else { format!("P{}", i - 1) };
                let two = format!("<ProtoInstance name='{inner}'/>").repeat(2);
                text + &format!(
                    "<ProtoDeclare name='P{i}'><ProtoBody><Group>{two}</Group></ProtoBody></ProtoDeclare>"
                )
            }) + "<ProtoInstance name='P11'/>",
        ),
    ]
}

/// Returns scenes in the classic encoding.
fn classic() -> Vec<Content> {
    let long = "N".repeat(128);
    vec![
        ("classic nodes", "A{}".repeat(30_000)),
        ("classic groups", "Group{}".repeat(20_000)),
        ("classic fields", "A{b 1}".repeat(20_000)),
        ("classic strings", format!("Text {{ string [ {} ] }}", "\"\"".repeat(100_000))),
        ("classic routes", "ROUTE a.b TO c.d\n".repeat(10_000)),
        ("classic names", (0..9_000).map(|i| format!("DEF a{i} Group{{}}")).collect()),
        ("classic uses of a long type", format!("DEF a {long}{{}}{}", " USE a".repeat(10_000))),
        (
            "classic prototypes",
            (0..5_000).map(|i| format!("PROTO P{i}[field SFFloat f 1]{{}}P{i}{{f 2}}")).collect(),
        ),
        (
            "classic points",
            format!("Shape{{geometry PointSet{{coord Coordinate{{point[{}]}}}}}}", "0 0 1 ".repeat(20_000)),
        ),
        ("classic comments", "#\n".repeat(200_000)),
    ]
}

#[test]
fn classic_x3d_is_read_within_what_its_text_asks_for() {
    let _turn = TURN.lock().unwrap_or_else(PoisonError::into_inner);
    for (name, inside) in classic() {
        let text = format!("#VRML V2.0 utf8\n{inside}");
        least_budget(name, |memory| x3d::parse_within(text.as_bytes(), "s", &mut |_| None, memory));
    }
}

#[test]
fn x3d_files_are_read_within_what_their_text_asks_for() {
    let _turn = TURN.lock().unwrap_or_else(PoisonError::into_inner);
    let scene = |inside: &str| format!("<X3D><Scene>{inside}</Scene></X3D>");
    for (name, inside) in [many_nodes(), large_geometries(), pictures(), prototypes()].concat() {
        let text = scene(&inside);
        least_budget(name, |memory| x3d::parse_within(text.as_bytes(), "s", &mut |_| None, memory));
    }
    // A few compressed bytes that decompress to many.
    let mut packed = GzEncoder::new(Vec::new(), Compression::best());
    packed.write_all(scene(&format!("<Group/><!--{}-->", " ".repeat(3 << 20))).as_bytes()).unwrap();
    let packed = packed.finish().unwrap();
    assert!(packed.len() < 10_000, "{} bytes", packed.len());
    least_budget("gzip", |memory| x3d::parse_within(&packed, "s", &mut |_| None, memory));
}

/// A prototype with a field and a few nodes.
const PROTO: &str = "<ProtoDeclare name='P'><ProtoInterface><field name='f' type='SFVec3f' accessType='inputOutput' value='1 2 3'/>\
    </ProtoInterface><ProtoBody><Transform DEF='T'><IS><connect nodeField='translation' protoField='f'/></IS><Switch><a/><Group/></Switch>\
    <Shape><Box/></Shape></Transform></ProtoBody></ProtoDeclare>";

#[test]
fn what_a_scene_keeps_is_counted_with_its_textures_and_meshes() {
    let _turn = TURN.lock().unwrap_or_else(PoisonError::into_inner);
    let file = png(2048, 2048, ExtendedColorType::Rgba8);
    let hex: String = file.iter().map(|b| format!("%{b:02x}")).collect();
    let text = format!(
        "<X3D><Scene><Shape><Appearance><ImageTexture url='\"data:,{hex}\"'/></Appearance><Sphere/></Shape></Scene></X3D>"
    );
    let budget = MemoryBudget::unlimited();
    let mut memory = LoadMemory::new(&budget, u64::MAX);
    let document = x3d::parse_within(text.as_bytes(), "s", &mut |_| None, &mut memory).unwrap();
    let kept = memory.into_kept();
    assert!(kept.bytes() > 2048 * 2048 * 4, "{} bytes kept", kept.bytes());
    assert_eq!(budget.used_for(MemoryUse::Resources), kept.bytes());
    assert_eq!(budget.used_for(MemoryUse::Decoders), 0);
    drop((document, kept));
    assert_eq!(budget.used(), 0);
    let mut memory = LoadMemory::new(&budget, 8 << 20);
    let refused = x3d::parse_within(text.as_bytes(), "s", &mut |_| None, &mut memory).map(drop).unwrap_err();
    assert_eq!(refused.code(), Code::Quota);
}

#[test]
fn a_scene_says_what_its_objects_take_however_often_they_are_used() {
    let _turn = TURN.lock().unwrap_or_else(PoisonError::into_inner);
    // Ten times ten times ... shapes in a few hundred bytes.
    let mut text = String::from("<X3D><Scene><Group DEF='g0'><Shape><Box/></Shape></Group>");
    for i in 1..5 {
        let uses = format!("<Group USE='g{}'/>", i - 1).repeat(8);
        text += &format!("<Group DEF='g{i}'>{uses}</Group>");
    }
    text += "</Scene></X3D>";
    let document = x3d::parse(text.as_bytes(), "s", &mut |_| None).unwrap();
    let (scene, held) = most_held(|| document.at(0.0));
    assert!(scene.objects.len() > 4000);
    let stated = document.scene_bytes();
    assert!(held <= stated && stated < 4 * held, "{held} bytes held, {stated} stated");
}

#[test]
fn shapes_take_what_they_are_said_to_take() {
    let _turn = TURN.lock().unwrap_or_else(PoisonError::into_inner);
    let check = |name: &str, charged: u64, make: &dyn Fn() -> Mesh| {
        let (mesh, held) = most_held_here(make);
        println!("{name}: {charged} bytes charged, {held} held, {} kept", mesh.size_bytes());
        assert!(held <= charged, "{name}: {held} bytes held, {charged} charged");
        assert!(charged <= held + held * 15 / 100, "{name}: {charged} bytes charged for {held}");
    };
    for (nu, nv) in [(60, 20), (300, 100), (1000, 333)] {
        check(&format!("KNOT {nu} {nv}"), shapes::knot_bytes(nu, nv), &|| shapes::knot(nu, nv).unwrap());
    }
    for level in [10, 37, 100] {
        check(&format!("TEAPOT {level}"), shapes::teapot_bytes(level), &|| shapes::teapot(level).unwrap());
    }
}
