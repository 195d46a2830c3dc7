//! Vectors spilled to memory, to read their lanes one by one.

/// Vector in memory. Compilers would leave it in its register and extract the lanes there, which
/// costs several times as much as loads if most of them are used.
#[repr(C, align(64))]
pub struct Spill<const N: usize>(pub [i32; N]);

impl<const N: usize> Spill<N> {
    /// Returns lane k, read as unsigned.
    ///
    /// # Panics
    /// If `k` is out of range.
    #[inline(always)]
    pub fn lane(&self, k: usize) -> usize {
        // SAFETY: the place is a reference's; volatile asks for no more than that it really is read.
        unsafe { std::ptr::read_volatile(&raw const self.0[k]) as u32 as usize }
    }

    /// Returns lanes 2 k and 2 k + 1, read as unsigned by one load: loads dominate the time of a
    /// gather.
    ///
    /// # Panics
    /// If `k` is out of range.
    #[cfg(any(test, feature = "avx"))]
    #[inline(always)]
    pub fn pair(&self, k: usize) -> [usize; 2] {
        let place: &[i32; 2] = self.0[2 * k..].first_chunk().expect("a pair of lanes");
        // SAFETY: the place is a reference's, so its eight bytes may be read, and pairs of a vector
        // aligned to 64 bytes are aligned to eight; volatile asks for no more than that they really
        // are read.
        let pair = unsafe { std::ptr::read_volatile(std::ptr::from_ref(place).cast::<u64>()) };
        let (low, high) = (pair as u32 as usize, (pair >> 32) as usize);
        if cfg!(target_endian = "big") { [high, low] } else { [low, high] }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lanes_are_read_as_they_are() {
        let numbers = [0, 1, -1, i32::MIN, i32::MAX, 7, 8, 9];
        let spill = Spill(numbers);
        for (k, pair) in numbers.as_chunks::<2>().0.iter().enumerate() {
            assert_eq!([2 * k, 2 * k + 1].map(|k| spill.lane(k)), spill.pair(k));
            assert_eq!(spill.pair(k), pair.map(|lane| lane as u32 as usize));
        }
    }
}
