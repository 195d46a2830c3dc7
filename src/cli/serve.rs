//! `fbptr serve`: a server for programs in any language, with a window or headless.

use super::bytes::ByteSize;
use super::interval::Interval;
use super::movie::{Clock, MovieArgs, MovieWriter, Sampler};
use super::output::Stdout;
use super::record_gate::RecordGate;
use super::render_args::RenderArgs;
use super::web::WebArgs;
use super::{FrameSize, Status, args, check_picture, say_as_program, signals};
use crate::draw2d::Blend;
use crate::load::SandboxDir;
use crate::memory::SharedFile;
use crate::save;
use crate::server::{
    Dialect, Display, DisplayObserver, Engine, FileSharing, Limits, ListenAddress, MetricsBoard,
    MetricsServer, OutputState, PeriodicSnapshots, Server, SnapshotPlan, VerbCounts,
};
use crate::simd::allocator;
use args::crt::CrtArgs;
use clap::Args;
use crossbeam_channel::{Sender, bounded};
use std::io;
use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

/// Time after a signal for received commands to run; a drawing that is not finished by then is
/// abandoned.
const PATIENCE: Duration = Duration::from_millis(400);
/// Time after a signal at which the process ends even if the render thread is still running.
const LAST_MOMENT: Duration = Duration::from_millis(950);
/// Time after a signal at which the process ends even if the files of the command line are still
/// being written.
const LAST_MOMENT_OF_FILES: Duration = Duration::from_secs(10);

/// Serve a video memory to other programs.
#[derive(Debug, Args)]
pub struct Serve {
    /// The frame's size
    #[arg(long, value_name = "WxH")]
    size: Option<FrameSize>,
    /// Listen on a TCP address, any number of times; :PORT or PORT is loopback [default: 127.0.0.1:1234]
    #[arg(long, value_name = "ADDR")]
    listen: Vec<String>,
    /// Let --listen, --metrics and --web take addresses that other machines reach
    #[arg(long)]
    allow_remote: bool,
    /// Listen on a Unix socket, any number of times
    #[arg(long, value_name = "PATH")]
    unix: Vec<PathBuf>,
    /// Serve standard input too, with replies on standard output
    #[arg(long)]
    stdin: bool,
    /// Open no window
    #[arg(long)]
    headless: bool,
    /// Open the window over the whole screen (X11); F11 goes back
    #[arg(long, conflicts_with = "headless")]
    fullscreen: bool,
    /// Show addresses, clients and rates in the window from the start; F3 hides them
    #[arg(long, conflicts_with = "headless")]
    overlay: bool,
    /// Enlargement of the frame by the window; F10 changes it
    #[arg(long, value_name = "HOW", value_enum, default_value_t = Enlarge::Whole, conflicts_with = "headless")]
    scaling: Enlarge,
    /// Put the video memory into a file that other programs map
    #[arg(long, value_name = "PATH")]
    shm: Option<PathBuf>,
    /// Blend of connections that do not say BLEND: over composes the alpha of PX x y rrggbbaa
    #[arg(long, value_name = "MODE", value_enum, default_value_t = Alpha::Replace)]
    alpha: Alpha,
    /// Take one hex digit as a colour of PX: g is the grey gg
    #[arg(long)]
    grey_digit: bool,
    /// Let SNAP write files in this folder
    #[arg(long, value_name = "DIR")]
    snap_dir: Option<PathBuf>,
    /// Write the frame into the --snap-dir every so often (10s, 5m, 1h), as wall-YYYYMMDD-HHMMSS.png in UTC
    #[arg(long, value_name = "TIME", requires = "snap_dir")]
    snap_every: Option<Interval>,
    /// Bytes that all those pictures may take, in blocks of 4096 (K, M, G); the oldest go
    #[arg(long, value_name = "BYTES", default_value = "1G", requires = "snap_every")]
    snap_keep: ByteSize,
    /// Serve /metrics (Prometheus; JSON by Accept) and /metrics.json over HTTP on this address; :PORT is loopback
    #[arg(long, value_name = "ADDR")]
    metrics: Option<String>,
    /// Let LOAD read files from this folder
    #[arg(long, value_name = "DIR")]
    load_dir: Option<PathBuf>,
    /// Write the frame at the end: .png, .ppm or .raw
    #[arg(long, value_name = "OUT")]
    snap: Option<PathBuf>,
    /// Record what is executed; `fbptr play` plays it again. A recording that cannot be written is reported at once, and
    /// the server ends with status 1
    #[arg(long, value_name = "FILE")]
    record: Option<PathBuf>,
    #[command(flatten)]
    web: WebArgs,
    #[command(flatten)]
    drawing: RenderArgs,
    #[command(flatten)]
    crt: CrtArgs,
    #[command(flatten)]
    movie: MovieArgs,
    #[command(flatten)]
    quotas: Quotas,
}

