//! Detection of connections that speak another protocol, by their first bytes.
//!
//! In: the first bytes of a TCP connection, split anywhere. Out: whether they begin an HTTP request
//! or a TLS handshake. A web page can make a browser connect to any host and port and send a
//! request whose body the page has written; if the lines of the request's head were only unknown
//! verbs, the body would run as commands. No verb begins like a request, so no client of this
//! protocol is refused by mistake, and nothing of a request's first line can have taken effect
//! before it is detected.

use fbptr_command::Verb;

/// First bytes of a request, in any case, longest last: the methods that a browser sends by itself
/// or for a page, and the preface of HTTP/2. Any other word is a method if ` HTTP/1.1` or a similar
/// version ends its line.
const REQUESTS: [&[u8]; 10] = [
    b"GET ",
    b"PUT ",
    b"POST ",
    b"HEAD ",
    b"PATCH ",
    b"TRACE ",
    b"DELETE ",
    b"OPTIONS ",
    b"CONNECT ",
    b"PRI * HTTP/2",
];
/// End of a request's first line; `0` stands for a digit.
const REQUEST_END: &[u8; 9] = b" HTTP/0.0";
/// Longest first line of a request in bytes. The decoder accepts no longer lines either.
const MAX_LINE_BYTES: u64 = 4096;
/// First bytes of a TLS record: type handshake, and the version's high byte.
const TLS_HANDSHAKE: &[u8] = &[0x16, 0x03];
const LONGEST: usize = 12;

/// A protocol other than that of this server.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Foreign {
    /// HTTP, version 2 included.
    Http,
    /// TLS, whatever its content is.
    Tls,
}

impl Foreign {
    /// Returns the bytes that are sent to the client before the connection ends.
    pub fn reply(self) -> String {
        match self {
            Foreign::Http => {
                let body = "This port speaks fbptr's command protocol (Pixelflut and more), not HTTP: nothing of \
                            this request was run. From a shell: printf 'HELP\\n' | nc HOST PORT\n";
                format!(
                    "HTTP/1.1 400 Bad Request\r\nContent-Type: text/plain; charset=utf-8\r\n\
                     Content-Length: {}\r\nX-Content-Type-Options: nosniff\r\nCache-Control: no-store\r\n\
                     Connection: close\r\n\r\n{body}",
                    body.len()
                )
            }
            Foreign::Tls => "ERR 1 0 EPROTO CONNECT: this port speaks plain text, not TLS\n".to_owned(),
        }
    }
}

/// Result of reading the first bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Verdict {
    /// No decision: the bytes so far could begin either.
    Undecided,
    /// The connection speaks this server's protocol.
    Ours,
    /// The connection speaks another protocol.
    Foreign(Foreign),
}

/// Detector for the first bytes of one connection.
#[derive(Debug, Default)]
pub(crate) struct Sniffer {
    /// The first bytes, up to the longest pattern, and their number.
    seen: [u8; LONGEST],
    length: usize,
    /// The last bytes, without line ends.
    tail: [u8; REQUEST_END.len()],
    /// Number of bytes read.
    total: u64,
    /// Set when the first word is complete and is not a verb.
    has_method: bool,
}

impl Sniffer {
    /// Reads bytes of the stream, of which the first is at position `place`; bytes that it has read
    /// before are skipped. To be called until it returns a decision.
    pub fn look(&mut self, place: u64, bytes: &[u8]) -> Verdict {
        let seen_before = usize::try_from(self.total.saturating_sub(place)).unwrap_or(bytes.len());
        for &byte in bytes.get(seen_before..).unwrap_or(&[]) {
            let verdict = self.take(byte);
            if verdict != Verdict::Undecided {
                return verdict;
            }
        }
        Verdict::Undecided
    }

    fn take(&mut self, byte: u8) -> Verdict {
        self.total += 1;
        if self.length < LONGEST {
            self.seen[self.length] = byte;
            self.length += 1;
        }
        let seen = &self.seen[..self.length];
        let is_start = self.total <= LONGEST as u64;
        if is_start && REQUESTS.iter().any(|request| begins_with(seen, request)) {
            return Verdict::Foreign(Foreign::Http);
        }
        if is_start && begins_with(seen, TLS_HANDSHAKE) {
            return Verdict::Foreign(Foreign::Tls);
        }
        if byte == b'\n' {
            return match self.has_method && is_request_end(&self.tail) {
                true => Verdict::Foreign(Foreign::Http),
                false => Verdict::Ours,
            };
        }
        if byte != b'\r' {
            self.tail.rotate_left(1);
            self.tail[REQUEST_END.len() - 1] = byte;
        }
        let may_become = |prefix: &&[u8]| begins_with(prefix, seen);
        let may_be_known = is_start && REQUESTS.iter().chain([&TLS_HANDSHAKE]).any(may_become);
        let may_be_other = self.total <= MAX_LINE_BYTES && (self.has_method || self.may_be_method(byte));
        match may_be_known || may_be_other {
            true => Verdict::Undecided,
            false => Verdict::Ours,
        }
    }

