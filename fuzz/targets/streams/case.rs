//! Derives a case from an input: the streams of a few connections, the order in which their pieces
//! reach the server, and the server's settings.

use super::data::DataProvider;
use super::verbs::{self, Written};
use super::words::Extremes;
use fbptr::pipeline::{CoarseDepth, RenderOptions};
use fbptr::server::Limits;
use fbptr::simd::Level;
use std::sync::OnceLock;

/// A connection, from its beginning to its end.
#[derive(Default)]
pub struct Connection {
    /// All bytes that the client sends.
    pub stream: Vec<u8>,
    /// Offset of each command in the stream, and the first word of its reply if it has one.
    pub commands: Vec<(u64, Option<&'static str>)>,
    /// True if replies can be matched to commands: errors are reported, and the framing is as
    /// written.
    pub is_matched: bool,
    /// True if the stream ends in order; otherwise the connection is reset.
    pub is_finished: bool,
    /// Where it is served: reply bytes after which its client has gone without reading more.
    pub reads: Option<usize>,
}

/// A run of bytes of one connection, executed at once. An empty one ends the connection.
pub struct Turn {
    pub connection: usize,
    pub bytes: std::ops::Range<usize>,
}

/// Streams, their interleaving and the settings of the server.
pub struct Case {
    pub size: [u32; 2],
    pub limits: Limits,
    pub connections: Vec<Connection>,
    pub turns: Vec<Turn>,
    /// Length limit of the pieces in the second run, in bytes.
    pub piece_bytes: usize,
    /// Options of the first and the second run.
    pub options: [RenderOptions; 2],
    /// True if a render thread serves it too, with all connections concurrent.
    pub is_served: bool,
}

/// Largest number of commands in a case, those of `verbs::setting` not counted.
const MAX_COMMANDS: usize = 60;

impl Case {
    /// Derives the case of an input.
    pub fn new(input: &[u8]) -> Case {
        let data = &mut DataProvider::new(input);
        let size = [[1, 1], [16, 8], [33, 17], [40, 20], [64, 48], [97, 61]][data.below(6)];
        let extremes = Extremes { real: [3, 6, 12, 60][data.below(4)], junk: [50, 200, 1000][data.below(3)] };
        let mut case = Case {
            size,
            limits: limits(data),
            connections: Vec::new(),
            turns: Vec::new(),
            piece_bytes: [1, 2, 7, 61, 400, usize::MAX][data.below(6)],
            options: [options(data), options(data)],
            is_served: data.below(3) == 0,
        };
        let mut open: Vec<usize> = (0..1 + data.below(3)).map(|_| case.begin(data, extremes)).collect();
        for tag in 0..5 + data.below(MAX_COMMANDS - 5) {
            let slot = data.below(open.len());
            let connection = open[slot];
            match data.below(40) {
                0 => {
                    // A reset or an orderly end, possibly in the middle of a command.
                    let written = verbs::any(data, extremes);
                    let cut = data.below(written.bytes.len());
                    case.write(connection, Written { bytes: written.bytes[..cut].to_vec(), reply: None });
                    case.connections[connection].is_finished = data.below(2) == 0;
                    case.turns.push(Turn { connection, bytes: 0..0 });
                    open[slot] = case.begin(data, extremes);
                }
                1 if !case.connections[connection].is_matched => case.write_noise(connection, data),
                2..6 => {
                    let bytes = format!("SYNC s{tag}\n").into_bytes();
                    case.write(connection, Written { bytes, reply: Some("SYNC") });
                }
                _ => case.write(connection, verbs::any(data, extremes)),
            }
        }
        case
    }

    /// Begins a connection and returns its index.
    fn begin(&mut self, data: &mut DataProvider, extremes: Extremes) -> usize {
        let is_matched = data.below(4) > 0;
        let reads = data.once_in(6).then(|| [0, 1, 40, 2000][data.below(4)]);
        let connection = Connection { is_matched, is_finished: true, reads, ..Connection::default() };
        self.connections.push(connection);
        let connection = self.connections.len() - 1;
        let how = if is_matched { "report" } else { ["count", "close", "report"][data.below(3)] };
        if is_matched || data.below(2) == 0 {
            self.write(connection, Written { bytes: format!("ERRORS {how}\n").into_bytes(), reply: None });
        }
        if data.below(2) == 0 {
            for written in verbs::setting(data, extremes) {
                self.write(connection, written);
            }
        }
        connection
    }

    fn write(&mut self, connection: usize, written: Written) {
        if written.bytes.is_empty() {
            return;
        }
        let this = &mut self.connections[connection];
        let from = this.stream.len();
        this.commands.push((from as u64, written.reply));
        this.stream.extend_from_slice(&written.bytes);
        self.turns.push(Turn { connection, bytes: from..self.connections[connection].stream.len() });
    }

    /// Appends arbitrary bytes, which may swallow the commands that follow.
    fn write_noise(&mut self, connection: usize, data: &mut DataProvider) {
        let seed = data.bits();
        let mut bytes: Vec<u8> =
            (0..data.below(30) as u64).map(|i| (seed.wrapping_mul(2 * i + 3) >> 40) as u8).collect();
        match data.below(4) {
            0 => bytes.extend(b":7\n"),
            1 => bytes.extend(format!("X :{}\n", data.below(90)).bytes()),
            2 => bytes.extend([b'a'].repeat(data.below(5000))),
            _ => bytes.push(b'\n'),
        }
        self.write(connection, Written { bytes, reply: None });
    }

    /// Formats the case as text, for the report of a failure.
    pub fn to_text(&self) -> String {
        use std::fmt::Write;
        let mut out = format!("# {}x{}, {:?}\n", self.size[0], self.size[1], self.limits);
        writeln!(out, "# second time: pieces of {}, {:?}", self.piece_bytes, self.options[1].simd)
            .expect("a String takes all");
        for turn in &self.turns {
            let connection = &self.connections[turn.connection];
            match turn.bytes.is_empty() {
                true => writeln!(out, "# connection {} ends", turn.connection).expect("a String takes all"),
                false => {
                    let bytes = connection.stream[turn.bytes.clone()].escape_ascii();
                    writeln!(out, "{}: {bytes}", turn.connection).expect("a String takes all");
                }
            }
        }
        out
    }
}

/// Chooses limits, sometimes so small that streams reach them.
fn limits(data: &mut DataProvider) -> Limits {
    let is_tight = data.once_in(4);
    let of = |data: &mut DataProvider, few: u64, many: u64| {
        if is_tight && data.below(2) == 0 { few } else { many }
    };
    Limits {
        payload_bytes: of(data, 200, 100_000),
        names: of(data, 1, 4096) as usize,
        resource_bytes: of(data, 3000, 8 << 20),
        reply_bytes: of(data, 300, 1 << 20) as usize,
        matrix_stack: of(data, 1, 20) as usize,
        lights: of(data, 1, 256) as usize,
        ..Limits::default()
    }
}

/// Chooses threads, vector level and hierarchical z, none of which may change a byte.
fn options(data: &mut DataProvider) -> RenderOptions {
    static THREADS: OnceLock<RenderOptions> = OnceLock::new();
    let threads = THREADS.get_or_init(|| RenderOptions {
        pool: fbptr::server::worker_pool(Some(2)),
        ..RenderOptions::default()
    });
    let level = Level::ALL[data.below(3)];
    RenderOptions {
        pool: threads.pool.clone().filter(|_| data.below(2) == 0),
        simd: level.is_available().then_some(level),
        coarse: if data.below(3) == 0 { CoarseDepth::On } else { CoarseDepth::Off },
        ..RenderOptions::default()
    }
}
