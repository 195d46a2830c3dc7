//! Command streams and recordings in the viewer: replayed with the viewer's overrides, up to the
//! shown frame.
//!
//! A frame is the picture at a `PRESENT`; a stream without one is one frame. When the overrides
//! change or time goes back, the stream is replayed from its beginning on a new engine, so every
//! picture is the one that playing the stream gives.

use super::Wishes;
use super::difference::{Difference, Work};
use super::frame::ViewerFrame;
use fbptr_command::Command;
use fbptr_core::memory::VideoMemory;
use fbptr_core::pipeline::{RenderOptions, RenderPath, Renderer};
use fbptr_core::scene::{Camera, QualityUse, ViewOverrides};
use fbptr_server::{Audience, Budget, Engine, Notice, Output, Pace, Playback, Session, StreamState};
use std::sync::Arc;

/// Factory of the engine that a stream is played on.
pub type MakeEngine = Arc<dyn Fn() -> Result<Engine, String> + Send + Sync>;

/// A stream or recording, and the state of its replay.
pub(super) struct Replay {
    bytes: Arc<[u8]>,
    make_engine: MakeEngine,
    playing: Option<Playing>,
    /// Notices of the first replay, until they are taken.
    notices: Vec<Notice>,
    /// Number of notices already reported: each replay meets the same ones.
    reported: usize,
    /// Number of the last frame, once the end was reached.
    last_frame: Option<u64>,
}

/// A stream or recording on its engine.
pub(super) struct Playing {
    engine: Engine,
    playback: Playback,
    view_overrides: ViewOverrides,
    used: usize,
    has_ended: bool,
    notices: Vec<Notice>,
}

impl Playing {
    /// Creates an engine on which nothing of `bytes` was played yet.
    pub fn new(
        bytes: &[u8],
        make_engine: &MakeEngine,
        view_overrides: ViewOverrides,
        path: RenderPath,
    ) -> Result<Self, String> {
        let mut engine = make_engine()?;
        if path == RenderPath::Plain {
            engine.set_renderer(Renderer::new(RenderOptions { path, ..RenderOptions::default() }));
        }
        engine.set_view_overrides(view_overrides);
        let playback = Playback::new(&mut engine, bytes);
        Ok(Playing { engine, playback, view_overrides, used: 0, has_ended: false, notices: Vec::new() })
    }

    /// Returns whether the input is one stream of commands, and no recording.
    pub fn is_stream(&self) -> bool {
        self.playback.is_stream()
    }

    /// Plays the commands that are complete in the first bytes of a stream.
    pub fn play_bytes(&mut self, bytes: &[u8]) {
        let mut out = Output::default();
        while !self.has_ended && self.used < bytes.len() {
            let budget = Budget { pace: Pace::OneFrame, ..Budget::NONE };
            let rest = &bytes[self.used..];
            let (taken, state) = self.playback.feed(&mut self.engine, rest, &mut out, budget);
            self.used += taken;
            self.has_ended = state == StreamState::Ended;
            out.replies.clear();
        }
    }

    /// Plays until `frames` frames were presented, or to the end.
    pub fn play_to(&mut self, bytes: &[u8], frames: u64) {
        let budget = Budget { pace: Pace::OneFrame, ..Budget::NONE };
        let mut out = Output::default();
        while !self.has_ended && self.engine.frames() < frames {
            let state = match self.used < bytes.len() {
                true => {
                    let (taken, state) =
                        self.playback.feed(&mut self.engine, &bytes[self.used..], &mut out, budget);
                    self.used += taken;
                    state
                }
                false => self.playback.finish(&mut self.engine, &mut out),
            };
            self.has_ended = state == StreamState::Ended;
            // Replies have no reader here.
            out.replies.clear();
            self.notices.append(&mut out.notices);
        }
    }

    /// Returns the number of frames presented.
    pub fn frames(&self) -> u64 {
        self.engine.frames()
    }

    /// Returns the memory that the stream draws into.
    pub fn memory(&self) -> &VideoMemory {
        self.engine.memory()
    }

    /// Returns the first refused command's error.
    pub fn first_error(&self) -> Option<String> {
        let is_error = |notice: &&Notice| matches!(notice, Notice::Refused(_));
        self.notices.iter().find(is_error).map(|error| error.play_line("line"))
    }

