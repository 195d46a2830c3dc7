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
mod input;
mod keys;
mod nd;
mod overlay;
mod refresh;
mod replay;
mod scene3d;
mod status_lines;
mod time;

pub use keys::{Action, BINDINGS, Binding, Key, Look, MOUSE, help_lines};
pub use overlay::{Overlay, Zoom};
pub use replay::MakeEngine;

use crate::eye::{Executor, EyeScene};
use crate::load::x3d::X3dDocument;
use crate::memory::VideoMemory;
use crate::pipeline::Renderer;
use crate::scene::{
    Cull, Geometry, HiddenSurface, Navigator, QualityUse, ShadeMode, TextureUse, ViewOverrides,
};
use difference::Exact;
use frame::ViewerFrame;
use nd::Nd;
use replay::Replay;
use scene3d::{SceneSource, Space};
use std::collections::HashSet;
use std::sync::Arc;
use std::time::Duration;
use time::Rate;

/// What is looked at.
pub enum Model {
    /// A mesh, framed and lit.
    Mesh {
        /// The mesh.
        geometry: Arc<Geometry>,
        /// Whether its back can be seen: it is drawn then, and lit from both sides.
        is_open: bool,
    },
    /// An X3D document; one without a viewpoint is framed.
    X3d(Box<X3dDocument>),
    /// A scene of N dimensions.
    Eye(Box<EyeScene>),
    /// A stream of commands, and what makes the engine that it is played on (of the frame's size).
    Stream(Arc<[u8]>, MakeEngine),
}

/// How a viewer begins.
pub struct ViewerOptions {
    /// What is looked at, as the overlay calls it.
    pub name: String,
    /// The frame's size in pixels; [`Viewer::frame_size`] knows what fits.
    pub size: [u32; 2],
    /// Seconds since the scene's start.
    pub time: f64,
    /// Frames a second.
    pub fps: f64,
    /// Faces that are left out in place of those that the scene leaves out.
    pub cull: Option<Cull>,
    /// What draws.
    pub renderer: Renderer,
    /// Whose threads share the work of N dimensions.
    pub pool: Arc<dyn Executor + Send + Sync>,
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
    /// Fill the screen with the window, or go back.
    Fullscreen,
    /// Enlarge the picture to the window, or by whole factors.
    Scaling,
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
    fn view_overrides(&self) -> ViewOverrides {
        let (shade, textures) = match self.look {
            Look::AsGiven => (None, TextureUse::AsGiven),
            Look::Wire => (Some(ShadeMode::Wire), TextureUse::AsGiven),
            Look::Flat => (Some(ShadeMode::Flat), TextureUse::Off),
            Look::Gouraud => (Some(ShadeMode::Gouraud), TextureUse::Off),
            Look::Phong => (Some(ShadeMode::Phong), TextureUse::Off),
            Look::Textured => (Some(ShadeMode::Phong), TextureUse::AsGiven),
        };
        ViewOverrides {
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
    pool: Arc<dyn Executor + Send + Sync>,
    wishes: Wishes,
    frame: ViewerFrame,
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
    pub fn new(model: Model, options: ViewerOptions) -> Result<Self, String> {
        let ViewerOptions { name, size, time, fps, cull, renderer, pool } = options;
        let frame = ViewerFrame::new(size).map_err(|e| e.to_string())?;
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
            wishes: Wishes { time, frame: frame_number, cull, ..Wishes::default() },
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

    fn subject(model: Model, name: &str, size: [u32; 2], pool: &Arc<dyn Executor + Send + Sync>) -> Subject {
        let aspect = f64::from(size[0]) / f64::from(size[1]);
        match model {
            Model::Mesh { geometry, is_open } => {
                Subject::Space(Box::new(Space::new(SceneSource::Mesh { geometry, is_open }, name, aspect)))
            }
            Model::X3d(document) => {
                Subject::Space(Box::new(Space::new(SceneSource::X3d(document), name, aspect)))
            }
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
    pub fn take_errors(&mut self, file: &str) -> Vec<String> {
        match &mut self.subject {
            Subject::Replay(replay) => replay.take_errors().iter().map(|c| c.play_line(file)).collect(),
            _ => Vec::new(),
        }
    }
}

#[cfg(test)]
mod tests;
