//! Broken, hostile and odd files: refused with their position, read with a warning, or read; never
//! a panic, never an endless loop.

use crate::support::{check, data, draw, parse, warnings};
use fbptr::load::x3d;
use proptest::prelude::*;
use std::time::{Duration, Instant};

/// Returns the text of a refusal; panics if the file is read.
fn refusal(text: &str) -> String {
    match parse(text) {
        Ok(_) => panic!("was read:\n{text}"),
        Err(error) => error.to_string(),
    }
}

#[test]
fn xml_that_is_not_well_formed_is_refused_at_line_and_column() {
    for (text, expected) in [
        ("", "t.x3d:1:1: expected an element <X3D>, found \"the end of the file\""),
        ("  \n <!-- a -->", "t.x3d:2:12: "),
        ("hello", "t.x3d:1:1: "),
        ("<X3D>\n <Scene>\n", "t.x3d:2:2: expected <Scene> to be closed by </Scene>"),
        (
            "<X3D>\n<Scene>\n</X3D>",
            "t.x3d:3:1: expected </Scene> first, which closes <Scene> of line 2, found \"</X3D>\"",
        ),
        ("<X3D></X3D></X3D>", "t.x3d:1:12: expected no closing tag where nothing is open"),
        ("<Scene><Box size=\"1 1 1/></Scene>", "t.x3d:1:"),
        ("<Scene>\n<Box size=1/></Scene>", "t.x3d:2:11: "),
        (
            "<Scene>\n<Box size='1 1 1' size='2 2 2'/></Scene>",
            "t.x3d:2:19: expected the attribute \"size\" once",
        ),
        ("<Scene>\n &nbsp; </Scene>", "t.x3d:2:2: expected an entity that is declared, not \"nbsp\""),
        ("<Scene>\n a & b </Scene>", "t.x3d:2:4: "),
        ("<Scene><!-- a -- b --></Scene>", "t.x3d:1:"),
        ("<Scene><!-- a", "t.x3d:1:8: expected a comment to end with -->"),
        ("<Scene><![CDATA[ a", "t.x3d:1:8: expected a CDATA section"),
        ("<!DOCTYPE X3D [", "t.x3d:1:1: expected the document type declaration to end"),
        ("<a:Scene/>", "t.x3d:1:"),
        ("<Scene/><Scene/>", "t.x3d:1:"),
        ("<Scene>\u{1}</Scene>", "t.x3d:1:8: "),
        ("<Sc<ene/>", "t.x3d:1:"),
    ] {
        let found = refusal(text);
        assert!(found.starts_with(expected), "{text:?}: {found}");
    }
}

#[test]
fn what_is_no_x3d_is_refused_in_plain_words() {
    for (text, expected) in [
        ("<html><body/></html>", "t.x3d:1:1: expected an X3D file, whose root is <X3D>, found \"<html>"),
        ("<X3D>\n</X3D>", "t.x3d:1:1: expected a <Scene> inside <X3D>"),
    ] {
        let found = refusal(text);
        assert!(found.starts_with(expected), "{text:?}: {found}");
    }
    assert!(parse("<Scene/>").is_ok(), "a bare Scene is accepted");
    assert!(parse("\u{feff}<?xml version='1.0'?>\n<!DOCTYPE X3D PUBLIC 'a' 'b' [<!ENTITY w 'white'>]>\n<X3D><Scene/></X3D>").is_ok());
}

/// Checks how the refusal of each scene begins.
fn check_refusals(refusals: &[(&str, &str)]) {
    for (nodes, expected) in refusals {
        let found = refusal(&format!("<X3D><Scene>\n{nodes}</Scene></X3D>"));
        assert!(found.starts_with(&format!("t.x3d:{expected}")), "{nodes}: {found}");
    }
}

