//! The device's shared memories: the framebuffer memory, the control page, and the preload library
//! as a file, each without a name in the file system.

use super::attributes::WRITABLE;
use super::elf::Unserved;
use super::layout as at;
use super::mode::{self, DeviceLimits, Var};
use super::sysfs;
pub use fbptr_core::memory::DeviceMemory;
use rustix::fs::{MemfdFlags, fstat, memfd_create};
use rustix::thread::futex;
use std::fs::File;
use std::io::{self, Read, Write};
use std::os::fd::{AsFd, AsRawFd};
use std::os::unix::fs::FileExt;
use std::sync::atomic::{AtomicU32, Ordering};

/// The compiled preload library, as gzip.
const LIBRARY: &[u8] = include_bytes!(concat!(env!("OUT_DIR"), "/fbptr_preload.so.gz"));
/// Its variant that also stands for GLUT and OpenGL.
const GLUT_LIBRARY: &[u8] = include_bytes!(concat!(env!("OUT_DIR"), "/fbptr_glut.so.gz"));

/// Returns the preload library, or its variant that also stands for GLUT and OpenGL.
///
/// # Errors
/// None: what is compiled in can be read.
pub fn preload_library(is_glut: bool) -> io::Result<Vec<u8>> {
    let mut library = Vec::new();
    let packed = if is_glut { GLUT_LIBRARY } else { LIBRARY };
    flate2::read::GzDecoder::new(packed).read_to_end(&mut library)?;
    Ok(library)
}

/// Screens' worth of memory that a device has: two more than are visible, for page flipping.
const SCREENS: u64 = 3;

/// Properties of a device.
#[derive(Clone, Copy, Debug)]
pub struct DeviceOptions {
    /// Width and height of the frame in pixels.
    pub size: (u32, u32),
    /// Index of the format that it has before a program sets one, in [`mode::FORMATS`].
    pub format: usize,
    /// Vertical blanks a second.
    pub hz: u32,
    /// Bytes of a row where its pixels need less; 0 for rows without padding.
    pub line_length: u32,
    /// The program is linked with GLUT, and draws in one screen of its window's size.
    pub is_glut: bool,
}

/// A framebuffer device.
#[derive(Debug)]
pub struct Device {
    memory: DeviceMemory,
    pub(super) control: DeviceMemory,
    library: File,
    /// The writable files of `/sys/class/graphics/fb0`, in the order of [`WRITABLE`].
    pub(super) attributes: Vec<File>,
    pub(super) limits: DeviceLimits,
}

impl Device {
    /// Creates a device whose memory is zero.
    ///
    /// # Errors
    /// If the system refuses a memory, or it would be larger than 4 GiB.
    pub fn new(options: &DeviceOptions) -> io::Result<Device> {
        let (width, height) = options.size;
        let least_line = options.line_length.next_multiple_of(4);
        let line = (u64::from(width) * 4).max(least_line.into());
        let screens = if options.is_glut { 1 } else { SCREENS };
        let bytes = (line * u64::from(height) * screens).next_multiple_of(4096);
        let smem_len = u32::try_from(bytes).map_err(|_| {
            io::Error::other(format!("{width}x{height} pixels need {bytes} bytes, more than 4 GiB"))
        })?;
        let format = options.format as u32;
        let limits = DeviceLimits { width, height, smem_len, hz: options.hz, format, least_line };
        let control = DeviceMemory::new("fbptr-control", at::CONTROL_BYTES)?;
        let mut library = File::from(memfd_create("fbptr-preload", MemfdFlags::CLOEXEC)?);
        library.write_all(&preload_library(options.is_glut)?)?;
        let attributes = WRITABLE.iter().map(|name| sysfs::attribute(name)).collect::<io::Result<_>>()?;
        let memory = DeviceMemory::new("fbptr-fb0", bytes as usize)?;
        let device = Device { memory, control, library, attributes, limits };
        device.write_control()?;
        Ok(device)
    }

