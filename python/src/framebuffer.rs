//! The class that `fbptr.Framebuffer` extends: commands, text streams, memory, questions, files.
//!
//! In: calls from Python. Out: changed memory, values, exceptions. Locks: see [`crate::access`].

use crate::access::{Length, Shared, State};
use crate::arguments;
use crate::batches::Batch;
use crate::errors::{self, Refused};
use crate::offsets::{self, Place};
use crate::paths::FilePath;
use crate::scene::os_error;
use crate::slots::{Form, forms};
use crate::view;
use fbptr::command::{EndOfInput, Payload, Reach};
use fbptr::error::{Code, Fault};
use fbptr::load::SandboxDir;
use fbptr::memory::FbPtr;
use fbptr::pipeline::RenderOptions;
use fbptr::pipeline::trace::Probe;
use fbptr::save::{self, golden};
use fbptr::scene::{Cull, HiddenSurface, Interpolation, Material, Sampling, ShadeMode};
use fbptr::server::{Audience, Budget, Engine, Limits, Output, Stream, worker_pool};
use fbptr::{Renderer, VideoMemory};
use pyo3::exceptions::{PyAssertionError, PyIndexError, PyOSError};
use pyo3::ffi;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict, PyTuple};
use std::ffi::c_int;

/// Most 3-D draws that `trace` and `explain` look back on.
const LOGGED_DRAWS: usize = 256;

/// States of 3-D draws that a program can set for one draw.
pub struct SavedStates {
    shade: ShadeMode,
    cull: Cull,
    hide: HiddenSurface,
    interp: Interpolation,
    texture: Option<(String, Sampling)>,
    material: Material,
    quality: fbptr::command::Quality,
    model: fbptr::glam::DMat4,
}

/// A framebuffer with the engine: see `fbptr.Framebuffer`.
#[pyclass(subclass, frozen, module = "fbptr._native")]
pub struct Framebuffer {
    shared: Shared,
    /// Width and height in pixels.
    size: [u32; 2],
}

/// Replies of a call and the notices beside them, and whether the call was a text.
type Ran = (Output, bool);

impl Framebuffer {
    /// Calls a function with the memory.
    pub fn look<T: Send>(
        &self,
        py: Python<'_>,
        mut look: impl FnMut(&VideoMemory) -> T + Send,
    ) -> PyResult<T> {
        self.shared.with(py, Length::Long, |state| look(state.engine.memory()))
    }

    /// Returns the bytes of the memory.
    fn bytes(&self) -> usize {
        self.size[0] as usize * self.size[1] as usize * 4
    }
}

/// Returns how long a command of the form may take.
fn length_of(form: &Form) -> Length {
    let is_pixel = matches!(form.verb.name, "PX" | "PB" | "PEEK" | "POKE" | "DEPTHAT" | "PICK");
    let makes = matches!(form.verb.name, "CANVAS" | "MESH" | "LOAD" | "SNAP" | "FREE" | "DEPTH");
    let is_setting = form.verb.reach == Reach::Connection && form.verb.payload == Payload::Never && !makes;
    if is_pixel || is_setting { Length::Short } else { Length::Long }
}

/// Returns the reply of a call as bytes, or raises what was refused.
fn answer<'py>(py: Python<'py>, (out, is_text): Ran) -> PyResult<Option<Bound<'py, PyBytes>>> {
    if !out.notices.is_empty() {
        let refused: Vec<Refused> = errors::of_notices(py, &out.notices, is_text)?;
        if !refused.is_empty() {
            return Err(errors::refused(py, refused, &out.replies));
        }
    }
    Ok((!out.replies.is_empty()).then(|| PyBytes::new(py, &out.replies)))
}

/// Runs a text on the session of the state's stream, as a stream of its own: its lines are counted
/// from 1.
fn run_text(state: &mut State, text: &[u8]) -> Output {
    let mut out = Output::default();
    let mut stream = Stream::new(&state.engine, 1, Audience::Owner);
    std::mem::swap(stream.session_mut(), state.stream.session_mut());
    let mut rest = text;
    loop {
        let (used, progress) = stream.feed(&mut state.engine, rest, &mut out, Budget::NONE);
        rest = &rest[used..];
        let has_ended = matches!(progress, fbptr::server::StreamState::Ended);
        if has_ended || rest.is_empty() || used == 0 {
            break;
        }
    }
    let _ = stream.finish(&mut state.engine, EndOfInput::File, &mut out);
    std::mem::swap(stream.session_mut(), state.stream.session_mut());
    out
}

