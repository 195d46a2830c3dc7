//! Fears about the decoder: that a cut loses a command, that an error puts the stream out of step, that a malformed
//! command does something, that a verb is read otherwise than written down.

mod cuts;
mod dictionary;
mod framing;
mod light_colors;
mod naive;
mod page;
mod recorder;
mod roundtrip;
mod typed;
mod verbs;
