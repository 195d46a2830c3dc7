//! Detection of the CPU's vector width, and dispatch of kernels.
//!
//! With `--cfg narrow_vectors` kernels are compiled for four lanes alone: the same bytes, in a quarter of
//! the time that compiling takes. For builds that test other things than kernels.

use super::Simd;
#[cfg(all(target_arch = "x86_64", any(test, feature = "avx"), not(narrow_vectors)))]
use super::{avx2::RunAvx2, avx512::RunAvx512};
use std::sync::OnceLock;

/// Code over any [`Simd`]. Mark `run` `#[inline(always)]`, so that it is compiled for each level.
pub trait Kernel {
    /// Result of [`run`](Kernel::run).
    type Output;
    /// Runs the kernel with the token of a level.
    fn run<S: Simd>(self, s: S) -> Self::Output;
}

/// Kernel that takes the compiler long, so that each of its levels is compiled in a unit of code of its
/// own, beside the others; [`long_kernel`] implements it.
///
/// The compiler puts a function into the unit of the module of its type. So a kernel is entered by
/// methods of its own type, and an edit of one kernel compiles no other; one of these by methods of a
/// type for each level, in a module of its own.
pub(crate) trait LongKernel: Kernel {
    /// Type of the unit of 4 lanes.
    type Portable;
    /// Type of AVX2's unit.
    type Avx2;
    /// Type of the unit of pairs of AVX2's vectors.
    type Paired;
    /// Type of AVX-512's unit.
    type Avx512;
}

/// Implements [`LongKernel`] for a kernel, by modules beside it.
macro_rules! long_kernel {
    ($kernel:ty) => {
        mod portable {
            pub enum Unit {}
        }
        mod avx2 {
            pub enum Unit {}
        }
        mod paired {
            pub enum Unit {}
        }
        mod avx512 {
            pub enum Unit {}
        }
        impl $crate::simd::LongKernel for $kernel {
            type Portable = portable::Unit;
            type Avx2 = avx2::Unit;
            type Paired = paired::Unit;
            type Avx512 = avx512::Unit;
        }
    };
}
pub(crate) use long_kernel;

/// The entry of a kernel at a level that every CPU of the target has.
trait Run {
    /// Runs the kernel, in the unit of code of this type.
    #[inline(never)]
    fn run<K: Kernel, S: Simd>(kernel: K, s: S) -> K::Output {
        kernel.run(s)
    }
}

impl<U> Run for U {}

/// Vector width of a kernel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Level {
    /// 4 lanes, available everywhere: SSE2 on x86-64, WebAssembly's vectors where a module is built
    /// with them, elsewhere arrays.
    Portable,
    /// 4 lanes (little-endian AArch64 with NEON, which nearly all of them have).
    Neon,
    /// 8 lanes (x86-64 with AVX2, BMI1, BMI2, LZCNT, POPCNT; compiled by the feature `avx`).
    Avx2,
    /// 16 lanes (x86-64 with AVX-512 F, BW, DQ, VL, CD; compiled by the feature `avx`).
    Avx512,
}

impl Level {
    /// Every level, from narrow to wide.
    pub const ALL: [Level; 4] = [Level::Portable, Level::Neon, Level::Avx2, Level::Avx512];

    /// Returns the widest available level; detected once.
    pub fn best() -> Level {
        static BEST: OnceLock<Level> = OnceLock::new();
        *BEST.get_or_init(|| {
            Self::ALL.into_iter().rev().find(|l| l.is_available()).expect("portable is always available")
        })
    }

    /// Returns whether this CPU can run the level, and it is compiled.
    pub fn is_available(self) -> bool {
        match self {
            Level::Portable => true,
            #[cfg(all(target_arch = "x86_64", any(test, feature = "avx"), not(narrow_vectors)))]
            Level::Avx2 => {
                std::is_x86_feature_detected!("avx2")
                    && std::is_x86_feature_detected!("bmi1")
                    && std::is_x86_feature_detected!("bmi2")
                    && std::is_x86_feature_detected!("lzcnt")
                    && std::is_x86_feature_detected!("popcnt")
            }
            #[cfg(all(target_arch = "x86_64", any(test, feature = "avx"), not(narrow_vectors)))]
            Level::Avx512 => {
                std::is_x86_feature_detected!("avx512f")
                    && std::is_x86_feature_detected!("avx512bw")
                    && std::is_x86_feature_detected!("avx512dq")
                    && std::is_x86_feature_detected!("avx512vl")
                    && std::is_x86_feature_detected!("avx512cd")
            }
            // Part of the target, not detected.
            Level::Neon => HAS_NEON,
            #[cfg(not(all(target_arch = "x86_64", any(test, feature = "avx"), not(narrow_vectors))))]
            Level::Avx2 | Level::Avx512 => false,
        }
    }

