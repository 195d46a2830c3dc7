//! THE VIEWER: a file seen from everywhere. A state machine without a window: keys, pointer and time in; picture, overlay
//! and requests out, so that every key is tested without a screen.
//!
//! In: a [`Model`] (mesh, X3D document, N-dimensional scene, command stream), [`Key`]s, the pointer in frame pixels, time
//! as it passes. Out: video memory, an [`Overlay`] that is never in it, and [`Request`]s that are for whoever has files.
//! Promises: what is shown at the start is what rendering the file gives; a view of N dimensions is the picture that its
//! JSON gives; nothing is drawn again that did not change. It reads a clock only to say how long drawing took.

mod depth_picture;
mod difference;
mod frame;
mod keys;
mod nd;
mod overlay;
mod replay;
mod space;

pub use keys::{Action, BINDINGS, Binding, Key, Look, MOUSE, help_lines};
pub use overlay::{Overlay, Zoom};
pub use replay::MakeEngine;

use crate::command::{self, Command};
use crate::eye::{EyeScene, Pool};
use crate::load::x3d::X3dDocument;
use crate::memory::{FbPtr, VideoMemory};
use crate::pipeline::Renderer;
use crate::scene::{
    Camera, Cull, Geometry, HiddenSurface, Lens, Navigator, Projection, ProjectionChoice, QualityUse,
    ShadeMode, TextureUse, contain,
};
use difference::Exact;
use frame::Frame;
use nd::Nd;
use replay::Replay;
use space::{Source, Space};
use std::collections::HashSet;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// How long a message is shown.
const MESSAGE_TIME: Duration = Duration::from_secs(4);
/// A step by key: a turn, a part of the distance to what is looked at, a factor of that distance.
const TURN_RAD: f64 = std::f64::consts::PI / 36.0;
const WALK_PART: f64 = 0.05;
const ZOOM_FACTOR: f64 = 0.9;
/// Pixels a side of the inspector.
const ZOOM_SIDE: usize = 11;

/// What is looked at.
pub enum Model {
    /// A mesh, framed and lit.
    Mesh(Arc<Geometry>),
    /// An X3D document; one without a viewpoint is framed.
    X3d(Box<X3dDocument>),
    /// A scene of N dimensions.
    Eye(Box<EyeScene>),
    /// A stream of commands, and what makes the engine that it is played on (of the frame's size).
    Stream(Arc<[u8]>, MakeEngine),
}

/// How a viewer begins.
pub struct Options {
    /// What is looked at, as the overlay calls it.
    pub name: String,
    /// The frame's size in pixels; [`Viewer::frame_size`] knows what fits.
    pub size: [u32; 2],
    /// Seconds since the scene's start.
    pub time: f64,
    /// Frames a second.
    pub fps: f64,
    /// What draws.
    pub renderer: Renderer,
    /// Whose threads share the work of N dimensions.
    pub pool: Arc<dyn Pool + Send + Sync>,
}

/// What the viewer asks of whoever has files and windows.
#[derive(Clone, Debug, PartialEq)]
pub enum Request {
    /// Close.
    Quit,
    /// Save what is shown as PNG.
    Snapshot,
    /// Begin or end a GIF of what is shown.
    Record,
    /// Save these bytes in a file with this ending.
    Save {
        /// The ending, without its point.
        ending: &'static str,
        /// What to save.
        bytes: Vec<u8>,
    },
    /// Print this.
    Print(String),
}

/// Which picture is shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Show {
    Picture,
    Depth,
    Difference,
}

/// What the user wishes to see.
#[derive(Clone, Debug, Default)]
struct Wishes {
    look: Look,
    cull: Option<Cull>,
    hide: Option<HiddenSurface>,
    navigator: Navigator,
    /// Seconds since the scene's start, a whole number of frames after the first.
    time: f64,
    /// Frames since the scene's start.
    frame: u64,
    /// Whether depth and faces are wanted where the picture can do without.
    keeps_depth: bool,
}

