//! Durations as arguments, with s, m or h.

use std::str::FromStr;
use std::time::Duration;

/// A duration in whole seconds, from 1s to 8760h: `10`, `10s`, `5m`, `1h`.
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

/// Parses digits only: no sign.
fn whole(digits: &str) -> Option<u64> {
    digits.bytes().all(|b| b.is_ascii_digit()).then(|| digits.parse().ok()).flatten()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_have_units() {
        for (text, seconds) in [("1", 1), ("10s", 10), ("5m", 300), ("2h", 7200)] {
            assert_eq!(text.parse(), Ok(Interval(Duration::from_secs(seconds))), "{text}");
        }
        for text in ["", "s", "0", "0s", "-1s", "1.5s", "10 s", "1d", "9000h", "99999999999999999999h", "é"]
        {
            assert!(text.parse::<Interval>().is_err(), "{text}");
        }
    }
}
