//! Decompression of gzip files (RFC 1952).
//!
//! In: the bytes of a file and the memory limits. Out: the inflated bytes of all members with their
//! reservation, or an error. Zero bytes after a member are padding; bytes there that begin no
//! further member are left unread, as gzip itself leaves them, and counted. Output can be a
//! thousand times as long as the input, so it grows in steps, each reserved before it is allocated,
//! and never beyond the limit. A missing reservation is found by
//! tests/allocations/decoder_memory.rs.

use super::polled::PolledBytes;
use super::{LoadErrorKind, LoadMemory};
use fbptr_core::memory::Reservation;
use flate2::bufread::GzDecoder;
use std::io::{BufRead, Read};

/// Most inflated bytes of a gzip file.
pub(crate) const MAX_INFLATED: u64 = 512 << 20;

/// First step of the output in bytes; each further step doubles the output.
const FIRST_STEP: usize = 1 << 16;

/// Bytes of the decoder's window and tables.
const DECODER_BYTES: u64 = 64 << 10;

/// First bytes of every member.
const MAGIC: [u8; 2] = [0x1f, 0x8b];

/// Inflated bytes of a gzip file.
#[derive(Debug)]
pub(crate) struct Inflated {
    pub(crate) bytes: Vec<u8>,
    /// Working memory of `bytes`.
    pub(crate) held: Reservation,
    /// Number of bytes after the last member and its padding.
    pub(crate) trailing: usize,
}

/// Returns whether the bytes begin with gzip's magic number.
pub(crate) fn is_gzip(bytes: &[u8]) -> bool {
    bytes.starts_with(&MAGIC)
}

/// Inflates a gzip file.
///
/// # Errors
/// If the bytes are not valid gzip, the output is longer than `limit`, memory is short, or the
/// load was cancelled.
pub(crate) fn inflate(bytes: &[u8], limit: u64, memory: &LoadMemory) -> Result<Inflated, LoadErrorKind> {
    let mut held = memory.work(DECODER_BYTES)?;
    let mut rest = PolledBytes::new(bytes, memory.cancel());
    let mut out: Vec<u8> = Vec::new();
    loop {
        let mut member = GzDecoder::new(rest);
        append(&mut member, &mut out, limit, memory, &mut held)?;
        rest = member.into_inner();
        let skipped = skip_padding(&mut rest);
        memory.check_cancelled()?;
        skipped.map_err(|e| undecodable(&e))?;
        let left = rest.rest();
        // Half of a magic number is a member that was cut off.
        if left.is_empty() || !left.starts_with(&MAGIC[..left.len().min(MAGIC.len())]) {
            return Ok(Inflated { bytes: out, held, trailing: left.len() });
        }
    }
}

fn undecodable(reason: &std::io::Error) -> LoadErrorKind {
    LoadErrorKind::Undecodable { format: "gzip file", reason: reason.to_string() }
}

/// Appends the output of one member to `out`, which grows within `limit` and `held`.
fn append(
    member: &mut impl Read,
    out: &mut Vec<u8>,
    limit: u64,
    memory: &LoadMemory,
    held: &mut Reservation,
) -> Result<(), LoadErrorKind> {
    loop {
        // One byte beyond the limit shows that there is more.
        let left = (limit + 1).saturating_sub(out.len() as u64);
        let spare = out.capacity() - out.len();
        let step = if spare > 0 { spare } else { out.len().max(FIRST_STEP) }.min(left as usize);
        if spare < step {
            // Growing copies the vector: for a moment both allocations exist.
            let moved = memory.work(out.len() as u64)?;
            held.try_grow(step as u64).map_err(LoadErrorKind::OverBudget)?;
            out.reserve_exact(step);
            drop(moved);
        }
        let read = member.take(step as u64).read_to_end(out);
        memory.check_cancelled()?;
        let read = read.map_err(|e| undecodable(&e))?;
        if out.len() as u64 > limit {
            return Err(LoadErrorKind::TooBig {
                what: "bytes of an inflated file",
                found: out.len() as u64,
                limit,
            });
        }
        if read < step {
            return Ok(());
        }
    }
}

