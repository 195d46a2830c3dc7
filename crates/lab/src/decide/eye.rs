//! Decisions about scenes of N dimensions: the exact fibre, and fans of rays.
//!
//! The truth is the reference of 32 digits, which tries every set of active inequalities; it is slow,
//! so pixels of the whole screen are chosen at random, whether anything is drawn there or not. An eye
//! that is turned is compared with the scene turned in its place, which is rounded to f64.

use super::super::clock::Work;
use super::super::experiment::{Bound, Check, Effort, Row, Standing, Truth};
use super::super::report::Section;
use super::{
    COVERAGE, DECISION, DecideError, Decision, LARGEST, Question, SameWork, Setting, rows_effort, settings,
    summary,
};
use fbptr_core::executor::Executor;
use fbptr_core::eye::{EyeLightKind, EyePicture, EyeScene, Fibre, Pose, blit, render_with};
use fbptr_core::memory::VideoMemory;
use fbptr_server::worker_pool;
use fbptr_truth::DoubleDouble;
use fbptr_truth::eye::{SeenPoint, see};
use fbptr_truth::scenes::Random;

/// Largest number of pixels compared.
const MOST_COMPARED: usize = 2_000;
/// Least number of pixels compared.
const LEAST_COMPARED: usize = 32;
/// Steps of the reference that are made for all pixels together: some seconds.
const MOST_STEPS: f64 = 4e8;
/// Number of a facet where nothing is seen.
const MISS: i32 = fbptr_core::eye::MISS;

/// Pixels with what the reference sees there.
struct Seen {
    pixels: Vec<usize>,
    points: Vec<SeenPoint>,
}

/// Returns the number of pixels that the reference draws, by what one costs it: all sets of up to K
/// inequalities for each facet, and all facets again for each light.
fn compared_pixels(scene: &EyeScene) -> usize {
    let (n, hidden) = (scene.dim as f64, scene.hidden_dim() as i32);
    let sets = libm::pow(n + 2.0 * f64::from(hidden), f64::from(hidden));
    let of_facet = (sets + scene.lights.len() as f64) * n * n * n;
    let pixels = MOST_STEPS / (of_facet * scene.facets.len().max(1) as f64);
    (pixels as usize).clamp(LEAST_COMPARED, MOST_COMPARED)
}

impl Seen {
    /// Lets the reference see pixels of the screen.
    fn new(scene: &EyeScene) -> Seen {
        let (all, wanted) = (scene.pixel_count(), compared_pixels(scene));
        let mut random = Random::new(1888);
        let pixels: Vec<usize> = match all <= wanted {
            true => (0..all).collect(),
            false => (0..wanted).map(|_| random.below(all as u32) as usize).collect(),
        };
        let points = see::<DoubleDouble>(scene, pixels.iter().copied());
        Seen { pixels, points }
    }

    /// Returns the errors of a picture: colours where the reference sees something.
    fn errors(&self, picture: &EyePicture) -> Vec<f64> {
        let (mut distances, mut coverage) = (Vec::new(), 0);
        for (&i, point) in self.pixels.iter().zip(&self.points) {
            coverage += usize::from((picture.facet[i] == MISS) != (point.facet == MISS));
            if point.facet != MISS {
                let off = (0..3).map(|c| (picture.color[i][c] - point.color[c]).abs());
                distances.push(off.fold(0.0, f64::max));
            }
        }
        summary(distances, coverage)
    }

    /// Makes a picture wrong by a little more than a bound: tests of the report use it.
    fn spoil(&self, picture: &mut EyePicture, bound: &Bound) {
        let Some((&i, _)) = self.pixels.iter().zip(&self.points).find(|(_, p)| p.facet != MISS) else {
            return;
        };
        match bound.column {
            COVERAGE => picture.facet[i] = MISS,
            _ => picture.color[i][0] += 2.0 * bound.at_most,
        }
    }
}

/// Returns the scene seen by an eye along its own axes: turned in the eye's place.
fn along_axes(scene: &EyeScene) -> Result<EyeScene, DecideError> {
    let axes = scene.pose.axes();
    let eye = scene.pose.position.clone();
    let turn = |u: &[f64]| -> Vec<f64> {
        axes.iter().map(|axis| axis.iter().zip(u).map(|(a, x)| a * x).sum()).collect()
    };
    let place = |p: &[f64]| -> Vec<f64> {
        let from_eye: Vec<f64> = p.iter().zip(&eye).map(|(p, e)| p - e).collect();
        turn(&from_eye)
    };
    let mut parts = scene.clone().into_parts();
    parts.pose = Pose::identity(parts.dim);
    parts.facets.iter_mut().flat_map(|f| &mut f.v).for_each(|p| *p = place(p));
    for light in &mut parts.lights {
        match &mut light.kind {
            EyeLightKind::Sun { direction } => *direction = turn(direction),
            EyeLightKind::Radial { position } => *position = place(position),
            EyeLightKind::Plane { direction, point } => {
                (*direction, *point) = (turn(direction), place(point));
            }
        }
    }
    Ok(EyeScene::new(parts)?)
}

