//! The arguments of a program that draws by itself: `--headless --frames N --snap FILE`, as every
//! demo takes them.
//!
//! In: the process's arguments. Out: what of them concerns the window; other words are the
//! program's own and are left alone.

use std::ffi::OsString;
use std::path::PathBuf;

/// The settings of a program's window that its arguments ask for.
#[derive(Debug, Default, PartialEq)]
pub(super) struct ProgramArguments {
    /// Set to open no window.
    pub headless: bool,
    /// Number of frames after which the program ends.
    pub frames: Option<u64>,
    /// File in which the last frame is saved.
    pub snap: Option<PathBuf>,
}

impl ProgramArguments {
    /// Reads the arguments, without the program's name.
    ///
    /// # Errors
    /// Returns a message if a value is missing or malformed.
    pub fn of(words: impl Iterator<Item = OsString>) -> Result<Self, String> {
        let mut found = ProgramArguments::default();
        let mut words = words;
        while let Some(word) = words.next() {
            match word.to_str() {
                Some("--headless") => found.headless = true,
                Some("--frames") => {
                    let count = words.next().and_then(|w| w.to_str()?.parse().ok()).filter(|&n| n > 0);
                    found.frames = Some(count.ok_or("--frames: expected a number from 1")?);
                }
                Some("--snap") => {
                    found.snap = Some(words.next().ok_or("--snap: expected a file name")?.into());
                }
                _ => {}
            }
        }
        Ok(found)
    }

    /// Returns whether the frame with this number, from 0, is the last one.
    pub fn ends_with(&self, frame: u64) -> bool {
        let frames = self.frames.or(self.headless.then_some(1));
        frames.is_some_and(|frames| frame + 1 >= frames)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(line: &str) -> Result<ProgramArguments, String> {
        ProgramArguments::of(line.split_whitespace().map(OsString::from))
    }

    #[test]
    fn the_three_flags_are_read_and_other_words_left_alone() {
        let found = read("level.txt --headless --frames 7 --fast --snap last.png").expect("valid");
        assert_eq!((found.headless, found.frames, found.snap), (true, Some(7), Some("last.png".into())));
        assert_eq!(read("--help x"), Ok(ProgramArguments::default()));
        for bad in ["--frames", "--frames x", "--frames 0", "--snap"] {
            assert!(read(bad).is_err(), "{bad}");
        }
        let last = |line: &str, frame| read(line).expect("valid").ends_with(frame);
        assert!(!last("", u64::MAX - 1) && last("--headless", 0));
        assert!(!last("--frames 3", 1) && last("--frames 3", 2));
    }
}
