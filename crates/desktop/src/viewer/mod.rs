//! The viewer: interactive views of a file, as a state machine without a window. Keys, pointer and
//! time come in; a picture, an overlay and requests go out, so every key is tested without a
//! screen.
//!
//! In: a [`Model`] (mesh, X3D or glTF document, N-dimensional scene, command stream, the tour),
//! [`Key`]s, the pointer in frame pixels, elapsed time. Out: video memory, an [`Overlay`] that is
//! never drawn into it, and [`Request`]s for a caller that can access files and windows.
//!
//! Promises: the first picture is the one that rendering the file gives; a view in N dimensions is
//! the picture that its JSON gives; only what changed is drawn again. A clock is read only to
//! report the drawing time.

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
mod smoothing;
mod split;
mod status_lines;
mod studio;
mod time;
mod tour;
mod walk;

pub use keys::{Action, BINDINGS, Binding, Key, Look, MOUSE, help_lines};
pub use overlay::{Overlay, Zoom};
pub use replay::MakeEngine;
pub use split::Split;
pub use time::turntable_rate;
pub use tour::{FRAMES_PER_SECOND, MOVIE_FRAMES_PER_SECOND, MakeSizedEngine, SIZE as TOUR_SIZE};

use difference::Exact;
use fbptr_core::executor::Executor;
use fbptr_core::eye::EyeScene;
use fbptr_core::memory::VideoMemory;
use fbptr_core::pipeline::Renderer;
use fbptr_core::scene::{
    Cull, Geometry, HiddenSurface, Navigator, QualityUse, ShadeMode, TextureUse, ViewOverrides,
};
use fbptr_formats::animation::SceneFile;
use fbptr_formats::load::gltf::GltfDocument;
use fbptr_formats::load::x3d::X3dDocument;
use fbptr_server::Notice;
use frame::ViewerFrame;
use nd::Nd;
use replay::Replay;
use scene3d::{SceneSource, Space};
use smoothing::SubframeMean;
use split::SplitScreen;
use std::collections::HashSet;
use std::sync::Arc;
use std::time::Duration;
use time::Rate;
use tour::Tour;
use walk::Walk;

/// The contents to view.
pub enum Model {
    /// A mesh, framed and lit.
    Mesh {
        /// The mesh.
        geometry: Arc<Geometry>,
        /// True if the back faces can be seen: they are drawn and lit from both sides.
        is_open: bool,
    },
    /// An X3D document. Without a viewpoint it is framed automatically.
    X3d(Box<X3dDocument>),
    /// A glTF document. Without a camera it is framed automatically, without lights lit.
    Gltf(Box<GltfDocument>),
    /// A scene of N dimensions.
    Eye(Box<EyeScene>),
    /// A stream of commands, and the factory of the engine (of the frame's size) that it is played
    /// on.
    Stream(Arc<[u8]>, MakeEngine),
    /// The built-in tour, and the factory of the engines that its steps are played on.
    Tour(MakeSizedEngine),
}

impl From<SceneFile> for Model {
    fn from(file: SceneFile) -> Self {
        match file {
            SceneFile::Mesh { geometry, is_open } => Model::Mesh { geometry, is_open },
            SceneFile::X3d(document) => Model::X3d(document),
            SceneFile::Gltf(document) => Model::Gltf(document),
            SceneFile::Eye(scene) => Model::Eye(scene),
        }
    }
}

/// Frame size of models in the studio, in pixels.
pub const STUDIO_SIZE: [u32; 2] = [960, 720];

/// Settings of a new viewer.
pub struct ViewerOptions {
    /// Name of the contents, as shown on the overlay.
    pub name: String,
    /// Size of the frame in pixels; [`Viewer::frame_size`] gives a suitable one.
    pub size: [u32; 2],
    /// Seconds since the scene's start.
    pub time: f64,
    /// Frames per second of animations.
    pub fps: f64,
    /// Face culling that replaces the scene's own, if set.
    pub cull: Option<Cull>,
    /// Side of points in pixels that replaces the scene's own, if set.
    pub point_size: Option<u32>,
    /// Set to show models in the studio: framed, lit, on a ground, and smooth at rest. Otherwise
    /// the first picture is the one that rendering the file gives.
    pub studio: bool,
    /// Set to let the model turn from the start.
    pub turntable: bool,
    /// Two modes to compare on a split screen.
    pub split: Option<Split>,
    /// The renderer of three-dimensional scenes.
    pub renderer: Renderer,
    /// Executor that renders N-dimensional scenes.
    pub pool: Executor,
}

