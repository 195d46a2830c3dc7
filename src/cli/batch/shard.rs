//! Arguments that choose the frames of one process.

use clap::Args;
use std::str::FromStr;

/// Part `index` of `count`: the frames whose number leaves `index` when divided by `count`, so
/// that neighbours, which cost alike, are spread over the parts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    /// Number of the part, from 0.
    pub index: u32,
    /// Number of parts.
    pub count: u32,
}

impl FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let parts = text.split_once('/').and_then(|(i, n)| Some((i.parse().ok()?, n.parse().ok()?)));
        match parts {
            Some((index, count)) if index < count => Ok(Shard { index, count }),
            _ => Err("expected a part and their number, as in 0/4, the part from 0".to_owned()),
        }
    }
}

/// The frames to draw.
#[derive(Clone, Copy, Debug, Default, Args)]
pub struct ShardArgs {
    /// First of the --frames to draw, from 0; what an earlier run has drawn is left as it is [default: 0]
    #[arg(long, value_name = "A", requires = "frames")]
    first: Option<u32>,
    /// Last of the --frames to draw, itself included [default: N-1]
    #[arg(long, value_name = "B", requires = "frames")]
    last: Option<u32>,
    /// Draw part I of N of the --frames, from 0; what an earlier run has drawn is left as it is
    #[arg(long, value_name = "I/N", requires = "frames")]
    shard: Option<Shard>,
}

impl ShardArgs {
    /// Returns whether the frames are one part of a batch.
    pub fn is_given(&self) -> bool {
        self.first.is_some() || self.last.is_some() || self.shard.is_some()
    }

    /// Returns the first and the last frame of the range.
    fn range(&self, count: u32) -> [u32; 2] {
        [self.first.unwrap_or(0), self.last.unwrap_or(count.saturating_sub(1))]
    }

    /// Checks the range for an animation of `count` frames.
    pub fn check(&self, count: u32) -> Result<(), String> {
        let [first, last] = self.range(count);
        if first <= last && last < count {
            return Ok(());
        }
        let end = count.saturating_sub(1);
        Err(format!("expected frames from 0 to {end}, the first before the last, found {first} to {last}"))
    }

    /// Returns the frames to draw of an animation of `count`.
    pub fn frames(&self, count: u32) -> impl Iterator<Item = u32> + use<> {
        let [first, last] = self.range(count);
        let Shard { index, count } = self.shard.unwrap_or(Shard { index: 0, count: 1 });
        (first..=last).filter(move |frame| frame % count == index)
    }

    /// Returns the name of the manifest.
    pub fn manifest_name(&self, count: u32) -> String {
        let [first, last] = self.range(count);
        match self.shard {
            Some(Shard { index, count }) => format!("frames-{index}-of-{count}.jsonl"),
            None => format!("frames-{first}-to-{last}.jsonl"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shards_share_all_frames_and_none_twice() {
        for count in [1, 7, 20] {
            for of in [1, 2, 3, 30] {
                let part =
                    |index| ShardArgs { shard: Some(Shard { index, count: of }), ..ShardArgs::default() };
                let mut all: Vec<u32> = (0..of).flat_map(|i| part(i).frames(count)).collect();
                all.sort_unstable();
                assert_eq!(all, (0..count).collect::<Vec<_>>());
            }
        }
        let part = ShardArgs { first: Some(3), last: Some(8), shard: Some(Shard { index: 1, count: 2 }) };
        assert_eq!(part.frames(20).collect::<Vec<_>>(), [3, 5, 7]);
        assert_eq!(part.manifest_name(20), "frames-1-of-2.jsonl");
    }

    #[test]
    fn ranges_are_inclusive_and_within_the_animation() {
        let range = |first, last| ShardArgs { first, last, shard: None };
        assert_eq!(range(Some(2), Some(4)).frames(5).collect::<Vec<_>>(), [2, 3, 4]);
        assert_eq!(range(Some(2), None).manifest_name(5), "frames-2-to-4.jsonl");
        assert_eq!(range(None, Some(4)).check(5), Ok(()));
        for (first, last) in [(0, 5), (5, 5), (3, 2)] {
            assert!(range(Some(first), Some(last)).check(5).is_err(), "{first} to {last}");
        }
        for text in ["", "1", "1/1", "2/1", "0/0", "-1/2", "a/b", "0/4/2"] {
            assert!(text.parse::<Shard>().is_err(), "{text}");
        }
    }
}
