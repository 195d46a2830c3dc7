//! The head of an HTTP/1.1 request, for the small servers of metrics and of the page in the browser.
//!
//! In: bytes up to a request's empty line. Out: its method, target and headers, or the status of
//! the refusal. Promise: only requests whose `Host` is an address, `localhost` or the server's own
//! name are valid, so a web page that points its own name at this address (DNS rebinding) gets
//! nothing. Source: RFC 9112, sections 2, 3 and 5.

use std::net::{Ipv4Addr, Ipv6Addr};

/// Status line and reason of a request that is not served.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Refused {
    /// Code and phrase of the status line.
    pub status: &'static str,
    /// Sentence for whoever reads the body.
    pub reason: &'static str,
}

fn bad(reason: &'static str) -> Refused {
    Refused { status: "400 Bad Request", reason }
}

/// The head of a valid request.
#[derive(Debug)]
pub(super) struct Head<'a> {
    /// True for `GET`, false for `HEAD`.
    pub is_get: bool,
    /// The target up to its query.
    pub path: &'a str,
    /// Headers in their order, values without outer blanks.
    headers: Vec<(&'a str, &'a str)>,
}

impl<'a> Head<'a> {
    /// Parses a head, which ends with an empty line. `own_name` is a host name that requests may
    /// use beside `localhost` and addresses.
    ///
    /// # Errors
    /// The status of the refusal.
    pub fn parse(head: &'a [u8], own_name: Option<&str>) -> Result<Head<'a>, Refused> {
        let text = std::str::from_utf8(head).ok().filter(|text| text.is_ascii());
        let mut lines = text.ok_or_else(|| bad("the request is not ASCII"))?.split("\r\n");
        let words: Vec<&str> = lines.next().unwrap_or_default().split(' ').collect();
        let &[method, target, version] = &words[..] else { return Err(bad("no request line")) };
        if !matches!(version, "HTTP/1.1" | "HTTP/1.0") {
            let status = "505 HTTP Version Not Supported";
            return Err(Refused { status, reason: "HTTP/1.1 is spoken here" });
        }
        let mut headers = Vec::new();
        for line in lines.take_while(|line| !line.is_empty()) {
            let (name, value) = line.split_once(':').ok_or_else(|| bad("a header has no colon"))?;
            if name.is_empty() || name.contains(|c: char| c.is_ascii_whitespace() || c.is_ascii_control()) {
                return Err(bad("a header's name is none"));
            }
            headers.push((name, value.trim_matches([' ', '\t'])));
        }
        let path = target.split('?').next().unwrap_or(target);
        let head = Head { is_get: method == "GET", path, headers };
        match head.values("host").collect::<Vec<_>>()[..] {
            [host] if serves(host, own_name) => {}
            // A request without a name cannot result from DNS rebinding: browsers always send one.
            [] if version == "HTTP/1.0" => {}
            [_] => {
                let reason = "this name is not served: use the address, localhost, or the name that the server \
                              was given";
                return Err(Refused { status: "403 Forbidden", reason });
            }
            _ => return Err(bad("there must be one Host header")),
        }
        if !target.starts_with('/') {
            return Err(bad("the target must be a path"));
        }
        if !matches!(method, "GET" | "HEAD") {
            let status = "405 Method Not Allowed";
            return Err(Refused { status, reason: "GET and HEAD are served" });
        }
        Ok(head)
    }

    /// Returns the values of all headers of a name, which is in lower case.
    pub fn values(&self, name: &str) -> impl Iterator<Item = &'a str> {
        self.headers.iter().filter(move |(n, _)| n.eq_ignore_ascii_case(name)).map(|(_, value)| *value)
    }

    /// Returns the value of a header that is there once.
    #[cfg(feature = "web")]
    pub fn value(&self, name: &str) -> Option<&'a str> {
        let mut values = self.values(name);
        values.next().filter(|_| values.next().is_none())
    }
}

/// Returns whether requests may use this `Host`: an address, `localhost`, or the server's own name,
/// with any port.
fn serves(host: &str, own_name: Option<&str>) -> bool {
    let (name, port) = match host.rsplit_once(':') {
        // Colons of an IPv6 address are inside brackets.
        Some((name, port)) if !port.contains(']') => (name, port),
        _ => (host, "0"),
    };
    let bare = name.strip_prefix('[').and_then(|name| name.strip_suffix(']'));
    let is_address = match bare {
        Some(v6) => v6.parse::<Ipv6Addr>().is_ok(),
        None => name.parse::<Ipv4Addr>().is_ok(),
    };
    let is_own = |own: &str| own.eq_ignore_ascii_case(name);
    port.parse::<u16>().is_ok() && (is_address || is_own("localhost") || own_name.is_some_and(is_own))
}

/// Returns the length of a request's head if it is complete. `from` is the number of bytes that
/// were there at the last call.
pub(super) fn head_length(bytes: &[u8], from: usize) -> Option<usize> {
    // The empty line may have begun in the previous read.
    let from = from.saturating_sub(3);
    bytes.get(from..)?.windows(4).position(|w| w == b"\r\n\r\n").map(|at| from + at + 4)
}
