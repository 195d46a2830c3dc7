//! Verifies that the drawing of faces is divided into pieces: other clients are answered while a
//! draw runs, and what it leaves is what it leaves in one piece, live and in a replay.

use crate::fairness::{live_and_replayed, patient, read_to, recorded};
use crate::process::fbptr;
use crate::support::{Numbers, Serving, Wire};
use fbptr::command::EndOfInput;
use fbptr::server::{Audience, Budget, Engine, Limits, Output, Stream, StreamState};
use std::time::{Duration, Instant};

const SIZE: (u32, u32) = (800, 600);

const VIEW: &str = "LIGHT 0 DIR 0 0 -1 1 1 1\nLOOKAT 0 0 6 0 0 0 0 1 0\nCULL none\n";

/// Returns an OBJ file of triangles that fill the view, from far to near.
fn layers(count: usize) -> String {
    let mut obj = String::new();
    for i in 0..count {
        let z = i as f64 / count as f64;
        obj += &format!("v -30 -20 {z:.4}\nv 30 -20 {z:.4}\nv 0 40 {z:.4}\nf -3 -2 -1\n");
    }
    obj
}

fn mesh_of_layers(count: usize) -> String {
    let obj = layers(count);
    format!("MESH m OBJ :{}\n{obj}", obj.len())
}

/// Returns an X3D file of transparent triangles that fill the view.
fn scene_of_layers(count: usize) -> String {
    let (mut points, mut indices) = (String::new(), String::new());
    for i in 0..count {
        let z = i as f64 / count as f64;
        points += &format!("-30 -20 {z} 30 -20 {z} 0 40 {z} ");
        indices += &format!("{} {} {} -1 ", 3 * i, 3 * i + 1, 3 * i + 2);
    }
    let x3d = format!(
        "<X3D><Scene><Shape><Appearance><Material transparency='.5'/></Appearance>\
         <IndexedFaceSet solid='false' coordIndex='{indices}'><Coordinate point='{points}'/></IndexedFaceSet>\
         </Shape></Scene></X3D>"
    );
    format!("SCENE X3D :{}\n{x3d}LOOKAT 0 0 6 0 0 0 0 1 0\n", x3d.len())
}

/// Returns an X3D file of many boxes.
fn scene_of_boxes(count: usize) -> String {
    let mut x3d = String::from("<X3D><Scene>");
    for i in 0..count {
        let [x, y, z] = [i % 40, i / 40 % 40, i / 1600].map(|v| v as f64 / 10.0 - 2.0);
        x3d += &format!(
            "<Transform translation='{x} {y} {z}'><Shape><Box size='.1 .1 .1'/></Shape></Transform>"
        );
    }
    x3d += "</Scene></X3D>";
    format!("SCENE X3D :{}\n{x3d}LOOKAT 0 0 6 0 0 0 0 1 0\n", x3d.len())
}

/// A long draw: the commands before it, for a size, and the draw.
type Case = (&'static str, fn(usize) -> String, &'static str);

const CASES: [Case; 8] = [
    ("opaque", |n| mesh_of_layers(60 * n), "DRAW m\n"),
    (
        "transparent",
        |n| format!("MATERIAL black #cc black 1 black .5\n{}", mesh_of_layers(8 * n)),
        "DRAW m\n",
    ),
    ("painter", |n| format!("HIDE painter\nMESH m KNOT 200 {}\n", 12 * n), "DRAW m\n"),
    ("wire", |n| format!("SHADE wire\nMESH m KNOT 200 {}\n", 12 * n), "DRAW m\n"),
    ("narrow depths", |n| format!("DEPTH u16\n{}", mesh_of_layers(40 * n)), "DRAW m\n"),
    ("first draw of a large mesh", |n| format!("MESH m KNOT 400 {}\n", 50 * n), "DRAW m\n"),
    ("scene", |n| scene_of_layers(8 * n), "DRAWSCENE\n"),
    ("scene of many objects", |n| scene_of_boxes(800 * n), "DRAWSCENE\n"),
];

