//! Decisions about streams of commands: as they are, and within error budgets.
//!
//! A stream is played to its end; the compared frame is the last one, as `fbptr play --snap` writes
//! it. Its time is that of the whole stream, from its bytes, over the number of its `PRESENT`s. The
//! truth is the same stream drawn by the plain path in f64; figures of two dimensions have no second
//! code there. What is drawn on is what differs from the colour of the last `CLEAR`.

use super::super::clock::Work;
use super::super::experiment::{Check, Effort, Row, Standing};
use super::super::report::Section;
use super::truth::Found;
use super::{
    DECISION, DecideError, Decision, Question, SameWork, Setting, bounds, rows_effort, settings, summary,
};
use fbptr_command::{
    BYTE_ORDER_MARK, Command, Decoder, EndOfInput, Flow, Limits as DecoderLimits, Sink, StreamError,
    StreamPosition,
};
use fbptr_core::memory::Rgba;
use fbptr_core::pipeline::{RenderOptions, RenderPath, Renderer};
use fbptr_core::scene::MaxError;
use fbptr_formats::load::SandboxDir;
use fbptr_server::{Budget, Engine, Limits, Notice, Output, Playback, RECORD_MAGIC, StreamState};

/// Remarks on a stream before it is played.
struct Overview {
    background: Rgba,
    has_faces: bool,
    asks_for_quality: bool,
}

impl Sink for Overview {
    fn pixel(&mut self, _: i32, _: i32, _: Rgba) {}

    fn binary_pixels(&mut self, _: &[u8]) {}

    fn command(&mut self, command: Command, _: StreamPosition) -> Flow {
        match command {
            Command::Clear { color } => self.background = color,
            Command::Quality { .. } => self.asks_for_quality = true,
            Command::Draw { .. } | Command::DrawScene { .. } => self.has_faces = true,
            Command::Quit => return Flow::Stop,
            _ => {}
        }
        Flow::Continue
    }

    fn error(&mut self, _: StreamError) -> Flow {
        Flow::Continue
    }
}

impl Overview {
    fn of(bytes: &[u8]) -> Overview {
        let mut overview = Overview { background: [0, 0, 0, 255], has_faces: false, asks_for_quality: false };
        let mut decoder = Decoder::new(DecoderLimits::default());
        let _ = decoder.feed(bytes, &mut overview);
        let _ = decoder.finish(EndOfInput::File, &mut overview);
        overview
    }
}

/// Returns the number of a stream's first lines that a further command may follow: those up to `SIZE`,
/// which is valid as the first command alone.
pub fn quality_line(stream: &[u8]) -> usize {
    let is_command = |line: &&[u8]| !line.starts_with(b"#") && !line.trim_ascii().is_empty();
    let stream = stream.strip_prefix(BYTE_ORDER_MARK).unwrap_or(stream);
    let first = stream.split(|&b| b == b'\n').enumerate().find(|(_, line)| is_command(line));
    match first {
        Some((i, line))
            if line.trim_ascii_start().get(..4).is_some_and(|v| v.eq_ignore_ascii_case(b"SIZE")) =>
        {
            i + 1
        }
        _ => 0,
    }
}

/// Returns the stream with a budget.
fn within(stream: &[u8], setting: &Setting) -> Vec<u8> {
    let Setting::Within(MaxError { steps, shift }) = setting else { return stream.to_vec() };
    let stream = stream.strip_prefix(BYTE_ORDER_MARK).unwrap_or(stream);
    let lines = quality_line(stream);
    let at: usize = stream.split_inclusive(|&b| b == b'\n').take(lines).map(<[u8]>::len).sum();
    let (head, tail) = stream.split_at(at);
    [head, format!("QUALITY max-error {steps} {shift}\n").as_bytes(), tail].concat()
}

/// Plays a stream to its end. Returns its last frame, and the number of frames that it presents.
fn play(
    bytes: &[u8],
    [width, height]: [u32; 2],
    load_dir: Option<&SandboxDir>,
    renderer: Renderer,
) -> Result<(Vec<u8>, u32), DecideError> {
    let limits = Limits::default().for_frame(width, height);
    let mut engine =
        Engine::with_limits(width, height, limits).map_err(|e| DecideError::Stream(e.message.to_string()))?;
    engine.take_size();
    engine.set_renderer(renderer);
    if let Some(folder) = load_dir {
        engine.set_load_dir(folder.clone());
    }
    let (mut playback, mut used, mut out) = (Playback::new(&mut engine, bytes), 0, Output::default());
    loop {
        let state = match used < bytes.len() {
            true => {
                let (taken, state) = playback.feed(&mut engine, &bytes[used..], &mut out, Budget::NONE);
                used += taken;
                state
            }
            false => playback.finish(&mut engine, &mut out),
        };
        out.replies.clear();
        if state == StreamState::Ended {
            break;
        }
    }
    match out.notices.iter().find(|notice| matches!(notice, Notice::Refused(_))) {
        Some(refused) => Err(DecideError::Stream(refused.play_line("stream"))),
        None => {
            let frames = u32::try_from(engine.frames()).unwrap_or(u32::MAX);
            Ok((engine.into_memory().bytes().to_vec(), frames))
        }
    }
}

