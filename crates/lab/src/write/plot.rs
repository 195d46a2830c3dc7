//! Plots as SVG: speed against error, both axes logarithmic.

use super::{number, time};
use crate::{Report, Row, Scaling, Section, Standing};
use std::fmt::Write;

const WIDTH: f64 = 460.0;
const HEIGHT: f64 = 280.0;
const LEFT: f64 = 66.0;
const RIGHT: f64 = 14.0;
const TOP: f64 = 14.0;
const BOTTOM: f64 = 44.0;

/// Logarithmic axis over whole decades, or from 1, 2 or 5 to 1, 2 or 5 times a power of ten if its
/// values lie near each other; values of 0 are at its start.
struct Axis {
    first: f64,
    last: f64,
    from_px: f64,
    to_px: f64,
}

impl Axis {
    fn over(values: impl Iterator<Item = f64> + Clone, from_px: f64, to_px: f64) -> Axis {
        let positive = values.clone().filter(|v| *v > 0.0 && v.is_finite());
        let low = positive.clone().fold(f64::INFINITY, f64::min);
        let high = positive.fold(0.0, f64::max);
        let (low, high) = if low.is_finite() { (low, high) } else { (1.0, 1.0) };
        // One decade below, for zeros.
        let room = if values.clone().any(|v| v <= 0.0) { 1.0 } else { 0.0 };
        let first = libm::floor(libm::log10(low) - 0.05) - room;
        let last = libm::ceil(libm::log10(high) + 0.05).max(first + 1.0);
        if room == 0.0 && high <= NEAR * low {
            let [first, last] = [round_below(low / 1.1), 1.0 / round_below(1.0 / (1.1 * high))];
            return Axis { first: libm::log10(first), last: libm::log10(last), from_px, to_px };
        }
        Axis { first, last, from_px, to_px }
    }

    fn place(&self, value: f64) -> f64 {
        let log = if value > 0.0 { libm::log10(value).clamp(self.first, self.last) } else { self.first };
        self.from_px + (self.to_px - self.from_px) * (log - self.first) / (self.last - self.first)
    }

    /// Returns the values that have a line: decades, and between them 2 and 5 times where the axis is
    /// short.
    fn marks(&self) -> Vec<f64> {
        let step = ((self.last - self.first) / 6.0).ceil().max(1.0) as usize;
        let [first, last] = [libm::floor(self.first) as i32, libm::ceil(self.last) as i32];
        let of_decade: &[f64] = if self.last - self.first <= 1.5 { &[1.0, 2.0, 5.0] } else { &[1.0] };
        let decades = (first..=last).step_by(step).map(|k| libm::pow(10.0, f64::from(k)));
        let all = decades.flat_map(|decade| of_decade.iter().map(move |part| part * decade));
        let is_inside = |v: &f64| (self.first - 1e-9..=self.last + 1e-9).contains(&libm::log10(*v));
        all.filter(is_inside).collect()
    }
}

/// Ratio of values up to which an axis need not have whole decades.
const NEAR: f64 = 30.0;

/// Returns the largest of 1, 2 and 5 times a power of ten that is not above a value.
fn round_below(value: f64) -> f64 {
    let decade = libm::pow(10.0, libm::floor(libm::log10(value) + 1e-9));
    let part = [5.0, 2.0].into_iter().find(|part| part * decade <= value * (1.0 + 1e-9));
    part.unwrap_or(1.0) * decade
}

/// Plot with the names of its numbered points.
pub(super) struct Plot {
    /// Text of an SVG element.
    pub svg: String,
    /// Names in order, each with whether it is the default.
    pub names: Vec<(String, bool)>,
}

impl Plot {
    /// Returns the plot with its names as a list below.
    pub fn with_list(&self) -> String {
        let item = |(name, is_default): &(String, bool)| {
            let class = if *is_default { " class=\"usual\"" } else { "" };
            format!("<li{class}>{}</li>", escape(name))
        };
        let items: String = self.names.iter().map(item).collect();
        format!("{}<ol>{items}</ol>\n", self.svg)
    }
}

