//! Derives choices from an input's bytes, and from a generator seeded by the input when they run
//! out.
//!
//! An input of a few bytes already determines long streams, and each byte that the engine changes
//! changes one choice.

/// The choices of one input, in order.
pub struct DataProvider<'a> {
    bytes: &'a [u8],
    state: u64,
}

impl<'a> DataProvider<'a> {
    /// Starts with the first four bytes as the generator's seed; the rest are choices.
    pub fn new(input: &'a [u8]) -> Self {
        let (seed, bytes) = input.split_at(input.len().min(4));
        let state = seed
            .iter()
            .fold(0x9e37_79b9_7f4a_7c15, |s: u64, &b| (s ^ u64::from(b)).wrapping_mul(0x100_0000_01b3));
        DataProvider { bytes, state }
    }

    fn byte(&mut self) -> u8 {
        if let Some((&first, rest)) = self.bytes.split_first() {
            self.bytes = rest;
            return first;
        }
        // xorshift64*, Vigna 2016.
        self.state ^= self.state >> 12;
        self.state ^= self.state << 25;
        self.state ^= self.state >> 27;
        (self.state.wrapping_mul(0x2545_f491_4f6c_dd1d) >> 56) as u8
    }

    /// Returns a number below `n`, which is at most 65,536.
    pub fn below(&mut self, n: usize) -> usize {
        match n {
            0 | 1 => 0,
            2..=256 => usize::from(self.byte()) * n >> 8,
            _ => (usize::from(self.byte()) << 8 | usize::from(self.byte())) * n >> 16,
        }
    }

    /// Returns true in one of `n` cases on average.
    pub fn once_in(&mut self, n: usize) -> bool {
        self.below(n) == n - 1
    }

    /// Returns an element of a list.
    pub fn of<'b, T: ?Sized>(&mut self, list: &[&'b T]) -> &'b T {
        list[self.below(list.len())]
    }

    /// Returns 64 bits.
    pub fn bits(&mut self) -> u64 {
        u64::from_le_bytes(std::array::from_fn(|_| self.byte()))
    }
}
