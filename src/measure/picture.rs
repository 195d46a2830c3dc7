//! Cases through the pipeline, and the truth of them.

use crate::memory::{DepthMemory, IdMemory, VideoMemory};
use crate::pipeline::{self, DrawCall, SceneOptions, Target};
use crate::scene::{Viewport, ViewportRule};
use crate::truth::scenes::Case;
use crate::truth::{Transparency, TruthPicture, render};

/// What the draws of a case left behind.
#[derive(Clone, Debug)]
pub struct Drawn {
    /// The frame.
    pub memory: VideoMemory,
    /// Its depth, where the draws needed one.
    pub depth: Option<DepthMemory>,
    /// The face that wrote the depth of each pixel; an object's name is its number.
    pub ids: IdMemory,
}

/// Draws a case by the pipeline: one draw an object, or the whole scene, as its settings say.
///
/// # Panics
/// When the case's frame cannot be made or its scene be drawn: cases are made by the program itself.
pub fn draw_case(case: &Case) -> Drawn {
    let mut memory = VideoMemory::new(case.width, case.height).expect("a case's frame is small");
    let mut ids = IdMemory::new(case.width, case.height);
    let mut depth = None;
    let mut target =
        Target { memory: &mut memory, depth: &mut depth, depth_format: case.format, ids: Some(&mut ids) };
    let s = &case.settings;
    let whole = Viewport { x: 0, y: 0, width: case.width, height: case.height, rule: ViewportRule::Corners };
    let viewport = s.viewport.unwrap_or(whole);
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
            pipeline::draw_scene(&mut target, &scene, &options).expect("a case's scene can be drawn");
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
                pipeline::draw(&mut target, &call).expect("a case's object can be drawn");
            }
        }
    }
    Drawn { memory, depth, ids }
}

/// The truth of a case.
pub(super) fn truth(case: &Case) -> TruthPicture {
    render(&case.scene, case.width, case.height, case.format, &case.settings)
        .expect("a case's camera makes a picture")
}
