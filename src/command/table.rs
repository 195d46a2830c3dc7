//! The verb table: every verb of the language, once. The decoder, the error messages, HELP and the
//! fuzzer's dictionary are derived from it.
//!
//! Templates: words in lower case stand for arguments, `[...]` is optional, `a|b` is a choice, `:N`
//! announces N payload bytes after the line. Pixelflut's own verbs come first: clients that probe
//! read no further.

use super::args::{Args, ParseError};
use super::commands::Command;
use super::parse::{control, memory, three_d, two_d};
use super::verb::Arity::{From, Of};
use super::verb::{Arity, Encoding, Form, Group, Payload, Verb};

/// Parser of a verb's arguments.
type Parse = fn(&mut Args<'_>) -> Result<Command, ParseError>;

/// Creates one syntax of a verb.
const fn form(syntax: &'static str, about: &'static str) -> Form {
    Form { syntax, about }
}

/// Creates a row for a text verb.
const fn text(
    name: &'static str,
    group: Group,
    arity: Arity,
    payload: Payload,
    parse: Parse,
    forms: &'static [Form],
) -> Verb {
    Verb { name, group, arity, payload, forms, encoding: Encoding::Text(parse) }
}

/// Creates a row for a binary verb of Pixelflut.
const fn binary(name: &'static str, forms: &'static [Form]) -> Verb {
    Verb {
        name,
        group: Group::Pixelflut,
        arity: Of(&[]),
        payload: Payload::Never,
        forms,
        encoding: Encoding::Binary,
    }
}

use Group::{Control, Memory, Pixelflut, ThreeD, TwoD};
use Payload::{Always, BySubject, Never};

#[rustfmt::skip]
pub(super) static TABLE: [Verb; 75] = [
    text("HELP", Pixelflut, Of(&[0]), Never, control::help, &[
        form("HELP", "lists the verbs"),
    ]),
    text("SIZE", Pixelflut, Of(&[0]), Never, control::size, &[
        form("SIZE", "answers SIZE width height"),
    ]),
    text("PX", Pixelflut, Of(&[2, 3]), Never, memory::px, &[
        form("PX x y rrggbb", "sets a pixel to a colour in hex, moved by OFFSET"),
        form("PX x y rrggbbaa", "sets a pixel and its alpha; under BLEND over it is composed"),
        form("PX x y gg", "sets a pixel to a grey in hex"),
        form("PX x y name", "sets a pixel to a CSS colour; names stand wherever a colour does"),
        form("PX x y", "answers PX x y rrggbb"),
    ]),
    binary("PB", &[
        form("PBxxyyrgba", "sets a pixel in ten bytes: PB, x and y as u16 little-endian, r, g, b, a; no newline"),
    ]),
    binary("PXMULTI", &[
        form("PXMULTIxxyynnnn", "then nnnn (u32) times rgba: a run of pixels from (x,y) on, wrapping at row ends"),
    ]),
    text("OFFSET", Pixelflut, Of(&[2]), Never, memory::offset, &[
        form("OFFSET x y", "moves all later text PX of this connection; replaces the last"),
    ]),
    text("STATS", Pixelflut, Of(&[0]), Never, control::stats, &[
        form("STATS", "answers one line of key=value"),
    ]),
    text("QUIT", Pixelflut, Of(&[0]), Never, control::quit, &[
        form("QUIT", "ends the connection"),
    ]),

    text("POKE", Memory, Of(&[2]), Never, memory::poke, &[
        form("POKE offset hexbytes", "writes bytes; offset = (width*y + x)*4, bytes R G B A"),
    ]),
    text("PEEK", Memory, Of(&[2]), Never, memory::peek, &[
        form("PEEK offset n", "answers PEEK offset hexbytes"),
    ]),
    text("BLIT", Memory, Of(&[4]), Always, memory::blit, &[
        form("BLIT x y w h :N", "draws a rectangle of RGBA rows, N = w*h*4 bytes"),
    ]),
    text("READ", Memory, Of(&[4]), Never, memory::read, &[
        form("READ x y w h", "answers READ x y w h :N and the RGBA rows"),
    ]),
    text("COPY", Memory, Of(&[6]), Never, memory::copy, &[
        form("COPY sx sy w h dx dy", "copies a rectangle, as through a temporary copy"),
    ]),
    text("POINTS", Memory, Of(&[0]), Always, memory::points, &[
        form("POINTS :N", "draws packed pixels, 8 bytes each: x and y as u16 little-endian, r, g, b, a"),
    ]),
    text("CRC", Memory, Of(&[0, 4]), Never, memory::crc, &[
        form("CRC [x y w h]", "answers CRC xxxxxxxx, the CRC-32 of the RGBA bytes"),
    ]),
    text("CLEAR", Memory, Of(&[0, 1]), Never, memory::clear, &[
        form("CLEAR [colour]", "fills the frame (default 000000ff) and clears the depth"),
    ]),

    text("LINE", TwoD, Of(&[5, 6]), Never, two_d::line, &[
        form("LINE x0 y0 x1 y1 c0 [c1]", "draws a line, both ends lit; with c1 the colour runs from c0 to c1"),
    ]),
    text("TRI", TwoD, Of(&[7, 9]), Never, two_d::tri, &[
        form("TRI x0 y0 x1 y1 x2 y2 c0 [c1 c2]", "draws a triangle's three lines"),
    ]),
    text("FILL", TwoD, Of(&[7, 9]), Never, two_d::fill, &[
        form("FILL x0 y0 x1 y1 x2 y2 c0 [c1 c2]", "fills a triangle, colours interpolated; reals"),
    ]),
    text("RECT", TwoD, Of(&[5]), Never, two_d::rect, &[
        form("RECT x y w h c", "draws the border of a rectangle"),
    ]),
    text("FILLRECT", TwoD, Of(&[5]), Never, two_d::fillrect, &[
        form("FILLRECT x y w h c", "fills the pixels with centres in [x,x+w) x [y,y+h); reals"),
    ]),
    text("CIRCLE", TwoD, Of(&[4]), Never, two_d::circle, &[
        form("CIRCLE cx cy r c", "draws a circle about a pixel"),
    ]),
    text("FILLCIRCLE", TwoD, Of(&[4]), Never, two_d::fillcircle, &[
        form("FILLCIRCLE cx cy r c", "fills the pixel centres nearer than r to a point; reals"),
    ]),
    text("POLY", TwoD, From(3), Never, two_d::poly, &[
        form("POLY c x0 y0 [x1 y1 ...]", "draws a closed outline"),
    ]),
    text("FILLPOLY", TwoD, From(3), Never, two_d::fillpoly, &[
        form("FILLPOLY c x0 y0 [x1 y1 ...]", "fills a polygon, even-odd; reals"),
    ]),
    text("TEXT", TwoD, Of(&[3]), Always, two_d::text, &[
        form("TEXT x y c :N", "writes N bytes of UTF-8 in 8x8 letters from the upper left corner (x,y)"),
    ]),
    text("LINEAA", TwoD, Of(&[5]), Never, two_d::lineaa, &[
        form("LINEAA x0 y0 x1 y1 c", "draws an anti-aliased line by exact coverage; reals"),
    ]),
    text("BLEND", TwoD, Of(&[1]), Never, two_d::blend, &[
        form("BLEND replace|over", "stores colours as they are, or composes them source-over"),
    ]),

    text("MESH", ThreeD, From(2), BySubject, three_d::mesh, &[
        form("MESH name OBJ :N", "makes a mesh from the N bytes of an OBJ file"),
        form("MESH name BOX [x y z]", "makes a box (2 2 2)"),
        form("MESH name SPHERE [r]", "makes a sphere (1)"),
        form("MESH name CONE [r h]", "makes a cone (1 2)"),
        form("MESH name CYLINDER [r h]", "makes a cylinder (1 2)"),
        form("MESH name TEAPOT [level]", "makes Newell's teapot, each patch cut level x level"),
        form("MESH name KNOT nu nv", "makes a torus knot of nu x nv quads"),
    ]),
    text("TEX", ThreeD, Of(&[1]), Always, three_d::tex, &[
        form("TEX name :N", "makes a texture from the N bytes of a PNG or JPEG file"),
    ]),
    text("SCENE", ThreeD, Of(&[1]), Always, three_d::scene, &[
        form("SCENE X3D :N", "replaces camera, lights and objects by those of an X3D file"),
    ]),
    text("EYE", ThreeD, Of(&[1]), Always, three_d::eye, &[
        form("EYE name :N", "makes an N-dimensional scene from JSON"),
    ]),
    text("FREE", ThreeD, Of(&[1]), Never, three_d::free, &[
        form("FREE name", "forgets a mesh, texture or scene"),
    ]),
    text("LOAD", ThreeD, Of(&[2, 3]), Never, three_d::load, &[
        form("LOAD MESH|TEX name path", "loads a file of the server's own folder"),
        form("LOAD SCENE path", "loads an X3D file of the server's own folder"),
    ]),
    text("LOOKAT", ThreeD, Of(&[9]), Never, three_d::lookat, &[
        form("LOOKAT ex ey ez rx ry rz ux uy uz", "puts the eye at e, looking at r, u up"),
    ]),
    text("PERSPECTIVE", ThreeD, Of(&[3, 4]), Never, three_d::perspective, &[
        form("PERSPECTIVE fov near far [FOVMIN]", "sees in perspective; the angle is vertical, or on the smaller side"),
    ]),
    text("PLANE", ThreeD, Of(&[3]), Never, three_d::plane, &[
        form("PLANE d near far", "sees in perspective on a view plane at distance d"),
    ]),
    text("FRUSTUM", ThreeD, Of(&[6]), Never, three_d::frustum, &[
        form("FRUSTUM l r b t near far", "sees in perspective through a window at the near plane"),
    ]),
    text("ORTHO", ThreeD, Of(&[6]), Never, three_d::ortho, &[
        form("ORTHO l r b t near far", "sees in parallel"),
    ]),
    text("OBLIQUE", ThreeD, Of(&[8]), Never, three_d::oblique, &[
        form("OBLIQUE cavalier|cabinet angle l r b t near far", "sees in oblique parallel"),
    ]),
    text("ISOMETRIC", ThreeD, Of(&[6]), Never, three_d::isometric, &[
        form("ISOMETRIC l r b t near far", "sees isometrically"),
    ]),
    text("PSEUDOISO", ThreeD, Of(&[6]), Never, three_d::pseudoiso, &[
        form("PSEUDOISO l r b t near far", "sees pseudo-isometrically"),
    ]),
    text("WINDOW", ThreeD, Of(&[16]), Never, three_d::window, &[
        form("WINDOW vrp(3) p(3) vup(3) cu cv su sv dp near far", "sees by the viewing transformation"),
    ]),
    text("VIEWPORT", ThreeD, Of(&[4, 5]), Never, three_d::viewport, &[
        form("VIEWPORT x y w h [centres|corners]", "puts the picture into a part of the frame"),
    ]),
    text("IDENTITY", ThreeD, Of(&[0]), Never, three_d::identity, &[
        form("IDENTITY", "resets the model matrix"),
    ]),
    text("PUSH", ThreeD, Of(&[0]), Never, three_d::push, &[
        form("PUSH", "keeps the model matrix"),
    ]),
    text("POP", ThreeD, Of(&[0]), Never, three_d::pop, &[
        form("POP", "brings back the model matrix kept last"),
    ]),
    text("TRANSLATE", ThreeD, Of(&[3]), Never, three_d::translate, &[
        form("TRANSLATE x y z", "multiplies the model matrix on the right, as the next four do"),
    ]),
    text("ROTATE", ThreeD, Of(&[4]), Never, three_d::rotate, &[
        form("ROTATE ax ay az angle", "turns about an axis, in radians"),
    ]),
    text("SCALE", ThreeD, Of(&[3]), Never, three_d::scale, &[
        form("SCALE x y z", "scales along the axes"),
    ]),
    text("SHEAR", ThreeD, Of(&[6]), Never, three_d::shear, &[
        form("SHEAR xy xz yx yz zx zy", "shears: x' = x + xy*y + xz*z and so on"),
    ]),
    text("MATRIX", ThreeD, Of(&[16]), Never, three_d::matrix, &[
        form("MATRIX m00..m33", "sixteen numbers, row by row"),
    ]),
    text("AMBIENT", ThreeD, From(1), Never, three_d::ambient, &[
        form("AMBIENT r g b", "sets the ambient light; colours of light are 0..1 and above"),
        form("AMBIENT name", "the same by a CSS name or #rrggbb; so may any r g b of LIGHT and MATERIAL be given"),
    ]),
    text("LIGHT", ThreeD, From(2), Never, three_d::light, &[
        form("LIGHT i POINT x y z r g b [c l q]", "puts a light at a point, fading by 1/(c + l d + q d^2)"),
        form("LIGHT i DIR dx dy dz r g b", "lets light fall in a direction"),
        form("LIGHT i SPOT x y z dx dy dz angle exponent r g b [c l q]", "puts a spot light"),
        form("LIGHT i OFF", "takes a light away"),
    ]),
    text("MATERIAL", ThreeD, From(4), Never, three_d::material, &[
        form("MATERIAL ka(3) kd(3) ks(3) n [emissive(3) [transparency]]", "says how surfaces answer light"),
        form("MATERIAL ka kd ks n [emissive [transparency]]", "the same with names of colours"),
    ]),
    text("TEXTURE", ThreeD, Of(&[1, 2, 3]), Never, three_d::texture, &[
        form("TEXTURE name|OFF [nearest|bilinear|mipmap|trilinear] [repeat|clamp]", "lays a texture on what is drawn next"),
    ]),
    text("SHADE", ThreeD, Of(&[1]), Never, three_d::shade, &[
        form("SHADE wire|flat|gouraud|phong", "chooses how faces are coloured"),
    ]),
    text("CULL", ThreeD, Of(&[1]), Never, three_d::cull, &[
        form("CULL back|front|none", "chooses the faces to leave out"),
    ]),
    text("HIDE", ThreeD, Of(&[1]), Never, three_d::hide, &[
        form("HIDE zbuffer|painter|none", "chooses how hidden surfaces are found"),
    ]),
    text("DEPTH", ThreeD, Of(&[1]), Never, three_d::depth, &[
        form("DEPTH u16|u24|u32|f32|reversed", "chooses how depth is stored, and clears it"),
    ]),
    text("INTERP", ThreeD, Of(&[1]), Never, three_d::interp, &[
        form("INTERP perspective|affine", "chooses how values run across a face"),
    ]),
    text("DRAW", ThreeD, Of(&[1]), Never, three_d::draw, &[
        form("DRAW name", "draws a mesh"),
    ]),
    text("DRAWSCENE", ThreeD, Of(&[0, 1, 2]), Never, three_d::drawscene, &[
        form("DRAWSCENE [time] [SORTED]", "draws the scene at a time, transparent faces in order or sorted"),
    ]),
    text("DRAWEYE", ThreeD, Of(&[5]), Never, three_d::draweye, &[
        form("DRAWEYE name x y w h", "draws an N-dimensional scene into a rectangle"),
    ]),
    text("QUALITY", ThreeD, Of(&[1, 2]), Never, three_d::quality, &[
        form("QUALITY exact", "draws exactly"),
        form("QUALITY max-error e", "draws the cheapest way that stays within e steps of colour"),
    ]),

    text("DEPTHAT", Control, Of(&[2]), Never, control::depthat, &[
        form("DEPTHAT x y", "answers DEPTHAT x y z, 0 near and 1 far"),
    ]),
    text("PICK", Control, Of(&[2]), Never, control::pick, &[
        form("PICK x y", "answers PICK x y name|none triangle"),
    ]),
    text("SYNC", Control, Of(&[1]), Never, control::sync, &[
        form("SYNC tag", "answers SYNC tag when all before it is done"),
    ]),
    text("HELLO", Control, Of(&[0]), Never, control::hello, &[
        form("HELLO", "answers HELLO fbptr 1 width height stride rgba"),
    ]),
    text("VERSION", Control, Of(&[0]), Never, control::version, &[
        form("VERSION", "answers VERSION and the program's version"),
    ]),
    text("AUTO", Control, Of(&[1]), Never, control::auto, &[
        form("AUTO on|off", "shows the memory as it changes, or only at PRESENT"),
    ]),
    text("PRESENT", Control, Of(&[0, 1]), Never, control::present, &[
        form("PRESENT [wait]", "ends a frame; wait answers FRAME n once it is shown"),
    ]),
    text("EVENTS", Control, Of(&[1]), Never, control::events, &[
        form("EVENTS on|off", "asks for EVENT lines: keys, text, mouse, resize, close"),
    ]),
    text("ERRORS", Control, Of(&[1]), Never, control::errors, &[
        form("ERRORS count|report|close", "settles whether errors are counted, reported, or end the connection"),
    ]),
    text("SNAP", Control, Of(&[1]), Never, control::snap, &[
        form("SNAP name.png|ppm|raw", "writes the frame to the snapshot folder, answers SNAP name w h crc"),
        form("SNAP :", "answers SNAP w h png :N and the file"),
    ]),
];
