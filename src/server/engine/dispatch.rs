//! The door of the engine: what all requests have in common, and the dispatch of commands.
//!
//! In: a request and its session, the result of its job, or its pieces. Out: its effect and its
//! reply, or a fault. Each request is counted here, once; the limit of replies, the counts of errors
//! and the events that let observers keep or undo what began stand here alone, for commands as for
//! batches of pixels.
//!
//! A panic in what a request does is a defect of the server. It refuses that request and no other:
//! observers are told that it is undone, then of the pixels and depths as they are now. A panic of
//! an observer is not caught here.

use super::job::JobResult;
use super::{Effect, Engine, Event, Pieces, Progress, Request};
use crate::cancel::CancelToken;
use crate::command::Command;
use crate::error::{Code, Fault};
use crate::math::matrix;
use crate::scene::LookAt;
use crate::server::read_files::ReadFile;
use crate::server::{Budget, Session};
use glam::DMat4;
use std::panic::{AssertUnwindSafe, catch_unwind};

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
        let mut progress = self.begin(session, Request::Command(command), replies)?;
        loop {
            match progress {
                Progress::Done(effect) => return Ok(effect),
                Progress::Job(job) => {
                    let result = job.run_guarded(&CancelToken::default());
                    progress = self.apply(session, result, replies)?;
                }
                Progress::Pieces(pieces) => {
                    progress = self.run_pieces(session, *pieces, replies, Budget::NONE)?
                }
            }
        }
    }

    /// Runs one request of `session`, or the part of it that comes before its job or its pieces.
    /// Inlined, so that a batch is dispatched where it is known.
    ///
    /// # Errors
    /// See [`Engine::run`].
    #[inline]
    pub(in crate::server) fn begin(
        &mut self,
        session: &mut Session,
        request: Request<'_>,
        replies: &mut Vec<u8>,
    ) -> Result<Progress, Fault> {
        session.stats.commands += request.count() as u64;
        session.has_used_other_verbs |= !request.is_pixelflut();
        self.send(&Event::Received(&request));
        let request = match request {
            Request::Command(command) if self.may_suspend && self.is_long(session, &command) => {
                return Ok(Progress::Pieces(Box::new(self.begin_in_pieces(session, command))));
            }
            request => request,
        };
        let start = replies.len();
        let has_begun = !request.is_made_by_job();
        if has_begun {
            self.send_begin(session, &request);
        }
        #[cfg(test)]
        let verb = request.verb();
        let result = self.guarded(|engine| {
            let result = engine.dispatch(session, request, replies);
            #[cfg(test)]
            engine.meet_defect(verb);
            result
        });
        self.end_request(session, has_begun, result, &[], replies, start)
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
        let JobResult { made, files } = result;
        let (start, has_begun) = (replies.len(), made.is_ok());
        let result = made.and_then(|(command, apply)| {
            self.send_begin(session, &Request::Command(command));
            self.guarded(|engine| apply(engine, session, replies))
        });
        self.end_request(session, has_begun, result, &files, replies, start)
    }

    /// Runs at least one piece of a command, and more until the budget's time is used up. Returns
    /// the rest of the command if it is not complete.
    ///
    /// # Errors
    /// The reason for which the command was refused or ended early.
    pub(in crate::server) fn run_pieces(
        &mut self,
        session: &mut Session,
        mut pieces: Pieces,
        replies: &mut Vec<u8>,
        budget: Budget,
    ) -> Result<Progress, Fault> {
        let is_done = self.guarded(|engine| engine.advance(session, &mut pieces, budget));
        if let Ok(false) = is_done {
            return Ok(Progress::Pieces(Box::new(pieces)));
        }
        if self.has_defect {
            self.stop_pieces(&mut pieces);
        }
        let (start, has_begun) = (replies.len(), is_done.is_ok());
        let result = is_done.map(|_| {
            let request = self.end_pieces(session, pieces, replies);
            self.send_begin(session, &request);
            Progress::Done(Effect::Done)
        });
        self.end_request(session, has_begun, result, &[], replies, start)
    }

    /// Runs a part of a request. A panic in it refuses the request.
    #[inline]
    fn guarded<T>(&mut self, part: impl FnOnce(&mut Engine) -> Result<T, Fault>) -> Result<T, Fault> {
        // Pixels that it has drawn stay. The memories hold plain numbers, so any state of them is
        // valid.
        match catch_unwind(AssertUnwindSafe(|| part(self))) {
            Ok(result) => result,
            Err(_) => Err(self.note_defect("this command met a defect of the server, and was given up")),
        }
    }

    /// Notes that the running request met a defect. Returns its fault.
    #[cold]
    pub(super) fn note_defect(&mut self, message: &str) -> Fault {
        self.has_defect = true;
        self.end_band();
        Fault::new(Code::Format, message)
    }

    /// Panics if a test wants this verb to meet a defect.
    #[cfg(test)]
    pub(super) fn meet_defect(&self, verb: &'static str) {
        assert_ne!(self.wanted_defect, Some(verb), "a defect for a test");
    }

    /// Sends observers the memories as a request has left them that met a defect: a part of it may
    /// be drawn.
    #[cold]
    fn send_after_defect(&mut self) {
        self.has_defect = false;
        self.send_rows(0..self.framebuffer.height());
        if self.framebuffer.depth.is_some() {
            self.discard_depths();
        }
    }

    /// Ends a request, or a part of it: checks the limit of replies, counts errors, and sends
    /// observers the end of what has begun.
    #[inline]
    fn end_request(
        &mut self,
        session: &mut Session,
        has_begun: bool,
        mut result: Result<Progress, Fault>,
        files: &[ReadFile],
        replies: &mut Vec<u8>,
        start: usize,
    ) -> Result<Progress, Fault> {
        let length = replies.len() - start;
        if !matches!(result, Ok(Progress::Pieces(_))) {
            self.quotas.reply.shrink_to(0);
        }
        if let (true, Err(too_long)) = (result.is_ok(), self.quotas.check_reply_length(length as u64)) {
            result = Err(too_long);
        }
        if result.is_err() {
            replies.truncate(start);
            session.stats.errors += 1;
        }
        if has_begun {
            self.send_end(session, matches!(result, Ok(Progress::Done(_))), files);
        }
        if result.is_err() && self.has_defect {
            self.send_after_defect();
        }
        result
    }

    /// Runs a request, or creates its job.
    #[inline]
    fn dispatch(
        &mut self,
        s: &mut Session,
        request: Request<'_>,
        out: &mut Vec<u8>,
    ) -> Result<Progress, Fault> {
        match request {
            Request::Command(command) => return self.dispatch_command(s, command, out),
            Request::Pixel { x, y, color } => self.framebuffer.moved_pixel(s, x, y, color),
            Request::Pixels(records) => self.framebuffer.pixels(s, records),
            Request::BinaryPixels(records) => self.framebuffer.binary_pixels(s, records),
            Request::Lines(lines) => self.lines(s, lines),
            Request::PixelRun { x, y, rgba } => self.framebuffer.pixel_run(s, x, y, rgba)?,
            Request::Blit { rect, rgba } => self.framebuffer.blit(s, rect, rgba)?,
            Request::Points(packed) => self.points(s, packed)?,
        }
        Ok(Progress::Done(Effect::Done))
    }

    /// Runs a command, or creates its job. Has one line per verb.
    #[inline(never)]
    fn dispatch_command(
        &mut self,
        s: &mut Session,
        command: Command,
        out: &mut Vec<u8>,
    ) -> Result<Progress, Fault> {
        use Command as C;
        match command {
            C::Help => self.help(out),
            C::Size => self.framebuffer.size(out),
            C::GetPixel { x, y } => self.framebuffer.asked_pixel(s, x, y, out)?,
            C::Pixel { x, y, color } => self.framebuffer.moved_pixel(s, x, y, color),
            C::Offset { x, y } => s.offset = [x, y],
            C::Quit => return Ok(Progress::Done(Effect::Quit)),
            C::Stats => self.stats(s, out),
            C::BinaryPixel { x, y, color } => self.framebuffer.pixel(s, x.into(), y.into(), color),
            C::PixelRun { x, y, rgba } => self.framebuffer.pixel_run(s, x, y, &rgba)?,

            C::Poke { offset, bytes } => self.framebuffer.poke(s, offset, &bytes)?,
            C::Peek { offset, n } => self.peek(offset, n, out)?,
            C::Blit { rect, rgba } => self.framebuffer.blit(s, rect, &rgba)?,
            C::Read { rect } => self.read(rect, out)?,
            C::Copy { source, dx, dy } => self.framebuffer.copy(s, source, dx, dy)?,
            C::Points { packed } => self.points(s, &packed)?,
            C::Crc { rect } => self.framebuffer.crc(rect, out)?,
            C::Clear { color } => self.clear(s, color),

            C::Figure(figure) => self.framebuffer.figure(s, &figure)?,
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
            C::Depth(format) => self.framebuffer.set_depth_format(format),
            C::Interp(mode) => s.interp = mode,
            C::Quality(quality) => s.quality = quality,
            C::Draw { name } => return self.draw(s, name, None),
            C::DrawScene { time, sorted } => return self.draw_scene(s, time, sorted, None),
            C::DrawEye { name, rect } => return self.draw_eye(s, name, rect),

            C::DepthAt { x, y } => self.framebuffer.depth_at(x, y, out)?,
            C::Pick { x, y } => self.framebuffer.pick(x, y, out)?,
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

#[cfg(test)]
mod tests;
