//! `fbptr view`: interactive views of a file in a window, or some of its frames without one.

use super::frame_clock::FrameClock;
use super::mesh_args::MeshArgs;
use super::play::{open_stream, size_of_stream};
use super::render_args::RenderArgs;
use super::scene_file::{self, ReadOptions, SceneError, Watch};
use super::view_web::ViewerPage;
use super::web::WebArgs;
use super::{FrameSize, Status, check_picture, say_as_program, signals};
use crate::executor::Executor;
use crate::load::SandboxDir;
use crate::save::{self, Movie, MovieFormat};
use crate::server::{Engine, Limits, Notice, worker_pool};
use crate::viewer::{Model, Split, Viewer, ViewerOptions, help_lines};
use clap::{Args, ValueEnum};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Time between two looks at keys and clock without a window.
const BROWSER_TICK: Duration = Duration::from_millis(3);
/// Time between two checks of the file without a window.
const WATCH_EVERY: Duration = Duration::from_millis(250);

/// Look at a mesh, a scene or a stream from everywhere.
#[derive(Debug, Args)]
pub struct ViewArgs {
    /// File to look at: .gltf, .glb, .x3d, .x3dz, .x3dv, .wrl, .obj, .stl, .ply, .json for N dimensions, anything
    /// else is a stream of commands; or a built-in model, as teapot
    #[arg(value_name = "FILE", required_unless_present = "list")]
    file: Option<PathBuf>,
    /// Print the names of the built-in models
    #[arg(long, exclusive = true)]
    list: bool,
    /// The frame's size [default: 640x480, or what fits an N-dimensional screen]
    #[arg(long, value_name = "WxH")]
    size: Option<FrameSize>,
    /// Seconds since the scene's start
    #[arg(long, value_name = "T", value_parser = super::render::finite, default_value = "0", allow_negative_numbers = true)]
    time: f64,
    /// Frames a second [default: 60 in a window; 25 with --headless, --snap or --movie]
    #[arg(long, value_name = "F", value_parser = super::render::positive)]
    fps: Option<f64>,
    /// End after so many frames; without a window, draw so many [default there: 1]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    frames: Option<u64>,
    /// Open no window
    #[arg(long)]
    headless: bool,
    /// Print how long the frames took to draw, from the second one on: their number, median, 99th percentile and longest
    #[arg(long, requires = "headless")]
    frame_times: bool,
    /// Frame and light models, put them on a ground, and smooth what is at rest: on or off
    /// [default: on in a window, off with --headless, --snap or --movie]
    #[arg(long, value_name = "on|off", value_parser = on_or_off)]
    studio: Option<bool>,
    /// Let the model turn, once in 12 seconds; T stops it
    #[arg(long)]
    turntable: bool,
    /// Show two modes side by side, and their difference magnified; V goes on to the next two
    #[arg(long, value_name = "MODES", value_enum)]
    split: Option<SplitArg>,
    /// Show the picture as a cathode ray tube does; K changes it. Files never have that look
    #[arg(long, conflicts_with = "headless")]
    crt: bool,
    /// Write the last frame: .png, .ppm or .raw
    #[arg(long, value_name = "OUT")]
    snap: Option<PathBuf>,
    /// Write every frame: .gif, .apng, .y4m, .png (numbered), or - for y4m on standard output
    #[arg(long, value_name = "OUT")]
    movie: Option<PathBuf>,
    /// Folder that F9, F12 and J save to
    #[arg(long, value_name = "DIR", default_value = ".")]
    save_dir: PathBuf,
    /// Let a scene read files from this folder, not only from its own
    #[arg(long, value_name = "DIR")]
    root: Option<PathBuf>,
    /// Let a stream's LOAD read files from this folder
    #[arg(long, value_name = "DIR")]
    load_dir: Option<PathBuf>,
    /// Let --web take an address that other machines reach
    #[arg(long)]
    allow_remote: bool,
    #[command(flatten)]
    web: WebArgs,
    #[command(flatten)]
    meshes: MeshArgs,
    #[command(flatten)]
    drawing: RenderArgs,
}

/// Returns the list of all keys, for the end of `--help` and the man page.
pub(super) fn keys_help() -> String {
    let keys = |is_nd| help_lines(is_nd).into_iter().map(|l| format!("  {l}\n")).collect::<String>();
    format!("Keys:\n{}\nKeys for N dimensions:\n{}", keys(false), keys(true))
}

impl ViewArgs {
    /// Shows the file until the window is closed, and returns the exit status.
    pub(super) fn run(self) -> Status {
        if self.list {
            return scene_file::list_models();
        }
        match self.view() {
            Ok(status) => status,
            Err(error) => error.say(),
        }
    }

