//! The input devices: `/dev/input/event0` (a keyboard), `event1` (a pointer with absolute
//! coordinates) and `mice` (PS/2), and the keys of the console.
//!
//! In: events of a window or of a replay, and what programs write to the devices. Out: bytes as the
//! kernel's devices give them, to every program that has a device open. A device is a socket in the
//! abstract namespace, of which no file is left; the preload library connects to it. Everything is
//! done by [`InputDevices::poll`] and [`InputDevices::feed`], on the thread that calls them, and
//! nothing of it blocks: a program that does not read loses events, others do not notice.

mod evdev;
mod ps2;

use super::device::Device;
use super::keys::{self, LEFT_SHIFT};
use super::layout as at;
use evdev::{ABS, Batch, KEY, REL};
use fbptr_core::input::InputEvent;
use ps2::Ps2;
use rustix::net::sockopt::socket_peercred;
use std::io::{self, ErrorKind, Read, Write};
use std::os::linux::net::SocketAddrExt;
use std::os::unix::net::{SocketAddr, UnixListener, UnixStream};

/// Most bytes that a program may be behind; later events are dropped.
const BEHIND: usize = 64 << 10;
/// Most programs that may have a device open.
const READERS: usize = 64;
/// Codes of the buttons: left, right, middle, in the order of PS/2.
const BUTTONS: [(u8, u16); 3] = [(1, 0x110), (4, 0x111), (2, 0x112)];

/// Kind of a device, in the order of their sockets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Keyboard,
    Pointer,
    Mice,
}

const KINDS: [(Kind, &str); 3] =
    [(Kind::Keyboard, "event0"), (Kind::Pointer, "event1"), (Kind::Mice, "mice")];

/// A program that has a device open.
#[derive(Debug)]
struct Reader {
    kind: Kind,
    stream: UnixStream,
    /// Clock of the events' times, as `EVIOCSCLOCKID` sets it.
    clock: u8,
    mouse: Ps2,
    /// Bytes that the socket has had no room for.
    pending: Vec<u8>,
    /// A request of which only the first byte has come.
    is_clock_next: bool,
}

/// The input devices of a run.
#[derive(Debug)]
pub struct InputDevices {
    listeners: Vec<(Kind, UnixListener)>,
    readers: Vec<Reader>,
    size: (u32, u32),
    pointer: (i32, i32, u8),
}

impl InputDevices {
    /// Creates the devices.
    ///
    /// # Errors
    /// If the system refuses a socket.
    pub fn new(device: &Device) -> io::Result<InputDevices> {
        let mut listeners = Vec::new();
        for (kind, name) in KINDS {
            let name = format!("fbptr-run-{}-{}/{name}", std::process::id(), device.inode()?);
            let listener = UnixListener::bind_addr(&SocketAddr::from_abstract_name(name)?)?;
            listener.set_nonblocking(true)?;
            listeners.push((kind, listener));
        }
        let size = device.size();
        Ok(InputDevices { listeners, readers: Vec::new(), size, pointer: (0, 0, 0) })
    }

    /// Lets new programs in, and answers what programs have written.
    pub fn poll(&mut self) {
        for (kind, listener) in &self.listeners {
            while let Ok((stream, _)) = listener.accept() {
                let is_own = socket_peercred(&stream).is_ok_and(|peer| peer.uid == rustix::process::getuid());
                if is_own && self.readers.len() < READERS && stream.set_nonblocking(true).is_ok() {
                    self.readers.push(Reader::new(*kind, stream));
                }
            }
        }
        self.readers.retain_mut(Reader::answer);
    }

    /// Passes an event to the devices. Returns the bytes that the console's terminal gets.
    pub fn feed(&mut self, device: &Device, event: &InputEvent) -> Vec<u8> {
        match event {
            InputEvent::Key { name, down } => {
                let Some(key) = keys::by_name(name) else { return Vec::new() };
                let mut batch = Batch::new();
                batch.add(KEY, key.code.into(), i32::from(*down));
                device.hold(key.code.into(), *down);
                self.send(Kind::Keyboard, &batch);
                console_key(device.word(at::KEYBOARD_MODE_AT), key, *down)
            }
            InputEvent::Text(character) => console_text(device.word(at::KEYBOARD_MODE_AT), *character),
            InputEvent::Mouse { x, y, buttons } => {
                self.move_pointer(device, *x, *y, *buttons);
                Vec::new()
            }
            InputEvent::Wheel { dx, dy } => {
                let mut batch = Batch::new();
                // REL_WHEEL, REL_HWHEEL
                batch.add_unless_zero(REL, 8, *dy);
                batch.add_unless_zero(REL, 6, *dx);
                self.send(Kind::Pointer, &batch);
                self.send_mouse(0, 0, *dy);
                Vec::new()
            }
            InputEvent::Resize { .. } | InputEvent::Close => Vec::new(),
        }
    }

