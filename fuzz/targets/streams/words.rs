//! Writes the words of commands: numbers, colours, names; most of them valid, some extreme, some
//! invalid.

use super::data::DataProvider;

/// Frequency of extreme and invalid words in a case.
#[derive(Clone, Copy, Debug)]
pub struct Extremes {
    /// One real number in this many is extreme.
    pub real: usize,
    /// One word in this many is invalid.
    pub junk: usize,
}

const REALS: [&str; 32] = [
    "1e308",
    "-1e308",
    "1.7976931348623157e308",
    "-1.7976931348623157e308",
    "5e-324",
    "-5e-324",
    "-0",
    "1e300",
    "-1e300",
    "1e299",
    "1e154",
    "-1e154",
    "1e17",
    "-1e17",
    "1e15",
    "1e-300",
    "2.2250738585072014e-308",
    "4294967296",
    "2147483648",
    "-2147483649",
    "1e9",
    "-1e9",
    "16777217",
    "3.4028236e38",
    "1e-45",
    "1e-9",
    "562949953421312",
    "-1e39",
    "1e200",
    "1e-160",
    "9007199254740993",
    "0.49999999999999994",
];
const WHOLES: [&str; 14] = [
    "2147483647",
    "-2147483648",
    "-1",
    "65535",
    "65536",
    "32767",
    "1073741824",
    "-1073741824",
    "100000",
    "-100000",
    "8192",
    "2147483600",
    "-2147483600",
    "16384",
];
const JUNK: [&str; 16] = [
    "nan",
    "inf",
    "1e999",
    "",
    "0x10",
    "1e",
    "--1",
    "\u{e9}",
    "\"",
    "2147483648",
    ":",
    "99999999999999999999",
    "1,5",
    "-",
    "+",
    "1e-999999999",
];
const COLORS: [&str; 18] = [
    "#f80",
    "#ff800080",
    "ff0000",
    "00ff00",
    "0000ff",
    "ffffff",
    "000000",
    "ff000080",
    "00ff0001",
    "ffffff00",
    "80",
    "tomato",
    "transparent",
    "01010101",
    "7f7f7f7f",
    "fefefe",
    "RebeccaPurple",
    "12345678",
];
pub const MESHES: [&str; 4] = ["m", "n", "@m", "o"];
pub const TEXTURES: [&str; 3] = ["t", "@t", "u"];
pub const EYES: [&str; 2] = ["e", "@e"];
pub const CANVASES: [&str; 3] = ["c", "d", "m"];

/// Writer of the words of one command.
pub struct Words<'d, 'i> {
    pub data: &'d mut DataProvider<'i>,
    pub extremes: Extremes,
    pub line: String,
}

impl Words<'_, '_> {
    /// Appends a word unchanged.
    pub fn word(&mut self, word: &str) -> &mut Self {
        self.line.push(' ');
        self.line += word;
        self
    }

    fn junk(&mut self) -> bool {
        if self.data.once_in(self.extremes.junk) {
            let word = JUNK[self.data.below(JUNK.len())];
            self.word(word);
            return true;
        }
        false
    }

    /// Appends an integer: near the size of a small frame, or at a limit.
    pub fn whole(&mut self) -> &mut Self {
        if self.junk() {
            return self;
        }
        let word = match self.data.below(self.extremes.real) {
            0 => WHOLES[self.data.below(WHOLES.len())].to_owned(),
            _ => (self.data.below(80) as i32 - 8).to_string(),
        };
        self.word(&word)
    }

    /// Appends an integer in 0..n, or an extreme one.
    pub fn small(&mut self, n: usize) -> &mut Self {
        if self.data.once_in(self.extremes.real * 4) {
            return self.whole();
        }
        let word = self.data.below(n).to_string();
        self.word(&word)
    }

    /// Appends a real number near `middle`, at most `reach` off, or an extreme one.
    pub fn real(&mut self, middle: f64, reach: f64) -> &mut Self {
        if self.junk() {
            return self;
        }
        let word = match self.data.below(self.extremes.real) {
            0 => self.extreme(),
            // Integers and halves meet edges and ties.
            1..3 => {
                format!("{}", middle + ((self.data.below(9) as f64 - 4.0) / 4.0 * reach * 2.0).round() / 2.0)
            }
            _ => format!("{}", middle + (self.data.below(4096) as f64 / 2048.0 - 1.0) * reach),
        };
        self.word(&word)
    }

    fn extreme(&mut self) -> String {
        match self.data.below(5) {
            0 => {
                let any = f64::from_bits(self.data.bits());
                if any.is_finite() { format!("{any:e}") } else { "1e308".to_owned() }
            }
            1 => format!("{}e{}", self.data.below(19) as i32 - 9, self.data.below(620) as i32 - 310),
            _ => REALS[self.data.below(REALS.len())].to_owned(),
        }
    }

    /// Appends `n` real numbers.
    pub fn reals(&mut self, n: usize, middle: f64, reach: f64) -> &mut Self {
        for _ in 0..n {
            self.real(middle, reach);
        }
        self
    }

    /// Appends `n` integers.
    pub fn wholes(&mut self, n: usize) -> &mut Self {
        for _ in 0..n {
            self.whole();
        }
        self
    }

    /// Appends a colour.
    pub fn color(&mut self) -> &mut Self {
        if self.junk() {
            return self;
        }
        let word = COLORS[self.data.below(COLORS.len())];
        self.word(word)
    }

    /// Appends a word of a list, or sometimes an invalid one.
    pub fn one_of(&mut self, list: &[&str]) -> &mut Self {
        if self.junk() {
            return self;
        }
        let word = self.data.of(list);
        self.word(word)
    }

    /// Calls `write` in half of the cases.
    pub fn maybe(&mut self, write: impl FnOnce(&mut Self) -> &mut Self) -> &mut Self {
        if self.data.below(2) == 1 { write(self) } else { self }
    }
}
