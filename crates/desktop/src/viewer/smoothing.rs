//! Anti-aliasing at rest: while nothing moves, the picture is drawn again and again, each time
//! moved by parts of a pixel, and the mean is shown.
//!
//! In: 16 sub-frames, one a call, so that a key waits for one picture at most. Out: their mean so
//! far, (sum + n/2) / n in integers; after the last, 4x4 samples a pixel. Whatever redraws the
//! picture starts again, and what is measured or compared has no sub-frames.

use super::frame::ViewerFrame;
use super::scene3d::{Pass, Tools};
use super::studio::SUBFRAMES;
use super::{Show, Subject, Viewer};
use fbptr_core::memory::VideoMemory;

/// The mean of the sub-frames drawn so far.
#[derive(Default)]
pub(super) struct SubframeMean {
    /// Sums of the sub-frames' bytes.
    sums: Vec<u16>,
    /// Number of sub-frames in the sums.
    count: usize,
    /// Frame of the sub-frames, and the mean.
    frames: Option<(ViewerFrame, VideoMemory)>,
}

impl SubframeMean {
    /// Discards the sub-frames.
    pub fn restart(&mut self) {
        self.count = 0;
    }

    /// Returns the mean, if there is any.
    pub fn picture(&self) -> Option<&VideoMemory> {
        self.frames.as_ref().filter(|_| self.count > 0).map(|(_, mean)| mean)
    }

    /// Returns whether all sub-frames are drawn.
    pub fn is_done(&self) -> bool {
        self.count == SUBFRAMES.len()
    }

    /// Adds the sub-frame that was drawn.
    fn add(&mut self) {
        let Some((frame, mean)) = &mut self.frames else { return };
        let bytes = frame.memory.bytes();
        if self.count == 0 {
            self.sums.clear();
            self.sums.resize(bytes.len(), 0);
        }
        self.count += 1;
        let n = self.count as u16;
        for ((sum, byte), shown) in self.sums.iter_mut().zip(bytes).zip(mean.bytes_mut()) {
            *sum += u16::from(*byte);
            *shown = ((*sum + n / 2) / n) as u8;
        }
    }
}

impl Viewer {
    /// Returns whether the picture is at rest and is to be smoothed.
    fn is_at_rest(&self) -> bool {
        let moves = self.is_animated() && !self.is_paused;
        let is_picture = self.show == Show::Picture && !self.inspects && self.split.is_none();
        self.wishes.studio && is_picture && !moves && self.buttons == 0 && self.failure.is_none()
    }

    /// Returns whether the next [`Viewer::refresh`] has a sub-frame to draw.
    pub fn has_more_to_smooth(&self) -> bool {
        matches!(self.subject, Subject::Space(_)) && self.is_at_rest() && !self.smoothing.is_done()
    }

    /// Draws the next sub-frame, if the picture is at rest. Returns whether the shown picture
    /// changed.
    pub(super) fn smooth(&mut self) -> bool {
        if !self.is_at_rest() {
            let was_smooth = self.smoothing.count > 0;
            self.smoothing.restart();
            return was_smooth;
        }
        if self.smoothing.is_done() {
            return false;
        }
        let Subject::Space(space) = &mut self.subject else { return false };
        if self.smoothing.frames.is_none() {
            let size = [self.frame.memory.width(), self.frame.memory.height()];
            let frame = ViewerFrame::new(size).and_then(|f| Ok((f, VideoMemory::new(size[0], size[1])?)));
            self.smoothing.frames = frame.ok();
        }
        let Some((frame, _)) = &mut self.smoothing.frames else { return false };
        let tools = Tools { renderer: &mut self.renderer, pool: &self.pool };
        let pass = Pass { shift: Some(SUBFRAMES[self.smoothing.count]), ..Pass::default() };
        if space.draw(&self.wishes, frame, tools, pass).is_err() {
            return false;
        }
        self.smoothing.add();
        true
    }

    /// Draws all sub-frames of a picture at rest: for programs without a window.
    pub fn finish_smoothing(&mut self) {
        self.refresh();
        while self.has_more_to_smooth() && self.refresh() {}
    }

    /// Draws all sub-frames of the picture, also of one that moves: for the frames of a movie.
    pub fn smooth_fully(&mut self) {
        let was_paused = std::mem::replace(&mut self.is_paused, true);
        self.finish_smoothing();
        self.is_paused = was_paused;
    }
}
