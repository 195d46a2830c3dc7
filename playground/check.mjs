// Plays streams in the engine of a built page, under Node, and prints the CRC-32 of each one's last frame; then feeds it
// broken streams, none of which may trap.
//
// Usage: node check.mjs PAGE.html [STREAM.fbs ...]
import { readFileSync } from "node:fs";
import { makeEngine, moduleOf } from "./module.mjs";

const module = moduleOf(process.argv[2]);
const imports = WebAssembly.Module.imports(module);
if (imports.length > 0) throw new Error(`the module imports ${JSON.stringify(imports)}`);
const engine = makeEngine(new WebAssembly.Instance(module).exports);

const streams = process.argv.slice(3);
for (const path of streams) {
    engine.load(readFileSync(path));
    engine.run(0);
    console.log(`${path} ${engine.crc()}`);
}

// Examples of all verbs, with bytes changed, cut and joined by a generator of fixed seed.
let seed = 12345;
const below = (n) => { seed = (Math.imul(seed, 1103515245) + 12345) >>> 0; return Math.floor(seed / 2 ** 32 * n); };
const parts = engine.verbs().map((verb) => Buffer.from(verb.help.split("\nExample:\n")[1] ?? "", "latin1"));
let refused = 0;
for (let round = 0; round < 400; round++) {
    const stream = Buffer.concat(Array.from({ length: 1 + below(12) }, () => parts[below(parts.length)]));
    for (let i = below(6); i > 0 && stream.length > 0; i--) stream[below(stream.length)] = below(256);
    const head = below(8) === 0 ? Buffer.from(`SIZE ${below(300)} ${below(300)}\n`) : Buffer.from("SIZE 64 48\n");
    try { engine.load(Buffer.concat([head, stream.subarray(0, below(stream.length + 1))])); } catch (e) {
        if (e instanceof WebAssembly.RuntimeError) throw e;
        continue;
    }
    const pace = below(3);
    for (let i = 0; i < 2000 && engine.run(pace) !== 2; i++);
    refused += engine.report().errors;
}
console.error(`400 broken streams, ${refused} commands refused, no trap`);
