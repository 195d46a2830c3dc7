//! `fbptr draw`: a prompt beside the window. Each line that is typed is drawn at once.
//!
//! The prompt is a client like others, see [`connection`]; [`session`] keeps what was typed, so that
//! it can be taken back and saved. Without a terminal the lines of standard input are taken the
//! same way, and a refused command makes the exit status 1.

mod connection;
mod file;
mod line;
mod prompt;
mod session;
mod step;
mod teach;
mod terminal;

use super::render_args::RenderArgs;
use super::{FrameSize, Status, check_picture, output, say_as_program, signals};
use crate::memory::VideoMemory;
use crate::save::{self, SnapshotFormat};
use crate::server::{Display, DisplayObserver, Engine, Limits, Server};
use clap::Args;
use connection::{Answers, Line};
use file::Stream;
use line::{CommandLine, Typed, TypedPayload};
use prompt::Prompt;
use session::Session;
use std::io::IsTerminal;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, channel};
use std::time::Duration;
use terminal::Terminal;

/// Type commands and see them drawn: a prompt beside the window.
#[derive(Debug, Args)]
pub struct Draw {
    /// A stream to go on with
    #[arg(value_name = "FILE")]
    file: Option<PathBuf>,
    /// The frame's size
    #[arg(long, value_name = "WxH")]
    size: Option<FrameSize>,
    /// Open no window
    #[arg(long)]
    headless: bool,
    /// Write the frame at the end: .png, .ppm or .raw
    #[arg(long, value_name = "OUT")]
    snap: Option<PathBuf>,
    #[command(flatten)]
    drawing: RenderArgs,
}

/// Reason for the end of the prompt.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Ending {
    /// `quit`, or the end of the input.
    Quit,
    /// SIGINT, SIGTERM or SIGHUP: the thread of the prompt may read on.
    Signal,
}

/// Largest payload that is read from a file, in bytes.
const MAX_FILE_BYTES: u64 = 1 << 30;

impl Draw {
    /// Reads and draws lines until `quit` or the end of the input. Returns the exit status.
    pub(super) fn run(self) -> Status {
        match self.draw() {
            Ok(status) => status,
            Err(message) => {
                say_as_program(message);
                Status::BadArguments
            }
        }
    }

    fn draw(&self) -> Result<Status, String> {
        if let Some(snap) = &self.snap {
            check_picture(snap)?;
        } else if self.headless {
            output::end_if_closed();
        }
        let stream = self.file.as_deref().map(Stream::read).transpose()?;
        let size_of_file = stream.as_ref().and_then(|stream| stream.size);
        let FrameSize { width, height } = self.size.or(size_of_file).unwrap_or(FrameSize::DEFAULT);
        let limits = Limits { memory_bytes: self.drawing.memory_bytes(), ..Limits::default() };
        let mut engine =
            Engine::with_limits(width, height, limits.for_frame(width, height)).map_err(|e| e.message)?;
        engine.set_renderer(self.drawing.renderer());
        let display = self.wants_window().then(|| Display::new(width, height));
        if let Some(display) = &display {
            engine.attach(DisplayObserver::new(display.clone()));
        }
        let server = Arc::new(Server::start(engine).map_err(|e| format!("no thread to render on: {e}"))?);
        let (ended, end) = channel();
        let (shown, on_thread) = (display.clone(), server.clone());
        let (signalled, left) = (ended.clone(), display.clone());
        let terminal = Arc::new(Terminal::note());
        let on_terminal = terminal.clone();
        signals::watch(move || {
            let _ = signalled.send(Ending::Signal);
            left.iter().for_each(|display| display.leave());
        })?;
        let typing = std::thread::Builder::new()
            .name("prompt".into())
            .spawn(move || {
                let status = converse(on_thread, on_terminal, [width, height], stream);
                // The window's thread may wait for either.
                let _ = ended.send(Ending::Quit);
                shown.iter().for_each(|display| display.leave());
                status
            })
            .map_err(|e| format!("no thread to read on: {e}"))?;
        if show(&server, display, &end) == Ending::Signal {
            terminal.give_back();
            let picture = server.client().snapshot().map_err(|fault| fault.message)?;
            return Ok(self.save(&picture, Status::Success));
        }
        let status = typing.join().unwrap_or_else(|_| Err("the prompt ended early".to_owned()))?;
        let server = Arc::into_inner(server).ok_or("the prompt's connection is still open")?;
        let engine = server.shut_down(Duration::from_secs(1));
        Ok(self.save(engine.memory(), status))
    }

