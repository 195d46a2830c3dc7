//! Commands in pieces are those in one: bytes, replies, counts and refusals.

mod verbs;

use super::*;
use crate::engine::Progress;
use crate::{Audience, Limits};
use fbptr_command::{AreaColors, RealRect};
use fbptr_core::draw2d::{self, Blend};

const SIZE: (u32, u32) = (700, 330);

/// Creates an engine whose frame has a different value at each place.
fn engine() -> Engine {
    let mut engine = Engine::new(SIZE.0, SIZE.1).unwrap();
    for (i, byte) in engine.framebuffer.memory.bytes_mut().iter_mut().enumerate() {
        *byte = (i * 37 + i / 251) as u8;
    }
    engine.framebuffer.memory.take_damage();
    engine
}

fn rect_of_clip() -> Rect {
    Rect { x: 100, y: 50, w: 501, h: 203 }
}

fn commands() -> Vec<Command> {
    let [a, b, c] = [[255, 0, 9, 200], [0, 255, 0, 90], [3, 4, 255, 255]];
    let rect = |x, y, w, h| Rect { x, y, w, h };
    let fill = |points| Command::Figure(Figure::Fill { points, colors: AreaColors::Three([a, b, c]) });
    let records = (0..300_000u32).flat_map(|i| {
        let [x, y] = [i * 7 % 720, i * 13 % 340].map(|v| (v as u16).to_le_bytes());
        [x[0], x[1], y[0], y[1], i as u8, 7, 9, 100]
    });
    vec![
        fill([[-30.0, -20.0], [900.0, 10.0], [40.5, 600.25]]),
        fill([[-3e9, -2e9], [3e9, 1.5], [-1.25, 4e9]]),
        Command::Figure(Figure::Fill {
            points: [[0.5, 0.5], [690.0, 7.0], [5.0, 329.0]],
            colors: AreaColors::One(b),
        }),
        Command::Figure(Figure::FillPoly {
            color: b,
            points: vec![[0.0, 0.0], [699.0, 300.0], [3.0, 320.0], [600.0, 9.5]],
        }),
        Command::Figure(Figure::FillRect { rect: rect(-5, 7, 400, 300).into(), color: b }),
        Command::Figure(Figure::FillRect { rect: RealRect { x: 0.25, y: -1e9, w: 699.5, h: 2e9 }, color: b }),
        Command::Figure(Figure::FillCircle { cx: 300.25, cy: 100.5, r: 250.0, color: a }),
        Command::Figure(Figure::FillEllipse { center: [300.25, 100.5], radii: [400.0, 250.0], color: a }),
        Command::Figure(Figure::Ellipse { center: [300.25, 100.5], radii: [290.0, 150.0], color: a }),
        Command::Figure(Figure::Arc {
            center: [300.25, 100.5],
            radii: [20.0, 350.0],
            angles: [-1.0, 3.5],
            color: a,
        }),
        Command::Figure(Figure::WideLine { p0: [-30.0, 20.5], p1: [720.0, 300.0], width: 90.5, color: b }),
        Command::Figure(Figure::Bezier {
            points: [[3.0, 4.0], [900.0, 20.0], [-200.0, 300.0], [690.0, 310.0]],
            width: 40.0,
            color: b,
        }),
        Command::Figure(Figure::Poly { color: a, points: vec![[-9, 4], [699, 300], [3, 800], [650, -20]] }),
        Command::Figure(Figure::Circle { cx: 300, cy: 100, r: 250, color: a }),
        Command::Figure(Figure::LineAa { p0: [-3.5, 7.25], p1: [720.0, 300.5], color: a }),
        Command::Figure(Figure::Print { x: 3, y: 9, color: a, text: "W\u{e9}g Q".repeat(300) }),
        Command::Blit {
            rect: rect(-20, 13, 610, 300),
            rgba: (0..610 * 300 * 4).map(|i| (i / 7) as u8).collect(),
        },
        Command::PixelRun { x: 13, y: 40, rgba: (0..700 * 400 * 4).map(|i| (i / 5) as u8).collect() },
        Command::Peek { offset: 0, n: 700 * 330 * 4 },
        Command::Peek { offset: 9, n: 300_001 },
        Command::Clear { color: c },
        Command::Copy { source: rect(3, 0, 600, 300), dx: 9, dy: 11 },
        Command::Copy { source: rect(3, 20, 600, 300), dx: 1, dy: -40 },
        Command::Copy { source: rect(3, 20, 600, 300), dx: 7, dy: 20 },
        Command::Points { packed: records.collect() },
        Command::Figure(Figure::Text {
            x: -20,
            y: 3,
            color: a,
            utf8: ("W\u{e9}g\r\u{1f600}Q".repeat(4000) + "\nabc").into_bytes(),
        }),
        Command::Read { rect: rect(10, 20, 600, 300) },
        Command::Crc { rect: None },
        Command::Crc { rect: Some(rect(10, 20, 600, 300)) },
    ]
}