/// Returns a frame with the pixels that are not of the background.
fn found(bytes: Vec<u8>, background: Rgba) -> Found {
    let drawn = bytes.as_chunks().0.iter().map(|pixel| *pixel != background).collect();
    Found { bytes, drawn }
}

/// Returns the errors of a frame beside the right one.
fn errors(found: &Found, right: &Found) -> Vec<f64> {
    let pixels = found.bytes.chunks_exact(4).zip(right.bytes.chunks_exact(4)).zip(&right.drawn);
    let off = |(a, b): (&[u8], &[u8])| (0..3).map(|c| a[c].abs_diff(b[c])).max().unwrap_or(0);
    let distances = pixels.filter(|(_, drawn)| **drawn).map(|(pair, _)| f64::from(off(pair))).collect();
    let coverage = found.drawn.iter().zip(&right.drawn).filter(|(a, b)| a != b).count();
    summary(distances, coverage)
}

/// Compares a stream with itself within error budgets.
pub(super) fn decide(
    effort: &Effort,
    bytes: &[u8],
    load_dir: Option<&SandboxDir>,
    question: &Question<'_>,
) -> Result<Decision, DecideError> {
    let overview = Overview::of(bytes);
    let plain = RenderOptions { path: RenderPath::Plain, ..RenderOptions::default() };
    let (right, frames) = play(bytes, question.size, load_dir, Renderer::new(plain))?;
    let (right, frames) = (found(right, overview.background), frames.max(1));
    if !right.drawn.contains(&true) {
        return Err(DecideError::Nothing("every pixel of the last frame has the background's colour".into()));
    }
    let mut notes = vec![format!(
        "Compared is the last frame, with the plain path's in f64. A frame's time is that of the whole stream, its bytes \
         included, over the frames that it presents ({frames}). Figures of two dimensions have no second code in the truth. \
         Drawn on is what differs from the colour of the last CLEAR."
    )];
    if overview.asks_for_quality {
        notes.push("The stream sets QUALITY itself, which each row follows from there on.".into());
    }
    let is_recording = bytes.starts_with(RECORD_MAGIC);
    if is_recording {
        notes.push("A recording keeps what its connections asked for: no budget is compared.".into());
    }
    let budgets: &[MaxError] = if is_recording { &[] } else { &question.budgets };
    let (mut ways, mut same_work) = (Vec::new(), Vec::new());
    for setting in settings::of_stream(budgets) {
        match overview.has_faces || setting == Setting::Exact {
            true => ways.push((within(bytes, &setting), setting)),
            false => same_work.push(SameWork { setting: setting.name(), of: Setting::Exact.name() }),
        }
    }
    let mut pictures = Vec::new();
    for (stream, _) in &ways {
        let (bytes, _) = play(stream, question.size, load_dir, effort.renderer())?;
        pictures.push(found(bytes, overview.background));
    }
    let work = |(stream, _): &'_ (Vec<u8>, Setting)| {
        let stream = stream.clone();
        let draw = move || drop(play(&stream, question.size, load_dir, effort.renderer()));
        Box::new(draw) as Work<()>
    };
    let timings = rows_effort(effort, ways.len()).run_in_turns(ways.iter().map(work).collect());
    let mut rows = Vec::new();
    for (((_, setting), picture), ((), timing)) in ways.iter().zip(&pictures).zip(timings) {
        let standing = if *setting == Setting::Exact { Standing::Default } else { Standing::Mode };
        let key = (question.name.as_str(), &*setting.name(), standing);
        // Two frames of bytes, each within 2 of the right one; what two faces share is not decided here.
        let promised = match setting {
            Setting::Within(_) => bounds(setting, 4.0).into_iter().take(1).collect(),
            _ => Vec::new(),
        };
        let row = Row::judged(effort, key, picture, promised, |f| errors(f, &right), |_, _| {});
        let row = row.timed(timing, f64::from(frames));
        rows.push(row.with_picture(question.size[0], picture.bytes.clone(), right.bytes.clone()));
    }
    let section = Section { experiment: DECISION, rows, check: Check { difference: 0.0, at_most: 0.0 } };
    let settings = ways.into_iter().map(|way| way.1).collect();
    Ok(Decision::new(question, section, settings, same_work, notes))
}
