//! `fbptr tour`: the built-in tour in a window, or its last page and a movie of all without one.

use super::{Status, say_as_program};
use crate::executor::Executor;
use crate::pipeline::Renderer;
use crate::save::{self, Movie, MovieFormat, SaveError, SnapshotFormat};
use crate::server::{Engine, Limits, worker_pool};
use crate::viewer::{FRAMES_PER_SECOND, MOVIE_FRAMES_PER_SECOND, Model, TOUR_SIZE, Viewer, ViewerOptions};
use clap::Args;
use std::path::PathBuf;
use std::sync::Arc;

/// See from one pixel to four dimensions in short steps, each beside the commands that draw it.
#[derive(Debug, Args)]
pub struct Tour {
    /// Open no window: save the last page and a movie of all steps
    #[arg(long)]
    headless: bool,
    /// Show the tour as a cathode ray tube does; K changes it. Files never have that look
    #[arg(long, conflicts_with = "headless")]
    crt: bool,
    /// The last page, without a window: .png, .ppm or .raw
    #[arg(long, value_name = "OUT", default_value = "tour.png")]
    snap: PathBuf,
    /// The movie, without a window: .gif, .apng, .y4m, .png (numbered), or - for y4m on standard
    /// output
    #[arg(long, value_name = "OUT", default_value = "tour.gif")]
    movie: PathBuf,
    /// End after so many frames, 50 a second
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    frames: Option<u64>,
}

impl Default for Tour {
    fn default() -> Self {
        Tour { headless: false, crt: false, snap: "tour.png".into(), movie: "tour.gif".into(), frames: None }
    }
}

impl Tour {
    /// Shows the tour until the window is closed, or saves it. Returns the exit status.
    pub(super) fn run(self) -> Status {
        match self.show() {
            Ok(()) => Status::Success,
            Err(Refusal::Arguments(message)) => {
                say_as_program(message);
                Status::BadArguments
            }
            Err(Refusal::Failed(message)) => {
                say_as_program(message);
                Status::Failed
            }
        }
    }

    fn show(&self) -> Result<(), Refusal> {
        let bad = |e: SaveError| Refusal::Arguments(e.to_string());
        SnapshotFormat::of_path(&self.snap).map_err(bad)?;
        MovieFormat::of_path(&self.movie).map_err(bad)?;
        let options = ViewerOptions {
            name: "tour".to_owned(),
            size: TOUR_SIZE,
            time: 0.0,
            fps: FRAMES_PER_SECOND,
            cull: None,
            point_size: None,
            studio: false,
            turntable: false,
            split: None,
            renderer: Renderer::default(),
            pool: Executor::of_pool(worker_pool(None)),
        };
        let mut viewer = Viewer::new(Model::Tour(Arc::new(engine)), options).map_err(Refusal::Failed)?;
        if !self.headless {
            match self.in_window(&mut viewer) {
                Ok(()) => return Ok(()),
                Err(why) => say_as_program(format_args!("{why}: saving the tour instead")),
            }
        }
        self.save(&mut viewer)
    }

    /// Saves the last page, and a movie of all steps.
    fn save(&self, viewer: &mut Viewer) -> Result<(), Refusal> {
        let failed = |e: SaveError| Refusal::Failed(e.to_string());
        let end = self.frames.unwrap_or(u64::MAX);
        let frames: Vec<u64> = viewer.tour_movie_frames().into_iter().filter(|&frame| frame < end).collect();
        let [width, height] = TOUR_SIZE;
        let mut movie = Movie::create(&self.movie, width, height, MOVIE_FRAMES_PER_SECOND).map_err(failed)?;
        let mut progress = super::progress::Progress::new("frames", frames.len() as u64);
        for frame in frames {
            viewer.go_to(frame);
            viewer.refresh();
            if let Some(failure) = viewer.failure() {
                return Err(Refusal::Failed(failure.to_owned()));
            }
            match movie.push(viewer.shown()) {
                // Whoever reads the movie from a pipe has seen enough.
                Err(SaveError::Io { kind: std::io::ErrorKind::BrokenPipe, .. }) => break,
                pushed => pushed.map_err(failed)?,
            }
            progress.advance(1);
        }
        if let Some(frames) = self.frames {
            viewer.go_to(frames - 1);
            viewer.refresh();
        }
        save::to_path(viewer.shown(), &self.snap).map_err(failed)?;
        say_as_program(format_args!("saved {} and {}", self.snap.display(), self.movie.display()));
        Ok(())
    }

    #[cfg(not(feature = "window"))]
    fn in_window(&self, _: &mut Viewer) -> Result<(), String> {
        Err("built without windows".to_owned())
    }

    #[cfg(feature = "window")]
    fn in_window(&self, viewer: &mut Viewer) -> Result<(), String> {
        let seconds = |frames: u64| (frames as f64 / FRAMES_PER_SECOND).min(1e9);
        let mut options = crate::window::ViewerOptions {
            title: "fbptr: a framebuffer you can point at".to_owned(),
            crt: self.crt,
            is_smooth: false,
            save_dir: ".".into(),
            movie: None,
            ends_after: self.frames.map(|n| std::time::Duration::from_secs_f64(seconds(n))),
            on_picture: Box::new(|_, _| false),
            reload: Box::new(|| None),
        };
        crate::window::run_viewer(viewer, &mut options).map_err(|e| e.to_string())
    }
}

/// Reason why the tour was not shown or saved.
enum Refusal {
    /// The arguments are invalid.
    Arguments(String),
    /// A page or a file could not be made.
    Failed(String),
}

/// Creates the engine of a step.
fn engine([width, height]: [u32; 2]) -> Result<Engine, String> {
    Engine::with_limits(width, height, Limits::default()).map_err(|e| e.message)
}
