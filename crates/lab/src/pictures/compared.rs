//! Compared pixels of a picture, with the colours that are accepted at each.

use super::super::experiment::{Bound, Effort, Row, Standing};
use fbptr_core::memory::VideoMemory;
use fbptr_core::pipeline::Renderer;
use fbptr_truth::scenes::{Case, Random};
use fbptr_truth::{TruthPicture, render_pixels};

/// Range of each channel, in steps of 1/255.
pub(super) type Range = [[f64; 2]; 3];

/// Pixels drawn on, chosen at random, each with its right answers.
pub(super) struct Compared {
    width: u32,
    pixels: Vec<[u32; 2]>,
    accepted: Vec<Vec<Range>>,
}

impl Compared {
    /// Creates it from pixels and their right answers; a pixel without any is free.
    pub fn new(width: u32, pixels: Vec<[u32; 2]>, accepted: Vec<Vec<Range>>) -> Compared {
        Compared { width, pixels, accepted }
    }

    /// Chooses `count` of the pixels that a case is drawn on, and renders them by the reference.
    /// Returns `None` if the case is refused, or draws nothing.
    pub fn of_case(case: &Case, count: usize) -> Option<Compared> {
        let pixels = pixels_drawn(case, count)?;
        let truth =
            render_pixels(&case.scene, case.width, case.height, case.format, &case.settings, &pixels).ok()?;
        let accepted = pixels.iter().map(|pixel| ranges(&truth, *pixel)).collect();
        Some(Compared::new(case.width, pixels, accepted))
    }

    /// Returns a picture's colours at the pixels, in steps of 1/255.
    pub fn of_bytes(&self, bytes: &[u8]) -> Vec<[f64; 3]> {
        let color = |&[x, y]: &[u32; 2]| {
            let at = 4 * (self.width as usize * y as usize + x as usize);
            [0, 1, 2].map(|c| f64::from(bytes[at + c]))
        };
        self.pixels.iter().map(color).collect()
    }

    /// Returns largest error, RMSE and 99.9th percentile against the nearest right answers.
    pub fn errors(&self, found: &[[f64; 3]]) -> Vec<f64> {
        let (mut largest, mut squares) = (Vec::with_capacity(found.len()), 0.0);
        for (color, accepted) in found.iter().zip(&self.accepted) {
            let away = |range: &Range| {
                [0, 1, 2].map(|c| (range[c][0] - color[c]).max(color[c] - range[c][1]).max(0.0))
            };
            let most = |d: &[f64; 3]| d[0].max(d[1]).max(d[2]);
            let best = accepted.iter().map(away).min_by(|a, b| most(a).total_cmp(&most(b)));
            let best = best.unwrap_or([0.0; 3]);
            largest.push(most(&best));
            squares += best.iter().map(|d| d * d).sum::<f64>();
        }
        largest.sort_unstable_by(f64::total_cmp);
        let count = largest.len().max(1);
        let at = count - 1 - self.may_be_over();
        let of = |i: usize| largest.get(i).copied().unwrap_or(0.0);
        vec![of(count - 1), (squares / (3 * count) as f64).sqrt(), of(at)]
    }

    /// Returns the number of pixels beyond the 99.9th percentile.
    fn may_be_over(&self) -> usize {
        self.pixels.len() / 1000
    }

    /// Returns the row of a way, with its subject, name and standing, that drew these colours.
    pub fn judged(
        &self,
        effort: &Effort,
        key: (&str, &str, Standing),
        bounds: Vec<Bound>,
        found: &Vec<[f64; 3]>,
    ) -> Row {
        let mutate = |found: &mut Vec<[f64; 3]>, bound: &Bound| self.raise(found, bound.at_most);
        Row::judged(effort, key, found, bounds, |f| self.errors(f), mutate)
    }

    /// Moves as many pixels as the percentile needs away from their right answers, by `steps` and
    /// a little more: one step for pictures of bytes.
    fn raise(&self, found: &mut [[f64; 3]], steps: f64) {
        let more = if steps < 0.5 { steps } else { 1.0 };
        let places = found.iter_mut().zip(&self.accepted).filter(|(_, accepted)| accepted.len() == 1);
        for (color, accepted) in places.take(self.may_be_over() + 1) {
            let [low, high] = accepted[0][0];
            color[0] = if high < 128.0 { high + steps + more } else { low - steps - more };
        }
    }
}

/// Returns the right answers of a pixel; none if it is unconstrained.
fn ranges(truth: &TruthPicture, [x, y]: [u32; 2]) -> Vec<Range> {
    if truth.is_free(x, y) {
        return Vec::new();
    }
    let range = |s: &fbptr_truth::PixelState| [0, 1, 2].map(|c| [f64::from(s.lo[c]), f64::from(s.hi[c])]);
    truth.states(x, y).iter().map(range).collect()
}

/// Returns `count` of the pixels that a case is drawn on, with repetitions.
fn pixels_drawn(case: &Case, count: usize) -> Option<Vec<[u32; 2]>> {
    let mut memory = VideoMemory::new(case.width, case.height).ok()?;
    memory.bytes_mut().fill(0);
    let mut depth = None;
    let mut target = fbptr_core::pipeline::Target {
        memory: &mut memory,
        depth: &mut depth,
        depth_format: case.format,
        ids: None,
    };
    super::super::picture::try_draw_into(&mut Renderer::default(), &mut target, case).ok()?;
    let drawn: Vec<usize> =
        memory.bytes().chunks_exact(4).enumerate().filter(|(_, p)| p[3] != 0).map(|(i, _)| i).collect();
    if drawn.is_empty() {
        return None;
    }
    let mut r = Random::new(1975);
    let width = case.width as usize;
    let one = |_| {
        let i = drawn[r.below(drawn.len() as u32) as usize];
        [(i % width) as u32, (i / width) as u32]
    };
    Some((0..count).map(one).collect())
}
