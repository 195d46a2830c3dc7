//! The metrics endpoint: its values, its format to the letter, and hostile clients.

#![cfg(unix)]

use crate::process::{Process, fbptr};
use crate::support::Wire;
use std::collections::{HashMap, HashSet};
use std::io::{Read, Write};
use std::net::{Shutdown, SocketAddr, TcpStream};
use std::time::{Duration, Instant};

fn start(more: &[&str]) -> (Process, SocketAddr, SocketAddr) {
    let mut process =
        Process::start(&[&["--listen", ":0", "--metrics", ":0", "--size", "20x10"], more].concat());
    let address = process.address();
    let line = process.says();
    let metrics =
        line.strip_prefix("fbptr: metrics on http://").and_then(|rest| rest.strip_suffix("/metrics"));
    let metrics = metrics.unwrap_or_else(|| panic!("{line}")).parse().unwrap();
    (process, address, metrics)
}

/// Sends bytes and reads to the end; a reset counts as the end.
fn exchange(address: SocketAddr, request: &[u8]) -> Vec<u8> {
    let mut stream = TcpStream::connect(address).unwrap();
    stream.set_read_timeout(Some(Duration::from_secs(20))).unwrap();
    let _ = stream.write_all(request);
    let mut reply = Vec::new();
    let _ = stream.read_to_end(&mut reply);
    reply
}

/// Returns the body of a complete response with status 200.
fn get(address: SocketAddr, path: &str, media_type: &str) -> Option<String> {
    let reply = exchange(address, format!("GET {path} HTTP/1.1\r\nHost: {address}\r\n\r\n").as_bytes());
    let text = String::from_utf8(reply).unwrap();
    let (head, body) = text.split_once("\r\n\r\n")?;
    assert!(head.starts_with("HTTP/1.1 200 OK\r\n"), "{head}");
    assert!(head.contains(&format!("\r\nContent-Type: {media_type}\r\n")), "{head}");
    assert!(head.contains(&format!("\r\nContent-Length: {}\r\n", body.len())), "{head}");
    Some(body.to_owned())
}

fn samples(address: SocketAddr) -> Option<HashMap<String, f64>> {
    get(address, "/metrics", "text/plain; version=0.0.4; charset=utf-8").map(|text| parse_exposition(&text))
}

fn is_name(name: &str) -> bool {
    let is_first = |c: char| c.is_ascii_alphabetic() || c == '_' || c == ':';
    name.starts_with(is_first) && name.chars().all(|c| is_first(c) || c.is_ascii_digit())
}

/// Parses Prometheus' text format 0.0.4; panics on anything that it does not allow.
fn parse_exposition(text: &str) -> HashMap<String, f64> {
    assert!(text.ends_with('\n') && !text.contains('\r') && !text.contains("\n\n"));
    let (mut helped, mut typed, mut closed) = (HashSet::new(), HashMap::new(), HashSet::new());
    let mut current = String::new();
    let mut samples = HashMap::new();
    for line in text.lines() {
        if let Some(rest) = line.strip_prefix("# HELP ") {
            let (name, help) = rest.split_once(' ').unwrap();
            assert!(is_name(name) && !help.is_empty() && helped.insert(name), "{line}");
            assert!(
                closed.insert(std::mem::replace(&mut current, name.to_owned())),
                "{line}: lines of one family apart"
            );
        } else if let Some(rest) = line.strip_prefix("# TYPE ") {
            let (name, kind) = rest.split_once(' ').unwrap();
            assert!(name == current && matches!(kind, "counter" | "gauge"), "{line}");
            assert_eq!(
                kind == "counter",
                name.ends_with("_total"),
                "{line}: counters, and no others, end in _total"
            );
            assert!(typed.insert(name, kind).is_none(), "{line}");
        } else {
            assert!(!line.starts_with('#'), "{line}");
            let (key, value) = line.rsplit_once(' ').unwrap();
            let name = key.split('{').next().unwrap();
            assert!(name == current && typed.contains_key(name) && is_name(name), "{line}");
            if let Some(labels) = key.strip_prefix(name).filter(|labels| !labels.is_empty()) {
                let inner = labels.strip_prefix('{').and_then(|l| l.strip_suffix("\"}")).unwrap();
                let (label, at) = inner.split_once("=\"").unwrap();
                assert!(is_name(label) && !label.contains(':') && !at.contains(['"', '\\']), "{line}");
            }
            let value: f64 = value.parse().unwrap();
            assert!(value.is_finite() && value >= 0.0, "{line}");
            assert!(samples.insert(key.to_owned(), value).is_none(), "{line}: twice");
        }
    }
    assert_eq!(helped.len(), typed.len(), "each family has its HELP and TYPE");
    samples
}

