//! Effects of keys, pointer and wheel on the viewer.

use super::keys::{self, Action, Key, Look};
use super::split::SplitScreen;
use super::{Request, Show, Split, Subject, Viewer};
use fbptr_command::{self as command, Command};
use fbptr_core::scene::{Camera, Cull, HiddenSurface, Navigator, Projection, contain};
use glam::DVec3;

/// Angle of one key step.
const TURN_RAD: f64 = std::f64::consts::PI / 36.0;
/// Length of one key step, as a fraction of the distance to the target.
const WALK_PART: f64 = 0.05;
/// Factor by which one key step changes the distance to the target.
const ZOOM_FACTOR: f64 = 0.9;

impl Viewer {
    /// Handles a key press or release, and returns the resulting request, if any.
    pub fn key(&mut self, key: Key, is_down: bool) -> Option<Request> {
        if !is_down {
            self.keys_down.remove(&key);
            return None;
        }
        let is_repeat = !self.keys_down.insert(key);
        let binding = keys::binding(key);
        if is_repeat && !binding.repeats() {
            return None;
        }
        if let (Subject::Nd(_), false) = (&self.subject, binding.action == Action::Pause) {
            // A polytope turns by itself until a key is pressed.
            self.wishes.turns = false;
        }
        self.act(binding.action)
    }

    /// Executes the action of a key.
    fn act(&mut self, action: Action) -> Option<Request> {
        if self.act_in_tour(action) {
            return None;
        }
        match action {
            Action::Quit => return Some(Request::Quit),
            Action::Snapshot => return Some(Request::Snapshot),
            Action::Record => return Some(Request::Record),
            Action::Fullscreen => return Some(Request::Fullscreen),
            Action::Scaling => return Some(Request::Scaling),
            Action::Crt => return Some(Request::Crt),
            Action::Ground => self.toggle_ground(),
            Action::Turntable => self.toggle_turntable(),
            Action::Compare => self.compare_next(),
            Action::SaveView => return self.save_view(),
            // Help and plan share a corner: each replaces the other.
            Action::Help => (self.shows_help, self.shows_plan) = (!self.shows_help, false),
            Action::Status => self.shows_status = !self.shows_status,
            Action::FrameRate => self.shows_rate = !self.shows_rate,
            Action::Plan => (self.shows_plan, self.shows_help) = (!self.shows_plan, false),
            Action::Inspect => {
                self.end_split();
                self.inspects = !self.inspects;
                self.set_keeps_depth();
            }
            Action::Depth => self.toggle(Show::Depth),
            Action::Difference => self.toggle(Show::Difference),
            Action::Pause => {
                if let Subject::Nd(nd) = &self.subject
                    && nd.has_gallery()
                {
                    self.wishes.turns = !self.wishes.turns;
                    self.is_paused = false;
                    return None;
                }
                self.is_paused = !self.is_paused;
                if !self.is_animated() {
                    self.say("nothing moves by itself here".to_owned());
                }
            }
            Action::StepForward | Action::StepBack => {
                self.is_paused = true;
                let before = self.wishes.frame;
                self.step(if action == Action::StepForward { 1 } else { -1 });
                if !self.is_animated() {
                    self.say(format!("frame {}: nothing moves by itself here", self.wishes.frame));
                } else if self.wishes.frame == before {
                    self.say(format!("there is no frame beyond {before}"));
                }
            }
            Action::PixelForward | Action::PixelBack => self.walk_figure(action == Action::PixelForward),
            Action::Look(look) => self.set_look(look),
            Action::Projection => self.next_projection(),
            Action::Cull => self.next_cull(),
            Action::Hide => self.next_hide(),
            Action::Reset => {
                self.wishes.navigator = Navigator::default();
                (self.turned_frames, self.wishes.turned_rad) = (0, 0.0);
                if let Subject::Nd(nd) = &mut self.subject {
                    nd.reset();
                }
                self.is_stale = true;
            }
            Action::Walk(axis, steps) => self.walk(axis, steps),
            Action::Turn(axis, steps) => self.turn(axis, steps),
            Action::Zoom(steps) => self.zoom(steps),
            Action::NextPlane(_) | Action::TurnPlane(_) | Action::TurnAbout => self.act_nd(action),
        }
        None
    }

