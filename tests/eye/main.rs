//! Tests of the N-dimensional eye: worked cases, hard cases, a reference in rational numbers,
//! changes of a scene that must not change its picture, and the command line.

mod cases;
mod command_line;
mod definitions;
mod exact;
mod hard;
mod metamorphic;
