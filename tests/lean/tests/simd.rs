//! The unit tests of the crate's vectors alone, for processors that the rest of its tests is not
//! built for: each operation of each level that the processor has, against plain arrays.
#![allow(dead_code, unused_imports, reason = "only the tests are used")]

#[path = "../../../src/simd/mod.rs"]
mod simd;
