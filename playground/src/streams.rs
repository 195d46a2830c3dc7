//! Writes streams into a folder, and prints the CRC-32 of each one's last frame, drawn natively:
//! the tour, test data that a stream can carry, and random streams. `playground/check.mjs` draws
//! the same streams in the engine of the page.
//!
//! Usage: `streams DATA OUT [COUNT]`, where `DATA` is `tests/data`, and `COUNT` the number of
//! random streams.

#[path = "../../tests/lean/src/files.rs"]
mod files;

use fbptr_engine::Pace;
use fbptr_playground::{Player, View};
use files::files;
use std::error::Error;
use std::fmt::Write;
use std::path::{Path, PathBuf};

type Outcome = Result<(), Box<dyn Error>>;

fn main() -> Outcome {
    let mut words = std::env::args_os().skip(1);
    let mut folder = || words.next().map(PathBuf::from).ok_or("expected: streams DATA OUT [COUNT]");
    let (data, out) = (folder()?, folder()?);
    let count = words.next().map_or(Ok(200), |word| word.to_string_lossy().parse())?;
    std::fs::create_dir_all(&out)?;
    let tour = std::fs::read(data.join("../../demos/tour.fbs"))?;
    draw(&out.join("tour.fbs"), tour)?;
    let kinds = [("x3d", "x3d"), ("meshes", "obj"), ("nd-cases", "json")];
    for (folder, ending) in kinds {
        for path in files(&data.join(folder), ending)? {
            let bytes = std::fs::read(&path)?;
            let stem = path.strip_prefix(&data)?.to_string_lossy().replace(['/', '\\'], "-");
            draw(&out.join(format!("{stem}.fbs")), carried(ending, &bytes))?;
        }
    }
    for seed in 0..count {
        draw(&out.join(format!("random-{seed}.fbs")), Random::stream(seed).into_bytes())?;
    }
    Ok(())
}

/// Draws a stream, writes it, and prints its checksum.
fn draw(path: &Path, stream: Vec<u8>) -> Outcome {
    std::fs::write(path, &stream)?;
    let mut player = Player::new(stream, &View::default())?;
    let _ = player.run(Pace::Free);
    println!("{} {:08x}", path.display(), player.crc());
    Ok(())
}

/// Returns a stream that carries a file, and draws it.
fn carried(kind: &str, file: &[u8]) -> Vec<u8> {
    let (head, tail) = match kind {
        "x3d" => ("SCENE X3D", "\nDRAWSCENE 1\n"),
        "obj" => ("MESH m OBJ", "\nDRAW m\n"),
        _ => ("EYE e", "\nDRAWEYE e 0 0 120 90\n"),
    };
    let head = format!("SIZE 120 90\n{head} :{}\n", file.len());
    [head.as_bytes(), file, tail.as_bytes()].concat()
}

/// Numbers of a linear congruential generator; whole numbers alone, so the same everywhere.
struct Random(u64);