    /// Executes an action that only N-dimensional scenes have.
    fn act_nd(&mut self, action: Action) {
        let Subject::Nd(nd) = &mut self.subject else {
            return self.say("that key is for scenes of N dimensions".to_owned());
        };
        match action {
            Action::NextPlane(by) => nd.next_plane(by),
            Action::TurnPlane(steps) => {
                nd.turn_plane(steps);
                self.is_stale = true;
            }
            _ => {
                let center = nd.turn_about_other();
                self.say(format!("turning about {center}"));
            }
        }
    }

    /// Switches between another picture and the rendered one.
    fn toggle(&mut self, show: Show) {
        self.end_split();
        self.show = if self.show == show { Show::Picture } else { show };
        self.other_of = None;
        self.set_keeps_depth();
    }

    /// Shows or hides the studio's ground.
    fn toggle_ground(&mut self) {
        match &self.subject {
            Subject::Space(space) if space.has_ground() => {
                self.wishes.hides_ground = !self.wishes.hides_ground;
                self.is_stale = true;
            }
            _ => self.say(
                "only meshes and glTF models stand on a ground, in a window or with --studio".to_owned(),
            ),
        }
    }

    /// Goes on to the next comparison on a split screen; shows a polytope as a gallery, or by the
    /// eye alone.
    fn compare_next(&mut self) {
        match &self.subject {
            Subject::Space(_) => {
                self.split = Split::after(self.split);
                let size = [self.frame.memory.width(), self.frame.memory.height()];
                if self.split.is_some() && !SplitScreen::fits(size) {
                    self.split = None;
                    return self.say("the frame is too small for a split screen".to_owned());
                }
                (self.show, self.inspects) = (Show::Picture, false);
                self.set_keeps_depth();
                self.is_stale = true;
            }
            Subject::Nd(nd) if nd.has_gallery() => {
                self.wants_gallery = !self.wishes.shows_gallery;
                if self.wants_gallery {
                    (self.show, self.inspects, self.wishes.look) = (Show::Picture, false, Look::AsGiven);
                }
            }
            _ => self.say("there are no two modes to compare here".to_owned()),
        }
    }

    /// Returns from a split screen to one picture.
    fn end_split(&mut self) {
        self.is_stale |= self.split.take().is_some();
    }

    /// Switches between the gallery of a polytope and the eye's picture alone, which is shown where
    /// its looks, depths or differences are.
    pub(super) fn follow_gallery(&mut self) {
        let Subject::Nd(nd) = &self.subject else { return };
        let is_plain = self.show == Show::Picture && !self.inspects && self.wishes.look == Look::AsGiven;
        let shows = self.wants_gallery && is_plain && nd.has_gallery();
        if std::mem::replace(&mut self.wishes.shows_gallery, shows) != shows {
            self.is_stale = true;
        }
    }

    /// Starts or stops the turntable.
    fn toggle_turntable(&mut self) {
        let Subject::Space(space) = &mut self.subject else {
            return self.say("the turntable is for meshes and scenes".to_owned());
        };
        self.wishes.turns = !self.wishes.turns;
        if self.wishes.turns {
            space.leave_room_to_turn(true);
            // What turns takes time, and a scene's own movement goes on meanwhile.
            self.wishes.was_paused = std::mem::take(&mut self.is_paused);
        } else {
            self.is_paused |= std::mem::take(&mut self.wishes.was_paused);
        }
        self.say(if self.wishes.turns { "turning: T stops it" } else { "stopped" }.to_owned());
        self.is_stale = true;
    }

    fn set_keeps_depth(&mut self) {
        let is_bare = self.show == Show::Difference;
        if std::mem::replace(&mut self.wishes.is_bare, is_bare) != is_bare {
            self.is_stale |= self.wishes.studio;
        }
        let keeps = self.show == Show::Depth || self.inspects;
        if self.wishes.keeps_depth != keeps {
            self.wishes.keeps_depth = keeps;
            // N-dimensional scenes and streams store their depth in any case.
            self.is_stale |= matches!(self.subject, Subject::Space(_));
        }
    }

    fn set_look(&mut self, look: Look) {
        self.wishes.look = look;
        self.is_stale = true;
        // Depths look the same in every style: the key would seem to do nothing.
        if self.show == Show::Depth {
            self.show = Show::Picture;
        }
        let time = self.wishes.time;
        let remark = match &mut self.subject {
            Subject::Replay(replay) if look != Look::AsGiven => {
                (!replay.is_spatial()).then_some("this stream draws nothing in three dimensions")
            }
            Subject::Space(space) if look == Look::Textured => match space.textures(time) {
                (true, _) => None,
                (false, true) => Some("no texture: squares by the mesh's own coordinates"),
                (false, false) => Some("no texture, and no coordinates for one"),
            },
            _ => None,
        };
        if let Some(remark) = remark {
            self.say(remark.to_owned());
        }
    }

