//! Input of a run: from the window, from a replay, and from the terminal that `fbptr` was started
//! in.

use super::replay::Replay;
use super::spawn::Terminals;
use super::{Refusal, Run};
use crate::command::Command;
use crate::fbdev::{Device, InputDevices};
use crate::input::InputEvent;
use crate::server::{Client, Server};
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use std::io::{self, IsTerminal, Read, Write};
use std::time::Instant;

/// Limit of the file of `--keys`.
const MAX_KEYS_BYTES: u64 = 64 << 20;

/// Sources of input, and the devices that it goes to.
#[derive(Debug)]
pub struct Input {
    devices: InputDevices,
    replay: Replay,
    terminals: Terminals,
    /// Receives the window's events.
    client: Client,
}

impl Input {
    /// Connects the sources to the devices.
    ///
    /// # Errors
    /// A file of `--keys` that cannot be read, or a system without sockets or threads.
    pub fn new(args: &Run, device: &Device, server: &Server, terminals: Terminals) -> Result<Input, Refusal> {
        let refuse = |message: String| Refusal { status: 2, message };
        let lines = match &args.keys {
            Some(path) => {
                let no_file = |e: String| refuse(format!("{}: {e}", path.display()));
                let bytes =
                    crate::save::read_input(path, MAX_KEYS_BYTES).map_err(|e| no_file(e.to_string()))?;
                String::from_utf8(bytes).map_err(|e| no_file(e.to_string()))?
            }
            None => String::new(),
        };
        let replay = Replay::new(&lines, args.text.as_deref().unwrap_or("")).map_err(|e| {
            refuse(format!(
                "{}: {e}",
                args.keys.as_ref().map_or("--keys".into(), |path| path.display().to_string())
            ))
        })?;
        let no_devices = |e: io::Error| refuse(format!("no input devices: {e}"));
        let devices = InputDevices::new(device).map_err(no_devices)?;
        if io::stdin().is_terminal() {
            forward_stdin(terminals.clone()).map_err(no_devices)?;
        }
        let client = server.client();
        client.send(Command::Events(true));
        Ok(Input { devices, replay, terminals, client })
    }

    /// Passes on what has come since the last call. Returns whether a replay is going on.
    pub fn pass_on(&mut self, device: &Device, is_changed: bool, now: Instant) -> bool {
        self.devices.poll();
        self.terminals.activate(device.active_terminal());
        let mut events: Vec<InputEvent> = self.client.events();
        events.extend(self.replay.due(device.opens() > 0, is_changed, now));
        for event in events {
            let bytes = self.devices.feed(device, &event);
            self.write(&bytes);
        }
        !self.replay.is_over()
    }

    /// Writes to the console, unless it is full: nobody reads it then.
    fn write(&self, bytes: &[u8]) {
        let mut master = self.terminals.master();
        let mut ready = [PollFd::new(&master, PollFlags::OUT)];
        let now = Timespec { tv_sec: 0, tv_nsec: 0 };
        if !bytes.is_empty() && poll(&mut ready, Some(&now)).is_ok_and(|n| n > 0) {
            // Fails if the terminal is gone, and with it who would read it.
            let _ = master.write_all(bytes);
        }
    }
}

/// Copies standard input to the console, line by line as the terminal gives it.
fn forward_stdin(terminals: Terminals) -> io::Result<()> {
    std::thread::Builder::new().name("stdin".into()).spawn(move || {
        let (mut stdin, mut bytes) = (io::stdin(), [0; 1024]);
        while let Ok(len @ 1..) = stdin.read(&mut bytes) {
            if terminals.master().write_all(&bytes[..len]).is_err() {
                return;
            }
        }
    })?;
    Ok(())
}
