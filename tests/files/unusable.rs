//! Files of Inline and ExternProtoDeclare that cannot be used: the next URL is taken, or a warning
//! gives the reason, and nothing of them is left in the scene.

use crate::support::{check, warnings};
use fbptr::error::Code;
use fbptr::load::x3d::{self, X3dDocument};
use fbptr::load::{LoadContext, LoadError, LoadMemory};
use fbptr::memory::MemoryBudget;
use std::collections::HashMap;

const BOX: &str = "<Shape><Box/></Shape>";

/// A scene of one box.
const GOOD: (&str, &[u8]) = ("good.x3d", b"<Scene><Shape DEF='Good'><Box/></Shape></Scene>");

/// Parses a text with these files; counts how often each is asked for.
fn read(text: &str, files: &[(&str, &[u8])]) -> (Result<X3dDocument, LoadError>, HashMap<String, usize>) {
    let mut asked = HashMap::new();
    let document = x3d::parse(text.as_bytes(), "t.x3d", &mut |name| {
        *asked.entry(name.to_string()).or_default() += 1;
        files.iter().find(|(n, _)| *n == name).map(|(_, bytes)| bytes.to_vec())
    });
    (document, asked)
}

/// Parses a text with these files; checks the number of objects, and returns the warnings.
fn shown(text: &str, files: &[(&str, &[u8])], objects: usize) -> Vec<String> {
    let document = read(text, files).0.unwrap_or_else(|e| panic!("{e}: {text}"));
    let scene = document.at(0.0);
    check(&scene);
    assert_eq!(scene.objects.len(), objects, "{text}");
    warnings(&document)
}

