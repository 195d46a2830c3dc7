//! X3D over a socket: compressed scenes and prototypes, drawn for the current camera, and scenes
//! that would take too much.
//!
//! Guards against few bytes that become many nodes, and against names of files outside the sandbox.

use crate::folder::Folder;
use crate::support::{Serving, Wire};
use fbptr::load::SandboxDir;
use fbptr::server::{Engine, Limits};
use flate2::Compression;
use flate2::write::GzEncoder;
use std::io::Write;

pub fn gzip(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::best());
    encoder.write_all(bytes).unwrap();
    encoder.finish().unwrap()
}

pub fn scene(bytes: &[u8]) -> Vec<u8> {
    [format!("SCENE X3D :{}\n", bytes.len()).as_bytes(), bytes].concat()
}

/// Returns prototypes that each contain two instances of the one before, the first one a thousand
/// points.
pub fn doubling(levels: usize) -> String {
    let points = "0 0 0 ".repeat(1000);
    let mut text = format!(
        "<Scene><ProtoDeclare name='P0'><ProtoBody><Shape DEF='S'><PointSet DEF='G'><Coordinate DEF='C' point='{points}'/>\
         </PointSet></Shape></ProtoBody></ProtoDeclare>"
    );
    for i in 1..=levels {
        let inner = format!("<ProtoInstance name='P{}'/>", i - 1).repeat(2);
        text += &format!(
            "<ProtoDeclare name='P{i}'><ProtoBody><Group>{inner}</Group></ProtoBody></ProtoDeclare>"
        );
    }
    text + &format!("<ProtoInstance name='P{levels}'/></Scene>")
}

#[test]
fn a_compressed_scene_of_prototypes_is_drawn_for_the_camera_that_looks() {
    let serving = Serving::start(40, 30);
    let text = "<X3D><Scene><Viewpoint position='0 0 6'/><ProtoDeclare name='Near'><ProtoInterface><field name='shown' \
        type='MFNode' accessType='initializeOnly'/></ProtoInterface><ProtoBody><LOD range='20'><Group><IS><connect \
        nodeField='children' protoField='shown'/></IS></Group><Group/></LOD></ProtoBody></ProtoDeclare><ProtoInstance \
        name='Near'><fieldValue name='shown'><Shape><Box size='3 3 3'/></Shape></fieldValue></ProtoInstance></Scene></X3D>";
    let mut wire = serving.connect();
    wire.send(&scene(&gzip(text.as_bytes())));
    assert_eq!(wire.ask("DRAWSCENE\nSYNC a\n"), "SYNC a\n");
    let middle = |wire: &mut Wire| wire.ask("PX 20 15\n");
    assert_ne!(middle(&mut wire), "PX 20 15 000000\n");
    // Beyond 20 units the second level, which is empty, is selected.
    let said = wire.ask("CLEAR\nLOOKAT 0 0 21 0 0 0 0 1 0\nDRAWSCENE\nSYNC b\n");
    assert!(said.starts_with("WARN 7 ") && said.contains("DRAWSCENE: nothing is drawn"), "{said}");
    assert_eq!(wire.line(), "SYNC b\n");
    assert_eq!(middle(&mut wire), "PX 20 15 000000\n");
    assert_eq!(wire.ask("LOOKAT 0 0 19 0 0 0 0 1 0\nDRAWSCENE\nSYNC c\n"), "SYNC c\n");
    assert_ne!(middle(&mut wire), "PX 20 15 000000\n");
}

#[test]
fn scenes_that_would_take_too_much_are_refused_and_others_go_on() {
    let limits = Limits { memory_bytes: 64 << 20, ..Limits::default() };
    let serving = Serving::limited(40, 30, limits);
    let bomb = gzip(format!("<Scene><!--{}--></Scene>", " ".repeat(100 << 20)).as_bytes());
    assert!(bomb.len() < 1 << 20, "{} bytes", bomb.len());
    let recursive = "<Scene><ProtoDeclare name='P'><ProtoBody><Group><ProtoInstance name='P'/></Group></ProtoBody></ProtoDeclare>\
        <ProtoInstance name='P'/></Scene>";
    let deep = format!("<Scene>{}{}</Scene>", "<Group>".repeat(3000), "</Group>".repeat(3000));
    for (what, bytes, code) in [
        ("a bomb", bomb, "EQUOTA"),
        ("2^40 nodes", doubling(40).into_bytes(), "EQUOTA"),
        ("compressed", gzip(doubling(40).as_bytes()), "EQUOTA"),
        ("a prototype in itself", recursive.as_bytes().to_vec(), "EFORMAT"),
        ("deep nesting", deep.into_bytes(), "ETOOBIG"),
        ("half a gzip file", gzip(doubling(3).as_bytes())[..60].to_vec(), "EFORMAT"),
    ] {
        let said =
            String::from_utf8(serving.talk(&[&b"ERRORS report\n"[..], &scene(&bytes), b"SYNC z\n"].concat()))
                .unwrap();
        assert!(said.contains(&format!("{code} SCENE")) && said.ends_with("SYNC z\n"), "{what}: {said}");
        assert_eq!(serving.connect().ask("SIZE\n"), "SIZE 40 30\n", "{what}");
    }
}

#[test]
fn prototypes_of_files_come_from_the_folder_of_the_server_alone() {
    let folder = Folder::new("extern-protos");
    let ball = "<Scene><ProtoDeclare name='P'><ProtoBody><Shape><Box size='9 9 9'/></Shape></ProtoBody></ProtoDeclare></Scene>";
    std::fs::create_dir(folder.join("inside")).unwrap();
    std::fs::write(folder.join("inside/p.x3d"), ball).unwrap();
    std::fs::write(folder.join("p.x3d"), ball).unwrap();
    let mut engine = Engine::new(40, 30).unwrap();
    engine.set_load_dir(SandboxDir::open(&folder.join("inside")).unwrap());
    let serving = Serving::with(engine);
    let outside = folder.join("p.x3d");
    for (url, is_shown) in
        [("p.x3d", true), ("p.x3d#P", true), ("../p.x3d", false), (outside.to_str().unwrap(), false)]
    {
        let text =
            format!("<Scene><ExternProtoDeclare name='E' url='{url}'/><ProtoInstance name='E'/></Scene>");
        let mut wire = serving.connect();
        wire.send(&scene(text.as_bytes()));
        let mut pixel = wire.ask("CLEAR\nDRAWSCENE\nPX 20 15\n");
        if !is_shown {
            assert!(pixel.contains("DRAWSCENE: nothing is drawn"), "{url}: {pixel}");
            pixel = wire.line();
        }
        assert_eq!(pixel != "PX 20 15 000000\n", is_shown, "{url}: {pixel}");
    }
}
