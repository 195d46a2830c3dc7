//! A run: the device, the render thread that shows it, the program, and their ends.
//!
//! In: the arguments; the program's memory at each vertical blank. Out: the window or the movie,
//! the pictures at the end, the exit status. Threads: the main one has the window, one keeps the
//! vertical blanks, one waits for the program; the render thread converts.

use super::super::args::address;
use super::super::movie::{Clock, MovieWriter, Sampler};
use super::super::{FrameSize, Status, say_as_program, signals};
use super::after::{After, Countdown, Moment, limit_of};
use super::family::{self, Members, PATIENCE};
use super::glut::{self, Libraries};
use super::input::Input;
use super::picture::Pictures;
use super::spawn::{self, Leash, Started, Terminals};
use super::told::Told;
use super::{Refusal, Run};
use crate::fbdev::{Device, DeviceOptions, Format, ScanOut};
use crate::memory::VideoMemory;
use crate::server::{Display, DisplayObserver, Engine, Limits, ListenAddress, Server};
use crossbeam_channel::{Receiver, Sender, bounded};
use rustix::process::{Pid, Signal, kill_process};
use std::process::{Child, ExitStatus};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Largest window that a program of GLUT may make, in pixels.
const LARGEST_WINDOW: (u32, u32) = (4096, 4096);
/// Time between two looks whether a program has made its window.
const WINDOW_LOOK: Duration = Duration::from_millis(2);

/// Exit status of a run that `--limit` has ended, as that of `timeout`.
const TIMED_OUT: u8 = 124;
/// Time that a program has to finish a picture that is due.
const HALF_PATIENCE: Duration = Duration::from_secs(2);

/// Reason for the end of a run.
enum Ending {
    /// The program has ended.
    Exited(ExitStatus),
    /// The moment of `--after`, or that of `--limit`, has come, with this picture.
    Reached(Moment, Box<VideoMemory>),
    Signal,
    #[cfg(feature = "window")]
    WindowClosed,
}

/// Places that frames go to.
struct Outlets {
    display: Option<Arc<Display>>,
    movie: Option<MovieWriter>,
    sampler: Option<Sampler>,
    /// True while there is no window.
    #[cfg_attr(not(feature = "window"), expect(dead_code, reason = "windows alone change it"))]
    is_alone: Arc<AtomicBool>,
}

/// Parts of a run that its threads share.
struct Shared {
    device: Device,
    scan_out: Mutex<ScanOut>,
    server: Server,
    hz: u32,
    is_verbose: bool,
    told: Mutex<Told>,
    input: Mutex<Input>,
    /// Set while input is replayed.
    is_replayed: AtomicBool,
    /// When the picture of `--after` was due that was half of one.
    due: Mutex<Option<Instant>>,
    /// Until the moment of `--after` or `--limit`.
    countdown: Mutex<Option<Countdown>>,
    has_ended: AtomicBool,
}

