//! Decisions as Markdown, as a part of the HTML page, as JSON, and as pictures.

use super::plot::{escape, speed_against_error};
use super::png::{png_base64, png_bytes};
use super::{bounds, errors, number, prose, time};
use crate::decide::Decision;
use crate::{Report, Row};
use serde_json::{Value, json};
use std::fmt::Write;

/// Largest width in pixels of a picture in the page.
const SHOWN_WIDTH: u32 = 640;

/// Returns the heading: the name and the size.
fn heading(decision: &Decision) -> String {
    let [width, height] = decision.size;
    format!("{}, {width}x{height}", decision.name)
}

/// A cell of a table: a value, and its spread if it has one.
struct Cell(String, Option<String>);

impl Cell {
    fn text(&self) -> String {
        self.1.as_ref().map_or(self.0.clone(), |spread| format!("{} ({spread})", self.0))
    }

    fn html(&self) -> String {
        let spread = self.1.as_ref().map_or(String::new(), |spread| format!("<br><small>{spread}</small>"));
        format!("<td>{}{spread}</td>", escape(&self.0))
    }
}

/// Formats an error in steps of 1/255, with two digits after the point where it is no whole number.
fn steps(x: f64) -> String {
    match x {
        x if x.fract() == 0.0 => number(x),
        x if x >= 0.01 => format!("{x:.2}"),
        x => format!("{x:.0e}"),
    }
}

/// Returns the cells of a row after its name: time, times as fast, errors.
fn cells(decision: &Decision, row: &Row) -> Vec<Cell> {
    let spent = match row.nanosecond_quartiles() {
        Some([low, median, high]) => Cell(time(median), Some(format!("{} to {}", time(low), time(high)))),
        None => Cell(super::spent(row), None),
    };
    let speed = match decision.rows()[0].time_over(row) {
        Some(_) if row.is_default() => Cell("1".into(), None),
        Some([low, median, high]) => Cell(format!("{median:.2}"), Some(format!("{low:.2} to {high:.2}"))),
        None => Cell("-".into(), None),
    };
    let mut cells = vec![spent, speed];
    cells.extend(row.errors.iter().map(|e| Cell(steps(*e), None)));
    cells
}

/// Returns the rows to show.
fn shown(decision: &Decision) -> impl Iterator<Item = &Row> {
    decision.rows().iter().filter(|row| !decision.is_idle(row))
}

/// Returns the remarks below the table.
fn remarks(decision: &Decision) -> Vec<String> {
    let mut lines: Vec<String> = decision.idle().into_iter().collect();
    for row in decision.rows().iter().filter(|row| !row.is_within_bounds()) {
        let promised = bounds(&decision.section.experiment, row).join("; ");
        lines.push(format!("{} breaks its promise: {promised}.", row.alternative));
    }
    lines.extend(decision.notes.iter().cloned());
    lines
}

const HEADS: [&str; 6] =
    ["setting", "time a frame", "times as fast", "largest error", "99.9 %", "coverage off"];

/// Writes the decision as Markdown.
pub(super) fn markdown(out: &mut String, decision: &Decision) {
    let _ = writeln!(out, "\n## {}\n", heading(decision));
    if let Some(sentence) = decision.recommendation() {
        let _ = writeln!(out, "{sentence}\n");
    }
    let _ = writeln!(out, "| {} | |\n|---|{}---|", HEADS.join(" | "), "---:|".repeat(HEADS.len() - 1));
    for row in shown(decision) {
        let name =
            if row.is_default() { format!("**{}**", row.alternative) } else { row.alternative.clone() };
        let front = if decision.is_on_front(row) { "*" } else { "" };
        let _ = writeln!(
            out,
            "| {name} | {} | {front} |",
            cells(decision, row).iter().map(Cell::text).collect::<Vec<_>>().join(" | ")
        );
    }
    for same in &decision.same_work {
        let _ = writeln!(out, "| {} | the same work as {} | | | | | |", same.setting, same.of);
    }
    let _ = writeln!(out, "\n- {}", remarks(decision).join("\n- "));
}

/// Writes the decision as a section of the page.
pub(super) fn html(out: &mut String, decision: &Decision) {
    let _ = writeln!(out, "<section class=\"decision\">\n<h2>{}</h2>", escape(&heading(decision)));
    if let Some(sentence) = decision.recommendation() {
        let _ = writeln!(out, "<p class=\"verdict\">{}</p>", prose(&sentence));
    }
    let heads: String = HEADS.iter().map(|head| format!("<th>{head}</th>")).collect();
    let _ = writeln!(out, "<div class=\"wide\"><table>\n<thead><tr>{heads}</tr></thead>\n<tbody>");
    for row in shown(decision) {
        let class = match (row.is_within_bounds(), row.is_default()) {
            (false, _) => " class=\"broken\"",
            (true, true) => " class=\"default\"",
            (true, false) => "",
        };
        let cells: String = cells(decision, row).iter().map(Cell::html).collect();
        let front = if decision.is_on_front(row) { " *" } else { "" };
        let _ = writeln!(out, "<tr{class}><td>{}{front}</td>{cells}</tr>", escape(&row.alternative));
    }
    for same in &decision.same_work {
        let of = escape(&same.of);
        let setting = escape(&same.setting);
        let _ = writeln!(
            out,
            "<tr class=\"same\"><td>{setting}</td><td colspan=\"5\">the same work as {of}</td></tr>"
        );
    }
    out.push_str("</tbody>\n</table></div>\n");
    let rows: Vec<Row> = shown(decision).cloned().collect();
    if let Some(plot) = speed_against_error(&decision.section, &decision.name, &rows) {
        let _ = writeln!(out, "<div class=\"plots\"><figure>{}</figure></div>", plot.with_list());
    }
    let remarks: String = remarks(decision).iter().map(|line| format!("<li>{}</li>", prose(line))).collect();
    let _ = writeln!(out, "<ul>{remarks}</ul>");
    pictures(out, decision);
    out.push_str("</section>\n");
}

