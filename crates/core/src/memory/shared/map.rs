//! Memory map of a shared file. Other processes change it at any time, so every access is an atomic
//! load or store through a raw pointer, never a reference to plain bytes. This is the only file
//! of the crate outside `simd/` with unsafe code.
//!
//! Another program can also truncate the file at any time. The system then sends SIGBUS to a thread
//! that touches a missing page. The handler here replaces the map by zeroed anonymous memory and
//! records it, so that the access completes and [`Map::is_truncated`] returns true: no process is
//! ended. A SIGBUS of any other cause goes to the previous handler. Systems without such signals do
//! not truncate a mapped file.
#![allow(unsafe_code)]

use memmap2::{MmapOptions, MmapRaw};
use std::fs::File;
use std::io;
use std::sync::atomic::{AtomicU8, AtomicU32, AtomicU64};

/// Bytes that other processes read and write.
#[derive(Debug)]
pub(in crate::memory) struct Map {
    raw: MmapRaw,
    #[cfg(unix)]
    slot: &'static guard::Slot,
}

impl Map {
    /// Maps the first `bytes` bytes of `file`, which must be at least that long.
    ///
    /// # Errors
    /// If the system refuses, or if no guard slot is free.
    pub fn new(file: &File, bytes: usize) -> io::Result<Self> {
        let raw = MmapOptions::new().len(bytes).map_raw(file)?;
        Ok(Map {
            #[cfg(unix)]
            slot: guard::claim(raw.as_ptr() as usize, raw.len())?,
            raw,
        })
    }

    /// Returns whether an access found the file truncated. Reads since then return zeros, and
    /// writes are lost.
    pub fn is_truncated(&self) -> bool {
        #[cfg(unix)]
        return self.slot.is_truncated();
        #[cfg(not(unix))]
        false
    }

    /// Returns the four bytes at `at`.
    ///
    /// # Panics
    /// If `at` is not a multiple of 4 inside the map.
    pub fn word_at(&self, at: usize) -> &AtomicU32 {
        assert!(at.is_multiple_of(4) && at + 4 <= self.raw.len());
        // SAFETY: the map is page aligned and `at` is a multiple of 4 inside it; it lives as long
        // as `self`, and this process touches it through atomics only. If the file is truncated,
        // `guard` keeps its addresses valid.
        unsafe { AtomicU32::from_ptr(self.raw.as_mut_ptr().add(at).cast()) }
    }

    /// Returns the byte at `at`.
    ///
    /// # Panics
    /// If `at` is outside the map.
    pub fn byte_at(&self, at: usize) -> &AtomicU8 {
        assert!(at < self.raw.len());
        // SAFETY: as in `word_at`, with 1 in place of 4.
        unsafe { AtomicU8::from_ptr(self.raw.as_mut_ptr().add(at)) }
    }

    /// Returns `count` times eight bytes from `at` on.
    ///
    /// # Panics
    /// If `at` is not a multiple of 8, or the bytes are not all inside the map.
    #[cfg(target_os = "linux")]
    pub fn longs(&self, at: usize, count: usize) -> &[AtomicU64] {
        assert!(at.is_multiple_of(8) && at <= self.raw.len() && count <= (self.raw.len() - at) / 8);
        // SAFETY: as in `word_at`, for each of the words; a slice of atomics allows that others
        // write to it.
        unsafe { std::slice::from_raw_parts(self.raw.as_mut_ptr().add(at).cast(), count) }
    }

    /// Returns the eight bytes at `at`.
    ///
    /// # Panics
    /// If `at` is not a multiple of 8 inside the map.
    pub fn long(&self, at: usize) -> &AtomicU64 {
        assert!(at.is_multiple_of(8) && at + 8 <= self.raw.len());
        // SAFETY: as in `word_at`, with 8 in place of 4. Words of all sizes are used by one thread
        // only.
        unsafe { AtomicU64::from_ptr(self.raw.as_mut_ptr().add(at).cast()) }
    }
}

#[cfg(unix)]
impl Drop for Map {
    fn drop(&mut self) {
        // Must precede the unmapping by `raw`.
        self.slot.release();
    }
}

/// Handler of SIGBUS, and the address ranges that it guards.
#[cfg(unix)]
mod guard {
    use libc::{c_int, c_void, sigaction, siginfo_t};
    use std::io;
    use std::sync::OnceLock;
    use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

    /// Largest number of maps at one time.
    const SLOTS: usize = 64;

    /// Address range of a map; empty while the slot is free.
    #[derive(Debug)]
    pub struct Slot {
        /// First address; zero while the slot is free.
        start: AtomicUsize,
        end: AtomicUsize,
        is_truncated: AtomicBool,
    }

    static MAPPED: [Slot; SLOTS] = [const {
        Slot { start: AtomicUsize::new(0), end: AtomicUsize::new(0), is_truncated: AtomicBool::new(false) }
    }; SLOTS];

    /// Action before this handler was installed, or the system's error number.
    static PREVIOUS: OnceLock<Result<sigaction, i32>> = OnceLock::new();

