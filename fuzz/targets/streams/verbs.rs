//! Writes one command of any verb, with arguments of the right kinds.

use super::data::DataProvider;
use super::payloads;
use super::space::{camera, look, matrix};
use super::words::{CANVASES, EYES, Extremes, MESHES, TEXTURES, Words};
use fbptr::command::{Parameter, ParameterKind, Payload, Reply, Verb};
use std::sync::LazyLock;

/// A command as sent, and the beginning of its reply, if it has one.
pub struct Written {
    pub bytes: Vec<u8>,
    pub reply: Option<&'static str>,
}

/// Verbs, repeated by weight. Those of the verb table that have no weight here are added once;
/// `SYNC` has its own place.
pub static VERBS: LazyLock<Vec<&str>> = LazyLock::new(|| {
    const WEIGHTED: &str = "HELP SIZE PX PX PX PB PXMULTI OFFSET STATS QUIT POKE PEEK BLIT BLIT READ COPY \
        POINTS CRC CRC CLEAR LINE LINE LINE TRI FILL FILL FILL RECT FILLRECT CIRCLE FILLCIRCLE POLY \
        FILLPOLY FILLPOLY TEXT LINEAA LINEAA BLEND MESH MESH MESH MESH TEX TEX SCENE SCENE EYE EYE FREE \
        LOAD LOAD LOOKAT PERSPECTIVE PLANE FRUSTUM ORTHO OBLIQUE ISOMETRIC PSEUDOISO WINDOW VIEWPORT \
        IDENTITY PUSH POP TRANSLATE ROTATE SCALE SHEAR MATRIX AMBIENT LIGHT LIGHT MATERIAL TEXTURE \
        TEXTURE CANVAS CANVAS TARGET TARGET CLIP STAMP STAMP IMAGE BEZIER ARC SHADE SHADE CULL HIDE DEPTH INTERP DRAW DRAW DRAW DRAW DRAW DRAWSCENE DRAWSCENE DRAWEYE \
        DRAWEYE QUALITY DEPTHAT PICK HELLO VERSION AUTO PRESENT EVENTS ERRORS SNAP";
    let mut verbs: Vec<&str> = WEIGHTED.split(' ').collect();
    let others: Vec<&str> =
        Verb::all().iter().map(|v| v.name).filter(|v| *v != "SYNC" && !verbs.contains(v)).collect();
    verbs.extend(others);
    verbs
});

/// Returns a random command. `SYNC` is written by the caller, with a tag of its own.
pub fn any(data: &mut DataProvider, extremes: Extremes) -> Written {
    let verb = VERBS[data.below(VERBS.len())];
    one(verb, data, extremes)
}

/// Returns commands after which `DRAW` shows something: a mesh, a camera, a light.
pub fn setting(data: &mut DataProvider, extremes: Extremes) -> Vec<Written> {
    let verbs = ["MESH", "LOOKAT", "PERSPECTIVE", "LIGHT", "TEX", "TEXTURE", "SHADE", "DRAW", "EYE", "SCENE"];
    let calm = Extremes { real: extremes.real * 3, ..extremes };
    verbs[..3 + data.below(8)].iter().map(|verb| one(verb, data, calm)).collect()
}

