//! Fear: a verb draws outside the clip rectangle, or on the frame while a canvas is the target. Every
//! verb of the table that draws is tried by its example, so that no new one is forgotten.

use fbptr::command::{Encoding, Payload, Reach, Verb};
use fbptr::server::{Audience, Budget, Engine, Limits, Output, Stream};

const WIDTH: usize = 64;
const HEIGHT: usize = 48;

/// A background with many colours, and all that the examples of the verbs name.
const SETTING: &str = "CLEAR 204060\nFILL 0 0 64 10 30 48 ff0000 00ff0080 0000ff\n\
    MESH pot SPHERE 2\nLOOKAT 0 0 5 0 0 0 0 1 0\nPERSPECTIVE 0.8 0.1 100\nAMBIENT .4 .4 .4\n\
    LIGHT 0 DIR 0 -1 -1 1 1 1\nCANVAS hero 16 16\nTARGET hero\nCLEAR #f80\nTARGET FRAME\n";

const EYE: &str = r#"{"dim":2,"pixels":[4],"d":1,"S":[1],"I_d":0.5,"facets":[{"v":[[2,-3],[2,0.01]],"color":[250,100,50]}]}"#;

const SCENE: &str = "<X3D><Scene><Background skyColor='0 1 0'/><Shape><Appearance><Material/></Appearance>\
    <Sphere/></Shape></Scene></X3D>";

/// A picture of one red pixel beside a blue one, as PNM.
const PICTURE: &[u8] = b"P6 2 1 255\n\xff\0\0\0\0\xff";

struct Frame {
    engine: Engine,
    stream: Stream,
}

impl Frame {
    fn new() -> Frame {
        let engine = Engine::new(WIDTH as u32, HEIGHT as u32).expect("a small frame");
        let stream = Stream::new(&engine, 1, Audience::Owner);
        let mut frame = Frame { engine, stream };
        frame.run(SETTING.as_bytes());
        frame.run(format!("EYE world :{}\n{EYE}", EYE.len()).as_bytes());
        frame.run(format!("SCENE X3D :{}\n{SCENE}", SCENE.len()).as_bytes());
        frame
    }

    /// Runs commands that are in order, and returns their replies.
    fn run(&mut self, commands: &[u8]) -> Vec<u8> {
        let mut out = Output::default();
        let (used, _) = self.stream.feed(&mut self.engine, commands, &mut out, Budget::NONE);
        assert_eq!(used, commands.len());
        let refused = out.notices.iter().find(|notice| matches!(notice, fbptr::server::Notice::Refused(_)));
        assert!(refused.is_none(), "{}: {refused:?}", commands.escape_ascii());
        out.replies
    }

    fn pixels(&self) -> Vec<[u8; 4]> {
        self.engine.memory().bytes().as_chunks().0.to_vec()
    }

    /// Returns the pixels of the target.
    fn target(&mut self) -> Vec<[u8; 4]> {
        let reply = self.run(format!("READ 0 0 {WIDTH} {HEIGHT}\n").as_bytes());
        let start = reply.iter().position(|b| *b == b'\n').expect("a line") + 1;
        reply[start..].as_chunks().0.to_vec()
    }

    /// Returns the depths of the target.
    fn depths(&mut self) -> Vec<String> {
        let ask = |i: usize| format!("DEPTHAT {} {}\n", i % WIDTH, i / WIDTH);
        let asked: String = (0..WIDTH * HEIGHT).map(ask).collect();
        let replies = String::from_utf8(self.run(asked.as_bytes())).expect("text");
        replies.lines().map(|line| line.rsplit(' ').next().unwrap_or("").to_owned()).collect()
    }
}

/// Returns a command of the verb that can be run.
fn example(verb: &Verb) -> Vec<u8> {
    match verb.name {
        "IMAGE" => [format!("IMAGE 15 11 :{}\n", PICTURE.len()).as_bytes(), PICTURE].concat(),
        "PB" => b"PB\x10\0\x0c\0\x7f\0\0\x7f".to_vec(),
        "PXMULTI" => [&b"PXMULTI\x08\0\x0b\0\x40\0\0\0"[..], &[9; 256]].concat(),
        "POINTS" => b"POINTS :16\n\x08\0\x06\0\x7f\0\0\x7f\x10\0\x0c\0\x7f\0\0\x7f".to_vec(),
        "PX" => b"PX 16 12 ff8000\nPX 3 3 ff8000\n".to_vec(),
        "BLIT" => [&b"BLIT 8 6 10 10 :400\n"[..], &[77; 400]].concat(),
        "COPY" => b"COPY 30 0 16 16 5 5\n".to_vec(),
        "TEXT" => b"TEXT 2 2 white :11\nhello\nhello".to_vec(),
        "PRINT" => b"TEXTSIZE 2\nPRINT 2 2 white hello\nTEXTSIZE 1\n".to_vec(),
        "RECT" => b"RECT 15 12 40 30 white\n".to_vec(),
        "ELLIPSE" => b"ELLIPSE 20 20 9 12 white\n".to_vec(),
        "ARC" => b"ARC 20 20 3 9 0deg 200deg tomato\n".to_vec(),
        "STAMP" => b"STAMP hero 8 6\n".to_vec(),
        _ if verb.encoding == Encoding::Text
            && (verb.payload == Payload::Never || !verb.example.contains('\n')) =>
        {
            format!("{}\n", verb.example).into_bytes()
        }
        _ => verb.example.as_bytes().to_vec(),
    }
}

