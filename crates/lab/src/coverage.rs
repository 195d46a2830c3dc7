//! Coverage: gaps and double hits in a mesh that tiles the frame, by the renderer and by other
//! methods.

use super::clock::Work;
use super::coverage_drawn::{DrawnMesh, Hits};
use super::experiment::{Bound, Check, Effort, Experiment, Row, Standing, Truth};
use fbptr_core::math::coverage::{PixelRect, SnappedTriangle};
use fbptr_truth::scenes::Random;
use fbptr_truth::ulp_f32;

/// Experiment on coverage.
pub(super) const COVERAGE: Experiment = Experiment {
    id: "coverage",
    title: "Coverage",
    about: "A mesh without holes over the whole frame, its corners at random places. Gap: a pixel that no triangle has. Double: \
            one that several have. Off: a pixel not owned by just the triangle that holds its centre. The renderer draws the \
            mesh twice: every triangle in a colour of its own, which names the owner, and all of them half transparent, \
            which counts them; the time is that of the first.",
    truth: Truth {
        is: "the triangle whose unsnapped corners, multiples of 2^-24 pixel, hold the centre",
        digits: "all, whole numbers of 128 bits",
        second_way: "the mesh tiles the frame, so each centre has one owner; centres without",
    },
    check,
    columns: &["gaps", "double hits", "pixels off the unsnapped outline"],
    plotted: 2,
    unit: "pixel",
    rows,
};

pub(super) type Corners = [[f64; 2]; 3];
type Hit<'a> = &'a mut dyn FnMut(i32, i32);
type Way = fn(Corners, PixelRect, Hit);

fn exact(corners: Corners, clip: PixelRect, hit: Hit) {
    SnappedTriangle::new(corners).for_each_span(clip, |y, xs| xs.for_each(|x| hit(x, y)));
}

/// Coarser snapping: multiples of 1/16 and of 1 are multiples of 1/256, too.
fn snapped_to_16(corners: Corners, clip: PixelRect, hit: Hit) {
    exact(corners.map(|p| p.map(|v| (v * 16.0).round_ties_even() / 16.0)), clip, hit);
}

fn snapped_to_1(corners: Corners, clip: PixelRect, hit: Hit) {
    exact(corners.map(|p| p.map(f64::round_ties_even)), clip, hit);
}

/// Edge functions in f32, each corner rounded to f32, with a top-left rule for exact zeros.
fn edges_f32(corners: Corners, clip: PixelRect, hit: Hit) {
    let mut c = corners.map(|p| p.map(|v| v as f32));
    let doubled = |c: &[[f32; 2]; 3]| {
        (c[1][0] - c[0][0]) * (c[2][1] - c[0][1]) - (c[2][0] - c[0][0]) * (c[1][1] - c[0][1])
    };
    if doubled(&c) < 0.0 {
        c.swap(1, 2);
    }
    let ends = |k: usize, lo: i32, hi: i32| {
        let (min, max) = c.iter().fold((f32::MAX, f32::MIN), |(a, b), p| (a.min(p[k]), b.max(p[k])));
        (min.floor() as i32).max(lo)..(max.ceil() as i32 + 1).min(hi)
    };
    for y in ends(1, clip.y0, clip.y1) {
        for x in ends(0, clip.x0, clip.x1) {
            let p = [x as f32 + 0.5, y as f32 + 0.5];
            let inside = (0..3).all(|i| {
                let (a, b) = (c[i], c[(i + 1) % 3]);
                let d = [b[0] - a[0], b[1] - a[1]];
                let side = d[0] * (p[1] - a[1]) - d[1] * (p[0] - a[0]);
                side > 0.0 || (side == 0.0 && (d[1] < 0.0 || (d[1] == 0.0 && d[0] > 0.0)))
            });
            if inside {
                hit(x, y);
            }
        }
    }
}

/// Number of steps per pixel of all corners, so that the reference can decide in integers.
const PARTS: f64 = 16_777_216.0;