/// Writes each row's picture beside its difference from the truth.
fn pictures(out: &mut String, decision: &Decision) {
    out.push_str("<p>Each picture, and beside it its difference from the truth, 16 times as large:</p>\n<div class=\"pairs\">\n");
    for row in shown(decision) {
        let Some(p) = &row.picture else { continue };
        let _ = writeln!(out, "<figure><figcaption>{}</figcaption>", escape(&row.alternative));
        for (bytes, what) in [(&p.found, "drawn"), (&p.difference(), "difference")] {
            let (width, bytes) = reduced(p.width, bytes);
            let png = png_base64(width, &bytes);
            let alt = format!("{}, {what}", row.alternative);
            let _ = write!(out, "<img alt=\"{}\" src=\"data:image/png;base64,{png}\"/>", escape(&alt));
        }
        out.push_str("</figure>\n");
    }
    out.push_str("</div>\n");
}

/// Reduces a picture to [`SHOWN_WIDTH`] at most: each pixel has the largest of each channel, so that
/// no difference vanishes.
fn reduced(width: u32, rgba: &[u8]) -> (u32, Vec<u8>) {
    let factor = width.div_ceil(SHOWN_WIDTH) as usize;
    if factor < 2 {
        return (width, rgba.to_vec());
    }
    let (width, height) = (width as usize, rgba.len() / 4 / width as usize);
    let (w, h) = (width.div_ceil(factor), height.div_ceil(factor));
    let mut out = vec![0; 4 * w * h];
    for (i, pixel) in rgba.chunks_exact(4).enumerate() {
        let at = 4 * (i / width / factor * w + i % width / factor);
        out[at..at + 4].iter_mut().zip(pixel).for_each(|(a, b)| *a = (*b).max(*a));
    }
    (w as u32, out)
}

/// Returns the pictures of all rows as PNG files, with their names: `teapot-exact.png` and
/// `teapot-exact-difference.png`.
pub fn decision_pictures(report: &Report) -> Vec<(String, Vec<u8>)> {
    let mut files = Vec::new();
    for (k, decision) in report.decisions.iter().enumerate() {
        let number = if report.decisions.len() > 1 { format!("{}-", k + 1) } else { String::new() };
        let stem = format!("{number}{}", file_name(&decision.name));
        for row in shown(decision) {
            let Some(p) = &row.picture else { continue };
            let name = format!("{stem}-{}", plain_name(&row.alternative));
            files.push((format!("{name}.png"), png_bytes(p.width, &p.found)));
            files.push((format!("{name}-difference.png"), png_bytes(p.width, &p.difference())));
        }
    }
    files
}

/// Returns a file's name without its ending, and without what file names cannot have.
fn file_name(name: &str) -> String {
    plain_name(name.rsplit_once('.').map_or(name, |(stem, _)| if stem.is_empty() { name } else { stem }))
}

/// Returns a text with `-` in place of what file names cannot have; points of numbers stay.
fn plain_name(name: &str) -> String {
    name.chars().map(|c| if c.is_alphanumeric() || c == '.' { c } else { '-' }).collect()
}

/// Returns the decision as JSON; the keys of what comes from a clock contain `time`.
pub(super) fn value(decision: &Decision) -> Value {
    let columns = decision.section.experiment.columns;
    let row = |(i, r): (usize, &Row)| {
        json!({
            "setting": r.alternative,
            "command": decision.commands[i],
            "errors": errors(columns, r),
            "within_bounds": r.is_within_bounds(),
            "time_ns": r.nanoseconds_per_unit(),
            "time_ns_quartiles": r.nanosecond_quartiles(),
            "time_speed_of_exact": decision.rows()[0].time_over(r),
            "time_on_front": decision.is_on_front(r),
            "time_left_out": decision.is_idle(r),
            "time_samples": r.timing.as_ref().map(|t| t.samples()),
        })
    };
    let same = |s: &crate::decide::SameWork| json!({ "setting": s.setting, "of": s.of });
    json!({
        "name": decision.name,
        "size": decision.size,
        "limit": decision.limit,
        "rows": decision.rows().iter().enumerate().map(row).collect::<Vec<_>>(),
        "same_work": decision.same_work.iter().map(same).collect::<Vec<_>>(),
        "notes": decision.notes,
        "truth_difference": number(decision.section.check.difference),
        "time_recommended": decision.recommended().map(|i| decision.rows()[i].alternative.clone()),
        "time_recommendation": decision.recommendation(),
    })
}
