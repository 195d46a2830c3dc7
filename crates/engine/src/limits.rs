//! Quotas of a server, and their defaults. Those of a connection's matrices and lights have no
//! option on the command line.

use fbptr_core::error::{Code, Fault};
use std::time::Duration;

/// Quotas of a server, in bytes unless the name says otherwise.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Connections at one time; a further one gets an `EQUOTA` error and is closed.
    pub connections: usize,
    /// Connections at one time from one IPv4 address or one /64 network of IPv6 addresses.
    pub connections_per_address: usize,
    /// Time after which a socket's connection is closed if it sends nothing and waits for nothing;
    /// `None` for no limit.
    pub idle_timeout: Option<Duration>,
    /// Bytes of a payload (`:N`, and the run of `PXMULTI`).
    pub payload_bytes: u64,
    /// Named resources of one connection, and of all shared names together.
    pub names: usize,
    /// Bytes of the resources of one connection, and of all shared names together.
    pub resource_bytes: u64,
    /// Bytes of a frame.
    pub frame_bytes: u64,
    /// Bytes of everything that commands make the server hold, for all connections together. The
    /// command line sets it from the machine's memory.
    pub memory_bytes: u64,
    /// Bytes of a reply: a longer one is refused. A client that has not read as many bytes of replies,
    /// or 256 KiB, is served nothing more.
    pub reply_bytes: usize,
    /// Bytes of the files that SNAP has written into the snapshot folder, in blocks of 4096 bytes.
    pub snap_bytes: u64,
    /// Matrices on the stack of one connection.
    pub matrix_stack: usize,
    /// Lights of one connection; their indices are below this number.
    pub lights: usize,
    /// Time limit of one command, except for drawing faces; a command that exceeds it is ended.
    pub command_time: Duration,
}

impl Default for Limits {
    fn default() -> Self {
        Limits {
            connections: 1024,
            connections_per_address: 768,
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
    /// Returns these limits, with room in the replies for all pixels of a frame of this size.
    pub fn for_frame(self, width: u32, height: u32) -> Self {
        let whole = (width as usize * height as usize * 4).saturating_add(4096);
        Limits { reply_bytes: self.reply_bytes.max(whole), ..self }
    }

    /// Refuses a frame of `width` x `height` pixels that exceeds the limit.
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
