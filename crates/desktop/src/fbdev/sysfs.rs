//! The files of `/sys/class/graphics/fb0` that programs write.
//!
//! In: texts in memory files, which the preload library opens for programs. Out: changes of the
//! control page, at the next vertical blank. Programs also write by ways that the library does not
//! see, as streams do, so a text is read here, whoever wrote it. Nothing that is written panics.

use super::attributes::{self, Change, WRITABLE};
use super::device::Device;
use super::layout as at;
use super::mode::Var;
use rustix::fs::{FlockOperation, MemfdFlags, SealFlags, fcntl_add_seals, flock, memfd_create};
use std::fs::File;
use std::io;
use std::os::unix::fs::FileExt;
use std::sync::atomic::Ordering;

/// Bytes of a file.
const ATTRIBUTE_BYTES: usize = 4096;
/// Last byte of a writable file whose text has been seen before its line's end.
const SEEN: u8 = 0xff;

/// Creates a writable file of `/sys`.
pub(super) fn attribute(name: &str) -> io::Result<File> {
    let flags = MemfdFlags::CLOEXEC | MemfdFlags::ALLOW_SEALING;
    let file = File::from(memfd_create(format!("fbptr-{name}"), flags)?);
    file.set_len(ATTRIBUTE_BYTES as u64)?;
    fcntl_add_seals(&file, SealFlags::SHRINK | SealFlags::GROW | SealFlags::SEAL)?;
    Ok(file)
}

impl Device {
    /// Carries out what programs have written to the files of `/sys` by ways that the preload
    /// library does not see. A text is taken once its line has ended, or when it has been there
    /// before.
    pub fn take_attributes(&self) {
        if self.word(at::WRITERS_AT) == 0 {
            return;
        }
        for (file, name) in self.attributes.iter().zip(WRITABLE) {
            let mut bytes = [0; ATTRIBUTE_BYTES];
            let _ = file.read_at(&mut bytes, 0);
            let Some(start) = bytes.iter().position(|b| *b != 0 && *b != SEEN) else { continue };
            let text = bytes[start..].split(|b| *b == 0).next().unwrap_or_default();
            let is_whole = text.ends_with(b"\n") || bytes[ATTRIBUTE_BYTES - 1] == SEEN;
            let mark = if is_whole { 0 } else { SEEN };
            if is_whole {
                let lines = text.split(|b| *b == b'\n').filter(|line| !line.is_empty());
                lines.for_each(|line| self.change(name, line));
                let _ = file.write_all_at(&vec![0; text.len()], start as u64);
            }
            let _ = file.write_all_at(&[mark], ATTRIBUTE_BYTES as u64 - 1);
        }
    }

    /// Carries out what a text in a file of `/sys` asks for. One that is refused is forgotten: who
    /// wrote it has been told that it was taken.
    fn change(&self, name: &str, line: &[u8]) {
        let (_, before) = self.mode();
        match attributes::change(name, line, &before, &self.limits) {
            Ok(Change::Mode(var)) => self.set_mode(&before, var),
            Ok(Change::Pan(x, y)) => self.set_pan(x, y),
            Ok(Change::Blank(level)) => self.set_word(at::BLANK_AT, level),
            Ok(Change::Nothing) | Err(_) => {}
        }
    }

    fn set_pan(&self, x: u32, y: u32) {
        self.control.long(at::PAN_AT).store(u64::from(x) | u64::from(y) << 32, Ordering::Release);
        self.control.word(at::PANS_AT).fetch_add(1, Ordering::AcqRel);
    }

