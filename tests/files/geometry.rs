//! The mesh of each geometry node: positions, fronts, normals, texture coordinates, colours.

use crate::support::{area, close, mesh, parse, shape, volume, warnings};
use fbptr::scene::{LightingModel, Mesh, NONE};
use glam::{DVec2, DVec3, DVec4};
use std::f64::consts::PI;

const TEXTURED: &str = "<Appearance><PixelTexture image='1 1 1 0'/></Appearance>";

/// Returns the normals at a polygon's corners.
fn normals(mesh: &Mesh, polygon: usize) -> Vec<DVec3> {
    let p = mesh.polygons[polygon];
    let corners = &mesh.corners[p.first_corner as usize..(p.first_corner + p.corner_count) as usize];
    corners.iter().map(|c| mesh.normals[c.normal as usize]).collect()
}

/// Returns the colours at all corners.
fn colors(mesh: &Mesh) -> Vec<[f64; 4]> {
    mesh.corners.iter().map(|c| mesh.colors[c.color as usize].to_array()).collect()
}

fn textured(geometry: &str) -> Mesh {
    shape(TEXTURED, geometry).geometry.mesh.clone()
}

/// Returns the texture coordinates at all corners.
fn texcoords(mesh: &Mesh) -> Vec<DVec2> {
    mesh.corners.iter().map(|c| mesh.texcoords[c.texcoord as usize]).collect()
}

#[test]
fn closed_bodies_look_outwards() {
    let hull = |geometry: &str| volume(&mesh(geometry));
    assert!((hull("<Box/>") - 8.0).abs() < 1e-12);
    assert!((hull("<Sphere/>") - 4.0 / 3.0 * PI).abs() < 0.01);
    assert!((hull("<Cylinder/>") - 2.0 * PI).abs() < 0.01);
    assert!((hull("<Cone/>") - 2.0 / 3.0 * PI).abs() < 0.01);
    // The default extrusion: a square of 2 x 2, one high.
    assert!((hull("<Extrusion/>") - 4.0).abs() < 1e-12);
    let turned = hull("<Extrusion ccw='false'/>");
    assert!((turned + 4.0).abs() < 1e-12, "{turned}");
    // Along any straight line, and with the cross-section rotated about it.
    for spine in ["0 0 0 3 0 0", "1 1 1 1 1 -2", "0 0 0 0 -3 0", "0 0 0 1 1 1 2 2 2"] {
        let length = if spine.len() > 12 { 12f64.sqrt() } else { 3.0 };
        let volume = hull(&format!("<Extrusion spine='{spine}' orientation='0 1 0 0.7'/>"));
        assert!((volume - 4.0 * length).abs() < 1e-9, "{spine}: {volume}");
    }
    // A ring of four corners closes without a gap: it encloses the volume that caps would bound.
    let ring = "<Extrusion crossSection='0.1 0.1 0.1 -0.1 -0.1 -0.1 -0.1 0.1 0.1 0.1' beginCap='false' endCap='false' \
                spine='1 0 0 0 0 -1 -1 0 0 0 0 1 1 0 0' scale='1 1.4142135623730951'/>";
    let mesh = mesh(ring);
    assert_eq!((mesh.positions.len(), mesh.polygons.len()), (16, 16), "ends are shared");
    assert!(volume(&mesh) > 0.2, "{}", volume(&mesh));
}

#[test]
fn parts_of_solids_can_be_left_out() {
    let faces = |geometry: &str| mesh(geometry).polygons.len();
    assert_eq!(faces("<Cone side='false'/>"), 1);
    assert_eq!(faces("<Cylinder side='false' top='false'/>"), 1);
    assert_eq!(faces("<Cylinder side='false'/>"), 2);
    assert_eq!(faces("<Cylinder/>") - faces("<Cylinder bottom='false'/>"), 1);
    assert_eq!(faces("<Extrusion endCap='false'/>"), 5);
}

