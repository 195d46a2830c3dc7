// The functions of the module, with strings and arrays in place of addresses. Used by the page's worker and by the
// checks under Node.
"use strict";
function makeEngine(exports) {
    const decoder = new TextDecoder();
    const text = () => {
        const at = exports.fbptr_text() >>> 0;
        return new Uint8Array(exports.memory.buffer, at, exports.fbptr_text_bytes()).slice();
    };
    return {
        // Begins a stream of bytes. Throws the reason if it has no frame.
        load(bytes) {
            const at = exports.fbptr_reserve(bytes.length) >>> 0;
            if (at === 0) throw new Error("there is no memory for this stream");
            new Uint8Array(exports.memory.buffer, at, bytes.length).set(bytes);
            if (exports.fbptr_load() !== 0) throw new Error(decoder.decode(text()));
        },
        // Paces: 0 to the end, 1 one command, 2 to the next PRESENT. Returns 0 to go on, 1 to pause, 2 at the end.
        run: (pace) => exports.fbptr_run(pace),
        pause: () => exports.fbptr_pause_ms(),
        view: (v) => exports.fbptr_view(v.yaw, v.pitch, v.zoom, v.right, v.up),
        turns(turns) {
            exports.fbptr_turn(0, 0, 0);
            for (const [a, b, degrees] of turns) exports.fbptr_turn(a, b, degrees);
        },
        trace: (at) => exports.fbptr_trace(at ? at[0] : -1, at ? at[1] : -1),
        size: () => [exports.fbptr_width(), exports.fbptr_height()],
        pixels() {
            const bytes = exports.fbptr_width() * exports.fbptr_height() * 4;
            return new Uint8ClampedArray(exports.memory.buffer, exports.fbptr_pixels() >>> 0, bytes).slice();
        },
        crc: () => (exports.fbptr_crc() >>> 0).toString(16).padStart(8, "0"),
        report() {
            exports.fbptr_report();
            return JSON.parse(decoder.decode(text()));
        },
        inspect(x, y) {
            exports.fbptr_inspect(x, y);
            return decoder.decode(text());
        },
        png() {
            exports.fbptr_png();
            return text();
        },
        verbs() {
            exports.fbptr_verbs();
            return JSON.parse(decoder.decode(text()));
        },
    };
}
