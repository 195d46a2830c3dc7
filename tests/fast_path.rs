//! The renderer that programs run, against the truth and against the plain path: random scenes, every width, many threads.
//!
//! Fear: that the fast path is fast because it draws another picture - or another one on another machine.

use fbptr::memory::{DepthFormat, DepthMemory, IdMemory, VideoMemory};
use fbptr::pipeline::{DrawCall, DrawStats, RenderOptions, RenderPath, Renderer, SceneOptions, Target};
use fbptr::scene::Scene;
use fbptr::simd::Level;
use fbptr::truth::compare::compare;
use fbptr::truth::scenes::{Case, random};
use fbptr::truth::{Transparency, TruthPicture};
use std::sync::Arc;

/// Bytes, depths, and the name and triangle of each pixel.
type Words<'a> = (&'a [u8], Option<Vec<u32>>, Vec<Option<(u32, u32)>>);

/// What a renderer left behind.
struct Drawn {
    memory: VideoMemory,
    depth: Option<DepthMemory>,
    ids: IdMemory,
    stats: DrawStats,
}

impl Drawn {
    /// Every byte that a program could see.
    fn words(&self) -> Words<'_> {
        let (width, height) = (self.memory.width(), self.memory.height());
        let pixels = 0..(width * height) as usize;
        let depth = self.depth.as_ref().map(|d| pixels.clone().map(|i| d.word(i)).collect());
        let at = |i: usize| ((i as u32 % width) as i32, (i as u32 / width) as i32);
        let ids = pixels.map(at).map(|(x, y)| self.ids.get(x, y)).collect();
        (self.memory.bytes(), depth, ids)
    }
}

fn draw(case: &Case, renderer: &mut Renderer, mut truth: Option<&mut TruthPicture>) -> Drawn {
    let (width, height, s) = (case.width, case.height, &case.settings);
    let mut memory = VideoMemory::new(width, height).unwrap();
    let (mut depth, mut ids, mut stats) = (None, IdMemory::new(width, height), DrawStats::default());
    let mut target =
        Target { memory: &mut memory, depth: &mut depth, depth_format: case.format, ids: Some(&mut ids) };
    let mut options = SceneOptions::new(width, height);
    options.viewport = s.viewport.unwrap_or(options.viewport);
    (options.shade, options.hide, options.interp) = (s.shade, s.hide, s.interpolation);
    let mut scene = case.scene.clone();
    let mut tell = |scene: &Scene| truth.as_mut().map(|t| t.draw(scene, s).unwrap());
    match s.transparency {
        Transparency::AfterOpaque(order) => {
            options.transparency = order;
            stats += renderer.draw_scene(&mut target, &scene, &options).unwrap();
            tell(&scene);
        }
        // One DRAW an object, after the background.
        Transparency::AtOnce => {
            let objects = std::mem::take(&mut scene.objects);
            stats += renderer.draw_scene(&mut target, &scene, &options).unwrap();
            tell(&scene);
            scene.background.color = None;
            for object in objects {
                scene.objects = vec![object];
                stats += renderer
                    .draw(&mut target, &DrawCall::of_object(&scene.objects[0], &scene, &options))
                    .unwrap();
                tell(&scene);
            }
        }
    }
    Drawn { memory, depth, ids, stats }
}

/// A random scene, every other one bent to what the tile renderer serves: opaque, clear air, f32 depth.
fn case(seed: u64) -> Case {
    let mut case = random(seed);
    if seed.is_multiple_of(2) {
        case.format = DepthFormat::F32;
        case.scene.fog = None;
        for object in &mut case.scene.objects {
            object.material.transparency = 0.0;
        }
    }
    case
}

fn with(level: Level, threads: usize) -> Renderer {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    Renderer::new(RenderOptions { pool: Some(Arc::new(pool)), simd: Some(level), path: RenderPath::Fast })
}

fn from_env(name: &str, default: u64) -> u64 {
    std::env::var(name).ok().and_then(|n| n.parse().ok()).unwrap_or(default)
}

#[test]
fn random_scenes_are_right_and_alike_on_every_machine() {
    let (first, count) = (from_env("SEED", 1), from_env("SCENES", 120));
    let mut fast = Renderer::default();
    let mut plain = Renderer::new(RenderOptions { path: RenderPath::Plain, ..RenderOptions::default() });
    let mut others = Vec::new();
    for level in Level::ALL {
        for threads in [1, 2, 3, 16] {
            others.push((format!("{level:?} with {threads} threads"), with(level, threads)));
        }
    }
    let (mut wrong, mut unlike, mut fragments) = (Vec::new(), Vec::new(), [0; 2]);
    for seed in first..first + count {
        let case = case(seed);
        let mut truth = TruthPicture::new(case.width, case.height, case.format);
        let drawn = draw(&case, &mut fast, Some(&mut truth));
        let report = compare(&drawn.memory, drawn.depth.as_ref(), &truth);
        if !report.is_right() {
            println!("seed {seed} {:?} {:?}: {report}", case.settings, case.format);
            wrong.push(seed);
        }
        // The plain path lets the same faces and pixels through, but for depths that all but tie.
        let same = draw(&case, &mut plain, None).stats;
        let counts =
            |s: &DrawStats| [s.faces, s.faces_drawn, s.faces_culled, s.faces_outside, s.pixels_tested];
        assert_eq!(counts(&drawn.stats), counts(&same), "seed {seed}");
        fragments[0] += drawn.stats.pixels_written.abs_diff(same.pixels_written);
        fragments[1] += same.pixels_written;
        // Each scene at one level and number of threads, all of them in turn.
        let picked = (seed % others.len() as u64) as usize;
        let (name, renderer) = &mut others[picked];
        let other = draw(&case, renderer, None);
        if other.words() != drawn.words() || other.stats != drawn.stats {
            unlike.push((seed, name.clone()));
        }
    }
    println!("{count} scenes; {fragments:?} fragments differ");
    assert!(wrong.is_empty(), "{} of {count} scenes are wrong: {wrong:?}", wrong.len());
    assert!(unlike.is_empty(), "{unlike:?}");
    assert!(fragments[0] * 1000 <= fragments[1], "{fragments:?}");
}
