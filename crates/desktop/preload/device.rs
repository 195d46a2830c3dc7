//! The device as a process sees it: where the program `fbptr` keeps it, and the mapped control
//! page.

use crate::abi::{self, Stat, fail, next, set_errno};
use crate::elf::Unserved;
use crate::layout as at;
use crate::mode::{DeviceLimits, Var};
use crate::text::{Text, numbers};
use core::ffi::{CStr, c_char, c_int, c_long, c_void};
use core::ptr;
use core::sync::atomic::{AtomicPtr, AtomicU32, AtomicU64, Ordering};

/// Place of the device: `FBPTR_RUN` is `PID/CONTROL/MEMORY/DEVICE/INODE`, where CONTROL and MEMORY
/// are descriptors of that process, and DEVICE and INODE identify the memory's file.
#[derive(Clone, Copy)]
pub struct Device {
    pub pid: u64,
    control_fd: u64,
    memory_fd: u64,
    memory_device: u64,
    memory_inode: u64,
    /// The control page, which stays mapped.
    page: *const u8,
}

/// The control page of this process; null before it is mapped.
static PAGE: AtomicPtr<u8> = AtomicPtr::new(ptr::null_mut());

/// The numbers of `FBPTR_RUN`, once the page is mapped: the program may clear its environment.
static FACTS: [AtomicU64; 5] = [const { AtomicU64::new(0) }; 5];

/// The descriptor of the program `fbptr` that is this library, plus 1; 0 if it is not known.
static LIBRARY: AtomicU64 = AtomicU64::new(0);

/// Attaches to the device when the library is loaded.
pub extern "C" fn attach() {
    if let Some(device) = device() {
        device.word(at::LOADS_AT).fetch_add(1, Ordering::Relaxed);
        device.note_library();
    }
}

/// Returns the device, or `None` in a program that `fbptr` has not started, or that it has left.
pub fn device() -> Option<Device> {
    let page = PAGE.load(Ordering::Acquire);
    if !page.is_null() {
        let [pid, control_fd, memory_fd, memory_device, memory_inode] =
            core::array::from_fn(|i| FACTS[i].load(Ordering::Relaxed));
        return Some(Device { pid, control_fd, memory_fd, memory_device, memory_inode, page });
    }
    // SAFETY: the name ends with a zero byte.
    let value = unsafe { abi::getenv(c"FBPTR_RUN".as_ptr()) };
    if value.is_null() {
        return None;
    }
    // SAFETY: an environment variable is a C string, which nobody changes in a sound program.
    let text = unsafe { CStr::from_ptr(value) }.to_bytes();
    let facts @ [pid, control_fd, memory_fd, memory_device, memory_inode] = numbers(text)?;
    // The same values in every thread that comes here.
    for (place, value) in FACTS.iter().zip(facts) {
        place.store(value, Ordering::Relaxed);
    }
    let mut found = Device { pid, control_fd, memory_fd, memory_device, memory_inode, page };
    found.page = map(&found)?;
    Some(found)
}

/// Maps the control page. Of two threads that do it at once, one keeps its own.
fn map(device: &Device) -> Option<*const u8> {
    let saved = abi::errno();
    let fd = device.open_control();
    if fd < 0 {
        set_errno(saved);
        return None;
    }
    let Some(map) = next!("mmap", as Mmap) else { return None };
    // SAFETY: a new map of a file that is open, at an address that the system chooses.
    let page =
        unsafe { map(ptr::null_mut(), at::CONTROL_BYTES, abi::PROT_READ_WRITE, abi::MAP_SHARED, fd, 0) };
    // SAFETY: the descriptor is ours.
    unsafe { abi::close(fd) };
    set_errno(saved);
    if page as usize == usize::MAX {
        return None;
    }
    let page: *mut u8 = page.cast();
    // SAFETY: the map is larger than a word, aligned to a page, and never unmapped.
    let magic = unsafe { AtomicU32::from_ptr(page.cast()) }.load(Ordering::Acquire);
    if magic != at::MAGIC {
        return None;
    }
    match PAGE.compare_exchange(ptr::null_mut(), page, Ordering::AcqRel, Ordering::Acquire) {
        Ok(_) => Some(page),
        // The other thread's page is of the same file; this one stays mapped, once a process.
        Err(theirs) => Some(theirs),
    }
}