#[test]
fn numbers_keys_and_uses_are_refused_at_their_byte() {
    check_refusals(&[
        ("<Transform translation='0 nan 0'/>", "2:27: translation must be a finite number, found \"nan\""),
        ("<Transform translation='0 0 inf'/>", "2:29: translation must be a finite number"),
        (
            "<Transform\n translation='0\n 0 1e400'/>",
            "4:4: translation must be a finite number, found \"1e400\"",
        ),
        ("<Shape><Box solid='maybe'/></Shape>", "2:20: <Box> solid takes true or false, found \"maybe\""),
        ("<Switch whichChoice='1.5'/>", "2:22: <Switch> whichChoice takes one whole number, found \"1.5\""),
        ("<Inline url='\"a'/>", "2:14: <Inline> url takes quoted strings, found \"a quote"),
        (
            "<PositionInterpolator key='0 1' keyValue='0 0 0'/>",
            "2:43: expected 3 numbers in keyValue for each of the 2 keys",
        ),
        (
            "<ScalarInterpolator key='0 1 0.5' keyValue='0 0 0'/>",
            "2:26: each key must be at least the one before it",
        ),
        (
            "<Group DEF='g'><Switch><Group USE='g'/></Switch></Group>",
            "2:31: expected USE to name a node that is complete",
        ),
    ]);
}

#[test]
fn counts_and_indices_are_refused_at_their_byte() {
    check_refusals(&[
        (
            "<Shape><IndexedFaceSet coordIndex='0 1 3 -1'><Coordinate point='0 0 0 1 0 0 0 1 0'/></IndexedFaceSet></Shape>",
            "2:36: coordinate index 3 names none of the 3 there are",
        ),
        (
            "<Shape><IndexedFaceSet coordIndex='0 1 -2'><Coordinate point='0 0 0 1 0 0 0 1 0'/></IndexedFaceSet></Shape>",
            "2:36: coordinate index -2 names none of the 3 there are",
        ),
        (
            "<Shape><IndexedFaceSet coordIndex='0 1 2'/></Shape>",
            "2:36: coordinate index 0 names none of the 0",
        ),
        (
            "<Shape><IndexedFaceSet coordIndex='0 1 2'><Coordinate point='0 0 0 1 0 0 0 1 0'/>\n<Color color='1 1 1'/></IndexedFaceSet></Shape>",
            "3:15: colour index 1 names none of the 1 there are",
        ),
        (
            "<Shape><IndexedFaceSet coordIndex='0 1 2' normalIndex='0 0'><Coordinate point='0 0 0 1 0 0 0 1 0'/><Normal vector='0 0 \
             1'/></IndexedFaceSet></Shape>",
            "2:56: expected normalIndex to have runs like coordIndex",
        ),
        (
            "<Shape><IndexedLineSet coordIndex='0 7'><Coordinate point='0 0 0'/></IndexedLineSet></Shape>",
            "2:36: coordinate index 7",
        ),
        (
            "<Shape><LineSet vertexCount='1'><Coordinate point='0 0 0'/></LineSet></Shape>",
            "2:30: expected counts of 2",
        ),
        ("<Shape><TriangleFanSet fanCount='2'/></Shape>", "2:34: expected counts of 3 or more in fanCount"),
        ("<Shape><TriangleStripSet stripCount='-9'/></Shape>", "2:38: expected counts of 3 or more"),
        (
            "<Shape><ElevationGrid xDimension='1026' zDimension='1025' height='0'/></Shape>",
            "2:67: expected 1026 x 1025 = 1051650 heights",
        ),
        (
            "<Shape><ElevationGrid xDimension='2147483647' zDimension='2147483647' height='0'/></Shape>",
            "2:79: expected 2147483647 x 2147483647 = 4611686014132420609 heights",
        ),
        (
            "<Shape><Appearance><PixelTexture image='2 2 1 0'/></Appearance></Shape>",
            "2:34: expected 2 x 2 = 4 pixels, not 1",
        ),
    ]);
}

