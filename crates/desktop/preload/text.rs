//! Text without allocation: writing numbers into a buffer, and reading them.

/// A text in a buffer of fixed size; what does not fit is cut off.
pub struct Text<const N: usize> {
    bytes: [u8; N],
    len: usize,
}

impl<const N: usize> Text<N> {
    pub const fn new() -> Self {
        Text { bytes: [0; N], len: 0 }
    }

    pub fn push(&mut self, text: &[u8]) -> &mut Self {
        for &byte in text {
            // The last byte stays zero, so that the text is also a C string.
            if self.len + 1 < N {
                self.bytes[self.len] = byte;
                self.len += 1;
            }
        }
        self
    }

    pub fn number(&mut self, mut value: u64) -> &mut Self {
        let mut digits = [0; 20];
        let mut at = digits.len();
        loop {
            at -= 1;
            digits[at] = b'0' + (value % 10) as u8;
            value /= 10;
            if value == 0 {
                break;
            }
        }
        self.push(&digits[at..])
    }

    /// Keeps the first `len` bytes.
    pub fn truncate(&mut self, len: usize) {
        let len = len.min(self.len);
        self.bytes[len..self.len].fill(0);
        self.len = len;
    }

    pub fn as_bytes(&self) -> &[u8] {
        &self.bytes[..self.len]
    }

    /// Returns the text as a C string.
    pub fn as_ptr(&self) -> *const core::ffi::c_char {
        self.bytes.as_ptr().cast()
    }
}

/// Reads `N` numbers that stand between slashes, and what follows them.
pub fn numbers<const N: usize>(text: &[u8]) -> Option<[u64; N]> {
    let mut found = [0u64; N];
    let mut parts = text.split(|b| *b == b'/');
    for value in &mut found {
        let digits = parts.next().filter(|part| !part.is_empty())?;
        for digit in digits {
            let digit = digit.wrapping_sub(b'0');
            if digit > 9 {
                return None;
            }
            *value = value.checked_mul(10)?.checked_add(u64::from(digit))?;
        }
    }
    parts.next().is_none().then_some(found)
}
