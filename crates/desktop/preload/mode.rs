//! Modes of the emulated framebuffer: `struct fb_var_screeninfo`, the pixel formats, and which
//! modes the device accepts.
//!
//! Source: `linux/fb.h`, and for the rules `fb_set_var` of `drivers/video/fbdev/core/fbmem.c` and
//! `vfb_check_var` of `drivers/video/fbdev/vfb.c`. Pure functions without a system call; the
//! program and the preload library include this file.

/// `EINVAL`.
pub const INVALID: i32 = 22;
/// `ENOMEM`.
pub const NO_MEMORY: i32 = 12;

/// `FB_ACTIVATE_TEST` in [`Var::activate`]: the mode is checked and not set.
pub const ACTIVATE_TEST: u32 = 2;
/// `FB_ACTIVATE_MASK`.
pub const ACTIVATE_MASK: u32 = 15;
/// `FB_NONSTD_REV_PIX_IN_B` in [`Var::nonstd`]: the leftmost pixel of a byte is its highest bits.
pub const REVERSED_PIXELS: u32 = 2;
/// `FB_VMODE_YWRAP` in [`Var::vmode`].
pub const VMODE_YWRAP: u32 = 256;

/// `struct fb_bitfield`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Bitfield {
    /// Lowest bit.
    pub offset: u32,
    /// Number of bits.
    pub length: u32,
    /// Nonzero if the most significant bit is right.
    pub msb_right: u32,
}

const fn field(offset: u32, length: u32) -> Bitfield {
    Bitfield { offset, length, msb_right: 0 }
}

/// `struct fb_var_screeninfo`, field by field.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[allow(missing_docs)]
pub struct Var {
    pub xres: u32,
    pub yres: u32,
    pub xres_virtual: u32,
    pub yres_virtual: u32,
    pub xoffset: u32,
    pub yoffset: u32,
    pub bits_per_pixel: u32,
    pub grayscale: u32,
    pub red: Bitfield,
    pub green: Bitfield,
    pub blue: Bitfield,
    pub transp: Bitfield,
    pub nonstd: u32,
    pub activate: u32,
    pub height: u32,
    pub width: u32,
    pub accel_flags: u32,
    pub pixclock: u32,
    pub left_margin: u32,
    pub right_margin: u32,
    pub upper_margin: u32,
    pub lower_margin: u32,
    pub hsync_len: u32,
    pub vsync_len: u32,
    pub sync: u32,
    pub vmode: u32,
    pub rotate: u32,
    pub colorspace: u32,
    pub reserved: [u32; 4],
}

impl Var {
    /// Creates the structure from its 40 words.
    pub fn from_words(w: [u32; 40]) -> Var {
        let bits = |at: usize| Bitfield { offset: w[at], length: w[at + 1], msb_right: w[at + 2] };
        Var {
            xres: w[0],
            yres: w[1],
            xres_virtual: w[2],
            yres_virtual: w[3],
            xoffset: w[4],
            yoffset: w[5],
            bits_per_pixel: w[6],
            grayscale: w[7],
            red: bits(8),
            green: bits(11),
            blue: bits(14),
            transp: bits(17),
            nonstd: w[20],
            activate: w[21],
            height: w[22],
            width: w[23],
            accel_flags: w[24],
            pixclock: w[25],
            left_margin: w[26],
            right_margin: w[27],
            upper_margin: w[28],
            lower_margin: w[29],
            hsync_len: w[30],
            vsync_len: w[31],
            sync: w[32],
            vmode: w[33],
            rotate: w[34],
            colorspace: w[35],
            reserved: [w[36], w[37], w[38], w[39]],
        }
    }

    /// Returns the 40 words of the structure.
    pub fn to_words(self) -> [u32; 40] {
        let v = self;
        let [r, g, b, t] = [v.red, v.green, v.blue, v.transp];
        [
            v.xres,
            v.yres,
            v.xres_virtual,
            v.yres_virtual,
            v.xoffset,
            v.yoffset,
            v.bits_per_pixel,
            v.grayscale,
            r.offset,
            r.length,
            r.msb_right,
            g.offset,
            g.length,
            g.msb_right,
            b.offset,
            b.length,
            b.msb_right,
            t.offset,
            t.length,
            t.msb_right,
            v.nonstd,
            v.activate,
            v.height,
            v.width,
            v.accel_flags,
            v.pixclock,
            v.left_margin,
            v.right_margin,
            v.upper_margin,
            v.lower_margin,
            v.hsync_len,
            v.vsync_len,
            v.sync,
            v.vmode,
            v.rotate,
            v.colorspace,
            v.reserved[0],
            v.reserved[1],
            v.reserved[2],
            v.reserved[3],
        ]
    }
}

