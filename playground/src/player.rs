//! A stream on its engine, as far as it was run, and the user's view of it.

use fbptr::command::{Command, EndOfInput, Verb, help_on};
use fbptr::eye::Rotation;
use fbptr::glam::DVec3;
use fbptr::memory::VideoMemory;
use fbptr::pipeline::trace::Probe;
use fbptr::scene::{Camera, ViewOverrides};
use fbptr_engine::{
    Audience, Budget, Engine, Limits, Notice, Output, Pace, Session, Stream, StreamState, stated_size,
};
use serde_json::{Value, json};
use std::time::Duration;

/// Quotas of a page: little enough for a telephone.
pub const LIMITS: Limits = Limits {
    connections: 1,
    connections_per_address: 1,
    idle_timeout: None,
    payload_bytes: 16 << 20,
    names: 4096,
    resource_bytes: 256 << 20,
    frame_bytes: 64 << 20,
    memory_bytes: 512 << 20,
    reply_bytes: 16 << 20,
    snap_bytes: 0,
    matrix_stack: 1024,
    lights: 256,
    command_time: Duration::MAX,
};

/// The frame of a stream that does not state its size.
const SIZE: [u32; 2] = [640, 480];
/// Most replies and notices of one report.
const MAX_LINES: usize = 200;
/// Most bytes of replies that are shown of one report.
const MAX_REPLY_BYTES: usize = 16 << 10;

/// A user's changes of the view.
#[derive(Clone, Debug, Default)]
pub struct View {
    overrides: ViewOverrides,
    turns: Vec<Rotation>,
    /// The pixel to trace.
    pub trace: Option<[i32; 2]>,
}

impl View {
    /// Sets the view relative to the author's camera; without a camera nothing changes.
    pub fn set_camera(&mut self, [yaw, pitch]: [f64; 2], zoom: f64, pan: [f64; 2], given: Option<Camera>) {
        let Some(given) = given else { return };
        let mut overrides = ViewOverrides::default();
        let navigator = &mut overrides.navigator;
        let up = given.look_at.up.try_normalize().unwrap_or(DVec3::Y);
        if yaw != 0.0 || pitch != 0.0 {
            navigator.orbit(&given, up, yaw, pitch);
        }
        if pan != [0.0; 2] {
            navigator.walk(&given, [pan[0], pan[1], 0.0]);
        }
        if zoom != 1.0 {
            navigator.zoom_by(zoom);
        }
        self.overrides = overrides;
    }

    /// Adds a turn in the plane of two axes, in degrees; with two equal axes takes all turns back.
    pub fn turn(&mut self, a: usize, b: usize, angle_deg: f64) {
        match a == b {
            true => self.turns.clear(),
            false => self.turns.push(Rotation { a, b, angle_deg }),
        }
    }
}

/// State of a stream after a part of it has run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum State {
    /// It can go on.
    Ready,
    /// It pauses, and can then go on.
    Pauses,
    /// It has ended.
    Ended,
}

/// A stream on its engine.
pub struct Player {
    bytes: Vec<u8>,
    used: usize,
    engine: Engine,
    stream: Stream,
    out: Output,
    pause: Duration,
    has_ended: bool,
}

impl Player {
    /// Creates the engine of a stream, on which nothing has run.
    ///
    /// # Errors
    /// A message if it states the size of no frame.
    pub fn new(bytes: Vec<u8>, view: &View) -> Result<Self, String> {
        let stated = stated_size(&bytes).map(|[w, h]| {
            let number = |word: &str| word.parse::<u32>().ok().filter(|&n| n > 0);
            number(w).zip(number(h)).ok_or_else(|| format!("SIZE {w} {h}: expected two numbers above 0"))
        });
        let takes_size = stated.is_some();
        let (width, height) = stated.transpose()?.unwrap_or(SIZE.into());
        let mut engine =
            Engine::with_limits(width, height, LIMITS.for_frame(width, height)).map_err(|e| e.message)?;
        if takes_size {
            engine.take_size();
        }
        engine.set_view_overrides(view.overrides);
        engine.set_eye_turns(&view.turns);
        if let Some([x, y]) = view.trace {
            engine.set_trace(Probe::Pixel(x, y));
        }
        engine.open(1);
        let stream = Stream::new(&engine, 1, Audience::Owner);
        let (out, pause) = (Output::default(), Duration::ZERO);
        Ok(Player { bytes, used: 0, engine, stream, out, pause, has_ended: false })
    }