/// A request of the viewer to a caller with access to files and windows.
#[derive(Clone, Debug, PartialEq)]
pub enum Request {
    /// Close the viewer.
    Quit,
    /// Save the shown picture as PNG.
    Snapshot,
    /// Start or stop recording the shown pictures as GIF.
    Record,
    /// Switch between fullscreen and the window.
    Fullscreen,
    /// Switch between scaling the picture to the window and integer factors.
    Scaling,
    /// Switch between the look of a cathode ray tube and the pixels as they are.
    Crt,
    /// Save these bytes in a file with this extension.
    Save {
        /// The file extension, without its dot.
        ending: &'static str,
        /// The contents of the file.
        bytes: Vec<u8>,
    },
    /// Print this text.
    Print(String),
}

/// The picture that is shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Show {
    Picture,
    Depth,
    Difference,
}

/// View settings chosen by the user.
#[derive(Clone, Debug, Default)]
struct Wishes {
    look: Look,
    cull: Option<Cull>,
    point_size: Option<u32>,
    hide: Option<HiddenSurface>,
    navigator: Navigator,
    /// Seconds since the scene's start, an integer number of frames after the first.
    time: f64,
    /// Frames since the scene's start.
    frame: u64,
    /// Set while depth and face ids are needed even if the picture can do without.
    keeps_depth: bool,
    /// True if models stand in the studio.
    studio: bool,
    /// True if the studio's ground is not drawn.
    hides_ground: bool,
    /// Set while only the model is drawn, to be compared with the exact picture.
    is_bare: bool,
    /// Set while the model turns.
    turns: bool,
    /// True if the scene was paused before it began to turn.
    was_paused: bool,
    /// Angle by which the model has turned.
    turned_rad: f64,
    /// True if a polytope is shown as a gallery: wireframe, slice and shadow.
    shows_gallery: bool,
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
            point_size: self.point_size,
            hide: self.hide,
            textures,
            quality: QualityUse::AsGiven,
        }
    }
}

/// State of the contents, by kind of model.
enum Subject {
    Space(Box<Space>),
    Nd(Box<Nd>),
    Replay(Box<Replay>),
    Tour(Box<Tour>),
}

/// An interactive view of a [`Model`]; see the [module](self) documentation.
pub struct Viewer {
    subject: Subject,
    name: String,
    start_time: f64,
    fps: f64,
    renderer: Renderer,
    pool: Executor,
    wishes: Wishes,
    frame: ViewerFrame,
    /// The picture of depth or difference, if one of them is shown.
    other: VideoMemory,
    show: Show,
    exact: Exact,
    smoothing: SubframeMean,
    split: Option<Split>,
    split_screen: Option<SplitScreen>,
    /// The figure that is stepped through.
    walk: Option<Box<Walk>>,
    /// True if its picture was not shown yet.
    has_walked: bool,
    /// True if a polytope is to be shown as a gallery when nothing else of it is asked for.
    wants_gallery: bool,
    /// Frames for which the model has turned.
    turned_frames: i64,
    /// Number of the current picture.
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
    /// Returns the most suitable frame size for a model: 640x480, 960x720 in the studio, or an
    /// integer multiple of an N-dimensional screen near that.
    pub fn frame_size(model: &Model, studio: bool) -> [u32; 2] {
        let usual = if studio { STUDIO_SIZE } else { [640, 480] };
        match model {
            Model::Eye(scene) => Nd::frame_size(scene, usual),
            Model::Tour(_) => TOUR_SIZE,
            Model::Stream(..) => [640, 480],
            _ => usual,
        }
    }

