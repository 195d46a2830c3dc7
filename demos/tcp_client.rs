//! Draws on a server over TCP, with nothing but a socket and lines of text.
//!
//! `cargo run --example tcp_client -- 127.0.0.1:1234` draws on a running server; without an address
//! it starts one itself.

mod common;

use common::{Arguments, Outcome, run, save_snapshot, with_server};
use std::io::{BufRead, BufReader, Write};
use std::net::TcpStream;
use std::process::ExitCode;

fn main() -> ExitCode {
    run("[ADDRESS] ", |arguments| {
        if let Some(address) = &arguments.place {
            return draw(address, &arguments);
        }
        with_server("tcp client", [320, 240], arguments, draw)
    })
}

/// Runs the client, which is given only the address of the server.
fn draw(address: &str, arguments: &Arguments) -> Outcome {
    let mut server = TcpStream::connect(address)?;
    let mut replies = BufReader::new(server.try_clone()?);
    let mut reply = || -> std::io::Result<String> {
        let mut line = String::new();
        replies.read_line(&mut line)?;
        Ok(line)
    };
    server.write_all(b"SIZE\nAUTO off\n")?;
    let size: Vec<f64> = reply()?.split(' ').skip(1).filter_map(|n| n.trim().parse().ok()).collect();
    let [w, h] = size[..] else { return Err("no frame size came back".into()) };
    for frame in 0..arguments.frames.unwrap_or(if arguments.headless { 1 } else { u64::MAX }) {
        let mut picture = String::from("CLEAR 000818\n");
        let at = |k: u32| {
            let (a, turn) = (f64::from(k) * 0.0491, frame as f64 * 0.03);
            let reach = 0.45 * libm::cos(7.0 / 3.0 * a + turn);
            (w * (0.5 + reach * libm::cos(a)), h * (0.5 + reach * libm::sin(a)))
        };
        for k in 0..384 {
            let ((x0, y0), (x1, y1)) = (at(k), at(k + 1));
            let c = (k * 255 / 384) as u8;
            picture += &format!("LINEAA {x0} {y0} {x1} {y1} {:02x}{:02x}ff\n", 255 - c, c);
        }
        server.write_all((picture + "PRESENT wait\n").as_bytes())?;
        // The reply FRAME n says that the frame is on the screen, so the client is no faster than
        // the display.
        if !reply()?.starts_with("FRAME") {
            return Ok(());
        }
    }
    server.write_all(b"QUIT\n")?;
    arguments.snap.as_ref().map_or(Ok(()), |path| save_snapshot(address, path))
}
