//! Valid and invalid forms of every verb, as tables.

use crate::recorder::{Event, hear};
use crate::valid_forms::valid_forms;
use fbptr::command::{Encoding, Payload, Verb, encode};

const RED: [u8; 4] = [255, 0, 0, 255];

/// Invalid commands, each with its error code and the token that the error names.
const BAD: &[(&str, &str, &str)] = &[
    ("NONSENSE", "EVERB", "NONSENSE"),
    ("PXX 1 2 ff", "EVERB", "PXX"),
    ("HELP me now", "EARGS", "now"),
    ("SIZE 1", "EARGS", "1"),
    ("PX", "EARGS", "PX"),
    ("PX 1", "EARGS", "1"),
    ("PX 1 2 ff x", "EARGS", "x"),
    ("PX 1.0 2 ff", "ENUM", "1.0"),
    ("PX 1 2147483648 ff", "ENUM", "2147483648"),
    ("PX 1e1 2 ff", "ENUM", "1e1"),
    ("PX -- 2 ff", "ENUM", "--"),
    ("PX 1 2 0", "ECOLOUR", "0"),
    ("PX 1 2 fff", "ECOLOUR", "fff"),
    ("PX 1 2 ff00zz", "ECOLOUR", "ff00zz"),
    ("PX 1 2 #ff000", "ECOLOUR", "#ff000"),
    ("PX 1 2 bluish", "ECOLOUR", "bluish"),
    ("PX 1 2 :3\nabc", "EARGS", ":3"),
    ("OFFSET 1", "EARGS", "1"),
    ("OFFSET 1 x", "ENUM", "x"),
    ("STATS x", "EARGS", "x"),
    ("QUIT now", "EARGS", "now"),
    ("POKE 0", "EARGS", "0"),
    ("POKE x 00", "ENUM", "x"),
    ("POKE 0 000", "EFORMAT", "000"),
    ("POKE 0 0g", "EFORMAT", "0g"),
    ("POKE 4294967296 00", "ENUM", "4294967296"),
    ("PEEK 0", "EARGS", "0"),
    ("PEEK 0 -1", "ERANGE", "-1"),
    ("BLIT 0 0 1 1", "EARGS", "1"),
    ("BLIT 0 0 1 1 :5\n12345", "EFORMAT", ":5"),
    ("BLIT 0 0 1 1 :0\n", "EFORMAT", ":0"),
    ("BLIT 0 0 2147483647 2147483647 :4\nabcd", "EFORMAT", ":4"),
    ("BLIT 0 0 -1 1 :4\nabcd", "ERANGE", "-1"),
    ("BLIT 0 0 1 -1 :4\nabcd", "ERANGE", "-1"),
    ("READ 0 0 1", "EARGS", "1"),
    ("READ 0 0 -1 1", "ERANGE", "-1"),
    ("COPY 0 0 1 1 0", "EARGS", "0"),
    ("COPY 0 0 1 -5 0 0", "ERANGE", "-5"),
    ("POINTS", "EARGS", "POINTS"),
    ("POINTS :9\n123456789", "EFORMAT", ":9"),
    ("CRC 1", "EARGS", "1"),
    ("CRC 0 0 1 1 1", "EARGS", "1"),
    ("CRC 0 0 -1 1", "ERANGE", "-1"),
    ("CLEAR red blue", "EARGS", "blue"),
    ("CLEAR 0", "ECOLOUR", "0"),
    ("LINE 1 2 3 4", "EARGS", "4"),
    ("LINE 1 2 3 4 red red red", "EARGS", "red"),
    ("LINE 1 2 3 4.5 red", "ENUM", "4.5"),
    ("LINE 1 2 3 4 red read", "ECOLOUR", "read"),
    ("TRI 1 2 3 4 5 6 red red", "EARGS", "red"),
    ("TRI 1 2 3 4 5 x red", "ENUM", "x"),
    ("FILL 1 2 3 4 5 nan red", "ENUM", "nan"),
    ("FILL 1 2 3 4 5 1e999 red", "ENUM", "1e999"),
    ("FILL 1 2 3 4 5 6 red red x", "ECOLOUR", "x"),
    ("RECT 1 2 -3 4 red", "ERANGE", "-3"),
    ("RECT 1 2 3 4", "EARGS", "4"),
    ("FILLRECT 1 2 3 -4 red", "ERANGE", "-4"),
    ("FILLRECT 1 2 3 4 5", "ECOLOUR", "5"),
    ("CIRCLE 1 2 -3 red", "ERANGE", "-3"),
    ("CIRCLE 1 2 3.5 red", "ENUM", "3.5"),
    ("FILLCIRCLE 1 2 -.5 red", "ERANGE", "-0.5"),
    ("FILLCIRCLE 1 2 inf red", "ENUM", "inf"),
    ("POLY red", "EARGS", "red"),
    ("POLY red 1", "EARGS", "1"),
    ("POLY red 1 2 3", "EARGS", "3"),
    ("POLY 1 2 3", "ECOLOUR", "1"),
    ("POLY red 1 2 3 4.0", "ENUM", "4.0"),
    ("FILLPOLY red 1 2 3", "EARGS", "3"),
    ("FILLPOLY red 1 x", "ENUM", "x"),
    ("TEXT 1 2 red", "EARGS", "red"),
    ("TEXT 1 2 :2\nab", "EARGS", "2"),
    ("TEXT 1 2 red :2\na\u{e9}", "EFORMAT", "c3"),
    ("LINEAA 1 2 3 4 red red", "EARGS", "red"),
    ("PRINT 1 2 red", "EARGS", "red"),
    ("PRINT 1 2 reddish text", "ECOLOUR", "reddish"),
    ("PRINT 1 2 red a\u{7}b", "EFORMAT", "\u{7}"),
    ("WIDELINE 1 2 3 4 -1 red", "ERANGE", "-1"),
    ("WIDELINE 1 2 3 nan 1 red", "ENUM", "nan"),
    ("ELLIPSE 1 2 3 -4 red", "ERANGE", "-4"),
    ("FILLELLIPSE 1 2 -3 4 red", "ERANGE", "-3"),
    ("ARC 1 2 -3 4 0 1 red", "ERANGE", "-3"),
    ("ARC 1 2 3 4 0 1rad red", "ENUM", "1rad"),
    ("BEZIER 1 2 3 4 5 6 7 8 red", "EARGS", "red"),
    ("BEZIER 1 2 3 4 5 6 7 8 -1 red", "ERANGE", "-1"),
    ("SIZE -1 5", "ERANGE", "-1"),
    ("TITLE", "EARGS", "TITLE"),
    ("WAIT -1", "ERANGE", "-1"),
    ("WAIT 60.5", "ERANGE", "60.5"),
    ("WAIT inf", "ENUM", "inf"),
    ("CLIP on", "EARGS", "on"),
    ("CLIP 1 2 3 -4", "ERANGE", "-4"),
    ("CLIP 1 2", "EARGS", "2"),
    ("CANVAS c -1 4", "ERANGE", "-1"),
    ("CANVAS frame 4 4", "EARGS", "frame"),
    ("STAMP FRAME 4 4", "EARGS", "FRAME"),
    ("STAMP c 4 4 reddish", "ECOLOUR", "reddish"),
    ("TEXTSIZE 0", "ERANGE", "0"),
    ("TEXTSIZE 9", "ERANGE", "9"),
    ("IMAGE 1 2", "EARGS", "2"),
    ("ROTATE 0 0 1 45°", "ENUM", "45°"),
    ("LINE 1 2 3 4 #ff00g0", "ECOLOUR", "#ff00g0"),
    ("LINE 1 2 3 4 #ff000", "ECOLOUR", "#ff000"),
    ("LINEAA 1 2 3 e red", "ENUM", "e"),
    ("BLEND under", "EARGS", "under"),
    ("MESH a", "EARGS", "a"),
    ("MESH a PYRAMID", "EARGS", "PYRAMID"),
    ("MESH a OBJ", "EARGS", "OBJ"),
    ("MESH a OBJ x :1\nv", "EARGS", "x"),
    ("MESH a BOX :1\nv", "EARGS", ":1"),
    ("MESH a BOX 1 2", "EARGS", "2"),
    ("MESH a BOX 1 2 3 4", "EARGS", "4"),
    ("MESH a BOX 1 2 -3", "ERANGE", "-3"),
    ("MESH a SPHERE x", "ENUM", "x"),
    ("MESH a SPHERE -1", "ERANGE", "-1"),
    ("MESH a CONE 1", "EARGS", "1"),
    ("MESH a CYLINDER 1 -2", "ERANGE", "-2"),
    ("MESH a TEAPOT 1.5", "ENUM", "1.5"),
    ("MESH a TEAPOT -1", "ERANGE", "-1"),
    ("MESH a KNOT 5", "EARGS", "5"),
    ("MESH a KNOT 5 -5", "ERANGE", "-5"),
    ("MESH :a BOX", "EARGS", ":a"),
    ("TEX t", "EARGS", "t"),
    ("TEX :2\nab", "EARGS", "TEX"),
    ("SCENE VRML :1\nx", "EARGS", "VRML"),
    ("SCENE X3D", "EARGS", "X3D"),
    ("EYE e", "EARGS", "e"),
    ("EYE e\u{7f} :2\n{}", "EARGS", "e\u{7f}"),
    ("FREE", "EARGS", "FREE"),
    ("FREE a b", "EARGS", "b"),
    ("LOAD SOUND a b", "EARGS", "SOUND"),
    ("LOAD MESH a", "EARGS", "a"),
    ("LOAD SCENE a b", "EARGS", "b"),
    ("LOOKAT 1 2 3 4 5 6 7 8", "EARGS", "8"),
    ("LOOKAT 1 2 3 4 5 6 7 8 nan", "ENUM", "nan"),
    ("PERSPECTIVE 1 2", "EARGS", "2"),
    ("PERSPECTIVE 1 2 3 wide", "EARGS", "wide"),
    ("PLANE 1 2 x", "ENUM", "x"),
    ("FRUSTUM 1 2 3 4 5", "EARGS", "5"),
    ("ORTHO 1 2 3 4 5 infinity", "ENUM", "infinity"),
    ("OBLIQUE military 1 2 3 4 5 6 7", "EARGS", "military"),
    ("OBLIQUE cabinet 1 2 3 4 5 6", "EARGS", "6"),
    ("ISOMETRIC 1 2 3 4 5", "EARGS", "5"),
    ("PSEUDOISO 1 2 3 4 5 0x6", "ENUM", "0x6"),
    ("WINDOW 1 2 3", "EARGS", "3"),
    ("WINDOW 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 x", "ENUM", "x"),
    ("VIEWPORT 1 2 3", "EARGS", "3"),
    ("VIEWPORT 1 2 3 -4", "ERANGE", "-4"),
    ("VIEWPORT 1 2 3 4 edges", "EARGS", "edges"),
    ("IDENTITY 1", "EARGS", "1"),
    ("PUSH 1", "EARGS", "1"),
    ("POP 1", "EARGS", "1"),
    ("TRANSLATE 1 2", "EARGS", "2"),
    ("TRANSLATE 1 2 1e400", "ENUM", "1e400"),
    ("ROTATE 1 2 3", "EARGS", "3"),
    ("SCALE 1", "EARGS", "1"),
    ("SHEAR 1 2 3 4 5", "EARGS", "5"),
    ("MATRIX 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15", "EARGS", "15"),
    ("MATRIX 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 -", "ENUM", "-"),
    ("AMBIENT 1 -0.5 0", "ERANGE", "-0.5"),
    ("LIGHT 0 POINT 1 2 3 -1 0 0", "ERANGE", "-1"),
    ("LIGHT 0 DIR 1 2 3 0 0 -100000000", "ERANGE", "-100000000"),
    ("LIGHT 0 SPOT 1 2 3 0 0 -1 1 1 0 -2 0", "ERANGE", "-2"),
    ("AMBIENT 1 1", "EARGS", "1"),
    ("LIGHT 1", "EARGS", "1"),
    ("LIGHT x OFF", "ENUM", "x"),
    ("LIGHT -1 OFF", "ERANGE", "-1"),
    ("LIGHT 1 AREA 1", "EARGS", "AREA"),
    ("LIGHT 1 OFF 1", "EARGS", "1"),
    ("LIGHT 1 POINT 1 2 3 4 5", "EARGS", "5"),
    ("LIGHT 1 POINT 1 2 3 4 5 6 7 8", "EARGS", "8"),
    ("LIGHT 1 DIR 1 2 3 4 5 6 7", "EARGS", "7"),
    ("LIGHT 1 DIR 1 2 3 4 5 x", "ENUM", "x"),
    ("LIGHT 1 SPOT 1 2 3 4 5 6 7 8 9 10", "EARGS", "10"),
    ("MATERIAL 1 2 3 4 5 6 7 8 9", "EARGS", "9"),
    ("MATERIAL 1 2 3 4 5 6 7 8 9 10 11 12", "EARGS", "12"),
    ("MATERIAL 1 2 3 4 5 6 7 8 9 x", "ENUM", "x"),
    ("TEXTURE", "EARGS", "TEXTURE"),
    ("TEXTURE t clamp nearest", "EARGS", "nearest"),
    ("TEXTURE t smooth", "EARGS", "smooth"),
    ("SHADE toon", "EARGS", "toon"),
    ("CULL both", "EARGS", "both"),
    ("HIDE bsp", "EARGS", "bsp"),
    ("DEPTH u8", "EARGS", "u8"),
    ("INTERP linear", "EARGS", "linear"),
    ("DRAW", "EARGS", "DRAW"),
    ("DRAWSCENE x", "ENUM", "x"),
    ("DRAWSCENE 1 x", "EARGS", "x"),
    ("DRAWSCENE SORTED 1", "EARGS", "1"),
    ("DRAWEYE e 1 2 3", "EARGS", "3"),
    ("DRAWEYE e 1 2 -3 4", "ERANGE", "-3"),
    ("QUALITY", "EARGS", "QUALITY"),
    ("QUALITY good", "EARGS", "good"),
    ("QUALITY exact 1", "EARGS", "1"),
    ("QUALITY max-error", "EARGS", "max-error"),
    ("QUALITY max-error -1", "ERANGE", "-1"),
    ("QUALITY max-error 1 -1", "ERANGE", "-1"),
    ("QUALITY max-error 1 2 3", "EARGS", "3"),
    ("QUALITY max-error x", "ENUM", "x"),
    ("DEPTHAT 1", "EARGS", "1"),
    ("DEPTHAT 1 x", "ENUM", "x"),
    ("PICK 1 2 3", "EARGS", "3"),
    ("SYNC", "EARGS", "SYNC"),
    ("SYNC a b", "EARGS", "b"),
    ("HELLO x", "EARGS", "x"),
    ("VERSION 1", "EARGS", "1"),
    ("AUTO", "EARGS", "AUTO"),
    ("AUTO maybe", "EARGS", "maybe"),
    ("PRESENT now", "EARGS", "now"),
    ("EVENTS 1", "EARGS", "1"),
    ("ERRORS ignore", "EARGS", "ignore"),
    ("SNAP", "EARGS", "SNAP"),
];

