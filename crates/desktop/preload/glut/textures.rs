//! Textures: a copy of the texels, or the program's own allocation while it is of the window's
//! size.

use super::allocations::{PAGE, map, munmap, region_of};
use super::blit::{Image, Kind};
use super::screen;
use super::state::{TEXTURES, state};
use core::cell::Cell;
use core::ffi::{c_int, c_uint, c_void};
use core::ptr;

const TEXTURE_2D: c_uint = 0x0de1;
const PROXY_TEXTURE_2D: c_uint = 0x8064;
/// Most texels of a side.
const SIDE: usize = 8192;

/// A texture.
pub struct Texture {
    name: Cell<c_uint>,
    size: Cell<(usize, usize)>,
    /// Its own texels, R, G, B, A, and the bytes of the memory; null if it has none.
    texels: Cell<*mut u8>,
    room: Cell<usize>,
    /// The program's allocation that it shows, and its format; null while it shows its own texels.
    source: Cell<*const u8>,
    kind: Cell<Kind>,
}

impl Texture {
    pub const NONE: Texture = Texture {
        name: Cell::new(0),
        size: Cell::new((0, 0)),
        texels: Cell::new(ptr::null_mut()),
        room: Cell::new(0),
        source: Cell::new(ptr::null()),
        kind: Cell::new(Kind::rgb(4)),
    };

    fn image(&self) -> Option<Image> {
        let (width, height) = self.size.get();
        let source = self.source.get();
        let (start, kind) = if source.is_null() {
            (self.texels.get().cast_const(), Kind::rgb(4))
        } else {
            (source, self.kind.get())
        };
        let row_bytes = width * kind.bytes();
        (!start.is_null()).then_some(Image { start, width, height, row_bytes, kind })
    }

    /// Sets the size, with room for texels of its own.
    fn resize(&self, width: usize, height: usize) -> bool {
        let room = (width * height * 4).next_multiple_of(PAGE);
        if self.room.get() < room {
            self.give_back();
            self.texels.set(map(0, room, 0).cast());
            self.room.set(if self.texels.get().is_null() { 0 } else { room });
        }
        self.size.set((width, height));
        !self.texels.get().is_null()
    }

    fn give_back(&self) {
        let room = self.room.replace(0);
        if room > 0 {
            // SAFETY: the memory is the texture's own.
            unsafe { munmap(self.texels.replace(ptr::null_mut()).cast(), room) };
        }
    }

    /// Takes over texels at a place, which is inside.
    ///
    /// # Safety
    /// The memory is that of the image.
    unsafe fn fill(&self, image: &Image, (x, y): (usize, usize)) {
        let (width, texels) = (self.size.get().0, self.texels.get());
        for row in 0..image.height {
            for column in 0..image.width {
                // SAFETY: the texel is inside, and the memory that of the image, says the caller.
                unsafe {
                    let at = ((y + row) * width + x + column) * 4;
                    texels.add(at).cast::<[u8; 4]>().write(image.pixel(column, row));
                }
            }
        }
    }

    /// Copies the program's allocation, which it is going to change or to give back.
    fn keep_copy(&self) {
        let Some(image) = self.image().filter(|_| !self.source.get().is_null()) else { return };
        if self.resize(image.width, image.height) {
            // SAFETY: the allocation is there still, and the texture has room.
            unsafe { self.fill(&image, (0, 0)) };
        }
        self.source.set(ptr::null());
    }
}

/// Copies an allocation that is given back into the textures that show it.
pub fn keep_copies_of(start: usize) {
    // What is on the screen stays there without it.
    if screen::attached() == Some(start) {
        state()
            .textures
            .iter()
            .filter(|t| t.source.get() as usize == start)
            .for_each(|t| t.source.set(ptr::null()));
        return;
    }
    state().textures.iter().filter(|t| t.source.get() as usize == start).for_each(Texture::keep_copy);
}

/// Returns the bound texture, or a free one for a name that is new.
fn bound() -> Option<&'static Texture> {
    let name = state().bound.get().wrapping_add(1);
    let of = |name: c_uint| state().textures.iter().find(|texture| texture.name.get() == name);
    let found = of(name).or_else(|| of(0));
    if let Some(texture) = found {
        texture.name.set(name);
    }
    found
}

/// Returns the texels of the bound texture.
pub fn bound_image() -> Option<Image> {
    bound().and_then(Texture::image)
}