    fn next_projection(&mut self) {
        match self.given_camera() {
            Some(camera) => {
                let navigator = &mut self.wishes.navigator;
                navigator.projection = navigator.projection.next(&camera.projection);
                self.is_stale = true;
            }
            None => self.say("scenes of N dimensions are seen in perspective".to_owned()),
        }
    }

    fn next_cull(&mut self) {
        self.is_stale = true;
        if let Subject::Nd(nd) = &mut self.subject {
            self.wants_gallery = false;
            if !nd.toggle_slice() {
                self.say("no axis is hidden: there is no aperture".to_owned());
            }
            return;
        }
        self.wishes.cull = match self.wishes.cull {
            None => Some(Cull::Front),
            Some(Cull::Front) => Some(Cull::None),
            Some(Cull::None) => Some(Cull::Back),
            Some(Cull::Back) => None,
        };
    }

    fn next_hide(&mut self) {
        self.is_stale = true;
        if let Subject::Nd(nd) = &mut self.subject {
            self.wants_gallery = false;
            if !nd.next_fibre() {
                self.say("no axis is hidden: fibres are rays".to_owned());
            }
            return;
        }
        self.wishes.hide = match self.wishes.hide {
            None => Some(HiddenSurface::Painter),
            Some(HiddenSurface::Painter) => Some(HiddenSurface::None),
            Some(HiddenSurface::None) => Some(HiddenSurface::ZBuffer),
            Some(HiddenSurface::ZBuffer) => None,
        };
    }

    /// Returns the author's camera, or `None` for N-dimensional scenes.
    fn given_camera(&mut self) -> Option<Camera> {
        match &mut self.subject {
            Subject::Space(space) => Some(space.given_camera(self.wishes.time)),
            Subject::Replay(replay) => Some(replay.given_camera()),
            Subject::Nd(_) | Subject::Tour(_) => None,
        }
    }

    /// Moves along a viewer's axis (0 ahead, 1 left, 2 up) by key steps.
    fn walk(&mut self, axis: usize, steps: f64) {
        self.is_stale = true;
        // Without perspective, moving ahead does not enlarge the picture, so it zooms instead.
        let is_parallel = self.given_camera().is_some_and(|c| self.wishes.navigator.is_parallel(&c));
        match (&mut self.subject, axis) {
            (Subject::Nd(nd), _) => nd.walk(axis, steps),
            (_, 0) if is_parallel => self.zoom(steps / 2.0),
            (_, 0) => self.walk_by([0.0, 0.0, steps * WALK_PART]),
            (_, 1) => self.walk_by([-steps * WALK_PART, 0.0, 0.0]),
            (_, _) => self.walk_by([0.0, steps * WALK_PART, 0.0]),
        }
    }

    /// Moves right, up and ahead by fractions of the distance to the target.
    fn walk_by(&mut self, by: [f64; 3]) {
        if let Some(camera) = self.given_camera() {
            self.wishes.navigator.walk(&camera, by);
            self.is_stale = true;
        }
    }

    fn turn(&mut self, axis: usize, steps: f64) {
        self.is_stale = true;
        if let Subject::Nd(nd) = &mut self.subject {
            return nd.turn(0, axis, steps);
        }
        match axis {
            1 => self.orbit(-steps * TURN_RAD, 0.0),
            _ => self.orbit(0.0, -steps * TURN_RAD),
        }
    }

    /// Moves the camera around its target, about the scene's up direction.
    fn orbit(&mut self, yaw_rad: f64, pitch_rad: f64) {
        if let Some(camera) = self.given_camera() {
            let up = match &self.subject {
                // A stream's author chooses the up direction, z for some.
                Subject::Replay(_) => nearest_axis(camera.look_at.up),
                // OBJ and X3D scenes are upright along y, however their cameras are tilted.
                Subject::Space(_) | Subject::Nd(_) | Subject::Tour(_) => DVec3::Y,
            };
            self.wishes.navigator.orbit(&camera, up, yaw_rad, pitch_rad);
            self.is_stale = true;
        }
    }

    /// Moves nearer by key steps; in N dimensions, along the second axis of the selected plane.
    fn zoom(&mut self, steps: f64) {
        self.is_stale = true;
        match &mut self.subject {
            Subject::Nd(nd) => {
                let [_, along] = nd.plane();
                nd.walk(along, steps);
            }
            _ => self.wishes.navigator.zoom_by(libm::pow(ZOOM_FACTOR, steps)),
        }
    }

