//! `IMAGE`: a picture in a file's bytes, drawn on the target.
//!
//! In: a file, and the pixel of its upper left corner. Out: its pixels on the target, as `BLEND` says,
//! within the clip rectangle. A job decodes it; a large one is drawn in bands of rows, with the bytes
//! of one drawn at once (`every_verb_is_divided` of the pieces draws both).

use super::job::{Job, JobResult};
use super::resources::{JobMemory, SMALL_PICTURE_BYTES};
use super::{Effect, Engine, Progress};
use crate::Session;
use crate::resources::ResourceKind;
use fbptr_command::{Command, Rect};
use fbptr_core::error::Fault;
use fbptr_core::scene::Texture;
use fbptr_formats::load;

/// Pixels from which a picture is drawn in bands.
const LARGE_PICTURE_PIXELS: u64 = 1 << 19;

/// A decoded picture, and the memory that stays reserved for it until it is drawn.
#[derive(Debug)]
pub(super) struct Decoded {
    picture: Texture,
    _memory: JobMemory,
}

impl Decoded {
    /// Returns its RGBA rows.
    pub fn rgba(&self) -> &[u8] {
        self.picture.bytes()
    }
}

impl Engine {
    /// Runs `IMAGE`: a job decodes the picture, which is then drawn as the session's `BLEND` says.
    pub(super) fn image_job(
        &mut self,
        s: &mut Session,
        x: i32,
        y: i32,
        file: Vec<u8>,
    ) -> Result<Progress, Fault> {
        let (is_small, may_suspend) = (file.len() <= SMALL_PICTURE_BYTES, self.may_suspend);
        // The file again, for the command that is recorded when its last band is drawn.
        let bytes = if is_small || !may_suspend { file.len() } else { 2 * file.len() };
        let memory = self.job_memory(s, ResourceKind::Texture, "", bytes)?;
        Ok(Progress::Job(Job::new(is_small, move |cancel| {
            let mut memory = memory.until(cancel);
            let decoded = load::texture::decode_within(&file, "picture", &mut memory.result);
            let pieces = may_suspend.then(|| file.clone());
            let apply = decoded.map_err(Fault::from).map(|picture| {
                let rect = Rect { x, y, w: picture.width() as i32, h: picture.height() as i32 };
                let decoded = Decoded { picture, _memory: memory };
                move |engine: &mut Engine, s: &mut Session, _: &mut Vec<u8>| {
                    engine.draw_image(s, rect, decoded, pieces)
                }
            });
            JobResult::new(Command::Image { x, y, file }, apply)
        })))
    }

    /// Draws a decoded picture, or begins its bands if it is large and there is its file for them.
    fn draw_image(
        &mut self,
        s: &mut Session,
        rect: Rect,
        picture: Decoded,
        file: Option<Vec<u8>>,
    ) -> Result<Progress, Fault> {
        match file {
            Some(file) if self.framebuffer.visible(rect) > LARGE_PICTURE_PIXELS => {
                Ok(Progress::Pieces(Box::new(self.begin_image_in_pieces(rect, picture, file))))
            }
            _ => {
                self.put_picture(s, rect, &picture)?;
                self.framebuffer.count_image(s, rect);
                Ok(Progress::Done(Effect::Done))
            }
        }
    }
}
