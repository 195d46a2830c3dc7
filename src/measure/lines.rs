//! Lines: distance of the lit pixels from the segment, and difference from the midpoint rule.

use super::experiment::{Bound, Effort, Experiment, Row};
use crate::draw2d::{self, Blend, RampColor};
use crate::memory::VideoMemory;
use crate::truth::metrics::line_distance;
use crate::truth::scenes::Random;

/// Experiment on lines.
pub(super) const LINES: Experiment = Experiment {
    id: "lines",
    title: "Lines",
    about: "Random segments with whole ends. Distance: from a lit pixel's centre to the segment (for the anti-aliased line \
            weighed by its coverage). Midpoint rule: pixels lit by one of the two and not by the other, the rule worked in \
            whole numbers pixel by pixel. Coverage: against the one-pixel-wide rectangle about the segment, sampled 16 x 16.",
    columns: &[
        "largest distance, px",
        "mean distance, px",
        "pixels off the midpoint rule",
        "coverage RMSE, 1/255",
    ],
    plotted: 3,
    unit: "line",
    rows,
};

const SIDE: u32 = 64;
const WHITE: [u8; 4] = [255; 4];

type Draw = fn(&mut VideoMemory, [i32; 2], [i32; 2]);

fn bresenham(memory: &mut VideoMemory, p0: [i32; 2], p1: [i32; 2]) {
    draw2d::line(memory, p0, p1, RampColor { from: WHITE, to: None }, Blend::Replace);
}

fn anti_aliased(memory: &mut VideoMemory, p0: [i32; 2], p1: [i32; 2]) {
    draw2d::line_aa(memory, p0.map(f64::from), p1.map(f64::from), WHITE);
}

/// Digital differential analyser in f32: adds the slope at each step and rounds.
fn dda_f32(memory: &mut VideoMemory, p0: [i32; 2], p1: [i32; 2]) {
    let (dx, dy) = ((p1[0] - p0[0]) as f32, (p1[1] - p0[1]) as f32);
    let steps = dx.abs().max(dy.abs());
    let (mut x, mut y) = (p0[0] as f32, p0[1] as f32);
    let (step_x, step_y) = if steps > 0.0 { (dx / steps, dy / steps) } else { (0.0, 0.0) };
    for _ in 0..=steps as u32 {
        memory.put_pixel((x + 0.5).floor() as i32, (y + 0.5).floor() as i32, WHITE);
        x += step_x;
        y += step_y;
    }
}

/// Digital differential analyser in 16.16 fixed point.
fn dda_fixed(memory: &mut VideoMemory, p0: [i32; 2], p1: [i32; 2]) {
    let (dx, dy) = (p1[0] - p0[0], p1[1] - p0[1]);
    let steps = dx.abs().max(dy.abs());
    let step = |d: i32| if steps > 0 { (d << 16) / steps } else { 0 };
    let (mut x, mut y) = ((p0[0] << 16) + 0x8000, (p0[1] << 16) + 0x8000);
    for _ in 0..=steps {
        memory.put_pixel(x >> 16, y >> 16, WHITE);
        x += step(dx);
        y += step(dy);
    }
}

/// Returns the pixels of the midpoint rule: step k of n along the major axis, ceil(k m / n - 1/2)
/// along the other, so that a tie stays on the major axis.
fn midpoint_rule(p0: [i32; 2], p1: [i32; 2]) -> Vec<[i32; 2]> {
    let d = [p1[0] - p0[0], p1[1] - p0[1]];
    let major = usize::from(d[0].abs() < d[1].abs());
    let (n, m) = (d[major].abs(), d[1 - major].abs());
    (0..=n)
        .map(|k| {
            let minor = if n == 0 { 0 } else { (2 * k * m + n - 1).div_euclid(2 * n) };
            let mut p = p0;
            p[major] += k * d[major].signum();
            p[1 - major] += minor * d[1 - major].signum();
            p
        })
        .collect()
}

/// Returns the fraction of pixel (x, y), the unit square about (x, y), inside the rectangle about
/// the segment.
fn sampled_coverage(p0: [i32; 2], p1: [i32; 2], x: i32, y: i32) -> f64 {
    let d = [(p1[0] - p0[0]) as f64, (p1[1] - p0[1]) as f64];
    let length = (d[0] * d[0] + d[1] * d[1]).sqrt();
    if length == 0.0 {
        return 0.0;
    }
    let offset = |i: i32| (i as f64 + 0.5) / 16.0 - 0.5;
    let mut inside = 0u32;
    for (i, j) in (0..16).flat_map(|j| (0..16).map(move |i| (i, j))) {
        let q = [(x - p0[0]) as f64 + offset(i), (y - p0[1]) as f64 + offset(j)];
        let along = (q[0] * d[0] + q[1] * d[1]) / length;
        let across = (q[0] * d[1] - q[1] * d[0]) / length;
        inside += u32::from((0.0..=length).contains(&along) && across.abs() <= 0.5);
    }
    inside as f64 / 256.0
}

