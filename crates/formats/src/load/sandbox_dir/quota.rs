//! A sandbox directory with a limit on the bytes written through it.
//!
//! In: names and contents. Out: files, or an error with the figures. Files count in whole blocks.
//! Files that existed before, or that others write, do not count; files that others remove stop
//! counting when room is next searched for. Threads may write concurrently and share the quota.

use super::{SandboxDir, SandboxError};
use std::collections::BTreeMap;
use std::io::{self, Write};
use std::ops::Bound;
use std::path::PathBuf;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Block size: each file counts as a multiple of it.
const BLOCK_BYTES: u64 = 4096;
/// Most files checked for existence at once when room is missing: about a millisecond.
const LOOKED_FOR: usize = 500;

/// A sandbox directory whose files, as far as they were written through it, take at most a given
/// number of bytes.
#[derive(Debug)]
pub struct QuotaDir {
    folder: SandboxDir,
    limit_bytes: u64,
    usage: Mutex<Usage>,
}

/// Bytes in use, by file.
#[derive(Debug, Default)]
struct Usage {
    /// Files written, with the bytes they take.
    files: BTreeMap<PathBuf, u64>,
    /// Bytes of `files`, and of files that are being written.
    used_bytes: u64,
    /// Last file that was checked for existence, where the next search continues.
    looked_at: Option<PathBuf>,
}

impl QuotaDir {
    /// Limits the files written into `folder` to `limit_bytes` in total.
    pub fn new(folder: SandboxDir, limit_bytes: u64) -> Self {
        QuotaDir { folder, limit_bytes, usage: Mutex::default() }
    }

    /// Returns the folder.
    pub fn folder(&self) -> &SandboxDir {
        &self.folder
    }

    /// Returns the bytes taken by the files written and being written.
    pub fn used_bytes(&self) -> u64 {
        self.lock().used_bytes
    }

    fn lock(&self) -> MutexGuard<'_, Usage> {
        // After a panic the count may be off by one file, which still limits the folder.
        self.usage.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Writes the file `name` as [`SandboxDir::write`] does. The room of a file that it replaces is
    /// available to it.
    ///
    /// # Errors
    /// [`SandboxError::Quota`] if the file does not fit, or another [`SandboxError`].
    pub fn write(
        &self,
        name: &str,
        fill: impl FnOnce(&mut dyn Write) -> io::Result<()>,
    ) -> Result<(), SandboxError> {
        let path = self.folder.path_to_write(name)?;
        let replaced_bytes = self.lock().files.get(&path).copied().unwrap_or(0);
        let mut account =
            Account { quota: self, replaced_bytes, written_bytes: 0, taken_bytes: 0, full_at: None };
        let result = self.folder.write(name, |out| fill(&mut Metered { out, account: &mut account }));
        let Account { taken_bytes, full_at, .. } = account;
        let mut usage = self.lock();
        match result {
            Ok(()) => {
                let before = usage.files.insert(path, taken_bytes).unwrap_or(0);
                usage.used_bytes -= before;
                Ok(())
            }
            Err(e) => {
                usage.used_bytes -= taken_bytes;
                match full_at {
                    Some(used) => {
                        Err(SandboxError::Quota { name: name.into(), used, limit: self.limit_bytes })
                    }
                    None => Err(e),
                }
            }
        }
    }
}

impl Usage {
    /// Stops counting files that were removed. Checks at most [`LOOKED_FOR`] files; the next call
    /// continues after them.
    fn look_for_files(&mut self) {
        let after = self.looked_at.take().map_or(Bound::Unbounded, Bound::Excluded);
        let some: Vec<PathBuf> = self
            .files
            .range((after, Bound::Unbounded))
            .take(LOOKED_FOR)
            .map(|(path, _)| path.clone())
            .collect();
        let is_gone = |path: &PathBuf| {
            std::fs::symlink_metadata(path).is_err_and(|e| e.kind() == io::ErrorKind::NotFound)
        };
        for path in some.iter().filter(|path| is_gone(path)) {
            self.used_bytes -= self.files.remove(path).unwrap_or(0);
        }
        if some.len() == LOOKED_FOR {
            self.looked_at = some.into_iter().last();
        }
    }
}

/// Bytes of one file while it is being written.
struct Account<'a> {
    quota: &'a QuotaDir,
    replaced_bytes: u64,
    written_bytes: u64,
    taken_bytes: u64,
    /// Bytes in use, this file's not counted, when there was no room for it.
    full_at: Option<u64>,
}

impl Account<'_> {
    /// Reserves room for `more` bytes; returns whether there was any.
    fn take(&mut self, more: u64) -> bool {
        let wanted = (self.written_bytes + more).next_multiple_of(BLOCK_BYTES) - self.taken_bytes;
        let mut usage = self.quota.lock();
        let limit = self.quota.limit_bytes.saturating_add(self.replaced_bytes);
        let fits = |usage: &Usage| usage.used_bytes.saturating_add(wanted) <= limit;
        if !fits(&usage) && self.full_at.is_none() {
            usage.look_for_files();
        }
        if !fits(&usage) {
            self.full_at = Some(usage.used_bytes - self.taken_bytes);
            return false;
        }
        usage.used_bytes += wanted;
        self.taken_bytes += wanted;
        self.written_bytes += more;
        true
    }
}

/// A writer that fails when the quota is exhausted.
struct Metered<'a, 'q> {
    out: &'a mut dyn Write,
    account: &'a mut Account<'q>,
}

impl Write for Metered<'_, '_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        match self.account.take(bytes.len() as u64) {
            true => self.out.write_all(bytes).map(|()| bytes.len()),
            false => Err(io::ErrorKind::QuotaExceeded.into()),
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        self.out.flush()
    }
}
