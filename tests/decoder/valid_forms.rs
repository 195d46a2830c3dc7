//! Valid forms of every verb, with the commands that they mean.

use fbptr::command::{
    AreaColors, Command, ErrorMode, Figure, FileKind, LightCommand, MeshSource, Quality, RampColor, RealRect,
    Rect, SnapTarget,
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
pub type Forms = Vec<(&'static str, Command)>;

/// Returns the valid forms of every verb.
pub fn valid_forms() -> Forms {
    let groups = [
        memory_verbs(),
        figure_verbs(),
        curve_verbs(),
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

/// Returns the verbs of curves, lines of text and pictures.
fn curve_verbs() -> Forms {
    vec![
        (
            "PRINT 1 -2 #f00  two  words :5 ",
            Command::Figure(Figure::Print { x: 1, y: -2, color: RED, text: " two  words :5 ".into() }),
        ),
        (
            "WIDELINE 1 2 3.5 4 .5 #ff0000",
            Command::Figure(Figure::WideLine { p0: [1.0, 2.0], p1: [3.5, 4.0], width: 0.5, color: RED }),
        ),
        (
            "ELLIPSE 1 2 3.5 4 red",
            Command::Figure(Figure::Ellipse { center: [1.0, 2.0], radii: [3.5, 4.0], color: RED }),
        ),
        (
            "FILLELLIPSE 1 2 3.5 0 #ff0000ff",
            Command::Figure(Figure::FillEllipse { center: [1.0, 2.0], radii: [3.5, 0.0], color: RED }),
        ),
        (
            "ARC 1 2 3 4 -1.5 180deg red",
            Command::Figure(Figure::Arc {
                center: [1.0, 2.0],
                radii: [3.0, 4.0],
                angles: [-1.5, std::f64::consts::PI],
                color: RED,
            }),
        ),
        (
            "BEZIER 1 2 3 4 5 6 7 8 9.5 red",
            Command::Figure(Figure::Bezier {
                points: [[1.0, 2.0], [3.0, 4.0], [5.0, 6.0], [7.0, 8.0]],
                width: 9.5,
                color: RED,
            }),
        ),
        ("HELP line", Command::HelpOn { verb: "line".into() }),
        ("SIZE 64 48", Command::SetSize { w: 64, h: 48 }),
        ("TITLE Step 7 of :24", Command::Title { text: "Step 7 of :24".into() }),
        ("WAIT .5", Command::Wait { seconds: 0.5 }),
        ("CLIP -1 2 3 4", Command::Clip { rect: Some(rect(-1, 2, 3, 4)) }),
        ("CLIP off", Command::Clip { rect: None }),
        ("CANVAS c 3 4", Command::Canvas { name: "c".into(), w: 3, h: 4 }),
        ("TARGET c", Command::Target { name: Some("c".into()) }),
        ("TARGET frame", Command::Target { name: None }),
        ("STAMP c 1 -2", Command::Stamp { name: "c".into(), x: 1, y: -2, key: None }),
        ("STAMP c 1 -2 #f00", Command::Stamp { name: "c".into(), x: 1, y: -2, key: Some(RED) }),
        ("TEXTSIZE 8", Command::TextSize { size: 8 }),
        ("IMAGE 1 -2 :3\nPNG", Command::Image { x: 1, y: -2, file: b"PNG".to_vec() }),
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
        ("QUALITY MAX-ERROR 1.5", Command::Quality(Quality::MaxError(1.5.into()))),
        (
            "QUALITY max-error 4 0.5",
            Command::Quality(Quality::MaxError(fbptr::scene::MaxError { steps: 4.0, shift: 0.5 })),
        ),
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
