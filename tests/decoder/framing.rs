//! Framing of lines, payloads and binary commands: where each begins and ends.

use crate::recorder::{Event, Recorder, errors, hear, hear_pieces, short_error};
use fbptr::command::{
    Command, Decoder, EndOfInput, Flow, Limits, MAX_LINE_BYTES, PayloadPool, Sink, StreamPosition,
};
use fbptr::memory::MemoryBudget;

fn pixel(x: i32, y: i32) -> Event {
    Event::Pixel(x, y, [255; 4])
}

/// Summarizes the events of a stream: pixels as `x,y`, commands by verb, errors by code.
fn story(bytes: &[u8]) -> String {
    told(&hear(bytes))
}

fn told(events: &[Event]) -> String {
    let words: Vec<String> = events
        .iter()
        .map(|event| match event {
            Event::Pixel(x, y, _) => format!("{x},{y}"),
            Event::Binary(x, y, _) => format!("b{x},{y}"),
            Event::Command(c, _) => c.verb().to_owned(),
            Event::Error(e) => e.code.to_string(),
        })
        .collect();
    words.join(" ")
}

#[test]
fn lines_end_at_lf_and_lose_one_cr() {
    assert_eq!(hear(b"PX 1 2 ff\r\nPX 3 4 ff\n"), [pixel(1, 2), pixel(3, 4)]);
    assert_eq!(story(b"PX 1 2 ff\r\r\nSIZE\r\n"), "ECOLOUR SIZE");
    assert_eq!(story(b"\tPX\t\t1   2 ff \t\n px 1 2 FF\n"), "1,2 1,2");
    assert_eq!(story(b"\n\r\n \t \n# PX 1 2 ff\n#\n#x :5\nSIZE\n"), "SIZE");
    // A comment begins its line; after a blank, `#` is an ordinary word.
    assert_eq!(story(b" # x\nSTATS # x\n"), "EVERB EARGS");
    assert_eq!(story(b"PX 1 2 ff\x00\nPX\x0b1 2 ff\n"), "ECOLOUR EVERB");
}

#[test]
fn binary_commands_are_known_by_their_first_bytes_alone() {
    assert_eq!(story(b"PB\x01\x00\x02\x00\x0a\x0a\x0a\x0aPX 1 2 ff\nPBabcdefgh"), "b1,2 1,2 b25185,25699");
    assert_eq!(story(b"pb 1 2\nPbx\n PB\n"), "EVERB EVERB EVERB");
    let run = b"PXMULTI\x01\x00\x02\x00\x02\x00\x00\x00aAbBcCdDSIZE\n";
    let Event::Command(Command::PixelRun { x: 1, y: 2, rgba }, _) = &hear(run)[0] else { panic!() };
    assert_eq!(rgba, b"aAbBcCdD");
    assert_eq!(story(run), "PXMULTI SIZE");
    assert_eq!(story(b"PXMULTI\x01\x00\x02\x00\x00\x00\x00\x00SIZE\n"), "PXMULTI SIZE");
    assert_eq!(story(b"PXMULTX\npxmulti 1 2\nP\nPXMULT\nPX\n"), "EVERB EVERB EVERB EVERB EARGS");
}

#[test]
fn a_payload_follows_its_line() {
    assert_eq!(story(b"TEXT 1 2 ff :6\nPX 1\n\nSIZE\n"), "TEXT SIZE");
    assert_eq!(story(b"TEXT 1 2 ff :0\nSIZE\n"), "TEXT SIZE");
    assert_eq!(story(b"TEXT 1 2 ff :0003 \t\r\nabcSIZE\n"), "TEXT SIZE");
    assert_eq!(story(b"BLIT 0 0 1 2 :8\n12345678SIZE\n"), "BLIT SIZE");
}