    /// Runs the stream by one part; to its end if the pace is free.
    pub fn run(&mut self, pace: Pace) -> State {
        let budget = Budget { pace, ..Budget::NONE };
        loop {
            let state = match self.used < self.bytes.len() {
                _ if self.has_ended => return State::Ended,
                true => {
                    let rest = &self.bytes[self.used..];
                    let (taken, state) = self.stream.feed(&mut self.engine, rest, &mut self.out, budget);
                    self.used += taken;
                    state
                }
                false => self.stream.finish(&mut self.engine, EndOfInput::File, &mut self.out),
            };
            self.pause = Duration::ZERO;
            match state {
                StreamState::Ended => {
                    self.has_ended = true;
                    return State::Ended;
                }
                StreamState::Pauses(time) if pace == Pace::OneFrame => {
                    self.pause = time;
                    return State::Pauses;
                }
                StreamState::Yields if pace != Pace::Free => return State::Ready,
                // The page shows every frame at once; nothing else leaves a stream waiting that
                // may not be suspended.
                _ => {}
            }
        }
    }

    /// Returns for how many milliseconds the stream pauses.
    pub fn pause_ms(&self) -> f64 {
        self.pause.as_secs_f64() * 1000.0
    }

    /// Returns the frame.
    pub fn memory(&self) -> &VideoMemory {
        self.engine.memory()
    }

    /// Returns the CRC-32 of the frame.
    pub fn crc(&self) -> u32 {
        crc32fast::hash(self.engine.memory().bytes())
    }

    /// Returns the number of `PRESENT` commands so far.
    pub fn frames(&self) -> u64 {
        self.engine.frames()
    }

    /// Returns the author's camera.
    pub fn camera(&self) -> Camera {
        self.stream.session().seen_camera()
    }

    /// Returns what has happened since the last report.
    pub fn report(&mut self) -> Value {
        let bytes = std::mem::take(&mut self.out.replies);
        let shown = &bytes[..bytes.len().min(MAX_REPLY_BYTES)];
        let notices: Vec<_> = self.out.notices.drain(..).collect();
        let count = notices.len();
        let notices: Vec<Value> = notices.into_iter().take(MAX_LINES).map(notice).collect();
        let place = self.stream.place();
        let stats = self.ask(Command::Stats);
        let plan = stats.split_whitespace().find_map(|word| word.strip_prefix("plan=")).unwrap_or("-");
        json!({
            "line": place.line,
            "byte": place.byte,
            "bytes": self.bytes.len(),
            "commands": self.stream.session().stats.commands,
            "errors": self.stream.session().stats.errors,
            "frames": self.engine.frames(),
            "replies": printable(shown),
            "cut": bytes.len() - shown.len(),
            "notices": notices,
            "left_out": count.saturating_sub(MAX_LINES),
            "trace": self.engine.trace(),
            "spatial": plan != "-",
            "memory": self.engine.memory_budget().used(),
        })
    }

    /// Returns depth and name at a pixel of the frame, in two lines.
    pub fn inspect(&mut self, x: i32, y: i32) -> String {
        let depth = self.ask(Command::DepthAt { x, y });
        let pick = self.ask(Command::Pick { x, y });
        format!("{depth}\n{pick}")
    }

    /// Runs a query in a session of its own, and returns its reply or error as one line.
    fn ask(&mut self, command: Command) -> String {
        let (mut session, mut reply) = (Session::new(2, Audience::Owner), Vec::new());
        match self.engine.run(&mut session, command, &mut reply) {
            Ok(_) => String::from_utf8_lossy(&reply).trim_end().to_owned(),
            Err(fault) => fault.message,
        }
    }

    /// Returns the frame as a PNG file.
    pub fn png(&self) -> Vec<u8> {
        let mut file = Vec::new();
        match fbptr::save::png(self.engine.memory(), &mut file) {
            Ok(()) => file,
            // There is no system to fail; nothing is saved then.
            Err(_) => Vec::new(),
        }
    }
}

fn notice(notice: Notice) -> Value {
    match notice {
        Notice::Refused(refused) => {
            let line = refused.play_line("");
            let text = line.split_once(": ").map_or(&*line, |(_, text)| text);
            json!({ "kind": "error", "line": refused.place.line, "text": text })
        }
        Notice::Warning(text) => json!({ "kind": "warning", "text": text }),
        Notice::Remark { place, verb, text } => {
            json!({ "kind": "remark", "line": place.line, "text": format!("{verb}: {text}") })
        }
    }
}

/// Returns bytes as text; those that are not of printable ASCII as `\xNN`.
fn printable(bytes: &[u8]) -> String {
    let mut text = String::with_capacity(bytes.len());
    for &byte in bytes {
        match byte {
            b'\n' | b' '..=b'~' => text.push(char::from(byte)),
            _ => text.push_str(&byte.escape_ascii().to_string()),
        }
    }
    text
}

/// Returns the verbs: name, group, and what `HELP` says of them.
pub fn verbs() -> Value {
    let verb = |verb: &Verb| {
        let help = help_on(verb.name).unwrap_or_default();
        json!({ "name": verb.name, "group": verb.group.title(), "help": help })
    };
    Verb::all().iter().map(verb).collect()
}
