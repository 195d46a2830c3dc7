//! Right is: errors by another comparison, of another truth; pixels that are missing; the front and
//! the recommendation of figures that are given; each with a case that must fail.

use super::super::clock::Timing;
use super::*;
use fbptr_core::eye::Rotation;
use fbptr_core::scene::{Camera, Light};
use fbptr_truth::compare::color_error;
use fbptr_truth::scenes::{lit_triangle, object};
use glam::DVec3;

const SIZE: [u32; 2] = [80, 60];

/// Returns a ball under a light that is seen by the default camera.
fn ball() -> Scene {
    let mut ball = object("ball", fbptr_core::scene::shapes::sphere(0.8).unwrap());
    ball.material.kd = DVec3::new(0.7, 0.6, 0.5);
    let light = Light::directional(DVec3::new(-0.3, -0.4, -1.0), DVec3::ONE);
    Scene { camera: Some(Camera::default()), lights: vec![light], objects: vec![ball], ..Scene::default() }
}

fn question(scene: Scene, budgets: &[MaxError]) -> Question<'static> {
    let (shade, order) = (ShadeMode::Phong, TransparencyOrder::default());
    Question {
        name: "picture".into(),
        subject: Subject::Solid { scene: Box::new(scene), shade, order },
        size: SIZE,
        budgets: budgets.into(),
        limit: USUAL_LIMIT,
        command: &|setting| Some(format!("draw {}", setting.name())),
    }
}

fn decided(scene: Scene, budgets: &[MaxError]) -> Decision {
    decide(&Effort::QUICK.untimed(), question(scene, budgets)).unwrap()
}

fn case(scene: &Scene) -> Case {
    let settings =
        Settings { transparency: Transparency::AfterOpaque(Default::default()), ..Settings::default() };
    let [width, height] = SIZE;
    Case { name: "picture".into(), scene: scene.clone(), settings, format: Default::default(), width, height }
}

/// Returns the errors of a picture by the reference at every pixel, and the pixels in which it is
/// drawn on and the picture is not, or the reverse.
fn by_reference(case: &Case, found: &Found) -> (f64, usize) {
    let exact = super::super::picture::truth(case);
    let pixels = found.drawn.len();
    let is_drawn = |i: usize| {
        let [x, y] = [i as u32 % case.width, i as u32 / case.width];
        exact.states(x, y).iter().any(|s| s.drawn.is_some())
    };
    let error = |i: usize| color_error(&exact, i, std::array::from_fn(|c| found.bytes[4 * i + c]));
    let largest = (0..pixels).filter(|i| is_drawn(*i)).map(error).max().unwrap();
    (f64::from(largest), (0..pixels).filter(|i| is_drawn(*i) != found.drawn[*i]).count())
}

#[test]
fn errors_are_those_of_the_reference_at_every_pixel() {
    let scene = ball();
    let decision = decided(scene.clone(), &[]);
    let names: Vec<&str> = decision.rows().iter().map(|r| r.alternative.as_str()).collect();
    assert_eq!(names, ["exact", "gouraud", "flat"]);
    let case = case(&scene);
    for (row, shade) in decision.rows().iter().zip([ShadeMode::Phong, ShadeMode::Gouraud, ShadeMode::Flat]) {
        let options = SceneOptions { shade, ..scene_options(&case).unwrap() };
        let found = Found::draw(&mut Renderer::default(), &scene, &options, &case).unwrap();
        let (largest, coverage) = by_reference(&case, &found);
        // The plain path is within half a step of the reference, on each side of a rounding.
        assert!(
            (row.errors[LARGEST] - largest).abs() <= 1.0,
            "{}: {:?} {largest}",
            row.alternative,
            row.errors
        );
        assert_eq!(row.errors[COVERAGE], coverage as f64, "{}", row.alternative);
        assert_eq!(coverage, 0);
    }
    assert!(decision.rows()[0].errors[LARGEST] <= 1.0 && decision.rows()[2].errors[LARGEST] >= 3.0);
    assert!(decision.section.check.is_right() && decision.rows()[0].is_within_bounds());
}

