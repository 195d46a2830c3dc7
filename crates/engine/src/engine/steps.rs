//! The pixels of one command in the order in which its algorithm reaches them, with the numbers that
//! decide each.
//!
//! In: a command, and the frame before and after it. Out: its pixels (of a line from its first end, of
//! everything else row by row), each with its colour, and a line of text when it is asked for. Right is:
//! the pixels drawn one after the other make the frame that the command has made.

use super::figure_numbers;
use fbptr_command::{Command, Figure};
use fbptr_core::draw2d::{self, Blend, RampColor};
use fbptr_core::memory::{Rgba, VideoMemory};

/// Longest text of a pixel in characters.
const MAX_TEXT: usize = 150;

/// One pixel of the walk.
#[derive(Clone, Copy, Debug)]
pub struct Step {
    /// Offset of the pixel in the frame, in bytes.
    pub offset: usize,
    /// Its bytes after the command.
    pub color: Rgba,
}

impl Step {
    /// Returns place and numbers of the pixel in a frame of `size`, as one line; without a command the
    /// place alone.
    pub fn text(&self, command: Option<&Command>, size: [u32; 2]) -> String {
        let at = place_of(self.offset / 4, size[0]);
        let numbers = command.and_then(|command| figure_numbers(command, size, at));
        format!("({}, {})  {}", at[0], at[1], numbers.as_deref().map(brief).unwrap_or_default())
    }
}

/// Returns column and row of a pixel.
fn place_of(pixel: usize, width: u32) -> [i32; 2] {
    let width = width.max(1) as usize;
    [(pixel % width) as i32, (pixel / width) as i32]
}

/// Returns the pixels that a command changed from `before` to `after`, and of lines and circles those
/// too that had the colour already.
pub fn figure_steps(command: Option<&Command>, before: &VideoMemory, after: &VideoMemory) -> Vec<Step> {
    let walked = command.and_then(|command| walked(command, after));
    let pixels = before.bytes().chunks_exact(4).zip(after.bytes().chunks_exact(4)).enumerate();
    let mut found: Vec<([i32; 2], Step)> = Vec::new();
    for (i, (old, new)) in pixels {
        let is_walked = walked.as_ref().is_some_and(|walked| walked.bytes()[4 * i + 3] != 0);
        if old != new || is_walked {
            let color = [new[0], new[1], new[2], new[3]];
            found.push((place_of(i, after.width()), Step { offset: 4 * i, color }));
        }
    }
    if let Some(Command::Figure(Figure::Line { p0, p1, .. })) = command {
        // Along the longer axis, from the first end.
        let axis = usize::from(p0[0].abs_diff(p1[0]) < p0[1].abs_diff(p1[1]));
        found.sort_by_key(|(at, _)| at[axis].abs_diff(p0[axis]));
    }
    found.into_iter().map(|(_, step)| step).collect()
}

/// Returns a frame of the size of `like` in which the pixels of a line or a circle are opaque, the
/// others transparent; `None` for other commands.
fn walked(command: &Command, like: &VideoMemory) -> Option<VideoMemory> {
    let Command::Figure(figure @ (Figure::Line { .. } | Figure::Circle { .. })) = command else {
        return None;
    };
    let mut frame = VideoMemory::new(like.width(), like.height()).ok()?;
    frame.bytes_mut().fill(0);
    let opaque = [255; 4];
    match figure {
        Figure::Line { p0, p1, .. } => {
            let color = RampColor { from: opaque, to: None };
            draw2d::line(&mut frame, *p0, *p1, color, Blend::Replace);
        }
        Figure::Circle { cx, cy, r, .. } => {
            draw2d::circle(&mut frame, [*cx, *cy], *r, opaque, Blend::Replace).ok()?;
        }
        _ => return None,
    }
    Some(frame)
}

/// Returns the part of a figure's numbers that belongs to the pixel alone, in one line: of a walk the
/// last row of its table.
fn brief(numbers: &str) -> String {
    let lines: Vec<&str> = numbers.lines().collect();
    let row = lines.iter().position(|line| line.starts_with("distance")).and_then(|i| i.checked_sub(1));
    let head = lines.iter().find(|line| line.trim_end().ends_with(" d") && line.starts_with("  "));
    let words = |line: &str| line.split_whitespace().collect::<Vec<_>>().join(" ");
    let mut text = match (head, row) {
        (Some(head), Some(row)) => {
            let cells = head.split_whitespace().zip(lines[row].split_whitespace());
            // The place is said already.
            let rest = cells.filter(|(name, _)| !matches!(*name, "x" | "y"));
            rest.map(|(name, value)| format!("{name} {value}")).collect::<Vec<_>>().join(", ")
        }
        // The same for every pixel of the figure.
        _ => {
            let is_common = |line: &&&str| line.starts_with("corner") || line.starts_with("area");
            let own = lines.iter().skip(1).filter(|line| !is_common(line));
            own.map(|line| words(line)).collect::<Vec<_>>().join("; ")
        }
    };
    if let Some((end, _)) = text.char_indices().nth(MAX_TEXT) {
        text.truncate(end);
        text.push_str(" ...");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(line: &str, before: &VideoMemory, after: &VideoMemory) -> (Vec<Step>, Vec<String>) {
        let command = Command::parse(line.as_bytes(), None).ok();
        let steps = figure_steps(command.as_ref(), before, after);
        let size = [after.width(), after.height()];
        let texts = steps.iter().map(|step| step.text(command.as_ref(), size)).collect();
        (steps, texts)
    }

    #[test]
    fn a_line_is_walked_from_its_first_end_with_its_decision_variable() {
        let before = VideoMemory::new(16, 12).unwrap();
        let mut after = before.clone();
        let color = RampColor { from: [255, 0, 0, 255], to: None };
        draw2d::line(&mut after, [12, 8], [2, 5], color, Blend::Replace);
        let (steps, texts) = of("LINE 12 8 2 5 red", &before, &after);
        assert_eq!(texts.len(), 11);
        // d = 2m - n = -4 at first; 2m = 6, 2m - 2n = -14.
        assert_eq!(texts[..3], ["(12, 8)  step 0, d -4", "(11, 8)  step 1, d 2", "(10, 7)  step 2, d -12"]);
        let mut drawn = before.clone();
        for step in &steps {
            drawn.bytes_mut()[step.offset..step.offset + 4].copy_from_slice(&step.color);
        }
        assert!(drawn.bytes() == after.bytes());
        // Drawn again, where nothing changes: the same walk.
        assert_eq!(of("LINE 12 8 2 5 red", &after, &after).1, texts);
    }

    #[test]
    fn other_commands_have_the_pixels_that_they_changed() {
        let before = VideoMemory::new(8, 8).unwrap();
        let mut after = before.clone();
        let corners = [[0.0, 0.0], [4.0, 0.0], [0.0, 4.0]];
        draw2d::fill(&mut after, corners, draw2d::AreaColors::One([9, 8, 7, 255]), Blend::Replace);
        let (filled, texts) = of("FILL 0 0 4 0 0 4 090807", &before, &after);
        let lit = before.bytes().chunks_exact(4).zip(after.bytes().chunks_exact(4)).filter(|(a, b)| a != b);
        assert_eq!(filled.len(), lit.count());
        assert!(texts.iter().all(|text| text.chars().count() <= MAX_TEXT + 20), "{texts:?}");
        assert!(texts[0].contains("edge"), "{texts:?}");
        assert!(of("TRANSLATE 1 0 0", &before, &before).0.is_empty());
    }
}
