//! Recognizes connections that speak another protocol than ours by their first bytes.
//!
//! In: the first bytes of a TCP connection, however they are cut. Out: whether they begin an HTTP request or a TLS
//! handshake. A page in somebody's browser can make it open a connection to any host and port and send a request whose
//! body the page has written; were the request's lines merely unknown verbs, the body would run as commands. No verb
//! begins like this, so no client of ours is mistaken, and nothing of a method's name can have taken effect by then: it has
//! no LF.

/// The first bytes that begin a request, in any case, longest last. Methods are those that a browser sends by itself or for
/// a page (any other is preceded by an OPTIONS request of the browser's own), and the preface of HTTP/2.
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
    seen: [u8; LONGEST],
    length: usize,
}

impl Sniffer {
    /// Looks at bytes of the stream that begin at `place`; what it has seen before may be among them. To be asked until it
    /// has decided.
    pub fn look(&mut self, place: u64, bytes: &[u8]) -> Verdict {
        let seen_before = usize::try_from((self.length as u64).saturating_sub(place)).unwrap_or(bytes.len());
        let bytes = bytes.get(seen_before..).unwrap_or(&[]);
        let taken = bytes.len().min(LONGEST - self.length);
        self.seen[self.length..self.length + taken].copy_from_slice(&bytes[..taken]);
        self.length += taken;
        let seen = &self.seen[..self.length];
        let is = |prefix: &[u8]| begins_with(seen, prefix);
        if REQUESTS.iter().any(|request| is(request)) {
            return Verdict::Foreign(Foreign::Http);
        }
        if is(TLS_HANDSHAKE) {
            return Verdict::Foreign(Foreign::Tls);
        }
        let may_become = |prefix: &&[u8]| begins_with(prefix, seen);
        match REQUESTS.iter().chain([&TLS_HANDSHAKE]).any(may_become) {
            true => Verdict::Undecided,
            false => Verdict::Ours,
        }
    }
}

/// Whether `bytes` begin with `prefix`, letters in any case.
fn begins_with(bytes: &[u8], prefix: &[u8]) -> bool {
    bytes.get(..prefix.len()).is_some_and(|start| start.eq_ignore_ascii_case(prefix))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::command::Verb;

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
            "gets / HTTP/1.1\n",
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
