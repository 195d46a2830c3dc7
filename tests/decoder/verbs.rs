//! Valid and invalid forms of every verb, as tables.

use crate::recorder::{Event, hear};
use fbptr::command::{
    AreaColors, Command, ErrorMode, Figure, FileKind, LightCommand, MeshSource, Quality, RampColor, RealRect,
    Rect, SnapTarget, Verb,
};
use fbptr::memory::DepthFormat;
use fbptr::scene::{
    Attenuation, Cull, Filter, HiddenSurface, Interpolation, Material, ObliqueKind, Projection, Sampling,
    ShadeMode, ViewportRule, Wrap,
};
use glam::{DMat4, DVec3};

const RED: [u8; 4] = [255, 0, 0, 255];
const GREEN: [u8; 4] = [0, 255, 0, 255];
const BLUE: [u8; 4] = [0, 0, 255, 255];

fn rect(x: i32, y: i32, w: i32, h: i32) -> Rect {
    Rect { x, y, w, h }
}

fn v(x: f64, y: f64, z: f64) -> DVec3 {
    DVec3::new(x, y, z)
}

fn mesh(name: &str, source: MeshSource) -> Command {
    Command::Mesh { name: name.into(), source: Box::new(source) }
}

fn light(index: i32, light: LightCommand) -> Command {
    Command::Light { index, light: Box::new(light) }
}

fn projection(projection: Projection) -> Command {
    Command::Projection(Box::new(projection))
}

fn area(points: [[f64; 2]; 3], colors: AreaColors) -> Command {
    Command::Figure(Figure::Fill { points, colors })
}