#[test]
fn an_inline_that_cannot_be_used_is_a_warning_with_its_reason() {
    for (bytes, reason) in [
        (&b""[..], "bad:1:1: expected an element <X3D>, found \"the end of the file\""),
        (b"<Scene>\n<Foo></Scene>", "bad:2:6: expected </Foo> first"),
        (b"<html/>", "bad:1:1: expected an X3D file, whose root is <X3D>"),
        (b"<Scene>\n\xff</Scene>", "bad:2:1: not a readable X3D file: the bytes are not text"),
        (b"#VRML V1.0 ascii\nGroup {}", "bad: not a readable X3D file: it is VRML 1.0"),
        (b"#X3D V3.3 utf8\nGroup {", "bad:2:8: expected a field or }, which closes the Group"),
        (b"glTF\x02\0\0\0", "bad: not a readable X3D file: it is a binary glTF model"),
        (b"{\"asset\":{}}", "bad: not a readable X3D file: it is JSON"),
        (b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR", "bad: not a readable X3D file: it is binary data"),
        (b"\x1f\x8b\x08", "bad: not a readable gzip file: "),
        (b"<Scene>\n<Transform scale='1 nan 2'/></Scene>", "bad:2:21: scale must be a finite number"),
        (
            b"<Scene>\n<Group DEF='a'><Group USE='a'/></Group></Scene>",
            "bad:2:23: expected USE to name a node",
        ),
        (
            b"<Scene>\n<PositionInterpolator key='0 1' keyValue='0 0 0'/></Scene>",
            "bad:2:43: expected 3 numbers in keyValue",
        ),
    ] {
        let text = format!("<Scene>{BOX}\n<Inline url='bad'/>{BOX}</Scene>");
        let found = shown(&text, &[("bad", bytes)], 2);
        let expected =
            format!("t.x3d:2:1: warning: Inline [\"bad\"] cannot be used and was skipped: {reason}");
        assert!(found.len() == 1 && found[0].starts_with(&expected), "{found:#?}\n{expected}");
    }
}

#[test]
fn the_first_url_that_can_be_used_is_taken() {
    let files = [
        GOOD,
        ("a.wrl", &b"#VRML V1.0 ascii"[..]),
        ("b.x3d", b"<Scene>\n<Shape><Box size='no'/></Shape></Scene>"),
    ];
    let inline = |urls: &str| format!("<Scene>\n<Inline url='{urls}'/></Scene>");
    for urls in ["\"a.wrl\" \"b.x3d\" \"gone.x3d\" \"good.x3d\"", "\"good.x3d\" \"a.wrl\""] {
        assert_eq!(shown(&inline(urls), &files, 1), [""; 0], "{urls}");
    }
    // Each reason is told, but not those of files that do not exist.
    let found = shown(&inline("\"a.wrl\" \"gone.x3d\" \"b.x3d\""), &files, 0);
    let reasons = "a.wrl: not a readable X3D file: it is VRML 1.0, whose nodes X3D does not have; b.x3d:2:";
    assert!(found.len() == 1 && found[0].contains(&format!("was skipped: {reasons}")), "{found:?}");
    let proto = |urls: &str| {
        format!("<Scene>\n<ExternProtoDeclare name='P' url='{urls}'/><ProtoInstance name='P'/></Scene>")
    };
    let with_proto =
        format!("<Scene><ProtoDeclare name='P'><ProtoBody>{BOX}</ProtoBody></ProtoDeclare></Scene>");
    let files =
        [("p.x3d", with_proto.as_bytes()), ("a.wrl", b"#VRML V1.0 ascii"), ("b.x3d", b"<Scene>\n<Foo>")];
    assert_eq!(shown(&proto("\"a.wrl#P\" \"b.x3d#P\" \"p.x3d#P\""), &files, 1), [""; 0]);
    let found = shown(&proto("\"a.wrl#P\" \"b.x3d#P\""), &files, 0);
    let expected = "t.x3d:2:1: warning: ExternProtoDeclare \"P\" cannot be had (\"a.wrl#P\" cannot be used: a.wrl: not a \
                    readable X3D file: it is VRML 1.0, whose nodes X3D does not have; \"b.x3d#P\" cannot be used: b.x3d:2:1: expected <Foo> to be \
                    closed by </Foo>, found \"the end of the file\"): its instances were skipped";
    assert_eq!(found, [expected]);
}

#[test]
fn a_file_that_cannot_be_used_is_read_once_and_told_wherever_it_is_named() {
    let bad = ("bad.x3d", &b"<Scene><Foo></Scene>"[..]);
    let text = "<Scene>\n<Inline url='bad.x3d'/>\n<Inline url='\"bad.x3d\"'/>\n<Inline url='\"./bad.x3d\" \"good.x3d\"'/></Scene>";
    let (document, asked) = read(text, &[bad, GOOD]);
    let document = document.unwrap();
    assert_eq!((asked["bad.x3d"], asked["good.x3d"], document.at(0.0).objects.len()), (1, 1, 1));
    let lines: Vec<u32> = document.warnings().iter().map(|w| w.place.line).collect();
    assert_eq!(lines, [2, 3]);
    let text = "<Scene>\n<ExternProtoDeclare name='P' url='bad.x3d#P'/>\n<ExternProtoDeclare name='Q' url='bad.x3d#Q'/>\
                <ProtoInstance name='P'/><ProtoInstance name='P'/><ProtoInstance name='Q'/></Scene>";
    let (document, asked) = read(text, &[bad]);
    let document = document.unwrap();
    assert_eq!(asked["bad.x3d"], 1);
    let lines: Vec<u32> = document.warnings().iter().map(|w| w.place.line).collect();
    assert_eq!(lines, [2, 3]);
}

#[test]
fn nothing_of_an_unusable_file_is_left() {
    // It has inlined a file, given names, routes, textures and a sky, and made meshes, before its
    // error. The nodes after it get the indices of its own.
    let texture = "<PixelTexture image='1 1 1 9'/>";
    let bad = format!(
        "<Scene><Inline url='good.x3d'/><Background backUrl='sky.png'/><Shape DEF='S'><Appearance>{texture}</Appearance>\
         <PointSet><Coordinate point='1 0 0'/></PointSet></Shape><Shape><Appearance>{texture}<TextureTransform \
         translation='1 1'/></Appearance><Sphere/></Shape><TimeSensor DEF='C' loop='true'/>\
         <PositionInterpolator DEF='P' key='0 1' keyValue='0 0 0 1 1 1'/><Transform DEF='T'/>\
         <ROUTE fromNode='C' fromField='fraction_changed' toNode='P' toField='set_fraction'/>\
         <ROUTE fromNode='P' fromField='value_changed' toNode='T' toField='translation'/>\
         <Shape><ElevationGrid xDimension='1026' zDimension='1025' height='0'/></Shape></Scene>"
    );
    let png = std::fs::read(crate::support::data().join("x3d-cpp/checker.png")).unwrap();
    let files = [GOOD, ("bad.x3d", bad.as_bytes()), ("sky.png", &png)];
    let after = "<Group><Shape><PointSet><Coordinate point='2 0 0'/></PointSet></Shape></Group>\
                 <Shape><Appearance><Material/></Appearance><Sphere/></Shape><Inline url='good.x3d'/><Background/>";
    let text = format!("<Scene>\n<Inline url='bad.x3d'/>{after}</Scene>");
    let document = read(&text, &files).0.unwrap();
    let found = warnings(&document);
    let expected = "t.x3d:2:1: warning: Inline [\"bad.x3d\"] cannot be used and was skipped: bad.x3d:1:";
    assert!(found.len() == 1 && found[0].starts_with(expected), "{found:#?}");
    assert!(!document.is_animated() && !document.depends_on_viewer());
    let alone = read(&format!("<Scene>\n{after}</Scene>"), &files).0.unwrap();
    assert_eq!(document.scene_bytes(), alone.scene_bytes());
    let (scene, alone) = (document.at(0.0), alone.at(0.0));
    check(&scene);
    let facts = |scene: &fbptr::scene::Scene| {
        let of = |o: &fbptr::scene::Object| {
            (o.name.clone(), o.model, o.geometry.mesh.positions.clone(), o.texture.is_some())
        };
        (scene.objects.iter().map(of).collect::<Vec<_>>(), scene.background.color)
    };
    assert_eq!(facts(&scene), facts(&alone));
    assert_eq!(scene.objects.len(), 3);
    assert!(scene.sky == alone.sky);
}

#[test]
fn an_error_in_an_extern_prototype_skips_its_instances() {
    let lib = |field: &str, body: &str| {
        format!(
            "<Scene><ProtoDeclare name='P'><ProtoInterface>\n<field name='size' type='SFVec3f' \
             accessType='initializeOnly' value='{field}'/></ProtoInterface><ProtoBody><Group DEF='G'>\n{body}</Group>\
             </ProtoBody></ProtoDeclare></Scene>"
        )
    };
    let text = format!(
        "<Scene>\n<ExternProtoDeclare name='P' url='p.x3d'/><ProtoInstance name='P' DEF='A'/>{BOX}\
         <Transform><ProtoInstance name='P'/></Transform><ProtoInstance USE='A'/>\
         <ROUTE fromNode='A' fromField='size' toNode='A' toField='size'/></Scene>"
    );
    let bad = "<Shape><ElevationGrid xDimension='1026' zDimension='1025' height='0'/></Shape>";
    for (file, reason) in [
        (lib("1 2", BOX), "p.x3d:2:70: field \"size\" takes 3 numbers, found \"2 numbers\""),
        (lib("1 2 3", &format!("{BOX}<Box size='x'/><Shape><Box size='x'/></Shape>")), "p.x3d:3:"),
        (lib("1 2 3", &format!("{BOX}{bad}")), "p.x3d:3:"),
    ] {
        let found = shown(&text, &[("p.x3d", file.as_bytes())], 1);
        let expected = format!("t.x3d:2:1: warning: ExternProtoDeclare \"P\" cannot be used ({reason}");
        let told: Vec<&String> = found.iter().filter(|w| w.starts_with("t.x3d")).collect();
        assert!(told.len() == 1 && told[0].starts_with(&expected), "{found:#?}");
        assert!(told[0].ends_with("): its instances were skipped"), "{found:#?}");
    }
    // The same errors in the scene's own file, or in what it gives to an instance, stay errors.
    let own = format!(
        "<Scene><ProtoDeclare name='P'><ProtoBody>{bad}</ProtoBody></ProtoDeclare><ProtoInstance name='P'/></Scene>"
    );
    assert_eq!(read(&own, &[]).0.unwrap_err().code(), Code::Format);
    let taker = "<Scene><ProtoDeclare name='P'><ProtoInterface><field name='g' type='SFNode' accessType='initializeOnly'/>\
                 </ProtoInterface><ProtoBody><Shape><IS><connect nodeField='geometry' protoField='g'/></IS></Shape></ProtoBody>\
                 </ProtoDeclare></Scene>";
    let given = bad.replace("<Shape>", "<fieldValue name='g'>\n").replace("</Shape>", "</fieldValue>");
    let text = format!(
        "<Scene><ExternProtoDeclare name='P' url='p.x3d'/><ProtoInstance name='P'>{given}</ProtoInstance></Scene>"
    );
    let error = read(&text, &[("p.x3d", taker.as_bytes())]).0.unwrap_err().to_string();
    assert!(error.starts_with("t.x3d:2:"), "{error}");
}

#[test]
fn limits_and_cycles_remain_errors_of_the_scene() {
    let inline = |name: &str| format!("<Scene>{BOX}<Inline url='{name} \"good.x3d\"'/></Scene>");
    let deep = format!("<Scene>{}{}</Scene>", "<Group>".repeat(300), "</Group>".repeat(300));
    let (a, b) =
        ("<Scene><Inline url='b.x3d'/></Scene>", "<Scene><Inline url='\"a.x3d\" \"good.x3d\"'/></Scene>");
    let me = "<Scene><ProtoDeclare name='P'><ProtoBody><Group><ProtoInstance name='P'/></Group></ProtoBody></ProtoDeclare>\
              <ProtoInstance name='P'/></Scene>";
    let files = [
        GOOD,
        ("deep.x3d", deep.as_bytes()),
        ("a.x3d", a.as_bytes()),
        ("b.x3d", b.as_bytes()),
        ("me.x3d", me.as_bytes()),
    ];
    for (name, code, expected) in [
        ("\"deep.x3d\"", Code::TooBig, "deep.x3d:1:"),
        ("\"a.x3d\"", Code::Format, "b.x3d:1:"),
        ("\"me.x3d\"", Code::Format, "me.x3d:1:"),
    ] {
        let error = read(&inline(name), &files).0.unwrap_err();
        assert_eq!(error.code(), code, "{error}");
        assert!(error.to_string().starts_with(expected), "{error}");
    }
    let budget = MemoryBudget::new(1 << 20);
    let long = format!("<Scene>{}</Scene>", BOX.repeat(50_000));
    let context = LoadContext {
        folder: "",
        opener: &mut |_| Some(long.clone().into()),
        memory: &mut LoadMemory::new(&budget, u64::MAX),
    };
    let error = x3d::parse_in(inline("\"a.x3d\"").as_bytes(), "t.x3d", context).unwrap_err();
    assert_eq!(error.code(), Code::Quota, "{error}");
}