/// Returns how many rounds of queries another client gets answered between the beginning of a draw
/// and its end.
fn rounds_beside(setting: &str, draw: &str) -> usize {
    let serving = Serving::limited(SIZE.0, SIZE.1, patient());
    let (mut busy, mut other) = (serving.connect(), serving.connect());
    for wire in [&busy, &other] {
        wire.0.set_read_timeout(Some(Duration::from_secs(600))).unwrap();
    }
    assert_eq!(busy.ask(&format!("{VIEW}{setting}PX 0 0 000000\nSYNC begin\n")), "SYNC begin\n");
    assert_eq!(other.ask("SYNC begin\n"), "SYNC begin\n");
    busy.send(format!("PX 0 0 123456\n{draw}SYNC end\n").as_bytes());
    while other.ask("PX 0 0\n") == "PX 0 0 000000\n" {}
    busy.0.set_nonblocking(true).unwrap();
    let mut rounds = 0;
    while busy.0.peek(&mut [0]).is_err() {
        rounds += 1;
        let mark = format!("SYNC {rounds}\n");
        other
            .send(format!("SIZE\nPX 400 300\nCRC 0 0 100 100\nDEPTHAT 400 300\nPICK 3 4\n{mark}").as_bytes());
        assert_eq!(other.line(), "SIZE 800 600\n");
        for verb in ["PX 400 300 ", "CRC ", "DEPTHAT 400 300 ", "PICK 3 4 "] {
            let line = other.line();
            assert!(line.starts_with(verb), "{line}");
        }
        assert_eq!(other.line(), mark);
    }
    busy.0.set_nonblocking(false).unwrap();
    assert_eq!(busy.line(), "SYNC end\n", "{draw} comes to its end");
    rounds
}

#[test]
fn queries_of_others_are_answered_while_faces_are_drawn() {
    for (what, setting, draw) in CASES {
        // A fast machine needs a larger draw before it is divided often.
        let found = [1, 4, 16, 64, 256].map(|n| (n, setting)).into_iter().find_map(|(n, setting)| {
            let rounds = rounds_beside(&setting(n), draw);
            (rounds >= 5).then_some(rounds)
        });
        assert!(found.is_some(), "{what}: others wait until the draw is over");
    }
}

/// Runs a stream on an engine of its own, every command in one piece. Returns the replies.
fn at_once(script: &str) -> String {
    let mut engine = Engine::new(SIZE.0, SIZE.1).unwrap();
    let mut stream = Stream::new(&engine, 1, Audience::Connection);
    let mut out = Output::default();
    let (used, state) = stream.feed(&mut engine, script.as_bytes(), &mut out, Budget::NONE);
    assert_eq!((used, state), (script.len(), StreamState::Ready));
    let _ = stream.finish(&mut engine, EndOfInput::Stream, &mut out);
    String::from_utf8(out.replies).unwrap()
}

/// Removes what `STATS` says of the server and not of the drawing.
fn drawn_words(replies: &str) -> String {
    let is_kept = |word: &&str| {
        let key = word.split_once('=').map_or("", |(key, _)| key);
        matches!(
            key,
            "" | "commands" | "pixels" | "errors" | "clipped" | "empty_draws" | "plan" | "depth_bytes"
        )
    };
    replies.lines().map(|line| line.split(' ').filter(is_kept).collect::<Vec<_>>().join(" ") + "\n").collect()
}

#[test]
fn a_draw_in_pieces_leaves_what_it_leaves_in_one() {
    for (what, setting, draw) in CASES {
        let serving = Serving::limited(SIZE.0, SIZE.1, patient());
        let end = "CRC\nDEPTHAT 400 300\nDEPTHAT 3 7\nPICK 400 300\nPICK 3 7\nSTATS\n";
        let script = format!("CLEAR 102030\n{VIEW}{}{draw}{end}ROTATE 0 1 0 1\n{draw}{end}", setting(1));
        let wire = serving.connect();
        wire.0.set_read_timeout(Some(Duration::from_secs(600))).unwrap();
        let got = String::from_utf8(wire.talk(script.as_bytes())).unwrap();
        assert_eq!(drawn_words(&got), drawn_words(&at_once(&script)), "{what}");
    }
}

#[test]
fn a_picture_of_the_eye_in_pieces_is_the_one_drawn_at_once() {
    let eye = fbptr().args(["eye", "--make", "tesseract"]).output().unwrap().stdout;
    let eye = String::from_utf8(eye).unwrap();
    let script = format!(
        "EYE e :{}\n{eye}DRAWEYE e -5 -9 790 640\nCRC\nSTATS\nDRAWEYE e 3 -900 700 1490\nCRC\nSTATS\n",
        eye.len()
    );
    let serving = Serving::limited(SIZE.0, SIZE.1, patient());
    assert_eq!(drawn_words(&serving.say(&script)), drawn_words(&at_once(&script)));
}

