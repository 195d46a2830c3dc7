//! Depth formats: the smallest separation that each keeps in order, compared with theory.

use super::experiment::{Bound, Check, Effort, Experiment, Row, Standing, Truth};
use super::picture::{BenchFrame, drawn_in_turns};
use fbptr_core::memory::DepthFormat;
use fbptr_core::scene::{
    Camera, Corner, Cull, LightingModel, LookAt, Material, Mesh, NONE, Projection, Scene,
};
use fbptr_truth::scenes::{Case, Random, object};
use fbptr_truth::{DoubleDouble, Settings};
use glam::DVec3;

/// Experiment on depth formats.
pub(super) const DEPTH: Experiment = Experiment {
    id: "depth",
    title: "Depth formats",
    about: "Pairs of squares that face the eye at about the geometric mean of near and far, a relative separation apart, drawn by \
            the renderer, every other pair with the nearer first. The smallest separation, in steps of the fourth root of 2, at \
            which the nearer is seen in every pair; beside it the theory: one step (or ulp) of the format, times d (f - n) / \
            (f n).",
    truth: Truth {
        is: "the spacing of the format's values, over the slope of z = f (d - n) / (d (f - n))",
        digits: "15",
        second_way: "z at both ends of that separation with 32 digits: their distance in spacings, less 1",
    },
    check,
    columns: &["smallest separation kept, part of d", "theory, part of d", "measured / theory"],
    plotted: 0,
    unit: "pixel",
    rows,
};

/// Pairs with one distance between near and far.
#[derive(Clone, Copy)]
struct Range {
    decade: i32,
    far: f64,
    /// Geometric mean of near, 1, and far.
    middle: f64,
}

impl Range {
    fn all() -> impl Iterator<Item = Range> {
        (1..=7).map(|decade| {
            let far = libm::pow(10.0, f64::from(decade));
            Range { decade, far, middle: far.sqrt() }
        })
    }

    /// Returns z = f (d - 1) / (d (f - 1)) and 1 - z = (f - d) / (d (f - 1)) in the middle, without
    /// cancellation.
    fn depths(self) -> (f64, f64) {
        let (far, d) = (self.far, self.middle);
        let scale = 1.0 / (d * (far - 1.0));
        (far * (d - 1.0) * scale, (far - d) * scale)
    }

    /// Returns the separation, as a part of the distance, that is one step of the format in the
    /// middle.
    fn theory(self, format: DepthFormat) -> f64 {
        self.spacing(format) * self.middle * (self.far - 1.0) / self.far
    }

    /// Returns the spacing of the format's values in the middle.
    fn spacing(self, format: DepthFormat) -> f64 {
        let (z, complement) = self.depths();
        match format {
            DepthFormat::U16 => 1.0 / 65_535.0,
            DepthFormat::U24 => 1.0 / 16_777_215.0,
            DepthFormat::U32 => 1.0 / 4_294_967_295.0,
            DepthFormat::F32 => fbptr_truth::ulp_f32(z),
            DepthFormat::Reversed => fbptr_truth::ulp_f32(complement),
        }
    }
}

/// Grid of pairs on a frame.
struct Pairs {
    columns: u32,
    rows: u32,
    /// Side of a pair's cell in pixels.
    cell: u32,
    /// Distances, in the middle of the range times 0.95 to 1.05.
    factors: Vec<f64>,
}

impl Pairs {
    fn new(effort: &Effort, seed: u64) -> Pairs {
        let (columns, rows, cell) = effort.pick((16, 13, 4), (50, 40, 8));
        let mut r = Random::new(seed);
        let factors = (0..columns * rows).map(|_| r.real(0.95, 1.05)).collect();
        Pairs { columns, rows, cell, factors }
    }

    /// Returns the pairs at a separation as a case: the nearer square is white, the farther black.
    fn case(&self, range: Range, format: DepthFormat, separation: f64) -> Case {
        let mut mesh = Mesh::default();
        let unlit = |level| Material {
            emissive: DVec3::splat(level),
            kd: DVec3::ZERO,
            model: LightingModel::Unlit,
            ..Material::default()
        };
        mesh.materials = vec![unlit(1.0), unlit(0.25)];
        let aspect = f64::from(self.columns) / f64::from(self.rows);
        for (i, factor) in (0..).zip(&self.factors) {
            let near = range.middle * factor;
            let both = [(near, 0), (near * (1.0 + separation), 1)];
            let order = if i % 2 == 0 { [1, 0] } else { [0, 1] };
            for (d, material) in order.map(|k| both[k]) {
                // The cell in NDC, a tenth smaller on each side; the angle is 90 degrees.
                let ndc = |k: u32, n: u32, part: f64| 2.0 * (f64::from(k) + part) / f64::from(n) - 1.0;
                let xs = [0.1, 0.9].map(|p| ndc(i % self.columns, self.columns, p) * aspect * d);
                let ys = [0.9, 0.1].map(|p| -ndc(i / self.columns, self.rows, p) * d);
                let first = mesh.positions.len() as u32;
                let corners = [[xs[0], ys[0]], [xs[1], ys[0]], [xs[1], ys[1]], [xs[0], ys[1]]];
                mesh.positions.extend(corners.map(|[x, y]| DVec3::new(x, y, -d)));
                let corner = |k| Corner { position: first + k, normal: NONE, texcoord: NONE, color: NONE };
                mesh.push_polygon(&[0, 1, 2, 3].map(corner), material);
            }
        }
        let mut pairs = object("pairs", mesh);
        pairs.cull = Cull::None;
        let look_at = LookAt { eye: DVec3::ZERO, reference: DVec3::NEG_Z, up: DVec3::Y };
        let fov_rad = std::f64::consts::FRAC_PI_2;
        let projection =
            Projection::Perspective { fov_rad, near: 1.0, far: range.far, on_smaller_side: false };
        Case {
            name: "pairs".into(),
            scene: Scene {
                camera: Some(Camera { look_at, projection }),
                objects: vec![pairs],
                ..Scene::default()
            },
            settings: Settings::default(),
            format,
            width: self.columns * self.cell,
            height: self.rows * self.cell,
        }
    }