#[test]
fn a_face_set_takes_concave_faces_and_either_winding() {
    let arrow = "coordIndex='0 1 2 3 -1'><Coordinate point='0 0 0 4 0 0 1 1 0 0 4 0'/></IndexedFaceSet>";
    let ccw = mesh(&format!("<IndexedFaceSet convex='false' {arrow}"));
    assert_eq!((ccw.triangles.len(), area(&ccw)), (2, DVec3::Z * 4.0));
    assert_eq!(normals(&ccw, 0), [DVec3::Z; 4]);
    let cw = mesh(&format!("<IndexedFaceSet ccw='false' {arrow}"));
    assert_eq!((area(&cw), normals(&cw, 0)), (DVec3::Z * -4.0, vec![DVec3::NEG_Z; 4]));
}

#[test]
fn colours_lie_on_vertices_or_faces_by_index_or_by_count() {
    const QUADS: &str =
        "<Coordinate point='0 0 0 1 0 0 1 1 0 0 1 0'/><Color color='1 0 0 0 1 0 0 0 1 1 1 1'/>";
    let red = |rgb: &[[f64; 4]]| rgb.iter().map(|c| c[0] + 2.0 * c[1] + 4.0 * c[2]).collect::<Vec<_>>();
    let of = |fields: &str| {
        red(&colors(&mesh(&format!(
            "<IndexedFaceSet coordIndex='0 1 2 -1 0 2 3' {fields}>{QUADS}</IndexedFaceSet>"
        ))))
    };
    assert_eq!(of(""), [1.0, 2.0, 4.0, 1.0, 4.0, 7.0]);
    assert_eq!(of("colorIndex='3 3 3 -1 1 0 2'"), [7.0, 7.0, 7.0, 2.0, 1.0, 4.0]);
    assert_eq!(of("colorPerVertex='false'"), [1.0, 1.0, 1.0, 2.0, 2.0, 2.0]);
    assert_eq!(of("colorPerVertex='false' colorIndex='2 0'"), [4.0, 4.0, 4.0, 1.0, 1.0, 1.0]);
    let rgba = shape(
        "<Appearance><Material transparency='0.5'/></Appearance>",
        "<TriangleSet><Coordinate point='0 0 0 1 0 0 0 1 0'/><ColorRGBA color='1 0 0 1 0 1 0 0.5 0 0 1 0'/></TriangleSet>",
    );
    assert_eq!(rgba.geometry.mesh.colors[1], DVec4::new(0.0, 1.0, 0.0, 0.5));
    assert_eq!((rgba.material.transparency, rgba.material.kd), (0.0, DVec3::ONE));
}

#[test]
fn normals_are_the_files_or_follow_the_crease_angle() {
    let roof = |fields: &str, nodes: &str| {
        mesh(&format!(
            "<IndexedFaceSet coordIndex='0 1 2 3 -1 1 4 5 2 -1' {fields}><Coordinate point='-1 0 1 0 1 1 0 1 -1 -1 0 -1 1 0 1 1 0 -1'/>\
             {nodes}</IndexedFaceSet>"
        ))
    };
    let slope = DVec3::new(-1.0, 1.0, 0.0).normalize();
    for n in normals(&roof("", ""), 0) {
        close(n, slope);
    }
    let smooth = normals(&roof("creaseAngle='1.6'", ""), 0);
    close(smooth[0], slope);
    close(smooth[1], DVec3::Y);
    let own = "<Normal vector='0 0 1 1 0 0'/>";
    assert_eq!(normals(&roof("normalPerVertex='false'", own), 1), [DVec3::X; 4]);
    assert_eq!(normals(&roof("normalPerVertex='false' normalIndex='1 0'", own), 1), [DVec3::Z; 4]);
    let indexed = roof("normalIndex='0 1 1 0 -1 1 1 0 0'", own);
    assert_eq!(normals(&indexed, 1), [DVec3::X, DVec3::X, DVec3::Z, DVec3::Z]);
}

