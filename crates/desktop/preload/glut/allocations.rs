//! `malloc` and its kin: large allocations have pages of their own, so that the device's memory can
//! be mapped in the place of the one that the program shows.
//!
//! Until the window's size is known these are all of 64 kB and more; then those of three to five
//! bytes for each of its pixels. Around such an allocation lie pages that are watched while it is
//! the device's memory (`watch.rs`). Everything else is the C library's. Called by all threads, and
//! before `main`: no lock is taken, and nothing here allocates.

use super::{screen, textures, watch};
use crate::abi::{self, fail};
use crate::memory::mmap;
use core::ffi::{c_int, c_void};
use core::ptr;
use core::sync::atomic::{AtomicUsize, Ordering};

unsafe extern "C" {
    fn __libc_malloc(len: usize) -> *mut c_void;
    fn __libc_calloc(count: usize, len: usize) -> *mut c_void;
    fn __libc_realloc(memory: *mut c_void, len: usize) -> *mut c_void;
    fn __libc_free(memory: *mut c_void);
    pub fn munmap(memory: *mut c_void, len: usize) -> c_int;
    pub fn mprotect(memory: *mut c_void, len: usize, access: c_int) -> c_int;
}

/// Bytes of a page; larger pages of some machines are refused by `mmap`, which is the C library's
/// matter then.
pub const PAGE: usize = 4096;
/// Least bytes of an allocation with pages of its own, before the window's size is known.
const LEAST: usize = 64 << 10;
/// Most bytes of one.
const MOST: usize = 256 << 20;
/// Bytes before an allocation that are watched.
pub const BEFORE: usize = 1 << 20;
/// Bytes that an allocation may have more than five for each pixel.
const SLACK: usize = 4096;
/// Allocations with pages of their own at a time.
const REGIONS: usize = 256;

pub const PROT_READ: c_int = 1;
const MAP_PRIVATE: c_int = 2;
pub const MAP_FIXED: c_int = 0x10;
const MAP_ANONYMOUS: c_int = 0x20;
const MAP_NORESERVE: c_int = 0x4000;
/// Place of a region that is being made.
const CLAIMED: usize = 1;

/// An allocation with pages of its own; `start` is 0 if there is none.
struct Region {
    start: AtomicUsize,
    len: AtomicUsize,
}

static TABLE: [Region; REGIONS] =
    [const { Region { start: AtomicUsize::new(0), len: AtomicUsize::new(0) } }; REGIONS];

/// The thread that has called GLUT first, by the place of its errno; 0 before that.
static THREAD: AtomicUsize = AtomicUsize::new(0);
/// Pixels of the window; 0 before its size is known.
static PIXELS: AtomicUsize = AtomicUsize::new(0);

/// Returns the bytes behind an allocation of `len` bytes that are watched, after its last page.
pub fn behind(len: usize) -> usize {
    len.next_multiple_of(PAGE).max(1 << 20)
}

/// Maps private memory; null if the system refuses.
pub fn map(at: usize, len: usize, flags: c_int) -> *mut c_void {
    let flags = MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE | flags;
    // SAFETY: new memory, or memory over pages of a region, which is ours.
    let memory = unsafe { mmap(at as *mut c_void, len, abi::PROT_READ_WRITE, flags, -1, 0) };
    if memory as usize == usize::MAX { ptr::null_mut() } else { memory }
}

/// Returns the region that an address lies in: its start and its length.
pub fn region_of(address: usize) -> Option<(usize, usize)> {
    TABLE.iter().find_map(|region| {
        let start = region.start.load(Ordering::Acquire);
        let len = region.len.load(Ordering::Relaxed);
        (start > CLAIMED && (start..start + len.max(1)).contains(&address)).then_some((start, len))
    })
}

/// Returns whether the state of GLUT belongs to another thread than this one.
fn is_foreign() -> bool {
    let thread = THREAD.load(Ordering::Relaxed);
    // SAFETY: a call without arguments.
    thread != 0 && thread != unsafe { abi::__errno_location() } as usize
}

/// Notes the window's size, and the thread of GLUT. If nothing is shown yet, an allocation that fits it becomes the
/// device's memory.
pub fn note_window(width: u32, height: u32) {
    let pixels = width as usize * height as usize;
    // SAFETY: a call without arguments.
    THREAD.store(unsafe { abi::__errno_location() } as usize, Ordering::Relaxed);
    PIXELS.store(pixels, Ordering::Relaxed);
    if screen::attached().is_some() {
        return;
    }
    let found = |least: usize, most: usize| {
        TABLE.iter().find_map(|region| {
            let (start, len) = (region.start.load(Ordering::Acquire), region.len.load(Ordering::Relaxed));
            (start > CLAIMED && (least..=most).contains(&len)).then_some(start)
        })
    };
    if let Some(start) = found(pixels * 4, pixels * 5 + SLACK) {
        screen::guess(start, 4);
    } else if let Some(start) = found(pixels * 3, pixels * 3 + SLACK) {
        screen::guess(start, 3);
    }
}

/// Returns whether an allocation may be what the window shows.
fn may_be_shown(len: usize) -> bool {
    match PIXELS.load(Ordering::Relaxed) {
        0 => (LEAST..=MOST).contains(&len),
        pixels => {
            (pixels * 3..=(pixels * 5 + SLACK).min(MOST)).contains(&len) && len >= PAGE && !is_foreign()
        }
    }
}

