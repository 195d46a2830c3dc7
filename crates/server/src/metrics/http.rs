//! The metrics endpoint: a small HTTP/1.1 server for `GET /metrics` and `GET /metrics.json` only. A
//! client that accepts `application/json` and no text gets JSON from `/metrics`, too.
//!
//! In: requests on a TCP address of its own. Out: responses made from [`MetricsBoard::read`], with
//! `Connection: close`. Threads: one that accepts, and at most [`MAX_CLIENTS`] that each serve one
//! connection for at most [`PATIENCE`]. Promises: a request has at most [`MAX_HEAD_BYTES`], bodies
//! are not read, and no client takes the place of others for longer than its time. A web page that
//! points its own name at this address (DNS rebinding) gets nothing: only addresses, `localhost`
//! and the endpoint's configured name are served.
//!
//! It does not use a crate, because `tiny_http` limits neither a request's head nor its time, and
//! `hyper` with its dependencies would take longer to build than the rest of the server. Source:
//! RFC 9112, sections 2, 3 and 5.

use super::{MetricsBoard, format};
use crate::http::{Head, Refused, head_length};
use std::io::{self, Read, Write};
use std::net::{IpAddr, Ipv4Addr, Ipv6Addr, Shutdown, SocketAddr, TcpListener, TcpStream};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::thread::{Builder, JoinHandle};
use std::time::{Duration, Instant};

/// Connections that are served at one time, at most.
const MAX_CLIENTS: usize = 8;
/// Most bytes of a request up to its empty line.
const MAX_HEAD_BYTES: usize = 4096;
/// Longest time of one connection, from its first byte to its last.
const PATIENCE: Duration = Duration::from_secs(3);
const STACK_BYTES: usize = 128 << 10;

/// The metrics endpoint. Dropping it ends it.
#[derive(Debug)]
pub struct MetricsServer {
    address: SocketAddr,
    is_ending: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl MetricsServer {
    /// Descriptors that it has open at most: the listener, its clients, and one that is refused.
    pub const MAX_FILES: usize = MAX_CLIENTS + 2;

    /// Serves `board` at `address`. `name` is a host name that requests may use beside `localhost`
    /// and addresses.
    ///
    /// # Errors
    /// If the address cannot be bound, or the system has no thread to give.
    pub fn start(address: SocketAddr, name: Option<&str>, board: Arc<MetricsBoard>) -> io::Result<Self> {
        let listener = TcpListener::bind(address)?;
        let address = listener.local_addr()?;
        let is_ending = Arc::new(AtomicBool::new(false));
        let site = Arc::new(Site { board, name: name.map(str::to_owned) });
        let is_over = is_ending.clone();
        let accept = move || accept_all(&listener, &site, &is_over);
        let thread = Builder::new().name("metrics".into()).stack_size(STACK_BYTES).spawn(accept)?;
        Ok(MetricsServer { address, is_ending, thread: Some(thread) })
    }

    /// Returns the address, with the port that the system chose for port 0.
    pub fn address(&self) -> SocketAddr {
        self.address
    }
}

impl Drop for MetricsServer {
    fn drop(&mut self) {
        self.is_ending.store(true, Ordering::Release);
        let mut address = self.address;
        match address.ip() {
            IpAddr::V4(ip) if ip.is_unspecified() => address.set_ip(Ipv4Addr::LOCALHOST.into()),
            IpAddr::V6(ip) if ip.is_unspecified() => address.set_ip(Ipv6Addr::LOCALHOST.into()),
            _ => {}
        }
        // Wakes the thread. If that fails, it sleeps on, and ends with the process.
        let is_woken = TcpStream::connect_timeout(&address, Duration::from_millis(300)).is_ok();
        if is_woken && let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

fn accept_all(listener: &TcpListener, site: &Arc<Site>, is_ending: &AtomicBool) {
    let clients = Arc::new(AtomicUsize::new(0));
    loop {
        let accepted = listener.accept();
        if is_ending.load(Ordering::Acquire) {
            return;
        }
        // No descriptor or memory is left: other connections may end soon.
        let Ok((stream, _)) = accepted else {
            std::thread::sleep(Duration::from_millis(20));
            continue;
        };
        if clients.fetch_add(1, Ordering::AcqRel) >= MAX_CLIENTS {
            clients.fetch_sub(1, Ordering::AcqRel);
            continue;
        }
        let (site, place) = (site.clone(), ClientSlot(clients.clone()));
        let serve = move || {
            let _place = place;
            // A client that has gone does not need an answer.
            let _ = site.serve(stream);
        };
        // If there is no thread, the connection is closed and its place freed.
        let _ = Builder::new().name("metrics client".into()).stack_size(STACK_BYTES).spawn(serve);
    }
}

/// A place among the connections that are served, which is freed when this is dropped.
struct ClientSlot(Arc<AtomicUsize>);

impl Drop for ClientSlot {
    fn drop(&mut self) {
        self.0.fetch_sub(1, Ordering::AcqRel);
    }
}

struct Site {
    board: Arc<MetricsBoard>,
    name: Option<String>,
}

/// A valid request.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Request<'a> {
    path: &'a str,
    wants_body: bool,
    /// True if the accepted media types prefer JSON to text.
    prefers_json: bool,
}

/// Status line, media type and body of a response.
struct Response {
    status: &'static str,
    media_type: &'static str,
    body: String,
}

impl Response {
    fn refusal(status: &'static str, reason: &str) -> Response {
        Response { status, media_type: "text/plain; charset=utf-8", body: format!("{reason}\n") }
    }
}

impl Site {
    fn serve(&self, mut stream: TcpStream) -> io::Result<()> {
        let until = Instant::now() + PATIENCE;
        let mut head = [0; MAX_HEAD_BYTES];
        let (response, wants_body) = match read_head(&mut stream, &mut head, until)? {
            None => {
                (Response::refusal("431 Request Header Fields Too Large", "the request is too long"), true)
            }
            Some(length) => match self.parse(&head[..length]) {
                Ok(request) => (self.respond(&request), request.wants_body),
                Err(refusal) => (refusal, true),
            },
        };
        let Response { status, media_type, body } = response;
        let allow = if status.starts_with("405") { "Allow: GET, HEAD\r\n" } else { "" };
        let mut text = format!(
            "HTTP/1.1 {status}\r\nContent-Type: {media_type}\r\nContent-Length: {}\r\n{allow}\
             Cache-Control: no-store\r\nVary: Accept\r\nX-Content-Type-Options: nosniff\r\nConnection: close\r\n\r\n",
            body.len()
        );
        if wants_body {
            text.push_str(&body);
        }
        write_all(&mut stream, text.as_bytes(), until)?;
        stream.shutdown(Shutdown::Write)?;
        // A socket that is closed with unread bytes is reset, and the response may be lost.
        let mut rest = [0; 512];
        for _ in 0..16 {
            stream.set_read_timeout(Some(time_left(until)?))?;
            if stream.read(&mut rest)? == 0 {
                break;
            }
        }
        Ok(())
    }

