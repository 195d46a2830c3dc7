//! Feeds arbitrary bytes, cut anywhere, to the decoder. It must not panic, must give the same
//! events for all cuts, must count lines and bytes, must report errors as one short ASCII line, and
//! each decoded command must survive encoding and decoding.
#![no_main]

use fbptr::command::{
    BINARY_PIXEL_BYTES, Command, Decoder, EndOfInput, Flow, Limits, Sink, StreamError, StreamPosition,
    binary_pixel, encode,
};
use libfuzzer_sys::fuzz_target;

const LIMITS: Limits = Limits { payload_bytes: 4096 };

#[derive(Debug, PartialEq)]
enum Event {
    Command(Command, Option<StreamPosition>),
    Error(StreamError),
}

#[derive(Default)]
struct Heard(Vec<Event>);

impl Sink for Heard {
    fn pixel(&mut self, x: i32, y: i32, color: [u8; 4]) {
        self.0.push(Event::Command(Command::Pixel { x, y, color }, None));
    }
    fn binary_pixels(&mut self, records: &[u8]) {
        assert!(records.len().is_multiple_of(BINARY_PIXEL_BYTES));
        for record in records.as_chunks().0 {
            let (x, y, color) = binary_pixel(record);
            self.0.push(Event::Command(Command::BinaryPixel { x, y, color }, None));
        }
    }
    fn command(&mut self, command: Command, place: StreamPosition) -> Flow {
        let flow = if command == Command::Quit { Flow::Stop } else { Flow::Continue };
        self.0.push(Event::Command(command, Some(place)));
        flow
    }
    fn error(&mut self, error: StreamError) -> Flow {
        let line = error.wire_line();
        assert!(line.len() < 1000 && line.bytes().all(|b| (b' '..=b'~').contains(&b)), "{line}");
        assert!(!error.play_line("f").contains('\n'));
        self.0.push(Event::Error(error));
        Flow::Continue
    }
}

fn hear<'a>(pieces: impl IntoIterator<Item = &'a [u8]>, end: EndOfInput) -> (Vec<Event>, StreamPosition) {
    let (mut decoder, mut heard) = (Decoder::new(LIMITS), Heard::default());
    for piece in pieces {
        if decoder.feed(piece, &mut heard) == Flow::Stop {
            break;
        }
        assert!(decoder.pending_bytes() < 300_000);
    }
    let place = decoder.place();
    let _ = decoder.finish(end, &mut heard);
    (heard.0, place)
}

fuzz_target!(|input: &[u8]| {
    // The first byte selects the cuts and the kind of end.
    let Some((&how, stream)) = input.split_first() else { return };
    let end = if how & 1 == 0 { EndOfInput::Stream } else { EndOfInput::File };
    let (whole, place) = hear([stream], end);
    let (cut, cut_place) = match how >> 1 {
        0 => {
            let (a, b) = stream.split_at(stream.len() / 2);
            hear([a, b], end)
        }
        size => hear(stream.chunks(size.into()), end),
    };
    assert_eq!(whole, cut);
    let stopped = whole.iter().any(|e| match e {
        Event::Command(command, _) => *command == Command::Quit,
        Event::Error(error) => error.closes,
    });
    // After the error for a too long line the stream may be closed; then the position tells only
    // how far it was read.
    if !stopped && place.byte == stream.len() as u64 {
        assert_eq!(place.line, 1 + stream.iter().filter(|&&b| b == b'\n').count() as u64);
        assert_eq!(place, cut_place);
    }
    let mut bytes = Vec::new();
    for event in whole {
        let Event::Command(command, _) = event else { continue };
        command.validate().expect("what is heard is in order");
        bytes.clear();
        // The only commands that cannot be encoded are long lines of numbers that grow when written
        // in full.
        if encode(&command, &mut bytes).is_err() {
            assert!(matches!(command.verb(), "POLY" | "FILLPOLY"), "{command:?}");
            continue;
        }
        let (again, _) = hear([&bytes[..]], EndOfInput::Stream);
        let [Event::Command(same, _)] = &again[..] else { panic!("{command:?} became {again:?}") };
        assert_eq!(*same, command);
        // Bytes are compared for the sign of zero, which equality ignores.
        let mut same_bytes = Vec::new();
        encode(same, &mut same_bytes).expect("what was read is written again");
        assert_eq!(same_bytes, bytes);
    }
});
