//! One memory budget for all connections: the program under attacks on its memory, each possible
//! with a few kilobytes.
//!
//! Guards against clients that fill the machine's memory, and against a refusal that leaves other
//! clients unserved.

#[cfg(target_os = "linux")]
use crate::process::Process;
use crate::scenes::{doubling, gzip, scene};
use crate::support::{Serving, Wire};
use fbptr::server::Limits;
use image::ImageEncoder;
use std::net::SocketAddr;
use std::time::Duration;

/// Budget of the attacked server in bytes.
const BUDGET: u64 = 64 << 20;
/// Bytes that a process holds beside its budget and what it holds at the start (code and tables,
/// more in a build that is optimized less): stacks of threads, code that is used later, and small
/// freed blocks that its allocator retains, at most a part of the budget.
const OVERHEAD: u64 = 24 << 20;
/// Bytes held for each connection beside the budget: its state, and its writer's stack.
const CONNECTION: u64 = 64 << 10;

fn png(side: u32) -> Vec<u8> {
    let mut out = Vec::new();
    let pixels = vec![7; side as usize * side as usize * 4];
    let encoder = image::codecs::png::PngEncoder::new(&mut out);
    encoder.write_image(&pixels, side, side, image::ExtendedColorType::Rgba8).unwrap();
    out
}

/// Returns a command with its payload.
fn with_payload(head: &str, payload: &[u8]) -> Vec<u8> {
    [format!("{head} :{}\n", payload.len()).as_bytes(), payload].concat()
}

/// Returns a scene of boxes with pictures of `side` x `side` pixels, each a file of its own.
fn scene_of_pictures(count: usize, side: u32) -> Vec<u8> {
    let file = png(side);
    let shape = |i: usize| {
        // Each URL differs, so that no texture is shared.
        let hex: String = file.iter().map(|byte| format!("%{byte:02x}")).collect();
        format!(
            "<Shape><Appearance><ImageTexture url='\"data:image/png;a={i},{hex}\"'/></Appearance><Box/></Shape>"
        )
    };
    let shapes: String = (0..count).map(shape).collect();
    with_payload("SCENE X3D", format!("<X3D><Scene>{shapes}</Scene></X3D>").as_bytes())
}

/// Returns nested groups with 8 to the power of `depth` shapes.
fn scene_of_uses(depth: u32) -> Vec<u8> {
    let mut text = String::from("<X3D><Scene><Group DEF='g0'><Shape><Box/></Shape></Group>");
    for i in 1..=depth {
        let uses = format!("<Group USE='g{}'/>", i - 1).repeat(8);
        text += &format!("<Group DEF='g{i}'>{uses}</Group>");
    }
    with_payload("SCENE X3D", (text + "</Scene></X3D>").as_bytes())
}

/// Returns a mesh that repeats one sliver from corner to corner of the frame: it is in the bin of
/// every tile it crosses and covers few pixels.
fn full_frames(faces: usize) -> Vec<u8> {
    let text = "v -9 -9 0\nv 9 9 0\nv 9 9.01 0\n".to_owned() + &"f 1 2 3\n".repeat(faces);
    with_payload("MESH m OBJ", text.as_bytes())
}

fn high_water(process: &Process) -> u64 {
    let status = std::fs::read_to_string(format!("/proc/{}/status", process.id())).unwrap();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:")).unwrap();
    line.trim().trim_end_matches("kB").trim().parse::<u64>().unwrap() * 1024
}

fn answers(address: SocketAddr) {
    assert_eq!(Wire::connect(address).ask("SIZE\n"), "SIZE 320 240\n");
}

/// Sends a request and returns the replies, after verifying that the server still answers others.
fn attack(address: SocketAddr, request: &[u8]) -> String {
    let said = Wire::connect(address).talk(request);
    answers(address);
    String::from_utf8_lossy(&said).into_owned()
}

