//! Bytes that an instruction of x86-64 stores, from its prefixes and its first bytes of code.
//!
//! Source: the tables of the manuals' volume 2. A store that is not in here counts as one byte, the
//! least that it can be. Pure functions; the program's tests include this file.

/// Prefixes of an instruction.
#[derive(Clone, Copy, Default)]
struct Prefixes {
    is_16: bool,
    /// 0xf2 or 0xf3, 0 for none.
    repeat: u8,
    is_64: bool,
}

impl Prefixes {
    /// Bytes of a general register.
    fn word(self) -> usize {
        match self {
            Prefixes { is_64: true, .. } => 8,
            Prefixes { is_16: true, .. } => 2,
            _ => 4,
        }
    }
}

/// Returns the bytes that the instruction at the beginning of `code` stores, 1 to 64.
pub fn size_of_store(code: &[u8]) -> usize {
    let mut prefixes = Prefixes::default();
    let mut rest = code;
    while let [byte, tail @ ..] = rest {
        match byte {
            0x66 => prefixes.is_16 = true,
            0xf2 | 0xf3 => prefixes.repeat = *byte,
            0x26 | 0x2e | 0x36 | 0x3e | 0x64 | 0x65 | 0x67 | 0xf0 => {}
            0x40..=0x4f => prefixes.is_64 = byte & 8 != 0,
            _ => break,
        }
        rest = tail;
    }
    match rest {
        [0x0f, opcode, ..] => of_two_bytes(*opcode, prefixes),
        // VEX with two bytes, with three, and EVEX.
        [0xc5, p, opcode, ..] => of_vector(*opcode, p & 3, if p & 4 != 0 { 32 } else { 16 }, false),
        [0xc4, _, p, opcode, ..] => {
            of_vector(*opcode, p & 3, if p & 4 != 0 { 32 } else { 16 }, p & 0x80 != 0)
        }
        [0x62, _, p, q, opcode, ..] => of_vector(*opcode, p & 3, 16 << (q >> 5 & 3).min(2), p & 0x80 != 0),
        // mov, stos, movs, xchg, arithmetic with a register, with a number, shifts, inc and not.
        [0x89 | 0xc7 | 0xab | 0xa5 | 0x87 | 0x81 | 0x83 | 0xc1 | 0xd1 | 0xd3 | 0xf7 | 0xff, ..] => {
            prefixes.word()
        }
        [opcode @ 0x00..=0x3f, ..] if opcode & 7 == 1 => prefixes.word(),
        _ => 1,
    }
}

fn of_two_bytes(opcode: u8, prefixes: Prefixes) -> usize {
    let prefix = match prefixes {
        Prefixes { repeat: 0xf3, .. } => 2,
        Prefixes { repeat: 0xf2, .. } => 3,
        Prefixes { is_16: true, .. } => 1,
        _ => 0,
    };
    match opcode {
        // Of the registers of MMX.
        0x7f | 0xe7 if prefix == 0 => 8,
        0x11 | 0x29 | 0x2b | 0x7f | 0xe7 | 0x7e | 0xd6 | 0x13 | 0x17 => {
            of_vector(opcode, prefix, 16, prefixes.is_64)
        }
        0xc3 | 0xb1 | 0xc1 | 0xab | 0xb3 | 0xbb | 0xa4 | 0xa5 | 0xac | 0xad => prefixes.word(),
        _ => 1,
    }
}

/// Stores of vector registers; `prefix` is 1, 2, 3 for 0x66, 0xf3, 0xf2.
fn of_vector(opcode: u8, prefix: u8, whole: usize, is_64: bool) -> usize {
    match (opcode, prefix) {
        (0x11, 2) => 4,
        (0x11, 3) => 8,
        (0x11 | 0x29 | 0x2b | 0x7f | 0xe7, _) => whole,
        (0x7e, _) => {
            if is_64 {
                8
            } else {
                4
            }
        }
        (0xd6 | 0x13 | 0x17, _) => 8,
        _ => 1,
    }
}
