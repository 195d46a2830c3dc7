//! Verifies that a long command of one client does not hold up the others, and that the commands
//! executed meanwhile appear in the recording in the order of execution.

use crate::folder::Folder;
use crate::support::{Numbers, Serving, Wire};
use fbptr::command::EndOfInput;
use fbptr::server::{Engine, Finish, Limits, Notice, Player, Recorder, RenderThread};
use std::io::{self, ErrorKind, Write};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Duration;

/// Returns limits under which even a slow machine gives up no command.
pub fn patient() -> Limits {
    Limits { command_time: Duration::from_secs(600), ..Limits::default() }
}

/// One client sends a pixel and a long command at once; another one, which has seen the pixel, asks
/// for a SYNC. The SYNC must be answered before the long command is. A server that runs the long
/// command in one go shows the pixel only when all is done.
fn overtakes(serving: &Serving, once: &str, long: &str) {
    let (mut busy, mut other) = (serving.connect(), serving.connect());
    assert_eq!(busy.ask(&format!("{once}PX 0 0 000000\nSYNC begin\n")), "SYNC begin\n");
    assert_eq!(other.ask("SYNC begin\n"), "SYNC begin\n");
    busy.send(format!("PX 0 0 123456\n{long}SYNC end\n").as_bytes());
    while other.ask("PX 0 0\n") != "PX 0 0 123456\n" {}
    assert_eq!(other.ask("SYNC me\n"), "SYNC me\n");
    busy.0.set_nonblocking(true).unwrap();
    let peeked = busy.0.peek(&mut [0]);
    assert_eq!(peeked.map_err(|e| e.kind()), Err(ErrorKind::WouldBlock), "{long:?} is over already");
    busy.0.set_nonblocking(false).unwrap();
    busy.0.set_read_timeout(Some(Duration::from_secs(600))).unwrap();
    let rest = busy.rest();
    assert!(rest.ends_with(b"SYNC end\n"), "{long:?} comes to its end");
    assert!(!rest.starts_with(b"ERR"), "{}", String::from_utf8_lossy(&rest[..rest.len().min(200)]));
}

#[test]
fn a_snapshot_of_noise_holds_nobody_up() {
    let serving = Serving::limited(2400, 2000, patient());
    let mut numbers = Numbers(9);
    let mut noise = format!("BLIT 0 0 2400 2000 :{}\n", 2400 * 2000 * 4).into_bytes();
    noise.extend((0..2400 * 2000).flat_map(|_| numbers.below(u32::MAX).to_le_bytes()));
    let mut wire = serving.connect();
    wire.send(&noise);
    assert_eq!(wire.ask("SYNC drawn\n"), "SYNC drawn\n");
    overtakes(&serving, "", "SNAP :\n");
}

#[test]
fn a_file_that_is_loaded_holds_nobody_up() {
    let folder = Folder::new("fairness-load");
    let mut obj = String::new();
    for i in 0..120_000 {
        obj += &format!("v {} {} {}\nv {i} 1 2\nv 3 {i} 4\nf -1 -2 -3\n", i % 7, i % 11, i % 13);
    }
    std::fs::write(folder.join("big.obj"), obj).unwrap();
    let mut engine = Engine::with_limits(64, 48, patient()).unwrap();
    engine.set_load_dir(fbptr::load::SandboxDir::open(folder.as_ref()).unwrap());
    overtakes(&Serving::with(engine), "", "LOAD MESH m big.obj\n");
}

#[test]
fn figures_in_pieces_hold_nobody_up() {
    let serving = Serving::limited(2048, 2048, patient());
    let fill = "FILL 1 1 2000 1 1 2000 ff000080 00ff0080 0000ff80\n".repeat(6);
    overtakes(&serving, "BLEND over\n", &fill);
    overtakes(&serving, "", &"COPY 0 0 2040 2040 5 5\n".repeat(40));
}

/// A recording in memory.
#[derive(Clone, Default)]
pub struct Sheet(Arc<Mutex<Vec<u8>>>);

impl Write for Sheet {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.lock().unwrap().extend_from_slice(bytes);
        Ok(bytes.len())
    }
    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// Returns a server that records into memory.
pub fn recorded(width: u32, height: u32, limits: Limits) -> (Serving, Sheet) {
    let sheet = Sheet::default();
    let mut engine = Engine::with_limits(width, height, limits).unwrap();
    engine.attach(Recorder::new(Box::new(sheet.clone()), width, height).unwrap());
    (Serving::with(engine), sheet)
}

/// Stops the server and plays its recording; returns the bytes of both frames.
pub fn live_and_replayed(serving: Serving, sheet: &Sheet, width: u32, height: u32) -> [Vec<u8>; 2] {
    let engine = serving.server.shut_down(Duration::from_secs(20));
    let live = engine.memory().bytes().to_vec();
    drop(engine);
    let recording = sheet.0.lock().unwrap().clone();
    let thread = RenderThread::start(Engine::new(width, height).unwrap()).unwrap();
    let input = Box::new(io::Cursor::new(recording));
    // A draw that shows nothing is valid, live and in the replay.
    let tell = |notice| {
        let is_remark = matches!(notice, Notice::Remark { .. });
        assert!(is_remark, "refused commands are not in a recording: {notice:?}");
    };
    let player = Player::start(&thread, input, Box::new(io::sink()), EndOfInput::File, tell).unwrap();
    player.wait();
    [live, thread.finish(Finish::WhenAllEnded).bytes().to_vec()]
}