    /// Returns whether the first word may be an HTTP method that ends, or continues, with `byte`.
    /// Binary commands follow their names without a blank, so they are none.
    fn may_be_method(&mut self, byte: u8) -> bool {
        let seen = &self.seen[..self.length];
        if begins_with(seen, b"PB") || begins_with(seen, b"PX") || self.total > LONGEST as u64 {
            return false;
        }
        let is_end = byte == b' ';
        self.has_method = is_end && self.length > 1 && Verb::find(&seen[..self.length - 1]).is_none();
        self.has_method || byte.is_ascii_alphabetic()
    }
}

/// Returns whether a line with this end is the first line of a request.
fn is_request_end(tail: &[u8; REQUEST_END.len()]) -> bool {
    let fits = |(&byte, &wanted): (&u8, &u8)| match wanted {
        b'0' => byte.is_ascii_digit(),
        _ => byte.eq_ignore_ascii_case(&wanted),
    };
    tail.iter().zip(REQUEST_END).all(fits)
}

/// Returns whether `bytes` begin with `prefix`, ignoring case.
fn begins_with(bytes: &[u8], prefix: &[u8]) -> bool {
    bytes.get(..prefix.len()).is_some_and(|start| start.eq_ignore_ascii_case(prefix))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the verdict on a stream in pieces of `cut` bytes, each of which is read twice.
    fn verdict(bytes: &[u8], cut: usize) -> Verdict {
        let (mut sniffer, mut place) = (Sniffer::default(), 0);
        let mut last = Verdict::Undecided;
        for piece in bytes.chunks(cut) {
            for _ in 0..2 {
                last = sniffer.look(place, piece);
                if last != Verdict::Undecided {
                    return last;
                }
            }
            place += piece.len() as u64;
        }
        last
    }

    #[test]
    fn requests_are_known_however_they_are_cut() {
        for request in REQUESTS {
            let whole = [request, b"/ HTTP/1.1\r\nHost: a\r\n\r\nPX 1 1 ff0000\n"].concat();
            for cut in 1..whole.len() {
                assert_eq!(verdict(&whole, cut), Verdict::Foreign(Foreign::Http), "{request:?} by {cut}");
                let lower = whole.to_ascii_lowercase();
                assert_eq!(verdict(&lower, cut), Verdict::Foreign(Foreign::Http), "{request:?} by {cut}");
            }
            assert_eq!(verdict(&request[..request.len() - 1], 1), Verdict::Undecided, "{request:?}");
        }
        for cut in 1..4 {
            assert_eq!(verdict(&[0x16, 0x03, 0x01, 0x02], cut), Verdict::Foreign(Foreign::Tls));
        }
    }

    #[test]
    fn no_verb_and_no_other_word_is_mistaken() {
        let verbs = Verb::all().iter().flat_map(|verb| {
            [format!("{}\n", verb.name), format!("{} 1\n", verb.name.to_lowercase())].map(String::into_bytes)
        });
        let others = [
            "PX 1 1 ff0000\n",
            "GETTER 1\n",
            "GET\n",
            "gets / HTTP/1.1 \n",
            "TEXT 1 1 ffffff / HTTP/1.1\n",
            "FOO HTTP/1\nFOO / HTTP/1.1\n",
            "POSTER\n",
            "PRI * X\n",
            "#GET \n",
            "\nGET /\n",
            " GET /\n",
            "PUT\n",
            "\x16\n",
            "PB\x03\x00\x01\x01abcd",
            "PXMULTI\x00\x00",
        ];
        for stream in verbs.chain(others.map(|o| o.as_bytes().to_vec())) {
            for cut in 1..=stream.len() {
                assert_eq!(verdict(&stream, cut), Verdict::Ours, "{stream:?} by {cut}");
            }
        }
    }

    #[test]
    fn other_methods_are_known_by_the_end_of_their_line() {
        for line in ["PROPFIND /a HTTP/1.1\r\n", "foo / HTTP/1.0\n", "BREW pot HTTP/2.0\r\n"] {
            let whole = format!("{line}Host: a\r\n\r\nPX 1 1 ff0000\n").into_bytes();
            for cut in 1..whole.len() {
                assert_eq!(verdict(&whole, cut), Verdict::Foreign(Foreign::Http), "{line:?} by {cut}");
            }
            assert_eq!(verdict(&line.as_bytes()[..line.len() - 1], 3), Verdict::Undecided, "{line:?}");
        }
        let long = [b"FOO ".as_slice(), &[b'x'; 5000], b" HTTP/1.1\n"].concat();
        assert_eq!(verdict(&long, 100), Verdict::Ours);
    }

    #[test]
    fn nothing_that_is_undecided_can_have_run() {
        assert!(REQUESTS.iter().all(|request| request.len() <= LONGEST && !request.contains(&b'\n')));
    }

    #[test]
    fn the_reply_is_one_whole_http_response() {
        let reply = Foreign::Http.reply();
        let (head, body) = reply.split_once("\r\n\r\n").unwrap();
        assert!(head.starts_with("HTTP/1.1 400 Bad Request\r\n"));
        assert!(head.contains(&format!("Content-Length: {}\r\n", body.len())), "{head}");
        assert!(body.is_ascii() && body.lines().count() == 1);
    }
}
