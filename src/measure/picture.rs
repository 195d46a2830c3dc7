//! Scenes through the pipeline, and the truth of them, for the experiments on pictures.

use crate::memory::{DepthMemory, VideoMemory};
use crate::pipeline::{self, SceneOptions, Target};
use crate::scene::TransparencyOrder;
use crate::truth::scenes::Case;
use crate::truth::{Transparency, TruthPicture, render};

/// A case drawn by the pipeline as a whole scene.
pub(super) fn draw(case: &Case) -> (VideoMemory, Option<DepthMemory>) {
    let mut memory = VideoMemory::new(case.width, case.height).expect("an experiment's frame is small");
    let mut depth = None;
    let mut target = Target { memory: &mut memory, depth: &mut depth, depth_format: case.format, ids: None };
    let s = &case.settings;
    let mut options = SceneOptions::new(case.width, case.height);
    options.viewport = s.viewport.unwrap_or(options.viewport);
    options.shade = s.shade;
    options.hide = s.hide;
    options.interp = s.interpolation;
    options.transparency = match s.transparency {
        Transparency::AfterOpaque(order) => order,
        Transparency::AtOnce => TransparencyOrder::FileOrder,
    };
    pipeline::draw_scene(&mut target, &case.scene, &options).expect("an experiment's scene can be drawn");
    (memory, depth)
}

/// The truth of a case.
pub(super) fn truth(case: &Case) -> TruthPicture {
    render(&case.scene, case.width, case.height, case.format, &case.settings)
        .expect("an experiment's camera makes a picture")
}