#[test]
fn a_command_in_pieces_is_the_command_in_one() {
    let clip = Some(rect_of_clip());
    for (blend, clip) in [(Blend::Replace, None), (Blend::Over, None), (Blend::Over, clip)] {
        for command in commands() {
            let [mut whole, mut cut] = [(); 2].map(|()| (engine(), Session::new(1, Audience::Owner)));
            (whole.1.surfaces.clip, cut.1.surfaces.clip) = (clip, clip);
            (whole.1.blend, cut.1.blend) = (blend, blend);
            let (mut want, mut got) = (Vec::new(), Vec::new());
            let _ = whole.0.run(&mut whole.1, command.clone(), &mut want).unwrap();
            let mut pieces = cut.0.begin_in_pieces(&mut cut.1, command.clone()).unwrap();
            let mut count = 1;
            let budget = Budget { until: Some(Instant::now()), ..Budget::NONE };
            while let Progress::Pieces(rest) = cut.0.run_pieces(&mut cut.1, pieces, &mut got, budget).unwrap()
            {
                (pieces, count) = (*rest, count + 1);
            }
            let may_be_one = matches!(command, Command::Crc { .. } | Command::PixelRun { .. });
            assert!(count > 1 || may_be_one, "{} is one piece", command.verb());
            assert!(whole.0.memory().bytes() == cut.0.memory().bytes(), "{} {blend:?}", command.verb());
            assert!(want == got, "{} {blend:?}: the replies differ", command.verb());
            // The door counts commands before it prepares their pieces.
            cut.1.stats.commands += 1;
            assert_eq!(whole.1.stats, cut.1.stats, "{}", command.verb());
            let damage = whole.0.framebuffer.memory.take_damage();
            assert_eq!(damage, cut.0.framebuffer.memory.take_damage(), "{}", command.verb());
            assert_eq!(cut.0.memory().window(), 0..SIZE.1);
        }
    }
}

/// Runs a command in pieces; returns the largest number of pixels in the rows that a piece wrote.
fn most_in_a_piece(engine: &mut Engine, s: &mut Session, command: Command) -> u64 {
    let mut pieces = engine.begin_in_pieces(s, command).expect("it has pieces");
    let (budget, mut most) = (Budget { until: Some(Instant::now()), ..Budget::NONE }, 0);
    loop {
        let rest = engine.run_pieces(s, pieces, &mut Vec::new(), budget).expect("is not refused");
        // A canvas has its own damage.
        s.surfaces.swap_target(&mut engine.framebuffer);
        let rows = engine.framebuffer.memory.take_damage();
        let width = u64::from(engine.framebuffer.width());
        s.surfaces.swap_target(&mut engine.framebuffer);
        most = most.max(u64::from(rows.end.saturating_sub(rows.start)) * width);
        match rest {
            Progress::Pieces(rest) => pieces = *rest,
            _ => return most,
        }
    }
}

