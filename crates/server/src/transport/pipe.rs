//! Reader of pipes and files: a thread each, because the system does not report when they are
//! readable.
//!
//! In: any byte source, and the connection that it belongs to. Out: batches of bytes in pooled
//! buffers, within the same limits as those of sockets; the rest of a large payload in the buffer that
//! it is run from, which the render thread lends: a copy less. Promises: no pooled buffer is held while
//! the thread waits for bytes.

use super::poll::{FEW_BYTES, Return};
use crate::buffer_pool::POOLED_BUFFER_BYTES;
use crate::message::{Batch, Message};
use std::io::{self, ErrorKind, Read};

/// Reads `input` to its end, no faster than the render thread runs the bytes.
pub(super) fn read_all(mut input: Box<dyn Read + Send>, back: &Return) {
    let Return { registered, shared } = back;
    let end = || shared.at_end(registered).into_iter().for_each(|message| registered.send(message));
    let mut own = vec![0; POOLED_BUFFER_BYTES];
    loop {
        if let Some(mut payload) = registered.wait_for_room() {
            let filled = payload.read_from(&mut *input);
            let is_at_end = payload.missing() > 0;
            if shared.note_batch(registered, filled) {
                registered.send(Message::Payload(registered.id, payload));
            }
            if is_at_end {
                return end();
            }
            continue;
        }
        let filled = match read_some(&mut *input, &mut own) {
            Ok(filled @ 1..) => filled,
            // An input that fails ends like one that was closed; the bytes before that still count.
            Ok(0) | Err(_) => return end(),
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
