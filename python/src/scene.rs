//! Frames of a scene file: any frame, in any order, with the bytes that `fbptr render` gives it.
//!
//! In: the bytes of a scene file, those of the files that it refers to (given, or read in its
//! folder), and the options of its frames. Out: pixels, CRCs, files that are whole or absent. The
//! interpreter's lock is released while a frame is drawn; calls of several threads take turns.

use crate::paths::FilePath;
use fbptr::animation::{
    Animation, FrameError, FrameOptions, LoadedScene, SceneFile, SceneFormat, SceneSource,
};
use fbptr::command::parse_color;
use fbptr::executor::Executor;
use fbptr::load::{LoadMemory, SandboxDir, Smoothing};
use fbptr::memory::VideoMemory;
use fbptr::models::{self, BuiltInModel};
use fbptr::pipeline::{RenderOptions, Renderer};
use fbptr::save::{self, SnapshotFormat};
use fbptr::scene::ShadeMode;
use fbptr::server::worker_pool;
use pyo3::exceptions::{PyOSError, PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::{Mutex, MutexGuard};

/// Largest file that a scene may read, in bytes.
const MAX_BYTES: u64 = 4 << 30;
/// The rule by which edges of meshes without normals are smooth, as for `fbptr render`.
const SMOOTHING: Smoothing = Smoothing::Automatic;

/// Files by name; None for those that are missing.
type Files = BTreeMap<String, Option<Vec<u8>>>;

/// Source of the files beside a scene.
enum Beside {
    Given(Files),
    Folder(Option<SandboxDir>),
}

/// An animation, and the renderer that draws it.
struct Drawing {
    animation: Animation,
    renderer: Renderer,
    executor: Executor,
}

/// A scene file and the options of its frames: see `fbptr.Scene`.
#[pyclass(subclass, frozen, module = "fbptr._native")]
pub struct Scene {
    drawing: Mutex<Drawing>,
    size: [u32; 2],
    count: u32,
    recipe: u32,
    warnings: Vec<String>,
    beside: Files,
}

fn value_error(message: impl std::fmt::Display) -> PyErr {
    PyValueError::new_err(message.to_string())
}

/// Returns the exception of a file that was not written; its number is the system's.
pub fn os_error(error: &save::SaveError, path: &std::path::Path) -> PyErr {
    use std::io::ErrorKind;
    let save::SaveError::Io { kind, reason, .. } = error else { return value_error(error) };
    // The numbers of Linux, where no other is known.
    let number = match kind {
        ErrorKind::StorageFull => 28,
        ErrorKind::FileTooLarge => 27,
        ErrorKind::QuotaExceeded => 122,
        ErrorKind::NotFound => 2,
        ErrorKind::PermissionDenied => 13,
        ErrorKind::NotADirectory => 20,
        ErrorKind::IsADirectory => 21,
        ErrorKind::ReadOnlyFilesystem => 30,
        _ => 5,
    };
    PyOSError::new_err((number, reason.clone(), path.display().to_string()))
}

/// Kind of a scene's source.
#[derive(Clone, Copy)]
enum Format {
    File(SceneFormat),
    /// No file: a model of the package.
    BuiltIn(&'static BuiltInModel),
}

/// Returns the format of a word: a file name's ending, or `model` for the built-in model `name`.
fn format_of(word: &str, name: &str) -> PyResult<Format> {
    if word == "model" {
        let unknown =
            || value_error(format!("there is no built-in model {name:?}; fbptr.models() lists them"));
        return models::named(name).map(Format::BuiltIn).ok_or_else(unknown);
    }
    let known = "x3d, x3dz, x3dv, x3dvz, wrl, wrz, gltf, glb, obj, stl, ply or json";
    let unknown = || value_error(format!("expected the format {known}, found {word:?}"));
    SceneFormat::of_ending(word).map(Format::File).ok_or_else(unknown)
}

/// Names of the built-in models.
#[pyfunction]
pub fn model_names() -> Vec<&'static str> {
    models::all().iter().map(|model| model.name).collect()
}

/// The bytes of the OBJ file of Blender's monkey.
#[pyfunction]
pub fn suzanne() -> &'static [u8] {
    models::SUZANNE
}

