// Runs the engine beside the page. A message has an id and is answered with it. After a trap, which only memory or stack
// that run out can cause, the next message gets a new instance.
"use strict";
let compiled = null, engine = null, given = false;
const fresh = async () => makeEngine((await WebAssembly.instantiate(compiled, {})).exports);
function picture(more) {
    const pixels = engine.pixels(), size = engine.size(), report = engine.report();
    return { ...more, size, pixels, report, crc: engine.crc() };
}
// Begins a stream with a view. The view is relative to the author's camera, which a run without a view finds.
function begin(m) {
    engine.trace(m.trace);
    engine.turns(m.turns || []);
    const home = { yaw: 0, pitch: 0, zoom: 1, right: 0, up: 0 };
    const view = m.view || home;
    const moved = Object.keys(home).some((k) => home[k] !== view[k]);
    if (moved && !given) { engine.view(home); engine.load(m.bytes); engine.run(0); given = true; }
    if (moved) engine.view(view); else engine.view(home);
    engine.load(m.bytes);
}
const tasks = {
    async open(m) {
        const module = unpack(m.packed, m.size);
        if (!WebAssembly.validate(module)) throw new Error("this browser is too old: its WebAssembly has no vectors (SIMD), as Chrome 91, Firefox 89 and Safari 16.4 do");
        compiled = await WebAssembly.compile(module);
        engine = await fresh();
        return { verbs: engine.verbs() };
    },
    // Runs all of a stream, or its first frames or commands.
    run(m) {
        given = given && !m.changed;
        const start = performance.now();
        begin(m);
        let state = 0;
        if (m.steps === undefined) engine.run(0);
        else for (let i = 0; i < m.steps && state !== 2; i++) state = engine.run(m.pace);
        return picture({ state, pause: engine.pause(), ms: performance.now() - start });
    },
    // Goes on: one command or one frame.
    step(m) {
        const start = performance.now(), state = engine.run(m.pace);
        return picture({ state, pause: engine.pause(), ms: performance.now() - start });
    },
    inspect: (m) => ({ text: engine.inspect(m.x, m.y) }),
    png: () => ({ png: engine.png() }),
};
let queue = Promise.resolve();
onmessage = ({ data }) => {
    queue = queue.then(async () => {
        try {
            if (engine === null && data.task !== "open") engine = await fresh();
            const answer = await tasks[data.task](data);
            postMessage({ id: data.id, ...answer }, answer.pixels ? [answer.pixels.buffer] : []);
        } catch (e) {
            const trapped = e instanceof WebAssembly.RuntimeError || e instanceof RangeError;
            if (trapped) { engine = null; given = false; }
            const why = trapped ? "memory or stack ran out in this stream; the engine was started anew" : e.message;
            postMessage({ id: data.id, error: why });
        }
    });
};
