//! Counters of `STATS`, for one connection or for all.

use std::ops::{AddAssign, Sub};

/// Counters that only increase.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Stats {
    /// Decoded stream bytes.
    pub bytes: u64,
    /// Commands that were run or refused.
    pub commands: u64,
    /// Pixels stored by pixel, block and `CLEAR` commands; figures are counted as commands.
    pub pixels: u64,
    /// Refused commands.
    pub errors: u64,
    /// Pixels of `PX`, `PB`, `PXMULTI`, `POINTS` and `BLIT` that were off the frame.
    pub clipped: u64,
    /// `PRESENT` commands.
    pub frames: u64,
    /// Draws that showed nothing: no pixel, or only black ones because there was no light.
    pub empty_draws: u64,
}

impl AddAssign for Stats {
    fn add_assign(&mut self, o: Self) {
        self.bytes += o.bytes;
        self.commands += o.commands;
        self.pixels += o.pixels;
        self.errors += o.errors;
        self.clipped += o.clipped;
        self.frames += o.frames;
        self.empty_draws += o.empty_draws;
    }
}

impl Sub for Stats {
    type Output = Stats;

    fn sub(self, o: Self) -> Stats {
        Stats {
            bytes: self.bytes - o.bytes,
            commands: self.commands - o.commands,
            pixels: self.pixels - o.pixels,
            errors: self.errors - o.errors,
            clipped: self.clipped - o.clipped,
            frames: self.frames - o.frames,
            empty_draws: self.empty_draws - o.empty_draws,
        }
    }
}

impl Stats {
    /// Formats the counters as `key=value` words, with `prefix` before each key.
    pub fn words(&self, prefix: &str) -> String {
        format!(
            "{prefix}bytes={} {prefix}commands={} {prefix}pixels={} {prefix}errors={} {prefix}clipped={} {prefix}frames={} {prefix}empty_draws={}",
            self.bytes, self.commands, self.pixels, self.errors, self.clipped, self.frames, self.empty_draws
        )
    }
}