/// Returns whether the unsnapped triangle contains the centre of pixel (x, y), by the same top-left
/// rule.
fn holds(corners: &Corners, x: i32, y: i32) -> bool {
    let integer = |v: f64| (v * PARTS) as i128;
    let mut c = corners.map(|p| p.map(integer));
    let p = [integer(x as f64 + 0.5), integer(y as f64 + 0.5)];
    let doubled = (c[1][0] - c[0][0]) * (c[2][1] - c[0][1]) - (c[2][0] - c[0][0]) * (c[1][1] - c[0][1]);
    if doubled < 0 {
        c.swap(1, 2);
    }
    doubled != 0
        && (0..3).all(|i| {
            let (a, b) = (c[i], c[(i + 1) % 3]);
            let d = [b[0] - a[0], b[1] - a[1]];
            let side = d[0] * (p[1] - a[1]) - d[1] * (p[0] - a[0]);
            side > 0 || (side == 0 && (d[1] < 0 || (d[1] == 0 && d[0] > 0)))
        })
}

/// Returns a grid of cells with jittered corners, two triangles per cell, that tiles the square
/// from `origin` on with a margin.
fn tiling(origin: f64, side: f64, cell: [f64; 2]) -> Vec<Corners> {
    let mut r = Random::new(1988);
    let n = cell.map(|c| (side / c).ceil() as usize + 4);
    let mut corner = |i: usize, j: usize| {
        // Below a quarter of a cell every quad stays convex, so that no triangles overlap.
        let jitter = [r.real(-0.24, 0.24), r.real(-0.24, 0.24)];
        [i, j].iter().enumerate().fold([0.0; 2], |mut p, (k, &at)| {
            p[k] = ((origin + (at as f64 - 2.0 + jitter[k]) * cell[k]) * PARTS).round() / PARTS;
            p
        })
    };
    let points: Vec<Vec<[f64; 2]>> = (0..=n[1]).map(|j| (0..=n[0]).map(|i| corner(i, j)).collect()).collect();
    let mut triangles = Vec::new();
    for j in 0..n[1] {
        for i in 0..n[0] {
            let [a, b, c, d] = [points[j][i], points[j][i + 1], points[j + 1][i + 1], points[j + 1][i]];
            triangles.push([a, b, c]);
            // Every other one is reversed: coverage does not depend on the winding.
            triangles.push(if (i + j) % 2 == 0 { [a, c, d] } else { [d, c, a] });
        }
    }
    triangles
}

/// Returns slanted strips across the frame, 0.4 px wide and 50,000 px long, two triangles each:
/// their edge functions are differences of products far larger than the frame.
fn strips(side: f64) -> Vec<Corners> {
    let mut r = Random::new(1971);
    let reach = 20_000.0;
    let mut offset = -side - 2.0;
    let mut ends = Vec::new();
    while offset < side + 2.0 {
        let end = |at: f64, r: &mut Random| {
            [at, ((0.7654321 * at + offset + r.real(0.0, 0.2)) * PARTS).round() / PARTS]
        };
        ends.push([end(-reach, &mut r), end(reach, &mut r)]);
        offset += 0.5;
    }
    ends.windows(2).flat_map(|w| [[w[0][0], w[0][1], w[1][1]], [w[1][0], w[0][0], w[1][1]]]).collect()
}

/// Returns the largest distance in pixels that snapping may move an edge: half a diagonal of the
/// grid.
fn off_by_grid<const PARTS_OF_PIXEL: u32>(_: &Corners) -> f64 {
    0.5f64.sqrt() / f64::from(PARTS_OF_PIXEL)
}

/// Returns the largest distance in pixels that f32 may move an edge: half an ulp of the
/// coordinates, and eight roundings of an edge function of this extent.
fn off_by_f32(corners: &Corners) -> f64 {
    let largest = corners.iter().flatten().fold(0f64, |m, v| m.max(v.abs()));
    let extent = (0..3).fold(1f64, |m, i| {
        let (a, b) = (corners[i], corners[(i + 1) % 3]);
        m.max(libm::hypot(b[0] - a[0], b[1] - a[1]) + 1.0)
    });
    0.5f64.sqrt() * ulp_f32(largest) + 8.0 * extent / 16_777_216.0
}