    fn move_pointer(&mut self, device: &Device, x: i32, y: i32, buttons: u8) {
        let inside = |v: i32, side: u32| v.clamp(0, side.min(i32::MAX as u32) as i32 - 1);
        let (x, y) = (inside(x, self.size.0), inside(y, self.size.1));
        let (old_x, old_y, old_buttons) = std::mem::replace(&mut self.pointer, (x, y, buttons));
        device.set_word(at::POINTER_AT, x as u32);
        device.set_word(at::POINTER_AT + 4, y as u32);
        let mut batch = Batch::new();
        for (axis, old, new) in [(0, old_x, x), (1, old_y, y)] {
            if old != new {
                batch.add(ABS, axis, new);
            }
        }
        for (bit, code) in BUTTONS {
            if (old_buttons ^ buttons) & bit != 0 {
                batch.add(KEY, code, i32::from(buttons & bit != 0));
                device.hold(code, buttons & bit != 0);
            }
        }
        self.send(Kind::Pointer, &batch);
        if (old_x, old_y, old_buttons) != (x, y, buttons) {
            self.send_mouse(x - old_x, y - old_y, 0);
        }
    }

    /// Sends a batch of events to all who have the device open.
    fn send(&mut self, kind: Kind, batch: &Batch) {
        if !batch.is_empty() {
            for reader in self.readers.iter_mut().filter(|reader| reader.kind == kind) {
                let bytes = batch.bytes(reader.clock);
                reader.push(&bytes);
            }
        }
    }

    fn send_mouse(&mut self, dx: i32, dy: i32, wheel: i32) {
        let buttons = self.pointer.2;
        for reader in self.readers.iter_mut().filter(|reader| reader.kind == Kind::Mice) {
            let bytes = reader.mouse.packets(dx, dy, wheel, buttons);
            reader.push(&bytes);
        }
    }
}

impl Reader {
    fn new(kind: Kind, stream: UnixStream) -> Self {
        Reader { kind, stream, clock: 0, mouse: Ps2::default(), pending: Vec::new(), is_clock_next: false }
    }

    /// Queues bytes, all of them or none, and sends what there is room for.
    fn push(&mut self, bytes: &[u8]) {
        if self.pending.len() + bytes.len() <= BEHIND {
            self.pending.extend_from_slice(bytes);
        }
        while !self.pending.is_empty() {
            match self.stream.write(&self.pending) {
                Ok(sent) if sent > 0 => drop(self.pending.drain(..sent)),
                _ => return,
            }
        }
    }

    /// Reads what the program has written, and answers. Returns false once it has closed the
    /// device.
    fn answer(&mut self) -> bool {
        let mut bytes = [0; 256];
        loop {
            match self.stream.read(&mut bytes) {
                Ok(0) => return false,
                Ok(len) => {
                    for byte in &bytes[..len] {
                        self.take(*byte);
                    }
                }
                Err(e) if e.kind() == ErrorKind::Interrupted => {}
                Err(e) if e.kind() == ErrorKind::WouldBlock => break,
                Err(_) => return false,
            }
        }
        self.push(&[]);
        true
    }

    fn take(&mut self, byte: u8) {
        if self.kind == Kind::Mice {
            let answer = self.mouse.command(byte);
            return self.push(&answer);
        }
        // The library sends the letter c and the clock's number.
        if std::mem::replace(&mut self.is_clock_next, byte == b'c') {
            (self.clock, self.is_clock_next) = (byte, false);
        }
    }
}

/// Modes of the keyboard in which the console gives characters.
const XLATE: u32 = 1;
const UNICODE: u32 = 3;

