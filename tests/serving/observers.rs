//! Observers of the engine from outside of the crate: they see every request once, with its end, and
//! the frames that are finished.

use crate::support::Serving;
use fbptr::command::Command;
use fbptr::memory::VideoMemory;
use fbptr::server::{Audience, Budget, Engine, Output, Session, Stream};
use fbptr_engine::engine::{Event, FrameView, Observer, Occasion, PendingRows, PixelRuns};
use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::{Arc, Mutex};

/// Counts and ends of requests, by verb.
#[derive(Clone, Debug, Default)]
struct Log(Arc<Mutex<Seen>>);

#[derive(Debug, Default)]
struct Seen {
    received: BTreeMap<&'static str, usize>,
    begins: usize,
    begun: Option<&'static str>,
    done: Vec<&'static str>,
    undone: Vec<&'static str>,
}

impl Observer for Log {
    fn event(&mut self, event: &Event<'_>, _: FrameView<'_>) {
        let seen = &mut *self.0.lock().unwrap();
        match event {
            Event::Received(request) => *seen.received.entry(request.verb()).or_default() += request.count(),
            Event::Begins { request, connection: 7, .. } => {
                seen.begins += 1;
                seen.begun = Some(request.verb());
            }
            Event::Done { connection: 7, .. } => seen.done.extend(seen.begun.take()),
            Event::Undone => seen.undone.extend(seen.begun.take()),
            _ => {}
        }
    }
}

#[test]
fn every_request_is_received_once_and_ends_once() {
    let log = Log::default();
    let mut engine = Engine::new(40, 30).unwrap();
    engine.attach(log.clone());
    let mut stream = Stream::new(&engine, 7, Audience::Connection);
    let script = [
        b"PX 1 1 ff0000\nPX 2 2 00ff00\nPX -3 1 0000ff\nPB\x01\x00\x01\x00abcdPB\x02\x00\x01\x00abcd"
            .as_slice(),
        b"LINE 0 0 9 9 ffffff\nLINE 0 9 9 0 ffffff\nBLIT 0 0 1 1 :4\nabcdBLIT 0 0 -1 1 :0\n",
        b"POINTS :8\nabcdefghMESH m BOX\nDRAW m\nDRAW none\nSIZE\nFOO\nPRESENT\n",
    ];
    let mut out = Output::default();
    for part in script {
        let _ = stream.feed(&mut engine, part, &mut out, Budget::NONE);
    }
    let seen = log.0.lock().unwrap();
    let received = [("BLIT", 1), ("DRAW", 2), ("LINE", 2), ("MESH", 1), ("PB", 2), ("POINTS", 1)];
    let received = received.into_iter().chain([("PRESENT", 1), ("PX", 3), ("SIZE", 1)]);
    assert_eq!(seen.received, received.collect());
    // The decoder refuses FOO and the second BLIT, so that they are no requests.
    assert_eq!(stream.session().stats.commands, 14 + 2);
    assert_eq!((&seen.undone[..], seen.begun), (&["DRAW"][..], None));
    assert_eq!(seen.begins, seen.done.len() + seen.undone.len());
    let mut done = seen.done.clone();
    done.dedup();
    assert_eq!(done, ["PX", "PB", "LINE", "BLIT", "POINTS", "MESH", "DRAW", "SIZE", "PRESENT"]);
}

#[test]
fn a_detached_observer_sees_nothing_more() {
    let log = Log::default();
    let mut engine = Engine::new(4, 3).unwrap();
    engine.attach(log.clone());
    assert!(engine.observer::<Log>().is_some());
    engine.detach::<Log>();
    assert!(engine.observer::<Log>().is_none());
    let mut session = Session::new(7, Audience::Owner);
    let _ = engine.run(&mut session, Command::Identity, &mut Vec::new()).unwrap();
    assert_eq!(log.0.lock().unwrap().received, BTreeMap::new());
}

/// Counts how often it is asked for pixels when it is attached.
#[derive(Clone, Debug, Default)]
struct Source(Arc<Mutex<usize>>);

impl Observer for Source {
    fn event(&mut self, _: &Event<'_>, _: FrameView<'_>) {}

    fn take_in(&mut self, memory: &mut VideoMemory, at: Occasion, _: Option<&mut PixelRuns>) -> bool {
        if let Occasion::Attached = at {
            *self.0.lock().unwrap() += 1;
            memory.put_pixel(1, 1, [9; 4]);
        }
        false
    }
}

