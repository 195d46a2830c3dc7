//! Lines against the closed form, the golden files, their own reversal, and the unclipped line.

use super::*;
use crate::draw2d::raster::{extremes, golden, lit, memory, picture};
use crate::executor::Executor;
use crate::math::coverage::PixelRect;
use proptest::prelude::*;
use serde_json::Value;
use std::time::Instant;

const WHITE: RampColor = RampColor { from: [255; 4], to: None };

/// Returns all pixels of a frame.
fn whole(width: u32, height: u32) -> PixelRect {
    PixelRect { x0: 0, y0: 0, x1: width as i32, y1: height as i32 }
}

/// Returns the run that [`draw`] draws.
fn visible(p0: [i32; 2], p1: [i32; 2], width: u32, height: u32) -> Option<VisibleRun> {
    let is_inside = inside(p0, [width, height]) && inside(p1, [width, height]);
    let clipped = VisibleRun::clipped(p0.map(i64::from), p1.map(i64::from), whole(width, height), width);
    if is_inside { Some(VisibleRun::unclipped(p0, p1, width)) } else { clipped }
}

/// Computes pixel k of the line from the closed form: minor = ceil(k m / n - 1/2).
fn pixel_at(p0: [i32; 2], p1: [i32; 2], k: i128) -> [i128; 2] {
    let d: [i128; 2] = [0, 1].map(|i| i128::from(p1[i]) - i128::from(p0[i]));
    let n = d[0].abs().max(d[1].abs());
    // ceil(a / b) = -floor(-a / b), with a / b = (2 k |d| - n) / 2 n; on the major axis it is k.
    let steps = |v: i128| if n == 0 { 0 } else { -(-(2 * k * v.abs() - n)).div_euclid(2 * n) };
    [0, 1].map(|i| i128::from(p0[i]) + d[i].signum() * steps(d[i]))
}

fn ramp_at(c0: Rgba, c1: Rgba, n: i128, k: i128) -> Rgba {
    std::array::from_fn(|i| {
        let (a, b) = (i128::from(c0[i]), i128::from(c1[i]));
        if n == 0 { c0[i] } else { (2 * a * n + 2 * (b - a) * k + n).div_euclid(2 * n) as u8 }
    })
}

fn ends(v: &Value) -> [[i32; 2]; 2] {
    let s: [i32; 4] = serde_json::from_value(v.clone()).unwrap();
    [[s[0], s[1]], [s[2], s[3]]]
}

#[test]
fn the_golden_segments_light_the_golden_pixels() {
    let golden = golden("seed001_bresenham.json");
    // The last entry is a note on the printed code.
    let cases = golden["expected"].as_array().unwrap().iter().filter(|case| case.get("segment").is_some());
    let cases: Vec<_> = cases.collect();
    assert_eq!(cases.len(), golden["inputs"]["segments"].as_array().unwrap().len());
    for case in cases {
        let [p0, p1] = ends(&case["segment"]);
        let pixels: Vec<(i32, i32)> = serde_json::from_value(case["pixels"].clone()).unwrap();
        let mut m = memory(24, 24);
        line(&mut m, p0, p1, WHITE, Blend::Replace);
        let mut want = pixels.clone();
        want.sort_by_key(|&(x, y)| (y, x));
        assert_eq!(lit(&m, 255), want, "{p0:?} to {p1:?}");
        for (k, &(x, y)) in pixels.iter().enumerate() {
            assert_eq!(pixel_at(p0, p1, k as i128), [x.into(), y.into()], "{p0:?} to {p1:?}, step {k}");
        }
    }
}

#[test]
fn the_golden_ramps_have_the_golden_colours() {
    let golden = golden("seed001_line_colour_ramp.json");
    for case in golden["expected"].as_array().unwrap() {
        // Translated, because one of the segments leaves the frame.
        let [p0, p1] = ends(&case["segment"]).map(|p| p.map(|v| v + 5));
        let color = |v: &Value| -> Rgba { serde_json::from_value(v.clone()).unwrap() };
        let mut m = memory(24, 24);
        let ramp = RampColor { from: color(&case["c0"]), to: Some(color(&case["c1"])) };
        line(&mut m, p0, p1, ramp, Blend::Replace);
        for pixel in case["pixels"].as_array().unwrap() {
            let [x, y]: [i32; 2] = serde_json::from_value(pixel["xy"].clone()).unwrap();
            assert_eq!(m.get_pixel(x + 5, y + 5).unwrap(), color(&pixel["rgba_u8"]), "{pixel}");
        }
    }
}

