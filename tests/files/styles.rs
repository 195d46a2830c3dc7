//! Lines, hatches, several textures and generated coordinates: the nodes' values, and the pixels
//! that result.

use crate::support::{check, close, document, draw, parse, scene, shape, warnings};
use fbptr::scene::{
    Camera, FillStyle, Hatch, LineKind, LineStyle, LookAt, Object, StageFunction, StageMode, StageSource,
};
use glam::{DVec2, DVec3, DVec4};

/// A viewpoint whose frame of 32 x 32 pixels shows x and y from 0 to 32.
const PIXELS: &str =
    "<OrthoViewpoint position='16 16 10' fieldOfView='-16 -16 16 16'/><NavigationInfo headlight='false'/>";

/// Returns the rows of a frame of 32 x 32 pixels as text, a character for each pixel: `.` for
/// black.
fn rows(nodes: &str) -> Vec<String> {
    let memory = draw(&scene(&format!("{PIXELS}{nodes}")), 32, 32);
    let pixels: Vec<char> =
        memory.bytes().chunks(4).map(|p| if p[..3] == [0; 3] { '.' } else { '#' }).collect();
    pixels.chunks(32).map(|row| row.iter().collect()).collect()
}

/// Returns a line from (2.5, y) to (29.5, y), with y up.
fn line(fields: &str, y: f64) -> String {
    format!(
        "<Shape><Appearance><Material emissiveColor='1 1 1'/><LineProperties {fields}/></Appearance>\
         <LineSet vertexCount='3'><Coordinate point='2.5 {y} 0 13.5 {y} 0 29.5 {y} 0'/></LineSet></Shape>"
    )
}

#[test]
fn a_line_is_as_wide_as_its_scale_factor_says() {
    for (factor, first, last) in
        [("-3", 16, 16), ("0", 16, 16), ("1.4", 16, 16), ("2", 16, 17), ("3", 15, 17), ("7.6", 13, 20)]
    {
        let rows = rows(&line(&format!("linewidthScaleFactor='{factor}'"), 15.5));
        let lit: Vec<usize> = (0..32).filter(|y| rows[*y].contains('#')).collect();
        assert_eq!((lit[0], *lit.last().unwrap()), (first, last), "{factor}");
        assert_eq!(rows[first], format!("..{}..", "#".repeat(28)), "{factor}");
    }
    let plain = rows(&line("applied='false' linetype='2' linewidthScaleFactor='5'", 15.5));
    assert_eq!(plain[16], format!("..{}..", "#".repeat(28)));
    assert!(plain.iter().enumerate().all(|(y, row)| y == 16 || !row.contains('#')));
    // Steep lines are widened horizontally.
    let upright = "<Shape><Appearance><Material emissiveColor='1 1 1'/><LineProperties linewidthScaleFactor='4'/></Appearance>\
        <LineSet vertexCount='2'><Coordinate point='10.5 0.5 0 10.5 31.5 0'/></LineSet></Shape>";
    assert!(rows(upright).iter().all(|row| row == "..........####.................." || row == ".........####..................."));
}

#[test]
fn patterns_go_on_from_one_line_to_the_next() {
    let of = |linetype: u32| rows(&line(&format!("linetype='{linetype}'"), 15.5))[16].clone();
    assert_eq!(of(1), "..############################..");
    assert_eq!(of(2), "..########........########......");
    assert_eq!(of(3), "..#...#...#...#...#...#...#.....");
    assert_eq!(of(4), "..########...##...########...#..");
    assert_eq!(of(5), "..########..#..#..########..#...");
    let twice = rows(&line("linetype='2' linewidthScaleFactor='2'", 15.5));
    assert_eq!((&twice[16][..], &twice[17]), ("..################..............", &twice[16]));
    let style = |fields: &str| {
        let look = format!("<Appearance><LineProperties {fields}/></Appearance>");
        shape(&look, "<Circle2D/>").style.line
    };
    assert_eq!(
        style("linetype='4' linewidthScaleFactor='3'"),
        LineStyle { width: 3, kind: LineKind::DashDot }
    );
    assert_eq!(style("linewidthScaleFactor='1e9'").width, 256);
    let other = parse(
        "<Scene><Shape><Appearance><LineProperties linetype='16'/></Appearance><Circle2D/></Shape></Scene>",
    );
    assert!(warnings(&other.unwrap())[0].contains("linetype 16 is drawn like one of the types 1 to 5"));
}

