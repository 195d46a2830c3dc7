//! Streams of commands in the viewer: played again with the viewer's view overrides, up to the frame that is shown.
//!
//! A frame is what stands at a `PRESENT`; a stream without one is one frame. Where the overrides change, or time goes back, the
//! stream is played from its beginning on a fresh engine, so that every picture is what playing it would give.

use super::Wishes;
use super::difference::{Difference, Work};
use super::frame::ViewerFrame;
use crate::command::{Command, EndOfInput};
use crate::pipeline::{RenderOptions, RenderPath, Renderer};
use crate::scene::{Camera, QualityUse, ViewOverrides};
use crate::server::{
    Audience, Budget, CommandError, Engine, Notice, Output, Pace, Session, Stream, StreamState,
};
use std::sync::Arc;

/// Makes the engine that a stream is played on.
pub type MakeEngine = Arc<dyn Fn() -> Result<Engine, String> + Send + Sync>;

/// A stream, and how far it was played.
pub(super) struct Replay {
    bytes: Arc<[u8]>,
    make_engine: MakeEngine,
    playing: Option<Playing>,
    /// Errors of the first playing, until they are told.
    errors: Vec<CommandError>,
    /// How many were told already: each playing meets the same ones.
    reported: usize,
    /// The number of the last frame, once the end was seen.
    last_frame: Option<u64>,
}

/// A stream on its engine.
struct Playing {
    engine: Engine,
    stream: Stream,
    view_overrides: ViewOverrides,
    used: usize,
    has_ended: bool,
    errors: Vec<CommandError>,
}

impl Playing {
    fn new(
        make_engine: &MakeEngine,
        view_overrides: ViewOverrides,
        path: RenderPath,
    ) -> Result<Self, String> {
        let mut engine = make_engine()?;
        if path == RenderPath::Plain {
            engine.set_renderer(Renderer::new(RenderOptions { path, ..RenderOptions::default() }));
        }
        engine.set_view_overrides(view_overrides);
        engine.open(1);
        let stream = Stream::new(&engine, 1, Audience::Owner);
        Ok(Playing { engine, stream, view_overrides, used: 0, has_ended: false, errors: Vec::new() })
    }

    /// Plays on until so many frames were presented, or to the end.
    fn play_to(&mut self, bytes: &[u8], frames: u64) {
        let budget = Budget { pace: Pace::OneFrame, ..Budget::NONE };
        let mut out = Output::default();
        while !self.has_ended && self.engine.frames() < frames {
            let state = match self.used < bytes.len() {
                true => {
                    let (taken, state) =
                        self.stream.feed(&mut self.engine, &bytes[self.used..], &mut out, budget);
                    self.used += taken;
                    state
                }
                false => self.stream.finish(&mut self.engine, EndOfInput::File, &mut out),
            };
            self.has_ended = state == StreamState::Ended;
            // Nobody reads replies here.
            out.replies.clear();
            for notice in out.notices.drain(..) {
                if let Notice::Refused(refused) = notice {
                    self.errors.push(refused);
                }
            }
        }
    }

    /// One line of reply to a question from outside of the stream.
    fn ask(&mut self, command: Command) -> String {
        let (mut session, mut reply) = (Session::new(2, Audience::Owner), Vec::new());
        match self.engine.run(&mut session, command, &mut reply) {
            Ok(_) => String::from_utf8_lossy(&reply).trim_end().to_owned(),
            Err(fault) => fault.message,
        }
    }
}

impl Replay {
    pub fn new(bytes: Arc<[u8]>, make_engine: MakeEngine) -> Self {
        Replay { bytes, make_engine, playing: None, errors: Vec::new(), reported: 0, last_frame: None }
    }

    /// What was refused, once.
    pub fn take_errors(&mut self) -> Vec<CommandError> {
        std::mem::take(&mut self.errors)
    }

