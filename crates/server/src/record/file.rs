//! Files of recordings: locked before they are emptied, so that a second server cannot destroy a
//! recording in progress.

use super::writer::Patience;
use fbptr_formats::save::{begin, is_link};
use std::fs::{File, OpenOptions, TryLockError};
use std::io;
use std::path::Path;
use std::time::{Duration, Instant};

/// Time that a pipe's reader has to open it.
const READER_WITHIN: Duration = Duration::from_secs(1);

/// An open and empty file, pipe or device for a recording. It is locked as long as it is open.
#[derive(Debug)]
pub struct RecordFile {
    pub(super) file: File,
    pub(super) patience: Patience,
}

impl RecordFile {
    /// Opens and locks `path`, and empties it if it is a file. Waits up to a second for the reader
    /// of a pipe.
    ///
    /// # Errors
    /// If it cannot be opened, if another process records into it, or if it is a pipe without a
    /// reader.
    pub fn open(path: &Path) -> io::Result<RecordFile> {
        let mut options = OpenOptions::new();
        options.write(true).create(true).truncate(false);
        #[cfg(unix)]
        {
            use std::os::unix::fs::OpenOptionsExt;
            options.custom_flags(rustix::fs::OFlags::NONBLOCK.bits() as i32);
        }
        // A link is replaced, and what it leads to stays as it was.
        let file = if is_link(path) { begin(path)? } else { open_with_reader(&options, path)? };
        let meta = file.metadata()?;
        // Devices such as /dev/null and /dev/full are shared, so they are not locked.
        if meta.is_file() || is_pipe(&meta) {
            lock(&file)?;
        }
        if meta.is_file() {
            file.set_len(0)?;
        }
        wait_in_writes(&file)?;
        let patience = if meta.is_file() { Patience::FILE } else { Patience::PIPE };
        Ok(RecordFile { file, patience })
    }
}

fn lock(file: &File) -> io::Result<()> {
    match file.try_lock() {
        Ok(()) => Ok(()),
        Err(TryLockError::WouldBlock) => {
            let message = "another process records into it, and its recording is left as it is";
            Err(io::Error::new(io::ErrorKind::WouldBlock, message))
        }
        // On a file system without locks no other process can have one either.
        Err(TryLockError::Error(e)) if e.kind() == io::ErrorKind::Unsupported => Ok(()),
        Err(TryLockError::Error(e)) => Err(e),
    }
}

/// Opens `path`; if it is a pipe without a reader, tries again for [`READER_WITHIN`].
fn open_with_reader(options: &OpenOptions, path: &Path) -> io::Result<File> {
    let until = Instant::now() + READER_WITHIN;
    loop {
        match options.open(path) {
            Err(e) if has_no_reader(&e) => {
                if Instant::now() >= until {
                    return Err(io::Error::new(e.kind(), "a pipe that nobody reads"));
                }
                std::thread::sleep(Duration::from_millis(10));
            }
            result => return result,
        }
    }
}

#[cfg(unix)]
fn has_no_reader(e: &io::Error) -> bool {
    e.raw_os_error() == Some(rustix::io::Errno::NXIO.raw_os_error())
}

#[cfg(not(unix))]
fn has_no_reader(_: &io::Error) -> bool {
    false
}

#[cfg(unix)]
fn is_pipe(meta: &std::fs::Metadata) -> bool {
    std::os::unix::fs::FileTypeExt::is_fifo(&meta.file_type())
}

#[cfg(not(unix))]
fn is_pipe(_: &std::fs::Metadata) -> bool {
    false
}

/// Clears `O_NONBLOCK`, which was needed for opening only: the writer's thread may block.
#[cfg(unix)]
fn wait_in_writes(file: &File) -> io::Result<()> {
    use rustix::fs::{OFlags, fcntl_getfl, fcntl_setfl};
    let flags = fcntl_getfl(file)?;
    Ok(fcntl_setfl(file, flags - OFlags::NONBLOCK)?)
}

#[cfg(not(unix))]
fn wait_in_writes(_: &File) -> io::Result<()> {
    Ok(())
}
