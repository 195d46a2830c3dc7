//! Draws a case by the pipeline and by the reference, and says what is off.

use fbptr::memory::{DepthMemory, IdMemory, VideoMemory};
use fbptr::pipeline::{self, DrawCall, SceneOptions, Target};
use fbptr::scene::{Viewport, ViewportRule};
use fbptr::truth::compare::compare;
use fbptr::truth::scenes::Case;
use fbptr::truth::{Transparency, TruthPicture, render};

/// What a draw left behind.
pub struct Drawn {
    /// The frame.
    pub memory: VideoMemory,
    /// Its depth.
    pub depth: Option<DepthMemory>,
    /// The faces that wrote depth.
    pub ids: IdMemory,
}

fn viewport_of(case: &Case) -> Viewport {
    let whole = Viewport { x: 0, y: 0, width: case.width, height: case.height, rule: ViewportRule::Corners };
    case.settings.viewport.unwrap_or(whole)
}

/// The case through the pipeline: one draw an object, or the whole scene.
pub fn draw(case: &Case) -> Drawn {
    let mut memory = VideoMemory::new(case.width, case.height).unwrap();
    let mut ids = IdMemory::new(case.width, case.height);
    let mut depth = None;
    let mut target =
        Target { memory: &mut memory, depth: &mut depth, depth_format: case.format, ids: Some(&mut ids) };
    let s = &case.settings;
    let mut scene = case.scene.clone();
    for o in &mut scene.objects {
        o.cull = s.cull.unwrap_or(o.cull);
    }
    match s.transparency {
        Transparency::AfterOpaque(transparency) => {
            let options = SceneOptions {
                viewport: viewport_of(case),
                shade: s.shade,
                hide: s.hide,
                interp: s.interpolation,
                transparency,
                ..SceneOptions::new(case.width, case.height)
            };
            pipeline::draw_scene(&mut target, &scene, &options).unwrap();
        }
        Transparency::AtOnce => {
            for (i, o) in scene.objects.iter().enumerate() {
                let call = DrawCall {
                    model: o.model,
                    camera: scene.camera.unwrap_or_default(),
                    viewport: viewport_of(case),
                    ambient: scene.ambient,
                    lights: &scene.lights,
                    light_subset: o.lights.as_deref(),
                    back_material: o.back_material.as_ref(),
                    texture: o.texture.as_ref().map(|t| &*t.0),
                    sampling: o.texture.as_ref().map(|t| t.1).unwrap_or_default(),
                    shade: o.shade.unwrap_or(s.shade),
                    cull: o.cull,
                    hide: s.hide,
                    interp: s.interpolation,
                    two_sided_lighting: o.two_sided_lighting,
                    fog: scene.fog,
                    name: i as u32,
                    ..DrawCall::new(&o.geometry, &o.material, case.width, case.height)
                };
                pipeline::draw(&mut target, &call).unwrap();
            }
        }
    }
    Drawn { memory, depth, ids }
}

/// Pixels where PICK would answer another face than the one right answer.
fn picks_off(drawn: &Drawn, truth: &TruthPicture) -> Vec<(u32, u32)> {
    let pixels = (0..truth.height()).flat_map(|y| (0..truth.width()).map(move |x| (x, y)));
    pixels
        .filter(|&(x, y)| {
            let states = truth.states(x, y);
            let right = states[0].depth_owner.map(|key| (truth.face(key).object, truth.face(key).triangle));
            states.len() == 1 && !truth.is_free(x, y) && drawn.ids.get(x as i32, y as i32) != right
        })
        .collect()
}

/// Draws a case both ways; what is wrong with it, if anything.
pub fn fault_of(case: &Case) -> Option<String> {
    let truth = render(&case.scene, case.width, case.height, case.format, &case.settings).unwrap();
    let drawn = draw(case);
    let report = compare(&drawn.memory, drawn.depth.as_ref(), &truth);
    let picks = picks_off(&drawn, &truth);
    if report.is_right() && picks.is_empty() {
        return None;
    }
    let s = &case.settings;
    Some(format!(
        "{}: {report}  picks off: {picks:?}\n  {s:?} {:?} {}x{}\n  {:?}",
        case.name, case.format, case.width, case.height, case.scene.camera
    ))
}
