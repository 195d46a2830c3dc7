//! Cancellable input for third-party decoders.
//!
//! In: bytes and a token. Out: the bytes in pieces, with a check of the token before each; an I/O
//! error once it is cancelled, which makes the decoder return. Runs on the decoding thread. Pieces
//! are short because compressed pictures unpack to about a thousand times their bytes.

use fbptr_core::cancel::CancelToken;
use std::io::{self, BufRead, Cursor, Read, Seek, SeekFrom};

/// Longest piece in bytes.
const PIECE_BYTES: usize = 16 << 10;

/// Reader over a byte slice that fails once a token is cancelled.
#[derive(Debug)]
pub(super) struct PolledBytes<'a> {
    bytes: Cursor<&'a [u8]>,
    cancel: &'a CancelToken,
}

impl<'a> PolledBytes<'a> {
    /// Creates a reader of `bytes` that fails once `cancel` is cancelled.
    pub fn new(bytes: &'a [u8], cancel: &'a CancelToken) -> Self {
        PolledBytes { bytes: Cursor::new(bytes), cancel }
    }

    /// Returns the bytes that are not read yet.
    pub fn rest(&self) -> &'a [u8] {
        self.bytes.get_ref().get(self.bytes.position() as usize..).unwrap_or(&[])
    }
}

impl Read for PolledBytes<'_> {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        let piece = self.fill_buf()?;
        let count = piece.len().min(out.len());
        out[..count].copy_from_slice(&piece[..count]);
        self.consume(count);
        Ok(count)
    }
}

impl BufRead for PolledBytes<'_> {
    fn fill_buf(&mut self) -> io::Result<&[u8]> {
        if self.cancel.is_cancelled() {
            return Err(io::Error::other("reading was given up"));
        }
        let rest = self.bytes.fill_buf()?;
        Ok(&rest[..rest.len().min(PIECE_BYTES)])
    }

    fn consume(&mut self, count: usize) {
        self.bytes.consume(count);
    }
}

impl Seek for PolledBytes<'_> {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.bytes.seek(to)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_bytes_come_in_pieces_and_end_when_they_are_cancelled() {
        let bytes: Vec<u8> = (0..100_000_u32).map(|i| (i / 3) as u8).collect();
        let token = CancelToken::new();
        let mut whole = Vec::new();
        assert_eq!(PolledBytes::new(&bytes, &token).read_to_end(&mut whole).unwrap(), bytes.len());
        assert_eq!(whole, bytes);
        let mut reader = PolledBytes::new(&bytes, &token);
        assert_eq!(reader.seek(SeekFrom::Start(70_000)).unwrap(), 70_000);
        assert_eq!(reader.fill_buf().unwrap(), &bytes[70_000..70_000 + PIECE_BYTES]);
        let mut some = [0; 50_000];
        assert_eq!(reader.read(&mut some).unwrap(), PIECE_BYTES, "a piece, however much is asked for");
        token.cancel();
        assert!(reader.read(&mut some).is_err() && reader.fill_buf().is_err());
        assert!(PolledBytes::new(&bytes, &token).read_to_end(&mut whole).is_err());
    }
}