/// Sends resources, scenes and a drawing that no budget allows as a whole; each is refused or done
/// in pieces.
fn attack_by_contents(address: SocketAddr, note: &mut dyn FnMut(&str)) {
    let said = attack(address, &scene_of_pictures(10, 2048));
    assert!(said.contains("EQUOTA SCENE"), "{said}");
    note("a scene's pictures");
    let said = attack(address, &scene_of_pictures(10, 4096));
    assert!(said.contains("EQUOTA SCENE"), "{said}");
    note("a scene's large pictures");
    let said = attack(address, &with_payload("TEX t", &png(4096)));
    assert!(said.contains("EQUOTA TEX"), "{said}");
    note("a picture");
    let draws = b"CULL none\nHIDE zbuffer\nDRAW m\nDRAW m\nSYNC a\n".to_vec();
    let said = attack(address, &[full_frames(40_000), draws].concat());
    // A busy machine may need more than the time that a command has.
    let is_in_time = !said.contains("EQUOTA DRAW: given up after");
    assert!(said.ends_with("SYNC a\n") && !(is_in_time && said.contains("ERR ")), "drawn in pieces: {said}");
    note("full-frame faces");
    let said = attack(address, &[scene_of_uses(6), b"DRAWSCENE\nSYNC a\n".to_vec()].concat());
    assert!(said.contains("EQUOTA SCENE") && said.ends_with("SYNC a\n"), "{said}");
    note("objects used again and again");
    let said = attack(address, b"MESH k KNOT 3000 3000\nMESH t TEAPOT 300\n");
    assert_eq!(said.matches("EQUOTA MESH").count(), 2, "{said}");
    note("shapes");
}

/// Sends texts that grow when they are read.
fn attack_by_texts(address: SocketAddr, note: &mut dyn FnMut(&str)) {
    let bomb = gzip(format!("<Scene><!--{}--></Scene>", " ".repeat(100 << 20)).as_bytes());
    let said = attack(address, &scene(&bomb));
    assert!(said.contains("EQUOTA SCENE"), "{said}");
    note("inflated bytes");
    let said = attack(address, &scene(doubling(40).as_bytes()));
    assert!(said.contains("EQUOTA SCENE"), "{said}");
    note("instances of prototypes");
    let said = attack(address, &with_payload("EYE e", "[".repeat(100).as_bytes()));
    assert!(said.contains("ERR"), "{said}");
    let arrays = format!("{{\"facets\":[{}0]}}", "[],".repeat(2_000_000));
    let said = attack(address, &with_payload("EYE e", arrays.as_bytes()));
    assert!(said.contains("EQUOTA EYE"), "{said}");
    note("arrays");
    let elements = format!("<X3D><Scene>{}</Scene></X3D>", "<a/>".repeat(1 << 20));
    let said = attack(address, &with_payload("SCENE X3D", elements.as_bytes()));
    assert!(said.contains("EQUOTA SCENE"), "{said}");
    note("elements");
    let said = attack(address, &with_payload("MESH o OBJ", "v 0 0 0\n".repeat(1 << 19).as_bytes()));
    assert!(said.contains("EQUOTA MESH"), "{said}");
    note("vertices");
}

/// Holds memory by many connections at once.
fn attack_by_connections(address: SocketAddr, note: &mut dyn FnMut(&str)) {
    // Many small resources of several connections: their sum is bounded.
    let mut wires: Vec<Wire> = (0..8).map(|_| Wire::connect(address)).collect();
    let texture = with_payload("TEX", &png(256))[4..].to_vec();
    let mut refused = 0;
    for (i, wire) in wires.iter_mut().enumerate() {
        for k in 0..60 {
            wire.send(&[format!("TEX t{i}_{k} ").as_bytes(), &texture].concat());
        }
        let said = wire.ask("SYNC a\n");
        refused += usize::from(said.contains("EQUOTA"));
    }
    assert!(refused > 0, "480 textures of 600 KB were all taken");
    answers(address);
    drop(wires);
    note("many textures");
    // Payloads that never end.
    let mut wires: Vec<Wire> = (0..64).map(|_| Wire::connect(address)).collect();
    for wire in &mut wires {
        wire.send(format!("ERRORS report\nBLIT 0 0 2000 2000 :{}\n", 16_000_000).as_bytes());
        wire.send(&vec![1; 3 << 20]);
    }
    answers(address);
    drop(wires);
    note("payloads");
    // Replies that no client reads.
    let mut wires: Vec<Wire> = (0..32).map(|_| Wire::connect(address)).collect();
    for wire in &mut wires {
        wire.send("READ 0 0 320 240\n".repeat(60).as_bytes());
    }
    answers(address);
    note("replies");
}

