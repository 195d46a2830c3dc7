//! The numbers of words that a verb takes.

/// Numbers of words that a verb takes after its name, `:N` not counted.
///
/// Bit n stands for n words, bit 31 for 31 words or more.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Arity(u32);

impl Arity {
    /// No number of words.
    pub(super) const NEVER: Arity = Arity(0);
    /// No words.
    pub(super) const ZERO: Arity = Arity(1);
    /// One word.
    pub(super) const ONE: Arity = Arity(1 << 1);

    /// Exactly this many words.
    pub(super) const fn exactly(count: usize) -> Arity {
        Arity(1 << count)
    }

    /// This many words or more.
    pub(super) const fn at_least(count: usize) -> Arity {
        Arity(u32::MAX << count)
    }

    /// The numbers of words of either.
    pub(super) const fn or(self, other: Arity) -> Arity {
        Arity(self.0 | other.0)
    }

    /// The numbers of words of both, one after the other.
    pub(super) const fn plus(self, other: Arity) -> Arity {
        let (mut sum, mut count) = (0, 0);
        while count < 32 {
            if self.0 >> count & 1 == 1 {
                sum |= other.0 << count;
            }
            count += 1;
        }
        Arity(sum)
    }

    /// The numbers of words of `count` arguments of this kind.
    pub(super) const fn times(self, count: usize) -> Arity {
        let (mut sum, mut n) = (Arity::ZERO, 0);
        while n < count {
            sum = sum.plus(self);
            n += 1;
        }
        sum
    }

    /// Returns whether a line may have `count` words after its verb.
    pub const fn allows(self, count: usize) -> bool {
        let bit = if count < 31 { count } else { 31 };
        self.0 >> bit & 1 == 1
    }

    /// Returns the least number of words.
    pub const fn least(self) -> usize {
        self.0.trailing_zeros() as usize
    }

    /// Returns the greatest number of words, or `None` if there is no limit but the line's.
    pub const fn most(self) -> Option<usize> {
        match self.0.leading_zeros() {
            0 => None,
            32 => Some(0),
            zeros => Some(31 - zeros as usize),
        }
    }

    /// Returns the numbers in words, as in `takes 5 or 6 arguments`.
    pub(super) fn in_words(self) -> String {
        let numbers = match (self.least(), self.most()) {
            (least, None) => format!("{least} or more"),
            (_, Some(0)) => return "no arguments".to_owned(),
            (1, Some(1)) => return "1 argument".to_owned(),
            (least, Some(most)) => {
                let counts = (least..=most).filter(|n| self.allows(*n));
                counts.map(|n| n.to_string()).collect::<Vec<_>>().join(" or ")
            }
        };
        format!("{numbers} arguments")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arguments_one_after_the_other_take_the_sums_of_their_words() {
        let optional = Arity::ZERO.or(Arity::exactly(4));
        let both = Arity::exactly(2).plus(optional).plus(Arity::ZERO.or(Arity::ONE));
        let taken: Vec<usize> = (0..40).filter(|n| both.allows(*n)).collect();
        assert_eq!(taken, [2, 3, 6, 7]);
        assert_eq!((both.least(), both.most()), (2, Some(7)));
        assert_eq!(both.in_words(), "2 or 3 or 6 or 7 arguments");
        assert_eq!(Arity::ONE.times(16).most(), Some(16));
        assert_eq!((Arity::NEVER.most(), Arity::NEVER.allows(0)), (Some(0), false));
    }

    #[test]
    fn an_open_end_stays_open() {
        let open = Arity::ONE.plus(Arity::at_least(2));
        assert_eq!((open.least(), open.most()), (3, None));
        assert!(!open.allows(2) && [3, 30, 31, 32, 2000].iter().all(|n| open.allows(*n)));
        assert_eq!(open.in_words(), "3 or more arguments");
    }
}
