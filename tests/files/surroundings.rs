//! Parts of a file beside its nodes: compression, units, references outside its folder, stray text.

use crate::support::{close, parse, warnings};
use fbptr::cancel::CancelToken;
use fbptr::error::Code;
use fbptr::load::x3d::{self, X3dDocument};
use fbptr::load::{LoadContext, LoadErrorKind, LoadMemory};
use fbptr::memory::{MemoryBudget, MemoryUse};
use fbptr::scene::Projection;
use flate2::Compression;
use flate2::write::GzEncoder;
use glam::DVec3;
use std::io::Write;

fn gzip(text: &str) -> Vec<u8> {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::default());
    encoder.write_all(text.as_bytes()).unwrap();
    encoder.finish().unwrap()
}

const BOX: &str = "<Shape><Box/></Shape>";

#[test]
fn compressed_files_are_known_by_their_first_bytes() {
    let main = gzip(
        "<X3D><Scene><Inline url='inner.x3dz'/><ExternProtoDeclare name='P' url='p.x3d#P'/><ProtoInstance name='P'/></Scene></X3D>",
    );
    let inner = gzip(&format!("<Scene>{BOX}</Scene>"));
    let proto =
        gzip(&format!("<Scene><ProtoDeclare name='P'><ProtoBody>{BOX}</ProtoBody></ProtoDeclare></Scene>"));
    let document = x3d::parse(&main, "t.x3d", &mut |name| match name {
        "inner.x3dz" => Some(inner.clone()),
        "p.x3d" => Some(proto.clone()),
        _ => None,
    })
    .unwrap();
    assert_eq!((document.at(0.0).objects.len(), warnings(&document).len()), (2, 0));
    let error = x3d::parse(&main[..main.len() / 2], "t.x3d", &mut |_| None).unwrap_err();
    assert_eq!(error.code(), Code::Format);
    assert!(error.to_string().starts_with("t.x3d: not a readable gzip file: "), "{error}");
}

#[test]
fn bytes_after_the_end_of_gzip_data_are_skipped_with_a_warning() {
    let mut main = gzip(&format!("<Scene><Inline url='inner.x3dz'/>{BOX}</Scene>"));
    let inner = [gzip(&format!("<Scene>{BOX}</Scene>")), b"\0\0signature".to_vec()].concat();
    main.extend(b"\ntrailing");
    let parsed = |main: &[u8]| x3d::parse(main, "t.x3dz", &mut |_| Some(inner.clone()));
    let document = parsed(&main).unwrap();
    assert_eq!(document.at(0.0).objects.len(), 2);
    let expected = [
        "t.x3dz: warning: bytes after the end of the gzip data were skipped: 9",
        "inner.x3dz: warning: bytes after the end of the gzip data were skipped: 9",
    ];
    assert_eq!(warnings(&document), expected);
    // What is cut off stays an error.
    for length in [20, main.len() - 10] {
        let error = parsed(&main[..length]).unwrap_err().to_string();
        assert!(error.starts_with("t.x3dz: not a readable gzip file: "), "{length} bytes: {error}");
    }
}

#[test]
fn inflated_bytes_are_asked_for_before_they_exist() {
    let bomb = gzip(&format!("<Scene><!--{}--></Scene>", " ".repeat(4 << 20)));
    assert!(bomb.len() < 20_000, "{}", bomb.len());
    let budget = MemoryBudget::new(3 << 20);
    let mut memory = LoadMemory::new(&budget, u64::MAX);
    let error = x3d::parse_within(&bomb, "t.x3dz", &mut |_| None, &mut memory).unwrap_err();
    assert_eq!(error.code(), Code::Quota);
    // The buffer doubles step by step, and exists twice while it moves: at 1 MiB the next step
    // would exceed 3.
    let LoadErrorKind::OverBudget(over) = error.kind else { panic!("{error}") };
    assert_eq!((over.needed, over.used), (1 << 20, (2 << 20) + (64 << 10)));
    assert_eq!(over.purpose, MemoryUse::Decoders);
    // The text itself needs tables, which are reserved before it is parsed.
    let budget = MemoryBudget::new(20 << 20);
    let mut memory = LoadMemory::new(&budget, u64::MAX);
    let error = x3d::parse_within(&bomb, "t.x3dz", &mut |_| None, &mut memory).unwrap_err();
    let LoadErrorKind::OverBudget(over) = error.kind else { panic!("{error}") };
    assert!(over.needed > 7 * (4 << 20), "{over}");
    assert!(x3d::parse(&bomb, "t.x3dz", &mut |_| None).is_ok());
}