/// Returns the bytes of a row of `width` pixels, as `get_line_length` of `vfb.c` does.
const fn line_bytes(width: u32, bits: u32) -> u64 {
    (width as u64 * bits as u64).div_ceil(32) * 4
}

/// A pixel format by name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Format {
    /// Name of `--format`: the order in memory from 24 bits on, from the highest bit at 16.
    pub name: &'static str,
    /// Bits of a pixel.
    pub bits: u32,
    /// 1 for grey levels.
    pub grayscale: u32,
    /// Red, green, blue and transparency.
    pub channels: [Bitfield; 4],
}

const fn format(name: &'static str, bits: u32, red: u32, green: u32, blue: u32, transp: Bitfield) -> Format {
    let channels = [field(red, 8), field(green, 8), field(blue, 8), transp];
    Format { name, bits, grayscale: 0, channels }
}

const fn high(name: &'static str, red: Bitfield, green: Bitfield, blue: Bitfield) -> Format {
    Format { name, bits: 16, grayscale: 0, channels: [red, green, blue, field(0, 0)] }
}

const fn palette(name: &'static str, bits: u32, grayscale: u32) -> Format {
    let index = field(0, bits);
    Format { name, bits, grayscale, channels: [index, index, index, field(0, 0)] }
}

/// All formats, those of each depth in the order in which they are preferred.
pub const FORMATS: &[Format] = &[
    format("bgrx", 32, 16, 8, 0, field(0, 0)),
    format("rgba", 32, 0, 8, 16, field(24, 8)),
    format("bgra", 32, 16, 8, 0, field(24, 8)),
    format("rgbx", 32, 0, 8, 16, field(0, 0)),
    format("xrgb", 32, 8, 16, 24, field(0, 0)),
    format("xbgr", 32, 24, 16, 8, field(0, 0)),
    format("argb", 32, 8, 16, 24, field(0, 8)),
    format("abgr", 32, 24, 16, 8, field(0, 8)),
    format("bgr24", 24, 16, 8, 0, field(0, 0)),
    format("rgb24", 24, 0, 8, 16, field(0, 0)),
    high("rgb565", field(11, 5), field(5, 6), field(0, 5)),
    high("bgr565", field(0, 5), field(5, 6), field(11, 5)),
    high("rgb555", field(10, 5), field(5, 5), field(0, 5)),
    high("bgr555", field(0, 5), field(5, 5), field(10, 5)),
    palette("pal8", 8, 0),
    palette("gray8", 8, 1),
    palette("pal4", 4, 0),
    palette("pal2", 2, 0),
    palette("mono", 1, 0),
];

impl Format {
    /// Returns the index of the format of this name.
    pub fn index(name: &str) -> Option<usize> {
        FORMATS.iter().position(|f| f.name == name)
    }

    /// Returns whether pixels are indices of the palette.
    pub fn is_indexed(&self) -> bool {
        self.bits <= 8
    }
}

/// Constants of a device, by which modes are checked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DeviceLimits {
    /// Width of the frame in pixels: the largest mode.
    pub width: u32,
    /// Height of the frame in pixels.
    pub height: u32,
    /// Bytes of its memory.
    pub smem_len: u32,
    /// Vertical blanks a second.
    pub hz: u32,
    /// Index of the default format.
    pub format: u32,
    /// Least bytes of a row: a multiple of four, 0 for rows without padding.
    pub least_line: u32,
}

impl DeviceLimits {
    /// Returns the bytes of a row of a mode's virtual screen: a multiple of four.
    pub fn line_length(&self, var: &Var) -> u32 {
        self.line_bytes(var.xres_virtual, var.bits_per_pixel) as u32
    }

    /// Returns the bytes of a row of `width` pixels, with its padding.
    pub fn line_bytes(&self, width: u32, bits: u32) -> u64 {
        line_bytes(width, bits).max(self.least_line.into())
    }
}