#[test]
fn the_payload_of_a_refused_command_is_skipped() {
    for line in [
        "NONSENSE x :9",
        ":9",
        "SIZE :9",
        "TEXT 1 x ff :9",
        "TEXT 1 2 3 4 5 :9",
        "BLIT 0 0 1 2 :9",
        "BLIT 0 0 -1 2 :9",
        "POINTS :9",
        "MESH a BOX :9",
        "MESH a OBJ x :9",
        "PX 1 2 ff :9",
    ] {
        let heard = story(format!("{line}\nSIZE\nPX\n\nPX 1 2 ff\n").as_bytes());
        let code = heard.strip_suffix(" 1,2").unwrap_or_else(|| panic!("{line}: {heard}"));
        assert!(code.starts_with('E') && !code.contains(' '), "{line}: {heard}");
    }
    // Nine bytes that are not UTF-8 are still the payload.
    assert_eq!(story(b"TEXT 1 2 ff :9\n\xff\n2345678SIZE\n"), "EFORMAT SIZE");
}

#[test]
fn a_colon_announces_a_length_or_nothing() {
    assert_eq!(story(b"SNAP :\nSYNC :\n"), "SNAP SYNC");
    assert_eq!(
        story(b"SYNC :x\nSYNC :5x\nSYNC ::\nSYNC :-1\nSYNC :+1\n:junk\nSIZE\n"),
        "EPROTO EPROTO EPROTO EPROTO EPROTO EPROTO SIZE"
    );
    assert_eq!(story(b"NONSENSE :x\nSIZE\n"), "EPROTO SIZE");
    // Only the last word counts.
    assert_eq!(story(b"SYNC :5 x\nSIZE\n"), "EARGS SIZE");
}

#[test]
fn a_length_over_the_limit_is_said_at_the_header_and_discarded() {
    let limits = Limits { payload_bytes: 8 };
    let (mut decoder, mut recorder) = (Decoder::new(limits), Recorder::default());
    assert_eq!(decoder.feed(b"TEXT 1 2 ff :9\n", &mut recorder), Flow::Continue);
    assert_eq!(told(&recorder.events), "ETOOBIG");
    assert_eq!(decoder.feed(b"PX 1 1 ffSIZE\n", &mut recorder), Flow::Continue);
    assert_eq!(told(&recorder.events), "ETOOBIG SIZE");
    assert_eq!(decoder.feed(b"TEXT 1 2 ff :8\n12345678", &mut recorder), Flow::Continue);
    // Three pixels are twelve bytes.
    assert_eq!(decoder.feed(b"PXMULTI\0\0\0\0\x03\0\0\0", &mut recorder), Flow::Continue);
    assert_eq!(told(&recorder.events), "ETOOBIG SIZE TEXT ETOOBIG");
    assert_eq!(decoder.feed(b"PX 1 1 ff\n\n\nSIZE\n", &mut recorder), Flow::Continue);
    assert_eq!(told(&recorder.events), "ETOOBIG SIZE TEXT ETOOBIG SIZE");
    // The length of an unknown verb's payload is checked before the verb.
    assert_eq!(decoder.feed(b"NONSENSE :18446744073709551615\n", &mut recorder), Flow::Continue);
    assert_eq!(told(&recorder.events[5..]), "ETOOBIG");
    assert!(decoder.pending_bytes() < 1 << 16);
}

#[test]
fn a_length_beyond_u64_closes_the_stream() {
    for text in ["SYNC :18446744073709551616\nSIZE\n", "NONSENSE :99999999999999999999999999\nSIZE\n"] {
        let (mut decoder, mut recorder) = (Decoder::new(Limits::default()), Recorder::default());
        assert_eq!(decoder.feed(text.as_bytes(), &mut recorder), Flow::Stop);
        let [Event::Error(error)] = recorder.events.as_slice() else { panic!("{:?}", recorder.events) };
        assert!(error.closes && error.code.as_str() == "EPROTO");
        assert_eq!(decoder.feed(b"SIZE\n", &mut recorder), Flow::Stop);
        assert_eq!(decoder.finish(EndOfInput::Stream, &mut recorder), Flow::Stop);
        assert_eq!(recorder.events.len(), 1);
    }
}

