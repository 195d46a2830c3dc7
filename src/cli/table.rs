//! `--table`: a small picture or its depths as a table of text on stdout.
//!
//! Columns are x, rows are y, both counted from the upper left pixel. A colour is rrggbb, with two
//! more digits if a pixel of the picture is not opaque; a depth has six decimals, 1 is the farthest.

use super::output;
use crate::memory::{DepthMemory, VideoMemory};
use clap::ValueEnum;
use std::fmt::Write as _;

/// Number of columns and rows at most.
const MOST: u32 = 64;

/// What the table has.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum Table {
    /// Colours in hex.
    Color,
    /// Depths.
    Depth,
}

impl Table {
    /// Checks that a picture is small enough.
    ///
    /// # Errors
    /// A message if it is not.
    pub(super) fn check(self, width: u32, height: u32) -> Result<(), String> {
        match width <= MOST && height <= MOST {
            true => Ok(()),
            false => {
                Err(format!("--table is for pictures up to {MOST}x{MOST}, this one has {width}x{height}"))
            }
        }
    }

    /// Prints the table. Without a depth memory nothing with a depth was drawn: 1 everywhere.
    pub(super) fn print(self, memory: &VideoMemory, depth: Option<&DepthMemory>) {
        output::print(self.text(memory, depth));
    }

    fn text(self, memory: &VideoMemory, depth: Option<&DepthMemory>) -> String {
        let is_opaque = memory.bytes().iter().skip(3).step_by(4).all(|a| *a == 255);
        let cell = |x: u32, y: u32| match self {
            Table::Color => {
                let [r, g, b, a] = memory.get_pixel(x as i32, y as i32).unwrap_or_default();
                let alpha = if is_opaque { String::new() } else { format!("{a:02x}") };
                format!("{r:02x}{g:02x}{b:02x}{alpha}")
            }
            Table::Depth => format!("{:.6}", depth.and_then(|d| d.z(x as i32, y as i32)).unwrap_or(1.0)),
        };
        let width = cell(0, 0).len();
        let mut out = String::from("   ");
        (0..memory.width()).for_each(|x| {
            let _ = write!(out, " {x:>width$}");
        });
        out.push('\n');
        for y in 0..memory.height() {
            let row: Vec<String> = (0..memory.width()).map(|x| cell(x, y)).collect();
            let _ = writeln!(out, "{y:>3} {}", row.join(" "));
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_and_depths_by_columns_and_rows() {
        let mut memory = VideoMemory::new(2, 2).unwrap();
        memory.clear([0, 0, 0, 255]);
        memory.put_pixel(1, 0, [255, 128, 0, 255]);
        let text = "         0      1\n  0 000000 ff8000\n  1 000000 000000\n";
        assert_eq!(Table::Color.text(&memory, None), text);
        memory.put_pixel(0, 1, [1, 2, 3, 4]);
        assert!(Table::Color.text(&memory, None).ends_with("  1 01020304 000000ff\n"));
        assert!(Table::Depth.text(&memory, None).ends_with("  1 1.000000 1.000000\n"));
        assert!(Table::Color.check(64, 64).is_ok() && Table::Color.check(65, 1).is_err());
    }
}
