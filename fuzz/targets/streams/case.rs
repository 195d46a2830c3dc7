//! A case: the streams of a few connections in the order in which their pieces reach the server, and how it is set up.

use super::dice::Dice;
use super::verbs::{self, Written};
use super::words::Taste;
use fbptr::pipeline::{CoarseDepth, RenderOptions};
use fbptr::server::Limits;
use fbptr::simd::Level;
use std::sync::OnceLock;

/// One connection, from its beginning to its end.
#[derive(Default)]
pub struct Life {
    /// All that it sends.
    pub stream: Vec<u8>,
    /// Where its commands begin, and what answers each.
    pub commands: Vec<(u64, Option<&'static str>)>,
    /// Whether its replies can be matched to its commands: it reports errors, and its commands are framed as they look.
    pub is_matched: bool,
    /// Whether its end is said; one that is reset just ends.
    pub is_finished: bool,
}

/// A run of bytes of one life.
pub struct Turn {
    pub life: usize,
    pub bytes: std::ops::Range<usize>,
}

/// See the module's text.
pub struct Case {
    pub size: [u32; 2],
    pub limits: Limits,
    pub lives: Vec<Life>,
    pub turns: Vec<Turn>,
    /// How it is cut the second time: pieces of at most so many bytes.
    pub pieces: usize,
    pub options: [RenderOptions; 2],
    /// Whether what LOAD reads names files of its own, which a recording does not hold.
    pub reads_more: bool,
}

/// So many commands at most.
const MAX_COMMANDS: usize = 60;

impl Case {
    /// What an input stands for.
    pub fn new(input: &[u8]) -> Case {
        let dice = &mut Dice::new(input);
        let size = [[1, 1], [16, 8], [33, 17], [40, 20], [64, 48], [97, 61]][dice.below(6)];
        let taste = Taste { extreme: [3, 6, 12, 60][dice.below(4)], junk: [50, 200, 1000][dice.below(3)] };
        let limits = limits(dice);
        let options = [options(dice), options(dice)];
        let pieces = [1, 2, 7, 61, 400, usize::MAX][dice.below(6)];
        let connections = 1 + dice.below(3);
        let mut case =
            Case { size, limits, lives: Vec::new(), turns: Vec::new(), pieces, options, reads_more: false };
        let mut current: Vec<usize> = (0..connections).map(|_| case.begin(dice, taste)).collect();
        for tag in 0..5 + dice.below(MAX_COMMANDS - 5) {
            let connection = dice.below(connections);
            let life = current[connection];
            match dice.below(40) {
                0 => {
                    // A reset, or an orderly end, in the midst of a command perhaps.
                    let written = verbs::any(dice, taste);
                    let cut = dice.below(written.bytes.len() + 1);
                    case.write(life, Written { bytes: written.bytes[..cut].to_vec(), reply: None });
                    case.lives[life].is_finished = dice.below(2) == 0;
                    case.turns.push(Turn { life, bytes: 0..0 });
                    current[connection] = case.begin(dice, taste);
                }
                1 if !case.lives[life].is_matched => case.write_noise(life, dice),
                2..6 => {
                    let bytes = format!("SYNC s{tag}\n").into_bytes();
                    case.write(life, Written { bytes, reply: Some("SYNC") });
                }
                _ => case.write(life, verbs::any(dice, taste)),
            }
        }
        case
    }

    /// A new life.
    fn begin(&mut self, dice: &mut Dice, taste: Taste) -> usize {
        let is_matched = dice.below(4) > 0;
        self.lives.push(Life { is_matched, is_finished: true, ..Life::default() });
        let life = self.lives.len() - 1;
        let how = if is_matched { "report" } else { ["count", "close", "report"][dice.below(3)] };
        if is_matched || dice.below(2) == 0 {
            self.write(life, Written { bytes: format!("ERRORS {how}\n").into_bytes(), reply: None });
        }
        if dice.below(2) == 0 {
            for written in verbs::setting(dice, taste) {
                self.write(life, written);
            }
        }
        life
    }

    fn write(&mut self, life: usize, written: Written) {
        let this = &mut self.lives[life];
        let from = this.stream.len();
        this.commands.push((from as u64, written.reply));
        this.stream.extend_from_slice(&written.bytes);
        let text = String::from_utf8_lossy(&written.bytes).to_uppercase();
        let names_files = ["INLINE.X3D", "LOOP.X3D", "TEXTURED.X3D"].iter().any(|name| text.contains(name));
        self.reads_more |= names_files;
        self.turns.push(Turn { life, bytes: from..self.lives[life].stream.len() });
    }

    /// Bytes of any kind, which may swallow what follows.
    fn write_noise(&mut self, life: usize, dice: &mut Dice) {
        let seed = dice.bits();
        let mut bytes: Vec<u8> =
            (0..dice.below(30) as u64).map(|i| (seed.wrapping_mul(2 * i + 3) >> 40) as u8).collect();
        match dice.below(4) {
            0 => bytes.extend(b":7\n"),
            1 => bytes.extend(format!("X :{}\n", dice.below(90)).bytes()),
            2 => bytes.extend([b'a'].repeat(dice.below(5000))),
            _ => bytes.push(b'\n'),
        }
        self.write(life, Written { bytes, reply: None });
    }

    /// The whole case as text, for whoever looks into a failure.
    pub fn told(&self) -> String {
        use std::fmt::Write;
        let mut out = format!("# {}x{}, {:?}\n", self.size[0], self.size[1], self.limits);
        writeln!(out, "# second time: pieces of {}, {:?}", self.pieces, self.options[1].simd)
            .expect("a String takes all");
        for turn in &self.turns {
            let life = &self.lives[turn.life];
            match turn.bytes.is_empty() {
                true => writeln!(out, "# connection {} ends", turn.life).expect("a String takes all"),
                false => {
                    let bytes = life.stream[turn.bytes.clone()].escape_ascii();
                    writeln!(out, "{}: {bytes}", turn.life).expect("a String takes all");
                }
            }
        }
        out
    }
}

/// Small limits, so that they are met.
fn limits(dice: &mut Dice) -> Limits {
    let tight = dice.once_in(4);
    let of = |dice: &mut Dice, few: u64, many: u64| if tight && dice.below(2) == 0 { few } else { many };
    Limits {
        payload_bytes: of(dice, 200, 100_000),
        names: of(dice, 1, 4096) as usize,
        resource_bytes: of(dice, 3000, 8 << 20),
        reply_bytes: of(dice, 300, 1 << 20) as usize,
        matrix_stack: of(dice, 1, 20) as usize,
        lights: of(dice, 1, 256) as usize,
        ..Limits::default()
    }
}

/// Threads, vectors, hidden faces left out or not: the bytes are the same.
fn options(dice: &mut Dice) -> RenderOptions {
    static THREADS: OnceLock<RenderOptions> = OnceLock::new();
    let threads = THREADS.get_or_init(|| RenderOptions {
        pool: fbptr::server::worker_pool(Some(2)),
        ..RenderOptions::default()
    });
    let level = Level::ALL[dice.below(3)];
    RenderOptions {
        pool: threads.pool.clone().filter(|_| dice.below(2) == 0),
        simd: level.is_available().then_some(level),
        coarse: if dice.below(3) == 0 { CoarseDepth::On } else { CoarseDepth::Off },
        ..RenderOptions::default()
    }
}