fn rows(effort: &Effort) -> Vec<Row> {
    let alternatives: [(&str, Draw, bool, Bound); 4] = [
        ("Bresenham, integers", bresenham, true, Bound { column: 0, at_most: 0.5 }),
        ("DDA in f32", dda_f32, false, Bound { column: 0, at_most: 0.501 }),
        ("DDA in 16.16 fixed point", dda_fixed, false, Bound { column: 0, at_most: 0.51 }),
        ("anti-aliased, exact area", anti_aliased, false, Bound { column: 3, at_most: 2.0 }),
    ];
    let count = effort.pick(60, 400);
    let mut rows = Vec::new();
    for (subject, longest) in [("long, about 40 px", SIDE), ("short, to 8 px", 8)] {
        let mut r = Random::new(1962);
        let segments: Vec<[[i32; 2]; 2]> = (0..count)
            .map(|_| {
                let base = [0, 1].map(|_| r.below(SIDE - longest + 1) as i32);
                [0, 1].map(|_| base.map(|b| b + r.below(longest) as i32))
            })
            .collect();
        for (name, draw, is_default, bound) in alternatives {
            let mut memory = VideoMemory::new(SIDE, SIDE).expect("a small frame");
            let mut one_by_one = || {
                let mut pictures = Vec::new();
                for &[p0, p1] in &segments {
                    memory.clear(VideoMemory::CLEAR);
                    draw(&mut memory, p0, p1);
                    pictures.push(memory.bytes().iter().step_by(4).copied().collect::<Vec<u8>>());
                }
                pictures
            };
            let errors = errors_of(&segments, &one_by_one());
            let mut canvas = VideoMemory::new(SIDE, SIDE).expect("a small frame");
            let (_, timing) = effort.run(|| {
                std::hint::black_box(&segments).iter().for_each(|&[p0, p1]| draw(&mut canvas, p0, p1))
            });
            rows.push(Row {
                subject: subject.into(),
                alternative: name.into(),
                is_default,
                errors,
                bounds: vec![bound],
                is_run: true,
                timing,
                work: segments.len() as f64,
                picture: None,
            });
        }
    }
    rows
}

/// Returns the error columns for pictures of one line each, one byte of coverage per pixel.
fn errors_of(segments: &[[[i32; 2]; 2]], pictures: &[Vec<u8>]) -> Vec<f64> {
    let (mut max, mut weighed, mut weight, mut off) = (0f64, 0f64, 0f64, 0usize);
    let (mut squares, mut samples) = (0f64, 0usize);
    for (&[p0, p1], picture) in segments.iter().zip(pictures) {
        let rule = midpoint_rule(p0, p1);
        let [a, b] = [p0.map(f64::from), p1.map(f64::from)];
        for (x, y) in (0..SIDE as i32).flat_map(|y| (0..SIDE as i32).map(move |x| (x, y))) {
            let coverage = picture[(SIDE as i32 * y + x) as usize] as f64 / 255.0;
            let distance = line_distance(a, b, &[[x, y]]).0;
            if coverage > 0.0 {
                max = max.max(distance * coverage);
                weighed += distance * coverage;
                weight += coverage;
            }
            off += usize::from((coverage >= 0.5) != rule.contains(&[x, y]));
            if distance < 1.5 {
                let difference = 255.0 * (coverage - sampled_coverage(p0, p1, x, y));
                squares += difference * difference;
                samples += 1;
            }
        }
    }
    vec![max, weighed / weight, off as f64, (squares / samples.max(1) as f64).sqrt()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_midpoint_rule_keeps_ties_on_the_major_axis() {
        assert_eq!(midpoint_rule([0, 0], [4, 2]), [[0, 0], [1, 0], [2, 1], [3, 1], [4, 2]]);
        assert_eq!(midpoint_rule([4, 2], [0, 0]), [[4, 2], [3, 2], [2, 1], [1, 1], [0, 0]]);
        assert_eq!(midpoint_rule([3, 3], [3, 3]), [[3, 3]]);
        assert!((sampled_coverage([0, 0], [9, 0], 4, 0) - 1.0).abs() < 1e-12);
        assert!((sampled_coverage([0, 0], [9, 0], 0, 0) - 0.5).abs() < 1e-12);
    }
}
