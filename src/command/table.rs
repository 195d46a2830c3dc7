//! THE VERB TABLE: every verb of the language, once. The decoder, the messages, HELP and the fuzzer's dictionary read it.
//!
//! Templates: words in lower case stand for arguments, `[...]` may be left out, `a|b` is a choice, `:N` announces N
//! payload bytes after the line. Pixelflut's own verbs come first: clients that probe read no further.

use super::args::{Args, Refusal};
use super::model::Command;
use super::parse::{control, memory, plane, space};
use super::verb::Counts::{From, Of};
use super::verb::{Counts, Form, Group, Payload, Reading, Verb};

type Parse = fn(&mut Args<'_>) -> Result<Command, Refusal>;

const fn form(syntax: &'static str, about: &'static str) -> Form {
    Form { syntax, about }
}

const fn text(
    name: &'static str,
    group: Group,
    counts: Counts,
    payload: Payload,
    parse: Parse,
    forms: &'static [Form],
) -> Verb {
    Verb { name, group, counts, payload, forms, reading: Reading::Text(parse) }
}

const fn binary(name: &'static str, forms: &'static [Form]) -> Verb {
    Verb {
        name,
        group: Group::Pixelflut,
        counts: Of(&[]),
        payload: Payload::Never,
        forms,
        reading: Reading::Binary,
    }
}

use Group::{Control, Memory, Pixelflut, Plane, Space};
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

    text("LINE", Plane, Of(&[5, 6]), Never, plane::line, &[
        form("LINE x0 y0 x1 y1 c0 [c1]", "draws a line, both ends lit; with c1 the colour runs from c0 to c1"),
    ]),
    text("TRI", Plane, Of(&[7, 9]), Never, plane::tri, &[
        form("TRI x0 y0 x1 y1 x2 y2 c0 [c1 c2]", "draws a triangle's three lines"),
    ]),
    text("FILL", Plane, Of(&[7, 9]), Never, plane::fill, &[
        form("FILL x0 y0 x1 y1 x2 y2 c0 [c1 c2]", "fills a triangle, colours interpolated; reals"),
    ]),
    text("RECT", Plane, Of(&[5]), Never, plane::rect, &[
        form("RECT x y w h c", "draws the border of a rectangle"),
    ]),
    text("FILLRECT", Plane, Of(&[5]), Never, plane::fillrect, &[
        form("FILLRECT x y w h c", "fills the pixels with centres in [x,x+w) x [y,y+h); reals"),
    ]),
    text("CIRCLE", Plane, Of(&[4]), Never, plane::circle, &[
        form("CIRCLE cx cy r c", "draws a circle about a pixel"),
    ]),
    text("FILLCIRCLE", Plane, Of(&[4]), Never, plane::fillcircle, &[
        form("FILLCIRCLE cx cy r c", "fills the pixel centres nearer than r to a point; reals"),
    ]),
    text("POLY", Plane, From(3), Never, plane::poly, &[
        form("POLY c x0 y0 [x1 y1 ...]", "draws a closed outline"),
    ]),
    text("FILLPOLY", Plane, From(3), Never, plane::fillpoly, &[
        form("FILLPOLY c x0 y0 [x1 y1 ...]", "fills a polygon, even-odd; reals"),
    ]),
    text("TEXT", Plane, Of(&[3]), Always, plane::text, &[
        form("TEXT x y c :N", "writes N bytes of UTF-8 in 8x8 letters from the upper left corner (x,y)"),
    ]),
    text("LINEAA", Plane, Of(&[5]), Never, plane::lineaa, &[
        form("LINEAA x0 y0 x1 y1 c", "draws an anti-aliased line by exact coverage; reals"),
    ]),
    text("BLEND", Plane, Of(&[1]), Never, plane::blend, &[
        form("BLEND replace|over", "stores colours as they are, or composes them source-over"),
    ]),

    text("MESH", Space, From(2), BySubject, space::mesh, &[
        form("MESH name OBJ :N", "makes a mesh from the N bytes of an OBJ file"),
        form("MESH name BOX [x y z]", "makes a box (2 2 2)"),
        form("MESH name SPHERE [r]", "makes a sphere (1)"),
        form("MESH name CONE [r h]", "makes a cone (1 2)"),
        form("MESH name CYLINDER [r h]", "makes a cylinder (1 2)"),
        form("MESH name TEAPOT [level]", "makes Newell's teapot, each patch cut level x level"),
        form("MESH name KNOT nu nv", "makes a torus knot of nu x nv quads"),
    ]),
    text("TEX", Space, Of(&[1]), Always, space::tex, &[
        form("TEX name :N", "makes a texture from the N bytes of a PNG or JPEG file"),
    ]),
    text("SCENE", Space, Of(&[1]), Always, space::scene, &[
        form("SCENE X3D :N", "replaces camera, lights and objects by those of an X3D file"),
    ]),
    text("EYE", Space, Of(&[1]), Always, space::eye, &[
        form("EYE name :N", "makes an N-dimensional scene from JSON"),
    ]),
    text("FREE", Space, Of(&[1]), Never, space::free, &[
        form("FREE name", "forgets a mesh, texture or scene"),
    ]),
    text("LOAD", Space, Of(&[2, 3]), Never, space::load, &[
        form("LOAD MESH|TEX name path", "loads a file of the server's own folder"),
        form("LOAD SCENE path", "loads an X3D file of the server's own folder"),
    ]),
    text("LOOKAT", Space, Of(&[9]), Never, space::lookat, &[
        form("LOOKAT ex ey ez rx ry rz ux uy uz", "puts the eye at e, looking at r, u up"),
    ]),
    text("PERSPECTIVE", Space, Of(&[3, 4]), Never, space::perspective, &[
        form("PERSPECTIVE fov near far [FOVMIN]", "sees in perspective; the angle is vertical, or on the smaller side"),
    ]),
    text("PLANE", Space, Of(&[3]), Never, space::plane, &[
        form("PLANE d near far", "sees in perspective on a view plane at distance d"),
    ]),
    text("FRUSTUM", Space, Of(&[6]), Never, space::frustum, &[
        form("FRUSTUM l r b t near far", "sees in perspective through a window at the near plane"),
    ]),
    text("ORTHO", Space, Of(&[6]), Never, space::ortho, &[
        form("ORTHO l r b t near far", "sees in parallel"),
    ]),
    text("OBLIQUE", Space, Of(&[8]), Never, space::oblique, &[
        form("OBLIQUE cavalier|cabinet angle l r b t near far", "sees in oblique parallel"),
    ]),
    text("ISOMETRIC", Space, Of(&[6]), Never, space::isometric, &[
        form("ISOMETRIC l r b t near far", "sees isometrically"),
    ]),
    text("PSEUDOISO", Space, Of(&[6]), Never, space::pseudoiso, &[
        form("PSEUDOISO l r b t near far", "sees pseudo-isometrically"),
    ]),
    text("WINDOW", Space, Of(&[16]), Never, space::window, &[
        form("WINDOW vrp(3) p(3) vup(3) cu cv su sv dp near far", "sees by the viewing transformation"),
    ]),
    text("VIEWPORT", Space, Of(&[4, 5]), Never, space::viewport, &[
        form("VIEWPORT x y w h [centres|corners]", "puts the picture into a part of the frame"),
    ]),
    text("IDENTITY", Space, Of(&[0]), Never, space::identity, &[
        form("IDENTITY", "resets the model matrix"),
    ]),
    text("PUSH", Space, Of(&[0]), Never, space::push, &[
        form("PUSH", "keeps the model matrix"),
    ]),
    text("POP", Space, Of(&[0]), Never, space::pop, &[
        form("POP", "brings back the model matrix kept last"),
    ]),
    text("TRANSLATE", Space, Of(&[3]), Never, space::translate, &[
        form("TRANSLATE x y z", "multiplies the model matrix on the right, as the next four do"),
    ]),
    text("ROTATE", Space, Of(&[4]), Never, space::rotate, &[
        form("ROTATE ax ay az angle", "turns about an axis, in radians"),
    ]),
    text("SCALE", Space, Of(&[3]), Never, space::scale, &[
        form("SCALE x y z", "scales along the axes"),
    ]),
    text("SHEAR", Space, Of(&[6]), Never, space::shear, &[
        form("SHEAR xy xz yx yz zx zy", "shears: x' = x + xy*y + xz*z and so on"),
    ]),
    text("MATRIX", Space, Of(&[16]), Never, space::matrix, &[
        form("MATRIX m00..m33", "sixteen numbers, row by row"),
    ]),
    text("AMBIENT", Space, From(1), Never, space::ambient, &[
        form("AMBIENT r g b", "sets the ambient light; colours of light are 0..1 and above"),
        form("AMBIENT name", "the same by a CSS name or #rrggbb; so may any r g b of LIGHT and MATERIAL be given"),
    ]),
    text("LIGHT", Space, From(2), Never, space::light, &[
        form("LIGHT i POINT x y z r g b [c l q]", "puts a light at a point, fading by 1/(c + l d + q d^2)"),
        form("LIGHT i DIR dx dy dz r g b", "lets light fall in a direction"),
        form("LIGHT i SPOT x y z dx dy dz angle exponent r g b [c l q]", "puts a spot light"),
        form("LIGHT i OFF", "takes a light away"),
    ]),
    text("MATERIAL", Space, From(4), Never, space::material, &[
        form("MATERIAL ka(3) kd(3) ks(3) n [emissive(3) [transparency]]", "says how surfaces answer light"),
        form("MATERIAL ka kd ks n [emissive [transparency]]", "the same with names of colours"),
    ]),
    text("TEXTURE", Space, Of(&[1, 2, 3]), Never, space::texture, &[
        form("TEXTURE name|OFF [nearest|bilinear|mipmap|trilinear] [repeat|clamp]", "lays a texture on what is drawn next"),
    ]),
    text("SHADE", Space, Of(&[1]), Never, space::shade, &[
        form("SHADE wire|flat|gouraud|phong", "chooses how faces are coloured"),
    ]),
    text("CULL", Space, Of(&[1]), Never, space::cull, &[
        form("CULL back|front|none", "chooses the faces to leave out"),
    ]),
    text("HIDE", Space, Of(&[1]), Never, space::hide, &[
        form("HIDE zbuffer|painter|none", "chooses how hidden surfaces are found"),
    ]),
    text("DEPTH", Space, Of(&[1]), Never, space::depth, &[
        form("DEPTH u16|u24|u32|f32|reversed", "chooses how depth is stored, and clears it"),
    ]),
    text("INTERP", Space, Of(&[1]), Never, space::interp, &[
        form("INTERP perspective|affine", "chooses how values run across a face"),
    ]),
    text("DRAW", Space, Of(&[1]), Never, space::draw, &[
        form("DRAW name", "draws a mesh"),
    ]),
    text("DRAWSCENE", Space, Of(&[0, 1, 2]), Never, space::drawscene, &[
        form("DRAWSCENE [time] [SORTED]", "draws the scene at a time, transparent faces in order or sorted"),
    ]),
    text("DRAWEYE", Space, Of(&[5]), Never, space::draweye, &[
        form("DRAWEYE name x y w h", "draws an N-dimensional scene into a rectangle"),
    ]),
    text("QUALITY", Space, Of(&[1, 2]), Never, space::quality, &[
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
