//! Layout of the control page: the state of the emulated framebuffer device that `fbptr run` and
//! the programs it runs share.
//!
//! A page of shared memory, all of it 32-bit and 64-bit words that are read and written atomically,
//! little-endian as the machine is. Both sides include this file: the program `fbptr`, which maps
//! the page from safe code, and the preload library. Offsets are in bytes.
//!
//! The variable screen information is written into the slot after the current one and then made the
//! current one, so that a writer that is killed leaves the earlier one whole.

/// Bytes of the page.
pub const CONTROL_BYTES: usize = 8192;
/// First word of the page.
pub const MAGIC: u32 = u32::from_le_bytes(*b"FBD1");

/// The magic.
pub const MAGIC_AT: usize = 0;
/// Bytes of the framebuffer memory.
pub const SMEM_LEN_AT: usize = 4;
/// Width of the frame in pixels.
pub const WIDTH_AT: usize = 8;
/// Height of the frame in pixels.
pub const HEIGHT_AT: usize = 12;
/// Vertical blanks so far; a futex.
pub const VSYNC_AT: usize = 16;
/// Vertical blanks a second.
pub const HZ_AT: usize = 20;
/// Number of times that the mode was set; it chooses the slot.
pub const MODE_SETS_AT: usize = 24;
/// Number of times that the palette was written.
pub const PALETTE_SETS_AT: usize = 28;
/// Blanking level, 0 for a picture.
pub const BLANK_AT: usize = 32;
/// Number of times that the visible part was moved.
pub const PANS_AT: usize = 36;
/// Number of these that the scan-out has taken over; a futex.
pub const PANS_TAKEN_AT: usize = 40;
/// Processes that have loaded the library.
pub const LOADS_AT: usize = 44;
/// Times that the framebuffer was opened.
pub const OPENS_AT: usize = 48;
/// Index of the format that the device has by default, in [`super::mode::FORMATS`].
pub const FORMAT_AT: usize = 52;
/// Number of entries that the log has had.
pub const LOGGED_AT: usize = 56;
/// Mode of the console, as `KDSETMODE` sets it.
pub const CONSOLE_MODE_AT: usize = 60;
/// Mode of the keyboard, as `KDSKBMODE` sets it.
pub const KEYBOARD_MODE_AT: usize = 64;
/// Lights of the keyboard.
pub const LEDS_AT: usize = 68;
/// Number of the active virtual terminal.
pub const ACTIVE_TERMINAL_AT: usize = 72;
/// Least bytes of a row, for rows with padding.
pub const LEAST_LINE_AT: usize = 76;
/// Mode of the virtual terminal as `VT_SETMODE` sets it: two words.
pub const TERMINAL_MODE_AT: usize = 88;
/// Set when no more scan-outs will come: nobody waits for them.
pub const ENDED_AT: usize = 96;
/// The pointer's place on the frame: two words.
pub const POINTER_AT: usize = 100;
/// Number of programs without the device that were told.
pub const TOLD_AT: usize = 108;
/// Number of times that a file of `/sys/class/graphics/fb0` was opened for writing.
pub const WRITERS_AT: usize = 112;
/// Set if the first row of the memory is the lowest of the picture.
pub const FLIPPED_AT: usize = 116;
/// Set if [`OUTSIDE_AT`] counts some of the stores only.
pub const OUTSIDE_IS_LEAST_AT: usize = 120;
/// First visible pixel of the virtual screen: xoffset in the low half, yoffset in the high half.
pub const PAN_AT: usize = 128;
/// Width and height of the window that a program of GLUT has made, two words; 0 before that.
pub const WINDOW_AT: usize = 136;
/// Bytes that such a program has stored outside of its video memory: 64 bits.
pub const OUTSIDE_AT: usize = 144;
/// Place of the first of them in bytes from the memory's start: 64 bits with a sign.
pub const OUTSIDE_FIRST_AT: usize = 152;
/// Bytes of the program's allocation that are the video memory; 0 if none is: 64 bits.
pub const DIRECT_BYTES_AT: usize = 160;
/// Set while callbacks of a program of GLUT run: its picture may be half of one.
pub const IS_DRAWING_AT: usize = 168;
/// Set if such a program is to wait for a vertical blank when its callbacks have returned.
pub const IS_PAUSE_WANTED_AT: usize = 172;
/// The mode's slots.
pub const MODES_AT: usize = 256;
/// Number of slots.
pub const MODES: usize = 4;
/// Words of a slot: `struct fb_var_screeninfo`.
pub const MODE_WORDS: usize = 40;
/// The log: refused requests, as a ring of 64-bit words.
pub const LOG_AT: usize = 1024;
/// Entries of the ring.
pub const LOG_ENTRIES: usize = 64;
/// The palette: an entry is four 16-bit values, red lowest, in one 64-bit word.
pub const PALETTE_AT: usize = 2048;
/// Entries of the palette.
pub const PALETTE_ENTRIES: usize = 256;

