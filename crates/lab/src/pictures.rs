//! Whole pictures: time against error for the modes that a stream of commands can choose, scene by
//! scene; the settings of a picture are compared in [`super::decide`].
//!
//! A scene as it asks to be drawn is the default row. The other rows change one mode each. The ways
//! of one scene are timed in turns, so that all see the same machine. Some pixels drawn on, chosen at
//! random, are compared with the reference.

mod compared;
mod others;
mod scenes;
mod ways;

pub(super) use scenes::made;
pub(super) use ways::limit;

use super::clock::Work;
use super::experiment::{Bound, Check, Effort, Experiment, Row, Truth};
use super::picture::{BenchFrame, Buffers, draw_case};
use compared::Compared;
use fbptr_truth::scenes::Case;
use ways::Way;

/// Experiment on whole pictures.
pub(super) const PICTURES: Experiment = Experiment {
    id: "pictures",
    title: "Appendix: whole pictures in other modes",
    about: "Scenes as they ask to be drawn, and in other modes of a stream: many cost and change nothing here. \
            The ways of a scene are timed in turns; each clears the frame and draws it. Errors are those of randomly chosen \
            pixels that are drawn on. Suzanne, the monkey's head of Blender, is a mesh by Victor Koehler (2018, MIT licence).",
    truth: Truth {
        is: "the scene as it asks to be drawn, by the reference; exact fibres; exact areas of the lines, one over the other",
        digits: "positions 32, lighting and areas 15",
        second_way: "the plain path, a program apart, at the same pixels; the largest difference in 1/255",
    },
    check,
    columns: &["largest error, 1/255", "RMSE, 1/255", "99.9th percentile, 1/255"],
    plotted: 1,
    unit: "pixel",
    rows,
};

/// Column of the largest error.
const LARGEST: usize = 0;

/// Number of pixels compared.
fn compared_pixels(effort: &Effort) -> usize {
    effort.pick(1_500, 4_000)
}

fn check(effort: &Effort) -> Check {
    check_of(effort, &scenes::made(effort))
}

/// Compares the plain path with the reference, at the compared pixels of all cases.
fn check_of(effort: &Effort, cases: &[Case]) -> Check {
    let difference = |case: &Case| -> Option<f64> {
        let compared = Compared::of_case(case, compared_pixels(effort))?;
        Some(compared.errors(&compared.of_bytes(draw_case(case).memory.bytes()))[LARGEST])
    };
    // Large meshes are left to the table of threads and vectors: the plain path takes seconds.
    let cases = cases.iter().filter(|case| scenes::faces(case) <= 100_000);
    let at_most = cases.clone().map(ways::limit).fold(1.0, f64::max);
    Check { difference: cases.filter_map(difference).fold(0.0, f64::max), at_most }
}

fn rows(effort: &Effort) -> Vec<Row> {
    let mut rows: Vec<Row> =
        scenes::made(effort).iter().filter_map(|case| rows_of(effort, case)).flatten().collect();
    rows.extend(others::page_of_lines(effort));
    rows.extend(others::tesseract(effort));
    rows
}

/// Returns the rows of one scene; `None` if it cannot be drawn.
fn rows_of(effort: &Effort, case: &Case) -> Option<Vec<Row>> {
    let compared = Compared::of_case(case, compared_pixels(effort))?;
    let (possible, others): (Vec<Way>, Vec<Way>) = ways::of(case)
        .into_iter()
        .partition(|way| Buffers::of_case(&mut effort.renderer(), &way.case).refusal.is_none());
    let frame = |way: &Way| BenchFrame::new(effort.renderer(), way.case.width, way.case.height);
    let mut frames: Vec<BenchFrame> = possible.iter().map(frame).collect();
    let mut works: Vec<Work<()>> = Vec::new();
    for (way, frame) in possible.iter().zip(&mut frames) {
        works.push(Box::new(|| frame.draw_with(&way.case.scene, &way.options, way.case.format)));
    }
    let timings = effort.run_in_turns(works);
    let pixels = f64::from(case.width) * f64::from(case.height);
    let mut rows = Vec::new();
    for ((way, frame), ((), timing)) in possible.iter().zip(&frames).zip(timings) {
        let found = compared.of_bytes(frame.memory.bytes());
        let key = (case.name.as_str(), way.name.as_str(), way.standing);
        let row = compared.judged(effort, key, way.bounds.clone(), &found);
        rows.push(row.timed(timing, pixels));
    }
    let left_out = |way: Way| Row::not_run(case.name.clone(), way.name, PICTURES.columns.len());
    rows.extend(others.into_iter().map(left_out));
    Some(rows)
}

/// Returns the bound of a column.
fn bound(column: usize, at_most: f64, because: &'static str) -> Bound {
    Bound { column, at_most, because }
}

/// Returns first quartile, median and third quartile of how many times as fast as the default of its
/// subject a row is, if both were timed.
pub fn speed_of(row: &Row, rows: &[Row]) -> Option<[f64; 3]> {
    rows.iter().find(|r| r.is_default())?.time_over(row)
}
