//! Stores outside of the video memory: the pages before and behind an allocation that is the
//! device's memory can only be read. A store there is counted, let through by one step of the
//! processor, and the page is closed again; the program goes on as it would elsewhere.
//!
//! Out: words of the control page, from which `fbptr` tells the user. On machines other than x86-64
//! a program cannot step itself: there the first store opens the pages for good. Runs in handlers
//! of SIGSEGV and SIGTRAP: it takes no lock and allocates nothing.

use super::allocations::{BEFORE, PAGE, PROT_READ, behind, mprotect};
use crate::abi;
use crate::device::device;
use crate::layout as at;
use core::ffi::{c_int, c_void};
use core::ptr;
use core::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

/// Stores that are counted one by one, before the pages are opened for good.
const STEPS: usize = if cfg!(target_arch = "x86_64") { 1 << 16 } else { 1 };
const SIGTRAP: c_int = 5;
const SIGSEGV: c_int = 11;
const SA_SIGINFO: c_int = 4;
const SA_NODEFER: c_int = 0x4000_0000;

/// `struct sigaction`.
#[repr(C)]
struct Action {
    handler: usize,
    mask: [u64; 16],
    flags: c_int,
    restorer: usize,
}

unsafe extern "C" {
    fn sigaction(signal: c_int, new: *const Action, old: *mut Action) -> c_int;
}

/// Start of the video memory, its bytes, and those of the allocation; 0 while nothing is watched.
static START: AtomicUsize = AtomicUsize::new(0);
static LEN: AtomicUsize = AtomicUsize::new(0);
static REGION_LEN: AtomicUsize = AtomicUsize::new(0);
/// Page that is open for one step; 0 if none is.
static OPEN: AtomicUsize = AtomicUsize::new(0);
static STEPPED: AtomicUsize = AtomicUsize::new(0);
static IS_INSTALLED: AtomicBool = AtomicBool::new(false);
/// What handled SIGSEGV before: handler and flags.
static OTHERS: [AtomicUsize; 2] = [const { AtomicUsize::new(0) }; 2];

/// Ranges that are watched: before and behind the video memory, in whole pages.
fn ranges() -> [(usize, usize); 2] {
    let (start, len) = (START.load(Ordering::Relaxed), LEN.load(Ordering::Relaxed));
    let region = REGION_LEN.load(Ordering::Relaxed);
    if start == 0 {
        return [(0, 0); 2];
    }
    let end = start + region.next_multiple_of(PAGE) + behind(region);
    [(start - BEFORE, start), (start + len.next_multiple_of(PAGE), end)]
}

fn allow(from: usize, to: usize, access: c_int) {
    if to > from {
        // SAFETY: pages of a region, which is ours.
        unsafe { mprotect(from as *mut c_void, to - from, access) };
    }
}

/// Begins to watch the pages around the first `len` bytes of an allocation of `region` bytes.
pub fn begin(start: usize, len: usize, region: usize) {
    end();
    LEN.store(len, Ordering::Relaxed);
    REGION_LEN.store(region, Ordering::Relaxed);
    START.store(start, Ordering::Release);
    if STEPPED.load(Ordering::Relaxed) >= STEPS {
        return;
    }
    install();
    for (from, to) in ranges() {
        allow(from, to, PROT_READ);
    }
}

/// Watches nothing any longer: the pages are as any others.
pub fn end() {
    for (from, to) in ranges() {
        allow(from, to, abi::PROT_READ_WRITE);
    }
    START.store(0, Ordering::Release);
}

fn install() {
    if IS_INSTALLED.swap(true, Ordering::Relaxed) {
        return;
    }
    let ours =
        |handler: usize| Action { handler, mask: [0; 16], flags: SA_SIGINFO | SA_NODEFER, restorer: 0 };
    let mut old = Action { handler: 0, mask: [0; 16], flags: 0, restorer: 0 };
    // SAFETY: the structures are those of the C library, and the handlers have its type.
    unsafe {
        sigaction(SIGSEGV, &ours(on_fault as *const () as usize), &mut old);
        sigaction(SIGTRAP, &ours(on_step as *const () as usize), ptr::null_mut());
    }
    OTHERS[0].store(old.handler, Ordering::Relaxed);
    OTHERS[1].store(old.flags as usize, Ordering::Relaxed);
}

