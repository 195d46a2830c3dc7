//! Lanes that are needed one by one.

/// A vector of places in memory, from where they are read. Compilers would keep it in its register and take the lanes out of
/// there, which costs several times as much as a load where most of them are wanted.
#[repr(C, align(64))]
pub struct Spill<const N: usize>(pub [i32; N]);

impl<const N: usize> Spill<N> {
    /// Lanes 2 k and 2 k + 1, read as unsigned by one load: loads are what a gather's time goes to.
    ///
    /// # Panics
    /// When there are none.
    #[inline(always)]
    pub fn pair(&self, k: usize) -> [usize; 2] {
        let place: &[i32; 2] = self.0[2 * k..].first_chunk().expect("a pair of lanes");
        // SAFETY: the place is a reference's, so its eight bytes may be read, and pairs of a vector aligned to 64 bytes are
        // aligned to eight; volatile asks for no more than that they really are read.
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
            assert_eq!(spill.pair(k), pair.map(|lane| lane as u32 as usize));
        }
    }
}