/// A blend as an argument.
#[derive(Clone, Copy, Debug, clap::ValueEnum)]
enum Alpha {
    /// Compose colours source-over
    Over,
    /// Store colours as they are
    Replace,
}

/// A way to enlarge the frame as an argument.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum Enlarge {
    /// By whole factors, with bars at the sides
    Whole,
    /// To the window's width or height, sharp
    Fit,
    /// To the window's width or height, smooth
    Smooth,
}

/// The quotas. Numbers of bytes may end in K, M or G.
#[derive(Debug, Args)]
pub(super) struct Quotas {
    /// Connections at one time
    #[arg(long, value_name = "N", default_value_t = Limits::default().connections as u32,
        value_parser = clap::value_parser!(u32).range(1..))]
    max_conns: u32,
    /// Connections at one time from one IPv4 address, or one /64 network of IPv6
    #[arg(long, value_name = "N", default_value_t = Limits::default().connections_per_address as u32,
        value_parser = clap::value_parser!(u32).range(1..))]
    max_conns_per_address: u32,
    /// Close connections that send nothing and are owed nothing for so long; 0 is never [default: 0]
    #[arg(long, value_name = "SECONDS", value_parser = clap::value_parser!(u32))]
    idle_timeout: Option<u32>,
    /// Bytes of a payload
    #[arg(long, value_name = "BYTES", default_value_t = ByteSize(Limits::default().payload_bytes))]
    max_payload: ByteSize,
    /// Names of a connection, and of all shared names
    #[arg(long, value_name = "N", default_value_t = Limits::default().names)]
    max_names: usize,
    /// Bytes of the resources of a connection, and of all shared ones
    #[arg(long, value_name = "BYTES", default_value_t = ByteSize(Limits::default().resource_bytes))]
    max_resources: ByteSize,
    /// Bytes of the frame
    #[arg(long, value_name = "BYTES", default_value_t = ByteSize(Limits::default().frame_bytes))]
    max_frame: ByteSize,
    /// Bytes of the files that SNAP has written
    #[arg(long, value_name = "BYTES", default_value_t = ByteSize(Limits::default().snap_bytes))]
    max_snaps: ByteSize,
    /// Bytes of replies that a client has not read [default: 64 MiB, or the frame's bytes if that is more]
    #[arg(long, value_name = "BYTES")]
    max_replies: Option<ByteSize>,
    /// Seconds that one command may take, but for the drawing of faces
    #[arg(long, value_name = "SECONDS", value_parser = seconds, default_value = "10")]
    max_command_time: Duration,
}

/// Parses a number of seconds above 0.
pub(super) fn seconds(text: &str) -> Result<Duration, String> {
    let number = text.parse::<f64>().ok().filter(|s| *s > 0.0);
    let time = number.and_then(|s| Duration::try_from_secs_f64(s).ok()).filter(|t| !t.is_zero());
    time.ok_or_else(|| format!("a number of seconds above 0 is expected, not {text:?}"))
}

