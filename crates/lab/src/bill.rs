//! The bill of one frame: what each stage cost beside what the plan said.
//!
//! In: a scene with its options, drawn by a renderer. Out: for each part of the plan the items and
//! bytes that were planned and those of this frame, and its time. The pipeline reads no clock: the
//! time of a part is that of the frame less that of the same frame without it. Where others hide
//! faces by it (culling, depth), leaving it out costs, and the time is negative: so much is saved.

use super::clock::{self, Timing};
use fbptr_core::memory::{DepthFormat, VideoMemory};
use fbptr_core::pipeline::{
    DrawStats, Part, PathCounts, PipelineError, Plan, Renderer, SceneOptions, Target,
};
use fbptr_core::scene::{Cull, HiddenSurface, Scene};
use std::fmt;
use std::sync::Arc;
use std::time::Duration;

/// Time budget of the frame, and of the frame without each part.
const BUDGET: Duration = Duration::from_millis(40);

/// One part of a bill.
#[derive(Clone, Debug, PartialEq)]
pub struct BillItem {
    /// The part.
    pub part: Part,
    /// Items and bytes that the plan says.
    pub planned: [u64; 2],
    /// Items of this frame, where the renderer counts them.
    pub count: Option<u64>,
    /// Bytes of this frame, where they can be told apart.
    pub bytes: Option<u64>,
    /// Seconds of the frame less those without the part; `None` where it cannot be left out alone,
    /// or the difference is within the quartiles.
    pub seconds: Option<f64>,
}

/// Costs of one frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Bill {
    /// Timing of the whole frame.
    pub frame: Timing,
    /// Bytes that the renderer keeps, and those that the plan allows at most.
    pub working_bytes: [u64; 2],
    /// The parts that the plan uses.
    pub items: Vec<BillItem>,
}

/// Parts that are left out together, as one way to draw the frame without them.
type Without = (Part, fn(&mut Scene, &mut SceneOptions));

/// Parts that a frame can be drawn without.
const LEFT_OUT: [Without; 8] = [
    (Part::DepthMemory, |_, options| options.hide = HiddenSurface::None),
    (Part::CullFaces, |scene, _| scene.objects.iter_mut().for_each(|o| o.cull = Cull::None)),
    (Part::LightFaces, |scene, _| scene.lights.clear()),
    (Part::LightVertices, |scene, _| scene.lights.clear()),
    (Part::LightPixels, |scene, _| scene.lights.clear()),
    (Part::Fog, |scene, _| scene.fog = None),
    (Part::SampleTextures, |scene, _| without_textures(scene)),
    (Part::SurfaceMaps, |scene, _| scene.objects.iter_mut().for_each(|o| o.style.maps = None)),
];

/// Removes all textures.
fn without_textures(scene: &mut Scene) {
    for o in &mut scene.objects {
        o.texture = None;
        o.style.stages = None;
        if o.geometry.textures.iter().any(Option::is_some) {
            Arc::make_mut(&mut o.geometry).textures.iter_mut().for_each(|t| *t = None);
        }
    }
}

/// Draws a scene again and again, each time without another part.
///
/// # Errors
/// As the renderer's.
pub fn bill(
    renderer: &mut Renderer,
    [width, height]: [u32; 2],
    scene: &Scene,
    options: &SceneOptions,
) -> Result<Bill, PipelineError> {
    let mut draw = |scene: &Scene, options: &SceneOptions| drawn(renderer, [width, height], scene, options);
    let whole = draw(scene, options)?;
    let mut items = Vec::new();
    for item in whole.plan.items().iter().filter(|i| i.used) {
        let seconds = match LEFT_OUT.iter().find(|(part, _)| *part == item.part) {
            Some((_, leave_out)) => {
                let (mut scene, mut options) = (scene.clone(), options.clone());
                leave_out(&mut scene, &mut options);
                difference(&whole.timing, &draw(&scene, &options)?.timing)
            }
            None => None,
        };
        items.push(BillItem {
            part: item.part,
            planned: [item.count, item.bytes],
            count: count_of(item.part, &whole),
            bytes: match item.part {
                Part::VideoMemory => Some(4 * u64::from(width) * u64::from(height)),
                Part::DepthMemory => whole.depth_bytes,
                _ => None,
            },
            seconds,
        });
    }
    Ok(Bill { frame: whole.timing, working_bytes: [whole.kept_bytes, whole.plan.working_bytes()], items })
}

/// Returns a - b if the quartiles are apart.
fn difference(a: &Timing, b: &Timing) -> Option<f64> {
    let is_apart = a.quartiles_s[0] > b.quartiles_s[2] || b.quartiles_s[0] > a.quartiles_s[2];
    is_apart.then(|| a.median_s() - b.median_s())
}

/// One frame, drawn several times.
struct DrawnFrame {
    plan: Plan,
    stats: DrawStats,
    paths: PathCounts,
    timing: Timing,
    depth_bytes: Option<u64>,
    kept_bytes: u64,
}

