//! `fbptr send`: sends a stream to a running server, and prints its replies.

use super::args::address::{self, ServerAddress};
use super::magic::CommandInput;
use super::output::Stdout;
use super::play::open_stream;
use super::progress::Watched;
use super::replies::{PREFACE, Replies};
use super::{Status, say_as_program};
use clap::Args;
use std::io::{self, Read, Write};
use std::net::{Shutdown, TcpStream};
#[cfg(unix)]
use std::os::unix::net::UnixStream;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Send a stream to a running server.
#[derive(Debug, Args)]
pub struct Send {
    /// The server: HOST:PORT, :PORT, or the path of a Unix socket
    #[arg(value_name = "ADDR")]
    address: String,
    /// The stream; `-` or nothing is standard input
    #[arg(value_name = "FILE")]
    file: Option<PathBuf>,
}

impl Send {
    /// Sends the stream and prints all replies; fails if one of them is an error.
    pub(super) fn run(self) -> Status {
        if Path::new(&self.address).is_file() {
            let file = &self.address;
            say_as_program(format_args!(
                "{file} is a file: the server stands before it, as in `fbptr send :1234 {file}`"
            ));
            return Status::BadArguments;
        }
        let target = match address::target(&self.address) {
            Ok(target) => target,
            Err(message) => {
                say_as_program(message);
                return Status::BadArguments;
            }
        };
        let is_foreign = Arc::new(AtomicBool::new(false));
        let (mut input, name): (Box<dyn Read>, _) = match &self.file {
            Some(path) if path != Path::new("-") => match open_stream(path, &path.display().to_string()) {
                Ok((file, len)) => {
                    (Box::new(Watched::new(file, len.unwrap_or(0))), path.display().to_string())
                }
                Err(message) => {
                    say_as_program(message);
                    return Status::BadArguments;
                }
            },
            _ => (Box::new(CommandInput::new(io::stdin(), is_foreign.clone())), "-".to_owned()),
        };
        let mut wire = match Wire::connect(&target) {
            Ok(wire) => wire,
            Err(e) => {
                say_as_program(address::no_server(&self.address, &e));
                return Status::Failed;
            }
        };
        let Ok(replies) = wire.try_clone() else { return Status::Failed };
        let printer = std::thread::spawn(move || print(replies));
        let mut buffer = vec![0; 1 << 16];
        // Otherwise errors of a stream that Pixelflut has as well would be counted only.
        let mut sent = wire.write_all(PREFACE).map_err(|e| (self.address.clone(), e));
        while sent.is_ok() {
            match input.read(&mut buffer) {
                Ok(0) => break,
                Ok(n) => sent = wire.write_all(&buffer[..n]).map_err(|e| (self.address.clone(), e)),
                Err(e) if e.kind() == io::ErrorKind::Interrupted => {}
                Err(e) => sent = Err((name.clone(), e)),
            }
        }
        wire.finish();
        let (has_errors, foreign) = printer.join().unwrap_or((true, None));
        if let Some(found) = foreign {
            say_as_program(format_args!("{}: expected a fbptr server, found {found:?}", self.address));
            return Status::Failed;
        }
        match sent {
            // The server may close first: after QUIT that is no error.
            Err((_, e)) if is_hang_up(&e) => {}
            Err((place, e)) => {
                say_as_program(format_args!("{place}: {e}"));
                return Status::Failed;
            }
            Ok(()) => {}
        }
        if has_errors || is_foreign.load(Ordering::Acquire) { Status::Failed } else { Status::Success }
    }
}

/// Returns whether an error means that the other side closed the connection.
fn is_hang_up(e: &io::Error) -> bool {
    matches!(e.kind(), io::ErrorKind::BrokenPipe | io::ErrorKind::ConnectionReset)
}

/// Prints replies on standard output. Returns whether one of their lines was an error, and the first
/// line of what is no server of this program.
fn print(mut wire: Wire) -> (bool, Option<String>) {
    let (mut buffer, mut text, mut replies) = (vec![0; 1 << 16], Vec::new(), Replies::default());
    let mut out = Stdout;
    let mut is_heard = true;
    loop {
        let count = match wire.read(&mut buffer) {
            Ok(count) => count,
            Err(e) if e.kind() == io::ErrorKind::Interrupted => continue,
            Err(_) => 0,
        };
        text.clear();
        let mut foreign = None;
        match count {
            0 => foreign = replies.finish(&mut text),
            _ => replies.take(&buffer[..count], &mut text),
        }
        is_heard = is_heard && out.write_all(&text).and_then(|()| out.flush()).is_ok();
        if count == 0 {
            return (replies.has_errors, foreign);
        }
    }
}

/// A connection to a server.
pub(super) enum Wire {
    Tcp(TcpStream),
    #[cfg(unix)]
    Unix(UnixStream),
}

impl Wire {
    pub fn connect(target: &ServerAddress) -> io::Result<Wire> {
        match target {
            ServerAddress::Tcp(address) => {
                let stream = TcpStream::connect(address)?;
                stream.set_nodelay(true)?;
                Ok(Wire::Tcp(stream))
            }
            #[cfg(unix)]
            ServerAddress::Unix(path) => UnixStream::connect(path).map(Wire::Unix),
            #[cfg(not(unix))]
            ServerAddress::Unix(_) => {
                Err(io::Error::new(io::ErrorKind::Unsupported, "this system has no unix sockets"))
            }
        }
    }

    fn try_clone(&self) -> io::Result<Wire> {
        match self {
            Wire::Tcp(s) => s.try_clone().map(Wire::Tcp),
            #[cfg(unix)]
            Wire::Unix(s) => s.try_clone().map(Wire::Unix),
        }
    }

    /// Closes the sending direction.
    pub fn finish(&self) {
        let _ = match self {
            Wire::Tcp(s) => s.shutdown(Shutdown::Write),
            #[cfg(unix)]
            Wire::Unix(s) => s.shutdown(Shutdown::Write),
        };
    }
}

impl Read for Wire {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        match self {
            Wire::Tcp(s) => s.read(buffer),
            #[cfg(unix)]
            Wire::Unix(s) => s.read(buffer),
        }
    }
}

impl Write for Wire {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        match self {
            Wire::Tcp(s) => s.write(bytes),
            #[cfg(unix)]
            Wire::Unix(s) => s.write(bytes),
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}
