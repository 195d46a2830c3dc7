// Takes the engine out of a built page, for the checks under Node.
import { readFileSync } from "node:fs";

const part = (name, made) => {
    const source = readFileSync(new URL(`page/${name}`, import.meta.url), "utf8");
    return new Function(`${source}; return ${made};`)();
};
export const unpack = part("unpack.js", "unpack");
export const makeEngine = part("engine.js", "makeEngine");

// Returns the module of a page, compiled.
export function moduleOf(page) {
    const [, size, packed] = /<script id="wasm"[^>]* data-bytes="(\d+)">([^<]*)</.exec(readFileSync(page, "utf8"));
    return new WebAssembly.Module(unpack(Buffer.from(packed, "base64"), Number(size)));
}
