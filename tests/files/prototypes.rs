//! Prototypes: the objects of an instance and what it shares, names and routes that reach into it,
//! and limits.

use crate::support::{check, parse, scene, warnings};
use fbptr::error::Code;
use fbptr::load::x3d::{self, X3dDocument};
use fbptr::load::{LoadErrorKind, LoadMemory};
use fbptr::memory::MemoryBudget;
use fbptr::scene::Scene;
use glam::DVec3;
use std::sync::Arc;

/// A prototype of a coloured ball at a position.
const BALL: &str = "<ProtoDeclare name='Ball'><ProtoInterface>\
    <field name='at' type='SFVec3f' accessType='inputOutput' value='1 2 3'/>\
    <field name='color' type='SFColor' accessType='initializeOnly' value='1 0 0'/>\
    <field name='radius' type='SFFloat' accessType='initializeOnly'/></ProtoInterface>\
    <ProtoBody><Transform DEF='T'><IS><connect nodeField='translation' protoField='at'/></IS>\
    <Shape><Appearance><Material><IS><connect nodeField='diffuseColor' protoField='color'/></IS></Material></Appearance>\
    <Sphere><IS><connect nodeField='radius' protoField='radius'/></IS></Sphere></Shape></Transform>\
    <Shape><Box/></Shape></ProtoBody></ProtoDeclare>";

fn places(scene: &Scene) -> Vec<DVec3> {
    scene.objects.iter().map(|o| o.model.w_axis.truncate()).collect()
}

/// Parses a text with an opener that serves these files by name.
fn with(text: &str, files: &[(&str, &str)]) -> Result<X3dDocument, fbptr::load::LoadError> {
    x3d::parse(text.as_bytes(), "t.x3d", &mut |name| {
        files.iter().find(|(n, _)| *n == name).map(|(_, text)| text.as_bytes().to_vec())
    })
}

#[test]
fn an_instance_has_its_defaults_and_what_it_is_given() {
    let s = scene(&format!(
        "{BALL}<ProtoInstance name='Ball'/><ProtoInstance name='Ball' DEF='Blue'><fieldValue name='color' value='0 0 1'/>\
         <fieldValue name='at' value='0 5 0'/><fieldValue name='radius' value='3'/></ProtoInstance>"
    ));
    // The box is the second node of the body: reachable by routes, and not drawn.
    assert_eq!(places(&s), [DVec3::new(1.0, 2.0, 3.0), DVec3::new(0.0, 5.0, 0.0)]);
    assert_eq!(s.objects.iter().map(|o| o.material.kd).collect::<Vec<_>>(), [DVec3::X, DVec3::Z]);
    // Without a value of the field the sphere has its own radius.
    let sizes: Vec<f64> = s.objects.iter().map(|o| o.model.x_axis.x).collect();
    assert_eq!(sizes, [1.0, 3.0]);
    assert_eq!(s.objects[1].name, "Blue");
}

#[test]
fn prototypes_hold_instances_of_others_and_pass_fields_on() {
    let s = scene(&format!(
        "{BALL}<ProtoDeclare name='Two'><ProtoInterface><field name='left' type='SFVec3f' accessType='inputOutput' value='-1 0 0'/>\
         </ProtoInterface><ProtoBody><Group><ProtoDeclare name='Ball'><ProtoBody><Shape><Cone/></Shape></ProtoBody></ProtoDeclare>\
         <ProtoInstance name='Ball'/></Group></ProtoBody></ProtoDeclare>\
         <ProtoDeclare name='Pair'><ProtoInterface><field name='first' type='SFVec3f' accessType='inputOutput' value='-1 0 0'/>\
         <field name='paint' type='SFColor' accessType='inputOutput' value='0 1 0'/></ProtoInterface>\
         <ProtoBody><Group><ProtoInstance name='Ball'><IS><connect nodeField='at' protoField='first'/>\
         <connect nodeField='color' protoField='paint'/></IS></ProtoInstance><ProtoInstance name='Ball'/></Group></ProtoBody></ProtoDeclare>\
         <ProtoInstance name='Pair'><fieldValue name='first' value='7 0 0'/></ProtoInstance><ProtoInstance name='Two'/>"
    ));
    // A prototype in a body shadows the outer one of the same name, in that body alone.
    assert_eq!(places(&s), [DVec3::X * 7.0, DVec3::new(1.0, 2.0, 3.0), DVec3::ZERO]);
    assert_eq!([s.objects[0].material.kd, s.objects[1].material.kd], [DVec3::Y, DVec3::X]);
}

