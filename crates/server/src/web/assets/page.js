// The page: joins the WebSocket, shows what it brings, and sends what the user does.

import { Console } from "./console.js";
import { Frame } from "./frame.js";
import { buttons, keyName, typed } from "./input.js";
import { png } from "./png.js";
import { View } from "./view.js";

const $ = (id) => document.getElementById(id);
const stage = $("stage");
/** Shortest time between two questions for a depth, and a page out of sight's between two frames. */
const PROBE_EVERY_MS = 100;
const HIDDEN_EVERY_MS = 1000;

let socket;
let hello = {};
let retryMs = 500;
let sends = false;
let hasListeners = false;
let pointer;
let probedAt = 0;
let shownTimes = [];
let earlier;

const say = (text) => {
  if (socket?.readyState === WebSocket.OPEN) socket.send(text);
};
const frame = new Frame($("frame"), shown);
const view = new View(stage, $("frame"), () => {
  $("scale").textContent = view.scale >= 1 ? `${view.scale}x` : `1/${(1 / view.scale).toFixed(1)}`;
  inspect();
});
const terminal = new Console($("log"), $("prompt"), $("line"), (line) => say(`line ${line}`));

function setState(name, text) {
  document.body.dataset.state = name;
  $("state").textContent = text;
}

function connect() {
  const scheme = location.protocol === "https:" ? "wss" : "ws";
  socket = new WebSocket(`${scheme}://${location.host}/socket`);
  socket.binaryType = "arraybuffer";
  // The token stands behind the #, which browsers send to nobody.
  socket.addEventListener("open", () => say(`join ${location.hash.slice(1)}`.trim()));
  socket.addEventListener("message", ({ data }) => (typeof data === "string" ? hear(data) : take(data)));
  socket.addEventListener("close", ({ code, reason }) => {
    setSends(false);
    if (code === 1008) {
      setState("refused", reason);
      return;
    }
    setState("connecting", "no server: trying again");
    setTimeout(connect, retryMs);
    retryMs = Math.min(retryMs * 1.6, 5000);
  });
}

function take(data) {
  const bytes = new Uint8Array(data);
  if (bytes[0] === 1) frame.take(data);
  else terminal.reply(bytes.subarray(1));
}

function hear(text) {
  const space = text.indexOf(" ");
  const [verb, rest] = space < 0 ? [text, ""] : [text.slice(0, space), text.slice(space + 1)];
  const known = { hello: begin, title: setTitle, listeners: setListeners, depth: setDepth, stats: setStats };
  if (known[verb]) known[verb](rest);
  else if (verb === "refused") terminal.print(rest, "error");
  else if (verb === "ended") {
    terminal.reset();
    terminal.print("the connection has ended; the next line opens another", "less");
  }
}

function begin(json) {
  hello = JSON.parse(json);
  retryMs = 500;
  [earlier, shownTimes] = [undefined, []];
  const isOther = frame.width !== hello.width || frame.height !== hello.height;
  frame.begin(hello);
  if (isOther) view.fit();
  terminal.reset();
  const drives = hello.rights === "drive";
  setState("live", drives ? "watch and drive" : "watching");
  $("prompt").hidden = !(drives && hello.commands);
  $("watching").hidden = drives;
  $("log").hidden = !drives;
  $("console").hidden = drives && !hello.commands;
  $("send").hidden = !drives;
}

function setTitle(text) {
  $("title").textContent = text;
  document.title = text;
}

function setListeners(text) {
  hasListeners = text === "1";
  document.body.dataset.listeners = text;
  $("send").classList.toggle("less", !hasListeners && hello.commands);
}

function shown(sequence, number) {
  const acknowledge = () => say(`ack ${sequence}`);
  if (document.hidden) setTimeout(acknowledge, HIDDEN_EVERY_MS);
  else acknowledge();
  const now = performance.now();
  shownTimes = [...shownTimes.filter((time) => time > now - 1000), now];
  document.body.dataset.sequence = sequence;
  document.body.dataset.frame = number;
  $("facts").textContent = `${frame.width}x${frame.height}, frame ${number}, ${shownTimes.length}/s`;
  inspect();
  window.dispatchEvent(new CustomEvent("fbptr-frame", { detail: { frame, sequence, number } }));
}

/** Shows the pixel under the pointer. */
function inspect() {
  const [x, y] = pointer ? view.pixelAt(...pointer) : [-1, -1];
  const isOn = x >= 0 && y >= 0 && x < frame.width && y < frame.height;
  $("cursor").hidden = true;
  if (!isOn) {
    for (const id of ["at", "offset", "rgba", "hex", "depth"]) $(id).textContent = "-";
    return;
  }
  view.outline($("cursor"), x, y);
  const rgba = [...frame.pixel(x, y)];
  const hex = rgba.map((byte) => byte.toString(16).padStart(2, "0")).join("");
  if ($("at").textContent !== `${x}, ${y}`) $("depth").textContent = "-";
  $("at").textContent = `${x}, ${y}`;
  $("offset").textContent = (y * frame.width + x) * 4;
  $("rgba").textContent = rgba.join(" ");
  $("hex").textContent = hex;
  $("swatch").style.background = `#${hex.slice(0, 6)}`;
  probe(x, y);
}