#[test]
fn texture_coordinates_are_the_files_or_the_boxs() {
    const FACE: &str = "<Coordinate point='0 0 0 4 0 0 4 2 0 0 2 0'/>";
    let face = |fields: &str, nodes: &str| {
        texcoords(&textured(&format!(
            "<IndexedFaceSet coordIndex='0 1 2 3' {fields}>{FACE}{nodes}</IndexedFaceSet>"
        )))
    };
    let corners = |list: [(f64, f64); 4]| list.map(|(x, y)| DVec2::new(x, y)).to_vec();
    assert_eq!(face("", ""), corners([(0.0, 0.0), (1.0, 0.0), (1.0, 0.5), (0.0, 0.5)]));
    let own = "<TextureCoordinate point='0 0 1 0 1 1 0 1'/>";
    assert_eq!(face("", own), corners([(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)]));
    assert_eq!(
        face("texCoordIndex='3 2 1 0 -1'", own),
        corners([(0.0, 1.0), (1.0, 1.0), (1.0, 0.0), (0.0, 0.0)])
    );
    let plain = mesh(&format!("<IndexedFaceSet coordIndex='0 1 2 3'>{FACE}{own}</IndexedFaceSet>"));
    assert!(
        plain.texcoords.is_empty() && plain.corners.iter().all(|c| c.texcoord == NONE),
        "no texture: no u,v"
    );
    let moved = shape(
        "<Appearance><PixelTexture image='1 1 1 0'/><TextureTransform translation='0.5 0' scale='2 2'/></Appearance>",
        &format!("<IndexedFaceSet coordIndex='0 1 2 3'>{FACE}{own}</IndexedFaceSet>"),
    );
    assert_eq!(moved.geometry.mesh.texcoords[0], DVec2::new(1.0, 0.0));
    assert_eq!(moved.geometry.mesh.texcoords[2], DVec2::new(3.0, 2.0));
}

#[test]
fn strips_and_fans_all_face_one_way() {
    const ZIGZAG: &str = "<Coordinate point='0 0 0 0 -1 0 1 0 0 1 -1 0 2 0 0'/>";
    const WHEEL: &str = "<Coordinate point='0 0 0 1 0 0 1 1 0 0 1 0 -1 1 0'/>";
    for (name, fields, points, expected) in [
        ("TriangleStripSet", "stripCount='5'", ZIGZAG, 1.5),
        ("TriangleStripSet", "stripCount='3'", ZIGZAG, 0.5),
        ("IndexedTriangleStripSet", "index='0 1 2 3 4 -1'", ZIGZAG, 1.5),
        ("IndexedTriangleStripSet", "index='0 1 2 -1 2 3 4'", ZIGZAG, 1.0),
        ("TriangleFanSet", "fanCount='5'", WHEEL, 1.5),
        ("IndexedTriangleFanSet", "index='0 1 2 3 -1 0 3 4 -1'", WHEEL, 1.5),
        ("IndexedTriangleSet", "index='0 1 2 0 2 3 0 3'", WHEEL, 1.0),
    ] {
        let mesh = mesh(&format!("<{name} {fields}>{points}</{name}>"));
        assert!((area(&mesh) - DVec3::Z * expected).length() < 1e-12, "{name} {fields}: {}", area(&mesh));
        for p in 0..mesh.polygons.len() {
            assert!(normals(&mesh, p).iter().all(|n| *n == DVec3::Z), "{name}");
        }
    }
    // Smooth over shared coordinates, or one normal per face.
    const TENT: &str = "<Coordinate point='0 1 0 -1 0 0 0 0 1 1 0 0'/>";
    let tent = |fields: &str| {
        mesh(&format!("<IndexedTriangleSet index='0 1 2 0 2 3' {fields}>{TENT}</IndexedTriangleSet>"))
    };
    assert!((normals(&tent(""), 0)[0] - DVec3::new(0.0, 1.0, 1.0).normalize()).length() < 1e-12);
    let flat = normals(&tent("normalPerVertex='false'"), 0);
    assert!(flat[0] == flat[2] && flat[0].x < -0.5);
}

#[test]
fn an_elevation_grid_lies_over_x_and_z_and_faces_up() {
    let grid = "xDimension='3' zDimension='2' xSpacing='2' zSpacing='4' height='0 1 0 0 1 0'";
    let mesh = textured(&format!("<ElevationGrid {grid}/>"));
    assert_eq!(mesh.positions[4], DVec3::new(2.0, 1.0, 4.0));
    assert_eq!(area(&mesh).y, 16.0);
    assert_eq!(mesh.texcoords[4], DVec2::new(0.5, 1.0));
    let left = DVec3::new(-1.0, 2.0, 0.0).normalize();
    normals(&mesh, 0).iter().for_each(|n| close(*n, left));
    let smooth = crate::support::mesh(&format!("<ElevationGrid {grid} creaseAngle='2'/>"));
    close(normals(&smooth, 0)[3], DVec3::Y);
    let colored = crate::support::mesh(&format!(
        "<ElevationGrid colorPerVertex='false' {grid}><Color color='1 0 0 0 0 1'/></ElevationGrid>"
    ));
    assert_eq!(colors(&colored)[4..], [[0.0, 0.0, 1.0, 1.0]; 4]);
    assert!(area(&crate::support::mesh(&format!("<ElevationGrid ccw='false' {grid}/>"))).y < 0.0);
}

