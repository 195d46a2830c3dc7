//! A decision: for one picture of a user's, each setting's time beside its error, and the setting to
//! recommend.
//!
//! In: a scene, an N-dimensional scene or a stream, with its size and the error budgets that are
//! asked for. Out: a [`Decision`]. Right is: errors are those of an independent comparison with the
//! truth, which is never a row; a pixel that a setting misses counts; settings that do the same work
//! as another are named and not timed; the others are timed in turns.

mod advice;
mod error;
mod eye;
mod settings;
mod stream;
#[cfg(test)]
mod tests;
mod truth;

pub use error::DecideError;
pub use settings::Setting;
pub use stream::quality_line;

use super::clock::Work;
use super::experiment::{Bound, Check, Effort, Experiment, Row, Standing, Truth};
use super::picture::{BenchFrame, scene_options};
use super::pictures::limit;
use super::report::Section;
use fbptr_core::eye::EyeScene;
use fbptr_core::pipeline::quality::MeshShapes;
use fbptr_core::pipeline::{DepthUse, Renderer, SceneOptions};
use fbptr_core::scene::{MaxError, Scene, ShadeMode, TransparencyOrder};
use fbptr_formats::load::SandboxDir;
use fbptr_truth::scenes::Case;
use fbptr_truth::{Settings, Transparency};
use settings::DrawnWork;
use std::time::Duration;
use truth::{Found, RightPicture};

/// The budgets that are compared where none is asked for, in 1/255 steps.
pub const USUAL_BUDGETS: [f64; 3] = [1.0, 4.0, 16.0];
/// The error that a recommended setting may have where none is asked for, in 1/255 steps.
pub const USUAL_LIMIT: f64 = 4.0;
/// Time that all rows of a decision take at most, but for a frame of each.
const MOST_TIME: Duration = Duration::from_secs(10);
/// Multiple of a row's time budget after which fewer samples have to do.
const PATIENCE: u32 = 5;

/// Columns of the rows.
const LARGEST: usize = 0;
const PERCENTILE: usize = 1;
const COVERAGE: usize = 2;

/// The rows of a decision as an experiment.
const DECISION: Experiment = Experiment {
    id: "decision",
    title: "Settings for a picture",
    about: "",
    truth: Truth {
        is: "the picture by the plain path in f64, one face and one pixel after the other; pixels in doubt by the reference",
        digits: "15, in doubt 32",
        second_way: "the reference of 32 digits, at pixels chosen at random; the largest difference in 1/255",
    },
    check: |_| Check { difference: 0.0, at_most: 1.0 },
    columns: &["largest error, 1/255", "99.9th percentile, 1/255", "coverage off, pixels"],
    plotted: PERCENTILE,
    unit: "frame",
    rows: |_| Vec::new(),
};

/// Subject of a decision.
pub enum Subject<'a> {
    /// A scene in three dimensions, with its camera and background.
    Solid {
        /// The scene.
        scene: Box<Scene>,
        /// Shading of objects without a shading mode of their own.
        shade: ShadeMode,
        /// Order of its transparent faces.
        order: TransparencyOrder,
    },
    /// A scene of N dimensions.
    Eye(&'a EyeScene),
    /// A stream of commands or a recording.
    Stream {
        /// Its bytes.
        bytes: &'a [u8],
        /// Folder that its `LOAD` reads from.
        load_dir: Option<SandboxDir>,
    },
}

/// A picture, and what is asked about it.
pub struct Question<'a> {
    /// Name of the picture.
    pub name: String,
    /// The scene or stream.
    pub subject: Subject<'a>,
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Error budgets to compare, in 1/255 steps.
    pub budgets: Vec<MaxError>,
    /// Largest 99.9th percentile of the error that a recommended setting has.
    pub limit: f64,
    /// Returns the command line that draws with a setting, if there is one.
    pub command: &'a dyn Fn(&Setting) -> Option<String>,
}

/// A setting that does the same work as another.
#[derive(Clone, Debug, PartialEq)]
pub struct SameWork {
    /// The setting.
    pub setting: String,
    /// The setting that it equals.
    pub of: String,
}

