//! Benchmark from the socket to the memory: a flood of commands, compared with a socket that only
//! reads and discards.
//!
//! `cargo bench --bench socket [-- --quick|--memory] [-- --only=WORDS]`, where WORDS are part of a
//! line's transport, workload and connections, as `--only='tcp PB 64'`. Each workload is sent by
//! one thread per connection to a server in the same process, over loopback, in writes of 256 KiB;
//! the time runs from the first byte to the answer to a `SYNC` behind the last. The ceiling is the
//! same bytes, sent the same way, to as many threads that read and discard them.
//!
//! Both vary with the system's placement of threads and with the rest of the machine, so only
//! figures measured within the same second are compared: in each round the ceiling and the server
//! alternate, in changing order, on one connection, on 64 and on a Unix socket. A rate is the
//! median of its rounds; a ratio is the median of the rounds' ratios, their least and largest in
//! brackets; so are 64 connections against one and the Unix socket against TCP. The pixels of every
//! measured run are compared with those sent.

use fbptr::memory::VideoMemory;
use fbptr::server::{Audience, Budget, Engine, ListenAddress, Output, Server, Stream, StreamState};
use std::io::{Read, Write};
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::path::PathBuf;
use std::time::{Duration, Instant};

const WIDTH: u32 = 1920;
const HEIGHT: u32 = 1080;
const WRITE_BYTES: usize = 256 << 10;

trait Wire: Read + Write + Send {}
impl<T: Read + Write + Send> Wire for T {}

/// Transport by which a server listens and clients connect.
#[derive(Clone)]
enum Road {
    Tcp,
    Unix(PathBuf),
}

fn connect(place: &ListenAddress) -> Box<dyn Wire> {
    match place {
        ListenAddress::Tcp(address) => {
            let stream = TcpStream::connect(address).expect("the server listens");
            stream.set_nodelay(true).expect("a socket option");
            Box::new(stream)
        }
        #[cfg(unix)]
        ListenAddress::Unix(path) => {
            Box::new(std::os::unix::net::UnixStream::connect(path).expect("the server listens"))
        }
        #[cfg(not(unix))]
        ListenAddress::Unix(_) => unreachable!("no unix sockets here"),
    }
}

/// A stream that is sent repeatedly, and the picture that it draws.
struct Workload {
    name: &'static str,
    unit: &'static str,
    bytes: Vec<u8>,
    /// Number of units (named by `unit`) in one pass of the stream.
    units: u64,
    picture: VideoMemory,
}

struct Numbers(u32);

impl Numbers {
    fn next(&mut self) -> u32 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 17;
        self.0 ^= self.0 << 5;
        self.0
    }
}

/// Generates pixels at random positions; returns the picture, in which the last pixel of each
/// position remains.
fn random_pixels(count: u32, mut each: impl FnMut(u32, u32, [u8; 4])) -> VideoMemory {
    let mut numbers = Numbers(0x1234_5678);
    let mut picture = VideoMemory::new(WIDTH, HEIGHT).expect("a frame");
    for _ in 0..count {
        let (x, y) = (numbers.next() % WIDTH, numbers.next() % HEIGHT);
        let [r, g, b, _] = numbers.next().to_le_bytes();
        let color = [r, g, b, 255];
        picture.put_pixel(x as i32, y as i32, color);
        each(x, y, color);
    }
    picture
}

fn rows(mut each: impl FnMut(u32, &[u8])) -> VideoMemory {
    let mut numbers = Numbers(77);
    let mut picture = VideoMemory::new(WIDTH, HEIGHT).expect("a frame");
    for y in 0..HEIGHT {
        let row: Vec<u8> = (0..WIDTH).flat_map(|_| numbers.next().to_le_bytes()).collect();
        let at = y as usize * row.len();
        picture.bytes_mut()[at..at + row.len()].copy_from_slice(&row);
        each(y, &row);
    }
    picture
}