/// Runs the program, and returns the exit status.
pub fn run(args: &Run) -> Result<Status, Refusal> {
    let refuse = |message: String| Refusal { status: 2, message };
    let pictures = Pictures::new(args)?;
    args.movie.check().map_err(refuse)?;
    if args.movie.takes_stdout() {
        return Err(refuse("--movie -: standard output is the program's".to_owned()));
    }
    let after = args.after.as_deref().map(str::parse::<After>).transpose().map_err(refuse)?;
    let limit = limit_of(args.limit.as_deref(), after).map_err(refuse)?;
    let program = spawn::find(&args.program)?;
    let mut names = glut::names(&program);
    if args.glut {
        names.extend(glut::usual());
    }
    let device = device(args, !names.is_empty())?;
    let terminals = Terminals::open(args.size.unwrap_or(FrameSize::DEFAULT).into())
        .map_err(|e| refuse(format!("no terminal: {e}")))?;
    device.set_terminals(terminals.numbers());
    let console = terminals.path().to_owned();
    let spawn = |device: &Device, libraries: Option<&Libraries>| {
        let folder = args.folder.as_deref();
        spawn::spawn(&program, &args.program, device, &console, libraries, folder, args.leave_daemons)
            .map_err(|e| Refusal { status: 126, message: format!("{}: {e}", program.display()) })
    };
    let libraries = (!names.is_empty()).then(|| Libraries::new(&names, &device.library_path())).transpose();
    let libraries = libraries.map_err(|e| refuse(format!("no folder of libraries: {e}")))?;
    // The frame is of the size of the window that a program of GLUT makes.
    let mut early = libraries.as_ref().map(|libraries| spawn(&device, Some(libraries))).transpose()?;
    let (width, height) = match &mut early {
        Some(started) => window_size(args, &device, started, limit),
        None => args.size.unwrap_or(FrameSize::DEFAULT).into(),
    };
    let limits = Limits::default().for_frame(width, height);
    let mut engine = Engine::with_limits(width, height, limits).map_err(|e| refuse(e.message))?;
    let outlets = outlets(args, &mut engine).map_err(refuse)?;
    let mut web = args.web.prepare(args.allow_remote).map_err(refuse)?;
    web.iter_mut().for_each(|web| web.attach(&mut engine));
    let server = serve(args, engine).map_err(refuse)?;
    let _page = web.map(|web| web.serve(&server)).transpose().map_err(refuse)?;
    let (endings, ending) = bounded(8);
    let told = endings.clone();
    signals::watch(move || _ = told.try_send(Ending::Signal)).map_err(refuse)?;
    let shared = Shared {
        scan_out: Mutex::new(ScanOut::new(!args.serve.is_empty())),
        input: Mutex::new(Input::new(args, &device, &server, terminals)?),
        device,
        server,
        hz: args.hz,
        is_verbose: args.verbose,
        told: Mutex::default(),
        is_replayed: AtomicBool::new(false),
        due: Mutex::default(),
        countdown: Mutex::new(
            (after.is_some() || limit.is_some()).then(|| Countdown::new(after, limit, Instant::now())),
        ),
        has_ended: AtomicBool::new(false),
    };
    let shared = Arc::new(shared);
    // The black frame before the program is none of its frames.
    shared.blank(|_, _| false);
    let started = match early {
        Some(started) => started,
        None => spawn(&shared.device, None)?,
    };
    Ok(shared.attend(args, started, outlets, pictures, (endings, ending)))
}

/// Makes the device: of the frame's size, or of the largest window that a program of GLUT may make.
fn device(args: &Run, is_glut: bool) -> Result<Device, Refusal> {
    let refuse = |message: String| Refusal { status: 2, message };
    let name = match (is_glut, args.alpha) {
        (true, true) => "rgba".to_owned(),
        (true, false) => "rgbx".to_owned(),
        (false, true) if args.format.len() == 4 => args.format.replace('x', "a"),
        (false, _) => args.format.clone(),
    };
    let format = Format::index(&name).ok_or_else(|| {
        let names: Vec<&str> = crate::fbdev::FORMATS.iter().map(|f| f.name).collect();
        refuse(format!("--format: {} is expected, not {:?}", names.join(", "), args.format))
    })?;
    let size = if is_glut { LARGEST_WINDOW } else { args.size.unwrap_or(FrameSize::DEFAULT).into() };
    let line_length = if is_glut { 0 } else { args.line_length };
    Device::new(&DeviceOptions { size, format, hz: args.hz, line_length, is_glut })
        .map_err(|e| refuse(format!("no framebuffer device: {e}")))
}

/// Waits until a program of GLUT has made its window or has ended. Returns the frame's size: that of
/// `--size`, if the window fits into it.
fn window_size(args: &Run, device: &Device, started: &mut Started, limit: Option<Duration>) -> (u32, u32) {
    let begun = Instant::now();
    let window = loop {
        match device.window() {
            Some(window) => break Some(window),
            None if limit.is_some_and(|limit| begun.elapsed() >= limit) => break None,
            None if !matches!(started.child.try_wait(), Ok(None)) => break None,
            None => std::thread::sleep(WINDOW_LOOK),
        }
    };
    let wanted: Option<(u32, u32)> = args.size.map(Into::into);
    match (window, wanted) {
        (Some(window), Some(wanted)) if window.0 > wanted.0 || window.1 > wanted.1 => {
            say_as_program(format_args!("--size: the program's window has {}x{} pixels", window.0, window.1));
            window
        }
        (window, wanted) => wanted.or(window).unwrap_or(FrameSize::DEFAULT.into()),
    }
}