    /// Returns whether the bytes of the pictures are kept, for other programs to compare.
    fn keeps_bytes(&self) -> bool {
        (self.headless && !self.web.is_wanted()) || self.snap.is_some() || self.movie.is_some()
    }

    fn file(&self) -> &Path {
        self.file.as_deref().unwrap_or(Path::new(""))
    }

    fn is_studio(&self) -> bool {
        self.studio.unwrap_or(!self.keeps_bytes())
    }

    fn fps(&self) -> f64 {
        self.fps.unwrap_or(if self.keeps_bytes() { 25.0 } else { 60.0 })
    }

    fn view(&self) -> Result<Status, SceneError> {
        let bad = SceneError::NoFile;
        if let Some(snap) = &self.snap {
            check_picture(snap).map_err(bad)?;
        }
        if let Some(path) = &self.movie {
            MovieFormat::of_path(path).map_err(|e| bad(e.to_string()))?;
        }
        if !self.save_dir.is_dir() {
            return Err(bad(format!("--save-dir {}: there is no such folder", self.save_dir.display())));
        }
        if self.frame_times && self.web.is_wanted() {
            return Err(bad("--frame-times and --web: browsers set the pace of frames".to_owned()));
        }
        let web = self.web.prepare(self.allow_remote).map_err(bad)?;
        let budget = self.drawing.budget();
        let mut watch = Watch::new(&self.drawing.reading_budget(&budget));
        let model = self.read(&mut watch, None)?;
        self.check_for(&model)?;
        let [width, height] =
            match self.size.map_or_else(|| self.stated_size(&model), |size| Ok(Some(size)))? {
                Some(FrameSize { width, height }) => [width, height],
                None => Viewer::frame_size(&model, self.is_studio()),
            };
        Limits::default().check_frame(width, height).map_err(|e| bad(e.message))?;
        let model = match model {
            // The stream's engine needs the frame's size, which depends on the model.
            Model::Stream(..) => self.read(&mut watch, Some([width, height]))?,
            model => model,
        };
        let movie = match &self.movie {
            Some(path) => {
                Some(Movie::create(path, width, height, self.fps()).map_err(|e| bad(e.to_string()))?)
            }
            None => None,
        };
        let name = self.file().file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
        let options = ViewerOptions {
            name,
            size: [width, height],
            time: self.time,
            fps: self.fps(),
            cull: self.meshes.cull,
            point_size: self.meshes.point_size,
            studio: self.is_studio(),
            turntable: self.turntable,
            split: self.split.map(SplitArg::split),
            renderer: self.drawing.renderer_within(&budget),
            pool: Executor::of_pool(worker_pool(None)),
        };
        let refused = |e: String| SceneError::Refused(format!("{}: {e}", self.file().display()));
        let mut viewer = Viewer::new(model, options).map_err(refused)?;
        let page = web.map(|web| ViewerPage::start(web, &viewer)).transpose().map_err(bad)?;
        let is_shown = self.show(&mut viewer, movie, watch, page)?;
        let (name, notices) = (self.file().display().to_string(), viewer.take_notices());
        notices.iter().for_each(|notice| say_as_program(notice.play_line(&name)));
        let is_refused = notices.iter().any(|notice| matches!(notice, Notice::Refused(_)));
        if let Some(path) = &self.snap {
            save::to_path(viewer.shown(), path).map_err(|e| SceneError::Refused(e.to_string()))?;
        }
        Ok(if is_shown && !is_refused { Status::Success } else { Status::Failed })
    }

    /// Reads the file as a model for the viewer.
    fn read(&self, watch: &mut Watch, size: Option<[u32; 2]>) -> Result<Model, SceneError> {
        if scene_file::is_scene(self.file())? {
            let options = ReadOptions { root: self.root.as_deref(), meshes: &self.meshes };
            let loaded = scene_file::read_watched(self.file(), options, watch)?;
            watch.hold(loaded.held);
            return Ok(Model::from(loaded.file));
        }
        let name = self.file().display().to_string();
        let no_file = |e: std::io::Error| SceneError::NoFile(format!("{name}: {e}"));
        watch.begin(self.file());
        let (mut file, _) = open_stream(self.file(), &name).map_err(SceneError::NoFile)?;
        let mut bytes = Vec::new();
        std::io::Read::read_to_end(&mut file, &mut bytes).map_err(no_file)?;
        let bytes: Arc<[u8]> = bytes.into();
        let [width, height] = size.unwrap_or([640, 480]);
        let (load_dir, drawing) = (self.load_dir.clone(), self.drawing.clone());
        let renderer = drawing.renderer();
        let make = move || {
            let limits = Limits { memory_bytes: drawing.memory_bytes(), ..Limits::default() };
            let limits = limits.for_frame(width, height);
            let mut engine = Engine::with_limits(width, height, limits).map_err(|e| e.message)?;
            engine.take_size();
            engine.set_renderer(crate::pipeline::Renderer::new(renderer.options().clone()));
            if let Some(path) = &load_dir {
                engine.set_load_dir(SandboxDir::open(path).map_err(|e| format!("{}: {e}", path.display()))?);
            }
            Ok(engine)
        };
        Ok(Model::Stream(bytes, Arc::new(make)))
    }