/// Reads a scene. Returns it with every file that it asked for.
fn read(
    bytes: &[u8],
    format: Format,
    name: &str,
    mut beside: Beside,
) -> Result<(LoadedScene, Files), String> {
    let format = match format {
        Format::File(format) => format,
        Format::BuiltIn(model) => {
            return Ok((model.load(SMOOTHING, LoadMemory::unlimited())?, Files::new()));
        }
    };
    let (mut asked, mut other_cases) = (BTreeMap::new(), Vec::new());
    let mut opener = |name: &str| {
        let found = match &mut beside {
            Beside::Given(files) => files.get(name).cloned().flatten(),
            Beside::Folder(folder) => folder.as_ref().and_then(|folder| {
                let read = |name: &str| folder.read(name, MAX_BYTES).ok();
                read(name).or_else(|| {
                    let other = folder.other_case(name)?;
                    let bytes = read(&other)?;
                    other_cases.push(format!("there is no {name:?}: {other:?} is read"));
                    Some(bytes)
                })
            }),
        };
        asked.insert(name.to_owned(), found.clone());
        found
    };
    let smoothing = SMOOTHING;
    let memory = LoadMemory::unlimited();
    let source = SceneSource { bytes, format, name, folder: "", opener: &mut opener, smoothing, memory };
    let mut loaded = SceneFile::read(source)?;
    loaded.warnings.append(&mut other_cases);
    Ok((loaded, asked))
}

impl Scene {
    fn lock(&self) -> PyResult<MutexGuard<'_, Drawing>> {
        let broken = |_| PyRuntimeError::new_err("an earlier call met a defect of the engine");
        self.drawing.lock().map_err(broken)
    }

    /// Draws a frame, with the interpreter's lock released.
    fn draw(&self, py: Python<'_>, frame: u32) -> PyResult<VideoMemory> {
        if frame >= self.count {
            let last = self.count - 1;
            return Err(value_error(format!("expected a frame from 0 to {last}, found {frame}")));
        }
        py.detach(|| {
            let mut drawing = self.lock()?;
            let Drawing { animation, renderer, executor } = &mut *drawing;
            let drawn: Result<VideoMemory, FrameError> = animation.draw(frame, renderer, executor);
            drawn.map_err(|e| value_error(format!("frame {frame}: {e}")))
        })
    }
}