    /// Guards a mapped range until the slot is released.
    pub fn claim(start: usize, bytes: usize) -> io::Result<&'static Slot> {
        install()?;
        let is_free =
            |slot: &&Slot| slot.start.compare_exchange(0, start, Ordering::AcqRel, Ordering::Relaxed).is_ok();
        let slot = MAPPED
            .iter()
            .find(is_free)
            .ok_or_else(|| io::Error::other(format!("{SLOTS} shared files are mapped already")))?;
        slot.is_truncated.store(false, Ordering::Release);
        // The handler sees the range only after this store.
        slot.end.store(start + bytes, Ordering::Release);
        Ok(slot)
    }

    impl Slot {
        pub fn is_truncated(&self) -> bool {
            self.is_truncated.load(Ordering::Acquire)
        }

        pub fn release(&self) {
            self.end.store(0, Ordering::Release);
            self.start.store(0, Ordering::Release);
        }
    }

    /// Installs the handler, once for the process.
    fn install() -> io::Result<()> {
        let mut is_first = false;
        let previous = PREVIOUS.get_or_init(|| {
            is_first = true;
            // SAFETY: an all-zero `sigaction` is a valid value, and the call only writes to it.
            let mut old: sigaction = unsafe { std::mem::zeroed() };
            // SAFETY: a null action changes nothing; `old` is a local variable.
            match unsafe { libc::sigaction(libc::SIGBUS, std::ptr::null(), &mut old) } {
                0 => Ok(old),
                _ => Err(last_error()),
            }
        });
        if let Err(number) = previous {
            return Err(io::Error::from_raw_os_error(*number));
        }
        if is_first {
            // SAFETY: an all-zero `sigaction` has an empty mask and no flags.
            let mut new: sigaction = unsafe { std::mem::zeroed() };
            new.sa_sigaction = on_bus_error as *const () as usize;
            new.sa_flags = libc::SA_SIGINFO | libc::SA_ONSTACK;
            // SAFETY: `new` names a function of the type that SA_SIGINFO asks for, which calls
            // nothing but atomics, mmap, sigaction and the previous handler: all of them may be
            // called in a signal's handler.
            if unsafe { libc::sigaction(libc::SIGBUS, &new, std::ptr::null_mut()) } != 0 {
                return Err(io::Error::last_os_error());
            }
        }
        Ok(())
    }

    fn last_error() -> i32 {
        io::Error::last_os_error().raw_os_error().unwrap_or(libc::EINVAL)
    }

    extern "C" fn on_bus_error(signal: c_int, info: *mut siginfo_t, context: *mut c_void) {
        // SAFETY: with SA_SIGINFO the system gives a valid `siginfo_t`; SIGBUS from the kernel has
        // an address.
        let (code, at) = unsafe { ((*info).si_code, (*info).si_addr() as usize) };
        // Codes above zero are the kernel's own.
        if code > 0 && MAPPED.iter().any(|slot| replace(slot, at)) {
            return;
        }
        call_previous(signal, info, context);
    }

    /// Replaces the slot's map by anonymous memory if `at` lies in it, and returns whether it did.
    /// The system then repeats the access.
    fn replace(slot: &Slot, at: usize) -> bool {
        let (start, end) = (slot.start.load(Ordering::Acquire), slot.end.load(Ordering::Acquire));
        if !(start..end).contains(&at) {
            return false;
        }
        slot.is_truncated.store(true, Ordering::Release);
        let (access, flags) =
            (libc::PROT_READ | libc::PROT_WRITE, libc::MAP_PRIVATE | libc::MAP_ANONYMOUS | libc::MAP_FIXED);
        // SAFETY: the range is that of a map that lives (`Map` releases its slot before it unmaps),
        // and that nothing but `Map` refers to: to replace it leaves every reference into it valid.
        let placed = unsafe { libc::mmap(start as *mut c_void, end - start, access, flags, -1, 0) };
        placed != libc::MAP_FAILED
    }

    /// Passes the signal on to the previous action.
    fn call_previous(signal: c_int, info: *mut siginfo_t, context: *mut c_void) {
        let old = match PREVIOUS.get() {
            Some(Ok(old)) if old.sa_sigaction != libc::SIG_DFL && old.sa_sigaction != libc::SIG_IGN => old,
            _ => {
                // SAFETY: an all-zero action is the default one: the access is repeated and ends
                // the process.
                unsafe {
                    let default: sigaction = std::mem::zeroed();
                    libc::sigaction(signal, &default, std::ptr::null_mut());
                }
                return;
            }
        };
        if old.sa_flags & libc::SA_SIGINFO != 0 {
            // SAFETY: with SA_SIGINFO the system holds a function of this type there.
            let handler: extern "C" fn(c_int, *mut siginfo_t, *mut c_void) =
                unsafe { std::mem::transmute(old.sa_sigaction) };
            handler(signal, info, context);
        } else {
            // SAFETY: without SA_SIGINFO it holds one of this type.
            let handler: extern "C" fn(c_int) = unsafe { std::mem::transmute(old.sa_sigaction) };
            handler(signal);
        }
    }
}
