//! The versions compared with a plain reader.

use super::*;
use proptest::prelude::*;

type Heard = (Vec<(u16, u16, [u8; 4])>, (usize, u64));

fn heard(read: impl Fn(&[u8], &mut dyn FnMut(u16, u16, [u8; 4])) -> (usize, u64), bytes: &[u8]) -> Heard {
    let mut pixels = Vec::new();
    let taken = read(bytes, &mut |x, y, c| pixels.push((x, y, c)));
    (pixels, taken)
}

fn heard_records(read: impl Fn(&[u8], &mut dyn FnMut(&[Record])) -> (usize, u64), bytes: &[u8]) -> Heard {
    let mut pixels = Vec::new();
    let taken = read(bytes, &mut |records| {
        pixels.extend(records.iter().map(|&[a, b, c, d, color @ ..]| {
            (u16::from_le_bytes([a, b]), u16::from_le_bytes([c, d]), color)
        }));
    });
    (pixels, taken)
}

fn portable(bytes: &[u8]) -> Heard {
    heard(|b, mut f| portable::pixel_lines(b, u64::MAX, &mut f), bytes)
}

#[cfg(all(target_arch = "x86_64", feature = "avx"))]
fn vectors(bytes: &[u8]) -> Option<Heard> {
    let read = |bytes: &[u8], mut each: &mut dyn FnMut(u16, u16, [u8; 4])| {
        Avx2Bytes::run(avx2::PixelLines { bytes, most: u64::MAX, each: &mut each }).expect("AVX2")
    };
    Avx2Bytes::is_available().then(|| heard(read, bytes))
}

#[cfg(not(all(target_arch = "x86_64", feature = "avx")))]
fn vectors(_: &[u8]) -> Option<Heard> {
    None
}

#[cfg(all(target_arch = "x86_64", feature = "avx"))]
fn wide(bytes: &[u8]) -> Option<Heard> {
    let read = |bytes: &[u8], mut emit: &mut dyn FnMut(&[Record])| {
        Avx512Bytes::run(avx512::PixelRecords { bytes, emit: &mut emit }).expect("AVX-512")
    };
    Avx512Bytes::is_available().then(|| heard_records(read, bytes))
}

#[cfg(not(all(target_arch = "x86_64", feature = "avx")))]
fn wide(_: &[u8]) -> Option<Heard> {
    None
}

/// Returns lines of all lengths.
fn plain_lines(count: usize, digits: usize) -> Vec<u8> {
    let line = |i: usize| {
        let [x, y] = [i * 7919 % 10_000, i * 104_729 % 10_000].map(|n| n % [10, 100, 1000, 10_000][i % 4]);
        let color = format!("{:08X}", (i as u32).wrapping_mul(0x9e37_79b9));
        format!("PX {x} {y} {}\n", &color[..digits])
    };
    (0..count).flat_map(|i| line(i).into_bytes()).collect()
}

/// Compares the reader of four lines at a time, with `bytes` amid plain lines, with the plain
/// reader.
fn check_wide(bytes: &[u8]) {
    for (before, digits, has_cr) in
        [(3, 6, false), (9, 6, true), (8, 8, false), (21, 2, true), (21, 2, false)]
    {
        let lines = |count| match has_cr {
            true => String::from_utf8(plain_lines(count, digits)).unwrap().replace('\n', "\r\n").into_bytes(),
            false => plain_lines(count, digits),
        };
        let (head, tail) = (lines(before), lines(90));
        let all = [&head[..], bytes, &tail].concat();
        let (mut plain, (mut used, _)) = plainly(&[&head[..], bytes].concat());
        if used == head.len() + bytes.len() {
            let (pixels, (more, _)) = plainly(&tail);
            plain.extend(pixels);
            used += more;
        }
        let whole = heard_records(|b, mut f| pixel_records(b, &mut f), &all);
        assert_eq!(
            whole,
            (plain.clone(), (used, plain.len() as u64)),
            "{:?}",
            String::from_utf8_lossy(bytes)
        );
        let Some((pixels, (used, lines))) = wide(&all) else { continue };
        assert_eq!(pixels, plain[..lines as usize], "{:?}", String::from_utf8_lossy(bytes));
        assert_eq!(plainly(&all[..used]).1, (used, lines));
    }
}

/// Reads plainly: splits at LF, then at blanks.
fn plainly(bytes: &[u8]) -> Heard {
    let (mut pixels, mut used) = (Vec::new(), 0);
    let pixel = |line: &str| -> Option<(u16, u16, [u8; 4])> {
        let words: Vec<&str> = line.strip_suffix("\r\n").or(line.strip_suffix('\n'))?.split(' ').collect();
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

/// Compares both line readers, alone and with the padded end, with the plain reader.
fn check(bytes: &[u8]) {
    let plain = plainly(bytes);
    assert_eq!(
        heard_records(|b, mut f| pixel_records(b, &mut f), bytes),
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
                    check_wide(line.repeat(3).as_bytes());
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
                if is_likely(byte) {
                    check_wide(&bytes);
                }
            }
        }
    }
}

/// Returns whether a byte is next to those of lines, or one of some others: all would take too
/// long.
fn is_likely(byte: u8) -> bool {
    byte.is_ascii_alphanumeric() || b"\0\t\x0b\r\x1f /:@[`{!\x80\xa0\xb0\xff\n".contains(&byte)
}

#[test]
fn four_at_a_time_all_lines_but_the_last_are_read() {
    let ends = |bytes: Vec<u8>, end: &str| String::from_utf8(bytes).unwrap().replace('\n', end).into_bytes();
    for (digits, end) in [2, 6, 8].into_iter().flat_map(|d| [(d, "\n"), (d, "\r\n")]) {
        let bytes = ends(plain_lines(20_000, digits), end);
        let plain = plainly(&bytes);
        if let Some((pixels, (used, lines))) = wide(&bytes) {
            assert!(bytes.len() - used < 1000, "{used} of {}", bytes.len());
            assert_eq!(pixels, plain.0[..lines as usize]);
        }
        assert_eq!(heard_records(|b, mut f| pixel_records(b, &mut f), &bytes), plain);
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
        check_wide(line.as_bytes());
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
        check_wide(&bytes);
        check(&bytes[..cut.index(bytes.len() + 1)]);
    }
}
