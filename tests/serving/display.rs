//! Display of frames by AUTO, PRESENT, EVENTS and stepping, with a test in place of the window.

use crate::support::Serving;
use fbptr::input::InputEvent;
use fbptr::server::{Display, DisplayObserver, Engine, Finish, RenderThread, ShownFrame};
use std::sync::Arc;
use std::time::{Duration, Instant};

fn shown(width: u32, height: u32) -> (Serving, Arc<Display>) {
    let display = Display::new(width, height);
    let mut engine = Engine::new(width, height).unwrap();
    engine.attach(DisplayObserver::new(display.clone()));
    (Serving::with(engine), display)
}

/// Reads frames as a window does until the pixel at the origin has this red; returns whether that
/// happened in time.
fn becomes_red(display: &Display, red: u8, patience: Duration) -> bool {
    let (mut window, until) = (ShownFrame::default(), Instant::now() + patience);
    while Instant::now() < until {
        display.copy_changes(window.version, &mut window);
        if window.bytes.first() == Some(&red) {
            return true;
        }
        std::thread::sleep(Duration::from_millis(1));
    }
    false
}

const SOON: Duration = Duration::from_secs(10);
const A_WHILE: Duration = Duration::from_millis(120);

#[test]
fn auto_follows_the_memory_and_off_shows_presents_alone() {
    let (serving, display) = shown(4, 4);
    let mut wire = serving.connect();
    wire.send(b"PX 0 0 110000\n");
    assert!(becomes_red(&display, 0x11, SOON));
    assert_eq!(wire.ask("AUTO off\nPX 0 0 220000\nSYNC a\n"), "SYNC a\n");
    assert!(!becomes_red(&display, 0x22, A_WHILE), "frozen");
    // Frames are shown as long as any connection asks for them.
    let mut other = serving.connect();
    other.send(b"AUTO on\nPX 0 0 330000\n");
    assert!(!becomes_red(&display, 0x33, A_WHILE));
    wire.send(b"PRESENT\n");
    assert!(becomes_red(&display, 0x33, SOON));
    wire.send(b"PX 0 0 440000\n");
    assert!(!becomes_red(&display, 0x44, A_WHILE));
    drop(wire);
    assert!(becomes_red(&display, 0x44, SOON), "its wish went with it");
}

#[test]
fn present_wait_answers_when_the_frame_is_on_the_screen_and_holds_the_rest_back() {
    let (serving, display) = shown(4, 4);
    let mut wire = serving.connect();
    wire.send(b"PX 0 0 110000\nPRESENT\nPX 0 0 220000\nPRESENT wait\nSYNC after\nPX 0 0 330000\n");
    assert!(becomes_red(&display, 0x22, SOON));
    wire.0.set_read_timeout(Some(A_WHILE)).unwrap();
    assert!(std::io::Read::read(&mut wire.0, &mut [0]).is_err(), "not on the screen yet");
    wire.0.set_read_timeout(Some(SOON)).unwrap();
    assert!(!becomes_red(&display, 0x33, A_WHILE), "what follows waits");
    display.note_shown(2);
    assert_eq!((wire.line(), wire.line()), ("FRAME 2\n".into(), "SYNC after\n".into()));
    assert!(becomes_red(&display, 0x33, SOON));
    // A closed window counts as one that shows every frame.
    wire.send(b"PRESENT wait\n");
    std::thread::sleep(Duration::from_millis(20));
    display.close();
    assert_eq!(wire.line(), "FRAME 3\n");
}

#[test]
fn events_reach_those_who_asked_and_no_one_else() {
    let (serving, display) = shown(4, 4);
    let (mut hears, mut deaf) = (serving.connect(), serving.connect());
    assert_eq!(hears.ask("EVENTS on\nSYNC a\n"), "SYNC a\n");
    assert_eq!(deaf.ask("SYNC b\n"), "SYNC b\n");
    assert!(display.has_listeners());
    display.send(InputEvent::Mouse { x: 3, y: 2, buttons: 1 });
    display.send(InputEvent::Key { name: "a".into(), down: true });
    display.close();
    assert_eq!(hears.line(), "EVENT mouse 3 2 1\n");
    assert_eq!(hears.line(), "EVENT key down a\n");
    assert_eq!(hears.line(), "EVENT close\n");
    assert_eq!(deaf.ask("SYNC c\n"), "SYNC c\n");
    assert_eq!(hears.ask("EVENTS off\nSYNC d\n"), "SYNC d\n");
    assert!(!display.has_listeners());
}

