//! Workloads S1 to S7, each compared with the plain path: a room seen from inside, transparent
//! layers, thousands of small objects, a mesh of millions of faces, growing frames and numbers of
//! lights, occluded walls.

mod made;
mod pieces;

use super::check::Check;
use super::frame::SceneFrame;
use super::{BenchOptions, BenchRun, Workload};
use fbptr_core::memory::{DepthMemory, VideoMemory};
use fbptr_core::pipeline::{self, DrawCall, SceneOptions};
use fbptr_core::scene::Scene;
use fbptr_truth::{Settings, Transparency, TruthPicture};
#[cfg(test)]
use glam::{DMat4, DVec3};
use made::{boxes, knot, layers, lit_knot, mesh_of, model, room, walls};

/// Returns the name of whatever grows in a workload, and its steps; the last step is the workload
/// itself.
pub(super) fn steps(workload: Workload) -> Option<(&'static str, &'static [u32])> {
    match workload {
        Workload::Layers64 => Some(("fragments", &[1, 4, 16, 64])),
        Workload::Objects10k | Workload::Scene10k => Some(("objects", &[625, 2500, 10_000])),
        Workload::Mesh4M => Some(("faces", &[62_500, 250_000, 1_000_000, 4_000_000])),
        Workload::Sizes => Some(("pixels", &[0, 1, 2, 3, 4])),
        Workload::Lights => Some(("lights", &[1, 4, 16, 64])),
        _ => None,
    }
}

/// Frame sizes from VGA to 8K.
const FRAMES: [[u32; 2]; 5] = [[640, 480], [1280, 720], [1920, 1080], [3840, 2160], [7680, 4320]];

/// Number of draws that are handed to the renderer at once, as a stream does.
const DRAWS_AT_ONCE: usize = 128;

/// Way of drawing a scene.
#[derive(Clone, Copy, PartialEq)]
enum By {
    /// The whole scene in one call.
    Scene,
    /// One draw per object, as in a stream.
    Draws,
}

pub(super) struct Scenes {
    workload: Workload,
    on: SceneFrame,
    scene: Scene,
    options: SceneOptions,
    by: By,
    /// Current size of whatever grows.
    amount: f64,
}

impl Scenes {
    /// Creates the workload at a step.
    pub fn new(workload: Workload, options: &BenchOptions, step: u32) -> Self {
        let mut size = [options.size.width, options.size.height];
        let divisor = options.size.divisor.max(1);
        if workload == Workload::Sizes {
            // A smaller size scales the whole series of frames; a larger one does not.
            let width = options.size.width.min(1920);
            size = FRAMES[step as usize].map(|side| (side * width / 1920).max(1));
        }
        let [width, height] = size;
        let (mut scene, amount) = match workload {
            // Counted in the first frame: nearer layers are larger.
            Workload::Layers64 => (layers(step), 0.0),
            Workload::Objects10k | Workload::Scene10k => {
                let count = step.div_ceil(divisor.min(100));
                (boxes(count), f64::from(count))
            }
            Workload::Mesh4M => {
                let mesh = mesh_of(step / divisor);
                let faces = mesh.triangles.len() as f64;
                (knot(mesh), faces)
            }
            Workload::Sizes => (knot(mesh_of(20_000 / divisor)), f64::from(width) * f64::from(height)),
            Workload::Hidden => (walls(divisor), 1.0),
            Workload::Model(name) => (model(name, size), 1.0),
            Workload::Lights => (lit_knot(mesh_of(20_000 / divisor), step), f64::from(step)),
            _ => (room(divisor), 1.0),
        };
        scene.fog = options.air.fog();
        Scenes {
            workload,
            on: SceneFrame::new(options, size),
            scene,
            options: SceneOptions::new(width, height),
            by: if workload == Workload::Objects10k { By::Draws } else { By::Scene },
            amount,
        }
    }

    /// Draws by the plain path and returns its picture and depths.
    fn plain(&self) -> (VideoMemory, Option<DepthMemory>) {
        self.on.plain(|target| match self.by {
            By::Scene => {
                pipeline::draw_scene(target, &self.scene, &self.options).expect("the scene is sound");
            }
            By::Draws => self.scene.objects.iter().for_each(|object| {
                let call = DrawCall::of_object(object, &self.scene, &self.options);
                pipeline::draw(target, &call).expect("the scene is sound");
            }),
        })
    }

    /// Renders some pixels by the reference.
    fn reference(&self, pixels: &[[u32; 2]]) -> TruthPicture {
        let mut picture = self.on.reference();
        let transparency = match self.by {
            By::Scene => Transparency::AfterOpaque(self.options.transparency),
            By::Draws => Transparency::AtOnce,
        };
        let settings = Settings { transparency, ..Settings::default() };
        picture.draw_at(&self.scene, &settings, Some(pixels)).expect("the camera is sound");
        picture
    }

    /// Draws a frame with the first object moved.
    #[cfg(test)]
    pub fn frame_moved(&mut self, by: DVec3) {
        let right = self.scene.objects[0].model;
        self.scene.objects[0].model = DMat4::from_translation(by) * right;
        self.frame();
        self.scene.objects[0].model = right;
    }
}

impl BenchRun for Scenes {
    fn frame(&mut self) {
        let (scene, options) = (&self.scene, &self.options);
        let mut tested = 0;
        self.on.draw(|renderer, target| match self.by {
            By::Scene => {
                let stats = renderer.draw_scene(target, scene, options).expect("the scene is sound");
                tested = stats.pixels_tested;
            }
            By::Draws => scene.objects.chunks(DRAWS_AT_ONCE).for_each(|objects| {
                let call = |object| DrawCall::of_object(object, scene, options);
                let calls: Vec<DrawCall> = objects.iter().map(call).collect();
                for drawn in renderer.draw_all(target, &calls) {
                    drawn.expect("the scene is sound");
                }
            }),
        });
        if self.workload == Workload::Layers64 {
            self.amount = tested as f64;
        }
    }

    fn bytes(&self) -> &[u8] {
        self.on.memory.bytes()
    }

    fn spoil(&mut self) {
        self.on.spoil();
    }

    fn truth(&mut self) -> VideoMemory {
        self.plain().0
    }

    fn check(&mut self) -> Check {
        self.on.check(self.workload, &self.plain(), |pixels| self.reference(pixels))
    }

    fn amount(&self) -> f64 {
        self.amount
    }

    fn threads(&self) -> usize {
        self.on.threads()
    }

    fn simd(&self) -> &'static str {
        self.on.renderer.level().as_str()
    }
}
