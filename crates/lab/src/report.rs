//! Report of all experiments.

use super::decide::{self, Decision};
use super::experiment::{Check, Effort, Experiment, Row, Standing};
use super::scaling::Scaling;
use std::cmp::Ordering;

/// Returns all experiments, in the order of the stages.
pub fn experiments() -> Vec<Experiment> {
    vec![
        super::lines::LINES,
        super::coverage::COVERAGE,
        super::interpolation::INTERPOLATION,
        super::depth::DEPTH,
        super::shading::SHADING,
        super::textures::TEXTURES,
        super::hidden_surfaces::HIDDEN,
        super::stages::STAGES,
        super::fibre_fan::FAN,
        super::eye::EYE,
        super::threads::THREADS,
        super::pictures::PICTURES,
    ]
}

/// Group of growth measurements.
#[derive(Clone, Copy, Debug)]
pub struct ScalingStudy {
    /// Short name.
    pub id: &'static str,
    /// Heading.
    pub title: &'static str,
    /// Function that measures it; points have no time if [`Effort`] has no time budget.
    pub run: fn(&Effort) -> Vec<Scaling>,
}

/// Returns all growth studies.
pub fn scaling_studies() -> Vec<ScalingStudy> {
    use super::{eye, scaling_studies};
    let study = |id, title, run| ScalingStudy { id, title, run };
    vec![
        study("triangles", "Growth with triangles", scaling_studies::triangles),
        study("pixels", "Growth with pixels", scaling_studies::pixels),
        study("lights", "Growth with lights", scaling_studies::lights),
        study("overdraw", "Growth with overdraw", scaling_studies::overdraw),
        study("clients", "Growth with clients", scaling_studies::clients),
        study("facets", "Growth with the eye's facets", eye::scaling_with_facets),
    ]
}

/// Experiment with its rows.
#[derive(Clone, Debug)]
pub struct Section {
    /// The experiment.
    pub experiment: Experiment,
    /// Rows that it produced.
    pub rows: Vec<Row>,
    /// Agreement of its truth with the second way.
    pub check: Check,
}

impl Section {
    /// Runs an experiment.
    pub fn of(experiment: Experiment, effort: &Effort) -> Section {
        Section { experiment, rows: (experiment.rows)(effort), check: (experiment.check)(effort) }
    }

    /// Iterates over the subjects in order, each with its rows.
    pub fn subjects(&self) -> impl Iterator<Item = (&str, &[Row])> {
        self.rows.chunk_by(|a, b| a.subject == b.subject).map(|rows| (rows[0].subject.as_str(), rows))
    }

    /// Returns (subject, alternative) of the modes that are clearly better than the default: plainly
    /// faster with no more error, or with at most half the error and the default not plainly faster.
    /// Returns `None` if nothing was timed, or there is no default or no other mode.
    pub fn better_than_default(&self) -> Option<Vec<(&str, &str)>> {
        let column = self.experiment.plotted;
        let mut better = Vec::new();
        let mut has_modes = false;
        for (subject, rows) in self.subjects() {
            let Some(default) = rows.iter().find(|r| r.is_default()) else { continue };
            if default.nanoseconds_per_unit().is_none() {
                continue;
            }
            let error = default.errors[column];
            for row in rows.iter().filter(|r| r.standing == Standing::Mode) {
                has_modes = true;
                let is_faster = row.is_plainly_faster(default) == Some(true) && row.errors[column] <= error;
                let is_nearer = row.errors[column] <= 0.5 * error && error > 0.0;
                if is_faster || (is_nearer && default.is_plainly_faster(row) == Some(false)) {
                    better.push((subject, row.alternative.as_str()));
                }
            }
        }
        has_modes.then_some(better)
    }

    /// Returns the result of [`Section::better_than_default`] as a sentence.
    pub fn verdict(&self) -> String {
        match self.better_than_default() {
            None => "Nothing here can be chosen in place of the default.".into(),
            Some(better) if better.is_empty() => {
                "Nothing else is a tenth faster than the default with no more error, or has half its error and is not a \
                 tenth slower, on any subject."
                    .into()
            }
            Some(better) => {
                let named: Vec<String> = better.iter().map(|(subject, name)| format!("{name} ({subject})")).collect();
                format!(
                    "Plainly better than the default, a tenth faster with no more error, or half the error and not a tenth \
                     slower: {}.",
                    named.join("; ")
                )
            }
        }
    }

    /// Returns whether `row` is on the Pareto front of `rows`: a mode of the program, plainly faster
    /// than each that is more accurate, while none that is as accurate is plainly faster.
    pub fn is_on_front(&self, rows: &[Row], row: &Row) -> bool {
        let column = self.experiment.plotted;
        let is_mode = |r: &&Row| r.standing != Standing::Comparison && r.nanoseconds_per_unit().is_some();
        let keeps = |other: &Row| match other.errors[column].total_cmp(&row.errors[column]) {
            Ordering::Less => row.is_plainly_faster(other) == Some(true),
            Ordering::Equal => other.is_plainly_faster(row) == Some(false),
            Ordering::Greater => true,
        };
        is_mode(&row) && rows.iter().filter(is_mode).all(keeps)
    }
}

