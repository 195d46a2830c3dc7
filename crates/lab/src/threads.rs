//! Vector width and threads: identical bytes, different times.

use super::clock::Work;
use super::experiment::{Bound, Check, Effort, Experiment, Row, Standing, Truth};
use super::picture::{self, BenchFrame, Compared};
use fbptr_core::memory::{DepthFormat, VideoMemory};
use fbptr_core::pipeline::{RenderOptions, RenderPath, Renderer};
use fbptr_core::scene::{Scene, shapes};
use fbptr_core::simd::Level;
use fbptr_server::worker_pool;
use fbptr_truth::scenes::{Case, lit_triangle, object};
use fbptr_truth::{Settings, Transparency};
use glam::DVec3;

/// Experiment on vector widths and numbers of threads.
pub(super) const THREADS: Experiment = Experiment {
    id: "threads",
    title: "Vector width and threads",
    about: "A shaded knot drawn by the plain path, and by the fast one at every vector width and on one to three threads. 1,000 \
            pixels drawn at random are compared with the truth, and the whole picture with that of the next fast row. A width \
            that this machine lacks is not run.",
    truth: Truth {
        is: "Phong's equation on the nearest face at the pixel's centre",
        digits: "positions 32, lighting 15",
        second_way: "the plain path, a program apart, at the same pixels; the largest difference in 1/255",
    },
    check,
    columns: &["largest error at compared pixels, 1/255", "pixels unlike another fast row"],
    plotted: 0,
    unit: "pixel",
    rows,
};

/// Largest number of threads in the experiment.
const MOST_THREADS: usize = 3;

/// Returns a scene of a lit, Phong-shaded knot of 2 `nu` `nv` triangles.
pub(super) fn knot(nu: u32, nv: u32) -> Scene {
    let mut scene = lit_triangle();
    let mut knot = object("knot", shapes::knot(nu, nv).expect("a knot of more than 3 by 3"));
    knot.material.ks = DVec3::splat(0.4);
    knot.material.n = 20.0;
    let mesh = &knot.geometry.mesh;
    let radius = mesh.positions.iter().fold(0.0f64, |m, p| m.max(p.length()));
    knot.model = glam::DMat4::from_scale(DVec3::splat(1.8 / radius));
    scene.objects = vec![knot];
    scene
}

/// Returns the default number of threads of a program.
fn usual_threads() -> usize {
    std::thread::available_parallelism().map_or(1, |n| n.get())
}

/// Returns the number of threads, of those measured, that a program has by default.
pub(super) fn default_threads() -> usize {
    usual_threads().min(MOST_THREADS)
}

/// Returns the standing of a row of the default width on this many threads. Another number draws
/// the same picture, and whether it is faster for work of a tenth of a millisecond is up to the
/// system's scheduler: it is for comparison.
pub(super) fn standing_of(threads: usize, is_default_width: bool) -> Standing {
    match threads == default_threads() {
        false => Standing::Comparison,
        true if is_default_width => Standing::Default,
        true => Standing::Mode,
    }
}

/// Returns the knot as a case.
fn case(effort: &Effort) -> Case {
    let (width, height) = effort.pick((320, 240), (1280, 960));
    Case {
        name: "knot".into(),
        scene: knot(effort.pick(120, 400), effort.pick(24, 60)),
        settings: Settings {
            transparency: Transparency::AfterOpaque(Default::default()),
            ..Settings::default()
        },
        format: DepthFormat::F32,
        width,
        height,
    }
}

fn check(effort: &Effort) -> Check {
    let case = case(effort);
    let plain = picture::draw_case(&case);
    Check { difference: Compared::new(&case).largest_error(plain.memory.bytes()), at_most: 1.0 }
}

/// Returns the rows' names with their options and standings; `None` for a width that is not here.
fn ways() -> Vec<(String, RenderPath, Level, usize, Standing)> {
    let plain = ("plain path, 1 thread".to_owned(), RenderPath::Plain, Level::Portable, 1, Standing::Mode);
    let mut ways = vec![plain];
    for level in Level::ALL {
        for threads in 1..=MOST_THREADS {
            let plural = if threads == 1 { "" } else { "s" };
            let name = format!("{} vectors, {threads} thread{plural}", level.as_str());
            let standing = standing_of(threads, level == Level::best());
            ways.push((name, RenderPath::Fast, level, threads, standing));
        }
    }
    ways
}

