//! The verb table: every verb of the language, said once. The enum of commands, the decoder, the
//! encoder, the checks, the error messages, HELP, the protocol page, the Python client's methods
//! and the fuzzer's dictionary are made from it.
//!
//! The rows' syntax is explained in [`super::verb_macros`], the kinds of arguments in
//! [`super::arguments`]; `CONTRIBUTING.md` adds a verb, step by step.
//!
//! In forms, words in lower case stand for arguments, `[...]` is optional, `a|b` is a choice, `:N`
//! announces N payload bytes after the line. Pixelflut's own verbs come first: clients that probe
//! read no further.

use super::args::{Args, ParseError};
use super::arguments::*;
use super::codec::{Codec, Parse};
use super::commands::{ErrorMode, FileKind, LightCommand, MeshSource, Quality, Shears, SnapTarget};
use super::encode::{EncodeError, LineWriter};
use super::figure::{DrawFigure, Drawn, Lend};
use super::plain_line::{PlainWords, ReadPlain};
use super::verb::{Arity, Encoding, Form, Group, Payload, Reach, Reply, Verb};
use super::verb_macros::*;
use fbptr_core::draw2d::{AreaColors, DrawError, FigureTarget, RampColor, RealRect, Rect};
use fbptr_core::error::Fault;
use fbptr_core::memory::{DepthFormat, Rgba};
use fbptr_core::scene::{
    Cull, HiddenSurface, Interpolation, Material, ObliqueKind, Projection, Sampling, ShadeMode, ViewportRule,
};
use glam::{DMat4, DVec3};

