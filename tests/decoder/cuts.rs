//! Verifies that a transport may cut a stream anywhere: the decoder's events stay the same.

use crate::naive::hear_naively;
use crate::recorder::{Event, hear, hear_pieces};
use fbptr::command::{EndOfInput, Group, Limits, ParameterKind, Payload, Verb};
use proptest::prelude::*;

const LIMITS: Limits = Limits { payload_bytes: 300 };

/// Returns a stream with every kind of framing, both valid and broken.
fn mixed_stream() -> Vec<u8> {
    let mut s = Vec::new();
    s.extend_from_slice(
        b"PX 1 2 a1b2c3\nPX 1023 767 00ff7f\nPX 12 345 ABCDEF80\npx -1 +2 red\r\nPX 5 6 7f\nPX 7 8\n",
    );
    s.extend_from_slice(
        b"PB\x01\x00\x02\x00\x0a\x0d\x50\x42PBPBPBPBPBSIZE\nPB\n\n\n\n\n\n\n\n# comment :5\n\n \t\r\n",
    );
    s.extend_from_slice(b"PXMULTI\x03\x00\x04\x00\x03\x00\x00\x00PX 1 2 ff\n\n\nPX 9 9 123456\n");
    s.extend_from_slice(
        b"TEXT 1 2 ff0000 :12\nPX 1 1 ff\nPB\nNONSENSE :7\nSIZE\n\nPLINE 0 0 9 9 red blue\r\n",
    );
    s.extend_from_slice(b"TEXT 1 2 ff :301\n");
    s.extend(std::iter::repeat_n(b"PX 1 1 ff0000\n".iter().copied(), 22).flatten().take(301));
    s.extend_from_slice(
        b"PX 1 2 zz\nPX 1 2 fffff\nPX 12345 67890 00ff00\nPX 1 2 3 4\nSYNC :x\nSYNC :\nPXMULTX\nPXM\nP\n",
    );
    s.extend_from_slice(b"PXMULTI\0\0\0\0\x50\0\0\0");
    s.extend(std::iter::repeat_n(b"PBPX 1 2 00\n".iter().copied(), 27).flatten().take(320));
    s.extend_from_slice(b"PX 1 2 ff00ff\r\nPOLY ");
    s.extend(std::iter::repeat_n(b"red \t", 900).flatten());
    s.extend_from_slice(b" :9\r\nPX 3 3 ffPX 9 8 010203\nSIZE\nTEXT 0 0 ff :4\nab");
    s
}

#[test]
fn every_cut_of_a_mixed_stream_tells_the_same() {
    let stream = mixed_stream();
    let whole = hear_pieces([&stream[..]], LIMITS, EndOfInput::Stream);
    assert_eq!(whole, hear_naively(&stream, LIMITS, EndOfInput::Stream));
    // The stream ends in an unfinished command, after many events.
    assert!(whole.len() > 30 && matches!(whole.last(), Some(Event::Error(_))));
    for cut in 0..=stream.len() {
        let (a, b) = stream.split_at(cut);
        assert_eq!(hear_pieces([a, b], LIMITS, EndOfInput::Stream), whole, "cut at {cut}");
    }
    for size in [1, 2, 3, 5, 7, 9, 10, 11, 13, 16, 64, 1448] {
        assert_eq!(hear_pieces(stream.chunks(size), LIMITS, EndOfInput::Stream), whole, "pieces of {size}");
    }
}

#[test]
fn every_three_pieces_of_a_short_stream_tell_the_same() {
    let stream = b"PX 1 2 a1b2c3\nPB\x01\x00\x02\x00rgbaPXMULTI\x03\x00\x04\x00\x01\x00\x00\x00rgbaTEXT 1 2 ff :2\nabNO :1\nxSIZE\r\n";
    let whole = hear(stream);
    for a in 0..=stream.len() {
        for b in a..=stream.len() {
            let pieces = [&stream[..a], &stream[a..b], &stream[b..]];
            assert_eq!(
                hear_pieces(pieces, Limits::default(), EndOfInput::Stream),
                whole,
                "cuts at {a} and {b}"
            );
        }
    }
}

#[test]
fn every_prefix_tells_the_beginning_and_at_most_one_more() {
    let stream = mixed_stream();
    let whole = hear_naively(&stream, LIMITS, EndOfInput::Stream);
    for end in [EndOfInput::Stream, EndOfInput::File] {
        for length in 0..stream.len() {
            let heard = hear_pieces([&stream[..length]], LIMITS, end);
            let same = heard.iter().zip(&whole).take_while(|(a, b)| a == b).count();
            assert!(heard.len() - same <= 1, "{length}: {:?}", &heard[same..]);
            assert_eq!(heard, hear_naively(&stream[..length], LIMITS, end), "{length}");
        }
    }
}

