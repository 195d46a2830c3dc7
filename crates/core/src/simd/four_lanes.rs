//! What levels of four lanes share: methods of [`Simd`](super::Simd) in terms of others, and the
//! order of bytes that packs the set lanes of a vector to the front.

/// Bytes of the set lanes for each mask, in order; behind them 255, for which the look-up gives 0.
#[cfg(not(target_arch = "x86_64"))]
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

/// Methods of a level whose vector is a row of a block. In scope are `I` and `M`.
macro_rules! block_of_one_row_methods {
    () => {
        #[inline(always)]
        fn store_masked_i(self, mask: M, v: I, to: &mut [i32]) {
            let old = self.load_i(to);
            self.store_i(self.select_i(mask, v, old), to);
        }
        #[inline(always)]
        fn load_block(self, from: &[i32], _stride: usize) -> I {
            self.load_i(from)
        }
        #[inline(always)]
        fn store_block_bytes(self, mask: M, v: I, to: &mut [u8], _stride: usize) {
            if mask.any() {
                self.store_masked_bytes(mask, v, to);
            }
        }
    };
}
pub(super) use block_of_one_row_methods;

/// Methods that pack set lanes to the front by a look-up of bytes. In scope are `I`, `M`, `packing`
/// and, from and to the registers' type, `packed` and `transposed`.
#[cfg(not(target_arch = "x86_64"))]
macro_rules! packing_methods {
    () => {
        #[inline(always)]
        fn compress_i(self, mask: M, v: I, to: &mut [i32]) -> usize {
            let bits = mask.bits();
            self.store_i(I(packed(v, packing(bits))), to);
            bits.count_ones() as usize
        }
        #[inline(always)]
        fn compress8(self, mask: M, fields: [I; 8], to: &mut [[i32; 8]]) -> usize {
            let to = &mut to[..4];
            let bits = mask.bits();
            let order = packing(bits);
            let [a, b, c, d, e, f, g, h] = fields;
            // Fields of no record are 0: so are the records behind the last one.
            let low = transposed([packed(a, order), packed(b, order), packed(c, order), packed(d, order)]);
            let high = transposed([packed(e, order), packed(f, order), packed(g, order), packed(h, order)]);
            let mut r = 0;
            while r < 4 {
                self.store_i(I(low[r]), &mut to[r][..4]);
                self.store_i(I(high[r]), &mut to[r][4..]);
                r += 1;
            }
            bits.count_ones() as usize
        }
    };
}
#[cfg(not(target_arch = "x86_64"))]
pub(super) use packing_methods;
