//! Changes of a whole picture: upside down, mirrored, turned, shifted, scaled.
//!
//! In: both pictures. Out: the change that, applied to the exact picture, gives most of the drawn
//! one. A change is found only if it takes away nine of ten wrong pixels (seven of ten for a scale,
//! whose edges fall between pixels), so that a local error is none.

use super::distance;
use super::pixels::{Pixels, pixel};
use fbptr_core::memory::VideoMemory;
use std::fmt;

/// Change of a whole picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Whole {
    /// Rows in reverse order.
    UpsideDown,
    /// Columns in reverse order.
    Mirrored,
    /// Both.
    HalfTurn,
    /// Moved by (x, y) pixels, y down.
    Shifted([i64; 2]),
    /// Magnified by a factor about the picture's middle.
    Scaled(f64),
}

impl fmt::Display for Whole {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Whole::UpsideDown => f.write_str(
                "the picture is upside down: row 0 is the upper one here, and the lower one in OpenGL; the \
                 viewport's matrix turns y around",
            ),
            Whole::Mirrored => f.write_str("the picture is mirrored: left and right are exchanged"),
            Whole::HalfTurn => f.write_str("the picture is turned by 180 degrees: x and y are both reversed"),
            Whole::Shifted([x, y]) => {
                let side = |v: i64, more: &str, less: &str| match v {
                    0 => String::new(),
                    v => format!(" {} to the {}", v.abs(), if v > 0 { more } else { less }),
                };
                let (across, down) = (side(x, "right", "left"), side(y, "bottom", "top"));
                let and = if across.is_empty() || down.is_empty() { "" } else { " and" };
                write!(f, "the picture is shifted, by pixels:{across}{and}{down}; ")?;
                f.write_str("one pixel comes from rounding where the exact rule takes the pixel that contains the point")
            }
            Whole::Scaled(k) => write!(
                f,
                "the picture is scaled by {k:.3} about its middle: the field of view has tan(fov/2) {:.3} times \
                 as large; is the angle meant for the height, the width or the smaller side?",
                1.0 / k
            ),
        }
    }
}

/// Number of pixels at most that the search for a scale looks at.
const SAMPLES: u64 = 40_000;
/// Largest shift that is searched, beside that of the outlines.
const NEAR: i64 = 4;
/// Largest difference of a channel between a scaled picture and the exact one.
const SCALED: u8 = 24;

impl Whole {
    /// Finds a change that leaves at most one `part` of the wrong pixels wrong.
    pub(super) fn find(pixels: &Pixels<'_>, places: &[[u32; 2]], part: usize) -> Option<Whole> {
        let wrong = places.len();
        if wrong < 4 {
            return None;
        }
        // A scale moves edges, and does not change all colours a little.
        let is_far = places.iter().filter(|at| pixels.distance(**at) > SCALED).count() * 2 >= wrong;
        let moves = [Whole::UpsideDown, Whole::Mirrored, Whole::HalfTurn].into_iter();
        let moves = moves.chain(shifts(pixels).into_iter().map(Whole::Shifted));
        let best = moves.map(|whole| (whole.wrong_after(pixels, wrong), whole));
        let best = best.min_by_key(|(after, whole)| (*after, whole.effort()));
        match best {
            Some((after, whole)) if after * part <= wrong => Some(whole),
            _ if is_far && part <= 10 => scale(pixels),
            _ => None,
        }
    }

    /// A measure of how far-fetched a change is, among those that explain equally much.
    fn effort(&self) -> i64 {
        match self {
            Whole::Shifted([x, y]) => x.abs() + y.abs(),
            _ => 0,
        }
    }

    /// Returns the place in the exact picture that a place of the drawn one shows.
    fn source(&self, [w, h]: [i64; 2], [x, y]: [i64; 2]) -> [i64; 2] {
        match *self {
            Whole::UpsideDown => [x, h - 1 - y],
            Whole::Mirrored => [w - 1 - x, y],
            Whole::HalfTurn => [w - 1 - x, h - 1 - y],
            Whole::Shifted([dx, dy]) => [x - dx, y - dy],
            Whole::Scaled(k) => [unscaled(x, w, k), unscaled(y, h, k)],
        }
    }

    /// Counts the pixels that stay wrong if the change is the cause, up to `enough`.
    fn wrong_after(&self, pixels: &Pixels<'_>, enough: usize) -> usize {
        let size = pixels.size.map(i64::from);
        let mut count = 0;
        for (at, found) in places(size).zip(pixels.mine.bytes().as_chunks::<4>().0) {
            let [x, y] = self.source(size, at);
            // What comes in from outside is background.
            let right = pixel(pixels.exact, x, y).unwrap_or(pixels.background);
            count += usize::from(!pixels.is_same(*found, right));
            if count >= enough {
                break;
            }
        }
        count
    }
}