fn workloads() -> Vec<Workload> {
    const PIXELS: u32 = 200_000;
    let mut text = Vec::new();
    let picture = random_pixels(PIXELS, |x, y, [r, g, b, _]| {
        writeln!(text, "PX {x} {y} {r:02x}{g:02x}{b:02x}").expect("a Vec takes all bytes");
    });
    let px = Workload { name: "PX text", unit: "M commands/s", bytes: text, units: PIXELS.into(), picture };
    let mut binary = Vec::new();
    let picture = random_pixels(PIXELS, |x, y, color| {
        binary.extend_from_slice(b"PB");
        binary.extend_from_slice(&(x as u16).to_le_bytes());
        binary.extend_from_slice(&(y as u16).to_le_bytes());
        binary.extend_from_slice(&color);
    });
    let pb = Workload { name: "PB", unit: "M pixels/s", bytes: binary, units: PIXELS.into(), picture };
    let pixels = u64::from(WIDTH) * u64::from(HEIGHT);
    let mut runs = Vec::new();
    let picture = rows(|y, row| {
        runs.extend_from_slice(b"PXMULTI\0\0");
        runs.extend_from_slice(&(y as u16).to_le_bytes());
        runs.extend_from_slice(&WIDTH.to_le_bytes());
        runs.extend_from_slice(row);
    });
    let multi = Workload { name: "PXMULTI rows", unit: "M pixels/s", bytes: runs, units: pixels, picture };
    let mut blits = Vec::new();
    let picture = rows(|y, row| {
        writeln!(blits, "BLIT 0 {y} {WIDTH} 1 :{}", row.len()).expect("a Vec takes all bytes");
        blits.extend_from_slice(row);
    });
    let blit = Workload { name: "BLIT rows", unit: "M pixels/s", bytes: blits, units: pixels, picture };
    let mut whole = Vec::new();
    let picture = rows(|y, row| {
        if y == 0 {
            writeln!(whole, "BLIT 0 0 {WIDTH} {HEIGHT} :{}", row.len() * HEIGHT as usize).expect("a Vec");
        }
        whole.extend_from_slice(row);
    });
    let frame = Workload { name: "BLIT frames", unit: "M pixels/s", bytes: whole, units: pixels, picture };
    vec![px, pb, multi, blit, frame]
}

/// Sends the stream `times` times and waits for the answer to the command behind it.
fn send(wire: &mut dyn Wire, bytes: &[u8], times: usize, last: &[u8], answer: usize) {
    for _ in 0..times {
        for piece in bytes.chunks(WRITE_BYTES) {
            wire.write_all(piece).expect("the other side reads");
        }
    }
    wire.write_all(last).expect("the other side reads");
    wire.read_exact(&mut vec![0; answer]).expect("the other side answers");
}

/// Starts threads that each read and discard `total` bytes of a connection and then answer with the
/// byte `~`.
fn discard(road: &Road, total: u64, connections: usize) -> (ListenAddress, std::thread::JoinHandle<()>) {
    fn run(mut wire: impl Read + Write, total: u64) {
        let (mut buffer, mut left) = (vec![0; WRITE_BYTES], total);
        while left > 0 {
            let n = wire.read(&mut buffer).expect("a client that sends");
            left -= n as u64;
        }
        wire.write_all(b"~").expect("a client that reads");
    }
    match road {
        Road::Tcp => {
            let listener = TcpListener::bind("127.0.0.1:0").expect("a free port");
            let address: SocketAddr = listener.local_addr().expect("an address");
            let thread = std::thread::spawn(move || {
                std::thread::scope(|scope| {
                    for _ in 0..connections {
                        let wire = listener.accept().expect("a client").0;
                        scope.spawn(move || run(wire, total));
                    }
                });
            });
            (ListenAddress::Tcp(address), thread)
        }
        #[cfg(unix)]
        Road::Unix(path) => {
            let path = path.with_extension("ceiling");
            let _ = std::fs::remove_file(&path);
            let listener = std::os::unix::net::UnixListener::bind(&path).expect("a socket file");
            let thread = std::thread::spawn(move || {
                std::thread::scope(|scope| {
                    for _ in 0..connections {
                        let wire = listener.accept().expect("a client").0;
                        scope.spawn(move || run(wire, total));
                    }
                });
            });
            (ListenAddress::Unix(path), thread)
        }
        #[cfg(not(unix))]
        Road::Unix(_) => unreachable!("no unix sockets here"),
    }
}

/// Returns the processor seconds used by this process, or 0 if the system does not tell.
fn processor_seconds() -> f64 {
    let stat = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    let fields: Vec<&str> = stat.rsplit(')').next().unwrap_or("").split_whitespace().collect();
    let ticks = |i: usize| fields.get(i).and_then(|t| t.parse::<f64>().ok()).unwrap_or(0.0);
    (ticks(11) + ticks(12)) / 100.0
}

fn ceiling(road: &Road, workload: &Workload, times: usize, connections: usize) -> Duration {
    let times = times / connections;
    let total = workload.bytes.len() as u64 * times as u64 + 1;
    let (place, thread) = discard(road, total, connections);
    let mut wires: Vec<_> = (0..connections).map(|_| connect(&place)).collect();
    let begun = Instant::now();
    std::thread::scope(|scope| {
        for wire in &mut wires {
            scope.spawn(|| send(&mut **wire, &workload.bytes, times, b"~", 1));
        }
    });
    let took = begun.elapsed();
    thread.join().expect("the reader ends");
    took
}

