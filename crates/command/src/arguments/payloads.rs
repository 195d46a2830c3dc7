//! The bytes that follow a line or a header, and bytes in hex.

use super::keywords::take_keyword;
use super::{Argument, TextArgument};
use crate::args::{Args, ParseError};
use crate::commands::{Command, Rect};
use crate::encode::{EncodeError, LineWriter};
use crate::verb::{Arity, ParameterKind, Payload};
use fbptr_core::error::{Code, Fault};
use fbptr_core::memory::read_hex;

/// Returns the fault of a payload whose length is another one.
fn wrong_length(expected: impl Into<String>, length: u64) -> Result<(), Fault> {
    Err(Fault::new(Code::Format, expected).got(format!(":{length}")))
}

/// Defines a payload of a line. `$check` are the checks beyond those of any payload.
macro_rules! payload {
    ($(#[$doc:meta])* $name:ident { $($check:tt)* }) => {
        $(#[$doc])*
        pub struct $name;

        impl Argument for $name {
            type Value = Vec<u8>;
            const KIND: ParameterKind = ParameterKind::Payload;
            const PAYLOAD: Payload = Payload::Always;

            $($check)*

            fn payload(bytes: &Vec<u8>) -> Option<&[u8]> {
                Some(bytes)
            }

            fn payload_mut(bytes: &mut Vec<u8>) -> Option<&mut Vec<u8>> {
                Some(bytes)
            }

            fn write(_: &Vec<u8>, _: &mut LineWriter<'_>) -> Result<(), EncodeError> {
                Ok(())
            }
        }

        impl TextArgument for $name {
            fn read(_: &mut Args<'_>) -> Result<Vec<u8>, ParseError> {
                Ok(Vec::new())
            }
        }
    };
}

payload! {
    /// Any bytes.
    Bytes {}
}
payload! {
    /// Packed pixels of eight bytes each.
    Records {
        fn check_length(_: &Vec<u8>, length: u64) -> Result<(), Fault> {
            match length.is_multiple_of(8) {
                true => Ok(()),
                false => wrong_length("the payload must be 8 bytes a pixel", length),
            }
        }
    }
}
payload! {
    /// Text.
    Utf8 {
        fn check_content(utf8: &Vec<u8>) -> Result<(), Fault> {
            utf8_or_fault(utf8)
        }
    }
}

/// Checks that a text is UTF-8; the error gives the offset and value of the first invalid byte.
fn utf8_or_fault(utf8: &[u8]) -> Result<(), Fault> {
    match std::str::from_utf8(utf8) {
        Ok(_) => Ok(()),
        Err(e) => {
            let at = e.valid_up_to();
            let byte = utf8.get(at).copied().unwrap_or(0);
            Err(Fault::new(Code::Format, format!("the text must be UTF-8, and is not at byte {at}"))
                .got(format!("{byte:02x}")))
        }
    }
}

/// Checks the length of `BLIT`'s rows, which its rectangle determines.
pub(crate) fn blit_length(command: &Command, length: u64) -> Result<(), Fault> {
    match command {
        Command::Blit { rect: Rect { w, h, .. }, .. } if *w >= 0 && *h >= 0 => {
            // Both are below 2^31: the product stays below 2^64.
            let expected = *w as u64 * *h as u64 * 4;
            match expected == length {
                true => Ok(()),
                false => {
                    wrong_length(format!("the payload of {w} x {h} pixels must be {expected} bytes"), length)
                }
            }
        }
        _ => Ok(()),
    }
}

/// The word `X3D` and the bytes of a file.
pub struct X3dFile;

impl Argument for X3dFile {
    type Value = Vec<u8>;
    const KIND: ParameterKind = ParameterKind::Payload;
    const WORDS: Arity = Arity::ONE;
    const PAYLOAD: Payload = Payload::Always;

    fn payload(bytes: &Vec<u8>) -> Option<&[u8]> {
        Some(bytes)
    }

    fn payload_mut(bytes: &mut Vec<u8>) -> Option<&mut Vec<u8>> {
        Some(bytes)
    }

    fn write(_: &Vec<u8>, line: &mut LineWriter<'_>) -> Result<(), EncodeError> {
        line.word("X3D");
        Ok(())
    }
}

impl TextArgument for X3dFile {
    fn read(args: &mut Args<'_>) -> Result<Vec<u8>, ParseError> {
        take_keyword(args, "X3D").map(|()| Vec::new())
    }
}

/// The pixels of a binary run, after their number.
pub struct Run;

impl Argument for Run {
    type Value = Vec<u8>;
    const KIND: ParameterKind = ParameterKind::Payload;

    fn check_length(_: &Vec<u8>, length: u64) -> Result<(), Fault> {
        match length.is_multiple_of(4) {
            true => Ok(()),
            false => wrong_length("the run must be 4 bytes a pixel", length),
        }
    }

    fn payload(bytes: &Vec<u8>) -> Option<&[u8]> {
        Some(bytes)
    }

    fn payload_mut(bytes: &mut Vec<u8>) -> Option<&mut Vec<u8>> {
        Some(bytes)
    }

    fn write(rgba: &Vec<u8>, line: &mut LineWriter<'_>) -> Result<(), EncodeError> {
        let pixels = u32::try_from(rgba.len() / 4)
            .map_err(|_| Fault::new(Code::TooBig, "a run has at most 4294967295 pixels"))?;
        line.binary(&pixels.to_le_bytes());
        Ok(())
    }
}

/// Bytes in hex, as one word.
pub struct HexBytes;

impl Argument for HexBytes {
    type Value = Vec<u8>;
    const KIND: ParameterKind = ParameterKind::Hex;
    const WORDS: Arity = Arity::ONE;

    fn check_content(bytes: &Vec<u8>) -> Result<(), Fault> {
        match bytes.is_empty() {
            true => Err(Fault::new(Code::Args, "there must be a byte to write")),
            false => Ok(()),
        }
    }

    fn write(bytes: &Vec<u8>, line: &mut LineWriter<'_>) -> Result<(), EncodeError> {
        line.hex(bytes);
        Ok(())
    }
}

impl TextArgument for HexBytes {
    fn read(args: &mut Args<'_>) -> Result<Vec<u8>, ParseError> {
        let hex = args.word();
        let mut bytes = vec![0; hex.len() / 2];
        match hex.len().is_multiple_of(2) && read_hex(hex, &mut bytes) {
            true => Ok(bytes),
            false => args.refuse(Code::Format, "bytes of two hex digits each", hex),
        }
    }
}
