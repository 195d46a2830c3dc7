use super::*;
use crate::clock::Instant;
use proptest::prelude::*;

fn play(script: &[u8], pieces: usize, audience: Audience) -> (Engine, Output) {
    let mut engine = Engine::new(16, 8).unwrap();
    let mut stream = Stream::new(&engine, 1, audience);
    let mut out = Output::default();
    for piece in script.chunks(pieces) {
        let (used, state) = stream.feed(&mut engine, piece, &mut out, Budget::NONE);
        if state == StreamState::Ended {
            return (engine, out);
        }
        assert_eq!((used, state), (piece.len(), StreamState::Ready));
    }
    let _ = stream.finish(&mut engine, EndOfInput::Stream, &mut out);
    (engine, out)
}

/// Plays a script in pieces of so many bytes on a frame of 280x190 pixels, and returns its replies.
fn replies_of(script: &str, threads: usize, pieces: usize, pace: Pace) -> String {
    let mut engine = Engine::new(280, 190).unwrap();
    let pool = crate::worker_pool(Some(threads));
    let options = fbptr_core::pipeline::RenderOptions { pool, ..Default::default() };
    engine.set_renderer(fbptr_core::pipeline::Renderer::new(options));
    let mut stream = Stream::new(&engine, 1, Audience::Connection);
    let mut out = Output::default();
    for piece in script.as_bytes().chunks(pieces) {
        let mut used = 0;
        while used < piece.len() {
            let budget = Budget { pace, ..Budget::NONE };
            used += stream.feed(&mut engine, &piece[used..], &mut out, budget).0;
        }
    }
    String::from_utf8(out.replies).unwrap()
}

/// Returns a generator of numbers below a limit.
fn numbers(mut state: u32) -> impl FnMut(u32) -> u32 {
    move |n| {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) % n
    }
}

#[test]
fn any_size_of_pieces_gives_the_same_answers() {
    let mut script = b"PX 1 1 ff0000\nOFFSET 2 2\nPX 1 1 00ff00\nPX 1 1\nLINE 0 0 9 5 0000ff\n".to_vec();
    script.extend_from_slice(b"PB\x05\x00\x06\x00abcdPXMULTI\x0e\x00\x00\x00\x03\x00\x00\x00123456789abc");
    script.extend_from_slice(b"BLIT 3 3 2 1 :8\n\nBLIT\n1\nCRC\nWHAT 1\nBLIT 1 1 :5\nPX 1\nSYNC end\n");
    let (_, whole) = play(&script, script.len(), Audience::Connection);
    let text = String::from_utf8_lossy(&whole.replies).into_owned();
    assert!(text.starts_with("PX 1 1 00ff00\nCRC "), "{text}");
    assert!(
        text.ends_with("SYNC end\n") && text.contains("EVERB WHAT") && text.contains("EARGS BLIT"),
        "{text}"
    );
    for pieces in 1..script.len() {
        assert_eq!(
            play(&script, pieces, Audience::Connection).1.replies,
            whole.replies,
            "pieces of {pieces}"
        );
    }
}

#[test]
fn an_error_behind_lines_is_reported_as_behind_any_verb_that_is_not_pixelflut() {
    let script = b"PX 1 zz\nLINE 0 0 9 5 0000ff\nPX 1 zz\nSTATS\n";
    for pieces in [script.len(), 1] {
        let (_, out) = play(script, pieces, Audience::Connection);
        let text = String::from_utf8_lossy(&out.replies).into_owned();
        assert!(text.starts_with("ERR 3 ") && text.contains("\nSTATS bytes="), "{text}");
        assert!(text.contains(" commands=4 ") && text.contains(" errors=2 "), "{text}");
    }
}

#[test]
fn lines_drawn_together_are_drawn_in_their_turn() {
    let mut script = String::new();
    let mut next = numbers(9);
    for i in 0..6000 {
        let [a, b, c, d] = [300, 200, 300, 200].map(&mut next);
        let color = next(1 << 24);
        script += &match i % 997 {
            3 => format!("PX {a} {b} {color:06x}\n"),
            8 => "BLEND over\n".to_owned(),
            500 => "BLEND replace\n".to_owned(),
            600 => format!("FILLRECT {a} {b} 30 20 {color:06x}80\n"),
            700 => "LINE 1 2\n".to_owned(),
            800 => "CRC\n".to_owned(),
            _ => format!("LINE {a} {b} {c} {d} {color:06x}7f\n"),
        };
    }
    script += "CRC\nSTATS\n";
    let run = |threads, pieces, pace| replies_of(&script, threads, pieces, pace);
    let one_by_one = run(1, 1000, Pace::OneCommand);
    assert!(one_by_one.matches("CRC").count() == 7, "{one_by_one}");
    for (threads, pieces) in [(1, usize::MAX), (2, usize::MAX), (3, 65_536), (2, 999)] {
        assert_eq!(run(threads, pieces, Pace::Free), one_by_one, "{threads} threads, pieces of {pieces}");
    }
}