#[test]
fn a_stamp_in_pieces_is_that_in_one_and_no_piece_draws_many_pixels() {
    let make = |name: &str, w, h| Command::Canvas { name: name.into(), w, h };
    let target = |name: &str| Command::Target { name: Some(name.into()) };
    let places =
        [[0, 0], [13, 40], [-20, 90], [5, -70], [-9, 0], [9, 0], [600, 250], [i32::MAX, 7], [7, i32::MIN]];
    let keys = [None, Some([37, 74, 111, 148])];
    let clips = [None, Some(rect_of_clip())];
    for (at, key) in places.into_iter().flat_map(|at| keys.map(|key| (at, key))) {
        for (clip, on) in
            clips.into_iter().flat_map(|clip| [None, Some("own"), Some("b")].map(|on| (clip, on)))
        {
            let command = Command::Stamp { name: "own".into(), x: at[0], y: at[1], key };
            let mut sides = [(); 2].map(|()| (engine(), Session::new(1, Audience::Owner)));
            for (engine, s) in &mut sides {
                for command in [make("own", 610, 300), make("b", 620, 310), target("own")] {
                    let _ = engine.run(s, command, &mut Vec::new()).unwrap();
                }
                s.surfaces.swap_target(&mut engine.framebuffer);
                let bytes = engine.framebuffer.memory.bytes_mut();
                bytes.iter_mut().enumerate().for_each(|(i, byte)| *byte = (i * 37 + i / 999) as u8);
                s.surfaces.swap_target(&mut engine.framebuffer);
                s.surfaces.set_target(on.map(str::to_owned)).unwrap();
                (s.surfaces.clip, s.blend) = (clip, Blend::Over);
                s.surfaces.swap_target(&mut engine.framebuffer);
                engine.framebuffer.memory.take_damage();
                s.surfaces.swap_target(&mut engine.framebuffer);
            }
            let [whole, cut] = &mut sides;
            // Against a stamp of a copy of the canvas, made at once.
            whole.1.surfaces.swap_target(&mut whole.0.framebuffer);
            let source = match on {
                Some("own") => whole.0.framebuffer.memory.clone(),
                _ => whole.1.surfaces.canvas("own").unwrap().clone(),
            };
            let memory = &mut whole.0.framebuffer.memory;
            if let Some(Rect { x, y, w, h }) = clip {
                memory.set_clip(x as u32..(x + w) as u32, y as u32..(y + h) as u32);
            }
            let rect = Rect { x: at[0], y: at[1], w: 610, h: 300 };
            draw2d::stamp(memory, rect, source.bytes(), key, Blend::Over).unwrap();
            let want = memory.bytes().to_vec();
            let most = most_in_a_piece(&mut cut.0, &mut cut.1, command.clone());
            assert!(most <= 1 << 15, "{most} pixels in a piece");
            cut.1.surfaces.swap_target(&mut cut.0.framebuffer);
            assert!(cut.0.framebuffer.memory.bytes() == want, "{at:?} {key:?} {clip:?} on {on:?}");
        }
    }
    // The estimate looks at the target, not at the frame.
    let (mut engine, mut s) = (Engine::new(8, 8).unwrap(), Session::new(1, Audience::Owner));
    for command in [make("big", 4000, 4000), target("big")] {
        let _ = engine.run(&mut s, command, &mut Vec::new()).unwrap();
    }
    engine.may_suspend = true;
    for command in [
        Command::Stamp { name: "big".into(), x: 1, y: 1, key: None },
        Command::Clear { color: [1; 4] },
        Command::Crc { rect: None },
    ] {
        let verb = command.verb();
        let begun = engine.begin(&mut s, Request::Command(command), &mut Vec::new()).unwrap();
        let Progress::Pieces(pieces) = begun else { panic!("{verb} on a large canvas is not in pieces") };
        engine.abandon(&mut s, verb, *pieces);
    }
}

#[test]
fn what_is_refused_is_refused_as_a_whole() {
    let rect = |x, y, w, h| Rect { x, y, w, h };
    let mut utf8 = vec![b'a'; 100_000];
    utf8[90_000] = 0xff;
    for command in [
        Command::Copy { source: rect(0, 100, 600, 300), dx: 1, dy: 2 },
        Command::Read { rect: rect(0, -1, 5, 5) },
        Command::Crc { rect: Some(rect(0, 0, -1, 5)) },
        Command::Figure(Figure::FillRect { rect: rect(0, 0, 5, -5).into(), color: [1; 4] }),
        Command::Points { packed: vec![0; 8 * 200_000 + 1] },
        Command::PixelRun { x: 1, y: 1, rgba: vec![7; 4 * 200_000 + 1] },
        Command::Blit { rect: rect(1, 1, 600, 300), rgba: vec![7; 5] },
        Command::Peek { offset: 16, n: 700 * 330 * 4 },
        Command::Peek { offset: -1, n: 1 },
        Command::Figure(Figure::Text { x: 0, y: 0, color: [1; 4], utf8 }),
    ] {
        let (mut engine, mut session, mut out) = (engine(), Session::new(1, Audience::Owner), Vec::new());
        let before = engine.framebuffer.memory.bytes().to_vec();
        let want = engine.run(&mut session, command.clone(), &mut out).unwrap_err();
        let pieces = engine.begin_in_pieces(&mut session, command.clone()).unwrap();
        let got = engine.run_pieces(&mut session, pieces, &mut out, Budget::NONE).unwrap_err();
        assert_eq!((got, out.len()), (want, 0), "{}", command.verb());
        assert!(engine.framebuffer.memory.bytes() == before, "{} has drawn", command.verb());
        assert_eq!(session.stats.errors, 2);
    }
}

#[test]
fn the_limit_of_replies_is_the_same_in_pieces() {
    let rect = Rect { x: 0, y: 0, w: 600, h: 300 };
    // Room for the pixels, and not for the line before them.
    let limits = Limits { reply_bytes: 600 * 300 * 4 + 5, ..Limits::default() };
    let mut engine = Engine::with_limits(SIZE.0, SIZE.1, limits).unwrap();
    let (mut session, mut out) = (Session::new(1, Audience::Owner), Vec::new());
    let want = engine.run(&mut session, Command::Read { rect }, &mut out).unwrap_err();
    let pieces = engine.begin_in_pieces(&mut session, Command::Read { rect }).unwrap();
    let got = engine.run_pieces(&mut session, pieces, &mut out, Budget::NONE).unwrap_err();
    assert_eq!((got, out.len()), (want, 0));
}