    fn respond(&self, request: &Request) -> Response {
        match request.path {
            "/metrics" if !request.prefers_json => {
                let body = format::prometheus(&self.board.read());
                Response { status: "200 OK", media_type: format::PROMETHEUS_TYPE, body }
            }
            "/metrics" | "/metrics.json" => {
                let body = format::json(&self.board.read());
                Response { status: "200 OK", media_type: "application/json", body }
            }
            _ => Response::refusal("404 Not Found", "there are /metrics and /metrics.json"),
        }
    }

    /// Parses a request's head, which ends with an empty line. Returns the response if it is not
    /// valid.
    fn parse<'a>(&self, head: &'a [u8]) -> Result<Request<'a>, Response> {
        let head = Head::parse(head, self.name.as_deref())
            .map_err(|Refused { status, reason }| Response::refusal(status, reason))?;
        let accepted: Vec<&str> = head.values("accept").flat_map(|value| value.split(',')).collect();
        Ok(Request { path: head.path, wants_body: head.is_get, prefers_json: prefers_json(&accepted) })
    }
}

/// Returns whether a client that accepts these media ranges prefers JSON to text (RFC 9110, section
/// 12.5.1). If it accepts both equally, or sends none, it gets text, which Prometheus' servers
/// expect.
fn prefers_json(accepted: &[&str]) -> bool {
    // The quality of a media type is that of the most specific range that contains it.
    let quality = |media: &str, kind: &str| {
        let of = |range: &&str| {
            let mut parts = range.split(';').map(|part| part.trim_matches([' ', '\t']));
            let name = parts.next().unwrap_or_default().to_ascii_lowercase();
            let precision = [media, kind, "*/*"].into_iter().rev().position(|known| known == name)?;
            let weight = parts.find_map(|part| part.strip_prefix("q=").or_else(|| part.strip_prefix("Q=")));
            Some((precision, weight.map_or(Some(1.0), |w| w.parse::<f64>().ok()).unwrap_or(0.0)))
        };
        accepted.iter().filter_map(of).max_by_key(|(precision, _)| *precision).map_or(0.0, |(_, q)| q)
    };
    quality("application/json", "application/*") > quality("text/plain", "text/*")
}

