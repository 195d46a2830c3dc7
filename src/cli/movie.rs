//! `--movie`: records the frames that `play` and `serve` show.
//!
//! There are two sources of frames. PRESENT: each one is a frame, none is lost, so the same stream
//! gives the same movie. The clock: the picture every 1/rate seconds, as a viewer of the screen
//! would see it. Each frame is in the file before the next is taken, so the recording of a killed
//! program is readable.

use super::args::crt::CrtArgs;
use crate::draw2d::crt::Crt;
use crate::memory::{MemoryError, VideoMemory};
use crate::save::{self, Movie, MovieFormat, SaveError};
use crate::server::{Display, ShownFrame};
use clap::Args;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// Longest sleep of the sampler, which limits how long it takes to end.
const LONGEST_SLEEP: Duration = Duration::from_millis(50);

/// The arguments of recording.
#[derive(Clone, Debug, Args)]
pub(super) struct MovieArgs {
    /// Record what is shown: .gif, .apng, .y4m, .png (numbered), or - for y4m on standard output
    #[arg(long, value_name = "OUT")]
    movie: Option<PathBuf>,
    /// Frames a second of the movie
    #[arg(long, value_name = "F", value_parser = super::render::positive, default_value = "25", requires = "movie")]
    movie_fps: f64,
}

impl MovieArgs {
    /// Returns whether a movie is to be written.
    pub fn is_wanted(&self) -> bool {
        self.movie.is_some()
    }

    /// Returns whether the movie is written to standard output.
    pub fn takes_stdout(&self) -> bool {
        self.movie.as_deref() == Some(Path::new("-"))
    }

    /// Validates the file name and its folder before anything is done.
    pub fn check(&self) -> Result<(), String> {
        let Some(path) = &self.movie else { return Ok(()) };
        MovieFormat::of_path(path).map_err(|e| e.to_string())?;
        super::check_folder(path)
    }

    /// Creates the requested movie, if any, with the CRT look where files have it.
    pub fn open(&self, width: u32, height: u32, crt: CrtArgs) -> Result<Option<MovieWriter>, String> {
        let Some(path) = &self.movie else { return Ok(None) };
        let [width, height] = crt.size_in_files([width, height]);
        let movie = Movie::create(path, width, height, self.movie_fps).map_err(|e| e.to_string())?;
        let state = MovieState { movie, crt, failure: None, presents: 0, last_crc: None };
        Ok(Some(MovieWriter { state: Arc::new(Mutex::new(state)), rate: self.movie_fps }))
    }
}

/// A movie that receives frames from several threads.
#[derive(Clone, Debug)]
pub(super) struct MovieWriter {
    state: Arc<Mutex<MovieState>>,
    rate: f64,
}

/// State of a movie, shared by its sources of frames.
#[derive(Debug)]
struct MovieState {
    movie: Movie,
    crt: CrtArgs,
    failure: Option<SaveError>,
    presents: u64,
    /// Checksum of the last frame's bytes.
    last_crc: Option<u32>,
}

impl MovieState {
    /// Appends a frame, unless an earlier one failed.
    fn push(&mut self, memory: &VideoMemory) {
        if self.failure.is_none() {
            self.last_crc = Some(save::crc32(memory));
            self.failure = self.append(memory).err();
        }
    }

    fn append(&mut self, memory: &VideoMemory) -> Result<(), SaveError> {
        if !self.crt.in_files() {
            return self.movie.push(memory);
        }
        let no_room = |e: MemoryError| SaveError::Io {
            path: self.movie.path().to_owned(),
            kind: std::io::ErrorKind::OutOfMemory,
            reason: e.to_string(),
        };
        let picture = Crt::picture(memory).map_err(no_room)?;
        self.movie.push(&picture)
    }
}

/// Time until which the clock takes frames.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Clock {
    /// Until the end.
    Always,
    /// Until the first PRESENT; from then on, PRESENTs are the frames.
    UntilPresent,
}

impl MovieWriter {
    fn lock(&self) -> MutexGuard<'_, MovieState> {
        // An unfinished frame is not in the file, so the state is valid even after a panic.
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Returns the function to call at each PRESENT, which records the frame.
    pub fn on_present(&self) -> Box<dyn FnMut(&VideoMemory) + Send> {
        let movie = self.clone();
        Box::new(move |memory| {
            let mut state = movie.lock();
            state.presents += 1;
            state.push(memory);
        })
    }

    /// Starts to record frames of `display` by the clock. While `is_window` is set there is no
    /// window, and recorded frames count as shown. `None` if no thread can be started.
    pub fn sample(&self, display: Arc<Display>, clock: Clock, is_window: Arc<AtomicBool>) -> Option<Sampler> {
        let (movie, ends) = (self.clone(), Arc::new(AtomicBool::new(false)));
        let told = ends.clone();
        let thread = std::thread::Builder::new().name("movie".into()).spawn(move || {
            movie.run(&display, clock, &is_window, &told);
        });
        // Without a thread at least the last frame is recorded.
        Some(Sampler { ends, thread: Some(thread.ok()?) })
    }

    /// Records frames by the clock until `ends` is set.
    fn run(&self, display: &Display, clock: Clock, is_window: &AtomicBool, ends: &AtomicBool) {
        let (begun, mut shown, mut taken) = (Instant::now(), ShownFrame::default(), 0u32);
        let Ok(mut memory) = VideoMemory::new(display.width(), display.height()) else { return };
        while !ends.load(Ordering::Acquire) {
            let due = begun + Duration::from_secs_f64(f64::from(taken) / self.rate);
            let now = Instant::now();
            if now < due {
                std::thread::sleep((due - now).min(LONGEST_SLEEP));
                continue;
            }
            if display.copy_changes(shown.version, &mut shown).is_some() {
                memory.bytes_mut().copy_from_slice(&shown.bytes);
            }
            {
                let mut state = self.lock();
                if clock == Clock::Always || state.presents == 0 {
                    state.push(&memory);
                }
            }
            if is_window.load(Ordering::Acquire) {
                display.note_shown(shown.frame);
            }
            taken += 1;
        }
    }

    /// Finishes the movie: `memory` is the last frame, unless it is already there. Returns the
    /// first error of writing; a closed pipe is no error.
    pub fn finish(&self, memory: &VideoMemory) -> Result<(), SaveError> {
        let mut state = self.lock();
        if state.last_crc != Some(save::crc32(memory)) {
            state.push(memory);
        }
        match state.failure.take() {
            Some(SaveError::Io { kind: std::io::ErrorKind::BrokenPipe, .. }) | None => Ok(()),
            Some(e) => Err(e),
        }
    }
}

/// A thread that records frames by the clock; dropping this ends it.
pub(super) struct Sampler {
    ends: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Drop for Sampler {
    fn drop(&mut self) {
        self.ends.store(true, Ordering::Release);
        if let Some(thread) = self.thread.take() {
            // A panic is reported by the thread itself, and affects only the movie.
            let _ = thread.join();
        }
    }
}
