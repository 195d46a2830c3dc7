// Makes the page of the playground: one file with its styles, scripts, examples and the engine, compressed as
// `page/unpack.js` reads it. Needs `xz`.
//
// Usage: node assemble.mjs MODULE.wasm OUT.html. The same input gives the same file.
import { execFileSync } from "node:child_process";
import { readFileSync, writeFileSync } from "node:fs";
import { gzipSync } from "node:zlib";
import { examples } from "./page/examples.mjs";

// Returns a module without its custom sections, which hold names alone.
export function stripped(module) {
    const parts = [module.subarray(0, 8)];
    for (let at = 8; at < module.length;) {
        let [length, shift, next] = [0, 0, at + 1];
        for (;;) {
            const byte = module[next++];
            length += (byte & 127) * 2 ** shift;
            shift += 7;
            if (byte < 128) break;
        }
        if (module[at] !== 0) parts.push(module.subarray(at, next + length));
        at = next + length;
    }
    return Buffer.concat(parts);
}

const [source, out] = process.argv.slice(2);
const part = (name) => readFileSync(new URL(`page/${name}`, import.meta.url), "utf8").trimEnd();
const module = stripped(readFileSync(source));
const filter = "--lzma1=preset=9e,dict=8MiB,nice=273,lc=4,lp=0,pb=0";
const packed = execFileSync("xz", ["--format=raw", filter, "--stdout"], { input: module, maxBuffer: 2 ** 28 });
const fill = {
    CSS: part("page.css"), BYTES: String(module.length), WASM: packed.toString("base64"), UNPACK: part("unpack.js"),
    ENGINE: part("engine.js"), WORKER: part("worker.js"),
};
fill.PAGE = part("page.js").replace("/*EXAMPLES*/[]", () => JSON.stringify(examples).replaceAll("<", "\\u003c"));
const page = part("page.html").replace(/\/\*([A-Z]+)\*\//g, (_, name) => fill[name]) + "\n";
writeFileSync(out, page);
console.log(`wasm ${module.length} bytes, compressed ${packed.length}; page ${page.length}, compressed ${gzipSync(page, { level: 9 }).length}`);
