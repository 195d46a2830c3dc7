//! A Pixelflut wall: sixteen clients, each with its own connection, fill their part of the frame
//! pixel by pixel; half of them in text, half in ten-byte binary pixels.
//!
//! `cargo run --example pixelflut_wall -- 127.0.0.1:1234` draws on a running server; without an
//! address it starts one itself.

mod common;

use common::{Arguments, Outcome, run, save_snapshot, with_server};
use std::io::{BufRead, BufReader, Write};
use std::net::TcpStream;
use std::process::ExitCode;

const CLIENTS: u32 = 16;

fn main() -> ExitCode {
    run("[ADDRESS] ", |arguments| {
        if let Some(address) = &arguments.place {
            return flood(address, &arguments);
        }
        with_server("pixelflut wall", [320, 240], arguments, flood)
    })
}

fn flood(address: &str, arguments: &Arguments) -> Outcome {
    let frames = arguments.frames.unwrap_or(if arguments.headless { 1 } else { u64::MAX });
    std::thread::scope(|scope| {
        let clients: Vec<_> = (0..CLIENTS).map(|i| scope.spawn(move || paint(address, i, frames))).collect();
        clients.into_iter().try_for_each(|c| c.join().expect("a client does not panic"))
    })?;
    arguments.snap.as_ref().map_or(Ok(()), |path| save_snapshot(address, path))
}

/// Draws the part of client `number`, in a wall of four by four.
fn paint(address: &str, number: u32, frames: u64) -> Outcome {
    let mut server = TcpStream::connect(address)?;
    let mut replies = BufReader::new(server.try_clone()?).lines();
    let mut reply = move || replies.next().unwrap_or_else(|| Ok(String::new()));
    server.write_all(b"SIZE\n")?;
    let size: Vec<u32> = reply()?.split(' ').skip(1).filter_map(|n| n.parse().ok()).collect();
    let [w, h] = size[..] else { return Err("no frame size came back".into()) };
    let (columns, rows) = (w / 4, h / 4);
    let (left, top) = (number % 4 * columns, number / 4 * rows);
    for frame in 0..frames {
        let mut bytes = Vec::new();
        for (x, y) in (0..rows).flat_map(|y| (0..columns).map(move |x| (left + x, top + y))) {
            let t = frame as f64 * 0.1;
            let wave = |k: f64| {
                let (x, y) = (f64::from(x) / f64::from(w), f64::from(y) / f64::from(h));
                libm::sin(k * x + t) + libm::sin(k * 0.8 * y - t * 0.7) + libm::sin(k * (x + y) + t * 0.4)
            };
            let [r, g, b] = [7.0, 9.0, 12.0].map(|k| (127.5 + 42.0 * wave(k)) as u8);
            match number % 2 {
                0 => bytes.extend(format!("PX {x} {y} {r:02x}{g:02x}{b:02x}\n").as_bytes()),
                // The bytes PB, x and y as little-endian u16, then R G B A.
                _ => {
                    bytes.extend(b"PB");
                    bytes.extend((x as u16).to_le_bytes().into_iter().chain((y as u16).to_le_bytes()));
                    bytes.extend([r, g, b, 255]);
                }
            }
        }
        server.write_all(&bytes)?;
        server.write_all(b"SIZE\n")?;
        // Replies come in order: this one confirms that all pixels before it were drawn.
        if !reply()?.starts_with("SIZE") {
            return Ok(());
        }
    }
    Ok(())
}
