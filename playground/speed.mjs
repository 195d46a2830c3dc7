// Times the frames of a stream in the engine of a built page, under Node: the least and the median in milliseconds.
//
// Usage: node speed.mjs PAGE.html STREAM.fbs
import { readFileSync } from "node:fs";
import { makeEngine, moduleOf } from "./module.mjs";

const engine = makeEngine(new WebAssembly.Instance(moduleOf(process.argv[2])).exports);
engine.load(readFileSync(process.argv[3]));
const times = [];
for (;;) {
    const start = performance.now();
    if (engine.run(2) === 2) break;
    times.push(performance.now() - start);
}
times.sort((a, b) => a - b);
console.log(`${times.length} frames, least ${times[0].toFixed(1)} ms, median ${times[times.length >> 1].toFixed(1)} ms, crc ${engine.crc()}`);