#[test]
fn hatches_lie_on_the_frame() {
    let square = |fields: &str| {
        rows(&format!(
            "<Transform translation='16 16 0'><Shape><Appearance><UnlitMaterial emissiveColor='0 0 0'/><FillProperties {fields}/></Appearance>\
             <Rectangle2D size='20 20'/></Shape></Transform>"
        ))
    };
    let lines = square("hatchStyle='1'");
    let lit: Vec<usize> = (0..32).filter(|y| lines[*y].contains('#')).collect();
    assert_eq!(lit, [8, 16, 24]);
    assert_eq!(lines[8], "......####################......");
    assert_eq!(square("hatchStyle='2'")[12], "........#.......#.......#.......");
    assert_eq!(square("hatchStyle='3'")[12], "............#.......#...........");
    assert_eq!(square("hatchStyle='2' hatched='false'")[12], ".".repeat(32));
    let style = |fields: &str| {
        let look = format!("<Appearance><FillProperties {fields}/></Appearance>");
        shape(&look, "<Box/>").style.fill
    };
    assert_eq!(style(""), FillStyle { is_filled: true, hatch: Some((Hatch::Horizontal, DVec3::ONE)) });
    assert_eq!(style("filled='false' hatched='false'"), FillStyle { is_filled: false, hatch: None });
    assert_eq!(style("hatchStyle='6' hatchColor='1 0 0'").hatch, Some((Hatch::Diamond, DVec3::X)));
    // Unfilled pixels show what is behind, and write no depth.
    let both = "<Transform translation='16 16 1'><Shape><Appearance><UnlitMaterial/><FillProperties filled='false' hatched='false'/></Appearance>\
        <Rectangle2D size='20 20'/></Shape></Transform><Transform translation='16 16 0'><Shape><Appearance><UnlitMaterial/></Appearance>\
        <Rectangle2D size='4 4'/></Shape></Transform>";
    assert_eq!(rows(both)[16], "..............####..............");
}

const QUAD: &str = "<IndexedFaceSet coordIndex='0 1 2 3' texCoordIndex='0 1 2 3'><Coordinate point='0 0 0 1 0 0 1 1 0 0 1 0'/>";

fn one_color(rgba: u32) -> String {
    format!("<PixelTexture image='1 1 4 {rgba:#x}'/>")
}

#[test]
fn several_textures_become_stages_with_their_words() {
    let look = format!(
        "<Appearance><Material/><MultiTexture color='1 0.5 0' alpha='0.25' mode='\"REPLACE\" \"ADD,SELECTARG2\" \"BLENDTEXTUREALPHA\"' \
         source='\"\" \"FACTOR\" \"DIFFUSE\"' function='\"\" \"COMPLEMENT\" \"ALPHAREPLICATE\"'>{0}{0}{0}{0}</MultiTexture></Appearance>",
        one_color(0xff00_00ff)
    );
    let object = shape(&look, &format!("{QUAD}</IndexedFaceSet>"));
    assert!(object.texture.is_none());
    let stages = object.style.stages.unwrap();
    assert_eq!((stages.stages.len(), stages.factor), (4, DVec4::new(1.0, 0.5, 0.0, 0.25)));
    let words: Vec<_> = stages.stages.iter().map(|s| (s.color, s.alpha, s.source, s.function)).collect();
    let expected = [
        (StageMode::Replace, StageMode::Replace, StageSource::Before, StageFunction::None),
        (StageMode::Add, StageMode::SelectArg2, StageSource::Factor, StageFunction::Complement),
        (
            StageMode::BlendTextureAlpha,
            StageMode::SelectArg2,
            StageSource::Diffuse,
            StageFunction::AlphaReplicate,
        ),
        (StageMode::Modulate, StageMode::Modulate, StageSource::Before, StageFunction::None),
    ];
    assert_eq!(words, expected);
    let odd = parse(&format!(
        "<Scene><Shape><Appearance>\n<MultiTexture mode='\"BUMP\"'>{}</MultiTexture></Appearance><Box/></Shape></Scene>",
        one_color(0xff)
    ));
    assert_eq!(
        warnings(&odd.unwrap()),
        ["t.x3d:2:1: warning: <MultiTexture> mode BUMP is not known: MODULATE is taken"]
    );
}

#[test]
fn each_texture_takes_its_own_coordinates_and_its_own_transform() {
    let uv = |coordinates: &str, transform: &str| -> Vec<Vec<DVec2>> {
        let look = format!(
            "<Appearance><MultiTexture>{0}{0}{0}</MultiTexture>{transform}</Appearance>",
            one_color(0xff)
        );
        let object = shape(&look, &format!("{QUAD}{coordinates}</IndexedFaceSet>"));
        let stages = object.style.stages.unwrap();
        stages.stages.iter().map(|s| s.texcoords.to_vec()).collect()
    };
    let unit = vec![DVec2::ZERO, DVec2::X, DVec2::ONE, DVec2::Y];
    let times = |k: f64| -> Vec<DVec2> { unit.iter().map(|p| *p * k).collect() };
    let list = |k: u32| format!("<TextureCoordinate point='0 0 {k} 0 {k} {k} 0 {k}'/>");
    let two = format!("<MultiTextureCoordinate>{}{}</MultiTextureCoordinate>", list(1), list(4));
    // The last entry is repeated if there are too few.
    assert_eq!(uv(&two, ""), [times(1.0), times(4.0), times(4.0)]);
    assert_eq!(uv(&list(2), ""), [times(2.0), times(2.0), times(2.0)]);
    assert_eq!(uv("", ""), [unit.clone(), unit.clone(), unit.clone()]);
    assert_eq!(uv(&two, "<TextureTransform scale='2 2'/>"), [times(2.0), times(8.0), times(8.0)]);
    let own =
        "<MultiTextureTransform><TextureTransform scale='3 3'/><TextureTransform/></MultiTextureTransform>";
    assert_eq!(uv(&two, own), [times(3.0), times(4.0), times(4.0)]);
    let generated = "<MultiTextureCoordinate><TextureCoordinateGenerator mode='COORD'/><TextureCoordinate point='9 9 9 9 9 9 9 9'/>\
                     </MultiTextureCoordinate>";
    assert_eq!(uv(generated, "")[..2], [unit.clone(), vec![DVec2::splat(9.0); 4]]);
}

