//! Goals for the N-dimensional eye, with the measured results.

use super::eye::{IN_A_VOLUME, ON_A_PLANE};
use super::report::Report;

/// Goal with its result.
#[derive(Clone, Debug, PartialEq)]
pub struct Goal {
    /// Measured subject.
    pub what: String,
    /// Required result.
    pub asked: String,
    /// Measured result.
    pub measured: String,
    /// True if the goal is met.
    pub is_met: bool,
}

/// Returns the eye's goals for speed and growth, as far as `report` has measured them.
pub fn eye_goals(report: &Report) -> Vec<Goal> {
    let seconds = |subject: &str, alternative: &str| {
        let rows = report.sections.iter().flat_map(|s| &s.rows);
        let row = rows.filter(|r| r.subject == subject).find(|r| r.alternative == alternative)?;
        Some((row.nanoseconds_per_unit()? * row.work * 1e-9, row.work))
    };
    let mut goals = Vec::new();
    if let Some((s, _)) = seconds(ON_A_PLANE, "2 threads") {
        goals.push(Goal {
            what: format!("{ON_A_PLANE}, 2 threads"),
            asked: "at least 10 pictures a second, goal 30".into(),
            measured: format!("{:.1} pictures a second", 1.0 / s),
            is_met: 1.0 / s >= 10.0,
        });
    }
    if let Some((s, pixels)) = seconds(IN_A_VOLUME, "1 thread") {
        goals.push(Goal {
            what: format!("{IN_A_VOLUME}, 1 thread"),
            asked: "at least 5 Mpixel/s".into(),
            measured: format!("{:.1} Mpixel/s", pixels / s * 1e-6),
            is_met: pixels / s >= 5e6,
        });
    }
    for g in report.scaling.iter().filter(|g| g.grows == "facets") {
        if let (Some(exponent), Some(at_most)) = (g.exponent(), g.at_most) {
            goals.push(Goal {
                what: format!("time a pixel against facets: {}", g.title),
                asked: format!("facets^{at_most} at most"),
                measured: format!("facets^{exponent:.2}"),
                is_met: exponent <= at_most,
            });
        }
    }
    goals
}
