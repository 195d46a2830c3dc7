//! Buffers of payloads, and pixels in grey digits.

use super::*;
use crate::Figure;
use crate::PayloadPool;
use fbptr_core::memory::{MemoryBudget, MemoryUse, Rgba};

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
fn a_byte_order_mark_is_skipped_at_the_beginning_only() {
    for split in 0..8 {
        let stream = b"\xef\xbb\xbfPX 1 2 ff0000\n\xef\xbb\xbfPX 3 4 ff0000\n";
        let (mut decoder, mut heard) = decoder();
        let _ = decoder.feed(&stream[..split], &mut heard);
        let _ = decoder.feed(&stream[split..], &mut heard);
        assert_eq!(heard.pixels, [(1, 2, [255, 0, 0, 255])], "{split}");
        assert_eq!(heard.errors, [Code::Verb], "{split}");
    }
    let (mut decoder, mut heard) = decoder();
    let _ = decoder.feed(b"\xef\xbb\xbf# a comment\n\xef\xbb\xbf", &mut heard);
    let _ = decoder.finish(EndOfInput::File, &mut heard);
    assert_eq!(heard.errors, [Code::Verb]);
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

#[test]
fn a_payload_beyond_the_memory_is_refused_and_skipped_and_all_of_it_is_given_back() {
    let budget = MemoryBudget::new(3 << 20);
    let pool = PayloadPool::within(&budget);
    let others = budget.try_reserve(MemoryUse::Draws, 1 << 20).unwrap();
    let (mut decoder, mut heard) = (Decoder::with_payload_pool(Limits::default(), &pool), Heard::default());
    let length = 2_500_000;
    let mut feed = |decoder: &mut Decoder, bytes: &[u8]| {
        let _ = decoder.feed(bytes, &mut heard);
        (heard.errors.clone(), heard.texts.len(), heard.pixels.len())
    };
    let none = (Vec::new(), 0, 0);
    assert_eq!(feed(&mut decoder, format!("TEXT 0 0 ff :{length}\n").as_bytes()), none);
    let mut left = length;
    // Two of its three steps of a mebibyte fit.
    while left > length - (2 << 20) {
        let piece = left.min(100_000).min(left - (length - (2 << 20)));
        assert_eq!(feed(&mut decoder, &vec![b'a'; piece]), none);
        left -= piece;
    }
    assert_eq!(budget.available(), 0);
    let refused = (vec![Code::Quota], 0, 0);
    assert_eq!(feed(&mut decoder, b"a"), refused);
    assert_eq!(budget.available(), 2 << 20);
    // The rest is no command.
    assert_eq!(feed(&mut decoder, &vec![b'\n'; left - 2]), refused);
    assert_eq!(feed(&mut decoder, b"\nPX 1 2 ff\n"), (vec![Code::Quota], 0, 1));
    drop(others);
    // A small payload that would keep its buffer gives it back while memory is short.
    for is_tight in [false, true] {
        let free = if is_tight { 400_000 } else { 3 << 20 };
        let others = budget.try_reserve(MemoryUse::Draws, budget.available() - free).unwrap();
        feed(&mut decoder, b"BLIT 0 0 50 50 :10000\n1");
        feed(&mut decoder, &[2; 9999]);
        assert_eq!(decoder.payload.capacity() == 0, is_tight);
        drop(others);
    }
}

#[test]
fn a_payload_in_huge_pages_reserves_the_page_that_is_mapped_ahead() {
    let room = 6 << 20;
    let budget = MemoryBudget::new(room);
    let pool = PayloadPool::within(&budget);
    for (length, fitting) in [(16 << 20, 4 << 20), (room as usize, room as usize - 1)] {
        let (mut decoder, mut heard) =
            (Decoder::with_payload_pool(Limits::default(), &pool), Heard::default());
        let _ = decoder.feed(format!("TEXT 0 0 ff :{length}\n").as_bytes(), &mut heard);
        for _ in 0..fitting / 1000 {
            let _ = decoder.feed(&[b'a'; 1000], &mut heard);
        }
        let _ = decoder.feed(&vec![b'a'; fitting % 1000], &mut heard);
        assert_eq!((budget.available(), &heard.errors), (0, &vec![]), "{length}");
        let _ = decoder.feed(b"a", &mut heard);
        assert_eq!(
            (heard.errors.len(), heard.texts.len()),
            if length > fitting + 1 { (1, 0) } else { (0, 1) }
        );
    }
}

#[test]
fn a_text_that_is_a_lines_end_is_utf_8_and_not_empty() {
    let (mut decoder, mut heard) = decoder();
    for (line, code) in [
        (&b"PRINT 0 0 ff \xc3\xa9\n"[..], None),
        (b"PRINT 0 0 ff caf\xc3\n", Some(Code::Format)),
        (b"TITLE \xff\xfe\n", Some(Code::Format)),
        (b"TITLE \t  \n", Some(Code::Args)),
        (b"TITLE a\x07b\n", Some(Code::Format)),
    ] {
        let _ = decoder.feed(line, &mut heard);
        assert_eq!(heard.errors.pop(), code, "{}", line.escape_ascii());
    }
}
