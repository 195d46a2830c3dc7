//! Drawing of test cases by the pipeline and by the reference.

use super::clock::{Timing, Work};
use super::experiment::Effort;
use fbptr_core::memory::{DepthFormat, DepthMemory, PickBuffer, VideoMemory};
use fbptr_core::pipeline::{
    DrawCall, PipelineError, RenderOptions, RenderPath, Renderer, SceneOptions, Target,
};
use fbptr_core::scene::{Scene, Viewport, ViewportRule};
use fbptr_truth::compare::{color_error, compare};
use fbptr_truth::scenes::{Case, Random};
use fbptr_truth::{Transparency, TruthPicture, render, render_pixels};

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

/// Buffers after one case was drawn, or refused.
pub(super) struct Buffers {
    /// Colours.
    pub memory: VideoMemory,
    /// Depth, if the draws needed one.
    pub depth: Option<DepthMemory>,
    /// Reason of a refusal.
    pub refusal: Option<PipelineError>,
}

impl Buffers {
    /// Draws a case.
    pub fn of_case(renderer: &mut Renderer, case: &Case) -> Buffers {
        let mut memory = VideoMemory::new(case.width, case.height).expect("a case's frame is small");
        let mut depth = None;
        let mut target =
            Target { memory: &mut memory, depth: &mut depth, depth_format: case.format, ids: None };
        let refusal = try_draw_into(renderer, &mut target, case).err();
        Buffers { memory, depth, refusal }
    }

    /// Returns whether both hold the same bytes and depths, or were refused alike.
    pub fn is_same(&self, other: &Buffers) -> bool {
        let words = |b: &Buffers| -> Vec<u32> {
            let pixels = (b.memory.width() * b.memory.height()) as usize;
            b.depth.iter().flat_map(|d| (0..pixels).map(|i| d.word(i))).collect()
        };
        self.memory.bytes() == other.memory.bytes()
            && self.refusal == other.refusal
            && words(self) == words(other)
    }
}

/// Returns the part of the frame that a case is drawn in.
fn viewport(case: &Case) -> Viewport {
    let full_frame =
        Viewport { x: 0, y: 0, width: case.width, height: case.height, rule: ViewportRule::Corners };
    case.settings.viewport.unwrap_or(full_frame)
}

/// Returns the options of a case that is drawn as one scene; `None` for one draw per object.
pub(super) fn scene_options(case: &Case) -> Option<SceneOptions> {
    let s = &case.settings;
    let Transparency::AfterOpaque(transparency) = s.transparency else { return None };
    Some(SceneOptions {
        viewport: viewport(case),
        shade: s.shade,
        hide: s.hide,
        interp: s.interpolation,
        transparency,
        ..SceneOptions::new(case.width, case.height)
    })
}

fn draw_into(renderer: &mut Renderer, target: &mut Target, case: &Case) {
    try_draw_into(renderer, target, case).expect("a case's scene can be drawn");
}

