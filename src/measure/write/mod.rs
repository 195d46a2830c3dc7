//! The report as Markdown, as JSON, and as one HTML page with plots.

mod html;
mod json;
mod markdown;
mod plot;

pub use html::html;
pub use json::{errors_json, json};
pub use markdown::{goals_markdown, hard_markdown, markdown};
pub use plot::contact_sheet;

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