impl Random {
    fn below(&mut self, n: u32) -> u32 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (((self.0 >> 32) * u64::from(n)) >> 32) as u32
    }

    /// Returns words of `count` multiples of 1/256 in `low..high`.
    fn reals(&mut self, count: usize, low: i32, high: i32) -> String {
        let real = |r: &mut Self| f64::from(low) + f64::from(r.below(256)) * f64::from(high - low) / 256.0;
        (0..count).map(|_| format!(" {}", real(self))).collect()
    }

    fn ints(&mut self, count: usize) -> String {
        (0..count).map(|_| format!(" {}", self.below(200) as i32 - 20)).collect()
    }

    fn color(&mut self) -> String {
        format!(" {:06x}{:02x}", self.below(1 << 24), self.below(256))
    }

    fn pick<'a>(&mut self, words: &[&'a str]) -> &'a str {
        words[self.below(words.len() as u32) as usize]
    }

    /// Returns the random stream of a seed: figures under meshes in random states.
    fn stream(seed: u64) -> String {
        let mut r = Random(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15));
        let mut s = format!("SIZE 160 120\nDEPTH {}\n", r.pick(&["u16", "u24", "u32", "f32", "reversed"]));
        for _ in 0..8 {
            r.figure(&mut s);
        }
        s += "LOOKAT 0 0 6 0 0 0 0 1 0\nPERSPECTIVE 45deg 0.5 40\n";
        for _ in 0..1 + r.below(4) {
            r.mesh(&mut s);
        }
        r.figure(&mut s);
        s
    }

    fn figure(&mut self, s: &mut String) {
        *s += &format!("BLEND {}\n", self.pick(&["replace", "over"]));
        *s += &match self.below(9) {
            0 => format!("LINE{}{}{}\n", self.ints(4), self.color(), self.color()),
            1 => format!("LINEAA{}{}\n", self.reals(4, -20, 180), self.color()),
            2 => format!("FILL{}{}{}{}\n", self.reals(6, -20, 180), self.color(), self.color(), self.color()),
            3 => format!("FILLCIRCLE{}{}{}\n", self.reals(2, 0, 160), self.reals(1, 0, 60), self.color()),
            4 => format!("FILLPOLY{}{}\n", self.color(), self.reals(8, -20, 180)),
            5 => format!("WIDELINE{}{}{}\n", self.reals(4, -20, 180), self.reals(1, 1, 20), self.color()),
            6 => format!("ELLIPSE{}{}{}\n", self.reals(2, 0, 160), self.reals(2, 1, 60), self.color()),
            7 => format!("BEZIER{}{}{}\n", self.reals(8, -20, 180), self.reals(1, 1, 9), self.color()),
            _ => format!("PRINT{}{} random\n", self.ints(2), self.color()),
        };
    }

    fn mesh(&mut self, s: &mut String) {
        let light = match self.below(3) {
            0 => format!("POINT{}{}", self.reals(3, -6, 6), self.reals(3, 0, 1)),
            1 => format!("DIR{} -3{}", self.reals(2, -1, 1), self.reals(3, 0, 1)),
            _ => format!("SPOT{} 0 0 -3 0.9 2{}", self.reals(3, -1, 6), self.reals(3, 0, 1)),
        };
        let mesh = match self.below(6) {
            0 => format!("SPHERE{}", self.reals(1, 1, 2)),
            1 => format!("BOX{}", self.reals(3, 1, 3)),
            2 => format!("CONE{}", self.reals(2, 1, 3)),
            3 => format!("CYLINDER{}", self.reals(2, 1, 2)),
            4 => format!("TEAPOT {}", 1 + self.below(6)),
            _ => format!("KNOT {} {}", 20 + self.below(60), 3 + self.below(12)),
        };
        let transparency = if self.below(3) == 0 { self.reals(1, 0, 1) } else { String::from(" 0") };
        let filter = self.pick(&["nearest", "bilinear", "mipmap", "trilinear"]);
        let wrap = self.pick(&["repeat", "clamp"]);
        let texture = match self.below(2) {
            0 => format!(
                "TEX t :50\nP3 2 2 255  255 160 0  40 0 80  40 0 80  255 160 0\nTEXTURE t {filter} {wrap}\n"
            ),
            _ => String::from("TEXTURE OFF\n"),
        };
        let shade = self.pick(&["wire", "flat", "gouraud", "phong"]);
        let cull = self.pick(&["back", "front", "none"]);
        let hide = self.pick(&["zbuffer", "painter", "none"]);
        let interp = self.pick(&["perspective", "affine"]);
        let (place, turn) = (self.reals(3, -1, 2), self.reals(3, -3, 3));
        let (ambient, material) = (self.reals(3, 0, 1), self.reals(9, 0, 1));
        let _ = write!(
            s,
            "LIGHT {} {light}\nMESH m {mesh}\n{texture}SHADE {shade}\nCULL {cull}\nHIDE {hide}\nINTERP {interp}\n\
             AMBIENT{ambient}\nMATERIAL{material} 20 0 0 0{transparency}\nIDENTITY\nTRANSLATE{place}\n\
             ROTATE 0 1 3{}\nDRAW m\n",
            self.below(3),
            &turn[..turn[1..].find(' ').map_or(turn.len(), |at| at + 1)],
        );
    }
}
