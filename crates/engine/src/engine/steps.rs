//! The pixels of one command in the order in which its algorithm reaches them, with the numbers that
//! decide each.
//!
//! In: a command, and the frame before and after it. Out: its pixels (of a line from its first end, of
//! everything else row by row), each with its colour and a line of text. Right is: the pixels drawn one
//! after the other make the frame that the command has made.

use super::figure_numbers;
use fbptr_command::{Command, Figure};
use fbptr_core::memory::{Rgba, VideoMemory};

/// Longest text of a pixel in characters.
const MAX_TEXT: usize = 150;

/// One pixel of the walk.
#[derive(Debug)]
pub struct Step {
    /// Offset of the pixel in the frame, in bytes.
    pub offset: usize,
    /// Its bytes after the command.
    pub color: Rgba,
    /// Place and numbers.
    pub text: String,
}

/// Returns the pixels that a command changed from `before` to `after`, and of lines and circles those
/// too that had the colour already; without a command, the pixels without their numbers.
pub fn figure_steps(command: Option<&Command>, before: &VideoMemory, after: &VideoMemory) -> Vec<Step> {
    let (width, size) = (after.width() as usize, [after.width(), after.height()]);
    let pixels = before.bytes().chunks_exact(4).zip(after.bytes().chunks_exact(4)).enumerate();
    let is_walk = matches!(command, Some(Command::Figure(Figure::Line { .. } | Figure::Circle { .. })));
    let mut found: Vec<([i32; 2], Step)> = Vec::new();
    for (i, (old, new)) in pixels {
        let at = [(i % width) as i32, (i / width) as i32];
        if old == new && !is_walk {
            continue;
        }
        let numbers = command.and_then(|command| figure_numbers(command, size, at));
        if old == new && numbers.is_none() {
            continue;
        }
        let text = format!("({}, {})  {}", at[0], at[1], numbers.as_deref().map(brief).unwrap_or_default());
        let color = [new[0], new[1], new[2], new[3]];
        found.push((at, Step { offset: 4 * i, color, text }));
    }
    if let Some(Command::Figure(Figure::Line { p0, p1, .. })) = command {
        // Along the longer axis, from the first end.
        let axis = usize::from(p0[0].abs_diff(p1[0]) < p0[1].abs_diff(p1[1]));
        found.sort_by_key(|(at, _)| at[axis].abs_diff(p0[axis]));
    }
    found.into_iter().map(|(_, step)| step).collect()
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
    use fbptr_core::draw2d::{self, Blend, RampColor};

    fn of(line: &str, before: &VideoMemory, after: &VideoMemory) -> Vec<Step> {
        figure_steps(Command::parse(line.as_bytes(), None).ok().as_ref(), before, after)
    }

    #[test]
    fn a_line_is_walked_from_its_first_end_with_its_decision_variable() {
        let before = VideoMemory::new(16, 12).unwrap();
        let mut after = before.clone();
        let color = RampColor { from: [255, 0, 0, 255], to: None };
        draw2d::line(&mut after, [12, 8], [2, 5], color, Blend::Replace);
        let steps = of("LINE 12 8 2 5 red", &before, &after);
        let texts: Vec<&str> = steps.iter().map(|step| step.text.as_str()).collect();
        assert_eq!(texts.len(), 11);
        // d = 2m - n = -4 at first; 2m = 6, 2m - 2n = -14.
        assert_eq!(texts[..3], ["(12, 8)  step 0, d -4", "(11, 8)  step 1, d 2", "(10, 7)  step 2, d -12"]);
        let mut drawn = before.clone();
        for step in &steps {
            drawn.bytes_mut()[step.offset..step.offset + 4].copy_from_slice(&step.color);
        }
        assert!(drawn.bytes() == after.bytes());
    }

    #[test]
    fn other_commands_have_the_pixels_that_they_changed() {
        let before = VideoMemory::new(8, 8).unwrap();
        let mut after = before.clone();
        let corners = [[0.0, 0.0], [4.0, 0.0], [0.0, 4.0]];
        draw2d::fill(&mut after, corners, draw2d::AreaColors::One([9, 8, 7, 255]), Blend::Replace);
        let filled = of("FILL 0 0 4 0 0 4 090807", &before, &after);
        let lit = before.bytes().chunks_exact(4).zip(after.bytes().chunks_exact(4)).filter(|(a, b)| a != b);
        assert_eq!(filled.len(), lit.count());
        assert!(filled.iter().all(|step| step.text.chars().count() <= MAX_TEXT + 20), "{filled:?}");
        assert!(filled[0].text.contains("edge"), "{filled:?}");
        assert!(of("TRANSLATE 1 0 0", &before, &before).is_empty());
    }
}