/// Plots speed against error for the rows of one subject; `None` if nothing was timed.
pub(super) fn speed_against_error(section: &Section, subject: &str, rows: &[Row]) -> Option<Plot> {
    let e = &section.experiment;
    let points: Vec<(&Row, f64, f64)> = rows
        .iter()
        .filter_map(|r| Some((r, r.errors[e.plotted], r.nanoseconds_per_unit()?)))
        .filter(|p| p.1.is_finite())
        .collect();
    if points.is_empty() {
        return None;
    }
    let x = Axis::over(points.iter().map(|p| p.1), LEFT, WIDTH - RIGHT);
    let y = Axis::over(points.iter().map(|p| p.2), HEIGHT - BOTTOM, TOP);
    let mut out = format!(
        "<svg viewBox=\"0 0 {WIDTH} {HEIGHT}\" role=\"img\" aria-label=\"{}: time against error, {}\">\n",
        escape(e.title),
        escape(subject)
    );
    let start = if points.iter().any(|p| p.1 == 0.0) { "0" } else { "" };
    draw_axes(&mut out, &x, start, e.columns[e.plotted], &y, &format!("time a {}", e.unit));
    // The Pareto front, from the fastest to the most accurate.
    let mut front: Vec<(f64, f64)> = points
        .iter()
        .filter(|p| section.is_on_front(rows, p.0))
        .map(|p| (x.place(p.1), y.place(p.2)))
        .collect();
    front.sort_by(|a, b| a.0.total_cmp(&b.0));
    let path: Vec<String> = front.iter().map(|(a, b)| format!("{a:.1},{b:.1}")).collect();
    let _ = writeln!(out, "<polyline class=\"front\" points=\"{}\"/>", path.join(" "));
    let places: Vec<(f64, f64)> = points.iter().map(|p| (x.place(p.1), y.place(p.2))).collect();
    let mut labels: Vec<(f64, f64)> = Vec::new();
    let mut names = Vec::new();
    // Drawn after, and so above, the lines that lead to them.
    let mut marks = String::new();
    for (k, (row, error, ns)) in points.iter().enumerate() {
        let (px, py) = places[k];
        let (lx, ly) = free_place(places[k], &places, &labels);
        labels.push((lx, ly));
        let class = match row.standing {
            Standing::Default => "default",
            Standing::Mode => "dot",
            Standing::Comparison => "apart",
        };
        let tip =
            format!("{}: {} = {}, {}", row.alternative, e.columns[e.plotted], number(*error), time(*ns));
        if libm::hypot(lx - px, ly - py) > 1.5 * LABEL_AWAY {
            let _ = writeln!(
                out,
                "<line class=\"aside\" x1=\"{px:.1}\" y1=\"{py:.1}\" x2=\"{lx:.1}\" y2=\"{ly:.1}\"/>"
            );
        }
        let _ = writeln!(
            marks,
            "<circle class=\"{class}\" cx=\"{px:.1}\" cy=\"{py:.1}\" r=\"4.5\"><title>{}</title></circle>\
             <circle class=\"paper\" cx=\"{lx:.1}\" cy=\"{ly:.1}\" r=\"7\"/>\
             <text class=\"label\" x=\"{lx:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{}</text>",
            escape(&tip),
            ly + 4.0,
            k + 1
        );
        names.push((super::name(row), row.is_default()));
    }
    out.push_str(&marks);
    out.push_str("</svg>\n");
    Some(Plot { svg: out, names })
}

/// Distance in pixels of a number from its point.
const LABEL_AWAY: f64 = 13.0;

/// Returns the place of a point's number: near it, within the plot, on no point and no other number.
fn free_place((px, py): (f64, f64), points: &[(f64, f64)], labels: &[(f64, f64)]) -> (f64, f64) {
    // Right above first, then around, then farther away.
    let around = (0..60).map(|i| {
        let (turn, ring) = (f64::from(i % 12) * 5.0 / 12.0, f64::from(i / 12) + 1.0);
        let angle = std::f64::consts::TAU * (turn - 0.125);
        (px + ring * LABEL_AWAY * libm::cos(angle), py + ring * LABEL_AWAY * libm::sin(angle))
    });
    let is_free = |&(x, y): &(f64, f64)| {
        let is_inside =
            (LEFT + 7.0..WIDTH - 7.0).contains(&x) && (TOP - 6.0..HEIGHT - BOTTOM - 7.0).contains(&y);
        let is_clear =
            |others: &[(f64, f64)], least: f64| others.iter().all(|o| libm::hypot(o.0 - x, o.1 - y) >= least);
        is_inside && is_clear(points, 11.0) && is_clear(labels, 14.0)
    };
    around.clone().find(is_free).unwrap_or((px, py))
}

