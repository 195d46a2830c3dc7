//! What every demo shares: `--headless --frames N --snap FILE`, a render thread, and a window or none.

#![allow(dead_code, reason = "no demo uses all of it")]

pub mod teapot;

use fbptr::error::Fault;
use fbptr::save;
use fbptr::server::{Client, Display, Engine, Finish, ListenAddress, RenderThread, Server};
use std::error::Error;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;
use std::time::Duration;

/// How a demo ends.
pub type Outcome = Result<(), Box<dyn Error + Send + Sync>>;

/// Whether a demo's frames differ.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Motion {
    /// One frame says it all.
    Still,
    /// Frame after frame, until the window is closed.
    Moving,
}

/// What a demo was asked for.
pub struct Arguments {
    /// Open no window.
    pub headless: bool,
    /// End after so many frames.
    pub frames: Option<u64>,
    /// Where to save the last frame.
    pub snap: Option<PathBuf>,
    /// What stands without a dash.
    pub place: Option<String>,
}

/// The process's arguments, if they are the ones that demos take.
pub fn arguments() -> Option<Arguments> {
    let mut found = Arguments { headless: false, frames: None, snap: None, place: None };
    let mut words = std::env::args().skip(1);
    while let Some(word) = words.next() {
        match word.as_str() {
            "--headless" => found.headless = true,
            "--frames" => found.frames = Some(words.next()?.parse().ok()?),
            "--snap" => found.snap = Some(words.next()?.into()),
            _ if word.starts_with('-') || found.place.is_some() => return None,
            _ => found.place = Some(word),
        }
    }
    Some(found)
}

/// Runs a demo with its arguments; the exit status of the process.
pub fn run(usage: &str, demo: impl FnOnce(Arguments) -> Outcome) -> ExitCode {
    let Some(arguments) = arguments() else {
        eprintln!("expected {usage}[--headless] [--frames N] [--snap FILE]");
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

/// Shows what `draw` draws, frame by frame (its second argument counts them from 0), and saves the last one if asked to.
pub fn show(
    title: &str,
    [width, height]: [u32; 2],
    motion: Motion,
    draw: impl FnMut(&Client, u64) -> Result<(), Fault> + Send + 'static,
) -> ExitCode {
    run("", |Arguments { headless, frames, snap, place }| {
        if let Some(place) = place {
            return Err(format!("{title}: nothing to do with {place:?}").into());
        }
        let mut engine = Engine::new(width, height)?;
        let display = (!headless).then(|| Display::new(width, height));
        if let Some(display) = &display {
            engine.set_display(display.clone());
        }
        let thread = RenderThread::start(engine)?;
        let limit = frames.unwrap_or(if headless || motion == Motion::Still { 1 } else { u64::MAX });
        let (client, shown) = (thread.client(), display.clone());
        let drawing = std::thread::spawn(move || draw_frames(&client, draw, limit, shown));
        if let Some(display) = display {
            let was_shown = look(title, display.clone(), &thread);
            // Closed, or never there: then only a number of frames that was asked for is still drawn.
            if was_shown || frames.is_none() {
                display.close();
            }
        }
        let drawn = drawing.join().expect("a demo does not panic");
        let engine = thread.finish(Finish::Now);
        drawn?;
        snap.map_or(Ok(()), |path| save::to_path(engine.memory(), &path))?;
        Ok(())
    })
}

/// Starts a server on a free port of this machine, with a window or without, and lets `client` use it.
pub fn with_server(
    title: &str,
    [width, height]: [u32; 2],
    arguments: Arguments,
    client: impl FnOnce(&str, &Arguments) -> Outcome + Send + 'static,
) -> Outcome {
    let mut engine = Engine::new(width, height)?;
    let display = (!arguments.headless).then(|| Display::new(width, height));
    if let Some(display) = &display {
        engine.set_display(display.clone());
    }
    let mut server = Server::start(engine)?;
    // Port 0: the system gives a free one.
    let ListenAddress::Tcp(address) = server.listen(ListenAddress::Tcp("127.0.0.1:0".parse()?))? else {
        return Err("asked for TCP, got something else".into());
    };
    let (is_endless, snap) = (arguments.frames.is_none() && !arguments.headless, arguments.snap.clone());
    let client = std::thread::spawn(move || client(&address.to_string(), &arguments));
    if let Some(display) = display {
        look(title, display, server.thread());
    }
    if is_endless {
        // The window is closed: the server goes, and the client sees it.
        let engine = server.shut_down(Duration::from_secs(1));
        snap.map_or(Ok(()), |path| save::to_path(engine.memory(), &path))?;
        return client.join().expect("a demo does not panic");
    }
    let drawn = client.join().expect("a demo does not panic");
    server.shut_down(Duration::from_secs(1));
    drawn
}

/// Saves what a server shows as a PNG file.
pub fn save_snapshot(address: &str, path: &Path) -> Outcome {
    let mut server = TcpStream::connect(address)?;
    server.write_all(b"SNAP :\n")?;
    let mut replies = BufReader::new(server);
    // SNAP w h png :N, and N bytes.
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

/// Shows the display in a window until it is closed; where there is none to be had, says so. Whether there was one.
#[cfg(feature = "window")]
pub fn look(title: &str, display: Arc<Display>, thread: &RenderThread) -> bool {
    let options = fbptr::window::Options { title: title.into(), ..Default::default() };
    match fbptr::window::run(display, options) {
        Ok(()) => true,
        Err(error) => {
            eprintln!("{title}: {error}: going on headless");
            thread.drop_display();
            false
        }
    }
}

/// Without windows there is none to show it in.
#[cfg(not(feature = "window"))]
pub fn look(title: &str, _display: Arc<Display>, thread: &RenderThread) -> bool {
    eprintln!("{title}: built without windows: going on headless");
    thread.drop_display();
    false
}
