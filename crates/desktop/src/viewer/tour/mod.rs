//! The tour in the viewer: steps that are played one after another, each on an engine of its own,
//! and shown with their caption and their commands.
//!
//! In: the script (see [`script`]), and a factory of engines. Out: pages of [`SIZE`] pixels by
//! frame number, at [`FRAMES_PER_SECOND`]; the tour stays at its last frame. Keys: on, back, pause,
//! single frames, and what concerns the window.
//!
//! Promise: the picture on a page is the one that playing the step's commands gives.
//!
//! Verified by: tests that play every step of the built-in script (of the longest, the first frames)
//! and compare pages with pictures.

mod page;
mod script;

pub use page::SIZE;
pub use script::FRAMES_PER_SECOND;

use super::keys::Action;
use super::replay::{MakeEngine, Playing};
use super::{Subject, Viewer, Wishes};
use fbptr_core::memory::VideoMemory;
use fbptr_core::pipeline::RenderPath;
use fbptr_server::Engine;
use flate2::read::GzDecoder;
use script::Step;
use std::io::Read;
use std::sync::Arc;

/// Factory of engines by frame size.
pub type MakeSizedEngine = Arc<dyn Fn([u32; 2]) -> Result<Engine, String> + Send + Sync>;

/// The built-in script (`steps.fbs`) as gzip.
const SCRIPT: &[u8] = include_bytes!(concat!(env!("OUT_DIR"), "/steps.fbs.gz"));

/// Frames per second of a movie of the tour.
pub const MOVIE_FRAMES_PER_SECOND: f64 = 5.0;
/// Pages of a motion that a movie shows, and the largest distance between two of them in frames.
const MOVIE_MOTION: u64 = 5;
const MOVIE_STRIDE: u64 = 10;
/// Frames of the movie that a step takes: after its motion the last of them stays.
const MOVIE_STEP: usize = 11;

/// The steps, and the one that is playing.
pub(super) struct Tour {
    steps: Vec<Step>,
    make_engine: MakeSizedEngine,
    /// Number of the step, and its stream on its engine.
    playing: Option<(usize, Playing)>,
}

impl Tour {
    /// Creates the tour of the built-in script.
    ///
    /// # Errors
    /// Returns the invalid line of the script.
    pub fn new(make_engine: MakeSizedEngine) -> Result<Self, String> {
        let mut script = Vec::new();
        GzDecoder::new(SCRIPT).read_to_end(&mut script).map_err(|e| e.to_string())?;
        Self::of_script(&script, make_engine)
    }

    fn of_script(script: &[u8], make_engine: MakeSizedEngine) -> Result<Self, String> {
        let steps = script::parse(script)?;
        match steps.is_empty() {
            true => Err("a tour without a step".to_owned()),
            false => Ok(Tour { steps, make_engine, playing: None }),
        }
    }

    /// Returns the number of the last frame.
    pub fn last_frame(&self) -> u64 {
        self.steps.iter().map(Step::frames).sum::<u64>() - 1
    }

    /// Returns the step at a frame, and the frame's number within it; the last of both for frames
    /// after the end.
    fn locate(&self, frame: u64) -> (usize, u64) {
        let mut rest = frame;
        for (i, step) in self.steps.iter().enumerate() {
            if rest < step.frames() {
                return (i, rest);
            }
            rest -= step.frames();
        }
        let last = self.steps.len() - 1;
        (last, self.steps[last].frames() - 1)
    }

    /// Returns the first frame of a step.
    fn first_frame(&self, step: usize) -> u64 {
        self.steps[..step].iter().map(Step::frames).sum()
    }

    /// Returns the first frame of the step `by` steps further, within the tour.
    fn first_frame_after(&self, frame: u64, by: i64) -> u64 {
        let (step, _) = self.locate(frame);
        self.first_frame(step.saturating_add_signed(by as isize).min(self.steps.len() - 1))
    }

