//! The page in the browser, as a browser sees it: frames, rights, events, and clients that behave
//! badly.

mod page;

use crate::support::Numbers;
use fbptr::server::{Engine, Limits, WebTokens};
use page::{PATIENCE, Page, Site};
use std::io::Write;
use std::net::TcpStream;
use std::time::{Duration, Instant};
use tungstenite::Message;
use tungstenite::client::IntoClientRequest;

#[test]
fn each_frame_is_the_memory_at_its_present_byte_for_byte() {
    let site = Site::start(150, 131);
    let (mut client, mut page, mut numbers) = (site.connect(), site.watch(), Numbers(7));
    client.send(b"AUTO off\n");
    for frame in 1..=40u64 {
        for _ in 0..numbers.below(60) {
            let [x, y] = [numbers.below(170), numbers.below(150)];
            client.send(format!("PX {x} {y} {:08x}\n", numbers.below(u32::MAX)).as_bytes());
        }
        if numbers.below(u32::MAX).is_multiple_of(4) {
            let [x, y] = [numbers.below(150), numbers.below(131)];
            client.send(format!("LINE {x} {y} {} 5 {:08x}\n", y / 2, numbers.below(u32::MAX)).as_bytes());
        }
        assert_eq!(client.ask("PRESENT wait\n"), format!("FRAME {frame}\n"), "no browser is waited for");
        page.until("the frame's number", |page| page.frame == frame);
        assert_eq!(page.bytes, site.memory().bytes(), "frame {frame}");
        // What is drawn after it is not shown before the next PRESENT.
        client.send(b"PX 1 1 12345678\n");
    }
    assert!(page.bytes.chunks(4).any(|pixel| pixel[3] != 255), "alpha is in the frame, too");
}

#[test]
fn a_display_that_follows_shows_what_is_drawn_without_present() {
    let site = Site::start(300, 200);
    let (mut client, mut page) = (site.connect(), site.watch());
    for i in 0..20 {
        client.send(format!("PX {} {} {:06x}\n", i * 13, i * 7, 0xff00 + i).as_bytes());
        client.ask("SYNC x\n");
        page.until_shows(&site.memory());
    }
    let mut late = site.watch();
    late.until_shows(&site.memory());
    assert_eq!(late.frames_shown, 1, "one that comes later gets the newest frame whole");
}

#[test]
fn a_slow_viewer_skips_to_the_newest_frame_and_holds_nobody() {
    let site = Site::start(256, 256);
    let (mut client, mut slow, mut fast) = (site.connect(), site.watch(), site.watch());
    slow.acknowledges = false;
    slow.until("a first frame", |page| page.frames_shown == 1);
    client.send(b"AUTO off\n");
    let mut numbers = Numbers(3);
    for frame in 1..=30u64 {
        for _ in 0..200 {
            let [x, y] = [numbers.below(256), numbers.below(256)];
            client.send(format!("PX {x} {y} {:06x}\n", numbers.below(u32::MAX) >> 8).as_bytes());
        }
        client.ask("PRESENT wait\n");
        fast.until("the frame's number", |page| page.frame == frame);
    }
    assert_eq!(fast.bytes, site.memory().bytes());
    assert!(fast.frames_shown >= 30);
    // It was sent as many frames as may be unacknowledged, and no more.
    slow.until("a second frame", |page| page.frames_shown == 2);
    slow.acknowledges = true;
    let sequence = slow.sequence;
    slow.say(&format!("ack {sequence}"));
    slow.until_shows(&site.memory());
    assert_eq!((slow.frames_shown, slow.frame), (3, 30), "it skipped what lay between");
}

#[test]
fn a_viewer_that_reads_nothing_delays_neither_the_server_nor_other_viewers() {
    let site = Site::start(512, 512);
    let (mut client, mut fast) = (site.connect(), site.watch());
    let deaf: Vec<Page> = (0..20).map(|_| site.watch()).collect();
    let mut numbers = Numbers(5);
    client.send(b"AUTO off\n");
    for frame in 1..=12u64 {
        let block: Vec<u8> = (0..512 * 512).flat_map(|_| numbers.below(u32::MAX).to_le_bytes()).collect();
        client.send(b"BLIT 0 0 512 512 :1048576\n");
        client.send(&block);
        client.ask("PRESENT wait\n");
        fast.until("the frame's number", |page| page.frame == frame);
        assert!(fast.bytes == site.memory().bytes(), "frame {frame}");
    }
    drop(deaf);
}