/// Calls `hit` with the pixels of `clip` whose centres lie within `reach` of the segment from a to
/// b.
fn near_segment([a, b]: [[f64; 2]; 2], reach: f64, clip: PixelRect, hit: Hit) {
    let d = [b[0] - a[0], b[1] - a[1]];
    let length2 = d[0] * d[0] + d[1] * d[1];
    let first = |v: f64, lo: i32| ((v - 0.5).ceil() as i32).max(lo);
    let past = |v: f64, hi: i32| ((v - 0.5).floor() as i32).saturating_add(1).min(hi);
    for y in first(a[1].min(b[1]) - reach, clip.y0)..past(a[1].max(b[1]) + reach, clip.y1) {
        let center_y = f64::from(y) + 0.5;
        // The part of the segment that is within reach of the row.
        let along = [-reach, reach]
            .map(|r| if d[1] == 0.0 { r * f64::INFINITY } else { (center_y + r - a[1]) / d[1] });
        let ends = along.map(|t| a[0] + d[0] * t.clamp(0.0, 1.0));
        let (low, high) = (ends[0].min(ends[1]) - reach, ends[0].max(ends[1]) + reach);
        for x in first(low, clip.x0)..past(high, clip.x1) {
            let p = [f64::from(x) + 0.5 - a[0], center_y - a[1]];
            let t = ((p[0] * d[0] + p[1] * d[1]) / length2).clamp(0.0, 1.0);
            if libm::hypot(p[0] - t * d[0], p[1] - t * d[1]) <= reach {
                hit(x, y);
            }
        }
    }
}

/// Part of the frame that a mesh is drawn on, with the mesh.
struct Subject {
    name: &'static str,
    clip: PixelRect,
    mesh: Vec<Corners>,
}

impl Subject {
    /// Returns all subjects.
    fn all(effort: &Effort) -> Vec<Subject> {
        let side = effort.pick(128, 512);
        let length = f64::from(side);
        let far = 131_072;
        let subject = |name, origin, mesh| {
            let clip = PixelRect { x0: origin, y0: origin, x1: origin + side, y1: origin + side };
            Subject { name, clip, mesh }
        };
        vec![
            subject("triangles of 4 px", 0, tiling(0.0, length, [4.0, 4.0])),
            subject("slivers of 16 x 0.25 px", 0, tiling(0.0, length, [16.0, 0.25])),
            subject(
                "triangles of 4 px, 131072 px from the origin",
                far,
                tiling(f64::from(far), length, [4.0, 4.0]),
            ),
            subject("strips 50000 px long, 0.4 px wide", 0, strips(length)),
        ]
    }

    fn pixels(&self) -> usize {
        ((self.clip.x1 - self.clip.x0) * (self.clip.y1 - self.clip.y0)) as usize
    }

    fn index(&self, x: i32, y: i32) -> usize {
        ((self.clip.x1 - self.clip.x0) * (y - self.clip.y0) + x - self.clip.x0) as usize
    }

    /// Returns for every pixel how many unsnapped triangles hold its centre, and the last of them.
    fn owners(&self) -> Vec<(u32, u32)> {
        let mut owners = vec![(0, u32::MAX); self.pixels()];
        for (t, corners) in self.mesh.iter().enumerate() {
            // A margin of one pixel finds every centre that the unsnapped outline can contain.
            let reach = |k: usize, from: i32, to: i32| {
                let (lo, hi) =
                    corners.iter().fold((f64::MAX, f64::MIN), |(a, b), p| (a.min(p[k]), b.max(p[k])));
                (lo.floor() as i32 - 1).max(from)..(hi.ceil() as i32 + 1).min(to)
            };
            for y in reach(1, self.clip.y0, self.clip.y1) {
                for x in reach(0, self.clip.x0, self.clip.x1).filter(|&x| holds(corners, x, y)) {
                    let owner = &mut owners[self.index(x, y)];
                    *owner = (owner.0 + 1, t as u32);
                }
            }
        }
        owners
    }

    /// Returns the hits of a way for comparison.
    fn walked(&self, way: Way) -> Hits {
        let mut hits = vec![(0u32, u32::MAX); self.pixels()];
        for (t, &corners) in self.mesh.iter().enumerate() {
            way(corners, self.clip, &mut |x, y| {
                let at = &mut hits[self.index(x, y)];
                *at = (at.0 + 1, t as u32);
            });
        }
        hits
    }