#[test]
fn fields_of_nodes_take_the_nodes_or_their_default() {
    let s = scene(
        "<ProtoDeclare name='Frame'><ProtoInterface><field name='look' type='SFNode' accessType='initializeOnly'>\
         <Material diffuseColor='0 1 0'/></field><field name='kids' type='MFNode' accessType='inputOutput'/></ProtoInterface>\
         <ProtoBody><Group><IS><connect nodeField='children' protoField='kids'/></IS><Shape><Appearance><IS>\
         <connect nodeField='material' protoField='look'/></IS></Appearance><Box/></Shape></Group></ProtoBody></ProtoDeclare>\
         <ProtoInstance name='Frame'/><ProtoInstance name='Frame'><fieldValue name='look'><Material diffuseColor='0 0 1'/></fieldValue>\
         <fieldValue name='kids'><Shape><Sphere/></Shape><Transform translation='4 0 0'><Shape><Cone/></Shape></Transform></fieldValue>\
         </ProtoInstance>",
    );
    let colors: Vec<DVec3> = s.objects.iter().map(|o| o.material.kd).collect();
    assert_eq!((colors[0], colors[1]), (DVec3::Y, DVec3::Z));
    assert_eq!(places(&s)[2..], [DVec3::ZERO, DVec3::X * 4.0]);
}

#[test]
fn an_instance_stands_where_its_first_node_can() {
    let s = scene(
        "<ProtoDeclare name='Red'><ProtoBody><Material diffuseColor='1 0 0'/></ProtoBody></ProtoDeclare>\
         <ProtoDeclare name='Look'><ProtoBody><Appearance><ProtoInstance name='Red' containerField='material'/></Appearance></ProtoBody>\
         </ProtoDeclare><Shape><ProtoInstance name='Look'/><Box/></Shape>\
         <Shape><Appearance><ProtoInstance name='Red'/></Appearance><Box/></Shape>",
    );
    assert!(s.objects.iter().all(|o| o.material.kd == DVec3::X));
    let wrong = parse(
        "<Scene><ProtoDeclare name='Red'><ProtoBody><Material/></ProtoBody></ProtoDeclare>\n<ProtoInstance name='Red'/></Scene>",
    );
    let message =
        "t.x3d:2:1: warning: <ProtoInstance> is a <Material>, which cannot stand in <Scene>, and was skipped";
    assert_eq!(warnings(&wrong.unwrap()), [message]);
}

#[test]
fn names_of_a_body_are_its_own_in_every_instance() {
    let body = "<ProtoDeclare name='P'><ProtoBody><Group><Shape DEF='S'><Box/></Shape><Transform translation='1 0 0'>\
                <Shape USE='S'/></Transform></Group></ProtoBody></ProtoDeclare>";
    let s = scene(&format!(
        "{body}<Shape DEF='S'><Cone/></Shape><ProtoInstance name='P' DEF='A'/><ProtoInstance name='P'/><Shape USE='S'/>\
         <Transform translation='0 9 0'><ProtoInstance USE='A'/></Transform>"
    ));
    let at = |x: f64, y: f64| DVec3::new(x, y, 0.0);
    let expected =
        [at(0., 0.), at(0., 0.), at(1., 0.), at(0., 0.), at(1., 0.), at(0., 0.), at(0., 9.), at(1., 9.)];
    assert_eq!(places(&s), expected);
    assert!(Arc::ptr_eq(&s.objects[0].geometry, &s.objects[5].geometry), "the scene's own S");
    let outside =
        parse(&format!("<Scene>{body}<ProtoInstance name='P'/>\n<Shape USE='S'/></Scene>")).unwrap();
    assert_eq!(warnings(&outside), ["t.x3d:2:1: warning: USE \"S\" has no DEF, and was skipped"]);
}