#[test]
fn small_draws_drawn_together_are_drawn_in_their_turn() {
    let mut script = "LIGHT 0 DIR -1 -1 -1 1 1 1\nAMBIENT 1 1 1\nLOOKAT 0 0 6 0 0 0 0 1 0\n\
        MESH box BOX 0.6 0.5 0.4\nMESH cone CONE\nMESH knot KNOT 60 9\nCLEAR 102030\n"
        .to_owned();
    let mut next = numbers(5);
    for i in 0..2500 {
        let [x, y, z] = [(); 3].map(|()| f64::from(next(600)) / 150.0 - 2.0);
        let [r, g, b] = [(); 3].map(|()| f64::from(next(100)) / 100.0);
        script += &match i % 499 {
            7 => "SHADE flat\n".to_owned(),
            40 => "SHADE gouraud\n".to_owned(),
            90 => "SHADE phong\n".to_owned(),
            120 => "CULL none\n".to_owned(),
            130 => "HIDE painter\n".to_owned(),
            160 => "HIDE zbuffer\n".to_owned(),
            // Refused and unseen draws, and a setting that is refused.
            200 => "DRAW none\n".to_owned(),
            230 => "POP\n".to_owned(),
            260 => "PUSH\nTRANSLATE 0 0 50\nDRAW cone\nPOP\nPOP\n".to_owned(),
            300 => "SHEAR 9e307 0 0 0 9e307 9e307\nSCALE 9e9 9e9 9e9\nDRAW box\n".to_owned(),
            // Others that see the frame, or change it.
            330 => "CRC\n".to_owned(),
            350 => format!("FILLRECT {} 20 60 50 ff8040\n", next(200)),
            370 => "LINE 0 0 250 180 red\nLINE 5 0 250 180 blue\n".to_owned(),
            390 => "CLIP 20 30 180 90\n".to_owned(),
            420 => "CLIP OFF\nCLEAR 203040\n".to_owned(),
            440 => "DRAW knot\n".to_owned(),
            410 => "PICK 140 95\nDEPTHAT 140 95\n".to_owned(),
            480 => "FREE cone\nMESH cone CONE 0.5 0.8\n".to_owned(),
            _ => format!(
                "IDENTITY\nTRANSLATE {x} {y} {z}\nROTATE 1 1 0 {x}\nSCALE .3 .3 .3\n\
                 MATERIAL {r} {g} {b} {b} {r} {g} .3 .3 .3 20 0 0 0 {}\nDRAW {}\n",
                if i % 9 == 0 { 0.5 } else { 0.0 },
                if i % 2 == 0 { "box" } else { "cone" },
            ),
        };
    }
    script += "CRC\nSTATS\n";
    let run = |threads: usize, pieces: usize, pace: Pace| {
        // The memory that draws leave behind depends on how they are drawn.
        let text = replies_of(&script, threads, pieces, pace);
        let words = |line: &str| match line.strip_prefix("STATS") {
            Some(_) => line.split(' ').filter(|word| !word.contains("memory")).collect::<Vec<_>>().join(" "),
            None => line.to_owned(),
        };
        text.lines().map(words).collect::<Vec<_>>()
    };
    let one_by_one = run(1, 1000, Pace::OneCommand);
    let count = |what: &str| one_by_one.iter().filter(|line| line.contains(what)).count();
    assert_eq!((count("CRC"), count("WARN"), count("PICK")), (6, 5, 5), "{one_by_one:#?}");
    assert!(count("ERANGE") > 10 && count("ENOENT") == 5 && count("none -1") < 5, "{one_by_one:#?}");
    for (threads, pieces) in [(1, usize::MAX), (2, usize::MAX), (3, 65_536), (2, 999)] {
        let got = run(threads, pieces, Pace::Free);
        assert_eq!(got, one_by_one, "{threads} threads, pieces of {pieces}");
    }
}