#[test]
fn every_verb_is_read_as_written() {
    for (text, command) in valid_forms() {
        // The stream is in step before and after the command.
        let heard = hear(
            format!("PX 7 7 07\n{text}{}SYNC after\n", if text.contains('\n') { "" } else { "\n" })
                .as_bytes(),
        );
        assert_eq!(heard.len(), 3, "{text}: {heard:?}");
        let Event::Command(heard, place) = &heard[1] else { panic!("{text}: {:?}", heard[1]) };
        assert_eq!((heard, place.line, place.byte), (&command, 2, 10), "{text}");
    }
}

#[test]
fn every_refusal_has_its_code_and_token_and_does_nothing() {
    for &(text, code, token) in BAD {
        let heard = hear(
            format!("PX 7 7 07\n{text}{}SYNC after\n", if text.contains('\n') { "" } else { "\n" })
                .as_bytes(),
        );
        assert_eq!(heard.len(), 3, "{text}: {heard:?}");
        let Event::Error(error) = &heard[1] else { panic!("{text}: {:?}", heard[1]) };
        assert_eq!(
            (error.code.as_str(), String::from_utf8_lossy(&error.token).as_ref()),
            (code, token),
            "{text}"
        );
        assert_eq!((error.place.line, error.place.byte, error.closes), (2, 10, false));
        let verb = text.split([' ', '\n']).next().unwrap();
        assert_eq!(error.subject.name(), verb);
        assert_eq!(error.is_unknown_verb(), code == "EVERB");
        assert!(error.wire_line().starts_with(&format!("ERR 2 10 {code} {verb}: ")), "{}", error.wire_line());
        assert!(
            error.play_line("f").starts_with(&format!("f:2: {code} {verb}: ")),
            "{}",
            error.play_line("f")
        );
    }
}