#[test]
fn every_small_line_is_the_closed_form_in_its_order() {
    for (dx, dy) in (-9..=9).flat_map(|dx| (-9..=9).map(move |dy| (dx, dy))) {
        let (p0, p1) = ([10, 10], [10 + dx, 10 + dy]);
        let run = visible(p0, p1, 21, 21).unwrap();
        let mut visited = Vec::new();
        run.visit(|at| visited.push([(at % 21) as i128, (at / 21) as i128]));
        let n = i128::from(dx.abs().max(dy.abs()));
        let want: Vec<_> = (0..=n).map(|k| pixel_at(p0, p1, k)).collect();
        assert_eq!(visited, want, "({dx},{dy})");
    }
}

/// Returns the pixels of the unclipped line inside a w x h frame, step by step from the closed
/// form; for short lines.
fn part_of_unclipped(p0: [i32; 2], p1: [i32; 2], w: u32, h: u32) -> Vec<(i32, i32)> {
    let n = p0[0].abs_diff(p1[0]).max(p0[1].abs_diff(p1[1]));
    let all = (0..=n).map(|k| pixel_at(p0, p1, k.into()));
    let inside = all.filter(|p| (0..w.into()).contains(&p[0]) && (0..h.into()).contains(&p[1]));
    let mut lit: Vec<_> = inside.map(|p| (p[0] as i32, p[1] as i32)).collect();
    lit.sort_by_key(|&(x, y)| (y, x));
    lit
}

/// Returns the pixels of any line inside a w x h frame: for each pixel, the steps that could light
/// it are tested.
fn asked_by_pixel(p0: [i32; 2], p1: [i32; 2], w: u32, h: u32) -> Vec<(i32, i32, i128)> {
    let (dx, dy) = (i128::from(p1[0]) - i128::from(p0[0]), i128::from(p1[1]) - i128::from(p0[1]));
    let n = dx.abs().max(dy.abs());
    let mut lit = Vec::new();
    for (x, y) in (0..h as i32).flat_map(|y| (0..w as i32).map(move |x| (x, y))) {
        let along = if dx.abs() >= dy.abs() { (x, p0[0], dx) } else { (y, p0[1], dy) };
        let k = (i128::from(along.0) - i128::from(along.1)) * if along.2 < 0 { -1 } else { 1 };
        if (0..=n).contains(&k) && pixel_at(p0, p1, k) == [x.into(), y.into()] {
            lit.push((x, y, k));
        }
    }
    lit
}