/// Draws grid, labels and titles. `start` labels the start of the x axis, where values of 0 are.
fn draw_axes(out: &mut String, x: &Axis, start: &str, x_title: &str, y: &Axis, y_title: &str) {
    for (k, v) in x.marks().into_iter().enumerate() {
        let at = x.place(v);
        let label = if k == 0 && !start.is_empty() { start.into() } else { number_of_decade(v) };
        let _ = writeln!(
            out,
            "<line class=\"grid\" x1=\"{at:.1}\" x2=\"{at:.1}\" y1=\"{TOP}\" y2=\"{:.1}\"/>",
            HEIGHT - BOTTOM
        );
        let _ = writeln!(
            out,
            "<text x=\"{at:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{label}</text>",
            HEIGHT - BOTTOM + 14.0
        );
    }
    for v in y.marks() {
        let at = y.place(v);
        let _ = writeln!(
            out,
            "<line class=\"grid\" x1=\"{LEFT}\" x2=\"{:.1}\" y1=\"{at:.1}\" y2=\"{at:.1}\"/>",
            WIDTH - RIGHT
        );
        let _ = writeln!(
            out,
            "<text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\">{}</text>",
            LEFT - 6.0,
            at + 4.0,
            time(v).replace(".0 ", " ").replace(".00 ", " ")
        );
    }
    let _ = writeln!(
        out,
        "<text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{}</text>",
        (LEFT + WIDTH - RIGHT) / 2.0,
        HEIGHT - 8.0,
        escape(x_title)
    );
    let _ = writeln!(
        out,
        "<text x=\"12\" y=\"{:.1}\" text-anchor=\"middle\" transform=\"rotate(-90 12 {:.1})\">{}</text>",
        HEIGHT / 2.0,
        HEIGHT / 2.0,
        escape(y_title)
    );
}

/// Plots time against size, with the line of the fitted power; empty if nothing was timed.
pub(super) fn scaling(g: &Scaling) -> String {
    let points: Vec<(f64, f64)> =
        g.points.iter().filter_map(|p| Some((p.x, p.timing.as_ref()?.median_s() * 1e9))).collect();
    if points.is_empty() {
        return String::new();
    }
    let x = Axis::over(points.iter().map(|p| p.0), LEFT, WIDTH - RIGHT);
    let y = Axis::over(points.iter().map(|p| p.1), HEIGHT - BOTTOM, TOP);
    let mut out = format!(
        "<svg viewBox=\"0 0 {WIDTH} {HEIGHT}\" role=\"img\" aria-label=\"time against {}: {}\">\n",
        g.grows,
        escape(&g.title)
    );
    draw_axes(&mut out, &x, "", g.grows, &y, "time");
    if let Some(exponent) = g.exponent() {
        // Through the mean of the logarithms.
        let mean = |f: fn(&(f64, f64)) -> f64| {
            points.iter().map(|p| libm::log10(f(p))).sum::<f64>() / points.len() as f64
        };
        let (mx, my) = (mean(|p| p.0), mean(|p| p.1));
        let ends = [points[0].0, points[points.len() - 1].0];
        let path = ends.map(|v| {
            let fitted = libm::pow(10.0, my + exponent * (libm::log10(v) - mx));
            format!("{:.1},{:.1}", x.place(v), y.place(fitted))
        });
        let _ = writeln!(out, "<polyline class=\"front\" points=\"{}\"/>", path.join(" "));
        let _ = writeln!(
            out,
            "<text x=\"{:.1}\" y=\"{:.1}\" style=\"font-size:15px\">{}<tspan dy=\"-5\" font-size=\"11\">{exponent:.2}</tspan></text>",
            LEFT + 12.0,
            TOP + 20.0,
            escape(g.grows)
        );
    }
    for (px, py) in points {
        let _ = writeln!(
            out,
            "<circle class=\"default\" cx=\"{:.1}\" cy=\"{:.1}\" r=\"5\"><title>{}: {}</title></circle>",
            x.place(px),
            y.place(py),
            number(px),
            time(py)
        );
    }
    out + "</svg>\n"
}

fn number_of_decade(v: f64) -> String {
    if (1e-3..1e4).contains(&v) { format!("{v}") } else { format!("{v:.0e}") }
}