#[test]
fn watching_and_driving_are_two_rights() {
    let site = Site::start(64, 48);
    let mut watcher = site.watch();
    watcher.say("line PX 1 1 ff0000");
    watcher.text_that("denied");
    watcher.say("key down a");
    watcher.text_that("denied");
    let mut driver = site.drive();
    driver.say("line PX 1 1 00ff00");
    driver.say("line PX 1 1");
    driver.until_replied("PX 1 1 00ff00\n");
    driver.until_shows(&site.memory());
    watcher.until_shows(&site.memory());

    let closed = Site::with(Engine::new(64, 48).unwrap(), WebTokens::new(true, true).unwrap());
    let address = closed.page.address();
    let mut guess = closed.tokens.watch().unwrap().to_owned();
    guess.replace_range(31.., if guess.ends_with('0') { "1" } else { "0" });
    for word in ["", "0", &guess] {
        let mut page = Page::connect(address);
        page.say(&format!("join {word}"));
        let said = page.until_closed();
        assert_eq!(said, ["closed the link has no token, or an old one"], "{word}");
    }
    let mut page = Page::connect(address);
    page.say("line PX 1 1 ff0000");
    page.until_closed();
    let mut watcher = Page::open(address, closed.tokens.watch().unwrap());
    watcher.say("line PX 1 1 ff0000");
    watcher.text_that("denied");
    let mut driver = Page::open(address, closed.tokens.drive().unwrap());
    driver.say("line SIZE");
    driver.until_replied("SIZE 64 48\n");
    assert!(closed.memory().bytes().chunks(4).all(|pixel| pixel == [0, 0, 0, 255]), "nothing was drawn");
}

#[test]
fn typed_commands_run_in_an_ordinary_connection() {
    let engine =
        Engine::with_limits(64, 48, Limits { connections: 2, ..Limits::default() }.for_frame(64, 48));
    let site = Site::with(engine.unwrap(), WebTokens::new(false, true).unwrap());
    let mut one = site.drive();
    one.say("line NOPE 1");
    one.until_replied("EVERB");
    one.say("line HELP");
    one.until_replied("PX");
    one.say("line OFFSET 5 5\nPX 0 0 0000ff\nPX 0 0");
    one.until_replied("0000ff\n");
    assert_eq!(site.memory().get_pixel(5, 5).unwrap(), [0, 0, 255, 255]);
    let mut two = site.drive();
    two.say("line PX 5 5");
    two.until_replied("PX 5 5 0000ff\n");
    let mut three = site.drive();
    three.say("line SIZE");
    assert!(three.text_that("refused ").contains("2 connections"), "quotas hold for them, too");
    one.say("line QUIT");
    one.text_that("ended");
    // Its place is free as soon as its threads have ended.
    let until = Instant::now() + PATIENCE;
    while three.replies.is_empty() && Instant::now() < until {
        three.say("line SIZE");
        three.until("an answer", |page| {
            !page.replies.is_empty() || page.texts.iter().any(|t| t.starts_with("refused"))
        });
        three.texts.clear();
    }
    assert_eq!(three.replies, "SIZE 64 48\n");
}

#[test]
fn keys_and_mouse_reach_the_clients_that_listen() {
    let site = Site::start(64, 48);
    let mut driver = site.drive();
    assert_eq!(driver.text_that("listeners "), "0");
    let mut client = site.connect();
    client.ask("EVENTS on\nSYNC x\n");
    assert_eq!(driver.text_that("listeners "), "1");
    for (said, event) in [
        ("key down left", "EVENT key down left\n"),
        ("text 41", "EVENT text u+0041 A\n"),
        ("key up left", "EVENT key up left\n"),
        ("mouse 3 -4 1", "EVENT mouse 3 -4 1\n"),
        ("wheel 0 1", "EVENT wheel 0 1\n"),
    ] {
        driver.say(said);
        assert_eq!(client.line(), event);
    }
}

