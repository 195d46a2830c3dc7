//! The drawing made at the prompt: the commands so far, which can be taken back and saved.
//!
//! The picture is always that of the commands listed, in order: `undo` draws all but the last ones
//! again, on a new connection and a cleared frame. A test compares it with the saved stream, played
//! from the start.

use super::connection::{Answers, Connection, Line};
use crate::memory::{DepthFormat, Rgba, VideoMemory};
use crate::server::Server;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Commands, and the connection on which they were run.
pub(super) struct Session {
    server: Arc<Server>,
    /// Width and height of the frame.
    size: [u32; 2],
    connection: Connection,
    /// Commands with their payloads that changed something, in order.
    steps: Vec<Vec<u8>>,
    /// Commands that were taken back, the last one first.
    undone: Vec<Vec<u8>>,
    /// File that was saved: only this one is overwritten.
    saved: Option<PathBuf>,
}

impl Session {
    /// Begins with the server's cleared frame of this width and height.
    ///
    /// # Errors
    /// If the system has no pipe or no thread to give.
    pub fn new(server: Arc<Server>, size: [u32; 2]) -> io::Result<Session> {
        let connection = Connection::open(&server)?;
        Ok(Session { server, size, connection, steps: Vec::new(), undone: Vec::new(), saved: None })
    }

    /// Runs whole commands. They are listed unless they were refused or were questions.
    ///
    /// # Errors
    /// If there is no new connection after the server has closed this one.
    pub fn run(&mut self, commands: Vec<u8>) -> io::Result<Answers> {
        let answers = match self.connection.exchange(&commands) {
            Ok(answers) => answers,
            // The commands closed it (`ERRORS close` and an error, say); those before are drawn
            // again.
            Err(_) => {
                self.redraw()?;
                let text = "the connection was closed by this command, which is left out".to_owned();
                let lines = vec![Line { number: None, text }];
                return Ok(Answers { lines, is_refused: true, is_reply: false, is_closed: true });
            }
        };
        if !answers.is_refused && !answers.is_reply {
            self.steps.push(commands);
            self.undone.clear();
        }
        Ok(answers)
    }

    /// Runs the complete commands of a file. All are listed, as one step: what is refused has no
    /// effect.
    ///
    /// # Errors
    /// If there is no new connection after the server has closed this one.
    pub fn run_file(&mut self, commands: Vec<u8>) -> io::Result<Answers> {
        let listed = self.steps.len();
        let answers = self.run(commands.clone())?;
        if self.steps.len() == listed && !answers.is_closed {
            self.steps.push(commands);
        }
        Ok(answers)
    }

    /// Takes back the last `count` commands, and returns the first line of each, the last one first.
    ///
    /// # Errors
    /// If there is no new connection.
    pub fn undo(&mut self, count: usize) -> io::Result<Vec<String>> {
        let kept = self.steps.len().saturating_sub(count);
        let taken: Vec<Vec<u8>> = self.steps.drain(kept..).rev().collect();
        let lines = taken.iter().map(|step| first_line(step).into_owned()).collect();
        if !taken.is_empty() {
            self.undone.extend(taken);
            self.redraw()?;
        }
        Ok(lines)
    }

    /// Runs the last `count` commands again that were taken back, and returns how many there were.
    ///
    /// # Errors
    /// If the connection has ended.
    pub fn redo(&mut self, count: usize) -> io::Result<usize> {
        let count = count.min(self.undone.len());
        for _ in 0..count {
            let Some(step) = self.undone.pop() else { break };
            self.connection.exchange(&step)?;
            self.steps.push(step);
        }
        Ok(count)
    }

    /// Lists the command again that was taken back last, and draws all commands anew: what
    /// [`Self::poke`] has set is gone.
    ///
    /// # Errors
    /// If there is no new connection.
    pub fn restore(&mut self) -> io::Result<()> {
        self.steps.extend(self.undone.pop());
        self.redraw()
    }

    /// Sets one pixel of the frame by its offset. It is not listed.
    ///
    /// # Errors
    /// If the connection has ended.
    pub fn poke(&mut self, offset: usize, [r, g, b, a]: Rgba) -> io::Result<()> {
        self.connection.exchange(format!("POKE {offset} {r:02x}{g:02x}{b:02x}{a:02x}\n").as_bytes()).map(drop)
    }

