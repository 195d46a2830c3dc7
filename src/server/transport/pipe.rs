//! Pipes and files: read by a thread each, because the system does not say when they can be read.
//!
//! In: anything that can be read, and the connection that it belongs to. Out: the same batches in
//! the same buffers as those of sockets, within the same limits. Promises: no pooled buffer is held
//! while
//! the thread waits for bytes.

use super::buffer_pool::POOLED_BUFFER_BYTES;
use super::poll::{FEW_BYTES, Return};
use crate::server::thread::message::{Batch, Message};
use std::io::{self, ErrorKind, Read};

/// Reads to the end, as fast as the render thread takes it.
pub(super) fn read_all(mut input: Box<dyn Read + Send>, back: &Return) {
    let Return { registered, shared } = back;
    let mut own = vec![0; POOLED_BUFFER_BYTES];
    loop {
        registered.wait_for_room();
        let filled = match read_some(&mut *input, &mut own) {
            Ok(filled @ 1..) => filled,
            // One that died says no more than one that was closed: what came before still counts.
            Ok(0) | Err(_) => {
                shared.at_end(registered).into_iter().for_each(|message| registered.send(message));
                return;
            }
        };
        if !shared.note_batch(registered, filled) {
            continue;
        }
        let batch = if filled <= FEW_BYTES {
            Batch { buffer: own[..filled].to_vec(), pooled: None, filled }
        } else {
            let mut pooled = shared.buffers.acquire();
            std::mem::swap(&mut pooled.buffer, &mut own);
            Batch { buffer: Vec::new(), pooled: Some(pooled), filled }
        };
        registered.send(Message::Bytes(registered.id, batch));
    }
}

fn read_some(input: &mut dyn Read, buffer: &mut [u8]) -> io::Result<usize> {
    loop {
        match input.read(buffer) {
            Err(e) if e.kind() == ErrorKind::Interrupted => {}
            result => return result,
        }
    }
}
