//! Dispatch of commands, and what all commands have in common: counting, the limit of replies,
//! recording.
//!
//! In: a command and its session. Out: its effect, its reply and its place in the recording, or a
//! fault.

use super::job::JobResult;
use super::{Effect, Engine, Progress};
use crate::cancel::CancelToken;
use crate::command::Command;
use crate::error::Fault;
use crate::math::matrix;
use crate::scene::LookAt;
use crate::server::{Budget, Session};
use glam::DMat4;

impl Engine {
    /// Runs one command of `session` to its end. Replies are appended to `replies`, which is left
    /// as it was on an error.
    ///
    /// # Errors
    /// The reason for which the command was refused; it has then changed nothing.
    pub fn run(
        &mut self,
        session: &mut Session,
        command: Command,
        replies: &mut Vec<u8>,
    ) -> Result<Effect, Fault> {
        self.may_suspend = false;
        let mut progress = self.begin(session, command, replies)?;
        loop {
            match progress {
                Progress::Done(effect) => return Ok(effect),
                Progress::Job(job) => {
                    progress = self.apply(session, job.run(&CancelToken::default()), replies)?;
                }
                Progress::Pieces(pieces) => {
                    progress = self.run_pieces(session, *pieces, replies, Budget::NONE)?
                }
            }
        }
    }

    /// Runs one command of `session`, or the part of it that comes before its job.
    ///
    /// # Errors
    /// See [`Engine::run`].
    pub(in crate::server) fn begin(
        &mut self,
        session: &mut Session,
        command: Command,
        replies: &mut Vec<u8>,
    ) -> Result<Progress, Fault> {
        session.stats.commands += 1;
        self.verb_counts.command(&command);
        if !is_pixelflut(&command) {
            session.has_used_other_verbs = true;
        }
        let start = replies.len();
        let recorded = match &mut self.recorder {
            Some(recorder) if !is_made_by_job(&command) => Some(recorder.command(session.id, &command)),
            _ => None,
        };
        let result = self.dispatch(session, command, replies);
        self.end_command(session, recorded, result, replies, start)
    }

    /// Applies the result of a command's job.
    ///
    /// # Errors
    /// See [`Engine::run`].
    pub(in crate::server) fn apply(
        &mut self,
        session: &mut Session,
        result: JobResult,
        replies: &mut Vec<u8>,
    ) -> Result<Progress, Fault> {
        let (command, apply) = match (result.command, result.apply) {
            (Some(command), Ok(apply)) => (command, apply),
            (_, Err(fault)) => {
                session.stats.errors += 1;
                return Err(fault);
            }
            (None, Ok(_)) => return Ok(Progress::Done(Effect::Done)),
        };
        let start = replies.len();
        self.files_read = result.files;
        let recorded = self.recorder.as_mut().map(|r| r.command(session.id, &command));
        drop(command);
        let result = apply(self, session, replies);
        self.end_command(session, recorded, result, replies, start)
    }

    /// Completes a command that has run: checks the limit of replies, counts errors, and keeps the
    /// command in the recording or removes it.
    #[inline]
    fn end_command(
        &mut self,
        session: &mut Session,
        recorded: Option<usize>,
        result: Result<Progress, Fault>,
        replies: &mut Vec<u8>,
        start: usize,
    ) -> Result<Progress, Fault> {
        let length = replies.len() - start;
        if !matches!(result, Ok(Progress::Pieces(_))) {
            self.held.reply.shrink_to(0);
        }
        let result = match result {
            Ok(_) if length > self.limits.reply_bytes => Err(self.reply_too_long(length as u64)),
            result => result,
        };
        if result.is_err() {
            replies.truncate(start);
            session.stats.errors += 1;
        }
        if let (Some(recorder), Some(before)) = (&mut self.recorder, recorded) {
            match result {
                Ok(Progress::Done(_)) if self.files_read.is_empty() => {}
                Ok(Progress::Done(_)) => recorder.attach_files(session.id, before, &self.files_read),
                _ => recorder.roll_back(before),
            }
            self.files_read.clear();
        }
        result
    }