/// Programs that were started and cannot have the device, as a ring of texts: a word that says why
/// ([`super::elf::Unserved`]) and how long the path is, 0 before it is whole, and the path.
pub const TEXTS_AT: usize = 4096;
/// Texts of the ring.
pub const TEXTS: usize = 8;
/// Bytes of a text with its word.
pub const TEXT_BYTES: usize = 256;
/// Keys and buttons that are held: a bit a code.
pub const HELD_AT: usize = 6144;
/// Bytes of these bits.
pub const HELD_BYTES: usize = 96;
/// Descriptors of the program `fbptr` that are the writable files of `/sys/class/graphics/fb0`: a
/// word each, in the order of [`super::attributes::WRITABLE`].
pub const ATTRIBUTE_FDS_AT: usize = 6272;
/// Inodes of these files: 64 bits each.
pub const ATTRIBUTE_INODES_AT: usize = 6400;

/// Number of the pseudo terminal that stands for each virtual terminal from 1 on, plus one; 0
/// without one: a word each.
pub const TERMINALS_AT: usize = 6528;
/// Virtual terminals, as many as the kernel has.
pub const TERMINALS: usize = 63;

/// Name of the environment variable by which a program finds the device.
pub const ENVIRONMENT: &str = "FBPTR_RUN";

/// Devices of an entry of the log.
pub const LOG_DEVICES: [&str; 3] = ["/dev/fb0", "the console", "/dev/input"];

/// Returns the offset of word `word` of the slot that `sets` chooses.
pub const fn mode_word_at(sets: u32, word: usize) -> usize {
    MODES_AT + (sets as usize % MODES * MODE_WORDS + word) * 4
}

/// Packs a palette entry.
pub const fn pack_color(red: u16, green: u16, blue: u16, transp: u16) -> u64 {
    red as u64 | (green as u64) << 16 | (blue as u64) << 32 | (transp as u64) << 48
}

/// Unpacks a palette entry: red, green, blue, transparency.
pub const fn unpack_color(entry: u64) -> [u16; 4] {
    [entry as u16, (entry >> 16) as u16, (entry >> 32) as u16, (entry >> 48) as u16]
}

/// Palette entry `index` of a device that has `1 << bits` of them, before a program sets one: the
/// console's colours of the kernel's `fbcmap.c`, or grey levels.
pub const fn default_color(index: u32, bits: u32, is_grey: bool) -> u64 {
    let top = (1u32 << bits) - 1;
    if is_grey || bits <= 2 {
        let level = if index > top { 0 } else { (index * 0xffff / top) as u16 };
        return pack_color(level, level, level, 0);
    }
    if index > 15 {
        return 0;
    }
    // Bit 2 is red, bit 1 green, bit 0 blue; bit 3 makes all of them lighter; 6 is brown.
    let light = if index & 8 != 0 { 0x5555 } else { 0 };
    let green = if index == 6 { 0x5555 } else { level_of(index & 2 != 0, light) };
    pack_color(level_of(index & 4 != 0, light), green, level_of(index & 1 != 0, light), 0)
}

const fn level_of(bit: bool, light: u16) -> u16 {
    if bit { 0xaaaa + light } else { light }
}
