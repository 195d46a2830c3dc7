//! Error budgets: a cheaper picture must not be further from the truth than was asked.
//!
//! Scenes that nothing was tuned on, drawn with the settings that the budget chooses, are compared
//! pixel by pixel with the reference: the 99.9th percentile of the colour error over the pixels drawn
//! on stays within E; coverage and depth equal those of the exact picture.

use fbptr::memory::{DepthFormat, DepthMemory, VideoMemory};
use fbptr::pipeline::quality::{Budget, Choice, MeshShapes, prove};
use fbptr::pipeline::{RenderOptions, Renderer, SceneOptions, Target};
use fbptr::scene::{Light, Scene, ShadeMode, Viewport, ViewportRule, shapes};
use fbptr::truth::compare::color_error;
use fbptr::truth::scenes::{Case, Random, object, random, random_camera};
use fbptr::truth::{Transparency, TruthPicture, render};
use glam::DVec3;

/// The values of E that are asked for.
const LIMITS: [f64; 7] = [1.0, 2.0, 4.0, 8.0, 16.0, 40.0, 100.0];

struct Outcome {
    max_error: f64,
    choice: Choice,
    /// Errors of the pixels drawn on, in ascending order.
    errors: Vec<u8>,
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

/// Returns the picture of a choice beside the truth.
fn outcome(case: &Case, truth: &TruthPicture, exact_depth: &[u32], choice: Choice) -> Outcome {
    let mut scene = case.scene.clone();
    choice.apply(&mut scene);
    let (memory, depth) = frame(&scene, &options(case), case);
    assert!(
        words(&depth, case) == exact_depth,
        "{}: coverage and depth are not touched\n{choice}",
        case.name
    );
    let mut errors = Vec::new();
    for i in 0..memory.bytes().len() / 4 {
        let (x, y) = (i as u32 % case.width, i as u32 / case.width);
        if truth.states(x, y).iter().any(|s| s.drawn.is_some()) {
            errors.push(color_error(truth, i, std::array::from_fn(|c| memory.bytes()[4 * i + c])));
        }
    }
    errors.sort_unstable();
    Outcome { max_error: choice.max_error.steps, choice, errors }
}

fn words(depth: &Option<DepthMemory>, case: &Case) -> Vec<u32> {
    let pixels = (case.width * case.height) as usize;
    depth.iter().flat_map(|d| (0..pixels).map(|i| d.word(i))).collect()
}

/// Returns the choice for a case whose meshes were drawn before.
fn choice(case: &Case, max_error: f64) -> Choice {
    let options = options(case);
    prove(
        &Budget { scene: &case.scene, options: &options, max_error: max_error.into() },
        &mut MeshShapes::at_once(),
    )
}

/// Draws a case with the settings that are chosen for each E.
fn keep_to(case: &Case, limits: &[f64]) -> Vec<Outcome> {
    let (_, exact_depth) = frame(&case.scene, &options(case), case);
    let exact_depth = words(&exact_depth, case);
    let truth = render(&case.scene, case.width, case.height, case.format, &case.settings).unwrap();
    limits.iter().map(|e| outcome(case, &truth, &exact_depth, choice(case, *e))).collect()
}

fn check(outcome: &Outcome, name: &str) {
    let (found, max_error) = (outcome.quantile(), outcome.max_error);
    assert!(f64::from(found) <= max_error, "{name} at {max_error}: {found}\n{}", outcome.choice);
}

/// Returns a scene of a smooth mesh of few faces under a few lights, so that cheaper shading pays.
fn large(seed: u64) -> Case {
    let mut r = Random::new(seed);
    let mut case = random(seed);
    (case.width, case.height, case.format) = (240, 180, DepthFormat::F32);
    case.settings = fbptr::truth::Settings {
        transparency: Transparency::AfterOpaque(Default::default()),
        shade: ShadeMode::Phong,
        ..Default::default()
    };
    let mut camera = random_camera(&mut r);
    camera.projection =
        fbptr::scene::Projection::Perspective { fov_rad: 0.5, near: 0.5, far: 50.0, on_smaller_side: false };
    case.scene.camera = Some(camera);
    case.scene.fog = None;
    let light = |r: &mut Random| match r.one_in(3) {
        true => Light::point(r.point(-9.0, 9.0), r.point(0.0, 0.8)),
        false => Light::directional(r.point(-1.0, 1.0), r.point(0.0, 0.8)),
    };
    case.scene.lights = (0..3).map(|_| light(&mut r)).collect();
    let dim = |_| Light::directional(DVec3::NEG_Z, DVec3::splat(0.004));
    case.scene.lights.extend((0..5).map(dim));
    let mesh = if seed.is_multiple_of(2) { shapes::teapot(4) } else { shapes::cuboid(DVec3::ONE) };
    let mut thing = object("thing", mesh.unwrap());
    if seed.is_multiple_of(3) {
        thing.material.ks = DVec3::splat(r.real(0.0, 0.4));
        thing.material.n = r.pick(&[2.0, 8.0, 40.0]);
    }
    case.scene.objects = vec![thing];
    case
}

#[test]
fn what_pays_holds_for_the_whole_picture() {
    let (mut modes, mut lights) = (0, 0);
    for seed in 1..17 {
        let case = large(seed);
        for outcome in keep_to(&case, &LIMITS) {
            check(&outcome, &format!("seed {seed}"));
            modes += usize::from(outcome.choice.settings[0].shade.is_some());
            lights += usize::from(outcome.choice.settings[0].lights.is_some());
        }
    }
    assert!(modes > 0 && lights > 0, "{modes} other modes, {lights} times fewer lights");
}

#[test]
fn the_cheaper_picture_is_the_same_with_any_threads_and_vectors() {
    let mut cheaper = 0;
    for case in (1..5).map(large) {
        let choice = choice(&case, 100.0);
        let mut scene = case.scene.clone();
        choice.apply(&mut scene);
        let with = |threads: usize, simd| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let pool = Some(std::sync::Arc::new(pool));
            let mut memory = VideoMemory::new(case.width, case.height).unwrap();
            let mut target =
                Target { memory: &mut memory, depth: &mut None, depth_format: case.format, ids: None };
            let mut renderer = Renderer::new(RenderOptions { pool, simd, ..RenderOptions::default() });
            renderer.draw_scene(&mut target, &scene, &options(&case)).unwrap();
            memory
        };
        let first = with(1, None);
        cheaper += usize::from(!choice.is_exact());
        assert!(with(3, None).bytes() == first.bytes(), "{choice}");
        for level in fbptr::simd::Level::ALL.into_iter().filter(|level| level.is_available()) {
            assert!(with(1, Some(level)).bytes() == first.bytes(), "{level:?}\n{choice}");
        }
    }
    assert!(cheaper > 0, "{cheaper} are cheaper");
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
        // From the second draw of a mesh on, what is proven for it pays.
        let stream = format!(
            "AMBIENT 0.3 0.3 0.3\nLIGHT 0 DIR -0.3 -0.4 -1 1 0.9 0.8\nLIGHT 1 DIR 1 0 -1 0.004 0.004 0.004\n\
             MATERIAL 0.2 0.2 0.2 0.7 0.5 0.4 0 0 0 9\nMESH m TEAPOT 4\n{quality}\n{draw}\nCLEAR 000000\n{draw}\n"
        );
        // The time limit of a slow machine is not under test here.
        let command_time = std::time::Duration::from_secs(3600);
        let limits = fbptr::server::Limits { command_time, ..Default::default() };
        let engine = fbptr::server::Engine::with_limits(320, 240, limits).unwrap();
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
        ("QUALITY max-error 200", 200, false),
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
    for part in ["chosen", "cost"] {
        assert!(text.contains(&format!("  {part} ")), "{part}: {text}");
    }
    let output = run(&["--max-error", "-1"]);
    assert_eq!(output.status.code(), Some(2));
}