fn end_point() -> impl Strategy<Value = [i32; 2]> {
    let coordinate = || {
        prop_oneof![
            4 => -30..60i32,
            2 => -3000..3000i32,
            2 => any::<i32>(),
            1 => prop::sample::select(extremes().to_vec()),
        ]
    };
    [coordinate(), coordinate()]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 4_000, max_global_rejects: 40_000, ..ProptestConfig::default() })]

    #[test]
    fn clipped_equals_the_part_of_the_whole(p0 in [-60..90i32, -60..90i32], p1 in [-60..90i32, -60..90i32]) {
        // Composited, so that a pixel drawn twice would show.
        let mut m = memory(30, 20);
        line(&mut m, p0, p1, RampColor { from: [255, 255, 255, 100], to: None }, Blend::Over);
        prop_assert_eq!(lit(&m, 100), part_of_unclipped(p0, p1, 30, 20));
    }

    #[test]
    fn any_line_lights_and_colours_what_the_closed_form_says(p0 in end_point(), p1 in end_point(), c0: Rgba, c1: Rgba) {
        let (w, h) = (23, 17);
        let asked = asked_by_pixel(p0, p1, w, h);
        let mut m = memory(w, h);
        m.clear([1, 2, 3, 4]);
        m.take_damage();
        line(&mut m, p0, p1, RampColor { from: c0, to: Some(c1) }, Blend::Replace);
        let mut want = memory(w, h);
        want.clear([1, 2, 3, 4]);
        let n = p0[0].abs_diff(p1[0]).max(p0[1].abs_diff(p1[1])).into();
        for &(x, y, k) in &asked {
            want.put_pixel(x, y, ramp_at(c0, c1, n, k));
        }
        prop_assert_eq!(m.bytes(), want.bytes());
        let rows = asked.iter().map(|p| p.1 as u32).min().map(|low| low..asked.last().unwrap().1 as u32 + 1);
        prop_assert_eq!(m.is_damaged().then(|| m.take_damage()), rows);
    }

    #[test]
    fn eight_abreast_visits_what_one_by_one_does(p0 in [0..1920i32, -9000..9000i32], p1 in [-9000..9000i32, 0..1080i32]) {
        let run = visible(p0, p1, 1920, 1080);
        prop_assume!(run.as_ref().is_some_and(|r| r.length > 0));
        let run = run.expect("it is seen");
        let (mut long, mut short, mut chosen) = (Vec::new(), Vec::new(), Vec::new());
        run.visit_short(|at| short.push(at));
        run.visit(|at| chosen.push(at));
        prop_assert_eq!(&chosen, &short);
        prop_assert!((u64::from(run.count) + 1) * 2 * run.length < 1 << 32, "32 bits carry every step here");
        run.visit_long(|at| long.push(at));
        prop_assert_eq!(&long, &short);
    }

    #[test]
    fn a_line_without_ties_is_the_same_backwards(p0 in end_point(), p1 in end_point()) {
        let d = [p0[0].abs_diff(p1[0]), p0[1].abs_diff(p1[1])].map(u64::from);
        let (n, m) = (d[0].max(d[1]), d[0].min(d[1]));
        // A tie needs 2 k m = n (2 j + 1) for some k: n / gcd is even.
        let gcd = num_integer::gcd(n, m);
        if gcd != 0 && (n / gcd) % 2 == 0 {
            return Ok(());
        }
        let (mut there, mut back) = (memory(40, 40), memory(40, 40));
        line(&mut there, p0, p1, WHITE, Blend::Replace);
        line(&mut back, p1, p0, WHITE, Blend::Replace);
        prop_assert_eq!(there.bytes(), back.bytes());
    }
}

#[test]
fn a_whole_line_clipped_is_itself() {
    let mut seen = 0;
    for (a, b) in (0..12 * 9).flat_map(|a| (0..12 * 9).step_by(5).map(move |b| (a, b))) {
        let (p0, p1) = ([a % 12, a / 12], [b % 12, b / 12]);
        let (mut complete, mut clipped) = (Vec::new(), Vec::new());
        VisibleRun::unclipped(p0, p1, 12).visit(|at| complete.push(at));
        VisibleRun::clipped(p0.map(i64::from), p1.map(i64::from), whole(12, 9), 12)
            .unwrap()
            .visit(|at| clipped.push(at));
        assert_eq!(complete, clipped, "{p0:?} {p1:?}");
        seen += complete.len();
    }
    assert!(seen > 10_000);
}

/// Creates lines of every kind: short and long, inside and outside, at the ends of i32, of one
/// colour and two.
fn crowd(count: usize) -> Vec<Line> {
    let mut state = 1u32;
    let mut next = |n: i32| {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as i32 % n
    };
    let far = [i32::MIN, i32::MIN + 1, -70_000, 50, 3_000_000, i32::MAX - 1, i32::MAX];
    (0..count)
        .map(|i| {
            let p0 = [next(80) - 10, next(60) - 10];
            let p1 = match i % 3 {
                0 => [next(80) - 10, next(60) - 10],
                1 if i % 5 == 0 => [far[next(7) as usize], far[next(7) as usize]],
                _ => [p0[0] + next(17) - 8, p0[1] + next(17) - 8],
            };
            let color: Rgba = std::array::from_fn(|_| next(256) as u8);
            let color = if i % 11 == 0 { [color[0], 1, 2, 0] } else { color };
            Line { p0, p1, color: RampColor { from: color, to: (i % 7 == 0).then_some([9, 250, 3, 100]) } }
        })
        .collect()
}