#[test]
fn what_others_tolerate_is_left_out_with_one_warning() {
    let faces = |indices: &str| {
        format!(
            "<Shape><IndexedFaceSet coordIndex='{indices}'><Coordinate point='0 0 0 1 0 0 0 1 0'/></IndexedFaceSet>\
             </Shape>"
        )
    };
    for (nodes, objects, expected) in [
        (
            format!("{}\n{}", faces("0 1 2 -1 0 1 3 -1 0 -7 1"), faces("0 1 2 -1 9 1 0")),
            2,
            "2:36: warning: coordinate index 3 names none of the 3 there are: the face or line is left out, 3 \
             times in all",
        ),
        (
            "<Shape><LineSet vertexCount='3'><Coordinate point='0 0 0 1 1 1'/></LineSet></Shape>".into(),
            1,
            "2:30: warning: expected vertexCount to count no more than the 2 coordinates, found \"3\": the face",
        ),
        (
            "<Shape><TriangleFanSet fanCount='2 3'><Coordinate point='0 0 0 1 1 1 0 0 0 1 0 0 0 1 0'/>\
             </TriangleFanSet></Shape>"
                .into(),
            1,
            "2:34: warning: expected counts of 3 or more in fanCount",
        ),
        (
            "<Shape><IndexedFaceSet coordIndex='0 1 2'><Coordinate point='0 0 0 1 0 0 0 1 0 5 5'/></IndexedFaceSet>\
             </Shape>"
                .into(),
            1,
            "2:62: warning: <Coordinate> point takes numbers in groups of 3, found \"11 numbers\": what is left over \
             is left out",
        ),
        (
            "<Transform translation='0 0'><Shape><Box/></Shape></Transform>".into(),
            1,
            "2:25: warning: <Transform> translation takes 3 numbers, found \"2 numbers\": its default is taken",
        ),
        (
            "<Shape><Box size='1 1 1 1'/></Shape>".into(),
            1,
            "2:19: warning: <Box> size takes 3 numbers, found \"4 numbers\": what is left over is left out",
        ),
        ("<Shape><Sphere radius=''/></Shape>".into(), 1, "2:24: warning: <Sphere> radius takes one number"),
        (
            "<Shape><Appearance USE='a'/><Box/></Shape>\n<Shape><Appearance DEF='a'><Material/></Appearance><Cone/></Shape>"
                .into(),
            2,
            "2:8: warning: USE \"a\" stands before its DEF in line 3, which is used",
        ),
        (
            "<Group USE='b'/><Transform translation='1 0 0'><Group DEF='b'><Shape><Box/></Shape></Group></Transform>"
                .into(),
            2,
            "2:1: warning: USE \"b\" stands before its DEF in line 2, which is used",
        ),
        (
            "<OrientationInterpolator keyValue='0 1 0 0 0 1 0 3'/><Shape><Box/></Shape>".into(),
            1,
            "2:1: warning: <OrientationInterpolator> has no keys and sends nothing",
        ),
        ("<Group USE='no'/><Shape><Box/></Shape>".into(), 1, "2:1: warning: USE \"no\" has no DEF, and was skipped"),
    ] {
        let document = parse(&format!("<X3D><Scene>\n{nodes}</Scene></X3D>")).unwrap_or_else(|e| panic!("{e}"));
        let found = warnings(&document);
        assert_eq!((document.at(0.0).objects.len(), found.len()), (objects, 1), "{nodes}: {found:#?}");
        assert!(found[0].starts_with(&format!("t.x3d:{expected}")), "{nodes}: {found:#?}");
        check(&document.at(0.0));
    }
}