/// The control: a picture without one face is compared with that of all faces.
#[test]
fn missing_pixels_count_as_coverage_and_as_errors() {
    let whole = ball();
    let case = case(&whole);
    let mut right = RightPicture::new(&case).unwrap();
    let options = scene_options(&case).unwrap();
    let draw = |scene: &Scene| Found::draw(&mut Renderer::default(), scene, &options, &case).unwrap();
    right.decide(&case, &draw(&whole), 1.0).unwrap();
    assert_eq!(right.errors(&draw(&whole))[COVERAGE], 0.0);
    let mut lacking = whole.clone();
    let geometry = std::sync::Arc::make_mut(&mut lacking.objects[0].geometry);
    let mut kept = geometry.mesh.clone();
    kept.triangles.truncate(geometry.mesh.triangles.len() / 2);
    geometry.mesh = kept;
    let found = draw(&lacking);
    let (largest, coverage) = by_reference(&case, &found);
    assert!(coverage > 100, "{coverage}");
    let errors = right.errors(&found);
    assert_eq!(errors[COVERAGE], coverage as f64);
    assert!(errors[PERCENTILE] > 50.0 && (errors[LARGEST] - largest).abs() <= 1.0, "{errors:?} {largest}");
    // And the other way: what is drawn beyond the right picture.
    let mut right = RightPicture::new(&Case { scene: lacking.clone(), ..case.clone() }).unwrap();
    right.decide(&Case { scene: lacking, ..case.clone() }, &found, 1.0).unwrap();
    assert_eq!(right.errors(&draw(&whole))[COVERAGE], coverage as f64);
}

#[test]
fn what_does_the_same_work_as_exact_is_named_and_not_drawn() {
    let mut scene = ball();
    scene.objects[0].shade = Some(ShadeMode::Flat);
    let decision = decided(scene, &[0.5, 4.0].map(MaxError::from));
    let rows: Vec<&str> = decision.rows().iter().map(|r| r.alternative.as_str()).collect();
    assert_eq!(rows, ["exact"]);
    let same: Vec<(&str, &str)> =
        decision.same_work.iter().map(|s| (s.setting.as_str(), s.of.as_str())).collect();
    assert_eq!(same[..2], [("max-error 0.5", "exact"), ("max-error 4", "exact")]);
    assert_eq!(same[2..], [("gouraud", "exact"), ("flat", "exact")]);
    // The control: lights that add too little are left out, which is other work.
    let mut scene = ball();
    let dim = || Light::directional(DVec3::NEG_Z, DVec3::splat(1e-4));
    scene.lights.extend((0..6).map(|_| dim()));
    let (ways, same) =
        prepare(&Case { width: 640, height: 480, ..case(&scene) }, &[0.5, 4.0].map(MaxError::from));
    assert!(ways.iter().any(|way| way.setting == Setting::Within(MaxError::from(4.0))));
    assert_eq!(same, [SameWork { setting: "max-error 0.5".into(), of: "exact".into() }]);
}

#[test]
fn nothing_to_see_is_an_error_with_its_reason() {
    let mut away = ball();
    away.objects[0].model = glam::DMat4::from_translation(DVec3::new(0.0, 0.0, 900.0));
    let error = decide(&Effort::QUICK.untimed(), question(away, &[])).unwrap_err();
    assert!(error.to_string().contains("the picture is empty: all of it lies behind the eye"), "{error}");
    let error = decide(&Effort::QUICK.untimed(), question(Scene::default(), &[])).unwrap_err();
    assert!(error.to_string().contains("there are no faces"), "{error}");
}

/// Returns a decision of rows with errors and times that are given: percentile, coverage, seconds.
fn given(rows: &[(Setting, [f64; 3])]) -> Decision {
    let row = |&(setting, [percentile, coverage, seconds]): &(Setting, [f64; 3])| {
        let mut row = Row::not_run("picture".into(), setting.name(), 3);
        (row.is_run, row.errors) = (true, vec![percentile, percentile, coverage]);
        row.standing = if setting == Setting::Exact { Standing::Default } else { Standing::Mode };
        let rounds: Vec<f64> = (0..40).map(|k| seconds * if k % 2 == 0 { 1.0 } else { 1.5 }).collect();
        row.timed(Some(Timing::of(&rounds, 1)), 1.0)
    };
    let section = Section {
        experiment: DECISION,
        rows: rows.iter().map(row).collect(),
        check: Check { difference: 0.0, at_most: 0.0 },
    };
    let settings = rows.iter().map(|r| r.0).collect();
    Decision::new(&question(lit_triangle(), &[]), section, settings, Vec::new(), Vec::new())
}

