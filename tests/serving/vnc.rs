//! The shared file seen by VNC: `x11vnc -rawfb` maps it, and a client of the RFB protocol (RFC
//! 6143) reads the pixels.

#![cfg(unix)]

use crate::folder::Folder;
use crate::process::Process;
use crate::support::Wire;
use crate::tools;
use std::io::{Read, Write};
use std::net::{TcpListener, TcpStream};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

const SIZE: [usize; 2] = [64, 48];

/// A program that is killed when the test ends.
struct Killed(Child);

impl Drop for Killed {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

fn read<const N: usize>(stream: &mut TcpStream) -> [u8; N] {
    let mut bytes = [0; N];
    stream.read_exact(&mut bytes).unwrap();
    bytes
}

/// Connects, without a password, and returns the frame's size.
fn handshake(stream: &mut TcpStream) -> [usize; 2] {
    assert_eq!(&read::<12>(stream), b"RFB 003.008\n");
    stream.write_all(b"RFB 003.008\n").unwrap();
    let [count] = read(stream);
    let mut kinds = vec![0; count.into()];
    stream.read_exact(&mut kinds).unwrap();
    assert!(kinds.contains(&1), "no way in without a password: {kinds:?}");
    stream.write_all(&[1]).unwrap();
    assert_eq!(read::<4>(stream), [0; 4]);
    stream.write_all(&[1]).unwrap();
    let [w1, w0, h1, h0] = read(stream);
    let _format = read::<16>(stream);
    let mut name = vec![0; u32::from_be_bytes(read(stream)) as usize];
    stream.read_exact(&mut name).unwrap();
    // SetPixelFormat: 32 bits, little-endian, red lowest. SetEncodings: raw alone.
    stream.write_all(&[0, 0, 0, 0, 32, 24, 0, 1, 0, 255, 0, 255, 0, 255, 0, 8, 16, 0, 0, 0]).unwrap();
    stream.write_all(&[2, 0, 0, 1, 0, 0, 0, 0]).unwrap();
    [[w1, w0], [h1, h0]].map(|side| u16::from_be_bytes(side).into())
}

/// Returns the frame's pixels.
fn frame(stream: &mut TcpStream, [width, height]: [usize; 2]) -> Vec<[u8; 4]> {
    let [w, h] = [width, height].map(|side| (side as u16).to_be_bytes());
    stream.write_all(&[3, 0, 0, 0, 0, 0, w[0], w[1], h[0], h[1]]).unwrap();
    let (mut pixels, mut missing) = (vec![[0; 4]; width * height], width * height);
    while missing > 0 {
        let [kind, _, n1, n0] = read(stream);
        assert_eq!(kind, 0, "a message that nobody asked for");
        for _ in 0..u16::from_be_bytes([n1, n0]) {
            let head: [u8; 12] = read(stream);
            let [x, y, w, h] =
                std::array::from_fn(|i| usize::from(u16::from_be_bytes([head[i * 2], head[i * 2 + 1]])));
            assert_eq!(head[8..], [0; 4], "another encoding than raw");
            for row in y..y + h {
                for pixel in &mut pixels[row * width + x..row * width + x + w] {
                    *pixel = read(stream);
                }
            }
            missing = missing.saturating_sub(w * h);
        }
    }
    pixels
}

#[test]
fn the_shared_file_is_seen_by_a_vnc_client() {
    if !tools::are_there(&["x11vnc"]) {
        return;
    }
    let folder = Folder::new("vnc");
    let file = folder.join("fb");
    let mut server =
        Process::start(&["--size", "64x48", "--shm", file.to_str().unwrap(), "--listen", "127.0.0.1:0"]);
    let mut wire = Wire::connect(server.address());
    wire.ask("CLEAR 102030\nPX 7 5 00ff00\nPX 63 47 0000ff\nPX 0 0 c80000\nSYNC x\n");
    // A free port: x11vnc takes none by itself that it would name in time.
    let port = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port();
    let map = format!("map:{}@64x48x32:ff/ff00/ff0000+4096", file.display());
    let x11vnc = Command::new("x11vnc")
        .args(["-quiet", "-nocursor", "-localhost", "-noipv6", "-once", "-rawfb", &map, "-rfbport"])
        .arg(port.to_string())
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let _x11vnc = Killed(x11vnc);
    let started = Instant::now();
    let mut stream = loop {
        match TcpStream::connect(("127.0.0.1", port)) {
            Ok(stream) => break stream,
            Err(e) => assert!(started.elapsed() < Duration::from_secs(60), "x11vnc does not listen: {e}"),
        }
        std::thread::sleep(Duration::from_millis(50));
    };
    stream.set_read_timeout(Some(Duration::from_secs(60))).unwrap();
    assert_eq!(handshake(&mut stream), SIZE);
    let pixels = frame(&mut stream, SIZE);
    let at = |x: usize, y: usize| pixels[y * SIZE[0] + x][..3].to_vec();
    let seen = [at(0, 0), at(7, 5), at(8, 5), at(63, 47)];
    assert_eq!(seen, [[200, 0, 0], [0, 255, 0], [16, 32, 48], [0, 0, 255]]);
}