#[test]
fn units_of_angle_and_length_are_applied() {
    let units = "<head><unit category='angle' name='degree' conversionFactor='0.017453292519943295'/>\
                 <unit category='length' name='foot' conversionFactor='0.3048'/><unit category='mass' conversionFactor='2'/></head>";
    let text = format!(
        "<X3D>{units}<Scene><Viewpoint fieldOfView='60' orientation='0 1 0 90'/><Transform rotation='0 0 1 90'><Shape>\
         <PointSet><Coordinate point='1 0 0'/></PointSet></Shape></Transform><Inline url='metres.x3d'/></Scene></X3D>"
    );
    let metres = "<X3D><Scene><Transform translation='3.048 0 0'><Shape><Box/></Shape></Transform><Inline url='inches.x3d'/></Scene></X3D>";
    let inches = "<X3D><head><unit category='length' conversionFactor='0.0254'/></head><Scene><Transform translation='12 0 0' \
                  rotation='0 0 1 1.5707963267948966'><Shape><Box/></Shape></Transform></Scene></X3D>";
    let document = x3d::parse(text.as_bytes(), "t.x3d", &mut |name| match name {
        "metres.x3d" => Some(metres.into()),
        "inches.x3d" => Some(inches.into()),
        _ => None,
    })
    .unwrap();
    assert_eq!(warnings(&document), [""; 0]);
    let scene = document.at(0.0);
    let camera = scene.camera.unwrap();
    assert!(matches!(camera.projection, Projection::Perspective { fov_rad, .. }
        if (fov_rad - std::f64::consts::FRAC_PI_3).abs() < 1e-12));
    // World units are the main file's, feet; the viewpoint's default position is not scaled.
    close(camera.look_at.eye, DVec3::Z * 10.0);
    close((camera.look_at.reference - camera.look_at.eye).normalize(), DVec3::NEG_X);
    close(scene.objects[0].model.transform_point3(DVec3::X), DVec3::Y);
    close(scene.objects[1].model.w_axis.truncate(), DVec3::X * 10.0);
    close(scene.objects[2].model.w_axis.truncate(), DVec3::X);
    // Angles in radians, and lengths of an inch.
    close(scene.objects[2].model.transform_vector3(DVec3::X), DVec3::Y / 12.0);
    let wrong =
        parse("<X3D>\n<head><unit category='length' conversionFactor='-1'/></head><Scene/></X3D>").unwrap();
    assert_eq!(
        warnings(&wrong),
        ["t.x3d:2:7: warning: <unit> conversionFactor \"-1\" is no number above 0: 1 is taken"]
    );
}

#[test]
fn prototypes_bring_the_units_of_their_file() {
    let lib = "<X3D><head><unit category='length' conversionFactor='10'/><unit category='angle' conversionFactor='2'/></head><Scene>\
               <ProtoDeclare name='P'><ProtoInterface><field name='turn' type='SFRotation' accessType='inputOutput' \
               value='0 0 1 0.7853981633974483'/></ProtoInterface><ProtoBody><Transform translation='1 0 0'><IS>\
               <connect nodeField='rotation' protoField='turn'/></IS><Shape><Box/></Shape></Transform></ProtoBody></ProtoDeclare></Scene></X3D>";
    let text = "<Scene><ExternProtoDeclare name='P' url='l.x3d'/><ProtoInstance name='P'/><ProtoInstance name='P'>\
                <fieldValue name='turn' value='0 0 1 0.7853981633974483'/></ProtoInstance></Scene>";
    let scene =
        x3d::parse(text.as_bytes(), "t.x3d", &mut |n| (n == "l.x3d").then(|| lib.into())).unwrap().at(0.0);
    close(scene.objects[0].model.w_axis.truncate(), DVec3::X * 10.0);
    // The default is in units of two radians, the instance's own value in radians.
    close(scene.objects[0].model.transform_vector3(DVec3::X), DVec3::Y * 10.0);
    close(scene.objects[1].model.transform_vector3(DVec3::X), DVec3::new(50f64.sqrt(), 50f64.sqrt(), 0.0));
}

