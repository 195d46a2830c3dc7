//! Fear: the pipeline draws something else than the specification says.
//!
//! Every random scene and every hard case is drawn twice, by the pipeline and by the independent reference, and compared by
//! the limits of `truth::compare`. `FBPTR_SCENES=10000` asks for more random scenes than the quick share, `FBPTR_SEED=n`
//! for one of them.

use fbptr::memory::{DepthMemory, IdMemory, VideoMemory};
use fbptr::pipeline::{self, DrawCall, SceneOptions, Target};
use fbptr::scene::{Viewport, ViewportRule};
use fbptr::truth::compare::compare;
use fbptr::truth::scenes::{Case, random};
use fbptr::truth::{Transparency, TruthPicture, hard_cases, render};

struct Drawn {
    memory: VideoMemory,
    depth: Option<DepthMemory>,
    ids: IdMemory,
}

fn viewport_of(case: &Case) -> Viewport {
    let whole = Viewport { x: 0, y: 0, width: case.width, height: case.height, rule: ViewportRule::Corners };
    case.settings.viewport.unwrap_or(whole)
}

/// The case through the pipeline: one draw an object, or the whole scene.
fn draw(case: &Case) -> Drawn {
    let mut memory = VideoMemory::new(case.width, case.height).unwrap();
    let mut ids = IdMemory::new(case.width, case.height);
    let mut depth = None;
    let mut target =
        Target { memory: &mut memory, depth: &mut depth, depth_format: case.format, ids: Some(&mut ids) };
    let s = &case.settings;
    let mut scene = case.scene.clone();
    for o in &mut scene.objects {
        o.cull = s.cull.unwrap_or(o.cull);
    }
    match s.transparency {
        Transparency::AfterOpaque(transparency) => {
            let options = SceneOptions {
                viewport: viewport_of(case),
                shade: s.shade,
                hide: s.hide,
                interp: s.interpolation,
                transparency,
                ..SceneOptions::new(case.width, case.height)
            };
            pipeline::draw_scene(&mut target, &scene, &options).unwrap();
        }
        Transparency::AtOnce => {
            for (i, o) in scene.objects.iter().enumerate() {
                let call = DrawCall {
                    model: o.model,
                    camera: scene.camera.unwrap_or_default(),
                    viewport: viewport_of(case),
                    ambient: scene.ambient,
                    lights: &scene.lights,
                    light_subset: o.lights.as_deref(),
                    back_material: o.back_material.as_ref(),
                    texture: o.texture.as_ref().map(|t| &*t.0),
                    sampling: o.texture.as_ref().map(|t| t.1).unwrap_or_default(),
                    shade: o.shade.unwrap_or(s.shade),
                    cull: o.cull,
                    hide: s.hide,
                    interp: s.interpolation,
                    two_sided_lighting: o.two_sided_lighting,
                    fog: scene.fog,
                    name: i as u32,
                    ..DrawCall::new(&o.geometry, &o.material, case.width, case.height)
                };
                pipeline::draw(&mut target, &call).unwrap();
            }
        }
    }
    Drawn { memory, depth, ids }
}

/// Pixels where PICK would answer another face than the one right answer.
fn picks_off(drawn: &Drawn, truth: &TruthPicture) -> Vec<(u32, u32)> {
    let pixels = (0..truth.height()).flat_map(|y| (0..truth.width()).map(move |x| (x, y)));
    pixels
        .filter(|&(x, y)| {
            let states = truth.states(x, y);
            let right = states[0].depth_owner.map(|key| (truth.face(key).object, truth.face(key).triangle));
            states.len() == 1 && !truth.is_free(x, y) && drawn.ids.get(x as i32, y as i32) != right
        })
        .collect()
}

/// Draws a case both ways; what is wrong with it, if anything.
fn fault_of(case: &Case) -> Option<String> {
    let truth = render(&case.scene, case.width, case.height, case.format, &case.settings).unwrap();
    let drawn = draw(case);
    let report = compare(&drawn.memory, drawn.depth.as_ref(), &truth);
    let picks = picks_off(&drawn, &truth);
    if report.is_right() && picks.is_empty() {
        return None;
    }
    let s = &case.settings;
    Some(format!(
        "{}: {report}  picks off: {picks:?}\n  {s:?} {:?} {}x{}\n  {:?}",
        case.name, case.format, case.width, case.height, case.scene.camera
    ))
}

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

/// What the comparison says of a case that was drawn with one thing changed.
fn sees(case: &Case, change: impl Fn(&mut Case)) -> bool {
    let mut other = case.clone();
    change(&mut other);
    let truth = render(&case.scene, case.width, case.height, case.format, &case.settings).unwrap();
    let drawn = draw(&other);
    !compare(&drawn.memory, drawn.depth.as_ref(), &truth).is_right()
}

/// The judge is judged: small changes of what is drawn must be seen in most scenes that show anything.
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

/// How much is left open: pixels with several right answers are rare, those without a firm one rarer still.
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