/// The settings of one picture, compared.
#[derive(Clone, Debug)]
pub struct Decision {
    /// The rows, the exact one first.
    pub section: Section,
    /// Name of the picture.
    pub name: String,
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Settings of the rows.
    pub settings: Vec<Setting>,
    /// Command lines of the rows.
    pub commands: Vec<Option<String>>,
    /// Settings without a row, as they do the same work as another.
    pub same_work: Vec<SameWork>,
    /// Remarks on the comparison.
    pub notes: Vec<String>,
    /// Largest 99.9th percentile of the error that the recommended setting may have.
    pub limit: f64,
}

/// Compares the settings of a picture.
///
/// # Errors
/// If it cannot be drawn, or nothing of it is seen.
pub fn decide(effort: &Effort, question: Question<'_>) -> Result<Decision, DecideError> {
    let mut decision = match question.subject {
        Subject::Solid { ref scene, shade, order } => {
            let [width, height] = question.size;
            let transparency = Transparency::AfterOpaque(order);
            let settings = Settings { shade, transparency, ..Settings::default() };
            let (name, scene) = (question.name.clone(), Scene::clone(scene));
            of_case(
                effort,
                &Case { name, scene, settings, format: Default::default(), width, height },
                &question,
            )
        }
        Subject::Eye(scene) => eye::decide(effort, scene, &question),
        Subject::Stream { bytes, ref load_dir } => {
            stream::decide(effort, bytes, load_dir.as_ref(), &question)
        }
    }?;
    let threads = if effort.threads == 1 { "1 thread".into() } else { format!("{} threads", effort.threads) };
    decision.notes.push(format!("Times are those of {threads}; `--threads` sets another number."));
    Ok(decision)
}

/// Returns the decisions of the scenes that the program makes.
pub(super) fn made(effort: &Effort) -> Vec<Decision> {
    let of_case = |case: &Case| {
        let question = Question {
            name: case.name.clone(),
            subject: Subject::Stream { bytes: &[], load_dir: None },
            size: [case.width, case.height],
            budgets: USUAL_BUDGETS.map(MaxError::from).into(),
            limit: USUAL_LIMIT,
            command: &|_| None,
        };
        of_case(effort, case, &question).ok()
    };
    super::pictures::made(effort).iter().filter_map(of_case).collect()
}

/// A setting of a scene, ready to be drawn.
struct Prepared {
    setting: Setting,
    scene: Scene,
    options: SceneOptions,
    work: DrawnWork,
}

/// Prepares the settings of a case; those that do the same work as an earlier one apart.
fn prepare(case: &Case, budgets: &[MaxError]) -> (Vec<Prepared>, Vec<SameWork>) {
    // Times are those of many frames: levels of detail are made at once.
    let mut shapes = MeshShapes::at_once().expecting(1024);
    let options = scene_options(case).unwrap_or(SceneOptions::new(case.width, case.height));
    let options = SceneOptions { depth_use: DepthUse::SceneOnly, ..options };
    let (mut all, mut same) = (Vec::<Prepared>::new(), Vec::new());
    for setting in settings::of_scene(&case.scene, budgets) {
        let (mut scene, mut options) = (case.scene.clone(), options.clone());
        setting.apply(&mut scene, &mut options, &mut shapes);
        let work = DrawnWork::of(&scene, &options);
        match all.iter().find(|other| other.work == work) {
            Some(other) => {
                same.push(SameWork { setting: setting.name(), of: other.setting.name() });
            }
            None => all.push(Prepared { setting, scene, options, work }),
        }
    }
    (all, same)
}

