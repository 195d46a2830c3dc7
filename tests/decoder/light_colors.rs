//! Verifies that one word, a CSS name or `#rrggbb`, may stand for the three reals of a light's
//! colour.

use crate::recorder::{Event, hear};
use fbptr::command::{Command, encode};
use glam::DVec3;
use proptest::prelude::*;

fn read(line: &str) -> Command {
    match &hear(format!("{line}\n").as_bytes())[..] {
        [Event::Command(command, _)] => command.clone(),
        other => panic!("{line}: {other:?}"),
    }
}

#[test]
fn a_word_is_the_three_reals_that_it_names() {
    for (words, reals) in [
        ("AMBIENT Yellow", "AMBIENT 1 1 0"),
        ("AMBIENT #0033ff", "AMBIENT 0 .2 1"),
        ("AMBIENT #33", "AMBIENT .2 .2 .2"),
        ("LIGHT 0 POINT 1 2 3 red", "LIGHT 0 POINT 1 2 3 1 0 0"),
        ("light 0 point 1 2 3 #0000FF 7 8 9", "LIGHT 0 POINT 1 2 3 0 0 1 7 8 9"),
        ("LIGHT 2 DIR 1 2 3 white", "LIGHT 2 DIR 1 2 3 1 1 1"),
        ("LIGHT 3 SPOT 1 2 3 4 5 6 .5 8 lime", "LIGHT 3 SPOT 1 2 3 4 5 6 .5 8 0 1 0"),
        ("LIGHT 3 SPOT 1 2 3 4 5 6 .5 8 lime 1 2 3", "LIGHT 3 SPOT 1 2 3 4 5 6 .5 8 0 1 0 1 2 3"),
        ("MATERIAL red lime blue 10", "MATERIAL 1 0 0 0 1 0 0 0 1 10"),
        ("MATERIAL .1 .2 .3 lime .4 .5 .6 10", "MATERIAL .1 .2 .3 0 1 0 .4 .5 .6 10"),
        ("MATERIAL red 1 1 1 blue 10 .1 .2 .3", "MATERIAL 1 0 0 1 1 1 0 0 1 10 .1 .2 .3"),
        ("MATERIAL 0 0 0 lime 1 1 1 10 cyan", "MATERIAL 0 0 0 0 1 0 1 1 1 10 0 1 1"),
        ("MATERIAL red 1 1 1 1 1 1 10 blue .5", "MATERIAL 1 0 0 1 1 1 1 1 1 10 0 0 1 .5"),
        ("MATERIAL red red red 10 black .5", "MATERIAL 1 0 0 1 0 0 1 0 0 10 0 0 0 .5"),
    ] {
        let command = read(words);
        assert_eq!(command, read(reals), "{words}");
        let mut bytes = Vec::new();
        encode(&command, &mut bytes).expect("it was read");
        assert_eq!(read(std::str::from_utf8(&bytes).expect("text").trim_end()), command, "{words}");
    }
}

#[test]
fn what_is_no_colour_of_light_is_refused_with_its_word() {
    for (text, code, token) in [
        ("AMBIENT reddish", "ECOLOUR", "reddish"),
        ("AMBIENT #12345", "ECOLOUR", "#12345"),
        ("AMBIENT #ff000080", "ECOLOUR", "#ff000080"),
        ("AMBIENT transparent", "ECOLOUR", "transparent"),
        ("AMBIENT nan", "ECOLOUR", "nan"),
        ("AMBIENT ff0000", "ECOLOUR", "ff0000"),
        ("AMBIENT 80", "EARGS", "80"),
        ("AMBIENT", "EARGS", "AMBIENT"),
        ("AMBIENT red 1", "EARGS", "1"),
        ("AMBIENT red lime blue", "ENUM", "red"),
        ("AMBIENT 1 x 1", "ENUM", "x"),
        ("AMBIENT 1 1 1 1", "EARGS", "1"),
        ("LIGHT 1 DIR 1 2 red", "EARGS", "red"),
        ("LIGHT 1 DIR red 1 2 3", "ENUM", "red"),
        ("LIGHT 1 DIR 1 2 3 reddish", "ECOLOUR", "reddish"),
        ("LIGHT 1 POINT 1 2 3 red blue", "ENUM", "blue"),
        ("LIGHT 1 POINT 1 2 3 red 1", "EARGS", "1"),
        ("LIGHT 1 SPOT 1 2 3 4 5 6 red 8 9", "ENUM", "red"),
        ("LIGHT 1 OFF red", "EARGS", "red"),
        ("MATERIAL", "EARGS", "MATERIAL"),
        ("MATERIAL red", "EARGS", "red"),
        ("MATERIAL red red red red", "EARGS", "red"),
        ("MATERIAL red red red 5 red red", "EARGS", "red"),
        ("MATERIAL red red reddish 5", "ECOLOUR", "reddish"),
        // As many words as the numbers would be.
        ("MATERIAL .1 a .1 .5 b .5 0 0 0 10", "ENUM", "a"),
        ("MATERIAL .1 .1 .1 .5 .5 .5 0 0 x y", "ENUM", "x"),
        ("MATERIAL 1 1 red red 5 6", "ENUM", "red"),
    ] {
        let heard = hear(format!("{text}\nSYNC after\n").as_bytes());
        let [Event::Error(error), Event::Command(Command::Sync { .. }, _)] = &heard[..] else {
            panic!("{text}: {heard:?}")
        };
        let found = (error.code.as_str(), String::from_utf8_lossy(&error.token).into_owned());
        assert_eq!(found, (code, token.to_owned()), "{text}: {}", error.message);
    }
    let heard = hear(b"AMBIENT reddish\n");
    let [Event::Error(error)] = &heard[..] else { panic!("{heard:?}") };
    assert_eq!(
        error.message,
        "argument 1 must be a colour of light: three reals, a CSS colour name, or gg or rrggbb in hex after #"
    );
}

proptest! {
    #[test]
    fn hex_is_each_byte_over_255(rgb: [u8; 3]) {
        let [r, g, b] = rgb;
        let wanted = DVec3::from_array(rgb.map(|c| f64::from(c) / 255.0));
        prop_assert_eq!(read(&format!("AMBIENT #{r:02x}{g:02X}{b:02x}")), Command::Ambient(wanted));
    }
}
