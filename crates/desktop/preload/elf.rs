//! Detection of executable files that the GNU C library's dynamic loader starts on this machine:
//! no other one preloads a library.
//!
//! Source: `elf(5)`. Pure functions; the program and the preload library include this file.

/// Bytes of a file that [`check`] begins with.
pub const HEAD_BYTES: usize = 256;
/// Most bytes of a loader's path.
const LOADER_BYTES: usize = 256;
/// Machine number of ELF files.
const OWN_MACHINE: u16 = match () {
    () if cfg!(target_arch = "x86_64") => 62,
    () if cfg!(target_arch = "aarch64") => 183,
    () => 243,
};

/// Reasons for which a library cannot be preloaded into a program.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unserved {
    /// Made for another machine.
    Machine = 1,
    /// Statically linked.
    Static = 2,
    /// Linked with musl.
    Musl = 3,
    /// Runs with the rights of another user.
    Rights = 4,
    /// Not a program but a call of one: it draws with OpenGL itself.
    Geometry = 5,
}

impl Unserved {
    /// All reasons.
    pub const ALL: [Unserved; 5] =
        [Unserved::Machine, Unserved::Static, Unserved::Musl, Unserved::Rights, Unserved::Geometry];

    /// Returns the reason in words.
    pub fn reason(self) -> &'static str {
        match self {
            Unserved::Machine => {
                "is made for another machine, or for 32 bits: a library of this machine cannot be preloaded"
            }
            Unserved::Static => {
                "is statically linked: no library can be preloaded, so it cannot be served (build it without -static)"
            }
            Unserved::Musl => "is linked with musl: the preload library needs the GNU C library",
            Unserved::Rights => {
                "runs with the rights of another user (set-user-ID or capabilities), so the system lets no library \
                 be preloaded: it cannot be served"
            }
            Unserved::Geometry => {
                "draws with OpenGL itself, which is not served: one picture is, by glDrawPixels or on a textured \
                 rectangle"
            }
        }
    }
}

/// Returns whether a file that begins with these bytes is an ELF file.
pub fn is_elf(head: &[u8]) -> bool {
    head.starts_with(b"\x7fELF")
}

/// Returns why an ELF file cannot be served, if it cannot. `read` fills a buffer from an offset of
/// the file and returns whether it could.
pub fn check(head: &[u8; HEAD_BYTES], mut read: impl FnMut(u64, &mut [u8]) -> bool) -> Result<(), Unserved> {
    let half = |at: usize| u16::from_le_bytes([head[at], head[at + 1]]);
    // 64 bits, little-endian.
    if head[4] != 2 || head[5] != 1 || half(18) != OWN_MACHINE {
        return Err(Unserved::Machine);
    }
    let table = u64::from_le_bytes(core::array::from_fn(|i| head[32 + i]));
    let (size, count) = (u64::from(half(54)), u64::from(half(56)));
    for i in 0..count {
        let mut header = [0; 56];
        let at = size.checked_mul(i).and_then(|offset| table.checked_add(offset)).unwrap_or(u64::MAX / 2);
        if !read(at, &mut header) {
            break;
        }
        let long = |at: usize| u64::from_le_bytes(core::array::from_fn(|i| header[at + i]));
        // PT_INTERP
        if header[..4] == [3, 0, 0, 0] {
            let mut loader = [0; LOADER_BYTES];
            let loader = &mut loader[..long(32).min(LOADER_BYTES as u64) as usize];
            read(long(8), loader);
            return match loader.windows(4).any(|word| word == b"musl") {
                false => Ok(()),
                true => Err(Unserved::Musl),
            };
        }
    }
    Err(Unserved::Static)
}

/// Returns the interpreter that a script's first line names, from the text after `#!`.
pub fn interpreter(line: &[u8]) -> Option<&[u8]> {
    let line = line.split(|b| matches!(b, b'\n' | 0)).next()?;
    line.split(|b| *b == b' ' || *b == b'\t').find(|word| !word.is_empty())
}