    /// Counts the centres that are nearer to an edge than the edge may move.
    fn near_edges(&self, off_by: fn(&Corners) -> f64) -> usize {
        let mut is_near = vec![false; self.pixels()];
        for corners in &self.mesh {
            for i in 0..3 {
                let segment = [corners[i], corners[(i + 1) % 3]];
                near_segment(segment, off_by(corners), self.clip, &mut |x, y| {
                    is_near[self.index(x, y)] = true
                });
            }
        }
        is_near.iter().filter(|n| **n).count()
    }
}

fn check(effort: &Effort) -> Check {
    let owners = Subject::all(effort).into_iter().flat_map(|s| s.owners());
    Check { difference: owners.filter(|o| o.0 != 1).count() as f64, at_most: 0.0 }
}

/// Counts gaps, double hits, and pixels with another owner than the true one.
fn errors_of(hits: &Hits, owners: &[(u32, u32)]) -> Vec<f64> {
    let gaps = hits.iter().filter(|h| h.0 == 0).count();
    let double = hits.iter().filter(|h| h.0 > 1).count();
    let off = hits.iter().zip(owners).filter(|(h, o)| h.0 != 1 || h.1 != o.1).count();
    vec![gaps as f64, double as f64, off as f64]
}

/// Takes a pixel from its triangle, gives it to a second one, or gives as many pixels away as the
/// bound allows and one more.
fn mutate(hits: &mut Hits, bound: &Bound) {
    match bound.column {
        0 => hits[0].0 = 0,
        1 => hits[0].0 = 2,
        _ => hits.iter_mut().take(bound.at_most as usize + 1).for_each(|h| h.1 = u32::MAX),
    }
}

fn rows(effort: &Effort) -> Vec<Row> {
    let none = |column| Bound {
        column,
        at_most: 0.0,
        because: "neighbours share their snapped edges, and the fill rule",
    };
    type Off = fn(&Corners) -> f64;
    let ways: [(&str, Option<Way>, Off, Standing); 4] = [
        ("the renderer, 1/256 pixel", None, off_by_grid::<256>, Standing::Default),
        ("exact, 1/16 pixel", Some(snapped_to_16), off_by_grid::<16>, Standing::Comparison),
        ("exact, whole pixels", Some(snapped_to_1), off_by_grid::<1>, Standing::Comparison),
        ("edge functions in f32", Some(edges_f32), off_by_f32, Standing::Comparison),
    ];
    let mut rows = Vec::new();
    for subject in Subject::all(effort) {
        let owners = subject.owners();
        let mut drawn = DrawnMesh::new(effort, &subject.mesh, subject.clip);
        let subject = &subject;
        // The renderer's hits are read from its bytes, beside the clock.
        let mut works: Vec<Work<Option<Hits>>> = vec![Box::new(|| {
            drawn.draw();
            None
        })];
        for walk in ways.iter().filter_map(|way| way.1) {
            works.push(Box::new(move || Some(subject.walked(walk))));
        }
        let found = effort.run_in_turns(works);
        for ((name, _, off_by, standing), (hits, timing)) in ways.iter().zip(found) {
            let hits = hits.unwrap_or_else(|| drawn.hits(effort));
            let near = subject.near_edges(*off_by);
            let because =
                "centres nearer to an edge than it may move: half a diagonal of the grid, or f32's rounding";
            let most_off = Bound { column: 2, at_most: near as f64, because };
            let bounds = match standing {
                Standing::Comparison if near >= subject.pixels() => Vec::new(),
                // A coarser grid may fold slivers over, and f32 edges may leave gaps.
                Standing::Comparison => vec![most_off],
                _ => vec![none(0), none(1), most_off],
            };
            let key = (subject.name, *name, *standing);
            let row = Row::judged(effort, key, &hits, bounds, |hits| errors_of(hits, &owners), mutate);
            rows.push(row.timed(timing, subject.pixels() as f64));
        }
    }
    rows
}
