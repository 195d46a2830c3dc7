//! `QUALITY max-error`: cheaper settings of a draw that stay within the error asked for.
//!
//! In: a draw and its largest error. Out: the draw with the settings that are proven to stay within
//! it. Levels of detail of a mesh are made by a job, where there are threads for it, before the first
//! draw that uses them. After its first `PICK` a connection draws whole meshes.

use super::drawing::MeshDraw;
use super::{Engine, Job, JobResult, Progress};
use crate::Session;
use fbptr_command::{Command, Quality};
use fbptr_core::cancel::CancelToken;
use fbptr_core::error::Fault;
use fbptr_core::memory::Reservation;
use fbptr_core::pipeline::SceneOptions;
use fbptr_core::pipeline::quality::{Budget, Level, QualitySettings, make_levels, prove, settings_of};
use fbptr_core::scene::{Geometry, MaxError, QualityUse, Scene};
use std::sync::Arc;

/// A mesh with its levels and the reservation for them.
type Made = (Arc<Geometry>, Vec<Level>, Option<Reservation>);

impl Engine {
    /// Returns the error that draws of the session may have, if they need not be exact.
    fn max_error(&self, s: &Session) -> Option<MaxError> {
        match (s.quality, self.rendering.view_overrides.quality) {
            (Quality::MaxError(max_error), QualityUse::AsGiven) if s.picks => {
                Some(MaxError { shift: 0.0, ..max_error })
            }
            (Quality::MaxError(max_error), QualityUse::AsGiven) => Some(max_error),
            _ => None,
        }
    }

    /// Returns those meshes whose levels of detail a job should make before the next draw; none where
    /// there are no threads for jobs.
    pub(super) fn due_levels<'m>(
        &self,
        s: &Session,
        meshes: impl Iterator<Item = &'m Arc<Geometry>>,
    ) -> Vec<Arc<Geometry>> {
        let mut due: Vec<Arc<Geometry>> = Vec::new();
        if self.may_suspend && self.max_error(s).is_some_and(|most| most.shift > 0.0) {
            for mesh in meshes.filter(|mesh| self.rendering.shapes.is_due(mesh)) {
                if !due.iter().any(|known| Arc::ptr_eq(known, mesh)) {
                    due.push(mesh.clone());
                }
            }
        }
        due
    }

    /// Returns the job that makes the levels of these meshes, and then runs `rest` of `command`.
    pub(super) fn levels_job(
        &self,
        due: Vec<Arc<Geometry>>,
        command: Command,
        rest: impl FnOnce(&mut Engine, &mut Session) -> Result<Progress, Fault> + Send + 'static,
    ) -> Job {
        let with_room = |mesh: Arc<Geometry>| (self.rendering.shapes.reserve_levels(&mesh), mesh);
        let due: Vec<_> = due.into_iter().map(with_room).collect();
        Job::new(false, move |cancel: &CancelToken| {
            let levels_of = |(held, mesh): (Option<Reservation>, Arc<Geometry>)| {
                let levels = if held.is_some() { make_levels(&mesh.mesh, cancel) } else { Vec::new() };
                (mesh, levels, held)
            };
            let made: Vec<Made> = due.into_iter().map(levels_of).collect();
            let draw = move |engine: &mut Engine, s: &mut Session, _: &mut Vec<u8>| {
                for (mesh, levels, held) in made {
                    engine.rendering.shapes.keep_levels(&mesh, levels, held);
                }
                rest(engine, s)
            };
            JobResult::new(command, Ok(draw))
        })
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
        if let Some(level) = chosen.level {
            draw.id = self.framebuffer.id_of_level(&draw.name, &level.origins);
            draw.geometry = level.geometry;
        }
    }

    /// Gives the objects of a `DRAWSCENE` the settings of its session's quality.
    pub(super) fn cheapen_scene(&mut self, s: &Session, scene: &mut Scene, options: &mut SceneOptions) {
        let Some(max_error) = self.max_error(s) else { return };
        let choice = prove(&Budget { scene, options, max_error }, &mut self.rendering.shapes);
        choice.apply(scene);
        if choice.settings.iter().any(|own| own.level.is_some()) {
            let origins = |own: &QualitySettings| own.level.as_ref().map(|level| level.origins.clone());
            let origins: Vec<_> = choice.settings.iter().map(origins).collect();
            options.first_name = self.framebuffer.ids_of_levels(scene, &origins);
        }
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
