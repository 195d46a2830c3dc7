// Drives the page in the browser: its canvas against the server's memory, typed commands, keys as events, the inspector,
// the saved PNG, reload, and the return after a restart.
//
// Usage: node web.mjs path/to/fbptr path/to/chromium folder-for-pictures
import assert from "node:assert/strict";
import { spawn } from "node:child_process";
import { readFileSync } from "node:fs";
import { connect } from "node:net";
import { inflateSync } from "node:zlib";
import { chromium } from "playwright-core";

const [fbptr, executablePath, pictures] = process.argv.slice(2);
const PATIENCE_MS = 30_000;

/** Starts a server; `web` is the address of its page. */
async function serve(size, web = "127.0.0.1:0") {
  const args = ["serve", "--headless", "--size", size, "--listen", "127.0.0.1:0", "--web", web, "--web-write"];
  const child = spawn(fbptr, args, { stdio: ["ignore", "inherit", "pipe"] });
  const ended = new Promise((resolve) => { child.on("exit", resolve); });
  // Several threads print these lines, in any order.
  const patterns = { port: /listening on tcp \S+:(\d+)\n/, watch: /browser: (\S+)\n/, drive: /drive: (\S+)\n/ };
  let said = "";
  const isReady = new Promise((resolve) => {
    child.stderr.on("data", (text) => {
      said += text;
      if (Object.values(patterns).every((pattern) => pattern.test(said))) resolve();
    });
  });
  const endsEarly = ended.then((code) => { throw new Error(`the server ended with ${code}: ${said}`); });
  await Promise.race([isReady, endsEarly]);
  const find = (name) => said.match(patterns[name])[1];
  return {
    port: Number(find("port")),
    watch: find("watch"),
    drive: find("drive"),
    stop: () => {
      child.kill("SIGTERM");
      return ended;
    },
  };
}

/** A client of the protocol. */
class Client {
  constructor(port) {
    this.socket = connect(port, "127.0.0.1");
    this.bytes = Buffer.alloc(0);
    this.socket.on("data", (data) => {
      this.bytes = Buffer.concat([this.bytes, data]);
      this.wake?.();
    });
  }

  async until(has) {
    const late = setTimeout(() => this.socket.destroy(new Error("no reply")), PATIENCE_MS);
    while (!has()) await new Promise((resolve) => { this.wake = resolve; });
    clearTimeout(late);
  }

  async line() {
    await this.until(() => this.bytes.includes(10));
    const end = this.bytes.indexOf(10);
    const line = this.bytes.subarray(0, end).toString();
    this.bytes = this.bytes.subarray(end + 1);
    return line;
  }

  send(text) {
    this.socket.write(text);
  }

  async ask(text) {
    this.send(text);
    return this.line();
  }

  /** Returns the RGBA rows of the frame. */
  async read(width, height) {
    await this.ask(`READ 0 0 ${width} ${height}\n`);
    await this.until(() => this.bytes.length >= width * height * 4);
    const rows = this.bytes.subarray(0, width * height * 4);
    this.bytes = this.bytes.subarray(width * height * 4);
    return rows;
  }
}

/** Returns the bytes that a page holds, and those of its canvas. */
const shown = (page) => page.evaluate(() => {
  const canvas = document.getElementById("frame");
  const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
  return { bytes: [...(window.frameShown?.bytes ?? [])], canvas: [...data], width: canvas.width };
});

/** Waits until a page shows the memory, byte for byte, and compares the canvas, which is opaque. */
async function shows(page, rows, what) {
  const until = Date.now() + PATIENCE_MS;
  for (;;) {
    const { bytes, canvas } = await shown(page);
    const opaque = Buffer.from(rows);
    for (let i = 3; i < opaque.length; i += 4) opaque[i] = 255;
    if (rows.equals(Buffer.from(bytes)) && opaque.equals(Buffer.from(canvas))) break;
    assert(Date.now() < until, `${what}: the page shows another frame`);
    await new Promise((resolve) => setTimeout(resolve, 50));
  }
  console.log(`${what}: the canvas is the memory`);
}

