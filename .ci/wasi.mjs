// Runs a program of WebAssembly's system interface (WASI) under Node: cargo's runner for the tests of `.ci/nightly`.
//
// Usage: node wasi.mjs PROGRAM.wasm [ARGUMENT ...]
import { readFileSync } from "node:fs";
import { WASI } from "node:wasi";

const [program, ...rest] = process.argv.slice(2);
const wasi = new WASI({ version: "preview1", args: [program, ...rest], env: process.env, returnOnExit: true });
const instance = await WebAssembly.instantiate(new WebAssembly.Module(readFileSync(program)), wasi.getImportObject());
process.exitCode = wasi.start(instance);
