//! The studio: framing, ground, turntable and smoothing, by keys.

use super::*;
use crate::viewer::studio::FILL;

fn studio_viewer(geometry: Arc<Geometry>, size: [u32; 2], turntable: bool) -> Viewer {
    let options = ViewerOptions { size, studio: true, turntable, ..options("studio") };
    Viewer::new(closed(geometry), options).expect("a viewer")
}

/// The box of the pixels that the model covers: width and height as parts of the frame's.
fn drawn_part(viewer: &mut Viewer) -> [f64; 2] {
    tap(viewer, Key::Z);
    viewer.refresh();
    let depth = viewer.frame.depth.as_ref().expect("kept");
    let (w, h) = (viewer.frame.memory.width() as i32, viewer.frame.memory.height() as i32);
    let [mut l, mut r, mut t, mut b] = [w, -1, h, -1];
    for (x, y) in (0..h).flat_map(|y| (0..w).map(move |x| (x, y))) {
        if depth.z(x, y).is_some_and(|z| z < 1.0) {
            [l, r, t, b] = [l.min(x), r.max(x), t.min(y), b.max(y)];
        }
    }
    tap(viewer, Key::Z);
    [f64::from(r - l + 1) / f64::from(w), f64::from(b - t + 1) / f64::from(h)]
}

#[test]
fn a_model_fills_four_fifths_of_the_frame() {
    let suzanne =
        concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/data/meshes/suzanne-sphere/monkey_head2.obj");
    let bytes = std::fs::read(suzanne).expect("a mesh");
    let suzanne = load::obj::parse(&bytes, &mut |_| None, "suzanne").expect("a mesh");
    let knot = Geometry { mesh: shapes::knot(90, 12).expect("a knot"), textures: Vec::new() };
    for geometry in [teapot(), Arc::new(knot), Arc::new(suzanne.geometry)] {
        for size in [[240, 180], [150, 200]] {
            let part = drawn_part(&mut studio_viewer(Arc::clone(&geometry), size, false));
            let larger = part[0].max(part[1]);
            assert!((FILL - 0.02..=FILL + 0.02).contains(&larger), "{size:?}: {part:?}");
        }
    }
}

#[test]
fn the_turntable_keeps_the_model_inside_and_comes_round() {
    let mut viewer = studio_viewer(teapot(), [120, 90], true);
    let first = picture(&mut viewer);
    for _ in 0..6 {
        viewer.advance(Duration::from_secs(1));
        let part = drawn_part(&mut viewer);
        assert!(part[0] < 0.9 && part[1] < 0.9, "{part:?}");
        assert!(picture(&mut viewer) != first);
    }
    viewer.advance(Duration::from_secs(6));
    assert!(picture(&mut viewer) == first, "twelve seconds are one turn");
    viewer.advance(Duration::from_secs(2));
    tap(&mut viewer, Key::T);
    let stopped = picture(&mut viewer);
    viewer.advance(Duration::from_secs(2));
    viewer.finish_smoothing();
    tap(&mut viewer, Key::G);
    tap(&mut viewer, Key::G);
    assert!(picture(&mut viewer) == stopped, "T stops it where it is");
    tap(&mut viewer, Key::R);
    assert!(picture(&mut viewer) == first);
}

#[test]
fn g_shows_and_hides_the_ground() {
    let mut viewer = studio_viewer(teapot(), SIZE, false);
    viewer.finish_smoothing();
    let with = picture(&mut viewer);
    tap(&mut viewer, Key::G);
    viewer.finish_smoothing();
    let without = picture(&mut viewer);
    assert!(with != without);
    // The model itself is the same.
    let middle = (36 * 96 + 48) * 4;
    assert_eq!(with[middle..middle + 4], without[middle..middle + 4]);
    tap(&mut viewer, Key::G);
    viewer.finish_smoothing();
    assert!(picture(&mut viewer) == with);
    let mut plain = mesh_viewer();
    let before = picture(&mut plain);
    tap(&mut plain, Key::G);
    assert!(picture(&mut plain) == before, "there is no ground outside the studio");
}

#[test]
fn a_picture_at_rest_becomes_the_mean_of_its_samples_and_a_key_ends_that() {
    let mut viewer = studio_viewer(teapot(), SIZE, false);
    tap(&mut viewer, Key::G);
    let coarse = picture(&mut viewer);
    assert!(viewer.has_more_to_smooth());
    let mut steps = 0;
    while viewer.refresh() {
        steps += 1;
    }
    assert_eq!(steps, 16);
    let smooth = viewer.shown().bytes().to_vec();
    assert!(smooth != coarse && !viewer.has_more_to_smooth());
    // A frame of four times the size has the same samples: their mean is within rounding of it.
    let mut large = studio_viewer(teapot(), SIZE.map(|s| s * 4), false);
    tap(&mut large, Key::G);
    let large_bytes = picture(&mut large);
    let mean = |x: usize, y: usize, c: usize| {
        let at = |i: usize, j: usize| u32::from(large_bytes[((y * 4 + j) * 96 * 4 + x * 4 + i) * 4 + c]);
        (0..16).map(|k| at(k % 4, k / 4)).sum::<u32>() / 16
    };
    let off = |x: usize, y: usize| {
        let shown = |c: usize| u32::from(smooth[(y * 96 + x) * 4 + c]);
        (0..3).map(|c| shown(c).abs_diff(mean(x, y, c))).max().unwrap_or(0)
    };
    let off: Vec<u32> = (0..72).flat_map(|y| (0..96).map(move |x| (x, y))).map(|(x, y)| off(x, y)).collect();
    let far = off.iter().filter(|&&d| d > 24).count();
    assert!(far < 30, "{far} pixels of {} are off the mean of 16 samples", off.len());
    tap(&mut viewer, Key::Left);
    viewer.refresh();
    assert!(viewer.has_more_to_smooth(), "the next picture begins anew");
    tap(&mut viewer, Key::E);
    viewer.wait_for_exact();
    assert!(!viewer.has_more_to_smooth(), "what is compared is not smoothed");
    let overlay = viewer.overlay();
    // Highlights are left out where they cannot reach a quarter of a step: a byte may be rounded otherwise.
    let is_near = |l: &String| l.starts_with("no pixel differs") || l.contains(", by 1 at most");
    assert!(overlay.bottom.iter().any(is_near), "{overlay:?}");
}

