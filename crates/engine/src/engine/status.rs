//! The state of an engine in numbers, for `STATS` and for the metrics.
//!
//! In: the engine's counters and sizes, and what its observers add. Out: plain values.

use super::Engine;
use crate::Stats;

/// State of an output of the server.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum OutputState {
    /// There is none.
    #[default]
    Off,
    /// Everything has been written so far.
    On,
    /// It has ended early.
    Failed,
}

impl OutputState {
    /// All states and their names in the metrics.
    pub const ALL: [(OutputState, &'static str); 3] =
        [(OutputState::Off, "off"), (OutputState::On, "on"), (OutputState::Failed, "failed")];

    /// Returns the word of `STATS`.
    pub(super) fn word(self) -> &'static str {
        match self {
            OutputState::Off => "off",
            OutputState::On => "ok",
            OutputState::Failed => "failed",
        }
    }
}

/// State of one output, which its observer reports, or whoever offers it while there is none.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct OutputStatus {
    /// Its name, the key of its state in `STATS`.
    pub name: &'static str,
    /// Its state.
    pub state: OutputState,
    /// Further values, with their keys in `STATS`.
    pub figures: Vec<(&'static str, u64)>,
}

impl OutputStatus {
    /// Returns the value of a key, 0 if there is none.
    pub fn figure(&self, key: &str) -> u64 {
        self.figures.iter().find(|(name, _)| *name == key).map_or(0, |(_, value)| *value)
    }

    /// Returns the `key=value` words of `STATS`.
    pub(super) fn words(&self) -> String {
        let figures = self.figures.iter().map(|(key, value)| format!(" {key}={value}"));
        format!("{}={}", self.name, self.state.word()) + &figures.collect::<String>()
    }
}

/// State of an engine and of its observers.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Status {
    /// Counters of all connections, up to the last slice of each.
    pub totals: Stats,
    /// Number of open connections.
    pub connections: usize,
    /// Number of connections closed for being idle.
    pub idle_closes: u64,
    /// Number of connections refused because they spoke HTTP or TLS.
    pub foreign_refused: u64,
    /// Bytes of the frame.
    pub frame_bytes: u64,
    /// Bytes of the depth buffer.
    pub depth_bytes: u64,
    /// Bytes of the pick buffer.
    pub id_bytes: u64,
    /// Limit of the memory budget, in bytes.
    pub memory_limit_bytes: u64,
    /// Bytes in use of the memory budget.
    pub memory_used_bytes: u64,
    /// Bytes of the shared resources.
    pub shared_resource_bytes: u64,
    /// Bytes of the files that `SNAP` wrote.
    pub snap_bytes: u64,
    /// Outputs that are offered, in that order, then others that observers report.
    pub outputs: Vec<OutputStatus>,
}

impl Status {
    /// Returns the state of the output of this name. One that nobody reports is off.
    pub fn output(&self, name: &'static str) -> OutputStatus {
        let found = self.outputs.iter().find(|output| output.name == name);
        found.cloned().unwrap_or_else(|| OutputStatus { name, ..OutputStatus::default() })
    }

    /// Puts the state of an output in the place of that of its name.
    fn set_output(&mut self, output: OutputStatus) {
        match self.outputs.iter_mut().find(|earlier| earlier.name == output.name) {
            Some(earlier) => *earlier = output,
            None => self.outputs.push(output),
        }
    }
}

impl Engine {
    /// Returns the state of the engine and of its observers.
    pub fn status(&self) -> Status {
        let [depth_bytes, id_bytes] = self.framebuffer.depth_and_id_bytes();
        let mut status = Status {
            totals: self.counters.totals,
            connections: self.counters.connections,
            idle_closes: self.counters.idle_closes,
            foreign_refused: self.counters.foreign_refused,
            frame_bytes: self.framebuffer.memory.bytes().len() as u64,
            depth_bytes,
            id_bytes,
            memory_limit_bytes: self.quotas.budget.limit(),
            memory_used_bytes: self.quotas.budget.used(),
            shared_resource_bytes: self.resources.shared.size_bytes(),
            snap_bytes: self.resources.snap_dir.as_ref().map_or(0, |folder| folder.used_bytes()),
            outputs: self.offered_outputs.clone(),
        };
        let frame = self.frame_view();
        let reported = self.observers.iter().filter_map(|observer| observer.output(frame));
        reported.for_each(|output| status.set_output(output));
        status
    }

    /// Adds an output to the state that observers may report later. Until then this is its state.
    pub fn offer_output(&mut self, output: OutputStatus) {
        self.offered_outputs.push(output);
    }
}

#[cfg(test)]
mod tests;
