//! Coverage against other ways to compute the area, and the drawn pixels against the coverage.

use super::*;
use crate::draw2d::raster::{fractional, memory};
use proptest::prelude::*;
use std::collections::BTreeMap;

const CLIP: PixelRect = PixelRect { x0: 0, y0: 0, x1: 12, y1: 9 };

fn areas(p0: [f64; 2], p1: [f64; 2], clip: PixelRect) -> BTreeMap<(i32, i32), f64> {
    let mut all = BTreeMap::new();
    for_each_covered_pixel(p0, p1, clip, clip, |x, y, area| {
        assert!(
            (0.0..=1.0).contains(&area) && (clip.x0..clip.x1).contains(&x) && (clip.y0..clip.y1).contains(&y)
        );
        assert!(all.insert((x, y), area).is_none(), "({x},{y}) twice");
    });
    all
}

/// Returns the same areas by cutting the rectangle at every pixel.
fn cut_areas(p0: [f64; 2], p1: [f64; 2], clip: PixelRect) -> BTreeMap<(i32, i32), f64> {
    let mut all = BTreeMap::new();
    if let Some(rect) = SegmentRect::new(p0, p1, clip) {
        cut_pixels(&rect, clip, clip, &mut |x, y, area| assert!(all.insert((x, y), area).is_none()));
    }
    all
}

/// Returns the largest difference of two pictures.
fn difference(a: &BTreeMap<(i32, i32), f64>, b: &BTreeMap<(i32, i32), f64>) -> f64 {
    let at = |m: &BTreeMap<_, f64>, p: &(i32, i32)| m.get(p).copied().unwrap_or(0.0);
    a.keys().chain(b.keys()).map(|p| (at(a, p) - at(b, p)).abs()).fold(0.0, f64::max)
}

