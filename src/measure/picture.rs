//! Drawing of test cases by the pipeline and by the reference.

use super::clock::Timing;
use super::experiment::Effort;
use crate::memory::{DepthFormat, DepthMemory, PickBuffer, VideoMemory};
use crate::pipeline::{DrawCall, RenderOptions, RenderPath, Renderer, SceneOptions, Target};
use crate::scene::{Scene, Viewport, ViewportRule};
use crate::truth::scenes::Case;
use crate::truth::{Transparency, TruthPicture, render};

/// Buffers after the draws of a case.
#[derive(Clone, Debug)]
pub struct Drawn {
    /// Colours.
    pub memory: VideoMemory,
    /// Depth, if the draws needed one.
    pub depth: Option<DepthMemory>,
    /// Face that wrote the depth of each pixel; an object's name is its number.
    pub ids: PickBuffer,
}

/// Draws a case by the plain path: one draw per object, or the whole scene, as its settings say.
///
/// # Panics
/// If the case's frame cannot be allocated or its scene cannot be drawn: the program generates all
/// cases.
pub fn draw_case(case: &Case) -> Drawn {
    let mut memory = VideoMemory::new(case.width, case.height).expect("a case's frame is small");
    let mut ids = PickBuffer::new(case.width, case.height);
    let mut depth = None;
    let mut target =
        Target { memory: &mut memory, depth: &mut depth, depth_format: case.format, ids: Some(&mut ids) };
    let plain = RenderOptions { path: RenderPath::Plain, ..RenderOptions::default() };
    draw_into(&mut Renderer::new(plain), &mut target, case);
    Drawn { memory, depth, ids }
}

fn draw_into(renderer: &mut Renderer, target: &mut Target, case: &Case) {
    let s = &case.settings;
    let full_frame =
        Viewport { x: 0, y: 0, width: case.width, height: case.height, rule: ViewportRule::Corners };
    let viewport = s.viewport.unwrap_or(full_frame);
    match s.transparency {
        Transparency::AfterOpaque(transparency) => {
            let mut scene = case.scene.clone();
            for o in &mut scene.objects {
                o.cull = s.cull.unwrap_or(o.cull);
            }
            let options = SceneOptions {
                viewport,
                shade: s.shade,
                hide: s.hide,
                interp: s.interpolation,
                transparency,
                ..SceneOptions::new(case.width, case.height)
            };
            renderer.draw_scene(target, &scene, &options).expect("a case's scene can be drawn");
        }
        Transparency::AtOnce => {
            for (i, o) in case.scene.objects.iter().enumerate() {
                let call = DrawCall {
                    model: o.model,
                    camera: case.scene.camera.unwrap_or_default(),
                    viewport,
                    ambient: case.scene.ambient,
                    lights: &case.scene.lights,
                    light_subset: o.lights.as_deref(),
                    back_material: o.back_material.as_ref(),
                    texture: o.texture.as_ref().map(|t| &*t.0),
                    sampling: o.texture.as_ref().map(|t| t.1).unwrap_or_default(),
                    shade: o.shade.unwrap_or(s.shade),
                    cull: s.cull.unwrap_or(o.cull),
                    hide: s.hide,
                    interp: s.interpolation,
                    two_sided_lighting: o.two_sided_lighting,
                    fog: case.scene.fog,
                    name: i as u32,
                    ..DrawCall::new(&o.geometry, &o.material, case.width, case.height)
                };
                renderer.draw(target, &call).expect("a case's object can be drawn");
            }
        }
    }
}

/// Renderer with its buffers, which are reused from frame to frame as in a server.
pub(super) struct BenchFrame {
    renderer: Renderer,
    /// Colours of the frame.
    pub memory: VideoMemory,
    depth: Option<DepthMemory>,
}

impl BenchFrame {
    /// Creates a frame of `width` x `height` pixels.
    pub fn new(renderer: Renderer, width: u32, height: u32) -> BenchFrame {
        let memory = VideoMemory::new(width, height).expect("a frame of at most 8K");
        BenchFrame { renderer, memory, depth: None }
    }

    fn clear(&mut self) {
        self.memory.clear([0, 0, 0, 255]);
        if let Some(depth) = &mut self.depth {
            depth.clear();
        }
    }

    /// Clears colour and depth and draws a scene on the whole frame.
    pub fn draw(&mut self, scene: &Scene) {
        self.clear();
        let options = SceneOptions::new(self.memory.width(), self.memory.height());
        let (memory, depth) = (&mut self.memory, &mut self.depth);
        let mut target = Target { memory, depth, depth_format: DepthFormat::F32, ids: None };
        self.renderer.draw_scene(&mut target, scene, &options).expect("a scene of the program's own making");
    }

    /// Clears colour and depth and draws a case of the frame's size.
    pub fn draw_case(&mut self, case: &Case) {
        self.clear();
        let (memory, depth) = (&mut self.memory, &mut self.depth);
        let mut target = Target { memory, depth, depth_format: case.format, ids: None };
        draw_into(&mut self.renderer, &mut target, case);
    }
}

/// Draws a case with the default options, by the tile renderer on one thread. Returns its bytes and
/// timing.
pub(super) fn drawn_as_usual(effort: &Effort, case: &Case) -> (Vec<u8>, Option<Timing>) {
    let mut frame = BenchFrame::new(Renderer::new(RenderOptions::default()), case.width, case.height);
    let ((), timing) = effort.run(|| frame.draw_case(case));
    (frame.memory.bytes().to_vec(), timing)
}

/// Renders a case by the reference.
pub(super) fn truth(case: &Case) -> TruthPicture {
    render(&case.scene, case.width, case.height, case.format, &case.settings)
        .expect("a case's camera makes a picture")
}
