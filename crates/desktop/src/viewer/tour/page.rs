//! The page of a step: the picture, its caption below, title and commands beside it.
//!
//! In: a step, its number, and the memory that its commands were drawn into. Out: a frame of
//! [`SIZE`], in the colours and with the spacing of `docs/look.md`.

use super::script::{PICTURE, Step};
use fbptr_core::draw2d::{Blend, text};
use fbptr_core::memory::{Rgba, VideoMemory};

/// Size of a page in pixels.
pub const SIZE: [u32; 2] = [960, 540];
const MARGIN: i32 = 16;
/// Left edge of the column with the commands.
const COLUMN: i32 = MARGIN + PICTURE[0] as i32 + MARGIN;
/// Letters that fit a line of the column, and of the title in letters of twice the size.
const COLUMN_LETTERS: usize = (SIZE[0] as usize - COLUMN as usize - MARGIN as usize) / 8;
const TITLE_LETTERS: usize = COLUMN_LETTERS / 2;
/// Distance between the tops of two lines.
const LINE: i32 = 12;

const PAPER: Rgba = [22, 29, 44, 255];
const TITLE: Rgba = [255, 176, 0, 255];
const TEXT: Rgba = [232, 232, 240, 255];
const QUIET: Rgba = [128, 140, 165, 255];
const CODE: Rgba = [46, 196, 182, 255];

/// Paints the page of step `number` (from 1) of `count` into a frame of [`SIZE`]. A frame of
/// another size is cleared to the background.
pub fn paint(frame: &mut VideoMemory, step: &Step, [number, count]: [usize; 2], picture: &VideoMemory) {
    frame.clear(PAPER);
    if [frame.width(), frame.height()] != SIZE {
        return;
    }
    enlarge(frame, picture);
    let mut y = MARGIN;
    for line in wrapped(&step.title, TITLE_LETTERS) {
        double_text(frame, [COLUMN, y], &line, TITLE);
        y += 20;
    }
    put(frame, [COLUMN, y + 2], &format!("step {number}/{count}"), QUIET);
    y += 24;
    let last = SIZE[1] as i32 - MARGIN - 8;
    let room = ((last - LINE - y) / LINE) as usize;
    for line in shown_lines(&step.lines, room) {
        let color = if line.starts_with(['#', '(']) { QUIET } else { CODE };
        put(frame, [COLUMN, y], &line, color);
        y += LINE;
    }
    let keys = match number < count {
        true => "Right: next  Left: back  F1: keys",
        false => "R: again  Left: back  F1: keys",
    };
    put(frame, [COLUMN, last], keys, QUIET);
    for (i, line) in (0..).zip(&step.caption) {
        put(frame, [MARGIN, MARGIN + PICTURE[1] as i32 + 10 + i * LINE], line, TEXT);
    }
}

/// Returns the lines of the column, at most `room`: long commands go on in further lines, and the
/// commands that are left out are counted in the last one.
fn shown_lines(lines: &[String], room: usize) -> Vec<String> {
    let commands: Vec<&str> = lines.iter().flat_map(|line| line.lines()).collect();
    let mut shown = Vec::new();
    // Lines up to the end of each command that leaves room for the count.
    let (mut whole, mut fitting) = (0, 0);
    for (i, command) in commands.iter().enumerate() {
        shown.extend(folded(command));
        if shown.len() < room {
            (whole, fitting) = (i + 1, shown.len());
        }
        if shown.len() > room {
            shown.truncate(fitting);
            shown.push(format!("# and {} more lines", commands.len() - whole));
            break;
        }
    }
    shown
}

/// Breaks a command into lines of the column's width, between words where that is possible. All
/// but the first are indented.
fn folded(command: &str) -> Vec<String> {
    let mut lines = vec![String::new()];
    for word in command.split_inclusive(' ') {
        let mut letters: Vec<char> = word.chars().collect();
        let used = |lines: &[String]| lines[lines.len() - 1].chars().count();
        let is_first = |lines: &[String]| lines[lines.len() - 1].trim().is_empty();
        if used(&lines) + word.trim_end().chars().count() > COLUMN_LETTERS && !is_first(&lines) {
            lines.push("  ".to_owned());
        }
        while used(&lines) + letters.len() > COLUMN_LETTERS {
            let rest = letters.split_off((COLUMN_LETTERS - used(&lines)).min(letters.len()));
            lines.last_mut().expect("never empty").extend(letters);
            letters = rest;
            if letters.iter().all(|&c| c == ' ') {
                break;
            }
            lines.push("  ".to_owned());
        }
        lines.last_mut().expect("never empty").extend(letters);
    }
    lines.iter().map(|line| line.trim_end().to_owned()).collect()
}

/// Breaks a text between words into lines of at most `letters` letters; longer words stay whole.
fn wrapped(text: &str, letters: usize) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        match lines.last_mut().filter(|line| line.chars().count() + 1 + word.chars().count() <= letters) {
            Some(line) => *line = format!("{line} {word}"),
            None => lines.push(word.to_owned()),
        }
    }
    lines
}