/// Valid lines with the commands that they mean.
type Forms = Vec<(&'static str, Command)>;

fn good() -> Forms {
    let groups = [
        memory_verbs(),
        figure_verbs(),
        resource_verbs(),
        camera_verbs(),
        matrix_verbs(),
        light_verbs(),
        surface_verbs(),
        drawing_verbs(),
    ];
    groups.concat()
}

/// Returns the verbs of pixels and bytes.
fn memory_verbs() -> Forms {
    vec![
        ("HELP", Command::Help),
        ("size", Command::Size),
        ("PX 1 -2", Command::GetPixel { x: 1, y: -2 }),
        ("OFFSET -5 +6", Command::Offset { x: -5, y: 6 }),
        ("STATS", Command::Stats),
        ("QUIT", Command::Quit),
        ("POKE 16 00fF7e", Command::Poke { offset: 16, bytes: vec![0, 255, 126] }),
        ("PEEK -1 4", Command::Peek { offset: -1, n: 4 }),
        ("BLIT 1 2 1 1 :4\nabcd", Command::Blit { rect: rect(1, 2, 1, 1), rgba: b"abcd".to_vec() }),
        ("BLIT 1 2 0 7 :0\n", Command::Blit { rect: rect(1, 2, 0, 7), rgba: vec![] }),
        ("READ 1 2 3 4", Command::Read { rect: rect(1, 2, 3, 4) }),
        ("COPY 1 2 3 4 5 6", Command::Copy { source: rect(1, 2, 3, 4), dx: 5, dy: 6 }),
        ("POINTS :8\n\x01\0\x02\0rgba", Command::Points { packed: b"\x01\0\x02\0rgba".to_vec() }),
        ("CRC", Command::Crc { rect: None }),
        ("CRC 1 2 3 4", Command::Crc { rect: Some(rect(1, 2, 3, 4)) }),
        ("CLEAR", Command::Clear { color: [0, 0, 0, 255] }),
        ("CLEAR 01020304", Command::Clear { color: [1, 2, 3, 4] }),
    ]
}

/// Returns the verbs of lines, areas and text.
fn figure_verbs() -> Forms {
    vec![
        (
            "LINE 1 2 3 4 ff0000",
            Command::Figure(Figure::Line {
                p0: [1, 2],
                p1: [3, 4],
                color: RampColor { from: RED, to: None },
            }),
        ),
        (
            "LINE 1 2 3 4 red Lime",
            Command::Figure(Figure::Line {
                p0: [1, 2],
                p1: [3, 4],
                color: RampColor { from: RED, to: Some(GREEN) },
            }),
        ),
        (
            "TRI 1 2 3 4 5 6 red",
            Command::Figure(Figure::Triangle {
                points: [[1, 2], [3, 4], [5, 6]],
                colors: AreaColors::One(RED),
            }),
        ),
        (
            "TRI 1 2 3 4 5 6 red lime blue",
            Command::Figure(Figure::Triangle {
                points: [[1, 2], [3, 4], [5, 6]],
                colors: AreaColors::Three([RED, GREEN, BLUE]),
            }),
        ),
        ("FILL 1 2 3.5 4e0 -5 .6 red", area([[1.0, 2.0], [3.5, 4.0], [-5.0, 0.6]], AreaColors::One(RED))),
        (
            "FILL 1 2 3 4 5 1e9 red lime blue",
            area([[1.0, 2.0], [3.0, 4.0], [5.0, 1e9]], AreaColors::Three([RED, GREEN, BLUE])),
        ),
        ("RECT 1 2 3 4 ff0000ff", Command::Figure(Figure::Rect { rect: rect(1, 2, 3, 4), color: RED })),
        (
            "FILLRECT 1 2 0 4 red",
            Command::Figure(Figure::FillRect { rect: rect(1, 2, 0, 4).into(), color: RED }),
        ),
        (
            "FILLRECT -1.5 .25 1e3 4 red",
            Command::Figure(Figure::FillRect {
                rect: RealRect { x: -1.5, y: 0.25, w: 1e3, h: 4.0 },
                color: RED,
            }),
        ),
        (
            "CIRCLE 1 2 3 80",
            Command::Figure(Figure::Circle { cx: 1, cy: 2, r: 3, color: [128, 128, 128, 255] }),
        ),
        (
            "FILLCIRCLE 1.5 2 3 red",
            Command::Figure(Figure::FillCircle { cx: 1.5, cy: 2.0, r: 3.0, color: RED }),
        ),
        ("POLY red 1 2", Command::Figure(Figure::Poly { color: RED, points: vec![[1, 2]] })),
        (
            "POLY red 1 2 3 4 5 6",
            Command::Figure(Figure::Poly { color: RED, points: vec![[1, 2], [3, 4], [5, 6]] }),
        ),
        (
            "FILLPOLY red 1 2.5 3 4",
            Command::Figure(Figure::FillPoly { color: RED, points: vec![[1.0, 2.5], [3.0, 4.0]] }),
        ),
        (
            "TEXT 1 2 red :2\n\u{e9}",
            Command::Figure(Figure::Text { x: 1, y: 2, color: RED, utf8: "\u{e9}".into() }),
        ),
        (
            "LINEAA 1 2 3.5 4 red",
            Command::Figure(Figure::LineAa { p0: [1.0, 2.0], p1: [3.5, 4.0], color: RED }),
        ),
        ("BLEND over", Command::Blend { over: true }),
        ("BLEND REPLACE", Command::Blend { over: false }),
    ]
}

/// Returns the verbs of meshes, textures and files.
fn resource_verbs() -> Forms {
    vec![
        ("MESH a OBJ :3\nv 1", mesh("a", MeshSource::Obj(b"v 1".to_vec()))),
        ("MESH @a box", mesh("@a", MeshSource::Box(v(2.0, 2.0, 2.0)))),
        ("MESH a BOX 1 2 3", mesh("a", MeshSource::Box(v(1.0, 2.0, 3.0)))),
        ("MESH a SPHERE", mesh("a", MeshSource::Sphere(1.0))),
        ("MESH a SPHERE .5", mesh("a", MeshSource::Sphere(0.5))),
        ("MESH a CONE", mesh("a", MeshSource::Cone(1.0, 2.0))),
        ("MESH a CONE 3 4", mesh("a", MeshSource::Cone(3.0, 4.0))),
        ("MESH a CYLINDER", mesh("a", MeshSource::Cylinder(1.0, 2.0))),
        ("MESH a CYLINDER 3 4", mesh("a", MeshSource::Cylinder(3.0, 4.0))),
        ("MESH a TEAPOT", mesh("a", MeshSource::Teapot(10))),
        ("MESH a TEAPOT 3", mesh("a", MeshSource::Teapot(3))),
        ("MESH a KNOT 30 7", mesh("a", MeshSource::Knot(30, 7))),
        ("TEX t :3\nPNG", Command::Texture { name: "t".into(), file: b"PNG".to_vec() }),
        ("SCENE x3d :4\n<X/>", Command::Scene { x3d: b"<X/>".to_vec() }),
        ("EYE e :2\n{}", Command::Eye { name: "e".into(), json: b"{}".to_vec() }),
        ("FREE @a", Command::Free { name: "@a".into() }),
        ("LOAD mesh a b.obj", Command::Load { kind: FileKind::Mesh, name: "a".into(), path: "b.obj".into() }),
        (
            "LOAD TEX a b.png",
            Command::Load { kind: FileKind::Texture, name: "a".into(), path: "b.png".into() },
        ),
        (
            "LOAD SCENE b.x3d",
            Command::Load { kind: FileKind::Scene, name: String::new(), path: "b.x3d".into() },
        ),
    ]
}

/// Returns the verbs of the view.
fn camera_verbs() -> Forms {
    let window = [-1.0, 1.0, -2.0, 2.0];
    let (near, far) = (0.5, 100.0);
    vec![
        (
            "LOOKAT 1 2 3 4 5 6 7 8 9",
            Command::LookAt { eye: v(1.0, 2.0, 3.0), reference: v(4.0, 5.0, 6.0), up: v(7.0, 8.0, 9.0) },
        ),
        (
            "PERSPECTIVE 1 .5 100",
            projection(Projection::Perspective { fov_rad: 1.0, near, far, on_smaller_side: false }),
        ),
        (
            "PERSPECTIVE 1 .5 100 fovmin",
            projection(Projection::Perspective { fov_rad: 1.0, near, far, on_smaller_side: true }),
        ),
        ("PLANE 2 .5 100", projection(Projection::Plane { d: 2.0, near, far })),
        ("FRUSTUM -1 1 -2 2 .5 100", projection(Projection::Frustum { window, near, far })),
        ("ORTHO -1 1 -2 2 .5 100", projection(Projection::Ortho { window, near, far })),
        (
            "OBLIQUE cavalier 1 -1 1 -2 2 .5 100",
            projection(Projection::Oblique {
                kind: ObliqueKind::Cavalier,
                angle_rad: 1.0,
                window,
                near,
                far,
            }),
        ),
        (
            "OBLIQUE CABINET 1 -1 1 -2 2 .5 100",
            projection(Projection::Oblique { kind: ObliqueKind::Cabinet, angle_rad: 1.0, window, near, far }),
        ),
        ("ISOMETRIC -1 1 -2 2 .5 100", projection(Projection::Isometric { window, near, far })),
        ("PSEUDOISO -1 1 -2 2 .5 100", projection(Projection::PseudoIsometric { window, near, far })),
        (
            "WINDOW 1 2 3 4 5 6 7 8 9 10 11 12 13 14 .5 100",
            projection(Projection::Window {
                vrp: v(1.0, 2.0, 3.0),
                p: v(4.0, 5.0, 6.0),
                vup: v(7.0, 8.0, 9.0),
                center: [10.0, 11.0],
                half: [12.0, 13.0],
                dp: 14.0,
                near,
                far,
            }),
        ),
        ("VIEWPORT -1 2 3 4", Command::Viewport { rect: rect(-1, 2, 3, 4), rule: ViewportRule::Corners }),
        (
            "VIEWPORT 1 2 3 4 centres",
            Command::Viewport { rect: rect(1, 2, 3, 4), rule: ViewportRule::Centres },
        ),
        (
            "VIEWPORT 1 2 3 4 CORNERS",
            Command::Viewport { rect: rect(1, 2, 3, 4), rule: ViewportRule::Corners },
        ),
    ]
}

/// Returns the verbs of the model matrix, and the ambient light.
fn matrix_verbs() -> Forms {
    vec![
        ("IDENTITY", Command::Identity),
        ("PUSH", Command::Push),
        ("POP", Command::Pop),
        ("TRANSLATE 1 2 3", Command::Translate(v(1.0, 2.0, 3.0))),
        ("ROTATE 1 2 3 4", Command::Rotate { axis: v(1.0, 2.0, 3.0), angle_rad: 4.0 }),
        ("SCALE 1 -2 3", Command::Scale(v(1.0, -2.0, 3.0))),
        ("SHEAR 1 2 3 4 5 6", Command::Shear(Box::new([1.0, 2.0, 3.0, 4.0, 5.0, 6.0]))),
        (
            "MATRIX 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16",
            // By columns: the third one holds each row's third number.
            Command::Matrix(Box::new(DMat4::from_cols_array(&[
                1.0, 5.0, 9.0, 13.0, 2.0, 6.0, 10.0, 14.0, 3.0, 7.0, 11.0, 15.0, 4.0, 8.0, 12.0, 16.0,
            ]))),
        ),
        ("AMBIENT .1 .2 2", Command::Ambient(v(0.1, 0.2, 2.0))),
    ]
}

/// Returns the forms of LIGHT.
fn light_verbs() -> Forms {
    vec![
        (
            "LIGHT 0 POINT 1 2 3 4 5 6",
            light(
                0,
                LightCommand::Point {
                    position: v(1.0, 2.0, 3.0),
                    color: v(4.0, 5.0, 6.0),
                    attenuation: Attenuation::NONE,
                },
            ),
        ),
        (
            "LIGHT 1 point 1 2 3 4 5 6 7 8 9",
            light(
                1,
                LightCommand::Point {
                    position: v(1.0, 2.0, 3.0),
                    color: v(4.0, 5.0, 6.0),
                    attenuation: Attenuation { c: 7.0, l: 8.0, q: 9.0 },
                },
            ),
        ),
        (
            "LIGHT 2 DIR 1 2 3 4 5 6",
            light(2, LightCommand::Dir { direction: v(1.0, 2.0, 3.0), color: v(4.0, 5.0, 6.0) }),
        ),
        (
            "LIGHT 3 SPOT 1 2 3 4 5 6 .5 8 9 10 11",
            light(
                3,
                LightCommand::Spot {
                    position: v(1.0, 2.0, 3.0),
                    direction: v(4.0, 5.0, 6.0),
                    angle_rad: 0.5,
                    exponent: 8.0,
                    color: v(9.0, 10.0, 11.0),
                    attenuation: Attenuation::NONE,
                },
            ),
        ),
        (
            "LIGHT 3 SPOT 1 2 3 4 5 6 .5 8 9 10 11 12 13 14",
            light(
                3,
                LightCommand::Spot {
                    position: v(1.0, 2.0, 3.0),
                    direction: v(4.0, 5.0, 6.0),
                    angle_rad: 0.5,
                    exponent: 8.0,
                    color: v(9.0, 10.0, 11.0),
                    attenuation: Attenuation { c: 12.0, l: 13.0, q: 14.0 },
                },
            ),
        ),
        ("LIGHT 4 OFF", light(4, LightCommand::Off)),
    ]
}

/// Returns the verbs of materials, textures and modes.
fn surface_verbs() -> Forms {
    let sampling = |filter, wrap| Sampling { filter, wrap_s: wrap, wrap_t: wrap };
    vec![
        (
            "MATERIAL 1 2 3 4 5 6 7 8 9 10",
            Command::Material(Box::new(Material {
                ka: v(1.0, 2.0, 3.0),
                kd: v(4.0, 5.0, 6.0),
                ks: v(7.0, 8.0, 9.0),
                n: 10.0,
                ..Material::default()
            })),
        ),
        (
            "MATERIAL 1 2 3 4 5 6 7 8 9 10 11 12 13 .5",
            Command::Material(Box::new(Material {
                ka: v(1.0, 2.0, 3.0),
                kd: v(4.0, 5.0, 6.0),
                ks: v(7.0, 8.0, 9.0),
                n: 10.0,
                emissive: v(11.0, 12.0, 13.0),
                transparency: 0.5,
                ..Material::default()
            })),
        ),
        ("TEXTURE t", Command::UseTexture { name: Some("t".into()), sampling: Sampling::default() }),
        (
            "TEXTURE t Trilinear clamp",
            Command::UseTexture {
                name: Some("t".into()),
                sampling: sampling(Filter::Trilinear, Wrap::Clamp),
            },
        ),
        (
            "TEXTURE t clamp",
            Command::UseTexture { name: Some("t".into()), sampling: sampling(Filter::Bilinear, Wrap::Clamp) },
        ),
        ("TEXTURE off", Command::UseTexture { name: None, sampling: Sampling::default() }),
        ("SHADE flat", Command::Shade(ShadeMode::Flat)),
        ("CULL Front", Command::Cull(Cull::Front)),
        ("HIDE painter", Command::Hide(HiddenSurface::Painter)),
        ("DEPTH U24", Command::Depth(DepthFormat::U24)),
        ("INTERP affine", Command::Interp(Interpolation::Affine)),
    ]
}

/// Returns the verbs of drawing, queries and settings.
fn drawing_verbs() -> Forms {
    vec![
        ("DRAW a", Command::Draw { name: "a".into() }),
        ("DRAWSCENE", Command::DrawScene { time: 0.0, sorted: false }),
        ("DRAWSCENE 1.5", Command::DrawScene { time: 1.5, sorted: false }),
        ("DRAWSCENE sorted", Command::DrawScene { time: 0.0, sorted: true }),
        ("DRAWSCENE 1.5 SORTED", Command::DrawScene { time: 1.5, sorted: true }),
        ("DRAWEYE e 1 2 3 4", Command::DrawEye { name: "e".into(), rect: rect(1, 2, 3, 4) }),
        ("QUALITY exact", Command::Quality(Quality::Exact)),
        ("QUALITY MAX-ERROR 1.5", Command::Quality(Quality::MaxError(1.5))),
        ("DEPTHAT 1 2", Command::DepthAt { x: 1, y: 2 }),
        ("PICK 1 2", Command::Pick { x: 1, y: 2 }),
        ("SYNC t-1", Command::Sync { tag: "t-1".into() }),
        ("HELLO", Command::Hello),
        ("VERSION", Command::Version),
        ("AUTO on", Command::Auto(true)),
        ("AUTO OFF", Command::Auto(false)),
        ("PRESENT", Command::Present { wait: false }),
        ("PRESENT wait", Command::Present { wait: true }),
        ("EVENTS on", Command::Events(true)),
        ("ERRORS count", Command::Errors(ErrorMode::Count)),
        ("ERRORS report", Command::Errors(ErrorMode::Report)),
        ("ERRORS close", Command::Errors(ErrorMode::Close)),
        ("SNAP a.png", Command::Snap(SnapTarget::File("a.png".into()))),
        ("SNAP :", Command::Snap(SnapTarget::Connection)),
    ]
}

/// Invalid commands, each with its error code and the token that the error names.
const BAD: &[(&str, &str, &str)] = &[
    ("NONSENSE", "EVERB", "NONSENSE"),
    ("PXX 1 2 ff", "EVERB", "PXX"),
    ("HELP me", "EARGS", "me"),
    ("SIZE 1", "EARGS", "1"),
    ("PX", "EARGS", "PX"),
    ("PX 1", "EARGS", "1"),
    ("PX 1 2 ff x", "EARGS", "x"),
    ("PX 1.0 2 ff", "ENUM", "1.0"),
    ("PX 1 2147483648 ff", "ENUM", "2147483648"),
    ("PX 1e1 2 ff", "ENUM", "1e1"),
    ("PX -- 2 ff", "ENUM", "--"),
    ("PX 1 2 0", "ECOLOUR", "0"),
    ("PX 1 2 fff", "ECOLOUR", "fff"),
    ("PX 1 2 ff00zz", "ECOLOUR", "ff00zz"),
    ("PX 1 2 #ff0000", "ECOLOUR", "#ff0000"),
    ("PX 1 2 bluish", "ECOLOUR", "bluish"),
    ("PX 1 2 :3\nabc", "EARGS", ":3"),
    ("OFFSET 1", "EARGS", "1"),
    ("OFFSET 1 x", "ENUM", "x"),
    ("STATS x", "EARGS", "x"),
    ("QUIT now", "EARGS", "now"),
    ("POKE 0", "EARGS", "0"),
    ("POKE x 00", "ENUM", "x"),
    ("POKE 0 000", "EFORMAT", "000"),
    ("POKE 0 0g", "EFORMAT", "0g"),
    ("POKE 4294967296 00", "ENUM", "4294967296"),
    ("PEEK 0", "EARGS", "0"),
    ("PEEK 0 -1", "ERANGE", "-1"),
    ("BLIT 0 0 1 1", "EARGS", "1"),
    ("BLIT 0 0 1 1 :5\n12345", "EFORMAT", ":5"),
    ("BLIT 0 0 1 1 :0\n", "EFORMAT", ":0"),
    ("BLIT 0 0 2147483647 2147483647 :4\nabcd", "EFORMAT", ":4"),
    ("BLIT 0 0 -1 1 :4\nabcd", "ERANGE", "-1"),
    ("BLIT 0 0 1 -1 :4\nabcd", "ERANGE", "-1"),
    ("READ 0 0 1", "EARGS", "1"),
    ("READ 0 0 -1 1", "ERANGE", "-1"),
    ("COPY 0 0 1 1 0", "EARGS", "0"),
    ("COPY 0 0 1 -5 0 0", "ERANGE", "-5"),
    ("POINTS", "EARGS", "POINTS"),
    ("POINTS :9\n123456789", "EFORMAT", ":9"),
    ("CRC 1", "EARGS", "1"),
    ("CRC 0 0 1 1 1", "EARGS", "1"),
    ("CRC 0 0 -1 1", "ERANGE", "-1"),
    ("CLEAR red blue", "EARGS", "blue"),
    ("CLEAR 0", "ECOLOUR", "0"),
    ("LINE 1 2 3 4", "EARGS", "4"),
    ("LINE 1 2 3 4 red red red", "EARGS", "red"),
    ("LINE 1 2 3 4.5 red", "ENUM", "4.5"),
    ("LINE 1 2 3 4 red read", "ECOLOUR", "read"),
    ("TRI 1 2 3 4 5 6 red red", "EARGS", "red"),
    ("TRI 1 2 3 4 5 x red", "ENUM", "x"),
    ("FILL 1 2 3 4 5 nan red", "ENUM", "nan"),
    ("FILL 1 2 3 4 5 1e999 red", "ENUM", "1e999"),
    ("FILL 1 2 3 4 5 6 red red x", "ECOLOUR", "x"),
    ("RECT 1 2 -3 4 red", "ERANGE", "-3"),
    ("RECT 1 2 3 4", "EARGS", "4"),
    ("FILLRECT 1 2 3 -4 red", "ERANGE", "-4"),
    ("FILLRECT 1 2 3 4 5", "ECOLOUR", "5"),
    ("CIRCLE 1 2 -3 red", "ERANGE", "-3"),
    ("CIRCLE 1 2 3.5 red", "ENUM", "3.5"),
    ("FILLCIRCLE 1 2 -.5 red", "ERANGE", "-0.5"),
    ("FILLCIRCLE 1 2 inf red", "ENUM", "inf"),
    ("POLY red", "EARGS", "red"),
    ("POLY red 1", "EARGS", "1"),
    ("POLY red 1 2 3", "EARGS", "3"),
    ("POLY 1 2 3", "ECOLOUR", "1"),
    ("POLY red 1 2 3 4.0", "ENUM", "4.0"),
    ("FILLPOLY red 1 2 3", "EARGS", "3"),
    ("FILLPOLY red 1 x", "ENUM", "x"),
    ("TEXT 1 2 red", "EARGS", "red"),
    ("TEXT 1 2 :2\nab", "EARGS", "2"),
    ("TEXT 1 2 red :2\na\u{e9}", "EFORMAT", "c3"),
    ("LINEAA 1 2 3 4 red red", "EARGS", "red"),
    ("LINEAA 1 2 3 e red", "ENUM", "e"),
    ("BLEND under", "EARGS", "under"),
    ("MESH a", "EARGS", "a"),
    ("MESH a PYRAMID", "EARGS", "PYRAMID"),
    ("MESH a OBJ", "EARGS", "OBJ"),
    ("MESH a OBJ x :1\nv", "EARGS", "x"),
    ("MESH a BOX :1\nv", "EARGS", ":1"),
    ("MESH a BOX 1 2", "EARGS", "2"),
    ("MESH a BOX 1 2 3 4", "EARGS", "4"),
    ("MESH a BOX 1 2 -3", "ERANGE", "-3"),
    ("MESH a SPHERE x", "ENUM", "x"),
    ("MESH a SPHERE -1", "ERANGE", "-1"),
    ("MESH a CONE 1", "EARGS", "1"),
    ("MESH a CYLINDER 1 -2", "ERANGE", "-2"),
    ("MESH a TEAPOT 1.5", "ENUM", "1.5"),
    ("MESH a TEAPOT -1", "ERANGE", "-1"),
    ("MESH a KNOT 5", "EARGS", "5"),
    ("MESH a KNOT 5 -5", "ERANGE", "-5"),
    ("MESH :a BOX", "EARGS", ":a"),
    ("TEX t", "EARGS", "t"),
    ("TEX :2\nab", "EARGS", "TEX"),
    ("SCENE VRML :1\nx", "EARGS", "VRML"),
    ("SCENE X3D", "EARGS", "X3D"),
    ("EYE e", "EARGS", "e"),
    ("EYE e\u{7f} :2\n{}", "EARGS", "e\u{7f}"),
    ("FREE", "EARGS", "FREE"),
    ("FREE a b", "EARGS", "b"),
    ("LOAD SOUND a b", "EARGS", "SOUND"),
    ("LOAD MESH a", "EARGS", "a"),
    ("LOAD SCENE a b", "EARGS", "b"),
    ("LOOKAT 1 2 3 4 5 6 7 8", "EARGS", "8"),
    ("LOOKAT 1 2 3 4 5 6 7 8 nan", "ENUM", "nan"),
    ("PERSPECTIVE 1 2", "EARGS", "2"),
    ("PERSPECTIVE 1 2 3 wide", "EARGS", "wide"),
    ("PLANE 1 2 x", "ENUM", "x"),
    ("FRUSTUM 1 2 3 4 5", "EARGS", "5"),
    ("ORTHO 1 2 3 4 5 infinity", "ENUM", "infinity"),
    ("OBLIQUE military 1 2 3 4 5 6 7", "EARGS", "military"),
    ("OBLIQUE cabinet 1 2 3 4 5 6", "EARGS", "6"),
    ("ISOMETRIC 1 2 3 4 5", "EARGS", "5"),
    ("PSEUDOISO 1 2 3 4 5 0x6", "ENUM", "0x6"),
    ("WINDOW 1 2 3", "EARGS", "3"),
    ("WINDOW 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 x", "ENUM", "x"),
    ("VIEWPORT 1 2 3", "EARGS", "3"),
    ("VIEWPORT 1 2 3 -4", "ERANGE", "-4"),
    ("VIEWPORT 1 2 3 4 edges", "EARGS", "edges"),
    ("IDENTITY 1", "EARGS", "1"),
    ("PUSH 1", "EARGS", "1"),
    ("POP 1", "EARGS", "1"),
    ("TRANSLATE 1 2", "EARGS", "2"),
    ("TRANSLATE 1 2 1e400", "ENUM", "1e400"),
    ("ROTATE 1 2 3", "EARGS", "3"),
    ("SCALE 1", "EARGS", "1"),
    ("SHEAR 1 2 3 4 5", "EARGS", "5"),
    ("MATRIX 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15", "EARGS", "15"),
    ("MATRIX 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 -", "ENUM", "-"),
    ("AMBIENT 1 1", "EARGS", "1"),
    ("LIGHT 1", "EARGS", "1"),
    ("LIGHT x OFF", "ENUM", "x"),
    ("LIGHT -1 OFF", "ERANGE", "-1"),
    ("LIGHT 1 AREA 1", "EARGS", "AREA"),
    ("LIGHT 1 OFF 1", "EARGS", "1"),
    ("LIGHT 1 POINT 1 2 3 4 5", "EARGS", "5"),
    ("LIGHT 1 POINT 1 2 3 4 5 6 7 8", "EARGS", "8"),
    ("LIGHT 1 DIR 1 2 3 4 5 6 7", "EARGS", "7"),
    ("LIGHT 1 DIR 1 2 3 4 5 x", "ENUM", "x"),
    ("LIGHT 1 SPOT 1 2 3 4 5 6 7 8 9 10", "EARGS", "10"),
    ("MATERIAL 1 2 3 4 5 6 7 8 9", "EARGS", "9"),
    ("MATERIAL 1 2 3 4 5 6 7 8 9 10 11 12", "EARGS", "12"),
    ("MATERIAL 1 2 3 4 5 6 7 8 9 x", "ENUM", "x"),
    ("TEXTURE", "EARGS", "TEXTURE"),
    ("TEXTURE t clamp nearest", "EARGS", "nearest"),
    ("TEXTURE t smooth", "EARGS", "smooth"),
    ("SHADE toon", "EARGS", "toon"),
    ("CULL both", "EARGS", "both"),
    ("HIDE bsp", "EARGS", "bsp"),
    ("DEPTH u8", "EARGS", "u8"),
    ("INTERP linear", "EARGS", "linear"),
    ("DRAW", "EARGS", "DRAW"),
    ("DRAWSCENE x", "ENUM", "x"),
    ("DRAWSCENE 1 x", "EARGS", "x"),
    ("DRAWSCENE SORTED 1", "EARGS", "1"),
    ("DRAWEYE e 1 2 3", "EARGS", "3"),
    ("DRAWEYE e 1 2 -3 4", "ERANGE", "-3"),
    ("QUALITY", "EARGS", "QUALITY"),
    ("QUALITY good", "EARGS", "good"),
    ("QUALITY exact 1", "EARGS", "1"),
    ("QUALITY max-error", "EARGS", "max-error"),
    ("QUALITY max-error -1", "ERANGE", "-1"),
    ("QUALITY max-error x", "ENUM", "x"),
    ("DEPTHAT 1", "EARGS", "1"),
    ("DEPTHAT 1 x", "ENUM", "x"),
    ("PICK 1 2 3", "EARGS", "3"),
    ("SYNC", "EARGS", "SYNC"),
    ("SYNC a b", "EARGS", "b"),
    ("HELLO x", "EARGS", "x"),
    ("VERSION 1", "EARGS", "1"),
    ("AUTO", "EARGS", "AUTO"),
    ("AUTO maybe", "EARGS", "maybe"),
    ("PRESENT now", "EARGS", "now"),
    ("EVENTS 1", "EARGS", "1"),
    ("ERRORS ignore", "EARGS", "ignore"),
    ("SNAP", "EARGS", "SNAP"),
];

#[test]
fn every_verb_is_read_as_written() {
    for (text, command) in good() {
        // The stream is in step before and after the command.
        let heard = hear(
            format!("PX 7 7 07\n{text}{}SYNC after\n", if text.contains('\n') { "" } else { "\n" })
                .as_bytes(),
        );
        assert_eq!(heard.len(), 3, "{text}: {heard:?}");
        let Event::Command(heard, place) = &heard[1] else { panic!("{text}: {:?}", heard[1]) };
        assert_eq!((heard, place.line, place.byte), (&command, 2, 10), "{text}");
    }
}

#[test]
fn every_refusal_has_its_code_and_token_and_does_nothing() {
    for &(text, code, token) in BAD {
        let heard = hear(
            format!("PX 7 7 07\n{text}{}SYNC after\n", if text.contains('\n') { "" } else { "\n" })
                .as_bytes(),
        );
        assert_eq!(heard.len(), 3, "{text}: {heard:?}");
        let Event::Error(error) = &heard[1] else { panic!("{text}: {:?}", heard[1]) };
        assert_eq!(
            (error.code.as_str(), String::from_utf8_lossy(&error.token).as_ref()),
            (code, token),
            "{text}"
        );
        assert_eq!((error.place.line, error.place.byte, error.closes), (2, 10, false));
        let verb = text.split([' ', '\n']).next().unwrap();
        assert_eq!(error.subject.name(), verb);
        assert_eq!(error.is_unknown_verb(), code == "EVERB");
        assert!(error.wire_line().starts_with(&format!("ERR 2 10 {code} {verb}: ")), "{}", error.wire_line());
        assert!(
            error.play_line("f").starts_with(&format!("f:2: {code} {verb}: ")),
            "{}",
            error.play_line("f")
        );
    }
}

#[test]
fn the_tables_of_this_test_have_every_text_verb() {
    let good = good();
    for verb in Verb::all().iter().filter(|v| !["PB", "PXMULTI"].contains(&v.name)) {
        let of =
            |text: &str| text.split([' ', '\n']).next().is_some_and(|w| w.eq_ignore_ascii_case(verb.name));
        assert!(
            verb.name == "PX" || good.iter().any(|g| of(g.0) && g.1.verb() == verb.name),
            "{}",
            verb.name
        );
        assert!(BAD.iter().any(|b| of(b.0)), "{}", verb.name);
    }
}

#[test]
fn names_that_are_not_text_are_refused() {
    for bytes in [&b"DRAW \xff\n"[..], b"SYNC a\x01b\n", b"FREE a\r\r\n"] {
        let [Event::Error(error)] = &hear(bytes)[..] else { panic!("{bytes:?}") };
        assert_eq!(error.code.as_str(), "EARGS");
    }
}

#[test]
fn a_pixel_takes_its_colour_in_any_form_and_its_verb_in_either_case() {
    for (text, event) in [
        ("PX 1 2 ff0000", Event::Pixel(1, 2, RED)),
        ("px 1 2 FF0000", Event::Pixel(1, 2, RED)),
        ("Px +1 -2 red", Event::Pixel(1, -2, RED)),
        ("PX 0001 2 11223344", Event::Pixel(1, 2, [0x11, 0x22, 0x33, 0x44])),
        ("PX -2147483648 2147483647 7f", Event::Pixel(i32::MIN, i32::MAX, [127, 127, 127, 255])),
        ("PX 1 2 transparent", Event::Pixel(1, 2, [0; 4])),
    ] {
        assert_eq!(hear(format!("{text}\n").as_bytes()), [event], "{text}");
    }
}