impl Wishes {
    fn lens(&self) -> Lens {
        let (shade, textures) = match self.look {
            Look::AsGiven => (None, TextureUse::AsGiven),
            Look::Wire => (Some(ShadeMode::Wire), TextureUse::AsGiven),
            Look::Flat => (Some(ShadeMode::Flat), TextureUse::Off),
            Look::Gouraud => (Some(ShadeMode::Gouraud), TextureUse::Off),
            Look::Phong => (Some(ShadeMode::Phong), TextureUse::Off),
            Look::Textured => (Some(ShadeMode::Phong), TextureUse::AsGiven),
        };
        Lens {
            navigator: self.navigator,
            shade,
            cull: self.cull,
            hide: self.hide,
            textures,
            quality: QualityUse::AsGiven,
        }
    }
}

enum Subject {
    Space(Box<Space>),
    Nd(Box<Nd>),
    Replay(Box<Replay>),
}

/// See the module's text.
pub struct Viewer {
    subject: Subject,
    name: String,
    start_time: f64,
    fps: f64,
    renderer: Renderer,
    pool: Arc<dyn Pool + Send + Sync>,
    wishes: Wishes,
    frame: Frame,
    /// Depth or difference, where one of them is shown.
    other: VideoMemory,
    show: Show,
    exact: Exact,
    /// Counts pictures; and the one for which `other` was made.
    version: u64,
    other_of: Option<u64>,
    is_stale: bool,
    depth_range: Option<[f64; 2]>,
    failure: Option<String>,
    is_paused: bool,
    /// Part of a frame that has passed.
    passed: f64,
    keys_down: HashSet<Key>,
    pointer: Option<[f64; 2]>,
    buttons: u8,
    shows_help: bool,
    shows_status: bool,
    shows_rate: bool,
    shows_plan: bool,
    inspects: bool,
    is_recording: bool,
    message: Option<(String, Duration)>,
    clock: Duration,
    drawing_took: Duration,
    rate: Rate,
}

/// Pictures drawn in the last second.
#[derive(Default)]
struct Rate {
    since: Duration,
    pictures: u32,
    per_second: f64,
}

impl Viewer {
    /// The frame that fits a model best: 640x480, or whole enlargements of an N-dimensional screen.
    pub fn frame_size(model: &Model) -> [u32; 2] {
        match model {
            Model::Eye(scene) => Nd::frame_size(scene),
            _ => [640, 480],
        }
    }

    /// A viewer that looks at `model`.
    ///
    /// # Errors
    /// A frame that cannot be had, or a model that cannot be drawn at all.
    pub fn new(model: Model, options: Options) -> Result<Self, String> {
        let Options { name, size, time, fps, renderer, pool } = options;
        let frame = Frame::new(size).map_err(|e| e.to_string())?;
        let other = VideoMemory::new(size[0], size[1]).map_err(|e| e.to_string())?;
        let subject = Self::subject(model, &name, size, &pool);
        let frame_number = if time > 0.0 { (time * fps) as u64 } else { 0 };
        let mut viewer = Viewer {
            subject,
            name,
            start_time: time,
            fps,
            renderer,
            pool,
            wishes: Wishes { time, frame: frame_number, ..Wishes::default() },
            frame,
            other,
            show: Show::Picture,
            exact: Exact::default(),
            version: 0,
            other_of: None,
            is_stale: true,
            depth_range: None,
            failure: None,
            is_paused: false,
            passed: 0.0,
            keys_down: HashSet::new(),
            pointer: None,
            buttons: 0,
            shows_help: false,
            shows_status: true,
            shows_rate: false,
            shows_plan: false,
            inspects: false,
            is_recording: false,
            message: None,
            clock: Duration::ZERO,
            drawing_took: Duration::ZERO,
            rate: Rate::default(),
        };
        viewer.refresh();
        match &viewer.failure {
            Some(failure) => Err(failure.clone()),
            None => Ok(viewer),
        }
    }