/// Results of a run.
#[derive(Clone, Debug)]
pub struct Report {
    /// Effort of the run.
    pub effort: Effort,
    /// The settings of pictures, compared; before the sections.
    pub decisions: Vec<Decision>,
    /// One section per experiment.
    pub sections: Vec<Section>,
    /// Growth measurements.
    pub scaling: Vec<Scaling>,
}

impl Report {
    /// Iterates over the sections, those of the decisions first.
    pub fn all_sections(&self) -> impl Iterator<Item = &Section> {
        self.decisions.iter().map(|d| &d.section).chain(&self.sections)
    }

    /// Returns a warning if the machine was not calm: if of more than a tenth of the timed rows the
    /// quartiles are further apart than a quarter of the median.
    pub fn unrest(&self) -> Option<String> {
        let timings = || self.all_sections().flat_map(|s| &s.rows).filter_map(|row| row.timing.as_ref());
        let (all, restless) = (timings().count(), timings().filter(|t| t.spread() > 0.25).count());
        (restless * 10 > all).then(|| {
            format!(
                "The machine was not calm: of {restless} of {all} rows the quartiles of the time are further apart than a quarter \
                 of the median. Verdicts may differ in the next run."
            )
        })
    }

    /// Returns the rows outside their bounds, as lines of text.
    pub fn broken_bounds(&self) -> Vec<String> {
        let mut broken = Vec::new();
        for s in self.all_sections() {
            if !s.check.is_right() {
                broken.push(format!(
                    "{}: the truth and its second way differ by {}, at most {} is expected",
                    s.experiment.title, s.check.difference, s.check.at_most
                ));
            }
            for row in s.rows.iter().filter(|r| !r.is_within_bounds()) {
                for b in row.bounds.iter().filter(|b| !matches!(row.errors[b.column], e if e <= b.at_most)) {
                    broken.push(format!(
                        "{}, {}, {}: {} is {}, at most {} is promised",
                        s.experiment.title,
                        row.subject,
                        row.alternative,
                        s.experiment.columns[b.column],
                        row.errors[b.column],
                        b.at_most
                    ));
                }
            }
        }
        broken
    }
}

/// Runs all experiments; `progress` is called with the title of each before it begins.
pub fn run(effort: Effort, progress: &mut dyn FnMut(&str)) -> Report {
    progress("Settings for six scenes");
    let decisions = decide::made(&effort);
    let sections = experiments()
        .into_iter()
        .map(|experiment| {
            progress(experiment.title);
            Section::of(experiment, &effort)
        })
        .collect();
    let mut scaling = Vec::new();
    if effort.time_per_row.is_some() {
        for study in scaling_studies() {
            progress(study.title);
            scaling.extend((study.run)(&effort));
        }
    }
    Report { effort, decisions, sections, scaling }
}

#[cfg(test)]
mod tests {
    use super::super::clock::Timing;
    use super::*;

    /// Returns a section of one subject: names, standings, errors, and times over a clock that is a
    /// third slower in every other round.
    fn section(rows: &[(&str, Standing, f64, f64)]) -> Section {
        let row = |&(name, standing, error, time): &(&str, Standing, f64, f64)| {
            let rounds: Vec<f64> = (0..40).map(|k| time * if k % 2 == 0 { 1.0 } else { 1.5 }).collect();
            let mut row = Row::not_run("subject".into(), name.into(), 1);
            (row.is_run, row.errors, row.standing) = (true, vec![error], standing);
            row.timed(Some(Timing::of(&rounds, 1)), 1.0)
        };
        let experiment = Experiment { plotted: 0, ..super::super::lines::LINES };
        let rows = rows.iter().map(row).collect();
        Section { experiment, rows, check: Check { difference: 0.0, at_most: 0.0 } }
    }

    #[test]
    fn verdicts_and_fronts_rest_on_rounds_and_not_on_ties() {
        use Standing::{Comparison, Default, Mode};
        let section = section(&[
            ("default", Default, 2.0, 1.0),
            ("as good and as fast, but for noise", Mode, 2.0, 0.97),
            ("as good and faster", Mode, 2.0, 0.8),
            ("nearer and hardly slower", Mode, 1.0, 1.05),
            ("nearer and slower", Mode, 0.5, 1.4),
            ("farther and hardly faster", Mode, 3.0, 0.75),
            ("farther and faster", Mode, 4.0, 0.5),
            ("no mode", Comparison, 0.0, 0.1),
        ]);
        let better = section.better_than_default().unwrap();
        let names: Vec<&str> = better.iter().map(|(_, name)| *name).collect();
        assert_eq!(names, ["as good and faster", "nearer and hardly slower"]);
        let on_front = section.rows.iter().filter(|row| section.is_on_front(&section.rows, row));
        let names: Vec<&str> = on_front.map(|row| row.alternative.as_str()).collect();
        let front =
            ["as good and faster", "nearer and hardly slower", "nearer and slower", "farther and faster"];
        assert_eq!(names, front);
    }
}
