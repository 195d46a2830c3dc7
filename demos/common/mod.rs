//! Shared code of the demos: the arguments `--headless --crt --frames N --snap FILE`, a render thread or
//! server, and an optional window.

#![allow(dead_code, reason = "no demo uses all of it")]

pub mod look;
pub mod teapot;

use fbptr::error::Fault;
use fbptr::save;
use fbptr::server::{Client, Display, DisplayObserver, Engine, Finish, ListenAddress, RenderThread, Server};
use std::error::Error;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;
use std::time::Duration;

/// Result of a demo.
pub type Outcome = Result<(), Box<dyn Error + Send + Sync>>;

/// Selects between one frame and an animation.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Motion {
    /// Every frame is equal; one is drawn by default.
    Still,
    /// Frames differ; they are drawn until the window is closed.
    Moving,
}

/// Command-line arguments of a demo.
pub struct Arguments {
    /// True if no window is to be opened.
    pub headless: bool,
    /// True if the window shows the frame as a cathode ray tube does.
    pub crt: bool,
    /// Number of frames to draw; by default the demo decides.
    pub frames: Option<u64>,
    /// File in which the last frame is saved.
    pub snap: Option<PathBuf>,
    /// Argument without a dash: the address of a server, for the demos that take one.
    pub place: Option<String>,
}

/// Parses the arguments of the process; `None` if one of them is unknown or malformed.
pub fn arguments() -> Option<Arguments> {
    let mut found = Arguments { headless: false, crt: false, frames: None, snap: None, place: None };
    let mut words = std::env::args().skip(1);
    while let Some(word) = words.next() {
        match word.as_str() {
            "--headless" => found.headless = true,
            "--crt" => found.crt = true,
            "--frames" => found.frames = Some(words.next()?.parse().ok()?),
            "--snap" => found.snap = Some(words.next()?.into()),
            _ if word.starts_with('-') || found.place.is_some() => return None,
            _ => found.place = Some(word),
        }
    }
    Some(found)
}

/// Runs a demo with its arguments and returns the exit status of the process: 2 for wrong
/// arguments.
pub fn run(usage: &str, demo: impl FnOnce(Arguments) -> Outcome) -> ExitCode {
    let Some(arguments) = arguments() else {
        eprintln!("expected {usage}[--headless] [--crt] [--frames N] [--snap FILE]");
        return ExitCode::from(2);
    };
    match demo(arguments) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}

/// Calls `draw` once for each frame, with the frame's number from 0, shows the frames, and saves
/// the last one if `--snap` was given.
pub fn show(
    title: &str,
    [width, height]: [u32; 2],
    motion: Motion,
    draw: impl FnMut(&Client, u64) -> Result<(), Fault> + Send + 'static,
) -> ExitCode {
    run("", |Arguments { headless, crt, frames, snap, place }| {
        if let Some(place) = place {
            return Err(format!("{title}: nothing to do with {place:?}").into());
        }
        let mut engine = Engine::new(width, height)?;
        let display = (!headless).then(|| Display::new(width, height));
        if let Some(display) = &display {
            engine.attach(DisplayObserver::new(display.clone()));
        }
        let thread = RenderThread::start(engine)?;
        let limit = frames.unwrap_or(if headless || motion == Motion::Still { 1 } else { u64::MAX });
        let (client, shown) = (thread.client(), display.clone());
        let drawing = std::thread::spawn(move || draw_frames(&client, draw, limit, shown));
        if let Some(display) = display {
            let was_shown = look(title, crt, display.clone(), &thread);
            // Without a window, a demo goes on only if a number of frames was asked for.
            if was_shown || frames.is_none() {
                display.close();
            }
        }
        let drawn = drawing.join().expect("a demo does not panic");
        let memory = thread.finish(Finish::Now);
        drawn?;
        snap.map_or(Ok(()), |path| save::to_path(&memory, &path))?;
        Ok(())
    })
}

/// Starts a server on a free port of this machine, with or without a window, and runs `client` with
/// its address on another thread.
pub fn with_server(
    title: &str,
    [width, height]: [u32; 2],
    arguments: Arguments,
    client: impl FnOnce(&str, &Arguments) -> Outcome + Send + 'static,
) -> Outcome {
    let mut engine = Engine::new(width, height)?;
    let display = (!arguments.headless).then(|| Display::new(width, height));
    if let Some(display) = &display {
        engine.attach(DisplayObserver::new(display.clone()));
    }
    let mut server = Server::start(engine)?;
    // Port 0: the system chooses a free one.
    let ListenAddress::Tcp(address) = server.listen(ListenAddress::Tcp("127.0.0.1:0".parse()?))? else {
        return Err("asked for TCP, got something else".into());
    };
    let crt = arguments.crt;
    let (is_endless, snap) = (arguments.frames.is_none() && !arguments.headless, arguments.snap.clone());
    let client = std::thread::spawn(move || client(&address.to_string(), &arguments));
    if let Some(display) = display {
        look(title, crt, display, server.thread());
    }
    if is_endless {
        // The window is closed: the server shuts down, and the client sees the end of its
        // connection.
        let engine = server.shut_down(Duration::from_secs(1));
        snap.map_or(Ok(()), |path| save::to_path(engine.memory(), &path))?;
        return client.join().expect("a demo does not panic");
    }
    let drawn = client.join().expect("a demo does not panic");
    server.shut_down(Duration::from_secs(1));
    drawn
}

/// Saves a server's frame as a PNG file.
pub fn save_snapshot(address: &str, path: &Path) -> Outcome {
    let mut server = TcpStream::connect(address)?;
    server.write_all(b"SNAP :\n")?;
    let mut replies = BufReader::new(server);
    // The reply is `SNAP w h png :N`, then N bytes.
    let mut header = String::new();
    replies.read_line(&mut header)?;
    let length = header.trim_end().rsplit_once(':').and_then(|(_, n)| n.parse().ok());
    let mut png = Vec::new();
    replies.take(length.ok_or(header)?).read_to_end(&mut png)?;
    Ok(std::fs::write(path, png)?)
}

fn draw_frames(
    client: &Client,
    mut draw: impl FnMut(&Client, u64) -> Result<(), Fault>,
    limit: u64,
    display: Option<Arc<Display>>,
) -> Result<(), Fault> {
    client.auto(false);
    for frame in 0..limit {
        draw(client, frame)?;
        client.sync()?;
        client.present()?;
        if let Some(display) = &display {
            if display.is_closed() {
                break;
            }
            std::thread::sleep(Duration::from_millis(16));
        }
    }
    Ok(())
}

/// Shows the display in a window until it is closed. Returns whether a window could be opened; if
/// not, prints the reason and removes the display from the render thread.
#[cfg(feature = "window")]
pub fn look(title: &str, crt: bool, display: Arc<Display>, thread: &RenderThread) -> bool {
    let options = fbptr::window::Options { title: title.into(), crt, ..Default::default() };
    match fbptr::window::run(display, options) {
        Ok(()) => true,
        Err(error) => {
            eprintln!("{title}: {error}: going on headless");
            thread.drop_display();
            false
        }
    }
}

/// Stands in for windows in a build without them: prints that, and returns false.
#[cfg(not(feature = "window"))]
pub fn look(title: &str, _crt: bool, _display: Arc<Display>, thread: &RenderThread) -> bool {
    eprintln!("{title}: built without windows: going on headless");
    thread.drop_display();
    false
}