#[test]
fn an_extrusion_scales_and_turns_at_each_spine_point() {
    let mesh = textured("<Extrusion scale='1 1 0.5 2' orientation='0 1 0 0 0 1 0 1.5707963267948966'/>");
    // At the top, (1, 1) is scaled to (0.5, 2) and rotated a quarter about y: x' = z, z' = -x.
    close(mesh.positions[0], DVec3::new(1.0, 0.0, 1.0));
    close(mesh.positions[4], DVec3::new(2.0, 1.0, -0.5));
    assert_eq!(mesh.positions.len(), 8);
    assert_eq!(
        texcoords(&mesh)[..4],
        [(0., 0.), (0.25, 0.), (0.25, 1.), (0., 1.)].map(|(s, t)| DVec2::new(s, t))
    );
    let caps: Vec<DVec3> = [4, 5].map(|p| normals(&mesh, p)[0]).into();
    close(caps[0], DVec3::NEG_Y);
    close(caps[1], DVec3::Y);
    // A file with two equal spine points: a flat frame in y = 0.
    let flat = crate::support::load("x_ite/Extrusion/Scales.x3d").unwrap().at(0.0);
    let mesh = &flat.objects[0].geometry.mesh;
    assert!(mesh.positions.iter().all(|p| p.y == 0.0));
    assert_eq!(area(mesh).length(), 12.0);
}

#[test]
fn lines_and_points_are_unlit_in_the_emissive_colour() {
    const POINTS: &str = "<Coordinate point='0 0 0 1 0 0 1 1 0 0 1 0'/>";
    const COLORS: &str = "<Color color='1 0 0 0 1 0 0 0 1 1 1 1'/>";
    let glow = "<Appearance><Material emissiveColor='1 0 1' diffuseColor='0 1 0'/></Appearance>";
    let line = shape(glow, &format!("<LineSet vertexCount='2 2'>{POINTS}</LineSet>"));
    assert_eq!(line.geometry.mesh.lines, [[0, 1], [2, 3]]);
    assert_eq!(
        (line.material.model, line.material.emissive),
        (LightingModel::Unlit, DVec3::new(1.0, 0.0, 1.0))
    );
    let lines = |fields: &str| {
        mesh(&format!("<IndexedLineSet coordIndex='0 1 2 -1 2 3' {fields}>{POINTS}{COLORS}</IndexedLineSet>"))
    };
    let reds = |mesh: &Mesh| colors(mesh).iter().map(|c| c[0] + 2.0 * c[1] + 4.0 * c[2]).collect::<Vec<_>>();
    let plain = lines("");
    assert_eq!(
        (plain.lines.clone(), reds(&plain)),
        (vec![[0, 1], [1, 2], [3, 4]], vec![1.0, 2.0, 4.0, 4.0, 7.0])
    );
    assert_eq!(reds(&lines("colorIndex='0 0 1 -1 2 2'")), [1.0, 1.0, 2.0, 4.0, 4.0]);
    assert_eq!(reds(&lines("colorPerVertex='false'")), [1.0, 1.0, 1.0, 2.0, 2.0]);
    assert_eq!(reds(&lines("colorPerVertex='false' colorIndex='3 1'")), [7.0, 7.0, 7.0, 2.0, 2.0]);
    let points = shape(glow, &format!("<PointSet>{POINTS}{COLORS}</PointSet>"));
    assert_eq!((points.geometry.mesh.points.len(), points.material.emissive), (4, DVec3::ONE));
    let lit =
        shape(glow, &format!("<PointSet>{POINTS}<Normal vector='0 0 1 0 0 1 0 0 1 0 0 1'/></PointSet>"));
    assert_eq!(lit.material.model, LightingModel::Blinn);
}