/// Gives all rows of the table to a macro: `verbs! { language }` defines the language by them, and
/// the engine makes its dispatch of them.
#[doc(hidden)]
#[macro_export]
macro_rules! verbs { ($with:ident $($more:tt)*) => { $with! { $($more)*
nested [Figure(Figure) = fn figure, Projection(Box<Projection>) = fn set_projection];

Pixelflut Text Command {
    HELP Help = fn help
        | HelpOn { verb: String } = fn help_on -> Lines: [
        "HELP": "lists the verbs",
        "HELP verb": "describes one of them, with an example",
    ] eg "HELP LINE";
    SIZE Size = fn size
        | SetSize { w: i32 = Side, h: i32 = Side } = fn set_size -> ByForm: [
        "SIZE": "answers SIZE width height",
        "SIZE w h": "sets the frame's size, as the first command of a file that is played",
    ] eg "SIZE";
    PX Pixel { x: i32, y: i32, color: Rgba } = fn moved_pixel
        | GetPixel { x: i32, y: i32 } = fn asked_pixel -> ByForm in clip: [
        "PX x y rrggbb": "sets a pixel to a colour in hex, moved by OFFSET",
        "PX x y rrggbbaa": "sets a pixel and its alpha; under BLEND over it is composed",
        "PX x y gg": "sets a pixel to a grey in hex",
        "PX x y name": "sets a pixel to a CSS colour; names stand wherever a colour does",
        "PX x y": "answers PX x y rrggbb",
    ] eg "PX 8 6 ff8000";
}
Pixelflut Binary Command {
    PB BinaryPixel { x: u16, y: u16, color: Rgba = RawColor } = fn binary_pixel in clip: [
        "PBxxyyrgba": "sets a pixel in ten bytes: PB, x and y as u16 little-endian, r, g, b, a; no newline",
    ] eg "PB\x08\0\x06\0\x7f\0\0\x7f";
    PXMULTI PixelRun { x: u16, y: u16, rgba: Vec<u8> = Run } = fn pixel_run in clip: [
        "PXMULTIxxyynnnn": "then nnnn (u32) times rgba: a run of pixels from (x,y) on, wrapping at row ends",
    ] eg "PXMULTI\x08\0\x06\0\x01\0\0\0\x7f\0\0\x7f";
}
Pixelflut Text Command {
    OFFSET Offset { x: i32, y: i32 } = fn set_offset:
        "moves all later text PX of this connection; replaces the last" eg "OFFSET 100 50";
    STATS Stats = fn stats -> Line: "answers one line of key=value" eg "STATS";
    QUIT Quit = fn quit: "ends the connection" eg "QUIT";
}

Memory Text Command {
    POKE Poke { offset: i32, bytes["hexbytes"]: Vec<u8> = HexBytes } = fn poke in target:
        "writes bytes; offset = (width*y + x)*4, bytes R G B A" eg "POKE 16 ff8000ff";
    PEEK Peek { offset: i32, n: i32 = ByteCount } = fn peek -> Line in target: "answers PEEK offset hexbytes"
        eg "PEEK 16 4";
    BLIT Blit { rect["x y w h"]: Rect, rgba[":N"]: Vec<u8> = Bytes } = fn blit with check_length = blit_length in clip:
        "draws a rectangle of RGBA rows, N = w*h*4 bytes" eg "BLIT 8 6 1 1 :4\nRGBA";
    READ Read { rect["x y w h"]: Rect } = fn read -> Bytes in target: "answers READ x y w h :N and the RGBA rows"
        eg "READ 8 6 2 1";
    COPY Copy { source["sx sy w h"]: Rect, dx: i32, dy: i32 } = fn copy in clip:
        "copies a rectangle, as through a temporary copy" eg "COPY 0 0 16 16 20 10";
    POINTS Points { packed[":N"]: Vec<u8> = Records } = fn points in clip:
        "draws packed pixels, 8 bytes each: x and y as u16 little-endian, r, g, b, a"
        eg "POINTS :8\n\x08\0\x06\0\x7f\0\0\x7f";
    CRC Crc { rect["[x y w h]"]: Option<Rect> } = fn crc -> Line in target:
        "answers CRC xxxxxxxx, the CRC-32 of the RGBA bytes" eg "CRC 0 0 16 16";
    CLEAR Clear { color["[colour]"]: Rgba = ClearColor } = fn clear in clip:
        "fills the frame (default 000000ff) and clears the depth" eg "CLEAR 204060";
}

TwoD Text Figure {
    LINE Line { p0["x0 y0"]: [i32; 2], p1["x1 y1"]: [i32; 2], color["c0 [c1]"]: RampColor } = fn line in clip:
        "draws a line, both ends lit; with c1 the colour runs from c0 to c1" eg "LINE 0 0 63 47 red yellow";
    TRI Triangle { points["x0 y0 x1 y1 x2 y2"]: [[i32; 2]; 3], colors["c0 [c1 c2]"]: AreaColors } = fn triangle in clip:
        "draws a triangle's three lines" eg "TRI 8 6 40 10 20 40 white";
    FILL Fill { points["x0 y0 x1 y1 x2 y2"]: [[f64; 2]; 3], colors["c0 [c1 c2]"]: AreaColors } = fn fill in clip:
        "fills a triangle, colours interpolated; reals" eg "FILL 8.5 6 40 10 20 40 red lime blue";
    RECT Rect { rect["x y w h"]: Rect, color["c"]: Rgba } = fn rect in clip: "draws the border of a rectangle"
        eg "RECT 8 6 40 30 white";
    FILLRECT FillRect { rect["x y w h"]: RealRect, color["c"]: Rgba } = fn fill_rect in clip:
        "fills the pixels with centres in [x,x+w) x [y,y+h); reals" eg "FILLRECT 8.5 6 40 30.25 white";
    CIRCLE Circle { cx: i32, cy: i32, r: i32 = Radius, color["c"]: Rgba } = fn circle in clip:
        "draws a circle about a pixel" eg "CIRCLE 32 24 20 white";
    FILLCIRCLE FillCircle { cx: f64, cy: f64, r: f64 = RealRadius, color["c"]: Rgba } = fn fill_circle in clip:
        "fills the pixel centres nearer than r to a point; reals" eg "FILLCIRCLE 32.5 24 19.5 ff800080";
    POLY Poly { color["c"]: Rgba, points["x0 y0 [x1 y1 ...]"]: Vec<[i32; 2]> } = fn poly in clip:
        "draws a closed outline" eg "POLY white 8 6 40 10 20 40";
    FILLPOLY FillPoly { color["c"]: Rgba, points["x0 y0 [x1 y1 ...]"]: Vec<[f64; 2]> } = fn fill_poly in clip:
        "fills a polygon, even-odd; reals" eg "FILLPOLY white 8.5 6 40 10 20 40";
    TEXT Text { x: i32, y: i32, color["c"]: Rgba, utf8[":N"]: Vec<u8> = Utf8 } = fn text in clip:
        "writes N bytes of UTF-8 in 8x8 letters from the upper left corner (x,y)"
        eg "TEXT 2 2 white :5\nhello";
    PRINT Print { x: i32, y: i32, color["c"]: Rgba, text["text ..."]: String = RestOfLine } = fn print in clip:
        "writes the rest of the line as TEXT does; no :N is read in it" eg "PRINT 2 2 white hello, world";
    WIDELINE WideLine {
        p0["x0 y0"]: [f64; 2], p1["x1 y1"]: [f64; 2], width["w"]: f64 = LineWidth, color["c"]: Rgba,
    } = fn wide_line in clip: "draws a line w wide with round ends: the pixel centres nearer than w/2; reals"
        eg "WIDELINE 8.5 40 50 8 6.5 gold";
    ELLIPSE Ellipse { center["cx cy"]: [f64; 2], radii["rx ry"]: [f64; 2] = Radii, color["c"]: Rgba } = fn ellipse in clip:
        "draws the rim of what FILLELLIPSE fills; reals" eg "ELLIPSE 32 24 30 18.5 white";
    FILLELLIPSE FillEllipse {
        center["cx cy"]: [f64; 2], radii["rx ry"]: [f64; 2] = Radii, color["c"]: Rgba,
    } = fn fill_ellipse in clip: "fills the pixel centres inside an ellipse; reals" eg "FILLELLIPSE 32 24 30 18.5 teal";
    ARC Arc {
        center["cx cy"]: [f64; 2], radii["inner outer"]: [f64; 2] = Radii, angles["start end"]: [f64; 2] = Angles,
        color["c"]: Rgba,
    } = fn arc in clip: "fills the part of a ring between two angles, clockwise from the right; reals"
        eg "ARC 32 24 12 20 -90deg 45deg tomato";
    BEZIER Bezier {
        points["x0 y0 x1 y1 x2 y2 x3 y3"]: [[f64; 2]; 4], width["w"]: f64 = LineWidth, color["c"]: Rgba,
    } = fn bezier in clip: "draws a cubic Bezier curve w wide with round ends; reals"
        eg "BEZIER 4 40 20 -20 44 70 60 8 3 white";
    LINEAA LineAa { p0["x0 y0"]: [f64; 2], p1["x1 y1"]: [f64; 2], color["c"]: Rgba } = fn line_aa in clip:
        "draws an anti-aliased line by exact coverage; reals" eg "LINEAA 0.5 0 63 47.25 white";
}
TwoD Text Command {
    BLEND Blend { over["replace|over"]: bool = BlendOver } = fn set_blend:
        "stores colours as they are, or composes them source-over" eg "BLEND over";
    CLIP Clip { rect["x y w h|OFF"]: Option<Rect> = ClipRect } = fn set_clip: [
        "CLIP x y w h": "lets later drawing of this connection touch a rectangle alone",
        "CLIP OFF": "lets it touch everything",
    ] eg "CLIP 8 6 40 30";
    CANVAS Canvas { name: String = CanvasName, w: i32 = Side, h: i32 = Side } = fn make_canvas:
        "makes a transparent off-screen frame, with a depth of its own" eg "CANVAS hero 16 16";
    TARGET Target { name["name|FRAME"]: Option<String> = TargetName } = fn set_target:
        "draws and reads later on a canvas, or on the frame again" eg "TARGET FRAME";
    STAMP Stamp { name: String = CanvasName, x: i32, y: i32, key["[c]"]: Option<Rgba> } = fn stamp in clip:
        "puts a canvas with its upper left corner at (x,y), but for its pixels of colour c"
        eg "STAMP hero 20 10";
    TEXTSIZE TextSize { size["1|2|3|4|5|6|7|8"]: i32 = TextScale } = fn set_text_size:
        "makes the letters of TEXT and PRINT so many times as large" eg "TEXTSIZE 2";
    IMAGE Image { x: i32, y: i32, file[":N"]: Vec<u8> = Bytes } = job image_job in clip:
        "puts a PNG or JPEG picture with its upper left corner at (x,y)" eg "IMAGE 8 6 :3\nPNG";
}

ThreeD Text Command {
    MESH Mesh { name: String, source: Box<MeshSource> } = job mesh_job: [
        "MESH name OBJ :N": "makes a mesh from the N bytes of an OBJ file",
        "MESH name BOX [x y z]": "makes a box (2 2 2)",
        "MESH name SPHERE [r]": "makes a sphere (1)",
        "MESH name CONE [r h]": "makes a cone (1 2)",
        "MESH name CYLINDER [r h]": "makes a cylinder (1 2)",
        "MESH name TEAPOT [level]": "makes Newell's teapot, each patch cut level x level",
        "MESH name KNOT nu nv": "makes a torus knot of nu x nv quads",
    ] eg "MESH pot TEAPOT 6";
    TEX Texture { name: String, file[":N"]: Vec<u8> = Bytes } = job texture_job:
        "makes a texture from the N bytes of a PNG or JPEG file" eg "TEX stone :3\nPNG";
    SCENE Scene { x3d["X3D :N"]: Vec<u8> = X3dFile } = job scene_job:
        "replaces camera, lights and objects by those of an X3D file"
        eg "SCENE X3D :26\n<X3D><Scene></Scene></X3D>";
    EYE Eye { name: String, json[":N"]: Vec<u8> = Bytes } = job eye_job:
        "makes an N-dimensional scene from JSON" eg "EYE world :2\n{}";
    FREE Free { name: String } = fn free: "forgets a mesh, texture, scene or canvas" eg "FREE pot";
    LOAD Load { kind: FileKind, name: String = LoadName, path: String } = fn load_job
        with check_names = load_names, write = write_load: [
        "LOAD MESH|TEX name path": "loads a file of the server's own folder",
        "LOAD SCENE path": "loads an X3D file of the server's own folder",
    ] eg "LOAD MESH pot teapot.obj";
    LOOKAT LookAt { eye["ex ey ez"]: DVec3, reference["rx ry rz"]: DVec3, up["ux uy uz"]: DVec3 } = fn look_at:
        "puts the eye at e, looking at r, u up" eg "LOOKAT 0 2 8 0 0 0 0 1 0";
}
ThreeD Text Projection {
    PERSPECTIVE Perspective {
        fov_rad["fov"]: f64 = Angle, near: f64, far: f64, on_smaller_side["[FOVMIN]"]: bool = FovMin,
    }: "sees in perspective; the angle is vertical, or on the smaller side" eg "PERSPECTIVE 0.8 0.1 100";
    PLANE Plane { d: f64, near: f64, far: f64 }: "sees in perspective on a view plane at distance d"
        eg "PLANE 2 0.1 100";
    FRUSTUM Frustum { window["l r b t"]: [f64; 4], near: f64, far: f64 }:
        "sees in perspective through a window at the near plane" eg "FRUSTUM -1 1 -1 1 1 100";
    ORTHO Ortho { window["l r b t"]: [f64; 4], near: f64, far: f64 }
        | OrthoContain { window["l r b t"]: [f64; 4], near: f64, far: f64 }: [
        "ORTHO l r b t near far": "sees in parallel",
    ] eg "ORTHO -4 4 -3 3 0.1 100";
    OBLIQUE Oblique {
        kind["cavalier|cabinet"]: ObliqueKind, angle_rad["angle"]: f64 = Angle, window["l r b t"]: [f64; 4],
        near: f64, far: f64,
    }: "sees in oblique parallel" eg "OBLIQUE cabinet 0.785 -4 4 -3 3 0.1 100";
    ISOMETRIC Isometric { window["l r b t"]: [f64; 4], near: f64, far: f64 }: "sees isometrically"
        eg "ISOMETRIC -4 4 -3 3 0.1 100";
    PSEUDOISO PseudoIsometric { window["l r b t"]: [f64; 4], near: f64, far: f64 }:
        "sees pseudo-isometrically" eg "PSEUDOISO -4 4 -3 3 0.1 100";
    WINDOW Window {
        vrp["vrp(3)"]: DVec3, p["p(3)"]: DVec3, vup["vup(3)"]: DVec3, center["cu cv"]: [f64; 2],
        half["su sv"]: [f64; 2], dp: f64, near: f64, far: f64,
    }: "sees by the viewing transformation" eg "WINDOW 0 0 0 0 0 8 0 1 0 0 0 4 3 1 0.1 100";
}
ThreeD Text Command {
    VIEWPORT Viewport { rect["x y w h"]: Rect, rule["[centres|corners]"]: ViewportRule = ViewportKind } = fn set_viewport:
        "puts the picture into a part of the frame" eg "VIEWPORT 0 0 64 48";
    IDENTITY Identity = fn reset_model: "resets the model matrix" eg "IDENTITY";
    PUSH Push = fn push_matrix: "keeps the model matrix" eg "PUSH";
    POP Pop = fn pop_matrix: "brings back the model matrix kept last" eg "POP";
    TRANSLATE Translate(by["x y z"]: DVec3) = fn translate_model:
        "multiplies the model matrix on the right, as the next four do" eg "TRANSLATE 1 0 -2";
    ROTATE Rotate { axis["ax ay az"]: DVec3, angle_rad["angle"]: f64 = Angle } = fn rotate_model:
        "turns about an axis; in radians, or as 45deg" eg "ROTATE 0 1 0 45deg";
    SCALE Scale(by["x y z"]: DVec3) = fn scale_model: "scales along the axes" eg "SCALE 2 2 2";
    SHEAR Shear(by["xy xz yx yz zx zy"]: Box<Shears>) = fn shear_model:
        "shears: x' = x + xy*y + xz*z and so on" eg "SHEAR 0.5 0 0 0 0 0";
    MATRIX Matrix(matrix["m00..m33"]: Box<DMat4>) = fn multiply_affine: "sixteen numbers, row by row"
        eg "MATRIX 1 0 0 5 0 1 0 0 0 0 1 0 0 0 0 1";
    AMBIENT Ambient(color: DVec3 = LightColor) = fn set_ambient: [
        "AMBIENT r g b": "sets the ambient light; colours of light are 0..1 and above",
        "AMBIENT name": "the same by a CSS name or #rrggbb; so may any r g b of LIGHT and MATERIAL be given",
    ] eg "AMBIENT 0.2 0.2 0.2";
    LIGHT Light { index: i32 = LightIndex, light: Box<LightCommand> } = fn set_light: [
        "LIGHT i POINT x y z r g b [c l q]": "puts a light at a point, fading by 1/(c + l d + q d^2)",
        "LIGHT i DIR dx dy dz r g b": "lets light fall in a direction",
        "LIGHT i SPOT x y z dx dy dz angle exponent r g b [c l q]": "puts a spot light",
        "LIGHT i OFF": "takes a light away",
    ] eg "LIGHT 0 POINT 5 9 7 1 1 1";
    MATERIAL Material(material: Box<Material>) = fn set_material: [
        "MATERIAL ka(3) kd(3) ks(3) n [emissive(3) [transparency]]": "says how surfaces answer light",
        "MATERIAL ka kd ks n [emissive [transparency]]": "the same with names of colours",
    ] eg "MATERIAL 0.2 0.2 0.2 0.8 0.5 0.2 0.5 0.5 0.5 30";
    TEXTURE UseTexture {
        name["name|OFF"]: Option<String> = TextureName,
        sampling["[nearest|bilinear|mipmap|trilinear] [repeat|clamp]"]: Sampling,
    } = fn use_texture: "lays a texture on what is drawn next" eg "TEXTURE stone bilinear repeat";
    SHADE Shade(mode["wire|flat|gouraud|phong"]: ShadeMode) = fn set_shade: "chooses how faces are coloured"
        eg "SHADE phong";
    CULL Cull(mode["back|front|none"]: Cull) = fn set_cull: "chooses the faces to leave out" eg "CULL back";
    HIDE Hide(mode["zbuffer|painter|none"]: HiddenSurface) = fn set_hide:
        "chooses how hidden surfaces are found" eg "HIDE zbuffer";
    DEPTH Depth(format["u16|u24|u32|f32|reversed"]: DepthFormat) = fn set_depth_format in target:
        "chooses how depth is stored, and clears it" eg "DEPTH u24";
    INTERP Interp(mode["perspective|affine"]: Interpolation) = fn set_interpolation:
        "chooses how values run across a face" eg "INTERP affine";
    DRAW Draw { name: String } = fn draw in clip: "draws a mesh" eg "DRAW pot";
    DRAWSCENE DrawScene { time["[time]"]: f64 = SceneTime, sorted["[SORTED]"]: bool = Sorted } = fn draw_scene in clip:
        "draws the scene at a time, transparent faces in order or sorted" eg "DRAWSCENE 1.5 SORTED";
    DRAWEYE DrawEye { name: String, rect["x y w h"]: Rect } = fn draw_eye in clip:
        "draws an N-dimensional scene into a rectangle" eg "DRAWEYE world 0 0 64 48";
    QUALITY Quality(quality: Quality) = fn set_quality: [
        "QUALITY exact": "draws exactly",
        "QUALITY max-error e [shift]": "draws more cheaply within e steps of colour and a shift in pixels",
    ] eg "QUALITY max-error 2";
}

Control Text Command {
    DEPTHAT DepthAt { x: i32, y: i32 } = fn depth_at -> Line in target: "answers DEPTHAT x y z, 0 near and 1 far"
        eg "DEPTHAT 32 24";
    PICK Pick { x: i32, y: i32 } = fn pick -> Line in target: "answers PICK x y name|none triangle" eg "PICK 32 24";
    SYNC Sync { tag: String } = fn sync -> Line: "answers SYNC tag when all before it is done"
        eg "SYNC frame7";
    HELLO Hello = fn hello -> Line: "answers HELLO fbptr 1 width height stride rgba" eg "HELLO";
    VERSION Version = fn version -> Line: "answers VERSION and the program's version" eg "VERSION";
    TITLE Title { text["text ..."]: String = RestOfLine } = fn set_title:
        "names the window by the rest of the line; no :N is read in it" eg "TITLE Step 7 of 24";
    WAIT Wait { seconds: f64 = Seconds } = fn pause:
        "pauses this connection alone, at most 60 s; not where no window is" eg "WAIT 0.5";
    AUTO Auto(on["on|off"]: bool = OnOff) = fn set_auto:
        "shows the memory as it changes, or only at PRESENT" eg "AUTO off";
    PRESENT Present { wait["[wait]"]: bool = Wait } = fn present -> ByForm:
        "ends a frame; wait answers FRAME n once it is shown" eg "PRESENT wait";
    EVENTS Events(on["on|off"]: bool = OnOff) = fn set_events:
        "asks for EVENT lines: keys, text, mouse, resize, close" eg "EVENTS on";
    ERRORS Errors(mode["count|report|close"]: ErrorMode) = fn set_error_mode:
        "settles whether errors are counted, reported, or end the connection" eg "ERRORS report";
    SNAP Snap(target: SnapTarget) = fn snap_job -> ByForm: [
        "SNAP name.png|ppm|raw": "writes the frame to the snapshot folder, answers SNAP name w h crc",
        "SNAP :": "answers SNAP w h png :N and the file",
    ] eg "SNAP frame.png";
}
}}}
verbs! { language }