#[test]
fn the_depth_under_the_pointer_is_that_of_the_server() {
    let site = Site::start(64, 48);
    let (mut client, mut page) = (site.connect(), site.watch());
    page.say("probe 32 24");
    assert_eq!(page.text_that("depth 32 24 "), "-");
    client.send(b"MESH m SPHERE\nDRAW m\n");
    let z = client.ask("DEPTHAT 32 24\n");
    let z = z.trim_end().rsplit(' ').next().unwrap();
    page.say("probe 32 24");
    let told: f64 = page.text_that("depth 32 24 ").parse().unwrap();
    // DEPTHAT has nine digits.
    assert!((told - z.parse::<f64>().unwrap()).abs() < 1e-8 && told < 1.0, "{told} {z}");
    for far in ["probe 64 0", "probe 4294967295 4294967295", "probe 0 48"] {
        page.say(far);
    }
    page.text_that("depth 0 48 -");
    let stats: serde_json::Value = serde_json::from_str(&page.text_that("stats ")).unwrap();
    assert!(stats["fbptr_connections"].is_u64());
}

#[test]
fn other_hosts_and_origins_get_nothing() {
    let site = Site::start(16, 16);
    let address = site.page.address();
    let get = |host: &str| site.status(&format!("GET / HTTP/1.1\r\nHost: {host}\r\n\r\n"));
    assert_eq!(get(&address.to_string()), "200");
    assert_eq!(get("localhost"), "200");
    assert_eq!(get("evil.example"), "403");
    for origin in ["http://evil.example", "null"] {
        let mut request = format!("ws://{address}/socket").into_client_request().unwrap();
        request.headers_mut().insert("Origin", origin.parse().unwrap());
        let refused = tungstenite::client(request, TcpStream::connect(address).unwrap());
        assert!(refused.is_err(), "{origin}");
    }
    let long = format!("GET / HTTP/1.1\r\nHost: localhost\r\nX: {}\r\n\r\n", "x".repeat(20_000));
    assert_eq!(site.status(&long), "431");
    for bad in ["\r\n\r\n", "GET\r\n\r\n", "GET / HTTP/1.1\r\n\r\n", "\u{e9}\r\n\r\n"] {
        assert_eq!(site.status(bad), "400", "{bad:?}");
    }
}

#[test]
fn hostile_clients_change_nothing_for_others() {
    let site = Site::start(64, 48);
    let (mut client, mut viewer) = (site.connect(), site.watch());
    let address = site.page.address();
    // Heads that never end: more of them than there may be connections.
    let idle: Vec<TcpStream> = (0..1000).filter_map(|_| TcpStream::connect(address).ok()).collect();
    for mut stream in &idle {
        // Some were closed already.
        let _ = stream.write_all(b"GET / HT");
    }
    assert_eq!(site.status("GET / HTTP/1.1\r\nHost: localhost\r\n\r\n"), "200", "they give way");
    // What no page sends ends the connection that sends it.
    let long_ping = [&b"\x89\xfe\x01\0\0\0\0\0"[..], &[0; 256]].concat();
    let frames: [&[u8]; 7] = [
        // Not masked; reserved bits; a reserved opcode.
        b"\x81\x05hello",
        b"\xf1\x80\0\0\0\0",
        b"\x83\x80\0\0\0\0",
        // Longer than there are bytes; longer than is allowed; a ping that is; not UTF-8.
        b"\x81\xff\xff\xff\xff\xff\xff\xff\xff\xff",
        b"\x81\xff\0\0\0\0\0\x10\0\0\0\0\0\0",
        &long_ping,
        b"\x81\x82\0\0\0\0\xff\xff",
    ];
    for frame in frames {
        let mut page = site.watch();
        page.socket.get_mut().write_all(frame).unwrap();
        page.until_closed();
    }
    for said in ["steer", "join", "ack x", "key down a\nb", "mouse 0 0 9"] {
        let mut page = site.watch();
        page.say(said);
        page.until_closed();
    }
    let mut page = site.watch();
    // It may be closed before all of it is sent.
    let _ = page.socket.send(Message::text("x".repeat(70_000)));
    page.until_closed();
    let mut page = site.watch();
    page.socket.send(Message::binary(vec![1, 2, 3])).unwrap();
    page.until_closed();
    // A viewer that shouts is closed.
    let mut loud = site.watch();
    while loud.socket.send(Message::text("ack 0")).is_ok() {}
    // Sockets without a first message, as many as there may be viewers.
    let mute: Vec<Page> = (0..150).map(|_| Page::connect(address)).collect();
    client.send(b"PX 3 3 abcdef\n");
    assert_eq!(client.ask("PX 3 3\n"), "PX 3 3 abcdef\n");
    viewer.until_shows(&site.memory());
    site.watch().until_shows(&site.memory());
    drop((idle, mute));
}

