//! Writes the words of the 3-D state: cameras, matrices, lights, materials and modes.

use super::words::Words;

/// Writes the words of a camera verb.
pub fn camera(verb: &str, w: &mut Words) {
    let range = |w: &mut Words| {
        w.real(0.6, 0.5).real(20.0, 15.0);
    };
    let window = |w: &mut Words| {
        w.real(-2.0, 1.0).real(2.0, 1.0).real(-2.0, 1.0).real(2.0, 1.0);
    };
    match verb {
        "LOOKAT" => {
            w.reals(3, 3.0, 4.0).reals(3, 0.0, 1.0).real(0.0, 0.3).real(1.0, 0.3).real(0.0, 0.3);
        }
        "PERSPECTIVE" => {
            w.real(1.0, 0.9);
            range(w);
            w.maybe(|w| w.one_of(&["FOVMIN"]));
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
            w.wholes(2).small(60).small(40).maybe(|w| w.one_of(&["centres", "corners"]));
        }
        _ => {
            window(w);
            range(w);
        }
    }
}

/// Writes the words of a verb that sets colours, lights, textures or modes.
pub fn look(verb: &str, w: &mut Words) {
    match verb {
        "AMBIENT" => {
            color(w);
        }
        "LIGHT" => light(w),
        "MATERIAL" => {
            for _ in 0..3 {
                color(w);
            }
            w.real(10.0, 12.0);
            w.maybe(|w| color(w).maybe(|w| w.real(0.4, 0.5)));
        }
        "TEXTURE" => {
            w.one_of(&["t", "@t", "u", "OFF"]);
            w.maybe(|w| w.one_of(&["nearest", "bilinear", "mipmap", "trilinear"]));
            w.maybe(|w| w.one_of(&["repeat", "clamp"]));
        }
        "SHADE" => {
            w.one_of(&["wire", "flat", "gouraud", "phong"]);
        }
        "CULL" => {
            w.one_of(&["back", "front", "none"]);
        }
        "HIDE" => {
            w.one_of(&["zbuffer", "painter", "none"]);
        }
        "DEPTH" => {
            w.one_of(&["u16", "u24", "u32", "f32", "reversed"]);
        }
        "INTERP" => {
            w.one_of(&["perspective", "affine"]);
        }
        "BLEND" => {
            w.one_of(&["over", "over", "replace"]);
        }
        _ => match w.data.below(3) {
            0 => {
                w.word("exact");
            }
            _ => {
                w.word("max-error").real(20.0, 22.0);
            }
        },
    }
}

/// Writes a colour of a light or material.
fn color<'w, 'd, 'i>(w: &'w mut Words<'d, 'i>) -> &'w mut Words<'d, 'i> {
    match w.data.below(4) {
        0 => w.one_of(&["white", "#80", "#ff8000", "navy"]),
        _ => w.reals(3, 0.5, 0.6),
    }
}

fn light(w: &mut Words) {
    w.small(4);
    match w.data.below(7) {
        0 => {
            w.word("OFF");
        }
        1 | 2 => {
            w.word("DIR").reals(3, -1.0, 1.5);
            color(w);
        }
        3 | 4 => {
            w.word("SPOT").reals(3, 2.0, 3.0).reals(3, -1.0, 1.0).real(0.7, 0.7).real(2.0, 3.0);
            color(w).maybe(|w| w.reals(3, 0.5, 0.6));
        }
        _ => {
            w.word("POINT").reals(3, 2.0, 3.0);
            color(w).maybe(|w| w.reals(3, 0.5, 0.6));
        }
    }
}

/// Writes the words of a verb of the model matrix.
pub fn matrix(verb: &str, w: &mut Words) {
    match verb {
        "TRANSLATE" => {
            w.reals(3, 0.0, 2.0);
        }
        "ROTATE" => {
            w.reals(4, 0.5, 1.0);
        }
        "SCALE" => {
            w.reals(3, 1.0, 1.2);
        }
        "SHEAR" => {
            w.reals(6, 0.0, 0.7);
        }
        "MATRIX" => {
            w.reals(12, 0.3, 1.0);
            w.word("0 0 0").one_of(&["1", "1", "1", "2", "0"]);
        }
        _ => {}
    }
}