/// Makes an allocation with pages of its own; null if there is no room for one.
fn allocate(len: usize) -> *mut c_void {
    let is_free = |region: &&Region| {
        region.start.compare_exchange(0, CLAIMED, Ordering::AcqRel, Ordering::Relaxed).is_ok()
    };
    let Some(region) = TABLE.iter().find(is_free) else { return ptr::null_mut() };
    let base = map(0, BEFORE + len.next_multiple_of(PAGE) + behind(len), 0);
    if base.is_null() {
        region.start.store(0, Ordering::Release);
        return base;
    }
    let start = base as usize + BEFORE;
    region.len.store(len, Ordering::Relaxed);
    region.start.store(start, Ordering::Release);
    let pixels = PIXELS.load(Ordering::Relaxed);
    if pixels != 0 && len >= pixels * 4 {
        screen::guess(start, 4);
    } else if pixels != 0 && screen::attached().is_none() {
        screen::guess(start, 3);
    }
    start as *mut c_void
}

/// Gives back an allocation, if it is one with pages of its own.
fn release(memory: *mut c_void) -> bool {
    let address = memory as usize;
    if !address.is_multiple_of(PAGE) || address <= CLAIMED {
        return false;
    }
    let Some(region) = TABLE.iter().find(|region| region.start.load(Ordering::Acquire) == address) else {
        return false;
    };
    // What another thread gives back may be what is shown: it stays.
    if is_foreign() {
        return true;
    }
    let len = region.len.load(Ordering::Relaxed);
    textures::keep_copies_of(address);
    screen::forget(address);
    // SAFETY: the pages are those that `allocate` has mapped, and the program has given them back.
    unsafe { munmap((address - BEFORE) as *mut c_void, BEFORE + len.next_multiple_of(PAGE) + behind(len)) };
    region.start.store(0, Ordering::Release);
    true
}

/// Allocates memory.
#[unsafe(no_mangle)]
pub extern "C" fn malloc(len: usize) -> *mut c_void {
    let memory = if may_be_shown(len) { allocate(len) } else { ptr::null_mut() };
    // SAFETY: a call without pointers.
    if memory.is_null() { unsafe { __libc_malloc(len) } } else { memory }
}

/// Allocates memory that is zero.
#[unsafe(no_mangle)]
pub extern "C" fn calloc(count: usize, len: usize) -> *mut c_void {
    let memory = match count.checked_mul(len) {
        Some(bytes) if may_be_shown(bytes) => allocate(bytes),
        _ => ptr::null_mut(),
    };
    // SAFETY: a call without pointers.
    if memory.is_null() { unsafe { __libc_calloc(count, len) } } else { memory }
}

/// Changes the size of an allocation.
///
/// # Safety
/// As for the C library's function.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn realloc(memory: *mut c_void, len: usize) -> *mut c_void {
    let address = memory as usize;
    let old = if address.is_multiple_of(PAGE) { region_of(address) } else { None };
    let Some((start, old_len)) = old.filter(|(start, _)| *start == address) else {
        // SAFETY: the memory is the C library's.
        return unsafe { __libc_realloc(memory, len) };
    };
    let new = malloc(len);
    if new.is_null() {
        fail(abi::ENOMEM);
        return new;
    }
    // SAFETY: both have so many bytes, and they are two.
    unsafe { ptr::copy_nonoverlapping(start as *const u8, new.cast::<u8>(), old_len.min(len)) };
    release(memory);
    new
}

/// Gives back an allocation.
///
/// # Safety
/// As for the C library's function.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn free(memory: *mut c_void) {
    if !release(memory) {
        // SAFETY: the memory is the C library's.
        unsafe { __libc_free(memory) };
    }
}

/// Returns the bytes of an allocation.
///
/// # Safety
/// As for the C library's function.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn malloc_usable_size(memory: *mut c_void) -> usize {
    if let Some((_, len)) = region_of(memory as usize).filter(|(start, _)| *start == memory as usize) {
        return len;
    }
    match abi::next!("malloc_usable_size", as unsafe extern "C" fn(*mut c_void) -> usize) {
        // SAFETY: the memory is the C library's.
        Some(next) => unsafe { next(memory) },
        None => 0,
    }
}

/// Maps the device's memory in the place of a region's first `len` bytes, and watches what lies
/// around it. What was there is in it then.
pub fn replace(start: usize, len: usize, fd: c_int) -> bool {
    let Some((_, region_len)) = region_of(start).filter(|(at, _)| *at == start) else { return false };
    let whole = len.next_multiple_of(PAGE);
    let mapped = |at: usize, flags: c_int| {
        // SAFETY: new memory, or memory over pages of the region, which is ours.
        let memory =
            unsafe { mmap(at as *mut c_void, whole, abi::PROT_READ_WRITE, abi::MAP_SHARED | flags, fd, 0) };
        (memory as usize != usize::MAX).then_some(memory)
    };
    let Some(other) = mapped(0, 0) else { return false };
    // SAFETY: the region and the map both have so many bytes, in whole pages.
    unsafe {
        ptr::copy_nonoverlapping(start as *const u8, other.cast::<u8>(), whole);
        munmap(other, whole);
    }
    if mapped(start, MAP_FIXED).is_none() {
        return false;
    }
    watch::begin(start, len, region_len);
    true
}

/// Gives a region that is the device's memory pages of its own again, with the same bytes.
pub fn restore(start: usize, len: usize) {
    watch::end();
    let whole = len.next_multiple_of(PAGE);
    let copy = map(0, whole, 0);
    if copy.is_null() {
        return;
    }
    // SAFETY: the region and the copy both have so many bytes.
    unsafe { ptr::copy_nonoverlapping(start as *const u8, copy.cast::<u8>(), whole) };
    if !map(start, whole, MAP_FIXED).is_null() {
        // SAFETY: as above.
        unsafe { ptr::copy_nonoverlapping(copy.cast::<u8>(), start as *mut u8, whole) };
    }
    // SAFETY: the copy is ours.
    unsafe { munmap(copy, whole) };
}
