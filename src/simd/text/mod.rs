//! Plain text pixels, many in a row: the decoder's hot path.
//!
//! In: a stream from a command boundary on. Taken here: lines `PX x y c` + LF with single blanks, x and y of one to four
//! digits, c of two, six or eight hex digits in either case, LF or CR LF. All else (signs, names, queries, other verbs, a
//! line that is not whole) ends the run and is left to the general reader. Every byte is looked at: a line with anything
//! out of place is not taken. Out: x, y and R,G,B,A of each, in order.
//!
//! Two twins with the same answer for every input: `portable` in whole words of eight bytes, and vectors of sixteen
//! bytes where the CPU has AVX2. Which one runs is asked of the CPU at each call, which costs a load.

mod portable;
#[cfg(target_arch = "x86_64")]
mod x86;

/// How many bytes a line is read through: none that is taken here has more, and a twin may look this far.
const WINDOW: usize = 32;

/// Reads plain pixels from the start of `bytes` on, giving each to `each`. Answers how many bytes and lines it took:
/// those up to the first line that is not plain or not whole, or somewhat before the end when that is near.
#[inline]
pub fn pixel_lines(bytes: &[u8], each: &mut impl FnMut(u16, u16, [u8; 4])) -> (usize, u64) {
    if !bytes.starts_with(b"PX ") {
        return (0, 0);
    }
    let (used, lines) = whole_windows(bytes, each);
    // The last lines are read in a copy with room behind it. No line is made of the zeros: none holds an LF.
    let rest = &bytes[used..];
    if !rest.starts_with(b"PX ") || rest.len() >= WINDOW {
        return (used, lines);
    }
    let mut padded = [0; 2 * WINDOW];
    padded[..rest.len()].copy_from_slice(rest);
    let (more_used, more_lines) = whole_windows(&padded, each);
    (used + more_used, lines + more_lines)
}

/// The same without the last window.
#[inline]
fn whole_windows(bytes: &[u8], each: &mut impl FnMut(u16, u16, [u8; 4])) -> (usize, u64) {
    #[cfg(target_arch = "x86_64")]
    if x86::is_there() {
        // SAFETY: the CPU was just asked for what the function needs.
        return unsafe { x86::pixel_lines(bytes, each) };
    }
    portable::pixel_lines(bytes, each)
}