#[test]
fn what_is_not_known_is_skipped_with_one_warning_that_names_it_and_its_line() {
    let text = "<X3D><Scene>\n<Sound><AudioClip loop='what'/>text</Sound>\n<Shape><Box colour='red'/></Shape>\n<Box/>\n\
        <Shape><Appearance><lmageTexture url='chess.png'/></Appearance><Sphere/></Shape>\n<Group DEF='a'/><Group DEF='a'/>\n\
        <Shape USE='a'/>\n<Script><![CDATA[ecmascript: if (a < b) {}]]></Script>\n<ProtoDeclare><ProtoBody><Group DEF='q'/>\
        </ProtoBody></ProtoDeclare>\n<Shape><Box/><Cone/></Shape>\n<Background skyColor='1 0 0 0 1 0' skyAngel='1'/>\n\
        <Shape><Appearance><Material><PixelTexture containerField='normalTexture'/></Material></Appearance><Sphere/></Shape></Scene></X3D>";
    let document = parse(text).unwrap();
    let expected = [
        "2:1: warning: node <Sound> is not known and was skipped, here and wherever it comes again",
        "3:8: warning: <Box> has no field \"colour\"",
        "4:1: warning: <Box> cannot stand in <Scene> and was skipped",
        "5:20: warning: node <lmageTexture> is not known and was skipped, here and wherever it comes again",
        "6:17: warning: DEF \"a\" is given twice; USE takes the last one before it",
        "8:1: warning: <Script> is left out, here and wherever it comes again: scripts are not run",
        "9:1: warning: <ProtoDeclare> without a name was skipped",
        "10:14: warning: <Shape> takes one geometry: this <Cone> was skipped",
        "11:1: warning: <Background> has no field \"skyAngel\"",
        "12:20: warning: <Material> is drawn without its normalTexture",
    ];
    let found = warnings(&document);
    assert_eq!(found.len(), expected.len(), "{found:#?}");
    for (found, expected) in found.iter().zip(expected) {
        assert_eq!(found, &format!("t.x3d:{expected}"));
    }
    assert_eq!(document.at(0.0).objects.len(), 4);
    let many = format!("<Scene>{}</Scene>", "<Box/>".repeat(5000));
    assert_eq!(warnings(&parse(&many).unwrap()).len(), 1001);
    // A type is told once in a file.
    let same = format!("<Scene>{}{}</Scene>", "<Foo/>".repeat(5000), "<Bar><Group/></Bar>".repeat(5000));
    assert_eq!(warnings(&parse(&same).unwrap()).len(), 2);
}

/// Parses a text that must end soon, on a stack as small as a worker thread's.
fn soon(what: &str, text: String) {
    let (what, started) = (what.to_string(), Instant::now());
    let run = std::thread::Builder::new().stack_size(2 << 20).spawn(move || match parse(&text) {
        Ok(document) => check(&document.at(1.0)),
        Err(error) => assert!(error.to_string().len() < 2000),
    });
    run.unwrap().join().unwrap_or_else(|_| panic!("{what}"));
    assert!(started.elapsed() < Duration::from_secs(20), "{what} took {:?}", started.elapsed());
}