    /// Writes the picture of `--snap`, and returns the exit status.
    fn save(&self, picture: &VideoMemory, status: Status) -> Status {
        match self.snap.as_ref().map(|path| save::to_path(picture, path)) {
            Some(Err(e)) => {
                say_as_program(e);
                Status::Failed
            }
            _ => status,
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
}

/// Shows the window on this thread, the main one, until it is closed or the prompt ends; then waits
/// for the prompt's end. Returns its reason.
#[cfg(feature = "window")]
fn show(server: &Server, display: Option<Arc<Display>>, end: &Receiver<Ending>) -> Ending {
    if let Some(display) = display {
        let options = crate::window::Options { title: "fbptr draw".into(), ..Default::default() };
        let closed = super::main_thread::show(display, options);
        server.thread().drop_display();
        match closed {
            Err(e) => say_as_program(format_args!("{e}: going on without a window; `snap FILE` saves")),
            Ok(()) => {
                if let Ok(ending) = end.try_recv() {
                    return ending;
                } else {
                    say_as_program("the window is closed; `snap FILE` saves the picture, `quit` ends")
                }
            }
        }
    }
    // An error means that the prompt's thread has ended.
    end.recv().unwrap_or(Ending::Quit)
}

#[cfg(not(feature = "window"))]
fn show(_: &Server, _: Option<Arc<Display>>, end: &Receiver<Ending>) -> Ending {
    // An error means that the prompt's thread has ended.
    end.recv().unwrap_or(Ending::Quit)
}

/// Reads lines and draws them until `quit` or the end of the input.
fn converse(
    server: Arc<Server>,
    terminal: Arc<Terminal>,
    size: [u32; 2],
    stream: Option<Stream>,
) -> Result<Status, String> {
    let broken = |e: std::io::Error| format!("the render thread cannot be reached: {e}");
    let mut session = Session::new(server, size).map_err(broken)?;
    let mut prompt = Prompt::new(terminal)?;
    let is_terminal = std::io::stdin().is_terminal();
    let mut has_failed = false;
    if is_terminal {
        output::print("Type a command, such as LINE 0 0 639 479 red gold; help lists them, quit ends.\n");
    }
    if let Some(Stream { name, bytes, skipped_lines, error, .. }) = stream {
        let answers = session.run_file(bytes).map_err(broken)?;
        has_failed |= answers.is_refused || error.is_some();
        for Line { number, text } in answers.lines {
            match number {
                Some(number) => say_as_program(format_args!("{name}:{}: {text}", number + skipped_lines)),
                None => output::print(format!("{text}\n")),
            }
        }
        error.iter().for_each(say_as_program);
    }
    loop {
        prompt.set_names(session.names());
        let text = match prompt.read("fbptr> ")? {
            prompt::Typed::Line(text) => text,
            prompt::Typed::Dropped => continue,
            prompt::Typed::End => break,
        };
        let done = match line::parse(&text) {
            Ok(Typed::Quit) => break,
            Ok(Typed::Command(command)) => match with_payload(&command, &mut prompt) {
                Ok(bytes) => {
                    let answers = session.run(bytes).map_err(broken)?;
                    answers.lines.iter().for_each(|line| output::print(format!("{}\n", line.text)));
                    hint(command.words, &answers);
                    Ok(!answers.is_refused)
                }
                Err(message) => Err(message),
            },
            Ok(own) => obey(&own, &mut session, &mut prompt).map(|()| true),
            Err(message) => Err(message),
        };
        match done {
            Ok(is_good) => has_failed |= !is_good,
            Err(message) => {
                output::print(format!("{message}\n"));
                has_failed = true;
            }
        }
    }
    Ok(if has_failed && !is_terminal { Status::Failed } else { Status::Success })
}

/// Does what a word to the prompt itself asks for.
fn obey(word: &Typed<'_>, session: &mut Session, prompt: &mut Prompt) -> Result<(), String> {
    let broken = |e: std::io::Error| format!("the render thread cannot be reached: {e}");
    match word {
        Typed::Help(None) => return page(&teach::overview(), prompt),
        Typed::Help(Some(word)) => return page(&teach::on(word)?, prompt),
        Typed::Undo(count) => {
            let taken = session.undo(*count).map_err(broken)?;
            if taken.is_empty() {
                return Err("there is nothing to undo".to_owned());
            }
            if std::io::stdin().is_terminal() {
                taken.iter().for_each(|line| output::print(format!("took back: {line}\n")));
            }
        }
        Typed::Redo(count) => {
            if session.redo(*count).map_err(broken)? == 0 {
                return Err("there is nothing to redo".to_owned());
            }
        }
        Typed::Step(count) => return step(session, prompt, *count),
        Typed::List => session.list().for_each(|line| output::print(format!("{line}\n"))),
        Typed::Save(file) => session.save(Path::new(file))?,
        Typed::Snap(file) => snap(session, Path::new(file))?,
        Typed::Nothing | Typed::Quit | Typed::Command(_) => {}
    }
    Ok(())
}

/// Draws the last command again, `count` pixels at each Enter, with the numbers of each; `q` draws the
/// rest at once. Without a terminal each line that is read counts as Enter.
fn step(session: &mut Session, prompt: &mut Prompt, count: usize) -> Result<(), String> {
    let broken = |e: std::io::Error| format!("the render thread cannot be reached: {e}");
    let after = session.picture()?;
    let Some(line) = session.undo(1).map_err(broken)?.pop() else {
        return Err("there is nothing to step through".to_owned());
    };
    let (command, steps) = step::steps(&line, &session.picture()?, &after);
    let size = [after.width(), after.height()];
    let mut shown = 0;
    for part in steps.chunks(count.max(1)) {
        for (number, step) in (shown + 1..).zip(part) {
            session.poke(step.offset, step.color).map_err(broken)?;
            let text = step.text(command.as_ref(), size);
            output::print(format!("{number:>5} of {}: {text}\n", steps.len()));
        }
        shown += part.len();
        if shown < steps.len() {
            match prompt.ask("Enter goes on, q draws the rest> ")? {
                prompt::Typed::Line(line) if !line.trim().eq_ignore_ascii_case("q") => {}
                _ => break,
            }
        }
    }
    session.restore().map_err(broken)?;
    match steps.is_empty() {
        true => Err(format!("{line} has changed no pixel")),
        false => Ok(()),
    }
}

/// Prints what may have been meant by a command.
fn hint(words: &str, answers: &Answers) {
    let hint = match answers.is_refused {
        true => {
            let text: Vec<&str> = answers.lines.iter().map(|line| line.text.as_str()).collect();
            teach::after_refusal(words, &text.join("\n"))
        }
        false => teach::after_success(words),
    };
    hint.iter().for_each(|hint| output::print(format!("{hint}\n")));
}

/// Number of lines that are printed at once on a terminal.
const PAGE_LINES: usize = 22;

/// Prints a text; on a terminal page by page.
fn page(text: &str, prompt: &mut Prompt) -> Result<(), String> {
    let lines: Vec<&str> = text.lines().collect();
    let is_terminal = std::io::stdin().is_terminal() && std::io::stdout().is_terminal();
    let length = if is_terminal { PAGE_LINES } else { lines.len().max(1) };
    let mut pages = lines.chunks(length).peekable();
    while let Some(page) = pages.next() {
        output::print(page.join("\n") + "\n");
        if pages.peek().is_some() {
            match prompt.ask("Enter shows more, q ends> ")? {
                prompt::Typed::Line(line) if line.trim().is_empty() => {}
                _ => break,
            }
        }
    }
    Ok(())
}

/// Writes the picture to a file.
fn snap(session: &Session, path: &Path) -> Result<(), String> {
    SnapshotFormat::of_path(path).map_err(|e| e.to_string())?;
    let picture = session.picture()?;
    save::to_path(&picture, path).map_err(|e| e.to_string())
}

/// Returns the bytes of a typed command with its payload.
fn with_payload(command: &CommandLine<'_>, prompt: &mut Prompt) -> Result<Vec<u8>, String> {
    let mut bytes = command.words.as_bytes().to_vec();
    match command.payload {
        TypedPayload::None => bytes.push(b'\n'),
        TypedPayload::File(file) => {
            let payload = read_file(Path::new(file))?;
            bytes.extend_from_slice(format!(" :{}\n", payload.len()).as_bytes());
            bytes.extend_from_slice(&payload);
            bytes.push(b'\n');
        }
        TypedPayload::Typed(count) => {
            bytes.push(b'\n');
            bytes.extend_from_slice(&typed_payload(count, prompt)?);
            bytes.push(b'\n');
        }
    }
    Ok(bytes)
}

/// Reads lines until they hold `count` bytes; the end of the last line may be one of them.
fn typed_payload(count: usize, prompt: &mut Prompt) -> Result<Vec<u8>, String> {
    let mut lines: Vec<String> = Vec::new();
    loop {
        let mut payload = lines.join("\n");
        if !lines.is_empty() && payload.len() + 1 == count {
            payload.push('\n');
        }
        let left = count.saturating_sub(payload.len());
        if left == 0 {
            return match payload.len() {
                length if length == count => Ok(payload.into_bytes()),
                length => Err(format!(
                    "the payload has {length} bytes, and :{count} was announced: nothing was drawn"
                )),
            };
        }
        match prompt.read(&format!("{left} more> "))? {
            prompt::Typed::Line(line) => lines.push(line),
            prompt::Typed::Dropped | prompt::Typed::End => {
                return Err(format!("the payload lacks {left} bytes: nothing was drawn"));
            }
        }
    }
}

/// Reads a file that is named on the command line or at the prompt.
fn read_file(path: &Path) -> Result<Vec<u8>, String> {
    let name = path.display().to_string();
    read_all(std::fs::File::open(path).map_err(|e| format!("{name}: {e}"))?, &name)
}

/// Reads an open file to its end.
fn read_all(file: std::fs::File, name: &str) -> Result<Vec<u8>, String> {
    let mut bytes = Vec::new();
    let mut limited = std::io::Read::take(file, MAX_FILE_BYTES + 1);
    std::io::Read::read_to_end(&mut limited, &mut bytes).map_err(|e| format!("{name}: {e}"))?;
    match bytes.len() as u64 > MAX_FILE_BYTES {
        true => Err(format!("{name}: over {MAX_FILE_BYTES} bytes")),
        false => Ok(bytes),
    }
}