#[test]
fn pixels_are_taken_in_from_the_observer_that_is_attached_and_from_no_other() {
    let source = Source::default();
    let mut engine = Engine::new(4, 3).unwrap();
    engine.attach(source.clone());
    engine.attach(Log::default());
    assert_eq!((*source.0.lock().unwrap(), engine.memory().get_pixel(1, 1).unwrap()), (1, [9; 4]));
}

const TILE: usize = 8;

/// Finds the tiles that differ between one finished frame and the next, as one would send them to
/// a viewer elsewhere.
#[derive(Debug, Default)]
struct Tiles {
    last: Vec<u8>,
    rows: PendingRows,
    /// Columns and rows of the changed tiles of each frame.
    frames: Arc<Mutex<Vec<Vec<[usize; 2]>>>>,
}

impl Observer for Tiles {
    fn event(&mut self, event: &Event<'_>, frame: FrameView<'_>) {
        match event {
            Event::Attached(_) => self.last = frame.memory.bytes().to_vec(),
            Event::Changed(rows) => self.rows.add(rows),
            Event::Presented => {
                let rows = self.rows.take();
                let (width, stride) = (frame.memory.width() as usize, frame.memory.stride_bytes());
                let mut changed = Vec::new();
                for y in rows.start as usize..rows.end as usize {
                    for x in (0..width).step_by(TILE) {
                        let bytes = y * stride + 4 * x..y * stride + 4 * width.min(x + TILE);
                        let tile = [x / TILE, y / TILE];
                        if self.last[bytes.clone()] != frame.memory.bytes()[bytes] && !changed.contains(&tile)
                        {
                            changed.push(tile);
                        }
                    }
                }
                self.last.copy_from_slice(frame.memory.bytes());
                self.frames.lock().unwrap().push(changed);
            }
            _ => {}
        }
    }
}

#[test]
fn changed_tiles_of_finished_frames_can_be_sent_elsewhere() {
    let tiles = Tiles::default();
    let frames = tiles.frames.clone();
    let mut engine = Engine::new(32, 24).unwrap();
    engine.attach(tiles);
    let serving = Serving::with(engine);
    let script = "PX 1 1 ff0000\nPX 30 20 00ff00\nPRESENT\nPRESENT\nFILLRECT 6 6 4 1 0000ff\nSYNC a\n\
                  PX 1 1 ff0000\nPRESENT\nPX 0 0 123456\nSYNC b\n";
    assert_eq!(serving.say(script), "SYNC a\nSYNC b\n");
    assert_eq!(*frames.lock().unwrap(), [vec![[0, 0], [3, 2]], vec![], vec![[0, 0], [1, 0]]]);
}

/// Rows that have changed, and the number of requests.
#[derive(Clone, Debug, Default)]
struct Rows(Arc<Mutex<(Vec<Range<u32>>, usize)>>);

impl Observer for Rows {
    fn event(&mut self, event: &Event<'_>, _: FrameView<'_>) {
        let (rows, requests) = &mut *self.0.lock().unwrap();
        match event {
            Event::Changed(changed) => rows.push(changed.clone()),
            Event::Begins { connection: 7, .. } => *requests += 1,
            _ => {}
        }
    }

    fn follows_figures(&self) -> bool {
        false
    }
}

#[test]
fn an_observer_of_rows_alone_is_sent_those_of_figures_that_are_drawn_together() {
    let figures: String =
        (0..5).map(|i| format!("FILLRECT {} {} 200 100 {i}0a0f0\n", 9 * i, 10 + 8 * i)).collect();
    let draw = |engine: &mut Engine| {
        let mut out = Output::default();
        let mut stream = Stream::new(engine, 7, Audience::Connection);
        let _ = stream.feed(engine, figures.as_bytes(), &mut out, Budget::NONE);
        engine.before_replies();
    };
    let [mut alone, mut followed] = [(); 2].map(|()| Engine::new(400, 300).unwrap());
    draw(&mut alone);
    let log = Rows::default();
    followed.attach(log.clone());
    followed.before_replies();
    log.0.lock().unwrap().0.clear();
    draw(&mut followed);
    {
        let (rows, requests) = &*log.0.lock().unwrap();
        assert!(rows.len() == 1 && rows[0] == (10..142) && *requests == 0, "{rows:?} {requests}");
    }
    assert!(followed.memory().bytes() == alone.memory().bytes());
    // Beside one that follows figures each is a request again.
    let all = Log::default();
    followed.attach(all.clone());
    draw(&mut followed);
    assert_eq!(all.0.lock().unwrap().done, ["FILLRECT"; 5]);
    followed.detach::<Log>();
    draw(&mut followed);
    assert_eq!((all.0.lock().unwrap().done.len(), log.0.lock().unwrap().1), (5, 5));
}
