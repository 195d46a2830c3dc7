//! Reading folders: `opendir`, `readdir` and their kin, with the device's names.
//!
//! A stream of a folder that lists the device is noted in a table of fixed size; one stream is read
//! by one thread at a time, as POSIX asks for.

use crate::abi::{self, errno, next, set_errno};
use crate::device::device;
use crate::folders::{self, FOLDERS, Folder};
use crate::paths::{Place, place};
use core::cell::UnsafeCell;
use core::ffi::{c_char, c_int, c_long, c_void};
use core::ptr;
use core::sync::atomic::{AtomicPtr, AtomicUsize, Ordering};

/// Streams of such folders that may be open at once; more list what the system has.
const STREAMS: usize = 32;

/// `struct dirent` of 64 bits.
#[repr(C)]
pub struct Entry {
    ino: u64,
    off: i64,
    reclen: u16,
    kind: u8,
    name: [u8; 256],
}

/// An open stream.
struct Stream {
    /// `DIR *`; null if the place in the table is free.
    dir: AtomicPtr<c_void>,
    folder: AtomicUsize,
    /// Entries of the device that were returned.
    at: AtomicUsize,
    entry: UnsafeCell<Entry>,
}

// SAFETY: the entry is written by the thread that reads the stream alone.
unsafe impl Sync for Stream {}

static TABLE: [Stream; STREAMS] = [const {
    Stream {
        dir: AtomicPtr::new(ptr::null_mut()),
        folder: AtomicUsize::new(0),
        at: AtomicUsize::new(0),
        entry: UnsafeCell::new(Entry { ino: 0, off: 0, reclen: 0, kind: 0, name: [0; 256] }),
    }
}; STREAMS];

/// Returns the stream's place in the table.
fn stream(dir: *mut c_void) -> Option<&'static Stream> {
    TABLE.iter().find(|stream| !dir.is_null() && stream.dir.load(Ordering::Acquire) == dir)
}

/// Notes a new stream if its folder lists the device.
fn note(dir: *mut c_void) -> *mut c_void {
    if dir.is_null() || device().is_none() {
        return dir;
    }
    let saved = errno();
    // SAFETY: the stream is open.
    let folder = folders::of_descriptor(unsafe { abi::dirfd(dir) });
    set_errno(saved);
    if let Some(folder) = folder {
        for stream in &TABLE {
            let free = ptr::null_mut();
            if stream.dir.compare_exchange(free, dir, Ordering::AcqRel, Ordering::Relaxed).is_ok() {
                stream.folder.store(folder, Ordering::Relaxed);
                stream.at.store(0, Ordering::Relaxed);
                break;
            }
        }
    }
    dir
}

type FdOpenDir = unsafe extern "C" fn(c_int) -> *mut c_void;
type ReadDir = unsafe extern "C" fn(*mut c_void) -> *mut Entry;

/// Opens a folder for reading.
///
/// # Safety
/// As for the C library's function.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn opendir(path: *const c_char) -> *mut c_void {
    // SAFETY: the caller passes a C string.
    if let Some((Place::Folder(index), device)) = unsafe { place(abi::AT_FDCWD, path, true) }.zip(device()) {
        let fd = folders::open(&device, index, abi::O_CLOEXEC);
        // SAFETY: the argument is a descriptor of ours, which the stream takes over.
        return if fd < 0 { ptr::null_mut() } else { unsafe { fdopendir(fd) } };
    }
    match next!("opendir", as unsafe extern "C" fn(*const c_char) -> *mut c_void) {
        // SAFETY: the argument is the caller's.
        Some(next) => note(unsafe { next(path) }),
        None => ptr::null_mut(),
    }
}

/// Opens the folder of a descriptor for reading.
///
/// # Safety
/// As for the C library's function.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fdopendir(fd: c_int) -> *mut c_void {
    match next!("fdopendir", as FdOpenDir) {
        // SAFETY: the argument is the caller's.
        Some(next) => note(unsafe { next(fd) }),
        None => ptr::null_mut(),
    }
}

impl Stream {
    fn folder(&self) -> &'static Folder {
        &FOLDERS[self.folder.load(Ordering::Relaxed) % FOLDERS.len()]
    }

    /// Returns the next entry: those of the system first, where it has the folder, without those
    /// that the device has.
    unsafe fn next(&self, dir: *mut c_void, next: ReadDir) -> *mut Entry {
        let folder = self.folder();
        while !folder.is_own() {
            // SAFETY: the stream is the caller's.
            let entry = unsafe { next(dir) };
            if entry.is_null() {
                break;
            }
            // SAFETY: the C library's entry ends its name with a zero byte.
            let name = unsafe { core::ffi::CStr::from_ptr((*entry).name.as_ptr().cast()) }.to_bytes();
            if !(0..).map_while(|at| folder.entry(at)).any(|(ours, _)| ours == name) {
                return entry;
            }
        }
        let at = self.at.load(Ordering::Relaxed);
        let Some((name, kind)) = folder.entry(at) else { return ptr::null_mut() };
        self.at.store(at + 1, Ordering::Relaxed);
        let entry = self.entry.get();
        // SAFETY: only the thread that reads the stream uses its entry; names are short.
        unsafe {
            (*entry).ino = 1 + at as u64;
            (*entry).off = at as i64 + 1;
            (*entry).reclen = size_of::<Entry>() as u16;
            (*entry).kind = kind;
            (*entry).name = [0; 256];
            (&mut (*entry).name)[..name.len()].copy_from_slice(name);
        }
        entry
    }
}