    /// Whether anything was presented. Known once a frame was drawn.
    pub fn is_animated(&self) -> bool {
        self.playing.as_ref().is_some_and(|p| p.engine.frames() > 0)
    }

    /// The number of the last frame, once the end was seen.
    pub fn last_frame(&self) -> Option<u64> {
        self.last_frame
    }

    /// The camera of the stream as it stands, as its author has it.
    pub fn given_camera(&self) -> Camera {
        self.playing.as_ref().map_or_else(Camera::default, |p| p.stream.session().camera)
    }

    /// Whether anything of three dimensions was drawn.
    pub fn is_spatial(&mut self) -> bool {
        let stats = self.playing.as_mut().map(|p| p.ask(Command::Stats)).unwrap_or_default();
        !stats.split_whitespace().any(|word| word == "plan=-")
    }

    /// Draws frame number `wishes.frame`, from 0.
    pub fn draw(&mut self, wishes: &Wishes, frame: &mut ViewerFrame) -> Result<(), String> {
        let (view_overrides, requested) = (wishes.view_overrides(), wishes.frame + 1);
        // What was drawn after the last PRESENT is not taken back.
        let is_before = |p: &Playing| p.engine.frames() < requested + u64::from(!p.has_ended);
        let fits = |p: &Playing| p.view_overrides == view_overrides && is_before(p);
        let mut playing = match self.playing.take().filter(fits) {
            Some(playing) => playing,
            None => Playing::new(&self.make_engine, view_overrides, RenderPath::Fast)?,
        };
        playing.play_to(&self.bytes, requested);
        if playing.has_ended {
            // What stands after the last PRESENT is a frame too.
            self.last_frame = Some(playing.engine.frames());
        }
        self.errors.extend(playing.errors.iter().skip(self.reported).cloned());
        self.reported = self.reported.max(playing.errors.len());
        frame.memory.bytes_mut().copy_from_slice(playing.engine.memory().bytes());
        frame.depth = playing.engine.depth().cloned();
        self.playing = Some(playing);
        Ok(())
    }

    pub fn plan(&mut self) -> Vec<String> {
        let stats = self.playing.as_mut().map(|p| p.ask(Command::Stats)).unwrap_or_default();
        let requested = ["plan=", "memory_bytes=", "depth_bytes=", "id_bytes=", "shared_bytes=", "presents="];
        let found = stats.split_whitespace().filter(|word| requested.iter().any(|w| word.starts_with(w)));
        // `plan=` holds several, with commas between and colons inside.
        let words = found.flat_map(|word| word.trim_start_matches("plan=").split(','));
        words.map(|word| word.replace(['=', ':'], " ")).collect()
    }

    pub fn inspect(&mut self, x: i32, y: i32) -> Vec<String> {
        let Some(playing) = &mut self.playing else { return Vec::new() };
        let depth = playing.ask(Command::DepthAt { x, y });
        let pick = playing.ask(Command::Pick { x, y });
        let tail =
            |line: &str, words: usize| line.split_whitespace().skip(words).collect::<Vec<_>>().join(" ");
        vec![format!("depth {}", tail(&depth, 3)), format!("pick {}", tail(&pick, 3))]
    }

    /// What works out the difference to the picture of the plain path.
    pub fn exact(&self, wishes: &Wishes, frame: &ViewerFrame) -> Work {
        let (bytes, make_engine) = (Arc::clone(&self.bytes), Arc::clone(&self.make_engine));
        let view_overrides = ViewOverrides { quality: QualityUse::Exact, ..wishes.view_overrides() };
        let (requested, found) = (wishes.frame + 1, frame.memory.bytes().to_vec());
        Box::new(move || {
            let mut playing = Playing::new(&make_engine, view_overrides, RenderPath::Plain)?;
            playing.play_to(&bytes, requested);
            Ok(Difference::of_bytes(&found, playing.engine.memory().bytes()))
        })
    }
}