#[test]
fn pieces_of_a_message_without_end_stop_nobody() {
    let site = Site::start(64, 48);
    let mut viewer = site.watch();
    let attacker = site.watch();
    let mut hose = attacker.socket.get_ref().try_clone().unwrap();
    // The first piece of a text, then pieces of no bytes: no limit of a message's length sees them.
    let hosing = std::thread::spawn(move || {
        hose.write_all(b"\x01\x81\0\0\0\0x").unwrap();
        let block = b"\0\x80\0\0\0\0".repeat(10_000);
        let mut sent = 0usize;
        while sent < 1 << 30 && hose.write_all(&block).is_ok() {
            sent += block.len();
        }
        sent
    });
    for round in 0..20 {
        viewer.say("probe 1 1");
        assert_eq!(viewer.text_that("depth "), "1 1 -", "round {round}");
    }
    assert!(hosing.join().unwrap() < 1 << 30, "it is closed");
    viewer.until_shows(&site.memory());
}

#[test]
fn where_all_places_are_taken_the_one_who_drives_gets_one_and_who_is_behind_gives_way() {
    let site = Site::start(64, 48);
    let address = site.page.address();
    let mut faithful = site.watch();
    faithful.until_shows(&site.memory());
    let mut crowd: Vec<Page> = (1..128).map(|_| site.watch()).collect();
    crowd.iter_mut().for_each(|page| page.until_shows(&site.memory()));
    let mut late = Page::connect(address);
    late.say("join ");
    assert_eq!(late.until_closed(), ["closed there are as many viewers as are allowed"]);
    site.drive().until_shows(&site.memory());
    let last = crowd.pop().unwrap();
    assert!(last.until_closed().contains(&"closed another viewer took this place".to_owned()));
    // From now on the crowd acknowledges nothing, though there is something new.
    site.connect().ask("PX 1 1 abcdef\nSYNC x\n");
    faithful.until_shows(&site.memory());
    // The driver has gone; one more watcher fills the place, and after a while there are places again.
    let until = Instant::now() + PATIENCE;
    let mut others: Vec<Page> = Vec::new();
    while others.len() < 3 {
        assert!(Instant::now() < until, "nobody gave way");
        let mut page = Page::connect(address);
        page.say("join ");
        match page.next() {
            Ok(()) => others.push(page),
            Err(_) => std::thread::sleep(Duration::from_millis(100)),
        }
        faithful.say("probe 0 0");
        faithful.text_that("depth ");
    }
    faithful.until_shows(&site.memory());
    drop(crowd);
}

#[test]
fn a_page_comes_back_after_the_server_was_restarted() {
    let site = Site::start(64, 48);
    let address = site.page.address();
    let mut page = site.watch();
    page.until_shows(&site.memory());
    drop(site.page);
    page.until_closed();
    let again = Site::start(32, 32);
    assert_ne!(again.page.address(), address);
    again.watch().until_shows(&again.memory());
}

#[test]
fn a_server_ends_while_viewers_drive() {
    let site = Site::start(64, 48);
    let mut page = site.drive();
    page.say("line SIZE");
    page.until_replied("SIZE 64 48\n");
    let Site { page: served, server, .. } = site;
    drop(served);
    server.finish();
    page.until_closed();
}
