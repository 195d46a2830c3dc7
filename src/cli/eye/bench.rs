//! `fbptr eye --bench`: speed against error of fans of rays, per space and screen.

use crate::cli::{Status, say, say_as_program};
use crate::measure::{Effort, Report, Section, experiments, write};
use crate::save;
use clap::Args;
use std::io::Write;
use std::path::PathBuf;

/// What to measure.
#[derive(Debug, Args)]
pub(super) struct Bench {
    /// Print a table of speed against error: fans of rays against the exact fibre
    #[arg(long, conflicts_with = "shape")]
    pub bench: bool,
    /// Small pictures, little time
    #[arg(long, requires = "bench")]
    quick: bool,
    /// Write the table with its plot as a page
    #[arg(long, value_name = "FILE.html", requires = "bench")]
    out: Option<PathBuf>,
}

impl Bench {
    pub fn run(&self) -> Status {
        let effort = if self.quick { Effort::QUICK } else { Effort::FULL };
        let sections = experiments().into_iter().filter(|e| e.id == "fan");
        let sections = sections.map(|experiment| Section { experiment, rows: (experiment.rows)(&effort) });
        let report = Report { effort, sections: sections.collect() };
        let machine = format!("Made by fbptr {} on {}.", env!("CARGO_PKG_VERSION"), std::env::consts::ARCH);
        let _ = write!(std::io::stdout().lock(), "{}", write::markdown(&report, &machine));
        let broken = report.broken_bounds();
        broken.iter().for_each(|line| say(line));
        let page = write::html(&report, &machine);
        let saved =
            self.out.as_ref().map(|path| save::atomically(path, |out| out.write_all(page.as_bytes())));
        if let Some(Err(e)) = saved {
            say_as_program(e);
            return Status::Failed;
        }
        if broken.is_empty() { Status::Success } else { Status::Failed }
    }
}
