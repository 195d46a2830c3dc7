//! What a server allows: every quota with its default. Those of a connection's matrices and lights have no flag on the command line.

use crate::error::{Code, Fault};
use std::time::Duration;

/// The quotas. Bytes unless the name says otherwise.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Connections at one time; one more is told `EQUOTA` and closed.
    pub connections: usize,
    /// Connections at one time from one IPv4 address or one /64 network of IPv6 addresses.
    pub connections_per_address: usize,
    /// The time after which a socket's connection that sends nothing and is owed nothing is closed; `None` is never.
    pub idle_timeout: Option<Duration>,
    /// A payload (`:N`, and the run of `PXMULTI`).
    pub payload_bytes: u64,
    /// Named resources of one connection, and of all shared names together.
    pub names: usize,
    /// Bytes of the resources of one connection, and of all shared names together.
    pub resource_bytes: u64,
    /// Bytes of a frame.
    pub frame_bytes: u64,
    /// Bytes of everything that commands make the server hold, of all connections together; the command line bounds it by the
    /// machine's memory.
    pub memory_bytes: u64,
    /// Replies that a client has not read yet: beyond it its commands wait, and a single longer reply is refused.
    pub reply_bytes: usize,
    /// Bytes of the files that SNAP has written into the snapshot folder, in whole blocks of 4096 bytes.
    pub snap_bytes: u64,
    /// Matrices on one connection's stack.
    pub matrix_stack: usize,
    /// Lights of one connection: indices are below it.
    pub lights: usize,
    /// Time that one command may take, drawing faces excepted; beyond it, it is given up.
    pub command_time: Duration,
}

impl Default for Limits {
    fn default() -> Self {
        Limits {
            connections: 1024,
            connections_per_address: usize::MAX,
            idle_timeout: None,
            payload_bytes: 64 << 20,
            names: 4096,
            resource_bytes: 1 << 30,
            frame_bytes: 1 << 30,
            memory_bytes: u64::MAX,
            reply_bytes: 64 << 20,
            snap_bytes: 1 << 30,
            matrix_stack: 1024,
            lights: 256,
            command_time: Duration::from_secs(10),
        }
    }
}

impl Limits {
    /// These limits, with room in the replies for all pixels of such a frame.
    pub fn for_frame(self, width: u32, height: u32) -> Self {
        let whole = (width as usize * height as usize * 4).saturating_add(4096);
        Limits { reply_bytes: self.reply_bytes.max(whole), ..self }
    }

    /// Refuses a frame of `width` x `height` pixels that is over the limit.
    pub fn check_frame(&self, width: u32, height: u32) -> Result<(), Fault> {
        let bytes = width as u64 * height as u64 * 4;
        match bytes <= self.frame_bytes {
            true => Ok(()),
            false => Err(Fault::new(
                Code::TooBig,
                format!(
                    "a frame of {width}x{height} takes {bytes} bytes, and the limit is {}",
                    self.frame_bytes
                ),
            )),
        }
    }
}