    fn subject(model: Model, name: &str, size: [u32; 2], pool: &Arc<dyn Pool + Send + Sync>) -> Subject {
        let aspect = f64::from(size[0]) / f64::from(size[1]);
        match model {
            Model::Mesh(geometry) => {
                Subject::Space(Box::new(Space::new(Source::Mesh(geometry), name, aspect)))
            }
            Model::X3d(document) => Subject::Space(Box::new(Space::new(Source::X3d(document), name, aspect))),
            Model::Eye(scene) => Subject::Nd(Box::new(Nd::new(*scene, Arc::clone(pool)))),
            Model::Stream(bytes, make_engine) => Subject::Replay(Box::new(Replay::new(bytes, make_engine))),
        }
    }

    /// Looks at another model from the same place, in the same way: the file has changed.
    pub fn reload(&mut self, model: Model) {
        let size = [self.frame.memory.width(), self.frame.memory.height()];
        let mut subject = Self::subject(model, &self.name, size, &self.pool);
        if let (Subject::Nd(old), Subject::Nd(new)) = (&self.subject, &mut subject) {
            new.take_place_of(old);
        }
        self.subject = subject;
        self.is_stale = true;
        self.say("reloaded".to_owned());
    }

    /// Says something on the screen for a while.
    pub fn say(&mut self, text: String) {
        self.message = Some((text, self.clock));
    }

    /// Tells whether a GIF is being written, for the overlay.
    pub fn set_recording(&mut self, is_recording: bool) {
        self.is_recording = is_recording;
    }

    /// Commands of a stream that were refused, as its file's owner is told, each once.
    pub fn take_complaints(&mut self, file: &str) -> Vec<String> {
        match &mut self.subject {
            Subject::Replay(replay) => replay.take_complaints().iter().map(|c| c.play_line(file)).collect(),
            _ => Vec::new(),
        }
    }

    // ---- time ----

    /// Whether anything moves by itself.
    pub fn is_animated(&self) -> bool {
        match &self.subject {
            Subject::Space(space) => space.is_animated(),
            Subject::Nd(_) => false,
            Subject::Replay(replay) => replay.is_animated(),
        }
    }

    /// Lets time pass.
    pub fn advance(&mut self, by: Duration) {
        self.clock += by;
        if self.message.as_ref().is_some_and(|(_, since)| self.clock >= *since + MESSAGE_TIME) {
            self.message = None;
        }
        let window = self.clock - self.rate.since;
        if window >= Duration::from_millis(500) {
            self.rate.per_second = f64::from(self.rate.pictures) / window.as_secs_f64();
            (self.rate.since, self.rate.pictures) = (self.clock, 0);
        }
        if self.exact.poll() {
            self.other_of = None;
        }
        // An exact picture is one of a moment: time waits for it.
        if self.is_paused || !self.is_animated() || self.show == Show::Difference {
            return;
        }
        self.passed += by.as_secs_f64() * self.fps;
        let frames = self.passed.floor();
        self.passed -= frames;
        self.step(frames as i64);
    }

    /// Moves time by whole frames.
    pub fn step(&mut self, frames: i64) {
        let last = match &self.subject {
            Subject::Replay(replay) => replay.last_frame().unwrap_or(u64::MAX),
            _ => u64::MAX,
        };
        let frame = self.wishes.frame.saturating_add_signed(frames).min(last);
        if frame != self.wishes.frame {
            self.set_frame(frame);
            self.is_stale = true;
        }
    }

    fn set_frame(&mut self, frame: u64) {
        let first = if self.start_time > 0.0 { (self.start_time * self.fps) as u64 } else { 0 };
        self.wishes.frame = frame;
        self.wishes.time = self.start_time + (frame as f64 - first as f64) / self.fps;
    }

    /// Seconds since the scene's start.
    pub fn time(&self) -> f64 {
        self.wishes.time
    }

    // ---- keys and pointer ----