    /// Draws smaller and smaller separations, from eight times the theory down, until a pair is lost.
    fn search(&self, effort: &Effort, range: Range, format: DepthFormat) -> Search {
        let (width, height) = (self.columns * self.cell, self.rows * self.cell);
        let mut frame = BenchFrame::new(effort.renderer(), width, height);
        let mut search = Search::new();
        let first = (-4.0 * libm::log2(8.0 * range.theory(format))).floor().max(4.0) as i32;
        for k in first.. {
            let separation = libm::exp2(-f64::from(k) / 4.0);
            frame.draw_case(&self.case(range, format, separation));
            search.push((separation, self.lost(frame.memory.bytes())));
            if search.last().is_some_and(|(_, lost)| *lost > 0) {
                break;
            }
        }
        search
    }

    /// Counts the pairs of a picture whose middle is not white.
    fn lost(&self, bytes: &[u8]) -> usize {
        let middle = |i: u32| {
            let [x, y] = [i % self.columns, i / self.columns].map(|k| k * self.cell + self.cell / 2);
            4 * (self.columns * self.cell * y + x) as usize
        };
        (0..self.columns * self.rows).filter(|&i| bytes[middle(i)] != 255).count()
    }
}

/// Compares the spacing with the distance of both ends' z, in 32 digits.
fn check(_: &Effort) -> Check {
    let one = DoubleDouble::ONE;
    let mut difference = 0f64;
    for range in Range::all() {
        let far = DoubleDouble::new(range.far);
        let z = |d: DoubleDouble| far * (d - one) / (d * (far - one));
        for format in DepthFormat::ALL {
            let (d, s) = (DoubleDouble::new(range.middle), DoubleDouble::new(range.theory(format)));
            // The slope falls by 1 + s over the separation, exactly.
            let steps = (z(d * (one + s)) - z(d)) * (one + s) / DoubleDouble::new(range.spacing(format));
            difference = difference.max((steps - one).abs().to_f64());
        }
    }
    Check { difference, at_most: 1e-12 }
}

/// Steps of a search: separations from large to small, each with the pairs lost.
type Search = Vec<(f64, usize)>;

/// Returns the last separation before a pair is lost.
fn kept(search: &Search) -> f64 {
    let whole = search.iter().take_while(|(_, lost)| *lost == 0);
    whole.last().map_or(f64::INFINITY, |(separation, _)| *separation)
}

fn bound(format: DepthFormat, theory: f64) -> Bound {
    // d up to 1.05 of the middle, one step of the search, and a slope that falls over the separation.
    let places = 1.05 * libm::exp2(0.25) * (1.0 + 2.0 * theory);
    match format {
        DepthFormat::F32 | DepthFormat::Reversed => Bound {
            column: 2,
            at_most: 2.0 * places,
            because: "rounded to the nearest f32: an ulp, twice that where d is in the next binade; d to 1.05 of the \
                      middle; a step of the search",
        },
        _ => Bound {
            column: 2,
            at_most: 1.002 * places,
            because: "within 0.501 of a step, so 1.002 steps apart; d to 1.05 of the middle; a step of the search",
        },
    }
}

fn rows(effort: &Effort) -> Vec<Row> {
    let mut rows = Vec::new();
    for range in Range::all() {
        let pairs = Pairs::new(effort, 1974 + range.decade as u64);
        let searches = DepthFormat::ALL.map(|format| pairs.search(effort, range, format));
        let formats = DepthFormat::ALL.into_iter().zip(&searches);
        let at_kept = |(format, search)| pairs.case(range, format, kept(search).min(0.5));
        let cases: Vec<Case> = formats.clone().map(at_kept).collect();
        for ((format, search), (bytes, timing)) in formats.zip(drawn_in_turns(effort, &cases)) {
            let theory = range.theory(format);
            let judge = |search: &Search| vec![kept(search), theory, kept(search) / theory];
            let mutate = |search: &mut Search, bound: &Bound| {
                search
                    .iter_mut()
                    .filter(|(s, _)| *s <= bound.at_most * theory)
                    .for_each(|(_, lost)| *lost = 1)
            };
            let is_default = format == DepthFormat::default();
            let standing = if is_default { Standing::Default } else { Standing::Mode };
            let subject = format!("near : far = 1 : 1e{}", range.decade);
            let key = (&subject[..], format.as_str(), standing);
            let row = Row::judged(effort, key, search, vec![bound(format, theory)], judge, mutate);
            rows.push(row.timed(timing, (bytes.len() / 4) as f64));
        }
    }
    rows
}
