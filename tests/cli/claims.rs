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
    fn rows<'a>(&'a self, id: &str) -> impl Iterator<Item = &'a Value> {
        let sections = self.0["sections"].as_array().expect("sections").iter();
        let of_table = sections.filter(|s| s["id"] == id).collect::<Vec<_>>();
        of_table.into_iter().flat_map(|s| s["rows"].as_array().expect("rows"))
    }

    /// Returns the subjects of a table, each once.
    fn subjects(&self, id: &str) -> Vec<&str> {
        let mut all: Vec<&str> = self.rows(id).filter_map(|row| row["subject"].as_str()).collect();
        all.dedup();
        all
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

/// Returns the scenes of the notes' table of the budget: name, cost of choosing, speeds from E 1 to
/// 64, and how they are lit.
fn budget_table(notes: &str) -> Vec<(String, f64, Vec<f64>, String)> {
    let cells = |line: &str| line.split('|').map(|cell| cell.trim().to_owned()).collect::<Vec<_>>();
    let rows = notes.lines().map(cells).filter(|row| row.len() == 14 && row[2].starts_with(char::is_numeric));
    let first = |cell: &String| cell.split(' ').next().and_then(|n| n.parse().ok()).expect("a number");
    rows.map(|row| (row[1].clone(), first(&row[4]), row[5..12].iter().map(first).collect(), row[12].clone()))
        .collect()
}

/// The budget's figures are times, and stand in the notes' table; both pages sum it up rightly.
#[test]
fn the_budgets_sums_are_those_of_its_table() {
    let notes = read("docs/notes/error-budget.md");
    let table = budget_table(&notes);
    let files = || table.iter().filter(|row| row.0.contains('/'));
    // E 4 is the third column, E 16 the fifth.
    let fast = |column: usize, times: f64| table.iter().filter(|row| row.2[column] >= times).count();
    let fast_files = |column: usize, times: f64| files().filter(|row| row.2[column] >= times).count();
    let mut choosing: Vec<f64> = table.iter().map(|row| row.1).collect();
    choosing.sort_by(f64::total_cmp);
    let (median, most) = (choosing[table.len() / 2], choosing[table.len() - 1]);
    let exact = || table.iter().filter(|row| !row.3.contains("E "));
    let mut noise: Vec<f64> = exact().flat_map(|row| row.2.iter().copied()).collect();
    noise.sort_by(f64::total_cmp);
    let all = table.len();
    let claims = [
        (
            PAGE,
            format!(
                "of {all}, the test data's meshes among them, E 4 is at least 1.3 times as fast as exact on {} \
                        and E 16 at least 1.6 times on {}",
                fast(2, 1.3),
                fast(4, 1.6)
            ),
        ),
        (
            PAGE,
            format!("Choosing costs {median} exact frames in the median, once a mesh, and {most} at most"),
        ),
        ("docs/notes/error-budget.md", format!("Of these {all} scenes {} are files", files().count())),
        (
            "docs/notes/error-budget.md",
            format!(
                "**E 4 is at least 1.3 times as fast as exact on {} ({} of the files), E 16 \
                        at least 1.6 times on {} ({})**",
                fast(2, 1.3),
                fast_files(2, 1.3),
                fast(4, 1.6),
                fast_files(4, 1.6)
            ),
        ),
        (
            "docs/notes/error-budget.md",
            format!(
                "On {} scenes nothing is chosen at any E; their {} cells have quartiles {:.2} \
                        and {:.2}, from {:.2} to {:.2}",
                exact().count(),
                noise.len(),
                noise[noise.len() / 4],
                noise[3 * noise.len() / 4],
                noise[0],
                noise[noise.len() - 1]
            ),
        ),
    ];
    for (page, words) in claims {
        assert!(joined(&read(page)).contains(&words), "{page} does not say: {words}");
    }
}