fn renderer(threads: usize) -> Renderer {
    let pool = worker_pool((threads != 0).then_some(threads));
    Renderer::new(RenderOptions { pool, ..RenderOptions::default() })
}

#[pymethods]
impl Framebuffer {
    #[new]
    #[pyo3(signature = (width=640, height=480, *, files=None, threads=1))]
    fn new(
        py: Python<'_>,
        width: u32,
        height: u32,
        files: Option<FilePath>,
        threads: usize,
    ) -> PyResult<Self> {
        let limits = Limits {
            payload_bytes: isize::MAX as u64,
            resource_bytes: u64::MAX,
            frame_bytes: u64::MAX,
            reply_bytes: usize::MAX,
            snap_bytes: u64::MAX,
            ..Limits::default()
        };
        let fault = |fault: Fault| errors::of_fault(py, 0, "SIZE", &fault);
        let mut engine = Engine::with_limits(width, height, limits).map_err(fault)?;
        if threads != 1 {
            engine.set_renderer(renderer(threads));
        }
        engine.log_draws(LOGGED_DRAWS);
        if let Some(path) = files {
            let open = || {
                SandboxDir::open(&path).map_err(|e| PyOSError::new_err(format!("{}: {e}", path.display())))
            };
            engine.set_load_dir(open()?);
            engine.set_snap_dir(open()?);
        }
        Ok(Framebuffer { shared: Shared::new(engine), size: [width, height] })
    }

    /// The width in pixels.
    #[getter]
    fn width(&self) -> u32 {
        self.size[0]
    }

    /// The height in pixels.
    #[getter]
    fn height(&self) -> u32 {
        self.size[1]
    }

