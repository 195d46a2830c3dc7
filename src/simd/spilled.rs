//! Lanes that are needed one by one.

/// A vector of places in memory, from where each is read by itself. Compilers would keep it in its register and take the lanes
/// out of there, which costs several times as much as a load where most of them are wanted.
pub struct Spilled<const N: usize>(pub [i32; N]);

impl<const N: usize> Spilled<N> {
    /// A lane, read as unsigned.
    #[inline(always)]
    pub fn lane(&self, lane: usize) -> usize {
        // SAFETY: the place is a reference's, so it may be read; volatile asks for no more than that it really is.
        unsafe { std::ptr::read_volatile(&self.0[lane]) as u32 as usize }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lanes_are_read_as_they_are() {
        let numbers = [0, 1, -1, i32::MIN, i32::MAX, 7, 8, 9];
        let spilled = Spilled(numbers);
        for (lane, number) in numbers.into_iter().enumerate() {
            assert_eq!(spilled.lane(lane), number as u32 as usize);
        }
    }
}