#[test]
fn flat_figures_lie_in_z_0_and_face_the_viewer() {
    let circle = mesh("<Circle2D radius='2'/>");
    assert!(
        circle.lines.len() == circle.positions.len()
            && circle.positions.iter().all(|p| (p.length() - 2.0).abs() < 1e-12)
    );
    assert_eq!(mesh("<Polyline2D lineSegments='0 0 1 1 2 0'/>").lines, [[0, 1], [1, 2]]);
    assert_eq!(mesh("<Polypoint2D point='0 0 1 1'/>").points.len(), 2);
    assert_eq!(area(&mesh("<Rectangle2D size='3 4'/>")), DVec3::Z * 12.0);
    let disc = area(&mesh("<Disk2D/>")).z;
    let ring = area(&mesh("<Disk2D innerRadius='0.5'/>")).z;
    assert!((disc - PI).abs() < 0.01 && (ring - 0.75 * disc).abs() < 1e-12);
    assert!(mesh("<Disk2D innerRadius='1'/>").lines.len() > 90);
    let triangles = mesh("<TriangleSet2D vertices='0 0 1 0 0 1 5 5 5 6 6 5'/>");
    assert_eq!((normals(&triangles, 0)[0], normals(&triangles, 1)[0]), (DVec3::Z, DVec3::NEG_Z));
    let object = shape("", "<Rectangle2D/>");
    assert!(object.two_sided_lighting, "seen from both sides unless solid");
    assert!(!shape("", "<Rectangle2D solid='true'/>").two_sided_lighting);
}

#[test]
fn arcs_run_counter_clockwise_and_close_by_their_centre_or_a_chord() {
    let arc = mesh("<Arc2D radius='2'/>");
    assert_eq!((arc.lines.len(), arc.positions.len()), (24, 25), "as fine as a circle");
    close(arc.positions[0], DVec3::X * 2.0);
    close(arc.positions[24], DVec3::Y * 2.0);
    let long = mesh("<Arc2D startAngle='1.5707963267948966' endAngle='0'/>");
    assert_eq!(long.lines.len(), 72, "from +y the long way to +x");
    for whole in ["startAngle='1' endAngle='1'", "startAngle='-4' endAngle='3'"] {
        let circle = mesh("<Circle2D/>");
        assert_eq!(mesh(&format!("<Arc2D {whole}/>")).lines, circle.lines, "{whole}");
        assert!((area(&mesh(&format!("<ArcClose2D {whole}/>"))).z - PI).abs() < 0.01, "{whole}");
    }
    let (pie, chord) = (area(&mesh("<ArcClose2D/>")).z, area(&mesh("<ArcClose2D closureType='CHORD'/>")).z);
    assert!((pie - PI / 4.0).abs() < 0.001 && (pie - chord - 0.5).abs() < 1e-12, "{pie} {chord}");
    let wrong = parse("<Scene><Shape><ArcClose2D closureType='ROUND'/></Shape></Scene>").unwrap();
    assert!(warnings(&wrong)[0].contains("PIE is taken"));
}

#[test]
fn quads_have_four_corners_and_the_properties_of_triangle_sets() {
    let points = "<Coordinate point='0 0 0 1 0 0 1 1 0 0 1 0 2 0 0 2 1 0'/>";
    let quads = mesh(&format!("<IndexedQuadSet index='0 1 2 3 1 4 5 2 0'>{points}</IndexedQuadSet>"));
    assert_eq!((quads.polygons.len(), quads.triangles.len()), (2, 4));
    assert_eq!((area(&quads), normals(&quads, 1)[3]), (DVec3::Z * 2.0, DVec3::Z));
    let turned = mesh(&format!("<IndexedQuadSet ccw='false' index='0 1 2 3'>{points}</IndexedQuadSet>"));
    assert_eq!(area(&turned), -DVec3::Z);
    let colour = "<Color color='1 0 0'/>";
    let left = parse(&format!(
        "<Scene><Shape><QuadSet colorPerVertex='false'>{points}{colour}</QuadSet></Shape></Scene>"
    ));
    let left = left.unwrap();
    assert!(warnings(&left)[0].contains("coordinates left over that make no quad"));
    assert_eq!(colors(&left.at(0.0).objects[0].geometry.mesh), [[1.0, 0.0, 0.0, 1.0]; 4]);
    let beyond = parse(&format!(
        "<Scene><Shape><IndexedQuadSet index='0 1 2 3 3 4 5 6'>{points}</IndexedQuadSet></Shape></Scene>"
    ));
    assert_eq!(beyond.unwrap().at(0.0).objects[0].geometry.mesh.polygons.len(), 1);
}

