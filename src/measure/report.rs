//! Report of all experiments.

use super::experiment::{Check, Effort, Experiment, Row, Standing};
use super::scaling::Scaling;

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
        super::pictures::PICTURES,
        super::fibre_fan::FAN,
        super::eye::EYE,
        super::threads::THREADS,
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

    /// Returns (subject, alternative) of the modes that are clearly better than the default:
    /// at least a tenth faster with no more error, the quartiles of the times apart, or with at most
    /// half the error in no more time, by the medians and by the third quartiles. Returns `None` if
    /// nothing was timed or there is no default.
    pub fn better_than_default(&self) -> Option<Vec<(&str, &str)>> {
        let column = self.experiment.plotted;
        let mut better = Vec::new();
        let mut has_default = false;
        for (subject, rows) in self.subjects() {
            let Some(default) = rows.iter().find(|r| r.is_default()) else { continue };
            let Some([low, time, high]) = default.nanosecond_quartiles() else { continue };
            has_default = true;
            let error = default.errors[column];
            for row in rows.iter().filter(|r| r.standing == Standing::Mode) {
                let Some([_, t, most]) = row.nanosecond_quartiles() else { continue };
                let is_faster = t < 0.9 * time && most < low && row.errors[column] <= error;
                let is_no_slower = t <= time && most <= high;
                let is_nearer = is_no_slower && row.errors[column] <= 0.5 * error && error > 0.0;
                if is_faster || is_nearer {
                    better.push((subject, row.alternative.as_str()));
                }
            }
        }
        has_default.then_some(better)
    }

    /// Returns the result of [`Section::better_than_default`] as a sentence.
    pub fn verdict(&self) -> String {
        match self.better_than_default() {
            None => "Nothing here is a default that could be bettered.".into(),
            Some(better) if better.is_empty() => {
                "Nothing else is a tenth faster than the default with no more error, or has half its error in no more \
                 time, on any subject, where the quartiles of the times are apart."
                    .into()
            }
            Some(better) => {
                let named: Vec<String> = better.iter().map(|(subject, name)| format!("{name} ({subject})")).collect();
                format!(
                    "Plainly better than the default, a tenth faster with no more error or half the error in no more time: {}.",
                    named.join("; ")
                )
            }
        }
    }

    /// Returns whether `row` is on the Pareto front of `rows`: a mode of the program, and no other
    /// mode is both faster and more accurate.
    pub fn is_on_front(&self, rows: &[Row], row: &Row) -> bool {
        let column = self.experiment.plotted;
        let is_mode = |r: &Row| r.standing != Standing::Comparison;
        let value = |r: &Row| Some((r.nanoseconds_per_unit().filter(|_| is_mode(r))?, r.errors[column]));
        let Some((time, error)) = value(row) else { return false };
        !rows.iter().filter_map(value).any(|(t, e)| t <= time && e <= error && (t < time || e < error))
    }
}

/// Results of a run.
#[derive(Clone, Debug)]
pub struct Report {
    /// Effort of the run.
    pub effort: Effort,
    /// One section per experiment.
    pub sections: Vec<Section>,
    /// Growth measurements.
    pub scaling: Vec<Scaling>,
}

impl Report {
    /// Returns a warning if the machine was not calm: if of more than a tenth of the timed rows the
    /// quartiles are further apart than a quarter of the median.
    pub fn unrest(&self) -> Option<String> {
        let timings = || self.sections.iter().flat_map(|s| &s.rows).filter_map(|row| row.timing);
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
        for s in &self.sections {
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
    Report { effort, sections, scaling }
}
