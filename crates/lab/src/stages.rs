//! Stages present and absent: what the plan leaves out, and what that saves.

use super::all_stages::all_stages;
use super::clock::Work;
use super::experiment::{Bound, Check, Effort, Experiment, Row, Standing, Truth};
use super::picture::{Compared, draw_case};
use super::report::Report;
use super::threads::knot;
use fbptr_core::memory::{DepthFormat, DepthMemory, PickBuffer, VideoMemory};
use fbptr_core::pipeline::{DepthUse, Renderer, SceneOptions, Target};
use fbptr_core::scene::{Filter, Fog, FogKind, LightingModel, Material, Sampling, Scene, Texture};
use fbptr_truth::scenes::{Case, box_mesh, object};
use fbptr_truth::{Settings, Transparency};
use glam::DVec3;
use std::sync::Arc;

/// Experiment on stages left out.
pub(super) const STAGES: Experiment = Experiment {
    id: "stages",
    title: "Stages present and absent",
    about: "Scenes drawn as their plan says, and by a renderer made to run every stage that keeps the picture: depth and the pick \
            buffer kept, faces lit, textured and fogged although none of it shows (`fbptr render --all-stages`). 1,000 pixels \
            drawn at random are compared with the truth.",
    truth: Truth {
        is: "the scene's own picture",
        digits: "positions 32, lighting 15",
        second_way: "the plain path, a program apart, at the same pixels; the largest difference in 1/255",
    },
    check,
    columns: &[
        "largest error at compared pixels, 1/255",
        "parts of the plan that run",
        "bytes of memories and tables",
    ],
    plotted: 2,
    unit: "pixel",
    rows,
};

const PLANNED: &str = "as planned";
const ALL: &str = "every stage run";

