//! File names of periodic snapshots: `wall-YYYYMMDD-HHMMSS[-N].png`.

use std::path::Path;

const PREFIX: &str = "wall-";
const ENDING: &str = ".png";
/// Most pictures of one second, which differ by a number.
pub const MOST_A_SECOND: u32 = 1000;

/// Returns whether a file name has the form of periodic snapshots; `SNAP` must not write such
/// files.
pub(super) fn is_own_name(name: &str) -> bool {
    let last = Path::new(name).file_name().and_then(|last| last.to_str());
    last.is_some_and(|last| parse_name(&last.to_ascii_lowercase()).is_some())
}

/// Parses `wall-YYYYMMDD-HHMMSS[-N].png`. Returns the time and the number.
pub fn parse_name(name: &str) -> Option<(String, u32)> {
    let middle = name.strip_prefix(PREFIX)?.strip_suffix(ENDING)?;
    let (stamp, number) = match middle.get(15..)? {
        "" => (middle, 0),
        rest => (&middle[..15], rest.strip_prefix('-')?.parse().ok()?),
    };
    let is_stamp =
        stamp.bytes().enumerate().all(|(i, b)| if i == 8 { b == b'-' } else { b.is_ascii_digit() });
    let is_written_so = name == format_name(stamp, number);
    (is_stamp && is_written_so && number < MOST_A_SECOND).then(|| (stamp.to_owned(), number))
}

/// Returns the name of the picture of a second with this number.
pub fn format_name(stamp: &str, number: u32) -> String {
    match number {
        0 => format!("{PREFIX}{stamp}{ENDING}"),
        n => format!("{PREFIX}{stamp}-{n}{ENDING}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_ours_only_when_written_as_we_write_them() {
        for own in [
            "wall-20261122-134405.png",
            "wall-20261122-134405-7.png",
            "a/wall-20261122-134405.png",
            "WALL-20261122-134405.PNG",
        ] {
            assert!(is_own_name(own), "{own}");
        }
        for other in [
            "wall-20261122-134405.png.txt",
            "wall-2026112-134405.png",
            "wall-20261122_134405.png",
            "wall-.png",
            "wall-20261122-134405-.png",
            "wall-20261122-134405-07.png",
            "wall-20261122-134405-1000.png",
            "wall-20261122-134405+1.png",
            "xwall-20261122-134405.png",
            "wall-20261122-13440é.png",
            "wall.png",
            "",
        ] {
            assert!(!is_own_name(other), "{other}");
        }
    }
}
