//! Lines: distance of the lit pixels from the segment, and difference from the midpoint rule.

use super::clock::Work;
use super::experiment::{Bound, Check, Effort, Experiment, Row, Standing, Truth};
use fbptr_core::draw2d::{self, Blend, RampColor};
use fbptr_core::memory::VideoMemory;
use fbptr_truth::metrics::line_distance;
use fbptr_truth::scenes::Random;

/// Experiment on lines.
pub(super) const LINES: Experiment = Experiment {
    id: "lines",
    title: "Lines",
    about: "Random segments with whole ends. Distance: from a lit pixel's centre to the segment (for the anti-aliased line \
            weighed by its coverage). Midpoint rule: pixels lit by one of the two and not by the other. Coverage: against the \
            area of each pixel in the one-pixel-wide rectangle about the segment.",
    truth: Truth {
        is: "the segment itself; the midpoint rule pixel by pixel; each pixel's square cut with the rectangle",
        digits: "distances and areas 15, the rule in whole numbers",
        second_way: "areas as the mean of 64 x 64 samples",
    },
    check,
    columns: &[
        "largest distance, px",
        "mean distance, px",
        "pixels off the midpoint rule",
        "largest coverage error, 1/255",
        "coverage RMSE, 1/255",
    ],
    plotted: 4,
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

/// Returns the area of pixel (x, y), the unit square about (x, y), inside the rectangle about the
/// segment: the square cut by the four sides, one after the other (I. E. Sutherland, G. W. Hodgman,
/// "Reentrant polygon clipping", 1974).
pub(super) fn area(p0: [i32; 2], p1: [i32; 2], x: i32, y: i32) -> f64 {
    let d = [f64::from(p1[0] - p0[0]), f64::from(p1[1] - p0[1])];
    let length = libm::hypot(d[0], d[1]);
    if length == 0.0 {
        return 0.0;
    }
    let u = d.map(|v| v / length);
    let sides = [(u, length), ([-u[0], -u[1]], 0.0), ([u[1], -u[0]], 0.5), ([-u[1], u[0]], 0.5)];
    let [cx, cy] = [f64::from(x - p0[0]), f64::from(y - p0[1])];
    let mut polygon: Vec<[f64; 2]> =
        [[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]].map(|[i, j]| [cx + i, cy + j]).to_vec();
    for (normal, most) in sides {
        let beyond = |p: [f64; 2]| p[0] * normal[0] + p[1] * normal[1] - most;
        let mut cut = Vec::new();
        for (i, &b) in polygon.iter().enumerate() {
            let a = polygon[(i + polygon.len() - 1) % polygon.len()];
            let (at_a, at_b) = (beyond(a), beyond(b));
            if (at_a > 0.0) != (at_b > 0.0) {
                let t = at_a / (at_a - at_b);
                cut.push([a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])]);
            }
            if at_b <= 0.0 {
                cut.push(b);
            }
        }
        polygon = cut;
    }
    let doubled: f64 = (0..polygon.len())
        .map(|i| (polygon[i], polygon[(i + 1) % polygon.len()]))
        .map(|(a, b)| (a[0] - cx) * (b[1] - cy) - (b[0] - cx) * (a[1] - cy))
        .sum();
    doubled.abs() / 2.0
}

/// Samples of a pixel in each direction in the second way.
const SAMPLES: i32 = 64;

/// Returns the same area as the mean of samples at the centres of `SAMPLES` x `SAMPLES` cells.
fn sampled_area(p0: [i32; 2], p1: [i32; 2], x: i32, y: i32) -> f64 {
    let d = [(p1[0] - p0[0]) as f64, (p1[1] - p0[1]) as f64];
    let length = libm::hypot(d[0], d[1]);
    let offset = |i: i32| (i as f64 + 0.5) / f64::from(SAMPLES) - 0.5;
    let mut inside = 0u32;
    for (i, j) in (0..SAMPLES).flat_map(|j| (0..SAMPLES).map(move |i| (i, j))) {
        let q = [(x - p0[0]) as f64 + offset(i), (y - p0[1]) as f64 + offset(j)];
        let along = (q[0] * d[0] + q[1] * d[1]) / length;
        let across = (q[0] * d[1] - q[1] * d[0]) / length;
        inside += u32::from((0.0..=length).contains(&along) && across.abs() <= 0.5);
    }
    f64::from(inside) / f64::from(SAMPLES * SAMPLES)
}

/// Compares both areas over the pixels about some segments. A row of samples meets the rectangle in
/// one interval, whose length it tells to 1/64; between the rows that length is a concave function,
/// of which they miss at most another 1/64.
fn check(effort: &Effort) -> Check {
    let mut difference = 0f64;
    let segments = [([3, 5], [11, 9]), ([3, 5], [3, 12]), ([10, 4], [7, 11]), ([2, 2], [12, 3])];
    for &(p0, p1) in &segments[..effort.pick(2, 4)] {
        for (x, y) in (0..16).flat_map(|y| (0..16).map(move |x| (x, y))) {
            difference = difference.max((area(p0, p1, x, y) - sampled_area(p0, p1, x, y)).abs());
        }
    }
    Check { difference, at_most: 2.0 / f64::from(SAMPLES) }
}