    /// Creates a viewer of `model` and draws the first picture.
    ///
    /// # Errors
    /// Fails if the frame cannot be allocated, or the model cannot be drawn.
    pub fn new(model: Model, options: ViewerOptions) -> Result<Self, String> {
        let ViewerOptions {
            name,
            size,
            time,
            fps,
            cull,
            point_size,
            studio,
            turntable,
            split,
            renderer,
            pool,
        } = options;
        let frame = ViewerFrame::new(size).map_err(|e| e.to_string())?;
        let other = VideoMemory::new(size[0], size[1]).map_err(|e| e.to_string())?;
        let mut subject = Self::subject(model, &name, size, &pool, studio)?;
        if let Subject::Space(space) = &mut subject {
            space.leave_room_to_turn(turntable);
        }
        // On a page of the tour nothing may cover the caption.
        let shows_status = !matches!(subject, Subject::Tour(_));
        // A polytope turns by itself until a key is pressed.
        let turns = turntable || matches!(&subject, Subject::Nd(nd) if nd.has_gallery());
        let frame_number = if time > 0.0 { (time * fps) as u64 } else { 0 };
        let mut viewer = Viewer {
            subject,
            name,
            start_time: time,
            fps,
            renderer,
            pool,
            wishes: Wishes {
                time,
                frame: frame_number,
                cull,
                point_size,
                studio,
                turns,
                ..Wishes::default()
            },
            frame,
            other,
            show: Show::Picture,
            exact: Exact::default(),
            smoothing: SubframeMean::default(),
            split,
            split_screen: None,
            walk: None,
            has_walked: false,
            wants_gallery: true,
            turned_frames: 0,
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
            shows_status,
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

    fn subject(
        model: Model,
        name: &str,
        size: [u32; 2],
        pool: &Executor,
        studio: bool,
    ) -> Result<Subject, String> {
        Ok(match model {
            Model::Mesh { geometry, is_open } => {
                let source = SceneSource::Mesh { geometry, is_open };
                Subject::Space(Box::new(Space::new(source, name, size, studio)))
            }
            Model::X3d(document) => {
                Subject::Space(Box::new(Space::new(SceneSource::X3d(document), name, size, studio)))
            }
            Model::Gltf(document) => {
                Subject::Space(Box::new(Space::new(SceneSource::Gltf(document), name, size, studio)))
            }
            Model::Eye(scene) => Subject::Nd(Box::new(Nd::new(*scene, pool.clone(), studio))),
            Model::Stream(bytes, make_engine) => Subject::Replay(Box::new(Replay::new(bytes, make_engine))),
            Model::Tour(make_engine) => Subject::Tour(Box::new(Tour::new(make_engine)?)),
        })
    }

    /// Shows another model from the same position, with the same settings, as after a change of the
    /// file.
    pub fn reload(&mut self, model: Model) {
        let size = [self.frame.memory.width(), self.frame.memory.height()];
        let mut subject = match Self::subject(model, &self.name, size, &self.pool, self.wishes.studio) {
            Ok(subject) => subject,
            Err(error) => return self.say(error),
        };
        if let (Subject::Nd(old), Subject::Nd(new)) = (&self.subject, &mut subject) {
            new.take_place_of(old);
        }
        if let (Subject::Space(old), Subject::Space(new)) = (&self.subject, &mut subject) {
            new.leave_room_to_turn(old.has_room_to_turn());
        }
        self.subject = subject;
        self.is_stale = true;
        self.say("reloaded".to_owned());
    }

    /// Shows a message on the overlay for a few seconds.
    pub fn say(&mut self, text: String) {
        self.message = Some((text, self.clock));
    }

    /// Sets whether a GIF is being recorded, for the overlay.
    pub fn set_recording(&mut self, is_recording: bool) {
        self.is_recording = is_recording;
    }

    /// Takes the notices about a stream's commands, each once: refusals, warnings and remarks.
    pub fn take_notices(&mut self) -> Vec<Notice> {
        match &mut self.subject {
            Subject::Replay(replay) => replay.take_notices(),
            _ => Vec::new(),
        }
    }
}

#[cfg(test)]
mod tests;
