//! The server: the render thread, and the listeners and pipes through which clients connect.

use super::admission::Admission;
use super::message::{Finish, Medium};
use super::metrics::VerbCounts;
use super::thread::RenderThread;
use super::transport::{
    ByteSource, Control, Endpoint, LINGERING, ListenAddress, ListenError, Listener, Uncontrolled, make_room,
    serve_connection,
};
#[cfg(feature = "web")]
use super::web::{WebFeed, WebOptions, WebServer, WebTarget};
use super::{Audience, Client, Engine};
use fbptr_command::EndOfInput;
use std::fmt;
use std::io::{self, Read, Write};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Warning that the limit of open files allows fewer connections than were asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TooFewDescriptors {
    /// Number of connections that were asked for.
    pub wanted: usize,
    /// Number of connections that are allowed.
    pub most: usize,
    /// Number of descriptors that the process may have open.
    pub limit: u64,
}

impl fmt::Display for TooFewDescriptors {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let TooFewDescriptors { wanted, most, limit } = self;
        write!(f, "no more than {most} connections at one time in place of {wanted}: ")?;
        write!(f, "the limit of open files is {limit} (ulimit -n)")
    }
}

impl std::error::Error for TooFewDescriptors {}

/// A running server.
///
/// ```
/// use fbptr_server::{Engine, ListenAddress, Server};
/// use std::io::{Read, Write};
///
/// let mut server = Server::start(Engine::new(64, 48)?)?;
/// let ListenAddress::Tcp(address) = server.listen(ListenAddress::Tcp("127.0.0.1:0".parse()?))? else { unreachable!() };
/// let mut client = std::net::TcpStream::connect(address)?;
/// client.write_all(b"PX 1 2 ff8000\nPX 1 2\nQUIT\n")?;
/// let mut answer = String::new();
/// client.read_to_string(&mut answer)?;
/// assert_eq!(answer, "PX 1 2 ff8000\n");
/// let engine = server.shut_down(std::time::Duration::from_secs(1));
/// assert_eq!(engine.memory().get_pixel(1, 2)?, [255, 128, 0, 255]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct Server {
    thread: RenderThread,
    listeners: Vec<Listener>,
    admission: Arc<Admission>,
}

impl Server {
    /// Starts the render thread, without any listener.
    ///
    /// # Errors
    /// If the system has no thread to give.
    pub fn start(engine: Engine) -> io::Result<Server> {
        let limits = engine.limits();
        let admission = Admission::new(limits.connections, limits.connections_per_address);
        if let Some(counts) = engine.observer::<VerbCounts>() {
            counts.board().set_admission(admission.clone());
        }
        let thread = RenderThread::start(engine)?;
        Ok(Server { thread, listeners: Vec::new(), admission })
    }

    /// Raises the process's limit of open files, as far as the system allows, to what the allowed
    /// connections, `places` listeners and `others` more files need. If that does not suffice,
    /// reduces the allowed connections to those for which there are descriptors, and returns the
    /// numbers. To be called before clients can connect.
    pub fn fit_descriptors(&mut self, places: usize, others: usize) -> Option<TooFewDescriptors> {
        // A listener has its socket, a descriptor in reserve, and three of its selector.
        let others = others + 5 * places + LINGERING;
        let wanted = self.admission.limit();
        let room = make_room(wanted.saturating_add(others))?;
        let most = room.more.saturating_sub(others).max(1);
        self.admission.set_limit(wanted.min(most));
        (most < wanted).then_some(TooFewDescriptors { wanted, most, limit: room.limit })
    }

    /// Listens at `place`. Returns the address, with the port that the system chose for port 0.
    ///
    /// # Errors
    /// See [`ListenError`].
    pub fn listen(&mut self, place: ListenAddress) -> Result<ListenAddress, ListenError> {
        let listener = Listener::start(place, self.thread.link(), self.admission.clone())?;
        let place = listener.place().clone();
        self.listeners.push(listener);
        Ok(place)
    }

    /// Serves one more connection over a pair of pipes, such as standard input and output.
    ///
    /// # Errors
    /// If the system has no thread to give.
    pub fn serve_pipe(
        &self,
        input: Box<dyn Read + Send>,
        output: Box<dyn Write + Send>,
        on_end: impl FnOnce() + Send + 'static,
    ) -> io::Result<()> {
        let control: Arc<dyn Control> = Arc::new(Uncontrolled);
        let endpoint = Endpoint {
            input: ByteSource::Alone(input),
            output,
            control,
            end: EndOfInput::Stream,
            audience: Audience::Connection,
            medium: Medium::Pipe,
            may_replay: false,
            on_notice: None,
            on_end: Some(Box::new(on_end)),
        };
        serve_connection(&self.thread.link(), endpoint)
    }

    /// Serves the page in the browser, with the frames of `feed`, which a
    /// [`WebObserver`](super::WebObserver) of this server's engine fills. Commands of those who may
    /// drive count as connections.
    ///
    /// # Errors
    /// If the address cannot be bound, or the system has no thread to give.
    #[cfg(feature = "web")]
    pub fn serve_web(&self, feed: Arc<WebFeed>, options: WebOptions) -> io::Result<WebServer> {
        let target = WebTarget::Thread { link: self.thread.link(), admission: self.admission.clone() };
        WebServer::start(feed, options, target)
    }

    /// Creates an in-process client.
    pub fn client(&self) -> Client {
        self.thread.client()
    }

    /// Returns the handle of the render thread.
    pub fn thread(&self) -> &RenderThread {
        &self.thread
    }

    /// Stops listening, and ends when every connection has ended, however long its client takes.
    pub fn finish(self) -> Engine {
        drop(self.listeners);
        self.thread.finish_engine(Finish::WhenAllEnded)
    }

    /// Stops listening, runs what was received, sends the last replies, and ends within `patience`
    /// plus a fraction of a second, whatever the clients do.
    pub fn shut_down(self, patience: Duration) -> Engine {
        let until = Instant::now() + patience;
        drop(self.listeners);
        self.thread.finish_engine(Finish::By(until))
    }
}
