//! Frame k of a scene file: an animation at its time, a mesh on its turntable, an N-dimensional
//! scene turned in planes of its own.
//!
//! In: the bytes of a scene file and the options of its frames. Out: the scene that frame k draws,
//! or its pixels. Promise: a frame depends on the file, the options and k, and on no frame before
//! it; so any machine may draw any part of an animation, and the bytes are those of a single run.

mod file;
mod turn;

pub use file::{LoadedScene, SceneFile, SceneFormat, SceneSource};
pub use turn::{PlaneTurn, TurnError};

use fbptr_core::executor::Executor;
use fbptr_core::eye::{self, ContactSheet, EyeError, EyeScene, Fibre};
use fbptr_core::memory::{MemoryError, Rgba, VideoMemory};
use fbptr_core::pipeline::{PipelineError, Renderer, SceneOptions, Target};
use fbptr_core::scene::{Cull, Scene, ShadeMode, TransparencyOrder};
use std::error::Error;
use std::fmt;
use std::sync::Arc;

/// Options that decide what the frames show.
#[derive(Clone, Debug, PartialEq)]
pub struct FrameOptions {
    /// Number of frames; a scene without an animation makes one turn in them.
    pub count: u32,
    /// Frames a second.
    pub rate: f64,
    /// Time of frame 0, in seconds since the scene's start.
    pub begin_s: f64,
    /// Width and height in pixels; `None` is 640x480, or an N-dimensional screen's own.
    pub size: Option<[u32; 2]>,
    /// Colour behind scenes that have no background.
    pub background: Rgba,
    /// Shading mode; `None` is the default.
    pub shade: Option<ShadeMode>,
    /// Distance to the near plane; `None` is the scene's.
    pub near: Option<f64>,
    /// Distance to the far plane; `None` is the scene's.
    pub far: Option<f64>,
    /// Culling of all objects; `None` is each one's own.
    pub cull: Option<Cull>,
    /// Side of points in pixels; `None` is each object's own.
    pub point_size: Option<u32>,
    /// Planes in which an N-dimensional scene turns over all frames.
    pub turns: Vec<PlaneTurn>,
}

impl Default for FrameOptions {
    fn default() -> Self {
        FrameOptions {
            count: 1,
            rate: 25.0,
            begin_s: 0.0,
            size: None,
            background: VideoMemory::CLEAR,
            shade: None,
            near: None,
            far: None,
            cull: None,
            point_size: None,
            turns: Vec::new(),
        }
    }
}

/// Size of pictures in pixels, where none is given.
pub const DEFAULT_SIZE: [u32; 2] = [640, 480];

/// Reason why a frame was not drawn.
#[derive(Clone, Debug, PartialEq)]
pub enum FrameError {
    /// The near and far planes do not fit the scene's camera.
    Camera(String),
    /// The pipeline refused the scene.
    Pipeline(PipelineError),
    /// The N-dimensional eye refused the scene.
    Eye(EyeError),
    /// The picture does not fit in memory.
    Memory(MemoryError),
}

impl fmt::Display for FrameError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            FrameError::Camera(reason) => write!(f, "camera: {reason}"),
            FrameError::Pipeline(e) => write!(f, "{e}"),
            FrameError::Eye(e) => write!(f, "{e}"),
            FrameError::Memory(e) => write!(f, "{e}"),
        }
    }
}

impl Error for FrameError {
    fn source(&self) -> Option<&(dyn Error + 'static)> {
        match self {
            FrameError::Pipeline(e) => e.source(),
            _ => None,
        }
    }
}

impl From<PipelineError> for FrameError {
    fn from(e: PipelineError) -> Self {
        FrameError::Pipeline(e)
    }
}

impl From<EyeError> for FrameError {
    fn from(e: EyeError) -> Self {
        FrameError::Eye(e)
    }
}

impl From<MemoryError> for FrameError {
    fn from(e: MemoryError) -> Self {
        FrameError::Memory(e)
    }
}

/// A scene file and the options of its frames.
pub struct Animation {
    /// The scene file.
    pub file: SceneFile,
    /// Name of the scene: that of its mesh, for a mesh file.
    pub name: String,
    /// The options.
    pub options: FrameOptions,
}

impl Animation {
    /// Creates the animation of a file.
    ///
    /// # Errors
    /// If a plane does not exist in the scene's space, or the scene is not N-dimensional.
    pub fn new(file: SceneFile, name: String, options: FrameOptions) -> Result<Self, TurnError> {
        let dim = match &file {
            SceneFile::Eye(scene) => Some(scene.dim),
            _ => None,
        };
        options.turns.iter().try_for_each(|turn| turn.check(dim))?;
        Ok(Animation { file, name, options })
    }

    /// Returns the size of the pictures in pixels.
    pub fn size(&self) -> [u32; 2] {
        match (&self.file, self.options.size) {
            (_, Some(size)) => size,
            (SceneFile::Eye(scene), None) => ContactSheet::of(&scene.pixels).picture_size(),
            (_, None) => DEFAULT_SIZE,
        }
    }

