//! Verifies that the protocol page lists every verb as the verb table does, and every error code.

use crate::generated::check_block;
use fbptr::command::{Group, Reach, Verb};
use fbptr::error::Code;
use std::fmt::Write;
use std::fs;
use std::path::Path;

const PAGE: &str = "docs/protocol.md";
const MARKS: [&str; 2] = [
    "<!-- Made from the verb table: BLESS=1 cargo test --test decoder page -->\n",
    "<!-- The end of what is made from the verb table -->\n",
];

/// Returns the tables of the page: a form of a verb in each row.
fn tables() -> String {
    let mut text = String::new();
    for group in Group::ALL {
        let head = "| form | effect | `TARGET` | `CLIP` |\n|---|---|---|---|";
        write!(text, "\n### {}\n\n{head}\n", group.title()).expect("a String takes all");
        let verbs = Verb::all().iter().filter(|v| v.group == group);
        for (verb, form) in verbs.flat_map(|v| v.forms.iter().map(move |form| (v, form))) {
            let [syntax, about] = [form.syntax, form.about].map(|cell| cell.replace('|', "\\|"));
            let obeys = match verb.reach {
                Reach::Connection => "- | -",
                Reach::Target => "obeys | -",
                Reach::Clip => "obeys | obeys",
            };
            writeln!(text, "| `{syntax}` | {about} | {obeys} |").expect("a String takes all");
        }
    }
    text.push('\n');
    text
}

#[test]
fn the_page_lists_the_verbs_as_the_table_does() {
    check_block(PAGE, MARKS, &tables());
}

#[test]
fn every_code_stands_in_the_page() {
    use Code::*;
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(PAGE);
    let page = fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    for code in [Verb, Args, Num, Colour, Range, NoEnt, TooBig, Format, Proto, Perm, Quota] {
        assert!(page.contains(&format!("`{code}`")), "the page lacks {code}");
    }
}