/// Makes names of textures.
///
/// # Safety
/// As for OpenGL's function.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn glGenTextures(count: c_int, names: *mut c_uint) {
    for i in 0..usize::try_from(count).unwrap_or(0) {
        let name = state().next_texture.get();
        state().next_texture.set(name.wrapping_add(1));
        // SAFETY: there is room for `count` names, says the caller.
        unsafe { *names.add(i) = name };
    }
}

/// Chooses the texture that the other calls mean.
#[unsafe(no_mangle)]
pub extern "C" fn glBindTexture(target: c_uint, name: c_uint) {
    if target == TEXTURE_2D {
        state().bound.set(name);
    }
}

/// Gives back textures.
///
/// # Safety
/// As for OpenGL's function.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn glDeleteTextures(count: c_int, names: *const c_uint) {
    for i in 0..usize::try_from(count).unwrap_or(0) {
        // SAFETY: there are `count` names, says the caller.
        let name = unsafe { *names.add(i) }.wrapping_add(1);
        if let Some(texture) = state().textures.iter().find(|t| name > 1 && t.name.get() == name) {
            texture.give_back();
            texture.source.set(ptr::null());
            texture.name.set(0);
        }
    }
}

/// Sets the texels of the bound texture.
///
/// # Safety
/// As for OpenGL's function: `pixels` is null or points to the pixels.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn glTexImage2D(
    target: c_uint,
    level: c_int,
    _internal: c_int,
    width: c_int,
    height: c_int,
    _border: c_int,
    format: c_uint,
    component: c_uint,
    pixels: *const c_void,
) {
    let (Ok(columns), Ok(rows)) = (usize::try_from(width), usize::try_from(height)) else { return };
    if level != 0 || target == PROXY_TEXTURE_2D || columns > SIDE || rows > SIDE {
        return;
    }
    let Some(texture) = bound() else { return super::ignored::tell(b"more than 64 textures") };
    texture.source.set(ptr::null());
    texture.size.set((columns, rows));
    if pixels.is_null() {
        texture.resize(columns, rows);
    } else {
        // SAFETY: the caller's promise.
        unsafe { upload(texture, (0, 0), (columns, rows), (format, component), pixels) };
    }
}

/// Sets a part of the texels of the bound texture.
///
/// # Safety
/// As for OpenGL's function: `pixels` points to the pixels.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn glTexSubImage2D(
    _target: c_uint,
    level: c_int,
    x: c_int,
    y: c_int,
    width: c_int,
    height: c_int,
    format: c_uint,
    component: c_uint,
    pixels: *const c_void,
) {
    let number = |n: c_int| usize::try_from(n).unwrap_or(usize::MAX);
    let Some(texture) = bound() else { return };
    let (whole, at, size) = (texture.size.get(), (number(x), number(y)), (number(width), number(height)));
    let is_inside = at.0.saturating_add(size.0) <= whole.0 && at.1.saturating_add(size.1) <= whole.1;
    if level == 0 && is_inside && !pixels.is_null() {
        // SAFETY: the caller's promise.
        unsafe { upload(texture, at, size, (format, component), pixels) };
    }
}

/// Builds the texels of the bound texture; the smaller levels are never used.
///
/// # Safety
/// As for GLU's function.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn gluBuild2DMipmaps(
    target: c_uint,
    internal: c_int,
    width: c_int,
    height: c_int,
    format: c_uint,
    component: c_uint,
    pixels: *const c_void,
) -> c_int {
    // SAFETY: the caller's promise.
    unsafe { glTexImage2D(target, 0, internal, width, height, 0, format, component, pixels) };
    0
}

/// Takes over pixels: an allocation that may be shown as it is stays where it is.
///
/// # Safety
/// `pixels` points to the pixels, and the part is inside the texture.
unsafe fn upload(
    texture: &Texture,
    at: (usize, usize),
    size: (usize, usize),
    (format, component): (c_uint, c_uint),
    pixels: *const c_void,
) {
    let Some(kind) = Kind::of(format, component) else {
        return super::ignored::tell(b"a texture of this format");
    };
    let image = Image::unpacked(pixels, size.0, size.1, kind);
    let start = image.start as usize;
    let is_own = start.is_multiple_of(PAGE) && region_of(start).is_some_and(|(at, _)| at == start);
    if is_own && at == (0, 0) && size == texture.size.get() && image.is_whole() && !state().is_composed.get()
    {
        texture.source.set(image.start);
        texture.kind.set(kind);
        return;
    }
    texture.keep_copy();
    let (width, height) = texture.size.get();
    if texture.resize(width, height) {
        // SAFETY: the caller's promise.
        unsafe { texture.fill(&image, at) };
    }
}

const _: () = assert!(TEXTURES == 64, "the message names the number");
