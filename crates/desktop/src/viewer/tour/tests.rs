use super::super::{Key, Model, ViewerOptions};
use super::script::PICTURE;
use super::*;
use fbptr_core::executor::Executor;
use fbptr_core::pipeline::Renderer;
use std::time::Duration;

fn engines() -> MakeSizedEngine {
    Arc::new(|[width, height]| Engine::new(width, height).map_err(|e| e.to_string()))
}

fn tour_viewer() -> Viewer {
    let options = ViewerOptions {
        name: "tour".to_owned(),
        size: SIZE,
        time: 0.0,
        fps: FRAMES_PER_SECOND,
        cull: None,
        point_size: None,
        studio: false,
        turntable: false,
        split: None,
        renderer: Renderer::default(),
        pool: Executor::default(),
    };
    Viewer::new(Model::Tour(engines()), options).expect("a tour")
}

fn press(viewer: &mut Viewer, key: Key) {
    assert_eq!(viewer.key(key, true), None);
    viewer.key(key, false);
    viewer.refresh();
    assert_eq!(viewer.failure(), None);
}

fn step_of(viewer: &Viewer) -> usize {
    let Subject::Tour(tour) = &viewer.subject else { panic!("a tour") };
    tour.locate(viewer.wishes.frame).0
}

#[test]
fn every_step_plays_without_an_error_and_draws() {
    let mut tour = Tour::new(engines()).expect("the script");
    assert!((20..=30).contains(&tour.steps.len()));
    let mut frame = VideoMemory::new(SIZE[0], SIZE[1]).expect("small");
    for number in 0..tour.steps.len() {
        // All frames of a step, or some of those that repeat the same commands.
        let step = &tour.steps[number];
        let motion = if step.presents_at(u64::MAX) > 80 { 3 } else { step.motion() };
        let wishes = Wishes { frame: tour.first_frame(number) + motion - 1, ..Wishes::default() };
        assert_eq!(tour.draw(&wishes, &mut frame), Ok(()));
        let (_, playing) = tour.playing.as_ref().expect("a step");
        let colors: std::collections::HashSet<&[u8]> = playing.memory().bytes().chunks(4).collect();
        assert!(colors.len() > 1, "step {} is one colour", number + 1);
        let step = &tour.steps[number];
        assert!(!step.title.is_empty() && (1..=2).contains(&step.caption.len()), "{}", step.title);
        let widest = step.caption.iter().map(|line| line.chars().count()).max().unwrap_or(0);
        assert!(widest * 8 <= PICTURE[0] as usize, "{}: a caption of {widest} letters", step.title);
    }
    assert_eq!(tour.locate(tour.last_frame()).0, tour.steps.len() - 1);
    assert_eq!(tour.locate(u64::MAX).0, tour.steps.len() - 1);
}

#[test]
fn a_page_holds_the_picture_that_its_commands_draw() {
    let mut viewer = tour_viewer();
    // Goes on twice, back once, and on by single frames into an animation.
    for (key, expected) in [(Key::Right, 1), (Key::Right, 2), (Key::Left, 1), (Key::Left, 0), (Key::Left, 0)]
    {
        press(&mut viewer, key);
        assert_eq!(step_of(&viewer), expected);
        let Subject::Tour(tour) = &viewer.subject else { panic!("a tour") };
        let [width, height] = tour.steps[expected].size;
        let factor = (PICTURE[0] / width) as i32;
        let mut playing = Playing::new(
            &tour.steps[expected].stream,
            &(Arc::new(move || Engine::new(width, height).map_err(|e| e.to_string())) as MakeEngine),
            Wishes::default().view_overrides(),
            RenderPath::Plain,
        )
        .expect("an engine");
        playing.play_to(&tour.steps[expected].stream, 1);
        for (x, y) in
            (0..PICTURE[0] as i32).flat_map(|x| (0..PICTURE[1] as i32).step_by(7).map(move |y| (x, y)))
        {
            let shown = viewer.shown().get_pixel(16 + x, 16 + y);
            assert_eq!(shown, playing.memory().get_pixel(x / factor, y / factor), "{x} {y}");
        }
    }
}