#[test]
fn a_recording_of_long_and_short_commands_of_three_replays_to_the_same_bytes() {
    const SIZE: (u32, u32) = (1100, 900);
    for seed in [3, 77] {
        let (serving, sheet) = recorded(SIZE.0, SIZE.1, patient());
        let client = |who: u32| {
            let mut numbers = Numbers(seed * 1000 + who);
            let mut wire = Wire::connect(serving.address);
            wire.send(b"ERRORS count\nLOOKAT 0 0 6 0 0 0 0 1 0\nLIGHT 0 DIR 0 0 -1 1 1 1\n");
            for step in 0..40 {
                let mut n = |limit| numbers.below(limit);
                let color = format!("{:06x}{:02x}", n(1 << 24), 64 + n(190));
                let command = match n(16) {
                    0 => format!("FILL {} -20 2000 {} -30 1500 {color} 00ff0090 0000ff\n", n(900), n(900)),
                    1 => format!("FILLPOLY {color} {} 0 1100 {} 3 900 {} 5\n", n(1100), n(900), n(900)),
                    2 => format!("FILLCIRCLE {} {} {} {color}\n", n(1100), n(900), 700 + n(500)),
                    3 => format!("COPY 0 {} 1000 700 {} {}\n", n(150), n(90), n(150)),
                    4 => format!("TEXT {} {} {color} :300000\n{}", n(900), n(400), "W\u{e9}".repeat(100_000)),
                    5 => format!("CLEAR {color}\n"),
                    6 => format!("MESH @m KNOT {} {}\n", 20 + n(100), 10 + n(30)),
                    7 => "FREE @m\n".to_owned(),
                    8 | 9 => "DRAW @m\n".to_owned(),
                    10 => format!("ROTATE 0 1 0 0.{}\n", n(100)),
                    11 => format!("BLEND {}\n", if n(2) == 0 { "over" } else { "replace" }),
                    12 => format!("QUALITY {}\n", if n(2) == 0 { "max-error 6" } else { "exact" }),
                    13 => "READ 0 0 1100 900\n".to_owned(),
                    14 => "CRC\nPX 3 4\nSNAP :\n".to_owned(),
                    _ => (0..200).map(|_| format!("PX {} {} {color}\n", n(1100), n(900))).collect(),
                };
                wire.send(command.as_bytes());
                if step % 8 == 7 {
                    // So that replies are read from time to time.
                    let mark = format!("SYNC {who}.{step}\n");
                    wire.send(mark.as_bytes());
                    read_to(&mut wire, mark.as_bytes());
                }
            }
        };
        std::thread::scope(|scope| (1..=3).for_each(|who| drop(scope.spawn(move || client(who)))));
        let [live, replayed] = live_and_replayed(serving, &sheet, SIZE.0, SIZE.1);
        assert!(live == replayed, "seed {seed}: the replay has other bytes");
    }
}

/// Reads replies up to and including this last one.
pub fn read_to(wire: &mut Wire, mark: &[u8]) {
    let mut tail = Vec::new();
    wire.0.set_read_timeout(Some(Duration::from_secs(600))).unwrap();
    let mut buffer = vec![0; 1 << 16];
    while !tail.ends_with(mark) {
        let count = match io::Read::read(&mut wire.0, &mut buffer) {
            // An interrupted read, such as that of a process stopped and continued, is not the end.
            Err(e) if e.kind() == ErrorKind::Interrupted => continue,
            count => count.unwrap(),
        };
        assert!(count > 0, "the server has closed");
        tail.extend_from_slice(&buffer[..count]);
        tail.drain(..tail.len().saturating_sub(mark.len()));
    }
}

#[test]
fn a_job_past_the_limit_of_time_is_given_up_without_effect() {
    let limits = Limits { command_time: Duration::from_millis(1), ..Limits::default() };
    let (serving, sheet) = recorded(64, 48, limits);
    let stream = "MESH m KNOT 1200 400\nSYNC after\nDRAW m\nPX 3 4 00ff00\nSYNC end\n";
    let replies = serving.say(stream);
    let lines: Vec<&str> = replies.lines().collect();
    assert!(lines[0].starts_with("ERR 1 0 EQUOTA MESH: given up after 0.001 s, without effect"), "{replies}");
    assert_eq!(lines[1], "SYNC after");
    assert!(lines[2].contains("ENOENT DRAW"), "{replies}");
    assert_eq!(lines[3..], ["SYNC end"], "{replies}");
    let [live, replayed] = live_and_replayed(serving, &sheet, 64, 48);
    assert!(live == replayed);
    assert_eq!(live[4 * (4 * 64 + 3)..][..4], [0, 255, 0, 255], "what follows is drawn");
}

