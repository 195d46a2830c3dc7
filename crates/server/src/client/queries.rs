//! The verbs that answer: each method waits until all earlier commands have run, and returns the
//! reply as a value.

use super::{Client, has_ended};
use fbptr_command::{Command, Rect, SnapTarget};
use fbptr_core::error::{Code, Fault};
use fbptr_core::memory::{Rgba, parse_color};

/// Returns the fault of a reply that is not the verb's.
fn no_reply(verb: &str) -> Fault {
    Fault::new(Code::Proto, format!("a reply of {verb} expected"))
}

impl Client {
    /// Runs a command, and returns its reply's text without the line end.
    fn ask_text(&self, command: Command) -> Result<String, Fault> {
        let reply = self.ask(command)?;
        Ok(String::from_utf8_lossy(&reply).trim_end().to_owned())
    }

    /// Runs a command, and returns the words of its reply behind `head`, the verb and the words
    /// that it repeats.
    fn ask_words(&self, command: Command, head: &str) -> Result<Vec<String>, Fault> {
        let text = self.ask_text(command)?;
        let words = text.strip_prefix(head).ok_or_else(|| no_reply(head))?;
        Ok(words.split_whitespace().map(str::to_owned).collect())
    }

    /// Runs a command, and returns the payload of its reply, which is announced by a line.
    fn ask_payload(&self, command: Command, verb: &str) -> Result<Vec<u8>, Fault> {
        let mut reply = self.ask(command)?;
        let line = reply.iter().position(|&byte| byte == b'\n').ok_or_else(|| no_reply(verb))?;
        if !reply.starts_with(verb.as_bytes()) {
            return Err(no_reply(verb));
        }
        Ok(reply.split_off(line + 1))
    }

    /// Sends `SIZE`, and returns width and height of the frame.
    ///
    /// # Errors
    /// If the render thread has ended.
    pub fn size(&self) -> Result<[u32; 2], Fault> {
        let words = self.ask_words(Command::Size, "SIZE ")?;
        match &words.iter().map(|word| word.parse()).collect::<Vec<_>>()[..] {
            [Ok(width), Ok(height)] => Ok([*width, *height]),
            _ => Err(no_reply("SIZE")),
        }
    }

    /// Sends `PX x y`, and returns the pixel's colour, which is opaque: the reply has no alpha. (For
    /// that, [`Client::read`] one pixel.)
    ///
    /// # Errors
    /// If the pixel is outside the frame, or the render thread has ended.
    pub fn get_pixel(&self, x: i32, y: i32) -> Result<Rgba, Fault> {
        let words = self.ask_words(Command::GetPixel { x, y }, "PX ")?;
        let color = words.last().and_then(|word| parse_color(word.as_bytes()));
        color.ok_or_else(|| no_reply("PX"))
    }

    /// Sends `PEEK`, and returns `n` bytes from a byte offset on.
    ///
    /// # Errors
    /// If a byte is outside the memory, `n` is over the limit, or the render thread has ended.
    pub fn peek(&self, offset: i32, n: i32) -> Result<Vec<u8>, Fault> {
        let words = self.ask_words(Command::Peek { offset, n }, "PEEK ")?;
        let hex = words.get(1).map_or("", String::as_str).as_bytes();
        let byte = |pair: &[u8; 2]| u8::from_str_radix(str::from_utf8(pair).ok()?, 16).ok();
        hex.as_chunks().0.iter().map(byte).collect::<Option<_>>().ok_or_else(|| no_reply("PEEK"))
    }

    /// Sends `READ`, and returns the RGBA rows of a rectangle.
    ///
    /// # Errors
    /// If the rectangle is not entirely inside the frame, or the render thread has ended.
    pub fn read(&self, rect: impl Into<Rect>) -> Result<Vec<u8>, Fault> {
        self.ask_payload(Command::Read { rect: rect.into() }, "READ")
    }

    /// Sends `CRC` of the video memory, and returns the checksum.
    ///
    /// # Errors
    /// If the render thread has ended.
    pub fn crc(&self) -> Result<u32, Fault> {
        self.checksum(None)
    }