    /// Checks that no argument is for a file of another kind.
    fn check_for(&self, model: &Model) -> Result<(), SceneError> {
        let (kind, flags) = match model {
            Model::Stream(..) => (
                "a stream of commands",
                &[
                    ("--smooth", self.meshes.smooth.is_some()),
                    ("--cull", self.meshes.cull.is_some()),
                    ("--point-size", self.meshes.point_size.is_some()),
                    ("--texture", self.meshes.texture.is_some()),
                    ("--strict", self.meshes.strict),
                    ("--dialect", self.meshes.dialect.is_some()),
                    ("--camera", self.meshes.camera.is_some()),
                    ("--root", self.root.is_some()),
                    ("--time", self.time != 0.0),
                    ("--studio on", self.studio == Some(true)),
                    ("--turntable", self.turntable),
                ][..],
            ),
            Model::Eye(_) => (
                "a scene of N dimensions",
                &[
                    ("--load-dir", self.load_dir.is_some()),
                    ("--cull", self.meshes.cull.is_some()),
                    ("--point-size", self.meshes.point_size.is_some()),
                    ("--split", self.split.is_some()),
                ][..],
            ),
            _ => ("no stream of commands", &[("--load-dir", self.load_dir.is_some())][..]),
        };
        match flags.iter().find(|(_, is_given)| *is_given) {
            None => Ok(()),
            Some((flag, _)) => {
                let file = self.file().display();
                Err(SceneError::NoFile(format!("{flag} does nothing here: {file} is {kind}")))
            }
        }
    }

    /// Returns the frame size that a stream states, as `play` takes it.
    fn stated_size(&self, model: &Model) -> Result<Option<FrameSize>, SceneError> {
        let Model::Stream(bytes, _) = model else { return Ok(None) };
        size_of_stream(bytes).map_err(|e| SceneError::NoFile(format!("{}: {e}", self.file().display())))
    }

    /// Shows the viewer in a window, in the browser, or draws its frames without one. Returns whether
    /// all was drawn and written.
    fn show(
        &self,
        viewer: &mut Viewer,
        movie: Option<Movie>,
        watch: Watch,
        page: Option<ViewerPage>,
    ) -> Result<bool, SceneError> {
        let (movie, watch, page) = match self.headless {
            true => (movie, watch, page),
            false => match self.in_window(viewer, movie, watch, page) {
                Ok(()) => return Ok(true),
                Err(unused) => {
                    let NoWindow { message, movie, watch, page } = *unused;
                    let keeps = movie.is_some() || self.snap.is_some() || page.is_some();
                    let next = if keeps { "" } else { "; --snap FILE or --movie FILE keeps what is drawn" };
                    say_as_program(format_args!("{message}: going on headless{next}"));
                    (movie, watch, page)
                }
            },
        };
        match page {
            Some(page) => self.in_browser(viewer, movie, watch, page),
            None => self.without_window(viewer, movie),
        }
    }

    /// Shows the viewer in the browser, until Ctrl-C or its key Q, or for the time of --frames.
    fn in_browser(
        &self,
        viewer: &mut Viewer,
        mut movie: Option<Movie>,
        mut watch: Watch,
        mut page: ViewerPage,
    ) -> Result<bool, SceneError> {
        let ends = Arc::new(AtomicBool::new(false));
        let told = ends.clone();
        signals::watch(move || told.store(true, Ordering::Release)).map_err(SceneError::Refused)?;
        let size = [viewer.shown().width(), viewer.shown().height()];
        let begun = Instant::now();
        let (mut last, mut watched) = (begun, begun);
        let is_over = |begun: Instant| self.run_time().is_some_and(|time| begun.elapsed() >= time);
        while !ends.load(Ordering::Acquire) && !is_over(begun) {
            if watched.elapsed() >= WATCH_EVERY {
                watched = Instant::now();
                match self.reload(&mut watch, size) {
                    Some(Ok(model)) => viewer.reload(model),
                    Some(Err(message)) => say_as_program(message),
                    None => {}
                }
            }
            let now = Instant::now();
            viewer.advance(now - std::mem::replace(&mut last, now));
            let is_new = viewer.refresh();
            if page.step(viewer, is_new) {
                break;
            }
            if let Some(movie) = &mut movie {
                let due = (begun.elapsed().as_secs_f64() * self.fps()) as u64 + 1;
                while movie.frames() < due {
                    movie.push(viewer.shown()).map_err(|e| SceneError::Refused(e.to_string()))?;
                }
            }
            if !viewer.has_more_to_smooth() {
                std::thread::sleep(BROWSER_TICK);
            }
        }
        Ok(true)
    }

