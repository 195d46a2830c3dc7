//! Parts of files that are made from the verb table: compared, and with BLESS=1 rewritten.

use std::fs;
use std::path::Path;

/// Checks that a file contains `wanted` between the lines `begin` and `end`. With BLESS=1 the file
/// is rewritten, and the test fails once more.
pub fn check_block(path: &str, [begin, end]: [&str; 2], wanted: &str) {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join(path);
    let text = fs::read_to_string(&file).unwrap_or_else(|e| panic!("{path}: {e}"));
    let (head, rest) = text.split_once(begin).unwrap_or_else(|| panic!("{path} has no line {begin:?}"));
    let (found, tail) = rest.split_once(end).unwrap_or_else(|| panic!("{path} has no line {end:?}"));
    if found != wanted && std::env::var_os("BLESS").is_some() {
        fs::write(&file, [head, begin, wanted, end, tail].concat()).expect("the file can be written");
    }
    let difference = found.lines().zip(wanted.lines()).find(|(a, b)| a != b);
    assert!(found == wanted, "{path} is not what the verb table says: {difference:?}; BLESS=1 rewrites it");
}

/// Checks that a file has the bytes of another. With BLESS=1 it is rewritten, and the test fails
/// once more.
pub fn check_copy(original: &str, copy: &str) {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let wanted = fs::read(root.join(original)).unwrap_or_else(|e| panic!("{original}: {e}"));
    let found = fs::read(root.join(copy)).unwrap_or_default();
    if found != wanted && std::env::var_os("BLESS").is_some() {
        fs::write(root.join(copy), &wanted).expect("the file can be written");
    }
    assert!(found == wanted, "{copy} is not {original}; BLESS=1 copies it");
}