#[test]
fn a_line_has_4096_bytes_without_its_end() {
    let full = format!("SYNC {}", "x".repeat(MAX_LINE_BYTES - 5));
    for end in ["\n", "\r\n"] {
        assert_eq!(story(format!("{full}{end}SIZE\n").as_bytes()), "SYNC SIZE");
        assert_eq!(story(format!("{full}y{end}SIZE\n").as_bytes()), "EPROTO SIZE");
        assert_eq!(
            story(format!("{full}\r{end}SIZE\n").as_bytes()),
            if end == "\n" { "SYNC SIZE" } else { "EPROTO SIZE" }
        );
        assert_eq!(story(format!("{full}{}{end}SIZE\n", "z".repeat(99_999)).as_bytes()), "EPROTO SIZE");
    }
    assert_eq!(errors(format!("SIZE\n{full}yz\n").as_bytes()), ["2 5 EPROTO SYNC"]);
    assert_eq!(
        errors(format!("{}\n", "w".repeat(5000)).as_bytes()),
        [format!("1 0 EPROTO {}", "w".repeat(40))]
    );
}

#[test]
fn a_line_too_long_still_announces_its_payload() {
    for filler in [4000, 4096, 4097, 5000, 70_000] {
        for (tail, heard) in [
            (" :5\n12\n45SIZE\n", "EPROTO SIZE"),
            (" :5 \t\r\n12\n45SIZE\n", "EPROTO SIZE"),
            (" : :5\n12345SIZE\n", "EPROTO SIZE"),
            (" :0\nSIZE\n", "EPROTO SIZE"),
            (" :5 x\nSIZE\n", "EPROTO SIZE"),
            (" :\nSIZE\n", "EPROTO SIZE"),
            (" ::5\nSIZE\n", "EPROTO SIZE"),
            (" :5x\nSIZE\n", "EPROTO SIZE"),
            (" :5\r\r\nSIZE\n", "EPROTO SIZE"),
            (" :18446744073709551616\nSIZE\n", "EPROTO"),
            // A single error, whatever is missing.
            (" :5\n12", "EPROTO"),
            (" :5", "EPROTO"),
        ] {
            let line = format!("TEXT {}{}{tail}", "x".repeat(filler), " ".repeat(99));
            assert_eq!(story(line.as_bytes()), heard, "{filler} {tail:?}");
        }
        let comment = format!("#{}{} :5\nSIZE\n", "x".repeat(filler), " ".repeat(99));
        assert_eq!(story(comment.as_bytes()), "EPROTO SIZE");
    }
    // The payload length may lie across the limit of a line.
    for filler in 4085..4100 {
        let line = format!("TEXT {} :0000000000000005\n12345SIZE\n", "x".repeat(filler));
        assert_eq!(story(line.as_bytes()), "EPROTO SIZE", "{filler}");
    }
}

#[test]
fn what_is_left_at_the_end_is_an_error_and_is_not_run() {
    for (text, error) in [
        ("PX 1 2 ff", "1 0 EPROTO PX"),
        ("SIZE\nPX 1 2 ff\r", "2 5 EPROTO PX"),
        ("P", "1 0 EPROTO P"),
        ("PB1234567", "1 0 EPROTO PB"),
        ("PXMUL", "1 0 EPROTO PXMUL"),
        ("PXMULTI1234", "1 0 EPROTO PXMULTI"),
        ("PXMULTI\0\0\0\0\x01\0\0\0abc", "1 0 EPROTO PXMULTI"),
        ("TEXT 1 2 ff :3\nab", "1 0 EPROTO TEXT"),
        ("TEXT 1 2 ff :3\n", "1 0 EPROTO TEXT"),
        (" nonsense", "1 0 EPROTO nonsense"),
    ] {
        let heard = hear(text.as_bytes());
        assert_eq!(heard.iter().filter_map(short_error).collect::<Vec<_>>(), [error], "{text:?}");
        assert_eq!(heard.len(), 1 + usize::from(text.starts_with("SIZE")), "{text:?}");
    }
    // A refused command is reported at once, and its missing payload is a second error.
    assert_eq!(story(b"NONSENSE :3\nab"), "EVERB EPROTO");
    // Blank lines and comments are no commands.
    for text in ["", "  \t", "\r", "# abc", "SIZE\n#"] {
        assert!(errors(text.as_bytes()).is_empty(), "{text:?}");
    }
}