/// Returns the bytes that a key gives on the console in this mode of the keyboard.
fn console_key(mode: u32, key: &keys::Key, down: bool) -> Vec<u8> {
    const RAW: u32 = 0;
    const MEDIUM_RAW: u32 = 2;
    match mode {
        // Codes of both modes are the same for the keys of the first keyboards.
        MEDIUM_RAW => vec![key.code | u8::from(!down) << 7],
        RAW if key.code < 0x59 => vec![key.code | u8::from(!down) << 7],
        RAW => Vec::new(),
        // Characters come as such.
        XLATE | UNICODE if down && key.sequence.len() > 1 => key.sequence.as_bytes().to_vec(),
        _ => Vec::new(),
    }
}

/// Returns the bytes that a character gives on the console in this mode of the keyboard: one byte
/// of Latin-1 as `K_XLATE` has it, UTF-8 as `K_UNICODE` has it.
fn console_text(mode: u32, character: char) -> Vec<u8> {
    match (mode, character) {
        // The delete key is one with a sequence of its own; windows give a character, too.
        (XLATE | UNICODE, '\x7f') => Vec::new(),
        (XLATE | UNICODE, '\x08') => vec![0x7f],
        (XLATE, c) => u8::try_from(c).map_or_else(|_| Vec::new(), |byte| vec![byte]),
        (UNICODE, c) => c.encode_utf8(&mut [0; 4]).as_bytes().to_vec(),
        _ => Vec::new(),
    }
}

