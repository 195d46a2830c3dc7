//! `fbptr play`: a stream of commands from a file or standard input, in a window or headless.

use super::args::color::color;
use super::args::crt::CrtArgs;
use super::expect::{ExpectArgs, Expected};
use super::frame_clock::FrameClock;
use super::magic::{self, CommandInput};
use super::movie::{Clock, MovieArgs, MovieWriter, Sampler};
use super::output::{self, Stdout};
use super::progress::Watched;
use super::render_args::RenderArgs;
use super::scene_file;
use super::table::Table;
use super::trace::TraceAt;
use super::web::{PreparedWeb, WebArgs, WebPage};
use super::{FrameSize, Status, check_folder, check_picture, say_as_program, signals};
use crate::command::EndOfInput;
use crate::load::SandboxDir;
use crate::memory::{DepthFormat, DepthMemory, Rgba, VideoMemory};
use crate::save;
use crate::server::{
    Display, DisplayObserver, Engine, Finish, Limits, Notice, OnPresent, Player, RenderThread, recorded_size,
    stated_size,
};
use clap::Args;
use std::fs::File;
use std::io::{self, Read, Seek};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

/// Play a stream of commands.
#[derive(Debug, Args)]
pub struct Play {
    /// The stream; `-` or nothing is standard input
    #[arg(value_name = "FILE")]
    file: Option<PathBuf>,
    /// The frame's size
    #[arg(long, value_name = "WxH")]
    size: Option<FrameSize>,
    /// The colour that the frame begins with, in hex or by its CSS name
    #[arg(long, value_name = "COLOUR", value_parser = color, default_value = "black")]
    background: Rgba,
    /// Open no window
    #[arg(long)]
    headless: bool,
    /// Stop at the first picture: the full stop goes on by one command that draws, after AUTO off to the next PRESENT, space to
    /// the end
    #[arg(long)]
    paused: bool,
    /// Write the frame at the end: .png, .ppm or .raw
    #[arg(long, value_name = "OUT")]
    snap: Option<PathBuf>,
    #[command(flatten)]
    expect: ExpectArgs,
    /// Print every number that a triangle (N, counted through all draws), what is seen at a pixel (X,Y) or a triangle at a
    /// pixel (N@X,Y) has on its way
    #[arg(long, value_name = "N|X,Y|N@X,Y")]
    trace: Option<TraceAt>,
    /// Print the picture at the end, or its depths, as a table of text; up to 64x64 pixels
    #[arg(long, value_name = "color|depth", num_args = 0..=1, require_equals = true, default_missing_value = "color")]
    table: Option<Table>,
    /// Print how long the frames took from one PRESENT to the next, a movie's writing included: their number, median, 99th
    /// percentile and longest
    #[arg(long, requires = "headless")]
    frame_times: bool,
    /// Print what the last draw of faces needs, where its view comes from, and why
    #[arg(long)]
    explain: bool,
    /// Write the depth at the end
    #[arg(long, value_name = "OUT.pfm")]
    depth_out: Option<PathBuf>,
    /// Let SNAP write files in this folder
    #[arg(long, value_name = "DIR")]
    snap_dir: Option<PathBuf>,
    /// Let LOAD read files from this folder
    #[arg(long, value_name = "DIR")]
    load_dir: Option<PathBuf>,
    /// Seconds that one command may take, but for the drawing of faces
    #[arg(long, value_name = "SECONDS", value_parser = super::serve::seconds, default_value = "10")]
    max_command_time: Duration,
    /// Let --web take an address that other machines reach
    #[arg(long)]
    allow_remote: bool,
    #[command(flatten)]
    web: WebArgs,
    #[command(flatten)]
    crt: CrtArgs,
    #[command(flatten)]
    movie: MovieArgs,
    #[command(flatten)]
    drawing: RenderArgs,
}

/// Stream of commands, ready to be played by its engine.
struct Stream {
    engine: Engine,
    input: Box<dyn Read + Send>,
    /// Name in messages.
    name: String,
    end: EndOfInput,
    has_failed: Arc<AtomicBool>,
    expected: Option<Expected>,
}