    /// Sets a mode, unless a program does so in this moment: the later one counts.
    fn set_mode(&self, before: &Var, var: Var) {
        if flock(self.control.file(), FlockOperation::NonBlockingLockExclusive).is_err() {
            return;
        }
        let sets = self.word(at::MODE_SETS_AT).wrapping_add(1);
        for (i, word) in var.to_words().into_iter().enumerate() {
            self.set_word(at::mode_word_at(sets, i), word);
        }
        self.set_pan(var.xoffset, var.yoffset);
        self.set_word(at::MODE_SETS_AT, sets);
        if var.bits_per_pixel <= 8 && var.bits_per_pixel != before.bits_per_pixel {
            self.reset_palette(var.bits_per_pixel, var.grayscale != 0);
            self.set_word(at::PALETTE_SETS_AT, self.word(at::PALETTE_SETS_AT).wrapping_add(1));
        }
        let _ = flock(self.control.file(), FlockOperation::Unlock);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fbdev::DeviceOptions;

    #[test]
    fn texts_are_taken_by_the_line_or_when_they_stay() {
        let device =
            Device::new(&DeviceOptions { size: (64, 40), format: 0, hz: 60, line_length: 0, is_glut: false })
                .unwrap();
        let file = |name: &str| &device.attributes[WRITABLE.iter().position(|n| *n == name).unwrap()];
        file("blank").write_all_at(b"1\n", 0).unwrap();
        device.take_attributes();
        assert_eq!(device.word(at::BLANK_AT), 0, "nobody has opened a file");
        device.set_word(at::WRITERS_AT, 1);
        device.take_attributes();
        assert_eq!(device.word(at::BLANK_AT), 1);
        // Several lines, later in the file; and a text without the end of a line.
        file("blank").write_all_at(b"0\n4\n3\n", 100).unwrap();
        file("bits_per_pixel").write_all_at(b"16", 0).unwrap();
        device.take_attributes();
        assert_eq!((device.word(at::BLANK_AT), device.mode().1.bits_per_pixel), (3, 32));
        device.take_attributes();
        assert_eq!(device.mode().1.bits_per_pixel, 16);
        // Texts that mean nothing, and bytes that are none.
        let bytes: Vec<u8> = (0..ATTRIBUTE_BYTES).map(|i| (i * 7 + i / 256) as u8).collect();
        for name in WRITABLE {
            file(name).write_all_at(&bytes, 0).unwrap();
        }
        (0..5).for_each(|_| device.take_attributes());
    }

    #[test]
    fn numbers_are_read_as_the_kernel_does_it() {
        let device =
            Device::new(&DeviceOptions { size: (64, 40), format: 0, hz: 60, line_length: 0, is_glut: false })
                .unwrap();
        let change = |name, text: &[u8]| attributes::change(name, text, &device.mode().1, &device.limits);
        for (text, bits) in [("0x10\n", 16), ("020", 16), ("8", 8), ("32\n", 32), ("24x", 24)] {
            let found = change("bits_per_pixel", text.as_bytes());
            assert!(
                matches!(found, Ok(Change::Mode(var)) if var.bits_per_pixel == bits),
                "{text}: {found:?}"
            );
        }
        let virtual_size = |text: &str| match change("virtual_size", text.as_bytes()) {
            Ok(Change::Mode(var)) => Some((var.xres_virtual, var.yres_virtual)),
            _ => None,
        };
        assert_eq!(virtual_size("64,80\n"), Some((64, 80)));
        assert_eq!((virtual_size("64"), virtual_size("64,"), virtual_size("64,9999")), (None, None, None));
        assert_eq!(change("pan", b"0,0"), Ok(Change::Pan(0, 0)));
        for (name, text) in [
            ("pan", "0,1"),
            ("bits_per_pixel", "x"),
            ("mode", "U:64x40"),
            ("mode", "64x40p-60"),
            ("rotate", "1"),
        ] {
            assert_eq!(change(name, text.as_bytes()), Err(22), "{name} {text}");
        }
        assert!(matches!(change("mode", b"U:32x20p-75\n"), Ok(Change::Mode(var)) if var.xres == 32));
        assert_eq!(change("blank", b"99"), Ok(Change::Blank(4)));
        assert_eq!(change("cursor", b"1"), Ok(Change::Nothing));
    }
}