    /// Runs a command, or creates its job. Has one line per verb.
    fn dispatch(&mut self, s: &mut Session, command: Command, out: &mut Vec<u8>) -> Result<Progress, Fault> {
        use Command as C;
        match command {
            C::Help => self.help(out),
            C::Size => self.size(out),
            C::GetPixel { x, y } => self.asked_pixel(s, x, y, out)?,
            C::Pixel { x, y, color } => {
                let (x, y) = Self::moved(s, x, y);
                self.pixel(s, x, y, color);
            }
            C::Offset { x, y } => s.offset = [x, y],
            C::Quit => return Ok(Progress::Done(Effect::Quit)),
            C::Stats => self.stats(s, out),
            C::BinaryPixel { x, y, color } => self.pixel(s, x.into(), y.into(), color),
            C::PixelRun { x, y, rgba } => self.pixel_run(s, x, y, &rgba)?,

            C::Poke { offset, bytes } => self.poke(s, offset, &bytes)?,
            C::Peek { offset, n } => self.peek(offset, n, out)?,
            C::Blit { rect, rgba } => self.blit(s, rect, &rgba)?,
            C::Read { rect } => self.read(rect, out)?,
            C::Copy { source, dx, dy } => self.copy(s, source, dx, dy)?,
            C::Points { packed } => self.points(s, &packed)?,
            C::Crc { rect } => self.crc(rect, out)?,
            C::Clear { color } => self.clear(s, color),

            C::Figure(figure) => self.figure(s, &figure)?,
            C::Blend { over } => {
                s.blend = if over { crate::draw2d::Blend::Over } else { crate::draw2d::Blend::Replace };
            }

            C::Mesh { name, source } => return self.mesh_job(s, name, source),
            C::Texture { name, file } => return self.texture_job(s, name, file),
            C::Scene { x3d } => return self.scene_job(s, x3d),
            C::Eye { name, json } => return self.eye_job(s, name, json),
            C::Free { name } => self.free(s, &name)?,
            C::Load { kind, name, path } => return self.load_job(s, kind, name, path),

            C::LookAt { eye, reference, up } => self.look_at(s, LookAt { eye, reference, up })?,
            C::Projection(projection) => self.set_projection(s, *projection)?,
            C::Viewport { rect, rule } => self.set_viewport(s, rect, rule)?,
            C::Identity => s.model = DMat4::IDENTITY,
            C::Push => self.push_matrix(s)?,
            C::Pop => self.pop_matrix(s)?,
            C::Translate(by) => self.multiply_model(s, matrix::translate(by))?,
            C::Rotate { axis, angle_rad } => self.rotate_model(s, axis, angle_rad)?,
            C::Scale(by) => self.multiply_model(s, matrix::scale(by))?,
            C::Shear(by) => self.shear_model(s, &by)?,
            C::Matrix(by) => self.multiply_affine(s, &by)?,
            C::Ambient(color) => s.ambient = color,
            C::Light { index, light } => self.set_light(s, index, *light)?,
            C::Material(material) => s.material = *material,
            C::UseTexture { name, sampling } => self.use_texture(s, name, sampling)?,
            C::Shade(mode) => s.shade = mode,
            C::Cull(mode) => s.cull = mode,
            C::Hide(mode) => s.hide = mode,
            C::Depth(format) => self.set_depth_format(format),
            C::Interp(mode) => s.interp = mode,
            C::Quality(quality) => s.quality = quality,
            C::Draw { name } => return self.draw(s, name, None),
            C::DrawScene { time, sorted } => return self.draw_scene(s, time, sorted, None),
            C::DrawEye { name, rect } => return self.draw_eye(s, name, rect),

            C::DepthAt { x, y } => self.depth_at(x, y, out)?,
            C::Pick { x, y } => self.pick(x, y, out)?,
            C::Sync { tag } => out.extend_from_slice(format!("SYNC {tag}\n").as_bytes()),
            C::Hello => self.hello(out),
            C::Version => out.extend_from_slice(VERSION_REPLY.as_bytes()),
            C::Auto(on) => self.set_auto(s, on),
            C::Present { wait } => return Ok(Progress::Done(self.present(s, wait, out))),
            C::Events(on) => self.set_events(s, on),
            C::Errors(mode) => s.error_mode = Some(mode),
            C::Snap(target) => return self.snap_job(target),
        }
        Ok(Progress::Done(Effect::Done))
    }
}

const VERSION_REPLY: &str = concat!("VERSION fbptr ", env!("CARGO_PKG_VERSION"), "\n");

/// Returns whether a command always has a job, whose result contains the command for the recording.
fn is_made_by_job(command: &Command) -> bool {
    use Command as C;
    matches!(command, C::Mesh { .. } | C::Texture { .. } | C::Scene { .. } | C::Eye { .. })
}

/// Returns whether a connection that sends this command may be a plain Pixelflut client.
fn is_pixelflut(command: &Command) -> bool {
    use Command as C;
    matches!(
        command,
        C::Help
            | C::Size
            | C::GetPixel { .. }
            | C::Pixel { .. }
            | C::BinaryPixel { .. }
            | C::PixelRun { .. }
            | C::Offset { .. }
            | C::Quit
            | C::Stats
    )
}