/// Runs one line reader after the other for as long as any of them takes a line: a stream keeps to one form of colour.
/// Answers how many bytes and lines were taken.
macro_rules! runs {
    ($bytes:expr, $each:expr, [$($line:expr),+]) => {{
        let (bytes, each): (&[u8], _) = ($bytes, $each);
        let (mut rest, mut lines) = (bytes, 0u64);
        loop {
            let before = lines;
            $(
                while let Some(window) = rest.first_chunk::<{ super::WINDOW }>() {
                    let Some((x, y, color, length)) = $line(window) else { break };
                    each(x, y, color);
                    lines += 1;
                    rest = &rest[length..];
                }
            )+
            if lines == before {
                break (bytes.len() - rest.len(), lines);
            }
        }
    }};
}
use runs;

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    type Heard = (Vec<(u16, u16, [u8; 4])>, (usize, u64));

    fn heard(read: impl Fn(&[u8], &mut dyn FnMut(u16, u16, [u8; 4])) -> (usize, u64), bytes: &[u8]) -> Heard {
        let mut pixels = Vec::new();
        let taken = read(bytes, &mut |x, y, c| pixels.push((x, y, c)));
        (pixels, taken)
    }

    fn portable(bytes: &[u8]) -> Heard {
        heard(|b, mut f| portable::pixel_lines(b, &mut f), bytes)
    }

    #[cfg(target_arch = "x86_64")]
    fn vectors(bytes: &[u8]) -> Option<Heard> {
        // SAFETY: the CPU was just asked for what the function needs.
        x86::is_there().then(|| heard(|b, mut f| unsafe { x86::pixel_lines(b, &mut f) }, bytes))
    }

    #[cfg(not(target_arch = "x86_64"))]
    fn vectors(_: &[u8]) -> Option<Heard> {
        None
    }

    /// The same by plain means: split at LF, split at blanks.
    fn plainly(bytes: &[u8]) -> Heard {
        let (mut pixels, mut used) = (Vec::new(), 0);
        let pixel = |line: &str| -> Option<(u16, u16, [u8; 4])> {
            let words: Vec<&str> =
                line.strip_suffix("\r\n").or(line.strip_suffix('\n'))?.split(' ').collect();
            let ["PX", x, y, color] = words[..] else { return None };
            let number = |w: &str| {
                let plain = (1..=4).contains(&w.len()) && w.bytes().all(|b| b.is_ascii_digit());
                if plain { w.parse().ok() } else { None }
            };
            if !color.bytes().all(|b| b.is_ascii_hexdigit()) {
                return None;
            }
            let byte = |i| u8::from_str_radix(&color[i..i + 2], 16).ok();
            let color = match color.len() {
                2 => [byte(0)?, byte(0)?, byte(0)?, 255],
                6 => [byte(0)?, byte(2)?, byte(4)?, 255],
                8 => [byte(0)?, byte(2)?, byte(4)?, byte(6)?],
                _ => return None,
            };
            Some((number(x)?, number(y)?, color))
        };
        for line in bytes.split_inclusive(|&b| b == b'\n') {
            let Some(found) = std::str::from_utf8(line).ok().and_then(pixel) else { break };
            pixels.push(found);
            used += line.len();
        }
        let lines = pixels.len() as u64;
        (pixels, (used, lines))
    }

    /// Both twins, alone and with the end looked at, against the plain reading.
    fn check(bytes: &[u8]) {
        let plain = plainly(bytes);
        assert_eq!(
            heard(|b, mut f| pixel_lines(b, &mut f), bytes),
            plain,
            "{:?}",
            String::from_utf8_lossy(bytes)
        );
        let mut padded = bytes.to_vec();
        padded.extend([0; WINDOW]);
        assert_eq!(portable(&padded), plain, "{:?}", String::from_utf8_lossy(bytes));
        if let Some(found) = vectors(&padded) {
            assert_eq!(found, plain, "{:?}", String::from_utf8_lossy(bytes));
        }
    }

    #[test]
    fn every_shape_of_line_is_taken_whole() {
        for x in ["0", "7", "42", "008", "1919", "0000", "9999"] {
            for y in ["0", "9", "10", "333", "1079", "0001"] {
                for color in ["00", "fF", "a1b2c3", "FFFFFF", "01234567", "89abcdef", "ABCDEF09"] {
                    for end in ["\n", "\r\n"] {
                        let line = format!("PX {x} {y} {color}{end}");
                        let taken = plainly(line.as_bytes()).1;
                        assert_eq!(taken, (line.len(), 1));
                        check(line.as_bytes());
                        check(line.repeat(5).as_bytes());
                    }
                }
            }
        }
    }

    #[test]
    fn every_byte_in_every_place_is_checked() {
        for line in [
            "PX 1 2 ff\n",
            "PX 12 3 a0b1c2\n",
            "PX 1234 5678 00ff7f\n",
            "PX 123 45 90807060\n",
            "PX 12 3 a0b1c2\r\n",
        ] {
            for at in 0..line.len() {
                for byte in 0..=255 {
                    let mut bytes = [line, line, "PX 9 9 99\n"].concat().into_bytes();
                    bytes[line.len() + at] = byte;
                    check(&bytes);
                }
            }
        }
    }

    #[test]
    fn every_arrangement_of_blanks_and_digits_is_read_alike() {
        let letters = *b" 7f";
        for length in 0..=8u32 {
            for number in 0..3usize.pow(length) {
                let words = (0..length).map(|i| letters[number / 3usize.pow(i) % 3]);
                let line: Vec<u8> = b"PX".iter().copied().chain(words).chain(*b"\n").collect();
                check(&[&line[..], b"PX 5 6 ff0000\n"].concat());
            }
        }
    }

    #[test]
    fn other_lengths_of_words_are_left() {
        for line in [
            "PX 12345 6 ff0000\n",
            "PX 1 23456 ff0000\n",
            "PX  1 2 ff0000\n",
            "PX 1  2 ff0000\n",
            "PX 1 2  ff0000\n",
            "PX   ff\n",
            "PX    ff\n",
            "PX   ff0000\n",
            "PX 1 2 f\n",
            "PX 1 2 fff\n",
            "PX 1 2 ffff\n",
            "PX 1 2 fffff\n",
            "PX 1 2 fffffff\n",
            "PX 1 2 fffffffff\n",
            "PX 1 2 ff0000 \n",
            "PX 1 2 ff0000\r\r\n",
            "PX 1 2\n",
            "PX 1 2 \n",
            "PX  2 ff\n",
            "PX 1 2 :0\n",
            "px 1 2 ff\n",
            "PX 1 ff0000\n",
            "PX 1 2 3 ff0000\n",
            "PX 1 2 ff0000",
            "\n",
            "",
            "P",
            "PX",
            "PX ",
            "PX 1 2\nPX 3 4 ff\n",
        ] {
            assert_eq!(plainly(line.as_bytes()).1, (0, 0), "{line:?}");
            check(line.as_bytes());
            check(format!("PX 5 6 ff0000\n{line}PX 7 8 ff0000\n").as_bytes());
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(4000))]

        #[test]
        fn the_twins_read_as_plain_reading_does(
            lines in prop::collection::vec((0..12_000u32, 0..12_000u32, any::<u32>(), prop::sample::select(vec![2, 6, 6, 6, 6, 8, 8, 5]), prop::sample::select(vec!["\n", "\n", "\r\n"])), 0..12),
            damage in prop::option::weighted(0.5, (any::<prop::sample::Index>(), any::<u8>())),
            cut in any::<prop::sample::Index>(),
        ) {
            let mut bytes: Vec<u8> =
                lines.iter().flat_map(|(x, y, c, n, end)| format!("PX {x} {y} {}{end}", &format!("{c:08x}")[..*n]).into_bytes()).collect();
            if let (Some((at, byte)), false) = (damage, bytes.is_empty()) {
                let at = at.index(bytes.len());
                bytes[at] = byte;
            }
            check(&bytes);
            check(&bytes[..cut.index(bytes.len() + 1)]);
        }
    }
}