#[test]
fn many_lines_are_each_line_in_turn() {
    let all = crowd(600);
    for blend in [Blend::Replace, Blend::Over] {
        for chunk in [1, 7, 600] {
            let (mut one, mut many) = (memory(60, 40), memory(60, 40));
            one.take_damage();
            many.take_damage();
            for part in all.chunks(chunk) {
                part.iter().for_each(|l| line(&mut one, l.p0, l.p1, l.color, blend));
                lines(&mut many, part.iter().copied(), blend);
                assert_eq!(one.take_damage(), many.take_damage());
            }
            assert!(one.bytes() == many.bytes());
        }
    }
}

#[test]
fn bands_of_threads_draw_what_one_thread_does() {
    let all = crowd(5_000);
    assert!(parallel::is_worth_threads(&all) && !parallel::is_worth_threads(&all[..1]));
    for blend in [Blend::Replace, Blend::Over] {
        for height in [1, 2, 40] {
            let mut one = memory(60, height);
            one.take_damage();
            all.iter().for_each(|l| line(&mut one, l.p0, l.p1, l.color, blend));
            let rows = one.take_damage();
            for threads in [1, 2, 3, 16, 50] {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
                let mut many = memory(60, height);
                many.take_damage();
                lines_on(&Executor::of_pool(Some(pool.into())), &mut many, &all, blend);
                assert!(one.bytes() == many.bytes(), "{threads} threads, {height} rows, {blend:?}");
                assert_eq!(many.take_damage(), rows);
            }
        }
    }
}

#[test]
fn the_rows_of_bands_are_those_that_were_drawn() {
    // Enough lines for several threads, all in rows 7 to 30: within the first and the second band,
    // and between the bands of five threads.
    let all: Vec<Line> = (0..4_000)
        .map(|i| Line { p0: [i % 50, 7 + i % 24], p1: [i % 37, 7 + i % 13], color: WHITE })
        .collect();
    for threads in [2, 5] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let mut m = memory(60, 40);
        m.take_damage();
        lines_on(&Executor::of_pool(Some(pool.into())), &mut m, &all, Blend::Replace);
        assert_eq!(m.take_damage(), 7..31, "{threads} threads");
    }
}

/// A line that notes on which thread it is read.
#[derive(Clone, Copy)]
struct Noted<'a>(Line, &'a std::sync::Mutex<std::collections::HashSet<std::thread::ThreadId>>);
impl From<Noted<'_>> for Line {
    fn from(noted: Noted) -> Line {
        noted.1.lock().unwrap().insert(std::thread::current().id());
        noted.0
    }
}

#[test]
fn many_lines_are_drawn_by_the_threads_of_the_pool_and_few_by_the_caller() {
    let threads_of = |count: usize| {
        let threads = std::sync::Mutex::default();
        let all: Vec<Noted> = crowd(count).into_iter().map(|line| Noted(line, &threads)).collect();
        let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build().unwrap();
        lines_on(&Executor::of_pool(Some(pool.into())), &mut memory(60, 40), &all, Blend::Replace);
        drop(all);
        threads.into_inner().unwrap()
    };
    let caller = std::thread::current().id();
    assert!(!threads_of(5_000).contains(&caller));
    assert!(threads_of(5).into_iter().eq([caller]));
}

#[test]
fn ramps_of_many_steps_are_exact_at_every_pixel() {
    // Between 2^16 steps and the longest line; each passes many integers inside the frame.
    let (c0, c1) = ([0, 255, 3, 200], [255, 0, 250, 200]);
    for (p0, p1) in [([-30_000, 0], [36_000, 1]), ([40_000, 1], [-30_001, 0]), ([-70_000, 0], [70_000, 1])] {
        let (mut m, mut want) = (memory(16_000, 2), memory(16_000, 2));
        line(&mut m, p0, p1, RampColor { from: c0, to: Some(c1) }, Blend::Replace);
        for (x, y, k) in asked_by_pixel(p0, p1, 16_000, 2) {
            want.put_pixel(x, y, ramp_at(c0, c1, p0[0].abs_diff(p1[0]).into(), k));
        }
        assert!(m.bytes() == want.bytes(), "{p0:?} {p1:?}");
    }
}

