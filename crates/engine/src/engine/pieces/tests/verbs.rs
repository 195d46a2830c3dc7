//! Every verb of the table at its largest arguments, on the frame and on a canvas, beside a SYNC of
//! another connection.
//!
//! In: the verb table. Each verb is written with numbers that reach across the target, lie far outside
//! or end their range, with the longest lists and with payloads of many bytes. Out: the most pixels
//! that are written between two looks at the other connection. Fear: a verb, a new one above all, that
//! takes as long as its arguments are large while everybody waits. Work is counted and not timed: the
//! rows that were written count with all their pixels, or if these are too many with those that
//! changed since the command began; a byte of a reply counts as a quarter of a pixel.

use crate::engine::Engine;
use crate::stream::Resume;
use crate::{Audience, Budget, Limits, Output, Pace, Stream, StreamState};
use fbptr_command::{Encoding, Parameter, ParameterKind, Payload, Reach, Verb};
use fbptr_core::cancel::CancelToken;
use std::time::{Duration, Instant};

/// Side of the frame and of the canvas.
const SIDE: u32 = 4096;
/// Most pixels between two looks: what the estimates let run at once.
const MOST_PIXELS: u64 = 8 << 20;
/// Colour of the target before each command.
const UNTOUCHED: [u8; 4] = [1, 2, 3, 255];
/// Pieces after which a command is given up: the others are like them.
const MOST_PIECES: usize = 200;
/// Bytes that arrive at once.
const SLICE_BYTES: usize = 1 << 16;
/// Verbs of faces, which are drawn on a thread of their own: they end their turns by the clock.
const FACES: [&str; 2] = ["DRAW", "DRAWSCENE"];

const SETTING: &str = "ERRORS report\nMESH pot SPHERE 2\nLOOKAT 0 0 3 0 0 0 0 1 0\nPERSPECTIVE 0.8 0.1 100\n\
    AMBIENT .4 .4 .4\nLIGHT 0 DIR 0 -1 -1 1 1 1\nBLEND over\nTEXTSIZE 8\nCANVAS hero 4096 4096\n";
const EYE: &str = r#"{"dim":2,"pixels":[4],"d":1,"S":[1],"I_d":0.5,"facets":[{"v":[[2,-3],[2,0.01]],"color":[250,100,50]}]}"#;
const SCENE: &str = "<X3D><Scene><Background skyColor='0 1 0'/><Shape><Sphere/></Shape></Scene></X3D>";

/// Numbers that the arguments of a line take in turn, in pixels of the target.
const NUMBERS: [&[f64]; 6] = {
    const S: f64 = SIDE as f64;
    [
        &[0.0, 0.0, S, S, 0.0, S, S, 0.0],
        &[-S, -S, 3.0 * S, 3.0 * S],
        &[S / 2.0, S / 2.0, S, S],
        &[0.0, S - 1.0],
        &[-1e6, 1e6, 1e6, -1e6],
        &[1e308, -1e308, 1e308],
    ]
};

fn number(kind: ParameterKind, value: f64) -> String {
    match kind {
        ParameterKind::Integer => (value as i32).to_string(),
        ParameterKind::Angle => format!("{}", value.clamp(-9.0, 9.0)),
        _ => format!("{value:?}"),
    }
}

/// Returns the words of a parameter with the next of these numbers; a name is that of the example.
fn words(parameter: &Parameter, example: &str, numbers: &mut impl Iterator<Item = f64>) -> Vec<String> {
    let most = parameter.arity.most().unwrap_or(400);
    (0..most)
        .filter_map(|_| {
            Some(match parameter.kind {
                ParameterKind::Integer | ParameterKind::Real | ParameterKind::Angle => {
                    number(parameter.kind, numbers.next()?)
                }
                ParameterKind::Color => "ff000080".to_owned(),
                ParameterKind::Name => example.split(' ').nth(1)?.to_owned(),
                ParameterKind::Keyword(list) => (*list.last()?).to_owned(),
                ParameterKind::Flag(word) => word.to_owned(),
                ParameterKind::Hex => "7f".repeat(1900),
                ParameterKind::RestOfLine => "W".repeat(3900),
                ParameterKind::Payload | ParameterKind::Words => return None,
            })
        })
        .collect()
}

