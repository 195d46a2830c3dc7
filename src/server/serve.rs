//! A server: the render thread, and the places where clients come in.

use super::thread::{Finish, RenderThread};
use super::transport::{
    Admission, ByteSource, Control, Endpoint, LINGERING, ListenAddress, ListenError, Listener, Medium,
    Uncontrolled, make_room, serve_connection,
};
use super::{Audience, Client, Engine};
use crate::command::EndOfInput;
use std::io::{self, Read, Write};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// The limit of open files allows fewer connections than were asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "no more than {most} connections at one time in place of {wanted}: the limit of open files is {limit} (ulimit -n)"
)]
pub struct TooFewDescriptors {
    /// Connections that were asked for.
    pub wanted: usize,
    /// Connections that are allowed now.
    pub most: usize,
    /// Descriptors that the process may have open.
    pub limit: u64,
}

/// A running server.
///
/// ```
/// use fbptr::server::{Engine, ListenAddress, Server};
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
    /// Starts the render thread; nobody can come in yet.
    ///
    /// # Errors
    /// When the system has no thread to give.
    pub fn start(engine: Engine) -> io::Result<Server> {
        let limits = engine.limits();
        let admission = Admission::new(limits.connections, limits.connections_per_address);
        if let Some(board) = engine.metrics() {
            board.set_admission(admission.clone());
        }
        let thread = RenderThread::start(engine)?;
        Ok(Server { thread, listeners: Vec::new(), admission })
    }

    /// Raises the process's limit of open files as far as the connections that are allowed at `places` places, and `others`
    /// more files, need it and the system lets it. Where it does not suffice fewer connections are allowed, those that there are descriptors for.
    /// To be called before clients are let in.
    pub fn fit_descriptors(&mut self, places: usize, others: usize) -> Option<TooFewDescriptors> {
        // A listener has its socket, a spare descriptor, and a selector's three.
        let others = others + 5 * places + LINGERING;
        let wanted = self.admission.limit();
        let room = make_room(wanted.saturating_add(others))?;
        let most = room.more.saturating_sub(others).max(1);
        self.admission.set_limit(wanted.min(most));
        (most < wanted).then_some(TooFewDescriptors { wanted, most, limit: room.limit })
    }

    /// Lets clients in at `place`; answers where that is, with the port that the system gave for port 0.
    ///
    /// # Errors
    /// See [`ListenError`].
    pub fn listen(&mut self, place: ListenAddress) -> Result<ListenAddress, ListenError> {
        let listener = Listener::start(place, self.thread.link(), self.admission.clone())?;
        let place = listener.place().clone();
        self.listeners.push(listener);
        Ok(place)
    }

    /// Serves one more connection over a pair of pipes, standard input and output for instance.
    ///
    /// # Errors
    /// When the system has no thread to give.
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

    /// A client in this process.
    pub fn client(&self) -> Client {
        self.thread.client()
    }

    /// The render thread.
    pub fn thread(&self) -> &RenderThread {
        &self.thread
    }

    /// Lets nobody in any more, and ends when every connection has, however long its client takes.
    pub fn finish(self) -> Engine {
        drop(self.listeners);
        self.thread.finish(Finish::WhenAllEnded)
    }

    /// Lets nobody in any more, finishes what was received, sends the last replies, and ends: within `patience` and a
    /// fraction of a second more, whatever the clients do.
    pub fn shut_down(self, patience: Duration) -> Engine {
        let until = Instant::now() + patience;
        drop(self.listeners);
        self.thread.finish(Finish::By(until))
    }
}
