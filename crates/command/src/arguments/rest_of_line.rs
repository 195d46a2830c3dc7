//! Text that is the rest of its line: no payload, no length to count.

use super::{Argument, TextArgument};
use crate::args::{Args, ParseError};
use crate::encode::{EncodeError, LineWriter};
use crate::plain_line::PlainWords;
use crate::verb::{Arity, ParameterKind};
use fbptr_core::error::{Code, Fault};

/// The rest of the line after one blank, as it stands there: blanks count, and a last word `:N`
/// announces nothing. It is not all blanks, and has no control characters but tabs.
pub struct RestOfLine;

impl Argument for RestOfLine {
    type Value = String;
    const KIND: ParameterKind = ParameterKind::RestOfLine;
    const WORDS: Arity = Arity::at_least(1);

    fn check_content(text: &String) -> Result<(), Fault> {
        if text.chars().all(|c| c == ' ' || c == '\t') {
            return Err(Fault::new(Code::Args, "there must be a text"));
        }
        match text.chars().find(|c| is_control(*c)) {
            Some(c) => {
                let message = "the text must be one line without control characters";
                Err(Fault::new(Code::Format, message).got(c.to_string()))
            }
            None => Ok(()),
        }
    }

    fn write(text: &String, line: &mut LineWriter<'_>) -> Result<(), EncodeError> {
        line.word(text);
        Ok(())
    }
}

impl TextArgument for RestOfLine {
    fn read(args: &mut Args<'_>) -> Result<String, ParseError> {
        let bytes = args.rest();
        let (text, broken) = match std::str::from_utf8(bytes) {
            Ok(text) => (text, None),
            Err(e) => ("", bytes.get(e.valid_up_to()..)),
        };
        match broken {
            None => Ok(text.to_owned()),
            Some(broken) => {
                let token = broken.get(..1).unwrap_or(broken);
                Err(ParseError::new(Code::Format, "the text must be UTF-8", token))
            }
        }
    }

    fn read_plain(words: &mut PlainWords<'_>) -> Option<String> {
        std::str::from_utf8(words.rest()?).ok().map(str::to_owned)
    }
}

/// Returns whether a character has no place in a line of text.
fn is_control(c: char) -> bool {
    c.is_control() && c != '\t'
}