impl Quotas {
    fn limits(&self, FrameSize { width, height }: FrameSize, memory_bytes: u64) -> Limits {
        let limits = Limits {
            memory_bytes,
            connections: self.max_conns as usize,
            connections_per_address: self.max_conns_per_address as usize,
            idle_timeout: self.idle_timeout.filter(|s| *s > 0).map(|s| Duration::from_secs(s.into())),
            payload_bytes: self.max_payload.0,
            names: self.max_names,
            resource_bytes: self.max_resources.0,
            frame_bytes: self.max_frame.0,
            snap_bytes: self.max_snaps.0,
            command_time: self.max_command_time,
            ..Limits::default()
        };
        match self.max_replies {
            Some(ByteSize(bytes)) => {
                Limits { reply_bytes: usize::try_from(bytes).unwrap_or(usize::MAX), ..limits }
            }
            None => limits.for_frame(width, height),
        }
    }
}

/// Data for the window's overlay: addresses and counters.
#[cfg_attr(not(feature = "window"), expect(dead_code, reason = "there is no window to tell it"))]
struct Told {
    addresses: Vec<String>,
    board: Option<Arc<MetricsBoard>>,
}

/// Places that frames and counters go to.
struct Outlets {
    /// Frames of the window.
    display: Option<Arc<Display>>,
    /// Counters, read by the metrics endpoint and the window's overlay.
    board: Option<Arc<MetricsBoard>>,
    movie: Option<MovieWriter>,
    /// Recorder of the movie's frames.
    sampler: Option<Sampler>,
    /// True while there is no window.
    is_alone: Arc<AtomicBool>,
}

/// Reason for the server's end.
enum Ending {
    Signal,
    InputEnded,
    #[cfg(feature = "window")]
    WindowClosed,
}

impl Serve {
    /// Serves until a signal, until the window is closed, or, if only standard input is served,
    /// until it ends.
    pub(super) fn run(self) -> Status {
        allocator::give_large_blocks_back();
        match self.serve() {
            Ok(status) => status,
            Err(message) => {
                say_as_program(message);
                Status::BadArguments
            }
        }
    }

    fn serve(&self) -> Result<Status, String> {
        self.check()?;
        let places = self.places()?;
        let metrics = self
            .metrics
            .as_deref()
            .map(|text| args::address::checked(text, self.allow_remote))
            .transpose()?;
        let mut web = self.web.prepare(self.allow_remote)?;
        let mut engine = self.engine()?;
        let outlets = self.outlets(&mut engine, metrics.is_some())?;
        web.iter_mut().for_each(|web| web.attach(&mut engine));
        let size = (engine.memory().width(), engine.memory().height());
        let (endings, ending) = bounded(8);
        // Before any client is admitted: from here on a signal ends the server in order.
        let told = endings.clone();
        signals::watch(move || _ = told.try_send(Ending::Signal))?;
        let mut server = Server::start(engine).map_err(|e| format!("no thread to render on: {e}"))?;
        let others = self.web.descriptors() + if metrics.is_some() { MetricsServer::MAX_FILES } else { 0 };
        if let Some(shortage) = server.fit_descriptors(places.len(), others) {
            say_as_program(format_args!("warning: {shortage}"));
        }
        let gate = RecordGate::close(&server, size);
        let mut listening = Vec::new();
        for place in places {
            listening.push(server.listen(place).map_err(|e| e.to_string())?);
        }
        let endpoint = match (metrics, &outlets.board) {
            (Some(address), Some(board)) => Some(self.serve_metrics(address, board.clone())?),
            _ => None,
        };
        let page = web.map(|web| web.serve(&server)).transpose()?;
        // The sockets first: a server whose port is taken leaves the other one's recording
        // unchanged.
        gate.open(self.record.as_deref())?;
        let mut heard_at = Vec::new();
        for place in listening {
            say_as_program(format_args!("listening on {place}"));
            heard_at.push(place.to_string());
        }
        if let Some(endpoint) = &endpoint {
            say_as_program(format_args!("metrics on http://{}/metrics", endpoint.address()));
        }
        let _snapshots = self.periodic_snapshots(&server)?;
        self.serve_stdin(&server, &endings)?;
        let Outlets { display, board, movie, sampler, is_alone } = outlets;
        let why = match display {
            Some(display) => {
                let told = Told { addresses: heard_at, board };
                let recorded = movie.is_some().then_some(&*is_alone);
                self.with_window(&server, display, told, endings, &ending, recorded)
            }
            None => ending.recv().unwrap_or(Ending::Signal),
        };
        drop(page);
        let mut engine = shut_down(server, why);
        engine.end();
        let status = engine.status();
        let has_failed = status.outputs.iter().any(|output| output.state == OutputState::Failed);
        drop(sampler);
        let is_saved = self.save(&engine, movie);
        Ok(if has_failed || !is_saved { Status::Failed } else { Status::Success })
    }

