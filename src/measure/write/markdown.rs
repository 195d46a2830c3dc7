//! The report as Markdown tables.

use super::{number, time};
use crate::measure::{HardRow, Report, Section};
use std::fmt::Write;

/// The whole report. `machine` says where and when it was made.
pub fn markdown(report: &Report, machine: &str) -> String {
    let mut out = String::from("# Speed against error\n\n");
    let _ = writeln!(out, "{machine}\n");
    out.push_str(
        "Errors are against a truth in f64 or wider and the same on every machine; times are of this one. **Bold**: the \
         default. `*`: on the Pareto front, nothing else is both faster and nearer to the truth. A row outside its bound \
         shows no time.\n",
    );
    for section in &report.sections {
        table(&mut out, section);
    }
    out
}

fn table(out: &mut String, section: &Section) {
    let e = &section.experiment;
    let _ = writeln!(out, "\n## {}\n\n{}\n", e.title, e.about);
    let heads: String = e.columns.iter().map(|c| format!(" {c} |")).collect();
    let _ = writeln!(out, "| subject | alternative |{heads} bound | time a {} | |", e.unit);
    let _ = writeln!(out, "|---|---|{} ---:|---:|---|", "---:|".repeat(e.columns.len()));
    for (subject, rows) in section.subjects() {
        for row in rows {
            let name =
                if row.is_default { format!("**{}**", row.alternative) } else { row.alternative.clone() };
            let errors: String = row.errors.iter().map(|v| format!(" {} |", number(*v))).collect();
            let bounds: Vec<String> = row
                .bounds
                .iter()
                .filter(|b| b.at_most.is_finite())
                .map(|b| format!("{} ≤ {}", e.columns[b.column], number(b.at_most)))
                .collect();
            let spent = match row.nanoseconds_per_unit() {
                Some(ns) => time(ns),
                None if !row.is_within_bounds() => "outside its bound".into(),
                None => "-".into(),
            };
            let front = if section.is_on_front(rows, row) { "*" } else { "" };
            let _ =
                writeln!(out, "| {subject} | {name} |{errors} {} | {spent} | {front} |", bounds.join("; "));
        }
    }
}

/// The hard cases as a table.
pub fn hard_markdown(rows: &[HardRow]) -> String {
    let failed = rows.iter().filter(|r| !r.passed).count();
    let mut out = format!("# Hard cases\n\n{} cases, {failed} failed.\n\n", rows.len());
    out.push_str("| case | what is promised | what was measured | |\n|---|---|---|---|\n");
    for r in rows {
        let verdict = if r.passed { "pass" } else { "**FAIL**" };
        let _ = writeln!(out, "| {} | {} | {} | {verdict} |", r.case, r.promise, r.measured);
    }
    out
}
