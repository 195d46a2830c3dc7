//! Lines of every verb, made from the kinds of its parameters in the verb table: they are read,
//! written and read again, and one word too many or too few is refused. A new verb needs no test of
//! its own for this.

use crate::recorder::{Event, hear};
use fbptr::command::{Command, Encoding, Parameter, ParameterKind, Payload, Verb, encode};
use proptest::prelude::*;

/// Verbs whose arguments depend on each other in ways that the kinds of parameters do not say.
const DEPENDENT: [&str; 3] = [
    // Few reals are between 0 and 60.
    "WAIT", // The payload's length is that of the rectangle.
    "BLIT", // Whether a colour is given decides about the command, which is a pixel to the sink.
    "PX",
];

/// Most words of a parameter without a limit.
const MOST_WORDS: usize = 12;

/// Returns the text verbs whose lines the table describes in full.
pub fn described() -> impl Iterator<Item = &'static Verb> {
    let is_described = |verb: &&Verb| {
        verb.encoding == Encoding::Text
            && verb.payload != Payload::BySubject
            && !DEPENDENT.contains(&verb.name)
            && verb.parameters.iter().all(|p| p.kind != ParameterKind::Words)
    };
    Verb::all().iter().filter(is_described)
}

/// Returns valid words of a kind, none for a payload.
fn word(kind: ParameterKind) -> BoxedStrategy<String> {
    match kind {
        ParameterKind::Integer => (0..=i32::MAX).prop_map(|n| n.to_string()).boxed(),
        ParameterKind::Real => any::<u64>()
            .prop_map(|bits| f64::from_bits(bits & !(1 << 63)))
            .prop_filter("finite", |n| n.is_finite())
            .prop_map(|n| format!("{n:?}"))
            .boxed(),
        ParameterKind::Angle => (word(ParameterKind::Real), any::<bool>())
            .prop_map(|(number, is_in_degrees)| format!("{number}{}", if is_in_degrees { "deg" } else { "" }))
            .boxed(),
        ParameterKind::Color => {
            prop::sample::select(vec!["ff8000", "01020304", "7F", "tomato", "#ff8000", "#f80", "#f80c"])
                .prop_map(str::to_owned)
                .boxed()
        }
        ParameterKind::Name => "[@a-zA-Z0-9._/-]{1,20}".boxed(),
        ParameterKind::Keyword(list) => prop::sample::select(list).prop_map(str::to_owned).boxed(),
        ParameterKind::Flag(word) => Just(word.to_owned()).boxed(),
        ParameterKind::Hex => "([0-9a-f]{2}){1,20}".boxed(),
        ParameterKind::RestOfLine => "[!-~é]([ -~]{0,20}| :5)".boxed(),
        ParameterKind::Payload | ParameterKind::Words => Just(String::new()).boxed(),
    }
}

/// Returns the words of a parameter, with a blank before each.
fn words(parameter: &'static Parameter) -> BoxedStrategy<String> {
    if parameter.kind == ParameterKind::Payload {
        // A payload's keyword stands in its syntax.
        let keyword = parameter.syntax.strip_suffix(":N").unwrap_or("").trim_end();
        return Just(if keyword.is_empty() { String::new() } else { format!(" {keyword}") }).boxed();
    }
    if parameter.kind == ParameterKind::RestOfLine {
        return word(parameter.kind).prop_map(|text| format!(" {text}")).boxed();
    }
    let least = parameter.arity.least();
    let most = parameter.arity.most().unwrap_or(MOST_WORDS);
    let counts: Vec<usize> = (least..=most)
        .filter(|n| parameter.arity.allows(*n))
        // Points are pairs.
        .filter(|n| parameter.arity.most().is_some() || n.is_multiple_of(2))
        .collect();
    prop::sample::select(counts)
        .prop_flat_map(|count| prop::collection::vec(word(parameter.kind), count))
        .prop_map(|words| words.iter().map(|word| format!(" {word}")).collect())
        .boxed()
}

