//! Tokens of a C or C++ source.
//!
//! In: bytes in any encoding of the ASCII kind. Out: words, numbers and signs with the places behind
//! them in those bytes, without comments, texts, lines of the preprocessor, and what `#if 0` leaves out.

/// A token and the place behind it.
#[derive(Clone, Debug)]
pub struct Token {
    pub text: String,
    pub end: usize,
}

impl Token {
    /// Returns whether it is a name or a keyword.
    pub fn is_word(&self) -> bool {
        self.text.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_')
    }
}

/// Returns a source with spaces in place of comments, texts and lines of the preprocessor.
fn blank(source: &[u8]) -> Vec<u8> {
    let mut out = source.to_vec();
    let (mut at, mut is_line_start) = (0, true);
    while at < source.len() {
        let rest = &source[at..];
        let len = if rest.starts_with(b"//") {
            line_end(rest)
        } else if rest.starts_with(b"/*") {
            rest[2..].windows(2).position(|two| two == b"*/").map_or(rest.len(), |end| end + 4)
        } else if let Some(len) = raw_text_end(source, at) {
            len
        } else if rest[0] == b'"' || (rest[0] == b'\'' && !is_separator(source, at)) {
            text_end(rest)
        } else if rest[0] == b'#' && is_line_start {
            if is_left_out(rest) { left_out(rest) } else { line_end(rest) }
        } else {
            is_line_start = rest[0] == b'\n' || (is_line_start && rest[0].is_ascii_whitespace());
            at += 1;
            continue;
        };
        let end = (at + len.max(1)).min(source.len());
        out[at..end].fill(b' ');
        at = end;
    }
    out
}

/// Returns the word of a line of the preprocessor, and what follows it.
fn directive(line: &[u8]) -> Option<(&[u8], &[u8])> {
    let line = line.trim_ascii_start().strip_prefix(b"#")?.trim_ascii_start();
    let len = line.iter().take_while(|byte| byte.is_ascii_alphabetic()).count();
    Some((&line[..len], line[len..].trim_ascii()))
}

/// Returns whether a line is `#if 0`, and nothing that an operator goes on with.
fn is_left_out(rest: &[u8]) -> bool {
    let (word, value) = directive(&rest[..line_end(rest)]).unwrap_or_default();
    let comment = value.windows(2).position(|two| two == b"//" || two == b"/*");
    let value = value[..comment.unwrap_or(value.len())].trim_ascii();
    word == b"if" && matches!(value, b"0" | b"(0)" | b"false")
}

/// Returns the length of what `#if 0` leaves out, with the line that ends it.
fn left_out(rest: &[u8]) -> usize {
    let (mut at, mut depth) = (0, 0_usize);
    while at < rest.len() {
        let end = at + line_end(&rest[at..]);
        match directive(&rest[at..end]) {
            Some((b"if" | b"ifdef" | b"ifndef", _)) => depth += 1,
            Some((b"endif", _)) if depth <= 1 => return end,
            Some((b"endif", _)) => depth -= 1,
            Some((b"else" | b"elif", _)) if depth == 1 => return end,
            _ => {}
        }
        at = end + 1;
    }
    rest.len()
}

/// Returns the length of a line, with the lines that a backslash joins to it.
fn line_end(rest: &[u8]) -> usize {
    let is_end = |at: &usize| {
        let before = rest[..*at].strip_suffix(b"\r").unwrap_or(&rest[..*at]);
        rest[*at] == b'\n' && !before.ends_with(b"\\")
    };
    (0..rest.len()).find(is_end).unwrap_or(rest.len())
}

/// Returns the length of a text in quotes, which ends with its line at the latest.
fn text_end(rest: &[u8]) -> usize {
    let mut at = 1;
    while at < rest.len() && rest[at] != rest[0] && rest[at] != b'\n' {
        at += 1 + usize::from(rest[at] == b'\\');
    }
    at + 1
}

/// Returns whether a quote parts the digits of a number, as in 1'000.
fn is_separator(source: &[u8], at: usize) -> bool {
    let word = source[..at].iter().rev().take_while(|byte| byte.is_ascii_alphanumeric() || **byte == b'\'');
    word.last().is_some_and(u8::is_ascii_digit)
}

/// Returns the length of a raw text from its quote on: R"( ... )", with a word before the brackets or none.
fn raw_text_end(source: &[u8], at: usize) -> Option<usize> {
    let rest = source[at..].strip_prefix(b"\"")?;
    if !source[..at].ends_with(b"R") {
        return None;
    }
    let word = rest.iter().position(|byte| *byte == b'(').filter(|len| *len <= 16)?;
    let end = [b")", &rest[..word], b"\""].concat();
    let len = rest.windows(end.len()).position(|bytes| bytes == end)?;
    Some(1 + len + end.len())
}

/// Returns the tokens of a source.
pub fn tokens(source: &[u8]) -> Vec<Token> {
    let text = &blank(source);
    let is_part = |byte: &u8| byte.is_ascii_alphanumeric() || *byte == b'_';
    let (mut tokens, mut at) = (Vec::new(), 0);
    while at < text.len() {
        let len = match text[at] {
            byte if byte.is_ascii_whitespace() || !byte.is_ascii() => {
                at += 1;
                continue;
            }
            byte if is_part(&byte) => text[at..].iter().take_while(|byte| is_part(byte)).count(),
            b':' if text[at..].starts_with(b"::") => 2,
            _ => 1,
        };
        let word = String::from_utf8_lossy(&text[at..at + len]).into_owned();
        at += len;
        tokens.push(Token { text: word, end: at });
    }
    tokens
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the tokens' texts with a blank between them.
    fn texts(source: &str) -> String {
        tokens(source.as_bytes()).iter().map(|token| token.text.as_str()).collect::<Vec<_>>().join(" ")
    }

    #[test]
    fn quotes_in_numbers_and_raw_texts_hide_no_brace() {
        assert_eq!(texts("int k = 1'000; }"), "int k = 1 ' 000 ; }");
        assert_eq!(texts("int k = 0xff'ff'; }"), "int k = 0xff ' ff ' ; }");
        assert_eq!(texts("char c = '{'; char d = '\\'';}"), "char c = ; char d = ; }");
        assert_eq!(texts("f(R\"(a \"quoted{\" text)\"); g(R\"x(}\")x\");"), "f ( R ) ; g ( R ) ;");
    }

    #[test]
    fn only_a_condition_of_zero_leaves_code_out() {
        for (condition, is_kept) in [
            ("0", false),
            ("(0) // old", false),
            ("0 /* a */", false),
            ("false", false),
            ("0 || 1", true),
            ("0x1", true),
            ("01", true),
        ] {
            assert_eq!(
                texts(&format!("#if {condition}\nint a;\n#endif\n")) == "int a ;",
                is_kept,
                "{condition}"
            );
        }
    }
}
