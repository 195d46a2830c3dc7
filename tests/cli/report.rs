//! The report's errors must not drift or differ between machines, and no bound may be broken
//! unseen.
//!
//! Every error column of the quick report is compared, to the digit, with
//! `tests/data/report/quick_errors.json`. `BLESS=1` rewrites that file and still fails. Times are
//! never asserted.

use fbptr::measure::{Effort, Report, run, write};
use serde_json::Value;
use std::path::PathBuf;
use std::sync::OnceLock;

fn quick() -> &'static Report {
    static REPORT: OnceLock<Report> = OnceLock::new();
    REPORT.get_or_init(|| {
        let start = std::time::Instant::now();
        run(Effort::QUICK.untimed(), &mut |title| println!("{:6.2} s {title}", start.elapsed().as_secs_f64()))
    })
}

#[test]
fn every_error_of_the_quick_report_is_as_it_was() {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/data/report/quick_errors.json");
    let found = write::errors_json(quick());
    if std::env::var_os("BLESS").is_some() {
        let text = serde_json::to_string_pretty(&found).unwrap() + "\n";
        std::fs::write(&path, text).unwrap();
        panic!("{} is rewritten: look at the difference", path.display());
    }
    let expected: Value = serde_json::from_str(&std::fs::read_to_string(&path).unwrap()).unwrap();
    let (found, expected) = (found.as_object().unwrap(), expected.as_object().unwrap());
    let keys = |v: &serde_json::Map<String, Value>| v.keys().cloned().collect::<Vec<_>>();
    assert_eq!(keys(found), keys(expected));
    for (key, errors) in expected {
        assert_eq!(&found[key], errors, "{key}");
    }
}

#[test]
fn no_bound_is_broken() {
    let broken = quick().broken_bounds();
    assert!(broken.is_empty(), "{}", broken.join("\n"));
}

#[test]
fn a_broken_bound_hides_the_time_and_is_named() {
    let mut report = quick().clone();
    let row = &mut report.sections[0].rows[0];
    row.timing = Some(fbptr::measure::Timing { min_s: 1e-3, median_s: 1e-3, runs: 3 });
    assert!(row.nanoseconds_per_unit().is_some());
    row.errors[0] = f64::NAN;
    assert!(row.nanoseconds_per_unit().is_none());
    assert_eq!(report.broken_bounds().len(), 1);
    assert!(write::markdown(&report, "here").contains("outside its bound"));
}

#[test]
fn the_page_is_well_formed_and_needs_no_network() {
    let mut report = quick().clone();
    for (i, row) in report.sections.iter_mut().flat_map(|s| &mut s.rows).enumerate() {
        let s = 1e-4 * (1.0 + i as f64);
        row.timing = Some(fbptr::measure::Timing { min_s: s, median_s: s, runs: 3 });
    }
    let page = write::html(&report, "a machine with < and &");
    assert!(!page.contains("http") && !page.contains("<script") && page.matches("<svg").count() > 10);
    // Void elements are the page's only difference from XML.
    let body = page[page.find("<body>").unwrap()..page.find("</html>").unwrap()].replace("<br>", "<br/>");
    if let Err(error) = roxmltree::Document::parse(&body) {
        panic!("the page's body is not well formed: {error}");
    }
    let json = write::json(&report, "here");
    assert_eq!(json["sections"].as_array().unwrap().len(), report.sections.len());
}

#[test]
fn every_hard_case_passes() {
    let rows = fbptr::measure::hard(&mut |_| {});
    let text = write::hard_markdown(&rows);
    assert!(rows.len() > 100 && rows.iter().all(|r| r.passed), "{text}");
}
