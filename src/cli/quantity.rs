//! Quantities as arguments: bytes with K, M or G, and times with s, m or h.

use std::str::FromStr;
use std::time::Duration;

/// So many bytes: `4096`, `64K`, `512M`, `2G` (powers of 1024).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Bytes(pub u64);

impl FromStr for Bytes {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let units = [('K', 10), ('M', 20), ('G', 30)];
        let expected = || format!("bytes are a number, and K, M or G after it, as in 512M, not {text:?}");
        let last = text.chars().last().map(|c| c.to_ascii_uppercase());
        let (digits, shift) = match units.iter().find(|(unit, _)| Some(*unit) == last) {
            Some((_, shift)) => (&text[..text.len() - 1], *shift),
            None => (text, 0),
        };
        let number = whole(digits).ok_or_else(expected)?;
        number.checked_mul(1 << shift).map(Bytes).ok_or_else(|| format!("{text:?} is more than 2^64 bytes"))
    }
}

/// A time of whole seconds, from one second on: `10`, `10s`, `5m`, `1h`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Interval(pub Duration);

impl FromStr for Interval {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let units = [('s', 1), ('m', 60), ('h', 3600)];
        let expected = || format!("a time is a number, and s, m or h after it, as in 10s, not {text:?}");
        let last = text.chars().last();
        let (digits, seconds) = match units.iter().find(|(unit, _)| Some(*unit) == last) {
            Some((_, seconds)) => (&text[..text.len() - 1], *seconds),
            None => (text, 1),
        };
        let seconds = whole(digits).ok_or_else(expected)?.saturating_mul(seconds);
        match seconds {
            1..=31_536_000 => Ok(Interval(Duration::from_secs(seconds))),
            _ => Err(format!("a time is from 1s to 8760h, not {text:?}")),
        }
    }
}

/// Digits alone: no sign.
fn whole(digits: &str) -> Option<u64> {
    digits.bytes().all(|b| b.is_ascii_digit()).then(|| digits.parse().ok()).flatten()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_and_times_have_units() {
        for (text, bytes) in [("0", 0), ("17", 17), ("4k", 4096), ("512M", 512 << 20), ("2G", 2 << 30)] {
            assert_eq!(text.parse(), Ok(Bytes(bytes)), "{text}");
        }
        for (text, seconds) in [("1", 1), ("10s", 10), ("5m", 300), ("2h", 7200)] {
            assert_eq!(text.parse(), Ok(Interval(Duration::from_secs(seconds))), "{text}");
        }
        for text in ["", "K", "-1", "+1", "1.5G", "1 G", "20000000000G", "1KB", "é"] {
            assert!(text.parse::<Bytes>().is_err(), "{text}");
        }
        for text in ["", "s", "0", "0s", "-1s", "1.5s", "10 s", "1d", "9000h", "99999999999999999999h", "é"]
        {
            assert!(text.parse::<Interval>().is_err(), "{text}");
        }
    }
}