/// Parses a scene in a folder of the root; returns the document and the names of the files that it
/// asked for.
fn inside(folder: &str, text: &str, files: &[&str]) -> (X3dDocument, Vec<String>) {
    let mut asked = Vec::new();
    let context = LoadContext {
        folder,
        opener: &mut |name| {
            asked.push(name.to_string());
            files.contains(&name).then(|| format!("<Scene>{BOX}</Scene>").into())
        },
        memory: &mut LoadMemory::unlimited(),
    };
    let document = x3d::parse_in(text.as_bytes(), "here/t.x3d", context).unwrap();
    (document, asked)
}

#[test]
fn names_may_climb_to_the_root_and_no_further() {
    let text =
        "<Scene>\n<Inline url='../b.x3d'/><Inline url='\"../../c.x3d\"'/><Inline url='d.x3d'/></Scene>";
    let (document, asked) = inside("a/", text, &["b.x3d", "a/d.x3d"]);
    assert_eq!((asked, document.at(0.0).objects.len()), (vec!["b.x3d".into(), "a/d.x3d".to_string()], 2));
    let expected = "here/t.x3d:2:25: warning: Inline [\"../../c.x3d\"] lies outside of the folder that files are read from and was skipped";
    assert_eq!(warnings(&document), [expected]);
    assert!(document.names_outside());
    let texture =
        "<Scene>\n<Shape><Appearance><ImageTexture url='../wood.png'/></Appearance><Box/></Shape></Scene>";
    let (document, asked) = inside("", texture, &[]);
    assert_eq!(asked, [""; 0]);
    let expected = "here/t.x3d:2:20: warning: texture left out: \"../wood.png\" lies outside of the folder that files are read from";
    assert_eq!(warnings(&document), [expected]);
    assert!(document.names_outside() && document.at(0.0).objects.len() == 1);
    // An Inline of the scene itself by another path is a cycle.
    let text = "<Scene><Inline url='../a/t.x3d'/></Scene>";
    let context = LoadContext { folder: "a/", opener: &mut |_| None, memory: &mut LoadMemory::unlimited() };
    let error = x3d::parse_in(text.as_bytes(), "t.x3d", context).unwrap_err();
    assert!(error.to_string().contains("a cycle"), "{error}");
    // A broken file in a parent folder is named by its path from the scene.
    let mut broken = |_: &str| Some(b"<Scene>".to_vec());
    let context = LoadContext { folder: "a/", opener: &mut broken, memory: &mut LoadMemory::unlimited() };
    let document = x3d::parse_in(b"<Scene><Inline url='../b.x3d'/></Scene>", "a/t.x3d", context).unwrap();
    let found = warnings(&document);
    assert!(found.len() == 1 && found[0].contains("was skipped: a/../b.x3d:1:1: "), "{found:?}");
}

#[test]
fn stray_text_is_a_warning_at_its_first_word() {
    let text = "<X3D>\n<Scene>\nhello there\n<Shape>\n  IndexedFaceSet>\n<Box/></Shape>&amp;<Group/></Scene>\nx</X3D>";
    let document = parse(text).unwrap();
    let expected = [
        "3:1: warning: text in <Scene> was skipped: \"hello there\"",
        "5:3: warning: text in <Shape> was skipped: \"IndexedFaceSet>\"",
        "6:15: warning: text in <Scene> was skipped: \"&\"",
        "7:1: warning: text in <X3D> was skipped: \"x\"",
    ];
    assert_eq!(warnings(&document), expected.map(|e| format!("t.x3d:{e}")));
    assert_eq!(document.at(0.0).objects.len(), 1);
}

#[test]
fn stray_text_in_the_head_and_in_prototypes_is_a_warning_too() {
    let text = "<X3D><head>a<meta name='n' content='c'>b</meta></head><Scene>\n\
        <ProtoDeclare name='P'>c<ProtoInterface>d\n\
        <field accessType='inputOutput' type='SFColor' name='f' value='1 0 0'>e</field></ProtoInterface>\n\
        <ProtoBody>f<Shape><Appearance><Material><IS>g<connect nodeField='diffuseColor' protoField='f'>h\n\
        </connect></IS></Material></Appearance><Box/></Shape></ProtoBody></ProtoDeclare>\n\
        <ProtoInstance name='P'>i<fieldValue name='f' value='0 1 0'>j</fieldValue><IS>k</IS></ProtoInstance>\n\
        </Scene></X3D>";
    let document = parse(text).unwrap();
    let skipped: Vec<String> =
        warnings(&document).iter().map(|w| w.rsplit(' ').next().unwrap_or("").to_owned()).collect();
    let mut sorted = skipped.clone();
    sorted.sort();
    let letters: Vec<String> = ('a'..='k').map(|c| format!("\"{c}\"")).collect();
    assert_eq!(sorted, letters, "{:?}", warnings(&document));
    assert_eq!(document.at(0.0).objects.len(), 1);
}

