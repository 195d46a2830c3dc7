//! Error budgets: a cheaper picture must not be further from the truth than was asked.
//!
//! Scenes that nothing was tuned on, drawn with the settings that the budget chooses, are compared
//! pixel by pixel with the reference: the 99.9th percentile of the colour error over the pixels
//! drawn on stays within E; coverage and depth equal those of the exact picture.

use fbptr::memory::{DepthFormat, DepthMemory, VideoMemory};
use fbptr::pipeline::quality::{Budget, BudgetKind, Choice, LOOK_AT_ALL, choose};
use fbptr::pipeline::{RenderOptions, Renderer, SceneOptions, Target};
use fbptr::scene::{Interpolation, Scene, ShadeMode, Viewport, ViewportRule, shapes};
use fbptr::truth::compare::color_error;
use fbptr::truth::scenes::{Case, Random, object, random, random_camera};
use fbptr::truth::{Transparency, render};
use glam::DVec3;

struct Outcome {
    max_error: f64,
    choice: Choice,
    /// Errors of the pixels drawn on, in ascending order.
    errors: Vec<u8>,
    is_cheaper: bool,
}

impl Outcome {
    fn quantile(&self) -> u8 {
        let n = self.errors.len();
        if n == 0 { 0 } else { self.errors[((0.999 * n as f64).ceil() as usize).max(1) - 1] }
    }
}

fn options(case: &Case) -> SceneOptions {
    let s = &case.settings;
    let whole = Viewport { x: 0, y: 0, width: case.width, height: case.height, rule: ViewportRule::Corners };
    SceneOptions {
        viewport: s.viewport.unwrap_or(whole),
        shade: s.shade,
        hide: s.hide,
        interp: s.interpolation,
        transparency: match s.transparency {
            Transparency::AfterOpaque(order) => order,
            Transparency::AtOnce => Default::default(),
        },
        ..SceneOptions::new(case.width, case.height)
    }
}

fn frame(scene: &Scene, options: &SceneOptions, case: &Case) -> (VideoMemory, Option<DepthMemory>) {
    let mut memory = VideoMemory::new(case.width, case.height).unwrap();
    let mut depth = None;
    let mut target = Target { memory: &mut memory, depth: &mut depth, depth_format: case.format, ids: None };
    Renderer::new(RenderOptions::default()).draw_scene(&mut target, scene, options).unwrap();
    (memory, depth)
}

/// Returns the budget of a case that is drawn as one scene.
fn budget<'a>(case: &'a Case, options: &'a SceneOptions, max_error: f64) -> Budget<'a> {
    Budget {
        scene: &case.scene,
        options,
        kind: BudgetKind::Scene,
        depth_format: case.format,
        width: case.width,
        height: case.height,
        max_error,
    }
}

/// Draws a case with the settings that the budget chooses, once for each E, and compares the
/// pictures with the truth.
fn keep_to(case: &Case, limits: &[f64]) -> Vec<Outcome> {
    let exact_options = options(case);
    let (_, exact_depth) = frame(&case.scene, &exact_options, case);
    let truth = render(&case.scene, case.width, case.height, case.format, &case.settings).unwrap();
    let one = |&max_error: &f64| {
        let budget = budget(case, &exact_options, max_error);
        let choice = choose(&mut Renderer::new(RenderOptions::default()), &budget).unwrap();
        let (mut scene, mut cheaper) = (case.scene.clone(), exact_options.clone());
        choice.apply(&mut scene, &mut cheaper);
        let (memory, depth) = frame(&scene, &cheaper, case);
        let words = |d: &Option<DepthMemory>| -> Vec<u32> {
            d.iter().flat_map(|d| (0..memory.bytes().len() / 4).map(|i| d.word(i))).collect()
        };
        let same = words(&depth) == words(&exact_depth);
        assert!(same, "{}: coverage and depth are not touched\n{choice}", case.name);
        let mut errors = Vec::new();
        for i in 0..memory.bytes().len() / 4 {
            let (x, y) = (i as u32 % case.width, i as u32 / case.width);
            if truth.states(x, y).iter().any(|s| s.drawn.is_some()) {
                errors.push(color_error(&truth, i, std::array::from_fn(|c| memory.bytes()[4 * i + c])));
            }
        }
        errors.sort_unstable();
        let is_cheaper = !choice.is_exact(&exact_options);
        Outcome { max_error, choice, errors, is_cheaper }
    };
    limits.iter().map(one).collect()
}

