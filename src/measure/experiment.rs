//! Experiments and the rows of their tables.

use super::clock::{self, Timing};
use std::time::Duration;

/// Size of the subjects, and time budget.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Effort {
    /// True for smaller subjects, for a report in under a minute.
    pub is_quick: bool,
    /// Time budget of each row; `None` takes no times, which changes no error.
    pub time_per_row: Option<Duration>,
}

impl Effort {
    /// Quick report.
    pub const QUICK: Effort = Effort { is_quick: true, time_per_row: Some(Duration::from_millis(120)) };
    /// Full report.
    pub const FULL: Effort = Effort { is_quick: false, time_per_row: Some(Duration::from_secs(1)) };

    /// Returns the same effort without times.
    pub fn untimed(self) -> Effort {
        Effort { time_per_row: None, ..self }
    }

    /// Returns `quick` or `full`, by the effort.
    pub fn pick<T>(&self, quick: T, full: T) -> T {
        if self.is_quick { quick } else { full }
    }

    /// Runs `work` and returns its output, with its timing if times are taken.
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

/// Promised limit of one error column.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bound {
    /// Index of the column.
    pub column: usize,
    /// Largest accepted error.
    pub at_most: f64,
}

/// Result of one alternative on one subject.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Subject: a scene or a parameter.
    pub subject: String,
    /// Name of the alternative.
    pub alternative: String,
    /// True if the program uses this alternative by default.
    pub is_default: bool,
    /// Errors, in the order of the experiment's columns.
    pub errors: Vec<f64>,
    /// Promised limits of the errors.
    pub bounds: Vec<Bound>,
    /// False if this machine cannot run the alternative: there are no errors, bounds and times.
    pub is_run: bool,
    /// Timing of one run, if it was timed.
    pub timing: Option<Timing>,
    /// Units of work in one run (see [`Experiment::unit`]).
    pub work: f64,
    /// Drawn picture, if the experiment draws pictures.
    pub picture: Option<Picture>,
}

/// Small picture with its reference.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// Width in pixels.
    pub width: u32,
    /// RGBA bytes drawn.
    pub found: Vec<u8>,
    /// RGBA bytes of the reference.
    pub truth: Vec<u8>,
}

impl Picture {
    /// Returns the absolute difference of each channel times 16, as opaque RGBA bytes.
    pub fn difference(&self) -> Vec<u8> {
        let channel = |(i, (a, b)): (usize, (&u8, &u8))| {
            if i % 4 == 3 { 255 } else { a.abs_diff(*b).saturating_mul(16) }
        };
        self.found.iter().zip(&self.truth).enumerate().map(channel).collect()
    }
}

impl Row {
    /// Returns the row of an alternative that this machine cannot run.
    pub fn not_run(subject: String, alternative: String, columns: usize) -> Row {
        Row {
            subject,
            alternative,
            is_default: false,
            errors: vec![f64::NAN; columns],
            bounds: Vec::new(),
            is_run: false,
            timing: None,
            work: 1.0,
            picture: None,
        }
    }

    /// Returns whether all bounds are met. A NaN error meets none.
    pub fn is_within_bounds(&self) -> bool {
        self.bounds.iter().all(|b| self.errors[b.column] <= b.at_most)
    }

    /// Returns the timing, unless the row is out of bounds, was not timed, or is too short for the
    /// clock.
    fn shown_timing(&self) -> Option<Timing> {
        self.timing.filter(|timing| self.is_within_bounds() && timing.is_measurable())
    }

    /// Returns the median of the nanoseconds per unit of work, or `None` if the row is out of
    /// bounds, was not timed, or is too short for the clock.
    pub fn nanoseconds_per_unit(&self) -> Option<f64> {
        self.nanosecond_quartiles().map(|quartiles| quartiles[1])
    }

    /// Returns first quartile, median and third quartile of the nanoseconds per unit of work, under
    /// the same conditions.
    pub fn nanosecond_quartiles(&self) -> Option<[f64; 3]> {
        Some(self.shown_timing()?.quartiles_s.map(|s| s * 1e9 / self.work))
    }
}

/// Set of alternatives for one stage.
#[derive(Clone, Copy, Debug)]
pub struct Experiment {
    /// Short name, for files and links.
    pub id: &'static str,
    /// Heading.
    pub title: &'static str,
    /// Description of the comparison and of the errors.
    pub about: &'static str,
    /// Names of the error columns.
    pub columns: &'static [&'static str],
    /// Index of the column that the plot of speed against error shows.
    pub plotted: usize,
    /// Name of one unit of work.
    pub unit: &'static str,
    /// Function that computes the rows.
    pub rows: fn(&Effort) -> Vec<Row>,
}