#[test]
fn a_paused_display_runs_nothing_but_steps() {
    let (serving, display) = shown(4, 4);
    display.set_paused(true);
    let mut wire = serving.connect();
    wire.send(b"PX 0 0 110000\nPX 0 0 220000\nAUTO off\nPX 0 0 330000\nPX 0 0 440000\nPRESENT\nPX 0 0 550000\nSYNC z\n");
    assert!(!becomes_red(&display, 0x11, A_WHILE));
    display.step();
    assert!(becomes_red(&display, 0x11, SOON));
    assert!(!becomes_red(&display, 0x22, A_WHILE), "one command a step");
    display.step();
    assert!(becomes_red(&display, 0x22, SOON));
    display.step();
    assert!(becomes_red(&display, 0x44, SOON), "AUTO off is no step; one frame a step from there");
    display.set_paused(false);
    assert_eq!(wire.line(), "SYNC z\n");
}

#[test]
fn a_step_is_one_frame_however_long_it_takes_and_however_it_comes() {
    let (serving, display) = shown(400, 400);
    display.set_paused(true);
    let mut wire = serving.connect();
    // More work than fits in a slice and more bytes than fit in one read.
    let frame = |red: u8| {
        let fills = "FILLRECT 0 0 400 400 000102\n".repeat(300);
        let pixels = "PX 1 1 00ff00\n".repeat(30_000);
        format!("{fills}{pixels}PX 0 0 {red:02x}0000\nPRESENT\n")
    };
    wire.send(b"AUTO off\n");
    let sender = std::thread::spawn(move || {
        for red in 1..=9 {
            wire.send(frame(red).as_bytes());
        }
        assert_eq!(wire.ask("SYNC end\n"), "SYNC end\n");
    });
    for red in 1..=9 {
        display.step();
        assert!(becomes_red(&display, red, SOON * 3), "step {red}");
    }
    assert!(!display.take_step(), "each step was taken once");
    display.step();
    sender.join().unwrap();
}

#[test]
fn depth_under_the_pointer_is_answered() {
    let (serving, display) = shown(16, 16);
    assert_eq!(serving.say("LIGHT 0 DIR 0 0 -1 1 1 1\nMESH b BOX\nDRAW b\nSYNC a\n"), "SYNC a\n");
    assert!(becomes_red(&display, 0, SOON));
    let until = Instant::now() + SOON;
    loop {
        let info = display.pixel_info(8, 8).unwrap();
        if let Some(depth) = info.depth {
            assert!(depth > 0.9 && depth < 1.0, "{depth}");
            break;
        }
        assert!(Instant::now() < until, "the render thread never answers");
        std::thread::sleep(Duration::from_millis(1));
    }
}

#[test]
fn an_in_process_client_presents_and_hears_of_its_errors() {
    let display = Display::new(8, 8);
    let mut engine = Engine::new(8, 8).unwrap();
    engine.attach(DisplayObserver::new(display.clone()));
    let thread = RenderThread::start(engine).unwrap();
    let client = thread.client();
    client.put_pixel(0, 0, [0x66, 0, 0, 255]);
    let window = std::thread::spawn({
        let display = display.clone();
        move || {
            assert!(becomes_red(&display, 0x66, SOON));
            let mut frame = ShownFrame::default();
            while frame.frame < 1 {
                display.copy_changes(frame.version, &mut frame);
            }
            display.note_shown(frame.frame);
        }
    });
    assert_eq!(client.present(), Ok(1));
    window.join().unwrap();
    client.draw("nothing");
    client.fill_rect([0, 0, -1, 1], [0; 4]);
    let fault = client.sync().unwrap_err();
    assert_eq!((fault.code.as_str(), fault.token.as_deref()), ("ENOENT", Some("nothing")));
    assert_eq!(client.sync(), Ok(()));
    drop(client);
    let engine = thread.finish_engine(Finish::WhenAllEnded);
    assert_eq!(engine.totals().errors, 2);
}
