//! The `fbptr` program.
fn main() {}