/// Gives a signal back to whoever handled it before: the instruction that caused it runs again.
fn give_back(signal: c_int) {
    let [handler, flags] = core::array::from_fn(|i| OTHERS[i].load(Ordering::Relaxed));
    let others = if signal == SIGSEGV { (handler, flags as c_int) } else { (0, 0) };
    let old = Action { handler: others.0, mask: [0; 16], flags: others.1, restorer: 0 };
    // SAFETY: the structure is the C library's.
    unsafe { sigaction(signal, &old, ptr::null_mut()) };
}

/// A memory access that is not allowed.
///
/// # Safety
/// The arguments are those of a signal's handler.
unsafe extern "C" fn on_fault(signal: c_int, info: *const c_void, context: *mut c_void) {
    // SAFETY: `si_addr` lies 16 bytes into the information about a memory fault.
    let address = unsafe { *info.cast::<usize>().add(2) };
    let watched = ranges();
    let is_ours = watched.iter().any(|(from, to)| (*from..*to).contains(&address));
    if !is_ours || STEPPED.load(Ordering::Relaxed) > STEPS {
        give_back(signal);
        return;
    }
    // SAFETY: the context is that of the handler.
    let bytes = unsafe { step::bytes_of_store(context) };
    note(address, bytes);
    if STEPPED.fetch_add(1, Ordering::Relaxed) + 1 >= STEPS {
        for (from, to) in watched {
            allow(from, to, abi::PROT_READ_WRITE);
        }
        return;
    }
    let page = address & !(PAGE - 1);
    OPEN.store(page, Ordering::Relaxed);
    open(page, abi::PROT_READ_WRITE);
    // SAFETY: as above.
    unsafe { step::set(context, true) };
}

/// Opens or closes a page and, for stores across its end, the next one.
fn open(page: usize, access: c_int) {
    for (from, to) in ranges() {
        allow(page.max(from), (page + 2 * PAGE).min(to), access);
    }
}

/// The step after a store that was let through.
///
/// # Safety
/// The arguments are those of a signal's handler.
unsafe extern "C" fn on_step(signal: c_int, _: *const c_void, context: *mut c_void) {
    let page = OPEN.swap(0, Ordering::Relaxed);
    if page == 0 {
        give_back(signal);
        return;
    }
    open(page, PROT_READ);
    // SAFETY: the context is that of the handler.
    unsafe { step::set(context, false) };
}

/// Counts a store for the user.
fn note(address: usize, bytes: usize) {
    let Some(device) = device() else { return };
    let index = address.wrapping_sub(START.load(Ordering::Relaxed)) as u64;
    let before = device.long(at::OUTSIDE_AT).fetch_add(bytes as u64, Ordering::AcqRel);
    if before == 0 {
        device.long(at::OUTSIDE_FIRST_AT).store(index, Ordering::Release);
    }
    if STEPPED.load(Ordering::Relaxed) + 1 >= STEPS {
        device.word(at::OUTSIDE_IS_LEAST_AT).store(1, Ordering::Release);
    }
}

#[cfg(not(target_arch = "x86_64"))]
mod step {
    use core::ffi::c_void;

    pub unsafe fn bytes_of_store(_: *mut c_void) -> usize {
        1
    }

    pub unsafe fn set(_: *mut c_void, _: bool) {}
}

#[cfg(target_arch = "x86_64")]
mod step {
    use super::PAGE;
    use core::ffi::c_void;

    /// Places of the instruction pointer and the flags in the context, in words.
    const RIP: usize = 5 + 16;
    const FLAGS: usize = 5 + 17;
    /// The flag by which the processor stops after one instruction.
    const TRAP: u64 = 0x100;

    /// Sets or clears the flag of single steps.
    ///
    /// # Safety
    /// `context` is that of a signal's handler.
    pub unsafe fn set(context: *mut c_void, is_on: bool) {
        // SAFETY: the caller's promise.
        let flags = unsafe { &mut *context.cast::<u64>().add(FLAGS) };
        *flags = if is_on { *flags | TRAP } else { *flags & !TRAP };
    }

    /// Returns the bytes that the instruction at the instruction pointer stores.
    ///
    /// # Safety
    /// `context` is that of a handler of a memory fault.
    pub unsafe fn bytes_of_store(context: *mut c_void) -> usize {
        // SAFETY: the caller's promise. What lies on the instruction's own page can be read; an
        // instruction across the end of a page is read up to it.
        unsafe {
            let at = *context.cast::<u64>().add(RIP) as usize;
            let len = (PAGE - at % PAGE).min(15);
            super::super::stores::size_of_store(core::slice::from_raw_parts(at as *const u8, len))
        }
    }
}