#[test]
fn the_plan_in_stats_is_the_same_for_every_vector_level() {
    // A knot, drawn again and again behind a wall that hides most of it: coarse depth is decided by
    // itself, and leaves out other fragments on other levels.
    let mut script =
        "LOOKAT 0 0 4 0 0 0 0 1 0\nPERSPECTIVE 1 1 9\nMESH knot KNOT 100 20\nMESH wall BOX\n".to_owned();
    let turns =
        ["PUSH\nTRANSLATE .4 0 1.7\nSCALE .9 3 .1\nDRAW wall\nPOP\nROTATE 1 1 0 .3\nDRAW knot\nSTATS\n"];
    turns.iter().cycle().take(6).for_each(|turn| script += &format!("CLEAR 102030\n{turn}"));
    let plans = |level: fbptr_core::simd::Level| -> Vec<String> {
        let mut engine = Engine::new(640, 480).unwrap();
        let options = fbptr_core::pipeline::RenderOptions { simd: Some(level), ..Default::default() };
        engine.set_renderer(fbptr_core::pipeline::Renderer::new(options));
        let (mut stream, mut out) = (Stream::new(&engine, 1, Audience::Connection), Output::default());
        let _ = stream.feed(&mut engine, script.as_bytes(), &mut out, Budget::NONE);
        let text = String::from_utf8(out.replies).unwrap();
        text.lines().filter_map(|line| Some(line.split_once(" plan=")?.1.to_owned())).collect()
    };
    let found = plans(fbptr_core::simd::Level::Portable);
    assert_eq!(found.len(), 6);
    assert!(!found[0].contains("tested:-") && found[1].contains("tested:-"), "{found:?}");
    for level in fbptr_core::simd::Level::ALL.into_iter().filter(|level| level.is_available()) {
        assert_eq!(plans(level), found, "{level:?}");
    }
}

#[test]
fn a_pixelflut_connection_hears_nothing_unasked_until_it_uses_more() {
    let quiet = b"PX 1 1 zz\nNOPE\nPX 1\nSIZE 3\nPX 99 99\n";
    assert_eq!(play(quiet, 5, Audience::Connection).1.replies, b"");
    let (_, out) = play(b"NOPE\nCRC 1\nNOPE\n", 5, Audience::Connection);
    let text = String::from_utf8(out.replies).unwrap();
    assert_eq!(text.lines().count(), 2, "{text}");
    assert!(text.starts_with("ERR 2 5 EARGS CRC: "), "{text}");
    let (_, out) = play(b"ERRORS count\nLINE 1\nNOPE\n", 5, Audience::Connection);
    assert_eq!(out.replies, b"");
    let (_, out) = play(b"NOPE\nPX 1\n", 5, Audience::Owner);
    assert_eq!(out.notices.len(), 2, "the player always hears");
    let (_, out) = play(b"PX 1 2 \xff\"\n", 5, Audience::Owner);
    let [Notice::Refused(refused)] = &out.notices[..] else { panic!("{:?}", out.notices) };
    assert!(refused.play_line("f").ends_with(", got \"\\xff\\x22\""), "{}", refused.play_line("f"));
}

#[test]
fn errors_close_runs_nothing_after_the_error() {
    let (engine, out) = play(b"ERRORS close\nNOPE\nPX 1 1 ff0000\nSIZE\n", 400, Audience::Connection);
    let text = String::from_utf8(out.replies).unwrap();
    assert_eq!(text, "ERR 2 13 EVERB NOPE: unknown verb, got \"NOPE\"\n");
    assert_eq!(engine.memory().get_pixel(1, 1).unwrap(), [0, 0, 0, 255]);
}

#[test]
fn half_a_command_leaves_no_trace() {
    let script = b"FILLRECT 0 0 4 4 ff0000\nBLIT 0 0 2 2 :16\n0123456789abcdef";
    for cut in 0..script.len() {
        let (engine, _) = play(&script[..cut], 1000, Audience::Connection);
        let first = engine.memory().get_pixel(0, 0).unwrap();
        let want = if cut < 24 { [0, 0, 0, 255] } else { [255, 0, 0, 255] };
        assert_eq!(first, want, "cut at {cut}");
    }
}

#[test]
fn a_stream_rests_when_its_budget_is_used_up() {
    let mut engine = Engine::new(16, 8).unwrap();
    let mut stream = Stream::new(&engine, 1, Audience::Connection);
    let mut out = Output::default();
    let script = b"SYNC a\nSYNC b\nPX 1 1 ff0000\nPX 2 2 ff0000\nPRESENT\nSYNC c\n";
    let few = Budget { reply_bytes: 3, ..Budget::NONE };
    assert_eq!(stream.feed(&mut engine, script, &mut out, few), (7, StreamState::Yields));
    let step = Budget { pace: Pace::OneCommand, ..Budget::NONE };
    assert_eq!(stream.feed(&mut engine, &script[7..], &mut out, step), (7, StreamState::Yields));
    assert_eq!(stream.feed(&mut engine, &script[14..], &mut out, step), (14, StreamState::Yields));
    assert_eq!(engine.memory().get_pixel(2, 2).unwrap(), [0, 0, 0, 255]);
    let frame = Budget { pace: Pace::OneFrame, ..Budget::NONE };
    assert_eq!(stream.feed(&mut engine, &script[28..], &mut out, frame), (22, StreamState::Yields));
    assert_eq!(engine.frames(), 1);
}