async function open(browser, link, options) {
  const context = await browser.newContext({ acceptDownloads: true, ...options });
  await context.addInitScript(() => {
    window.addEventListener("fbptr-frame", (event) => { window.frameShown = event.detail.frame; });
  });
  const page = await context.newPage();
  page.on("pageerror", (error) => { throw error; });
  page.on("console", (message) => {
    const isExpected = /WebSocket connection/.test(message.text());
    assert(message.type() !== "error" || isExpected, message.text());
  });
  await page.goto(link);
  await page.waitForSelector("body[data-state=live]", { timeout: PATIENCE_MS });
  return page;
}

const contents = (page, id) => page.locator(`#${id}`).textContent();
const becomes = (page, id, text) => page.waitForFunction(
  ([at, wanted]) => document.getElementById(at).textContent === wanted, [id, text], { timeout: PATIENCE_MS });
const logs = (page, text) => page.waitForFunction(
  (wanted) => document.getElementById("log").textContent.includes(wanted), text, { timeout: PATIENCE_MS });

/** Draws something with shapes, letters and alphas. */
const SCENE = `CLEAR 0e1420
FILLRECT 16 16 96 64 ffb000
FILL 200 20 300 60 180 110 2ec4b6 5b8cff ff5d5d
FILLCIRCLE 80 160 48 e8e8f0
TEXTSIZE 2
PRINT 128 200 e8e8f0 exact
PX 5 7 12345678
PX 319 239 00000000
`;

/** Returns the rows of a PNG whose rows have no filter. */
function rowsOf(png, width) {
  const data = [];
  for (let at = 8; at < png.length;) {
    const length = png.readUInt32BE(at);
    if (png.toString("latin1", at + 4, at + 8) === "IDAT") data.push(png.subarray(at + 8, at + 8 + length));
    at += 12 + length;
  }
  const rows = inflateSync(Buffer.concat(data));
  const stride = width * 4 + 1;
  return Buffer.concat(Array.from({ length: rows.length / stride }, (_, y) => {
    assert.equal(rows[y * stride], 0, "rows without a filter");
    return rows.subarray(y * stride + 1, (y + 1) * stride);
  }));
}

