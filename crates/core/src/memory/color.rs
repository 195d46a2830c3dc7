//! Colours as text: `gg`, `rrggbb`, `rrggbbaa` in hex, with or without a `#` before the digits,
//! `#rgb`, `#rgba`, or a CSS colour name. Without an alpha, a colour is opaque (ff).
//!
//! A word of hex digits of one of these three lengths is always hex: no CSS name is such a word.

use super::color_names::NAMES;
use super::video::Rgba;

/// Value of each hex digit, either case, and [`NO_DIGIT`] for other bytes. A table, because the mix
/// of digits and letters makes branches unpredictable.
static DIGITS: [u8; 256] = {
    let mut digits = [NO_DIGIT; 256];
    let mut n = 0;
    while n < 16 {
        digits[b"0123456789abcdef"[n] as usize] = n as u8;
        digits[b"0123456789ABCDEF"[n] as usize] = n as u8;
        n += 1;
    }
    digits
};

/// Marks a byte that is not a hex digit. All bits are set, so that or-ing other values keeps it.
const NO_DIGIT: u8 = 0xff;

/// Decodes the hex digits of `word` into `bytes`, two digits each, and returns whether all of them
/// were hex digits.
#[doc(hidden)]
pub fn read_hex(word: &[u8], bytes: &mut [u8]) -> bool {
    let mut seen = 0;
    for (byte, [high, low]) in bytes.iter_mut().zip(word.as_chunks::<2>().0) {
        let (high, low) = (DIGITS[*high as usize], DIGITS[*low as usize]);
        seen |= high | low;
        *byte = high << 4 | low;
    }
    seen != NO_DIGIT
}

fn hex_bytes<const N: usize>(word: &[u8]) -> Option<[u8; N]> {
    let mut bytes = [0; N];
    read_hex(word, &mut bytes).then_some(bytes)
}

/// Returns the colour that `word` stands for, or `None`.
///
/// ```
/// use fbptr_core::memory::parse_color;
/// assert_eq!(parse_color(b"80"), Some([128, 128, 128, 255]));
/// assert_eq!(parse_color(b"FF8000"), Some([255, 128, 0, 255]));
/// assert_eq!(parse_color(b"ff800040"), Some([255, 128, 0, 64]));
/// assert_eq!(parse_color(b"RebeccaPurple"), Some([102, 51, 153, 255]));
/// assert_eq!(parse_color(b"ff80"), None);
/// assert_eq!(parse_color(b"#ff8000"), Some([255, 128, 0, 255]));
/// assert_eq!(parse_color(b"#f80"), Some([255, 136, 0, 255]));
/// ```
pub fn parse_color(word: &[u8]) -> Option<Rgba> {
    if let [b'#', digits @ ..] = word {
        return marked_hex(digits);
    }
    plain_color(word)
}

/// Returns the colour of hex digits after a `#`: as without it, or `rgb` or `rgba`, whose digits
/// are doubled.
fn marked_hex(digits: &[u8]) -> Option<Rgba> {
    if !digits.iter().all(u8::is_ascii_hexdigit) {
        return None;
    }
    match *digits {
        [r, g, b] => plain_color(&[r, r, g, g, b, b]),
        [r, g, b, a] => plain_color(&[r, r, g, g, b, b, a, a]),
        _ => plain_color(digits),
    }
}

/// Returns the colour of hex digits without a mark, or of a CSS name.
fn plain_color(word: &[u8]) -> Option<Rgba> {
    let hex = match word.len() {
        2 => hex_bytes::<1>(word).map(|[g]| [g, g, g, 255]),
        6 => hex_bytes::<3>(word).map(|[r, g, b]| [r, g, b, 255]),
        8 => hex_bytes::<4>(word),
        _ => None,
    };
    hex.or_else(|| named(word))
}

/// Returns the colour that stands in place of three reals, R, G, B in 0..1: a CSS name, or `gg`,
/// `rgb`, `rrggbb`, `rgbf` or `rrggbbff` after a `#`.
///
/// The `#` is required because hex digits alone could be read as a number. The colour of a light
/// has no alpha: one that is not ff is refused.
///
/// ```
/// use fbptr_core::memory::parse_light_color;
/// assert_eq!(parse_light_color(b"#ff0033"), Some([1.0, 0.0, 0.2]));
/// assert_eq!(parse_light_color(b"Yellow"), Some([1.0, 1.0, 0.0]));
/// assert_eq!(parse_light_color(b"ff0033"), None);
/// ```
pub fn parse_light_color(word: &[u8]) -> Option<[f64; 3]> {
    let color = match word.strip_prefix(b"#") {
        Some(digits) => marked_hex(digits),
        None => named(word),
    };
    match color {
        Some([r, g, b, 255]) => Some([r, g, b].map(|c| f64::from(c) / 255.0)),
        _ => None,
    }
}

