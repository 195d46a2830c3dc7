//! `fbptr playground`: the page with the engine in it, served on this machine without a network.
//!
//! In: requests on a loopback address. Out: one built-in page for `GET /`. One connection is served
//! at a time, for at most [`PATIENCE`]. Promises: a request has at most [`MAX_HEAD_BYTES`], bodies
//! are not read, and a page that points its own name at this address (DNS rebinding) gets nothing.

use super::{Status, output, say_as_program};
use clap::Args;
use std::io::{self, Read, Write};
use std::net::{Ipv4Addr, TcpListener, TcpStream};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// The page, as gzip.
const PAGE: &[u8] = include_bytes!(concat!(env!("OUT_DIR"), "/playground.html.gz"));
/// Most bytes of a request up to its empty line.
const MAX_HEAD_BYTES: usize = 4096;
/// Longest time of one connection.
const PATIENCE: Duration = Duration::from_secs(3);

/// Draw in a browser, with the engine in the page.
#[derive(Debug, Args)]
pub struct Playground {
    /// Port on 127.0.0.1; 0 is any that is free
    #[arg(long, value_name = "PORT", default_value = "0")]
    port: u16,
    /// Open the page in the browser, too
    #[arg(long)]
    open: bool,
}

impl Playground {
    /// Serves the page until the program is ended by a signal.
    pub(super) fn run(self) -> Status {
        let listener = match TcpListener::bind((Ipv4Addr::LOCALHOST, self.port)) {
            Ok(listener) => listener,
            Err(e) => {
                say_as_program(format_args!("127.0.0.1:{}: {e}", self.port));
                return Status::Failed;
            }
        };
        let Ok(address) = listener.local_addr() else { return Status::Failed };
        let link = format!("http://{address}/");
        output::print(format!("{link}\n"));
        if self.open {
            open(&link);
        }
        let mut page = Vec::new();
        if let Err(e) = flate2::read::GzDecoder::new(PAGE).read_to_end(&mut page) {
            say_as_program(format_args!("the page: {e}"));
            return Status::Failed;
        }
        for connection in listener.incoming().flatten() {
            // Whoever asks and goes away loses his own answer alone.
            let _ = answer(connection, &page);
        }
        Status::Success
    }
}

/// Asks the desktop to show a page.
fn open(link: &str) {
    let opener = match std::env::consts::OS {
        "macos" => "open",
        "windows" => "explorer",
        _ => "xdg-open",
    };
    let quiet = Command::new(opener).arg(link).stdin(Stdio::null()).stdout(Stdio::null()).spawn();
    if let Err(e) = quiet {
        say_as_program(format_args!("{opener}: {e}; open {link} in a browser"));
    }
}

/// Reads a request's head and writes its answer.
fn answer(mut connection: TcpStream, page: &[u8]) -> io::Result<()> {
    let end = Instant::now() + PATIENCE;
    let mut head = Vec::new();
    while !head.windows(4).any(|w| w == b"\r\n\r\n") {
        let left = end.saturating_duration_since(Instant::now());
        if left.is_zero() || head.len() >= MAX_HEAD_BYTES {
            return Ok(());
        }
        connection.set_read_timeout(Some(left))?;
        let mut part = [0; 1024];
        match connection.read(&mut part)? {
            0 => return Ok(()),
            length => head.extend_from_slice(&part[..length]),
        }
    }
    connection.set_write_timeout(Some(PATIENCE))?;
    let (status, kind, body) = match requested(&head) {
        Some("/" | "/index.html") => ("200 OK", "text/html; charset=utf-8", page),
        Some(_) => ("404 Not Found", "text/plain", &b"only / is here\n"[..]),
        None => ("400 Bad Request", "text/plain", &b"expected GET / from this machine\n"[..]),
    };
    let length = body.len();
    write!(
        connection,
        "HTTP/1.1 {status}\r\nContent-Type: {kind}\r\nContent-Length: {length}\r\n\
         X-Content-Type-Options: nosniff\r\nConnection: close\r\n\r\n"
    )?;
    connection.write_all(body)
}

/// Returns the path that a request gets, if it is a GET for a name of this machine.
fn requested(head: &[u8]) -> Option<&str> {
    let head = std::str::from_utf8(head).ok()?;
    let mut lines = head.split("\r\n");
    let mut words = lines.next()?.split(' ');
    let (method, path, version) = (words.next()?, words.next()?, words.next()?);
    let mut hosts =
        lines.filter_map(|line| line.split_once(':')).filter(|(name, _)| name.eq_ignore_ascii_case("host"));
    let (_, host) = hosts.next()?;
    let name = host.trim().rsplit_once(':').map_or(host.trim(), |(name, _)| name);
    let is_local = matches!(name, "127.0.0.1" | "localhost") && hosts.next().is_none();
    let path = path.split('?').next()?;
    (method == "GET" && version.starts_with("HTTP/1.") && is_local).then_some(path)
}