    /// Runs a query in a session of its own, and returns its reply or error as one line.
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
        Replay { bytes, make_engine, playing: None, notices: Vec::new(), reported: 0, last_frame: None }
    }

    /// Takes the notices about commands; each is returned once.
    pub fn take_notices(&mut self) -> Vec<Notice> {
        std::mem::take(&mut self.notices)
    }

    /// Returns whether anything was presented, valid once a frame was drawn.
    pub fn is_animated(&self) -> bool {
        self.playing.as_ref().is_some_and(|p| p.engine.frames() > 0)
    }

    /// Returns the number of the last frame, once the end was reached.
    pub fn last_frame(&self) -> Option<u64> {
        self.last_frame
    }

    /// Returns the author's camera at the current position of the stream.
    pub fn given_camera(&self) -> Camera {
        self.playing.as_ref().map_or_else(Camera::default, |p| p.playback.camera())
    }

    /// Returns whether anything three-dimensional was drawn.
    pub fn is_spatial(&mut self) -> bool {
        let stats = self.playing.as_mut().map(|p| p.ask(Command::Stats)).unwrap_or_default();
        !stats.split_whitespace().any(|word| word == "plan=-")
    }

    /// Draws frame `wishes.frame`, counted from 0.
    pub fn draw(&mut self, wishes: &Wishes, frame: &mut ViewerFrame) -> Result<(), String> {
        let (view_overrides, requested) = (wishes.view_overrides(), wishes.frame + 1);
        // Drawing after the last PRESENT cannot be undone.
        let is_before = |p: &Playing| p.engine.frames() < requested + u64::from(!p.has_ended);
        let fits = |p: &Playing| p.view_overrides == view_overrides && is_before(p);
        let mut playing = match self.playing.take().filter(fits) {
            Some(playing) => playing,
            None => Playing::new(&self.bytes, &self.make_engine, view_overrides, RenderPath::Fast)?,
        };
        playing.play_to(&self.bytes, requested);
        if playing.has_ended {
            // The picture after the last PRESENT is a frame too.
            self.last_frame = Some(playing.engine.frames());
        }
        self.notices.extend(playing.notices.iter().skip(self.reported).cloned());
        self.reported = self.reported.max(playing.notices.len());
        frame.memory.bytes_mut().copy_from_slice(playing.engine.memory().bytes());
        frame.depth = playing.engine.depth().cloned();
        self.playing = Some(playing);
        Ok(())
    }

    /// Returns the engine's plan and memory use as lines of text.
    pub fn plan(&mut self) -> Vec<String> {
        let stats = self.playing.as_mut().map(|p| p.ask(Command::Stats)).unwrap_or_default();
        let requested = ["plan=", "memory_bytes=", "depth_bytes=", "id_bytes=", "shared_bytes=", "presents="];
        let found = stats.split_whitespace().filter(|word| requested.iter().any(|w| word.starts_with(w)));
        // `plan=` has several entries, separated by commas, with colons inside.
        let words = found.flat_map(|word| word.trim_start_matches("plan=").split(','));
        words.map(|word| word.replace(['=', ':'], " ")).collect()
    }

    /// Returns the depth and the face at a pixel, as lines of text.
    pub fn inspect(&mut self, x: i32, y: i32) -> Vec<String> {
        let Some(playing) = &mut self.playing else { return Vec::new() };
        let depth = playing.ask(Command::DepthAt { x, y });
        let pick = playing.ask(Command::Pick { x, y });
        let tail =
            |line: &str, words: usize| line.split_whitespace().skip(words).collect::<Vec<_>>().join(" ");
        vec![format!("depth {}", tail(&depth, 3)), format!("pick {}", tail(&pick, 3))]
    }

    /// Returns the bytes up to the shown frame, and the factory of the engine that they are played on.
    pub fn played(&self) -> (&[u8], &MakeEngine) {
        let used = self.playing.as_ref().map_or(0, |playing| playing.used);
        (&self.bytes[..used.min(self.bytes.len())], &self.make_engine)
    }

    /// Returns the work that computes the difference to the picture of the plain render path.
    pub fn exact(&self, wishes: &Wishes, frame: &ViewerFrame) -> Work {
        let (bytes, make_engine) = (Arc::clone(&self.bytes), Arc::clone(&self.make_engine));
        let view_overrides = ViewOverrides { quality: QualityUse::Exact, ..wishes.view_overrides() };
        let (requested, found) = (wishes.frame + 1, frame.memory.bytes().to_vec());
        Box::new(move || {
            let mut playing = Playing::new(&bytes, &make_engine, view_overrides, RenderPath::Plain)?;
            playing.play_to(&bytes, requested);
            Ok(Difference::of_bytes(&found, playing.engine.memory().bytes()))
        })
    }
}