const QUAD: &str = "coordIndex='0 1 2 -1 0 2 3 -1'";
const COORDINATES: &str = "<Coordinate point='0 0 0 1 0 0 1 1 0 0 1 0'/>";
const COLORS: &str = "<Color color='1 0 0 0 1 0 0 0 1 1 1 1'/>";

/// Parses a shape, and checks its number of faces (none if it is left out) and its warning.
fn check_shape(shape: &str, faces: Option<usize>, warning: Option<&str>) {
    let text = format!("<Scene>\n <Shape>{shape}</Shape>\n<Shape><Box/></Shape></Scene>");
    let document = parse(&text).unwrap_or_else(|e| panic!("{e}: {shape}"));
    let found: Vec<String> =
        warnings(&document).into_iter().filter(|w| !w.contains("GeoCoordinate")).collect();
    let expected: Vec<String> = warning.iter().map(|w| format!("t.x3d:2:{w}")).collect();
    assert_eq!(found, expected, "{shape}");
    let scene = document.at(0.0);
    assert_eq!(scene.objects.len(), 1 + usize::from(faces.is_some()), "{shape}");
    if let Some(faces) = faces {
        assert_eq!(scene.objects[0].geometry.mesh.polygons.len(), faces, "{shape}");
    }
}

#[test]
fn what_a_geometry_lacks_is_a_warning_and_the_rest_is_drawn() {
    let image = "<Appearance><PixelTexture image='1 1 1 9'/></Appearance>";
    let st = "<TextureCoordinate point='0 0 1 0 1 1 0 1'/>";
    for (shape, faces, warning) in [
        (
            format!("<IndexedFaceSet {QUAD}><GeoCoordinate point='1 2 3'/></IndexedFaceSet>"),
            None,
            Some("9: warning: <IndexedFaceSet> was left out: the node of its coordinates is not known"),
        ),
        (
            format!(
                "<IndexedFaceSet {QUAD}><CoordinateDouble point='0 0 0 1 0 0 1 1 0 0 1 0'/></IndexedFaceSet>"
            ),
            Some(2),
            None,
        ),
        (
            format!(
                "<IndexedFaceSet {QUAD} texCoordIndex='0 1 2 -1 0 2'>{COORDINATES}{st}</IndexedFaceSet>{image}"
            ),
            Some(2),
            Some(
                "9: warning: texCoordIndex does not have the runs of coordIndex (1 differ): what it lacks is put in",
            ),
        ),
        (
            format!(
                "<IndexedFaceSet {QUAD} texCoordIndex='0 1 2 3 -1 0 2 3 -1 1 -1'>{COORDINATES}{st}</IndexedFaceSet>{image}"
            ),
            Some(2),
            Some(
                "9: warning: texCoordIndex does not have the runs of coordIndex (2 differ): what it lacks is put in",
            ),
        ),
        (
            format!("<IndexedFaceSet {QUAD} colorIndex='0 1 -1'>{COORDINATES}{COLORS}</IndexedFaceSet>"),
            Some(2),
            Some(
                "9: warning: colorIndex does not have the runs of coordIndex (2 differ): what it lacks is put in",
            ),
        ),
        (
            format!(
                "<IndexedFaceSet {QUAD} colorPerVertex='false' colorIndex='3'>{COORDINATES}{COLORS}</IndexedFaceSet>"
            ),
            Some(2),
            Some("9: warning: colorIndex has 1 indices for 2 faces: the first colour is put in"),
        ),
        (
            "<ElevationGrid xDimension='9' zDimension='9'/>".into(),
            None,
            Some("9: warning: <ElevationGrid> was left out: it has none of its 9 x 9 heights"),
        ),
        (
            "<ElevationGrid xDimension='3' zDimension='3' height='0 0 0 0 1 0 0 0'/>".into(),
            Some(4),
            Some("9: warning: <ElevationGrid> lacks 1 of its 3 x 3 heights: 0 is taken"),
        ),
    ] {
        check_shape(&shape, faces, warning);
    }
}

