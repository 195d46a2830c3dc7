//! Pixels of a program: their formats, and copying them into the picture.

use super::state::state;
use super::{screen, textures};
use core::ffi::{c_uint, c_void};

/// Type of a component.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Component {
    Byte,
    Short,
    Word,
    Float,
}

/// Format of pixels in memory.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct Kind {
    component: Component,
    /// Components of a pixel.
    count: u8,
    /// The components that are red, green, blue and alpha; from `count` on it is full.
    places: [u8; 4],
}

impl Kind {
    /// Returns the format of three or four bytes R, G, B, A.
    pub const fn rgb(count: usize) -> Kind {
        Kind { component: Component::Byte, count: count as u8, places: [0, 1, 2, 3] }
    }

    /// Returns the format that two numbers of OpenGL name; `None` for one that is not served.
    pub fn of(format: c_uint, component: c_uint) -> Option<Kind> {
        let (count, mut places) = match format {
            // GL_RGB, GL_RGBA, GL_BGR, GL_BGRA, GL_LUMINANCE and GL_RED, GL_LUMINANCE_ALPHA, GL_ABGR_EXT
            0x1907 => (3, [0, 1, 2, 3]),
            0x1908 => (4, [0, 1, 2, 3]),
            0x80e0 => (3, [2, 1, 0, 3]),
            0x80e1 => (4, [2, 1, 0, 3]),
            0x1909 => (1, [0, 0, 0, 1]),
            0x1903 => (1, [0, 4, 4, 1]),
            0x190a => (2, [0, 0, 0, 1]),
            0x8000 => (4, [3, 2, 1, 0]),
            _ => return None,
        };
        let component = match component {
            // GL_UNSIGNED_BYTE, GL_UNSIGNED_INT_8_8_8_8_REV
            0x1401 => Component::Byte,
            0x8367 if count == 4 => Component::Byte,
            // GL_UNSIGNED_INT_8_8_8_8: the first component is the highest byte.
            0x8035 if count == 4 => {
                places = places.map(|place| 3 - place);
                Component::Byte
            }
            0x1403 => Component::Short,
            0x1405 => Component::Word,
            0x1406 => Component::Float,
            _ => return None,
        };
        Some(Kind { component, count, places })
    }

    /// Returns the bytes of a pixel.
    pub fn bytes(self) -> usize {
        let component = match self.component {
            Component::Byte => 1,
            Component::Short => 2,
            Component::Word | Component::Float => 4,
        };
        component * self.count as usize
    }

    /// Returns the order of red, green and blue in memory, if the device has such a format.
    pub fn direct_order(self) -> Option<[u8; 3]> {
        let [red, green, blue, alpha] = self.places;
        let is_direct = self.component == Component::Byte
            && self.count >= 3
            && alpha == 3
            && matches!([red, green, blue], [0, 1, 2] | [2, 1, 0]);
        is_direct.then_some([red, green, blue])
    }

    /// Reads a pixel as R, G, B, A.
    ///
    /// # Safety
    /// `from` points to a pixel of this format.
    pub unsafe fn read(self, from: *const u8) -> [u8; 4] {
        self.places.map(|place| {
            if place >= self.count {
                // No alpha is full; no colour is none.
                return if place == 4 { 0 } else { 255 };
            }
            let place = place as usize;
            // SAFETY: the component is one of the pixel's, says the caller.
            unsafe {
                match self.component {
                    Component::Byte => *from.add(place),
                    Component::Short => (from.cast::<u16>().add(place).read_unaligned() >> 8) as u8,
                    Component::Word => (from.cast::<u32>().add(place).read_unaligned() >> 24) as u8,
                    Component::Float => {
                        (from.cast::<f32>().add(place).read_unaligned().clamp(0.0, 1.0) * 255.0 + 0.5) as u8
                    }
                }
            }
        })
    }
}

/// Pixels in memory, row by row.
#[derive(Clone, Copy)]
pub struct Image {
    pub start: *const u8,
    pub width: usize,
    pub height: usize,
    pub row_bytes: usize,
    pub kind: Kind,
}

impl Image {
    /// Describes pixels that a program passes, as `glPixelStorei` has them.
    pub fn unpacked(start: *const c_void, width: usize, height: usize, kind: Kind) -> Image {
        let unpack = &state().unpack;
        let row = if unpack.row_length.get() > 0 { unpack.row_length.get() } else { width };
        let row_bytes = (row * kind.bytes()).next_multiple_of(unpack.alignment.get().max(1));
        let skipped = unpack.skip_rows.get() * row_bytes + unpack.skip_pixels.get() * kind.bytes();
        Image { start: start.cast::<u8>().wrapping_add(skipped), width, height, row_bytes, kind }
    }

    /// Returns whether the device shows these bytes as they are.
    pub fn is_whole(&self) -> bool {
        let size = state().size.get();
        (self.width, self.height) == (size.0 as usize, size.1 as usize)
            && self.row_bytes == self.width * self.kind.bytes()
            && self.kind.direct_order().is_some()
    }

