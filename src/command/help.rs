//! The HELP text, generated from the verb table.

use super::verb::{Group, Verb};
use std::fmt::Write;

/// Returns the reply to `HELP`: one line `template: description` per form of a verb, each ended by
/// LF.
///
/// Pixelflut's own verbs come first and without a heading: clients look for lines that begin with
/// `PX x y gg` and `OFFSET` and for one that contains `PBxxyyrgba`, some in the first kilobyte
/// only.
pub fn help_text() -> String {
    let mut text = String::from("fbptr: a Pixelflut server, and more. Commands:\n");
    for group in Group::ALL {
        if group != Group::Pixelflut {
            writeln!(text, "{}:", group.title()).expect("a String takes all text");
        }
        for form in Verb::all().iter().filter(|v| v.group == group).flat_map(|v| v.forms) {
            writeln!(text, "{}: {}", form.syntax, form.about).expect("a String takes all text");
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pixelflut_clients_find_what_they_look_for_at_once() {
        let text = help_text();
        let start: Vec<&str> = text[..1024].lines().collect();
        assert!(start.iter().any(|l| l.starts_with("PX x y gg")));
        assert!(start.iter().any(|l| l.starts_with("OFFSET")));
        assert!(start.iter().any(|l| l.contains("PBxxyyrgba")));
    }

    #[test]
    fn every_verb_has_its_lines() {
        let text = help_text();
        for verb in Verb::all() {
            assert!(text.lines().any(|l| l.starts_with(verb.name)), "{}", verb.name);
        }
        assert!(text.is_ascii() && text.ends_with('\n'));
        assert!(text.lines().all(|l| !l.is_empty() && l.len() < 160));
    }
}
