//! Reserves a shared file's blocks on disk: a store into a mapped file on a full disk would raise a
//! signal instead of an error.

use std::fs::File;
use std::io;

/// Sets the length of `file` to `bytes`, with all blocks allocated. Keeps the file's contents.
///
/// # Errors
/// `StorageFull` or `QuotaExceeded` if there is no room, or the system's error.
pub(super) fn reserve(file: &File, bytes: u64) -> io::Result<()> {
    #[cfg(target_os = "linux")]
    {
        use rustix::fs::{FallocateFlags, fallocate};
        use rustix::io::Errno;
        loop {
            match fallocate(file, FallocateFlags::empty(), 0, bytes) {
                Ok(()) => return file.set_len(bytes),
                Err(Errno::INTR) => {}
                // This file system cannot reserve.
                Err(Errno::OPNOTSUPP | Errno::NOSYS) => break,
                Err(e) => return Err(e.into()),
            }
        }
    }
    write_through(file, bytes)
}

/// Allocates blocks by writing zeros to every block that reads as zeros.
fn write_through(mut file: &File, bytes: u64) -> io::Result<()> {
    use std::io::{Read, Seek, SeekFrom, Write};
    file.set_len(bytes)?;
    let mut block = [0; 4096];
    for at in (0..bytes).step_by(block.len()) {
        let block = &mut block[..(bytes - at).min(4096) as usize];
        file.seek(SeekFrom::Start(at))?;
        file.read_exact(block)?;
        // A block with content is allocated already, and other programs may be writing to it.
        if block.iter().all(|b| *b == 0) {
            file.seek(SeekFrom::Start(at))?;
            file.write_all(block)?;
        }
    }
    file.seek(SeekFrom::Start(0)).map(drop)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn writing_through_keeps_what_is_there_and_fills_the_holes() {
        use std::io::{Read, Seek, SeekFrom, Write};
        let path = std::env::temp_dir().join(format!("fbptr-reserve-{}", std::process::id()));
        let mut options = File::options();
        let mut file = options.read(true).write(true).create(true).truncate(true).open(&path).unwrap();
        file.seek(SeekFrom::Start(5000)).unwrap();
        file.write_all(b"theirs").unwrap();
        write_through(&file, 20_001).unwrap();
        let mut all = Vec::new();
        file.read_to_end(&mut all).unwrap();
        assert_eq!((all.len(), &all[5000..5006]), (20_001, &b"theirs"[..]));
        assert!(all.iter().filter(|b| **b != 0).count() == 6);
        #[cfg(unix)]
        {
            use std::os::unix::fs::MetadataExt;
            assert!(file.metadata().unwrap().blocks() * 512 >= 20_001, "there are holes left");
        }
        std::fs::remove_file(&path).unwrap();
    }
}
