//! The program to be run: where it is, and whether a preloaded library reaches it.

use super::Refusal;
use crate::fbdev::elf::{self, HEAD_BYTES, Unserved};
use std::ffi::{OsStr, OsString};
use std::fs::{File, Metadata};
use std::io::Read;
use std::os::unix::ffi::{OsStrExt, OsStringExt};
use std::os::unix::fs::{FileExt, MetadataExt};
use std::path::{Path, PathBuf};

/// Interpreters of interpreters that are followed.
const DEPTH: u32 = 4;
/// Set-user-ID and set-group-ID.
const SET_UID: u32 = 0o4000;
const SET_GID: u32 = 0o2000;
fn refuse(status: u8, message: String) -> Refusal {
    Refusal { status, message }
}

/// Finds a program as a shell does, and checks that it can be served.
pub fn find(name: &OsStr) -> Result<PathBuf, Refusal> {
    let path = match name.as_bytes().contains(&b'/') {
        true => PathBuf::from(name),
        false => in_path(name, &std::env::var_os("PATH").unwrap_or_default())
            .ok_or_else(|| refuse(127, format!("{}: there is no such program in PATH", name.display())))?,
    };
    check(&path, DEPTH)?;
    Ok(path)
}

/// Returns the first executable of this name in the folders of `folders`.
fn in_path(name: &OsStr, folders: &OsStr) -> Option<PathBuf> {
    let mut found = std::env::split_paths(folders).map(|folder| folder.join(name));
    found.find(|path| path.metadata().is_ok_and(|meta| meta.is_file() && meta.mode() & 0o111 != 0))
}

/// Checks that a program, or its interpreter, can be served.
fn check(path: &Path, depth: u32) -> Result<(), Refusal> {
    let name = path.display();
    let meta = path.metadata().map_err(|e| match e.kind() {
        std::io::ErrorKind::NotFound => refuse(127, format!("{name}: {e}")),
        _ => refuse(126, format!("{name}: {e}")),
    })?;
    if !meta.is_file() || meta.mode() & 0o111 == 0 {
        return Err(refuse(126, format!("{name}: is not an executable file")));
    }
    if has_other_rights(path, &meta) {
        return Err(refuse(126, format!("{name}: {}", Unserved::Rights.reason())));
    }
    // What cannot be read may still be run; the system then says what is wrong.
    let Ok(file) = File::open(path) else { return Ok(()) };
    let mut head = [0; HEAD_BYTES];
    let len = (&file).read(&mut head).unwrap_or(0);
    match &head[..len] {
        [b'#', b'!', line @ ..] => match interpreter_of_script(line) {
            Some(interpreter) if depth > 0 => check(&interpreter, depth - 1),
            _ => Ok(()),
        },
        read if elf::is_elf(read) => {
            check_elf(&file, &head).map_err(|why| refuse(126, format!("{name}: {}", why.reason())))
        }
        _ => Ok(()),
    }
}

/// Returns whether a program runs with other rights than ours.
fn has_other_rights(path: &Path, meta: &Metadata) -> bool {
    let (uid, gid) = (rustix::process::geteuid().as_raw(), rustix::process::getegid().as_raw());
    let capabilities = || {
        let mut value = [0u8; 64];
        uid != 0 && rustix::fs::getxattr(path, "security.capability", &mut value).is_ok()
    };
    (meta.mode() & SET_UID != 0 && meta.uid() != uid)
        || (meta.mode() & SET_GID != 0 && meta.gid() != gid)
        || capabilities()
}

/// Returns the interpreter that a script's first line names.
fn interpreter_of_script(line: &[u8]) -> Option<PathBuf> {
    elf::interpreter(line).map(|word| PathBuf::from(OsString::from_vec(word.to_vec())))
}

/// Checks that the dynamic loader of the GNU C library, for this machine, starts an ELF file.
fn check_elf(file: &File, head: &[u8; HEAD_BYTES]) -> Result<(), Unserved> {
    elf::check(head, |offset, bytes| file.read_exact_at(bytes, offset).is_ok())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn programs_are_found_in_the_path_and_what_is_none_is_refused() {
        assert_eq!(in_path("sh".as_ref(), "/nowhere:/bin".as_ref()), Some("/bin/sh".into()));
        assert_eq!(find("no-such-program-here".as_ref()).unwrap_err().status, 127);
        assert_eq!(find("/no/such/program".as_ref()).unwrap_err().status, 127);
        for path in ["/", "/etc/passwd"] {
            assert_eq!(find(path.as_ref()).unwrap_err().status, 126, "{path}");
        }
        assert!(find("sh".as_ref()).is_ok());
    }

    #[test]
    fn a_script_is_as_good_as_its_interpreter() {
        let of = |line: &str| interpreter_of_script(line.as_bytes());
        assert_eq!(of(" /bin/sh -e\nrest"), Some("/bin/sh".into()));
        assert_eq!(of("/usr/bin/env\tpython3"), Some("/usr/bin/env".into()));
        assert_eq!(of("\n"), None);
    }

    #[test]
    fn elf_files_of_others_are_refused_and_broken_ones_do_no_harm() {
        let exe = File::open("/bin/sh").unwrap();
        let mut head = [0; 256];
        exe.read_exact_at(&mut head, 0).unwrap();
        assert_eq!(check_elf(&exe, &head), Ok(()));
        for (at, value, word) in [(4, 1, "32 bits"), (18, 1, "another machine"), (56, 0, "statically")] {
            let mut other = head;
            other[at] = value;
            if at == 56 {
                other[57] = 0;
            }
            assert!(check_elf(&exe, &other).unwrap_err().reason().contains(word));
        }
        for at in 0..64 {
            for value in [0, 0x7f, 0xff] {
                let mut broken = head;
                broken[at] = value;
                let _ = check_elf(&exe, &broken);
            }
        }
    }

    #[test]
    fn the_libraries_of_a_program_are_listed_and_broken_lists_do_no_harm() {
        let whole = std::fs::read("/bin/sh").unwrap();
        let list = |bytes: &[u8]| {
            let mut names = Vec::new();
            let read = |at: u64, to: &mut [u8]| {
                let from = usize::try_from(at).ok().and_then(|at| bytes.get(at..at.checked_add(to.len())?));
                from.map(|from| to.copy_from_slice(from)).is_some()
            };
            elf::each_needed(read, |name| names.push(String::from_utf8_lossy(name).into_owned()));
            names
        };
        assert!(list(&whole).iter().any(|name| name.starts_with("libc.so")), "{:?}", list(&whole));
        assert_eq!(list(b"#!/bin/sh"), Vec::<String>::new());
        let mut broken = whole.clone();
        for at in 0..1024.min(whole.len()) {
            for value in [0, 0x7f, 0xff] {
                broken[at] = value;
                list(&broken);
                broken[at] = whole[at];
            }
        }
        for len in (0..whole.len()).step_by(997) {
            list(&whole[..len]);
        }
    }
}
