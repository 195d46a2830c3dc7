//! The N-dimensional eye: worked cases, hard ones, a truth in rational numbers, what must not change a picture, its commands.

mod cases;
mod command_line;
mod definitions;
mod exact;
mod hard;
mod metamorphic;