fn serve(road: &Road) -> (Server, ListenAddress) {
    let mut server = Server::start(Engine::new(WIDTH, HEIGHT).expect("a frame")).expect("a thread");
    let place = match road {
        Road::Tcp => ListenAddress::Tcp("127.0.0.1:0".parse().expect("an address")),
        Road::Unix(path) => ListenAddress::Unix(path.clone()),
    };
    let place = server.listen(place).expect("a place to listen");
    (server, place)
}

/// Feeds the same bytes from memory, in pieces as large as a reader's: the cost of decoding and
/// drawing alone.
fn from_memory(workload: &Workload) -> Duration {
    let mut engine = Engine::new(WIDTH, HEIGHT).expect("a frame");
    let mut stream = Stream::new(&engine, 1, Audience::Connection);
    let (mut out, mut best) = (Output::default(), Duration::MAX);
    for _ in 0..100 {
        let begun = Instant::now();
        for piece in workload.bytes.chunks(WRITE_BYTES) {
            let (used, state) = stream.feed(&mut engine, piece, &mut out, Budget::NONE);
            assert_eq!((used, state), (piece.len(), StreamState::Ready));
        }
        best = best.min(begun.elapsed());
    }
    assert!(engine.memory().bytes() == workload.picture.bytes() && out.replies.is_empty());
    best
}

/// Sends the workload over `connections` at once, divided among them, and verifies the picture.
fn measured(road: &Road, workload: &Workload, times: usize, connections: usize) -> Duration {
    let (server, place) = serve(road);
    let mut wires: Vec<_> = (0..connections).map(|_| connect(&place)).collect();
    let begun = Instant::now();
    std::thread::scope(|scope| {
        for wire in &mut wires {
            scope.spawn(|| send(&mut **wire, &workload.bytes, times / connections, b"SYNC end\n", 9));
        }
    });
    let took = begun.elapsed();
    let engine = server.shut_down(Duration::from_secs(1));
    // Connections that send the same stream at once leave the right last pixel everywhere only if
    // each ends with it.
    let differs = |(a, b): (&[u8; 4], &[u8; 4])| a != b;
    let (got, want) =
        (engine.memory().bytes().as_chunks::<4>().0, workload.picture.bytes().as_chunks::<4>().0);
    let wrong = got.iter().zip(want).filter(|&p| differs(p)).count();
    if connections == 1 || !workload.name.starts_with('P') || workload.name.contains("rows") {
        assert_eq!(wrong, 0, "{}: pixels that are wrong", workload.name);
    } else {
        let drawn = want.iter().filter(|p| p[..3] != [0, 0, 0]).count();
        assert!(wrong < drawn / 10, "{}: {wrong} of {drawn} pixels are wrong", workload.name);
    }
    took
}

/// Returns the median and the longest wait of one client for a SYNC while 63 others flood.
fn longest_wait(workload: &Workload) -> (Duration, Duration) {
    let (server, place) = serve(&Road::Tcp);
    let until = Instant::now() + Duration::from_secs(2);
    let mut waits = Vec::new();
    std::thread::scope(|scope| {
        for _ in 0..63 {
            let mut wire = connect(&place);
            scope.spawn(move || {
                while Instant::now() < until {
                    send(&mut *wire, &workload.bytes[..workload.bytes.len() / 8], 1, b"", 0);
                }
            });
        }
        let mut wire = connect(&place);
        while Instant::now() < until {
            let begun = Instant::now();
            send(&mut *wire, b"", 0, b"SYNC me\n", 8);
            waits.push(begun.elapsed());
        }
    });
    drop(server.shut_down(Duration::from_secs(2)));
    waits.sort();
    (waits[waits.len() / 2], waits[waits.len() - 1])
}

/// Returns the median, the least and the largest.
fn spread(mut numbers: Vec<f64>) -> [f64; 3] {
    numbers.sort_by(f64::total_cmp);
    let n = numbers.len();
    [(numbers[(n - 1) / 2] + numbers[n / 2]) / 2.0, numbers[0], numbers[n - 1]]
}

/// One line of the table, with the seconds and processor seconds of its rounds.
struct Case<'a> {
    road_name: &'static str,
    road: &'a Road,
    connections: usize,
    times: usize,
    ours: Vec<[f64; 2]>,
    ceiling: Vec<[f64; 2]>,
}