fn drawn(
    renderer: &mut Renderer,
    [width, height]: [u32; 2],
    scene: &Scene,
    options: &SceneOptions,
) -> Result<DrawnFrame, PipelineError> {
    let mut memory =
        VideoMemory::new(width, height).map_err(|_| PipelineError::NotFinite { what: "the frame's size" })?;
    let (mut depth, depth_format) = (None, DepthFormat::default());
    // Facts about the meshes are kept from here on.
    renderer.release();
    let target = Target { memory: &mut memory, depth: &mut depth, depth_format, ids: None };
    let plan = renderer.plan_scene(&target, scene, options);
    let mut draw = |renderer: &mut Renderer| {
        let mut target = Target { memory: &mut memory, depth: &mut depth, depth_format, ids: None };
        if let Some(depth) = target.depth {
            depth.clear();
        }
        renderer.draw_scene(&mut target, scene, options)
    };
    let stats = draw(renderer)?;
    let paths = renderer.path_counts();
    let (_, timing) = clock::time(BUDGET, || draw(renderer).is_ok());
    let depth_bytes = depth.map(|d| d.size_bytes() as u64);
    Ok(DrawnFrame { plan, stats, paths, timing, depth_bytes, kept_bytes: renderer.size_bytes() as u64 })
}

/// Returns the items of a part that a frame had.
fn count_of(part: Part, frame: &DrawnFrame) -> Option<u64> {
    let (stats, paths) = (&frame.stats, &frame.paths);
    match part {
        Part::VideoMemory => Some(stats.pixels_written),
        Part::DepthMemory => Some(stats.pixels_tested),
        Part::TransformVertices => Some(stats.vertices),
        Part::CutFaces => Some(stats.faces_cut),
        Part::CullFaces => Some(stats.faces_culled),
        Part::LightFaces | Part::LightVertices => Some(stats.vertices_lit),
        Part::LightPixels => Some(stats.pixels_lit),
        Part::Coverage => Some(stats.faces_drawn),
        Part::Lines => Some(stats.lines_drawn),
        Part::Points => Some(stats.points_drawn),
        Part::CoarseDepth => Some(stats.faces_hidden),
        Part::TileRenderer => Some(paths.tiles),
        Part::FacesInOrder => Some(paths.vectors + paths.reference),
        _ => None,
    }
}

/// Returns the unit of a part's count in a frame, which is finer than the plan's for some.
fn unit_of(part: Part) -> &'static str {
    match part {
        Part::VideoMemory => "pixels written",
        Part::DepthMemory => "pixels tested",
        Part::CutFaces => "faces cut",
        Part::CullFaces => "faces culled",
        Part::LightPixels => "pixels lit",
        Part::Coverage => "faces drawn",
        Part::CoarseDepth => "faces hidden",
        _ => part.as_str().1,
    }
}

impl fmt::Display for Bill {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let milliseconds = |s: f64| 1e3 * s;
        let [low, median, high] = self.frame.quartiles_s.map(milliseconds);
        writeln!(
            f,
            "bill: this frame in {median:.3} ms ({low:.3} to {high:.3}, {} draws); {} bytes kept by the renderer, at most {} planned",
            self.frame.samples() * self.frame.runs,
            self.working_bytes[0],
            self.working_bytes[1]
        )?;
        for item in &self.items {
            let (name, unit) = item.part.as_str();
            write!(f, "  {name:<18} planned {} {unit}, {} bytes;", item.planned[0], item.planned[1])?;
            match item.count {
                Some(count) => write!(f, " was {count} {}", unit_of(item.part))?,
                None => write!(f, " not counted")?,
            }
            if let Some(bytes) = item.bytes {
                write!(f, ", {bytes} bytes")?;
            }
            match item.seconds.map(milliseconds) {
                Some(ms) if ms < 0.0 => writeln!(f, "; saved {:.3} ms", -ms)?,
                Some(ms) => writeln!(f, "; cost {ms:.3} ms")?,
                None => writeln!(f)?,
            }
        }
        writeln!(
            f,
            "  times: the frame less the same frame without the part; none where that is within the spread"
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fbptr_core::pipeline::RenderOptions;
    use fbptr_truth::scenes::lit_triangle;

    #[test]
    fn a_frame_is_billed_for_the_parts_of_its_plan() {
        let mut renderer = Renderer::new(RenderOptions::default());
        let bill = bill(&mut renderer, [64, 48], &lit_triangle(), &SceneOptions::new(64, 48)).unwrap();
        let of = |part| bill.items.iter().find(|i| i.part == part);
        let lit = of(Part::LightPixels).unwrap();
        let written = of(Part::VideoMemory).unwrap();
        assert_eq!((lit.planned[0], lit.count), (1, written.count));
        assert!(written.count.unwrap() > 300 && of(Part::SampleTextures).is_none());
        assert_eq!(of(Part::DepthMemory).unwrap().bytes, Some(64 * 48 * 4));
        assert_eq!(of(Part::TransformVertices).unwrap().count, Some(3));
        let text = bill.to_string();
        assert!(text.starts_with("bill: this frame in ") && text.contains("pixels lit"), "{text}");
    }

    #[test]
    fn times_within_the_spread_are_not_told_apart() {
        let timing = |[low, median, high]: [f64; 3]| Timing::of(&[low, low, median, high, high], 1);
        let [a, b, c] = [[1.0, 2.0, 3.0], [2.5, 3.5, 4.5], [4.0, 5.0, 6.0]].map(timing);
        assert_eq!(
            (difference(&a, &b), difference(&a, &c), difference(&c, &a)),
            (None, Some(-3.0), Some(3.0))
        );
    }
}