fn fibre(setting: &Setting) -> Fibre {
    match setting {
        Setting::Fan(rays) => Fibre::Fan(*rays),
        _ => Fibre::Exact,
    }
}

/// Compares the exact fibre of a scene with fans of rays.
pub(super) fn decide(
    effort: &Effort,
    scene: &EyeScene,
    question: &Question<'_>,
) -> Result<Decision, DecideError> {
    let mut notes = Vec::new();
    let mut same_work = Vec::new();
    let mut ways = Vec::new();
    for setting in settings::of_eye() {
        if scene.hidden_dim() == 0 && setting != Setting::Exact {
            let of = Setting::Exact.name();
            same_work.push(SameWork { setting: setting.name(), of });
            continue;
        }
        match fbptr_core::eye::plan(scene, fibre(&setting)) {
            Ok(_) => ways.push(setting),
            Err(error) if setting == Setting::Exact => return Err(error.into()),
            Err(error) => notes.push(format!("{} cannot be drawn: {error}.", setting.name())),
        }
    }
    let seen = match scene.pose.rotations.is_empty() {
        true => Seen::new(scene),
        false => {
            notes.push(
                "The reference cannot turn its eye: it sees the scene turned in the eye's place, rounded to f64."
                    .into(),
            );
            Seen::new(&along_axes(scene)?)
        }
    };
    if seen.points.iter().all(|point| point.facet == MISS) {
        let why = format!("the reference sees nothing at any of {} pixels", seen.points.len());
        return Err(DecideError::Nothing(why));
    }
    notes.insert(0, compared_in_words(seen.points.len(), scene.pixel_count()));
    let executor = Executor::of_pool(worker_pool(Some(effort.threads)));
    let draw = |fibre| render_with(scene, fibre, &executor);
    let mut pictures = Vec::new();
    for setting in &ways {
        pictures.push(draw(fibre(setting))?);
    }
    let work = |setting: &Setting| {
        let fibre = fibre(setting);
        Box::new(move || drop(draw(fibre))) as Work<()>
    };
    let timings = rows_effort(effort, ways.len()).run_in_turns(ways.iter().map(work).collect());
    let exact = shown(&pictures[0], question.size)?;
    let mut rows = Vec::new();
    for ((setting, picture), ((), timing)) in ways.iter().zip(&pictures).zip(timings) {
        let (standing, bounds) = match setting {
            Setting::Exact => (Standing::Default, exact_bounds()),
            _ => (Standing::Mode, Vec::new()),
        };
        let key = (question.name.as_str(), &*setting.name(), standing);
        let row = Row::judged(effort, key, picture, bounds, |p| seen.errors(p), |p, b| seen.spoil(p, b));
        let bytes = shown(picture, question.size)?;
        rows.push(row.timed(timing, 1.0).with_picture(question.size[0], bytes, exact.clone()));
    }
    if ways.len() > 1 {
        notes.push("The pictures of differences show those from the exact fibre's, as the reference draws no whole picture.".into());
    }
    let truth = Truth {
        is: "every set of active inequalities",
        digits: "32",
        second_way: "none here; the table of the fibre has rational numbers",
    };
    let experiment = super::Experiment { truth, ..DECISION };
    let section = Section { experiment, rows, check: Check { difference: 0.0, at_most: 0.0 } };
    Ok(Decision::new(question, section, ways, same_work, notes))
}

/// Says what the pictures are compared with, and at which pixels.
fn compared_in_words(count: usize, all: usize) -> String {
    let pixels = match count < all {
        true => format!("{count} of {all} pixels chosen at random; pixels of coverage are those among them"),
        false => format!("all {all} pixels"),
    };
    format!(
        "Compared with the reference of 32 digits, which tries every set of active inequalities, at {pixels}."
    )
}

/// Returns the promise of the exact fibre.
fn exact_bounds() -> Vec<Bound> {
    let because = "exact fibres: a step of 1/255, in which the digits of f64 vanish";
    vec![Bound { column: LARGEST, at_most: 1.0, because }]
}

/// Returns the bytes of a picture in a frame.
fn shown(picture: &EyePicture, [width, height]: [u32; 2]) -> Result<Vec<u8>, DecideError> {
    let mut memory = VideoMemory::new(width, height)?;
    blit(picture, &mut memory, 0, 0, width as i32, height as i32);
    Ok(memory.bytes().to_vec())
}
