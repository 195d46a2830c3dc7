//! Gzip files (RFC 1952) to the bytes that they hold.
//!
//! In: a whole file's bytes and a function that is asked before memory is taken. Out: the inflated bytes of all members, or why
//! not. A few bytes can stand for a thousand times as many, so the output grows in steps, and each step is asked for before
//! it exists; none is made beyond the limit.

use super::{Charge, LoadErrorKind};
use flate2::bufread::MultiGzDecoder;
use std::io::Read;

/// The most bytes that a gzip file may hold.
pub(crate) const MAX_INFLATED: u64 = 512 << 20;

/// The first step of the output, in bytes; each further one is as long as all before it.
const FIRST_STEP: usize = 1 << 16;

/// Whether bytes begin as those of a gzip file do.
pub(crate) fn is_gzip(bytes: &[u8]) -> bool {
    bytes.starts_with(&[0x1f, 0x8b])
}

/// The bytes that a gzip file holds.
///
/// # Errors
/// Bytes that are no gzip, more than `limit` of them, or memory that `charge` does not grant.
pub(crate) fn inflate(bytes: &[u8], limit: u64, charge: &mut Charge) -> Result<Vec<u8>, LoadErrorKind> {
    let mut decoder = MultiGzDecoder::new(bytes);
    let mut out: Vec<u8> = Vec::new();
    loop {
        // One byte beyond the limit tells that there is more.
        let room = (limit + 1).saturating_sub(out.len() as u64);
        let step = out.len().max(FIRST_STEP).min(room as usize);
        charge(step as u64).map_err(|left| LoadErrorKind::Memory { needed: step as u64, left })?;
        out.reserve_exact(step);
        let read = (&mut decoder).take(step as u64).read_to_end(&mut out);
        let read = read
            .map_err(|e| LoadErrorKind::Undecodable { format: "gzip file", reason: e.to_string() })?;
        if out.len() as u64 > limit {
            return Err(LoadErrorKind::TooBig {
                what: "bytes of an inflated file",
                found: out.len() as u64,
                limit,
            });
        }
        if read < step {
            return Ok(out);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
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
            assert_eq!(inflate(&both, MAX_INFLATED, &mut |_| Ok(())).unwrap(), text, "{cut}");
        }
    }

    #[test]
    fn a_bomb_ends_at_the_limit_and_each_step_is_asked_for_first() {
        let bomb = packed(&vec![0; 8 << 20]);
        assert!(bomb.len() < 10_000, "{} bytes", bomb.len());
        let error = inflate(&bomb, 1 << 20, &mut |_| Ok(())).unwrap_err();
        assert!(matches!(error, LoadErrorKind::TooBig { limit: 0x10_0000, .. }), "{error}");
        let mut left = 300_000_u64;
        let mut asked = Vec::new();
        let error = inflate(&bomb, MAX_INFLATED, &mut |bytes| {
            asked.push(bytes);
            left = left.checked_sub(bytes).ok_or(left)?;
            Ok(())
        });
        assert_eq!(asked, [65_536, 65_536, 131_072, 262_144]);
        assert_eq!(error, Err(LoadErrorKind::Memory { needed: 262_144, left: 37_856 }));
    }

    #[test]
    fn what_is_broken_is_refused() {
        let whole = packed(b"a scene");
        for cut in 0..whole.len() {
            assert!(inflate(&whole[..cut], MAX_INFLATED, &mut |_| Ok(())).is_err(), "cut at {cut}");
        }
        let mut wrong = whole.clone();
        let sum = wrong.len() - 8;
        wrong[sum] ^= 1;
        assert!(inflate(&wrong, MAX_INFLATED, &mut |_| Ok(())).is_err());
    }
}
