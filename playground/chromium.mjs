// Opens a built page in Chromium: the canvas shows the engine's bytes, each example draws without an error, a link's text
// is run, streams give the checksums that are named. Prints the checksums as `check.mjs` does.
//
// Usage: node chromium.mjs PAGE.html [--shots DIR] [STREAM.fbs ...]. Needs the package playwright-core, and Chromium.
import { createRequire } from "node:module";
import { existsSync, readFileSync } from "node:fs";
import { join, resolve } from "node:path";
import { pathToFileURL } from "node:url";

const require = createRequire(import.meta.url);
const { chromium } = require("playwright-core");
const words = process.argv.slice(2), page_file = resolve(words.shift());
const shots = words[0] === "--shots" ? words.splice(0, 2)[1] : null;
const executablePath = [process.env.CHROMIUM, "/usr/bin/chromium", "/usr/bin/chromium-browser", "/usr/bin/google-chrome"].find((p) => p && existsSync(p));
if (!executablePath) throw new Error("there is no Chromium");
const browser = await chromium.launch({ executablePath, args: ["--no-sandbox"] });
const address = pathToFileURL(page_file).href;
const assert = (is, what) => { if (!is) throw new Error(what); };
const ready = (page) => page.waitForFunction(() => document.body.dataset.ready, null, { timeout: 60000 });
const idle = (page, title) => page.waitForFunction((t) => shown !== null && last === text.value && (t === null || text.value === t), title, { timeout: 60000 });
try {
    const page = await browser.newPage({ viewport: { width: 1280, height: 800 } });
    const complaints = [];
    page.on("pageerror", (e) => complaints.push(e.message));
    page.on("request", (r) => { if (!/^(file|blob|data):/.test(r.url())) complaints.push(`asks for ${r.url()}`); });
    await page.goto(`${address}#${encodeURIComponent("SIZE 4 2\nPX 1 1 ff8000\nLIEN 1 2\n")}`);
    await ready(page);
    console.error(`first picture after ${await page.evaluate(() => document.body.dataset.ready)} ms`);
    const seen = await page.evaluate(() => [...paper.getImageData(1, 1, 1, 1).data].join());
    assert(seen === "255,128,0,255", `the canvas has ${seen}`);
    const message = await page.textContent("#messages");
    assert(message.includes("line 3: EVERB") && message.includes("did you mean LINE?"), message);
    assert(await page.textContent("#gutter .bad") === "3", "the wrong line is marked");
    for (let i = 0; i < await page.evaluate(() => examples.length); i++) {
        await page.selectOption("#examples", String(i));
        const content = await page.evaluate((n) => examples[n][1], i);
        await idle(page, content);
        await page.waitForFunction(() => shown.report.bytes === new TextEncoder().encode(text.value).length);
        assert((await page.evaluate(() => shown.report.errors)) === 0, `example ${i + 1}: ${await page.textContent("#messages")}`);
        const same = await page.evaluate(() => {
            const data = paper.getImageData(0, 0, canvas.width, canvas.height).data;
            return data.every((v, at) => at % 4 === 3 || v === shown.pixels[at]);
        });
        assert(same, `example ${i + 1}: the canvas has other colours`);
        if (shots) await page.screenshot({ path: join(shots, `example-${i + 1}.png`) });
    }
    for (const path of words) {
        const crc = await page.evaluate(async (b) => (await ask("run", { bytes: Uint8Array.from(b), changed: true })).crc, [...readFileSync(path)]);
        console.log(`${path} ${crc}`);
    }
    // Without a link the page opens with a picture that moves until somebody does something.
    const first = await browser.newPage({ viewport: { width: 1280, height: 800 } });
    await first.goto(address);
    await ready(first);
    const opened = await first.evaluate(() => shown.crc);
    await first.waitForFunction((crc) => shown.crc !== crc, opened);
    const area = await first.evaluate(() => [canvas.clientWidth / $("screen").clientWidth, canvas.clientHeight / $("screen").clientHeight]);
    assert(Math.max(...area) > 0.95, `the frame fills ${area} of its half`);
    if (shots) await first.screenshot({ path: join(shots, "opened.png") });
    await first.locator("#text").press("End");
    await first.keyboard.type(" ");
    await first.waitForFunction(() => !turning && !busy);
    await first.close();
    // Dragging turns a 3-D picture, and the author's view comes back.
    await page.selectOption("#examples", "5");
    await page.waitForFunction(() => shown.report.spatial && text.value.includes("phong"));
    const before = await page.evaluate(() => shown.crc), box = await page.locator("#canvas").boundingBox();
    await page.mouse.move(box.x + 100, box.y + 100);
    await page.mouse.down();
    await page.mouse.move(box.x + 180, box.y + 120, { steps: 4 });
    await page.mouse.up();
    await page.waitForFunction((crc) => shown.crc !== crc && !busy, before);
    if (shots) await page.screenshot({ path: join(shots, "turned.png") });
    await page.click("#home");
    await page.waitForFunction((crc) => shown.crc === crc, before);
    await page.mouse.click(box.x + box.width / 2, box.y + box.height / 2);
    await page.waitForFunction(() => document.getElementById("inspector").textContent.includes("FBptr["));
    if (shots) await page.screenshot({ path: join(shots, "trace.png") });
    if (shots) {
        const phone = await browser.newPage({ viewport: { width: 390, height: 844 }, deviceScaleFactor: 2 });
        await phone.goto(address);
        await ready(phone);
        await phone.selectOption("#examples", "7");
        await phone.waitForTimeout(1500);
        await phone.screenshot({ path: join(shots, "phone.png") });
    }
    assert(complaints.length === 0, complaints.join("\n"));
} finally {
    await browser.close();
}
