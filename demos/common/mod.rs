//! What every demo shares: `--headless --frames N --snap FILE`, a render thread, and a window or none.

use fbptr::error::Fault;
use fbptr::save;
use fbptr::server::{Client, Display, Engine, Finish, RenderThread};
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;
use std::time::Duration;

/// Whether a demo's frames differ.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Motion {
    /// One frame says it all.
    Still,
    /// Frame after frame, until the window is closed.
    Moving,
}

struct Arguments {
    headless: bool,
    frames: Option<u64>,
    snap: Option<PathBuf>,
}

fn arguments() -> Option<Arguments> {
    let mut found = Arguments { headless: false, frames: None, snap: None };
    let mut words = std::env::args().skip(1);
    while let Some(word) = words.next() {
        match word.as_str() {
            "--headless" => found.headless = true,
            "--frames" => found.frames = Some(words.next()?.parse().ok()?),
            "--snap" => found.snap = Some(words.next()?.into()),
            _ => return None,
        }
    }
    Some(found)
}

/// Shows what `draw` draws, frame by frame (its second argument counts them from 0), and saves the last one if asked to.
pub fn show(
    title: &str,
    [width, height]: [u32; 2],
    motion: Motion,
    draw: impl FnMut(&Client, u64) -> Result<(), Fault> + Send + 'static,
) -> ExitCode {
    let Some(Arguments { headless, frames, snap }) = arguments() else {
        eprintln!("expected [--headless] [--frames N] [--snap FILE]");
        return ExitCode::from(2);
    };
    let run = || -> Result<(), Box<dyn std::error::Error>> {
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
            look(title, display, &thread);
        }
        let drawn = drawing.join().expect("a demo does not panic");
        let engine = thread.finish(Finish::Now);
        drawn?;
        snap.map_or(Ok(()), |path| save::to_path(engine.memory(), &path))?;
        Ok(())
    };
    match run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{title}: {error}");
            ExitCode::FAILURE
        }
    }
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

/// Shows the display in a window until it is closed; where there is none to be had, says so.
#[cfg(feature = "window")]
fn look(title: &str, display: Arc<Display>, thread: &RenderThread) {
    let options = fbptr::window::Options { title: title.into(), ..Default::default() };
    if let Err(error) = fbptr::window::run(display, options) {
        eprintln!("{title}: {error}: going on headless");
        thread.drop_display();
    }
}

#[cfg(not(feature = "window"))]
fn look(title: &str, _display: Arc<Display>, thread: &RenderThread) {
    eprintln!("{title}: built without windows: going on headless");
    thread.drop_display();
}
