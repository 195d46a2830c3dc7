//! The report's errors must not drift or differ between machines, and no bound may be broken
//! unseen.
//!
//! Every error column of the quick report is compared, to the digit, with
//! `tests/data/report/quick_errors.json`. `BLESS=1` rewrites that file and still fails. Times are
//! never asserted.

use fbptr::measure::{Effort, Report, Standing, run, write};
use fbptr::simd::Level;
use serde_json::Value;
use std::path::PathBuf;
use std::sync::OnceLock;

pub fn quick() -> &'static Report {
    static REPORT: OnceLock<Report> = OnceLock::new();
    REPORT.get_or_init(|| {
        let start = std::time::Instant::now();
        run(Effort::QUICK.untimed().with_mutants(), &mut |title| {
            println!("{:6.2} s {title}", start.elapsed().as_secs_f64())
        })
    })
}

#[test]
fn every_error_of_the_quick_report_is_as_it_was() {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/data/report/quick_errors.json");
    let found = write::errors_json(quick());
    let expected: Value = serde_json::from_str(&std::fs::read_to_string(&path).unwrap()).unwrap();
    let (found, expected) = (found.as_object().unwrap(), expected.as_object().unwrap());
    // What this machine lacks is not run, and nothing else is missing.
    let lacks = |key: &str| {
        let missing = quick().sections.iter().flat_map(|s| s.rows.iter().map(move |r| (s.experiment.id, r)));
        missing
            .filter(|(_, r)| !r.is_run)
            .any(|(id, r)| key == format!("{id} / {} / {}", r.subject, r.alternative))
    };
    if std::env::var_os("BLESS").is_some() {
        // A vector width that this machine lacks draws the same bytes as those that it has.
        let alike = |key: &str| {
            let width = Level::ALL.iter().find(|l| key.contains(&format!(" {} vectors", l.as_str())))?;
            found.get(&key.replace(width.as_str(), Level::Portable.as_str()))
        };
        let kept = expected.iter().filter(|(key, _)| lacks(key)).map(|(k, v)| (k, alike(k).unwrap_or(v)));
        let all: serde_json::Map<_, _> =
            found.iter().chain(kept).map(|(k, v)| (k.clone(), v.clone())).collect();
        let text = serde_json::to_string_pretty(&all).unwrap() + "\n";
        std::fs::write(&path, text).unwrap();
        panic!("{} is rewritten: look at the difference", path.display());
    }
    assert!(found.keys().all(|key| expected.contains_key(key)));
    for (key, errors) in expected {
        match found.get(key) {
            Some(found) => assert_eq!(found, errors, "{key}"),
            None => assert!(lacks(key), "{key}"),
        }
    }
}

#[test]
fn no_bound_is_broken() {
    let broken = quick().broken_bounds();
    assert!(broken.is_empty(), "{}", broken.join("\n"));
}

/// Each bounded output, turned wrong by a little more than its bound, has to be seen.
#[test]
fn every_bound_can_break() {
    let mut count = 0;
    for section in quick().all_sections() {
        for row in &section.rows {
            assert_eq!(row.mutants.len(), row.bounds.len(), "{}, {}", row.subject, row.alternative);
            for (bound, error) in row.bounds.iter().zip(&row.mutants) {
                let place = (section.experiment.id, &row.subject, &row.alternative, bound);
                assert!(*error > bound.at_most, "not seen: {place:?} has {error}");
                let little = 2.0 * bound.at_most + 4.0;
                assert!(*error <= little, "not by a little: {place:?} has {error}");
                count += 1;
            }
        }
    }
    assert!(count > 100, "{count}");
}

/// No table compares a way with itself: every default has a bound, and so a truth that can differ.
#[test]
fn every_default_is_held_to_a_truth() {
    for section in quick().all_sections() {
        assert!(section.check.is_right(), "{}: {:?}", section.experiment.id, section.check);
        for row in section.rows.iter().filter(|r| r.is_default()) {
            assert!(!row.bounds.is_empty(), "{}: {}", section.experiment.id, row.alternative);
        }
    }
    let by_hand = |id: &str, alternative: &str| {
        let rows = quick().sections.iter().filter(|s| s.experiment.id == id).flat_map(|s| &s.rows);
        rows.filter(|r| r.alternative == alternative).map(|r| r.standing).collect::<Vec<_>>()
    };
    assert!(by_hand("interpolation", "f32 increments").iter().all(|s| *s == Standing::Comparison));
    assert!(by_hand("interpolation", "affine").iter().all(|s| *s == Standing::Mode));
}

