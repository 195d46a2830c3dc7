//! The worked example of `CONTRIBUTING.md`, which adds a verb, in a language of its own: the page's
//! row stands here as it is, so that it compiles, and is read, checked and written. Its function
//! stands in `draw2d/example.rs` of `fbptr-core`; `framebuffer/draw2d.rs` makes its method, and
//! `engine/example.rs` of `fbptr-engine` runs such a row on the engine.

use super::args::{Args, ParseError};
use super::arguments::*;
use super::codec::{Codec, Parse};
use super::encode::{EncodeError, LineWriter};
use super::figure::{DrawFigure, Drawn, Lend};
use super::plain_line::{PlainWords, ReadPlain};
use super::verb::{Arity, Encoding, Form, Group, Payload, Reach, Reply, Verb};
use super::verb_macros::*;
use fbptr_core::draw2d::{DrawError, FigureTarget};
use fbptr_core::error::{Code, Fault};
use fbptr_core::memory::Rgba;

const RED: Rgba = [255, 0, 0, 255];

/// Gives the rows of the example to a macro, as `verbs!` does with the table.
macro_rules! example_verbs { ($with:ident $($more:tt)*) => { $with! { $($more)*
nested [Figure(Figure) = fn figure];

TwoD Text Figure {
    CROSS Cross { x: i32, y: i32, r: i32 = Radius, color["c"]: Rgba } = fn cross in clip:
        "draws a cross of two lines, r pixels to each side of a pixel" eg "CROSS 32 24 10 white";
}
}}}
pub(crate) use example_verbs;

example_verbs! { language }

/// The function of the example, which the page adds to [`FigureTarget`].
trait DrawCross {
    fn cross(&mut self, x: i32, y: i32, r: i32, color: Rgba);
}

impl DrawCross for FigureTarget<'_> {
    fn cross(&mut self, x: i32, y: i32, r: i32, color: Rgba) {
        self.line([x.saturating_sub(r), y], [x.saturating_add(r), y], color.into());
        self.line([x, y.saturating_sub(r)], [x, y.saturating_add(r)], color.into());
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
fn the_examples_verb_is_read_checked_and_written() {
    #[rustfmt::skip]
    let valid_forms = [
        ("CROSS 8 6 3 red", Command::Figure(Figure::Cross { x: 8, y: 6, r: 3, color: RED })),
    ];
    for (text, command) in valid_forms {
        assert_eq!(read(text).as_ref(), Ok(&command));
        // Words are read eight bytes at a time.
        let line = format!("{text}\n{}", "\0".repeat(8));
        let words = &mut PlainWords::new(&line.as_bytes()["CROSS ".len()..]);
        assert_eq!(PLAIN[0].expect("a figure")(words).map(Command::Figure).as_ref(), Some(&command));
        let mut bytes = command.verb().as_bytes().to_vec();
        command.write(&mut LineWriter::new("CROSS", &mut bytes)).expect("it has a text form");
        assert_eq!((bytes.as_slice(), command.payload()), (&b"CROSS 8 6 3 ff0000"[..], None));
    }
}

#[test]
fn the_examples_row_says_all_that_others_are_told() {
    let [verb] = TABLE else { panic!("{TABLE:?}") };
    assert_eq!((verb.forms[0].syntax, verb.example), ("CROSS x y r c", "CROSS 32 24 10 white"));
    assert_eq!((verb.arity, verb.payload, verb.reply), (Arity::exactly(4), Payload::Never, Reply::Never));
    assert_eq!((verb.group, verb.encoding), (Group::TwoD, Encoding::Text));
    let words: Vec<&str> = verb.parameters.iter().map(|p| p.syntax).collect();
    assert_eq!(words, ["x", "y", "r", "c"]);
    let fault = Figure::Cross { x: 0, y: 0, r: -1, color: RED }.check_sizes().expect_err("a negative radius");
    assert_eq!((fault.code, fault.message.as_str()), (Code::Range, "the radius must be 0 or more"));
    let refused = read("CROSS 8 6 3 reddish").expect_err("no colour");
    assert_eq!((refused.code, refused.token.as_slice()), (Code::Colour, &b"reddish"[..]));
}

#[test]
fn the_pages_lines_stand_here() {
    let lines = |text: &str| text.lines().map(|l| l.trim().to_owned()).collect::<Vec<_>>();
    let here = [include_str!("example.rs"), include_str!("../../core/src/draw2d/example.rs")].map(lines);
    let page = include_str!("../../../CONTRIBUTING.md");
    let blocks: Vec<&str> =
        page.split("```rust\n").skip(1).filter_map(|rest| rest.split("```").next()).collect();
    assert_eq!(blocks.len(), 3, "the row, the function and the test");
    for block in blocks {
        let block = lines(block);
        let is_in = |file: &Vec<String>| file.windows(block.len()).any(|window| window == block);
        assert!(here.iter().any(is_in), "not in the example: {block:#?}");
    }
}
