//! One command of each verb, with arguments that look right.

use super::dice::Dice;
use super::payloads;
use super::words::{EYES, MESHES, TEXTURES, Taste, Words};

/// A command as it is sent, and what its reply begins with, if it has one.
pub struct Written {
    pub bytes: Vec<u8>,
    pub reply: Option<&'static str>,
}

/// The verbs, each as often as it leads somewhere. Every verb of `HELP` is here.
pub const VERBS: [&str; 100] = [
    "HELP",
    "SIZE",
    "PX",
    "PX",
    "PX",
    "PB",
    "PXMULTI",
    "OFFSET",
    "STATS",
    "QUIT",
    "POKE",
    "PEEK",
    "BLIT",
    "BLIT",
    "READ",
    "COPY",
    "POINTS",
    "CRC",
    "CRC",
    "CLEAR",
    "LINE",
    "LINE",
    "LINE",
    "TRI",
    "FILL",
    "FILL",
    "FILL",
    "RECT",
    "FILLRECT",
    "CIRCLE",
    "FILLCIRCLE",
    "POLY",
    "FILLPOLY",
    "FILLPOLY",
    "TEXT",
    "LINEAA",
    "LINEAA",
    "BLEND",
    "MESH",
    "MESH",
    "MESH",
    "MESH",
    "TEX",
    "TEX",
    "SCENE",
    "SCENE",
    "EYE",
    "EYE",
    "FREE",
    "LOAD",
    "LOAD",
    "LOOKAT",
    "PERSPECTIVE",
    "PLANE",
    "FRUSTUM",
    "ORTHO",
    "OBLIQUE",
    "ISOMETRIC",
    "PSEUDOISO",
    "WINDOW",
    "VIEWPORT",
    "IDENTITY",
    "PUSH",
    "POP",
    "TRANSLATE",
    "ROTATE",
    "SCALE",
    "SHEAR",
    "MATRIX",
    "AMBIENT",
    "LIGHT",
    "LIGHT",
    "MATERIAL",
    "TEXTURE",
    "TEXTURE",
    "SHADE",
    "SHADE",
    "CULL",
    "HIDE",
    "DEPTH",
    "INTERP",
    "DRAW",
    "DRAW",
    "DRAW",
    "DRAW",
    "DRAW",
    "DRAWSCENE",
    "DRAWSCENE",
    "DRAWEYE",
    "DRAWEYE",
    "QUALITY",
    "DEPTHAT",
    "PICK",
    "HELLO",
    "VERSION",
    "AUTO",
    "PRESENT",
    "EVENTS",
    "ERRORS",
    "SNAP",
];

/// Any command. `SYNC` is written by the caller, with a tag of its own.
pub fn any(dice: &mut Dice, taste: Taste) -> Written {
    let verb = VERBS[dice.below(VERBS.len())];
    one(verb, dice, taste)
}

/// What makes `DRAW` show something: a mesh, a light, a camera.
pub fn setting(dice: &mut Dice, taste: Taste) -> Vec<Written> {
    let verbs = ["MESH", "LOOKAT", "PERSPECTIVE", "LIGHT", "TEX", "TEXTURE", "SHADE", "DRAW", "EYE", "SCENE"];
    let calm = Taste { extreme: taste.extreme * 3, ..taste };
    verbs[..3 + dice.below(8)].iter().map(|verb| one(verb, dice, calm)).collect()
}