    /// Writes the control page of a new device, its magic last.
    fn write_control(&self) -> io::Result<()> {
        let set = |at: usize, value: u32| self.control.word(at).store(value, Ordering::Relaxed);
        set(at::SMEM_LEN_AT, self.limits.smem_len);
        set(at::WIDTH_AT, self.limits.width);
        set(at::HEIGHT_AT, self.limits.height);
        set(at::HZ_AT, self.limits.hz);
        set(at::FORMAT_AT, self.limits.format);
        set(at::LEAST_LINE_AT, self.limits.least_line);
        set(at::ACTIVE_TERMINAL_AT, 1);
        // K_UNICODE
        set(at::KEYBOARD_MODE_AT, 3);
        let var = mode::initial(&self.limits);
        for (i, word) in var.to_words().into_iter().enumerate() {
            set(at::mode_word_at(0, i), word);
        }
        self.reset_palette(var.bits_per_pixel.min(8), var.grayscale != 0);
        for (i, file) in self.attributes.iter().enumerate() {
            set(at::ATTRIBUTE_FDS_AT + i * 4, file.as_raw_fd() as u32);
            let inode = fstat(file)?.st_ino;
            self.control.long(at::ATTRIBUTE_INODES_AT + i * 8).store(inode, Ordering::Relaxed);
        }
        self.control.word(at::MAGIC_AT).store(at::MAGIC, Ordering::Release);
        Ok(())
    }

    /// Gives the palette the colours that a depth begins with.
    pub(super) fn reset_palette(&self, bits: u32, is_grey: bool) {
        for index in 0..1 << bits {
            let color = at::default_color(index, bits, is_grey);
            self.control.long(at::PALETTE_AT + index as usize * 8).store(color, Ordering::Relaxed);
        }
    }

    /// Notes that a key or a button is held, or no longer.
    pub(super) fn hold(&self, code: u16, is_down: bool) {
        let code = usize::from(code);
        if code < at::HELD_BYTES * 8 {
            let word = self.control.word(at::HELD_AT + code / 32 * 4);
            match is_down {
                true => word.fetch_or(1 << (code % 32), Ordering::Relaxed),
                false => word.fetch_and(!(1 << (code % 32)), Ordering::Relaxed),
            };
        }
    }

    /// Returns the inode of the framebuffer memory, which no other device has.
    ///
    /// # Errors
    /// If the memory's status cannot be read.
    pub(super) fn inode(&self) -> io::Result<u64> {
        Ok(fstat(self.memory.file())?.st_ino)
    }

    /// Returns the width and height of the frame in pixels.
    pub fn size(&self) -> (u32, u32) {
        (self.limits.width, self.limits.height)
    }

    /// Returns the environment variable, name and value, by which a program finds the device.
    ///
    /// # Errors
    /// If the memory's status cannot be read.
    pub fn environment(&self) -> io::Result<(&'static str, String)> {
        let status = fstat(self.memory.file())?;
        let fd = |file: &File| file.as_fd().as_raw_fd();
        let (control, memory) = (fd(self.control.file()), fd(self.memory.file()));
        let value = format!("{}/{control}/{memory}/{}/{}", std::process::id(), status.st_dev, status.st_ino);
        Ok((at::ENVIRONMENT, value))
    }

    /// Returns the path of the preload library, which is valid while this process lives.
    pub fn library_path(&self) -> String {
        format!("/proc/{}/fd/{}", std::process::id(), self.library.as_raw_fd())
    }

    /// Returns the framebuffer memory.
    pub(super) fn memory(&self) -> &DeviceMemory {
        &self.memory
    }

    /// Waits until the scan-out has taken over the visible part that was set as number `pan`.
    #[cfg(test)]
    pub(super) fn wait_for_pan(&self, pan: u32) {
        let word = self.control.word(at::PANS_TAKEN_AT);
        loop {
            let taken = word.load(Ordering::Acquire);
            if taken == pan {
                return;
            }
            let _ = futex::wait(word, futex::Flags::empty(), taken, None);
        }
    }

