//! Detection of executable files that the GNU C library's dynamic loader starts on this machine:
//! no other one preloads a library.
//!
//! Source: `elf(5)`. Pure functions; the program and the preload library include this file.

/// Bytes of a file that [`check`] begins with.
pub const HEAD_BYTES: usize = 256;
/// Most entries of a program's dynamic section that are read.
const MAX_ENTRIES: u64 = 1024;
/// Most bytes of a library's name.
const NAME_BYTES: usize = 64;
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

/// Passes the names of the libraries that a program itself needs to `each`: `read` fills a buffer
/// from an offset of the file and returns whether it could. Longer names than `NAME_BYTES` are cut
/// off.
pub fn each_needed(mut read: impl FnMut(u64, &mut [u8]) -> bool, mut each: impl FnMut(&[u8])) {
    let mut head = [0; 64];
    if !read(0, &mut head) || !is_elf(&head) || head[4] != 2 || head[5] != 1 {
        return;
    }
    let long = |bytes: &[u8], at: usize| u64::from_le_bytes(core::array::from_fn(|i| bytes[at + i]));
    let half = |at: usize| u64::from(u16::from_le_bytes([head[at], head[at + 1]]));
    let (table, size, count) = (long(&head, 32), half(54), half(56));
    let header = |kind: u32, index: u64, read: &mut dyn FnMut(u64, &mut [u8]) -> bool| {
        let mut header = [0; 56];
        let at = table.checked_add(size.checked_mul(index)?)?;
        (read(at, &mut header) && header[..4] == kind.to_le_bytes()).then_some(header)
    };
    // PT_DYNAMIC
    let Some(dynamic) = (0..count).find_map(|i| header(2, i, &mut read)) else { return };
    let entries = (long(&dynamic, 32) / 16).min(MAX_ENTRIES);
    let entry = |i: u64, read: &mut dyn FnMut(u64, &mut [u8]) -> bool| {
        let mut entry = [0; 16];
        let at = long(&dynamic, 8).checked_add(i * 16)?;
        read(at, &mut entry).then(|| (long(&entry, 0), long(&entry, 8)))
    };
    // DT_STRTAB: an address, whose place in the file a segment says (PT_LOAD).
    let Some((_, strings)) = (0..entries).find_map(|i| entry(i, &mut read).filter(|(tag, _)| *tag == 5))
    else {
        return;
    };
    let in_file = |load: [u8; 56]| {
        let (offset, address, len) = (long(&load, 8), long(&load, 16), long(&load, 32));
        strings.checked_sub(address).filter(|inside| *inside < len)?.checked_add(offset)
    };
    let Some(strings) = (0..count).find_map(|i| in_file(header(1, i, &mut read)?)) else { return };
    for i in 0..entries {
        // DT_NULL ends the list, DT_NEEDED is a name.
        match entry(i, &mut read) {
            Some((1, at)) => {
                let mut name = [0; NAME_BYTES];
                // A name that ends with the file is read byte by byte.
                let start = strings.saturating_add(at);
                if !read(start, &mut name) {
                    (0..NAME_BYTES).for_each(|i| _ = read(start.saturating_add(i as u64), &mut name[i..=i]));
                }
                each(name.split(|byte| *byte == 0).next().unwrap_or_default());
            }
            Some((0, _)) | None => return,
            Some(_) => {}
        }
    }
}

/// Returns the interpreter that a script's first line names, from the text after `#!`.
pub fn interpreter(line: &[u8]) -> Option<&[u8]> {
    let line = line.split(|b| matches!(b, b'\n' | 0)).next()?;
    line.split(|b| *b == b' ' || *b == b'\t').find(|word| !word.is_empty())
}