/// Looks up a CSS name in either case. `transparent` is all zeros, as in CSS.
fn named(word: &[u8]) -> Option<Rgba> {
    let mut lower = [0; MAX_NAME];
    let lower = lower.get_mut(..word.len())?;
    lower.copy_from_slice(word);
    lower.make_ascii_lowercase();
    if lower == b"transparent" {
        return Some([0; 4]);
    }
    let found = NAMES.binary_search_by(|(name, _)| name.as_bytes().cmp(lower)).ok()?;
    let [_, r, g, b] = NAMES[found].1.to_be_bytes();
    Some([r, g, b, 255])
}

/// Length in bytes of `lightgoldenrodyellow`, the longest name.
const MAX_NAME: usize = 20;

/// Returns the names of CSS colours, in lower case, sorted.
pub fn color_names() -> impl Iterator<Item = &'static str> {
    NAMES.iter().map(|(name, _)| *name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_names_are_css_sorted_and_never_hex() {
        assert_eq!(NAMES.len(), 148);
        assert!(NAMES.windows(2).all(|w| w[0].0 < w[1].0));
        assert_eq!(NAMES.iter().map(|n| n.0.len()).max(), Some(MAX_NAME));
        for (name, rgb) in NAMES {
            let [_, r, g, b] = rgb.to_be_bytes();
            assert_eq!(parse_color(name.as_bytes()), Some([r, g, b, 255]), "{name}");
            assert_eq!(parse_color(name.to_uppercase().as_bytes()), Some([r, g, b, 255]), "{name}");
        }
    }

    #[test]
    fn lengths_and_digits_decide() {
        for (word, color) in [
            ("00", [0, 0, 0, 255]),
            ("aB", [0xab, 0xab, 0xab, 255]),
            ("a1B2c3", [0xa1, 0xb2, 0xc3, 255]),
            ("00000000", [0; 4]),
            ("Transparent", [0; 4]),
            ("tan", [210, 180, 140, 255]),
            ("#a1B2c3", [0xa1, 0xb2, 0xc3, 255]),
            ("#a1B2c344", [0xa1, 0xb2, 0xc3, 0x44]),
            ("#f80", [255, 136, 0, 255]),
            ("#F80c", [255, 136, 0, 204]),
            ("#80", [128, 128, 128, 255]),
        ] {
            assert_eq!(parse_color(word.as_bytes()), Some(color), "{word}");
        }
        for word in [
            "",
            "0",
            "000",
            "0000",
            "00000",
            "0000000",
            "000000000",
            "#",
            "##ff0000",
            "#ff000",
            "#red",
            "f80",
            "gg",
            "12345g",
            "0x1234",
            "currentcolor",
            "+10000",
            "é0000",
            "rebeccapurple2rebeccapurple",
        ] {
            assert_eq!(parse_color(word.as_bytes()), None, "{word}");
        }
    }

    #[test]
    fn a_colour_of_light_is_a_name_or_marked_hex_without_alpha() {
        for (word, color) in [
            ("white", [1.0; 3]),
            ("BLACK", [0.0; 3]),
            ("#ff", [1.0; 3]),
            ("#0f3", [0.0, 1.0, 0.2]),
            ("#0033FF", [0.0, 0.2, 1.0]),
            ("#336699ff", [0.2, 0.4, 0.6]),
        ] {
            assert_eq!(parse_light_color(word.as_bytes()), Some(color), "{word}");
        }
        for word in
            ["", "#", "##ff", "#red", "#12345", "#ff000080", "transparent", "1e", "10e305", "80", "reddish"]
        {
            assert_eq!(parse_light_color(word.as_bytes()), None, "{word}");
        }
    }

    #[test]
    fn every_byte_in_every_place_is_checked() {
        for len in [2, 6, 8] {
            for at in 0..len {
                for byte in 0..=255u8 {
                    let mut word = vec![b'0'; len];
                    word[at] = byte;
                    assert_eq!(parse_color(&word).is_some(), byte.is_ascii_hexdigit(), "{word:?}");
                }
            }
        }
    }
}
