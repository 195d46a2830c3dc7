//! `fbptr snap`: a picture of a running server's memory, over the network.

use super::args::address;
use super::send::Wire;
use super::{Status, check_folder, say_as_program};
use crate::memory::VideoMemory;
use crate::save::{self, SnapshotFormat};
use clap::Args;
use std::io::{self, BufRead, BufReader, Read, Write};
use std::path::{Path, PathBuf};

/// Take a picture of a running server.
#[derive(Debug, Args)]
pub struct Snap {
    /// The server: HOST:PORT, :PORT, or the path of a Unix socket
    #[arg(value_name = "ADDR")]
    address: String,
    /// The picture: .png, .ppm or .raw
    #[arg(value_name = "OUT")]
    out: PathBuf,
}

impl Snap {
    /// Requests the picture and writes it.
    pub(super) fn run(self) -> Status {
        let place = Path::new(&self.address);
        if SnapshotFormat::of_path(place).is_ok() && (place.is_file() || !place.exists()) {
            let (address, out) = (&self.address, self.out.display());
            say_as_program(format_args!(
                "the server stands before the picture: `fbptr snap {out} {address}`"
            ));
            return Status::BadArguments;
        }
        let checked = address::target(&self.address).and_then(|target| {
            check_folder(&self.out)?;
            SnapshotFormat::of_path(&self.out).map(|f| (target, f)).map_err(|e| e.to_string())
        });
        let (target, format) = match checked {
            Ok(checked) => checked,
            Err(message) => {
                say_as_program(message);
                return Status::BadArguments;
            }
        };
        let taken = match Wire::connect(&target) {
            Ok(wire) => ask(wire).map_err(|e| format!("{}: {e}", self.address)),
            Err(e) => Err(address::no_server(&self.address, &e)),
        };
        let written = taken.and_then(|memory| {
            save::atomically(&self.out, |out| format.write(&memory, out)).map_err(|e| e.to_string())
        });
        match written {
            Ok(()) => Status::Success,
            Err(message) => {
                say_as_program(message);
                Status::Failed
            }
        }
    }
}

/// Reads the server's memory over its connection: first its size, then all rows.
fn ask(mut wire: Wire) -> Result<VideoMemory, String> {
    let broken = |e: io::Error| format!("the connection broke: {e}");
    wire.write_all(b"HELLO\n").map_err(broken)?;
    let mut replies = BufReader::new(wire);
    let mut line = String::new();
    replies.by_ref().take(1000).read_line(&mut line).map_err(broken)?;
    let words: Vec<&str> = line.split_whitespace().collect();
    let ["HELLO", "fbptr", _, width, height, ..] = words[..] else {
        return Err(format!("expected a fbptr server, found {:?}", line.trim_end()));
    };
    let number = |text: &str| text.parse::<u32>().map_err(|_| format!("{text:?} is no size"));
    let (width, height) = (number(width)?, number(height)?);
    let mut memory = VideoMemory::new(width, height).map_err(|e| e.to_string())?;
    // In one reply all rows are of the same moment.
    replies.get_mut().write_all(format!("READ 0 0 {width} {height}\nQUIT\n").as_bytes()).map_err(broken)?;
    line.clear();
    replies.by_ref().take(1000).read_line(&mut line).map_err(broken)?;
    let bytes = memory.bytes().len();
    if line.trim_end() != format!("READ 0 0 {width} {height} :{bytes}") {
        return Err(format!("expected its pixels, found {:?}", line.trim_end()));
    }
    replies.read_exact(memory.bytes_mut()).map_err(broken)?;
    Ok(memory)
}
