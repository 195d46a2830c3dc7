//! The report as Markdown, as JSON, and as one HTML page with plots.

mod html;
mod json;
mod markdown;
mod plot;

pub use html::html;
pub use json::{errors_json, json};
pub use markdown::{goals_markdown, hard_markdown, markdown};
pub use plot::contact_sheet;

use super::{Bound, Experiment, Row};

/// Formats an error for a table, with its significant digits, identical on every machine.
pub(super) fn number(x: f64) -> String {
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
    match (row.nanosecond_quartiles(), row.timing) {
        (Some([low, median, high]), _) => format!("{} ({} to {})", time(median), time(low), time(high)),
        _ if !row.is_run => "not run: this machine lacks it".into(),
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
