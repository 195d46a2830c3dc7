//! Verifies that the protocol page lists every verb and every error code.

use fbptr::command::Verb;
use fbptr::error::Code;
use std::fs;
use std::path::Path;

fn page() -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/protocol.md");
    fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

#[test]
fn every_form_of_every_verb_stands_in_the_page() {
    let page = page();
    for form in Verb::all().iter().flat_map(|v| v.forms) {
        assert!(
            page.contains(&format!("`{}`", form.syntax.replace('|', "\\|"))),
            "the page lacks `{}`",
            form.syntax
        );
    }
}

#[test]
fn every_code_stands_in_the_page() {
    use Code::*;
    let page = page();
    for code in [Verb, Args, Num, Colour, Range, NoEnt, TooBig, Format, Proto, Perm, Quota] {
        assert!(page.contains(&format!("`{code}`")), "the page lacks {code}");
    }
}
