//! Memory that this process may use: the machine's, or less if a control group limits it.
//!
//! In: files of /proc and of the control groups' file system, versions 1 and 2. Out: bytes. Called
//! once at the start, when arguments are parsed. On other systems than Linux, and if the files
//! cannot be read, [`FALLBACK_BYTES`] are assumed.

use std::fs;
use std::path::Path;

/// Bytes of memory to assume if the machine does not report it.
const FALLBACK_BYTES: u64 = 4 << 30;

/// Returns a quarter of the memory that this process may use, in bytes: the default of the memory
/// budget.
pub fn default_memory_bytes() -> u64 {
    usable_bytes(Path::new("/proc"), Path::new("/sys/fs/cgroup")) / 4
}

/// Returns the least of the machine's memory and the limits of the process's control groups, in
/// bytes.
fn usable_bytes(proc: &Path, groups: &Path) -> u64 {
    let machine = fs::read_to_string(proc.join("meminfo")).ok().and_then(|text| total_of(&text));
    let own_groups = fs::read_to_string(proc.join("self/cgroup")).unwrap_or_default();
    let limits = own_groups.lines().filter_map(|line| group_limit(line, groups));
    limits.chain(machine).min().unwrap_or(FALLBACK_BYTES)
}

/// Parses a line such as `MemTotal:  8052404 kB` of /proc/meminfo. Returns bytes.
fn total_of(meminfo: &str) -> Option<u64> {
    let line = meminfo.lines().find_map(|line| line.strip_prefix("MemTotal:"))?;
    line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok()?.checked_mul(1024)
}

/// Returns the limit of one line of /proc/self/cgroup: `0::/a/b` of version 2, `4:memory:/a/b` of
/// version 1. The limits of the enclosing groups apply, too. Inside a container the path may be
/// that of the host, and the container's own group the root.
fn group_limit(line: &str, groups: &Path) -> Option<u64> {
    let mut parts = line.splitn(3, ':');
    let (number, controllers, path) = (parts.next()?, parts.next()?, parts.next()?);
    let (root, file) = match (number, controllers) {
        ("0", "") => (groups.to_path_buf(), "memory.max"),
        (_, list) if list.split(',').any(|c| c == "memory") => {
            (groups.join("memory"), "memory.limit_in_bytes")
        }
        _ => return None,
    };
    let own = Path::new(path.trim_start_matches('/'));
    // Without a limit, version 1 writes a number beyond all memory, version 2 "max".
    let limit =
        |group: &Path| fs::read_to_string(root.join(group).join(file)).ok()?.trim().parse::<u64>().ok();
    own.ancestors().filter_map(limit).min()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn write(root: &Path, files: &[(&str, &str)]) {
        for (name, text) in files {
            let path = root.join(name);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, text).unwrap();
        }
    }

    #[test]
    fn the_least_of_the_machine_and_its_groups_counts() {
        let meminfo = ("proc/meminfo", "MemFree: 5 kB\nMemTotal:       8000000 kB\n");
        let cases: [(&[(&str, &str)], u64); 7] = [
            (&[], FALLBACK_BYTES),
            (&[meminfo], 8_192_000_000),
            (
                &[meminfo, ("proc/self/cgroup", "0::/a/b\n"), ("sys/a/b/memory.max", "512000000\n")],
                512_000_000,
            ),
            (
                &[
                    meminfo,
                    ("proc/self/cgroup", "0::/a/b\n"),
                    ("sys/a/b/memory.max", "max\n"),
                    ("sys/a/memory.max", "70000\n"),
                ],
                70_000,
            ),
            (&[meminfo, ("proc/self/cgroup", "0::/host\n"), ("sys/memory.max", "60000\n")], 60_000),
            (
                &[
                    meminfo,
                    ("proc/self/cgroup", "3:cpu,memory:/x\n0::/\n"),
                    ("sys/memory/x/memory.limit_in_bytes", "900000\n"),
                ],
                900_000,
            ),
            (
                &[
                    meminfo,
                    ("proc/self/cgroup", "3:memory:/\n"),
                    ("sys/memory/memory.limit_in_bytes", "9223372036854771712\n"),
                ],
                8_192_000_000,
            ),
        ];
        for (i, (files, bytes)) in cases.into_iter().enumerate() {
            let root = std::env::temp_dir().join(format!("fbptr-machine-memory-{}-{i}", std::process::id()));
            write(&root, files);
            let usable = usable_bytes(&root.join("proc"), &root.join("sys"));
            let _ = fs::remove_dir_all(&root);
            assert_eq!(usable, bytes, "{files:?}");
        }
        assert!(default_memory_bytes() > 1 << 20, "this machine has memory");
    }
}
