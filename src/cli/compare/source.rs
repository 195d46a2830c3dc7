//! A picture to compare with: a file, or a stream or scene that is drawn, whose geometry is known.

use super::super::mesh_args::MeshArgs;
use super::super::play::{open_stream, size_of_stream};
use super::super::render_args::RenderArgs;
use super::super::scene_file::{self, ReadOptions, SceneError};
use super::geometry::{Figures, of_scene};
use crate::animation::{Animation, FrameOptions, LoadedScene};
use crate::load::SandboxDir;
use crate::measure::difference::{Geometry, Shape, Surface, WrongPixels};
use crate::memory::{DepthFormat, VideoMemory};
use crate::pipeline::SceneOptions;
use crate::pipeline::trace::trace_pixels;
use crate::save;
use crate::scene::Scene;
use crate::server::{Budget, Engine, Limits, Notice, Output, Playback, StreamState};
use std::io::Read;
use std::path::Path;

/// How streams and scenes are drawn.
#[derive(Clone, Copy)]
pub struct Reading<'a> {
    /// Their size; `None` is their own.
    pub size: Option<[u32; 2]>,
    pub time: f64,
    pub load_dir: Option<&'a Path>,
    pub meshes: Option<&'a MeshArgs>,
    pub drawing: &'a RenderArgs,
}

impl Reading<'_> {
    /// Returns the reading in the size of another picture, unless one was asked for.
    pub fn in_size_of(self, other: &Exact) -> Self {
        Reading { size: self.size.or(Some([other.memory.width(), other.memory.height()])), ..self }
    }
}

/// A picture, and what is known of its geometry.
pub struct Exact {
    pub memory: VideoMemory,
    drawn: Option<DrawnFrom>,
}

/// What a picture was drawn from.
enum DrawnFrom {
    Stream(Figures),
    Scene(Box<SceneGeometry>),
}

/// A scene, and its figures on the screen.
struct SceneGeometry {
    scene: Scene,
    options: SceneOptions,
    shapes: Vec<Shape>,
    is_complete: bool,
}

/// Returns whether a file is a picture by its name.
pub fn is_picture(path: &Path) -> bool {
    let ending = path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase());
    matches!(ending.as_deref(), Some("png" | "ppm" | "raw"))
}

impl Exact {
    /// Reads a picture, or draws a stream or scene.
    pub fn read(path: &Path, reading: Reading<'_>) -> Result<Exact, String> {
        if is_picture(path) {
            return Ok(Exact::of_pixels(read_picture(path, reading.size)?));
        }
        match scene_file::is_scene(path).map_err(|e| match e {
            SceneError::NoFile(message) | SceneError::Refused(message) => message,
        })? {
            true => read_scene(path, reading),
            false => read_stream(path, reading),
        }
    }

    /// Makes a picture whose geometry is not known.
    pub fn of_pixels(memory: VideoMemory) -> Exact {
        Exact { memory, drawn: None }
    }

    /// Compares a picture with this one.
    pub fn difference(&self, mine: &VideoMemory, per_channel: u8) -> WrongPixels {
        let none = |_: u64, _: [u32; 2]| None;
        match &self.drawn {
            None => WrongPixels::new(mine, &self.memory, per_channel, None),
            Some(DrawnFrom::Stream(figures)) => {
                let shapes = figures.shapes.clone();
                let geometry = Geometry { shapes, surface: &none, is_complete: figures.is_complete };
                WrongPixels::new(mine, &self.memory, per_channel, Some(&geometry))
            }
            Some(DrawnFrom::Scene(drawn)) => {
                let SceneGeometry { scene, options, shapes, is_complete } = &**drawn;
                let size = [self.memory.width(), self.memory.height()];
                let compared = |surface: &dyn Fn(u64, [u32; 2]) -> Option<Surface>| {
                    let geometry = Geometry { shapes: shapes.clone(), surface, is_complete: *is_complete };
                    WrongPixels::new(mine, &self.memory, per_channel, Some(&geometry))
                };
                trace_pixels(scene, options, size, DepthFormat::default(), |pixel| {
                    compared(&|number, at| {
                        let p = pixel(number, at.map(|v| v as i32))?;
                        Some(Surface { color: p.bytes, opacity: p.opacity, z: p.z })
                    })
                })
                .unwrap_or_else(|_| compared(&none))
            }
        }
    }
}

