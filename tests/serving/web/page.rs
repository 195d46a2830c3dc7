//! The page's side of the wire: a server with a page, and a page that keeps a copy of the frame.

use crate::support::Wire;
use fbptr::memory::VideoMemory;
use fbptr::server::{
    Engine, ListenAddress, MetricsBoard, Server, VerbCounts, WebFeed, WebObserver, WebOptions, WebServer,
    WebTokens,
};
use flate2::read::DeflateDecoder;
use std::io::{Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::time::{Duration, Instant};
use tungstenite::client::IntoClientRequest;
use tungstenite::{Message, WebSocket};

/// Longest wait for something that must come.
pub const PATIENCE: Duration = Duration::from_secs(60);

/// A server with a page on a free loopback port.
pub struct Site {
    pub page: WebServer,
    pub server: Server,
    pub clients: SocketAddr,
    pub tokens: WebTokens,
}

impl Site {
    pub fn start(width: u32, height: u32) -> Site {
        Site::with(Engine::new(width, height).unwrap(), WebTokens::new(false, true).unwrap())
    }

    pub fn with(mut engine: Engine, tokens: WebTokens) -> Site {
        let feed = WebFeed::new(engine.memory().width(), engine.memory().height());
        let board = MetricsBoard::new();
        engine.attach(VerbCounts::new(board.clone()));
        engine.attach(WebObserver::new(feed.clone()));
        let mut server = Server::start(engine).unwrap();
        let place = ListenAddress::Tcp("127.0.0.1:0".parse().unwrap());
        let ListenAddress::Tcp(clients) = server.listen(place).unwrap() else { panic!("not tcp") };
        let address = "127.0.0.1:0".parse().unwrap();
        let options = WebOptions { address, name: None, tokens: tokens.clone(), board: Some(board) };
        let page = server.serve_web(feed, options).unwrap();
        Site { page, server, clients, tokens }
    }

    pub fn connect(&self) -> Wire {
        Wire::connect(self.clients)
    }

    pub fn watch(&self) -> Page {
        Page::open(self.page.address(), "")
    }

    pub fn drive(&self) -> Page {
        Page::open(self.page.address(), self.tokens.drive().unwrap())
    }

    pub fn memory(&self) -> VideoMemory {
        self.server.client().snapshot().unwrap()
    }

    /// Sends a request as it is and returns the answer's status.
    pub fn status(&self, request: &str) -> String {
        let mut stream = TcpStream::connect(self.page.address()).unwrap();
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        stream.write_all(request.as_bytes()).unwrap();
        let mut answer = String::new();
        stream.read_to_string(&mut answer).unwrap();
        answer.split(' ').nth(1).unwrap_or("").to_owned()
    }
}

/// The page's side of a WebSocket, with its copy of the frame.
pub struct Page {
    pub socket: WebSocket<TcpStream>,
    pub width: usize,
    pub tile: usize,
    pub bytes: Vec<u8>,
    pub sequence: u64,
    pub frame: u64,
    pub frames_shown: u64,
    pub acknowledges: bool,
    pub pending: (u64, Vec<(usize, Vec<u8>)>),
    pub texts: Vec<String>,
    pub replies: String,
}

impl Page {
    pub fn open(address: SocketAddr, token: &str) -> Page {
        let mut page = Page::connect(address);
        page.say(&format!("join {token}"));
        let hello = page.text_that("hello ");
        let facts: serde_json::Value = serde_json::from_str(&hello).unwrap();
        let number = |name: &str| facts[name].as_u64().unwrap() as usize;
        (page.width, page.tile) = (number("width"), number("tile"));
        page.bytes = vec![0; number("width") * number("height") * 4];
        page
    }

    pub fn connect(address: SocketAddr) -> Page {
        let stream = TcpStream::connect(address).unwrap();
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        let mut request = format!("ws://{address}/socket").into_client_request().unwrap();
        request.headers_mut().insert("Origin", format!("http://{address}").parse().unwrap());
        let (socket, _) = tungstenite::client(request, stream).unwrap();
        Page {
            socket,
            width: 0,
            tile: 1,
            bytes: Vec::new(),
            sequence: 0,
            frame: 0,
            frames_shown: 0,
            acknowledges: true,
            pending: (0, Vec::new()),
            texts: Vec::new(),
            replies: String::new(),
        }
    }

    pub fn say(&mut self, text: &str) {
        self.socket.send(Message::text(text)).unwrap();
    }

    /// Handles the next message.
    pub fn next(&mut self) -> tungstenite::Result<()> {
        match self.socket.read()? {
            Message::Text(text) => self.texts.push(text.to_string()),
            Message::Binary(bytes) if bytes[0] == 1 => self.take_tiles(&bytes),
            Message::Binary(bytes) => self.replies.push_str(std::str::from_utf8(&bytes[1..]).unwrap()),
            Message::Close(frame) => {
                self.texts.push(format!("closed {}", frame.map_or(String::new(), |f| f.reason.to_string())));
                return Err(tungstenite::Error::ConnectionClosed);
            }
            _ => {}
        }
        Ok(())
    }

    pub fn take_tiles(&mut self, message: &[u8]) {
        let word = |at: usize| u64::from_le_bytes(message[at..at + 8].try_into().unwrap());
        let count = usize::from(u16::from_le_bytes([message[2], message[3]]));
        let (sequence, frame) = (word(4), word(12));
        if self.pending.0 != sequence {
            self.pending = (sequence, Vec::new());
        }
        let mut bytes = DeflateDecoder::new(&message[20 + 4 * count..]);
        for i in 0..count {
            let at = 20 + 4 * i;
            let index = u32::from_le_bytes(message[at..at + 4].try_into().unwrap()) as usize;
            let mut tile = vec![0; self.rows_of(index).map(|row| row.len()).sum()];
            bytes.read_exact(&mut tile).unwrap();
            self.pending.1.push((index, tile));
        }
        assert_eq!(bytes.read(&mut [0]).unwrap(), 0, "there is no more than the tiles");
        if message[1] == 1 {
            for (index, tile) in std::mem::take(&mut self.pending.1) {
                let mut at = 0;
                for row in self.rows_of(index).collect::<Vec<_>>() {
                    let length = row.len();
                    self.bytes[row].copy_from_slice(&tile[at..at + length]);
                    at += length;
                }
            }
            assert!(sequence > self.sequence, "frames come in order");
            (self.sequence, self.frame) = (sequence, frame);
            self.frames_shown += 1;
            if self.acknowledges {
                // If the server has closed the connection, the next read says so.
                let _ = self.socket.send(Message::text(format!("ack {sequence}")));
            }
        }
    }

    pub fn rows_of(&self, index: usize) -> impl Iterator<Item = std::ops::Range<usize>> + use<> {
        let (width, tile) = (self.width, self.tile);
        let height = self.bytes.len() / 4 / width;
        let columns = width.div_ceil(tile);
        let (x0, y0) = (index % columns * tile, index / columns * tile);
        let x1 = (x0 + tile).min(width);
        (y0..(y0 + tile).min(height)).map(move |y| (y * width + x0) * 4..(y * width + x1) * 4)
    }

    pub fn until(&mut self, what: &str, mut holds: impl FnMut(&Page) -> bool) {
        let until = Instant::now() + PATIENCE;
        while !holds(self) {
            assert!(Instant::now() < until, "{what} did not come: {:?}", self.replies);
            self.next().unwrap_or_else(|e| panic!("{what} did not come: {e}"));
        }
    }

    pub fn until_shows(&mut self, memory: &VideoMemory) {
        self.until("the frame", |page| page.bytes == memory.bytes());
    }

    /// Waits for a text that begins so, and returns its rest.
    pub fn text_that(&mut self, head: &str) -> String {
        let at = |page: &Page| page.texts.iter().position(|text| text.starts_with(head));
        self.until(head, |page| at(page).is_some());
        let text = self.texts.remove(at(self).unwrap());
        text[head.len()..].to_owned()
    }

    pub fn until_replied(&mut self, text: &str) {
        self.until(text, |page| page.replies.contains(text));
        self.replies.clear();
    }

    /// Reads until the server ends the connection, and returns what was said.
    pub fn until_closed(mut self) -> Vec<String> {
        while self.next().is_ok() {}
        self.texts
    }
}