type Mmap = unsafe extern "C" fn(*mut c_void, usize, c_int, c_int, c_int, i64) -> *mut c_void;
type Open = unsafe extern "C" fn(*const c_char, c_int, c_int) -> c_int;
type Syscall = unsafe extern "C" fn(c_long, ...) -> c_long;

impl Device {
    /// Returns the word at `offset` of the control page.
    pub fn word(&self, offset: usize) -> &'static AtomicU32 {
        debug_assert!(offset + 4 <= at::CONTROL_BYTES);
        // SAFETY: the page is mapped as long as the process lives, `offset` is one of the layout's,
        // inside it and aligned, and all its users access it atomically.
        unsafe { AtomicU32::from_ptr(self.page.cast_mut().add(offset).cast()) }
    }

    /// Returns the 64-bit word at `offset` of the control page.
    pub fn long(&self, offset: usize) -> &'static AtomicU64 {
        debug_assert!(offset + 8 <= at::CONTROL_BYTES);
        // SAFETY: as in `word`, with offsets that are multiples of 8.
        unsafe { AtomicU64::from_ptr(self.page.cast_mut().add(offset).cast()) }
    }

    /// Notes which descriptor the library was loaded from, before a program changes its
    /// environment.
    fn note_library(&self) {
        // SAFETY: the name ends with a zero byte.
        let value = unsafe { abi::getenv(c"LD_PRELOAD".as_ptr()) };
        if value.is_null() {
            return;
        }
        // SAFETY: an environment variable is a C string, which nobody changes yet.
        let text = unsafe { CStr::from_ptr(value) }.to_bytes();
        let folder = self.descriptors();
        let number = |part: &[u8]| numbers::<1>(part.strip_prefix(folder.as_bytes())?);
        if let Some([number]) = text.split(|b| matches!(b, b':' | b' ')).find_map(number) {
            LIBRARY.store(number.wrapping_add(1), Ordering::Relaxed);
        }
    }

    /// Returns the folder of the descriptors of the program `fbptr`.
    fn descriptors(&self) -> Text<64> {
        let mut path = Text::new();
        path.push(b"/proc/").number(self.pid).push(b"/fd/");
        path
    }

    /// Returns the path that the library was loaded from.
    pub fn library_path(&self) -> Option<Text<64>> {
        let number = LIBRARY.load(Ordering::Relaxed).checked_sub(1)?;
        let mut path = self.descriptors();
        path.number(number);
        Some(path)
    }

    /// Returns the environment variable by which a program finds the device, name and value.
    pub fn variable(&self) -> Text<192> {
        let mut text = Text::new();
        text.push(at::ENVIRONMENT.as_bytes()).push(b"=").push(self.value().as_bytes());
        text
    }

    /// Returns the value of that variable.
    pub fn value(&self) -> Text<128> {
        let mut text = Text::new();
        text.number(self.pid).push(b"/").number(self.control_fd).push(b"/").number(self.memory_fd);
        text.push(b"/").number(self.memory_device).push(b"/").number(self.memory_inode);
        text
    }

    /// Opens a descriptor of the program `fbptr`.
    pub fn open_number(&self, number: u64, flags: c_int) -> c_int {
        let mut path = self.descriptors();
        path.number(number);
        let Some(open) = next!("open", as Open) else { return fail(abi::ENOSYS) };
        // SAFETY: the path is a C string.
        let fd = unsafe { open(path.as_ptr(), flags, 0) };
        match fd {
            // The program `fbptr` has ended.
            -1 if abi::errno() == abi::ENOENT => fail(abi::ENODEV),
            fd => fd,
        }
    }

    fn open_control(&self) -> c_int {
        self.open_number(self.control_fd, abi::O_RDWR | abi::O_CLOEXEC)
    }

    /// Opens the device's memory.
    pub fn open_memory(&self, flags: c_int) -> c_int {
        let fd =
            self.open_number(self.memory_fd, flags & (abi::O_ACCMODE | abi::O_NONBLOCK | abi::O_CLOEXEC));
        if fd >= 0 {
            self.word(at::OPENS_AT).fetch_add(1, Ordering::Release);
        }
        fd
    }

    /// Returns the inode of the device's memory, which no other device has.
    pub fn inode(&self) -> u64 {
        self.memory_inode
    }

    /// Returns whether this is the file of the device's memory.
    pub fn is_memory(&self, device: u64, inode: u64) -> bool {
        (device, inode) == (self.memory_device, self.memory_inode)
    }

    /// Returns whether the descriptor is the device's memory.
    pub fn is_memory_fd(&self, fd: c_int) -> bool {
        status(fd).is_some_and(|status| self.is_memory(status.dev, status.ino))
    }

    /// Runs `action` while no other process runs one.
    pub fn exclusively<T>(&self, action: impl FnOnce() -> T) -> T {
        let fd = self.open_control();
        if fd >= 0 {
            // SAFETY: the descriptor is ours. A lock that cannot be had is done without; a signal
            // is no reason for that.
            while unsafe { abi::flock(fd, abi::LOCK_EX) } != 0 && abi::errno() == abi::EINTR {}
        }
        let result = action();
        if fd >= 0 {
            // SAFETY: the descriptor is ours; closing it releases the lock.
            unsafe { abi::close(fd) };
        }
        result
    }

    /// Returns the device's constants.
    pub fn limits(&self) -> DeviceLimits {
        let word = |offset| self.word(offset).load(Ordering::Relaxed);
        DeviceLimits {
            width: word(at::WIDTH_AT),
            height: word(at::HEIGHT_AT),
            smem_len: word(at::SMEM_LEN_AT),
            hz: word(at::HZ_AT),
            format: word(at::FORMAT_AT),
            least_line: word(at::LEAST_LINE_AT),
        }
    }

    /// Returns the mode, with the present offsets.
    pub fn mode(&self) -> Var {
        loop {
            let sets = self.word(at::MODE_SETS_AT).load(Ordering::Acquire);
            let words =
                core::array::from_fn(|i| self.word(at::mode_word_at(sets, i)).load(Ordering::Relaxed));
            core::sync::atomic::fence(Ordering::Acquire);
            // Others may have set a mode meanwhile, and the slot may be in use again.
            if self.word(at::MODE_SETS_AT).load(Ordering::Relaxed) == sets {
                let pan = self.long(at::PAN_AT).load(Ordering::Acquire);
                return Var { xoffset: pan as u32, yoffset: (pan >> 32) as u32, ..Var::from_words(words) };
            }
        }
    }

    /// Sets the mode. To be called by one process at a time.
    pub fn set_mode(&self, mode: &Var) {
        let sets = self.word(at::MODE_SETS_AT).load(Ordering::Acquire).wrapping_add(1);
        for (i, word) in mode.to_words().into_iter().enumerate() {
            self.word(at::mode_word_at(sets, i)).store(word, Ordering::Relaxed);
        }
        self.long(at::PAN_AT)
            .store(u64::from(mode.xoffset) | u64::from(mode.yoffset) << 32, Ordering::Release);
        self.word(at::MODE_SETS_AT).store(sets, Ordering::Release);
    }

    /// Moves the visible part, and waits until the scan-out has taken it over: from then on the
    /// rows that were visible before are free.
    pub fn pan(&self, xoffset: u32, yoffset: u32) {
        self.long(at::PAN_AT).store(u64::from(xoffset) | u64::from(yoffset) << 32, Ordering::Release);
        let mine = self.word(at::PANS_AT).fetch_add(1, Ordering::AcqRel).wrapping_add(1);
        self.wait_until(at::PANS_TAKEN_AT, |taken| taken.wrapping_sub(mine) as i32 >= 0);
    }

    /// Waits for the next vertical blank. Returns whether it came.
    pub fn wait_for_vsync(&self) -> bool {
        let seen = self.word(at::VSYNC_AT).load(Ordering::Acquire);
        self.wait_until(at::VSYNC_AT, |count| count != seen)
    }

    /// Waits until `is_over` holds for a word. Returns false if the device has ended before, or has
    /// not moved for [`PATIENCE`]. Signals wake the thread early, which does not shorten the wait.
    fn wait_until(&self, offset: usize, is_over: impl Fn(u32) -> bool) -> bool {
        let (word, deadline) = (self.word(offset), nanoseconds() + PATIENCE);
        loop {
            let seen = word.load(Ordering::Acquire);
            if is_over(seen) {
                return true;
            }
            let rest = deadline - nanoseconds();
            if rest <= 0 || !self.is_alive() {
                return false;
            }
            wait(word, seen, rest.min(LOOK));
        }
    }

    fn is_alive(&self) -> bool {
        self.word(at::ENDED_AT).load(Ordering::Acquire) == 0
    }

    /// Notes a program that was started and cannot have the device.
    pub fn tell(&self, why: Unserved, path: &[u8]) {
        let path = &path[..path.len().min(at::TEXT_BYTES - 8)];
        let number = self.word(at::TOLD_AT).fetch_add(1, Ordering::AcqRel) as usize;
        let start = at::TEXTS_AT + number % at::TEXTS * at::TEXT_BYTES;
        self.long(start).store(0, Ordering::Release);
        for (i, bytes) in path.chunks(8).enumerate() {
            let mut word = [0; 8];
            word[..bytes.len()].copy_from_slice(bytes);
            self.long(start + 8 + i * 8).store(u64::from_le_bytes(word), Ordering::Relaxed);
        }
        self.long(start).store((why as u64) << 32 | path.len() as u64, Ordering::Release);
    }

    /// Notes a refused request, for `--verbose`: `device` is an index of [`at::LOG_DEVICES`].
    pub fn log(&self, device: u32, request: u32) {
        let number = self.word(at::LOGGED_AT).fetch_add(1, Ordering::AcqRel) as usize;
        let entry = 1 << 63 | u64::from(device) << 32 | u64::from(request);
        self.long(at::LOG_AT + number % at::LOG_ENTRIES * 8).store(entry, Ordering::Release);
    }
}