#[pymethods]
impl Scene {
    #[new]
    #[pyo3(signature = (
        data, format, name, *, folder=None, files=None, frames=1, fps=25.0, time=0.0, size=None,
        background=None, shade=None, near=None, far=None, turns=Vec::new(), threads=1
    ))]
    #[allow(clippy::too_many_arguments)]
    fn new(
        py: Python<'_>,
        data: Vec<u8>,
        format: &str,
        name: &str,
        folder: Option<FilePath>,
        files: Option<Files>,
        frames: u32,
        fps: f64,
        time: f64,
        size: Option<[u32; 2]>,
        background: Option<&str>,
        shade: Option<&str>,
        near: Option<f64>,
        far: Option<f64>,
        turns: Vec<String>,
        threads: usize,
    ) -> PyResult<Self> {
        let format = format_of(format, name)?;
        if frames == 0 || !(fps.is_finite() && fps > 0.0 && time.is_finite()) {
            let expected = "expected one frame or more, frames a second above 0 and a finite time";
            return Err(value_error(format!("{expected}, found {frames}, {fps} and {time}")));
        }
        if let Some(plane) = near.into_iter().chain(far).find(|plane| !(plane.is_finite() && *plane > 0.0)) {
            return Err(value_error(format!("expected planes at finite distances above 0, found {plane}")));
        }
        if let (Some(near), Some(far)) = (near, far)
            && near >= far
        {
            return Err(value_error(format!("expected near less than far, found {near} and {far}")));
        }
        let shade = match shade {
            None => None,
            Some(word) => Some(ShadeMode::from_keyword(word).ok_or_else(|| {
                value_error(format!("expected wire, flat, gouraud or phong, found {word:?}"))
            })?),
        };
        let background = match background {
            None => VideoMemory::CLEAR,
            Some(text) => parse_color(text.as_bytes())
                .ok_or_else(|| value_error(format!("expected a colour, found {text:?}")))?,
        };
        let turns = turns.iter().map(|text| text.parse()).collect::<Result<Vec<_>, _>>();
        let options = FrameOptions {
            count: frames,
            rate: fps,
            begin_s: time,
            size,
            background,
            shade,
            near,
            far,
            turns: turns.map_err(value_error)?,
            ..FrameOptions::default()
        };
        let beside = match (files, folder) {
            (Some(files), _) => Beside::Given(files),
            (None, folder) => Beside::Folder(folder.and_then(|folder| SandboxDir::open(&folder).ok())),
        };
        let (loaded, beside) = py.detach(|| read(&data, format, name, beside)).map_err(value_error)?;
        let LoadedScene { file, warnings, crc, .. } = loaded;
        let stem = std::path::Path::new(name).file_stem().map(|n| n.to_string_lossy().into_owned());
        let animation = Animation::new(file, stem.unwrap_or_default(), options).map_err(value_error)?;
        // The text of the arguments that `fbptr render` has beside these, at their defaults.
        let more = format!("{:?} {:?}", SMOOTHING, None::<f64>);
        let (size, recipe) = (animation.size(), animation.recipe(crc, &more));
        VideoMemory::new(size[0], size[1]).map_err(value_error)?;
        let pool = worker_pool((threads != 0).then_some(threads)).filter(|_| threads != 1);
        let renderer = Renderer::new(RenderOptions { pool: pool.clone(), ..RenderOptions::default() });
        let drawing = Mutex::new(Drawing { animation, renderer, executor: Executor::of_pool(pool) });
        Ok(Scene { drawing, size, count: frames, recipe, warnings, beside })
    }

    /// Width and height of the frames in pixels.
    #[getter]
    fn size(&self) -> (u32, u32) {
        (self.size[0], self.size[1])
    }

    /// Number of frames.
    #[getter]
    fn frames(&self) -> u32 {
        self.count
    }

    /// Checksum of the scene's files and of the options that change a frame.
    #[getter]
    fn recipe(&self) -> u32 {
        self.recipe
    }

    /// Messages about skipped parts of the file.
    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.warnings.clone()
    }

    /// Files that the scene asked for: bytes by name, None for those that are missing.
    #[getter]
    fn files<'py>(&self, py: Python<'py>) -> BTreeMap<String, Option<Bound<'py, PyBytes>>> {
        let bytes = |found: &Option<Vec<u8>>| found.as_ref().map(|bytes| PyBytes::new(py, bytes));
        self.beside.iter().map(|(name, found)| (name.clone(), bytes(found))).collect()
    }

    /// Returns the R, G, B, A bytes of a frame, row by row from the top.
    fn pixels<'py>(&self, py: Python<'py>, frame: u32) -> PyResult<Bound<'py, PyBytes>> {
        Ok(PyBytes::new(py, self.draw(py, frame)?.bytes()))
    }

    /// Returns the CRC-32 of a frame's R, G, B, A bytes.
    fn crc(&self, py: Python<'_>, frame: u32) -> PyResult<u32> {
        Ok(save::crc32(&self.draw(py, frame)?))
    }

    /// Returns a frame's CRC-32 and its bytes as a file of the ending: png, ppm or raw.
    fn encoded<'py>(
        &self,
        py: Python<'py>,
        frame: u32,
        ending: &str,
    ) -> PyResult<(u32, Bound<'py, PyBytes>)> {
        let format = SnapshotFormat::of_path(&PathBuf::from(format!("a.{ending}"))).map_err(value_error)?;
        let memory = self.draw(py, frame)?;
        let mut bytes = Vec::new();
        py.detach(|| format.write(&memory, &mut bytes)).map_err(value_error)?;
        Ok((save::crc32(&memory), PyBytes::new(py, &bytes)))
    }

    /// Writes a frame to a file, whole or not at all. Returns the CRC-32 of its pixels, the file's
    /// length in bytes and the CRC-32 of the file's bytes.
    fn write(&self, py: Python<'_>, frame: u32, path: FilePath) -> PyResult<(u32, u64, u32)> {
        let format = SnapshotFormat::of_path(&path).map_err(value_error)?;
        let memory = self.draw(py, frame)?;
        py.detach(|| {
            let mut bytes = Vec::new();
            format.write(&memory, &mut bytes).map_err(value_error)?;
            save::atomically(&path, |out| out.write_all(&bytes)).map_err(|e| os_error(&e, &path))?;
            Ok((save::crc32(&memory), bytes.len() as u64, crc32fast::hash(&bytes)))
        })
    }
}

/// Writes bytes to a file, whole or not at all.
#[pyfunction]
pub fn write_file(py: Python<'_>, path: FilePath, data: Vec<u8>) -> PyResult<()> {
    py.detach(|| save::atomically(&path, |out| out.write_all(&data)).map_err(|e| os_error(&e, &path)))
}

/// Removes the unfinished files that killed processes left in a folder, and none of a living one.
#[pyfunction]
pub fn remove_leftovers(py: Python<'_>, folder: FilePath) {
    py.detach(|| save::remove_leftovers_in(&folder));
}
