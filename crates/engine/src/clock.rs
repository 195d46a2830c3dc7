//! The monotonic clock by which budgets and commands are timed.
//!
//! Out: [`Instant`]. It is that of the standard library, except in WebAssembly without a system,
//! where there is no clock: time then stands still, so that no budget ends, and no command is given
//! up.

#[cfg(not(all(target_family = "wasm", target_os = "unknown")))]
pub use std::time::Instant;

#[cfg(all(target_family = "wasm", target_os = "unknown"))]
pub use stopped::Instant;

#[cfg(any(test, all(target_family = "wasm", target_os = "unknown")))]
mod stopped {
    use std::ops::Add;
    use std::time::Duration;

    /// A time after the start of a clock that stands still.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
    pub struct Instant(Duration);

    impl Instant {
        /// Returns the start.
        pub fn now() -> Self {
            Instant(Duration::ZERO)
        }

        /// Returns the time since an earlier one; zero if it is later.
        pub fn duration_since(&self, earlier: Instant) -> Duration {
            self.0.saturating_sub(earlier.0)
        }
    }

    impl Add<Duration> for Instant {
        type Output = Instant;

        /// Returns a later time. The greatest one is not exceeded.
        fn add(self, duration: Duration) -> Instant {
            Instant(self.0.saturating_add(duration))
        }
    }

    #[cfg(test)]
    mod tests {
        use super::*;

        #[test]
        fn no_time_passes_and_sums_do_not_overflow() {
            let start = Instant::now();
            let later = start + Duration::from_secs(1);
            assert!(Instant::now() == start && later > start);
            assert!(later + Duration::MAX > later);
            assert_eq!(later.duration_since(start), Duration::from_secs(1));
            assert_eq!(start.duration_since(later), Duration::ZERO);
        }
    }
}