    /// Returns the time of --frames.
    fn run_time(&self) -> Option<Duration> {
        self.frames.map(|n| Duration::from_secs_f64((n as f64 / self.fps()).min(1e9)))
    }

    /// Reads the file again if it has changed.
    fn reload(&self, watch: &mut Watch, size: [u32; 2]) -> Option<Result<Model, String>> {
        watch.has_changed().then(|| {
            self.read(watch, Some(size)).map_err(|e| match e {
                SceneError::NoFile(message) | SceneError::Refused(message) => message,
            })
        })
    }

    /// Draws the frames without a window. Returns whether all could be drawn.
    fn without_window(&self, viewer: &mut Viewer, mut movie: Option<Movie>) -> Result<bool, SceneError> {
        let frames = self.frames.unwrap_or(1);
        let mut progress = super::progress::Progress::new("frames", frames);
        let mut clock = FrameClock::start();
        for i in 0..frames {
            clock.begin_frame();
            if i > 0 {
                viewer.step(1);
            }
            let is_new = viewer.refresh();
            viewer.finish_smoothing();
            // The first picture was drawn when the file was opened; a still one is not drawn again.
            if i > 0 && is_new {
                clock.end_frame();
            }
            if let Some(failure) = viewer.failure() {
                say_as_program(format_args!("{}: {failure}", self.file().display()));
                return Ok(false);
            }
            if let Some(movie) = &mut movie {
                movie.push(viewer.shown()).map_err(|e| SceneError::Refused(e.to_string()))?;
            }
            progress.advance(1);
        }
        drop(progress);
        if self.frame_times {
            clock.report();
        }
        Ok(true)
    }

    #[cfg(not(feature = "window"))]
    fn in_window(
        &self,
        _: &mut Viewer,
        movie: Option<Movie>,
        watch: Watch,
        page: Option<ViewerPage>,
    ) -> Result<(), Box<NoWindow>> {
        Err(Box::new(NoWindow { message: "built without windows".to_owned(), movie, watch, page }))
    }

    #[cfg(feature = "window")]
    fn in_window(
        &self,
        viewer: &mut Viewer,
        movie: Option<Movie>,
        mut watch: Watch,
        mut page: Option<ViewerPage>,
    ) -> Result<(), Box<NoWindow>> {
        let size = [viewer.shown().width(), viewer.shown().height()];
        let mut options = crate::window::ViewerOptions {
            title: format!("fbptr view {}", self.file().display()),
            crt: self.crt,
            is_smooth: self.is_studio(),
            save_dir: self.save_dir.clone(),
            movie: movie.map(|movie| (movie, self.fps())),
            ends_after: self.run_time(),
            on_picture: Box::new(|viewer, is_new| {
                page.as_mut().is_some_and(|page| page.step(viewer, is_new))
            }),
            reload: Box::new(|| self.reload(&mut watch, size)),
        };
        let shown = crate::window::run_viewer(viewer, &mut options);
        let movie = options.movie.take().map(|(movie, _)| movie);
        drop(options);
        shown.map_err(|e| Box::new(NoWindow { message: e.to_string(), movie, watch, page }))
    }
}

/// Two modes to compare.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum SplitArg {
    /// Gouraud and Phong shading
    Shading,
    /// The exact path and the fast one
    Path,
    /// Depth in f32 and in u16
    Depth,
}

impl SplitArg {
    fn split(self) -> Split {
        match self {
            SplitArg::Shading => Split::Shading,
            SplitArg::Path => Split::Path,
            SplitArg::Depth => Split::Depth,
        }
    }
}

fn on_or_off(text: &str) -> Result<bool, String> {
    match text {
        "on" => Ok(true),
        "off" => Ok(false),
        _ => Err("expected on or off".to_owned()),
    }
}

/// Reason for the lack of a window, and what it has not used.
struct NoWindow {
    message: String,
    movie: Option<Movie>,
    watch: Watch,
    page: Option<ViewerPage>,
}
