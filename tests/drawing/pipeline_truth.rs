//! The plain path against the truth: every pixel of random scenes, by the project's limits.
//!
//! Guards against an error in the plain path itself, with which everything else is compared.

use fbptr::memory::VideoMemory;
use fbptr::pipeline::{self, DrawCall, SceneOptions, Target};
use fbptr::truth::compare::{Comparison, compare};
use fbptr::truth::scenes::{Case, random};
use fbptr::truth::{Transparency, TruthPicture};

/// Compares the pipeline's picture of a case with the truth; returns the comparison and the number
/// of pixels drawn on.
fn held_to_truth(case: &Case) -> (Comparison, u64) {
    let (width, height, s) = (case.width, case.height, &case.settings);
    let mut truth = TruthPicture::new(width, height, case.format);
    let mut memory = VideoMemory::new(width, height).unwrap();
    let mut depth = None;
    let mut target = Target { memory: &mut memory, depth: &mut depth, depth_format: case.format, ids: None };
    let mut options = SceneOptions::new(width, height);
    options.viewport = s.viewport.unwrap_or(options.viewport);
    (options.shade, options.hide, options.interp) = (s.shade, s.hide, s.interpolation);
    let mut scene = case.scene.clone();
    for object in &mut scene.objects {
        object.cull = s.cull.unwrap_or(object.cull);
    }
    match s.transparency {
        Transparency::AfterOpaque(order) => {
            options.transparency = order;
            pipeline::draw_scene(&mut target, &scene, &options).unwrap();
            truth.draw(&scene, s).unwrap();
        }
        // One DRAW per object, after the background.
        Transparency::AtOnce => {
            let objects = std::mem::take(&mut scene.objects);
            pipeline::draw_scene(&mut target, &scene, &options).unwrap();
            truth.draw(&scene, s).unwrap();
            scene.background.color = None;
            for object in objects {
                scene.objects = vec![object];
                pipeline::draw(&mut target, &DrawCall::of_object(&scene.objects[0], &scene, &options))
                    .unwrap();
                truth.draw(&scene, s).unwrap();
            }
        }
    }
    let states = (0..width * height).map(|i| &truth.states(i % width, i / width)[0]);
    let drawn = states.filter(|s| s.drawn.is_some()).count() as u64;
    (compare(&memory, depth.as_ref(), &truth), drawn)
}

#[test]
fn random_scenes_are_right_in_every_pixel() {
    let count: u64 = std::env::var("SCENES").ok().and_then(|n| n.parse().ok()).unwrap_or(150);
    let first: u64 = std::env::var("SEED").ok().and_then(|n| n.parse().ok()).unwrap_or(1);
    let mut wrong = Vec::new();
    let (mut pixels, mut drawn, mut loose) = (0, 0, 0);
    for seed in first..first + count {
        let case = random(seed);
        let (report, seen) = held_to_truth(&case);
        (pixels, drawn, loose) = (pixels + report.pixels as u64, drawn + seen, loose + report.loose as u64);
        if !report.is_right() {
            println!("{} {:?} {:?}: {report}", case.name, case.settings, case.format);
            wrong.push(seed);
        }
    }
    println!("{count} scenes, {pixels} pixels, {drawn} drawn to, {loose} with wide answers");
    assert!(
        drawn > pixels / 5 && loose < drawn / 50,
        "the scenes ask too little: {drawn} of {pixels}, {loose} loose"
    );
    assert!(wrong.is_empty(), "{} of {count} random scenes are wrong: {wrong:?}", wrong.len());
}
