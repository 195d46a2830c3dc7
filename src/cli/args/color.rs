//! Colours as arguments, in the syntax of the command language.

use crate::command::parse_color;
use crate::memory::Rgba;

/// Parses `rrggbb`, `rrggbbaa` or `gg` in hex, with or without a `#`, or a CSS name.
pub(in crate::cli) fn color(text: &str) -> Result<Rgba, String> {
    let word = text.strip_prefix('#').unwrap_or(text);
    parse_color(word.as_bytes()).ok_or_else(|| {
        format!(
            "expected a colour as rrggbb, rrggbbaa or gg in hex, or a CSS name such as tomato, found {text:?}"
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hex_or_a_name() {
        assert_eq!(color("#ff8000"), Ok([255, 128, 0, 255]));
        assert_eq!(color("RebeccaPurple"), Ok([102, 51, 153, 255]));
        assert_eq!(color("ff800040"), Ok([255, 128, 0, 64]));
        assert!(color("").is_err() && color("reddish").unwrap_err().contains("reddish"));
    }
}
