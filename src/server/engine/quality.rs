//! `QUALITY max-error`: cheaper settings of a draw that stay within the error asked for.
//!
//! In: a draw and its largest error. Out: the draw with the settings that are proven to stay within
//! it.

use super::Engine;
use super::drawing::MeshDraw;
use crate::command::Quality;
use crate::pipeline::SceneOptions;
use crate::pipeline::quality::{Budget, prove};
use crate::scene::{Object, QualityUse, Scene};
use crate::server::Session;
use std::sync::Arc;

impl Engine {
    /// Returns the error that draws of the session may have, if they need not be exact.
    fn max_error(&self, s: &Session) -> Option<f64> {
        match (s.quality, self.rendering.view_overrides.quality) {
            (Quality::MaxError(max_error), QualityUse::AsGiven) => Some(max_error),
            _ => None,
        }
    }

    /// Gives a `DRAW` the settings of its session's quality: those of a scene of one object.
    pub(super) fn cheapen_draw(&mut self, s: &Session, draw: &mut MeshDraw) {
        let Some(max_error) = self.max_error(s) else { return };
        let object = Object {
            name: String::new(),
            geometry: Arc::clone(&draw.geometry),
            model: draw.model,
            material: draw.material.clone(),
            back_material: None,
            cull: draw.cull,
            two_sided_lighting: draw.call().two_sided_lighting,
            shade: None,
            texture: draw.texture.as_ref().map(|t| (Arc::clone(t), draw.sampling)),
            lights: None,
            style: Default::default(),
        };
        let scene = Scene {
            camera: Some(draw.camera),
            ambient: draw.ambient,
            lights: std::mem::take(&mut draw.lights),
            objects: vec![object],
            ..Scene::default()
        };
        let options = SceneOptions {
            viewport: draw.viewport,
            shade: draw.shade,
            hide: draw.hide,
            interp: draw.interp,
            ..SceneOptions::new(self.framebuffer.width(), self.framebuffer.height())
        };
        let budget = Budget { scene: &scene, options: &options, max_error };
        let choice = prove(&budget, &mut self.rendering.shapes);
        let chosen = &choice.settings[0];
        draw.shade = chosen.shade.unwrap_or(draw.shade);
        draw.lights = match &chosen.lights {
            Some(lights) => lights.iter().map(|i| scene.lights[*i as usize]).collect(),
            None => scene.lights,
        };
    }

    /// Gives the objects of a `DRAWSCENE` the settings of its session's quality.
    pub(super) fn cheapen_scene(&mut self, s: &Session, scene: &mut Scene, options: &SceneOptions) {
        let Some(max_error) = self.max_error(s) else { return };
        let choice = prove(&Budget { scene, options, max_error }, &mut self.rendering.shapes);
        choice.apply(scene);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::server::{Audience, Output, Stream};

    /// Returns the pictures of these parts of one stream, after each of them.
    fn pictures(parts: &[&str]) -> Vec<Vec<u8>> {
        let mut engine = Engine::new(160, 120).unwrap();
        let mut stream = Stream::new(&engine, 1, Audience::Owner);
        let mut out = Output::default();
        let each = parts.iter().map(|part| {
            let _ = stream.feed(&mut engine, part.as_bytes(), &mut out, crate::server::Budget::NONE);
            engine.memory().bytes().to_vec()
        });
        each.collect()
    }

    #[test]
    fn what_is_proven_of_a_mesh_pays_from_its_second_draw_on_wherever_it_is_seen_from() {
        let mut scene = "LOOKAT 3 3 4 0 0 0 0 1 0\nPERSPECTIVE 0.6 1 9\nMESH m BOX\n".to_owned();
        scene += "LIGHT 0 DIR 0 -1 -1 1 1 1\n";
        (1..8).for_each(|i| scene += &format!("LIGHT {i} DIR 0 -1 -1 0.01 0.01 0.01\n"));
        let draw = |quality: &str| format!("QUALITY {quality}\nCLEAR 000000\nDRAW m\n");
        let (exact, cheaper) = (draw("exact"), draw("max-error 30"));
        let turned = "ROTATE 1 1 0 1\n";
        let found = pictures(&[&scene, &cheaper, &exact, &cheaper, &exact, turned, &cheaper, &exact]);
        assert!(found[1] == found[2], "the first draw is exact");
        assert!(found[3] != found[4], "the second is not");
        assert!(found[6] != found[7], "nor is another view");
    }
}