    /// Runs the verb with this index in the table; returns its reply.
    #[pyo3(signature = (index, args, kwargs=None))]
    fn _verb<'py>(
        &self,
        py: Python<'py>,
        index: usize,
        args: &Bound<'py, PyTuple>,
        kwargs: Option<&Bound<'py, PyDict>>,
    ) -> PyResult<Option<Bound<'py, PyBytes>>> {
        let form = forms().get(index).ok_or_else(|| PyIndexError::new_err("no such verb"))?;
        let words = arguments::words(py, form, args, kwargs)?;
        if let Some((rect, rgba)) = words.shared_picture(form) {
            let ran = self.shared.with(py, length_of(form), |state| {
                let mut out = Output::default();
                let _ = state.stream.blit(&mut state.engine, rect, rgba, &mut out, Budget::NONE);
                (out, false)
            })?;
            return answer(py, ran);
        }
        let mut command = Some(arguments::command(py, form, words)?);
        let ran = self.shared.with(py, length_of(form), |state| {
            let mut out = Output::default();
            if let Some(command) = command.take() {
                let _ = state.stream.run(&mut state.engine, command, &mut out, Budget::NONE);
            }
            (out, false)
        })?;
        answer(py, ran)
    }

    /// Draws many figures of one kind: rows of numbers, and one colour of four bytes or one a row.
    fn _batch(
        &self,
        py: Python<'_>,
        kind: &str,
        numbers: &Bound<'_, PyAny>,
        colors: &Bound<'_, PyAny>,
    ) -> PyResult<()> {
        let batch = Batch::new(kind, numbers, colors)?;
        let ran = self.shared.with(py, Length::Long, |state| {
            let mut out = Output::default();
            for command in batch.commands() {
                let _ = state.stream.run(&mut state.engine, command, &mut out, Budget::NONE);
            }
            (out, false)
        })?;
        answer(py, ran).map(|_| ())
    }

    /// Runs a text of commands; returns the replies.
    fn _run<'py>(&self, py: Python<'py>, text: &[u8]) -> PyResult<Bound<'py, PyBytes>> {
        let out = self.shared.with(py, Length::Long, |state| run_text(state, text))?;
        Ok(answer(py, (out, true))?.unwrap_or_else(|| PyBytes::new(py, b"")))
    }

    fn __len__(&self) -> usize {
        self.bytes()
    }

    fn __bool__(&self) -> bool {
        true
    }

    fn __getitem__<'py>(&self, py: Python<'py>, at: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
        let place = offsets::place(at, self.bytes())?;
        let data: Vec<u8> = self.shared.with(py, Length::Short, |state| {
            let memory = state.engine.memory().bytes();
            match place {
                Place::Slice { start, step: 1, count } => memory[start as usize..][..count].to_vec(),
                place => place.offsets().map(|at| memory[at]).collect(),
            }
        })?;
        Ok(match place {
            Place::Byte(_) => data[0].into_pyobject(py)?.into_any(),
            Place::Slice { .. } => PyBytes::new(py, &data).into_any(),
        })
    }

    fn __setitem__(&self, py: Python<'_>, at: &Bound<'_, PyAny>, value: &Bound<'_, PyAny>) -> PyResult<()> {
        let place = offsets::place(at, self.bytes())?;
        let data = place.data(value)?;
        self.shared.with(py, Length::Short, |state| {
            let memory = state.engine.memory_mut();
            for (at, byte) in place.offsets().zip(&data) {
                memory.poke(FbPtr::new(at as u64), &[*byte]).expect("the place was checked");
            }
        })
    }

    /// Fills a view of the memory.
    ///
    /// # Safety
    /// Called by the interpreter, with a place for a view.
    unsafe fn __getbuffer__(slf: Bound<'_, Self>, view: *mut ffi::Py_buffer, flags: c_int) -> PyResult<()> {
        let owner = slf.clone().into_any();
        // SAFETY: the interpreter gives a place for a view.
        unsafe { view::fill(&owner, &slf.get().shared, view, flags) }
    }

    /// Ends a view of the memory.
    ///
    /// # Safety
    /// Called by the interpreter, once for each view that was filled.
    unsafe fn __releasebuffer__(&self, view: *mut ffi::Py_buffer) {
        // SAFETY: the interpreter releases each view once.
        unsafe { view::release(&self.shared, view) }
    }

    /// The frame as a PNG file.
    fn png<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let file = self.shared.with(py, Length::Long, |state| {
            let mut file = Vec::new();
            save::png(state.engine.memory(), &mut file).map(|()| file)
        })?;
        file.map(|file| PyBytes::new(py, &file)).map_err(|e| PyOSError::new_err(e.to_string()))
    }

    /// Writes the frame to a file: .png, .ppm or .raw; or its depth: .pfm.
    fn save(&self, py: Python<'_>, path: FilePath) -> PyResult<()> {
        let is_depth = path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("pfm"));
        let saved = self.shared.with(py, Length::Long, |state| match (is_depth, state.engine.depth()) {
            (false, _) => save::to_path(state.engine.memory(), &path),
            (true, Some(depth)) => save::depth_to_path(depth, &path),
            (true, None) => {
                let [width, height] = self.size;
                let far = fbptr::memory::DepthMemory::new(width, height, fbptr::memory::DepthFormat::F32);
                save::depth_to_path(&far, &path)
            }
        })?;
        saved.map_err(|e| match e.code() {
            Code::Args | Code::Format => {
                errors::of_fault(py, 0, "save", &Fault::new(e.code(), e.to_string()))
            }
            _ => os_error(&e, &path),
        })
    }

    /// The depths of all pixels as f64 in the machine's order, row by row.
    fn _depths<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let [width, height] = self.size.map(|side| side as i32);
        let depths = self.shared.with(py, Length::Long, |state| {
            let depth = state.engine.depth();
            let z = |x, y| depth.and_then(|depth| depth.z(x, y)).unwrap_or(1.0);
            let mut bytes = Vec::with_capacity(self.bytes() * 2);
            (0..height).for_each(|y| (0..width).for_each(|x| bytes.extend(f64::to_ne_bytes(z(x, y)))));
            bytes
        })?;
        Ok(PyBytes::new(py, &depths))
    }

    /// The numbers of the surface seen at a pixel, of a triangle, or of a triangle at a pixel.
    #[pyo3(signature = (pixel, triangle))]
    fn _trace(
        &self,
        py: Python<'_>,
        pixel: Option<(i32, i32)>,
        triangle: Option<u64>,
    ) -> PyResult<Option<String>> {
        let probe = match (pixel, triangle) {
            (Some((x, y)), None) => Probe::Pixel(x, y),
            (Some((x, y)), Some(n)) => Probe::TriangleAt(n, x, y),
            (None, n) => Probe::Triangle(n.unwrap_or(0)),
        };
        self.shared.with(py, Length::Long, |state| state.engine.trace_logged(probe))
    }

    /// The plans of the 3-D draws since the last clear.
    fn explain(&self, py: Python<'_>) -> PyResult<String> {
        self.shared.with(py, Length::Long, |state| state.engine.explain_logged())
    }

    /// Compares the frame with a golden picture; the difference may have this size.
    fn _golden(&self, py: Python<'_>, path: FilePath, per_channel: u8, pixels: u64) -> PyResult<()> {
        let checked = self.shared.with(py, Length::Long, |state| {
            let tolerance = golden::Tolerance { per_channel, pixels };
            golden::check(state.engine.memory(), &*path, tolerance, golden::Mode::from_env())
        })?;
        checked.map_err(|e| PyAssertionError::new_err(e.to_string()))
    }

    /// Remembers the states that one draw may replace.
    fn _push_states(&self, py: Python<'_>) -> PyResult<()> {
        self.shared.with(py, Length::Short, |state| {
            let s = state.stream.session();
            let saved = SavedStates {
                shade: s.shade,
                cull: s.cull,
                hide: s.hide,
                interp: s.interp,
                texture: s.texture.clone(),
                material: s.material.clone(),
                quality: s.quality,
                model: s.model,
            };
            state.saved.push(saved);
        })
    }

    /// Sets back the states that were remembered last.
    fn _pop_states(&self, py: Python<'_>) -> PyResult<()> {
        self.shared.with(py, Length::Short, |state| {
            let Some(saved) = state.saved.pop() else { return };
            let s = state.stream.session_mut();
            let SavedStates { shade, cull, hide, interp, texture, material, quality, model } = saved;
            (s.shade, s.cull, s.hide, s.interp) = (shade, cull, hide, interp);
            (s.texture, s.material, s.quality, s.model) = (texture, material, quality, model);
        })
    }

    /// The lowest index without a light.
    fn _free_light(&self, py: Python<'_>) -> PyResult<usize> {
        self.shared.with(py, Length::Short, |state| {
            let lights = &state.stream.session().lights;
            lights.iter().position(Option::is_none).unwrap_or(lights.len())
        })
    }

    /// The width and height of the canvas that is the target, if one is.
    fn _canvas_size(&self, py: Python<'_>) -> PyResult<Option<(u32, u32)>> {
        self.shared
            .with(py, Length::Short, |state| state.stream.session().canvas_size().map(<(u32, u32)>::from))
    }

    /// The number of lights' places.
    fn _light_count(&self, py: Python<'_>) -> PyResult<usize> {
        self.shared.with(py, Length::Short, |state| state.stream.session().lights.len())
    }

    /// Runs LOAD with this folder in place of the framebuffer's own.
    fn _load(&self, py: Python<'_>, folder: FilePath, line: &str) -> PyResult<()> {
        let opened = SandboxDir::open(&folder);
        let opened = opened.map_err(|e| PyOSError::new_err(format!("{}: {e}", folder.display())))?;
        let command = fbptr::command::Command::parse(line.as_bytes(), None);
        let command = command.map_err(|e| errors::of_fault(py, 0, "LOAD", &(&e).into()))?;
        let mut given = Some((command, opened));
        let ran = self.shared.with(py, Length::Long, |state| {
            let mut out = Output::default();
            if let Some((command, folder)) = given.take() {
                let own = state.engine.replace_load_dir(Some(folder));
                let _ = state.stream.run(&mut state.engine, command, &mut out, Budget::NONE);
                state.engine.replace_load_dir(own);
            }
            (out, false)
        })?;
        answer(py, ran).map(drop)
    }
}
