//! `QUALITY max-error`: cheaper settings of a draw that stay within the error asked for.
//!
//! In: a draw and its largest error. Out: the draw with the settings that are proven to stay within
//! it. Levels of detail of a mesh are made by a job, where there are threads for it, before the first
//! draw that uses them. `PICK` then names, for what is left of a triangle of the whole mesh, that
//! triangle; no query changes what is drawn, so a recording without them replays to the same bytes.

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
            (Quality::MaxError(max_error), QualityUse::AsGiven) if self.rendering.tracing.is_some() => {
                // A trace follows the triangles of the whole mesh.
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
        draw.light_error = chosen.light_error;
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
    use crate::stream::Resume;
    use crate::{Audience, Output, Stream, StreamState};

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

    /// Returns a flat sheet of 5000 faces as an OBJ file.
    fn sheet() -> String {
        let mut obj = String::new();
        for (y, x) in (0..=50).flat_map(|y| (0..=50).map(move |x| (y, x))) {
            obj += &format!("v {} {} 0\n", f64::from(x) / 25.0 - 1.0, f64::from(y) / 25.0 - 1.0);
        }
        for (y, x) in (0..50).flat_map(|y| (0..50).map(move |x| (y, x))) {
            let at = y * 51 + x + 1;
            obj += &format!("f {} {} {} {}\n", at, at + 1, at + 52, at + 51);
        }
        obj
    }

    /// Runs a stream as a server does, with jobs if it `suspends`. Returns its replies.
    fn replies(suspends: bool, engine: &mut Engine, script: &str) -> String {
        let mut stream = Stream::new(engine, 1, Audience::Owner);
        let (mut out, mut used) = (Output::default(), 0);
        let budget = crate::Budget { suspends, ..crate::Budget::NONE };
        let mut state = StreamState::Ready;
        while used < script.len() || matches!(state, StreamState::Works | StreamState::InPieces) {
            state = match state {
                StreamState::Works => {
                    let result = out.job.take().expect("a job").run_guarded(&CancelToken::default());
                    stream.resume(engine, Resume::Job(result), &mut out, budget)
                }
                StreamState::InPieces => stream.resume(engine, Resume::Pieces, &mut out, budget),
                _ => {
                    let (taken, state) = stream.feed(engine, &script.as_bytes()[used..], &mut out, budget);
                    used += taken;
                    state
                }
            };
        }
        String::from_utf8(out.replies).unwrap()
    }

    #[test]
    fn a_level_is_drawn_when_it_pays_and_picks_name_the_whole_mesh() {
        let sheet = sheet();
        let mut script = format!("MESH m OBJ :{}\n{sheet}LOOKAT 0 0 4 0 0 0 0 1 0\n", sheet.len());
        script += "PERSPECTIVE 0.6 1 9\nLIGHT 0 DIR 0 0 -1 1 1 1\nQUALITY max-error 4 0.5\n";
        script += &"CLEAR 000000\nDRAW m\n".repeat(512);
        let once_more = script.clone() + "CLEAR 000000\nDRAW m\nPICK 16 12\n";
        let is_whole = |engine: &Engine| engine.rendering.plan.contains("faces:5000,");
        let mut found = Vec::new();
        for suspends in [false, true] {
            let mut engine = Engine::new(32, 24).unwrap();
            // The first draw of a mesh is not counted.
            replies(suspends, &mut engine, &script);
            assert!(is_whole(&engine), "{}", engine.rendering.plan);
            let exact = engine.memory().bytes().to_vec();
            let answer = replies(suspends, &mut engine, &once_more);
            assert!(!is_whole(&engine), "{}", engine.rendering.plan);
            assert!(engine.memory().bytes() == exact, "a flat sheet is the same in few faces");
            let triangle = answer.trim().strip_prefix("PICK 16 12 m ").unwrap().parse::<u32>().unwrap();
            assert!(triangle < 5000, "{answer}");
            found.push((engine.rendering.plan.clone(), triangle));
        }
        assert_eq!(found[0], found[1], "with jobs and without");
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
