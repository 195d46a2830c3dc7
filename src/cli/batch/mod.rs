//! `fbptr batch`: frames that several processes drew: verified, merged, joined to a movie.
//!
//! `render --shard` and `render --first --last` write them, each a file and a line of a manifest.

mod check;
mod manifest;
mod movie;
mod record;
mod shard;
mod writer;

pub use shard::ShardArgs;
pub use writer::{BatchPlan, BatchWriter, written_file};

use super::Status;
use clap::{Args, Subcommand};

/// Verify frames that were drawn in parts, and join them.
#[derive(Debug, Args)]
pub struct Batch {
    #[command(subcommand)]
    task: BatchTask,
}

#[derive(Debug, Subcommand)]
enum BatchTask {
    /// Verify every frame's CRC, and print which are missing or differ; then the exit status is 1
    Check(check::Check),
    /// Join the frames to a movie: the same file as that of one `fbptr render`
    Movie(movie::JoinMovie),
}

impl Batch {
    /// Runs the task, and returns the exit status.
    pub(super) fn run(self) -> Status {
        let done = match &self.task {
            BatchTask::Check(check) => check.run(),
            BatchTask::Movie(movie) => movie.run(),
        };
        done.unwrap_or_else(super::scene_file::SceneError::say)
    }
}

/// Returns numbers in ascending order as ranges: `0-3, 7, 9-10`.
pub fn ranges(numbers: &[u32]) -> String {
    let mut parts: Vec<[u32; 2]> = Vec::new();
    for &n in numbers {
        match parts.last_mut() {
            Some([_, last]) if last.checked_add(1) == Some(n) => *last = n,
            _ => parts.push([n, n]),
        }
    }
    ranges_text(&parts)
}

/// Returns ranges, first and last, as text.
fn ranges_text(ranges: &[[u32; 2]]) -> String {
    let text = |&[a, b]: &[u32; 2]| if a == b { a.to_string() } else { format!("{a}-{b}") };
    ranges.iter().map(text).collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    #[test]
    fn numbers_are_printed_as_ranges() {
        assert_eq!(super::ranges(&[0, 1, 2, 3, 7, 9, 10]), "0-3, 7, 9-10");
        assert_eq!(super::ranges(&[]), "");
        assert_eq!(super::ranges(&[u32::MAX]), "4294967295");
    }
}