    /// Returns the commands so far, one line each; payloads are left out.
    pub fn list(&self) -> impl Iterator<Item = std::borrow::Cow<'_, str>> {
        self.steps.iter().map(|step| first_line(step))
    }

    /// Returns the commands so far as a stream.
    pub fn stream(&self) -> Vec<u8> {
        let mut stream = b"# Drawn with `fbptr draw`; `fbptr play FILE` draws it again.\n".to_vec();
        stream.extend_from_slice(format!("SIZE {} {}\n", self.size[0], self.size[1]).as_bytes());
        for step in &self.steps {
            stream.extend_from_slice(step);
        }
        stream
    }

    /// Returns a copy of the picture.
    ///
    /// # Errors
    /// A message if the render thread has ended.
    pub fn picture(&self) -> Result<VideoMemory, String> {
        self.server.client().snapshot().map_err(|fault| fault.message)
    }

    /// Writes the commands so far as a stream. A file that this session has not written is kept.
    ///
    /// # Errors
    /// A message if the file exists or cannot be written.
    pub fn save(&mut self, path: &Path) -> Result<(), String> {
        let failed = |e: io::Error| format!("{}: {e}", path.display());
        if self.saved.as_deref() == Some(path) {
            let stream = self.stream();
            let put = |out: &mut dyn io::Write| out.write_all(&stream);
            return crate::save::replace(path, put).map_err(|e| e.to_string());
        }
        match std::fs::File::create_new(path) {
            Ok(mut file) => io::Write::write_all(&mut file, &self.stream()).map_err(failed)?,
            Err(e) if e.kind() == io::ErrorKind::AlreadyExists => {
                return Err(format!("{} exists and is kept: save under another name", path.display()));
            }
            Err(e) => return Err(failed(e)),
        }
        self.saved = Some(path.to_owned());
        Ok(())
    }

    /// Draws the listed commands again, on a new connection and a cleared frame.
    fn redraw(&mut self) -> io::Result<()> {
        self.connection = Connection::open(&self.server)?;
        let format = DepthFormat::default().as_str();
        let mut stream = format!("DEPTH {format}\nCLEAR\n").into_bytes();
        for name in self.shared_names() {
            stream.extend_from_slice(format!("FREE {name}\n").as_bytes());
        }
        for step in self.steps.iter().filter(|step| !is_pause(step)) {
            stream.extend_from_slice(step);
        }
        self.connection.exchange(&stream).map(drop)
    }

    /// Returns the shared names of all commands, those taken back included.
    fn shared_names(&self) -> Vec<String> {
        let mut names: Vec<String> = self
            .steps
            .iter()
            .chain(&self.undone)
            .filter_map(|step| step.split(|b| b.is_ascii_whitespace()).find(|word| word.starts_with(b"@")))
            .map(|name| String::from_utf8_lossy(name).into_owned())
            .collect();
        names.sort_unstable();
        names.dedup();
        names
    }

    /// Returns the names that the commands have made.
    pub fn names(&self) -> Vec<String> {
        const MAKERS: [&[u8]; 5] = [b"MESH", b"TEX", b"EYE", b"LOAD", b"CANVAS"];
        let mut names = Vec::new();
        for step in &self.steps {
            let mut words = step.split(|b| b.is_ascii_whitespace());
            let verb = words.next().unwrap_or_default();
            let skipped = usize::from(verb.eq_ignore_ascii_case(b"LOAD"));
            if MAKERS.iter().any(|maker| verb.eq_ignore_ascii_case(maker)) {
                names.extend(words.nth(skipped).map(|name| String::from_utf8_lossy(name).into_owned()));
            }
        }
        names
    }
}

/// Returns the first line of a command with its payload.
fn first_line(step: &[u8]) -> std::borrow::Cow<'_, str> {
    String::from_utf8_lossy(step.split(|b| *b == b'\n').next().unwrap_or_default())
}

/// Removes the size that a stream's first command states: here it would not be the first. Returns
/// whether there was one.
pub(super) fn drop_size(stream: &mut Vec<u8>) -> bool {
    let mut at = 0;
    for line in stream.split_inclusive(|&b| b == b'\n') {
        let words: Vec<&[u8]> = line.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty()).collect();
        if matches!(words[..], [verb, _, _] if verb.eq_ignore_ascii_case(b"SIZE")) {
            let end = at + line.len();
            stream.drain(at..end);
            return true;
        }
        if !words.is_empty() && !line.starts_with(b"#") {
            return false;
        }
        at += line.len();
    }
    false
}

/// Returns whether a command only waits.
fn is_pause(step: &[u8]) -> bool {
    step.get(..5).is_some_and(|start| start.eq_ignore_ascii_case(b"WAIT "))
}