    /// Refuses arguments that contradict each other.
    fn check(&self) -> Result<(), String> {
        if let Some(snap) = &self.snap {
            check_picture(snap)?;
        }
        self.movie.check()?;
        if self.movie.takes_stdout() && self.stdin {
            return Err("--movie - and --stdin: both want standard output".to_owned());
        }
        Ok(())
    }

    /// Connects the engine to the window's display, the metrics and the movie, where there are any.
    fn outlets(&self, engine: &mut Engine, has_metrics: bool) -> Result<Outlets, String> {
        let display = self.display(engine);
        let board = (has_metrics || display.is_some()).then(MetricsBoard::new);
        if let Some(board) = &board {
            engine.attach(VerbCounts::new(board.clone()));
        }
        let (width, height) = (engine.memory().width(), engine.memory().height());
        let movie = self.movie.open(width, height, self.crt)?;
        // The movie records the frames of the window's display, or of one without a window.
        let seen = display.clone().or_else(|| movie.is_some().then(|| Display::new(width, height)));
        if let Some(display) = &seen {
            engine.attach(DisplayObserver::new(display.clone()));
        }
        let is_alone = Arc::new(AtomicBool::new(display.is_none()));
        let sampler = match (&movie, seen) {
            (Some(movie), Some(display)) => movie.sample(display, Clock::Always, is_alone.clone()),
            _ => None,
        };
        Ok(Outlets { display, board, movie, sampler, is_alone })
    }

    /// Serves standard input, if it is asked for; its end is the server's where nothing else is
    /// served.
    fn serve_stdin(&self, server: &Server, endings: &Sender<Ending>) -> Result<(), String> {
        if !self.stdin {
            return Ok(());
        }
        let is_all = self.listen.is_empty() && self.unix.is_empty();
        let endings = endings.clone();
        let on_end = move || {
            if is_all {
                let _ = endings.try_send(Ending::InputEnded);
            }
        };
        server
            .serve_pipe(Box::new(io::stdin()), Box::new(Stdout), on_end)
            .map_err(|e| format!("no thread to read on: {e}"))
    }

    /// Finishes the movie and writes the snapshot, and returns whether both were written.
    fn save(&self, engine: &Engine, movie: Option<MovieWriter>) -> bool {
        let mut is_saved = true;
        if let Some(e) = movie.and_then(|movie| movie.finish(engine.memory()).err()) {
            say_as_program(format_args!("the movie ends early: {e}"));
            is_saved = false;
        }
        if let Some(error) = self.snap.as_ref().and_then(|path| self.crt.save(engine.memory(), path).err()) {
            say_as_program(error);
            is_saved = false;
        }
        is_saved
    }