    /// Handles the pointer's position in frame pixels (possibly outside the frame), or `None` if it
    /// left the window. `buttons` is the sum of 1 for left, 2 for middle and 4 for right.
    pub fn pointer(&mut self, at: Option<[f64; 2]>, buttons: u8) {
        let (before, held) =
            (std::mem::replace(&mut self.pointer, at), std::mem::replace(&mut self.buttons, buttons));
        let (Some([x0, y0]), Some([x1, y1])) = (before, at) else { return };
        // A press starts a drag at the current position.
        if buttons == 0 || held == 0 || [x0, y0] == [x1, y1] {
            return;
        }
        let height = f64::from(self.frame.memory.height());
        let (dx, dy) = ((x1 - x0) / height, (y1 - y0) / height);
        if !(dx.is_finite() && dy.is_finite()) {
            return;
        }
        self.is_stale = true;
        match (&mut self.subject, buttons & 1 != 0) {
            (Subject::Nd(nd), true) => {
                nd.turn_by(0, 1, 90.0 * dx);
                nd.turn_by(0, 2, 90.0 * dy);
            }
            (Subject::Nd(nd), false) => {
                nd.walk(1, 20.0 * dx);
                nd.walk(2, 20.0 * dy);
            }
            (_, true) => self.orbit(-dx * std::f64::consts::PI, -dy * std::f64::consts::PI),
            (_, false) => self.walk_by([-dx, dy, 0.0]),
        }
    }

    /// Handles the wheel, turned by this many steps; up is positive.
    pub fn wheel(&mut self, steps: f64) {
        if steps.is_finite() && steps != 0.0 {
            self.is_stale = true;
            match &mut self.subject {
                Subject::Nd(nd) => nd.walk(0, steps),
                _ => self.wishes.navigator.zoom_by(libm::pow(ZOOM_FACTOR, steps)),
            }
        }
    }

    /// Returns a request to save the view: the scene's JSON, or the camera as commands.
    fn save_view(&mut self) -> Option<Request> {
        if let Subject::Nd(nd) = &self.subject {
            let mut bytes = nd.scene().to_value().to_string().into_bytes();
            bytes.push(b'\n');
            return Some(Request::Save { ending: "json", bytes });
        }
        let wishes = self.wishes.clone();
        let aspect = f64::from(self.frame.memory.width()) / f64::from(self.frame.memory.height());
        let Camera { look_at, mut projection } = match &mut self.subject {
            Subject::Space(space) => space.camera(&wishes),
            Subject::Replay(replay) => wishes.navigator.apply(&replay.given_camera(), None, aspect),
            Subject::Nd(_) | Subject::Tour(_) => return None,
        };
        // No command describes a window that adapts to the frame, so its adapted size is printed.
        if let Projection::OrthoContain { window, near, far } = projection {
            projection = Projection::Ortho { window: contain(window, aspect), near, far };
        }
        let stand = Command::LookAt { eye: look_at.eye, reference: look_at.reference, up: look_at.up };
        let mut text = Vec::new();
        for command in [stand, Command::Projection(Box::new(projection))] {
            // A command that has no text form is left out.
            let _ = command::encode(&command, &mut text);
        }
        Some(Request::Print(String::from_utf8_lossy(&text).into_owned()))
    }
}

/// Returns the coordinate axis, with sign, nearest to `v`; on ties, y is preferred.
fn nearest_axis(v: DVec3) -> DVec3 {
    let axes = [DVec3::Y, DVec3::Z, DVec3::X].map(|axis| axis * axis.dot(v).signum());
    let mut nearest = axes[0];
    for axis in axes {
        if axis.dot(v) > nearest.dot(v) {
            nearest = axis;
        }
    }
    nearest
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_axis_keeps_its_sign() {
        for (v, axis) in [
            (DVec3::new(0.1, 0.9, -0.3), DVec3::Y),
            (DVec3::new(0.0, -2.0, 1.0), -DVec3::Y),
            (DVec3::new(0.3, 0.3, 0.9), DVec3::Z),
            (DVec3::new(-3.0, 1.0, 1.0), -DVec3::X),
            (DVec3::new(1.0, 1.0, 1.0), DVec3::Y),
        ] {
            assert_eq!(nearest_axis(v), axis, "{v}");
        }
    }
}