/// Places that frames go to.
struct Outlets {
    /// Frames of the window.
    display: Option<Arc<Display>>,
    movie: Option<MovieWriter>,
    /// Recorder by the clock, for a movie of a live stream.
    sampler: Option<Sampler>,
    is_live: bool,
    /// True while there is no window.
    is_alone: Arc<AtomicBool>,
    /// Clock of the frames, if their times are asked for.
    clock: Option<Arc<Mutex<FrameClock>>>,
}

impl Play {
    /// Plays to the end, and returns the exit status.
    pub(super) fn run(self) -> Status {
        let prepared = self.prepare().and_then(|prepared| {
            let memory = prepared.engine.memory();
            let movie = self.movie.open(memory.width(), memory.height(), self.crt)?;
            Ok((movie, self.web.prepare(self.allow_remote)?, prepared))
        });
        match prepared {
            Ok((movie, web, stream)) => self.play(stream, movie, web),
            Err(message) => {
                say_as_program(message);
                Status::BadArguments
            }
        }
    }

    /// Opens and validates everything that the arguments name.
    fn prepare(&self) -> Result<Stream, String> {
        if let Some(snap) = &self.snap {
            check_picture(snap)?;
        }
        if let Some(path) = &self.depth_out {
            save::check_depth_path(path).map_err(|e| e.to_string())?;
            check_folder(path)?;
        }
        self.movie.check()?;
        let expected = self.expect.check(&self.drawing)?;
        let printed = [
            ("--trace", self.trace.is_some()),
            ("--explain", self.explain),
            ("--table", self.table.is_some()),
        ];
        for (option, is_set) in printed {
            if self.movie.takes_stdout() && is_set {
                return Err(format!("--movie - and {option}: both want standard output"));
            }
        }
        let has_failed = Arc::new(AtomicBool::new(false));
        let (mut size_of_file, mut takes_size) = (None, false);
        let (input, name, end): (Box<dyn Read + Send>, _, _) = match &self.file {
            Some(path) if path != Path::new("-") => {
                let name = path.display().to_string();
                let (file, len) = open_stream(path, &name)?;
                if len.is_some() {
                    size_of_file = read_size(&file).map_err(|e| format!("{name}: {e}"))?;
                    takes_size = true;
                }
                let end = if len.is_some() { EndOfInput::File } else { EndOfInput::Stream };
                let input: Box<dyn Read + Send> = match len {
                    Some(len) if self.headless => Box::new(Watched::new(file, len)),
                    _ => Box::new(file),
                };
                (input, name, end)
            }
            _ => (
                Box::new(CommandInput::new(io::stdin(), has_failed.clone())),
                "-".to_owned(),
                EndOfInput::Stream,
            ),
        };
        let mut engine = self.engine(self.size.or(size_of_file).unwrap_or(FrameSize::DEFAULT))?;
        if takes_size {
            engine.take_size();
        }
        Ok(Stream { engine, input, name, end, has_failed, expected })
    }

    /// Creates the engine according to the arguments.
    fn engine(&self, FrameSize { width, height }: FrameSize) -> Result<Engine, String> {
        // The stream is the user's own, so it may fill the user's disk.
        let limits = Limits {
            snap_bytes: u64::MAX,
            command_time: self.max_command_time,
            memory_bytes: self.drawing.memory_bytes(),
            ..Limits::default()
        };
        let mut engine =
            Engine::with_limits(width, height, limits.for_frame(width, height)).map_err(|e| e.message)?;
        let folder = |path: &Path| SandboxDir::open(path).map_err(|e| format!("{}: {e}", path.display()));
        engine.set_renderer(self.drawing.renderer());
        if let Some(trace) = self.trace {
            engine.set_trace(trace.probe());
        }
        if self.explain {
            engine.set_explain();
        }
        if self.background != VideoMemory::CLEAR {
            engine.fill_frame(self.background);
        }
        if let Some(path) = &self.snap_dir {
            engine.set_snap_dir(folder(path)?);
            save::remove_leftovers_in(path);
        }
        if let Some(path) = &self.load_dir {
            engine.set_load_dir(folder(path)?);
        }
        Ok(engine)
    }

