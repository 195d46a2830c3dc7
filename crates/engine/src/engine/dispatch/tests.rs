//! Tests of the door: the ends of requests that meet a defect.

use super::*;
use crate::engine::{FrameView, Observer};
use crate::{Audience, Output, Stream};
use fbptr_command::{Figure, RealRect, Rect};
use fbptr_core::memory::MemoryUse;
use std::sync::{Arc, Mutex};

/// The events of requests, by their names.
#[derive(Clone, Debug, Default)]
struct Log(Arc<Mutex<Vec<&'static str>>>);

impl Observer for Log {
    fn event(&mut self, event: &Event<'_>, _: FrameView<'_>) {
        self.0.lock().unwrap().push(match event {
            Event::Begins { .. } => "begins",
            Event::Done { .. } => "done",
            Event::Undone => "undone",
            Event::Pixels(_) => "pixels",
            _ => return,
        });
    }
}

impl Log {
    fn take(&self) -> Vec<&'static str> {
        std::mem::take(&mut *self.0.lock().unwrap())
    }
}

fn engine_with_log(width: u32, height: u32) -> (Engine, Session, Log) {
    let (mut engine, log) = (Engine::new(width, height).unwrap(), Log::default());
    engine.attach(log.clone());
    (engine, Session::new(7, Audience::Owner), log)
}

#[test]
fn a_defect_ends_its_request_and_no_other_for_commands_as_for_batches() {
    let fill = "FILLRECT 0 0 9 9 ff0000\n";
    let cases: [(&str, &[u8]); 8] = [
        ("FILLRECT", fill.as_bytes()),
        ("READ", b"READ 0 0 100 90\n"),
        ("PX", b"PX 1 1 ff0000\nPX 2 2 00ff00\n"),
        ("PB", b"PB\x01\x00\x01\x00abcdPB\x02\x00\x01\x00abcd"),
        ("PXMULTI", b"PXMULTI\x00\x00\x00\x00\x01\x00\x00\x00abcd"),
        ("LINE", b"LINE 0 0 9 9 ffffff\nLINE 0 9 9 0 ffffff\n"),
        ("BLIT", b"BLIT 0 0 1 1 :4\nabcd"),
        ("POINTS", b"POINTS :8\n\x01\x00\x01\x00abcd"),
    ];
    for (verb, script) in cases {
        let (mut engine, _, log) = engine_with_log(100, 90);
        let mut stream = Stream::new(&engine, 7, Audience::Connection);
        let mut out = Output::default();
        engine.wanted_defect = Some(verb);
        let _ = stream.feed(&mut engine, script, &mut out, Budget::NONE);
        assert_eq!(log.take(), ["begins", "undone", "pixels"], "{verb}");
        assert_eq!(engine.memory_budget().used_for(MemoryUse::Replies), 0, "{verb}");
        assert_eq!(stream.session().stats.errors, 1, "{verb}");
        engine.wanted_defect = None;
        let _ = stream.feed(&mut engine, script, &mut out, Budget::NONE);
        assert_eq!(log.take(), ["begins", "done"], "{verb}");
        let _ = stream.feed(&mut engine, b"SYNC end\n", &mut out, Budget::NONE);
        assert!(out.replies.ends_with(b"SYNC end\n"), "{verb}");
        assert_eq!(stream.session().stats.errors, 1, "{verb}");
    }
}

#[test]
fn small_draws_wait_for_others_where_threads_share_them() {
    let script = b"MESH b BOX\nDRAW b\nTRANSLATE 1 0 0\nDRAW b\n";
    let done = ["begins", "done"];
    for (threads, waits) in [(1, false), (2, true)] {
        let (mut engine, _, log) = engine_with_log(40, 30);
        let pool = crate::worker_pool(Some(threads));
        let options = fbptr_core::pipeline::RenderOptions { pool, ..Default::default() };
        engine.set_renderer(fbptr_core::pipeline::Renderer::new(options));
        let mut stream = Stream::new(&engine, 7, Audience::Connection);
        let mut out = Output::default();
        let _ = stream.feed(&mut engine, script, &mut out, Budget::NONE);
        let drawn = if waits { ["begins", "undone"] } else { done };
        let mut want = [done, drawn, done, drawn].concat();
        if waits {
            // Both are drawn at the end of the slice.
            want.extend([done, done].concat());
        }
        assert_eq!(log.take(), want, "{threads} threads");
        assert!(stream.session().stats.pixels > 0 && out.replies.is_empty());
        // A defect leaves nothing to be drawn later.
        engine.wanted_defect = Some("DRAW");
        let _ = stream.feed(&mut engine, b"DRAW b\n", &mut out, Budget::NONE);
        assert_eq!(log.take()[..2], ["begins", "undone"]);
        assert_eq!(stream.session().stats.errors, 1);
    }
}

#[test]
fn what_a_job_leaves_to_do_ends_when_it_meets_a_defect() {
    let (mut engine, mut session, log) = engine_with_log(4, 3);
    let apply = |engine: &mut Engine, _: &mut Session, replies: &mut Vec<u8>| {
        replies.extend_from_slice(b"half a reply");
        engine.framebuffer.memory.clear([1, 2, 3, 4]);
        panic!("a defect for a test")
    };
    let mut replies = b"earlier".to_vec();
    let result = JobResult::new(Command::Identity, Ok(apply));
    let fault = engine.apply(&mut session, result, &mut replies).unwrap_err();
    assert_eq!((fault.code, replies.as_slice()), (Code::Format, b"earlier".as_slice()));
    assert_eq!((log.take(), session.stats.errors), (vec!["begins", "undone", "pixels"], 1));
}

#[test]
fn a_piece_that_meets_a_defect_ends_the_command_and_its_band() {
    let rect = RealRect::from(Rect { x: 0, y: 0, w: 700, h: 300 });
    for (command, width) in [
        (Command::Figure(Figure::FillRect { rect, color: [9; 4] }), 700),
        (Command::Clear { color: [9; 4] }, 700),
        (Command::Points { packed: vec![0; 80] }, 7),
    ] {
        let (mut engine, mut session, log) = engine_with_log(width, 300);
        let verb = command.verb();
        engine.wanted_defect = Some(verb);
        let pieces = engine.begin_in_pieces(&mut session, command).expect("it has pieces");
        let mut replies = Vec::new();
        let ended = engine.run_pieces(&mut session, pieces, &mut replies, Budget::NONE);
        assert_eq!(ended.unwrap_err().code, Code::Format, "{verb}");
        // It would begin at its end.
        assert_eq!((log.take(), session.stats.errors), (vec!["pixels"], 1), "{verb}");
        assert_eq!(engine.memory().window(), 0..300, "{verb}");
    }
}