/// Connects the engine to the window's display and the movie, where there are any.
fn outlets(args: &Run, engine: &mut Engine) -> Result<Outlets, String> {
    let size = (engine.memory().width(), engine.memory().height());
    let display = wants_window(args).then(|| Display::new(size.0, size.1));
    let movie = args.movie.open(size.0, size.1, args.crt)?;
    let seen = display.clone().or_else(|| movie.is_some().then(|| Display::new(size.0, size.1)));
    if let Some(display) = &seen {
        engine.attach(DisplayObserver::new(display.clone()));
    }
    let is_alone = Arc::new(AtomicBool::new(display.is_none()));
    let sampler = match (&movie, seen) {
        (Some(movie), Some(display)) => movie.sample(display, Clock::Always, is_alone.clone()),
        _ => None,
    };
    Ok(Outlets { display, movie, sampler, is_alone })
}

/// Starts the render thread, and listens where that is asked for.
fn serve(args: &Run, engine: Engine) -> Result<Server, String> {
    let places: Vec<_> =
        args.serve.iter().map(|text| address::checked(text, args.allow_remote)).collect::<Result<_, _>>()?;
    let mut server = Server::start(engine).map_err(|e| format!("no thread to render on: {e}"))?;
    for place in places {
        let place = server.listen(ListenAddress::Tcp(place)).map_err(|e| e.to_string())?;
        say_as_program(format_args!("listening on {place}"));
    }
    Ok(server)
}

fn wants_window(args: &Run) -> bool {
    if cfg!(not(feature = "window")) && !args.headless {
        say_as_program("built without windows: going on headless");
    }
    cfg!(feature = "window") && !args.headless
}

impl Shared {
    /// Attends the program to its end.
    fn attend(
        self: Arc<Self>,
        args: &Run,
        Started { child, leash }: Started,
        outlets: Outlets,
        pictures: Pictures,
        (endings, ending): (Sender<Ending>, Receiver<Ending>),
    ) -> Status {
        let pid = Pid::from_child(&child);
        let (exits, exit) = bounded(1);
        let waits = wait_for(child, exits, endings.clone());
        let keeper = self.clone();
        let told = endings.clone();
        let ticks = std::thread::Builder::new().name("vsync".into()).spawn(move || keeper.keep(told));
        let (Ok(_), Ok(ticks)) = (waits, ticks) else {
            drop(leash);
            say_as_program("no thread for the vertical blanks");
            return Status::Failed;
        };
        let why = match &outlets.display {
            Some(display) => self.with_window(args, display, &outlets, endings, &ending),
            None => ending.recv().unwrap_or(Ending::Signal),
        };
        let (picture, status) = self.conclude(why, pid, leash, &exit);
        // Nothing is left, unless the starter was killed.
        family::end(if args.leave_daemons { Members::Session(pid) } else { Members::All });
        self.has_ended.store(true, Ordering::Release);
        // A panic there is reported by the thread itself.
        let _ = ticks.join();
        let picture = picture.or_else(|| self.last_picture());
        self.device.end();
        self.tell_refused();
        if let Some(line) = self.device.stores_outside() {
            say_as_program(line);
        }
        self.warn(&pictures);
        finish(outlets, &pictures, picture.as_deref(), status)
    }

    /// Ends the program if it still runs. Returns the picture of `--after`, if that was the reason,
    /// and the program's status.
    fn conclude(
        &self,
        why: Ending,
        starter: Pid,
        leash: Leash,
        exit: &Receiver<ExitStatus>,
    ) -> (Option<Box<VideoMemory>>, Status) {
        let picture = match why {
            Ending::Exited(status) => return (None, spawn::status_of(status)),
            Ending::Reached(moment, picture) => Some((moment, picture)),
            Ending::Signal => None,
            #[cfg(feature = "window")]
            Ending::WindowClosed => None,
        };
        drop(leash);
        // The starter gives up after twice that time.
        let status = exit.recv_timeout(3 * PATIENCE).or_else(|_| {
            let _ = kill_process(starter, Signal::KILL);
            exit.recv_timeout(PATIENCE)
        });
        let own = match status {
            Ok(status) => spawn::status_of(status),
            // It cannot be killed, as while it waits for a device.
            Err(_) => Status::Failed,
        };
        match picture {
            Some((Moment::After, picture)) => (Some(picture), Status::Success),
            Some((Moment::Limit, picture)) => {
                say_as_program("the program did not end by itself: the limit of its time has ended it");
                (Some(picture), Status::Program(TIMED_OUT))
            }
            None => (None, own),
        }
    }