#[test]
fn time_leads_through_all_steps_and_ends_at_the_last() {
    let mut viewer = tour_viewer();
    let Subject::Tour(tour) = &viewer.subject else { panic!("a tour") };
    let (frames, steps) = (tour.last_frame(), tour.steps.len());
    let first = viewer.shown().bytes().to_vec();
    (0..155).for_each(|_| viewer.advance(Duration::from_millis(20)));
    assert!(viewer.refresh());
    assert_eq!(step_of(&viewer), 1);
    // On a machine that is too slow no picture is left out by more than a few frames.
    let before = viewer.wishes.frame;
    viewer.advance(Duration::from_secs(5));
    assert!((1..10).contains(&(viewer.wishes.frame - before)));
    viewer.go_to(frames - 1);
    (0..9).for_each(|_| viewer.advance(Duration::from_millis(20)));
    viewer.refresh();
    assert_eq!((viewer.wishes.frame, step_of(&viewer)), (frames, steps - 1));
    assert!(first != viewer.shown().bytes());
    // Space stops time, R starts again.
    press(&mut viewer, Key::R);
    assert!(first == viewer.shown().bytes());
    press(&mut viewer, Key::Space);
    viewer.advance(Duration::from_secs(9));
    assert_eq!(viewer.wishes.frame, 0);
}

#[test]
fn keys_without_a_meaning_change_nothing_and_help_names_those_that_have_one() {
    let mut viewer = tour_viewer();
    let before = viewer.shown().bytes().to_vec();
    for key in
        [Key::One, Key::P, Key::C, Key::H, Key::Z, Key::E, Key::B, Key::J, Key::Up, Key::Tab, Key::Equal]
    {
        press(&mut viewer, key);
        assert!(viewer.shown().bytes() == before, "{key:?}");
    }
    assert!(viewer.overlay().list.is_empty());
    viewer.key(Key::F1, true);
    let lines = viewer.overlay().list;
    assert!(lines.iter().any(|line| line.starts_with("Right")) && lines.iter().all(|line| line.len() <= 36));
}

#[test]
fn an_animation_is_the_same_forwards_and_by_single_frames_back() {
    let mut viewer = tour_viewer();
    let Subject::Tour(tour) = &viewer.subject else { panic!("a tour") };
    let animated =
        (0..tour.steps.len()).find(|&i| tour.steps[i].presents_at(u64::MAX) > 20).expect("an animation");
    let first = tour.first_frame(animated);
    viewer.go_to(first + 3);
    viewer.refresh();
    let third = viewer.shown().bytes().to_vec();
    press(&mut viewer, Key::Period);
    assert!(viewer.shown().bytes() != third);
    press(&mut viewer, Key::Comma);
    assert!(viewer.shown().bytes() == third);
}

#[test]
fn a_movie_shows_every_step_for_the_same_time() {
    let tour = Tour::new(engines()).expect("the script");
    let frames = tour.movie_frames();
    assert!(frames.is_sorted() && frames.len() == tour.steps.len() * MOVIE_STEP);
    for (i, of_step) in frames.chunks(MOVIE_STEP).enumerate() {
        assert!(of_step.iter().all(|&frame| tour.locate(frame).0 == i), "{}", tour.steps[i].title);
        let pages: std::collections::BTreeSet<u64> = of_step.iter().copied().collect();
        let step = &tour.steps[i];
        assert_eq!(pages.len() as u64, MOVIE_MOTION.min(step.motion()));
        if step.hold() > MOVIE_STRIDE {
            let shown = step.presents_at(of_step[MOVIE_STEP - 1] - tour.first_frame(i));
            assert_eq!(shown, step.presents_at(u64::MAX), "{}: not shown to its end", step.title);
        }
    }
}

#[test]
fn an_invalid_script_is_refused() {
    let refused = |script: &[u8]| Tour::of_script(script, engines()).err().expect("an error");
    assert!(refused(b"").contains("without a step"));
    assert!(refused(b"PX 0 0 red\n").starts_with("line 1"));
    let mut tour = Tour::of_script(b"#= a\nNONSENSE\n", engines()).expect("a step");
    let mut frame = VideoMemory::new(SIZE[0], SIZE[1]).expect("small");
    let error = tour.draw(&Wishes::default(), &mut frame).expect_err("no such verb");
    assert!(error.contains("step 1") && error.contains("EVERB"), "{error}");
}