#[test]
fn line_sets_count_by_either_name() {
    let points = "<Coordinate point='0 0 0 1 0 0 1 1 0 0 1 0 2 0 0'/>";
    let lines = |counts: &str| mesh(&format!("<LineSet {counts}>{points}</LineSet>")).lines;
    assert_eq!(lines("stripCount='3 2'"), [[0, 1], [1, 2], [3, 4]]);
    assert_eq!(lines("stripCount='3 2'"), lines("vertexCount='3 2'"));
    assert_eq!(lines("stripCount='2' vertexCount='5'").len(), 4, "the standard's name wins");
}

#[test]
fn text_is_set_by_its_font_style() {
    let bounds = |geometry: &str| mesh(geometry).bounds().unwrap();
    let near = |a: f64, b: f64| assert!((a - b).abs() < 0.01, "{a} is not {b}");
    // Capitals stand on the baseline, 0.73 of the size high; characters have their own widths.
    let (low, high) = bounds("<Text string='\"HH\"'/>");
    assert_eq!((low.y, high.y), (0.0, 146.0 / 200.0));
    assert!(low.x >= 0.0 && high.x <= 1.8 && high.x > 1.5);
    assert!(bounds("<Text string='\"ll\"'/>").1.x < 0.7);
    let style = "<FontStyle size='4' justify='\"MIDDLE\" \"MIDDLE\"'/>";
    let (low, high) = bounds(&format!("<Text string='\"HH\"'>{style}</Text>"));
    // The line of 4 is centred: its baseline is at 2 - 0.76 * 4.
    near(low.y, -1.04);
    near(high.y, 1.88);
    near(low.x + high.x, 0.0);
    let (low, _) = bounds("<Text string='\"A\" \"B\"'><FontStyle spacing='2'/></Text>");
    near(low.y, -2.0);
    let (_, high) = bounds("<Text string='\"HHHH\"' maxExtent='2'/>");
    assert!(high.x <= 2.0 && high.x > 1.7);
    let (_, high) = bounds("<Text string='\"HH\"' length='8'/>");
    assert!(high.x <= 8.0 && high.x > 6.5);
    assert!(area(&mesh("<Text string='\"A\"'/>")).z > 0.0);
    near(bounds("<Text string='\"p\"'/>").0.y, -0.21);
    let sans = mesh("<Text string='\"HH\"'><FontStyle family='\"Comic\" \"SANS\"'/></Text>");
    assert_eq!(sans.polygons.len(), 2);
    assert!(sans.positions.len() < mesh("<Text string='\"HH\"'/>").positions.len(), "no serifs");
    let right = "<FontStyle justify='\"END\"' leftToRight='true' family='\"TYPEWRITER\"'/>";
    let (low, high) = bounds(&format!("<Text string='\"MiiM\"'>{right}</Text>"));
    assert!(low.x > -2.4 && low.x < -2.3 && high.x < 0.0 && high.x > -0.1, "{low} {high}");
}

#[test]
fn what_has_no_size_is_left_out_with_a_warning() {
    for geometry in [
        "<Box size='1 0 1'/>",
        "<Sphere radius='-1'/>",
        "<Cone height='0'/>",
        "<Cylinder radius='0'/>",
        "<Circle2D radius='0'/>",
        "<Disk2D innerRadius='2'/>",
        "<Rectangle2D size='-1 1'/>",
        "<ElevationGrid/>",
        "<Extrusion spine='0 0 0'/>",
        "<Text string='\"a\"'><FontStyle size='0'/></Text>",
        "<IndexedFaceSet coordIndex='0 1 -1'><Coordinate point='0 0 0 1 0 0'/></IndexedFaceSet>",
    ] {
        let document = parse(&format!("<Scene>\n<Shape>{geometry}</Shape></Scene>")).unwrap();
        assert_eq!(document.at(0.0).objects.len(), 0, "{geometry}");
        let warnings = warnings(&document);
        assert!(warnings.len() == 1 && warnings[0].starts_with("t.x3d:2:"), "{geometry}: {warnings:?}");
    }
}
