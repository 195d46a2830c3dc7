//! Order of bytes that packs the set lanes of a vector of four numbers to the front, for levels
//! that permute bytes by a table.

/// Bytes of the set lanes for each mask, in order; behind them 255, for which the look-up gives 0.
pub(super) static PACKING: [[u8; 16]; 16] = {
    let mut table = [[255; 16]; 16];
    let mut bits = 0;
    while bits < 16 {
        let (mut byte, mut n) = (0, 0);
        while byte < 16 {
            if bits >> (byte / 4) & 1 == 1 {
                table[bits][n] = byte as u8;
                n += 1;
            }
            byte += 1;
        }
        bits += 1;
    }
    table
};