    /// Sends `CRC` of a rectangle, and returns the checksum.
    ///
    /// # Errors
    /// If the rectangle is not entirely inside the frame, or the render thread has ended.
    pub fn crc_of(&self, rect: impl Into<Rect>) -> Result<u32, Fault> {
        self.checksum(Some(rect.into()))
    }

    fn checksum(&self, rect: Option<Rect>) -> Result<u32, Fault> {
        let words = self.ask_words(Command::Crc { rect }, "CRC ")?;
        let crc = words.last().and_then(|hex| u32::from_str_radix(hex, 16).ok());
        crc.ok_or_else(|| no_reply("CRC"))
    }

    /// Sends `DEPTHAT`, and returns the depth of a pixel, from 0 (near) to 1 (far).
    ///
    /// # Errors
    /// If the pixel is outside the frame, or the render thread has ended.
    pub fn depth_at(&self, x: i32, y: i32) -> Result<f64, Fault> {
        let words = self.ask_words(Command::DepthAt { x, y }, "DEPTHAT ")?;
        words.last().and_then(|z| z.parse().ok()).ok_or_else(|| no_reply("DEPTHAT"))
    }

    /// Sends `PICK`, and returns the name and the triangle that are seen at a pixel, or `None`.
    ///
    /// # Errors
    /// If the pixel is outside the frame, or the render thread has ended.
    pub fn pick(&self, x: i32, y: i32) -> Result<Option<(String, u32)>, Fault> {
        let words = self.ask_words(Command::Pick { x, y }, "PICK ")?;
        match &words[..] {
            [_, _, _, triangle] if triangle == "-1" => Ok(None),
            [_, _, name, triangle] => {
                Ok(Some((name.clone(), triangle.parse().map_err(|_| no_reply("PICK"))?)))
            }
            _ => Err(no_reply("PICK")),
        }
    }

    /// Sends `HELP`, and returns the list of verbs.
    ///
    /// # Errors
    /// If the render thread has ended.
    pub fn help(&self) -> Result<String, Fault> {
        self.ask_text(Command::Help)
    }

    /// Sends `STATS`, and returns its line of `key=value` words.
    ///
    /// # Errors
    /// If the render thread has ended.
    pub fn stats(&self) -> Result<String, Fault> {
        self.ask_text(Command::Stats)
    }

    /// Sends `HELLO`, and returns its line: protocol, version, size, stride and pixel format.
    ///
    /// # Errors
    /// If the render thread has ended.
    pub fn hello(&self) -> Result<String, Fault> {
        self.ask_text(Command::Hello)
    }

    /// Sends `VERSION`, and returns the program's version.
    ///
    /// # Errors
    /// If the render thread has ended.
    pub fn version(&self) -> Result<String, Fault> {
        Ok(self.ask_words(Command::Version, "VERSION fbptr ")?.join(" "))
    }

    /// Sends `SNAP name`, which writes the frame to the server's snapshot folder, and returns the
    /// frame's checksum.
    ///
    /// # Errors
    /// If there is no snapshot folder, the name is refused, or the file cannot be written.
    pub fn snap(&self, name: &str) -> Result<u32, Fault> {
        let words = self.ask_words(Command::Snap(SnapTarget::File(name.into())), "SNAP ")?;
        let crc = words.last().and_then(|hex| u32::from_str_radix(hex, 16).ok());
        crc.ok_or_else(|| no_reply("SNAP"))
    }

    /// Sends `SNAP :`, and returns the frame as the bytes of a PNG file.
    ///
    /// # Errors
    /// If the memory budget has no room for it, or the render thread has ended.
    pub fn snap_png(&self) -> Result<Vec<u8>, Fault> {
        self.ask_payload(Command::Snap(SnapTarget::Connection), "SNAP")
    }

    /// Sends `PRESENT wait`: ends a frame and waits until it is shown. Returns its number.
    ///
    /// # Errors
    /// If the render thread has ended.
    pub fn present(&self) -> Result<u64, Fault> {
        let words = self.ask_words(Command::Present { wait: true }, "FRAME ");
        words.ok().and_then(|words| words.first()?.parse().ok()).ok_or_else(has_ended)
    }
}