    /// Returns the constants by which modes are checked.
    pub(super) fn limits(&self) -> &DeviceLimits {
        &self.limits
    }

    /// Returns a word of the control page.
    pub(super) fn word(&self, at: usize) -> u32 {
        self.control.word(at).load(Ordering::Acquire)
    }

    /// Returns a 64-bit word of the control page.
    pub(super) fn long(&self, at: usize) -> u64 {
        self.control.long(at).load(Ordering::Acquire)
    }

    pub(super) fn set_word(&self, at: usize, value: u32) {
        self.control.word(at).store(value, Ordering::Release);
    }

    #[cfg(test)]
    pub(super) fn set_long(&self, at: usize, value: u64) {
        self.control.long(at).store(value, Ordering::Release);
    }

    /// Sets the numbers of the pseudo terminals that stand for the virtual terminals from 1 on.
    pub fn set_terminals(&self, numbers: impl Iterator<Item = Option<u32>>) {
        for (index, number) in numbers.take(at::TERMINALS).enumerate() {
            self.set_word(at::TERMINALS_AT + index * 4, number.map_or(0, |number| number + 1));
        }
    }

    /// Returns the number of the virtual terminal that has the keyboard, from 1.
    pub fn active_terminal(&self) -> u32 {
        self.word(at::ACTIVE_TERMINAL_AT)
    }

    /// Returns the number of times that a program has opened the device.
    pub fn opens(&self) -> u32 {
        self.word(at::OPENS_AT)
    }

    /// Returns the size in pixels of the window that a program of GLUT has made; `None` before that.
    pub fn window(&self) -> Option<(u32, u32)> {
        let width = self.word(at::WINDOW_AT);
        (width != 0).then(|| (width, self.word(at::WINDOW_AT + 4)))
    }

    /// Returns whether callbacks of a program of GLUT run, so that its picture may be half of one.
    pub fn is_drawing(&self) -> bool {
        self.word(at::IS_DRAWING_AT) != 0
    }

    /// Lets such a program wait for a vertical blank when they have returned.
    pub fn ask_for_pause(&self) {
        self.set_word(at::IS_PAUSE_WANTED_AT, 1);
    }

    /// Returns a line about stores outside of the video memory of a program of GLUT, if there were
    /// any. Bytes between the memory's end and that of its last page are not watched: those that
    /// are not zero count.
    pub fn stores_outside(&self) -> Option<String> {
        let mut bytes = self.long(at::OUTSIDE_AT);
        let mut first = self.long(at::OUTSIDE_FIRST_AT) as i64;
        let len = (self.long(at::DIRECT_BYTES_AT) as usize).min(self.memory.len_bytes());
        let mut rest = vec![0; len.next_multiple_of(4096).min(self.memory.len_bytes()) - len];
        // A memory that cannot be read has had no stores.
        let is_read = self.memory.file().read_exact_at(&mut rest, len as u64).is_ok();
        let stored: Vec<usize> = (0..rest.len()).filter(|i| is_read && rest[*i] != 0).collect();
        if let Some(place) = stored.first() {
            let place = (len + place) as i64;
            first = if bytes == 0 || (0..first).contains(&place) { place } else { first };
            bytes += stored.len() as u64;
        }
        let (_, var) = self.mode();
        let line = i64::from(self.limits.line_length(&var)).max(1);
        let pixel = i64::from(var.bits_per_pixel / 8).max(1);
        let least = if self.word(at::OUTSIDE_IS_LEAST_AT) == 0 { "" } else { "at least " };
        let unit = if bytes == 1 { "byte" } else { "bytes" };
        let (x, y) = (first.rem_euclid(line) / pixel, first.div_euclid(line));
        (bytes > 0).then(|| {
            format!(
                "{least}{bytes} {unit} stored outside the video memory; the first at FBptr[{first}], x = {x}, y = {y}"
            )
        })
    }