fn one(verb: &'static str, data: &mut DataProvider, extremes: Extremes) -> Written {
    match verb {
        "PB" | "PXMULTI" => return binary(verb, data),
        _ => {}
    }
    // Verbs may be written in lower case; those that begin with PB may not.
    let line = if data.once_in(16) { verb.to_lowercase() } else { verb.to_owned() };
    let mut w = Words { data, extremes, line };
    let mut payload = None;
    let reply = match verb {
        "BLIT" | "POINTS" | "TEXT" | "MESH" | "TEX" | "SCENE" | "EYE" => {
            payload = with_payload(verb, &mut w);
            None
        }
        "CANVAS" | "TARGET" | "CLIP" | "STAMP" | "TEXTSIZE" => {
            surface(verb, &mut w);
            None
        }
        "IMAGE" => {
            w.wholes(2);
            payload = Some(payloads::picture(w.data));
            None
        }
        "POKE" | "PEEK" | "READ" | "COPY" | "CRC" | "CLEAR" | "PX" | "OFFSET" => memory(verb, &mut w),
        "LINE" | "TRI" | "FILL" | "RECT" | "FILLRECT" | "CIRCLE" | "FILLCIRCLE" | "POLY" | "FILLPOLY"
        | "LINEAA" => {
            plane(verb, &mut w);
            None
        }
        "LOOKAT" | "PERSPECTIVE" | "PLANE" | "FRUSTUM" | "ORTHO" | "OBLIQUE" | "ISOMETRIC" | "PSEUDOISO"
        | "WINDOW" | "VIEWPORT" => {
            camera(verb, &mut w);
            None
        }
        "AMBIENT" | "LIGHT" | "MATERIAL" | "TEXTURE" | "SHADE" | "CULL" | "HIDE" | "DEPTH" | "INTERP"
        | "BLEND" | "QUALITY" => {
            look(verb, &mut w);
            None
        }
        "TRANSLATE" | "ROTATE" | "SCALE" | "SHEAR" | "MATRIX" | "IDENTITY" | "PUSH" | "POP" => {
            matrix(verb, &mut w);
            None
        }
        "HELP" | "SIZE" | "STATS" | "HELLO" | "VERSION" | "QUIT" | "FREE" | "LOAD" | "DRAW" | "DRAWSCENE"
        | "DRAWEYE" | "DEPTHAT" | "PICK" | "AUTO" | "EVENTS" | "PRESENT" | "ERRORS" | "SNAP" => {
            rest(verb, &mut w)
        }
        _ => {
            payload = by_table(verb, &mut w);
            match Verb::named(verb).map(|v| v.reply) {
                Some(Reply::Line | Reply::Bytes) => Some(verb),
                _ => None,
            }
        }
    };
    let mut line = std::mem::take(&mut w.line);
    if let Some(payload) = &payload {
        // Sometimes of another length than the words say.
        line += &format!(" :{}", payload.len());
    }
    line += if w.data.once_in(12) { "\r\n" } else { "\n" };
    let mut bytes = line.into_bytes();
    bytes.extend(payload.unwrap_or_default());
    Written { bytes, reply }
}

fn binary(verb: &str, data: &mut DataProvider) -> Written {
    let mut bytes = verb.as_bytes().to_vec();
    let at = |data: &mut DataProvider| {
        (if data.once_in(6) { data.below(65_536) } else { data.below(70) } as u16).to_le_bytes()
    };
    let (x, y) = (at(data), at(data));
    bytes.extend(x.into_iter().chain(y));
    let pixels = match verb {
        "PB" => 1,
        _ => {
            let pixels = data.below(60);
            bytes.extend((pixels as u32).to_le_bytes());
            pixels
        }
    };
    for _ in 0..pixels {
        bytes.extend((data.below(65_536) as u32 * 40_503).to_le_bytes());
    }
    Written { bytes, reply: None }
}

fn with_payload(verb: &str, w: &mut Words) -> Option<Vec<u8>> {
    let mut payload = match verb {
        "BLIT" => {
            let (width, height) = (w.data.below(24), w.data.below(12));
            w.wholes(2).word(&width.to_string()).word(&height.to_string());
            noise(w.data, width * height * 4)
        }
        "POINTS" => {
            let points = w.data.below(50);
            let mut bytes = noise(w.data, points * 8);
            // Most positions lie on the frame.
            bytes
                .chunks_mut(8)
                .for_each(|p| [p[0], p[1], p[2], p[3]] = [p[0] & 63, p[1] & 1, p[2] & 63, p[3] & 1]);
            bytes
        }
        "TEXT" => {
            w.wholes(2).color();
            let bytes = w.data.below(30);
            if w.data.once_in(4) {
                noise(w.data, bytes)
            } else {
                "a\nb \u{e9}\tZ\u{20ac}gj|".repeat(3).into_bytes()
            }
        }
        "MESH" => return mesh(w),
        "TEX" => {
            w.one_of(&TEXTURES);
            payloads::picture(w.data)
        }
        "SCENE" => {
            w.word("X3D");
            payloads::x3d(w.data)
        }
        _ => {
            w.one_of(&EYES);
            payloads::world(w.data)
        }
    };
    if w.data.once_in(30) {
        payload.pop();
    }
    Some(payload)
}