#[test]
fn routes_reach_through_an_instance_and_move_it_alone() {
    let clock = "<TimeSensor DEF='C' cycleInterval='2' loop='true'/><PositionInterpolator DEF='I' key='0 1' keyValue='0 0 0 8 0 0'/>\
                 <ROUTE fromNode='C' fromField='fraction_changed' toNode='I' toField='set_fraction'/>";
    let outside = format!(
        "<Scene>{BALL}<ProtoInstance name='Ball' DEF='A'/><ProtoInstance name='Ball' DEF='B'/>{clock}\
         <ROUTE fromNode='I' fromField='value_changed' toNode='B' toField='set_at'/></Scene>"
    );
    let document = parse(&outside).unwrap();
    assert_eq!(warnings(&document), [""; 0]);
    assert!(document.is_animated());
    assert_eq!(places(&document.at(0.5)), [DVec3::new(1.0, 2.0, 3.0), DVec3::X * 2.0]);
    // An animated body: each instance has its own sensor, with its own interval.
    let inside = "<Scene><ProtoDeclare name='M'><ProtoInterface><field name='time' type='SFTime' accessType='initializeOnly' value='4'/>\
        <field name='out' type='SFVec3f' accessType='outputOnly'/></ProtoInterface><ProtoBody><Transform DEF='T'><Shape><Box/></Shape></Transform>\
        <TimeSensor DEF='C' loop='true'><IS><connect nodeField='cycleInterval' protoField='time'/></IS></TimeSensor>\
        <PositionInterpolator DEF='I' key='0 1' keyValue='0 0 0 8 0 0'><IS><connect nodeField='value_changed' protoField='out'/></IS>\
        </PositionInterpolator><ROUTE fromNode='C' fromField='fraction_changed' toNode='I' toField='set_fraction'/>\
        <ROUTE fromNode='I' fromField='value_changed' toNode='T' toField='translation'/></ProtoBody></ProtoDeclare>\
        <ProtoInstance name='M'/><ProtoInstance name='M' DEF='Fast'><fieldValue name='time' value='2'/></ProtoInstance>\
        <Transform DEF='Follower'><Shape><Box/></Shape></Transform>\
        <ROUTE fromNode='Fast' fromField='out' toNode='Follower' toField='translation'/></Scene>";
    let document = parse(inside).unwrap();
    assert_eq!(warnings(&document), [""; 0]);
    assert_eq!(places(&document.at(1.0)), [DVec3::X * 2.0, DVec3::X * 4.0, DVec3::X * 4.0]);
    let missing = outside.replace("set_at", "set_size");
    let found = warnings(&parse(&missing).unwrap());
    assert!(
        found[0].contains("ROUTE names \"set_size\", which the prototype of \"B\" does not have"),
        "{found:?}"
    );
}

#[test]
fn a_prototype_in_itself_is_refused() {
    for (text, expected) in [
        (
            "<ProtoDeclare name='P'><ProtoBody><Group><ProtoInstance name='P'/></Group></ProtoBody></ProtoDeclare>\n<ProtoInstance name='P'/>",
            "t.x3d:1:",
        ),
        (
            "<ProtoDeclare name='A'><ProtoBody><Group><ProtoDeclare name='B'><ProtoBody><Group><ProtoInstance name='A'/></Group></ProtoBody>\
             </ProtoDeclare><ProtoInstance name='B'/></Group></ProtoBody></ProtoDeclare><ProtoInstance name='A'/>",
            "t.x3d:1:",
        ),
    ] {
        let error = parse(&format!("<Scene>{text}</Scene>")).unwrap_err().to_string();
        assert!(error.starts_with(expected) && error.contains("prototypes are not recursive"), "{error}");
    }
    // A prototype that is never used gives no warning.
    let unused = "<Scene><ProtoDeclare name='P'><ProtoBody><Group><ProtoInstance name='P'/></Group></ProtoBody></ProtoDeclare></Scene>";
    assert_eq!(warnings(&parse(unused).unwrap()), [""; 0]);
}