#[test]
fn a_line_clipped_to_bands_is_the_line() {
    // Each row by itself: rows of the unclipped line, computed one at a time.
    let mut marked = 0;
    for l in crowd(400) {
        let (mut complete, mut rows) = (memory(60, 40), memory(60, 40));
        complete.take_damage();
        line(&mut complete, l.p0, l.p1, l.color, Blend::Replace);
        for y in 0..40 {
            let [a, b] = [l.p0, l.p1].map(|[x, line_y]| [i64::from(x), i64::from(line_y) - y]);
            if let Some(run) = VisibleRun::clipped(a, b, whole(60, 1), 60) {
                let row = &mut super::pixels_mut(&mut rows)[60 * y as usize..][..60];
                assert_eq!(run.draw(row, l.color, Blend::Replace), 0..1);
                marked += 1;
            }
        }
        assert!(complete.bytes() == rows.bytes(), "{l:?}");
    }
    assert!(marked > 2_000);
}

#[test]
fn a_tie_stays_on_the_major_axis_in_the_direction_of_travel() {
    let mut m = memory(7, 4);
    line(&mut m, [1, 1], [5, 3], WHITE, Blend::Replace);
    assert_eq!(picture(&m), TIE_THERE);
    let mut m = memory(7, 4);
    line(&mut m, [5, 3], [1, 1], WHITE, Blend::Replace);
    assert_eq!(picture(&m), TIE_BACK);
}

#[test]
fn four_billion_pixels_cost_what_is_seen() {
    let (p0, p1) = ([-2_000_000_000, -2_000_000_000], [2_000_000_000, 1_000_000_000]);
    // This one passes left of the frame, so a parallel one that crosses it is drawn too.
    for shift in [0, 500_000_000] {
        let (p0, p1) = ([p0[0], p0[1] + shift], [p1[0], p1[1] + shift]);
        let mut m = memory(1920, 1080);
        let best = (0..9)
            .map(|_| {
                let start = Instant::now();
                line(&mut m, p0, p1, WHITE, Blend::Replace);
                start.elapsed()
            })
            .min()
            .unwrap();
        assert!(best.as_micros() < 1000, "{best:?}");
        let want: Vec<_> = (0..1920)
            .map(|x| pixel_at(p0, p1, i128::from(x) - i128::from(p0[0])))
            .filter(|p| (0..1080).contains(&p[1]))
            .map(|p| (p[0] as i32, p[1] as i32))
            .collect();
        let mut drawn = lit(&m, 255);
        drawn.sort();
        assert_eq!(drawn, want);
        assert_eq!(want.is_empty(), shift == 0);
    }
}

#[test]
fn outlines_are_their_lines() {
    let points = [[2, 1], [12, 4], [5, 9]];
    let (a, b, c) = ([255, 0, 0, 128], [0, 255, 0, 200], [0, 0, 255, 60]);
    for blend in [Blend::Replace, Blend::Over] {
        let (mut tri, mut want) = (memory(14, 11), memory(14, 11));
        triangle_outline(&mut tri, points, AreaColors::Three([a, b, c]), blend);
        for (i, j, from, to) in [(0, 1, a, b), (1, 2, b, c), (2, 0, c, a)] {
            line(&mut want, points[i], points[j], RampColor { from, to: Some(to) }, blend);
        }
        assert_eq!(tri.bytes(), want.bytes());
        let (mut closed, mut tri) = (memory(14, 11), memory(14, 11));
        poly(&mut closed, &points, a, blend);
        triangle_outline(&mut tri, points, AreaColors::One(a), blend);
        assert_eq!(closed.bytes(), tri.bytes());
    }
    let mut m = memory(3, 3);
    poly(&mut m, &[], a, Blend::Replace);
    assert!(lit(&m, 255).is_empty());
    poly(&mut m, &[[1, 2]], a, Blend::Replace);
    assert_eq!(lit(&m, 255), [(1, 2)]);
}

const TIE_THERE: &str = "
.......
.##....
...##..
.....#.";

const TIE_BACK: &str = "
.......
.#.....
..##...
....##.";