    /// Returns all addresses to listen on, validated.
    fn places(&self) -> Result<Vec<ListenAddress>, String> {
        let mut addresses: Vec<SocketAddr> = self
            .listen
            .iter()
            .map(|text| args::address::checked(text, self.allow_remote))
            .collect::<Result<_, _>>()?;
        if addresses.is_empty() && self.unix.is_empty() && !self.stdin {
            addresses.push(args::address::default_address());
        }
        for address in addresses.iter().filter(|a| !args::address::is_loopback(a)) {
            say_as_program(format_args!(
                "warning: {address} can be reached from other machines, and everybody may draw"
            ));
        }
        let tcp = addresses.into_iter().map(ListenAddress::Tcp);
        Ok(tcp.chain(self.unix.iter().cloned().map(ListenAddress::Unix)).collect())
    }

    /// Starts the HTTP endpoint of the metrics.
    fn serve_metrics(&self, address: SocketAddr, board: Arc<MetricsBoard>) -> Result<MetricsServer, String> {
        let name = self.metrics.as_deref().and_then(args::address::host_name);
        MetricsServer::start(address, name, board)
            .map_err(|e| format!("cannot serve metrics on {address}: {e}"))
    }

    /// Starts the periodic snapshots, if they are requested.
    fn periodic_snapshots(&self, server: &Server) -> Result<Option<PeriodicSnapshots>, String> {
        let (Some(Interval(every)), Some(path)) = (self.snap_every, &self.snap_dir) else { return Ok(None) };
        let plan = SnapshotPlan { folder: folder(path)?, every, keep_bytes: self.snap_keep.0 };
        let say = |failure: String| say_as_program(format_args!("no snapshot: {failure}"));
        PeriodicSnapshots::start(server.thread(), plan, say)
            .map(Some)
            .map_err(|e| format!("no thread to write snapshots on: {e}"))
    }

    /// Creates the engine according to the arguments.
    fn engine(&self) -> Result<Engine, String> {
        let wanted = self.size.unwrap_or(FrameSize::DEFAULT);
        let memory = self.drawing.memory_bytes();
        self.quotas.limits(wanted, memory).check_frame(wanted.width, wanted.height).map_err(|e| e.message)?;
        let shared = match &self.shm {
            None => None,
            Some(path) => {
                let size = (wanted.width, wanted.height);
                Some(SharedFile::open(path, size, self.size.is_some()).map_err(|e| e.to_string())?)
            }
        };
        let size =
            shared.as_ref().map_or(wanted, |file| FrameSize { width: file.width(), height: file.height() });
        let FrameSize { width, height } = size;
        let mut engine =
            Engine::with_limits(width, height, self.quotas.limits(size, memory)).map_err(|e| e.message)?;
        engine.set_renderer(self.drawing.renderer());
        let blend = match self.alpha {
            Alpha::Over => Blend::Over,
            Alpha::Replace => Blend::Replace,
        };
        engine.set_dialect(Dialect { blend, grey_digits: self.grey_digit });
        if let Some(path) = &self.snap_dir {
            engine.set_snap_dir(folder(path)?);
            save::remove_leftovers_in(path);
            if self.snap_every.is_some() {
                engine.reserve_snapshot_names();
            }
        }
        if let Some(path) = &self.load_dir {
            engine.set_load_dir(folder(path)?);
        }
        if let Some(file) = shared {
            engine.attach(FileSharing::new(file, |error| {
                say_as_program(format_args!("{error}: no longer shared"));
            }));
        }
        Ok(engine)
    }

    #[cfg(feature = "window")]
    fn display(&self, engine: &Engine) -> Option<Arc<Display>> {
        (!self.headless).then(|| Display::new(engine.memory().width(), engine.memory().height()))
    }

    #[cfg(not(feature = "window"))]
    fn display(&self, _: &Engine) -> Option<Arc<Display>> {
        if !self.headless {
            say_as_program("built without windows: going on headless");
        }
        None
    }