/// Returns the format of a mode, by its depth and bit fields; the preferred one of the depth for
/// other bit fields.
pub fn format_of(var: &Var, default: u32) -> Option<&'static Format> {
    let bits = match var.bits_per_pixel {
        1 => 1,
        2 => 2,
        3..=4 => 4,
        5..=8 => 8,
        9..=16 => 16,
        17..=24 => 24,
        25..=32 => 32,
        _ => return None,
    };
    let of_depth = || FORMATS.iter().filter(move |f| f.bits == bits);
    if bits <= 8 {
        return of_depth().find(|f| f.grayscale == var.grayscale).or_else(|| of_depth().next());
    }
    let place = |b: &Bitfield| (b.offset, b.length);
    let colors = [var.red, var.green, var.blue];
    let same_colors = move |f: &&Format| f.channels[..3].iter().map(place).eq(colors.iter().map(place));
    let same_alpha = |f: &&Format| f.channels[3].length == var.transp.length;
    let default = FORMATS.get(default as usize).filter(|f| f.bits == bits);
    // Fifteen bits without bit fields are five a channel.
    let of_15 = || of_depth().find(|f| var.bits_per_pixel == 15 && f.name == "rgb555");
    of_depth()
        .find(|f| same_colors(f) && same_alpha(f))
        .or_else(|| of_depth().find(same_colors))
        .or_else(of_15)
        .or(default)
        .or_else(|| of_depth().next())
}

/// Returns the mode that is set when `wanted` is asked for.
///
/// # Errors
/// `EINVAL` for a mode that the device does not have, `ENOMEM` for a virtual screen that is larger
/// than its memory.
pub fn check(wanted: &Var, device: &DeviceLimits) -> Result<Var, i32> {
    let format = format_of(wanted, device.format).ok_or(INVALID)?;
    let least = [device.width.min(8), device.height.min(8)];
    let is_size =
        (least[0]..=device.width).contains(&wanted.xres) && (least[1]..=device.height).contains(&wanted.yres);
    if !is_size || wanted.grayscale > 1 || wanted.rotate != 0 || wanted.vmode & VMODE_YWRAP != 0 {
        return Err(INVALID);
    }
    let far = |offset: u32, res: u32| offset.checked_add(res).ok_or(INVALID);
    let xres_virtual = wanted.xres_virtual.max(far(wanted.xoffset, wanted.xres)?);
    let yres_virtual = wanted.yres_virtual.max(far(wanted.yoffset, wanted.yres)?);
    // Rows of 2^32 pixels and as many rows have less than 2^66 bits: the first factor is bounded.
    let line = device.line_bytes(xres_virtual, format.bits);
    if line > u64::from(device.smem_len) || line * u64::from(yres_virtual) > u64::from(device.smem_len) {
        return Err(NO_MEMORY);
    }
    Ok(mode(Var { xres_virtual, yres_virtual, ..*wanted }, format, device.hz))
}

/// Returns whether the visible part can be moved there, as `fb_pan_display` checks it. It begins at
/// a byte.
pub fn can_pan(var: &Var, xoffset: u32, yoffset: u32) -> bool {
    let fits = |offset: u32, res: u32, whole: u32| offset.checked_add(res).is_some_and(|end| end <= whole);
    fits(xoffset, var.xres, var.xres_virtual)
        && fits(yoffset, var.yres, var.yres_virtual)
        && u64::from(xoffset) * u64::from(var.bits_per_pixel) % 8 == 0
}

/// Returns the mode that a device has before a program sets one.
pub fn initial(device: &DeviceLimits) -> Var {
    let format = &FORMATS[device.format as usize % FORMATS.len()];
    let var = Var {
        xres: device.width,
        yres: device.height,
        xres_virtual: device.width,
        yres_virtual: device.height,
        ..Var::default()
    };
    mode(var, format, device.hz)
}

/// Completes a mode: its bit fields, its timings, and the picture's size in millimetres at 96 dots
/// an inch.
fn mode(var: Var, format: &Format, hz: u32) -> Var {
    let [red, green, blue, transp] = format.channels;
    let margin = var.xres / 8;
    let (total, lines) = (u64::from(var.xres + 3 * margin), u64::from(var.yres) + 24);
    let millimetres = |pixels: u32| (u64::from(pixels) * 254 / 960) as u32;
    Var {
        bits_per_pixel: format.bits,
        grayscale: format.grayscale,
        red,
        green,
        blue,
        transp,
        nonstd: if format.bits < 8 { var.nonstd & REVERSED_PIXELS } else { 0 },
        activate: 0,
        height: millimetres(var.yres),
        width: millimetres(var.xres),
        accel_flags: 0,
        pixclock: (1_000_000_000_000 / (total * lines * u64::from(hz.max(1)))).clamp(1, 0xffff_ffff) as u32,
        left_margin: margin,
        right_margin: margin,
        hsync_len: margin,
        upper_margin: 16,
        lower_margin: 4,
        vsync_len: 4,
        sync: 0,
        vmode: 0,
        rotate: 0,
        colorspace: 0,
        reserved: [0; 4],
        ..var
    }
}