    /// Plays a prepared stream and writes what was asked for.
    fn play(&self, stream: Stream, movie: Option<MovieWriter>, mut web: Option<PreparedWeb>) -> Status {
        let Stream { mut engine, input, name, end, has_failed, expected } = stream;
        let outlets = self.outlets(&mut engine, movie, end);
        web.iter_mut().for_each(|web| web.attach(&mut engine));
        let thread = match RenderThread::start(engine) {
            Ok(thread) => thread,
            Err(e) => {
                say_as_program(format_args!("no thread to render on: {e}"));
                return Status::Failed;
            }
        };
        let page = match web.map(|web| web.serve_thread(&thread)).transpose() {
            Ok(page) => page,
            Err(message) => {
                say_as_program(message);
                return Status::BadArguments;
            }
        };
        let interrupted = watch_signals(&thread, outlets.display.clone());
        let player =
            match Player::start(&thread, input, self.replies(), end, notices(name, has_failed.clone())) {
                Ok(player) => player,
                Err(e) => {
                    say_as_program(format_args!("no thread to read on: {e}"));
                    return Status::Failed;
                }
            };
        let Outlets { display, movie, sampler, is_live, is_alone, clock } = outlets;
        let mut engine = match display {
            Some(display) => self.with_window(thread, player, display, is_live.then_some(&*is_alone), page),
            None => finish_alone(thread, player, page),
        };
        self.report(&mut engine, &has_failed);
        if let Some(clock) = clock {
            clock.lock().unwrap_or_else(PoisonError::into_inner).report();
        }
        drop(sampler);
        let mut is_saved = self.save(&engine);
        if let Some(e) = movie.and_then(|movie| movie.finish(engine.memory()).err()) {
            say_as_program(format_args!("the movie ends early: {e}"));
            is_saved = false;
        }
        if interrupted.load(Ordering::Acquire) {
            return Status::Interrupted;
        }
        is_saved &= expected.is_none_or(|expected| expected.is_met_by(engine.memory()));
        match has_failed.load(Ordering::Acquire) || !is_saved {
            true => Status::Failed,
            false => Status::Success,
        }
    }

    /// Connects the engine to a display and to the movie, where there are any.
    fn outlets(&self, engine: &mut Engine, movie: Option<MovieWriter>, end: EndOfInput) -> Outlets {
        let (width, height) = (engine.memory().width(), engine.memory().height());
        let new_display = || Display::new(width, height);
        let display = self.wants_window().then(new_display);
        // A stream that is typed or sent runs in real time; a file has only its PRESENTs.
        let is_live = movie.is_some() && end == EndOfInput::Stream;
        let seen = display.clone().or_else(|| is_live.then(new_display));
        // A frame is in the movie before anything sees it on the display.
        if let Some(movie) = &movie {
            engine.attach(OnPresent::new(movie.on_present()));
        }
        if let Some(seen) = &seen {
            engine.attach(DisplayObserver::new(seen.clone()));
            if self.paused && display.is_some() {
                seen.set_paused(true);
                seen.step();
            }
        }
        let is_alone = Arc::new(AtomicBool::new(display.is_none()));
        let sampler = match (&movie, &seen) {
            (Some(movie), Some(seen)) if is_live => {
                movie.sample(seen.clone(), Clock::UntilPresent, is_alone.clone())
            }
            _ => None,
        };
        let clock = self.frame_times.then(|| Arc::new(Mutex::new(FrameClock::start())));
        if let Some(clock) = clock.clone() {
            engine.attach(OnPresent::new(move |_| {
                clock.lock().unwrap_or_else(PoisonError::into_inner).end_frame_of_stream()
            }));
        }
        Outlets { display, movie, sampler, is_live, is_alone, clock }
    }