    /// Returns the number of processes that have loaded the library.
    pub fn loads(&self) -> u32 {
        self.word(at::LOADS_AT)
    }

    /// Returns the mode as it was last set. The slot may have been taken for a later mode while it
    /// was read: then the next call returns that one.
    pub(super) fn mode(&self) -> (u32, Var) {
        let sets = self.word(at::MODE_SETS_AT);
        let word = |i: usize| self.control.word(at::mode_word_at(sets, i)).load(Ordering::Relaxed);
        (sets, Var::from_words(std::array::from_fn(word)))
    }

    /// Takes over the place of the visible part, and lets those go on who wait for that. Returns
    /// xoffset and yoffset.
    pub(super) fn take_pan(&self) -> (u32, u32) {
        let pans = self.word(at::PANS_AT);
        let pan = self.long(at::PAN_AT);
        let taken = self.control.word(at::PANS_TAKEN_AT);
        if taken.swap(pans, Ordering::AcqRel) != pans {
            wake(taken);
        }
        (pan as u32, (pan >> 32) as u32)
    }

    /// Begins a vertical blank: those who wait for it go on.
    pub fn vsync(&self) {
        let count = self.control.word(at::VSYNC_AT);
        count.fetch_add(1, Ordering::AcqRel);
        wake(count);
    }

    /// Ends the device: nobody waits for a scan-out any longer.
    pub fn end(&self) {
        self.set_word(at::ENDED_AT, 1);
        wake(self.control.word(at::VSYNC_AT));
        wake(self.control.word(at::PANS_TAKEN_AT));
    }

    /// Returns the programs that were started and cannot have the device since `seen`, the number
    /// of those returned before, as lines.
    pub fn unserved_programs(&self, seen: &mut u32) -> Vec<String> {
        let told = self.word(at::TOLD_AT);
        let first = (*seen).max(told.saturating_sub(at::TEXTS as u32));
        let mut lines = Vec::new();
        for number in first..told {
            let start = at::TEXTS_AT + number as usize % at::TEXTS * at::TEXT_BYTES;
            let head = self.long(start);
            // A text that is not written yet is returned the next time.
            if head == 0 {
                break;
            }
            let words = (8..at::TEXT_BYTES).step_by(8).flat_map(|at| self.long(start + at).to_le_bytes());
            let path: Vec<u8> = words.take(head as u32 as usize).collect();
            let why = Unserved::ALL.iter().find(|why| **why as u64 == head >> 32);
            let reason = why.map_or("cannot be served", |why| why.reason());
            lines.push(format!("{}: {reason}", String::from_utf8_lossy(&path)));
            *seen = number + 1;
        }
        lines
    }

    /// Returns the requests that programs made in vain since `seen`, the number of those returned
    /// before, as lines.
    pub fn refused_requests(&self, seen: &mut u32) -> Vec<String> {
        let logged = self.word(at::LOGGED_AT);
        let first = (*seen).max(logged.saturating_sub(at::LOG_ENTRIES as u32));
        let mut lines = Vec::new();
        for number in first..logged {
            let entry = self.long(at::LOG_AT + number as usize % at::LOG_ENTRIES * 8);
            // An entry that is not written yet is returned the next time.
            if entry == 0 {
                break;
            }
            let device = at::LOG_DEVICES.get((entry >> 32 & 0xff) as usize).unwrap_or(&"a device");
            lines.push(format!("{device}: unknown request {:#x}: EINVAL", entry as u32));
            *seen = number + 1;
        }
        lines
    }
}

impl Drop for Device {
    fn drop(&mut self) {
        self.end();
    }
}

