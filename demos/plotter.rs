//! A plotter driven by another process: this one opens the window and starts the other, which is
//! given only the address and draws curves by text commands.
//!
//! `cargo run --example plotter -- 127.0.0.1:1234` is the other process; any program that can write
//! to a socket could take its place.

mod common;

use common::{Arguments, Outcome, run, save_snapshot, with_server};
use std::fmt::Write as _;
use std::io::{BufRead, BufReader, Write};
use std::net::TcpStream;
use std::process::{Command, ExitCode};

fn main() -> ExitCode {
    run("[ADDRESS] ", |arguments| {
        if let Some(address) = &arguments.place {
            return plot(address, &arguments);
        }
        with_server("plotter", [480, 240], arguments, |address, arguments| {
            let mut other = Command::new(std::env::current_exe()?);
            other.arg(address);
            // With a window, the number of frames is not limited here.
            if let Some(frames) = arguments.frames.or(arguments.headless.then_some(1)) {
                other.args(["--frames", &frames.to_string()]);
            }
            if !other.status()?.success() {
                return Err("the other process failed".into());
            }
            arguments.snap.as_ref().map_or(Ok(()), |path| save_snapshot(address, path))
        })
    })
}

type Curve = fn(f64) -> f64;

/// Runs the other process: draws the background, axes, and three curves that grow to the right.
fn plot(address: &str, arguments: &Arguments) -> Outcome {
    let mut server = TcpStream::connect(address)?;
    let mut replies = BufReader::new(server.try_clone()?).lines();
    let paper = "CLEAR 0e1420\nAUTO off\nLINE 20 120 460 120 808ca5\nLINE 20 16 20 224 808ca5\n\
                 PRINT 300 16 ff5d5d 3 sin(x)/x\nPRINT 300 28 5b8cff sin(x^2/8)\n\
                 PRINT 300 40 ffb000 exp(-x/8) cos(2x)\n";
    server.write_all(paper.as_bytes())?;
    let curves: [(&str, Curve); 3] = [
        ("ff5d5d", |x| 3.0 * libm::sin(x) / x.max(1e-9)),
        ("5b8cff", |x| libm::sin(x * x / 8.0)),
        ("ffb000", |x| libm::exp(-x / 8.0) * libm::cos(2.0 * x)),
    ];
    let at = |f: Curve, step: u64| {
        let x = step as f64 * 0.05;
        (20.0 + x * 22.0, 120.0 - 34.0 * f(x))
    };
    for frame in 0..arguments.frames.unwrap_or(u64::MAX).min(100) {
        let mut lines = String::new();
        for (step, (color, f)) in (0..4).flat_map(|i| curves.map(|c| (frame * 4 + i, c))) {
            let ((x0, y0), (x1, y1)) = (at(f, step), at(f, step + 1));
            writeln!(lines, "LINEAA {x0} {y0} {x1} {y1} {color}")?;
        }
        server.write_all((lines + "PRESENT wait\n").as_bytes())?;
        if !replies.next().is_some_and(|line| line.is_ok_and(|l| l.starts_with("FRAME"))) {
            return Ok(());
        }
    }
    Ok(server.write_all(b"QUIT\n")?)
}
