//! The worked example of `CONTRIBUTING.md`, which adds a verb, in a language of its own: the page's
//! lines stand here as they are, so that they compile, and run.

use super::args::{Args, ParseError};
use super::arguments::*;
use super::codec::{Codec, Parse};
use super::encode::{EncodeError, LineWriter};
use super::verb::{Arity, Encoding, Form, Group, Payload, Reply, Verb};
use super::verb_macros::*;
use crate::draw2d::{self, Blend, RampColor};
use crate::error::{Code, Fault};
use crate::memory::{Rgba, VideoMemory};

const RED: Rgba = [255, 0, 0, 255];

language! {
nested [];

TwoD Text Command {
    CROSS Cross { x: i32, y: i32, r: i32 = Radius, color["c"]: Rgba }:
        "draws a cross of two lines, r pixels to each side of a pixel";
}
}

/// Stands for the session of a connection.
struct Session {
    blend: Blend,
}

/// Stands for the engine.
struct Engine {
    memory: VideoMemory,
}

impl Engine {
    fn dispatch(&mut self, s: &mut Session, command: Command) {
        use Command as C;
        match command {
            C::Cross { x, y, r, color } => self.cross(s, [x, y], r, color),
        }
    }

    /// Draws a cross of two lines, `r` pixels to each side of a pixel.
    fn cross(&mut self, s: &Session, [x, y]: [i32; 2], r: i32, color: Rgba) {
        let color = RampColor { from: color, to: None };
        let [left, right] = [x.saturating_sub(r), x.saturating_add(r)];
        let [top, bottom] = [y.saturating_sub(r), y.saturating_add(r)];
        draw2d::line(&mut self.memory, [left, y], [right, y], color, s.blend);
        draw2d::line(&mut self.memory, [x, top], [x, bottom], color, s.blend);
    }
}

/// Returns the command of a line of the language.
fn read(line: &str) -> Result<Command, ParseError> {
    let (verb, words) = line.split_once(' ').expect("a verb and words");
    let row = TABLE.iter().position(|v| v.name == verb).expect("a verb of the table");
    let mut args = Args::new(words.as_bytes());
    assert!(TABLE[row].arity.allows(args.count()), "{line}");
    PARSERS[row].expect("a text verb")(&mut args)
}

#[test]
fn the_examples_verb_is_read_checked_written_and_drawn() {
    #[rustfmt::skip]
    let valid_forms = [
        ("CROSS 8 6 3 red", Command::Cross { x: 8, y: 6, r: 3, color: RED }),
    ];
    for (text, command) in valid_forms {
        assert_eq!(read(text).as_ref(), Ok(&command));
        let mut bytes = command.verb().as_bytes().to_vec();
        command.write(&mut LineWriter::new("CROSS", &mut bytes)).expect("it has a text form");
        assert_eq!((bytes.as_slice(), command.payload()), (&b"CROSS 8 6 3 ff0000"[..], None));

        let mut engine = Engine { memory: VideoMemory::new(16, 12).expect("a small frame") };
        engine.dispatch(&mut Session { blend: Blend::Replace }, command);
        let is_red = |x, y| engine.memory.get_pixel(x, y).is_ok_and(|color| color == RED);
        let red = (0..16).flat_map(|x| (0..12).map(move |y| (x, y))).filter(|(x, y)| is_red(*x, *y));
        let expected = (5..12).map(|x| (x, 6)).chain((3..10).map(|y| (8, y)));
        let [red, expected]: [std::collections::BTreeSet<(i32, i32)>; 2] =
            [red.collect(), expected.collect()];
        assert_eq!(red, expected);
    }
}

#[test]
fn the_examples_row_says_all_that_others_are_told() {
    let [verb] = TABLE else { panic!("{TABLE:?}") };
    assert_eq!(verb.forms[0].syntax, "CROSS x y r c");
    assert_eq!((verb.arity, verb.payload, verb.reply), (Arity::exactly(4), Payload::Never, Reply::Never));
    assert_eq!((verb.group, verb.encoding), (Group::TwoD, Encoding::Text));
    let words: Vec<&str> = verb.parameters.iter().map(|p| p.syntax).collect();
    assert_eq!(words, ["x", "y", "r", "c"]);
    let fault =
        Command::Cross { x: 0, y: 0, r: -1, color: RED }.check_sizes().expect_err("a negative radius");
    assert_eq!((fault.code, fault.message.as_str()), (Code::Range, "the radius must be 0 or more"));
    let refused = read("CROSS 8 6 3 reddish").expect_err("no colour");
    assert_eq!((refused.code, refused.token.as_slice()), (Code::Colour, &b"reddish"[..]));
}

#[test]
fn the_pages_lines_stand_here() {
    let lines = |text: &str| text.lines().map(|l| l.trim().to_owned()).collect::<Vec<_>>();
    let here = lines(include_str!("example.rs"));
    let page = include_str!("../../CONTRIBUTING.md");
    let blocks: Vec<&str> =
        page.split("```rust\n").skip(1).filter_map(|rest| rest.split("```").next()).collect();
    assert_eq!(blocks.len(), 4, "the row, the arm, the function and the test");
    for block in blocks {
        let block = lines(block);
        assert!(here.windows(block.len()).any(|window| window == block), "not in the example: {block:#?}");
    }
}