fn rows(effort: &Effort) -> Vec<Row> {
    let case = case(effort);
    let compared = Compared::new(&case);
    let subject = format!("a knot of {} triangles", case.scene.objects[0].geometry.mesh.triangles.len());
    let bound = |column, at_most, because| Bound { column, at_most, because };
    let of_truth = bound(0, 1.0, "the limit of untextured colours, by the specification");
    let of_bytes =
        bound(1, 0.0, "every width and number of threads computes each pixel by the same operations");
    let ways = ways();
    let mut frames: Vec<Option<BenchFrame>> = Vec::new();
    for (_, path, level, threads, _) in &ways {
        let (pool, simd) = (worker_pool(Some(*threads)), Some(*level));
        let options = RenderOptions { pool, simd, path: *path, ..RenderOptions::default() };
        let frame = || BenchFrame::new(Renderer::new(options), case.width, case.height);
        frames.push(level.is_available().then(frame));
    }
    let mut works: Vec<Work<()>> = Vec::new();
    for frame in frames.iter_mut().flatten() {
        works.push(Box::new(|| frame.draw(&case.scene)));
    }
    let mut timings = effort.run_in_turns(works).into_iter();
    let mut drawn = Vec::new();
    for ((name, path, _, _, standing), frame) in ways.into_iter().zip(frames) {
        let run = frame.and_then(|frame| Some((frame.memory, timings.next()?.1)));
        drawn.push((name, path, standing, run));
    }
    let fast =
        || drawn.iter().filter(|d| d.1 == RenderPath::Fast).filter_map(|d| Some((&d.0, &d.3.as_ref()?.0)));
    let mut rows = Vec::new();
    for (name, path, standing, run) in &drawn {
        let Some((memory, timing)) = run else {
            rows.push(Row::not_run(subject.clone(), name.clone(), THREADS.columns.len()));
            continue;
        };
        // The next fast row after this one, the first after the last.
        let next = fast().skip_while(|(other, _)| *other != name).nth(1).or_else(|| fast().next());
        let other = next.map_or(memory, |(_, memory)| memory);
        let judge = |memory: &VideoMemory| {
            let unlike = memory.bytes().chunks_exact(4).zip(other.bytes().chunks_exact(4));
            let unlike = unlike.filter(|(a, b)| a != b).count();
            vec![compared.largest_error(memory.bytes()), unlike as f64]
        };
        let mutate = |memory: &mut VideoMemory, bound: &Bound| match bound.column {
            0 => compared.raise(memory.bytes_mut(), bound.at_most),
            _ => memory.bytes_mut()[0] ^= 1,
        };
        let bounds = match path {
            RenderPath::Plain => vec![of_truth],
            RenderPath::Fast => vec![of_truth, of_bytes],
        };
        let row = Row::judged(effort, (&subject, name, *standing), memory, bounds, judge, mutate);
        rows.push(row.timed(timing.clone(), f64::from(case.width) * f64::from(case.height)));
    }
    rows
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_rows_of_the_default_number_of_threads_can_be_chosen() {
        let ways = ways();
        let defaults: Vec<_> = ways.iter().filter(|way| way.4 == Standing::Default).collect();
        let [(_, RenderPath::Fast, level, threads, _)] = defaults[..] else { panic!("{}", defaults.len()) };
        assert_eq!((*level, *threads), (Level::best(), default_threads()));
        for (name, path, level, threads, standing) in &ways {
            let is_fast = *path == RenderPath::Fast;
            let is_comparison = is_fast && *threads != default_threads();
            let is_default = is_fast && !is_comparison && *level == Level::best();
            assert_eq!(*standing == Standing::Comparison, is_comparison, "{name}");
            assert_eq!(*standing == Standing::Default, is_default, "{name}");
        }
    }
}