#[test]
fn a_recording_of_draws_beside_other_writers_replays_to_the_same_bytes() {
    let (serving, sheet) = recorded(SIZE.0, SIZE.1, patient());
    let draws = |who: usize| {
        let mut wire = Wire::connect(serving.address);
        wire.send(format!("ERRORS count\n{VIEW}").as_bytes());
        for (i, (_, setting, draw)) in CASES.into_iter().enumerate().filter(|(i, _)| i % 2 == who) {
            let mark = format!("SYNC {i}\n");
            wire.send(format!("{}{draw}ROTATE 0 0 1 0.5\n{draw}{mark}", setting(1)).as_bytes());
            read_to(&mut wire, mark.as_bytes());
        }
    };
    let writes = |who: u32| {
        let (mut numbers, mut wire) = (Numbers(who + 8), Wire::connect(serving.address));
        for step in 0..60 {
            let mut n = |limit| numbers.below(limit);
            let color = format!("{:06x}", n(1 << 24));
            wire.send(
                format!("PX {} {} {color}\nFILLRECT {} {} 90 70 {color}\n", n(800), n(600), n(800), n(600))
                    .as_bytes(),
            );
            let mark = format!("SYNC {who}.{step}\n");
            wire.send(mark.as_bytes());
            read_to(&mut wire, mark.as_bytes());
        }
    };
    std::thread::scope(|scope| {
        (0..2).for_each(|who| drop(scope.spawn(move || draws(who))));
        (0..2).for_each(|who| drop(scope.spawn(move || writes(who))));
    });
    let [live, replayed] = live_and_replayed(serving, &sheet, SIZE.0, SIZE.1);
    assert!(live == replayed, "the replay has other bytes");
}

#[test]
fn a_draw_past_the_limit_of_time_is_recorded_as_it_stands() {
    let limits = Limits { command_time: Duration::from_millis(1), ..Limits::default() };
    let (serving, sheet) = recorded(SIZE.0, SIZE.1, limits);
    let mut wire = serving.connect();
    wire.0.set_read_timeout(Some(Duration::from_secs(600))).unwrap();
    // So few that they are read at once, without a limit of time.
    let obj = layers(130);
    wire.send(format!("{VIEW}MESH m OBJ :{}\n{obj}MESH b BOX .4 .4 .4\n", obj.len()).as_bytes());
    wire.send(
        b"DRAW b\nDEPTHAT 400 300\nMATERIAL black #cc black 1 black .9\nDRAW m\nDEPTHAT 400 300\nSYNC end\n",
    );
    let before = wire.line();
    assert!(before.starts_with("DEPTHAT 400 300 0."), "{before}");
    let said = wire.line();
    assert!(said.ends_with(" EQUOTA DRAW: given up after 0.001 s, with a part of it drawn\n"), "{said}");
    assert_eq!(wire.line(), "DEPTHAT 400 300 1.00000000\n", "the depths are cleared");
    assert_eq!(wire.line(), "SYNC end\n");
    // Drawn behind the first box, where it is seen because the depths were cleared.
    let box_behind = "MATERIAL black #40 black 1\nTRANSLATE 0 0 -1\nDRAW b\nSYNC end\n";
    assert_eq!(wire.ask(box_behind), "SYNC end\n");
    drop(wire);
    let [live, replayed] = live_and_replayed(serving, &sheet, SIZE.0, SIZE.1);
    assert!(live == replayed, "the replay has other bytes");
}

#[test]
fn a_client_that_goes_in_the_middle_of_a_draw_leaves_the_server_whole() {
    let serving = Serving::limited(SIZE.0, SIZE.1, patient());
    for (_, setting, draw) in CASES {
        let mut wire = serving.connect();
        wire.send(format!("{VIEW}{}{draw}SYNC never read\n", setting(1)).as_bytes());
        wire.reset();
    }
    let until = Instant::now() + Duration::from_secs(300);
    while !serving.say("STATS\n").contains(" connections=1 ") {
        assert!(Instant::now() < until, "{}", serving.say("STATS\n"));
        std::thread::sleep(Duration::from_millis(20));
    }
    let script = format!("DEPTH f32\nCLEAR 102030\n{VIEW}MESH m KNOT 60 20\nDRAW m\nCRC\n");
    assert_eq!(serving.say(&script), at_once(&script));
}