/// Wakes all who wait for a change of the word, in whatever process.
fn wake(word: &AtomicU32) {
    // Fails for no word of ours; a waiter would look again after a tenth of a second.
    let _ = futex::wake(word, futex::Flags::empty(), i32::MAX as u32);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn device() -> Device {
        Device::new(&DeviceOptions { size: (64, 40), format: 0, hz: 60, line_length: 0, is_glut: false })
            .unwrap()
    }

    #[test]
    fn modes_are_those_of_the_kernels_rules() {
        let device = device();
        let limits = *device.limits();
        let (_, var) = device.mode();
        assert_eq!((var.xres, var.yres, limits.line_length(&var), var.red.offset), (64, 40, 256, 16));
        let set = |change: fn(&mut Var)| {
            let mut wanted = var;
            change(&mut wanted);
            mode::check(&wanted, &limits)
        };
        // The bit fields of 32 bits do not fit 16: the depth's own are taken.
        let high = set(|v| v.bits_per_pixel = 16).unwrap();
        assert_eq!((high.red.offset, high.green.length, limits.line_length(&high)), (11, 6, 128));
        assert_eq!(set(|v| v.bits_per_pixel = 15).unwrap().green.length, 5);
        let rgba = set(|v| (v.red.offset, v.blue.offset, v.transp.length) = (0, 16, 8)).unwrap();
        assert_eq!((rgba.red.offset, rgba.transp.offset), (0, 24));
        assert_eq!(set(|v| v.yres_virtual = 120).unwrap().yres_virtual, 120);
        assert_eq!(set(|v| v.yoffset = 10).unwrap().yres_virtual, 50);
        // The memory is of whole pages: 128 rows of 256 bytes.
        assert_eq!(set(|v| v.yres_virtual = 128).unwrap().yres_virtual, 128);
        assert_eq!(set(|v| v.yres_virtual = 129), Err(mode::NO_MEMORY));
        assert_eq!(set(|v| (v.xres_virtual, v.yres_virtual) = (u32::MAX, u32::MAX)), Err(mode::NO_MEMORY));
        assert_eq!(set(|v| v.yoffset = u32::MAX), Err(mode::INVALID));
        for refused in [
            |v: &mut Var| v.xres = 65,
            |v: &mut Var| v.yres = 7,
            |v: &mut Var| v.bits_per_pixel = 33,
            |v: &mut Var| v.grayscale = 0x3231_5659,
            |v: &mut Var| v.rotate = 1,
        ] {
            assert_eq!(set(refused), Err(mode::INVALID));
        }
        for bits in [1, 2, 4, 8] {
            let mut wanted = var;
            wanted.bits_per_pixel = bits;
            let found = mode::check(&wanted, &limits).unwrap();
            assert_eq!((found.bits_per_pixel, found.red.length), (bits, bits));
            assert_eq!(limits.line_length(&found), 8 * bits);
        }
    }

    #[test]
    fn words_of_a_mode_keep_their_order() {
        let words = std::array::from_fn(|i| i as u32 + 1);
        let var = Var::from_words(words);
        assert_eq!(var.to_words(), words);
        assert_eq!((var.bits_per_pixel, var.green.length, var.activate, var.rotate), (7, 13, 22, 35));
    }

    #[test]
    fn refused_requests_are_told_once_and_the_latest_of_many() {
        let device = device();
        let log = |number: u32| {
            let entry = 1 << 63 | u64::from(number);
            device
                .control
                .long(at::LOG_AT + number as usize % at::LOG_ENTRIES * 8)
                .store(entry, Ordering::Release);
            device.set_word(at::LOGGED_AT, number + 1);
        };
        let mut seen = 0;
        log(0);
        assert_eq!(device.refused_requests(&mut seen), ["/dev/fb0: unknown request 0x0: EINVAL"]);
        assert!(device.refused_requests(&mut seen).is_empty());
        (1..200).for_each(log);
        assert_eq!(device.refused_requests(&mut seen).len(), at::LOG_ENTRIES);
        // Numbers that a program has forged.
        device.set_word(at::LOGGED_AT, u32::MAX);
        assert!(device.refused_requests(&mut seen).len() <= at::LOG_ENTRIES);
    }
}