let probeTimer;
function probe(x, y) {
  const wait = probedAt + PROBE_EVERY_MS - performance.now();
  if (wait > 0) {
    // The last pixel is asked for, even if the pointer rests.
    probeTimer ??= setTimeout(() => {
      probeTimer = undefined;
      inspect();
    }, wait);
    return;
  }
  probedAt = performance.now();
  say(`probe ${x} ${y}`);
}

function setDepth(text) {
  const [x, y, z] = text.split(" ");
  if ($("at").textContent !== `${x}, ${y}`) return;
  $("depth").textContent = z === "-" ? "none" : Number(z).toFixed(6);
}

const short = (n) => {
  const unit = [[1e9, "G"], [1e6, "M"], [1e3, "k"]].find(([size]) => n >= size);
  return unit ? `${(n / unit[0]).toFixed(1)}${unit[1]}` : String(Math.round(n));
};

function setStats(json) {
  const values = JSON.parse(json);
  const now = performance.now();
  $("server").hidden = false;
  $("clients").textContent = values.fbptr_connections;
  $("errors").textContent = values.fbptr_errors_total;
  // A server without a limit tells the largest number there is.
  const limit = values.fbptr_memory_limit_bytes;
  $("memory").textContent =
    short(values.fbptr_memory_used_bytes) + (limit <= Number.MAX_SAFE_INTEGER ? ` of ${short(limit)}` : "");
  if (earlier) {
    const seconds = (now - earlier.now) / 1000;
    const rate = (name) => short(Math.max(0, values[name] - earlier.values[name]) / seconds);
    $("commands").textContent = rate("fbptr_commands_total");
    $("pixels").textContent = rate("fbptr_pixels_total");
    $("bytes").textContent = rate("fbptr_received_bytes_total");
  }
  earlier = { now, values };
  if (!document.querySelector("details").open) return;
  const flat = Object.entries(values).flatMap(([name, value]) =>
    typeof value === "object" ? Object.entries(value).map(([at, n]) => [`${name} ${at}`, n]) : [[name, value]]);
  $("stats").replaceChildren(...flat.filter(([, n]) => n !== 0).map(([name, n]) => {
    const row = document.createElement("div");
    const [term, text] = [document.createElement("dt"), document.createElement("dd")];
    [term.textContent, term.title, text.textContent] = [name.replace("fbptr_", ""), name, n];
    row.append(term, text);
    return row;
  }));
}

function setSends(on) {
  sends = on;
  $("send").setAttribute("aria-pressed", on);
  stage.classList.toggle("sends", on);
  if (on) stage.focus();
}

function sendMouse(event) {
  say(`mouse ${view.pixelAt(event.clientX, event.clientY).join(" ")} ${buttons(event)}`);
}

stage.addEventListener("pointerdown", (event) => {
  stage.setPointerCapture(event.pointerId);
  stage.focus();
  pointer = [event.clientX, event.clientY];
  if (sends) sendMouse(event);
  else view.press(event);
  inspect();
  event.preventDefault();
});
stage.addEventListener("pointermove", (event) => {
  pointer = [event.clientX, event.clientY];
  if (sends) sendMouse(event);
  else view.drag(event);
  inspect();
});
for (const name of ["pointerup", "pointercancel"]) {
  stage.addEventListener(name, (event) => {
    if (sends) sendMouse(event);
    view.release(event);
  });
}
stage.addEventListener("pointerleave", (event) => {
  if (event.pointerType === "mouse") pointer = undefined;
  inspect();
});
stage.addEventListener("contextmenu", (event) => event.preventDefault());
stage.addEventListener("wheel", (event) => {
  event.preventDefault();
  const box = stage.getBoundingClientRect();
  if (sends) say(`wheel ${Math.sign(event.deltaX)} ${-Math.sign(event.deltaY)}`);
  else if (event.deltaY) view.step(-Math.sign(event.deltaY), event.clientX - box.left, event.clientY - box.top);
}, { passive: false });
stage.addEventListener("keydown", (event) => {
  if (!sends) {
    const act = { 0: () => view.fit(), "+": () => view.step(1), "-": () => view.step(-1) }[event.key];
    const pan = { ArrowLeft: [32, 0], ArrowRight: [-32, 0], ArrowUp: [0, 32], ArrowDown: [0, -32] }[event.key];
    if (pan) view.pan(...pan);
    act?.();
    if (act || pan) event.preventDefault();
    return;
  }
  event.preventDefault();
  if (event.key === "Escape") {
    setSends(false);
    return;
  }
  const name = keyName(event);
  if (name && !event.repeat) say(`key down ${name}`);
  const character = typed(event);
  if (character) say(`text ${character}`);
});
stage.addEventListener("keyup", (event) => {
  const name = keyName(event);
  if (sends && name) say(`key up ${name}`);
});

$("fit").addEventListener("click", () => view.fit());
$("in").addEventListener("click", () => view.step(1));
$("out").addEventListener("click", () => view.step(-1));
$("send").addEventListener("click", () => setSends(!sends));
$("png").addEventListener("click", async () => {
  const url = URL.createObjectURL(await png(frame.width, frame.height, frame.bytes));
  const link = document.createElement("a");
  [link.href, link.download] = [url, `fbptr-${document.body.dataset.frame ?? 0}.png`];
  link.click();
  setTimeout(() => URL.revokeObjectURL(url), 1000);
});
window.addEventListener("hashchange", () => location.reload());
connect();
