//! Report as Markdown tables.

use super::{bounds, derivations, error, mebibytes, name, number, saved, spent, time, truth};
use crate::{Goal, HardRow, Report, Section};
use std::fmt::Write;

/// Returns the whole report. `machine` describes where and when it was made.
pub fn markdown(report: &Report, machine: &str) -> String {
    let mut out = String::from("# Speed against error\n\n");
    let _ = writeln!(out, "{machine}\n");
    out.push_str(
        "Errors are against the truth that each table names, and the same on every machine; times are of this one. **Bold**: \
         the default, drawn as programs get it. Rows `for comparison` are no mode of the program, or other numbers of threads. \
         `*`: on the Pareto front, plainly faster than every mode of less error, while no mode of equal error is plainly faster. \
         Times are medians, with the first and third quartile of their samples in brackets. The alternatives of a subject are \
         timed in turns and compared round by round; plainly faster means at least 10 % in the median round, and faster at all in \
         three rounds of four. A row outside its bound shows no time.\n",
    );
    if let Some(unrest) = report.unrest() {
        let _ = writeln!(out, "\n{unrest}");
    }
    for decision in &report.decisions {
        super::decision::markdown(&mut out, decision);
    }
    for section in &report.sections {
        table(&mut out, section);
        let saved = saved(report);
        if section.experiment.id == "stages" && !saved.is_empty() {
            let _ = writeln!(out, "\nSaved by what is left out:\n\n- {}", saved.join("\n- "));
        }
    }
    scaling_tables(&mut out, report);
    out
}

/// Returns the goals and their results as a table.
pub fn goals_markdown(goals: &[Goal]) -> String {
    let mut out = String::from("\n## Goals\n\n| of | asked | measured | |\n|---|---|---|---|\n");
    for t in goals {
        let verdict = if t.is_met { "met" } else { "**missed**" };
        let _ = writeln!(out, "| {} | {} | {} | {verdict} |", t.what, t.asked, t.measured);
    }
    out
}

fn scaling_tables(out: &mut String, report: &Report) {
    if report.scaling.is_empty() {
        return;
    }
    out.push_str(
        "\n## Growth\n\nThe exponent is that of the power of the first column that fits the times best. Memory is the largest \
         resident set of the whole process meanwhile, the scene and the report itself included.\n",
    );
    for g in &report.scaling {
        let exponent = g.exponent().map_or("-".into(), |e| format!("{e:.2}"));
        let promise = g.at_most.map_or(String::new(), |m| format!(", at most {m} is promised"));
        let _ = writeln!(out, "\n### {}\n\n{}^{exponent}{promise}.\n", g.title, g.grows);
        let _ = writeln!(out, "| {} | time | peak memory |\n|---:|---:|---:|", g.grows);
        for p in &g.points {
            let spent = p.timing.as_ref().map_or("-".into(), |t| time(t.median_s() * 1e9));
            let _ = writeln!(out, "| {} | {spent} | {} |", number(p.x), mebibytes(p.peak_bytes));
        }
    }
}

fn table(out: &mut String, section: &Section) {
    let e = &section.experiment;
    let _ = writeln!(out, "\n## {}\n\n{}\n\n{}\n", e.title, e.about, truth(section));
    let heads: String = e.columns.iter().map(|c| format!(" {c} |")).collect();
    let _ = writeln!(out, "| subject | alternative |{heads} bound | time a {} | |", e.unit);
    let _ = writeln!(out, "|---|---|{} ---:|---:|---|", "---:|".repeat(e.columns.len()));
    for (subject, rows) in section.subjects() {
        for row in rows {
            let name = if row.is_default() { format!("**{}**", name(row)) } else { name(row) };
            let errors: String = row.errors.iter().map(|v| format!(" {} |", error(row, *v))).collect();
            let bounds = bounds(e, row).join("; ");
            let spent = spent(row);
            let front = if section.is_on_front(rows, row) { "*" } else { "" };
            let _ = writeln!(out, "| {subject} | {name} |{errors} {bounds} | {spent} | {front} |");
        }
    }
    let derivations = derivations(section);
    if !derivations.is_empty() {
        let _ = writeln!(out, "\nBounds:\n\n- {}", derivations.join("\n- "));
    }
    if section.rows.iter().any(|r| r.timing.is_some()) {
        let _ = writeln!(out, "\n{}", section.verdict());
    }
}

/// Returns the hard cases as a table.
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
