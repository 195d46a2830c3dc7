//! The last figure of a stream's frame, pixel by pixel.
//!
//! In: the stream's bytes up to the shown frame. Out: the picture as the figure's algorithm has reached
//! one pixel after the other, and the numbers that decide each. Right is: at the last pixel the picture
//! is the one that the figure has made; what the stream draws after it is left out.

use super::replay::{Playing, Replay};
use super::{Show, Subject, Viewer};
use fbptr_command::{Command, Decoder, EndOfInput, Figure, Flow, Limits, Sink, StreamError, StreamPosition};
use fbptr_core::memory::{Rgba, VideoMemory};
use fbptr_core::pipeline::RenderPath;
use fbptr_core::scene::ViewOverrides;
use fbptr_server::{Step, figure_steps};

/// A figure whose pixels are shown one by one.
pub(super) struct Walk {
    picture: VideoMemory,
    /// Each pixel, and its bytes before it was drawn.
    steps: Vec<(Step, Rgba)>,
    shown: usize,
    command: Command,
    /// Its verb, and the line of the stream that it is in.
    name: String,
}

impl Walk {
    /// Returns the last figure with numbers of the shown frame, with none of its pixels.
    pub fn new(replay: &Replay, overrides: ViewOverrides) -> Result<Walk, String> {
        let (bytes, make_engine) = replay.played();
        let mut playing = Playing::new(bytes, make_engine, overrides, RenderPath::Fast)?;
        if !playing.is_stream() {
            return Err("a recording is not stepped through, only a stream of commands".to_owned());
        }
        let mut last = LastFigure::default();
        last.read(bytes);
        let Some((command, place, end)) = last.found else {
            return Err("no LINE, LINEAA, CIRCLE, FILL or FILLPOLY to step through".to_owned());
        };
        playing.play_bytes(&bytes[..place.byte as usize]);
        let picture = playing.memory().clone();
        let mut with_figure = bytes[..end].to_vec();
        if with_figure.last() != Some(&b'\n') {
            with_figure.push(b'\n');
        }
        playing.play_bytes(&with_figure);
        let found = figure_steps(Some(&command), &picture, playing.memory());
        if found.is_empty() {
            return Err("the last figure changes no pixel".to_owned());
        }
        let before = |step: &Step| {
            let at = &picture.bytes()[step.offset..step.offset + 4];
            [at[0], at[1], at[2], at[3]]
        };
        let steps =
            found.into_iter().map(|step| (before(&step), step)).map(|(old, step)| (step, old)).collect();
        let name = format!("{}, line {}", command.verb(), place.line);
        Ok(Walk { picture, steps, shown: 0, command, name })
    }

    /// Returns the picture.
    pub fn picture(&self) -> &VideoMemory {
        &self.picture
    }

    /// Shows one pixel more or less. Returns whether there is one.
    fn go(&mut self, is_forward: bool) -> bool {
        let next = if is_forward { Some(self.shown) } else { self.shown.checked_sub(1) };
        let Some((step, old)) = next.and_then(|next| self.steps.get(next)) else { return false };
        let color = if is_forward { step.color } else { *old };
        self.picture.bytes_mut()[step.offset..step.offset + 4].copy_from_slice(&color);
        self.shown = if is_forward { self.shown + 1 } else { self.shown - 1 };
        true
    }

    /// Returns the pixel that was shown last, x and y.
    pub fn at(&self) -> Option<[f64; 2]> {
        let (step, _) = self.steps.get(self.shown.checked_sub(1)?)?;
        let (pixel, width) = (step.offset / 4, self.picture.width() as usize);
        Some([(pixel % width) as f64, (pixel / width) as f64])
    }

    /// Returns the numbers of the pixel that was shown last, one a line.
    pub fn numbers(&self) -> Vec<String> {
        let step = self.shown.checked_sub(1).and_then(|at| self.steps.get(at));
        let size = [self.picture.width(), self.picture.height()];
        let text = step.map_or_else(String::new, |(step, _)| step.text(Some(&self.command), size));
        let text = text.split_once(")  ").map_or("", |(_, text)| text);
        let is_walk = text.starts_with("step ");
        let parts = text.split(if is_walk { ", " } else { "; " }).filter(|part| !part.is_empty());
        parts.map(str::to_owned).collect()
    }

    /// Returns the line of the overlay.
    pub fn line(&self) -> String {
        format!("{}: pixel {} of {}", self.name, self.shown, self.steps.len())
    }
}

impl Viewer {
    /// Shows one pixel more or less of the shown frame's last figure.
    pub(super) fn walk_figure(&mut self, is_forward: bool) {
        let Subject::Replay(replay) = &self.subject else {
            return self.say("that key is for streams of commands".to_owned());
        };
        (self.is_paused, self.show) = (true, Show::Picture);
        if self.walk.is_none() {
            match Walk::new(replay, self.wishes.view_overrides()) {
                Ok(walk) => self.walk = Some(Box::new(walk)),
                Err(message) => return self.say(message),
            }
        }
        let Some(walk) = &mut self.walk else { return };
        if !walk.go(is_forward) {
            self.say(if is_forward { "the figure is whole" } else { "there is no pixel before" }.to_owned());
        }
        self.has_walked = true;
    }
}

/// The last figure that has numbers, where it begins, and the place behind it.
#[derive(Default)]
struct LastFigure {
    found: Option<(Command, StreamPosition, usize)>,
    is_new: bool,
}

impl LastFigure {
    fn read(&mut self, bytes: &[u8]) {
        let (mut decoder, mut used) = (Decoder::new(Limits::default()), 0);
        while used < bytes.len() {
            let (count, flow) = decoder.feed_some(&bytes[used..], self);
            used += count;
            if let (true, Some((_, _, end))) = (std::mem::take(&mut self.is_new), &mut self.found) {
                *end = used;
            }
            if flow == Flow::Stop || (count == 0 && flow != Flow::Pause) {
                return;
            }
        }
        // A last line without its end.
        let _ = decoder.finish(EndOfInput::File, self);
        if let (true, Some((_, _, end))) = (self.is_new, &mut self.found) {
            *end = used;
        }
    }
}

impl Sink for LastFigure {
    fn pixel(&mut self, _: i32, _: i32, _: Rgba) {}

    fn binary_pixels(&mut self, _: &[u8]) {}

    fn command(&mut self, command: Command, place: StreamPosition) -> Flow {
        let Command::Figure(
            Figure::Line { .. }
            | Figure::LineAa { .. }
            | Figure::Circle { .. }
            | Figure::Fill { .. }
            | Figure::FillPoly { .. },
        ) = &command
        else {
            return Flow::Continue;
        };
        self.found = Some((command, place, 0));
        self.is_new = true;
        Flow::Pause
    }

    fn error(&mut self, _: StreamError) -> Flow {
        Flow::Continue
    }
}