fn drawing_verbs() -> Vec<&'static Verb> {
    Verb::all().iter().filter(|verb| verb.reach == Reach::Clip).collect()
}

#[test]
fn every_verb_that_draws_stays_in_the_clip_rectangle() {
    let is_inside = |i: usize| (13..31).contains(&(i % WIDTH)) && (10..29).contains(&(i / WIDTH));
    assert!(drawing_verbs().len() >= 26);
    for verb in drawing_verbs() {
        for blend in ["replace", "over"] {
            let setting = format!("BLEND {blend}\n");
            let (mut plain, mut clipped) = (Frame::new(), Frame::new());
            let before = plain.pixels();
            plain.run(&[setting.as_bytes(), &example(verb)].concat());
            clipped.run(&[setting.as_bytes(), b"CLIP 13 10 18 19\n", &example(verb)].concat());
            let (whole, part) = (plain.pixels(), clipped.pixels());
            for i in 0..WIDTH * HEIGHT {
                let want = if is_inside(i) { whole[i] } else { before[i] };
                assert_eq!(part[i], want, "{} {blend} at {} {}", verb.name, i % WIDTH, i / WIDTH);
            }
            let differs = |i: usize| is_inside(i) && part[i] != before[i];
            assert!((0..WIDTH * HEIGHT).any(differs), "{} draws nothing inside", verb.name);
            // Afterwards all of it can be drawn on again.
            clipped.run(b"CLIP OFF\nCLEAR 010203\n");
            assert!(clipped.pixels().iter().all(|pixel| *pixel == [1, 2, 3, 255]));
        }
    }
}

#[test]
fn every_verb_that_draws_draws_on_the_target_and_nowhere_else() {
    for verb in drawing_verbs() {
        let (mut plain, mut other) = (Frame::new(), Frame::new());
        let before = other.pixels();
        plain.run(&[b"CLEAR 204060\n", &example(verb)[..]].concat());
        other.run(format!("CANVAS c {WIDTH} {HEIGHT}\nTARGET c\nCLEAR 204060\n").as_bytes());
        other.run(&example(verb));
        assert!(other.target() == plain.pixels(), "{} on a canvas", verb.name);
        assert!(other.pixels() == before, "{} has drawn on the frame", verb.name);
        let (on_canvas, on_frame) = (other.depths(), plain.depths());
        assert!(on_canvas == on_frame, "{}: other depths", verb.name);
        other.run(b"TARGET FRAME\nSTAMP c 0 0\n");
        assert!(other.pixels() == plain.pixels(), "{} as a stamp", verb.name);
    }
}

#[test]
fn depths_and_names_are_clipped_as_pixels_are() {
    let (mut plain, mut clipped) = (Frame::new(), Frame::new());
    plain.run(b"DRAW pot\n");
    clipped.run(b"CLIP 13 10 18 19\nDRAW pot\nCLIP OFF\n");
    let (whole, part) = (plain.depths(), clipped.depths());
    let is_inside = |i: usize| (13..31).contains(&(i % WIDTH)) && (10..29).contains(&(i / WIDTH));
    for i in 0..WIDTH * HEIGHT {
        let want = if is_inside(i) { &whole[i] } else { "1.00000000" };
        assert_eq!(part[i], want, "{} {}", i % WIDTH, i / WIDTH);
    }
    assert!(part.iter().any(|z| z != "1.00000000"));
    assert_eq!(
        clipped.run(b"PICK 25 24\nPICK 40 24\n").split(|b| *b == b'\n').nth(1),
        Some(&b"PICK 40 24 none -1"[..])
    );
    // A clear leaves what lies outside, too.
    plain.run(b"CLIP 0 0 20 48\nCLEAR\nCLIP OFF\n");
    let left = plain.depths();
    assert!((0..WIDTH * HEIGHT).all(|i| left[i] == if i % WIDTH < 20 { "1.00000000" } else { &whole[i] }));
}