/// Style of plots outside an HTML page.
const CONTACT_SHEET_STYLE: &str = "
text { font: 11px system-ui, sans-serif; fill: #1c2430; } .title { font-size: 14px; font-weight: 600; } .subject { fill: #4a5564; }
.grid { stroke: #d7dce3; stroke-width: 1; } .dot { fill: #1c2430; } .default { fill: #0b62c4; stroke: #fff; stroke-width: 1.5; }
.label { font-weight: 600; } .paper { fill: #fff; fill-opacity: .8; } .usual { fill: #0b62c4; font-weight: 600; }
.front { fill: none; stroke: #c4570b; stroke-width: 1.5; stroke-dasharray: 4 3; }
.aside { stroke: #1c2430; stroke-width: 1; fill: #1c2430; }
.apart { fill: #fff; stroke: #1c2430; stroke-width: 1; }
";

/// Returns several plots as one SVG in two columns: each experiment's first subject, then the
/// growths.
pub fn contact_sheet(report: &Report, machine: &str) -> String {
    const MARGIN: f64 = 24.0;
    const HEAD: f64 = 40.0;
    const LINE: f64 = 13.0;
    let mut cells: Vec<(&str, String, Plot)> = Vec::new();
    for section in report.all_sections() {
        let plots = section.subjects().filter_map(|(subject, rows)| {
            Some((subject.to_owned(), speed_against_error(section, subject, rows)?))
        });
        // One plot per experiment, but all of them if there are at most two experiments.
        let is_decision = section.experiment.id == "decision";
        let count = if report.sections.len() > 2 && !is_decision { 1 } else { usize::MAX };
        cells.extend(plots.take(count).map(|(subject, plot)| (section.experiment.title, subject, plot)));
    }
    for g in report.scaling.iter().filter(|g| g.exponent().is_some()) {
        cells.push(("Growth", g.title.clone(), Plot { svg: scaling(g), names: Vec::new() }));
    }
    // Names stand in two columns below their plot; a row of plots is as high as its longest list.
    let lines = |plot: &Plot| plot.names.len().div_ceil(2);
    let heights: Vec<f64> = cells
        .chunks(2)
        .map(|row| HEAD + HEIGHT + LINE * (1 + row.iter().map(|c| lines(&c.2)).max().unwrap_or(0)) as f64)
        .collect();
    let width = 2.0 * WIDTH + 3.0 * MARGIN;
    let height = heights.iter().sum::<f64>() + 3.0 * MARGIN;
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" width=\"{width}\" height=\"{height}\">\n\
         <style>{CONTACT_SHEET_STYLE}</style>\n<rect width=\"{width}\" height=\"{height}\" fill=\"#fff\"/>\n\
         <text x=\"{MARGIN}\" y=\"{MARGIN}\">{}</text>\n",
        escape(machine)
    );
    for (i, (title, subject, plot)) in cells.iter().enumerate() {
        let x = MARGIN + (i % 2) as f64 * (WIDTH + MARGIN);
        let y = 2.0 * MARGIN + heights[..i / 2].iter().sum::<f64>();
        let _ = writeln!(
            out,
            "<text class=\"title\" x=\"{x}\" y=\"{}\">{}</text><text class=\"subject\" x=\"{x}\" y=\"{}\">{}</text>",
            y + 14.0,
            escape(title),
            y + 30.0,
            escape(subject)
        );
        let placed = format!("<svg x=\"{x}\" y=\"{}\" width=\"{WIDTH}\" height=\"{HEIGHT}\" ", y + HEAD);
        out.push_str(&plot.svg.replacen("<svg ", &placed, 1));
        for (k, (name, is_default)) in plot.names.iter().enumerate() {
            let (column, line) = (k / lines(plot), k % lines(plot));
            let class = if *is_default { " class=\"usual\"" } else { "" };
            let _ = writeln!(
                out,
                "<text{class} x=\"{:.1}\" y=\"{:.1}\">{}. {}</text>",
                x + 30.0 + column as f64 * WIDTH / 2.0,
                y + HEAD + HEIGHT + 10.0 + line as f64 * LINE,
                k + 1,
                escape(name)
            );
        }
    }
    out + "</svg>\n"
}

/// Escapes text for HTML.
pub fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