/// Reads up to the empty line that ends a request's head. Returns its length, or `None` if it is
/// too long.
fn read_head(stream: &mut TcpStream, head: &mut [u8], until: Instant) -> io::Result<Option<usize>> {
    let mut length = 0;
    loop {
        if length == head.len() {
            return Ok(None);
        }
        stream.set_read_timeout(Some(time_left(until)?))?;
        let filled = stream.read(&mut head[length..])?;
        if filled == 0 {
            return Err(io::ErrorKind::UnexpectedEof.into());
        }
        let from = length;
        length += filled;
        if let Some(end) = head_length(&head[..length], from) {
            return Ok(Some(end));
        }
    }
}

fn write_all(stream: &mut TcpStream, mut bytes: &[u8], until: Instant) -> io::Result<()> {
    while !bytes.is_empty() {
        stream.set_write_timeout(Some(time_left(until)?))?;
        match stream.write(bytes)? {
            0 => return Err(io::ErrorKind::WriteZero.into()),
            written => bytes = &bytes[written..],
        }
    }
    Ok(())
}

/// Returns the time left.
///
/// # Errors
/// [`io::ErrorKind::TimedOut`] if none is left.
fn time_left(until: Instant) -> io::Result<Duration> {
    match until.saturating_duration_since(Instant::now()) {
        Duration::ZERO => Err(io::ErrorKind::TimedOut.into()),
        left => Ok(left),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn status(head: &str) -> &'static str {
        let site = Site { board: MetricsBoard::new(), name: Some("wall.example".into()) };
        match site.parse(head.as_bytes()) {
            Ok(request) => site.respond(&request).status,
            Err(refusal) => refusal.status,
        }
    }

    #[test]
    fn hosts_that_are_names_of_others_are_refused() {
        for host in [
            "127.0.0.1",
            "127.0.0.1:9100",
            "[::1]:9100",
            "[::1]",
            "localhost",
            "LOCALHOST:1",
            "Wall.example:9",
        ] {
            assert_eq!(status(&format!("GET /metrics HTTP/1.1\r\nHost: {host}\r\n\r\n")), "200 OK", "{host}");
        }
        for host in [
            "evil.example",
            "localhost.evil.example",
            "127.0.0.1.evil.example",
            "",
            ":9100",
            "[::1",
            "::1",
            "[::1]x",
            "127.0.0.1:x",
            "127.0.0.1:99999",
            "localhost:",
            "[localhost]",
            "127.0.0.1, evil.example",
            "a@127.0.0.1",
        ] {
            let head = format!("GET /metrics HTTP/1.1\r\nHost: {host}\r\n\r\n");
            assert_eq!(status(&head), "403 Forbidden", "{host}");
        }
        assert_eq!(status("GET /metrics HTTP/1.1\r\n\r\n"), "400 Bad Request");
        assert_eq!(status("GET /metrics HTTP/1.0\r\n\r\n"), "200 OK");
        assert_eq!(
            status("GET /metrics HTTP/1.1\r\nHost: localhost\r\nhost: evil.example\r\n\r\n"),
            "400 Bad Request"
        );
    }

    #[test]
    fn other_requests_have_their_status() {
        let status = |line: &str| status(&format!("{line}\r\nHost: localhost\r\n\r\n"));
        assert_eq!(status("GET /metrics?x=1 HTTP/1.1"), "200 OK");
        assert_eq!(status("HEAD /metrics.json HTTP/1.0"), "200 OK");
        assert_eq!(status("GET / HTTP/1.1"), "404 Not Found");
        assert_eq!(status("GET /metrics/../metrics HTTP/1.1"), "404 Not Found");
        assert_eq!(status("POST /metrics HTTP/1.1"), "405 Method Not Allowed");
        assert_eq!(status("GET http://localhost/metrics HTTP/1.1"), "400 Bad Request");
        assert_eq!(status("GET /metrics HTTP/2.0"), "505 HTTP Version Not Supported");
        for line in
            ["GET /metrics", "GET  /metrics HTTP/1.1", "", "\u{e9} / HTTP/1.1", "GET /metrics HTTP/1.1 "]
        {
            assert_eq!(status(line), "400 Bad Request", "{line}");
        }
        assert_eq!(status("GET /metrics HTTP/1.1\r\n folded: x"), "400 Bad Request");
        assert_eq!(status("GET /metrics HTTP/1.1\r\nno colon"), "400 Bad Request");
        assert_eq!(status("GET /metrics HTTP/1.1\r\nHost : evil.example"), "400 Bad Request");
    }
}