fn one(verb: &'static str, dice: &mut Dice, taste: Taste) -> Written {
    match verb {
        "PB" | "PXMULTI" => return binary(verb, dice),
        _ => {}
    }
    // Verbs may be written in lower case; those that begin with PB may not.
    let line = if dice.once_in(16) { verb.to_lowercase() } else { verb.to_owned() };
    let mut w = Words { dice, taste, line };
    let mut payload = None;
    let reply = match verb {
        "BLIT" | "POINTS" | "TEXT" | "MESH" | "TEX" | "SCENE" | "EYE" => {
            payload = with_payload(verb, &mut w);
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
        _ => rest(verb, &mut w),
    };
    let mut line = std::mem::take(&mut w.line);
    if let Some(payload) = &payload {
        // Now and then of another length than the words say.
        line += &format!(" :{}", payload.len());
    }
    line += if w.dice.once_in(12) { "\r\n" } else { "\n" };
    let mut bytes = line.into_bytes();
    bytes.extend(payload.unwrap_or_default());
    Written { bytes, reply }
}

fn binary(verb: &str, dice: &mut Dice) -> Written {
    let mut bytes = verb.as_bytes().to_vec();
    let at = |dice: &mut Dice| {
        (if dice.once_in(6) { dice.below(65_536) } else { dice.below(70) } as u16).to_le_bytes()
    };
    let (x, y) = (at(dice), at(dice));
    bytes.extend(x.into_iter().chain(y));
    let pixels = match verb {
        "PB" => 1,
        _ => {
            let pixels = dice.below(60);
            bytes.extend((pixels as u32).to_le_bytes());
            pixels
        }
    };
    for _ in 0..pixels {
        bytes.extend((dice.below(65_536) as u32 * 40_503).to_le_bytes());
    }
    Written { bytes, reply: None }
}

fn with_payload(verb: &str, w: &mut Words) -> Option<Vec<u8>> {
    let mut payload = match verb {
        "BLIT" => {
            let (width, height) = (w.dice.below(24), w.dice.below(12));
            w.wholes(2).word(&width.to_string()).word(&height.to_string());
            noise(w.dice, width * height * 4)
        }
        "POINTS" => {
            let points = w.dice.below(50);
            let mut bytes = noise(w.dice, points * 8);
            // Places on the frame, most of them.
            bytes
                .chunks_mut(8)
                .for_each(|p| [p[0], p[1], p[2], p[3]] = [p[0] & 63, p[1] & 1, p[2] & 63, p[3] & 1]);
            bytes
        }
        "TEXT" => {
            w.wholes(2).color();
            let bytes = w.dice.below(30);
            if w.dice.once_in(4) {
                noise(w.dice, bytes)
            } else {
                "a\nb \u{e9}\tZ\u{20ac}gj|".repeat(3).into_bytes()
            }
        }
        "MESH" => return mesh(w),
        "TEX" => {
            w.one_of(&TEXTURES);
            payloads::picture(w.dice)
        }
        "SCENE" => {
            w.word("X3D");
            payloads::x3d(w.dice)
        }
        _ => {
            w.one_of(&EYES);
            payloads::world(w.dice)
        }
    };
    if w.dice.once_in(30) {
        payload.pop();
    }
    Some(payload)
}

fn mesh(w: &mut Words) -> Option<Vec<u8>> {
    w.one_of(&MESHES);
    match w.dice.below(12) {
        0 => w.word("BOX").maybe(|w| drop(w.reals(3, 2.0, 1.9))),
        1 => w.word("SPHERE").maybe(|w| drop(w.real(1.0, 0.9))),
        2 => w.word("CONE").maybe(|w| drop(w.reals(2, 1.0, 0.9))),
        3 => w.word("CYLINDER").maybe(|w| drop(w.reals(2, 1.0, 0.9))),
        4 => w.word("TEAPOT").small(4),
        5 => w.word("KNOT").small(12).small(8),
        _ => {
            w.word("OBJ");
            return Some(payloads::obj(w.dice, w.taste));
        }
    };
    None
}

fn noise(dice: &mut Dice, bytes: usize) -> Vec<u8> {
    let seed = dice.bits();
    (0..bytes as u64).map(|i| (seed.wrapping_mul(2 * i + 1) >> 29) as u8).collect()
}

fn memory(verb: &str, w: &mut Words) -> Option<&'static str> {
    match verb {
        "PX" => {
            w.wholes(2);
            if w.dice.below(3) == 0 {
                return Some("PX");
            }
            w.color();
        }
        "OFFSET" => drop(w.wholes(2)),
        "POKE" => drop(w.small(4000).one_of(&["00", "ff00ff00", "123", "0102030405060708090a0b0c", "zz"])),
        "PEEK" => {
            w.small(4000).small(64);
            return Some("PEEK");
        }
        "READ" => {
            w.small(20).small(9).small(30).small(9);
            return Some("READ");
        }
        "COPY" => drop(w.small(12).small(6).small(16).small(9).wholes(2)),
        "CRC" => {
            w.maybe(|w| drop(w.small(20).small(9).small(30).small(9)));
            return Some("CRC");
        }
        _ => drop(w.maybe(|w| drop(w.color()))),
    }
    None
}