/// Copies a picture into the picture area, each pixel as a square.
fn enlarge(frame: &mut VideoMemory, picture: &VideoMemory) {
    let factor = (PICTURE[0] / picture.width().max(1)).max(1) as usize;
    let (stride, from) = (frame.width() as usize * 4, picture.width() as usize * 4);
    let margin = MARGIN as usize;
    let (width, height) = (PICTURE[0] as usize, PICTURE[1] as usize);
    for (y, row) in frame.bytes_mut().chunks_exact_mut(stride).skip(margin).take(height).enumerate() {
        let source = &picture.bytes()[(y / factor).min(picture.height() as usize - 1) * from..][..from];
        let target = &mut row[margin * 4..][..width * 4];
        let squares = target.chunks_mut(4 * factor).zip(source.chunks_exact(4));
        for (square, pixel) in squares {
            square.chunks_exact_mut(4).for_each(|p| p.copy_from_slice(pixel));
        }
    }
}

fn put(frame: &mut VideoMemory, at: [i32; 2], line: &str, color: Rgba) {
    text(frame, at, line.as_bytes(), color, Blend::Replace).expect("a str is UTF-8");
}

/// Draws a line in letters of twice the size.
fn double_text(frame: &mut VideoMemory, [x, y]: [i32; 2], line: &str, color: Rgba) {
    let width = line.chars().count() as u32 * 8;
    let Ok(mut small) = VideoMemory::new(width.max(1), 8) else { return };
    put(&mut small, [0, 0], line, color);
    let stride = small.width() as usize * 4;
    for (row, pixels) in small.bytes().chunks_exact(stride).enumerate() {
        for (column, pixel) in pixels.chunks_exact(4).enumerate().filter(|(_, p)| *p == color) {
            let color = [pixel[0], pixel[1], pixel[2], pixel[3]];
            for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
                frame.put_pixel(x + column as i32 * 2 + dx, y + row as i32 * 2 + dy, color);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::script::parse;
    use super::*;

    #[test]
    fn titles_and_long_commands_break_between_words() {
        assert_eq!(wrapped("Which pixels are inside?", 16), ["Which pixels are", "inside?"]);
        assert_eq!(wrapped("", 16), Vec::<String>::new());
        let long = "x".repeat(COLUMN_LETTERS);
        assert_eq!(folded(&long), [long.as_str()]);
        assert_eq!(
            folded(&format!("POKE 1 {long}")),
            ["POKE 1".to_owned(), format!("  {}", &long[2..]), "  xx".to_owned()]
        );
        let words = "MATERIAL 1.00 0.36 0.36 1.00 0.36 0.36 0 0 0 1";
        assert_eq!(folded(words), ["MATERIAL 1.00 0.36 0.36 1.00 0.36", "  0.36 0 0 0 1"]);
        assert_eq!(folded(""), [""]);
        let lines: Vec<String> = (0..9).map(|i| i.to_string()).collect();
        assert_eq!(shown_lines(&lines, 9), lines);
        assert_eq!(shown_lines(&lines, 3), ["0", "1", "# and 7 more lines"]);
        // A command is shown whole or not at all.
        let lines = ["CLEAR".to_owned(), words.to_owned(), "DRAW a".to_owned()];
        assert_eq!(shown_lines(&lines, 3), ["CLEAR", "# and 2 more lines"]);
        assert_eq!(shown_lines(&lines, 4).len(), 4);
    }

    #[test]
    fn a_page_shows_each_pixel_as_a_square_and_nothing_over_it() {
        let step = parse(b"#= T\n#: caption\n#size 40x30\nPX 1 2 red\n").expect("a script").remove(0);
        let mut picture = VideoMemory::new(40, 30).expect("small");
        for (x, y) in [(0, 0), (39, 0), (0, 29), (39, 29), (7, 11)] {
            picture.put_pixel(x, y, [x as u8, y as u8, 99, 255]);
        }
        let mut frame = VideoMemory::new(SIZE[0], SIZE[1]).expect("small");
        paint(&mut frame, &step, [1, 1], &picture);
        for y in 0..PICTURE[1] as i32 {
            for x in 0..PICTURE[0] as i32 {
                let shown = frame.get_pixel(MARGIN + x, MARGIN + y).expect("inside");
                assert_eq!(shown, picture.get_pixel(x / 16, y / 16).expect("inside"), "{x} {y}");
            }
        }
        assert_eq!(frame.get_pixel(MARGIN - 1, MARGIN), Ok(PAPER));
        let text = |range: std::ops::Range<i32>, color| {
            (0..540).any(|y| range.clone().any(|x| frame.get_pixel(x, y) == Ok(color)))
        };
        assert!(text(COLUMN..960, TITLE) && text(COLUMN..960, CODE) && text(0..COLUMN, TEXT));
    }
}