    /// Returns the stream that replies go to: standard error if the movie takes standard output.
    fn replies(&self) -> Box<dyn io::Write + Send> {
        let owes_nothing = self.headless
            && [&self.snap, &self.depth_out, &self.snap_dir].iter().all(|path| path.is_none())
            && !self.movie.is_wanted()
            && !self.web.is_wanted();
        if owes_nothing {
            output::end_if_closed();
        }
        match self.movie.takes_stdout() {
            true => Box::new(io::stderr()),
            false => Box::new(Stdout),
        }
    }

    /// Says at the end what was abandoned, what the trace found and what the file may have been.
    fn report(&self, engine: &mut Engine, has_failed: &AtomicBool) {
        if let Some(verb) = engine.take_abandoned() {
            say_as_program(format_args!("ended in the middle of {verb}: the picture may hold a part of it"));
        }
        if self.explain {
            match engine.explanation() {
                Some(plan) => output::print(plan),
                None => say_as_program("--explain: there was no draw of faces"),
            }
        }
        if self.trace.is_some() {
            match engine.trace() {
                Some(numbers) => output::print(format!("{numbers}\n")),
                None => {
                    say_as_program("--trace: no draw had this triangle, or gave this pixel its colour");
                    has_failed.store(true, Ordering::Release);
                }
            }
        }
        if let Some(table) = self.table {
            let memory = engine.memory();
            match table.check(memory.width(), memory.height()) {
                Ok(()) => table.print(memory, engine.depth()),
                Err(message) => {
                    say_as_program(message);
                    has_failed.store(true, Ordering::Release);
                }
            }
        }
        if let Some(path) = self.file.as_deref().filter(|path| scene_file::has_scene_ending(path))
            && has_failed.load(Ordering::Acquire)
        {
            let path = path.display();
            say_as_program(format_args!(
                "{path} was read as a stream of commands; as a scene, `fbptr view {path}` shows it"
            ));
        }
    }

    #[cfg(feature = "window")]
    fn wants_window(&self) -> bool {
        !self.headless
    }

    #[cfg(not(feature = "window"))]
    fn wants_window(&self) -> bool {
        if !self.headless {
            say_as_program("built without windows: going on headless");
        }
        false
    }

    /// Plays with the window on this thread, the main one.
    #[cfg(feature = "window")]
    fn with_window(
        &self,
        thread: RenderThread,
        player: Player,
        display: Arc<Display>,
        recorded: Option<&AtomicBool>,
        page: Option<WebPage>,
    ) -> Engine {
        let shown = display.clone();
        player.on_end(move || shown.finish());
        let title = self.file.as_ref().map_or("fbptr".into(), |f| format!("fbptr {}", f.display()));
        let (crt, saves_crt) = (self.crt.in_window(), self.crt.in_files());
        let options = crate::window::Options { title, crt, saves_crt, ..Default::default() };
        match super::main_thread::show(display, options) {
            Ok(()) if player.has_ended() => {
                // Those who drive in a browser would keep the thread running.
                drop(page);
                thread.finish_engine(Finish::WhenAllEnded)
            }
            // The user closed the window.
            Ok(()) => thread.finish_engine(Finish::Now),
            Err(e) => {
                say_as_program(format_args!("{e}: going on headless"));
                match recorded {
                    // The movie continues and takes the window's place.
                    Some(is_alone) => is_alone.store(true, Ordering::Release),
                    None => thread.drop_display(),
                }
                finish_alone(thread, player, page)
            }
        }
    }

    #[cfg(not(feature = "window"))]
    fn with_window(
        &self,
        thread: RenderThread,
        player: Player,
        _: Arc<Display>,
        _: Option<&AtomicBool>,
        page: Option<WebPage>,
    ) -> Engine {
        finish_alone(thread, player, page)
    }

