//! `--movie`: what `play` and `serve` show, as a movie.
//!
//! Two sources of frames, each with its own promise. PRESENT: every one is a frame, none is lost, the same stream gives the
//! same movie. The clock: what stands every 1/rate seconds, as somebody at the screen would see it. Each frame is in the file
//! before the next is taken; a program that is killed leaves what was recorded readable.

use crate::memory::VideoMemory;
use crate::save::{self, Movie, MovieFormat, SaveError};
use crate::server::{Display, ShownFrame};
use clap::Args;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// How long the sampler sleeps at most, so that it ends soon when told to.
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
    /// Whether standard output is the movie's.
    pub fn takes_stdout(&self) -> bool {
        self.movie.as_deref() == Some(Path::new("-"))
    }

    /// Checks the name before anything is done.
    pub fn check(&self) -> Result<(), String> {
        self.movie
            .as_ref()
            .map_or(Ok(()), |path| MovieFormat::of_path(path).map(drop).map_err(|e| e.to_string()))
    }

    /// The movie that is asked for, if any.
    pub fn open(&self, width: u32, height: u32) -> Result<Option<MovieWriter>, String> {
        let Some(path) = &self.movie else { return Ok(None) };
        let movie = Movie::create(path, width, height, self.movie_fps).map_err(|e| e.to_string())?;
        let state = MovieState { movie, failure: None, presents: 0, last_crc: None };
        Ok(Some(MovieWriter { state: Arc::new(Mutex::new(state)), rate: self.movie_fps }))
    }
}

/// A movie that frames of several threads go into.
#[derive(Clone, Debug)]
pub(super) struct MovieWriter {
    state: Arc<Mutex<MovieState>>,
    rate: f64,
}

#[derive(Debug)]
struct MovieState {
    movie: Movie,
    failure: Option<SaveError>,
    presents: u64,
    /// Of the last frame's bytes.
    last_crc: Option<u32>,
}

impl MovieState {
    fn push(&mut self, memory: &VideoMemory) {
        if self.failure.is_none() {
            self.last_crc = Some(save::crc32(memory));
            self.failure = self.movie.push(memory).err();
        }
    }
}

/// Until when the clock takes frames.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Clock {
    /// To the end.
    Always,
    /// Up to the first PRESENT: from there on, those are the frames.
    UntilPresent,
}

impl MovieWriter {
    fn lock(&self) -> MutexGuard<'_, MovieState> {
        // A frame that was not finished is not in the file: the state is sound.
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// What is to be called at each PRESENT: it is a frame.
    pub fn on_present(&self) -> Box<dyn FnMut(&VideoMemory) + Send> {
        let movie = self.clone();
        Box::new(move |memory| {
            let mut state = movie.lock();
            state.presents += 1;
            state.push(memory);
        })
    }

    /// Takes frames by the clock from what `display` shows. `is_window` says that nobody else shows it: frames that are
    /// in the movie count as shown then.
    pub fn sample(&self, display: Arc<Display>, clock: Clock, is_window: Arc<AtomicBool>) -> Option<Sampler> {
        let (movie, ends) = (self.clone(), Arc::new(AtomicBool::new(false)));
        let told = ends.clone();
        let thread = std::thread::Builder::new().name("movie".into()).spawn(move || {
            movie.run(&display, clock, &is_window, &told);
        });
        // Without a thread to spare there is the last frame at least.
        Some(Sampler { ends, thread: Some(thread.ok()?) })
    }

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

    /// The end: what stands now is the last frame, unless it is there already. Whether all was written; a pipe that nobody
    /// reads any more has what it wanted.
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

/// A thread that takes frames by the clock; it ends when this is dropped.
pub(super) struct Sampler {
    ends: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Drop for Sampler {
    fn drop(&mut self) {
        self.ends.store(true, Ordering::Release);
        if let Some(thread) = self.thread.take() {
            // A panic there is told by the thread itself, and costs the movie alone.
            let _ = thread.join();
        }
    }
}
