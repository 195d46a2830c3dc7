// Draws the tour in WebAssembly, and prints the checksum of each frame as `crcs` does.
//
// Usage: node tour.mjs fbptr_lean.wasm. The module imports nothing: no clock, no file, no thread.
import { readFileSync } from "node:fs";

const module = new WebAssembly.Module(readFileSync(process.argv[2]));
const imports = WebAssembly.Module.imports(module);
if (imports.length > 0) {
    throw new Error(`the module imports ${imports.map((i) => `${i.module}.${i.name}`).join(", ")}`);
}
const { tour_crc } = new WebAssembly.Instance(module).exports;
for (let frame = 1; frame <= 9; frame++) {
    console.log(`tour ${frame} ${(tour_crc(frame) >>> 0).toString(16).padStart(8, "0")}`);
}