fn read_picture(path: &Path, size: Option<[u32; 2]>) -> Result<VideoMemory, String> {
    let bytes = save::read_input(path, 4 << 30).map_err(|e| format!("{}: {e}", path.display()))?;
    save::read_picture(path, &bytes, size).map_err(|e| e.to_string())
}

fn read_scene(path: &Path, reading: Reading<'_>) -> Result<Exact, String> {
    let message = |e: SceneError| match e {
        SceneError::NoFile(message) | SceneError::Refused(message) => message,
    };
    let plain = MeshArgs::default();
    let meshes = reading.meshes.unwrap_or(&plain);
    let budget = &reading.drawing.budget();
    let options = ReadOptions { root: None, meshes };
    let LoadedScene { file, held: _held, .. } =
        scene_file::read(path, options, &reading.drawing.reading_budget(budget)).map_err(message)?;
    let mut renderer = reading.drawing.renderer_within(budget);
    let options = FrameOptions {
        begin_s: reading.time,
        size: reading.size,
        cull: meshes.cull,
        point_size: meshes.point_size,
        ..FrameOptions::default()
    };
    let failed = |e: &dyn std::fmt::Display| format!("{}: {e}", path.display());
    let animation = Animation::new(file, String::new(), options).map_err(|e| failed(&e))?;
    let executor = super::super::eye::pool(None);
    let memory = animation.draw(0, &mut renderer, &executor).map_err(|e| failed(&e))?;
    let drawn = match animation.eye_scene(0).map_err(|e| failed(&e))? {
        Some(_) => None,
        None => {
            let (scene, options) = (animation.scene(0).map_err(|e| failed(&e))?, animation.scene_options());
            let (shapes, is_complete) = of_scene(&scene, &options, animation.size());
            Some(DrawnFrom::Scene(Box::new(SceneGeometry { scene, options, shapes, is_complete })))
        }
    };
    Ok(Exact { memory, drawn })
}

fn read_stream(path: &Path, reading: Reading<'_>) -> Result<Exact, String> {
    let name = path.display().to_string();
    let (mut file, _) = open_stream(path, &name)?;
    let mut bytes = Vec::new();
    file.read_to_end(&mut bytes).map_err(|e| format!("{name}: {e}"))?;
    let own = size_of_stream(&bytes).map_err(|e| format!("{name}: {e}"))?;
    let own = own.map(|size| [size.width, size.height]);
    let [width, height] = own.or(reading.size).unwrap_or([640, 480]);
    let limits = Limits { memory_bytes: reading.drawing.memory_bytes(), ..Limits::default() };
    let mut engine =
        Engine::with_limits(width, height, limits.for_frame(width, height)).map_err(|e| e.message)?;
    engine.take_size();
    engine.set_renderer(reading.drawing.renderer());
    if let Some(path) = reading.load_dir {
        engine.set_load_dir(SandboxDir::open(path).map_err(|e| format!("{}: {e}", path.display()))?);
    }
    let (mut playback, mut used, mut out) = (Playback::new(&mut engine, &bytes), 0, Output::default());
    loop {
        let state = match used < bytes.len() {
            true => {
                let (taken, state) = playback.feed(&mut engine, &bytes[used..], &mut out, Budget::NONE);
                used += taken;
                state
            }
            false => playback.finish(&mut engine, &mut out),
        };
        out.replies.clear();
        if state == StreamState::Ended {
            break;
        }
    }
    if let Some(refused) = out.notices.iter().find(|notice| matches!(notice, Notice::Refused(_))) {
        return Err(refused.play_line(&name));
    }
    let figures = Figures::of_stream(&bytes);
    Ok(Exact { memory: engine.into_memory(), drawn: Some(DrawnFrom::Stream(figures)) })
}
