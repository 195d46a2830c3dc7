//! Recognizes connections that speak another protocol than ours by their first bytes.
//!
//! In: the first bytes of a TCP connection, however they are cut. Out: whether they begin an HTTP request or a TLS
//! handshake. A page in somebody's browser can make it open a connection to any host and port and send a request whose
//! body the page has written; were the request's lines merely unknown verbs, the body would run as commands. No verb
//! begins like this, so no client of ours is mistaken, and nothing of a request's first line can have taken effect by then.

use crate::command::Verb;

/// The first bytes that begin a request, in any case, longest last. Methods are those that a browser sends by itself or for
/// a page, and the preface of HTTP/2. Any other word is a method where ` HTTP/1.1` or the like ends its line.
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
/// The end of a request's first line; `0` stands for a digit.
const REQUEST_END: &[u8; 9] = b" HTTP/0.0";
/// Longer first lines are no requests: the decoder takes none of them.
const MAX_LINE_BYTES: u64 = 4096;
/// A TLS record of type handshake and its version's high byte.
const TLS_HANDSHAKE: &[u8] = &[0x16, 0x03];
const LONGEST: usize = 12;

/// A protocol that is not ours.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Foreign {
    /// HTTP, version 2 included.
    Http,
    /// TLS, and whatever is inside.
    Tls,
}

impl Foreign {
    /// What the other side is told before the connection ends.
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

/// What the first bytes tell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Verdict {
    /// Nothing yet: all bytes so far could begin either.
    Undecided,
    /// The connection is not foreign.
    Ours,
    /// It is.
    Foreign(Foreign),
}

/// Looks at the first bytes of one connection.
#[derive(Debug, Default)]
pub(crate) struct Sniffer {
    /// The first bytes, as many as are wanted, and how many they are.
    seen: [u8; LONGEST],
    length: usize,
    /// The last bytes but line ends.
    tail: [u8; REQUEST_END.len()],
    /// Bytes looked at.
    total: u64,
    /// The first word is over, and no verb.
    has_method: bool,
}

impl Sniffer {
    /// Looks at bytes of the stream that begin at `place`; what it has seen before may be among them. To be asked until it
    /// has decided.
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

    /// Whether the first word may be a method of HTTP that ends, or goes on, with `byte`. Binary commands follow their names
    /// without a blank.
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

/// Whether a line with this end is a request's.
fn is_request_end(tail: &[u8; REQUEST_END.len()]) -> bool {
    let fits = |(&byte, &wanted): (&u8, &u8)| match wanted {
        b'0' => byte.is_ascii_digit(),
        _ => byte.eq_ignore_ascii_case(&wanted),
    };
    tail.iter().zip(REQUEST_END).all(fits)
}

/// Whether `bytes` begin with `prefix`, letters in any case.
fn begins_with(bytes: &[u8], prefix: &[u8]) -> bool {
    bytes.get(..prefix.len()).is_some_and(|start| start.eq_ignore_ascii_case(prefix))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The verdict on a stream that comes in pieces, each of which is looked at twice.
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
