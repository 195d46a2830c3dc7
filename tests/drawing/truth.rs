//! Verifies that the pipeline draws what the specification says.
//!
//! Every random scene and every hard case is drawn twice, by the pipeline and by the independent
//! reference, and compared by the limits of `truth::compare`. `FBPTR_SCENES=10000` sets the number
//! of random scenes, `FBPTR_SEED=n` selects one of them.

use crate::against_truth::fault_of;
use fbptr::measure::draw_case;
use fbptr::truth::compare::compare;
use fbptr::truth::scenes::{Case, random};
use fbptr::truth::{hard_cases, render};

#[test]
fn random_scenes_agree_with_the_truth() {
    let number = |key: &str| std::env::var(key).ok().and_then(|v| v.parse::<u64>().ok());
    let seeds = match number("FBPTR_SEED") {
        Some(seed) => seed..seed + 1,
        None => 0..number("FBPTR_SCENES").unwrap_or(150),
    };
    let total = seeds.end - seeds.start;
    let faults: Vec<String> = seeds.filter_map(|seed| fault_of(&random(seed))).collect();
    let shown: String = faults.iter().take(10).map(String::as_str).collect();
    assert!(faults.is_empty(), "{} of {total} random scenes are off:\n{shown}", faults.len());
}

#[test]
fn hard_cases_agree_with_the_truth() {
    let cases = hard_cases();
    let faults: Vec<String> = cases.iter().filter_map(fault_of).collect();
    assert!(
        faults.is_empty(),
        "{} of {} hard cases are off:\n{}",
        faults.len(),
        cases.len(),
        faults.concat()
    );
}

/// Returns whether the comparison notices a change of a case before it is drawn.
fn sees(case: &Case, change: impl Fn(&mut Case)) -> bool {
    let mut other = case.clone();
    change(&mut other);
    let truth = render(&case.scene, case.width, case.height, case.format, &case.settings).unwrap();
    let drawn = draw_case(&other);
    !compare(&drawn.memory, drawn.depth.as_ref(), &truth).is_right()
}

/// Tests the comparison itself: small changes of the input must be noticed in most scenes that show
/// anything.
#[test]
fn small_faults_are_seen() {
    let cases: Vec<Case> = (0..60).map(random).collect();
    let count = |change: &dyn Fn(&mut Case)| cases.iter().filter(|c| sees(c, change)).count();
    let nudge = |c: &mut Case| {
        for o in &mut c.scene.objects {
            o.model.w_axis.x += 0.02;
        }
    };
    let brighter = |c: &mut Case| {
        for o in &mut c.scene.objects {
            o.material.emissive += glam::DVec3::splat(0.02);
        }
    };
    let swapped = |c: &mut Case| c.scene.objects.reverse();
    let flipped = |c: &mut Case| {
        for o in &mut c.scene.objects {
            o.two_sided_lighting = !o.two_sided_lighting;
        }
    };
    let found = [count(&nudge), count(&brighter), count(&swapped), count(&flipped)];
    assert!(found[0] > 45 && found[1] > 45 && found[2] > 10 && found[3] > 10, "seen in {found:?} of 60");
}

/// Bounds the freedom of the reference: pixels with several right answers are rare, those without a
/// firm one rarer still.
#[test]
fn the_truth_is_firm_nearly_everywhere() {
    let (mut pixels, mut drawn, mut turns, mut loose) = (0, 0, 0, 0);
    for seed in 0..100 {
        let case = random(seed);
        let truth = render(&case.scene, case.width, case.height, case.format, &case.settings).unwrap();
        for (x, y) in (0..case.height).flat_map(|y| (0..case.width).map(move |x| (x, y))) {
            let states = truth.states(x, y);
            pixels += 1;
            drawn += usize::from(states[0].drawn.is_some());
            turns += usize::from(states.len() > 1);
            let wide = states.iter().any(|s| (0..3).any(|c| s.hi[c] - s.lo[c] > 4));
            loose += usize::from(truth.is_free(x, y) || wide);
        }
    }
    println!("{pixels} pixels, {drawn} drawn, {turns} with several answers, {loose} loose");
    assert!(drawn > pixels / 4, "{drawn} of {pixels} pixels are drawn");
    assert!(turns * 50 < drawn && loose * 200 < drawn, "{turns} turns, {loose} loose of {drawn} drawn");
}