#[test]
fn the_front_and_the_recommendation_rest_on_figures() {
    let (gouraud, flat) = (Setting::Shade(ShadeMode::Gouraud), Setting::Shade(ShadeMode::Flat));
    let exact = (Setting::Exact, [1.0, 0.0, 1.0]);
    let rows = [
        exact,
        (Setting::Within(MaxError::from(1.0)), [1.0, 0.0, 0.99]),
        (Setting::Within(MaxError::from(4.0)), [3.0, 0.0, 0.72]),
        (gouraud, [3.0, 0.0, 0.70]),
        (flat, [40.0, 0.0, 0.5]),
        (Setting::Affine, [2.0, 7.0, 0.4]),
    ];
    let decision = given(&rows);
    // A promise goes before what is measured and hardly faster; pixels may not be missing.
    assert_eq!(
        decision.recommended().map(|i| decision.settings[i]),
        Some(Setting::Within(MaxError::from(4.0)))
    );
    let sentence = decision.recommendation().unwrap();
    assert!(
        sentence.contains("1.39 times as fast") && sentence.ends_with("`draw max-error 4`"),
        "{sentence}"
    );
    assert!(decision.is_idle(&decision.rows()[1]) && decision.idle().unwrap().contains("max-error 1 has"));
    let on_front = |d: &Decision| -> Vec<String> {
        d.rows().iter().filter(|r| d.is_on_front(r)).map(|r| r.alternative.clone()).collect()
    };
    assert_eq!(on_front(&decision), ["exact", "max-error 1", "affine"]);
    assert_eq!(on_front(&given(&rows[..5])), ["exact", "max-error 1", "max-error 4", "gouraud", "flat"]);
    // The control: within one step nothing is faster.
    let strict = Decision { limit: 1.0, ..decision.clone() };
    assert_eq!(strict.recommended(), Some(0));
    assert!(strict.recommendation().unwrap().ends_with("`draw exact`"));
    let untimed = decided(ball(), &[]);
    assert_eq!((untimed.recommended(), untimed.recommendation()), (None, None));
}

#[test]
fn an_eye_that_is_turned_sees_its_scene_turned() {
    let scene = super::super::eye::two_tesseracts([24, 18]);
    let scene = scene.turned(&[Rotation { a: 1, b: 3, angle_deg: 20.0 }]).unwrap();
    let question =
        Question { subject: Subject::Eye(&scene), size: [24, 18], ..question(Scene::default(), &[]) };
    let decision = decide(&Effort::QUICK.untimed(), question).unwrap();
    let exact = &decision.rows()[0];
    assert!(exact.errors[LARGEST] < 1e-6 && exact.errors[COVERAGE] == 0.0, "{:?}", exact.errors);
    assert!(decision.rows()[1].errors[COVERAGE] > 0.0, "a fan of three rays misses something");
    assert!(decision.notes.iter().any(|note| note.contains("turned in the eye's place")));
}

#[test]
fn a_streams_budget_comes_after_its_size() {
    let drawing = "MESH m TEAPOT\nDRAW m\n";
    let stream = format!("# a comment\nSIZE 80 60\nCLEAR 000000\n{drawing}");
    assert_eq!([quality_line(stream.as_bytes()), quality_line(drawing.as_bytes())], [2, 0]);
    let picture = "SIZE 80 60\nCLEAR 102030\nFILLRECT 10 10 20 5 red\nPRESENT\nPRESENT\n";
    let subject = || Subject::Stream { bytes: picture.as_bytes(), load_dir: None };
    let decision = decide(
        &Effort::QUICK.untimed(),
        Question { subject: subject(), ..question(Scene::default(), &[MaxError::from(4.0)]) },
    );
    let decision = decision.unwrap();
    assert_eq!((decision.rows().len(), decision.rows()[0].errors[COVERAGE]), (1, 0.0));
    assert_eq!(decision.same_work[0].of, "exact");
    let refused = Subject::Stream { bytes: b"LINE 1\n", load_dir: None };
    let error =
        decide(&Effort::QUICK.untimed(), Question { subject: refused, ..question(Scene::default(), &[]) });
    assert!(matches!(error, Err(DecideError::Stream(line)) if line.contains(":1")));
}