    /// Returns the frames that a movie of the tour shows, in order, with their repetitions.
    pub fn movie_frames(&self) -> Vec<u64> {
        let mut frames = Vec::new();
        for (i, step) in self.steps.iter().enumerate() {
            let shown = MOVIE_MOTION.min(step.motion());
            // A picture that grows step by step is shown to its end, a long motion in part.
            let end = step.motion() - 1;
            let span = if step.hold() > MOVIE_STRIDE { end } else { end.min((shown - 1) * MOVIE_STRIDE) };
            frames.extend((0..shown).map(|k| self.first_frame(i) + k * span / (shown - 1).max(1)));
            let last = frames[frames.len() - 1];
            frames.extend(std::iter::repeat_n(last, MOVIE_STEP - shown as usize));
        }
        frames
    }

    /// Paints the page of frame `wishes.frame`.
    pub fn draw(&mut self, wishes: &Wishes, frame: &mut VideoMemory) -> Result<(), String> {
        let (number, within) = self.locate(wishes.frame);
        let step = &self.steps[number];
        let presents = step.presents_at(within);
        let fits = |(other, playing): &(usize, Playing)| *other == number && playing.frames() <= presents;
        let (_, mut playing) = match self.playing.take().filter(fits) {
            Some(playing) => playing,
            None => {
                let (make, size) = (Arc::clone(&self.make_engine), step.size);
                let make: MakeEngine = Arc::new(move || make(size));
                let overrides = Wishes::default().view_overrides();
                (number, Playing::new(&step.stream, &make, overrides, RenderPath::Fast)?)
            }
        };
        playing.play_to(&step.stream, presents);
        let error = playing.first_error();
        page::paint(frame, step, [number + 1, self.steps.len()], playing.memory());
        self.playing = Some((number, playing));
        match error {
            Some(error) => Err(format!("step {}: {error}", number + 1)),
            None => Ok(()),
        }
    }
}

/// Returns the lines of the help for the tour.
pub(super) fn help() -> Vec<String> {
    [
        "Right next step",
        "Left  step before",
        "Space pause, go on",
        ". ,   one frame on, back",
        "R     from the beginning",
        "I     inspect address and bytes",
        "F9    begin, end a GIF",
        "F10   fit or whole factors",
        "F11   fullscreen (X11)",
        "F12   save a PNG",
        "Esc   quit",
    ]
    .map(str::to_owned)
    .to_vec()
}

impl Viewer {
    /// Executes an action that the tour has of its own, and returns whether `action` is finished
    /// with: done, or without a meaning here.
    pub(super) fn act_in_tour(&mut self, action: Action) -> bool {
        let Subject::Tour(tour) = &self.subject else { return false };
        let frame = match action {
            Action::Turn(1, steps) | Action::Walk(1, steps) => {
                tour.first_frame_after(self.wishes.frame, if steps < 0.0 { 1 } else { -1 })
            }
            Action::Turn(..) | Action::Walk(2, _) | Action::Walk(0, _) => return true,
            Action::Reset => 0,
            Action::Look(_)
            | Action::Projection
            | Action::Cull
            | Action::Hide
            | Action::Depth
            | Action::Difference
            | Action::Plan
            | Action::SaveView
            | Action::Zoom(_)
            | Action::NextPlane(_)
            | Action::TurnPlane(_)
            | Action::TurnAbout => {
                self.say("not in the tour: F1 lists its keys".to_owned());
                return true;
            }
            _ => return false,
        };
        self.passed = 0.0;
        self.set_frame(frame);
        self.is_stale = true;
        true
    }

    /// Moves the tour to a frame.
    pub fn go_to(&mut self, frame: u64) {
        self.set_frame(frame);
        self.is_stale = true;
    }

    /// Returns the frames that a movie of the tour shows; none of other models.
    pub fn tour_movie_frames(&self) -> Vec<u64> {
        match &self.subject {
            Subject::Tour(tour) => tour.movie_frames(),
            _ => Vec::new(),
        }
    }
}

#[cfg(test)]
mod tests;