fn plane(verb: &str, w: &mut Words) {
    match verb {
        "LINE" => drop(w.wholes(4).color().maybe(|w| drop(w.color()))),
        "TRI" => drop(w.wholes(6).color().maybe(|w| drop(w.color().color()))),
        "FILL" => drop(w.reals(6, 16.0, 40.0).color().maybe(|w| drop(w.color().color()))),
        "RECT" => drop(w.wholes(4).color()),
        "FILLRECT" => drop(w.reals(2, 8.0, 20.0).reals(2, 10.0, 12.0).color()),
        "CIRCLE" => drop(w.wholes(3).color()),
        "FILLCIRCLE" => drop(w.reals(2, 16.0, 20.0).real(10.0, 11.0).color()),
        "LINEAA" => drop(w.reals(4, 16.0, 40.0).color()),
        _ => {
            w.color();
            for _ in 0..1 + w.dice.below(9) {
                if verb == "POLY" {
                    w.wholes(2)
                } else {
                    w.reals(2, 16.0, 40.0)
                };
            }
        }
    }
}

fn camera(verb: &str, w: &mut Words) {
    let range = |w: &mut Words| drop(w.real(0.6, 0.5).real(20.0, 15.0));
    let window = |w: &mut Words| drop(w.real(-2.0, 1.0).real(2.0, 1.0).real(-2.0, 1.0).real(2.0, 1.0));
    match verb {
        "LOOKAT" => {
            drop(w.reals(3, 3.0, 4.0).reals(3, 0.0, 1.0).real(0.0, 0.3).real(1.0, 0.3).real(0.0, 0.3))
        }
        "PERSPECTIVE" => {
            w.real(1.0, 0.9);
            range(w);
            w.maybe(|w| drop(w.one_of(&["FOVMIN"])));
        }
        "PLANE" => {
            w.real(1.0, 0.9);
            range(w);
        }
        "OBLIQUE" => {
            w.one_of(&["cavalier", "cabinet"]).real(0.8, 1.0);
            window(w);
            range(w);
        }
        "WINDOW" => {
            w.reals(3, 4.0, 1.0)
                .reals(3, 0.0, 1.0)
                .reals(2, 0.0, 0.3)
                .real(1.0, 0.3)
                .reals(2, 0.0, 0.4)
                .reals(2, 1.0, 0.8);
            w.real(1.0, 0.8);
            range(w);
        }
        "VIEWPORT" => {
            drop(w.wholes(2).small(60).small(40).maybe(|w| drop(w.one_of(&["centres", "corners"]))))
        }
        _ => {
            window(w);
            range(w);
        }
    }
}

fn look(verb: &str, w: &mut Words) {
    let color = |w: &mut Words| match w.dice.below(4) {
        0 => w.one_of(&["white", "#80", "#ff8000", "navy"]),
        _ => w.reals(3, 0.5, 0.6),
    };
    match verb {
        "AMBIENT" => drop(color(w)),
        "LIGHT" => light(w, color),
        "MATERIAL" => {
            for _ in 0..3 {
                color(w);
            }
            w.real(10.0, 12.0);
            w.maybe(|w| {
                color(w);
                w.maybe(|w| drop(w.real(0.4, 0.5)));
            });
        }
        "TEXTURE" => {
            w.one_of(&["t", "@t", "u", "OFF"]);
            w.maybe(|w| drop(w.one_of(&["nearest", "bilinear", "mipmap", "trilinear"])));
            w.maybe(|w| drop(w.one_of(&["repeat", "clamp"])));
        }
        "SHADE" => drop(w.one_of(&["wire", "flat", "gouraud", "phong"])),
        "CULL" => drop(w.one_of(&["back", "front", "none"])),
        "HIDE" => drop(w.one_of(&["zbuffer", "painter", "none"])),
        "DEPTH" => drop(w.one_of(&["u16", "u24", "u32", "f32", "reversed"])),
        "INTERP" => drop(w.one_of(&["perspective", "affine"])),
        "BLEND" => drop(w.one_of(&["over", "over", "replace"])),
        _ => match w.dice.below(3) {
            0 => drop(w.word("exact")),
            _ => drop(w.word("max-error").real(20.0, 22.0)),
        },
    }
}

