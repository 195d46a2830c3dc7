//! Memory without a name in the file system that other processes of this user map: the memories of
//! the emulated framebuffer device.
//!
//! In: a size. Out: a memory file (`memfd_create`), sealed so that nobody can change its size, and
//! its words. It ends with the last process that has it open or mapped, however these end. Every
//! access is an atomic load or store, because others write at any time.

use super::shared::map::Map;
use rustix::fs::{MemfdFlags, SealFlags, fcntl_add_seals, memfd_create};
use std::fs::File;
use std::io;
use std::sync::atomic::{AtomicU32, AtomicU64, Ordering::Relaxed};

/// A sealed memory file and its map.
#[derive(Debug)]
pub struct DeviceMemory {
    file: File,
    map: Map,
    bytes: usize,
}

impl DeviceMemory {
    /// Creates a memory of `bytes` zero bytes. The size must be a multiple of 8.
    ///
    /// # Errors
    /// If the system refuses.
    pub fn new(name: &str, bytes: usize) -> io::Result<Self> {
        let file = File::from(memfd_create(name, MemfdFlags::CLOEXEC | MemfdFlags::ALLOW_SEALING)?);
        file.set_len(bytes as u64)?;
        fcntl_add_seals(&file, SealFlags::SHRINK | SealFlags::GROW | SealFlags::SEAL)?;
        Ok(DeviceMemory { map: Map::new(&file, bytes)?, file, bytes })
    }

    /// Returns the file.
    pub fn file(&self) -> &File {
        &self.file
    }

    /// Returns the size in bytes.
    pub fn len_bytes(&self) -> usize {
        self.bytes
    }

    /// Returns the word at an offset.
    ///
    /// # Panics
    /// If the offset is not a multiple of 4 inside the memory.
    pub fn word(&self, at: usize) -> &AtomicU32 {
        self.map.word_at(at)
    }

    /// Returns the 64-bit word at an offset.
    ///
    /// # Panics
    /// If the offset is not a multiple of 8 inside the memory.
    pub fn long(&self, at: usize) -> &AtomicU64 {
        self.map.long(at)
    }

    /// Copies the bytes from `at` on over `copy`, and returns whether any of them was another one.
    /// Bytes that are the same are only read.
    ///
    /// # Panics
    /// If `at` or the copy's length is not a multiple of 4, or the bytes are not inside the memory.
    pub fn refresh(&self, at: usize, copy: &mut [u8]) -> bool {
        assert!(copy.len().is_multiple_of(4));
        let head = if at.is_multiple_of(8) { 0 } else { 4.min(copy.len()) };
        let (head, rest) = copy.split_at_mut(head);
        let (longs, tail) = rest.as_chunks_mut::<8>();
        let theirs = self.map.longs((at + head.len()).next_multiple_of(8).min(self.bytes), longs.len());
        let (mut is_changed, tail_at) = (false, at + head.len() + longs.len() * 8);
        if let Ok(head) = <&mut [u8; 4]>::try_from(head) {
            is_changed |= refresh_word(self.word(at), head);
        }
        for (theirs, ours) in theirs.chunks(BLOCK).zip(longs.chunks_mut(BLOCK)) {
            let difference = theirs
                .iter()
                .zip(&*ours)
                .fold(0, |sum, (theirs, ours)| sum | theirs.load(Relaxed) ^ u64::from_ne_bytes(*ours));
            if difference != 0 {
                is_changed = true;
                for (theirs, ours) in theirs.iter().zip(ours) {
                    *ours = theirs.load(Relaxed).to_ne_bytes();
                }
            }
        }
        if let Ok(tail) = <&mut [u8; 4]>::try_from(tail) {
            is_changed |= refresh_word(self.word(tail_at), tail);
        }
        is_changed
    }
}

/// Words of eight bytes that are compared between two checks for a difference.
const BLOCK: usize = 64;

fn refresh_word(theirs: &AtomicU32, ours: &mut [u8; 4]) -> bool {
    let theirs = theirs.load(Relaxed).to_ne_bytes();
    std::mem::replace(ours, theirs) != theirs
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::os::unix::fs::FileExt;

    #[test]
    fn changes_are_found_at_every_place_and_of_every_length() {
        let memory = DeviceMemory::new("test", 4096).unwrap();
        let mut copy = vec![0; 4096];
        for (start, end) in
            [(0, 4096), (4, 2048), (4, 8), (8, 12), (4, 4092), (4092, 4096), (12, 12), (4, 16)]
        {
            for at in [start, (start + end) / 2, end.max(1) - 1] {
                memory.file().write_all_at(&[at as u8 | 1], at as u64).unwrap();
                let is_inside = (start..end).contains(&at);
                assert_eq!(memory.refresh(start, &mut copy[start..end]), is_inside, "{at} in {start}..{end}");
                assert!(!memory.refresh(start, &mut copy[start..end]), "seen twice: {at} in {start}..{end}");
                memory.file().write_all_at(&[0], at as u64).unwrap();
                memory.refresh(0, &mut copy);
            }
        }
    }

    #[test]
    fn nobody_can_change_its_size() {
        let memory = DeviceMemory::new("test", 4096).unwrap();
        assert!(memory.file().set_len(0).is_err() && memory.file().set_len(8192).is_err());
        assert!(memory.file().write_all_at(&[1], 4096).is_err());
        assert_eq!(memory.file().metadata().unwrap().len(), 4096);
    }
}
