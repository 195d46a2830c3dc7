//! Classic encoding and VRML 97: the same pictures as the XML of the same scene, and errors with their
//! place, whatever is wrong with a text.

use crate::support::{data, draw, load, warnings};
use fbptr::load::x3d::{self, X3dDocument};

fn parse(text: &[u8]) -> Result<X3dDocument, String> {
    x3d::parse(text, "t.wrl", &mut |_| None).map_err(|e| e.to_string())
}

fn sample(name: &str) -> Vec<u8> {
    std::fs::read(data().join("classic").join(name)).unwrap()
}

#[test]
fn all_encodings_of_a_scene_have_the_same_pixels() {
    let expected = load("made/encodings.x3d").unwrap();
    assert_eq!(warnings(&expected), [] as [String; 0]);
    for name in ["classic/scene.x3dv", "classic/scene.wrl"] {
        let document = load(name).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(warnings(&document), [] as [String; 0], "{name}");
        for time in [0.0, 1.0, 2.5] {
            let [found, expected] = [&document, &expected].map(|d| draw(&d.at(time), 160, 120));
            assert!(found.bytes() == expected.bytes(), "{name} at {time}");
        }
    }
    let [first, later] = [0.0, 1.0].map(|time| draw(&expected.at(time), 160, 120));
    assert!(first.bytes() != later.bytes(), "routes are followed");
}

#[test]
fn compressed_files_and_inlines_of_either_encoding_are_read() {
    use std::io::Write;
    let mut packer = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::default());
    packer.write_all(&sample("scene.wrl")).unwrap();
    let packed = packer.finish().unwrap();
    assert_eq!(parse(&packed).unwrap().at(0.0).objects.len(), 7);
    let mut opener = |name: &str| (name == "scene.wrz").then(|| packed.clone());
    let outer = b"<X3D><Scene><Inline url='\"scene.wrz\"'/></Scene></X3D>";
    let document = x3d::parse(outer, "t.x3d", &mut opener).unwrap();
    assert_eq!((document.at(0.0).objects.len(), document.warnings().len()), (7, 0));
}

#[test]
fn names_of_prototypes_and_nodes_have_their_scope() {
    let text = "#VRML V2.0 utf8
        EXTERNPROTO Far [ field SFFloat size ] [ \"far.wrl#Far\" ]
        PROTO Box2 [ field SFString name \"a\" ] { PROTO Box3 [ ] { Box { } } Shape { geometry Box3 { } } }
        DEF A Group { children [ DEF B Shape { geometry Box { } } Box2 { name \"b\" } ] }
        USE B Script { url \"x.js\" field SFNode n USE A eventIn SFBool on eventOut SFBool off directOutput TRUE }
        Far { size 2 }";
    let far = "#VRML V2.0 utf8\nPROTO Far [ field SFFloat size 1 ] { Shape { geometry Sphere { radius IS size } } }";
    let mut opener = |name: &str| (name == "far.wrl").then(|| far.as_bytes().to_vec());
    let document = x3d::parse(text.as_bytes(), "t.wrl", &mut opener).unwrap();
    let found = warnings(&document);
    assert_eq!(document.at(0.0).objects.len(), 4, "{found:?}");
    assert_eq!(found.len(), 1, "{found:?}");
    assert!(found[0].starts_with("t.wrl:5:15: warning: ") && found[0].contains("scripts"), "{found:?}");
}

#[test]
fn what_is_wrong_is_said_at_its_place() {
    let deep = format!("{}Box {{}}{}", "Group { children [\n".repeat(300), "] }".repeat(300));
    for (body, expected) in [
        (
            "Shape {",
            "t.wrl:2:8: expected a field or }, which closes the Shape of line 2, found \"the end of the file\"",
        ),
        ("Shape { geometry }", "t.wrl:2:18: expected a value of the field geometry, found \"}\""),
        ("Group { children [ Shape { }", "expected a value or ], which closes the children of line 2"),
        ("Text { string [\n\"a\n", "t.wrl:3:1: expected a string to end with \""),
        ("Box { size 1 2 x }", "t.wrl:2:18: expected a value of the field x, found \"}\""),
        ("Shape { geometry Box { size 1 2 3e400 } }", "t.wrl:2:33: "),
        (
            "Shape { geometry IndexedFaceSet { coordIndex [ 0 # 1\n 1.5 ] } }",
            "t.wrl:3:2: <IndexedFaceSet> coordIndex takes whole numbers",
        ),
        ("Box { size 1 2 3 size 1 2 3 }", "t.wrl:2:18: expected the field size once in this node"),
        ("ROUTE a.b c.d", "t.wrl:2:11: expected TO in a ROUTE"),
        ("ROUTE ab TO c.d", "t.wrl:2:7: expected node.field in a ROUTE"),
        ("PROTO P [ field SFFloat ] { }", "t.wrl:2:25: expected the name of a field"),
        ("}", "t.wrl:2:1: expected a node or a statement"),
        ("Group }", "t.wrl:2:7: expected { after the node type Group"),
        ("7 { }", "t.wrl:2:1: expected the type of a node"),
        ("DEF A Group { children USE A }", "t.wrl:2:28: expected USE to name a node that is complete"),
        ("Inline { url \"t.wrl\" }", "no Inline of"),
        (&deep, "nesting of nodes"),
    ] {
        let text = format!("#VRML V2.0 utf8\n{body}");
        let own = text.clone().into_bytes();
        let read = x3d::parse(text.as_bytes(), "t.wrl", &mut |_| Some(own.clone()));
        let message = read.map_or_else(|e| e.to_string(), |_| "read".into());
        assert!(message.contains(expected), "{body}\n{message}\n{expected}");
    }
    let old = parse(b"#VRML V1.0 ascii\nSeparator { Cube { } }").unwrap_err();
    assert!(old.contains("VRML 1.0") && !old.contains('\n'), "{old}");
    let latin = parse(b"#VRML V2.0 utf8\n# \xe9\nShape { geometry Box { } }").unwrap();
    assert_eq!(warnings(&latin), ["t.wrl: warning: the file is no UTF-8: Latin-1 is taken"]);
}

#[test]
fn a_text_may_end_or_change_anywhere() {
    for name in ["scene.x3dv", "scene.wrl"] {
        let text = sample(name);
        for length in 0..text.len() {
            if let Err(message) = parse(&text[..length]) {
                assert!(message.starts_with("t.wrl:"), "{length}: {message}");
            }
        }
        let pieces: [&[u8]; 14] = [
            b"{", b"}", b"[", b"]", b"\"", b"#", b"\\", b",", b" DEF ", b" USE B ", b" IS ", b"\0", b"\xff",
            b" PROTO ",
        ];
        let mut state = 0x2545_f491_4f6c_dd1d_u64;
        let mut random = |below: usize| {
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            (state % below as u64) as usize
        };
        for _ in 0..3000 {
            let mut changed = text.clone();
            for _ in 0..=random(4) {
                let (from, length) = (random(changed.len()), random(4));
                let to = (from + length).min(changed.len());
                changed.splice(from..to, pieces[random(pieces.len())].iter().copied());
            }
            let _ = parse(&changed).map(|document| document.at(1.0));
        }
    }
}