fn mesh(w: &mut Words) -> Option<Vec<u8>> {
    w.one_of(&MESHES);
    match w.data.below(12) {
        0 => w.word("BOX").maybe(|w| w.reals(3, 2.0, 1.9)),
        1 => w.word("SPHERE").maybe(|w| w.real(1.0, 0.9)),
        2 => w.word("CONE").maybe(|w| w.reals(2, 1.0, 0.9)),
        3 => w.word("CYLINDER").maybe(|w| w.reals(2, 1.0, 0.9)),
        4 => w.word("TEAPOT").small(4),
        5 => w.word("KNOT").small(12).small(8),
        _ => {
            w.word("OBJ");
            return Some(payloads::obj(w.data, w.extremes));
        }
    };
    None
}

fn noise(data: &mut DataProvider, bytes: usize) -> Vec<u8> {
    let seed = data.bits();
    (0..bytes as u64).map(|i| (seed.wrapping_mul(2 * i + 1) >> 29) as u8).collect()
}

fn memory(verb: &str, w: &mut Words) -> Option<&'static str> {
    match verb {
        "PX" => {
            w.wholes(2);
            if w.data.below(3) == 0 {
                return Some("PX");
            }
            w.color();
            if w.line.ends_with(' ') {
                // The invalid colour was an empty word, and without a colour PX is a query.
                return Some("PX");
            }
        }
        "OFFSET" => {
            w.wholes(2);
        }
        "POKE" => {
            w.small(4000).one_of(&["00", "ff00ff00", "123", "0102030405060708090a0b0c", "zz"]);
        }
        "PEEK" => {
            w.small(4000).small(64);
            return Some("PEEK");
        }
        "READ" => {
            w.small(20).small(9).small(30).small(9);
            return Some("READ");
        }
        "COPY" => {
            w.small(12).small(6).small(16).small(9).wholes(2);
        }
        "CRC" => {
            w.maybe(|w| w.small(20).small(9).small(30).small(9));
            return Some("CRC");
        }
        _ => {
            w.maybe(|w| w.color());
        }
    }
    None
}

fn plane(verb: &str, w: &mut Words) {
    match verb {
        "LINE" => {
            w.wholes(4).color().maybe(|w| w.color());
        }
        "TRI" => {
            w.wholes(6).color().maybe(|w| w.color().color());
        }
        "FILL" => {
            w.reals(6, 16.0, 40.0).color().maybe(|w| w.color().color());
        }
        "RECT" => {
            w.wholes(4).color();
        }
        "FILLRECT" => {
            w.reals(2, 8.0, 20.0).reals(2, 10.0, 12.0).color();
        }
        "CIRCLE" => {
            w.wholes(3).color();
        }
        "FILLCIRCLE" => {
            w.reals(2, 16.0, 20.0).real(10.0, 11.0).color();
        }
        "LINEAA" => {
            w.reals(4, 16.0, 40.0).color();
        }
        _ => {
            w.color();
            for _ in 0..1 + w.data.below(9) {
                if verb == "POLY" {
                    w.wholes(2)
                } else {
                    w.reals(2, 16.0, 40.0)
                };
            }
        }
    }
}

/// Writes the words of the verbs of canvases, targets and clip rectangles. Sizes are now and then those
/// of which a server has room for few, or none.
fn surface(verb: &str, w: &mut Words) {
    match verb {
        "CANVAS" => {
            w.one_of(&CANVASES);
            match w.data.below(12) {
                0 => w.wholes(2),
                1 => w.one_of(&["1", "2000", "32768", "32769"]).one_of(&["1", "2000", "0"]),
                _ => w.small(80).small(60),
            };
        }
        "TARGET" => {
            w.one_of(&["c", "d", "m", "FRAME", "frame", "FRAME"]);
        }
        "CLIP" => match w.data.once_in(3) {
            true => drop(w.one_of(&["OFF", "off", "OFF 1"])),
            false => drop(w.wholes(2).small(50).small(40)),
        },
        "STAMP" => {
            w.one_of(&CANVASES).wholes(2).maybe(|w| w.color());
        }
        _ => {
            w.one_of(&["1", "2", "3", "8", "0", "9"]);
        }
    }
}

