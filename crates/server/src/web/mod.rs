//! The page in the browser: shows the frame of a running server, and lets those who may drive it.
//!
//! In: frames of a [`WebFeed`], on which a [`WebObserver`] puts what an engine draws; HTTP requests
//! and WebSocket messages of browsers. Out: one page without external resources, and over its
//! WebSocket the tiles that have changed, compressed once for all viewers; commands of those who may
//! drive, which run in an ordinary connection each (`commands.rs`); keys and pointer as events.
//!
//! Threads: one (`event_loop.rs`), which serves all connections without blocking, and gives way to
//! the render thread. Promises: the render thread never waits for it longer than one copy of rows
//! takes; what a viewer shows is the memory at one moment, byte for byte; a viewer that reads slowly
//! skips to the newest frame and delays nobody; connections, bytes and times are bounded, whatever
//! a client sends. Sources: RFC 6455 (WebSocket), RFC 9112 (HTTP/1.1), RFC 1951 (deflate).

mod commands;
mod connection;
mod event_loop;
mod feed;
mod observer;
mod page;
mod rights;
mod socket;
mod tiles;
mod turn;
mod wire;

pub use feed::WebFeed;
pub use observer::WebObserver;
pub use rights::WebTokens;

use super::admission::Admission;
use super::metrics::MetricsBoard;
use super::transport::Link;
use event_loop::EventLoop;
use fbptr_core::input::InputEvent;
use std::io;
use std::net::SocketAddr;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{Builder, JoinHandle};

/// Connections at one time, at most; half of them may be viewers.
const MAX_CONNECTIONS: usize = 256;
/// Viewers at one time, at most.
const MAX_VIEWERS: usize = MAX_CONNECTIONS / 2;
const STACK_BYTES: usize = 512 << 10;

/// Settings of the page.
#[derive(Debug)]
pub struct WebOptions {
    /// Address to listen on.
    pub address: SocketAddr,
    /// Host name that requests may use beside `localhost` and addresses.
    pub name: Option<String>,
    /// The tokens of the links.
    pub tokens: WebTokens,
    /// Counters that the page shows, if there are any.
    pub board: Option<Arc<MetricsBoard>>,
}

/// The receiver of the events and commands of those who drive.
pub(super) enum WebTarget {
    /// A render thread. Commands run in connections that `admission` counts.
    Thread { link: Link, admission: Arc<Admission> },
    /// A program that takes events from the feed's display, and has no commands.
    Program,
}

impl std::fmt::Debug for WebTarget {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let name = if matches!(self, WebTarget::Program) { "Program" } else { "Thread" };
        write!(f, "WebTarget::{name}")
    }
}

impl WebTarget {
    /// Sends an event of the user; drops it if thousands are queued already.
    fn send(&self, feed: &WebFeed, event: InputEvent) {
        match self {
            WebTarget::Thread { link, .. } => {
                drop(link.messages.try_send(super::message::Message::Event(event)))
            }
            WebTarget::Program => feed.display().send(event),
        }
    }
}

/// A server of the page. Dropping it ends it.
#[derive(Debug)]
pub struct WebServer {
    address: SocketAddr,
    is_ending: Arc<AtomicBool>,
    feed: Arc<WebFeed>,
    thread: Option<JoinHandle<()>>,
}

impl WebServer {
    /// Descriptors that it has open at most: connections, the listener, the selector's.
    pub const MAX_FILES: usize = MAX_CONNECTIONS + 5;

    /// Serves the pictures of a program that is no server, such as the viewer: it puts them on the
    /// feed's display, and takes events from there.
    ///
    /// # Errors
    /// If the address cannot be bound, or the system has no thread to give.
    pub fn of_program(feed: Arc<WebFeed>, options: WebOptions) -> io::Result<WebServer> {
        WebServer::start(feed, options, WebTarget::Program)
    }

    /// Serves the frames that are on `feed`.
    ///
    /// # Errors
    /// If the address cannot be bound, or the system has no thread to give.
    pub(super) fn start(feed: Arc<WebFeed>, options: WebOptions, target: WebTarget) -> io::Result<WebServer> {
        let is_ending = Arc::new(AtomicBool::new(false));
        let event_loop = EventLoop::new(feed.clone(), options, target, is_ending.clone())?;
        let address = event_loop.address();
        let thread =
            Builder::new().name("web".into()).stack_size(STACK_BYTES).spawn(move || event_loop.run())?;
        Ok(WebServer { address, is_ending, feed, thread: Some(thread) })
    }

    /// Returns the address, with the port that the system chose for port 0.
    pub fn address(&self) -> SocketAddr {
        self.address
    }
}

impl Drop for WebServer {
    fn drop(&mut self) {
        self.is_ending.store(true, Ordering::Release);
        self.feed.wake_web();
        if let Some(thread) = self.thread.take() {
            // A thread that panicked has ended, too.
            let _ = thread.join();
        }
    }
}
