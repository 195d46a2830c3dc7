//! The programs as their users run them, and the pages that those read: commands, demos, movies, the report, the docs.

mod demos;
mod docs;
mod layers;
mod movie;
mod play;
mod report;