#[test]
fn hostile_files_end_soon() {
    let scene = |nodes: String| format!("<X3D><Scene>{nodes}</Scene></X3D>");
    soon("deep nesting", scene(format!("{}{}", "<Group>".repeat(100_000), "</Group>".repeat(100_000))));
    soon(
        "the deepest nesting that is read",
        scene(format!("{}<Shape><Box/></Shape>{}", "<Group>".repeat(250), "</Group>".repeat(250))),
    );
    soon(
        "deep nesting of what is not known",
        scene(format!("{}{}", "<Foo>".repeat(250), "</Foo>".repeat(250))),
    );
    let chain: String =
        (1..5000).map(|i| format!("<Group DEF='g{i}'><Group USE='g{}'/></Group>", i - 1)).collect();
    soon("a chain of USE", scene(format!("<Group DEF='g0'/>{chain}")));
    let forward: String =
        (0..5000).map(|i| format!("<Group DEF='f{i}'><Group USE='f{}'/></Group>", i + 1)).collect();
    soon("a chain of USE before DEF", scene(forward));
    soon("many USE without DEF", scene(format!("{}{chain}", "<Group USE='no'/>".repeat(50_000))));
    let doubled: String = (1..60)
        .map(|i| format!("<Group DEF='g{i}'><Group USE='g{0}'/><Group USE='g{0}'/></Group>", i - 1))
        .collect();
    soon("doubling by USE", scene(format!("<Group DEF='g0'><Shape><Box/></Shape></Group>{doubled}")));
    soon("doubling of nothing", scene(format!("<Group DEF='g0'/>{doubled}")));
    let laughs: String =
        (1..10).map(|i| format!("<!ENTITY l{i} '{}'>", format!("&l{};", i - 1).repeat(10))).collect();
    soon(
        "a billion laughs",
        format!("<!DOCTYPE X3D [<!ENTITY l0 'lol'>{laughs}]><X3D><Scene a='&l9;'/></X3D>"),
    );
    let long = "x".repeat(1 << 20);
    soon(
        "a long entity, often",
        format!("<!DOCTYPE X3D [<!ENTITY a '{long}'>]><X3D><Scene b='{}'/></X3D>", "&a;".repeat(9999)),
    );
    let attributes: String = (0..100_000).map(|i| format!(" a{i}='0'")).collect();
    soon("many attributes", format!("<X3D><Scene{attributes}/></X3D>"));
    let namespaces: String = (0..20_000).map(|i| format!(" xmlns:a{i}='u{i}'")).collect();
    soon("many namespaces", format!("<X3D{namespaces}><Scene/></X3D>"));
    soon("one long line of nodes", scene("<Foo/>".repeat(100_000)));
    soon("one long line of shapes", scene("<Shape><Sphere/></Shape>".repeat(20_000)));
    let points = "0 0 0 ".repeat(3000);
    let section = "0 0 1 0 ".repeat(2000);
    soon(
        "a huge extrusion",
        scene(format!("<Shape><Extrusion spine='{points}' crossSection='{section}'/></Shape>")),
    );
    soon("a long text", scene(format!("<Shape><Text string='\"{}\"'/></Shape>", "W".repeat(1 << 20))));
    let fan: String = (0..100_000).map(|i| format!("0 {} {} -1 ", i % 50 + 1, i % 49 + 2)).collect();
    let rim: String = (0..60).map(|i| format!("{i} {} {} ", i * i % 7, i % 5)).collect();
    soon(
        "faces that all meet in one corner",
        scene(format!(
            "<Shape><IndexedFaceSet creaseAngle='1' coordIndex='{fan}'><Coordinate point='{rim}'/></IndexedFaceSet></Shape>"
        )),
    );
    let lights = "<Group><DirectionalLight/><Shape><Box/></Shape></Group>".repeat(5000);
    soon("many lights", scene(lights));
    soon("huge numbers", scene("<Transform scale='1e300 1e300 1e300'><Transform scale='1e300 1e300 1e300'><Shape><Box/></Shape><PointLight/><Fog visibilityRange='1'/></Transform></Transform>".into()));
    soon("huge coordinates", scene("<Shape><IndexedFaceSet coordIndex='0 1 2'><Coordinate point='1e308 -1e308 0 -1e308 1e308 0 1e308 1e308 1e308'/></IndexedFaceSet></Shape>".into()));
}

#[test]
fn inlines_that_multiply_are_bounded() {
    // Each file includes the next one twice.
    let text = "<Scene><Inline url='f0.x3d'/></Scene>";
    let result = x3d::parse(text.as_bytes(), "t.x3d", &mut |name| {
        let i: u32 = name.trim_start_matches('f').trim_end_matches(".x3d").parse().ok()?;
        Some(
            format!(
                "<Scene><Inline url='f{0}.x3d'/><Inline url='f{0}.x3d'/><Shape><Box/></Shape></Scene>",
                i + 1
            )
            .into(),
        )
    });
    let error = result.unwrap_err().to_string();
    assert!(error.contains("nesting"), "{error}");
    let result = x3d::parse(text.as_bytes(), "t.x3d", &mut |name| {
        let i: u32 = name.trim_start_matches('f').trim_end_matches(".x3d").parse().ok()?;
        (i < 40).then(|| {
            format!(
                "<Scene><Inline url='f{0}.x3d'/><Inline url='f{0}.x3d'/><Shape><Box/></Shape></Scene>",
                i + 1
            )
            .into()
        })
    });
    let error = result.unwrap_err().to_string();
    assert!(error.contains("nodes, with those of USE and Inline"), "{error}");
}

