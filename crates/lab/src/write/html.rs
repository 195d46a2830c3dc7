//! Report as one HTML page: no script, no external resources, plots as inline SVG.

use super::plot::{escape, scaling, speed_against_error};
use super::png::png_base64;
use super::{bounds, derivations, error, mebibytes, name, number, prose, saved, spent, time, truth};
use crate::{Report, Section};
use std::fmt::Write;

const STYLE: &str = "
:root { color-scheme: light dark; --ink: #1c2430; --paper: #ffffff; --faint: #d7dce3; --mark: #0b62c4; --front: #c4570b; }
@media (prefers-color-scheme: dark) { :root { --ink: #e4e8ee; --paper: #14181e; --faint: #39424e; --mark: #6db3ff; --front: #ffa45c; } }
body { font: 15px/1.5 system-ui, sans-serif; color: var(--ink); background: var(--paper); max-width: 68rem; margin: 2rem auto; padding: 0 1rem; }
h1, h2 { line-height: 1.2; } h2 { margin-top: 3rem; border-top: 1px solid var(--faint); padding-top: 1rem; }
table { border-collapse: collapse; width: 100%; font-variant-numeric: tabular-nums; font-size: 13px; }
th, td { padding: .2rem .6rem; text-align: right; border-bottom: 1px solid var(--faint); vertical-align: top; }
th:first-child, td:first-child { text-align: left; }
tr.subject td { text-align: left; font-weight: 600; padding-top: .8rem; }
tr.default td:first-child { font-weight: 600; color: var(--mark); }
tr.broken td { color: #c00; }
.plots { display: flex; flex-wrap: wrap; gap: 1rem; margin: 1rem 0; } figure { margin: 0; flex: 1 1 24rem; max-width: 32rem; }
figcaption { font-weight: 600; font-size: 13px; }
figure ol { columns: 2; margin: .2rem 0 0; padding-left: 1.6rem; font-size: 12px; } .usual { color: var(--mark); font-weight: 600; }
.label { font-weight: 600; } .paper { fill: var(--paper); fill-opacity: .8; } .pictures { display: flex; flex-wrap: wrap; gap: 1rem; } .pictures figure { flex: 0 0 auto; max-width: none; }
.wide { overflow-x: auto; } .decision td, td small { white-space: nowrap; } td small { opacity: .75; } tr.same td { opacity: .75; } tr.same td + td { text-align: left; }
.pairs { display: grid; grid-template-columns: repeat(auto-fill, minmax(min(28rem, 100%), 1fr)); gap: 1rem; } .pairs figure { max-width: 100%; } .pairs img { image-rendering: pixelated; width: calc(50% - 2px); margin-right: 2px; background: #000; }
code { overflow-wrap: anywhere; }
.pictures img { image-rendering: pixelated; width: 9rem; margin-right: 2px; background: #000; }
svg { width: 100%; height: auto; } svg text { font: 11px system-ui, sans-serif; fill: var(--ink); }
.apart { fill: var(--paper); stroke: var(--ink); stroke-width: 1; }
.grid { stroke: var(--faint); stroke-width: 1; } .dot { fill: var(--ink); } .default { fill: var(--mark); stroke: var(--paper); stroke-width: 1.5; }
.front { fill: none; stroke: var(--front); stroke-width: 1.5; stroke-dasharray: 4 3; }
.aside { stroke: var(--ink); stroke-width: 1; fill: var(--ink); }
.verdict { border-left: 3px solid var(--front); padding-left: .8rem; }
@media (max-width: 40rem) { th, td { padding: .2rem .25rem; font-size: 12px; } .decision td:first-child, td small { white-space: normal; } td small { display: block; line-height: 1.2; } td br { display: none; } }
@media print { body { max-width: none; margin: 0; } h2 { break-after: avoid; } figure, tr { break-inside: avoid; } }
";

/// Returns the whole page. `machine` describes where and when it was made.
pub fn html(report: &Report, machine: &str) -> String {
    let mut out = format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <title>fbptr: speed against error</title>\n<style>{STYLE}</style>\n</head>\n<body>\n<h1>Speed against error</h1>\n"
    );
    let _ = writeln!(out, "<p>{}</p>", prose(machine));
    out.push_str(
        "<p>Each numbered point is one setting, or one way of doing a stage. To the left: nearer to the truth; down: faster. The blue one is what \
         the program does unless told otherwise; the dashed line is the Pareto front, modes that are plainly faster than every \
         mode of less error. Errors are the same to the digit on every machine; times are of this one: medians, with the \
         first and third quartile in brackets. The alternatives of a subject are timed in turns and compared round by round; \
         plainly faster means at least 10 % in the median round, and faster at all in three rounds of four.</p>\n",
    );
    if let Some(unrest) = report.unrest() {
        let _ = writeln!(out, "<p>{}</p>", escape(&unrest));
    }
    for decision in &report.decisions {
        super::decision::html(&mut out, decision);
    }
    for section in &report.sections {
        section_html(&mut out, section);
        if section.experiment.id == "stages" {
            let saved: String =
                saved(report).iter().map(|line| format!("<li>{}</li>", escape(line))).collect();
            let _ = writeln!(out, "<p>Saved by what is left out:</p>\n<ul>{saved}</ul>");
        }
    }
    scaling_html(&mut out, report);
    out.push_str("</body>\n</html>\n");
    out
}

/// Writes times against sizes, with the fitted exponents.
fn scaling_html(out: &mut String, report: &Report) {
    if report.scaling.is_empty() {
        return;
    }
    out.push_str(
        "<section id=\"growth\">\n<h2>Growth</h2>\n<p>Time against size, both logarithmic; the line is the power that fits best. \
         Memory is the largest resident set of the whole process meanwhile.</p>\n<div class=\"plots\">\n",
    );
    for g in &report.scaling {
        let _ = writeln!(out, "<figure><figcaption>{}</figcaption>\n{}", escape(&g.title), scaling(g));
        let exponent = g.exponent().map_or("-".into(), |e| format!("{e:.2}"));
        let promise = g.at_most.map_or(String::new(), |m| format!(" (at most {m} is promised)"));
        let _ = writeln!(
            out,
            "<table><thead><tr><th>{} <sup>{exponent}</sup>{promise}</th><th>time</th><th>peak memory</th></tr></thead><tbody>",
            escape(g.grows)
        );
        for p in &g.points {
            let spent = p.timing.as_ref().map_or("-".into(), |t| time(t.median_s() * 1e9));
            let _ = writeln!(
                out,
                "<tr><td>{}</td><td>{spent}</td><td>{}</td></tr>",
                number(p.x),
                mebibytes(p.peak_bytes)
            );
        }
        out.push_str("</tbody></table></figure>\n");
    }
    out.push_str("</div>\n</section>\n");
}

fn section_html(out: &mut String, section: &Section) {
    let e = &section.experiment;
    let _ =
        writeln!(out, "<section id=\"{}\">\n<h2>{}</h2>\n<p>{}</p>", e.id, escape(e.title), prose(e.about));
    let _ = writeln!(out, "<p>{}</p>", escape(&truth(section)));
    out.push_str("<div class=\"plots\">\n");
    for (subject, rows) in section.subjects() {
        if let Some(plot) = speed_against_error(section, subject, rows) {
            let plot = plot.with_list();
            let _ = writeln!(out, "<figure><figcaption>{}</figcaption>\n{plot}</figure>", escape(subject));
        }
    }
    out.push_str("</div>\n<div class=\"wide\"><table>\n<thead><tr><th>alternative</th>");
    for c in e.columns {
        let _ = write!(out, "<th>{}</th>", escape(c));
    }
    let _ = writeln!(out, "<th>bound</th><th>time a {}</th></tr></thead>\n<tbody>", escape(e.unit));
    for (subject, rows) in section.subjects() {
        let _ = writeln!(
            out,
            "<tr class=\"subject\"><td colspan=\"{}\">{}</td></tr>",
            e.columns.len() + 3,
            escape(subject)
        );
        for row in rows {
            let class = match (row.is_within_bounds(), row.is_default()) {
                (false, _) => " class=\"broken\"",
                (true, true) => " class=\"default\"",
                (true, false) => "",
            };
            let _ = write!(out, "<tr{class}><td>{}</td>", escape(&name(row)));
            for v in &row.errors {
                let _ = write!(out, "<td>{}</td>", error(row, *v));
            }
            let bounds: Vec<String> = bounds(e, row).iter().map(|bound| escape(bound)).collect();
            let _ = writeln!(out, "<td>{}</td><td>{}</td></tr>", bounds.join("<br>"), spent(row));
        }
    }
    out.push_str("</tbody>\n</table></div>\n");
    let derivations: String =
        derivations(section).iter().map(|line| format!("<li>{}</li>", escape(line))).collect();
    if !derivations.is_empty() {
        let _ = writeln!(out, "<p>Bounds:</p>\n<ul>{derivations}</ul>");
    }
    if section.rows.iter().any(|r| r.timing.is_some()) {
        let _ = writeln!(out, "<p class=\"verdict\">{}</p>", escape(&section.verdict()));
    }
    pictures(out, section);
    out.push_str("</section>\n");
}

/// Writes the drawn picture, the reference, and their difference times 16, for every row with
/// pictures.
fn pictures(out: &mut String, section: &Section) {
    let rows: Vec<_> = section.rows.iter().filter_map(|r| Some((r, r.picture.as_ref()?))).collect();
    if rows.is_empty() {
        return;
    }
    out.push_str("<p>Drawn, true, and the difference 16 times:</p>\n<div class=\"pictures\">\n");
    for (row, p) in rows {
        let _ = writeln!(
            out,
            "<figure><figcaption>{}, {}</figcaption>",
            escape(&row.subject),
            escape(&row.alternative)
        );
        for (bytes, what) in [(&p.found, "drawn"), (&p.truth, "true"), (&p.difference(), "difference")] {
            let png = png_base64(p.width, bytes);
            let _ = write!(out, "<img alt=\"{what}\" src=\"data:image/png;base64,{png}\"/>");
        }
        out.push_str("</figure>\n");
    }
    out.push_str("</div>\n");
}
