//! Report as JSON.

use super::{errors, value};
use crate::{Report, Standing, savings, speed_of};
use serde_json::{Value, json};

/// Returns the whole report. The keys of all that comes from a clock, or differs from run to run for
/// other reasons, contain `time`; everything else is the same in any two runs.
pub fn json(report: &Report, machine: &str) -> Value {
    let sections: Vec<Value> = report
        .sections
        .iter()
        .map(|s| {
            let rows: Vec<Value> = s
                .subjects()
                .flat_map(|(_, rows)| rows.iter().map(move |r| (rows, r)))
                .map(|(rows, r)| {
                    let bounds: Vec<Value> = r
                        .bounds
                        .iter()
                        .map(|b| json!({ "column": s.experiment.columns[b.column], "at_most": value(b.at_most), "because": b.because }))
                        .collect();
                    json!({
                        "subject": r.subject,
                        "alternative": r.alternative,
                        "default": r.is_default(),
                        "for_comparison": r.standing == Standing::Comparison,
                        "errors": errors(s.experiment.columns, r),
                        "bounds": bounds,
                        "run": r.is_run,
                        "within_bounds": r.is_run.then(|| r.is_within_bounds()),
                        "time_ns_per_unit": r.nanoseconds_per_unit(),
                        "time_ns_quartiles": r.nanosecond_quartiles(),
                        "time_speed_of_default": speed_of(r, rows),
                        "time_on_front": s.is_on_front(rows, r),
                        "time_samples": r.timing.as_ref().map(|t| t.samples()),
                        "time_runs_per_sample": r.timing.as_ref().map(|t| t.runs),
                    })
                })
                .collect();
            json!({
                "id": s.experiment.id,
                "title": s.experiment.title,
                "about": s.experiment.about,
                "truth": {
                    "is": s.experiment.truth.is,
                    "digits": s.experiment.truth.digits,
                    "second_way": s.experiment.truth.second_way,
                    "difference": value(s.check.difference),
                    "at_most": value(s.check.at_most),
                },
                "unit": s.experiment.unit,
                "rows": rows,
                "time_verdict": s.verdict(),
            })
        })
        .collect();
    let scaling: Vec<Value> = report
        .scaling
        .iter()
        .map(|g| {
            let points: Vec<Value> = g
                .points
                .iter()
                .map(|p| json!({ "x": p.x, "time": { "seconds": p.timing.as_ref().map(|t| t.median_s()), "peak_bytes": p.peak_bytes } }))
                .collect();
            json!({ "title": g.title, "grows": g.grows, "time_exponent": g.exponent(), "at_most": g.at_most, "points": points })
        })
        .collect();
    let saved: Vec<Value> = savings(report)
        .iter()
        .map(|s| {
            json!({
                "scene": s.scene,
                "parts_left_out": value(s.parts_left_out),
                "bytes_saved": value(s.bytes_saved),
                "time_ratio": s.time_ratio,
            })
        })
        .collect();
    let decisions: Vec<Value> = report.decisions.iter().map(super::decision::value).collect();
    json!({ "time_and_machine": machine, "time_unrest": report.unrest(), "quick": report.effort.is_quick, "decisions": decisions, "sections": sections, "growth": scaling, "saved": saved })
}

/// Returns the errors alone, which are identical to the digit on every machine, by section,
/// subject, alternative and column.
pub fn errors_json(report: &Report) -> Value {
    let mut all = serde_json::Map::new();
    for s in report.all_sections() {
        for r in s.rows.iter().filter(|r| r.is_run) {
            let key = format!("{} / {} / {}", s.experiment.id, r.subject, r.alternative);
            all.insert(key, errors(s.experiment.columns, r));
        }
    }
    Value::Object(all)
}
