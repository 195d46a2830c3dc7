//! The right picture of a scene: every pixel by the plain path, in f64, and those in doubt by the
//! reference of 32 digits.
//!
//! In: a case. Out: for each pixel whether it is drawn on, and its colour. The set of compared pixels
//! comes from here: pixels that a renderer misses are in it. Right is: a pixel in doubt has every
//! answer that the reference accepts. The plain path shares the preparation of a draw with the fast
//! one, the reference only the scene's data, so pixels are in doubt where the exact picture differs
//! from the plain path's by more than rounding, and a thousand others are compared to check this.

use super::super::experiment::Bound;
use super::super::picture::scene_options;
use super::{COVERAGE, DecideError, summary};
use fbptr_core::memory::VideoMemory;
use fbptr_core::pipeline::{EmptyDraw, RenderOptions, RenderPath, Renderer, SceneOptions, Target};
use fbptr_core::scene::{Background, Scene};
use fbptr_truth::render_pixels;
use fbptr_truth::scenes::{Case, Random};
use std::collections::HashMap;

/// Number of pixels that the reference checks beside those in doubt.
const CHECKED: usize = 1_000;
/// Largest number of pixels in doubt that the reference decides.
const DECIDED: usize = 4_000;
/// Largest number of faces of a scene that the reference draws.
const MOST_FACES: usize = 300_000;

/// A drawn picture: its bytes, and which pixels are drawn on.
#[derive(Clone, Debug)]
pub(super) struct Found {
    pub bytes: Vec<u8>,
    pub drawn: Vec<bool>,
}

impl Found {
    /// Draws a scene, and its pixels without a background.
    pub fn draw(
        renderer: &mut Renderer,
        scene: &Scene,
        options: &SceneOptions,
        case: &Case,
    ) -> Result<Found, DecideError> {
        Ok(Found::draw_explained(renderer, scene, options, case)?.0)
    }

    /// Draws as [`Found::draw`] does, and says why nothing is seen, if nothing is.
    fn draw_explained(
        renderer: &mut Renderer,
        scene: &Scene,
        options: &SceneOptions,
        case: &Case,
    ) -> Result<(Found, Option<EmptyDraw>), DecideError> {
        let mut memory = VideoMemory::new(case.width, case.height)?;
        let mut draw = |memory: &mut VideoMemory, scene: &Scene| {
            let mut target = Target { memory, depth: &mut None, depth_format: case.format, ids: None };
            renderer.draw_scene(&mut target, scene, options)
        };
        let stats = draw(&mut memory, scene)?;
        let empty = EmptyDraw::of_scene(&stats, scene, options, &memory);
        let bytes = memory.bytes().to_vec();
        memory.bytes_mut().fill(0);
        draw(&mut memory, &Scene { background: Background::default(), sky: None, ..scene.clone() })?;
        let drawn = memory.bytes().chunks_exact(4).map(|pixel| pixel[3] != 0).collect();
        Ok((Found { bytes, drawn }, empty))
    }
}

/// One right answer of a pixel in doubt.
#[derive(Clone, Copy, Debug)]
struct Answer {
    drawn: bool,
    low: [u8; 3],
    high: [u8; 3],
}

/// The right picture.
pub(super) struct RightPicture {
    plain: Found,
    /// Answers of the reference, by pixel; none if any is right.
    decided: HashMap<usize, Vec<Answer>>,
    has_sky: bool,
    /// Largest difference of the plain path from the reference, in 1/255; `None` if the scene has too
    /// many faces for it.
    pub difference: Option<f64>,
    /// Number of pixels that the reference has drawn.
    pub by_reference: usize,
}

impl RightPicture {
    /// Draws a case by the plain path.
    ///
    /// # Errors
    /// If the case is refused, or nothing of it is seen.
    pub fn new(case: &Case) -> Result<RightPicture, DecideError> {
        let plain = RenderOptions { path: RenderPath::Plain, ..RenderOptions::default() };
        let options = scene_options(case).unwrap_or(SceneOptions::new(case.width, case.height));
        let mut renderer = Renderer::new(plain);
        let (plain, empty) = Found::draw_explained(&mut renderer, &case.scene, &options, case)?;
        if !plain.drawn.contains(&true) {
            let why = empty.map_or("no pixel is drawn on".to_owned(), |empty| empty.to_string());
            return Err(DecideError::Nothing(why));
        }
        let has_sky = case.scene.sky.is_some();
        Ok(RightPicture { plain, decided: HashMap::new(), has_sky, difference: None, by_reference: 0 })
    }