#[test]
fn extern_prototypes_come_from_files_beside_the_scene() {
    let file = "<X3D><Scene><ProtoDeclare name='One'><ProtoBody><Shape><Box/></Shape></ProtoBody></ProtoDeclare>\
        <ProtoDeclare name='Two'><ProtoInterface><field name='at' type='SFVec3f' accessType='inputOutput' value='0 2 0'/></ProtoInterface>\
        <ProtoBody><Transform><IS><connect nodeField='translation' protoField='at'/></IS><ProtoInstance name='One'/>\
        <Inline url='in.x3d'/></Transform></ProtoBody></ProtoDeclare><Shape><Sphere/></Shape></Scene></X3D>";
    let files = [
        ("lib/p.x3d", file),
        ("lib/in.x3d", "<Scene><Shape><Cone/></Shape></Scene>"),
        ("old.wrl", "#VRML V1.0 ascii\nGroup {}"),
        ("relay.x3d", "<Scene><ExternProtoDeclare name='Two' url='\"lib/p.x3d#Two\"'/></Scene>"),
        ("circle.x3d", "<Scene><ExternProtoDeclare name='C' url='circle.x3d#C'/></Scene>"),
    ];
    let text = |url: &str| {
        format!(
            "<Scene>\n<ExternProtoDeclare name='P' url='{url}'><field name='at' type='SFVec3f' accessType='inputOutput'/></ExternProtoDeclare>\
             <ProtoInstance name='P'/><ProtoInstance name='P'/></Scene>"
        )
    };
    let shown = |url: &str| {
        let document = with(&text(url), &files).unwrap();
        let scene = document.at(0.0);
        check(&scene);
        (places(&scene), warnings(&document))
    };
    let up = DVec3::Y * 2.0;
    for url in [
        "lib/p.x3d#Two",
        "\"http://x/y.x3d#Two\" \"old.wrl#Two\" \"lib/p.x3d#Two\"",
        "relay.x3d#Two",
        "relay.x3d",
    ] {
        assert_eq!(shown(url), (vec![up; 4], Vec::new()), "{url}");
    }
    // Without a fragment, the first prototype of the file is used.
    assert_eq!(shown("lib/p.x3d").0, [DVec3::ZERO; 2]);
    for (url, reason) in [
        ("lib/p.x3d#Three", "\"lib/p.x3d#Three\" has no such prototype"),
        ("gone.x3d#P", "\"gone.x3d#P\" cannot be found in the scene&apos;s folder"),
        ("../p.x3d#P", "\"../p.x3d#P\" lies outside of the folder that files are read from"),
        (
            "old.wrl#P",
            "\"old.wrl#P\" cannot be used: old.wrl: not a readable X3D file: it is VRML 1.0, whose nodes X3D does not have",
        ),
        ("", "has no url"),
    ] {
        let (objects, found) = shown(url);
        let reason = reason.replace("&apos;", "'");
        let expected = format!(
            "t.x3d:2:1: warning: ExternProtoDeclare \"P\" cannot be had ({reason}): its instances were skipped"
        );
        assert_eq!((objects.len(), found), (0, vec![expected]));
    }
    let (objects, found) = shown("circle.x3d#C");
    assert_eq!(objects.len(), 0);
    assert!(
        found[0].contains("circle.x3d:1:8: warning: ExternProtoDeclare \"C\" leads back to itself"),
        "{found:?}"
    );
}

