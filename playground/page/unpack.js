// Unpacks the module: LZMA without a header, as `xz --format=raw --lzma1=lc=4,lp=0,pb=0` writes it. Browsers bring gzip
// alone, which leaves four tenths more to load. Used by the page's worker and by the checks under Node.
"use strict";
// Returns the first `size` bytes of what `packed` holds. Bytes that are no such packing give other bytes or an error.
function unpack(packed, size) {
    const out = new Uint8Array(size), CONTEXT_BITS = 4;
    // Chances of a zero, of 2048, that each bit changes; `bit` reads by the one at `i`.
    const chances = (n) => new Uint16Array(n).fill(1024);
    const literals = chances(0x300 << CONTEXT_BITS), matches = chances(12), repeats = chances(12 * 4), single = chances(12);
    const slots = chances(4 * 64), near = chances(128), low = chances(16), lengths = chances(274), repeatLengths = chances(274);
    let range = 0xFFFFFFFF, at = 5;
    let code = new DataView(packed.buffer, packed.byteOffset).getUint32(1);
    function grow() {
        range = (range << 8) >>> 0;
        code = ((code << 8) | packed[at++]) >>> 0;
    }
    function bit(p, i) {
        const bound = (range >>> 11) * p[i];
        let found = 0;
        if (code < bound) {
            range = bound;
            p[i] += (2048 - p[i]) >> 5;
        } else {
            range -= bound;
            code -= bound;
            p[i] -= p[i] >> 5;
            found = 1;
        }
        if (range < 0x1000000) grow();
        return found;
    }
    function tree(p, base, bits) {
        let node = 1;
        for (let i = 0; i < bits; i++) node = (node << 1) | bit(p, base + node);
        return node - (1 << bits);
    }
    // A tree whose lowest bit comes first.
    function reversed(p, base, bits) {
        let node = 1, found = 0;
        for (let i = 0; i < bits; i++) {
            const one = bit(p, base + node);
            node = (node << 1) | one;
            found |= one << i;
        }
        return found;
    }
    // Bits that are one or zero alike.
    function even(bits) {
        let found = 0;
        for (let i = 0; i < bits; i++) {
            range >>>= 1;
            const one = code >= range ? 1 : 0;
            if (one) code -= range;
            found = (found << 1) | one;
            if (range < 0x1000000) grow();
        }
        return found;
    }
    function length(p) {
        if (!bit(p, 0)) return 2 + tree(p, 2, 3);
        return bit(p, 1) ? 18 + tree(p, 18, 8) : 10 + tree(p, 10, 3);
    }
    function distance(count) {
        const slot = tree(slots, Math.min(count - 2, 3) * 64, 6), more = (slot >> 1) - 1;
        if (slot < 4) return slot;
        const base = (2 | (slot & 1)) << more;
        if (slot < 14) return base + reversed(near, base - slot, more);
        return base + even(more - 4) * 16 + reversed(low, 0, 4);
    }
    function literal(to, state, from) {
        const base = 0x300 * (to > 0 ? out[to - 1] >> (8 - CONTEXT_BITS) : 0);
        let node = 1;
        // After a match the byte that it would have gone on with tells more.
        for (let other = out[from], same = state >= 7; same && node < 0x100; other <<= 1) {
            const expected = (other >> 7) & 1, one = bit(literals, base + ((1 + expected) << 8) + node);
            node = (node << 1) | one;
            same = one === expected;
        }
        while (node < 0x100) node = (node << 1) | bit(literals, base + node);
        return node;
    }
    // What came before, as one of twelve states, and the last four distances, less one.
    let state = 0, [a, b, c, d] = [0, 0, 0, 0];
    for (let to = 0; to < size;) {
        if (!bit(matches, state)) {
            out[to] = literal(to, state, to - a - 1);
            to++;
            state = state < 4 ? 0 : state < 10 ? state - 3 : state - 6;
            continue;
        }
        let count = 1;
        if (!bit(repeats, state)) {
            [b, c, d] = [a, b, c];
            count = length(lengths);
            state = state < 7 ? 7 : 10;
            a = distance(count);
        } else if (bit(repeats, 12 + state)) {
            if (!bit(repeats, 24 + state)) [a, b] = [b, a];
            else if (!bit(repeats, 36 + state)) [a, b, c] = [c, a, b];
            else [a, b, c, d] = [d, a, b, c];
            count = length(repeatLengths);
            state = state < 7 ? 8 : 11;
        } else if (bit(single, state)) {
            count = length(repeatLengths);
            state = state < 7 ? 8 : 11;
        } else {
            state = state < 7 ? 9 : 11;
        }
        if (a >= to) throw new Error("the module is damaged");
        for (const end = Math.min(to + count, size); to < end; to++) out[to] = out[to - a - 1];
    }
    return out;
}