/// Reads the metrics until `is_right`; panics after 30 seconds.
fn wait_for(address: SocketAddr, is_right: impl Fn(&HashMap<String, f64>) -> bool) -> HashMap<String, f64> {
    let until = Instant::now() + Duration::from_secs(30);
    loop {
        let last = samples(address);
        if let Some(samples) = last.as_ref().filter(|samples| is_right(samples)) {
            return samples.clone();
        }
        assert!(Instant::now() < until, "waited in vain, last {last:?}");
        std::thread::sleep(Duration::from_millis(50));
    }
}

#[test]
fn a_command_in_pieces_is_counted_by_its_verb() {
    let (_process, address, metrics) = start(&[]);
    let mut wire = Wire::connect(address);
    let text = "x".repeat(400_000);
    wire.send(format!("TEXT 0 0 ffffff :{}\n{text}SYNC a\n", text.len()).as_bytes());
    assert_eq!(wire.line(), "SYNC a\n");
    let samples = wait_for(metrics, |samples| samples["fbptr_commands_total"] == 2.0);
    assert_eq!(samples["fbptr_verb_commands_total{verb=\"TEXT\"}"], 1.0);
}

#[test]
fn the_values_are_what_happened() {
    let (_process, address, metrics) = start(&["--max-conns-per-address", "2"]);
    let mut wire = Wire::connect(address);
    wire.send(
        b"PX 1 1 ff0000\nPX 99 99 ff0000\nPB\x01\x00\x01\x00abcdLINE 0 0 1 1 ffffff\nNONSENSE\nPRESENT\n",
    );
    wire.send(b"MESH m BOX\nMESH @m BOX\nDRAW m\nSYNC a\n");
    while wire.line() != "SYNC a\n" {}
    let stats = wire.ask("STATS\n");
    let pixels = stats.split(" total_pixels=").nth(1).and_then(|rest| rest.split(' ').next());
    let pixels: f64 = pixels.and_then(|n| n.parse().ok()).unwrap_or_else(|| panic!("{stats}"));
    assert!(pixels > 2.0, "the box counts, too: {pixels}");
    assert!(Wire::connect(address).talk(b"GET / HTTP/1.1\r\n\r\n").starts_with(b"HTTP/1.1 400"));
    let until = Instant::now() + Duration::from_secs(20);
    // The refused request counts among the address's connections until it is closed.
    let _second = loop {
        let mut wire = Wire::connect(address);
        if wire.try_ask("SYNC b\n").is_some_and(|line| line == "SYNC b\n") {
            break wire;
        }
        assert!(Instant::now() < until, "the refused request's place is never free");
    };
    while !Wire::connect(address).talk(b"").starts_with(b"ERR 0 0 EQUOTA") {
        assert!(Instant::now() < until, "the address's share is never used up");
    }
    let found =
        wait_for(metrics, |s| s["fbptr_connections"] == 2.0 && s["fbptr_foreign_requests_total"] == 1.0);
    for (name, value) in [
        ("fbptr_pixels_total", pixels),
        ("fbptr_clipped_pixels_total", 1.0),
        ("fbptr_errors_total", 2.0),
        ("fbptr_frames_total", 1.0),
        ("fbptr_verb_commands_total{verb=\"PX\"}", 2.0),
        ("fbptr_verb_commands_total{verb=\"PB\"}", 1.0),
        ("fbptr_verb_commands_total{verb=\"LINE\"}", 1.0),
        ("fbptr_verb_commands_total{verb=\"MESH\"}", 2.0),
        ("fbptr_verb_commands_total{verb=\"READ\"}", 0.0),
        ("fbptr_connections_refused_total{reason=\"server_full\"}", 0.0),
        ("fbptr_memory_bytes{use=\"frame\"}", 800.0),
        ("fbptr_recording{state=\"off\"}", 1.0),
        ("fbptr_queue_bytes", 0.0),
    ] {
        assert_eq!(found.get(name), Some(&value), "{name}");
    }
    assert!(found["fbptr_connections_refused_total{reason=\"address_full\"}"] >= 1.0);
    for memory in ["depth", "shared_resources", "private_resources"] {
        assert!(found[&format!("fbptr_memory_bytes{{use=\"{memory}\"}}")] > 0.0, "{memory}");
    }
    let json = get(metrics, "/metrics.json", "application/json").unwrap();
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!(json["fbptr_pixels_total"].as_f64(), Some(pixels));
    assert_eq!(json["fbptr_verb_commands_total"]["PX"], 2);
    let later = wait_for(metrics, |s| s["fbptr_uptime_seconds"] > found["fbptr_uptime_seconds"]);
    assert!(later["fbptr_received_bytes_total"] >= found["fbptr_received_bytes_total"]);
}

