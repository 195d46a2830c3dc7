//! The rights to watch and to drive, and the tokens that prove them.
//!
//! In: the token of a link, as a browser sends it. Out: the rights of that viewer. A token stands
//! behind the `#` of a link, so that it is in no request, no log and no `Referer`; the page sends it
//! as its first message. Promise: the time of a comparison does not depend on where two tokens
//! differ.

use std::fmt;
use std::io;

/// Random bytes of a token.
const TOKEN_BYTES: usize = 16;

/// The rights of a viewer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Rights {
    /// To see frames.
    Watch,
    /// To see frames, to run commands and to send events.
    Drive,
}

/// A random word of a link.
#[derive(Clone, PartialEq, Eq)]
struct Token(String);

impl fmt::Debug for Token {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Token")
    }
}

impl Token {
    fn random() -> io::Result<Token> {
        let mut bytes = [0; TOKEN_BYTES];
        getrandom::fill(&mut bytes).map_err(io::Error::other)?;
        Ok(Token(bytes.iter().map(|byte| format!("{byte:02x}")).collect()))
    }

    /// Returns whether `word` is the token. Reads all of it, wherever they differ.
    fn is(&self, word: &str) -> bool {
        let (own, other) = (self.0.as_bytes(), word.as_bytes());
        let differences = own.iter().zip(other).fold(0, |all, (a, b)| all | (a ^ b));
        own.len() == other.len() && std::hint::black_box(differences) == 0
    }
}

/// The tokens of a server's links.
#[derive(Clone, Debug)]
pub struct WebTokens {
    /// `None` if everybody who reaches the address may watch.
    watch: Option<Token>,
    /// `None` if nobody may drive.
    drive: Option<Token>,
}

impl WebTokens {
    /// Draws the tokens that are needed: one to watch if `is_remote`, one to drive if `is_writable`.
    ///
    /// # Errors
    /// If the system has no random numbers.
    pub fn new(is_remote: bool, is_writable: bool) -> io::Result<WebTokens> {
        let token = |is_needed: bool| is_needed.then(Token::random).transpose();
        Ok(WebTokens { watch: token(is_remote)?, drive: token(is_writable)? })
    }

    /// Returns the word behind the `#` of the link for watching, if it needs one.
    pub fn watch(&self) -> Option<&str> {
        self.watch.as_ref().map(|token| token.0.as_str())
    }

    /// Returns the word behind the `#` of the link for driving, if that is allowed.
    pub fn drive(&self) -> Option<&str> {
        self.drive.as_ref().map(|token| token.0.as_str())
    }

    /// Returns the rights of who sends `word`, if any.
    pub(super) fn rights(&self, word: &str) -> Option<Rights> {
        let is = |token: &Option<Token>| token.as_ref().is_some_and(|token| token.is(word));
        let (watches, drives) = (is(&self.watch), is(&self.drive));
        match drives {
            true => Some(Rights::Drive),
            false => (watches || self.watch.is_none()).then_some(Rights::Watch),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_token_gives_its_right_and_no_other() {
        let tokens = WebTokens::new(true, true).unwrap();
        let (watch, drive) = (tokens.watch().unwrap(), tokens.drive().unwrap());
        assert_ne!(watch, drive);
        assert_eq!(watch.len(), 2 * TOKEN_BYTES);
        assert_eq!(tokens.rights(watch), Some(Rights::Watch));
        assert_eq!(tokens.rights(drive), Some(Rights::Drive));
        for wrong in ["", "0", &watch[1..], &format!("{drive}0"), &drive.to_uppercase().replace('0', "1")] {
            assert_eq!(tokens.rights(wrong), None, "{wrong}");
        }
        let local = WebTokens::new(false, false).unwrap();
        assert_eq!((local.rights(""), local.rights(drive)), (Some(Rights::Watch), Some(Rights::Watch)));
        assert_eq!((local.watch(), local.drive()), (None, None));
        assert!(!format!("{tokens:?}").contains(drive), "a token is not in logs");
    }
}