    /// Lets the reference decide the pixels at which the exact picture differs from the plain path's
    /// by more than `limit` steps or in coverage, and check as many others.
    ///
    /// # Errors
    /// If the case's camera is unusable.
    pub fn decide(&mut self, case: &Case, exact: &Found, limit: f64) -> Result<(), DecideError> {
        let faces: usize = case.scene.objects.iter().map(|o| o.geometry.mesh.triangles.len()).sum();
        if faces > MOST_FACES {
            return Ok(());
        }
        let is_doubtful = |i: &usize| {
            self.plain.drawn[*i] != exact.drawn[*i]
                || f64::from(distance(color(&self.plain, *i), color(exact, *i))) > limit
        };
        let doubtful: Vec<usize> = (0..exact.drawn.len()).filter(is_doubtful).collect();
        let step = doubtful.len().div_ceil(DECIDED).max(1);
        let mut asked: Vec<usize> = doubtful.into_iter().step_by(step).collect();
        let drawn: Vec<usize> = (0..exact.drawn.len()).filter(|i| self.plain.drawn[*i]).collect();
        let mut random = Random::new(1975);
        let mut checked: Vec<usize> =
            (0..CHECKED).map(|_| drawn[random.below(drawn.len() as u32) as usize]).collect();
        asked.append(&mut checked);
        asked.sort_unstable();
        asked.dedup();
        let width = case.width as usize;
        let pixels: Vec<[u32; 2]> = asked.iter().map(|i| [(i % width) as u32, (i / width) as u32]).collect();
        let reference =
            render_pixels(&case.scene, case.width, case.height, case.format, &case.settings, &pixels)?;
        let mut difference = 0;
        for (&i, &[x, y]) in asked.iter().zip(&pixels) {
            let answer =
                |s: &fbptr_truth::PixelState| Answer { drawn: s.drawn.is_some(), low: s.lo, high: s.hi };
            let answers: Vec<Answer> = match reference.is_free(x, y) {
                true => Vec::new(),
                false => reference.states(x, y).iter().map(answer).collect(),
            };
            difference = difference.max(nearest(&answers, color(&self.plain, i)));
            self.decided.insert(i, answers);
        }
        self.difference = Some(f64::from(difference));
        self.by_reference = pixels.len();
        Ok(())
    }

    /// Returns whether the colour of a pixel is compared.
    fn is_compared(&self, i: usize) -> bool {
        self.has_sky
            || match self.decided.get(&i) {
                Some(answers) => answers.iter().any(|a| a.drawn),
                None => self.plain.drawn[i],
            }
    }

    /// Returns largest error, 99.9th percentile and the number of pixels of coverage that differ.
    pub fn errors(&self, found: &Found) -> Vec<f64> {
        let (mut distances, mut coverage) = (Vec::with_capacity(found.drawn.len()), 0);
        for (i, drawn) in found.drawn.iter().enumerate() {
            let decided = self.decided.get(&i);
            coverage += usize::from(match decided {
                Some(answers) => !answers.is_empty() && answers.iter().all(|a| a.drawn != *drawn),
                None => *drawn != self.plain.drawn[i],
            });
            if self.is_compared(i) {
                let off = decided.map_or_else(
                    || distance(color(&self.plain, i), color(found, i)),
                    |answers| nearest(answers, color(found, i)),
                );
                distances.push(f64::from(off));
            }
        }
        summary(distances, coverage)
    }

    /// Returns the bytes of the right picture, by the answers nearest to a drawn one.
    pub fn bytes_beside(&self, found: &Found) -> Vec<u8> {
        let mut bytes = self.plain.bytes.clone();
        for (&i, answers) in &self.decided {
            let own = color(found, i);
            let right = match answers.iter().min_by_key(|a| distance_to(a, own)) {
                Some(a) => [0, 1, 2].map(|c| own[c].clamp(a.low[c], a.high[c])),
                None => own,
            };
            bytes[4 * i..4 * i + 3].copy_from_slice(&right);
        }
        bytes
    }

    /// Makes a drawn picture wrong by a little more than a bound: tests of the report use it.
    pub fn spoil(&self, found: &mut Found, bound: &Bound) {
        let drawn: Vec<usize> = (0..found.drawn.len()).filter(|i| self.is_compared(*i)).collect();
        let places = drawn.iter().filter(|i| !self.decided.contains_key(i));
        if bound.column == COVERAGE {
            places.take(1).for_each(|i| found.drawn[*i] = !self.plain.drawn[*i]);
            return;
        }
        let off = bound.at_most as u8 + 1;
        for &i in places.take(drawn.len() / 1000 + 1) {
            let right = self.plain.bytes[4 * i];
            found.bytes[4 * i] = if right < 128 { right + off } else { right - off };
        }
    }
}

fn color(found: &Found, i: usize) -> [u8; 3] {
    [0, 1, 2].map(|c| found.bytes[4 * i + c])
}

/// Returns the largest difference of a channel.
fn distance(a: [u8; 3], b: [u8; 3]) -> u8 {
    (0..3).map(|c| a[c].abs_diff(b[c])).max().unwrap_or(0)
}

fn distance_to(answer: &Answer, color: [u8; 3]) -> u8 {
    distance([0, 1, 2].map(|c| color[c].clamp(answer.low[c], answer.high[c])), color)
}

fn nearest(answers: &[Answer], color: [u8; 3]) -> u8 {
    answers.iter().map(|a| distance_to(a, color)).min().unwrap_or(0)
}