#[test]
fn a_url_belongs_to_the_folder_of_the_file_that_gives_it() {
    let shape = |name: &str| format!("<Scene><Shape><{name}/></Shape></Scene>");
    let proto = "<Scene><ProtoDeclare name='P'><ProtoInterface>\
        <field name='file' type='MFString' accessType='inputOutput' value='\"part.x3d\"'/></ProtoInterface>\
        <ProtoBody><Inline><IS><connect nodeField='url' protoField='file'/></IS></Inline></ProtoBody></ProtoDeclare></Scene>";
    // An instance in a prototype of the same file passes its value on.
    let pass = "<Scene><ExternProtoDeclare name='P' url='../lib/p.x3d#P'/><ProtoDeclare name='Q'><ProtoInterface>\
        <field name='outer' type='MFString' accessType='inputOutput' value='\"part.x3d\"'/></ProtoInterface><ProtoBody>\
        <ProtoInstance name='P'><IS><connect nodeField='file' protoField='outer'/></IS></ProtoInstance>\
        </ProtoBody></ProtoDeclare></Scene>";
    let [cone, box_, sphere] = ["Cone", "Box", "Sphere"].map(shape);
    let files = [
        ("lib/p.x3d", proto),
        ("more/pass.x3d", pass),
        ("lib/part.x3d", &cone),
        ("more/part.x3d", &box_),
        ("part.x3d", &sphere),
    ];
    let faces = |proto: &str, value: &str| {
        let text = format!(
            "<Scene><ExternProtoDeclare name='I' url='{proto}'/><ProtoInstance name='I'>{value}</ProtoInstance></Scene>"
        );
        let document = with(&text, &files).unwrap();
        (document.at(0.0).objects.first().map(|o| o.geometry.mesh.corners.len()), warnings(&document))
    };
    let of = |text: &str| {
        scene(&text.replace("<Scene>", "").replace("</Scene>", "")).objects[0].geometry.mesh.corners.len()
    };
    let [cone, box_, sphere] = [&cone, &box_, &sphere].map(|text| Some(of(text)));
    assert!(cone != box_ && box_ != sphere && cone != sphere);
    let mine = |value: &str, field: &str| format!("<fieldValue name='{field}' value='\"{value}\"'/>");
    for (proto, value, expected) in [
        ("lib/p.x3d#P", String::new(), cone),
        ("lib/p.x3d#P", mine("part.x3d", "file"), sphere),
        ("lib/p.x3d#P", mine("more/part.x3d", "file"), box_),
        ("more/pass.x3d#Q", String::new(), box_),
        ("more/pass.x3d#Q", mine("./part.x3d", "outer"), sphere),
        ("more/pass.x3d#Q", mine("lib/part.x3d", "outer"), cone),
    ] {
        assert_eq!(faces(proto, &value), (expected, Vec::new()), "{proto} {value}");
    }
    let (none, found) = faces("lib/p.x3d#P", &mine("../part.x3d", "file"));
    assert!(none.is_none() && found[0].contains("lies outside of"), "{found:?}");
}

#[test]
fn what_is_wrong_with_fields_is_said_once_at_its_place() {
    let text = "<Scene><ProtoDeclare name='P'><ProtoInterface>\n<field name='m' type='SFMatrix3f' accessType='inputOutput' value='1'/>\
        <field name='n' type='SFInt32' accessType='inputOutput' value='4'/></ProtoInterface><ProtoBody><Group>\n\
        <Shape><Sphere><IS><connect nodeField='radius' protoField='n'/><connect nodeField='what' protoField='n'/>\
        <connect nodeField='solid' protoField='gone'/></IS></Sphere></Shape><Foo/></Group></ProtoBody></ProtoDeclare>\n\
        <ProtoInstance name='P'/><ProtoInstance name='P'><fieldValue name='z' value='1'/></ProtoInstance>\n\
        <ProtoInstance name='Q'/><Group><IS><connect nodeField='x' protoField='y'/></IS></Group></Scene>";
    let document = parse(text).unwrap();
    let expected = [
        "2:1: warning: field \"m\" has a type, \"SFMatrix3f\", that is not known",
        "3:20: warning: <Sphere> radius takes one number, and IS gives it one whole number",
        "3:64: warning: <Sphere> has no field \"what\"",
        "3:106: warning: IS names \"gone\", which the prototype does not have",
        "3:174: warning: node <Foo> is not known and was skipped, here and wherever it comes again",
        "4:50: warning: prototype \"P\" has no field \"z\"",
        "5:1: warning: no prototype \"Q\" is declared before this instance, which was skipped",
        "5:37: warning: IS stands outside of a ProtoBody and was skipped",
    ];
    assert_eq!(warnings(&document), expected.map(|e| format!("t.x3d:{e}")));
    assert_eq!(document.at(0.0).objects.len(), 2);
    for (field, value, column) in [("SFVec3f", "1 2", 64), ("SFFloat", "nan", 64), ("SFBool", "maybe", 63)] {
        let text = format!(
            "<Scene><ProtoDeclare name='P'><ProtoInterface>\n<field name='f' type='{field}' accessType='inputOutput' value='{value}'/>\
             </ProtoInterface><ProtoBody><Group/></ProtoBody></ProtoDeclare><ProtoInstance name='P'/></Scene>"
        );
        let error = parse(&text).unwrap_err().to_string();
        assert!(error.starts_with(&format!("t.x3d:2:{column}: field \"f\" takes")), "{error}");
    }
}