#[test]
fn clients_that_mean_no_good_get_little_and_hold_nobody_up() {
    let (process, _, metrics) = start(&[]);
    let head = |text: &str| exchange(metrics, text.as_bytes());
    let status =
        |text: &str| String::from_utf8_lossy(&head(text)).lines().next().unwrap_or_default().to_owned();
    assert_eq!(status("GET /metrics HTTP/1.1\r\nHost: evil.example\r\n\r\n"), "HTTP/1.1 403 Forbidden");
    assert_eq!(status("GET /metrics HTTP/1.1\r\n\r\n"), "HTTP/1.1 400 Bad Request");
    assert_eq!(
        status("POST /metrics HTTP/1.1\r\nHost: localhost\r\n\r\n"),
        "HTTP/1.1 405 Method Not Allowed"
    );
    assert_eq!(status("GET /etc/passwd HTTP/1.1\r\nHost: localhost\r\n\r\n"), "HTTP/1.1 404 Not Found");
    let long = format!("GET /metrics HTTP/1.1\r\nHost: localhost\r\nX: {}\r\n\r\n", "x".repeat(100_000));
    let refused = status(&long);
    assert!(refused.is_empty() || refused.starts_with("HTTP/1.1 431 "), "{refused}");
    assert_eq!(status("\0\u{1}\u{2}\r\n\r\n"), "HTTP/1.1 400 Bad Request");
    let reply = head("HEAD /metrics HTTP/1.1\r\nHost: localhost\r\n\r\n");
    assert!(reply.starts_with(b"HTTP/1.1 200 OK\r\n") && reply.ends_with(b"\r\n\r\n"), "no body for HEAD");
    // A client that sends its request byte by byte is served; a second request on a connection is
    // not.
    let mut slow = TcpStream::connect(metrics).unwrap();
    slow.set_nodelay(true).unwrap();
    for byte in b"GET /metrics HTTP/1.0\r\n\r\n" {
        slow.write_all(&[*byte]).unwrap();
    }
    let _ = slow.write_all(b"GET /metrics HTTP/1.0\r\n\r\n");
    slow.shutdown(Shutdown::Write).unwrap();
    let mut reply = String::new();
    slow.read_to_string(&mut reply).unwrap();
    assert_eq!(reply.matches("HTTP/1.1 200 OK").count(), 1);
    // All slots are taken by silent connections: these are closed, and another client is served.
    let silent: Vec<TcpStream> = (0..50).map(|_| TcpStream::connect(metrics).unwrap()).collect();
    wait_for(metrics, |samples| samples["fbptr_connections"] == 0.0);
    drop(silent);
    // Clients that never read are closed as well.
    let deaf: Vec<TcpStream> = (0..8).map(|_| TcpStream::connect(metrics).unwrap()).collect();
    for mut stream in &deaf {
        stream.write_all(b"GET /metrics HTTP/1.0\r\n\r\n").unwrap();
    }
    wait_for(metrics, |samples| samples["fbptr_connections"] == 0.0);
    drop(deaf);
    assert_eq!(process.ends_after("TERM"), Some(0));
}

#[test]
fn other_machines_are_let_in_only_when_asked() {
    let arguments = ["serve", "--headless", "--listen", ":0", "--metrics", "0.0.0.0:0"];
    let out = fbptr().args(arguments).output().unwrap();
    assert_eq!(out.status.code(), Some(2));
    let message = String::from_utf8_lossy(&out.stderr).into_owned();
    assert!(message.contains("needs --allow-remote"), "{message}");
}

#[test]
fn json_is_answered_to_whoever_accepts_it() {
    let (_process, _, metrics) = start(&[]);
    for (accept, is_json) in [
        ("Accept: application/json", true),
        ("accept: Application/JSON;q=0.9, text/plain;q=0.5", true),
        ("Accept: text/html, application/*;q=0.8", true),
        ("Accept: application/json;q=0, */*", false),
        ("Accept: application/json;q=0.5, text/plain", false),
        ("Accept: application/openmetrics-text;version=1.0.0;q=0.5,text/plain;version=0.0.4;q=0.2", false),
        ("Accept: text/plain, application/json", false),
        ("Accept: */*", false),
        ("Accept: ;;q=,/", false),
        ("X-Nothing: application/json", false),
    ] {
        let request = format!("GET /metrics HTTP/1.1\r\nHost: {metrics}\r\n{accept}\r\n\r\n");
        let reply = String::from_utf8(exchange(metrics, request.as_bytes())).unwrap();
        let (head, body) = reply.split_once("\r\n\r\n").unwrap();
        assert!(head.starts_with("HTTP/1.1 200 OK\r\n"), "{accept}: {head}");
        assert_eq!(head.contains("\r\nContent-Type: application/json\r\n"), is_json, "{accept}: {head}");
        assert_eq!(body.starts_with('{'), is_json, "{accept}: {body}");
        assert!(head.contains("\r\nVary: Accept\r\n"), "{accept}: {head}");
    }
}