    /// Keeps the vertical blanks until the run has ended.
    fn keep(self: Arc<Self>, endings: Sender<Ending>) {
        let (started, mut blank) = (Instant::now(), 0u64);
        while !self.has_ended.load(Ordering::Acquire) {
            blank += 1;
            let hz = u64::from(self.hz);
            let due = started + Duration::new(blank / hz, (blank % hz * 1_000_000_000 / hz) as u32);
            let now = Instant::now();
            match due.checked_duration_since(now) {
                Some(rest) => std::thread::sleep(rest),
                // Blanks that were missed do not come later.
                None => blank += ((now - due).as_secs_f64() * f64::from(self.hz)) as u64,
            }
            self.device.take_attributes();
            let shared = self.clone();
            let moment = Arc::new(Mutex::new(Moment::After));
            let come = moment.clone();
            let decide = move |is_changed, is_half| {
                let has_come = shared.has_come(is_changed, is_half);
                has_come.inspect(|m| *come.lock().unwrap_or_else(PoisonError::into_inner) = *m).is_some()
            };
            let Some((is_changed, picture)) = self.blank(decide) else { return };
            let is_replayed = self.lock_input().pass_on(&self.device, is_changed, Instant::now());
            self.is_replayed.store(is_replayed, Ordering::Release);
            if let Some(picture) = picture {
                let moment = *moment.lock().unwrap_or_else(PoisonError::into_inner);
                let _ = endings.try_send(Ending::Reached(moment, picture));
            }
            self.tell_refused();
        }
    }

    fn tell_refused(&self) {
        self.told.lock().unwrap_or_else(PoisonError::into_inner).tell(&self.device, self.is_verbose);
    }

    fn lock_input(&self) -> std::sync::MutexGuard<'_, Input> {
        self.input.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Returns the moment that has come, once. That of `--after` comes later for a picture that is
    /// half of one, unless its program draws on and on.
    fn has_come(&self, is_changed: bool, is_half: bool) -> Option<Moment> {
        let mut countdown = self.countdown.lock().unwrap_or_else(PoisonError::into_inner);
        // Before the device is open, the frame is nobody's.
        let is_changed = is_changed && self.device.opens() > 0;
        let is_replayed = self.is_replayed.load(Ordering::Acquire);
        let moment = countdown.as_mut().and_then(|c| c.note(is_changed, is_replayed, Instant::now()))?;
        let mut due = self.due.lock().unwrap_or_else(PoisonError::into_inner);
        if is_half && due.get_or_insert_with(Instant::now).elapsed() < HALF_PATIENCE {
            self.device.ask_for_pause();
            return None;
        }
        *countdown = None;
        Some(moment)
    }

    /// One vertical blank: the render thread converts what has changed. Returns whether anything
    /// has, and the picture if `decide` wants it, which is told whether anything has changed and
    /// whether the program was drawing. `None` if the render thread has ended.
    fn blank(
        self: &Arc<Self>,
        decide: impl FnOnce(bool, bool) -> bool + Send + 'static,
    ) -> Option<(bool, Option<Box<VideoMemory>>)> {
        let (done, outcome) = bounded(1);
        let shared = self.clone();
        self.server.thread().run_between(move |engine| {
            let mut scan_out = shared.scan_out.lock().unwrap_or_else(PoisonError::into_inner);
            let is_half = shared.device.is_drawing();
            let is_changed =
                engine.write_frame(|memory| scan_out.update(&shared.device, memory)).unwrap_or(false);
            shared.device.vsync();
            let picture = decide(is_changed, is_half).then(|| Box::new(engine.memory().clone()));
            // Without a receiver the run has ended.
            let _ = done.send((is_changed, picture));
        });
        outcome.recv().ok()
    }

