//! Text of the overlay: help, status, plan, inspector.

use super::keys::{Action, Look, help_lines_of};
use super::split::SplitScreen;
use super::{Overlay, Show, Subject, Viewer, Zoom};
use fbptr_core::memory::FbPtr;
use fbptr_core::scene::ProjectionChoice;

/// Pixels on each side of the inspector.
const ZOOM_SIDE: usize = 11;

impl Viewer {
    /// Returns the current overlay.
    pub fn overlay(&mut self) -> Overlay {
        let mut overlay = Overlay { zoom: self.zoom_box(), captions: self.captions(), ..Overlay::default() };
        if self.shows_help {
            overlay.list = self.help();
        } else if self.shows_plan {
            overlay.list = self.plan();
        }
        if self.shows_rate {
            overlay.top.insert(0, format!("{:5.1} frames/s", self.rate.per_second));
        }
        if self.is_recording {
            overlay.bottom.push("recording: F9 ends it".to_owned());
        }
        overlay.bottom.extend(self.failure.iter().map(|f| format!("not drawn: {f}")));
        overlay.bottom.extend(self.message.as_ref().map(|(text, _)| text.clone()));
        overlay.bottom.extend(self.show_line());
        overlay.bottom.extend(self.walk.as_ref().map(|walk| walk.line()));
        if self.shows_status && !self.shows_help {
            overlay.bottom.extend(self.status());
        }
        overlay
    }

    /// Returns the rectangles of the frame that hold captions: left, top, right, bottom, in pixels.
    fn captions(&self) -> Vec<[usize; 4]> {
        let size = [self.frame.memory.width() as usize, self.frame.memory.height() as usize];
        match &self.subject {
            Subject::Space(_) if self.split.is_some() => SplitScreen::captions(size),
            Subject::Nd(nd) if nd.has_gallery() && self.wishes.shows_gallery => super::nd::captions(size),
            _ => Vec::new(),
        }
    }

    /// Returns the help lines of the keys that have an effect on the current contents.
    fn help(&mut self) -> Vec<String> {
        if matches!(self.subject, Subject::Tour(_)) {
            return super::tour::help();
        }
        let is_animated = self.is_animated();
        let has_ground = matches!(&self.subject, Subject::Space(space) if space.has_ground());
        let has_gallery = matches!(&self.subject, Subject::Nd(nd) if nd.has_gallery());
        let has_turntable = matches!(self.subject, Subject::Space(_));
        let is_stream = matches!(self.subject, Subject::Replay(_));
        let (is_nd, is_spatial, has_hidden_axis) = match &mut self.subject {
            Subject::Space(_) => (false, true, false),
            Subject::Nd(nd) => (true, true, nd.has_hidden_axis()),
            Subject::Replay(replay) => (false, replay.is_spatial(), false),
            Subject::Tour(_) => (false, false, false),
        };
        help_lines_of(is_nd, |action| match action {
            Action::Pause if is_nd => has_gallery,
            Action::Pause | Action::StepForward | Action::StepBack => is_animated,
            Action::PixelForward | Action::PixelBack => is_stream,
            Action::Ground => has_ground,
            Action::Turntable => has_turntable,
            Action::Compare => has_turntable || has_gallery,
            Action::Cull | Action::Hide if is_nd => has_hidden_axis,
            Action::Look(_) | Action::Projection | Action::Cull | Action::Hide | Action::Depth => is_spatial,
            Action::Walk(..) | Action::Turn(..) | Action::Zoom(_) => is_spatial,
            Action::Reset | Action::SaveView => is_spatial,
            _ => true,
        })
    }

    /// Returns the line that describes a picture of depth or difference.
    fn show_line(&self) -> Option<String> {
        match (self.show, self.depth_range) {
            (Show::Picture, _) => None,
            (Show::Depth, None) => Some("nothing here has a depth".to_owned()),
            (Show::Depth, Some([least, largest])) => {
                let what = if matches!(self.subject, Subject::Nd(_)) { "distance" } else { "depth" };
                Some(format!("{what}: white {least:.6} to dark {largest:.6}"))
            }
            (Show::Difference, _) => {
                let exact = match self.subject {
                    Subject::Space(_) => "the exact picture",
                    Subject::Nd(_) => "exact fibres",
                    Subject::Replay(_) | Subject::Tour(_) => "the plain path",
                };
                Some(match self.exact.of(self.version) {
                    None => format!("working out {exact} ..."),
                    Some(Ok(difference)) => difference.line(exact),
                    Some(Err(e)) => format!("{exact} cannot be had: {e}"),
                })
            }
        }
    }