    /// A key goes down or up.
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
        self.act(binding.action)
    }

    fn act(&mut self, action: Action) -> Option<Request> {
        match action {
            Action::Quit => return Some(Request::Quit),
            Action::Snapshot => return Some(Request::Snapshot),
            Action::Record => return Some(Request::Record),
            Action::SaveView => return self.save_view(),
            // They share a corner: each takes the other's place.
            Action::Help => (self.shows_help, self.shows_plan) = (!self.shows_help, false),
            Action::Status => self.shows_status = !self.shows_status,
            Action::FrameRate => self.shows_rate = !self.shows_rate,
            Action::Plan => (self.shows_plan, self.shows_help) = (!self.shows_plan, false),
            Action::Inspect => {
                self.inspects = !self.inspects;
                self.set_keeps_depth();
            }
            Action::Depth => self.toggle(Show::Depth),
            Action::Difference => self.toggle(Show::Difference),
            Action::Pause => {
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
            Action::Look(look) => self.set_look(look),
            Action::Projection => self.next_projection(),
            Action::Cull => self.next_cull(),
            Action::Hide => self.next_hide(),
            Action::Reset => {
                self.wishes.navigator = Navigator::default();
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
            _ => nd.turn_about_other(),
        }
    }

    fn toggle(&mut self, show: Show) {
        self.show = if self.show == show { Show::Picture } else { show };
        self.other_of = None;
        self.set_keeps_depth();
    }

    fn set_keeps_depth(&mut self) {
        let keeps = self.show == Show::Depth || self.inspects;
        if self.wishes.keeps_depth != keeps {
            self.wishes.keeps_depth = keeps;
            // N dimensions and streams keep their depth in any case.
            self.is_stale |= matches!(self.subject, Subject::Space(_));
        }
    }

    fn set_look(&mut self, look: Look) {
        self.wishes.look = look;
        self.is_stale = true;
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

    /// The author's camera, where there is one of three dimensions.
    fn given_camera(&mut self) -> Option<Camera> {
        match &mut self.subject {
            Subject::Space(space) => Some(space.given_camera(self.wishes.time)),
            Subject::Replay(replay) => Some(replay.given_camera()),
            Subject::Nd(_) => None,
        }
    }

    fn walk(&mut self, axis: usize, steps: f64) {
        self.is_stale = true;
        // Without a vanishing point nothing grows on the way: then it grows by itself.
        let is_parallel = self.given_camera().is_some_and(|c| self.wishes.navigator.is_parallel(&c));
        match (&mut self.subject, axis) {
            (Subject::Nd(nd), _) => nd.walk(axis, steps),
            (_, 0) if is_parallel => self.zoom(steps / 2.0),
            (_, 0) => self.walk_by([0.0, 0.0, steps * WALK_PART]),
            (_, 1) => self.walk_by([-steps * WALK_PART, 0.0, 0.0]),
            (_, _) => self.walk_by([0.0, steps * WALK_PART, 0.0]),
        }
    }

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

    fn orbit(&mut self, yaw_rad: f64, pitch_rad: f64) {
        if let Some(camera) = self.given_camera() {
            self.wishes.navigator.orbit(&camera, yaw_rad, pitch_rad);
            self.is_stale = true;
        }
    }

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

    /// The pointer is at a place of the frame, in pixels (off the frame too), or away; buttons are 1 left + 2 middle + 4 right.
    pub fn pointer(&mut self, at: Option<[f64; 2]>, buttons: u8) {
        let (before, held) =
            (std::mem::replace(&mut self.pointer, at), std::mem::replace(&mut self.buttons, buttons));
        let (Some([x0, y0]), Some([x1, y1])) = (before, at) else { return };
        // A press begins a drag where it is.
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

    /// The wheel turned by so many steps, up is positive.
    pub fn wheel(&mut self, steps: f64) {
        if steps.is_finite() && steps != 0.0 {
            self.is_stale = true;
            match &mut self.subject {
                Subject::Nd(nd) => nd.walk(0, steps),
                _ => self.wishes.navigator.zoom_by(libm::pow(ZOOM_FACTOR, steps)),
            }
        }
    }

    /// The view as something to keep: the scene's JSON, or the camera in commands.
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
            Subject::Nd(_) => return None,
        };
        // No verb asks for a window that grows: what it grew to is said.
        if let Projection::OrthoContain { window, near, far } = projection {
            projection = Projection::Ortho { window: contain(window, aspect), near, far };
        }
        let stand = Command::LookAt { eye: look_at.eye, reference: look_at.reference, up: look_at.up };
        let mut text = Vec::new();
        for command in [stand, Command::Projection(Box::new(projection))] {
            // What cannot stand in a stream is left out.
            let _ = command::encode(&command, &mut text);
        }
        Some(Request::Print(String::from_utf8_lossy(&text).into_owned()))
    }

    // ---- what is seen ----

    /// Draws what is out of date; whether what is shown has changed. To be called before [`Viewer::shown`].
    pub fn refresh(&mut self) -> bool {
        let was_stale = std::mem::take(&mut self.is_stale);
        if was_stale {
            let begun = Instant::now();
            let drawn = match &mut self.subject {
                Subject::Space(space) => space.draw(&self.wishes, &mut self.frame, &mut self.renderer),
                Subject::Nd(nd) => nd.draw(&self.wishes, &mut self.frame),
                Subject::Replay(replay) => replay.draw(&self.wishes, &mut self.frame),
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
        }
        was_stale | self.refresh_other()
    }

    /// Makes the picture of depth, or of the difference, where it is shown and out of date.
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
                    };
                    self.exact.begin(self.version, work);
                }
            }
        }
        self.other_of = Some(self.version);
        true
    }

    /// Waits for an exact picture that is being worked out: for programs without a window, and tests.
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

    /// What is shown: the picture, its depth, or its difference to the exact one.
    pub fn shown(&self) -> &VideoMemory {
        match self.show {
            Show::Picture => &self.frame.memory,
            Show::Depth | Show::Difference => &self.other,
        }
    }

    /// Why the last picture could not be drawn.
    pub fn failure(&self) -> Option<&str> {
        self.failure.as_deref()
    }

    /// What lies over the picture now.
    pub fn overlay(&mut self) -> Overlay {
        let mut overlay = Overlay { zoom: self.zoom_box(), ..Overlay::default() };
        if self.shows_help {
            overlay.top = help_lines(matches!(self.subject, Subject::Nd(_)));
        } else if self.shows_plan {
            overlay.top = self.plan();
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
        if self.shows_status && !self.shows_help {
            overlay.bottom.extend(self.status());
        }
        overlay
    }

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
                    Subject::Replay(_) => "the plain path",
                };
                Some(match self.exact.of(self.version) {
                    None => format!("working out {exact} ..."),
                    Some(Ok(difference)) => difference.line(exact),
                    Some(Err(e)) => format!("{exact} cannot be had: {e}"),
                })
            }
        }
    }

    /// What is seen, and how.
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

    fn plan(&mut self) -> Vec<String> {
        let mut lines = match &mut self.subject {
            Subject::Space(space) => space.plan(&self.wishes, &mut self.frame),
            Subject::Nd(nd) => nd.plan(),
            Subject::Replay(replay) => replay.plan(),
        };
        let (took, budget) = (self.drawing_took.as_secs_f64() * 1e3, 1e3 / self.fps);
        lines.push(format!("drawn in {took:.1} ms of the {budget:.1} ms that {} frames/s leave", self.fps));
        lines
    }

    fn zoom_box(&mut self) -> Option<Zoom> {
        let [x, y] = self.pointer.filter(|_| self.inspects)?.map(|v| v.floor());
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
        lines.extend(match &mut self.subject {
            Subject::Space(space) => space.inspect(&self.frame, x, y),
            Subject::Nd(nd) => nd.inspect(&self.frame, x as u32, y as u32),
            Subject::Replay(replay) => replay.inspect(x, y),
        });
        Some(Zoom { side: ZOOM_SIDE, colors, lines, belongs_left: x >= width as i32 / 2 })
    }
}

#[cfg(test)]
mod tests;
