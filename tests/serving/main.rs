//! A server that other programs can trust: over real sockets, as its clients see it.

mod crowd;
mod display;
mod process;
mod protocol;
mod quotas;
mod support;
mod trust;