    /// Serves with the window on this thread, the main one, until the window is closed or the
    /// server ends for another reason.
    #[cfg(feature = "window")]
    fn with_window(
        &self,
        server: &Server,
        display: Arc<Display>,
        told: Told,
        endings: Sender<Ending>,
        ending: &crossbeam_channel::Receiver<Ending>,
        recorded: Option<&AtomicBool>,
    ) -> Ending {
        let (watched, seen) = (display.clone(), ending.clone());
        let watcher = std::thread::spawn(move || {
            let why = seen.recv().unwrap_or(Ending::Signal);
            watched.leave();
            why
        });
        let options = self.window_options(told);
        if let Err(e) = super::main_thread::show(display, options) {
            say_as_program(format_args!("{e}: going on headless"));
            match recorded {
                // The movie continues and takes the window's place.
                Some(is_alone) => is_alone.store(true, Ordering::Release),
                None => server.thread().drop_display(),
            }
        } else {
            let _ = endings.try_send(Ending::WindowClosed);
        }
        watcher.join().unwrap_or(Ending::Signal)
    }

    #[cfg(feature = "window")]
    fn window_options(&self, Told { addresses, board }: Told) -> crate::window::Options {
        use crate::window::{Options, Scaling, ServerStatus};
        Options {
            title: "fbptr serve".into(),
            fullscreen: self.fullscreen,
            scaling: match self.scaling {
                Enlarge::Whole => Scaling::Whole,
                Enlarge::Fit => Scaling::Fit,
                Enlarge::Smooth => Scaling::Smooth,
            },
            crt: self.crt.in_window(),
            saves_crt: self.crt.in_files(),
            shows_rates: self.overlay,
            server: board.map(|board| ServerStatus::new(addresses, board)),
            ..Options::default()
        }
    }

    #[cfg(not(feature = "window"))]
    fn with_window(
        &self,
        _: &Server,
        _: Arc<Display>,
        _: Told,
        _: Sender<Ending>,
        ending: &crossbeam_channel::Receiver<Ending>,
        _: Option<&AtomicBool>,
    ) -> Ending {
        ending.recv().unwrap_or(Ending::Signal)
    }
}

/// Ends the server and returns its engine: a stream's end lets all commands run, other reasons do
/// not wait for long.
fn shut_down(server: Server, why: Ending) -> Engine {
    let mut engine = match why {
        Ending::InputEnded => server.finish(),
        _ => {
            let is_rendering = end_at_the_last_moment();
            let engine = server.shut_down(PATIENCE);
            is_rendering.store(false, Ordering::Release);
            engine
        }
    };
    if let Some(verb) = engine.take_abandoned() {
        say_as_program(format_args!(
            "ended in the middle of {verb}: the memory may hold a part of it, a recording has nothing of it"
        ));
    }
    engine
}

/// Opens a folder that clients name files in.
pub(super) fn folder(path: &Path) -> Result<SandboxDir, String> {
    SandboxDir::open(path).map_err(|e| format!("{}: {e}", path.display()))
}

/// Ends the process in time even if a command runs for minutes or a disk does not respond.
///
/// The caller clears the returned flag when the render thread has ended.
fn end_at_the_last_moment() -> Arc<AtomicBool> {
    let is_rendering = Arc::new(AtomicBool::new(true));
    let flag = is_rendering.clone();
    let watch = move || {
        std::thread::sleep(LAST_MOMENT);
        if flag.load(Ordering::Acquire) {
            say_as_program("still busy: ended in the middle of a command");
            std::process::exit(1);
        }
        std::thread::sleep(LAST_MOMENT_OF_FILES - LAST_MOMENT);
        say_as_program("still busy: ended in the middle of writing files");
        std::process::exit(1);
    };
    // If no thread can be started there is no time limit, and shutdown continues.
    let _ = std::thread::Builder::new().name("last moment".into()).spawn(watch);
    is_rendering
}