#[test]
fn what_every_instance_has_alike_is_made_once() {
    let points: String = (0..4000).map(|i| format!("{i} 0 0 {i} 1 0 {i} 0 1 ")).collect();
    let text = format!(
        "<Scene><ProtoDeclare name='P'><ProtoInterface><field name='at' type='SFVec3f' accessType='inputOutput' value='0 0 0'/></ProtoInterface>\
         <ProtoBody><Transform><IS><connect nodeField='translation' protoField='at'/></IS><Shape><TriangleSet>\
         <Coordinate point='{points}'/></TriangleSet></Shape></Transform></ProtoBody></ProtoDeclare>{}</Scene>",
        "<ProtoInstance name='P'/>".repeat(5000)
    );
    let mut memory = LoadMemory::unlimited();
    let document = x3d::parse_within(text.as_bytes(), "t.x3d", &mut |_| None, &mut memory).unwrap();
    let scene = document.at(0.0);
    assert_eq!(scene.objects.len(), 5000);
    assert!(scene.objects.iter().all(|o| Arc::ptr_eq(&o.geometry, &scene.objects[0].geometry)));
    let kept = memory.kept_bytes();
    assert!((1 << 20..32 << 20).contains(&kept), "{kept} bytes");
}

#[test]
fn expansion_is_charged_before_it_exists_and_bounded() {
    // Each prototype contains two instances of the one before: 2^40 nodes.
    let mut text =
        String::from("<Scene><ProtoDeclare name='P0'><ProtoBody><Group DEF='G'/></ProtoBody></ProtoDeclare>");
    for i in 1..40 {
        text += &format!(
            "<ProtoDeclare name='P{i}'><ProtoBody><Group><ProtoInstance name='P{0}'/><ProtoInstance name='P{0}'/></Group></ProtoBody></ProtoDeclare>",
            i - 1
        );
    }
    text += "<ProtoInstance name='P39'/></Scene>";
    let error = parse(&text).unwrap_err();
    assert_eq!(error.code(), Code::TooBig, "{error}");
    assert!(error.to_string().contains("nodes, fields and connections that prototypes make"), "{error}");
    let budget = MemoryBudget::new(4_000_000);
    let mut memory = LoadMemory::new(&budget, u64::MAX);
    let error = x3d::parse_within(text.as_bytes(), "t.x3d", &mut |_| None, &mut memory).unwrap_err();
    assert_eq!(error.code(), Code::Quota, "{error}");
    let LoadErrorKind::OverBudget(over) = error.kind else { panic!("{error}") };
    assert!(over.used > 3_900_000 && over.needed < 100_000, "{over}");
    // A chain within the limit of depth, and one beyond it.
    for (count, is_read) in [(100, true), (300, false)] {
        let mut text =
            String::from("<Scene><ProtoDeclare name='P0'><ProtoBody><Group/></ProtoBody></ProtoDeclare>");
        for i in 1..count {
            text += &format!(
                "<ProtoDeclare name='P{i}'><ProtoBody><Group><ProtoInstance name='P{}'/></Group></ProtoBody></ProtoDeclare>",
                i - 1
            );
        }
        text += &format!("<ProtoInstance name='P{}'/></Scene>", count - 1);
        let read = std::thread::Builder::new().stack_size(2 << 20).spawn(move || parse(&text).is_ok());
        assert_eq!(read.unwrap().join().expect("it ends"), is_read, "{count}");
    }
}
