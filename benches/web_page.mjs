// Counts the frames that the page shows in Chromium during a flood, and their latency: for benches/web.py.
//
// Usage: node web_page.mjs path/to/chromium link seconds
import { createRequire } from "node:module";

const [executablePath, link, seconds] = process.argv.slice(2);
const { chromium } = createRequire(`${process.cwd()}/`)("playwright-core");
const browser = await chromium.launch({ executablePath, args: ["--no-sandbox"] });
const page = await browser.newPage({ viewport: { width: 1280, height: 800 } });
await page.addInitScript(() => {
  window.latencies = [];
  window.addEventListener("fbptr-frame", ({ detail: { frame } }) => {
    // Pixel (0, 0) has the time at which it was sent.
    const stamp = (frame.bytes[0] << 16) | (frame.bytes[1] << 8) | frame.bytes[2];
    window.latencies.push((Date.now() - stamp) & 0xffffff);
  });
});
await page.goto(link);
await page.waitForSelector("body[data-sequence]");
console.log("ready");
await new Promise((resolve) => setTimeout(resolve, seconds * 1000));
const ms = (await page.evaluate(() => window.latencies)).slice(1).sort((a, b) => a - b);
const at = (q) => ms[Math.min(ms.length - 1, Math.floor(q * ms.length))];
console.log(`frames/s ${(ms.length / seconds).toFixed(1)}; latency p50 ${at(0.5)} ms, p99 ${at(0.99)} ms`);
await browser.close();