/// Draws a case, or says why it is refused.
pub(super) fn try_draw_into(
    renderer: &mut Renderer,
    target: &mut Target,
    case: &Case,
) -> Result<(), PipelineError> {
    let s = &case.settings;
    match scene_options(case) {
        Some(options) if s.cull.is_none() => {
            renderer.draw_scene(target, &case.scene, &options)?;
        }
        Some(options) => {
            let mut scene = case.scene.clone();
            for o in &mut scene.objects {
                o.cull = s.cull.unwrap_or(o.cull);
            }
            renderer.draw_scene(target, &scene, &options)?;
        }
        None => {
            for (i, o) in case.scene.objects.iter().enumerate() {
                let call = DrawCall {
                    model: o.model,
                    camera: case.scene.camera.unwrap_or_default(),
                    viewport: viewport(case),
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
                renderer.draw(target, &call)?;
            }
        }
    }
    Ok(())
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

    /// Clears colour and depth and draws a scene with these options.
    pub fn draw_with(&mut self, scene: &Scene, options: &SceneOptions, depth_format: DepthFormat) {
        self.clear();
        let (memory, depth) = (&mut self.memory, &mut self.depth);
        let mut target = Target { memory, depth, depth_format, ids: None };
        self.renderer.draw_scene(&mut target, scene, options).expect("a scene that was drawn before");
    }

    /// Clears colour and depth and draws a case of the frame's size.
    pub fn draw_case(&mut self, case: &Case) {
        self.clear();
        let (memory, depth) = (&mut self.memory, &mut self.depth);
        let mut target = Target { memory, depth, depth_format: case.format, ids: None };
        draw_into(&mut self.renderer, &mut target, case);
    }
}

/// Draws the cases of a subject with the default options, in turns. Returns their bytes and timings.
pub(super) fn drawn_in_turns(effort: &Effort, cases: &[Case]) -> Vec<(Vec<u8>, Option<Timing>)> {
    let frame = |case: &Case| BenchFrame::new(effort.renderer(), case.width, case.height);
    let mut frames: Vec<BenchFrame> = cases.iter().map(frame).collect();
    let mut works: Vec<Work<()>> = Vec::new();
    for (case, frame) in cases.iter().zip(&mut frames) {
        works.push(Box::new(|| frame.draw_case(case)));
    }
    let timings = effort.run_in_turns(works).into_iter().map(|((), timing)| timing);
    frames.iter().map(|frame| frame.memory.bytes().to_vec()).zip(timings).collect()
}

/// Renders a case by the reference.
pub(super) fn truth(case: &Case) -> TruthPicture {
    render(&case.scene, case.width, case.height, case.format, &case.settings)
        .expect("a case's camera makes a picture")
}

/// Renders the listed pixels of a case by the reference.
pub(super) fn truth_pixels(case: &Case, pixels: &[[u32; 2]]) -> TruthPicture {
    render_pixels(&case.scene, case.width, case.height, case.format, &case.settings, pixels)
        .expect("a case's camera makes a picture")
}

/// Moves one channel of one byte picture away from its truth, by `steps` and one more: at a pixel
/// with a single accepted result, on the side that has room for it.
pub(super) fn raise_error(found: &mut [u8], exact: &TruthPicture, steps: f64) {
    let off = steps as i32 + 1;
    for (i, pixel) in found.chunks_exact_mut(4).enumerate() {
        let [x, y] = [i as u32 % exact.width(), i as u32 / exact.width()];
        let [state] = exact.states(x, y) else { continue };
        if exact.is_free(x, y) || state.lo != state.hi {
            continue;
        }
        for (channel, right) in pixel.iter_mut().zip(state.lo) {
            let moved = [i32::from(right) + off, i32::from(right) - off];
            if let Some(wrong) = moved.into_iter().find_map(|v| u8::try_from(v).ok()) {
                *channel = wrong;
                return;
            }
        }
    }
}

/// Returns the largest difference of the plain f64 path from the reference, two programs without
/// common code: the second way of the tables whose truth is the reference.
pub(super) fn plain_against_truth(case: &Case) -> f64 {
    f64::from(compare(&draw_case(case).memory, None, &truth(case)).max_color)
}

/// Number of pixels that a [`Compared`] has.
const COMPARED: usize = 1_000;

/// Pixels of a case drawn at random, with their truth.
pub(super) struct Compared {
    pixels: Vec<[u32; 2]>,
    exact: TruthPicture,
}

impl Compared {
    /// Renders the pixels by the reference.
    pub fn new(case: &Case) -> Compared {
        let mut r = Random::new(1964);
        let pixels: Vec<[u32; 2]> =
            (0..COMPARED).map(|_| [r.below(case.width), r.below(case.height)]).collect();
        let exact = truth_pixels(case, &pixels);
        Compared { pixels, exact }
    }

    /// Returns the largest error of a picture at these pixels, in 1/255.
    pub fn largest_error(&self, bytes: &[u8]) -> f64 {
        let error = |&[x, y]: &[u32; 2]| {
            let at = (self.exact.width() * y + x) as usize;
            color_error(&self.exact, at, std::array::from_fn(|c| bytes[4 * at + c]))
        };
        f64::from(self.pixels.iter().map(error).max().unwrap_or(0))
    }

    /// Moves one pixel away from its truth, by `steps` and one more.
    pub fn raise(&self, bytes: &mut [u8], steps: f64) {
        for &[x, y] in &self.pixels {
            let [state] = self.exact.states(x, y) else { continue };
            if !self.exact.is_free(x, y) && state.lo == state.hi && state.hi[0] < 250 {
                bytes[4 * (self.exact.width() * y + x) as usize] = state.hi[0] + steps as u8 + 1;
                return;
            }
        }
    }
}
