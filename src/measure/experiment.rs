//! What an experiment is, and what a row of its table holds.

use super::clock::{self, Timing};
use std::time::Duration;

/// How much is done, and whether it is timed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Effort {
    /// Smaller subjects, for a report in under a minute.
    pub is_quick: bool,
    /// How long each row may be timed; `None` takes no times, which changes no error.
    pub time_per_row: Option<Duration>,
}

impl Effort {
    /// The quick report.
    pub const QUICK: Effort = Effort { is_quick: true, time_per_row: Some(Duration::from_millis(120)) };
    /// The whole report.
    pub const FULL: Effort = Effort { is_quick: false, time_per_row: Some(Duration::from_secs(1)) };

    /// The same without times.
    pub fn untimed(self) -> Effort {
        Effort { time_per_row: None, ..self }
    }

    /// `quick` or `full`, as the effort is.
    pub fn pick<T>(&self, quick: T, full: T) -> T {
        if self.is_quick { quick } else { full }
    }

    /// The output of `work`, and how long it takes where times are taken.
    pub fn run<T>(&self, mut work: impl FnMut() -> T) -> (T, Option<Timing>) {
        match self.time_per_row {
            None => (work(), None),
            Some(budget) => {
                let (output, timing) = clock::time(budget, work);
                (output, Some(timing))
            }
        }
    }
}

/// A promise about one error column.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bound {
    /// Which column.
    pub column: usize,
    /// The error is at most this.
    pub at_most: f64,
}

/// One alternative on one subject.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// What it was done on: a scene, a parameter.
    pub subject: String,
    /// Which way of doing it.
    pub alternative: String,
    /// Whether it is what the program does unless told otherwise.
    pub is_default: bool,
    /// The errors, in the order of the experiment's columns.
    pub errors: Vec<f64>,
    /// What is promised of them.
    pub bounds: Vec<Bound>,
    /// How long one run took, if it was timed.
    pub timing: Option<Timing>,
    /// Units of work in one run (see [`Experiment::unit`]).
    pub work: f64,
    /// What was drawn, where the experiment is on pictures.
    pub picture: Option<Picture>,
}

/// A small picture beside its truth.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// Width in pixels.
    pub width: u32,
    /// RGBA bytes that were drawn.
    pub found: Vec<u8>,
    /// RGBA bytes that are right.
    pub truth: Vec<u8>,
}

impl Picture {
    /// The difference of each channel, 16 times, as RGBA bytes.
    pub fn difference(&self) -> Vec<u8> {
        let channel = |(i, (a, b)): (usize, (&u8, &u8))| {
            if i % 4 == 3 { 255 } else { a.abs_diff(*b).saturating_mul(16) }
        };
        self.found.iter().zip(&self.truth).enumerate().map(channel).collect()
    }
}

impl Row {
    /// Whether every bound is kept. An error that is not a number keeps none.
    pub fn is_within_bounds(&self) -> bool {
        self.bounds.iter().all(|b| self.errors[b.column] <= b.at_most)
    }

    /// Nanoseconds for a unit of work, unless the row broke a bound or was not timed.
    pub fn nanoseconds_per_unit(&self) -> Option<f64> {
        let timing = self.timing.filter(|_| self.is_within_bounds())?;
        Some(timing.min_s * 1e9 / self.work)
    }
}

/// A set of alternatives for one stage.
#[derive(Clone, Copy, Debug)]
pub struct Experiment {
    /// Short name, for files and links.
    pub id: &'static str,
    /// Heading.
    pub title: &'static str,
    /// What is compared with what, and how the errors are meant.
    pub about: &'static str,
    /// The error columns.
    pub columns: &'static [&'static str],
    /// The column that the plot of speed against error shows.
    pub plotted: usize,
    /// What one unit of work is.
    pub unit: &'static str,
    /// Makes the rows.
    pub rows: fn(&Effort) -> Vec<Row>,
}
