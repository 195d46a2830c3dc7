//! The HELP text, generated from the verb table.

use super::suggest::nearest_verb;
use super::verb::{Group, Reach, Verb};
use fbptr_core::error::{Code, Fault};
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

/// Returns the reply to `HELP verb`: the verb's forms, what of `TARGET` and `CLIP` it obeys, and an
/// example, whose payload follows on lines of its own. Bytes that are no text are written as `\xNN`.
/// The name may be in either case.
///
/// # Errors
/// `EVERB` if there is no such verb, with the nearest one.
pub fn help_on(name: &str) -> Result<String, Fault> {
    let Some(verb) = Verb::named(&name.to_ascii_uppercase()) else {
        let near = nearest_verb(name).map_or(String::new(), |near| format!(" (did you mean {near}?)"));
        return Err(Fault::new(Code::Verb, format!("no verb has this name{near}")).got(name));
    };
    let forms = verb.forms.iter().map(|form| format!("{}: {}\n", form.syntax, form.about));
    let reach = match verb.reach {
        Reach::Connection => "",
        Reach::Target => "It obeys TARGET.\n",
        Reach::Clip => "It obeys TARGET and CLIP.\n",
    };
    let is_plain = verb.example.chars().all(|c| c == '\n' || (' '..='~').contains(&c));
    let example = match is_plain {
        true => verb.example.to_owned(),
        false => verb.example.as_bytes().escape_ascii().to_string(),
    };
    Ok(format!("{}{reach}Example:\n{example}\n", forms.collect::<String>()))
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
    fn every_verb_is_described_with_an_example() {
        for verb in Verb::all() {
            let text = help_on(&verb.name.to_lowercase()).unwrap();
            assert!(text.is_ascii() && text.starts_with(verb.name) && text.ends_with('\n'), "{text}");
            let (_, example) = text.split_once("\nExample:\n").unwrap();
            assert!(example.starts_with(verb.name), "{text}");
        }
        assert!(help_on("fill").unwrap().contains("It obeys TARGET and CLIP.\nExample:\nFILL 8.5"));
        let refused = help_on("LIEN").unwrap_err();
        assert_eq!(
            (refused.code, refused.message.as_str()),
            (Code::Verb, "no verb has this name (did you mean LINE?)")
        );
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
