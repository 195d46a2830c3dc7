//! Verifies that the fuzzer's dictionary contains every verb and keyword of the verb table.

use fbptr::command::Verb;
use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

/// Bytes of the framing that a fuzzer should not have to find by chance.
const FRAMING: [&str; 14] = [
    " ",
    "\n",
    "\r\n",
    "\t",
    "#",
    ":",
    ":0",
    ":8",
    ":4097",
    ":18446744073709551616",
    "PB\u{1}\0\u{2}\0rgba",
    "PXMULTI\0\0\0\0\u{1}\0\0\0",
    "PX 1 2 a1b2c3\n",
    "PX 12 345 80\r\n",
];
const WORDS: [&str; 11] = [
    "a1b2c3",
    "#a1b2c3",
    "A1B2C3D4",
    "7f",
    "tomato",
    "transparent",
    "-2147483648",
    "2147483648",
    "1e999",
    "-.5e-3",
    "nan",
];

fn dictionary() -> String {
    let mut entries: BTreeSet<String> = FRAMING.iter().chain(&WORDS).map(|w| w.to_string()).collect();
    for verb in Verb::all() {
        entries.insert(verb.name.to_owned());
        for word in verb.forms.iter().flat_map(|f| f.syntax.split([' ', '[', ']', '|'])) {
            // Keywords are the words in upper case, and both sides of a choice.
            let is_choice = verb.forms.iter().any(|f| {
                f.syntax.split([' ', '[', ']']).any(|w| w.contains('|') && w.split('|').any(|c| c == word))
            });
            let is_upper = word.len() > 1 && word.bytes().all(|b| b.is_ascii_uppercase());
            if is_choice || is_upper || ["exact", "max-error", "wait"].contains(&word) {
                entries.insert(word.to_owned());
            }
        }
    }
    let mut text = String::from("# Made from the verb table: BLESS=1 cargo test --test decoder dictionary\n");
    for entry in entries {
        text.push('"');
        for byte in entry.bytes() {
            match byte {
                b'"' | b'\\' => text += &format!("\\{}", byte as char),
                b' '..=b'~' => text.push(byte as char),
                byte => text += &format!("\\x{byte:02X}"),
            }
        }
        text.push_str("\"\n");
    }
    text
}

#[test]
fn the_dictionary_is_that_of_the_table() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz/verbs.dict");
    let wanted = dictionary();
    let found = fs::read_to_string(&path).unwrap_or_default();
    if found != wanted && std::env::var_os("BLESS").is_some() {
        fs::write(&path, &wanted).expect("the dictionary can be written");
    }
    assert!(found == wanted, "{} is not what the table says; BLESS=1 rewrites it", path.display());
    assert!(wanted.lines().count() > Verb::all().len() + 40);
}