    /// Returns the status lines: name, shading style and view settings.
    fn status(&self) -> Vec<String> {
        let look = match (self.wishes.look, matches!(self.subject, Subject::Nd(_))) {
            (Look::AsGiven, _) => "as given",
            (Look::Wire, false) => "wire",
            (Look::Flat, false) => "flat",
            (Look::Gouraud, false) => "Gouraud",
            (Look::Phong, false) => "Phong",
            (Look::Textured, false) => "textured",
            (Look::Wire, true) => "outlines",
            (Look::Flat, true) => "own colours",
            (Look::Gouraud, true) => "light alone",
            (Look::Phong, true) => "colour and light",
            (Look::Textured, true) => "facet numbers",
        };
        if self.wishes.shows_gallery {
            // The captions say the rest.
            return vec![format!("{} | F1 help", self.name)];
        }
        let mut words = vec![self.name.clone(), look.to_owned()];
        if !matches!(self.subject, Subject::Nd(_)) {
            words.extend(match self.wishes.navigator.projection {
                ProjectionChoice::AsGiven => None,
                ProjectionChoice::Perspective => Some("perspective".to_owned()),
                ProjectionChoice::Orthographic => Some("orthographic".to_owned()),
                ProjectionChoice::Oblique => Some("oblique".to_owned()),
            });
            words.extend(self.wishes.cull.map(|c| format!("cull {}", c.as_str())));
            words.extend(self.wishes.hide.map(|h| format!("hide {}", h.as_str())));
        }
        if self.is_animated() {
            words.push(format!("t {:.2}", self.wishes.time));
            words.extend(self.is_paused.then(|| "paused".to_owned()));
        }
        words.push("F1 help".to_owned());
        let mut lines = vec![words.join(" | ")];
        if let Subject::Nd(nd) = &self.subject {
            lines.extend(nd.status());
        }
        lines
    }

    /// Returns the lines of the plan, with the drawing time.
    fn plan(&mut self) -> Vec<String> {
        let mut lines = match &mut self.subject {
            Subject::Space(space) => space.plan(&self.wishes, &mut self.frame, &self.renderer),
            Subject::Nd(nd) => nd.plan(),
            Subject::Replay(replay) => replay.plan(),
            Subject::Tour(_) => Vec::new(),
        };
        let (took, budget) = (self.drawing_took.as_secs_f64() * 1e3, 1e3 / self.fps);
        lines.push(format!("drawn in {took:.1} ms of the {budget:.1} ms that {} frames/s leave", self.fps));
        lines
    }

    /// Returns the inspector for the pixel that a figure has reached, or that is under the pointer, if
    /// it is shown.
    fn zoom_box(&mut self) -> Option<Zoom> {
        let (walked, numbers) =
            self.walk.as_ref().map_or((None, Vec::new()), |walk| (walk.at(), walk.numbers()));
        let [x, y] = walked.or(self.pointer.filter(|_| self.inspects))?.map(|v| v.floor());
        let (width, height) = (self.frame.memory.width(), self.frame.memory.height());
        let is_inside = (0.0..f64::from(width)).contains(&x) && (0.0..f64::from(height)).contains(&y);
        if !is_inside {
            return None;
        }
        let (x, y) = (x as i32, y as i32);
        let shown = self.shown();
        let half = (ZOOM_SIDE / 2) as i32;
        let around = (-half..=half).flat_map(|dy| (-half..=half).map(move |dx| (x + dx, y + dy)));
        let colors = around.map(|(x, y)| shown.get_pixel(x, y).ok()).collect();
        let [r, g, b, a] = shown.get_pixel(x, y).ok()?;
        let offset = FbPtr::of_pixel(width, x as u32, y as u32);
        let mut lines = vec![
            format!("x {x} y {y}"),
            format!("{offset}"),
            format!("= 0x{:x}", offset.offset_bytes()),
            format!("{r:02x} {g:02x} {b:02x} {a:02x}"),
            format!("R {r} G {g} B {b} A {a}"),
        ];
        if walked.is_some() {
            lines.truncate(1);
            lines.extend(numbers);
            return Some(Zoom { side: ZOOM_SIDE, colors, lines, belongs_left: x >= width as i32 / 2 });
        }
        lines.extend(match &mut self.subject {
            Subject::Space(space) => space.inspect(&self.frame, x, y),
            Subject::Nd(nd) => nd.inspect(&self.frame, x as u32, y as u32),
            Subject::Replay(replay) => replay.inspect(x, y),
            Subject::Tour(_) => Vec::new(),
        });
        Some(Zoom { side: ZOOM_SIDE, colors, lines, belongs_left: x >= width as i32 / 2 })
    }
}