fn places([w, h]: [i64; 2]) -> impl Iterator<Item = [i64; 2]> {
    (0..h).flat_map(move |y| (0..w).map(move |x| [x, y]))
}

fn unscaled(v: i64, side: i64, k: f64) -> i64 {
    let middle = side as f64 / 2.0;
    ((v as f64 + 0.5 - middle) / k + middle).floor() as i64
}

/// Returns the rectangle x0, y0, x1, y1 of what is not background; `None` if nothing is.
fn outline(picture: &VideoMemory, pixels: &Pixels<'_>) -> Option<[i64; 4]> {
    let mut all = None;
    let size = pixels.size.map(i64::from);
    for ([x, y], color) in places(size).zip(picture.bytes().as_chunks::<4>().0) {
        if !pixels.is_same(*color, pixels.background) {
            let [x0, y0, x1, y1] = all.unwrap_or([x, y, x, y]);
            all = Some([x.min(x0), y.min(y0), x.max(x1), y.max(y1)]);
        }
    }
    all
}

/// Returns the shifts that are tried: all near ones, and those between the outlines' sides.
fn shifts(pixels: &Pixels<'_>) -> Vec<[i64; 2]> {
    let mut all: Vec<_> = (-NEAR..=NEAR).flat_map(|y| (-NEAR..=NEAR).map(move |x| [x, y])).collect();
    let exact = outline(pixels.exact, pixels);
    if let (Some(a), Some(b)) = (outline(pixels.mine, pixels), exact) {
        all.extend([[a[0] - b[0], a[1] - b[1]], [a[2] - b[2], a[3] - b[3]]]);
    }
    // A picture that is moved out of sight would explain any picture of almost nothing.
    let size = pixels.size.map(i64::from);
    let is_seen = |shift: &[i64; 2]| {
        exact.is_none_or(|[x0, y0, x1, y1]| {
            let seen = |side: usize, from: i64, to: i64| {
                ((to + shift[side]).min(size[side] - 1) - (from + shift[side]).max(0) + 1).max(0)
            };
            2 * seen(0, x0, x1) * seen(1, y0, y1) >= (x1 - x0 + 1) * (y1 - y0 + 1)
        })
    };
    all.retain(|shift| *shift != [0, 0] && is_seen(shift));
    all
}

/// Returns the share of the sampled pixels that show something and agree if the picture is scaled
/// by `k`.
fn agreement(pixels: &Pixels<'_>, k: f64) -> f64 {
    let [w, h] = pixels.size.map(i64::from);
    let step = ((w as u64 * h as u64) / SAMPLES).isqrt().max(1) as usize;
    let (mut same, mut all) = (0u32, 0u32);
    for y in (0..h).step_by(step) {
        for x in (0..w).step_by(step) {
            let [sx, sy] = Whole::Scaled(k).source([w, h], [x, y]);
            let Some(found) = pixel(pixels.mine, x, y) else { continue };
            let Some(right) = pixel(pixels.exact, sx, sy) else { continue };
            if [found, right].iter().all(|c| pixels.is_same(*c, pixels.background)) {
                continue;
            }
            all += 1;
            same += u32::from(distance(found, right) <= SCALED);
        }
    }
    if all < 16 { 0.0 } else { f64::from(same) / f64::from(all) }
}

/// Finds a scale about the middle.
fn scale(pixels: &Pixels<'_>) -> Option<Whole> {
    let best_of = |range: &mut dyn Iterator<Item = f64>| {
        range.map(|k| (agreement(pixels, k), k)).max_by(|a, b| a.0.total_cmp(&b.0))
    };
    let (_, near) = best_of(&mut (-45..=45).map(|i| 1.02f64.powi(i)))?;
    let finer = |i: i32| near * (1.0 + f64::from(i) * 0.001);
    let (share, _) = best_of(&mut (-20..=20).map(finer))?;
    // The middle of those that agree as well: pixels are coarse.
    let as_well: Vec<f64> =
        (-20..=20).map(finer).filter(|k| agreement(pixels, *k) >= share - 0.002).collect();
    let k = as_well.iter().sum::<f64>() / as_well.len() as f64;
    let before = agreement(pixels, 1.0);
    let is_found = share >= 0.85 && 1.0 - share <= 0.3 * (1.0 - before) && (k - 1.0).abs() > 0.01;
    is_found.then_some(Whole::Scaled(k))
}