    /// Returns the level's name on the command line.
    pub const fn as_str(self) -> &'static str {
        match self {
            Level::Portable => "portable",
            Level::Neon => "neon",
            Level::Avx2 => "avx2",
            Level::Avx512 => "avx512",
        }
    }

    /// Returns the level with a command-line name, in any case of letters.
    pub fn from_name(name: &str) -> Option<Level> {
        Self::ALL.into_iter().find(|l| l.as_str().eq_ignore_ascii_case(name))
    }

    /// Runs `kernel` at this level, or at the widest available level below it.
    #[inline]
    pub fn dispatch<K: Kernel>(self, kernel: K) -> K::Output {
        self.dispatch_in::<K, K, K, K>(kernel)
    }

    /// Runs a kernel in vectors of four lanes, whatever the CPU has: one that is not worth the code
    /// of several levels.
    #[inline]
    pub(crate) fn in_four_lanes<K: Kernel>(kernel: K) -> K::Output {
        kernel.run(PORTABLE)
    }

    /// Runs a kernel of long chains of dependent operations: as [`dispatch`](Level::dispatch) does,
    /// but over pairs of vectors where they have 8 lanes and pairs are faster.
    #[inline]
    pub(crate) fn dispatch_long<K: LongKernel>(self, kernel: K) -> K::Output {
        #[cfg(all(target_arch = "x86_64", any(test, feature = "avx"), not(narrow_vectors)))]
        if self.min(Level::best()) == Level::Avx2 && super::avx2::pairs_are_faster() {
            // SAFETY: `best` found the CPU to have every feature that the function names.
            return unsafe { K::Paired::run_paired(kernel) };
        }
        self.dispatch_in::<K, K::Portable, K::Avx2, K::Avx512>(kernel)
    }

    /// Runs `kernel` by the entries of a type for each level.
    #[inline]
    #[cfg_attr(
        not(all(target_arch = "x86_64", any(test, feature = "avx"), not(narrow_vectors))),
        allow(clippy::extra_unused_type_parameters, reason = "there is one level alone")
    )]
    fn dispatch_in<K: Kernel, Portable, Avx2, Avx512>(self, kernel: K) -> K::Output {
        #[cfg(all(target_arch = "x86_64", any(test, feature = "avx"), not(narrow_vectors)))]
        {
            let level = self.min(Level::best());
            if level == Level::Avx512 {
                // SAFETY: `best` found the CPU to have every feature that the function names.
                return unsafe { Avx512::run_avx512(kernel) };
            }
            if level == Level::Avx2 {
                // SAFETY: `best` found the CPU to have every feature that the function names.
                return unsafe { Avx2::run_avx2(kernel) };
            }
        }
        #[cfg(all(target_arch = "aarch64", target_feature = "neon", target_endian = "little"))]
        if self >= Level::Neon {
            return <Portable as Run>::run(kernel, super::neon::Neon);
        }
        <Portable as Run>::run(kernel, PORTABLE)
    }
}

/// Token of the level [`Level::Portable`].
#[cfg(target_arch = "x86_64")]
const PORTABLE: super::sse2::Sse2 = super::sse2::Sse2;
#[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
const PORTABLE: super::wasm::Simd128 = super::wasm::Simd128;
#[cfg(not(any(target_arch = "x86_64", all(target_arch = "wasm32", target_feature = "simd128"))))]
const PORTABLE: super::Portable<4> = super::Portable;

/// True where the level NEON is compiled.
const HAS_NEON: bool = cfg!(all(target_arch = "aarch64", target_feature = "neon", target_endian = "little"));

#[cfg(test)]
mod tests {
    use super::super::{Part, Portable, pair::Paired};
    use super::*;

    /// The squares of the lanes' numbers, by a part of the kernel.
    struct Squares;

    impl Kernel for Squares {
        type Output = Vec<i32>;
        #[inline(always)]
        fn run<S: Simd>(self, s: S) -> Vec<i32> {
            s.call(s, self)
        }
    }

    impl<S: Simd> Part<S> for Squares {
        type Output = Vec<i32>;
        #[inline(always)]
        fn run(self, s: S) -> Vec<i32> {
            let mut squares = vec![0; S::LANES];
            s.store_i(s.iota() * s.iota(), &mut squares);
            squares
        }
    }

    #[test]
    fn a_part_has_its_kernels_vectors() {
        let truth = Kernel::run(Squares, Portable::<16>);
        assert_eq!(truth[15], 225);
        assert_eq!(Kernel::run(Squares, Paired(Portable::<8>)), truth);
        for level in Level::ALL {
            let squares = level.dispatch(Squares);
            assert_eq!(squares, truth[..squares.len()], "{level:?}");
        }
    }
}