    /// Returns the frame after the program's end.
    fn last_picture(self: &Arc<Self>) -> Option<Box<VideoMemory>> {
        self.blank(|_, _| true).and_then(|(_, picture)| picture)
    }

    /// Says why there is no picture, where one was asked for.
    fn warn(&self, pictures: &Pictures) {
        if self.device.loads() == 0 {
            say_as_program("the program has not loaded the preload library, so it had no framebuffer");
        } else if pictures.are_wanted() && self.device.opens() == 0 && self.device.window().is_some() {
            say_as_program("the program has shown no picture of its own: the picture is black");
        } else if pictures.are_wanted() && self.device.opens() == 0 {
            say_as_program("the program has not opened /dev/fb0: the picture is black");
        }
    }

    /// Shows the window on this thread until it is closed or the run ends for another reason.
    #[cfg(feature = "window")]
    fn with_window(
        &self,
        args: &Run,
        display: &Arc<Display>,
        outlets: &Outlets,
        endings: Sender<Ending>,
        ending: &Receiver<Ending>,
    ) -> Ending {
        let (watched, seen) = (display.clone(), ending.clone());
        let watcher = std::thread::spawn(move || {
            let why = seen.recv().unwrap_or(Ending::Signal);
            watched.leave();
            why
        });
        let name = args.program.first().map_or_else(String::new, |name| name.display().to_string());
        let options = crate::window::Options {
            title: format!("fbptr run {name}"),
            crt: args.crt.in_window(),
            saves_crt: args.crt.in_files(),
            ..Default::default()
        };
        if let Err(e) = super::super::main_thread::show(display.clone(), options) {
            say_as_program(format_args!("{e}: going on headless"));
            match outlets.movie {
                // The movie goes on in the window's place.
                Some(_) => outlets.is_alone.store(true, Ordering::Release),
                None => self.server.thread().drop_display(),
            }
        } else {
            let _ = endings.try_send(Ending::WindowClosed);
        }
        watcher.join().unwrap_or(Ending::Signal)
    }

    #[cfg(not(feature = "window"))]
    fn with_window(
        &self,
        _: &Run,
        _: &Arc<Display>,
        _: &Outlets,
        _: Sender<Ending>,
        ending: &Receiver<Ending>,
    ) -> Ending {
        ending.recv().unwrap_or(Ending::Signal)
    }
}

/// Waits for the program on a thread of its own, and tells both receivers.
fn wait_for(
    mut child: Child,
    exits: Sender<ExitStatus>,
    endings: Sender<Ending>,
) -> std::io::Result<std::thread::JoinHandle<()>> {
    std::thread::Builder::new().name("program".into()).spawn(move || {
        if let Ok(status) = child.wait() {
            let _ = exits.try_send(status);
            let _ = endings.send(Ending::Exited(status));
        }
    })
}

/// Writes and compares what was asked for, and returns the exit status.
fn finish(outlets: Outlets, pictures: &Pictures, picture: Option<&VideoMemory>, status: Status) -> Status {
    let Outlets { movie, sampler, .. } = outlets;
    drop(sampler);
    let Some(picture) = picture else {
        say_as_program("the render thread has ended early");
        return Status::Failed;
    };
    let mut is_saved = true;
    if let Some(e) = movie.and_then(|movie| movie.finish(picture).err()) {
        say_as_program(format_args!("the movie ends early: {e}"));
        is_saved = false;
    }
    let is_equal = pictures.take(picture).unwrap_or_else(|e| {
        say_as_program(e);
        is_saved = false;
        None
    });
    match (is_saved, is_equal) {
        (false, _) | (true, Some(false)) => Status::Failed,
        (true, Some(true)) => {
            if !matches!(status, Status::Success | Status::Program(0)) {
                say_as_program(format_args!(
                    "the picture is equal; the program itself ended with {status:?}"
                ));
            }
            Status::Success
        }
        (true, None) => status,
    }
}