/// Computes the area independently, by integrating the rectangle's breadth over many thin strips of
/// the pixel.
fn integrated(p0: [f64; 2], p1: [f64; 2], x: i32, y: i32) -> f64 {
    let d = [p1[0] - p0[0], p1[1] - p0[1]];
    let length = d[0].hypot(d[1]);
    let u = [d[0] / length, d[1] / length];
    const STRIPS: i32 = 2000;
    let strips = (0..STRIPS).map(|k| {
        let py = f64::from(y) - 0.5 + (f64::from(k) + 0.5) / f64::from(STRIPS);
        // lo <= a px + b <= hi is an interval of px, for each of the two directions.
        let interval = |a: f64, b: f64, lo: f64, hi: f64| {
            if a.abs() < 1e-12 {
                return if (lo..=hi).contains(&b) { (f64::MIN, f64::MAX) } else { (0.0, 0.0) };
            }
            let (s, t) = ((lo - b) / a, (hi - b) / a);
            (s.min(t), s.max(t))
        };
        let along = interval(u[0], (py - p0[1]) * u[1] - p0[0] * u[0], 0.0, length);
        let across = interval(-u[1], (py - p0[1]) * u[0] + p0[0] * u[1], -0.5, 0.5);
        let (left, right) = (f64::from(x) - 0.5, f64::from(x) + 0.5);
        (along.1.min(across.1).min(right) - along.0.max(across.0).max(left)).max(0.0)
    });
    strips.sum::<f64>() / f64::from(STRIPS)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 100, ..ProptestConfig::default() })]

    #[test]
    fn a_share_is_the_area_in_common(p0 in [-4.0..16.0f64, -4.0..12.0f64], p1 in [-4.0..16.0f64, -4.0..12.0f64]) {
        prop_assume!((p0[0] - p1[0]).abs() > 1e-3);
        let got = areas(p0, p1, CLIP);
        for (x, y) in (0..9).flat_map(|y| (0..12).map(move |x| (x, y))) {
            let (area, want) = (got.get(&(x, y)).copied().unwrap_or(0.0), integrated(p0, p1, x, y));
            prop_assert!((area - want).abs() < 2e-3, "({x},{y}): {area}, not {want}");
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2_000, ..ProptestConfig::default() })]

    #[test]
    fn all_shares_together_are_the_length(p0 in [-40.0..40.0f64, -40.0..40.0f64], p1 in [-40.0..40.0f64, -40.0..40.0f64]) {
        let whole = areas(p0, p1, PixelRect { x0: -50, y0: -50, x1: 50, y1: 50 });
        let length = (p0[0] - p1[0]).hypot(p0[1] - p1[1]);
        prop_assert!((whole.values().sum::<f64>() - length).abs() < 1e-9);
        // The clipped line equals the unclipped one, and so does the reversed one.
        let (clipped, back) = (areas(p0, p1, CLIP), areas(p1, p0, CLIP));
        for (x, y) in (0..9).flat_map(|y| (0..12).map(move |x| (x, y))) {
            let at = |m: &BTreeMap<_, f64>| m.get(&(x, y)).copied().unwrap_or(0.0);
            prop_assert!((at(&clipped) - at(&whole)).abs() < 1e-9);
            prop_assert!((at(&back) - at(&whole)).abs() < 1e-9);
        }
    }

    #[test]
    fn stepped_areas_are_the_cut_ones(
        p0 in [fractional(), fractional()], d in [-90.0..90.0f64, -90.0..90.0f64], tilt in prop::sample::select(vec![0.0, 1e-40, 1e-18, 1e-9, 1e-5, 1.0]), bits in 0..12u32,
    ) {
        let clip = PixelRect { x0: 0, y0: 0, x1: 1920, y1: 1080 };
        let round = |v: f64| (v * f64::from(1 << bits)).round() / f64::from(1 << bits);
        let d = d.map(round);
        for p1 in [[p0[0] + d[0], p0[1] + d[1]], [p0[0] + d[0], p0[1] + d[1] * tilt], [p0[0] + d[0] * tilt, p0[1] + d[1]], [p0[0] + d[0], p0[1] + d[0]]] {
            let off = difference(&areas(p0, p1, clip), &cut_areas(p0, p1, clip));
            prop_assert!(off < 1e-9, "{:?} {:?}: {}", p0, p1, off);
        }
    }

    #[test]
    fn bands_of_rows_have_the_bytes_of_the_whole(
        p0 in [fractional(), fractional()], p1 in [fractional(), fractional()], far in prop::sample::select(vec![1.0, 1e3, 1e9, 1e200]), color: [u8; 4], at in 1..80u32, columns in 0..50u32,
    ) {
        let scale = |p: [f64; 2], k: f64| p.map(|v| v / 15.0 * k);
        let [mut whole, mut bands] = [memory(128, 72), memory(128, 72)];
        for m in [&mut whole, &mut bands] {
            m.set_clip(columns..columns + 60, 3..70);
        }
        let (p0, p1) = (scale(p0, 1.0), scale(p1, far));
        line_aa(&mut whole, p0, p1, color);
        for rows in [0..at, at..at + 1, at + 1..72] {
            bands.set_window(rows);
            line_aa(&mut bands, p0, p1, color);
        }
        prop_assert!(whole.bytes() == bands.bytes());
    }

    #[test]
    fn an_end_far_off_changes_only_the_direction(angle in 0.0..6.3f64, e in 6.5..300.0f64, through in [0.0..11.0f64, 0.0..8.0f64]) {
        // From a point in the frame to one far away: equals a line in the same direction that just
        // leaves the frame.
        let (s, c) = libm::sincos(angle);
        let far = [through[0] + c * 10f64.powf(e), through[1] + s * 10f64.powf(e)];
        let d = [far[0] - through[0], far[1] - through[1]].map(|v| v / 10f64.powf(e));
        let near = [through[0] + 40.0 * d[0], through[1] + 40.0 * d[1]];
        let (a, b) = (areas(through, far, CLIP), areas(through, near, CLIP));
        for (x, y) in (0..9).flat_map(|y| (0..12).map(move |x| (x, y))) {
            let at = |m: &BTreeMap<_, f64>| m.get(&(x, y)).copied().unwrap_or(0.0);
            prop_assert!((at(&a) - at(&b)).abs() < 1e-9, "({x},{y}): {} {}", at(&a), at(&b));
        }
    }

    #[test]
    fn any_bits_are_answered(bits: [u64; 4]) {
        let v = bits.map(f64::from_bits);
        line_aa(&mut memory(12, 9), [v[0], v[1]], [v[2], v[3]], [255; 4]);
    }
}

