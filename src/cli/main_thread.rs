//! The main thread, which shows the windows of a command that runs on a thread of its own.
//!
//! Some systems allow windows on the main thread alone, and Xlib ends the process by `exit` when
//! the X server dies under one, at whatever moment. `exit` runs the destructors of the main
//! thread's thread-local values first: one of them tells the command that its window is gone, and
//! waits for it to end in order, with its recording and its pictures, before the process does.

use super::Status;
use std::cell::RefCell;
use std::collections::VecDeque;
use std::process::ExitCode;
use std::sync::{Condvar, Mutex, MutexGuard, OnceLock, PoisonError};

/// Work for the main thread.
type Job = Box<dyn FnOnce() + Send>;

#[derive(Default)]
struct State {
    jobs: VecDeque<Job>,
    /// Set when a window's end has ended the main thread's own work.
    is_lost: bool,
    /// The command's status, once it has ended.
    status: Option<Status>,
}

/// Both threads' state. A condition variable works in the destructors of a thread, too.
#[derive(Default)]
struct MainThread {
    state: Mutex<State>,
    changed: Condvar,
}

static MAIN: OnceLock<MainThread> = OnceLock::new();

impl MainThread {
    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn wait<'a>(&self, state: MutexGuard<'a, State>) -> MutexGuard<'a, State> {
        self.changed.wait(state).unwrap_or_else(PoisonError::into_inner)
    }

    /// Does the command's jobs until it has ended.
    fn serve(&self) -> Status {
        let mut state = self.lock();
        loop {
            if let Some(status) = state.status {
                return status;
            }
            match state.jobs.pop_front() {
                Some(job) => {
                    drop(state);
                    job();
                    state = self.lock();
                }
                None => state = self.wait(state),
            }
        }
    }
}

/// Ends the command in order, if the process exits while the main thread shows its window.
struct AtExit;

impl Drop for AtExit {
    fn drop(&mut self) {
        let Some(main) = MAIN.get() else { return };
        let mut state = main.lock();
        state.is_lost = true;
        main.changed.notify_all();
        let status = loop {
            match state.status {
                Some(status) => break status,
                None => state = main.wait(state),
            }
        };
        drop(state);
        std::process::exit(status.code().into());
    }
}

thread_local! {
    static AT_EXIT: RefCell<Option<AtExit>> = const { RefCell::new(None) };
}

/// Tells the main thread the command's status, also that of a panic.
struct Ended(Option<Status>);

impl Drop for Ended {
    fn drop(&mut self) {
        if let Some(main) = MAIN.get() {
            // 101 is the status of a program that has panicked.
            main.lock().status = Some(self.0.unwrap_or(Status::Program(101)));
            main.changed.notify_all();
        }
    }
}

/// Bytes of the command's stack, those that a main thread usually has.
const STACK_BYTES: usize = 8 << 20;

/// Runs a command beside the main thread, which is the caller, and returns its status.
pub(super) fn beside(command: impl FnOnce() -> Status + Send + 'static) -> Status {
    let main = MAIN.get_or_init(MainThread::default);
    let run = move || {
        let mut ended = Ended(None);
        ended.0 = Some(command());
    };
    let thread = std::thread::Builder::new().name("command".into()).stack_size(STACK_BYTES).spawn(run);
    if let Err(e) = thread {
        super::say_as_program(format_args!("no thread for the command: {e}"));
        return Status::Failed;
    }
    AT_EXIT.with_borrow_mut(|guard| *guard = Some(AtExit));
    let status = main.serve();
    // An end in order is not to be waited for.
    AT_EXIT.with_borrow_mut(|guard| guard.take().map(std::mem::forget));
    status
}

/// Runs `job` on the main thread. Returns its result, or `None` if the window system has ended it.
/// Without a main thread that serves, it runs on the calling one.
#[cfg(feature = "window")]
pub(super) fn run<T: Send + 'static>(job: impl FnOnce() -> T + Send + 'static) -> Option<T> {
    use std::sync::Arc;
    let Some(main) = MAIN.get() else { return Some(job()) };
    let result = Arc::new(Mutex::new(None));
    let place = result.clone();
    let mut state = main.lock();
    state.jobs.push_back(Box::new(move || {
        let found = job();
        *place.lock().unwrap_or_else(PoisonError::into_inner) = Some(found);
        MAIN.get().iter().for_each(|main| {
            // The waiting thread is between its look and its wait, or waits: it holds the lock or
            // has given it back.
            drop(main.lock());
            main.changed.notify_all();
        });
    }));
    main.changed.notify_all();
    loop {
        if let Some(found) = result.lock().unwrap_or_else(PoisonError::into_inner).take() {
            return Some(found);
        }
        if state.is_lost {
            return None;
        }
        state = main.wait(state);
    }
}

/// Shows a window of a display until it is closed. A window system that ends counts as that.
#[cfg(feature = "window")]
pub(super) fn show(
    display: std::sync::Arc<crate::server::Display>,
    options: crate::window::Options,
) -> Result<(), crate::window::WindowError> {
    let shown = display.clone();
    run(move || crate::window::run(display, options)).unwrap_or_else(|| {
        shown.close();
        Ok(())
    })
}

impl Status {
    /// Returns the number of the exit status.
    fn code(self) -> u8 {
        match self {
            Status::Success => 0,
            Status::Failed => 1,
            Status::BadArguments => 2,
            Status::Interrupted => 130,
            Status::Program(status) => status,
        }
    }
}

impl From<Status> for ExitCode {
    fn from(status: Status) -> ExitCode {
        ExitCode::from(status.code())
    }
}