#[test]
fn every_text_verb_has_a_valid_form_here() {
    let good = valid_forms();
    for verb in Verb::all().iter().filter(|v| v.encoding == Encoding::Text) {
        let of =
            |text: &str| text.split([' ', '\n']).next().is_some_and(|w| w.eq_ignore_ascii_case(verb.name));
        assert!(good.iter().any(|g| of(g.0) && g.1.verb() == verb.name), "{}", verb.name);
    }
}

#[test]
fn names_that_are_not_text_are_refused() {
    for bytes in [&b"DRAW \xff\n"[..], b"SYNC a\x01b\n", b"FREE a\r\r\n"] {
        let [Event::Error(error)] = &hear(bytes)[..] else { panic!("{bytes:?}") };
        assert_eq!(error.code.as_str(), "EARGS");
    }
}

#[test]
fn a_pixel_takes_its_colour_in_any_form_and_its_verb_in_either_case() {
    for (text, event) in [
        ("PX 1 2 ff0000", Event::Pixel(1, 2, RED)),
        ("px 1 2 FF0000", Event::Pixel(1, 2, RED)),
        ("Px +1 -2 red", Event::Pixel(1, -2, RED)),
        ("PX 0001 2 11223344", Event::Pixel(1, 2, [0x11, 0x22, 0x33, 0x44])),
        ("PX -2147483648 2147483647 7f", Event::Pixel(i32::MIN, i32::MAX, [127, 127, 127, 255])),
        ("PX 1 2 transparent", Event::Pixel(1, 2, [0; 4])),
    ] {
        assert_eq!(hear(format!("{text}\n").as_bytes()), [event], "{text}");
    }
}

#[test]
fn the_example_of_every_verb_is_one_command_that_is_read_as_it_is_written() {
    for verb in Verb::all() {
        let bytes = match verb.encoding {
            Encoding::Text if verb.payload != Payload::Never && verb.example.contains('\n') => {
                verb.example.into()
            }
            Encoding::Text => format!("{}\n", verb.example),
            Encoding::Binary => verb.example.into(),
        };
        let written = match &hear(bytes.as_bytes())[..] {
            [Event::Command(command, _)] => {
                assert_eq!(command.verb(), verb.name, "{}", verb.example);
                let mut written = Vec::new();
                encode(command, &mut written).expect("it has a text form");
                let again = hear(&written);
                assert!(matches!(&again[..], [Event::Command(read, _)] if read == command), "{again:?}");
                continue;
            }
            [Event::Pixel(..)] => "PX",
            [Event::Binary(..)] => "PB",
            events => panic!("{}: {events:?}", verb.example),
        };
        assert_eq!(written, verb.name, "{}", verb.example);
    }
}