/// Returns the alternatives, each with its bounds.
fn alternatives() -> [(&'static str, Draw, Standing, Vec<Bound>); 4] {
    let distance = |at_most, because| Bound { column: 0, at_most, because };
    let rule = Bound { column: 2, at_most: 0.0, because: "Bresenham's steps are the midpoint rule's" };
    let rounding = "a coverage is rounded to the nearest of 255 steps";
    [
        (
            "Bresenham, integers",
            bresenham,
            Standing::Default,
            vec![distance(0.5, "the minor coordinate is rounded to the nearest whole number"), rule],
        ),
        (
            "anti-aliased, exact area",
            anti_aliased,
            Standing::Mode,
            vec![Bound { column: 3, at_most: 0.5 + 1e-9, because: rounding }],
        ),
        (
            "DDA in f32",
            dda_f32,
            Standing::Comparison,
            vec![distance(0.5 + 2e-4, "64 sums in f32, each off by half an ulp of 64: 64 x 2^-18 px")],
        ),
        (
            "DDA in 16.16 fixed point",
            dda_fixed,
            Standing::Comparison,
            vec![distance(0.5 + 1e-3, "a step is cut to 2^-16, 63 times: 63 x 2^-16 px")],
        ),
    ]
}

fn rows(effort: &Effort) -> Vec<Row> {
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
        let ways = alternatives();
        let mut canvases = ways.each_ref().map(|_| VideoMemory::new(SIDE, SIDE).expect("a small frame"));
        let mut works: Vec<Work<()>> = Vec::new();
        for ((_, draw, ..), canvas) in ways.iter().zip(&mut canvases) {
            works.push(Box::new(|| {
                std::hint::black_box(&segments).iter().for_each(|&[p0, p1]| draw(canvas, p0, p1))
            }));
        }
        let timings = effort.run_in_turns(works);
        for ((name, draw, standing, bounds), ((), timing)) in ways.into_iter().zip(timings) {
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
            let pictures = one_by_one();
            let judge = |pictures: &Vec<Vec<u8>>| errors_of(&segments, pictures);
            let mutate = |pictures: &mut Vec<Vec<u8>>, bound: &Bound| mutate(&segments, pictures, bound);
            let row = Row::judged(effort, (subject, name, standing), &pictures, bounds, judge, mutate);
            rows.push(row.timed(timing, segments.len() as f64));
        }
    }
    rows
}

/// Lights the pixel of the first picture that is nearest beyond the bound, or takes one step of
/// coverage more than it.
fn mutate(segments: &[[[i32; 2]; 2]], pictures: &mut [Vec<u8>], bound: &Bound) {
    let [p0, p1] = segments[0];
    let [a, b] = [p0.map(f64::from), p1.map(f64::from)];
    let places = (0..SIDE as i32).flat_map(|y| (0..SIDE as i32).map(move |x| [x, y]));
    let index = |[x, y]: [i32; 2]| (SIDE as i32 * y + x) as usize;
    match bound.column {
        0 => {
            let distance = |p: [i32; 2]| line_distance(a, b, &[p]).0;
            let beyond = places.filter(|&p| distance(p) > bound.at_most);
            if let Some(p) = beyond.min_by(|&p, &q| distance(p).total_cmp(&distance(q))) {
                pictures[0][index(p)] = 255;
            }
        }
        2 => pictures[0][index(p0)] = 0,
        _ => {
            let covered = |p: &[i32; 2]| (0.2..0.8).contains(&area(p0, p1, p[0], p[1]));
            if let Some(p) = places.into_iter().find(covered) {
                pictures[0][index(p)] = (255.0 * area(p0, p1, p[0], p[1]) + bound.at_most).floor() as u8 + 1;
            }
        }
    }
}

/// Returns the error columns for pictures of one line each, one byte of coverage per pixel.
fn errors_of(segments: &[[[i32; 2]; 2]], pictures: &[Vec<u8>]) -> Vec<f64> {
    let (mut max, mut weighed, mut weight, mut off) = (0f64, 0f64, 0f64, 0usize);
    let (mut worst, mut squares, mut samples) = (0f64, 0f64, 0usize);
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
                let difference = 255.0 * (coverage - area(p0, p1, x, y));
                worst = worst.max(difference.abs());
                squares += difference * difference;
                samples += 1;
            }
        }
    }
    vec![max, weighed / weight, off as f64, worst, (squares / samples.max(1) as f64).sqrt()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_midpoint_rule_keeps_ties_on_the_major_axis() {
        assert_eq!(midpoint_rule([0, 0], [4, 2]), [[0, 0], [1, 0], [2, 1], [3, 1], [4, 2]]);
        assert_eq!(midpoint_rule([4, 2], [0, 0]), [[4, 2], [3, 2], [2, 1], [1, 1], [0, 0]]);
        assert_eq!(midpoint_rule([3, 3], [3, 3]), [[3, 3]]);
        assert!((area([0, 0], [9, 0], 4, 0) - 1.0).abs() < 1e-12);
        assert!((area([0, 0], [9, 0], 0, 0) - 0.5).abs() < 1e-12);
        assert_eq!((area([0, 0], [9, 0], 4, 2), area([3, 3], [3, 3], 3, 3)), (0.0, 0.0));
    }
}
