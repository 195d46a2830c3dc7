//! Each claim that the pages make from the report is traced to a line of `report.json`.
//!
//! A claim is words of a page, and what the rows of the quick report have to say for them to be
//! true. In the page's results every number stands in some claim, so that none is added unseen;
//! times are no claims, for they are those of one machine on one day.

use serde_json::Value;
use std::path::PathBuf;

/// Words of a page, and the rows and numbers that they rest on.
struct Claim {
    page: &'static str,
    words: &'static str,
    /// Returns whether the report says so.
    holds: fn(&Report) -> bool,
}

const PAGE: &str = "docs/report.md";

include!("claims/list.rs");

struct Report(Value);

impl Report {
    fn rows<'a>(&'a self, id: &'a str) -> impl Iterator<Item = &'a Value> {
        let sections = self.0["sections"].as_array().expect("sections").iter();
        sections.filter(move |s| s["id"] == id).flat_map(|s| s["rows"].as_array().expect("rows"))
    }

    fn of<'a>(&'a self, id: &'a str, alternative: &'a str) -> impl Iterator<Item = &'a Value> {
        let rows = self.rows(id).filter(move |r| r["alternative"] == alternative).collect::<Vec<_>>();
        assert!(!rows.is_empty(), "{id} has no {alternative}");
        rows.into_iter()
    }

    /// Returns an error of each row of an alternative.
    fn errors(&self, id: &str, alternative: &str, column: &str) -> Vec<f64> {
        let error =
            |r: &Value| r["errors"][column].as_f64().unwrap_or_else(|| panic!("{id}: {column} in {r}"));
        self.of(id, alternative).map(error).collect()
    }

    fn largest(&self, id: &str, alternative: &str, column: &str) -> f64 {
        self.errors(id, alternative, column).into_iter().fold(0.0, f64::max)
    }
}

fn read(path: &str) -> String {
    std::fs::read_to_string(PathBuf::from(env!("CARGO_MANIFEST_DIR")).join(path)).expect(path)
}

fn report() -> Report {
    Report(fbptr::measure::write::json(super::report::quick(), "here"))
}

/// Returns text with one space for every break.
fn joined(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

#[test]
fn each_claim_is_what_the_report_says() {
    let report = report();
    for claim in CLAIMS {
        assert!(
            joined(&read(claim.page)).contains(claim.words),
            "{} does not say: {}",
            claim.page,
            claim.words
        );
        assert!((claim.holds)(&report), "the report does not say: {}", claim.words);
    }
}

#[test]
fn no_number_of_the_results_is_without_its_claim() {
    let page = joined(&read(PAGE));
    let results = &page[page.find("## Results").expect("results")..];
    let mut rest = results.to_owned();
    for claim in CLAIMS.iter().filter(|c| c.page == PAGE) {
        rest = rest.replace(claim.words, "");
    }
    // The name of a format is no number.
    rest = rest.replace("f32", "");
    assert!(!rest.contains(|c: char| c.is_ascii_digit()), "not traced: {rest}");
}