/// Returns a line of a verb and its payload, whose length every kind of payload takes.
fn line(verb: &'static Verb) -> BoxedStrategy<Vec<u8>> {
    let parameters: Vec<_> = verb.parameters.iter().map(words).collect();
    let payload = (0..4usize).prop_map(|records| "eight by".repeat(records));
    (parameters, payload)
        .prop_map(|(words, payload)| {
            let head = format!("{}{}", verb.name, words.concat());
            match verb.payload {
                Payload::Never => format!("{head}\n").into_bytes(),
                _ => format!("{head} :{}\n{payload}", payload.len()).into_bytes(),
            }
        })
        .boxed()
}

/// Returns the only command of a stream.
fn heard_once(bytes: &[u8]) -> Result<Command, TestCaseError> {
    match &hear(bytes)[..] {
        [Event::Command(command, _)] => Ok(command.clone()),
        other => Err(TestCaseError::fail(format!("{}: {other:?}", bytes.escape_ascii()))),
    }
}

/// Returns a line of any verb that the table describes in full, and that verb.
fn any_line() -> BoxedStrategy<(&'static Verb, Vec<u8>)> {
    let verbs: Vec<&'static Verb> = described().collect();
    prop::sample::select(verbs).prop_flat_map(|verb| (Just(verb), line(verb))).boxed()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(4000))]

    #[test]
    fn every_described_line_is_read_and_written((verb, line) in any_line()) {
        let command = heard_once(&line)?;
        prop_assert_eq!(command.verb(), verb.name);
        let mut bytes = Vec::new();
        encode(&command, &mut bytes).map_err(|e| TestCaseError::fail(e.to_string()))?;
        let again = heard_once(&bytes)?;
        prop_assert_eq!(format!("{command:?}"), format!("{again:?}"));
    }
}

#[test]
fn most_verbs_are_described_in_full() {
    let others: Vec<&str> =
        Verb::all().iter().filter(|v| !described().any(|d| d == *v)).map(|v| v.name).collect();
    let expected = [
        "PX", "PB", "PXMULTI", "BLIT", "CLIP", "MESH", "LOAD", "AMBIENT", "LIGHT", "MATERIAL", "TEXTURE",
        "QUALITY", "WAIT",
    ];
    assert_eq!(others, expected, "their tests are in `roundtrip`");
}

#[test]
fn a_word_too_many_and_too_few_are_refused() {
    for verb in Verb::all().iter().filter(|v| v.encoding == Encoding::Text) {
        let least = verb.arity.least();
        let too_few = (least > 0).then(|| least - 1);
        for count in too_few.into_iter().chain(verb.arity.most().map(|most| most + 1)) {
            let words: Vec<String> = (0..count).map(|n| format!("w{n}")).collect();
            let blamed = words.last().map_or(verb.name, String::as_str);
            let line = format!("{} {}\n", verb.name, words.join(" "));
            let [Event::Error(error)] = &hear(line.as_bytes())[..] else { panic!("{line} is not refused") };
            assert_eq!((error.code.as_str(), error.token.as_slice()), ("EARGS", blamed.as_bytes()), "{line}");
            assert!(error.message.contains(verb.forms[0].syntax), "{line}: {}", error.message);
        }
    }
}

#[test]
fn choices_in_a_syntax_are_the_keywords_that_are_read() {
    let mut count = 0;
    for verb in Verb::all() {
        for parameter in verb.parameters {
            let ParameterKind::Keyword(list) = parameter.kind else { continue };
            let syntax = parameter.syntax.trim_matches(['[', ']']);
            // `LOAD` lists its kinds in two forms.
            if verb.name != "LOAD" {
                assert_eq!(syntax.split('|').collect::<Vec<_>>(), list, "{}", verb.name);
                count += 1;
            }
        }
    }
    assert!(count >= 8, "{count}");
}