#[test]
fn small_draws_within_an_error_are_the_same_on_any_number_of_threads() {
    let script = |quality: &str| {
        let mut script = "LOOKAT 3 3 4 0 0 0 0 1 0\nPERSPECTIVE 0.6 1 9\nMESH m BOX\n".to_owned();
        script += "LIGHT 0 DIR 0 -1 -1 1 1 1\n";
        (1..8).for_each(|i| script += &format!("LIGHT {i} DIR 0 -1 -1 0.01 0.01 0.01\n"));
        script += &format!("QUALITY {quality}\n");
        for frame in 0..3 {
            script += "CLEAR\n";
            for i in 0..9 {
                let [x, y] = [i % 3 - 1, i / 3 - 1];
                script += &format!("IDENTITY\nTRANSLATE {x} {y} 0\nROTATE 1 1 0 {frame}\nDRAW m\n");
            }
            script += "CRC\n";
        }
        script
    };
    let within = script("max-error 30");
    let alone = replies_of(&within, 1, usize::MAX, Pace::Free);
    for threads in [2, 3] {
        assert_eq!(replies_of(&within, threads, usize::MAX, Pace::Free), alone, "{threads} threads");
    }
    assert_ne!(alone, replies_of(&script("exact"), 1, usize::MAX, Pace::Free));
}

/// Returns an OBJ file with these corners and one face of all of them.
fn obj(corners: &[[f64; 3]]) -> String {
    let lines = corners.iter().map(|[x, y, z]| format!("v {x:e} {y:e} {z:e}\n"));
    let face: String = (1..=corners.len()).map(|i| format!(" {i}")).collect();
    format!("{}f{face}\n", lines.collect::<String>())
}

fn draw(setting: &str, obj: &str) -> String {
    let script =
        format!("{setting}\nMESH m OBJ :{}\n{obj}QUALITY max-error 40\nDRAW m\nSYNC end\n", obj.len());
    String::from_utf8(play(script.as_bytes(), usize::MAX, Audience::Connection).1.replies).unwrap()
}

#[test]
fn quality_bears_a_corner_at_the_end_of_the_range() {
    let corners = [[-1e308, -2.4, -3.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.5]];
    for setting in ["", "SHADE wire"] {
        let replies = draw(setting, &obj(&corners));
        assert!(replies.ends_with("SYNC end\n") && !replies.contains("ERR "), "{setting}: {replies}");
    }
}

#[test]
fn lines_bear_ends_that_no_pixel_holds() {
    let corners =
        [[0.0; 3], [2.538641780355495, 2.0929266199436105e-136, 0.0], [0.0, -1.3908630219965512, 0.0]];
    let setting = "SHADE wire\nCULL none\nLOOKAT 0 1.1102674947234016e-103 -1.734260416372793 0 0 0 0 1 0\nPERSPECTIVE 1 0e0 0e0\n\
        SCALE -1.9456990801196434 -3.1556175855094014e239 0";
    let replies = draw(setting, &obj(&corners));
    assert!(replies.ends_with("SYNC end\n") && !replies.contains("defect"), "{replies}");
}

/// Generates finite numbers as a command may have them, extreme values among them.
fn real() -> impl Strategy<Value = f64> {
    prop_oneof![
        4 => -3.0..3.0f64,
        2 => any::<u64>().prop_map(f64::from_bits).prop_filter("finite", |v| v.is_finite()),
        1 => prop::sample::select(vec![f64::MAX, -f64::MAX, 1e308, -1e308, 5e-324, -5e-324, -0.0, 1e154, -1e155, 1e39]),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, ..ProptestConfig::default() })]

    #[test]
    fn quality_bears_numbers_of_any_size(
        corners in prop::collection::vec([real(), real(), real()], 3..6),
        eye in [real(), real(), real()], range in [real(), real()], scale in [real(), real(), real()],
        shade in prop::sample::select(vec!["wire", "flat", "gouraud", "phong"]),
        camera in prop::sample::select(vec!["PERSPECTIVE 1", "ORTHO -2 2 -2 2", "FRUSTUM -1 1 -1 1", "PLANE 1"]),
    ) {
        let ([ex, ey, ez], [sx, sy, sz], [near, far]) = (eye, scale, range);
        let setting = format!(
            "SHADE {shade}\nCULL none\nLOOKAT {ex:e} {ey:e} {ez:e} 0 0 0 0 1 0\n{camera} {near:e} {far:e}\nSCALE {sx:e} {sy:e} {sz:e}",
        );
        // Many commands are refused, but none meets a defect of the server.
        let replies = draw(&setting, &obj(&corners));
        prop_assert!(replies.ends_with("SYNC end\n") && !replies.contains("defect"), "{}", replies);
    }
}