#[test]
fn both_ends_at_1e15_cross_the_frame_where_they_should() {
    // Through (5, 4) at a slope of 1/3: both ends are integers, so the line passes there exactly.
    let k = 1e15;
    let (a, b) = (
        areas([5.0 - 3.0 * k, 4.0 - k], [5.0 + 3.0 * k, 4.0 + k], CLIP),
        areas([-25.0, -6.0], [35.0, 14.0], CLIP),
    );
    assert_eq!(a.len(), b.len());
    for (at, area) in a {
        assert!((area - b[&at]).abs() < 1e-9, "{at:?}");
    }
}

#[test]
fn coverage_times_alpha_is_composed_over() {
    let mut m = memory(12, 9);
    m.take_damage();
    line_aa(&mut m, [1.0, 3.0], [4.0, 3.0], [200, 100, 50, 255]);
    assert_eq!(m.take_damage(), 3..4);
    // Half of each end pixel, all of those between: 128 = round(127.5).
    let half = super::super::over([200, 100, 50, 128], [0, 0, 0, 255]);
    for (x, want) in [
        (0, [0, 0, 0, 255]),
        (1, half),
        (2, [200, 100, 50, 255]),
        (3, [200, 100, 50, 255]),
        (4, half),
        (5, [0, 0, 0, 255]),
    ] {
        assert_eq!(m.get_pixel(x, 3).unwrap(), want, "{x}");
    }
    // On the border of two rows each gets half; 128/255 of alpha 100 is 50.
    let mut m = memory(12, 9);
    line_aa(&mut m, [2.5, 1.0], [2.5, 6.0], [255, 255, 255, 100]);
    let lit = super::super::over([255, 255, 255, 50], [0, 0, 0, 255]);
    assert_eq!((m.get_pixel(2, 3).unwrap(), m.get_pixel(3, 3).unwrap()), (lit, lit));
}

#[test]
fn what_has_no_length_or_no_place_draws_nothing() {
    let mut m = memory(12, 9);
    m.take_damage();
    for (p0, p1) in [
        ([3.0, 3.0], [3.0, 3.0]),
        ([0.0, -0.0], [-0.0, 0.0]),
        ([3.0, 3.0], [3.0, 3.0 + 1e-12]),
        ([0.0, 0.0], [5e-324, 0.0]),
        ([f64::NAN, 0.0], [4.0, 4.0]),
        ([0.0, 0.0], [f64::INFINITY, 4.0]),
        ([1e300, 0.0], [1e300, 9.0]),
        ([-f64::MAX, 1e5], [f64::MAX, 1e5]),
    ] {
        line_aa(&mut m, p0, p1, [255; 4]);
    }
    line_aa(&mut m, [0.0, 0.0], [9.0, 9.0], [255, 255, 255, 0]);
    assert!(!m.is_damaged());
    line_aa(&mut m, [-f64::MAX, 4.0], [f64::MAX, 4.0], [255; 4]);
    assert_eq!(m.take_damage(), 4..5);
    assert_eq!(m.row(4).unwrap(), [255; 48]);
}

#[test]
fn a_frame_of_one_pixel() {
    let mut m = memory(1, 1);
    line_aa(&mut m, [0.0, -1e308], [0.0, 1e308], [255; 4]);
    assert_eq!(m.bytes(), [255; 4]);
}
