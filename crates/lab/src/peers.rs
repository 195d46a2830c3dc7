//! Other programs' frames beside those of fbptr, as `benches/peers/run.sh` timed them.
//!
//! In: the text of its `peers.json`. Out: a section of the report, whose subjects are the workloads
//! W1 to W5 with their threads. Nothing is measured here, so nothing stands here without that file.

use super::clock::Timing;
use super::experiment::{Bound, Check, Experiment, Row, Standing, Truth};
use super::report::Section;
use serde_json::Value;

const PEERS: Experiment = Experiment {
    id: "peers",
    title: "Other programs",
    about: "Workloads W1 to W5 of `fbptr bench`, 1920x1080, in fbptr and in other programs, as `benches/peers/run.sh` timed \
            them in turns: the median frame of the best round. A pixel is off that is more than 1/255 from the truth.",
    truth: Truth {
        is: "each workload's picture, by the reference",
        digits: "15",
        second_way: "fbptr's frames; their largest difference in 1/255",
    },
    check: |_| Check { difference: 0.0, at_most: 0.0 },
    columns: &["largest error, 1/255", "pixels off"],
    plotted: 0,
    unit: "frame",
    rows: |_| Vec::new(),
};

/// Largest error of fbptr's own frames that is expected, in 1/255: that of textured colours.
const OWN_ERROR: f64 = 2.0;

/// Returns the section of a `peers.json`. Rows of other workloads, and rows whose picture was not
/// compared with the truth, are left out.
///
/// # Errors
/// Text of what is wrong with the file, also if no row is left.
pub fn peers_of(json: &str) -> Result<Section, String> {
    let all: Vec<Value> = serde_json::from_str(json).map_err(|e| e.to_string())?;
    let mut rows: Vec<Row> = all.iter().filter_map(row).collect();
    if rows.is_empty() {
        return Err("no rows of the workloads W1 to W5 with their errors".into());
    }
    rows.sort_by(|a, b| a.subject.cmp(&b.subject).then(b.is_default().cmp(&a.is_default())));
    let own = rows.iter().filter(|row| row.is_default());
    let difference = own.fold(0.0, |most, row| row.errors[0].max(most));
    Ok(Section { experiment: PEERS, rows, check: Check { difference, at_most: OWN_ERROR } })
}

/// Returns the limit of fbptr's own colours: W4 is textured.
fn own_limit(workload: &str) -> Bound {
    let because = "the limit of textured colours, 2, or of others, 1, by the specification";
    Bound { column: 0, at_most: if workload.starts_with("W4") { OWN_ERROR } else { 1.0 }, because }
}

/// Returns one row.
fn row(value: &Value) -> Option<Row> {
    let word = |name: &str| value[name].as_str();
    let (workload, peer, config) = (word("wl")?, word("peer")?, word("cfg")?);
    if !("W1".."W6").contains(&workload) {
        return None;
    }
    let threads = config.split('T').next()?;
    let level = config.split_once(' ').map_or(String::new(), |(_, level)| format!(", {level}"));
    let milliseconds = value["med_ms"].as_f64().filter(|ms| *ms > 0.0)?;
    Some(Row {
        subject: format!("{workload}, {threads} {}", if threads == "1" { "thread" } else { "threads" }),
        alternative: format!("{peer}{level}"),
        standing: if peer == "fbptr" { Standing::Default } else { Standing::Comparison },
        errors: vec![value["max_err"].as_f64()?, value["pixels_off"].as_f64()?],
        bounds: if peer == "fbptr" { vec![own_limit(workload)] } else { Vec::new() },
        mutants: Vec::new(),
        is_run: true,
        timing: Some(Timing::single(milliseconds / 1e3)),
        work: 1.0,
        picture: None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_stand_beside_those_of_the_program_by_workload_and_threads() {
        let section = peers_of(
            r#"[{"wl":"W1_phong70k","peer":"euc","cfg":"1T","med_ms":90.5,"max_err":3,"pixels_off":4},
                {"wl":"W1_phong70k","peer":"fbptr","cfg":"1T avx2","med_ms":5.5,"max_err":1,"pixels_off":0},
                {"wl":"W1_phong70k","peer":"fbptr","cfg":"2T avx2","med_ms":3.5,"max_err":1,"pixels_off":0},
                {"wl":"W2_phong1M","peer":"sdl","cfg":"1T","med_ms":3.5,"max_err":null,"pixels_off":null},
                {"wl":"W7_putpixel_100M","peer":"fbptr","cfg":"1T","med_ms":3.5,"max_err":0,"pixels_off":0}]"#,
        )
        .unwrap();
        let rows = |(subject, rows): (&str, &[Row])| {
            let names: Vec<&str> = rows.iter().map(|row| row.alternative.as_str()).collect();
            format!("{subject}: {}", names.join("; "))
        };
        let lines: Vec<String> = section.subjects().map(rows).collect();
        assert_eq!(lines, ["W1_phong70k, 1 thread: fbptr, avx2; euc", "W1_phong70k, 2 threads: fbptr, avx2"]);
        assert_eq!(section.rows[1].errors, [3.0, 4.0]);
        assert_eq!(section.rows[1].nanoseconds_per_unit(), Some(90.5e6));
        assert!(section.check.is_right() && section.rows.iter().all(Row::is_within_bounds));
        assert_eq!(section.rows.iter().map(|row| row.bounds.len()).collect::<Vec<_>>(), [1, 0, 1]);
        assert_eq!(section.better_than_default(), None, "no other program is a mode of this one");
        assert!(peers_of("{}").is_err() && peers_of("[]").is_err());
    }
}
