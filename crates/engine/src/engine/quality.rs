//! `QUALITY max-error`: cheaper settings of a draw that stay within the error asked for.
//!
//! In: a draw and its largest error. Out: the draw with the settings that are proven to stay within
//! it.

use super::Engine;
use super::drawing::MeshDraw;
use crate::Session;
use fbptr_command::Quality;
use fbptr_core::pipeline::SceneOptions;
use fbptr_core::pipeline::quality::{Budget, prove, settings_of};
use fbptr_core::scene::{QualityUse, Scene};

impl Engine {
    /// Returns the error that draws of the session may have, if they need not be exact.
    fn max_error(&self, s: &Session) -> Option<f64> {
        match (s.quality, self.rendering.view_overrides.quality) {
            (Quality::MaxError(max_error), QualityUse::AsGiven) => Some(max_error),
            _ => None,
        }
    }

    /// Gives a `DRAW` the settings of its session's quality.
    pub(super) fn cheapen_draw(&mut self, s: &Session, draw: &mut MeshDraw) {
        let Some(max_error) = self.max_error(s) else { return };
        let (chosen, ndc_box) = settings_of(&draw.call(), max_error, &mut self.rendering.shapes);
        draw.ndc_box = ndc_box;
        draw.shade = chosen.shade.unwrap_or(draw.shade);
        if let Some(lights) = chosen.lights {
            draw.lights = lights.iter().map(|i| draw.lights[*i as usize]).collect();
        }
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
    use crate::{Audience, Output, Stream};

    /// Returns the pictures of these parts of one stream, after each of them.
    fn pictures(parts: &[&str]) -> Vec<Vec<u8>> {
        let mut engine = Engine::new(160, 120).unwrap();
        let mut stream = Stream::new(&engine, 1, Audience::Owner);
        let mut out = Output::default();
        let each = parts.iter().map(|part| {
            let _ = stream.feed(&mut engine, part.as_bytes(), &mut out, crate::Budget::NONE);
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