#[test]
fn other_encodings_are_read_or_refused() {
    let text = "<?xml version='1.0'?><Scene><Shape><Text string='\"é\"'/></Shape></Scene>";
    let utf16: Vec<u8> =
        [0xff, 0xfe].into_iter().chain(text.encode_utf16().flat_map(u16::to_le_bytes)).collect();
    let latin: Vec<u8> =
        text.replace("'1.0'", "'1.0' encoding='ISO-8859-1'").chars().map(|c| c as u32 as u8).collect();
    for bytes in [text.as_bytes(), &utf16, &latin] {
        let mesh = x3d::parse(bytes, "t.x3d", &mut |_| None).unwrap().at(0.0);
        assert!(mesh.objects[0].geometry.mesh.corners.len() > 30, "an e and its accent");
    }
    let error = x3d::parse(b"<Scene>\n \xff</Scene>", "t.x3d", &mut |_| None).unwrap_err();
    assert!(error.to_string().starts_with("t.x3d:2:2: "), "{error}");
}

/// Returns the texts that are mutated: every test scene, and one with every feature.
fn corpus() -> Vec<Vec<u8>> {
    let mut all: Vec<Vec<u8>> = crate::files::readable()
        .map(|name| std::fs::read(data().join(name)).unwrap())
        .filter(|b| b.len() < 6000)
        .collect();
    all.push(EVERYTHING.into());
    all
}

const EVERYTHING: &str = "<X3D><Scene><NavigationInfo/><Background/><Fog visibilityRange='50'/><Viewpoint viewAll='true'/><OrthoViewpoint/>\
<Group DEF='G'><Shape DEF='S'><Appearance><TwoSidedMaterial separateBackColor='true'/><PixelTexture image='1 2 4 0xff 0xffffffff'/>\
<TextureTransform rotation='1'/></Appearance><IndexedFaceSet coordIndex='0 1 2 3 -1 0 2 1 -1' colorIndex='0 1 0 1 -1 1 1 1 -1' \
creaseAngle='0.5' texCoordIndex='0 1 2 0 -1 0 1 2 -1'><Coordinate DEF='P' point='0 0 0 1 0 0 1 1 0 0 1 1'/><Color color='1 0 0 0 1 0'/>\
<TextureCoordinate point='0 0 1 0 0 1'/></IndexedFaceSet></Shape></Group><Transform DEF='T' center='1 1 1' scaleOrientation='1 0 0 1' scale='1 \
2 3' rotation='0 1 0 2' translation='1 0 0'><Group USE='G'/><SpotLight/></Transform><Switch whichChoice='0'><Shape><Extrusion \
crossSection='1 0 0 1 -1 0 0 -1 1 0' spine='0 0 0 0 1 0 1 2 0 1 2 3' scale='1 1 2 2' orientation='0 1 0 1'/></Shape></Switch><Shape>\
<ElevationGrid xDimension='2' zDimension='3' height='0 1 2 3 4 5' creaseAngle='2'/></Shape><Shape><Text string='\"aB\" \"c\"'><FontStyle \
justify='\"MIDDLE\" \"END\"'/></Text></Shape><Shape><IndexedLineSet coordIndex='0 1 -1 1 0'><Coordinate point='0 0 0 1 1 1'/>\
</IndexedLineSet></Shape><Shape><TriangleStripSet stripCount='4'><Coordinate USE='P'/></TriangleStripSet></Shape><Shape><Disk2D \
innerRadius='0.5'/></Shape><TimeSensor DEF='C' loop='true' cycleInterval='3'/><CoordinateInterpolator DEF='I' key='0 1' keyValue='0 0 0 1 0 0 \
1 1 0 0 1 1 1 0 0 1 0 0 1 1 0 0 1 2'/><OrientationInterpolator DEF='O' key='0 0.5 1' keyValue='0 1 0 0 0 1 0 3 1 0 0 6'/><ROUTE \
fromNode='C' fromField='fraction_changed' toNode='I' toField='set_fraction'/><ROUTE fromNode='I' fromField='value_changed' toNode='P' \
toField='point'/><ROUTE fromNode='C' fromField='fraction_changed' toNode='O' toField='set_fraction'/><ROUTE fromNode='O' \
fromField='value_changed' toNode='T' toField='rotation'/></Scene></X3D>";

#[test]
fn the_scene_that_has_everything_is_read() {
    let document = parse(EVERYTHING).unwrap();
    assert_eq!(warnings(&document), [] as [&str; 0]);
    assert_eq!(document.at(0.0).objects.len(), 8);
}

