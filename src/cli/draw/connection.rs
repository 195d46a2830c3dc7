//! One connection of the prompt to the render thread, over pipes: the protocol as every other
//! client speaks it, with its errors and limits.

use crate::cli::replies::{REPORT_ERRORS, announced_bytes};
use crate::server::Server;
use std::io::{self, BufRead, BufReader, PipeReader, PipeWriter, Read, Write};

/// A connection that waits for each command to be done.
pub(super) struct Connection {
    to: PipeWriter,
    from: BufReader<PipeReader>,
    /// Number of the last SYNC.
    syncs: u64,
    /// Number of lines sent.
    lines: u64,
}

/// A line of an answer.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Line {
    /// Line of the commands, from 1, that an error or a warning is about.
    pub number: Option<u64>,
    /// The reply, or the error or warning without its place.
    pub text: String,
}

/// The server's answers to commands.
#[derive(Debug, Default, PartialEq, Eq)]
pub(super) struct Answers {
    /// Lines to show: replies, warnings and errors in order.
    pub lines: Vec<Line>,
    /// True if a command was refused.
    pub is_refused: bool,
    /// True if there was a reply: the command was a question.
    pub is_reply: bool,
    /// True if the commands ended their connection, and were left out.
    pub is_closed: bool,
}

impl Connection {
    /// Connects to a server.
    ///
    /// # Errors
    /// If the system has no pipe or no thread to give.
    pub fn open(server: &Server) -> io::Result<Connection> {
        let (input, to) = io::pipe()?;
        let (from, output) = io::pipe()?;
        server.serve_pipe(Box::new(input), Box::new(output), || ())?;
        let mut connection = Connection { to, from: BufReader::new(from), syncs: 0, lines: 0 };
        connection.exchange(REPORT_ERRORS)?;
        Ok(connection)
    }

    /// Sends whole commands, waits until they are done, and returns the answers.
    ///
    /// # Errors
    /// If the connection has ended.
    pub fn exchange(&mut self, commands: &[u8]) -> io::Result<Answers> {
        self.syncs += 1;
        let end = format!("SYNC prompt{}", self.syncs);
        let before = self.lines;
        self.lines += commands.iter().filter(|&&byte| byte == b'\n').count() as u64 + 1;
        let Connection { to, from, .. } = self;
        std::thread::scope(|scope| {
            // The answers are read meanwhile: a pipe holds only so many of them.
            let sent = scope.spawn(|| {
                to.write_all(commands)?;
                to.write_all(format!("{end}\n").as_bytes())
            });
            let answers = answers(from, &end, before);
            sent.join().unwrap_or_else(|_| Err(io::Error::other("the sender ended")))?;
            answers
        })
    }
}

/// Reads the answers before the line `end`, to commands that `before` lines were sent before.
fn answers(from: &mut impl BufRead, end: &str, before: u64) -> io::Result<Answers> {
    let mut answers = Answers::default();
    loop {
        let mut line = Vec::new();
        if from.read_until(b'\n', &mut line)? == 0 {
            return Err(io::ErrorKind::UnexpectedEof.into());
        }
        let line = String::from_utf8_lossy(line.trim_ascii_end()).into_owned();
        let word = line.split(' ').next().unwrap_or_default();
        match word {
            "SYNC" if line == end => return Ok(answers),
            "ERR" => {
                answers.is_refused = true;
                answers.lines.push(placed(&line, before));
            }
            "WARN" => answers.lines.push(placed(&line, before)),
            // Of `PRESENT wait`, which ends a frame and asks nothing.
            "EVENT" | "FRAME" => {}
            _ => {
                answers.is_reply = true;
                let bytes = announced_bytes(&line);
                if bytes > 0 {
                    io::copy(&mut from.take(bytes), &mut io::sink())?;
                }
                answers.lines.push(Line { number: None, text: line });
            }
        }
    }
}

/// Splits `ERR line byte CODE VERB: message`, or a warning.
fn placed(line: &str, before: u64) -> Line {
    let mut words = line.splitn(4, ' ').skip(1);
    let number = words.next().and_then(|number| number.parse::<u64>().ok());
    let text = words.nth(1).unwrap_or(line).to_owned();
    Line { number: number.map(|number| number.saturating_sub(before)), text }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn answers_end_at_their_own_sync_and_skip_bytes() {
        let mut said =
            &b"ERR 3 17 ENUM LINE: a number, got \"x\"\nREAD 0 0 1 1 :4\nSYN\nSYNC a\nSYNC b\nrest"[..];
        let answers = answers(&mut said, "SYNC b", 2).unwrap();
        let texts: Vec<&str> = answers.lines.iter().map(|line| line.text.as_str()).collect();
        assert_eq!(texts, ["ENUM LINE: a number, got \"x\"", "READ 0 0 1 1 :4", "SYNC a"]);
        assert_eq!(answers.lines[0].number, Some(1), "counted from the commands' own first line");
        assert!(answers.is_refused && answers.is_reply);
        assert_eq!(said, b"rest");
        assert!(super::answers(&mut &b"SYNC b"[..], "SYNC c", 0).is_err());
    }
}
