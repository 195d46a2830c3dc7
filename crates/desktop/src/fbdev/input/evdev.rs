//! Events as `linux/input.h` has them on 64 bits: time, type, code and value.

use rustix::time::{ClockId, clock_gettime};

/// Types of events.
pub const KEY: u16 = 1;
/// Relative movement.
pub const REL: u16 = 2;
/// Absolute place.
pub const ABS: u16 = 3;
/// Ends a batch.
const SYN: u16 = 0;

/// Bytes of an event.
const EVENT_BYTES: usize = 24;

/// Events of one moment.
#[derive(Debug, Default)]
pub struct Batch {
    events: Vec<(u16, u16, i32)>,
}

impl Batch {
    pub fn new() -> Self {
        Batch::default()
    }

    pub fn add(&mut self, kind: u16, code: u16, value: i32) {
        self.events.push((kind, code, value));
    }

    pub fn add_unless_zero(&mut self, kind: u16, code: u16, value: i32) {
        if value != 0 {
            self.add(kind, code, value);
        }
    }

    pub fn is_empty(&self) -> bool {
        self.events.is_empty()
    }

    /// Returns the events as bytes, with the time of a clock (0 real time, 1 monotonic, 7 since the
    /// start of the machine) and the end of the batch.
    pub fn bytes(&self, clock: u8) -> Vec<u8> {
        let now = clock_gettime(match clock {
            1 => ClockId::Monotonic,
            7 => ClockId::Boottime,
            _ => ClockId::Realtime,
        });
        let mut bytes = Vec::with_capacity((self.events.len() + 1) * EVENT_BYTES);
        for (kind, code, value) in self.events.iter().copied().chain([(SYN, 0, 0)]) {
            bytes.extend_from_slice(&now.tv_sec.to_ne_bytes());
            bytes.extend_from_slice(&(now.tv_nsec as i64 / 1000).to_ne_bytes());
            bytes.extend_from_slice(&kind.to_ne_bytes());
            bytes.extend_from_slice(&code.to_ne_bytes());
            bytes.extend_from_slice(&value.to_ne_bytes());
        }
        bytes
    }
}