fn light(w: &mut Words, color: impl for<'w, 'd, 'i> Fn(&'w mut Words<'d, 'i>) -> &'w mut Words<'d, 'i>) {
    w.small(4);
    match w.dice.below(7) {
        0 => drop(w.word("OFF")),
        1 | 2 => {
            w.word("DIR").reals(3, -1.0, 1.5);
            color(w);
        }
        3 | 4 => {
            w.word("SPOT").reals(3, 2.0, 3.0).reals(3, -1.0, 1.0).real(0.7, 0.7).real(2.0, 3.0);
            color(w).maybe(|w| drop(w.reals(3, 0.5, 0.6)));
        }
        _ => {
            w.word("POINT").reals(3, 2.0, 3.0);
            color(w).maybe(|w| drop(w.reals(3, 0.5, 0.6)));
        }
    }
}

fn matrix(verb: &str, w: &mut Words) {
    match verb {
        "TRANSLATE" => drop(w.reals(3, 0.0, 2.0)),
        "ROTATE" => drop(w.reals(4, 0.5, 1.0)),
        "SCALE" => drop(w.reals(3, 1.0, 1.2)),
        "SHEAR" => drop(w.reals(6, 0.0, 0.7)),
        "MATRIX" => {
            w.reals(12, 0.3, 1.0);
            w.word("0 0 0").one_of(&["1", "1", "1", "2", "0"]);
        }
        _ => {}
    }
}

fn rest(verb: &str, w: &mut Words) -> Option<&'static str> {
    match verb {
        "HELP" => return Some("HELP"),
        "SIZE" => return Some("SIZE"),
        "STATS" => return Some("STATS"),
        "HELLO" => return Some("HELLO"),
        "VERSION" => return Some("VERSION"),
        "FREE" => drop(w.one_of(&["m", "@m", "t", "@t", "e", "@e", "n"])),
        "LOAD" => load(w),
        "DRAW" => drop(w.one_of(&MESHES)),
        "DRAWSCENE" => drop(w.maybe(|w| drop(w.real(1.0, 2.0).maybe(|w| drop(w.one_of(&["SORTED"])))))),
        "DRAWEYE" => drop(w.one_of(&EYES).wholes(2).small(40).small(20)),
        "DEPTHAT" => {
            w.small(40).small(20);
            return Some("DEPTHAT");
        }
        "PICK" => {
            w.small(40).small(20);
            return Some("PICK");
        }
        "AUTO" | "EVENTS" => drop(w.one_of(&["on", "off"])),
        "PRESENT" => {
            if w.dice.below(2) == 0 {
                w.word("wait");
                return Some("FRAME");
            }
        }
        // To count or to close is for the streams whose replies are not matched.
        "ERRORS" => drop(w.word("report")),
        "SNAP" => {
            w.one_of(&[":", ":", "a.png", "b.ppm", "c.raw", "../a.png", "d/e.png", "link.png", "fifo.png"]);
            return Some("SNAP");
        }
        _ => {}
    }
    None
}

fn load(w: &mut Words) {
    match w.dice.below(3) {
        0 => w.word("MESH").one_of(&MESHES),
        1 => w.word("TEX").one_of(&TEXTURES),
        _ => w.word("SCENE"),
    };
    w.one_of(&super::files::NAMES);
}
