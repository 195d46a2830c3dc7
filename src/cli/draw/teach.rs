//! What the prompt says beside the answers: help by topic, and hints after a command that was
//! refused or may not mean what it says.
//!
//! In: the words of a typed line and the answers to it. Out: text. The verbs and forms are those of
//! the table; the only lists here are words that stand for a verb in other languages and programs.

use super::line::OWN_WORDS;
use crate::command::{Group, Verb, color_names, help_on, nearest};
use std::fmt::Write;

/// Topics of `help`, and the groups of verbs that they show.
const TOPICS: [(&str, Group); 5] = [
    ("pixels", Group::Pixelflut),
    ("memory", Group::Memory),
    ("2-D", Group::TwoD),
    ("3-D", Group::ThreeD),
    ("control", Group::Control),
];

/// Words of other programs, and what they are called here.
const MEANINGS: [(&[&str], &str); 20] = [
    (&["rectangle", "square", "bar"], "FILLRECT x y w h c fills a rectangle, RECT draws its outline"),
    (&["disc", "disk", "dot", "filledcircle"], "FILLCIRCLE cx cy r c fills a disc, CIRCLE draws its outline"),
    (&["pixel", "point", "plot", "putpixel", "set", "pset"], "PX x y colour sets a pixel"),
    (&["triangle"], "FILL x0 y0 x1 y1 x2 y2 c fills a triangle, in one colour or three"),
    (&["polygon", "polyline"], "FILLPOLY fills a polygon, POLY draws its outline"),
    (&["oval", "ellipsoid"], "ELLIPSE cx cy rx ry c draws an ellipse"),
    (&["write", "label", "string", "say"], "PRINT x y colour words writes a line of text"),
    (&["background", "erase", "cls", "fillscreen", "bg"], "CLEAR colour fills the frame"),
    (&["stroke", "segment", "lineto"], "LINE x0 y0 x1 y1 c draws a line"),
    (&["thick", "width", "linewidth"], "WIDELINE x0 y0 x1 y1 width c draws a thick line"),
    (&["picture", "sprite", "drawimage"], "TEX name < FILE reads a picture, STAMP or BLIT draws one"),
    (&["cube"], "MESH name BOX makes a cube, DRAW name draws it"),
    (&["ball"], "MESH name SPHERE makes a ball, DRAW name draws it"),
    (
        &["teapot", "model", "obj", "object"],
        "MESH name TEAPOT, or MESH name OBJ < FILE, makes a mesh; DRAW name draws it",
    ),
    (&["move", "shift"], "TRANSLATE x y z moves what is drawn next"),
    (&["camera", "eyeat", "view"], "LOOKAT ex ey ez rx ry rz ux uy uz places the eye"),
    (&["lamp", "sun"], "LIGHT 0 DIR dx dy dz colour, or LIGHT 0 POINT x y z colour, gives light"),
    (&["color", "colour", "setcolor"], "colours stand at the end of each command; `help colour` tells how"),
    (&["sleep", "delay"], "WAIT seconds waits"),
    (
        &["open", "import"],
        "commands of a file: `fbptr draw FILE`; a payload: MESH pot OBJ < FILE, TEX t < FILE",
    ),
];

const COLORS: &str = "A colour is one of
  a CSS name     red, gold, navy, tomato, rebeccapurple ... (148)
  #rgb           #f80 is #ff8800
  rrggbb         ff8800, with or without #
  rrggbbaa       ff880080: half transparent after BLEND over
  gg             80: grey
Where two or three colours may stand, a ramp runs between them: LINE 0 0 639 479 red gold
Colours of light (MATERIAL, LIGHT, AMBIENT) are names, #rrggbb, or three numbers from 0 to 1.
";

/// Returns the answer to `help` alone: the prompt's own words and the topics.
pub(super) fn overview() -> String {
    let mut text = String::from("The prompt's own words:\n");
    for (form, about) in OWN_WORDS {
        let _ = writeln!(text, "  {form:<14}{about}");
    }
    text += "Commands by topic, each explained by `help VERB`:\n";
    for (topic, group) in TOPICS {
        let names: Vec<&str> = Verb::all().iter().filter(|v| v.group == group).map(|v| v.name).collect();
        let _ = write!(text, "  help {topic:<9}");
        let mut column = 16;
        for name in names {
            if column + name.len() > 78 {
                text += "\n                ";
                column = 16;
            }
            text += name;
            text.push(' ');
            column += name.len() + 1;
        }
        text.push('\n');
    }
    text + "  help colour   how colours are written\n  help all      every form of every command\n\
            A command whose payload is a file ends in < FILE: TEX stone < stone.png\n"
}