#[test]
fn a_files_last_line_may_lack_its_lf_and_nothing_else() {
    let file = |text: &str| told(&hear_pieces([text.as_bytes()], Limits::default(), EndOfInput::File));
    assert_eq!(file("SIZE\nPX 1 2 ff"), "SIZE 1,2");
    assert_eq!(file("PX 1 2 ff\r"), "1,2");
    assert_eq!(file("PX 1 2"), "PX");
    assert_eq!(file("P"), "EVERB");
    assert_eq!(file("PXMULT"), "EVERB");
    assert_eq!(file("QUIT"), "QUIT");
    assert_eq!(file("# end"), "");
    assert_eq!(file("TEXT 1 2 ff :0"), "TEXT");
    assert_eq!(file("TEXT 1 2 ff :1"), "EPROTO");
    assert_eq!(file("TEXT 1 2 ff :2\na"), "EPROTO");
    assert_eq!(file("PB12345"), "EPROTO");
    assert_eq!(file("PXMULTI12345"), "EPROTO");
    assert_eq!(file("SYNC :x"), "EPROTO");
    assert_eq!(file(&"x".repeat(4096)), "EVERB");
    assert_eq!(file(&"x".repeat(4097)), "EPROTO");
}

#[test]
fn places_count_lf_and_bytes_of_everything_before() {
    let mut stream = Vec::new();
    stream.extend_from_slice(b"PX 1 2 ff\n\n# comment\nPB\n\n\n\n\n\n\n\n");
    stream.extend_from_slice(b"PXMULTI\n\0\n\0\x02\0\0\0\n\n\n\n----");
    stream.extend_from_slice(b"BLIT 0 0 1 1 :4\n\n\n\n\nNONSENSE :4\n\n\n..");
    let here = (stream.iter().filter(|&&b| b == b'\n').count() as u64 + 1, stream.len() as u64);
    stream.extend_from_slice(b"WHAT\nSIZE\n");
    let heard = hear(&stream);
    let Event::Error(error) = &heard[heard.len() - 2] else { panic!() };
    assert_eq!((error.place.line, error.place.byte), here);
    let Event::Command(Command::Size, place) = heard[heard.len() - 1] else { panic!() };
    assert_eq!(place, StreamPosition { line: here.0 + 1, byte: here.1 + 5 });
}

#[test]
fn stop_ends_the_reading_at_that_command() {
    for stream in [&b"SIZE\nQUIT\nPX 1 2 ff\nSIZE\n"[..], b"SIZE\nquit\r\nPB12345678NONSENSE\n"] {
        for cut in 0..stream.len() {
            let (mut decoder, mut recorder) =
                (Decoder::new(Limits::default()), Recorder { obeys_quit: true, ..Recorder::default() });
            for piece in [&stream[..cut], &stream[cut..]] {
                let _ = decoder.feed(piece, &mut recorder);
            }
            assert_eq!(decoder.finish(EndOfInput::File, &mut recorder), Flow::Stop);
            assert_eq!(told(&recorder.events), "SIZE QUIT");
        }
    }
    let mut recorder = Recorder { stops_at_error: true, ..Recorder::default() };
    let mut decoder = Decoder::new(Limits::default());
    assert_eq!(decoder.feed(b"NONSENSE :3\nabcSIZE\n", &mut recorder), Flow::Stop);
    assert_eq!(told(&recorder.events), "EVERB");
}