#[test]
fn three_stages_give_the_pixels_that_the_formulas_give() {
    let pixel = |mode: &str, material: &str, textures: &[u32]| -> [u8; 4] {
        let all: String = textures.iter().map(|t| one_color(*t)).collect();
        let nodes = format!(
            "{PIXELS}<Transform translation='16 16 0'><Shape><Appearance>{material}<MultiTexture mode='{mode}'>{all}</MultiTexture></Appearance>\
             <Rectangle2D size='20 20'/></Shape></Transform>"
        );
        let s = scene(&nodes);
        check(&s);
        let memory = draw(&s, 32, 32);
        let bytes = &memory.bytes()[(16 * 32 + 16) * 4..];
        [bytes[0], bytes[1], bytes[2], bytes[3]]
    };
    let white = "<UnlitMaterial/>";
    // 0.2 0.4 0.6; + 0.4 0.4 0.4; * 1 0.5 0.
    let three = [0x3366_99ff, 0x6666_66ff, 0xff80_00ff];
    assert_eq!(pixel("\"MODULATE\" \"ADD\" \"MODULATE\"", white, &three), [153, 102, 0, 255]);
    assert_eq!(
        pixel("\"REPLACE\"", "<UnlitMaterial emissiveColor='0 0 1'/>", &three[..1]),
        [51, 102, 153, 255]
    );
    assert_eq!(pixel("\"MODULATE\" \"SUBTRACT\"", white, &three[..2]), [51, 0, 0, 255]);
    assert_eq!(
        pixel("\"MODULATE\" \"BLENDTEXTUREALPHA\"", white, &[0xff00_00ff, 0x0000_ff33]),
        [204, 0, 51, 255]
    );
    // A single stage that multiplies is a plain texture.
    let plain = format!(
        "{PIXELS}<Transform translation='16 16 0'><Shape><Appearance>{white}{}</Appearance><Rectangle2D size='20 20'/></Shape></Transform>",
        one_color(three[0])
    );
    let memory = draw(&scene(&plain), 32, 32);
    assert_eq!(pixel("", white, &three[..1]), memory.bytes()[(16 * 32 + 16) * 4..][..4]);
}

#[test]
fn coordinates_are_generated_for_one_texture_and_follow_the_viewer() {
    let text = |mode: &str, transform: &str| {
        format!(
            "<Transform translation='0 0 -2'><Shape><Appearance>{}{transform}</Appearance>{QUAD}<TextureCoordinateGenerator mode='{mode}'/>\
             <Normal vector='0 0 1'/></IndexedFaceSet></Shape></Transform>",
            one_color(0xff)
        )
        .replace("coordIndex='0 1 2 3' texCoordIndex='0 1 2 3'", "coordIndex='0 1 2 3' normalPerVertex='false'")
    };
    let of = |o: &Object| -> Vec<DVec2> {
        let mesh = &o.geometry.mesh;
        mesh.corners.iter().map(|c| mesh.texcoords[c.texcoord as usize]).collect()
    };
    let unit = [DVec2::ZERO, DVec2::X, DVec2::ONE, DVec2::Y];
    let local = document(&text("COORD", ""));
    assert!(!local.depends_on_viewer());
    assert_eq!(of(&local.at(0.0).objects[0]), unit);
    let moved = document(&text("COORD", "<TextureTransform scale='2 2'/>"));
    assert_eq!(of(&moved.at(0.0).objects[0])[1], DVec2::X * 2.0);
    let camera = document(&text("COORD-EYE", ""));
    assert!(camera.depends_on_viewer());
    assert_eq!(of(&camera.at(0.0).objects[0]), unit);
    let look_at =
        LookAt { eye: DVec3::new(3.0, 0.0, 8.0), reference: DVec3::new(3.0, 0.0, 0.0), up: DVec3::Y };
    let seen = camera.seen_at(0.0, Some(&Camera { look_at, ..Camera::default() }));
    let x = of(&seen.objects[0])[1].x;
    close(DVec3::X * x, DVec3::X * -2.0);
}
