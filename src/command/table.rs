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
use super::verb::{Arity, Encoding, Form, Group, Payload, Reply, Verb};
use super::verb_macros::*;
use crate::draw2d::{AreaColors, RampColor, RealRect, Rect};
use crate::error::Fault;
use crate::memory::{DepthFormat, Rgba};
use crate::scene::{
    Cull, HiddenSurface, Interpolation, Material, ObliqueKind, Projection, Sampling, ShadeMode, ViewportRule,
};
use glam::{DMat4, DVec3};

language! {
nested [Figure(Figure), Projection(Box<Projection>)];

Pixelflut Text Command {
    HELP Help -> Lines: "lists the verbs";
    SIZE Size -> Line: "answers SIZE width height";
    PX Pixel { x: i32, y: i32, color: Rgba } | GetPixel { x: i32, y: i32 } -> ByForm: [
        "PX x y rrggbb": "sets a pixel to a colour in hex, moved by OFFSET",
        "PX x y rrggbbaa": "sets a pixel and its alpha; under BLEND over it is composed",
        "PX x y gg": "sets a pixel to a grey in hex",
        "PX x y name": "sets a pixel to a CSS colour; names stand wherever a colour does",
        "PX x y": "answers PX x y rrggbb",
    ];
}
Pixelflut Binary Command {
    PB BinaryPixel { x: u16, y: u16, color: Rgba = RawColor }: [
        "PBxxyyrgba": "sets a pixel in ten bytes: PB, x and y as u16 little-endian, r, g, b, a; no newline",
    ];
    PXMULTI PixelRun { x: u16, y: u16, rgba: Vec<u8> = Run }: [
        "PXMULTIxxyynnnn": "then nnnn (u32) times rgba: a run of pixels from (x,y) on, wrapping at row ends",
    ];
}
Pixelflut Text Command {
    OFFSET Offset { x: i32, y: i32 }: "moves all later text PX of this connection; replaces the last";
    STATS Stats -> Line: "answers one line of key=value";
    QUIT Quit: "ends the connection";
}

Memory Text Command {
    POKE Poke { offset: i32, bytes["hexbytes"]: Vec<u8> = HexBytes }:
        "writes bytes; offset = (width*y + x)*4, bytes R G B A";
    PEEK Peek { offset: i32, n: i32 = ByteCount } -> Line: "answers PEEK offset hexbytes";
    BLIT Blit { rect["x y w h"]: Rect, rgba[":N"]: Vec<u8> = Bytes } with check_length = blit_length:
        "draws a rectangle of RGBA rows, N = w*h*4 bytes";
    READ Read { rect["x y w h"]: Rect } -> Bytes: "answers READ x y w h :N and the RGBA rows";
    COPY Copy { source["sx sy w h"]: Rect, dx: i32, dy: i32 }:
        "copies a rectangle, as through a temporary copy";
    POINTS Points { packed[":N"]: Vec<u8> = Records }:
        "draws packed pixels, 8 bytes each: x and y as u16 little-endian, r, g, b, a";
    CRC Crc { rect["[x y w h]"]: Option<Rect> } -> Line: "answers CRC xxxxxxxx, the CRC-32 of the RGBA bytes";
    CLEAR Clear { color["[colour]"]: Rgba = ClearColor }:
        "fills the frame (default 000000ff) and clears the depth";
}

TwoD Text Figure {
    LINE Line { p0["x0 y0"]: [i32; 2], p1["x1 y1"]: [i32; 2], color["c0 [c1]"]: RampColor }:
        "draws a line, both ends lit; with c1 the colour runs from c0 to c1";
    TRI Triangle { points["x0 y0 x1 y1 x2 y2"]: [[i32; 2]; 3], colors["c0 [c1 c2]"]: AreaColors }:
        "draws a triangle's three lines";
    FILL Fill { points["x0 y0 x1 y1 x2 y2"]: [[f64; 2]; 3], colors["c0 [c1 c2]"]: AreaColors }:
        "fills a triangle, colours interpolated; reals";
    RECT Rect { rect["x y w h"]: Rect, color["c"]: Rgba }: "draws the border of a rectangle";
    FILLRECT FillRect { rect["x y w h"]: RealRect, color["c"]: Rgba }:
        "fills the pixels with centres in [x,x+w) x [y,y+h); reals";
    CIRCLE Circle { cx: i32, cy: i32, r: i32 = Radius, color["c"]: Rgba }: "draws a circle about a pixel";
    FILLCIRCLE FillCircle { cx: f64, cy: f64, r: f64 = RealRadius, color["c"]: Rgba }:
        "fills the pixel centres nearer than r to a point; reals";
    POLY Poly { color["c"]: Rgba, points["x0 y0 [x1 y1 ...]"]: Vec<[i32; 2]> }: "draws a closed outline";
    FILLPOLY FillPoly { color["c"]: Rgba, points["x0 y0 [x1 y1 ...]"]: Vec<[f64; 2]> }:
        "fills a polygon, even-odd; reals";
    TEXT Text { x: i32, y: i32, color["c"]: Rgba, utf8[":N"]: Vec<u8> = Utf8 }:
        "writes N bytes of UTF-8 in 8x8 letters from the upper left corner (x,y)";
    LINEAA LineAa { p0["x0 y0"]: [f64; 2], p1["x1 y1"]: [f64; 2], color["c"]: Rgba }:
        "draws an anti-aliased line by exact coverage; reals";
}
TwoD Text Command {
    BLEND Blend { over["replace|over"]: bool = BlendOver }:
        "stores colours as they are, or composes them source-over";
}

ThreeD Text Command {
    MESH Mesh { name: String, source: Box<MeshSource> }: [
        "MESH name OBJ :N": "makes a mesh from the N bytes of an OBJ file",
        "MESH name BOX [x y z]": "makes a box (2 2 2)",
        "MESH name SPHERE [r]": "makes a sphere (1)",
        "MESH name CONE [r h]": "makes a cone (1 2)",
        "MESH name CYLINDER [r h]": "makes a cylinder (1 2)",
        "MESH name TEAPOT [level]": "makes Newell's teapot, each patch cut level x level",
        "MESH name KNOT nu nv": "makes a torus knot of nu x nv quads",
    ];
    TEX Texture { name: String, file[":N"]: Vec<u8> = Bytes }:
        "makes a texture from the N bytes of a PNG or JPEG file";
    SCENE Scene { x3d["X3D :N"]: Vec<u8> = X3dFile }:
        "replaces camera, lights and objects by those of an X3D file";
    EYE Eye { name: String, json[":N"]: Vec<u8> = Bytes }: "makes an N-dimensional scene from JSON";
    FREE Free { name: String }: "forgets a mesh, texture or scene";
    LOAD Load { kind: FileKind, name: String = LoadName, path: String }
        with check_names = load_names, write = write_load: [
        "LOAD MESH|TEX name path": "loads a file of the server's own folder",
        "LOAD SCENE path": "loads an X3D file of the server's own folder",
    ];
    LOOKAT LookAt { eye["ex ey ez"]: DVec3, reference["rx ry rz"]: DVec3, up["ux uy uz"]: DVec3 }:
        "puts the eye at e, looking at r, u up";
}
ThreeD Text Projection {
    PERSPECTIVE Perspective {
        fov_rad["fov"]: f64, near: f64, far: f64, on_smaller_side["[FOVMIN]"]: bool = FovMin,
    }: "sees in perspective; the angle is vertical, or on the smaller side";
    PLANE Plane { d: f64, near: f64, far: f64 }: "sees in perspective on a view plane at distance d";
    FRUSTUM Frustum { window["l r b t"]: [f64; 4], near: f64, far: f64 }:
        "sees in perspective through a window at the near plane";
    ORTHO Ortho { window["l r b t"]: [f64; 4], near: f64, far: f64 }
        | OrthoContain { window["l r b t"]: [f64; 4], near: f64, far: f64 }: [
        "ORTHO l r b t near far": "sees in parallel",
    ];
    OBLIQUE Oblique {
        kind["cavalier|cabinet"]: ObliqueKind, angle_rad["angle"]: f64, window["l r b t"]: [f64; 4],
        near: f64, far: f64,
    }: "sees in oblique parallel";
    ISOMETRIC Isometric { window["l r b t"]: [f64; 4], near: f64, far: f64 }: "sees isometrically";
    PSEUDOISO PseudoIsometric { window["l r b t"]: [f64; 4], near: f64, far: f64 }:
        "sees pseudo-isometrically";
    WINDOW Window {
        vrp["vrp(3)"]: DVec3, p["p(3)"]: DVec3, vup["vup(3)"]: DVec3, center["cu cv"]: [f64; 2],
        half["su sv"]: [f64; 2], dp: f64, near: f64, far: f64,
    }: "sees by the viewing transformation";
}
ThreeD Text Command {
    VIEWPORT Viewport { rect["x y w h"]: Rect, rule["[centres|corners]"]: ViewportRule = ViewportKind }:
        "puts the picture into a part of the frame";
    IDENTITY Identity: "resets the model matrix";
    PUSH Push: "keeps the model matrix";
    POP Pop: "brings back the model matrix kept last";
    TRANSLATE Translate(by["x y z"]: DVec3):
        "multiplies the model matrix on the right, as the next four do";
    ROTATE Rotate { axis["ax ay az"]: DVec3, angle_rad["angle"]: f64 }: "turns about an axis, in radians";
    SCALE Scale(by["x y z"]: DVec3): "scales along the axes";
    SHEAR Shear(by["xy xz yx yz zx zy"]: Box<Shears>): "shears: x' = x + xy*y + xz*z and so on";
    MATRIX Matrix(matrix["m00..m33"]: Box<DMat4>): "sixteen numbers, row by row";
    AMBIENT Ambient(color: DVec3 = LightColor): [
        "AMBIENT r g b": "sets the ambient light; colours of light are 0..1 and above",
        "AMBIENT name": "the same by a CSS name or #rrggbb; so may any r g b of LIGHT and MATERIAL be given",
    ];
    LIGHT Light { index: i32 = LightIndex, light: Box<LightCommand> }: [
        "LIGHT i POINT x y z r g b [c l q]": "puts a light at a point, fading by 1/(c + l d + q d^2)",
        "LIGHT i DIR dx dy dz r g b": "lets light fall in a direction",
        "LIGHT i SPOT x y z dx dy dz angle exponent r g b [c l q]": "puts a spot light",
        "LIGHT i OFF": "takes a light away",
    ];
    MATERIAL Material(material: Box<Material>): [
        "MATERIAL ka(3) kd(3) ks(3) n [emissive(3) [transparency]]": "says how surfaces answer light",
        "MATERIAL ka kd ks n [emissive [transparency]]": "the same with names of colours",
    ];
    TEXTURE UseTexture {
        name["name|OFF"]: Option<String> = TextureName,
        sampling["[nearest|bilinear|mipmap|trilinear] [repeat|clamp]"]: Sampling,
    }: "lays a texture on what is drawn next";
    SHADE Shade(mode["wire|flat|gouraud|phong"]: ShadeMode): "chooses how faces are coloured";
    CULL Cull(mode["back|front|none"]: Cull): "chooses the faces to leave out";
    HIDE Hide(mode["zbuffer|painter|none"]: HiddenSurface): "chooses how hidden surfaces are found";
    DEPTH Depth(format["u16|u24|u32|f32|reversed"]: DepthFormat):
        "chooses how depth is stored, and clears it";
    INTERP Interp(mode["perspective|affine"]: Interpolation): "chooses how values run across a face";
    DRAW Draw { name: String }: "draws a mesh";
    DRAWSCENE DrawScene { time["[time]"]: f64 = SceneTime, sorted["[SORTED]"]: bool = Sorted }:
        "draws the scene at a time, transparent faces in order or sorted";
    DRAWEYE DrawEye { name: String, rect["x y w h"]: Rect }: "draws an N-dimensional scene into a rectangle";
    QUALITY Quality(quality: Quality): [
        "QUALITY exact": "draws exactly",
        "QUALITY max-error e": "draws the cheapest way that stays within e steps of colour",
    ];
}

Control Text Command {
    DEPTHAT DepthAt { x: i32, y: i32 } -> Line: "answers DEPTHAT x y z, 0 near and 1 far";
    PICK Pick { x: i32, y: i32 } -> Line: "answers PICK x y name|none triangle";
    SYNC Sync { tag: String } -> Line: "answers SYNC tag when all before it is done";
    HELLO Hello -> Line: "answers HELLO fbptr 1 width height stride rgba";
    VERSION Version -> Line: "answers VERSION and the program's version";
    AUTO Auto(on["on|off"]: bool = OnOff): "shows the memory as it changes, or only at PRESENT";
    PRESENT Present { wait["[wait]"]: bool = Wait } -> ByForm:
        "ends a frame; wait answers FRAME n once it is shown";
    EVENTS Events(on["on|off"]: bool = OnOff): "asks for EVENT lines: keys, text, mouse, resize, close";
    ERRORS Errors(mode["count|report|close"]: ErrorMode):
        "settles whether errors are counted, reported, or end the connection";
    SNAP Snap(target: SnapTarget) -> ByForm: [
        "SNAP name.png|ppm|raw": "writes the frame to the snapshot folder, answers SNAP name w h crc",
        "SNAP :": "answers SNAP w h png :N and the file",
    ];
}
}
