//! The recommended setting, and the rows that help to decide.

use super::super::experiment::Row;
use super::super::report::Section;
use super::{COVERAGE, Decision, LARGEST, PERCENTILE, Question, SameWork, Setting};

impl Decision {
    /// Creates a decision.
    pub(super) fn new(
        question: &Question<'_>,
        section: Section,
        settings: Vec<Setting>,
        same_work: Vec<SameWork>,
        notes: Vec<String>,
    ) -> Decision {
        let commands = settings.iter().map(question.command).collect();
        let (name, size, limit) = (question.name.clone(), question.size, question.limit);
        Decision { section, name, size, settings, commands, same_work, notes, limit }
    }

    /// Returns the rows.
    pub fn rows(&self) -> &[Row] {
        &self.section.rows
    }

    /// Returns whether a row is on the Pareto front of time against error.
    pub fn is_on_front(&self, row: &Row) -> bool {
        self.section.is_on_front(self.rows(), row)
    }

    /// Returns whether a row decides nothing: it has the exact one's errors and is not plainly faster.
    pub fn is_idle(&self, row: &Row) -> bool {
        let exact = &self.rows()[0];
        !row.is_default() && row.errors == exact.errors && row.is_plainly_faster(exact) == Some(false)
    }

    /// Returns the names of the rows that decide nothing, in a sentence; `None` if all do.
    pub fn idle(&self) -> Option<String> {
        let names: Vec<&str> =
            self.rows().iter().filter(|row| self.is_idle(row)).map(|row| row.alternative.as_str()).collect();
        let verb = if names.len() == 1 { "has" } else { "have" };
        (!names.is_empty()).then(|| {
            format!("Left out: {} {verb} the errors of exact and no plainly shorter time.", names.join(", "))
        })
    }

    /// Returns the index of the recommended row: of those within the limit that miss no pixel, the
    /// fastest one that is plainly faster than the exact one, or else that. `None` if nothing was
    /// timed. A promised error goes before a measured one that is no more than a tenth faster.
    pub fn recommended(&self) -> Option<usize> {
        let rows = self.rows();
        let exact = rows.first().filter(|row| row.nanoseconds_per_unit().is_some())?;
        let mut best = 0;
        for (i, row) in rows.iter().enumerate().skip(1) {
            let is_within =
                row.errors[PERCENTILE] <= self.limit && row.errors[COVERAGE] <= exact.errors[COVERAGE];
            if !is_within || row.is_plainly_faster(exact) != Some(true) {
                continue;
            }
            let is_promised = self.settings[i].is_promised();
            let is_faster = row.is_plainly_faster(&rows[best]) == Some(true);
            let is_surer = is_promised
                && !self.settings[best].is_promised()
                && rows[best].is_plainly_faster(row) == Some(false);
            if best == 0 || is_faster || is_surer {
                best = i;
            }
        }
        Some(best)
    }

    /// Returns the recommendation in one sentence, with its command line if it has one.
    pub fn recommendation(&self) -> Option<String> {
        let i = self.recommended()?;
        let (row, exact) = (&self.rows()[i], &self.rows()[0]);
        let command = self.commands[i].as_ref().map_or(String::new(), |command| format!(": `{command}`"));
        if i == 0 {
            return Some(format!(
                "Draw it exactly: no other setting is plainly faster and within {} steps of 255{command}",
                self.limit
            ));
        }
        let [low, median, high] = exact.time_over(row)?;
        let sure = match self.settings[i].is_promised() {
            true => "which is promised for every camera",
            false => "measured for this picture alone",
        };
        let [usual, largest] =
            [PERCENTILE, LARGEST].map(|column| super::super::write::number(row.errors[column]));
        Some(format!(
            "Draw it with {}: {median:.2} times as fast as exact ({low:.2} to {high:.2}); it is off by at most {usual} steps of \
             255 in 999 of 1000 pixels and by {largest} in all, {sure}{command}",
            row.alternative
        ))
    }
}