/// Returns the scenes, from few stages to all.
fn subjects(effort: &Effort) -> [(&'static str, Scene); 4] {
    let unlit = |emissive| Material { emissive, model: LightingModel::Unlit, ..Material::default() };
    let bare = |mesh, material| {
        let mut o = object("bare", mesh);
        o.material = material;
        Scene { objects: vec![o], ..Scene::default() }
    };
    let [nu, nv] = effort.pick([60, 12], [250, 20]);
    let lit = knot(nu, nv);
    let mut all = lit.clone();
    all.fog = Some(Fog { color: DVec3::ONE, kind: FogKind::Linear, visibility_range: 30.0 });
    for o in &mut all.objects {
        let bytes = (0..64u8).flat_map(|i| [200 + i % 8 * 4, 160 + i / 8 * 8, 120, 255]).collect();
        let texture = Arc::new(Texture::new(8, 8, bytes).expect("8 x 8 texels"));
        o.texture = Some((texture, Sampling { filter: Filter::Trilinear, ..Sampling::default() }));
    }
    let mut unlit_knot = lit.clone();
    unlit_knot.lights.clear();
    unlit_knot.objects[0].material = unlit(DVec3::new(0.2, 0.5, 0.9));
    [
        ("a convex box, unlit", bare(box_mesh(DVec3::new(1.2, 0.9, 0.7)), unlit(DVec3::new(0.9, 0.4, 0.1)))),
        ("a knot, unlit", unlit_knot),
        ("a knot, Phong", lit),
        ("a knot, Phong, textured, in fog", all),
    ]
}

fn case(effort: &Effort, scene: Scene) -> Case {
    let (width, height) = effort.pick((320, 240), (640, 480));
    let transparency = Transparency::AfterOpaque(Default::default());
    Case {
        name: "stages".into(),
        scene,
        settings: Settings { transparency, ..Settings::default() },
        format: DepthFormat::F32,
        width,
        height,
    }
}

fn check(effort: &Effort) -> Check {
    let difference = subjects(effort).into_iter().fold(0f64, |worst, (_, scene)| {
        let case = case(effort, scene);
        worst.max(Compared::new(&case).largest_error(draw_case(&case).memory.bytes()))
    });
    Check { difference, at_most: 2.0 }
}

/// Buffers of a frame that may keep depth and faces.
struct Frame {
    renderer: Renderer,
    memory: VideoMemory,
    depth: Option<DepthMemory>,
    ids: Option<PickBuffer>,
}

impl Frame {
    fn new(effort: &Effort, case: &Case, has_ids: bool) -> Frame {
        Frame {
            renderer: effort.renderer(),
            memory: VideoMemory::new(case.width, case.height).expect("a case's frame is small"),
            depth: None,
            ids: has_ids.then(|| PickBuffer::new(case.width, case.height)),
        }
    }

    /// Returns the renderer and what it draws on.
    fn split(&mut self) -> (&mut Renderer, Target<'_>) {
        let Frame { renderer, memory, depth, ids } = self;
        (renderer, Target { memory, depth, depth_format: DepthFormat::F32, ids: ids.as_mut() })
    }

    /// Clears and draws.
    fn draw(&mut self, scene: &Scene, options: &SceneOptions) {
        self.memory.clear(VideoMemory::CLEAR);
        if let Some(depth) = &mut self.depth {
            depth.clear();
        }
        if let Some(ids) = &mut self.ids {
            ids.clear();
        }
        let (renderer, mut target) = self.split();
        renderer.draw_scene(&mut target, scene, options).expect("a scene of the program's own making");
    }

    /// Returns the number of parts that the plan uses, and its bytes.
    fn plan(&mut self, scene: &Scene, options: &SceneOptions) -> [f64; 2] {
        let (renderer, target) = self.split();
        let plan = renderer.plan_scene(&target, scene, options);
        let parts = plan.items().iter().filter(|i| i.used).count();
        [parts as f64, plan.bytes() as f64]
    }
}

fn rows(effort: &Effort) -> Vec<Row> {
    let limit =
        Bound { column: 0, at_most: 2.0, because: "the limit of textured colours, by the specification" };
    let mut rows = Vec::new();
    for (subject, scene) in subjects(effort) {
        let case = case(effort, scene);
        let compared = Compared::new(&case);
        let planned =
            SceneOptions { depth_use: DepthUse::SceneOnly, ..SceneOptions::new(case.width, case.height) };
        let (forced, kept) = all_stages(&case.scene, &planned);
        let ways = [
            (PLANNED, Standing::Default, &case.scene, &planned),
            (ALL, Standing::Comparison, &forced, &kept),
        ];
        let mut frames = ways.map(|way| Frame::new(effort, &case, way.1 == Standing::Comparison));
        let mut works: Vec<Work<()>> = Vec::new();
        for ((_, _, scene, options), frame) in ways.iter().zip(&mut frames) {
            works.push(Box::new(|| frame.draw(scene, options)));
        }
        let timings = effort.run_in_turns(works);
        for (((name, standing, scene, options), frame), ((), timing)) in
            ways.iter().zip(&mut frames).zip(timings)
        {
            let plan = frame.plan(scene, options);
            let judge = |memory: &VideoMemory| vec![compared.largest_error(memory.bytes()), plan[0], plan[1]];
            let mutate =
                |memory: &mut VideoMemory, bound: &Bound| compared.raise(memory.bytes_mut(), bound.at_most);
            let row =
                Row::judged(effort, (subject, name, *standing), &frame.memory, vec![limit], judge, mutate);
            rows.push(row.timed(timing, f64::from(case.width * case.height)));
        }
    }
    rows
}

/// The cost of the stages that one scene's plan leaves out.
#[derive(Clone, Debug, PartialEq)]
pub struct Saving {
    /// The scene.
    pub scene: String,
    /// Parts that run only in a renderer made to run every stage.
    pub parts_left_out: f64,
    /// Bytes that they would take.
    pub bytes_saved: f64,
    /// Time with every stage over the time as planned, if both were measured.
    pub time_ratio: Option<f64>,
}

/// Returns what absence saves, scene by scene, as far as `report` has measured it.
pub fn savings(report: &Report) -> Vec<Saving> {
    let sections = report.sections.iter().filter(|s| s.experiment.id == STAGES.id);
    let saving = |(scene, rows): (&str, &[Row])| {
        let named = |name: &str| rows.iter().find(|r| r.alternative == name);
        let (planned, all) = (named(PLANNED)?, named(ALL)?);
        Some(Saving {
            scene: scene.into(),
            parts_left_out: all.errors[1] - planned.errors[1],
            bytes_saved: all.errors[2] - planned.errors[2],
            time_ratio: all.time_over(planned).map(|ratio| ratio[1]),
        })
    };
    sections.flat_map(|s| s.subjects()).filter_map(saving).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use fbptr_core::pipeline::Part;

    /// A scene made to run every stage is drawn by the path that draws the scene itself.
    #[test]
    fn every_stage_runs_on_the_path_of_the_scene() {
        let effort = Effort::QUICK.untimed();
        for (subject, scene) in subjects(&effort) {
            let case = case(&effort, scene);
            let planned = SceneOptions::new(case.width, case.height);
            let (forced, kept) = all_stages(&case.scene, &planned);
            let mut memory = VideoMemory::new(case.width, case.height).unwrap();
            let target =
                Target { memory: &mut memory, depth: &mut None, depth_format: DepthFormat::F32, ids: None };
            let renderer = effort.renderer();
            let plans =
                [(&case.scene, &planned), (&forced, &kept)].map(|(s, o)| renderer.plan_scene(&target, s, o));
            let parts = [Part::TileRenderer, Part::Fog, Part::SampleTextures, Part::LightPixels];
            assert!(plans[0].uses(parts[0]), "{subject}");
            assert!(parts.iter().all(|part| plans[1].uses(*part)), "{subject}:\n{}", plans[1]);
        }
    }
}
