//! `fbptr eye --bench`: speed against error of fans of rays, for several spaces and screens.

use crate::cli::report::machine;
use crate::cli::{Status, check_folder, output, say_as_program};
use crate::measure::{Effort, Report, Section, experiments, eye_goals, scaling_studies, write};
use crate::save;
use clap::Args;
use std::path::PathBuf;

/// Options of `eye --bench`.
#[derive(Debug, Args)]
pub(super) struct Bench {
    /// Print a table of speed against error: fans of rays against the exact fibre
    #[arg(long, conflicts_with = "shape")]
    pub bench: bool,
    /// Small pictures, little time
    #[arg(long, requires = "bench", conflicts_with_all = ["shape", "scene"])]
    quick: bool,
    /// Write the tables with their plots as a page, or the plots alone as a picture
    #[arg(long, value_name = "FILE.html|FILE.svg", requires = "bench", conflicts_with_all = ["shape", "scene"])]
    out: Option<PathBuf>,
}

impl Bench {
    pub fn run(&self) -> Status {
        if let Err(message) = self.check() {
            say_as_program(message);
            return Status::BadArguments;
        }
        let effort = if self.quick { Effort::QUICK } else { Effort::FULL };
        let sections = experiments().into_iter().filter(|e| matches!(e.id, "fan" | "eye"));
        let sections = sections.map(|experiment| Section::of(experiment, &effort));
        let sections = sections.collect();
        let scaling = scaling_studies().into_iter().filter(|g| g.id == "facets");
        let scaling = scaling.flat_map(|study| (study.run)(&effort)).collect();
        let report = Report { effort, decisions: Vec::new(), sections, scaling };
        let machine = machine(if self.quick { "fbptr eye --bench --quick" } else { "fbptr eye --bench" });
        let goals = eye_goals(&report);
        let text = write::markdown(&report, &machine) + &write::goals_markdown(&goals);
        output::print(text);
        let broken = report.broken_bounds();
        broken.iter().for_each(say_as_program);
        let is_picture = self.out.as_ref().is_some_and(|path| path.extension().is_some_and(|e| e == "svg"));
        let page = match is_picture {
            true => write::contact_sheet(&report, &machine),
            false => write::html(&report, &machine),
        };
        let saved =
            self.out.as_ref().map(|path| save::atomically(path, |out| out.write_all(page.as_bytes())));
        if let Some(Err(e)) = saved {
            say_as_program(e);
            return Status::Failed;
        }
        if broken.is_empty() { Status::Success } else { Status::Failed }
    }

    /// Checks the name of the output before anything is measured.
    fn check(&self) -> Result<(), String> {
        let Some(path) = &self.out else { return Ok(()) };
        if !path.extension().is_some_and(|ending| ending == "html" || ending == "svg") {
            return Err(format!("{}: expected .html or .svg", path.display()));
        }
        check_folder(path)
    }
}