    /// Returns whether the frames are one turn of a scene in three dimensions.
    pub fn is_turntable(&self) -> bool {
        let is_solid = !matches!(self.file, SceneFile::Eye(_));
        is_solid && self.options.count > 1 && !self.file.is_animated()
    }

    /// Returns whether all frames are the same picture.
    pub fn is_still(&self) -> bool {
        matches!(self.file, SceneFile::Eye(_)) && self.options.turns.is_empty()
    }

    /// Returns the order of the file's transparent faces; in glTF there is none that counts.
    pub fn transparency(&self) -> TransparencyOrder {
        match self.file {
            SceneFile::Gltf(_) => TransparencyOrder::Sorted,
            _ => TransparencyOrder::default(),
        }
    }

    /// Returns the part of a full turn at which a frame stands: 0 at the first.
    fn part(&self, frame: u32) -> f64 {
        f64::from(frame) / f64::from(self.options.count)
    }

    /// Returns the scene of a frame; the default scene if the file is N-dimensional.
    ///
    /// # Errors
    /// If the requested planes do not fit the camera.
    pub fn scene(&self, frame: u32) -> Result<Scene, FrameError> {
        let [width, height] = self.size();
        let aspect = f64::from(width) / f64::from(height);
        let time = self.options.begin_s + f64::from(frame) / self.options.rate;
        let (mut scene, has_camera) = match &self.file {
            SceneFile::X3d(document) => (document.at_size(time, [width, height]), document.has_viewpoint()),
            SceneFile::Gltf(document) => (document.at(time, aspect), document.has_camera()),
            SceneFile::Mesh { geometry, is_open } => {
                (Scene::of_mesh(Arc::clone(geometry), &self.name, aspect, *is_open), false)
            }
            SceneFile::Eye(_) => return Ok(Scene::default()),
        };
        if let Some(cull) = self.options.cull {
            scene.objects.iter_mut().for_each(|object| object.cull = cull);
        }
        if let Some(size) = self.options.point_size {
            scene.objects.iter_mut().for_each(|object| object.style.point_size = size);
        }
        if self.is_turntable() {
            turn::turn(&mut scene, self.part(frame), (!has_camera).then_some([width, height]));
        }
        if let Some(camera) = &mut scene.camera {
            let [near, far] = camera.projection.near_far_mut();
            *near = self.options.near.unwrap_or(*near);
            *far = self.options.far.unwrap_or(*far);
            camera.matrices(1.0).map_err(|e| FrameError::Camera(e.to_string()))?;
        }
        Ok(scene)
    }

    /// Returns the N-dimensional scene of a frame; `None` if the file is in three dimensions.
    ///
    /// # Errors
    /// If a turned facet is beyond the range of numbers.
    pub fn eye_scene(&self, frame: u32) -> Result<Option<EyeScene>, FrameError> {
        let SceneFile::Eye(scene) = &self.file else { return Ok(None) };
        Ok(Some(turn::turned(scene, &self.options.turns, self.part(frame))?))
    }

    /// Returns the options of the scene's drawing.
    pub fn scene_options(&self) -> SceneOptions {
        let [width, height] = self.size();
        SceneOptions {
            shade: self.options.shade.unwrap_or_default(),
            transparency: self.transparency(),
            ..SceneOptions::new(width, height)
        }
    }

    /// Draws a frame. An N-dimensional one is drawn by the executor, others by the renderer.
    ///
    /// # Errors
    /// If the scene is refused, or there is no memory for the picture.
    pub fn draw(
        &self,
        frame: u32,
        renderer: &mut Renderer,
        executor: &Executor,
    ) -> Result<VideoMemory, FrameError> {
        let [width, height] = self.size();
        let mut memory = VideoMemory::new(width, height)?;
        if let Some(scene) = self.eye_scene(frame)? {
            let picture = eye::render_with(&scene, Fibre::Exact, executor)?;
            eye::blit(&picture, &mut memory, 0, 0, width as i32, height as i32);
            return Ok(memory);
        }
        if self.options.background != VideoMemory::CLEAR {
            memory.clear(self.options.background);
        }
        let mut target =
            Target { memory: &mut memory, depth: &mut None, depth_format: Default::default(), ids: None };
        renderer.draw_scene(&mut target, &self.scene(frame)?, &self.scene_options())?;
        Ok(memory)
    }

    /// Returns a checksum of what the frames depend on: the files, by their checksum, and the
    /// options; the number of frames only where it changes a frame. `more` is further text.
    pub fn recipe(&self, files_crc: u32, more: &str) -> u32 {
        let o = &self.options;
        let has_parts = self.is_turntable() || !o.turns.is_empty();
        let count = if has_parts { o.count } else { 0 };
        let text = format!(
            "{files_crc:08x} {count} {:?} {:?} {:?} {:?} {:?} {:?} {:?} {:?} {:?} {more}",
            o.rate,
            o.begin_s,
            self.size(),
            o.background,
            o.shade,
            o.near,
            o.far,
            o.cull,
            o.turns
        );
        crc32fast::hash(text.as_bytes())
    }
}
