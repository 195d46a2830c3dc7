//! `--expect`: the picture at the end of a command beside a golden one, or beside what a scene or
//! stream shows.
//!
//! A golden picture is compared by the golden test's rules: the frame and the magnified difference
//! are written beside it, and `BLESS=1` rewrites it. What differs is classified as `fbptr compare`
//! does, which prints the same words.

use super::compare::{Exact, Reading, is_picture};
use super::render_args::RenderArgs;
use super::{say, say_as_program};
use crate::measure::difference::WrongPixels;
use crate::memory::VideoMemory;
use crate::save::golden::{self, GoldenError, Mode, Tolerance};
use clap::Args;
use std::path::PathBuf;

/// Help of `--tolerance`.
pub(super) const TOLERANCE: &str = "Difference that is allowed in a channel, and the number of pixels that may \
                                    differ by more";

/// Arguments of a command that ends with a picture.
#[derive(Clone, Debug, Args)]
pub(super) struct ExpectArgs {
    /// Compare the frame at the end with a picture, or with what a scene or stream shows. The
    /// status is 0 if they are equal; if not, it is 1, the wrong pixels are put into classes as by
    /// `fbptr compare`, and the frame and the difference are written beside a picture. BLESS=1 in
    /// the environment writes the picture, and fails
    #[arg(long, value_name = "FILE|SCENE")]
    pub(super) expect: Option<PathBuf>,
    #[arg(long, value_name = "N[,PIXELS]", default_value = "0", requires = "expect", help = TOLERANCE)]
    tolerance: String,
}

/// An expected picture.
#[derive(Clone, Debug)]
pub(super) struct Expected {
    path: PathBuf,
    tolerance: Tolerance,
    drawing: RenderArgs,
}

impl ExpectArgs {
    /// Checks the arguments before anything is drawn; `None` if nothing is expected.
    pub(super) fn check(&self, drawing: &RenderArgs) -> Result<Option<Expected>, String> {
        let tolerance = parse_tolerance(&self.tolerance)?;
        let Some(path) = self.expect.clone() else { return Ok(None) };
        if !is_picture(&path) && !path.exists() && crate::models::named(&path.to_string_lossy()).is_none() {
            return Err(format!("--expect {}: there is no such file", path.display()));
        }
        Ok(Some(Expected { path, tolerance, drawing: drawing.clone() }))
    }
}

impl Expected {
    /// Compares a frame, says what is wrong with it, and returns whether it is equal.
    pub(super) fn is_met_by(&self, memory: &VideoMemory) -> bool {
        // Golden pictures are PNG files.
        match self.path.extension().is_some_and(|e| e.eq_ignore_ascii_case("png")) {
            true => self.is_golden(memory),
            false => self.is_drawn(memory),
        }
    }

    fn is_golden(&self, memory: &VideoMemory) -> bool {
        let Err(error) = golden::check(memory, &self.path, self.tolerance, Mode::from_env()) else {
            return true;
        };
        say_as_program(&error);
        if let (GoldenError::Differs { .. }, Ok(exact)) = (&error, golden::read_png(&self.path)) {
            classes(&WrongPixels::new(memory, &exact, self.tolerance.per_channel, None));
        }
        false
    }

    fn is_drawn(&self, memory: &VideoMemory) -> bool {
        let reading = Reading {
            size: Some([memory.width(), memory.height()]),
            time: 0.0,
            load_dir: None,
            meshes: None,
            drawing: &self.drawing,
        };
        let exact = match Exact::read(&self.path, reading) {
            Ok(exact) => exact,
            Err(message) => {
                say_as_program(format_args!("--expect {message}"));
                return false;
            }
        };
        let difference = exact.difference(memory, self.tolerance.per_channel);
        if difference.size == difference.exact_size && difference.wrong <= self.tolerance.pixels {
            return true;
        }
        say_as_program(format_args!("{}: the picture differs", self.path.display()));
        classes(&difference);
        false
    }
}

/// Prints the classes of a difference.
fn classes(difference: &WrongPixels) {
    say(difference.to_string().trim_end());
}

/// Parses `N` or `N,PIXELS`.
pub(super) fn parse_tolerance(text: &str) -> Result<Tolerance, String> {
    let (channel, pixels) = text.split_once(',').unwrap_or((text, "0"));
    match (channel.parse(), pixels.parse()) {
        (Ok(per_channel), Ok(pixels)) => Ok(Tolerance { per_channel, pixels }),
        _ => Err(format!("--tolerance: N or N,PIXELS is expected, N to 255, not {text:?}")),
    }
}
