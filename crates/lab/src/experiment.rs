//! Experiments and the rows of their tables.

use super::clock::{self, Timing, Work};
use fbptr_core::pipeline::{RenderOptions, Renderer};
use fbptr_core::simd::Level;
use fbptr_server::worker_pool;
use std::time::Duration;

/// Size of the subjects, and time budget.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Effort {
    /// True for smaller subjects, for a report in under a minute.
    pub is_quick: bool,
    /// Time budget of each row; `None` takes no times, which changes no error.
    pub time_per_row: Option<Duration>,
    /// True to turn the output of each bounded row wrong by a little more than its bound as well,
    /// which the row has to notice ([`Row::mutants`]): for tests alone.
    pub has_mutants: bool,
    /// SIMD level that draws; `None` is the best one here.
    pub simd: Option<Level>,
    /// Threads that draw.
    pub threads: usize,
}

impl Effort {
    /// Quick report.
    pub const QUICK: Effort = Effort {
        is_quick: true,
        time_per_row: Some(Duration::from_millis(120)),
        has_mutants: false,
        simd: None,
        threads: 1,
    };
    /// Full report.
    pub const FULL: Effort =
        Effort { is_quick: false, time_per_row: Some(Duration::from_secs(1)), ..Effort::QUICK };

    /// Returns the same effort without times.
    pub fn untimed(self) -> Effort {
        Effort { time_per_row: None, ..self }
    }

    /// Returns the same effort with mutants.
    pub fn with_mutants(self) -> Effort {
        Effort { has_mutants: true, ..self }
    }

    /// Returns the same effort, drawn by a level on some threads, which changes no error.
    pub fn drawn_by(self, simd: Option<Level>, threads: usize) -> Effort {
        Effort { simd, threads, ..self }
    }

    /// Returns a renderer with the effort's level and threads.
    pub(super) fn renderer(&self) -> Renderer {
        let pool = worker_pool(Some(self.threads));
        Renderer::new(RenderOptions { pool, simd: self.simd, ..RenderOptions::default() })
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

    /// Runs the works of a subject's rows. Returns their outputs, each with its timing if times are
    /// taken: in turns, so that they can be compared.
    pub(super) fn run_in_turns<T>(&self, works: Vec<Work<'_, T>>) -> Vec<(T, Option<Timing>)> {
        match self.time_per_row {
            None => works.into_iter().map(|mut work| (work(), None)).collect(),
            Some(budget) => {
                let timed = clock::in_turns(budget, works).into_iter();
                timed.map(|(output, timing)| (output, Some(timing))).collect()
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
    /// Derivation of the limit, in one line.
    pub because: &'static str,
}

/// Standing of an alternative.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Standing {
    /// The program draws this way unless told otherwise.
    Default,
    /// A mode that a user can choose.
    Mode,
    /// For comparison: no mode of the program, or the default on another number of threads.
    Comparison,
}

/// Result of one alternative on one subject.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Subject: a scene or a parameter.
    pub subject: String,
    /// Name of the alternative.
    pub alternative: String,
    /// Standing of the alternative.
    pub standing: Standing,
    /// Errors, in the order of the experiment's columns.
    pub errors: Vec<f64>,
    /// Promised limits of the errors.
    pub bounds: Vec<Bound>,
    /// Error of each bound's column after the output was turned wrong by a little more than the
    /// bound; empty without [`Effort::has_mutants`].
    pub mutants: Vec<f64>,
    /// False if this machine cannot run the alternative: there are no errors, bounds and times.
    pub is_run: bool,
    /// Timing of one run, if it was timed: in turns with the other rows of its subject.
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
    /// Returns the row of an alternative whose `output` has the errors that `judge` finds. `mutate`
    /// turns an output wrong by a little more than a bound.
    pub(super) fn judged<T: Clone>(
        effort: &Effort,
        (subject, alternative, standing): (&str, &str, Standing),
        output: &T,
        bounds: Vec<Bound>,
        judge: impl Fn(&T) -> Vec<f64>,
        mutate: impl Fn(&mut T, &Bound),
    ) -> Row {
        let error_of_mutant = |bound: &Bound| {
            let mut wrong = output.clone();
            mutate(&mut wrong, bound);
            judge(&wrong)[bound.column]
        };
        Row {
            subject: subject.into(),
            alternative: alternative.into(),
            standing,
            errors: judge(output),
            mutants: bounds.iter().filter(|_| effort.has_mutants).map(error_of_mutant).collect(),
            bounds,
            is_run: true,
            timing: None,
            work: 1.0,
            picture: None,
        }
    }

    /// Returns the row with the timing of a run of `work` units.
    pub(super) fn timed(self, timing: Option<Timing>, work: f64) -> Row {
        Row { timing, work, ..self }
    }

    /// Returns the row with a picture.
    pub(super) fn with_picture(self, width: u32, found: Vec<u8>, truth: Vec<u8>) -> Row {
        Row { picture: Some(Picture { width, found, truth }), ..self }
    }

    /// Returns whether the program draws this way unless told otherwise.
    pub fn is_default(&self) -> bool {
        self.standing == Standing::Default
    }

    /// Returns the row of an alternative that this machine cannot run.
    pub fn not_run(subject: String, alternative: String, columns: usize) -> Row {
        Row {
            subject,
            alternative,
            standing: Standing::Mode,
            errors: vec![f64::NAN; columns],
            bounds: Vec::new(),
            mutants: Vec::new(),
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
    fn shown_timing(&self) -> Option<&Timing> {
        self.timing.as_ref().filter(|timing| self.is_within_bounds() && timing.is_measurable())
    }

    /// Returns first quartile, median and third quartile of the row's time a unit over that of
    /// another row of its subject, round by round; `None` if one of them shows no time.
    pub fn time_over(&self, other: &Row) -> Option<[f64; 3]> {
        let ratios = self.shown_timing()?.over(other.shown_timing()?);
        Some(ratios.map(|ratio| ratio * other.work / self.work))
    }

    /// Returns whether the row is plainly faster than another of its subject: by a tenth or more in
    /// the median round, and at all in three of four.
    pub fn is_plainly_faster(&self, other: &Row) -> Option<bool> {
        let [_, median, high] = self.time_over(other)?;
        Some(median < 0.9 && high < 1.0)
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

/// Definition that the errors of an experiment are measured against; never one of its rows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Truth {
    /// The definition.
    pub is: &'static str,
    /// Digits with which it is computed.
    pub digits: &'static str,
    /// Second way by which it is computed, and what is compared.
    pub second_way: &'static str,
}

/// Agreement of a truth with its second way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Check {
    /// Largest difference of both ways.
    pub difference: f64,
    /// Largest accepted difference.
    pub at_most: f64,
}

impl Check {
    /// Returns whether both ways agree.
    pub fn is_right(&self) -> bool {
        self.difference <= self.at_most
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
    /// Truth that the errors are measured against.
    pub truth: Truth,
    /// Function that computes the truth in a second way.
    pub check: fn(&Effort) -> Check,
    /// Names of the error columns.
    pub columns: &'static [&'static str],
    /// Index of the column that the plot of speed against error shows.
    pub plotted: usize,
    /// Name of one unit of work.
    pub unit: &'static str,
    /// Function that computes the rows.
    pub rows: fn(&Effort) -> Vec<Row>,
}
