//! A sink that records its calls.

use fbptr::command::{
    BINARY_PIXEL_BYTES, Command, Decoder, EndOfInput, Flow, Limits, Rect, Sink, StreamError, StreamPosition,
    binary_pixel,
};

/// One call of the sink; runs of binary pixels are split into pixels.
#[derive(Clone, Debug, PartialEq)]
pub enum Event {
    Pixel(i32, i32, [u8; 4]),
    Binary(u16, u16, [u8; 4]),
    Command(Command, StreamPosition),
    Error(StreamError),
}

#[derive(Default)]
pub struct Recorder {
    pub events: Vec<Event>,
    /// If set, QUIT is answered with `Stop`, as a session does.
    pub obeys_quit: bool,
    /// If set, an error is answered with `Stop`.
    pub stops_at_error: bool,
    pub calls_by_slice: usize,
}

impl Sink for Recorder {
    fn pixel(&mut self, x: i32, y: i32, color: [u8; 4]) {
        self.events.push(Event::Pixel(x, y, color));
    }

    fn binary_pixels(&mut self, records: &[u8]) {
        assert!(!records.is_empty() && records.len().is_multiple_of(BINARY_PIXEL_BYTES));
        for record in records.as_chunks::<BINARY_PIXEL_BYTES>().0 {
            assert_eq!(&record[..2], b"PB");
            let (x, y, color) = binary_pixel(record);
            self.events.push(Event::Binary(x, y, color));
        }
    }

    fn command(&mut self, command: Command, place: StreamPosition) -> Flow {
        command.validate().expect("what the decoder passes on is in order");
        let stop = self.obeys_quit && command == Command::Quit;
        self.events.push(Event::Command(command, place));
        if stop { Flow::Stop } else { Flow::Continue }
    }

    fn error(&mut self, error: StreamError) -> Flow {
        let line = error.wire_line();
        assert!(line.len() < 1000 && line.bytes().all(|b| (b' '..=b'~').contains(&b)), "{line}");
        self.events.push(Event::Error(error));
        if self.stops_at_error { Flow::Stop } else { Flow::Continue }
    }

    fn blit(&mut self, rect: Rect, rgba: &[u8], place: StreamPosition) -> Flow {
        self.calls_by_slice += 1;
        self.command(Command::Blit { rect, rgba: rgba.to_vec() }, place)
    }
}

/// Returns the events of a stream that is fed in these pieces.
pub fn hear_pieces<'a>(
    pieces: impl IntoIterator<Item = &'a [u8]>,
    limits: Limits,
    end: EndOfInput,
) -> Vec<Event> {
    let (mut decoder, mut recorder) = (Decoder::new(limits), Recorder::default());
    for piece in pieces {
        if decoder.feed(piece, &mut recorder) == Flow::Stop {
            break;
        }
    }
    let _ = decoder.finish(end, &mut recorder);
    recorder.events
}

/// Returns the events of a stream that is fed in one piece.
pub fn hear(bytes: &[u8]) -> Vec<Event> {
    hear_pieces([bytes], Limits::default(), EndOfInput::Stream)
}

/// Returns the errors of a stream, as `line byte CODE VERB`.
pub fn errors(bytes: &[u8]) -> Vec<String> {
    hear(bytes).iter().filter_map(short_error).collect()
}

pub fn short_error(event: &Event) -> Option<String> {
    match event {
        Event::Error(e) => Some(format!("{} {} {} {}", e.place.line, e.place.byte, e.code, e.subject.name())),
        _ => None,
    }
}