/// Returns a random scene, with random camera and modes, that is drawn by one call.
fn whole(seed: u64) -> Case {
    let mut case = random(seed);
    if case.settings.transparency == Transparency::AtOnce {
        case.settings.transparency = Transparency::AfterOpaque(Default::default());
    }
    // Textures in the reference may be 2 steps off where its own decision is a tie; the budget is
    // not concerned.
    case
}

#[test]
fn random_scenes_stay_within_their_budget() {
    let (mut cheaper, mut looked_at) = (0, 0);
    for seed in 9000..9040 {
        let case = whole(seed);
        for outcome in keep_to(&case, &[2.0, 8.0]) {
            let (found, max_error) = (outcome.quantile(), outcome.max_error);
            let choice = &outcome.choice;
            assert!(f64::from(found) <= max_error, "{} at {max_error}: {found}\n{choice}", case.name);
            cheaper += usize::from(outcome.is_cheaper);
            looked_at += usize::from(!outcome.errors.is_empty());
        }
    }
    // The promise is not kept by exact drawing alone.
    assert!(cheaper * 3 > looked_at && looked_at > 40, "{cheaper} of {looked_at} are cheaper");
}

/// Returns a scene of a smooth ball under a few lights, on a frame too large for every pixel to be
/// probed.
fn large(seed: u64) -> Case {
    let mut r = Random::new(seed);
    let mut case = random(seed);
    (case.width, case.height, case.format) = (360, 280, DepthFormat::F32);
    case.settings = fbptr::truth::Settings {
        transparency: Transparency::AfterOpaque(Default::default()),
        shade: ShadeMode::Phong,
        interpolation: Interpolation::Perspective,
        ..Default::default()
    };
    let mut camera = random_camera(&mut r);
    camera.projection =
        fbptr::scene::Projection::Perspective { fov_rad: 0.5, near: 0.5, far: 50.0, on_smaller_side: false };
    case.scene.camera = Some(camera);
    case.scene.fog = None;
    let mut ball = object("ball", shapes::sphere(1.4).unwrap());
    ball.material.ks = DVec3::splat(r.real(0.0, 0.4));
    ball.material.n = r.pick(&[2.0, 8.0, 40.0]);
    case.scene.objects = vec![ball];
    case
}

#[test]
fn a_sampled_budget_holds_for_the_whole_picture() {
    let mut sampled = 0;
    for seed in [1, 2] {
        let case = large(seed);
        for outcome in keep_to(&case, &[2.0, 6.0, 20.0]) {
            let (found, max_error) = (outcome.quantile(), outcome.max_error);
            assert!(f64::from(found) <= max_error, "{seed} at {max_error}: {found}\n{}", outcome.choice);
            assert!(outcome.errors.len() > LOOK_AT_ALL, "{} pixels", outcome.errors.len());
            sampled += usize::from(outcome.choice.sampled > 0 && outcome.choice.confidence < 1.0);
        }
    }
    assert!(sampled > 0, "some choice rests on a sample");
}

#[test]
fn the_choice_is_the_same_with_any_threads() {
    let case = whole(9001);
    let exact_options = options(&case);
    let budget = budget(&case, &exact_options, 4.0);
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let options = RenderOptions { pool: Some(std::sync::Arc::new(pool)), ..RenderOptions::default() };
        choose(&mut Renderer::new(options), &budget).unwrap()
    };
    assert_eq!(with(1), with(3));
}

/// Returns the 99.9th percentile of the difference of two frames, in steps, over the pixels that
/// either drew on, and the number of these.
fn difference(a: &VideoMemory, b: &VideoMemory) -> (u8, usize) {
    let pairs = a.bytes().chunks_exact(4).zip(b.bytes().chunks_exact(4));
    let drawn = pairs.filter(|(p, q)| p[..3] != [0; 3] || q[..3] != [0; 3]);
    let mut errors: Vec<u8> =
        drawn.map(|(p, q)| (0..3).map(|c| p[c].abs_diff(q[c])).max().unwrap()).collect();
    errors.sort_unstable();
    (errors[((0.999 * errors.len() as f64).ceil() as usize).max(1) - 1], errors.len())
}

