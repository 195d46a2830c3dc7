//! Servers and clients for the tests.

use crate::folder::Folder;
use fbptr::memory::VideoMemory;
use fbptr::server::{Engine, Limits, ListenAddress, Server};
use std::io::{ErrorKind, Read, Write};
use std::net::{Shutdown, SocketAddr, TcpStream};
use std::path::PathBuf;
use std::time::Duration;

/// A server on a free loopback port.
pub struct Serving {
    pub server: Server,
    pub address: SocketAddr,
}

impl Serving {
    pub fn start(width: u32, height: u32) -> Serving {
        Serving::with(Engine::new(width, height).unwrap())
    }

    pub fn limited(width: u32, height: u32, limits: Limits) -> Serving {
        Serving::with(Engine::with_limits(width, height, limits).unwrap())
    }

    pub fn with(engine: Engine) -> Serving {
        let mut server = Server::start(engine).unwrap();
        let place = ListenAddress::Tcp("127.0.0.1:0".parse().unwrap());
        let ListenAddress::Tcp(address) = server.listen(place).unwrap() else { panic!("not tcp") };
        Serving { server, address }
    }

    pub fn connect(&self) -> Wire {
        Wire::connect(self.address)
    }

    /// Sends the request, closes the sending side and returns all replies.
    pub fn talk(&self, request: &[u8]) -> Vec<u8> {
        self.connect().talk(request)
    }

    /// [`Serving::talk`] with text.
    pub fn say(&self, request: &str) -> String {
        String::from_utf8_lossy(&self.talk(request.as_bytes())).into_owned()
    }

    pub fn memory(&self) -> VideoMemory {
        self.server.client().snapshot().unwrap()
    }
}

/// A client's socket, with time limits that a busy machine does not reach.
pub struct Wire(pub TcpStream);

impl Wire {
    pub fn connect(address: SocketAddr) -> Wire {
        let stream = TcpStream::connect(address).unwrap();
        stream.set_nodelay(true).unwrap();
        let patience = Some(Duration::from_secs(300));
        stream.set_read_timeout(patience).unwrap();
        stream.set_write_timeout(patience).unwrap();
        Wire(stream)
    }

    pub fn send(&mut self, bytes: &[u8]) {
        self.0.write_all(bytes).unwrap();
    }

    /// Reads one reply line, with its LF.
    pub fn line(&mut self) -> String {
        let mut line = Vec::new();
        let mut byte = [0];
        while !line.ends_with(b"\n") {
            self.0.read_exact(&mut byte).unwrap();
            line.push(byte[0]);
        }
        String::from_utf8(line).unwrap()
    }

    pub fn ask(&mut self, request: &str) -> String {
        self.send(request.as_bytes());
        self.line()
    }

    /// Sends a request and reads one reply line, or returns `None` if none comes in time.
    pub fn try_ask(&mut self, request: &str) -> Option<String> {
        self.send(request.as_bytes());
        let (mut line, mut byte) = (Vec::new(), [0]);
        while !line.ends_with(b"\n") {
            self.0.read_exact(&mut byte).ok()?;
            line.push(byte[0]);
        }
        String::from_utf8(line).ok()
    }

    pub fn talk(mut self, request: &[u8]) -> Vec<u8> {
        self.send(request);
        self.rest()
    }

    /// Closes the sending side and reads to the end.
    pub fn rest(mut self) -> Vec<u8> {
        match self.0.shutdown(Shutdown::Write) {
            // The server may have closed the connection already; what it sent can still be read.
            Err(e) if e.kind() == ErrorKind::NotConnected => {}
            result => result.unwrap(),
        }
        let mut all = Vec::new();
        self.0.read_to_end(&mut all).unwrap();
        all
    }

    /// Closes the connection, with a reset where the system sends one for unread bytes.
    pub fn reset(self) {
        self.0.set_nonblocking(true).unwrap();
        drop(self.0.shutdown(Shutdown::Both));
    }
}

impl Folder {
    pub fn join(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }
}

/// A pseudo-random number generator: xorshift32.
pub struct Numbers(pub u32);

impl Numbers {
    pub fn below(&mut self, limit: u32) -> u32 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 17;
        self.0 ^= self.0 << 5;
        self.0 % limit
    }
}