fn with_payload(head: &str, payload: &[u8]) -> Vec<u8> {
    [format!("{head} :{}\n", payload.len()).as_bytes(), payload].concat()
}

/// Returns the lines of a verb with its largest arguments, some of which it may refuse.
fn lines(verb: &Verb) -> Vec<Vec<u8>> {
    let bytes = (SIDE * SIDE * 4) as usize;
    match verb.name {
        "PX" => vec![b"PX 16 12 ff8000\n".to_vec()],
        "PB" => vec![b"PB\x10\0\x0c\0\x7f\0\0\x7f".to_vec()],
        "PXMULTI" => {
            vec![[&b"PXMULTI\0\0\0\0"[..], &(bytes as u32 / 4).to_le_bytes(), &vec![9; bytes]].concat()]
        }
        "BLIT" => vec![with_payload(&format!("BLIT 0 0 {SIDE} {SIDE}"), &vec![9; bytes])],
        "IMAGE" => {
            let head = format!("P5 {SIDE} {SIDE} 255\n").into_bytes();
            vec![with_payload("IMAGE 0 0", &[head, vec![77; bytes / 4]].concat())]
        }
        "TEXT" => vec![with_payload("TEXT 0 0 ff000080", ("W".repeat(63) + "\n").repeat(1 << 14).as_bytes())],
        "PEEK" => vec![format!("PEEK 0 {}\n", bytes / 4).into_bytes()],
        _ if verb.encoding != Encoding::Text => Vec::new(),
        _ => NUMBERS
            .iter()
            .map(|numbers| {
                let mut numbers = numbers.iter().copied().cycle().take(400);
                let all = verb.parameters.iter().flat_map(|p| words(p, verb.example, &mut numbers));
                let mut head = verb.name.to_owned();
                for word in all {
                    if head.len() + word.len() < 4000 {
                        head += " ";
                        head += &word;
                    }
                }
                match verb.payload {
                    Payload::Always => with_payload(&head, &b"\x10\x01\x20\x02\x7f\0\0\x7f".repeat(1 << 20)),
                    _ => format!("{head}\n").into_bytes(),
                }
            })
            .collect(),
    }
}

/// A busy connection, and another one that is answered beside it.
struct Beside {
    engine: Engine,
    busy: Stream,
    other: Stream,
    out: Output,
}

impl Beside {
    fn new() -> Beside {
        let limits = Limits { reply_bytes: 256 << 20, payload_bytes: 256 << 20, ..Limits::default() };
        let engine = Engine::with_limits(SIDE, SIDE, limits).unwrap();
        let [busy, other] = [1, 2].map(|id| Stream::new(&engine, id, Audience::Connection));
        let mut beside = Beside { engine, busy, other, out: Output::default() };
        for bytes in [
            SETTING.as_bytes().to_vec(),
            with_payload("EYE world", EYE.as_bytes()),
            with_payload("SCENE X3D", SCENE.as_bytes()),
        ] {
            let (most, replies, _) = beside.run(&bytes);
            assert!(replies.is_empty() && most < MOST_PIXELS, "{}", replies.escape_ascii());
        }
        beside
    }