/// Applies one change to a text, at a fraction `at` of its length: deletes, inserts, replaces,
/// duplicates, reverses, truncates or scrambles bytes.
fn change(bytes: &mut Vec<u8>, at: f64, kind: u8, what: &str, length: usize) {
    let i = (at * bytes.len() as f64) as usize;
    let end = (i + length).min(bytes.len());
    match kind {
        0 => drop(bytes.drain(i..end)),
        1 => drop(bytes.splice(i..i, what.bytes())),
        2 => drop(bytes.splice(i..end, what.bytes())),
        3 => {
            let copy = bytes[i..end].to_vec();
            bytes.splice(i..i, copy);
        }
        4 => bytes[i..end].reverse(),
        5 => bytes.truncate(i),
        _ => bytes.iter_mut().skip(i).take(length).for_each(|b| *b = b.wrapping_mul(31).wrapping_add(7)),
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 600, ..ProptestConfig::default() })]

    /// Any file, however damaged, is read or refused; a scene that is read is valid and can be
    /// drawn.
    #[test]
    fn damaged_files_never_panic(
        which in 0..1000_usize,
        changes in prop::collection::vec(
            (0.0..1.0_f64, 0..7_u8, prop::sample::select(&[
                "-1", "9", "1e308", "-0", " ", "'", "\"", "<", ">", "/>", "&", "<Shape>", "</Shape>", "USE='S'", "DEF='T'", "0 0 0 ", "2147483647",
                "0.0000001", "true", "<Box/>", "Sphere", "Transform", "\u{e9}",
            ][..]), 1..40_usize),
            1..5,
        ),
        time in -1.0..10.0_f64,
    ) {
        let corpus = corpus();
        let mut bytes = corpus[which % corpus.len()].clone();
        for (at, kind, what, length) in changes {
            change(&mut bytes, at, kind, what, length);
        }
        match x3d::parse(&bytes, "m.x3d", &mut |_| None) {
            Ok(document) => {
                let scene = document.at(time);
                check(&scene);
                if scene.camera.is_some_and(|c| c.matrices(1.0).is_ok()) {
                    draw(&scene, 8, 8);
                }
            }
            Err(error) => prop_assert!(error.to_string().starts_with("m.x3d"), "{}", error),
        }
    }

    /// Fields with any numbers are read or refused, and a scene that is read can be drawn.
    #[test]
    fn any_numbers_in_fields_are_survived(numbers in prop::collection::vec(prop::num::f64::NORMAL | prop::num::f64::ZERO, 40), time in 0.0..3.0_f64) {
        let list = |from: usize, n: usize| {
            numbers[from..from + n].iter().map(|x| x.to_string()).collect::<Vec<_>>().join(" ")
        };
        let text = format!(
            "<Scene><Viewpoint position='{}' orientation='{}' fieldOfView='{}'/><Transform translation='{}' rotation='{}' scale='{}' center='{}' \
             scaleOrientation='{}'><Shape><Appearance><Material shininess='{}' transparency='{}'/></Appearance><Extrusion spine='{}' \
             scale='{}' creaseAngle='{}'/></Shape><PointLight location='{}' radius='{}'/></Transform></Scene>",
            list(0, 3), list(3, 4), list(7, 1), list(8, 3), list(11, 4), list(15, 3), list(18, 3), list(21, 4), list(25, 1), list(26, 1),
            list(27, 9), list(36, 2), list(38, 1), list(0, 3), list(39, 1),
        );
        let document = parse(&text).unwrap();
        let scene = document.at(time);
        if scene.camera.is_some_and(|c| c.matrices(1.0).is_ok()) && fbptr_can_draw(&scene) {
            draw(&scene, 8, 8);
        }
    }
}

/// Returns whether every position of the scene is finite, as the pipeline requires.
fn fbptr_can_draw(scene: &fbptr::scene::Scene) -> bool {
    scene.objects.iter().all(|o| o.geometry.mesh.positions.iter().all(|p| p.is_finite()))
}
