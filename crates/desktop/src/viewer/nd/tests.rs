//! Turning, selecting planes, and the JSON of the view.

use super::*;
use fbptr_core::executor::Executor;
use fbptr_core::eye::shapes::{DemoScene, cube};

fn tesseract() -> Nd {
    let demo = DemoScene { pixels: vec![24, 18], aperture_tan: 0.3, turns: vec![(0, 1, 20.0), (1, 3, 30.0)] };
    Nd::new(demo.scene(cube(4).expect("a cube")).expect("a scene"), Executor::default(), false)
}

#[test]
fn turning_about_the_middle_keeps_it_where_it_is_seen() {
    let mut nd = tesseract();
    let place = |nd: &Nd| -> Vec<f64> {
        let away: Vec<f64> = nd.middle.iter().zip(&nd.pose.position).map(|(m, o)| m - o).collect();
        let along = |axis: &Vec<f64>| axis.iter().zip(&away).map(|(x, y)| x * y).sum();
        nd.pose.axes().iter().map(along).collect()
    };
    let before = place(&nd);
    for (a, b) in [(0, 3), (1, 3), (0, 1), (2, 3), (0, 2)] {
        nd.turn(a, b, 3.0);
        let after = place(&nd);
        assert!(before.iter().zip(&after).all(|(x, y)| (x - y).abs() < 1e-12), "{a}-{b}: {after:?}");
    }
}

#[test]
fn every_plane_can_be_chosen_and_turns_the_eye() {
    let mut nd = tesseract();
    nd.about = About::Eye;
    let mut seen = Vec::new();
    for _ in 0..6 {
        let before = nd.pose.axes();
        nd.turn_plane(1.0);
        assert_ne!(nd.pose.axes(), before, "{:?}", nd.plane());
        seen.push(nd.plane());
        nd.next_plane(1);
    }
    seen.sort();
    assert_eq!(seen, [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]]);
    nd.next_plane(-1);
    nd.reset();
    assert_eq!(nd.pose, nd.given.pose);
}

#[test]
fn what_the_json_says_is_what_was_seen() {
    let mut nd = tesseract();
    nd.turn(0, 3, 1.0);
    nd.walk(3, 1.0);
    nd.walk(0, -2.0);
    nd.turn_by(1, 2, 0.7321);
    nd.toggle_slice();
    let mut frame = ViewerFrame::new([48, 36]).expect("small");
    let wishes = Wishes::default();
    nd.draw(&wishes, &mut frame).expect("drawn");
    let text = nd.scene().to_value().to_string();
    let again = eye::render(&EyeScene::from_json(text.as_bytes()).expect("a scene"));
    let mut other = ViewerFrame::new([48, 36]).expect("small");
    paint(&again, &mut other);
    assert!(frame.memory.bytes() == other.memory.bytes());
    assert_eq!(nd.picture.expect("a picture").to_json(), again.to_json());
}

#[test]
fn long_lines_are_parted_after_commas_and_keep_every_word() {
    let line = "facets     ".to_owned() + &["a good many degenerate"; 7].join(", ");
    let parts = folded(&line);
    assert!(parts.len() > 1 && parts.iter().all(|p| p.len() <= 74), "{parts:?}");
    let words = |text: &str| text.split_whitespace().map(str::to_owned).collect::<Vec<_>>();
    assert_eq!(words(&parts.join(" ")), words(&line));
    assert_eq!(folded(&"x".repeat(100)).len(), 1);
}

#[test]
fn steps_read_well() {
    assert_eq!([0.0, 0.013, 0.3, 0.76, 40.0].map(round_step), [0.1, 0.01, 0.2, 1.0, 50.0]);
}
