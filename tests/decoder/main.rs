//! Tests of the decoder. Verified: a cut loses no command, an error leaves the stream in step, a
//! malformed command does nothing, and each verb is read as documented.

mod c_client;
mod cuts;
mod dictionary;
mod framing;
mod generated;
mod light_colors;
mod naive;
mod page;
mod python;
mod recorder;
mod roundtrip;
mod table_lines;
mod typed;
mod valid_forms;
mod verbs;