#[test]
fn a_broken_bound_hides_the_time_and_is_named() {
    let mut report = quick().clone();
    let row = &mut report.sections[0].rows[0];
    row.timing = Some(fbptr::measure::Timing::single(1e-3));
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
        row.timing = Some(fbptr::measure::Timing::single(s));
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

#[test]
fn what_was_not_run_shows_neither_errors_nor_a_verdict() {
    let mut report = quick().clone();
    let section = report.sections.last_mut().unwrap();
    let columns = section.experiment.columns.len();
    section.rows.push(fbptr::measure::Row::not_run("a knot".into(), "vectors of the future".into(), columns));
    let markdown = write::markdown(&report, "here");
    let line = markdown.lines().find(|l| l.contains("vectors of the future")).unwrap();
    assert!(line.contains("not run") && !line.contains("NaN") && !line.contains("≤"), "{line}");
    let json = write::json(&report, "here");
    let row =
        json["sections"].as_array().unwrap().last().unwrap()["rows"].as_array().unwrap().last().unwrap();
    assert_eq!(
        (&row["run"], &row["within_bounds"], &row["errors"]),
        (&Value::Bool(false), &Value::Null, &Value::Null)
    );
    assert!(report.broken_bounds().is_empty());
}

/// Removes everything under a key that contains `time`.
fn without_times(value: &mut Value) {
    match value {
        Value::Object(fields) => {
            fields.retain(|key, _| !key.contains("time"));
            fields.values_mut().for_each(without_times);
        }
        Value::Array(items) => items.iter_mut().for_each(without_times),
        _ => {}
    }
}

#[test]
fn whatever_comes_from_a_clock_is_named_after_it() {
    let timed = |scale: f64, machine| {
        let mut report = quick().clone();
        for (i, row) in report.sections.iter_mut().flat_map(|s| &mut s.rows).enumerate() {
            let s = 1e-4 * scale * (1.0 + ((i as f64) * scale).sin().abs());
            row.timing = Some(fbptr::measure::Timing::of(&[s, s * 1.1, s * scale][..1 + i % 3], 1 + i));
        }
        let point = |x| fbptr::measure::ScalingPoint {
            x,
            timing: Some(fbptr::measure::Timing::single(x * scale)),
            peak_bytes: Some((scale * 1e6) as u64),
        };
        let points = vec![point(1.0), point(2.0 + scale)];
        let points =
            points.into_iter().map(|p| fbptr::measure::ScalingPoint { x: p.x.min(2.0), ..p }).collect();
        report.scaling =
            vec![fbptr::measure::Scaling { title: "growth".into(), grows: "things", at_most: None, points }];
        write::json(&report, machine)
    };
    let [mut a, mut b] = [timed(1.5, "today"), timed(3.25, "tomorrow")];
    assert_ne!(a, b);
    without_times(&mut a);
    without_times(&mut b);
    assert_eq!(a, b);
}

/// Neither the SIMD level nor the threads change an error.
#[test]
fn errors_are_the_same_on_every_level_and_number_of_threads() {
    use fbptr::simd::Level;
    // Those that the effort's renderer draws.
    let ids = ["coverage", "interpolation", "depth", "shading", "textures", "hidden", "stages", "pictures"];
    // The two narrowest: the shared report is drawn at the best level by the machine's threads.
    for (level, threads) in Level::ALL.into_iter().filter(|l| l.is_available()).zip([16, 3]) {
        let effort = Effort::QUICK.untimed().drawn_by(Some(level), threads);
        for section in quick().sections.iter().filter(|s| ids.contains(&s.experiment.id)) {
            let rows = (section.experiment.rows)(&effort);
            assert_eq!(rows.len(), section.rows.len());
            for (a, b) in rows.iter().zip(&section.rows) {
                let place = (section.experiment.id, &a.subject, &a.alternative, level.as_str(), threads);
                assert_eq!(a.errors, b.errors, "{place:?}");
            }
        }
    }
}
