//! The report as Markdown, as JSON, and as one HTML page with plots.

mod decision;
mod html;
mod json;
mod markdown;
mod plot;
mod png;

pub use decision::decision_pictures;
pub use html::html;
pub use json::{errors_json, json};
pub use markdown::{goals_markdown, hard_markdown, markdown};
pub use plot::{contact_sheet, escape};
pub(crate) use png::png_base64;

use super::{Bound, Experiment, Report, Row, Section, Standing, savings};
use serde_json::Value;

/// Formats an error for a table, with its significant digits, identical on every machine.
pub(crate) fn number(x: f64) -> String {
    if x == 0.0 {
        return "0".into();
    }
    if !x.is_finite() {
        return if x > 0.0 { "∞".into() } else { format!("{x}") };
    }
    if x.fract() == 0.0 && x.abs() < 1e9 {
        return format!("{x}");
    }
    if (1e-3..1e6).contains(&x.abs()) { format!("{x:.4}") } else { format!("{x:.3e}") }
}

/// Formats an error of a row, `-` if the row was not run.
pub(super) fn error(row: &Row, x: f64) -> String {
    if row.is_run { number(x) } else { "-".into() }
}

/// Returns the name of a row's alternative; one that is no mode of the program is marked so.
pub(super) fn name(row: &Row) -> String {
    match row.standing {
        Standing::Comparison => format!("for comparison: {}", row.alternative),
        Standing::Default | Standing::Mode => row.alternative.clone(),
    }
}

/// Returns the truth of a section, its digits, and how well its second way agrees.
pub(super) fn truth(section: &Section) -> String {
    let (truth, check) = (&section.experiment.truth, section.check);
    format!(
        "Truth: {}. Digits: {}. Second way: {}; they differ by {}, at most {} is expected.",
        truth.is,
        truth.digits,
        truth.second_way,
        number(check.difference),
        number(check.at_most)
    )
}

/// Returns what the stages left out save, scene by scene, as lines of text.
pub(super) fn saved(report: &Report) -> Vec<String> {
    let line = |s: &super::Saving| {
        let ratio = s
            .time_ratio
            .map_or(String::new(), |r| format!(", and with them the frame takes {r:.2} times as long"));
        format!("{}: {} parts left out, {} bytes less{ratio}", s.scene, s.parts_left_out, s.bytes_saved)
    };
    savings(report).iter().map(line).collect()
}

/// Returns the derivations of a section's bounds, each once.
pub(super) fn derivations(section: &Section) -> Vec<String> {
    let mut all = Vec::new();
    for bound in section.rows.iter().flat_map(|r| &r.bounds) {
        let line = format!("{}: {}", section.experiment.columns[bound.column], bound.because);
        if !all.contains(&line) {
            all.push(line);
        }
    }
    all
}

/// Returns the bounds of a row, each with the part of it that was measured, or that nothing is
/// promised.
pub(super) fn bounds(experiment: &Experiment, row: &Row) -> Vec<String> {
    let of = |b: &Bound| {
        let promise = format!("{} ≤ {}", experiment.columns[b.column], number(b.at_most));
        match b.at_most > 0.0 {
            true => format!("{promise} ({:.0} % of it)", 100.0 * row.errors[b.column] / b.at_most),
            false => promise,
        }
    };
    match row.bounds.is_empty() {
        true => vec!["no promise".into()],
        false => row.bounds.iter().map(of).collect(),
    }
}

/// Returns the time of a row with its quartiles, or the reason why there is none.
pub(super) fn spent(row: &Row) -> String {
    match (row.nanosecond_quartiles(), &row.timing) {
        (Some([low, median, high]), Some(timing)) if timing.samples() > 1 => {
            format!("{} ({} to {})", time(median), time(low), time(high))
        }
        (Some([_, median, _]), _) => time(median),
        _ if !row.is_run => "not run here".into(),
        _ if !row.is_within_bounds() => "outside its bound".into(),
        (None, Some(_)) => "not measurable here".into(),
        (None, None) => "-".into(),
    }
}

/// Formats nanoseconds with a suitable unit.
pub(super) fn time(ns: f64) -> String {
    match ns {
        ns if ns < 1e3 => format!("{ns:.1} ns"),
        ns if ns < 1e6 => format!("{:.2} µs", ns / 1e3),
        ns => format!("{:.2} ms", ns / 1e6),
    }
}

/// Formats bytes in MiB, or `-` if they are not available.
pub(super) fn mebibytes(bytes: Option<u64>) -> String {
    bytes.map_or("-".into(), |b| format!("{:.1} MiB", b as f64 / 1048576.0))
}

/// Escapes prose for HTML, with the code between backticks as such.
fn prose(text: &str) -> String {
    let parts = text.split('`').map(escape).enumerate();
    parts.map(|(i, part)| if i % 2 == 1 { format!("<code>{part}</code>") } else { part }).collect()
}

/// Converts a number; infinite ones, which JSON lacks, become text.
fn value(x: f64) -> Value {
    if x.is_finite() { Value::from(x) } else { Value::from(x.to_string()) }
}

/// Returns the errors of a row by their columns; null if it was not run.
fn errors(columns: &[&str], row: &Row) -> Value {
    if !row.is_run {
        return Value::Null;
    }
    let pairs = columns.iter().zip(&row.errors).map(|(c, e)| ((*c).to_owned(), value(*e)));
    Value::Object(pairs.collect())
}

#[cfg(test)]
mod tests {
    use super::prose;

    #[test]
    fn backticks_are_code() {
        assert_eq!(prose("as `a < b` & so"), "as <code>a &lt; b</code> &amp; so");
    }
}