/// Nanoseconds after which nobody waits for the scan-out any longer.
const PATIENCE: i64 = 2_000_000_000;
/// Nanoseconds after which a waiting thread looks whether the device has ended.
const LOOK: i64 = 100_000_000;

/// Returns the time of the monotonic clock in nanoseconds.
fn nanoseconds() -> i64 {
    let mut time = abi::Timespec { seconds: 0, nanoseconds: 0 };
    // SAFETY: the time is valid for writing; this clock is always there.
    unsafe { abi::clock_gettime(abi::CLOCK_MONOTONIC, &mut time) };
    time.seconds * 1_000_000_000 + time.nanoseconds
}

/// Waits while the word is `seen`, for so many nanoseconds at most, less than a second; a signal
/// ends the wait, too.
fn wait(word: &AtomicU32, seen: u32, nanoseconds: i64) {
    let timeout = abi::Timespec { seconds: 0, nanoseconds };
    let Some(syscall) = next!("syscall", as Syscall) else { return };
    let saved = abi::errno();
    // SAFETY: the word and the time are valid for the call; other wake-ups are harmless.
    unsafe {
        syscall(abi::SYS_FUTEX, word.as_ptr(), abi::FUTEX_WAIT, seen as c_long, &timeout, 0usize, 0usize)
    };
    set_errno(saved);
}

/// Returns the status of a descriptor as the system sees it.
pub fn status(fd: c_int) -> Option<Stat> {
    let saved = abi::errno();
    // SAFETY: an all-zero `Stat` is valid, and `next_fstat` writes to it only.
    let mut status: Stat = unsafe { core::mem::zeroed() };
    let result = crate::stat::next_fstat(fd, &mut status);
    set_errno(saved);
    (result == 0).then_some(status)
}