#[test]
fn v_compares_two_modes_and_comes_round() {
    let mut viewer = studio_viewer(teapot(), [240, 180], false);
    viewer.finish_smoothing();
    let whole = picture(&mut viewer);
    let mut seen = vec![whole.clone()];
    for split in [Split::Shading, Split::Path, Split::Depth] {
        tap(&mut viewer, Key::V);
        assert_eq!(viewer.split, Some(split));
        assert_eq!(viewer.overlay().captions.len(), 4);
        let now = picture(&mut viewer);
        assert!(!seen.contains(&now) && !viewer.has_more_to_smooth(), "{split:?}");
        // Below the left picture is the difference: somewhere, and black around.
        let [w, h] = [96, 54];
        let lit = |x0: usize, y0: usize| {
            let pixel = |x: usize, y: usize| &now[(y * 240 + x) * 4..][..3];
            let all = (y0..y0 + h).flat_map(|y| (x0..x0 + w).map(move |x| (x, y)));
            all.filter(|&(x, y)| pixel(x, y) != [0; 3]).count()
        };
        let differing = lit(16, 16 + 24 + 46);
        assert!(differing < w * h / 2, "{split:?}: {differing}");
        assert!(split == Split::Path || differing > 0, "{split:?} shows no difference");
        seen.push(now);
    }
    tap(&mut viewer, Key::V);
    viewer.finish_smoothing();
    assert!(picture(&mut viewer) == whole && viewer.overlay().captions.is_empty());
    tap(&mut viewer, Key::V);
    tap(&mut viewer, Key::Z);
    assert_eq!(viewer.split, None, "the depth is that of one picture");
}

#[test]
fn a_polytope_turns_beside_slice_and_shadow_until_a_key_is_pressed() {
    let turns = vec![(0, 1, 20.0), (1, 3, 30.0), (0, 2, 15.0)];
    let demo = DemoScene { pixels: vec![48, 36], aperture_tan: 0.3, turns };
    let scene = demo.scene(cube(4).expect("a cube")).expect("a scene");
    let options = ViewerOptions { size: [192, 168], studio: true, ..options("tesseract") };
    let mut viewer = Viewer::new(Model::Eye(Box::new(scene)), options).expect("a viewer");
    let first = picture(&mut viewer);
    viewer.advance(Duration::from_millis(400));
    let turned = picture(&mut viewer);
    assert!(first != turned, "it turns by itself");
    tap(&mut viewer, Key::Tab);
    viewer.advance(Duration::from_secs(1));
    viewer.refresh();
    let stopped = picture(&mut viewer);
    viewer.advance(Duration::from_secs(1));
    assert!(picture(&mut viewer) == stopped, "a key stops it");
    tap(&mut viewer, Key::Space);
    viewer.advance(Duration::from_secs(1));
    assert!(picture(&mut viewer) != stopped, "Space lets it turn on");
    tap(&mut viewer, Key::V);
    let alone = picture(&mut viewer);
    assert!(viewer.overlay().captions.is_empty());
    tap(&mut viewer, Key::V);
    let gallery = picture(&mut viewer);
    assert_eq!(viewer.overlay().captions.len(), 3);
    assert!(alone != gallery);
    // The eye's looks are seen in its picture alone; 0 returns to the gallery.
    tap(&mut viewer, Key::Two);
    assert!(![alone, gallery.clone()].contains(&picture(&mut viewer)));
    tap(&mut viewer, Key::Zero);
    assert!(picture(&mut viewer) == gallery);
}

#[test]
fn sixty_frames_a_second_are_shown_while_a_picture_takes_less() {
    let turntable = |fps| {
        let options = ViewerOptions { fps, turntable: true, ..options("paced") };
        Viewer::new(closed(teapot()), options).expect("a viewer")
    };
    let ms = |ms: u64| Duration::from_millis(ms);
    for (picture_takes, frames) in [(ms(2), 60), (ms(12), 60), (ms(16), 60), (ms(18), 55), (ms(40), 25)] {
        // The window's loop with a clock that is counted: advance, draw and show, sleep.
        let (mut viewer, mut now, mut pictures) = (turntable(60.0), Duration::ZERO, 0);
        viewer.refresh();
        let mut last = now;
        while now < Duration::from_secs(1) {
            viewer.advance(now - last);
            last = now;
            if std::mem::take(&mut viewer.is_stale) {
                pictures += 1;
                now += picture_takes;
            }
            let to_frame = viewer.time_to_next_frame().expect("it turns").saturating_sub(now - last);
            now += to_frame.clamp(Duration::from_micros(50), ms(3));
        }
        assert!((frames - 1..=frames + 1).contains(&pictures), "{picture_takes:?}: {pictures}");
    }
    let mut still = turntable(60.0);
    tap(&mut still, Key::Space);
    assert_eq!(still.time_to_next_frame(), None, "nothing is to come while it is paused");
}