    /// Returns the pixels of the rows that were written on the frame and the target since the last
    /// call; of more than [`MOST_PIXELS`] those that are not [`UNTOUCHED`].
    fn written(&mut self) -> u64 {
        let mut sum = 0;
        // Without a target the frame is seen twice, the second time without damage.
        for _ in 0..2 {
            let memory = &mut self.engine.framebuffer.memory;
            let rows = memory.take_damage();
            let rows = u64::from(rows.end.saturating_sub(rows.start)) * u64::from(memory.width());
            sum += match rows > MOST_PIXELS {
                true => {
                    memory.bytes().as_chunks().0.iter().filter(|pixel| **pixel != UNTOUCHED).count() as u64
                }
                false => rows,
            };
            self.busy.session_mut().surfaces.swap_target(&mut self.engine.framebuffer);
        }
        sum
    }

    /// Runs bytes of the busy connection piece by piece, with a SYNC of the other one beside each.
    /// Returns the most pixels of a piece, the replies and the number of pieces.
    fn run(&mut self, bytes: &[u8]) -> (u64, Vec<u8>, usize) {
        self.busy.session_mut().surfaces.swap_target(&mut self.engine.framebuffer);
        self.engine.framebuffer.memory.clear(UNTOUCHED);
        self.busy.session_mut().surfaces.swap_target(&mut self.engine.framebuffer);
        self.written();
        let (mut used, mut most, mut replies) = (0, 0, Vec::new());
        let (mut pieces, mut resumed) = (0, 0);
        let mut state = StreamState::Ready;
        while used < bytes.len() || !matches!(state, StreamState::Ready | StreamState::Yields) {
            if resumed >= MOST_PIECES && state == StreamState::InPieces {
                self.busy.abandon(&mut self.engine);
                break;
            }
            let budget = Budget {
                until: Some(Instant::now()),
                suspends: true,
                pace: Pace::Free,
                command_time: Some(Duration::from_secs(3600)),
                ..Budget::NONE
            };
            let (engine, out) = (&mut self.engine, &mut self.out);
            state = match state {
                StreamState::InPieces => {
                    resumed += 1;
                    self.busy.resume(engine, Resume::Pieces, out, budget)
                }
                StreamState::Works => {
                    let result = out.job.take().expect("a job").run_guarded(&CancelToken::default());
                    self.busy.resume(engine, Resume::Job(result), out, budget)
                }
                _ => {
                    let end = bytes.len().min(used + SLICE_BYTES);
                    let (taken, state) = self.busy.feed(engine, &bytes[used..end], out, budget);
                    used += taken;
                    state
                }
            };
            replies.append(&mut self.out.replies);
            pieces += 1;
            most = most.max(self.written());
            let asks = Budget { only_asks: state == StreamState::InPieces, ..budget };
            let (_, other) = self.other.feed(&mut self.engine, b"SYNC me\n", &mut self.out, asks);
            assert!(matches!(other, StreamState::Ready | StreamState::Yields), "{other:?}");
            assert_eq!(std::mem::take(&mut self.out.replies), b"SYNC me\n", "after {pieces} pieces");
        }
        (most, replies, pieces)
    }
}

#[test]
fn every_verb_is_divided_on_the_frame_and_on_a_canvas() {
    for target in ["TARGET FRAME\n", "CANVAS k 4096 4096\nTARGET k\nBLEND over\n"] {
        let mut beside = Beside::new();
        beside.run(target.as_bytes());
        for verb in Verb::all().iter().filter(|verb| verb.reach != Reach::Connection) {
            let mut accepted = 0;
            for line in lines(verb) {
                let (most, replies, pieces) = beside.run(&line);
                let is_refused = replies.starts_with(b"ERR");
                accepted += usize::from(!is_refused);
                let line = line[..line.len().min(90)].escape_ascii();
                if FACES.contains(&verb.name) {
                    assert!(is_refused || pieces > 1, "{line}: others wait for all of it");
                } else {
                    let work = most.max(replies.len() as u64 / 4 / pieces as u64);
                    assert!(work <= MOST_PIXELS, "{target}{line}: {work} pixels in one of {pieces} pieces");
                }
            }
            assert!(accepted > 0, "{}: all its lines are refused; it needs lines of its own here", verb.name);
        }
    }
}