/// Returns areas large and small, and what may stand between them, on a frame of 280x190 pixels.
fn areas(seed: u32) -> String {
    let mut next = numbers(seed);
    let mut script = "AUTO off\n".to_owned();
    for i in 0..400 {
        let color = format!("{:06x}{:02x}", next(1 << 24), [255, 255, 90, 0][next(4) as usize]);
        let at = |v: u32| f64::from(v) / 4.0 - 40.0;
        let (x, y, w, h) = (at(next(1200)), at(next(900)), at(next(1200)) + 40.0, at(next(900)) + 40.0);
        script += &match next(16) {
            0..6 => format!("FILLRECT {x} {y} {w} {h} {color}\n"),
            6 | 7 => format!("FILLCIRCLE {x} {y} {} {color}\n", w / 2.0),
            8 => format!("FILL {x} {y} {w} {h} {h} {x} {color}\n"),
            9 => format!("FILLPOLY {color} {x} {y} {w} {h} {h} {x} {y} {w}\n"),
            10 => format!("FILLRECT {x} {y} 3 2 {color}\n"),
            11 => format!("FILLRECT {x} {y} -3 {h} {color}\n"),
            12 => format!("FILL 1e20 {y} -1e19 {h} {h} 3e25 {color}\n"),
            13 => ["BLEND over\n", "BLEND replace\n"][next(2) as usize].to_owned(),
            14 => ["CLIP 20 30 100 60\n", "CLIP\n", "PX 5 5\n"][next(3) as usize].to_owned(),
            _ => format!("LINE {i} 3 80 {i} {color}\n"),
        };
    }
    script + "STATS\nCRC\n"
}

#[test]
fn areas_drawn_in_bands_are_drawn_in_their_turn() {
    for seed in 0..12 {
        let script = areas(seed);
        let one_by_one = replies_of(&script, 1, script.len(), Pace::OneCommand);
        assert!(one_by_one.contains(" commands=402 "), "{one_by_one}");
        for (threads, pieces) in [(1, script.len()), (3, script.len()), (1, 999), (1, 64)] {
            let together = replies_of(&script, threads, pieces, Pace::Free);
            assert!(together == one_by_one, "{seed}, {threads} threads, pieces of {pieces}: {together}");
        }
    }
}

#[test]
fn areas_wait_for_one_another_and_no_longer_than_others_should() {
    let mut engine = Engine::new(280, 190).unwrap();
    let mut stream = Stream::new(&engine, 1, Audience::Connection);
    let mut out = Output::default();
    let script = "FILLRECT 0 0 280 190 ff0000\n".repeat(2000);
    let budget = Budget { until: Some(Instant::now()), ..Budget::NONE };
    let (used, state) = stream.feed(&mut engine, script.as_bytes(), &mut out, budget);
    assert_eq!(state, StreamState::Yields);
    // An estimate of 26,835 ns each, up to 8 ms.
    assert_eq!(used, 28 * 299);
    assert_eq!(stream.session().stats.commands, 299);
}

#[test]
#[cfg(debug_assertions)]
fn an_area_that_meets_a_defect_is_refused_at_its_place_and_the_others_are_drawn() {
    let mut engine = Engine::new(280, 190).unwrap();
    let mut stream = Stream::new(&engine, 1, Audience::Connection);
    let mut out = Output::default();
    engine.wanted_defect = Some("FILLCIRCLE");
    let script = b"FILLRECT 0 0 280 190 ff0000\nFILLCIRCLE 90 90 80 00ff00\nFILLRECT 0 100 280 90 0000ff\nPX 1 1\nPX 1 180\n";
    let _ = stream.feed(&mut engine, script, &mut out, Budget::NONE);
    let text = String::from_utf8(out.replies).unwrap();
    let lines: Vec<&str> = text.lines().collect();
    assert!(lines[0].starts_with("ERR 2 28 EFORMAT FILLCIRCLE: "), "{text}");
    assert_eq!(lines[1..], ["PX 1 1 ff0000", "PX 1 180 0000ff"]);
    let stats = stream.session().stats;
    assert_eq!((stats.commands, stats.errors), (5, 1));
}