    /// Writes the requested files, and returns whether all were written.
    fn save(&self, engine: &Engine) -> bool {
        let memory = engine.memory();
        let snap = self.snap.as_ref().map(|path| self.crt.save(memory, path));
        let depth = self.depth_out.as_ref().map(|path| match engine.depth() {
            Some(depth) => save::depth_to_path(depth, path),
            // Nothing with a depth was drawn: 1 everywhere.
            None => save::depth_to_path(
                &DepthMemory::new(memory.width(), memory.height(), DepthFormat::F32),
                path,
            ),
        });
        let depth = depth.map(|written| written.map_err(|e| e.to_string()));
        let mut is_saved = true;
        for error in [snap, depth].into_iter().flatten().filter_map(Result::err) {
            say_as_program(error);
            is_saved = false;
        }
        is_saved
    }
}

/// Waits for the stream's end without a window; a page in the browser stays until a signal.
fn finish_alone(thread: RenderThread, player: Player, page: Option<WebPage>) -> Engine {
    player.wait();
    if let Some(page) = page {
        if !thread.is_finished() {
            say_as_program("the stream has ended; the page stays until Ctrl-C");
        }
        while !thread.is_finished() {
            std::thread::sleep(Duration::from_millis(50));
        }
        drop(page);
    }
    thread.finish_engine(Finish::WhenAllEnded)
}

/// Opens a file that holds a stream of commands; the length is `None` for a pipe or device.
pub(super) fn open_stream(path: &Path, name: &str) -> Result<(File, Option<u64>), String> {
    let refused = |e: io::Error| format!("{name}: {e}");
    let file = File::open(path).map_err(refused)?;
    let meta = file.metadata().map_err(refused)?;
    if meta.is_dir() {
        return Err(format!("{name}: is a folder"));
    }
    if !meta.is_file() {
        return Ok((file, None));
    }
    if let Some(content) = magic::other_than_commands(&file).map_err(refused)? {
        return Err(format!("{name}: {content}; expected a stream of commands"));
    }
    (&file).rewind().map_err(refused)?;
    Ok((file, Some(meta.len())))
}

/// Returns the receiver of a stream's notices, which sets `has_failed` at a refused command.
fn notices(name: String, has_failed: Arc<AtomicBool>) -> impl FnMut(Notice) + Send + 'static {
    move |notice| {
        if matches!(notice, Notice::Refused(_)) {
            has_failed.store(true, Ordering::Release);
        }
        say_as_program(notice.play_line(&name));
    }
}

/// Returns the frame size of a recording from its first line, or `None` for another stream. Rewinds
/// the file.
fn read_size(mut file: &File) -> Result<Option<FrameSize>, String> {
    let mut first = Vec::new();
    file.take(1 << 16).read_to_end(&mut first).map_err(|e| e.to_string())?;
    file.rewind().map_err(|e| e.to_string())?;
    size_of_stream(&first)
}

/// Returns the frame size that a recording's first line or a stream's first command states.
///
/// # Errors
/// A message if it is no size of a frame.
pub(super) fn size_of_stream(first: &[u8]) -> Result<Option<FrameSize>, String> {
    if let Some(size) = first.split(|&b| b == b'\n').next().and_then(recorded_size) {
        return size.parse().map(Some).map_err(|e| format!("the recording's frame size {size}: {e}"));
    }
    match stated_size(first) {
        Some([w, h]) => format!("{w}x{h}").parse().map(Some).map_err(|e| format!("SIZE {w} {h}: {e}")),
        None => Ok(None),
    }
}

/// Ends playback on a signal, still writing the snapshot, and at once on a second one. Returns a
/// flag that is set by the first signal.
fn watch_signals(thread: &RenderThread, display: Option<Arc<Display>>) -> Arc<AtomicBool> {
    let (stop, has_come) = (thread.stopper(), Arc::new(AtomicBool::new(false)));
    let flag = has_come.clone();
    // Without a handler the system's default action ends the process.
    let _ = signals::watch(move || {
        flag.store(true, Ordering::Release);
        stop();
        if let Some(display) = &display {
            display.leave();
        }
    });
    has_come
}