/// Returns the events of typing a character: what goes down, with the character, and what goes up
/// again.
pub fn typing(character: char) -> [Vec<InputEvent>; 2] {
    let key = |code: u8, down| {
        let name = keys::KEYS.iter().find(|key| key.code == code).map_or("", |key| key.name);
        InputEvent::Key { name: name.to_owned(), down }
    };
    // A terminal's line ends with a carriage return.
    let text = InputEvent::Text(if character == '\n' { '\r' } else { character });
    match keys::by_character(character) {
        None => [vec![text], Vec::new()],
        Some((found, false)) => [vec![key(found.code, true), text], vec![key(found.code, false)]],
        Some((found, true)) => {
            let shift = |down| key(LEFT_SHIFT, down);
            [vec![shift(true), key(found.code, true), text], vec![key(found.code, false), shift(false)]]
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fbdev::DeviceOptions;

    /// Devices, and a program that has opened one of them.
    fn opened(name: &str) -> (Device, InputDevices, UnixStream) {
        let device =
            Device::new(&DeviceOptions { size: (64, 40), format: 0, hz: 60, line_length: 0, is_glut: false })
                .unwrap();
        let mut inputs = InputDevices::new(&device).unwrap();
        let name = format!("fbptr-run-{}-{}/{name}", std::process::id(), device.inode().unwrap());
        let stream = UnixStream::connect_addr(&SocketAddr::from_abstract_name(name).unwrap()).unwrap();
        stream.set_nonblocking(true).unwrap();
        inputs.poll();
        (device, inputs, stream)
    }

    fn read(stream: &mut UnixStream) -> Vec<u8> {
        let mut bytes = vec![0; 4096];
        let len = stream.read(&mut bytes).unwrap_or(0);
        bytes.truncate(len);
        bytes
    }

    /// Type, code and value of each event.
    fn events(bytes: &[u8]) -> Vec<(u16, u16, i32)> {
        assert_eq!(bytes.len() % 24, 0);
        let half = |b: &[u8], at: usize| u16::from_ne_bytes([b[at], b[at + 1]]);
        let value = |b: &[u8]| i32::from_ne_bytes(b[20..24].try_into().unwrap());
        bytes.chunks(24).map(|b| (half(b, 16), half(b, 18), value(b))).collect()
    }

    #[test]
    fn keys_arrive_as_events_and_on_the_console_as_its_mode_says() {
        let (device, mut inputs, mut stream) = opened("event0");
        for (mode, down, up) in [
            (3, b"\x1b[D".as_slice(), b"".as_slice()),
            (1, b"\x1b[D", b""),
            (2, &[105], &[233]),
            (0, b"", b""),
            (4, b"", b""),
        ] {
            device.set_word(at::KEYBOARD_MODE_AT, mode);
            let key = |down| InputEvent::Key { name: "left".into(), down };
            assert_eq!(inputs.feed(&device, &key(true)), down, "mode {mode}");
            assert_eq!(inputs.feed(&device, &key(false)), up, "mode {mode}");
            let expected = [(1, 105, 1), (0, 0, 0), (1, 105, 0), (0, 0, 0)];
            assert_eq!(events(&read(&mut stream)), expected);
        }
        assert_eq!(inputs.feed(&device, &InputEvent::Key { name: "none".into(), down: true }), b"");
        device.set_word(at::KEYBOARD_MODE_AT, 3);
        let text = |c| InputEvent::Text(c);
        let typed = ['a', 'é', '\x08', '\x7f', '\r'].map(|c| inputs.feed(&device, &text(c)));
        assert_eq!(typed.concat(), "aé\x7f\r".as_bytes());
        device.set_word(at::KEYBOARD_MODE_AT, 1);
        assert_eq!(['é', '€'].map(|c| inputs.feed(&device, &text(c))).concat(), [0xe9]);
        assert_eq!(read(&mut stream), b"", "characters are no keys");
    }

    #[test]
    fn the_pointer_moves_in_frame_pixels_and_stays_inside() {
        let (device, mut inputs, mut stream) = opened("event1");
        let mut mouse = |x, y, buttons| {
            inputs.feed(&device, &InputEvent::Mouse { x, y, buttons });
            events(&read(&mut stream))
        };
        assert_eq!(mouse(5, 0, 0), [(3, 0, 5), (0, 0, 0)]);
        assert_eq!(mouse(5, 7, 5), [(3, 1, 7), (1, 0x110, 1), (1, 0x111, 1), (0, 0, 0)]);
        assert_eq!(mouse(5, 7, 5), []);
        assert_eq!(mouse(i32::MAX, i32::MIN, 0).first(), Some(&(3, 0, 63)));
        assert_eq!((device.word(at::POINTER_AT), device.word(at::POINTER_AT + 4)), (63, 0));
        inputs.feed(&device, &InputEvent::Wheel { dx: 0, dy: -2 });
        assert_eq!(events(&read(&mut stream)), [(2, 8, -2), (0, 0, 0)]);
    }

    #[test]
    fn a_mouse_answers_its_commands_and_moves_relatively() {
        let (device, mut inputs, mut stream) = opened("mice");
        inputs.feed(&device, &InputEvent::Mouse { x: 10, y: 3, buttons: 1 });
        assert_eq!(read(&mut stream), [0x29, 10, 253]);
        stream.write_all(&[0xf3, 200, 0xf3, 100, 0xf3, 80, 0xf2]).unwrap();
        inputs.poll();
        assert_eq!(read(&mut stream), [0xfa, 0xfa, 0xfa, 0xfa, 0xfa, 0xfa, 0xfa, 3]);
        inputs.feed(&device, &InputEvent::Wheel { dx: 0, dy: 1 });
        assert_eq!(read(&mut stream), [9, 0, 0, 255]);
        drop(stream);
        inputs.poll();
        assert!(inputs.readers.is_empty());
    }

    #[test]
    fn a_program_that_does_not_read_loses_events_only() {
        let (device, mut inputs, mut stream) = opened("event0");
        for _ in 0..20_000 {
            inputs.feed(&device, &InputEvent::Key { name: "a".into(), down: true });
        }
        assert!(inputs.readers[0].pending.len() <= BEHIND);
        // Whole events are lost, never parts of one.
        let mut all = Vec::new();
        loop {
            let bytes = read(&mut stream);
            if bytes.is_empty() {
                break;
            }
            all.extend(bytes);
            inputs.poll();
        }
        assert!(events(&all).chunks(2).all(|pair| pair == [(1, 30, 1), (0, 0, 0)]));
    }

    #[test]
    fn typing_presses_the_keys_that_give_the_character() {
        let names = |c| -> Vec<String> {
            let name = |event: InputEvent| match event {
                InputEvent::Key { name, down } => format!("{}{name}", if down { '+' } else { '-' }),
                other => format!("{other:?}"),
            };
            typing(c).into_iter().flatten().map(name).collect()
        };
        assert_eq!(names('A'), ["+leftshift", "+a", "Text('A')", "-a", "-leftshift"]);
        assert_eq!(names('\n'), ["+enter", "Text('\\r')", "-enter"]);
        assert_eq!(names('ß'), ["Text('ß')"]);
        assert_eq!(names('-')[0], "+minus");
    }
}