/// Skips zero bytes; leaves any other byte unread.
fn skip_padding(rest: &mut PolledBytes<'_>) -> std::io::Result<()> {
    loop {
        let piece = rest.fill_buf()?;
        let zeros = piece.iter().take_while(|byte| **byte == 0).count();
        let is_end = zeros < piece.len() || piece.is_empty();
        rest.consume(zeros);
        if is_end {
            return Ok(());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fbptr_core::memory::MemoryBudget;
    use flate2::Compression;
    use flate2::write::GzEncoder;
    use std::io::Write;

    fn packed(bytes: &[u8]) -> Vec<u8> {
        let mut encoder = GzEncoder::new(Vec::new(), Compression::best());
        encoder.write_all(bytes).unwrap();
        encoder.finish().unwrap()
    }

    #[test]
    fn every_member_of_a_file_comes_out() {
        let text: Vec<u8> = (0..300_000_u32).map(|i| (i / 7) as u8).collect();
        for cut in [0, 1, 65_536, 299_999] {
            let both = [packed(&text[..cut]), packed(&text[cut..])].concat();
            assert!(is_gzip(&both));
            let Inflated { bytes, held, trailing } =
                inflate(&both, MAX_INFLATED, &LoadMemory::unlimited()).unwrap();
            assert_eq!((&bytes, trailing), (&text, 0), "{cut}");
            assert!(held.bytes() >= bytes.capacity() as u64, "{cut}: {} bytes held", held.bytes());
        }
    }

    #[test]
    fn zeros_after_the_last_member_are_padding() {
        let text = vec![0; 70_000];
        let inflated = |file: &[u8]| inflate(file, MAX_INFLATED, &LoadMemory::unlimited());
        for zeros in [0, 1, 511, 40_000] {
            let padded = [packed(&text), vec![0; zeros]].concat();
            let read = inflated(&padded).unwrap();
            assert_eq!((&read.bytes, read.trailing), (&text, 0), "{zeros} zeros");
            let both = [&padded[..], &packed(b"more")].concat();
            assert_eq!(
                inflated(&both).unwrap().bytes,
                [&text[..], b"more"].concat(),
                "{zeros} zeros between"
            );
            for cut in 1..20 {
                let half = &both[..padded.len() + cut];
                assert!(inflated(half).is_err(), "{cut} bytes of a member after {zeros} zeros");
            }
        }
    }

    #[test]
    fn bytes_that_begin_no_member_are_counted_and_left() {
        let long = vec![b'x'; 100_000];
        for trailing in [&b"x"[..], b"\x1fx", b"\x8b\x1f", b"\n<X3D/>", &long] {
            for zeros in [0, 300] {
                let file = [packed(b"a scene"), vec![0; zeros], trailing.to_vec()].concat();
                let read = inflate(&file, MAX_INFLATED, &LoadMemory::unlimited()).unwrap();
                assert_eq!(
                    (&read.bytes[..], read.trailing),
                    (&b"a scene"[..], trailing.len()),
                    "{zeros} zeros"
                );
            }
        }
    }

    #[test]
    fn a_bomb_ends_at_the_limit_and_each_step_is_asked_for_first() {
        let bomb = packed(&vec![0; 8 << 20]);
        assert!(bomb.len() < 10_000, "{} bytes", bomb.len());
        let error = inflate(&bomb, 1 << 20, &LoadMemory::unlimited()).unwrap_err();
        assert!(matches!(error, LoadErrorKind::TooBig { limit: 0x10_0000, .. }), "{error}");
        let budget = MemoryBudget::new(400_000);
        let error = inflate(&bomb, MAX_INFLATED, &LoadMemory::new(&budget, u64::MAX)).unwrap_err();
        // Reserved at that point: 64 KiB for the decoder, twice 64 KiB of output, and 128 KiB to
        // move it; the next 128 KiB are refused.
        let LoadErrorKind::OverBudget(over) = error else { panic!("{error}") };
        assert_eq!((over.needed, over.used, over.limit), (131_072, 327_680, 400_000));
        assert_eq!(budget.used(), 0, "everything is given back");
    }

    #[test]
    fn what_is_broken_is_refused() {
        let whole = packed(b"a scene");
        for cut in 0..whole.len() {
            let cut_off = inflate(&whole[..cut], MAX_INFLATED, &LoadMemory::unlimited());
            assert!(cut_off.is_err(), "cut at {cut}");
        }
        let mut wrong = whole.clone();
        let sum = wrong.len() - 8;
        wrong[sum] ^= 1;
        assert!(inflate(&wrong, MAX_INFLATED, &LoadMemory::unlimited()).is_err());
    }
}
