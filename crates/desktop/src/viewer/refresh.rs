//! The shown picture: the rendered one, its depth, or its difference to the exact one, each redrawn
//! when out of date.

use super::scene3d::{Pass, Tools};
use super::split::SplitScreen;
use super::{Show, Subject, Viewer, depth_picture};
use fbptr_core::memory::VideoMemory;
use std::time::{Duration, Instant};

impl Viewer {
    /// Redraws what is out of date, and returns whether the shown picture changed. To be called
    /// before [`Viewer::shown`].
    pub fn refresh(&mut self) -> bool {
        self.follow_gallery();
        let was_stale = std::mem::take(&mut self.is_stale);
        if was_stale {
            let begun = Instant::now();
            let drawn = match &mut self.subject {
                Subject::Space(_) => self.draw_space(),
                Subject::Nd(nd) => nd.draw(&self.wishes, &mut self.frame),
                Subject::Replay(replay) => replay.draw(&self.wishes, &mut self.frame),
                Subject::Tour(tour) => tour.draw(&self.wishes, &mut self.frame.memory),
            };
            self.drawing_took = begun.elapsed();
            self.failure = drawn.err();
            if let Subject::Replay(replay) = &self.subject
                && let Some(last) = replay.last_frame().filter(|&last| last < self.wishes.frame)
            {
                self.set_frame(last);
            }
            self.version += 1;
            self.rate.pictures += 1;
            self.smoothing.restart();
            // It belongs to the picture before.
            self.walk = None;
        }
        let is_smoother = !was_stale && self.smooth();
        was_stale | std::mem::take(&mut self.has_walked) | is_smoother | self.refresh_other()
    }

    /// Draws a scene of three dimensions, on a split screen if it is asked for and fits.
    fn draw_space(&mut self) -> Result<(), String> {
        let Subject::Space(space) = &mut self.subject else { return Ok(()) };
        if let Some(split) = self.split {
            if self.split_screen.is_none() {
                let size = [self.frame.memory.width(), self.frame.memory.height()];
                self.split_screen = SplitScreen::new(size, self.renderer.options());
            }
            if let Some(screen) = &mut self.split_screen {
                let memory = &mut self.frame.memory;
                return screen.draw(split, space, &self.wishes, &mut self.renderer, &self.pool, memory);
            }
        }
        let tools = Tools { renderer: &mut self.renderer, pool: &self.pool };
        space.draw(&self.wishes, &mut self.frame, tools, Pass::default())
    }

    /// Redraws the picture of depth or difference if it is shown and out of date. Returns whether
    /// it did.
    fn refresh_other(&mut self) -> bool {
        if self.show == Show::Picture || self.other_of == Some(self.version) {
            return false;
        }
        match self.show {
            Show::Picture => {}
            Show::Depth => {
                self.depth_range = match &self.subject {
                    Subject::Nd(nd) => nd.paint_distances(&mut self.other),
                    _ => {
                        let (w, h) = (self.other.width(), self.other.height());
                        depth_picture::paint(
                            &mut self.other,
                            &depth_picture::depths(self.frame.depth.as_ref(), w, h),
                        )
                    }
                };
            }
            Show::Difference => {
                match self.exact.of(self.version) {
                    Some(Ok(difference)) => difference.paint(&mut self.other),
                    Some(Err(_)) => self.other.clear(VideoMemory::CLEAR),
                    None => self.other.bytes_mut().copy_from_slice(self.frame.memory.bytes()),
                }
                if self.exact.wants(self.version) {
                    let work = match &mut self.subject {
                        Subject::Space(space) => space.exact(&self.wishes, &self.frame),
                        Subject::Nd(nd) => nd.exact(&self.wishes, &self.frame),
                        Subject::Replay(replay) => replay.exact(&self.wishes, &self.frame),
                        Subject::Tour(_) => Box::new(|| Err("the tour is compared with nothing".to_owned())),
                    };
                    self.exact.begin(self.version, work);
                }
            }
        }
        self.other_of = Some(self.version);
        true
    }

    /// Waits until the exact picture is computed: for programs without a window, and tests.
    pub fn wait_for_exact(&mut self) {
        while self.show == Show::Difference && self.failure.is_none() {
            self.refresh();
            if self.exact.of(self.version).is_some() {
                self.other_of = None;
                self.refresh();
                return;
            }
            std::thread::sleep(Duration::from_millis(5));
            self.advance(Duration::ZERO);
        }
    }

    /// Returns the shown picture: the rendered one, its depth, or its difference to the exact one.
    pub fn shown(&self) -> &VideoMemory {
        match (self.show, &self.walk) {
            (Show::Picture, Some(walk)) => walk.picture(),
            (Show::Picture, None) => self.smoothing.picture().unwrap_or(&self.frame.memory),
            (Show::Depth | Show::Difference, _) => &self.other,
        }
    }

    /// Returns the error of the last picture, if it could not be drawn.
    pub fn failure(&self) -> Option<&str> {
        self.failure.as_deref()
    }
}