impl Case<'_> {
    fn round(&mut self, workload: &Workload, is_ceiling: bool) {
        let begun = processor_seconds();
        let run = if is_ceiling { ceiling } else { measured };
        let took = run(self.road, workload, self.times, self.connections).as_secs_f64();
        let to = if is_ceiling { &mut self.ceiling } else { &mut self.ours };
        to.push([took, processor_seconds() - begun]);
    }

    /// Returns the megabytes per second of each round.
    fn rates(&self, workload: &Workload, rounds: &[[f64; 2]]) -> Vec<f64> {
        rounds.iter().map(|[took, _]| self.bytes(workload) / took / 1e6).collect()
    }

    fn bytes(&self, workload: &Workload) -> f64 {
        workload.bytes.len() as f64 * self.times as f64
    }

    fn print(&self, workload: &Workload) {
        let [[rate, ..], [ceiling, ..]] =
            [&self.ours, &self.ceiling].map(|rounds| spread(self.rates(workload, rounds)));
        let shares = self.ceiling.iter().zip(&self.ours).map(|(c, o)| c[0] / o[0] * 100.0).collect();
        let [share, least, largest] = spread(shares);
        let cost = |rounds: &[[f64; 2]]| {
            spread(rounds.iter().map(|[_, cost]| cost / self.bytes(workload) * 1e9).collect())[0]
        };
        println!(
            "{:<6}{:<14}{:>6}{rate:>8.0}{ceiling:>9.0}{share:>7.0}% {:<11}{:>8.1} {:<13} {:>6.2} {:>6.2}",
            self.road_name,
            workload.name,
            self.connections,
            format!("({least:.0} to {largest:.0})"),
            workload.units as f64 * rate * 1e6 / workload.bytes.len() as f64 / 1e6,
            workload.unit,
            cost(&self.ours),
            cost(&self.ceiling),
        );
    }
}

/// Measures one workload in all cases, and prints them and their ratios.
fn compare(workload: &Workload, cases: &mut [Case<'_>], rounds: usize) {
    for round in 0..rounds {
        for case in &mut *cases {
            case.round(workload, round % 2 == 0);
            case.round(workload, round % 2 != 0);
        }
    }
    cases.iter().for_each(|case| case.print(workload));
    let find =
        |name: &str, connections| cases.iter().find(|c| c.road_name == name && c.connections == connections);
    let Some(one) = find("tcp", 1) else { return };
    for (what, other) in [("64 connections", find("tcp", 64)), ("unix", find("unix", 1))] {
        let Some(other) = other else { continue };
        let (rates, others) = (one.rates(workload, &one.ours), other.rates(workload, &other.ours));
        let [ratio, least, largest] = spread(others.iter().zip(&rates).map(|(o, r)| o / r).collect());
        println!(
            "      {what} against one over tcp: {ratio:.2} ({least:.2} to {largest:.2}) of its bytes a second"
        );
    }
}

fn main() {
    let is_quick = std::env::args().any(|a| a == "--quick");
    let only = std::env::args().find_map(|a| a.strip_prefix("--only=").map(String::from)).unwrap_or_default();
    let (megabytes, rounds) = if is_quick { (200, 3) } else { (700, 7) };
    let mut roads = vec![("tcp", Road::Tcp, 1), ("tcp", Road::Tcp, 64)];
    if cfg!(unix) {
        let path = std::env::temp_dir().join(format!("fbptr-bench-{}", std::process::id()));
        roads.push(("unix", Road::Unix(path), 1));
    }
    let workloads = workloads();
    for workload in workloads.iter().filter(|_| only.is_empty()) {
        let took = from_memory(workload).as_secs_f64();
        let (rate, units) = (workload.bytes.len() as f64 / took / 1e6, workload.units as f64 / took / 1e6);
        println!("from memory {:<14}{rate:>8.0} MB/s {units:>9.1} {}", workload.name, workload.unit);
    }
    if std::env::args().any(|a| a == "--memory") {
        return;
    }
    println!(
        "{:<6}{:<14}{:>6}{:>8}{:>9}{:>8} {:<11}{:>22}   processor ns/byte, and the ceiling's",
        "road", "workload", "conns", "MB/s", "ceiling", "share", "", "rate"
    );
    for workload in &workloads {
        let mut cases: Vec<_> = roads
            .iter()
            .filter(|(name, _, connections)| {
                format!("{name} {} {connections}", workload.name).contains(&only)
            })
            .map(|(road_name, road, connections)| Case {
                road_name,
                road,
                connections: *connections,
                times: (megabytes * 1_000_000 / workload.bytes.len()).next_multiple_of(64),
                ours: Vec::new(),
                ceiling: Vec::new(),
            })
            .collect();
        compare(workload, &mut cases, rounds);
    }
    if !only.is_empty() {
        return;
    }
    let (median, longest) = longest_wait(&workloads[0]);
    println!("a SYNC beside 63 floods: median {median:?}, longest {longest:?}");
}