#[cfg(target_os = "linux")]
#[test]
fn a_server_under_attack_stays_within_its_budget_and_answers() {
    let budget = BUDGET.to_string();
    let arguments =
        ["--listen", "127.0.0.1:0", "--size", "320x240", "--threads", "2", "--max-memory", &budget];
    let mut process = Process::start(&arguments);
    let address = process.address();
    let start = high_water(&process);
    let mut peaks = Vec::new();
    let mut note = |what: &str| peaks.push((what.to_owned(), high_water(&process) >> 10));
    note("start");
    attack_by_contents(address, &mut note);
    attack_by_texts(address, &mut note);
    attack_by_connections(address, &mut note);
    let connections = 130;
    let bound = start + BUDGET + OVERHEAD + CONNECTION * connections;
    let high = high_water(&process);
    println!("{peaks:?} KiB, bound {} KiB", bound >> 10);
    assert!(high <= bound, "{high} bytes held at most, the bound is {bound}: {peaks:?} KiB");
    let stats = Wire::connect(address).ask("STATS\n");
    assert!(stats.contains(&format!("memory_limit={BUDGET} memory_used=")), "{stats}");
}

#[test]
fn stats_show_what_each_use_holds_and_give_it_back() {
    let limits = Limits { memory_bytes: 50_000_000, ..Limits::default() };
    let serving = Serving::limited(64, 64, limits);
    let of = |stats: &str, key: &str| -> u64 {
        let word = stats.split_whitespace().find_map(|w| w.strip_prefix(&format!("{key}="))).unwrap();
        word.parse().unwrap()
    };
    let mut wire = serving.connect();
    let before = wire.ask("STATS\n");
    assert_eq!((of(&before, "memory_limit"), of(&before, "memory_frame")), (50_000_000, 64 * 64 * 4));
    assert_eq!((of(&before, "memory_resources"), of(&before, "memory_draws")), (0, 0));
    wire.send(&with_payload("TEX t", &png(64)));
    wire.send(b"LIGHT 0 DIR 0 0 -1 1 1 1\nMESH m SPHERE\nDRAW m\n");
    let after = wire.ask("STATS\n");
    assert!(of(&after, "memory_resources") > 64 * 64 * 4 && of(&after, "memory_draws") > 0, "{after}");
    assert!(of(&after, "memory_frame") >= 64 * 64 * (4 + 4 + 8), "{after}");
    let uses = ["frame", "resources", "decoders", "draws", "replies", "records", "payloads"];
    let sum: u64 = uses.iter().map(|u| of(&after, &format!("memory_{u}"))).sum();
    assert_eq!(sum, of(&after, "memory_used"), "{after}");
    wire.send(b"FREE t\nFREE m\n");
    let freed = wire.ask("STATS\n");
    assert!(of(&freed, "memory_resources") < of(&after, "memory_resources") - 64 * 64 * 4, "{freed}");
}

#[test]
fn textures_are_refused_by_the_quota_before_they_are_decoded() {
    let serving = Serving::limited(8, 8, Limits { resource_bytes: 10_000_000, ..Limits::default() });
    let said = serving.talk(&with_payload("TEX t", &png(4096)));
    let said = String::from_utf8(said).unwrap();
    assert!(said.contains("EQUOTA TEX") && said.contains("the quota leaves 10000000"), "{said}");
    let said = serving.talk(&scene_of_pictures(3, 2048));
    let said = String::from_utf8(said).unwrap();
    assert!(said.contains("EQUOTA SCENE") && said.contains("the quota leaves 10000000"), "{said}");
}

#[test]
fn a_payload_is_counted_once_when_its_command_takes_it_over() {
    const LIMIT: u64 = 4_000_000;
    let patient = Duration::from_secs(600);
    let limits = Limits { memory_bytes: LIMIT, command_time: patient, ..Limits::default() };
    let serving = Serving::limited(8, 8, limits);
    // The text is mostly comments, of which nothing is stored, so that the payload is all that is
    // held.
    let mut text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n".to_owned();
    text += &format!("#{}\n", " nothing".repeat(100)).repeat(LIMIT as usize * 6 / 10 / 802);
    let mut wire = serving.connect();
    wire.send(&with_payload("MESH m OBJ", text.as_bytes()));
    assert_eq!(wire.ask("SYNC made\n"), "SYNC made\n", "a payload of 60 % of the budget");
    wire.send(b"FREE m\n");
    let stats = wire.ask("STATS\n");
    let payloads = stats.split(" memory_payloads=").nth(1).and_then(|rest| rest.split_whitespace().next());
    let payloads: u64 = payloads.and_then(|n| n.parse().ok()).unwrap_or_else(|| panic!("{stats}"));
    assert!(payloads < 1 << 20, "{payloads} bytes stay counted");
}
