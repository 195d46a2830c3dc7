//! Files that commands read: their contents by name, and the identity of a content.
//!
//! In: bytes of files, from the load folder or from a recording. Out: plain values, which the engine
//! passes to its observers. Fingerprints are computed on the thread that reads the file, because
//! hashing a long one takes long.

use std::collections::HashMap;
use std::hash::{BuildHasher, RandomState};
use std::sync::Arc;

/// File contents by the names that a command uses.
pub type FileSet = HashMap<String, Arc<[u8]>>;

/// A file that a command has read.
#[derive(Debug)]
pub struct ReadFile {
    /// Path inside the folder, as the command or the referring file names it.
    pub path: String,
    /// Content of the file.
    pub bytes: Arc<[u8]>,
    /// Identity of the content.
    pub fingerprint: Fingerprint,
}

/// Length and two keyed hashes of a content. Without the keys nobody can construct two contents
/// with the same fingerprint.
pub type Fingerprint = (usize, [u64; 2]);

/// The keys of a server's fingerprints.
#[derive(Clone, Debug, Default)]
pub(super) struct FileHasher([RandomState; 2]);

impl FileHasher {
    pub fn fingerprint(&self, bytes: &[u8]) -> Fingerprint {
        (bytes.len(), self.0.each_ref().map(|keys| keys.hash_one(bytes)))
    }
}