/// Defines `readdir` and its other name.
macro_rules! reads {
    ($($name:ident)*) => {$(
        /// Returns the next entry of a folder.
        ///
        /// # Safety
        /// As for the C library's function.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $name(dir: *mut c_void) -> *mut Entry {
            let Some(next) = next!(stringify!($name), as ReadDir) else { return ptr::null_mut() };
            match stream(dir) {
                // SAFETY: the stream is the caller's.
                Some(stream) => unsafe { stream.next(dir, next) },
                // SAFETY: the argument is the caller's.
                None => unsafe { next(dir) },
            }
        }
    )*};
}

reads! { readdir readdir64 }

/// Closes a stream.
///
/// # Safety
/// As for the C library's function.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn closedir(dir: *mut c_void) -> c_int {
    if let Some(stream) = stream(dir) {
        stream.dir.store(ptr::null_mut(), Ordering::Release);
    }
    match next!("closedir", as unsafe extern "C" fn(*mut c_void) -> c_int) {
        // SAFETY: the argument is the caller's.
        Some(next) => unsafe { next(dir) },
        None => abi::fail(abi::ENOSYS),
    }
}

/// Goes back to the first entry.
///
/// # Safety
/// As for the C library's function.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rewinddir(dir: *mut c_void) {
    if let Some(stream) = stream(dir) {
        stream.at.store(0, Ordering::Relaxed);
    }
    if let Some(next) = next!("rewinddir", as unsafe extern "C" fn(*mut c_void)) {
        // SAFETY: the argument is the caller's.
        unsafe { next(dir) }
    }
}

/// Returns the place in a stream.
///
/// # Safety
/// As for the C library's function.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn telldir(dir: *mut c_void) -> c_long {
    if let Some(stream) = stream(dir).filter(|stream| stream.folder().is_own()) {
        return stream.at.load(Ordering::Relaxed) as c_long;
    }
    match next!("telldir", as unsafe extern "C" fn(*mut c_void) -> c_long) {
        // SAFETY: the argument is the caller's.
        Some(next) => unsafe { next(dir) },
        None => abi::fail(abi::ENOSYS).into(),
    }
}

/// Goes to a place in a stream.
///
/// # Safety
/// As for the C library's function.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn seekdir(dir: *mut c_void, at: c_long) {
    if let Some(stream) = stream(dir).filter(|stream| stream.folder().is_own()) {
        return stream.at.store(at.max(0) as usize, Ordering::Relaxed);
    }
    if let Some(next) = next!("seekdir", as unsafe extern "C" fn(*mut c_void, c_long)) {
        // SAFETY: the arguments are the caller's.
        unsafe { next(dir, at) }
    }
}

type Choose = Option<unsafe extern "C" fn(*const Entry) -> c_int>;
type Compare = Option<unsafe extern "C" fn(*const c_void, *const c_void) -> c_int>;

/// Defines `scandir` and its other name, whose own way to the entries is inside the C library.
macro_rules! scans {
    ($($name:ident)*) => {$(
        /// Lists a folder: the chosen entries in order, in memory that the caller frees.
        ///
        /// # Safety
        /// As for the C library's function.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $name(
            path: *const c_char, list: *mut *mut *mut Entry, choose: Choose, compare: Compare,
        ) -> c_int {
            // SAFETY: the arguments are the caller's.
            unsafe { scan(path, list, choose, compare) }
        }
    )*};
}

scans! { scandir scandir64 }

unsafe fn scan(path: *const c_char, list: *mut *mut *mut Entry, choose: Choose, compare: Compare) -> c_int {
    // SAFETY: the caller passes a C string, and functions of these types; memory is the C
    // library's.
    unsafe {
        let dir = opendir(path);
        if dir.is_null() {
            return -1;
        }
        let (mut found, mut count) = (ptr::null_mut::<*mut Entry>(), 0usize);
        loop {
            let entry = readdir(dir);
            if entry.is_null() {
                break;
            }
            if choose.is_some_and(|choose| choose(entry) == 0) {
                continue;
            }
            let len = usize::from((*entry).reclen).min(size_of::<Entry>());
            let copy = abi::malloc(len);
            let grown: *mut *mut Entry = abi::realloc(found.cast(), (count + 1) * size_of::<usize>()).cast();
            if copy.is_null() || grown.is_null() {
                closedir(dir);
                return abi::fail(abi::ENOMEM);
            }
            ptr::copy_nonoverlapping(entry.cast::<u8>(), copy.cast(), len);
            found = grown;
            *found.add(count) = copy.cast();
            count += 1;
        }
        closedir(dir);
        if let Some(compare) = compare.filter(|_| count > 1) {
            abi::qsort(found.cast(), count, size_of::<usize>(), compare);
        }
        *list = found;
        count as c_int
    }
}
