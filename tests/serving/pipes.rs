//! Connections over pairs of pipes within one process.

use fbptr::server::{Audience, Budget, Engine, Limits, Output, Server, Stream};
use std::io::{self, Cursor, Read, Write};
use std::sync::{Arc, Mutex, mpsc};

#[test]
fn a_server_that_finishes_at_once_serves_the_pipes_that_it_was_given() {
    for round in 0..100 {
        let server = Server::start(Engine::new(4, 4).unwrap()).unwrap();
        for x in 0..3 {
            let stream = Cursor::new(format!("PX {x} 1 ff0000\n").into_bytes());
            server.serve_pipe(Box::new(stream), Box::new(io::sink()), || {}).unwrap();
        }
        let engine = server.finish();
        let row = [0, 1, 2].map(|x| engine.memory().get_pixel(x, 1).unwrap());
        assert_eq!(row, [[255, 0, 0, 255]; 3], "round {round}");
    }
}

/// Input that gives at most so many bytes at a time.
struct Pieces(Cursor<Vec<u8>>, usize);

impl Read for Pieces {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let most = buffer.len().min(self.1);
        self.0.read(&mut buffer[..most])
    }
}

/// Replies that the test can read.
#[derive(Clone, Default)]
struct Replies(Arc<Mutex<Vec<u8>>>);

impl Write for Replies {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.lock().unwrap().write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// Serves a stream in pieces on one frame; returns the frame's bytes and the replies.
fn served(stream: &[u8], piece: usize, limits: Limits) -> (Vec<u8>, String) {
    let server = Server::start(Engine::with_limits(SIDES[0], SIDES[1], limits).unwrap()).unwrap();
    let replies = Replies::default();
    let (ended, ends) = mpsc::channel();
    let input = Pieces(Cursor::new(stream.to_vec()), piece);
    server.serve_pipe(Box::new(input), Box::new(replies.clone()), move || ended.send(()).unwrap()).unwrap();
    ends.recv().unwrap();
    let engine = server.finish();
    let text = String::from_utf8(replies.0.lock().unwrap().clone()).unwrap();
    (engine.memory().bytes().to_vec(), text)
}

const SIDES: [u32; 2] = [1000, 700];

/// Frames of 2.8 MB, which the reader reads into the buffers that they are drawn from, each with a
/// question after it.
fn frames() -> Vec<u8> {
    let [w, h] = SIDES;
    let bytes = (w * h * 4) as usize;
    let mut stream = Vec::new();
    for frame in 1..=5_u8 {
        stream.extend(format!("BLIT 0 0 {w} {h} :{bytes}\n").into_bytes());
        // Some of them are line feeds, which count for positions.
        stream.extend((0..bytes).map(|at| (at as u8).wrapping_mul(frame)));
        stream.extend(format!("CRC 0 0 {w} {h}\nNOPE\n").into_bytes());
    }
    stream
}

#[test]
fn large_payloads_are_the_same_in_pieces_of_any_size() {
    let stream = frames();
    let mut engine = Engine::new(SIDES[0], SIDES[1]).unwrap();
    let mut fed = Stream::new(&engine, 1, Audience::Connection);
    let mut out = Output::default();
    assert_eq!(fed.feed(&mut engine, &stream, &mut out, Budget::NONE).0, stream.len());
    let replies = String::from_utf8(out.replies).unwrap();
    assert_eq!(replies.matches("CRC ").count(), 5);
    assert_eq!(replies.matches(" EVERB NOPE").count(), 5);
    for piece in [1 << 30, 1 << 20, 300_001, 77_777] {
        let (frame, replied) = served(&stream, piece, Limits::default());
        assert_eq!(replied, replies, "pieces of {piece} bytes");
        assert!(frame == engine.memory().bytes(), "pieces of {piece} bytes");
    }
}

#[test]
fn a_large_payload_that_is_cut_off_is_an_error_and_draws_nothing() {
    let stream = frames();
    let head = format!("BLIT 0 0 {} {} :{}\n", SIDES[0], SIDES[1], SIDES[0] * SIDES[1] * 4).len();
    for length in [head + 1_000_000, head + 1_500_000, head + 2_799_999] {
        let (frame, replied) = served(&stream[..length], 1 << 30, Limits::default());
        let missing = head + 2_800_000 - length;
        let says = format!("the stream ends {missing} bytes before the payload does");
        assert!(replied.starts_with("ERR 1 0 EPROTO BLIT: ") && replied.contains(&says), "{replied}");
        assert!(frame.chunks(4).all(|pixel| pixel == [0, 0, 0, 255]), "{length}");
    }
}

#[test]
fn a_large_payload_without_memory_is_refused_and_what_follows_runs() {
    let limits = Limits { memory_bytes: 2_800_000 + (3 << 20) / 2, ..Limits::default() };
    let mut stream = frames();
    stream.extend(b"PX 1 1 ff0000\nPX 1 1\n");
    let (_, replied) = served(&stream, 1 << 30, limits);
    assert_eq!(replied.matches(" EQUOTA BLIT: ").count(), 5, "{replied}");
    assert!(replied.ends_with("PX 1 1 ff0000\n"), "{replied}");
}