/// Returns the answer to `help WORD`: a topic, a verb or one of the prompt's own words.
///
/// # Errors
/// A message with the nearest verb, or with what the word is called here.
pub(super) fn on(word: &str) -> Result<String, String> {
    let is = |name: &str| name.eq_ignore_ascii_case(word);
    if is("all") {
        return Ok(crate::command::help_text());
    }
    if ["colour", "color", "colours", "colors"].into_iter().any(is) {
        return Ok(COLORS.to_owned());
    }
    let plain = |text: &str| text.replace('-', "");
    if let Some((_, group)) = TOPICS.iter().find(|(topic, _)| is(topic) || is(&plain(topic))) {
        let forms = Verb::all().iter().filter(|v| v.group == *group).flat_map(|v| v.forms);
        return Ok(forms.map(|form| format!("{}: {}\n", form.syntax, form.about)).collect());
    }
    let own = OWN_WORDS.iter().find(|(form, _)| form.split(' ').next().is_some_and(is));
    if let Some((form, about)) = own {
        return Ok(format!("{form}: {about}\n"));
    }
    help_on(word).map_err(|fault| match meaning(word) {
        Some(meaning) => meaning.to_owned(),
        None => format!("{}; help lists topics and verbs", fault.message),
    })
}

/// Returns what a word of other programs is called here.
fn meaning(word: &str) -> Option<&'static str> {
    MEANINGS.iter().find(|(words, _)| words.iter().any(|w| w.eq_ignore_ascii_case(word))).map(|(_, say)| *say)
}

/// Returns a hint about a command that was refused with these answers.
pub(super) fn after_refusal(words: &str, answers: &str) -> Option<String> {
    let mut parts = words.split_whitespace();
    let verb = parts.next()?;
    if answers.contains("EVERB") {
        return meaning(verb).map(str::to_owned);
    }
    if answers.contains("ECOLOUR") {
        let wrong = answers.rsplit("got \"").next()?.trim_end().trim_end_matches('"');
        return nearest(wrong, color_names())
            .map(|name| format!("did you mean {name}? `help colour` tells more"));
    }
    let rest: Vec<&str> = parts.collect();
    match verb.to_ascii_uppercase().as_str() {
        "TEXT" if rest.len() > 3 && !rest.iter().any(|word| word.starts_with(':')) => {
            Some(format!("PRINT {} writes a line without a count", rest.join(" ")))
        }
        "LOAD" => Some(
            "here files are payloads: MESH name OBJ < FILE, TEX name < FILE, SCENE < FILE, EYE name < FILE"
                .to_owned(),
        ),
        _ => None,
    }
}

/// Returns a hint about a command that was run but may not mean what it says.
pub(super) fn after_success(words: &str) -> Option<String> {
    let parts: Vec<&str> = words.split_whitespace().collect();
    let [verb, .., angle] = parts[..] else { return None };
    let angle: f64 = angle.parse().ok()?;
    (verb.eq_ignore_ascii_case("ROTATE") && angle.abs() > std::f64::consts::TAU)
        .then(|| format!("degrees? The angle is in radians; {angle}deg is in degrees"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_verb_has_a_topic_and_every_topic_a_page() {
        let overview = overview();
        for verb in Verb::all() {
            assert!(overview.contains(verb.name), "{}", verb.name);
        }
        assert!(
            overview.lines().count() <= 40 && overview.lines().all(|line| line.len() <= 80),
            "{overview}"
        );
        for (topic, group) in TOPICS {
            let page = on(topic).expect("a topic");
            let verb = Verb::all().iter().find(|v| v.group == group).expect("a verb");
            assert!(page.contains(verb.forms[0].syntax), "{page}");
        }
        assert_eq!(on("3d"), on("3-D"));
        assert!(on("color").is_ok_and(|text| text.contains("rebeccapurple")));
    }

    #[test]
    fn meanings_name_verbs_that_there_are_and_no_verb_is_one() {
        for (words, say) in MEANINGS {
            let verbs = say
                .split(|c: char| !c.is_ascii_alphanumeric())
                .filter(|w| w.len() > 1 && w.bytes().all(|b| b.is_ascii_uppercase()));
            for verb in verbs
                .filter(|w| !["BOX", "SPHERE", "TEAPOT", "OBJ", "FILE", "VERB", "DIR", "POINT"].contains(w))
            {
                assert!(Verb::find(verb.as_bytes()).is_some(), "{verb}");
            }
            for word in words {
                assert!(Verb::find(word.as_bytes()).is_none(), "{word}");
            }
        }
    }

    #[test]
    fn slips_are_answered_with_what_was_meant() {
        let color = "ECOLOUR LINE: argument 5 must be a colour, got \"orenge\"";
        assert!(after_refusal("LINE 0 0 9 9 orenge", color).is_some_and(|say| say.contains("orange")));
        assert!(after_refusal("rectangle 1 2", "EVERB").is_some_and(|say| say.contains("FILLRECT")));
        let text = after_refusal("TEXT 1 2 red hi you", "EARGS TEXT: takes 3 arguments");
        assert_eq!(text.as_deref(), Some("PRINT 1 2 red hi you writes a line without a count"));
        assert!(after_refusal("LOAD MESH a b.obj", "EPERM").is_some_and(|say| say.contains("< FILE")));
        assert_eq!(after_refusal("LINE 0 0", "EARGS"), None);
        assert!(after_success("ROTATE 0 1 0 45").is_some_and(|say| say.contains("45deg")));
        assert_eq!(after_success("ROTATE 0 1 0 45deg"), None);
        assert_eq!(after_success("ROTATE 0 1 0 3.1"), None);
        assert!(on("triangle").is_err_and(|say| say.contains("FILL ")));
    }
}