#[test]
fn a_command_in_pieces_past_the_limit_of_time_is_recorded_as_it_stands() {
    const SIZE: (u32, u32) = (2000, 3000);
    let limits = Limits { command_time: Duration::from_micros(500), ..Limits::default() };
    let (serving, sheet) = recorded(SIZE.0, SIZE.1, limits.for_frame(SIZE.0, SIZE.1));
    let mut wire = serving.connect();
    let fill = "BLEND over\nFILL -1 -1 9000 -1 -1 9000 ff000080 00ff0080 0000ff80\n";
    let reply = wire.ask(fill);
    assert!(reply.starts_with("ERR 2 11 EQUOTA FILL: given up after 0.0005 s, after "), "{reply}");
    assert!(reply.contains(" of 3000 rows"), "{reply}");
    let reply = wire.ask("READ 0 0 2000 3000\n");
    assert!(reply.contains("EQUOTA READ: given up after 0.0005 s, without effect"), "{reply}");
    assert_eq!(wire.ask("PX 1999 2999 00ff00\nBLEND replace\nSYNC end\n"), "SYNC end\n");
    drop(wire);
    let [live, replayed] = live_and_replayed(serving, &sheet, SIZE.0, SIZE.1);
    assert!(live[..4] != [0, 0, 0, 255] && live[live.len() - 8..][..4] == [0, 0, 0, 255], "a part was drawn");
    assert!(live == replayed, "the replay has other bytes");
}

#[test]
fn a_client_that_goes_while_its_job_runs_leaves_nothing() {
    let serving = Serving::start(64, 48);
    for _ in 0..3 {
        let mut wire = serving.connect();
        wire.send(b"MESH m KNOT 900 300\nSYNC never read\n");
        wire.reset();
    }
    let until = std::time::Instant::now() + Duration::from_secs(20);
    while !serving.say("STATS\n").contains(" connections=1 ") {
        assert!(std::time::Instant::now() < until, "{}", serving.say("STATS\n"));
        std::thread::sleep(Duration::from_millis(5));
    }
    assert_eq!(
        serving.say("LIGHT 0 DIR 0 0 -1 1 1 1\nMESH m KNOT 500 100\nDRAW m\nSYNC end\n"),
        "SYNC end\n"
    );
}

/// Sets a flag at the end of its scope, also after a failure.
struct SetAtEnd<'a>(&'a AtomicBool);

impl Drop for SetAtEnd<'_> {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Relaxed);
    }
}

#[test]
fn payloads_that_do_not_arrive_delay_nobody_until_they_end() {
    draw_beside_payloads_that_do_not_arrive(0);
}

#[test]
fn payloads_that_do_not_arrive_delay_nobody_until_they_end_beside_small_commands() {
    draw_beside_payloads_that_do_not_arrive(3);
}

/// The server reads few large payloads at a time. Those of clients that stop in the middle, or send
/// a little now and then, must not delay the others until they end, also where `floods` other
/// clients send small commands at full speed.
fn draw_beside_payloads_that_do_not_arrive(floods: usize) {
    let serving = Serving::limited(1920, 1080, patient());
    let frame = |grey: u8| {
        let mut bytes = format!("BLIT 0 0 1920 1080 :{}\n", 1920 * 1080 * 4).into_bytes();
        bytes.resize(bytes.len() + 1920 * 1080 * 4, grey);
        bytes
    };
    let begun = |grey: u8| {
        let mut wire = serving.connect();
        let (bytes, sent) = (frame(grey), 2 << 20);
        wire.send(&bytes[..sent]);
        (wire, bytes, sent)
    };
    let mut stopped: Vec<_> = (1..9).map(begun).collect();
    let mut slow: Vec<_> = (9..12).map(begun).collect();
    let ended = AtomicBool::new(false);
    std::thread::scope(|scope| {
        for _ in 0..floods {
            let (mut wire, ended) = (serving.connect(), &ended);
            scope.spawn(move || {
                let pixels = "PX 1 1 ff0000\n".repeat(20_000);
                while !ended.load(Ordering::Relaxed) {
                    wire.send(pixels.as_bytes());
                }
            });
        }
        scope.spawn(|| {
            while !ended.load(Ordering::Relaxed) {
                for (wire, bytes, sent) in &mut slow {
                    let end = (*sent + 1_000).min(bytes.len() - 1);
                    wire.send(&bytes[*sent..end]);
                    *sent = end;
                }
                std::thread::sleep(Duration::from_millis(1));
            }
        });
        let _end = SetAtEnd(&ended);
        for grey in 100..104 {
            let mut wire = serving.connect();
            wire.send(&frame(grey));
            assert_eq!(wire.ask("SYNC drawn\n"), "SYNC drawn\n");
            assert_eq!(serving.memory().get_pixel(7, 7), Ok([grey; 4]));
        }
    });
    // What was left off comes to its end, too.
    for (wire, bytes, sent) in stopped.iter_mut().chain(&mut slow) {
        wire.send(&bytes[*sent..]);
        assert_eq!(wire.ask("SYNC drawn\n"), "SYNC drawn\n");
        assert_eq!(serving.memory().get_pixel(7, 7), Ok([bytes[bytes.len() - 1]; 4]));
    }
}
