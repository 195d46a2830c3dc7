//! The result of a sheet as text, as JSON, and as a page for the student.

use super::judge::Graded;
use super::sheet::Sheet;
use crate::measure::difference::page_head;
use crate::measure::write::escape;
use serde_json::{Value, json};
use std::fmt::Write as _;

/// A sheet that was graded.
pub struct Report<'a> {
    pub sheet: &'a Sheet,
    pub items: Vec<Graded<'a>>,
}

impl Report<'_> {
    fn points(&self) -> f64 {
        self.items.iter().map(|graded| graded.points).sum()
    }

    fn of(&self) -> f64 {
        self.items.iter().map(|graded| graded.item.points).sum()
    }

    /// Returns whether all items have all their points.
    pub fn is_full(&self) -> bool {
        self.items.iter().all(|graded| graded.points >= graded.item.points)
    }

    /// Returns the lines of one item.
    pub fn line(graded: &Graded<'_>) -> String {
        let mut lines = graded.text.lines();
        let mut text = format!(
            "{:>5} of {:<5} {}: {}\n",
            number(graded.points),
            number(graded.item.points),
            graded.item.name,
            lines.next().unwrap_or("")
        );
        lines.for_each(|line| _ = writeln!(text, "{line}"));
        for said in said(graded) {
            let _ = writeln!(text, "         the program said: {said}");
        }
        text
    }

    /// Returns the last line.
    pub fn sum(&self) -> String {
        format!("{} of {} points\n", number(self.points()), number(self.of()))
    }

    /// Returns the result as JSON.
    pub fn json(&self) -> Value {
        let items: Vec<Value> = self
            .items
            .iter()
            .map(|graded| {
                json!({
                    "name": graded.item.name,
                    "points": graded.points,
                    "of": graded.item.points,
                    "text": graded.text.lines().next().unwrap_or(""),
                    "said": said(graded),
                    "difference": graded.difference.as_ref().map(|difference| difference.json()),
                })
            })
            .collect();
        json!({
            "title": self.sheet.title,
            "points": round(self.points()),
            "of": round(self.of()),
            "full": self.is_full(),
            "items": items,
        })
    }

    /// Returns the result as a page.
    pub fn page(&self) -> String {
        let mut out = page_head(&self.sheet.title);
        let _ = writeln!(out, "<p>{}</p>\n<ul>", escape(self.sum().trim_end()));
        for (i, graded) in self.items.iter().enumerate() {
            let _ = writeln!(
                out,
                "<li>{} of {}: <a href=\"#item{i}\">{}</a></li>",
                number(graded.points),
                number(graded.item.points),
                escape(&graded.item.name)
            );
        }
        out.push_str("</ul>\n");
        for (i, graded) in self.items.iter().enumerate() {
            let _ = writeln!(
                out,
                "<h1 id=\"item{i}\">{}: {} of {}</h1>",
                escape(&graded.item.name),
                number(graded.points),
                number(graded.item.points)
            );
            graded.item.text.iter().for_each(|line| _ = writeln!(out, "<p>{}</p>", escape(line)));
            let _ = writeln!(out, "<p>{}</p>", escape(graded.text.lines().next().unwrap_or("")));
            for line in said(graded) {
                let _ = writeln!(out, "<p><code>{}</code></p>", escape(&line));
            }
            if let Some(difference) =
                graded.difference.as_ref().filter(|_| graded.points < graded.item.points)
            {
                out.push_str(&difference.section(["yours", "exact"]));
            }
        }
        out.push_str("</html>\n");
        out
    }
}

/// Returns what the program said, where that helps: if points are missing, or memory was exceeded.
fn said(graded: &Graded<'_>) -> Vec<String> {
    let is_full = graded.points >= graded.item.points;
    let all = graded.said.iter().filter(|line| !is_full || line.contains("stored outside the video memory"));
    // Nothing that a terminal obeys.
    all.map(|line| line.replace(|c: char| c.is_control() && c != '\t', "\u{fffd}")).collect()
}

fn round(points: f64) -> f64 {
    (points * 1000.0).round() / 1000.0
}

/// Returns points with as many decimals as they have.
fn number(points: f64) -> String {
    format!("{}", round(points))
}