/// Generates pieces of streams close to commands, so that random search finds the edge cases.
fn fragment() -> impl Strategy<Value = Vec<u8>> {
    let words = prop::sample::select(vec![
        "PX",
        "px",
        "PB",
        "PXMULTI",
        "TEXT",
        "BLIT",
        "LINE",
        "SIZE",
        "POINTS",
        "MESH",
        "SNAP",
        "#",
        " ",
        "  ",
        "\t",
        "\n",
        "\r",
        "\r\n",
        "\n\n",
        ":",
        ":0",
        ":4",
        ":8",
        ":12",
        ":99",
        ":301",
        ":x",
        ":18446744073709551616",
        "0",
        "1",
        "-1",
        "+12",
        "1023",
        "9999",
        "10000",
        "99999",
        "2147483648",
        "ff",
        "a1b2c3",
        "A1B2C3D4",
        "red",
        "a1b2cg",
        "\0\0\0",
        "\u{1}\0\0\0",
        "é",
    ]);
    prop_oneof![
        8 => words.prop_map(|w| w.as_bytes().to_vec()),
        2 => prop::collection::vec(any::<u8>(), 0..6),
        6 => (0..3000i32, 0..3000i32, any::<u32>()).prop_map(|(x, y, c)| format!("PX {x} {y} {:06x}\n", c >> 8).into_bytes()),
        3 => (any::<i32>(), -12..120i32, any::<u32>(), 0..9usize)
            .prop_map(|(x, y, c, n)| format!("PX {x} {y} {}\n", &format!("{c:08x}")[..n.min(8)]).into_bytes()),
        1 => any::<[u8; 8]>().prop_map(|b| [b"PB".as_slice(), &b].concat()),
        1 => (0..5u32).prop_map(|n| [b"PXMULTI\x01\0\x02\0".as_slice(), &n.to_le_bytes(), &vec![b'\n'; n as usize * 4]].concat()),
        1 => (4050..4110usize).prop_map(|n| vec![b'y'; n]),
    ]
}

/// Generates a plain pixel command with one byte changed: the decoder's fast path must notice every
/// change.
fn damaged_pixel() -> impl Strategy<Value = Vec<u8>> {
    (0..20_000i32, 0..20_000i32, any::<u32>(), 2..9usize, any::<prop::sample::Index>(), any::<u8>()).prop_map(
        |(x, y, c, n, at, byte)| {
            let mut line = format!("PX {x} {y} {}\n", &format!("{c:08x}")[..n]).into_bytes();
            let at = at.index(line.len());
            line[at] = byte;
            line
        },
    )
}

/// Generates lines of figures, most of them plainly written, some with a byte changed, left out or put in.
fn figure_line() -> impl Strategy<Value = Vec<u8>> {
    let verbs: Vec<_> = Verb::all().iter().filter(|v| v.group == Group::TwoD).map(|v| v.name).collect();
    let word = prop_oneof![
        12 => (-999..9999i32).prop_map(|n| n.to_string()),
        2 => (-99.0..99.0f64).prop_map(|n| format!("{n:.2}")),
        1 => prop::sample::select(vec!["-0", "0000007", "1234567", "12345678", "2147483648", "1e3", "+5", "-", "1.", "."])
            .prop_map(str::to_owned),
        1 => prop::sample::select(vec!["red", "#0f8", "#12345678", "80", "abcdefg", ":4", "é", "off"])
            .prop_map(str::to_owned),
        6 => any::<u32>().prop_map(|c| format!("#{:06X}", c >> 8)),
        2 => any::<u32>().prop_map(|c| format!("{c:08x}")),
    ];
    let gap = prop_oneof![30 => Just(" "), 1 => Just("  "), 1 => Just("\t")];
    let end = prop_oneof![12 => Just("\n"), 2 => Just("\r\n"), 1 => Just(" \n"), 1 => Just("\r\r\n")];
    let change = prop_oneof![
        6 => Just(None),
        1 => (0..3u8, any::<prop::sample::Index>(), any::<u8>()).prop_map(Some),
    ];
    let words = prop::collection::vec((gap, word), 0..9);
    (prop::sample::select(verbs), any::<bool>(), words, end, change).prop_map(
        |(verb, lower, words, end, change)| {
            let mut line = if lower { verb.to_lowercase() } else { verb.to_owned() };
            words.iter().for_each(|(gap, word)| line.push_str(&format!("{gap}{word}")));
            let mut line = [line.as_bytes(), end.as_bytes()].concat();
            if let Some((how, at, byte)) = change {
                let at = at.index(line.len());
                match how {
                    0 => line[at] = byte,
                    1 => drop(line.remove(at)),
                    _ => line.insert(at, byte),
                }
            }
            line
        },
    )
}

