//! Laws of colour: the wrong colours of a picture as a function of the right ones.
//!
//! In: the wrong pixels that are background in neither picture. Out: the simplest of: channels
//! exchanged, a factor, a summand, a power, that gives at least six of ten of them within two steps
//! of 255. With one right colour alone, these laws cannot be told apart; the text says so.

use super::pixels::Pixels;
use fbptr_core::memory::Rgba;
use std::fmt;

/// Largest difference of a channel between the law and what was found.
const STEPS: f64 = 2.0;
/// Least number of pixels that a law is made of.
const LEAST: usize = 4;

#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    /// Blue, green, red.
    Exchanged,
    Factor([f64; 3]),
    Summand([f64; 3]),
    Power(f64),
}

/// Law of the wrong colours.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Law {
    kind: Kind,
    /// Share of the wrong pixels, background in neither picture, that it gives.
    share: f64,
    /// True if there is one right colour alone.
    is_of_one_color: bool,
}

impl Kind {
    fn apply(&self, right: Rgba) -> [f64; 3] {
        let [r, g, b, _] = right.map(f64::from);
        match *self {
            Kind::Exchanged => [b, g, r],
            Kind::Factor(k) => [r * k[0], g * k[1], b * k[2]],
            Kind::Summand(d) => [r + d[0], g + d[1], b + d[2]],
            Kind::Power(e) => [r, g, b].map(|v| 255.0 * (v / 255.0).powf(e)),
        }
        .map(|v| v.clamp(0.0, 255.0))
    }

    fn gives(&self, found: Rgba, right: Rgba) -> bool {
        let v = self.apply(right);
        (0..3).all(|c| (v[c] - f64::from(found[c])).abs() <= STEPS)
    }
}

/// Pair of colours: found, right.
type Pair = (Rgba, Rgba);

fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied()
}

/// Returns the median of `f` over a channel's values that are not cut off at 0 or 255.
fn of_channel(pairs: &[Pair], c: usize, f: impl Fn(f64, f64) -> f64) -> Option<f64> {
    let inside = pairs.iter().map(|(m, e)| (m[c], e[c])).filter(|(m, e)| *m < 255 && *m > 0 && *e > 0);
    // Dark colours have few steps to tell a ratio by.
    let bright: Vec<_> = inside.clone().filter(|(_, e)| *e > 40).collect();
    let values: Vec<_> = if bright.is_empty() { inside.collect() } else { bright };
    median(values.into_iter().map(|(m, e)| f(m.into(), e.into())).collect())
}

/// Returns the value of all three channels; a channel without values has that of the others.
fn of_channels(pairs: &[Pair], f: impl Fn(f64, f64) -> f64) -> Option<[f64; 3]> {
    let each: [Option<f64>; 3] = std::array::from_fn(|c| of_channel(pairs, c, &f));
    let any = each.iter().flatten().copied().next()?;
    Some(each.map(|v| v.unwrap_or(any)))
}

impl Law {
    /// Returns whether it gives most pixels, of more than one colour.
    pub(super) fn is_clear(&self) -> bool {
        self.share > 0.8 && !self.is_of_one_color
    }

    /// Finds the law, and returns which of the wrong pixels it explains.
    pub(super) fn find(pixels: &Pixels<'_>, wrong: &[[u32; 2]]) -> (Option<Law>, Vec<bool>) {
        let is_seen = |(m, e): &Pair| ![m, e].iter().any(|c| pixels.is_same(**c, pixels.background));
        let pair = |at: &[u32; 2]| (pixels.mine_at(*at), pixels.exact_at(*at));
        let pairs: Vec<Pair> = wrong.iter().map(pair).filter(is_seen).collect();
        if pairs.len() < LEAST {
            return (None, vec![false; wrong.len()]);
        }
        let ln = |v: f64| (v / 255.0).ln();
        let power: Vec<f64> = pairs
            .iter()
            .flat_map(|(m, e)| (0..3).map(|c| (m[c], e[c])).collect::<Vec<_>>())
            .filter(|(m, e)| (1..255).contains(m) && (20..236).contains(e))
            .map(|(m, e)| ln(m.into()) / ln(e.into()))
            .collect();
        let kinds = [
            Some(Kind::Exchanged),
            of_channels(&pairs, |m, e| m / e).map(Kind::Factor),
            of_channels(&pairs, |m, e| m - e).map(Kind::Summand),
            median(power).filter(|e| e.is_finite()).map(Kind::Power),
        ];
        let count = |kind: &Kind| pairs.iter().filter(|(m, e)| kind.gives(*m, *e)).count();
        // The first of those that explain the most.
        let best = kinds.into_iter().flatten().map(|kind| (count(&kind), kind));
        let best = best.reduce(|best, next| if next.0 > best.0 + best.0 / 50 { next } else { best });
        let Some((n, kind)) = best.filter(|(n, _)| *n >= LEAST && n * 10 >= pairs.len() * 6) else {
            return (None, vec![false; wrong.len()]);
        };
        let is_of_one_color = pairs.iter().all(|(_, e)| *e == pairs[0].1);
        let law = Law { kind, share: n as f64 / pairs.len() as f64, is_of_one_color };
        let explained = wrong.iter().map(pair).map(|p| is_seen(&p) && kind.gives(p.0, p.1)).collect();
        (Some(law), explained)
    }
}

impl fmt::Display for Law {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let each = |v: [f64; 3], digits: usize| {
            let text = v.map(|v| format!("{v:.digits$}"));
            match text[0] == text[1] && text[1] == text[2] {
                true => text[0].clone(),
                false => format!("{}, {}, {} (R, G, B)", text[0], text[1], text[2]),
            }
        };
        match self.kind {
            Kind::Exchanged => f.write_str("red and blue are exchanged: the bytes are R, G, B, A")?,
            Kind::Factor(k) => {
                write!(f, "the colour is off by a factor: {} of the right one", each(k, 3))?;
                f.write_str("; as by a light's intensity or a sum over n + 1 terms")?;
            }
            Kind::Summand(d) => {
                write!(f, "the colour is off by a summand: {} of 255", each(d.map(|v| v + 0.0), 0))?;
                f.write_str("; as by ambient light that is missing or counted twice")?;
            }
            Kind::Power(e) => {
                write!(f, "the colour is off by a power: 255 (c/255)^{e:.3}")?;
                f.write_str("; gamma, where the exact picture stores values as they are computed")?;
            }
        }
        match self.is_of_one_color {
            true => f.write_str(" (of one colour only, where other laws give the same)"),
            false => Ok(()),
        }
    }
}