#[test]
fn what_waits_is_bounded_and_given_back() {
    struct Nothing;
    impl Sink for Nothing {
        fn pixel(&mut self, _: i32, _: i32, _: [u8; 4]) {}
        fn binary_pixels(&mut self, _: &[u8]) {}
        fn command(&mut self, _: Command, _: StreamPosition) -> Flow {
            Flow::Continue
        }
        fn error(&mut self, _: fbptr::command::StreamError) -> Flow {
            Flow::Continue
        }
        fn blit(&mut self, _: fbptr::command::Rect, _: &[u8], _: StreamPosition) -> Flow {
            Flow::Continue
        }
    }
    let pool = PayloadPool::default();
    let mut decoder = Decoder::with_payload_pool(Limits::default(), &pool);
    let _ = decoder.feed(b"BLIT 0 0 2048 2048 :16777216\n", &mut Nothing);
    assert!(decoder.pending_bytes() < 1 << 14, "an announcement alone holds {}", decoder.pending_bytes());
    let piece = vec![7; 1 << 20];
    for _ in 0..15 {
        let _ = decoder.feed(&piece, &mut Nothing);
    }
    assert!(decoder.pending_bytes() <= (16 << 20) + (1 << 16), "{}", decoder.pending_bytes());
    let _ = decoder.feed(&piece, &mut Nothing);
    assert!(decoder.is_at_boundary());
    assert!(decoder.pending_bytes() < 1 << 14, "{}", decoder.pending_bytes());
    // The pool holds the large buffer for the next payload, until it has been unused for a while; that
    // of a longer one would be the sink's.
    assert_eq!(pool.held_bytes(), 16 << 20);
    let _ = decoder.feed(b"BLIT 0 0 2048 2000 :16384000\nabc", &mut Nothing);
    assert!(decoder.pending_bytes() < 1 << 15, "one that has only begun holds {}", decoder.pending_bytes());
    let _ = decoder.feed(&piece, &mut Nothing);
    assert_eq!((pool.held_bytes(), decoder.pending_bytes() >> 20), (0, 16));
    drop(decoder);
    let mut decoder = Decoder::new(Limits::default());
    let _ = decoder.feed(&vec![b'x'; 1 << 22], &mut Nothing);
    assert!(decoder.pending_bytes() < 1 << 14, "{}", decoder.pending_bytes());
}

#[test]
fn a_room_that_was_filled_before_is_of_the_budget_whole() {
    let budget = MemoryBudget::new(64 << 20);
    let pool = PayloadPool::within(&budget);
    let mut recorder = Recorder::default();
    let mut first = Decoder::with_payload_pool(Limits::default(), &pool);
    let _ = first.feed(b"BLIT 0 0 1024 2048 :8388608\n", &mut recorder);
    for _ in 0..8 {
        let _ = first.feed(&vec![7; 1 << 20], &mut recorder);
    }
    assert_eq!((pool.held_bytes(), budget.used()), (8 << 20, 8 << 20), "it waits for the next payload");
    // A payload that has only begun, and may never end, occupies the whole buffer: the pages were
    // touched before, and none goes back to the system.
    let mut stalled = Decoder::with_payload_pool(Limits::default(), &pool);
    let _ = stalled.feed(b"BLIT 0 0 1024 2048 :8388608\n", &mut recorder);
    let _ = stalled.feed(&vec![7; 300 << 10], &mut recorder);
    assert_eq!((pool.held_bytes(), budget.used()), (0, 8 << 20));
    // A new buffer of that size is reserved as it is filled, and the huge page that may be mapped ahead.
    let mut other = Decoder::with_payload_pool(Limits::default(), &pool);
    let _ = other.feed(b"BLIT 0 0 1024 2048 :8388608\n", &mut recorder);
    let _ = other.feed(&vec![7; 300 << 10], &mut recorder);
    assert_eq!(budget.used(), (8 << 20) + (3 << 20));
    drop((first, stalled, other));
    assert_eq!(budget.used(), 0);
}

#[test]
fn a_payload_that_lies_whole_in_a_piece_is_not_copied_first() {
    let mut recorder = Recorder::default();
    let mut decoder = Decoder::new(Limits::default());
    let _ = decoder.feed(b"BLIT 0 0 1 1 :4\nabcd", &mut recorder);
    assert_eq!((recorder.calls_by_slice, decoder.pending_bytes()), (1, 0));
}

#[test]
fn a_payload_that_no_memory_can_hold_is_refused_and_not_awaited() {
    // Half of the address space: the buffer grows with the bytes received, which are few.
    let limits = Limits { payload_bytes: u64::MAX };
    let (mut decoder, mut recorder) = (Decoder::new(limits), Recorder::default());
    let _ = decoder.feed(b"TEX a :9223372036854775807\nabc", &mut recorder);
    assert!(recorder.events.is_empty() && decoder.pending_bytes() < 1 << 20);
    let _ = decoder.finish(EndOfInput::Stream, &mut recorder);
    assert_eq!(told(&recorder.events), "EPROTO");
    let mut recorder = Recorder::default();
    let mut decoder = Decoder::new(limits);
    let _ = decoder.feed(b"TEX a :9223372036854775808\nabc", &mut recorder);
    assert_eq!(told(&recorder.events), "ETOOBIG");
}