#[test]
fn heights_that_a_grid_lacks_are_zero_and_charged() {
    let grid = |n: u32| {
        let text =
            format!("<Scene><Shape><ElevationGrid xDimension='{n}' zDimension='{n}' height='5 6'/></Shape>");
        text + "</Scene>"
    };
    let scene = parse(&grid(3)).unwrap().at(0.0);
    let heights: Vec<f64> = scene.objects[0].geometry.mesh.positions.iter().map(|p| p.y).collect();
    assert_eq!(heights, [5.0, 6.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
    // A million faces from a hundred bytes are charged before they exist.
    let budget = MemoryBudget::new(100 << 20);
    let mut memory = LoadMemory::new(&budget, u64::MAX);
    let text = grid(1024);
    let error = x3d::parse_within(text.as_bytes(), "t.x3d", &mut |_| None, &mut memory).unwrap_err();
    let LoadErrorKind::OverBudget(over) = error.kind else { panic!("{error}") };
    assert!(over.needed > 500 << 20 && over.used < 1 << 20, "{over}");
    // More are refused as a list that is too short.
    let error = parse(&grid(1026)).unwrap_err().to_string();
    assert!(error.contains("expected 1026 x 1026 = 1052676 heights"), "{error}");
}

#[test]
fn colour_indices_that_are_missing_are_put_in() {
    // The coordinate's own index is inserted.
    let text = format!(
        "<Scene><Shape><IndexedFaceSet {QUAD} colorIndex='0 0 0 -1 1'>{COORDINATES}{COLORS}</IndexedFaceSet></Shape></Scene>"
    );
    let scene = parse(&text).unwrap().at(0.0);
    let indices: Vec<u32> = scene.objects[0].geometry.mesh.corners.iter().map(|c| c.color).collect();
    assert_eq!(indices, [0, 0, 0, 1, 2, 3]);
    let lines = format!(
        "<Scene>\n<Shape><IndexedLineSet coordIndex='0 1 2' colorIndex='3'>{COORDINATES}{COLORS}</IndexedLineSet></Shape></Scene>"
    );
    let document = parse(&lines).unwrap();
    let expected =
        "t.x3d:2:8: warning: colorIndex does not have the runs of coordIndex: 2 indices are put in";
    assert_eq!(warnings(&document), [expected]);
    let indices: Vec<u32> =
        document.at(0.0).objects[0].geometry.mesh.corners.iter().map(|c| c.color).collect();
    assert_eq!(indices, [3, 1, 2]);
}

#[test]
fn a_node_in_a_field_of_another_kind_is_no_such_node() {
    // A material as a geometry must not crash the program.
    for nodes in [
        "<Shape><Material containerField='geometry'/></Shape>",
        "<Shape><Appearance><Box containerField='material'/></Appearance><Box/></Shape>",
        "<Shape><Box/><Group containerField='appearance'/></Shape>",
    ] {
        let document = parse(&format!("<Scene>{nodes}</Scene>")).unwrap();
        assert_eq!(warnings(&document).len(), 1, "{nodes}: {:?}", document.warnings());
        document.at(0.0);
    }
}

#[test]
fn a_scene_that_is_cancelled_is_read_no_further() {
    let picture = "<Shape><Appearance><ImageTexture url='\"p.png\"'/></Appearance><Box/></Shape>";
    let many = picture.repeat(100).replace("p.png", "%.png");
    let text = (0..100).fold(many, |text, i| text.replacen('%', &format!("p{i}"), 1));
    let text = format!("<X3D><Scene>{text}</Scene></X3D>");
    let token = CancelToken::new();
    let mut asked_for = Vec::new();
    let mut opener = |name: &str| {
        asked_for.push(name.to_owned());
        if asked_for.len() == 3 {
            token.cancel();
        }
        None
    };
    let mut memory = LoadMemory::unlimited().until(token.clone());
    let error = x3d::parse_within(text.as_bytes(), "t.x3d", &mut opener, &mut memory).unwrap_err();
    assert_eq!((error.kind, asked_for.len()), (LoadErrorKind::Cancelled, 3));
}