/// Compares the settings of a scene in three dimensions.
fn of_case(effort: &Effort, case: &Case, question: &Question<'_>) -> Result<Decision, DecideError> {
    let mut right = RightPicture::new(case)?;
    let (mut ways, same_work) = prepare(case, &question.budgets);
    let mut notes = Vec::new();
    let mut pictures = Vec::new();
    let mut renderer = effort.renderer();
    let mut refused = Vec::new();
    for way in &ways {
        match Found::draw(&mut renderer, &way.scene, &way.options, case) {
            Ok(found) => pictures.push(found),
            Err(error) if way.setting == Setting::Exact => return Err(error),
            Err(error) => {
                notes.push(format!("{} cannot be drawn: {error}.", way.setting.name()));
                refused.push(way.setting);
            }
        }
        if way.setting == Setting::Exact {
            notes.extend(shared_code(&renderer, &case.scene));
        }
    }
    ways.retain(|way| !refused.contains(&way.setting));
    drop(renderer);
    right.decide(case, &pictures[0], limit(case))?;
    notes.insert(0, right_in_words(&right));
    let timings = {
        let frame = || BenchFrame::new(effort.renderer(), case.width, case.height);
        let mut frames: Vec<BenchFrame> = ways.iter().map(|_| frame()).collect();
        let mut works: Vec<Work<()>> = Vec::new();
        for (way, frame) in ways.iter().zip(&mut frames) {
            works.push(Box::new(|| frame.draw_with(&way.scene, &way.options, case.format)));
        }
        rows_effort(effort, works.len()).run_in_turns(works)
    };
    let mut rows = Vec::new();
    for ((way, found), ((), timing)) in ways.iter().zip(&pictures).zip(timings) {
        let standing = if way.setting == Setting::Exact { Standing::Default } else { Standing::Mode };
        let key = (case.name.as_str(), &*way.setting.name(), standing);
        let (judge, spoil) = (|f: &Found| right.errors(f), |f: &mut Found, b: &Bound| right.spoil(f, b));
        let row = Row::judged(effort, key, found, bounds(&way.setting, limit(case)), judge, spoil);
        let beside = right.bytes_beside(found);
        rows.push(row.timed(timing, 1.0).with_picture(case.width, found.bytes.clone(), beside));
    }
    let check = Check { difference: right.difference.unwrap_or(0.0), at_most: limit(case) };
    let settings = ways.iter().map(|way| way.setting).collect();
    Ok(Decision::new(question, Section { experiment: DECISION, rows, check }, settings, same_work, notes))
}

/// Returns the effort of each of `count` rows, which together take [`MOST_TIME`] at most.
fn rows_effort(effort: &Effort, count: usize) -> Effort {
    let most = MOST_TIME / (PATIENCE * count.max(1) as u32);
    Effort { time_per_row: effort.time_per_row.map(|time| time.min(most)), ..*effort }
}

/// Returns the promises of a setting, for pictures whose colours are right within `limit` steps.
fn bounds(setting: &Setting, limit: f64) -> Vec<Bound> {
    let at_most = |column, at_most, because| Bound { column, at_most, because };
    let coverage = at_most(COVERAGE, 0.0, "every setting keeps coverage");
    match setting {
        Setting::Exact => {
            let because = "the limit of textured colours, 2, or of others, 1, by the specification";
            vec![at_most(LARGEST, limit, because), coverage]
        }
        Setting::Within(most) if setting.is_promised() => {
            let because = "the budget's promise, or the limit of exact pictures, if that is more";
            vec![at_most(PERCENTILE, most.steps.max(limit), because), coverage]
        }
        _ => Vec::new(),
    }
}

/// Returns largest error, 99.9th percentile, and pixels of coverage that differ.
fn summary(mut distances: Vec<f64>, coverage: usize) -> Vec<f64> {
    distances.sort_unstable_by(f64::total_cmp);
    let from_end = |i: usize| distances.iter().rev().nth(i).copied().unwrap_or(0.0);
    vec![from_end(0), from_end(distances.len() / 1000), coverage as f64]
}

/// Says what the truth is, and by how many pixels it was checked.
fn right_in_words(right: &RightPicture) -> String {
    let plain = "Compared with the plain path in f64, at every pixel that it draws on";
    match right.difference {
        Some(difference) => format!(
            "{plain}; {} pixels, those in doubt and others chosen at random, by the reference of 32 digits, from which the \
             plain path differs by at most {difference} there.",
            right.by_reference
        ),
        None => format!("{plain}; the reference of 32 digits is too slow for a scene of so many faces."),
    }
}

/// Says what both the compared pictures and the truth draw with the same code.
fn shared_code(renderer: &Renderer, scene: &Scene) -> Option<String> {
    let counts = renderer.path_counts();
    let meshes = scene.objects.iter().map(|o| &o.geometry.mesh);
    let lines: usize = meshes.map(|mesh| mesh.lines.len() + mesh.points.len()).sum();
    let mut shared = Vec::new();
    if counts.reference > 0 {
        shared.push("faces that no faster path supports".to_owned());
    }
    if lines > 0 {
        shared.push(format!("{lines} lines and points"));
    }
    (!shared.is_empty()).then(|| {
        format!(
            "The plain path has no second code for {}: there the truth is the reference's, at the pixels that it compared.",
            shared.join(" and ")
        )
    })
}