#[test]
fn a_stream_draws_within_the_quality_it_asked_for() {
    let picture = |quality: &str, draw: &str| {
        let stream = format!(
            "AMBIENT 0.3 0.3 0.3\nLIGHT 0 DIR -0.3 -0.4 -1 1 0.9 0.8\nLIGHT 1 DIR 1 0 -1 0.004 0.004 0.004\n\
             MATERIAL 0.2 0.2 0.2 0.7 0.5 0.4 0.3 0.3 0.3 9\nMESH m SPHERE 1.3\n{quality}\n{draw}\n"
        );
        // The search may take long on a slow machine; the time limit is not under test here.
        let command_time = std::time::Duration::from_secs(3600);
        let limits = fbptr::server::Limits { command_time, ..Default::default() };
        let engine = fbptr::server::Engine::with_limits(160, 120, limits).unwrap();
        let thread = fbptr::server::RenderThread::start(engine).unwrap();
        let client = thread.client();
        let mut decoder = Vec::new();
        fbptr_commands(&stream, &mut decoder);
        decoder.into_iter().for_each(|c| client.send(c));
        let frame = client.snapshot().unwrap();
        assert_eq!(client.errors(), []);
        drop(client);
        thread.finish(fbptr::server::Finish::Now);
        frame
    };
    let exact = picture("QUALITY exact", "DRAW m");
    for (quality, max_error, may_be_equal) in [
        ("QUALITY max-error 0", 0, true),
        ("QUALITY max-error 2", 2, true),
        ("QUALITY max-error 30", 30, false),
    ] {
        let (found, pixels) = difference(&exact, &picture(quality, "DRAW m"));
        assert!(found <= max_error + 1 && pixels > 1000, "{quality}: {found} on {pixels}");
        assert!(may_be_equal || found > 0, "{quality} changes nothing");
    }
}

/// Appends the commands of a stream.
fn fbptr_commands(stream: &str, commands: &mut Vec<fbptr::command::Command>) {
    struct Keep<'a>(&'a mut Vec<fbptr::command::Command>);
    impl fbptr::command::Sink for Keep<'_> {
        fn pixel(&mut self, _: i32, _: i32, _: [u8; 4]) {}
        fn binary_pixels(&mut self, _: &[u8]) {}
        fn command(
            &mut self,
            command: fbptr::command::Command,
            _: fbptr::command::StreamPosition,
        ) -> fbptr::command::Flow {
            self.0.push(command);
            fbptr::command::Flow::Continue
        }
        fn error(&mut self, error: fbptr::command::StreamError) -> fbptr::command::Flow {
            panic!("{error:?}");
        }
    }
    let mut decoder = fbptr::command::Decoder::new(Default::default());
    let mut keep = Keep(commands);
    let _ = decoder.feed(stream.as_bytes(), &mut keep);
    let _ = decoder.finish(fbptr::command::EndOfInput::Stream, &mut keep);
}

#[test]
fn render_says_what_it_chose_and_why() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/meshes/tinyobjloader");
    let out = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join("budget.ppm");
    let run = |arguments: &[&str]| {
        std::process::Command::new(env!("CARGO_BIN_EXE_fbptr"))
            .args(["render", folder.join("cornell_box.obj").to_str().unwrap(), "-o", out.to_str().unwrap()])
            .args(arguments)
            .output()
            .unwrap()
    };
    let output = run(&["--size", "160x120", "--max-error", "2", "--explain"]);
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(output.status.success() && text.contains("budget: at most 2 steps"), "{text}");
    for part in ["tried", "chosen", "cost", "sample"] {
        assert!(text.contains(&format!("  {part} ")), "{part}: {text}");
    }
    let output = run(&["--max-error", "-1"]);
    assert_eq!(output.status.code(), Some(2));
}