    /// Returns a pixel as R, G, B, A.
    ///
    /// # Safety
    /// The pixel is inside, and the memory is that of the image.
    pub unsafe fn pixel(&self, column: usize, row: usize) -> [u8; 4] {
        // SAFETY: the caller's promise.
        unsafe { self.kind.read(self.start.add(row * self.row_bytes + column * self.kind.bytes())) }
    }
}

/// Place of an image in the window: the pixel at x of the window, counted from the left and from the
/// bottom, shows column `scale.0 * x + offset.0`, and likewise its row.
#[derive(Clone, Copy)]
pub struct Place {
    pub scale: (f32, f32),
    pub offset: (f32, f32),
    /// Left, right, bottom, top in pixels of the window.
    pub edges: [f32; 4],
}

/// Draws an image. An allocation of the program that covers the window becomes what it shows.
///
/// # Safety
/// The memory is that of the image.
pub unsafe fn draw(image: &Image, place: &Place) {
    let (width, height) = state().size.get();
    let (width, height) = (width as f32, height as f32);
    let near = |a: f32, b: f32| (a - b).abs() < 1e-2;
    let covers = place.edges[0] <= 0.5
        && place.edges[1] >= width - 0.5
        && place.edges[2] <= 0.5
        && place.edges[3] >= height - 0.5;
    let is_flipped = near(place.scale.1, 1.0) && near(place.offset.1, 0.0);
    let is_upright = near(place.scale.1, -1.0) && near(place.offset.1, height);
    let is_exact = covers
        && near(place.scale.0, 1.0)
        && near(place.offset.0, 0.0)
        && (is_flipped || is_upright)
        && image.is_whole();
    if is_exact && screen::show(image.start as usize, image.kind, is_flipped) {
        return;
    }
    if covers {
        state().is_clear_due.set(false);
    } else {
        screen::clear_if_due();
    }
    // SAFETY: the caller's promise.
    unsafe { copy(image, place) };
}

/// Copies an image into the picture.
///
/// # Safety
/// The memory is that of the image.
unsafe fn copy(image: &Image, place: &Place) {
    let canvas = screen::canvas();
    if canvas.is_null() || image.width == 0 || image.height == 0 {
        return;
    }
    let (width, height) = state().size.get();
    // The pixels whose middles are inside.
    let first = |edge: f32| ((edge + 0.5).max(0.0)) as usize;
    let [left, right, bottom, top] = place.edges.map(first);
    let index = |scale: f32, offset: f32, at: usize, len: usize| {
        ((scale * (at as f32 + 0.5) + offset).max(0.0) as usize).min(len - 1)
    };
    for y in bottom..top.min(height as usize) {
        let row = index(place.scale.1, place.offset.1, y, image.height);
        for x in left..right.min(width as usize) {
            let column = index(place.scale.0, place.offset.0, x, image.width);
            // SAFETY: the pixel is one of the image's, and the map has one for each of the window.
            unsafe {
                let pixel = image.pixel(column, row);
                canvas.add((height as usize - 1 - y) * width as usize + x).write_volatile(pixel);
            }
        }
    }
}

/// Draws pixels at the raster position.
///
/// # Safety
/// As for OpenGL's function: `pixels` points to the pixels.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn glDrawPixels(
    width: i32,
    height: i32,
    format: c_uint,
    component: c_uint,
    pixels: *const c_void,
) {
    let Some(kind) = Kind::of(format, component) else {
        return super::ignored::tell(b"glDrawPixels of this format");
    };
    let (Ok(columns), Ok(rows)) = (usize::try_from(width), usize::try_from(height)) else { return };
    let image = Image::unpacked(pixels, columns, rows, kind);
    let (raster, zoom) = (state().raster.get(), state().zoom.get());
    if pixels.is_null() || zoom.0 == 0.0 || zoom.1 == 0.0 {
        return;
    }
    let ends = |start: f32, len: usize, zoom: f32| {
        let end = start + len as f32 * zoom;
        [start.min(end), start.max(end)]
    };
    let [left, right] = ends(raster.0, columns, zoom.0);
    let [bottom, top] = ends(raster.1, rows, zoom.1);
    let place = Place {
        scale: (1.0 / zoom.0, 1.0 / zoom.1),
        offset: (-raster.0 / zoom.0, -raster.1 / zoom.1),
        edges: [left, right, bottom, top],
    };
    // SAFETY: the caller's promise.
    unsafe { draw(&image, &place) };
}

/// Draws the bound texture on a rectangle: corners of the window, and texture coordinates of its
/// lower left and upper right one.
pub fn draw_texture(edges: [f32; 4], from: (f32, f32), to: (f32, f32)) {
    let Some(image) = textures::bound_image() else { return };
    let [left, right, bottom, top] = edges;
    let scale = (
        (to.0 - from.0) / (right - left) * image.width as f32,
        (to.1 - from.1) / (top - bottom) * image.height as f32,
    );
    let offset =
        (from.0 * image.width as f32 - left * scale.0, from.1 * image.height as f32 - bottom * scale.1);
    // SAFETY: the image of a texture is its own memory, or an allocation that is not given back.
    unsafe { draw(&image, &Place { scale, offset, edges }) };
}
