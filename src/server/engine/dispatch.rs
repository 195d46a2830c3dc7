//! The table of what each command does, and what is the same for all of them: counting, the limit of replies, recording.

use super::{Effect, Engine};
use crate::command::Command;
use crate::error::Fault;
use crate::server::Session;

impl Engine {
    /// Runs one command of `session`; replies are appended to `replies`, and left as they were on an error.
    ///
    /// # Errors
    /// Why the command was refused; it then changed nothing.
    pub fn run(
        &mut self,
        session: &mut Session,
        command: Command,
        replies: &mut Vec<u8>,
    ) -> Result<Effect, Fault> {
        session.stats.commands += 1;
        let connection = session.id;
        let start = replies.len();
        let recorded = self.recorder.as_mut().map(|r| r.command(connection, &command));
        let result = self.dispatch(session, command, replies).and_then(|effect| {
            let length = replies.len() - start;
            match length <= self.limits.reply_bytes {
                true => Ok(effect),
                false => Err(self.reply_too_long(length as u64)),
            }
        });
        if result.is_err() {
            replies.truncate(start);
            session.stats.errors += 1;
        }
        if let (Some(recorder), Some(before)) = (&mut self.recorder, recorded) {
            match result {
                Ok(_) if self.files_read.is_empty() => {}
                Ok(_) => recorder.attach_files(connection, before, &self.files_read),
                Err(_) => recorder.roll_back(before),
            }
            self.files_read.clear();
        }
        result
    }

    /// One line a verb: this is the table of what each command does.
    fn dispatch(&mut self, s: &mut Session, command: Command, out: &mut Vec<u8>) -> Result<Effect, Fault> {
        use Command as C;
        if !is_pixelflut(&command) {
            s.has_used_other_verbs = true;
        }
        match command {
            C::Help => self.help(out),
            C::Size => self.size(out),
            C::GetPixel { x, y } => self.asked_pixel(s, x, y, out)?,
            C::Pixel { x, y, color } => {
                let (x, y) = Self::moved(s, x, y);
                self.pixel(s, x, y, color);
            }
            C::Offset { x, y } => s.offset = [x, y],
            C::Quit => return Ok(Effect::Quit),
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

            C::Line { .. }
            | C::Triangle { .. }
            | C::Fill { .. }
            | C::Rect { .. }
            | C::FillRect { .. }
            | C::Circle { .. }
            | C::FillCircle { .. }
            | C::Poly { .. }
            | C::FillPoly { .. }
            | C::Text { .. }
            | C::LineAa { .. } => self.figure(s, command)?,
            C::Blend { over } => {
                s.blend = if over { crate::draw2d::Blend::Over } else { crate::draw2d::Blend::Replace };
            }

            C::Mesh { name, source } => self.make_mesh(s, &name, *source)?,
            C::Texture { name, file } => self.make_texture(s, &name, &file)?,
            C::Scene { x3d } => self.make_scene(s, &x3d)?,
            C::Eye { name, json } => self.make_eye(s, &name, &json)?,
            C::Free { name } => self.free(s, &name)?,
            C::Load { kind, name, path } => self.load(s, kind, &name, &path)?,

            C::LookAt { .. } | C::Projection(_) | C::Viewport { .. } => self.set_camera(s, command)?,
            C::Identity
            | C::Push
            | C::Pop
            | C::Translate(_)
            | C::Rotate { .. }
            | C::Scale(_)
            | C::Shear(_)
            | C::Matrix(_) => self.model_matrix(s, command)?,
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
            C::Draw { name } => self.draw(s, &name)?,
            C::DrawScene { time, sorted } => self.draw_scene(s, time, sorted)?,
            C::DrawEye { name, rect } => self.draw_eye(s, &name, rect)?,

            C::DepthAt { x, y } => self.depth_at(x, y, out)?,
            C::Pick { x, y } => self.pick(x, y, out)?,
            C::Sync { tag } => out.extend_from_slice(format!("SYNC {tag}\n").as_bytes()),
            C::Hello => self.hello(out),
            C::Version => out.extend_from_slice(VERSION_REPLY.as_bytes()),
            C::Auto(on) => self.set_auto(s, on),
            C::Present { wait } => return Ok(self.present(s, wait, out)),
            C::Events(on) => self.set_events(s, on),
            C::Errors(mode) => s.error_mode = Some(mode),
            C::Snap(target) => self.snap(target, out)?,
        }
        Ok(Effect::Done)
    }
}

const VERSION_REPLY: &str = concat!("VERSION fbptr ", env!("CARGO_PKG_VERSION"), "\n");

/// Whether a connection that uses this command is still a Pixelflut one.
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