#[test]
fn a_canvas_can_be_stamped_on_itself_and_freed_while_it_is_the_target() {
    let mut frame = Frame::new();
    frame.run(b"CANVAS c 8 8\nTARGET c\nFILLRECT 0 0 2 2 red\nSTAMP c 1 1 00000000\nCLIP 0 0 1 1\n");
    frame.run(b"TARGET FRAME\nCLIP OFF\nCLEAR black\nSTAMP c 10 10 00000000\n");
    let red: Vec<usize> = (0..WIDTH * HEIGHT)
        .filter(|i| frame.pixels()[*i] == [255, 0, 0, 255])
        .map(|i| i % WIDTH - 10 + (i / WIDTH - 10) * 8)
        .collect();
    assert_eq!(red, [0, 1, 8, 9, 10, 17, 18]);
    frame.run(b"TARGET c\nFREE c\nCLEAR 010203\n");
    assert!(frame.pixels().iter().all(|pixel| *pixel == [1, 2, 3, 255]), "the frame is the target again");
    // A new canvas of the target's name takes its place, transparent.
    frame.run(b"CANVAS c 4 4\nTARGET c\nCLEAR red\nCANVAS c 64 48\n");
    assert!(frame.target().iter().all(|pixel| *pixel == [0; 4]));
}

#[test]
fn canvases_are_bounded_and_given_back() {
    let limits = Limits { resource_bytes: 100_000, names: 3, ..Limits::default() };
    let mut engine = Engine::with_limits(16, 16, limits).expect("a small frame");
    let idle = engine.memory_budget().used();
    let mut stream = Stream::new(&engine, 1, Audience::Connection);
    let mut ask = |engine: &mut Engine, commands: &str| {
        let mut out = Output::default();
        let _ = stream.feed(engine, commands.as_bytes(), &mut out, Budget::NONE);
        String::from_utf8(out.replies).expect("text")
    };
    for (commands, code) in [
        ("ERRORS report\nCANVAS c 0 5\n", "ETOOBIG"),
        ("CANVAS c 40000 1\n", "EQUOTA"),
        ("CANVAS c 2147483647 2147483647\n", "ETOOBIG"),
        ("CANVAS a 100 200\nCANVAS b 100 200\n", "EQUOTA"),
        ("TARGET nowhere\n", "ENOENT"),
        ("STAMP nowhere 1 1\n", "ENOENT"),
        ("CANVAS b 1 1\nCANVAS c 1 1\nCANVAS d 1 1\n", "EQUOTA"),
        ("SIZE 3 3\n", "EPERM"),
    ] {
        let reply = ask(&mut engine, commands);
        assert!(reply.contains(code) && reply.lines().count() == 1, "{commands}: {reply}");
    }
    assert!(engine.memory_budget().used() >= idle + 80_000);
    assert_eq!(ask(&mut engine, "FREE a\nFREE b\nFREE c\n"), "");
    drop(stream);
    assert!(engine.memory_budget().used() < idle + 20_000);
}

#[test]
fn depths_and_faces_of_a_canvas_are_within_the_limit_of_its_connection() {
    let limits = Limits { resource_bytes: 100_000, ..Limits::default() };
    let mut engine = Engine::with_limits(16, 16, limits).expect("a small frame");
    let mut stream = Stream::new(&engine, 1, Audience::Connection);
    let mut ask = |commands: &str| {
        let mut out = Output::default();
        let _ = stream.feed(&mut engine, commands.as_bytes(), &mut out, Budget::NONE);
        String::from_utf8(out.replies).expect("text")
    };
    let bytes = |stats: String| {
        let word = stats.split(" resource_bytes=").nth(1).and_then(|rest| rest.split(' ').next());
        word.and_then(|word| word.parse::<u64>().ok()).unwrap_or_else(|| panic!("{stats}"))
    };
    let before = bytes(ask("ERRORS report\nMESH m BOX 1 1 1\nSTATS\n"));
    // 4 bytes of colours, 4 of depth and 8 of a face's number a pixel.
    let made = bytes(ask("CANVAS c 100 100\nTARGET c\nSTATS\n"));
    assert!((before + 40_000..before + 42_000).contains(&made), "{before} {made}");
    let refused = ask("DRAW m\n");
    assert!(refused.contains("EQUOTA DRAW") && refused.lines().count() == 1, "{refused}");
    assert_eq!(ask("FREE c\nCANVAS c 60 60\nTARGET c\nDRAW m\n"), "");
    let drawn = bytes(ask("STATS\n"));
    assert!((before + 57_600..before + 62_000).contains(&drawn), "{before} {drawn}");
    // What the canvases take is not left for meshes.
    let refused = ask("MESH n SPHERE\n");
    assert!(refused.contains("EQUOTA MESH"), "{refused}");
    assert_eq!(bytes(ask("FREE c\nSTATS\n")), before);
    assert_eq!(ask("DRAW m\n"), "", "the frame has no such limit");
}