/// Writes the words of a verb by the kinds of its parameters in the verb table, and returns its
/// payload.
fn by_table(verb: &str, w: &mut Words) -> Option<Vec<u8>> {
    let verb = Verb::named(verb)?;
    for parameter in verb.parameters {
        parameter_words(parameter, w);
    }
    let bytes = w.data.below(12) * 8;
    (verb.payload == Payload::Always).then(|| noise(w.data, bytes))
}

fn parameter_words(parameter: &Parameter, w: &mut Words) {
    let most = parameter.arity.most().unwrap_or(12);
    let counts: Vec<usize> =
        (parameter.arity.least()..=most).filter(|n| parameter.arity.allows(*n)).collect();
    for _ in 0..counts[w.data.below(counts.len())] {
        match parameter.kind {
            ParameterKind::Integer => w.whole(),
            ParameterKind::Real => w.real(14.0, 24.0),
            ParameterKind::Angle => match w.data.once_in(2) {
                true => w.one_of(&["45deg", "-1e9deg", "1e308deg", "0deg", "deg"]),
                false => w.real(3.0, 6.0),
            },
            ParameterKind::Color => w.color(),
            ParameterKind::Name => w.one_of(&MESHES),
            ParameterKind::Keyword(list) => w.one_of(list),
            ParameterKind::Flag(word) => w.word(word),
            ParameterKind::Hex => w.one_of(&["00", "ff00ff00", "123", "zz"]),
            ParameterKind::RestOfLine => w.one_of(&["words :9", ":3", "  a  b ", "\u{e9}\t|"]),
            ParameterKind::Payload | ParameterKind::Words => w.word(parameter.name),
        };
    }
}

fn rest(verb: &str, w: &mut Words) -> Option<&'static str> {
    match verb {
        "HELP" => return Some("HELP"),
        "SIZE" => return Some("SIZE"),
        "STATS" => return Some("STATS"),
        "HELLO" => return Some("HELLO"),
        "VERSION" => return Some("VERSION"),
        "FREE" => {
            w.one_of(&["m", "@m", "t", "@t", "e", "@e", "n", "c", "d"]);
        }
        "LOAD" => load(w),
        "DRAW" => {
            w.one_of(&MESHES);
        }
        "DRAWSCENE" => {
            w.maybe(|w| w.real(1.0, 2.0).maybe(|w| w.one_of(&["SORTED"])));
        }
        "DRAWEYE" => {
            w.one_of(&EYES).wholes(2).small(40).small(20);
        }
        "DEPTHAT" => {
            w.small(40).small(20);
            return Some("DEPTHAT");
        }
        "PICK" => {
            w.small(40).small(20);
            return Some("PICK");
        }
        "AUTO" | "EVENTS" => {
            w.one_of(&["on", "off"]);
        }
        "PRESENT" => {
            if w.data.below(2) == 0 {
                w.word("wait");
                return Some("FRAME");
            }
        }
        // The modes `count` and `close` are for streams whose replies are not matched.
        "ERRORS" => {
            w.word("report");
        }
        "SNAP" => {
            w.one_of(&[":", ":", "a.png", "b.ppm", "c.raw", "../a.png", "d/e.png", "link.png", "fifo.png"]);
            return Some("SNAP");
        }
        _ => {}
    }
    None
}

fn load(w: &mut Words) {
    match w.data.below(3) {
        0 => w.word("MESH").one_of(&MESHES),
        1 => w.word("TEX").one_of(&TEXTURES),
        _ => w.word("SCENE"),
    };
    w.one_of(&super::files::NAMES);
}
