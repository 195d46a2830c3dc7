//! Buffers of payloads, and pixels in grey digits.

use super::*;
use crate::command::Figure;
use crate::memory::Rgba;

/// Keeps pixels, errors, and texts with their buffers.
#[derive(Default)]
struct Heard {
    pixels: Vec<(i32, i32, Rgba)>,
    errors: Vec<Code>,
    texts: Vec<Vec<u8>>,
}

impl Sink for Heard {
    fn pixel(&mut self, x: i32, y: i32, color: Rgba) {
        self.pixels.push((x, y, color));
    }
    fn binary_pixels(&mut self, _: &[u8]) {}
    fn command(&mut self, command: Command, _: StreamPosition) -> Flow {
        if let Command::Figure(Figure::Text { utf8, .. }) = command {
            self.texts.push(utf8);
        }
        Flow::Continue
    }
    fn error(&mut self, error: StreamError) -> Flow {
        self.errors.push(error.code);
        Flow::Continue
    }
}

fn decoder() -> (Decoder, Heard) {
    (Decoder::new(Limits::default()), Heard::default())
}

#[test]
fn a_command_takes_its_buffer_over_unless_most_of_it_is_unused() {
    let (mut decoder, mut heard) = decoder();
    let _ = decoder.feed(b"TEXT 0 0 ff :3000\na", &mut heard);
    let buffer = decoder.payload.as_ptr();
    let _ = decoder.feed(&[b'a'; 2999], &mut heard);
    assert_eq!((heard.texts[0].as_ptr(), heard.texts[0].len()), (buffer, 3000), "not copied");
    assert_eq!(decoder.payload.capacity(), 0);
    // The sink has only looked at the bytes of this one, so the decoder keeps its buffer for the
    // next one.
    let _ = decoder.feed(b"BLIT 0 0 50 50 :10000\n1", &mut heard);
    let _ = decoder.feed(&[2; 9999], &mut heard);
    let kept = decoder.payload.capacity();
    assert!(kept >= 10_000);
    let _ = decoder.feed(b"TEXT 0 0 ff :3000\na", &mut heard);
    let _ = decoder.feed(&[b'a'; 2999], &mut heard);
    assert_eq!((heard.texts[1].capacity(), decoder.payload.capacity()), (3000, kept));
}

#[test]
fn a_payload_that_arrives_in_many_pieces_is_moved_a_few_times() {
    let (mut decoder, mut heard) = decoder();
    let _ = decoder.feed(b"TEXT 0 0 ff :60000\n", &mut heard);
    let mut capacities = Vec::new();
    for _ in 0..599 {
        let _ = decoder.feed(&[b'a'; 100], &mut heard);
        capacities.push(decoder.payload.capacity());
    }
    assert_eq!(decoder.missing_bytes(), 100);
    capacities.dedup();
    assert!(capacities.len() < 8, "{capacities:?}");
    assert!(capacities.iter().all(|c| *c <= 60_000));
}

#[test]
fn one_hex_digit_is_a_grey_where_that_is_accepted() {
    let lines = b"PX 1 2 f\nPX 3 -4 0\npx 5 6 A\nPX 7 8 g\nPX 9 9 fff\nCLEAR f\n";
    let (mut decoder, mut heard) = decoder();
    let _ = decoder.feed(lines, &mut heard);
    assert_eq!((heard.pixels, heard.errors), (vec![], vec![Code::Colour; 6]));
    let (mut decoder, mut heard) = (Decoder::new(Limits::default()), Heard::default());
    decoder.set_grey_digits(true);
    let _ = decoder.feed(lines, &mut heard);
    let grey = |v| [v, v, v, 255];
    assert_eq!(heard.pixels, [(1, 2, grey(0xff)), (3, -4, grey(0)), (5, 6, grey(0xaa))]);
    assert_eq!(heard.errors, [Code::Colour; 3]);
}