async function main() {
  let server = await serve("320x240");
  const browser = await chromium.launch({ executablePath, args: ["--no-sandbox"] });
  try {
    const client = new Client(server.port);
    client.send(SCENE);
    const page = await open(browser, server.watch, { viewport: { width: 1280, height: 800 } });
    await shows(page, await client.read(320, 240), "a scene");
    assert(await page.locator("#prompt").isHidden(), "who watches has no prompt");

    const driver = await open(browser, server.drive, { viewport: { width: 1280, height: 800 } });
    await driver.fill("#line", "FILLRECT 200 150 80 60 ff5d5d");
    await driver.press("#line", "Enter");
    await driver.fill("#line", "PX 210 160");
    await driver.press("#line", "Enter");
    await logs(driver, "PX 210 160 ff5d5d");
    await shows(page, await client.read(320, 240), "typed commands, in the other page");
    await driver.fill("#line", "NOPE");
    await driver.press("#line", "Enter");
    await logs(driver, "EVERB");
    await driver.fill("#line", "HELP");
    await driver.press("#line", "Enter");
    await logs(driver, "DEPTHAT");
    await driver.press("#line", "ArrowUp");
    await driver.press("#line", "ArrowUp");
    assert.equal(await driver.inputValue("#line"), "NOPE", "the history goes back");
    console.log("typed commands, errors, HELP and history");

    const box = await driver.locator("#frame").boundingBox();
    const scale = box.width / 320;
    await driver.mouse.move(box.x + 5.5 * scale, box.y + 7.5 * scale);
    await becomes(driver, "at", "5, 7");
    assert.equal(await contents(driver, "rgba"), "18 52 86 120");
    assert.equal(await contents(driver, "offset"), String((7 * 320 + 5) * 4));
    await becomes(driver, "depth", "none");
    console.log("the inspector");

    const events = new Client(server.port);
    assert.equal(await events.ask("EVENTS on\nSYNC x\n"), "SYNC x");
    await driver.waitForSelector("body[data-listeners=\"1\"]", { timeout: PATIENCE_MS });
    await driver.click("#send");
    await driver.keyboard.down("ArrowLeft");
    await driver.keyboard.up("ArrowLeft");
    assert.equal(await events.line(), "EVENT key down left");
    assert.equal(await events.line(), "EVENT key up left");
    await driver.keyboard.press("a");
    assert.deepEqual([await events.line(), await events.line(), await events.line()],
      ["EVENT key down a", "EVENT text u+0061 a", "EVENT key up a"]);
    await driver.mouse.move(box.x + 100.5 * scale, box.y + 50.5 * scale);
    await driver.mouse.down();
    let line = "";
    while (line !== "EVENT mouse 100 50 1") line = await events.line();
    await driver.mouse.up();
    await driver.mouse.wheel(0, 100);
    while (line !== "EVENT wheel 0 -1") line = await events.line();
    await driver.keyboard.press("Escape");
    assert.equal(await driver.getAttribute("#send", "aria-pressed"), "false", "Esc ends the sending");
    console.log("keys and mouse as events");

    const before = await contents(driver, "scale");
    await driver.mouse.wheel(0, -100);
    assert.notEqual(await contents(driver, "scale"), before, "the wheel zooms");
    await driver.screenshot({ path: `${pictures}/desktop.png` });
    await driver.click("#fit");
    await becomes(driver, "scale", before);
    const [download] = await Promise.all([driver.waitForEvent("download"), driver.click("#png")]);
    const rows = await client.read(320, 240);
    assert(rows.equals(rowsOf(readFileSync(await download.path()), 320)), "the PNG has other bytes");
    console.log("the saved PNG is the memory, with its alpha");

    await page.reload();
    await page.waitForSelector("body[data-state=live]", { timeout: PATIENCE_MS });
    await shows(page, rows, "after a reload");
    const address = new URL(server.watch).host;
    await server.stop();
    await page.waitForSelector("body[data-state=connecting]", { timeout: PATIENCE_MS });
    server = await serve("160x200", address);
    const again = new Client(server.port);
    again.send("CLEAR 2ec4b6\nPRINT 8 8 e8e8f0 again\n");
    await page.waitForSelector("body[data-state=live]", { timeout: PATIENCE_MS });
    await shows(page, await again.read(160, 200), "after a restart, with another size");
    await driver.waitForSelector("body[data-state=live]", { timeout: PATIENCE_MS });
    assert(await driver.locator("#prompt").isHidden(), "the old link no longer drives");

    const phone = { viewport: { width: 390, height: 844 }, deviceScaleFactor: 3, isMobile: true, hasTouch: true };
    const small = await open(browser, server.drive, phone);
    await shows(small, await again.read(160, 200), "on a phone");
    const spill = await small.evaluate(() => document.documentElement.scrollWidth - window.innerWidth);
    assert(spill <= 0, `the page is ${spill} pixels too wide for a phone`);
    await small.setViewportSize({ width: 360, height: 640 });
    const buttonRows = await small.evaluate(() => new Set([...document.querySelectorAll("nav button:not([hidden])")]
      .map((button) => button.offsetTop)).size);
    assert.equal(buttonRows, 1, "the buttons of a narrow phone take one row");
    await small.setViewportSize(phone.viewport);
    await small.tap("#stage");
    await small.screenshot({ path: `${pictures}/phone.png`, fullPage: true });
  } finally {
    await browser.close();
    await server.stop();
  }
}

await main();