/// Generates lines of figures with the arguments that their verbs take.
fn whole_figure_line() -> impl Strategy<Value = Vec<u8>> {
    let verbs: Vec<_> =
        Verb::all().iter().filter(|v| v.group == Group::TwoD && v.payload == Payload::Never).collect();
    let number = prop_oneof![9 => (-99..2000i32).prop_map(|n| n.to_string()), 1 => Just("7.25".to_owned())];
    let numbers = prop::collection::vec(number, 10);
    let colors = prop::collection::vec(any::<u32>().prop_map(|c| format!("#{:06x}", c >> 8)), 3);
    (prop::sample::select(verbs), numbers, colors, any::<bool>(), 0..40usize).prop_map(
        |(verb, numbers, colors, most, length)| {
            let (mut numbers, mut colors) = (numbers.iter().cycle(), colors.iter().cycle());
            let mut line = verb.name.to_owned();
            for parameter in verb.parameters {
                let count = if most { parameter.arity.most().unwrap_or(8) } else { parameter.arity.least() };
                for _ in 0..count {
                    let word = match parameter.kind {
                        ParameterKind::Color => colors.next().unwrap().clone(),
                        ParameterKind::RestOfLine => "a b ".repeat(length / 8) + "c",
                        _ => numbers.next().unwrap().clone(),
                    };
                    line.push_str(&format!(" {word}"));
                }
            }
            (line + "\n").into_bytes()
        },
    )
}

#[test]
fn a_figure_over_the_length_of_a_line_is_refused_however_it_is_written() {
    for length in [4095, 4096, 4097] {
        for end in ["\n", "\r\n"] {
            let head = "PRINT 1 2 #00ff00 ";
            let stream = format!("{head}{}{end}LINE 1 2 3 4 #ffffff\n", "x".repeat(length - head.len()));
            let heard = hear(stream.as_bytes());
            assert_eq!(
                heard,
                hear_pieces(stream.as_bytes().chunks(1), Limits::default(), EndOfInput::Stream)
            );
            assert_eq!(matches!(heard[0], Event::Error(_)), length > 4096, "{length}");
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(3000))]

    // A decoder that is fed byte by byte reads no line plainly.
    #[test]
    fn plain_figures_are_what_the_general_reader_hears(
        lines in prop::collection::vec(prop_oneof![figure_line(), whole_figure_line()], 1..12),
    ) {
        let stream = lines.concat();
        let general = hear_pieces(stream.chunks(1), LIMITS, EndOfInput::Stream);
        prop_assert_eq!(&hear_pieces([&stream[..]], LIMITS, EndOfInput::Stream), &general);
        prop_assert_eq!(&hear_pieces(stream.chunks(150), LIMITS, EndOfInput::Stream), &general);
    }

    #[test]
    fn streams_of_near_commands_tell_what_the_naive_reader_hears(
        fragments in prop::collection::vec(fragment(), 0..40),
        sizes in prop::collection::vec(1..70usize, 1..20),
        file in any::<bool>(),
    ) {
        let stream = fragments.concat();
        let end = if file { EndOfInput::File } else { EndOfInput::Stream };
        let truth = hear_naively(&stream, LIMITS, end);
        prop_assert_eq!(&hear_pieces([&stream[..]], LIMITS, end), &truth);
        let mut rest = &stream[..];
        let mut sizes = sizes.iter().cycle();
        let pieces = std::iter::from_fn(|| {
            let (piece, more) = rest.split_at(rest.len().min(*sizes.next()?));
            rest = more;
            (!piece.is_empty()).then_some(piece)
        });
        prop_assert_eq!(&hear_pieces(pieces, LIMITS, end), &truth);
    }

    #[test]
    fn a_pixel_with_one_wrong_byte_between_good_ones_is_read_as_its_words_say(
        line in damaged_pixel(),
        before in 0..5usize,
        after in 0..5usize,
    ) {
        let mut stream = b"PX 12 345 a1b2c3\n".repeat(before);
        stream.extend_from_slice(&line);
        stream.extend_from_slice(&b"PX 6 7 00ff00\n".repeat(after));
        prop_assert_eq!(hear(&stream), hear_naively(&stream, Limits::default(), EndOfInput::Stream));
    }

    #[test]
    fn random_bytes_are_survived(bytes in prop::collection::vec(any::<u8>(), 0..2000), size in 1..300usize) {
        let whole = hear_pieces([&bytes[..]], LIMITS, EndOfInput::Stream);
        prop_assert_eq!(hear_pieces(bytes.chunks(size), LIMITS, EndOfInput::Stream), whole);
    }
}
