"use strict";
const $ = (id) => document.getElementById(id);
const examples = /*EXAMPLES*/[];
const text = $("text"), canvas = $("canvas"), paper = canvas.getContext("2d");
const home = () => ({ yaw: 0, pitch: 0, zoom: 1, right: 0, up: 0 });
let view = home(), turns = new Map(), trace = null, shown = null, verbs = new Map();
let stepping = false, playing = false, turning = false, last = "", worker = null, count = 0, pending = new Map(), opened = null;

// The worker, and its answers in order.
function ask(task, more = {}) {
    return new Promise((resolve, reject) => {
        const id = ++count;
        pending.set(id, [resolve, reject]);
        worker.postMessage({ id, task, ...more });
    });
}
async function open() {
    const source = new Blob([$("worker").textContent], { type: "text/javascript" });
    worker = new Worker(URL.createObjectURL(source));
    worker.onmessage = ({ data }) => {
        const [resolve, reject] = pending.get(data.id);
        pending.delete(data.id);
        if (data.error === undefined) resolve(data); else reject(new Error(data.error));
    };
    const packed = Uint8Array.from(atob($("wasm").textContent.trim()), (c) => c.charCodeAt(0));
    const { verbs: list } = await ask("open", { packed, size: Number($("wasm").dataset.bytes) });
    verbs = new Map(list.map((v) => [v.name, v]));
}

// Streams are text here; a character above U+FFFF or a NUL is a byte sequence of UTF-8 like any other.
const bytes = () => new TextEncoder().encode(text.value);
async function run(more = {}) {
    if (!worker) return;
    const changed = text.value !== last;
    if (changed && trace && !more.trace) trace = null;
    last = text.value;
    stepping = more.steps !== undefined;
    const all = [...turns].filter(([, degrees]) => degrees !== 0).map(([plane, degrees]) => [...plane.split(",").map(Number), degrees]);
    try { show(await ask("run", { bytes: bytes(), view, turns: all, trace, changed, ...more })); } catch (e) { fail(e); }
}
async function step(pace) {
    stop();
    if (!stepping || text.value !== last) return run({ steps: 1, pace });
    try { show(await ask("step", { pace })); } catch (e) { fail(e); }
}
async function play() {
    if (playing) return stop();
    playing = true;
    $("play").textContent = "Stop";
    await run({ steps: 1, pace: 2 });
    while (playing && shown && shown.state !== 2) {
        await new Promise((next) => shown.state === 1 ? setTimeout(next, shown.pause) : requestAnimationFrame(next));
        if (!playing) break;
        try { show(await ask("step", { pace: 2 })); } catch (e) { fail(e); }
    }
    stop();
}
function stop() { playing = false; turning = false; $("play").textContent = "Play"; }
// What the page opens with turns until somebody does something.
async function turn() {
    turning = !matchMedia("(prefers-reduced-motion: reduce)").matches;
    for (let then = performance.now(); turning;) {
        const now = await new Promise((next) => requestAnimationFrame(next));
        if (!turning) break;
        view.yaw += Math.min(now - then, 100) * 0.0005;
        then = now;
        await soon();
    }
}

let reported = [];
function show(answer) {
    shown = answer;
    const [width, height] = answer.size, report = answer.report;
    if (canvas.width !== width || canvas.height !== height) { canvas.width = width; canvas.height = height; fit(); }
    // A canvas composes transparent pixels with the page: shown are the colours, whatever their alpha.
    const image = new ImageData(width, height);
    image.data.set(answer.pixels);
    for (let i = 3; i < image.data.length; i += 4) image.data[i] = 255;
    paper.putImageData(image, 0, 0);
    if (!stepping || report.commands <= 1) reported = [];
    reported.push(...report.notices);
    const lines = reported.map((n) => ({ kind: n.kind, line: n.line, text: n.line ? `line ${n.line}: ${n.text}` : n.text }));
    if (report.left_out) lines.push({ kind: "error", text: `and ${report.left_out} more` });
    if (report.replies) lines.push({ kind: "reply", text: report.replies + (report.cut ? `\n... ${report.cut} bytes more` : "") });
    $("messages").replaceChildren(...lines.map((l) => {
        const div = document.createElement("div");
        div.className = l.kind;
        div.textContent = l.text;
        if (l.line) div.onclick = () => goTo(l.line);
        return div;
    }));
    gutter(new Set(reported.filter((n) => n.kind === "error").map((n) => n.line)), stepping && answer.state !== 2 ? report.line : 0);
    $("status").textContent = `${width}x${height}  crc ${answer.crc}  ${report.commands} commands` +
        (report.frames ? `  ${report.frames} frames` : "") + `  ${answer.ms.toFixed(answer.ms < 10 ? 1 : 0)} ms` + (answer.state === 2 && stepping ? "  end" : "");
    if (trace) $("inspector").textContent = report.trace || `no 3-D draw gave pixel ${trace} its colour`;
    sliders();
}
function fail(e) {
    stop();
    const div = document.createElement("div");
    div.className = "error";
    div.textContent = e.message;
    $("messages").replaceChildren(div);
}
function goTo(line) {
    const lines = text.value.split("\n"), at = lines.slice(0, line - 1).join("\n").length + (line > 1 ? 1 : 0);
    text.focus();
    text.setSelectionRange(at, at + (lines[line - 1] || "").length);
    text.scrollTop = Math.max(0, (line - 6) * 20);
}

// The editor: line numbers, and the colours of verbs beneath a transparent text.
function gutter(bad, here) {
    const rows = text.value.split("\n").length;
    $("gutter").replaceChildren(...Array.from({ length: Math.min(rows, 5000) }, (_, i) => {
        const span = document.createElement("span");
        span.textContent = i + 1;
        span.className = bad.has(i + 1) ? "bad" : i + 1 === here ? "here" : "";
        return span;
    }));
    scroll();
}
function colour() {
    const html = (s) => s.replace(/[&<>]/g, (c) => ({ "&": "&amp;", "<": "&lt;", ">": "&gt;" })[c]);
    let payload = 0;
    const line = (l) => {
        if (payload > 0) { payload -= new TextEncoder().encode(l).length + 1; return html(l); }
        if (l.startsWith("#")) return `<span class="note">${html(l)}</span>`;
        const [, blank, verb, rest] = /^(\s*)(\S*)(.*)$/.exec(l.replace(/\r$/, ""));
        const name = verb.toUpperCase(), known = verbs.size === 0 || verbs.has(name);
        const length = name === "PRINT" || name === "TITLE" ? null : /(?:^|\s):(\d+)\s*$/.exec(rest);
        if (length) payload = Number(length[1]);
        const words = html(rest).replace(/(^|\s)([a-zA-Z_@][^\s]*)/g, '$1<span class="word">$2</span>');
        return `${blank}<span class="${known ? "verb" : "none"}">${html(verb)}</span>${words}`;
    };
    $("colors").innerHTML = text.value.length < 200000 ? text.value.split("\n").map(line).join("\n") + "\n" : html(text.value);
}
function scroll() {
    $("gutter").scrollTop = $("colors").scrollTop = text.scrollTop;
    $("colors").scrollLeft = text.scrollLeft;
}
let later = 0;
text.addEventListener("scroll", scroll);
text.addEventListener("input", () => {
    colour();
    gutter(new Set(), 0);
    stop();
    clearTimeout(later);
    later = setTimeout(() => run(), 250);
});

// N-dimensional scenes: a slider for each plane of rotation.
function sliders() {
    const scene = /"dim"\s*:\s*(\d)/.exec(text.value), dim = scene ? Math.min(Number(scene[1]), 6) : 0;
    const planes = [];
    for (let b = 1; b < dim; b++) for (let a = 0; a < b; a++) planes.push(`${a},${b}`);
    if ($("turns").dataset.dim === String(dim)) return;
    $("turns").dataset.dim = dim;
    $("turns").hidden = dim === 0;
    $("turns").replaceChildren(...planes.map((plane) => {
        const label = document.createElement("label"), input = document.createElement("input");
        Object.assign(input, { type: "range", min: -180, max: 180, step: 1, value: 0 });
        input.oninput = () => { turns.set(plane, Number(input.value)); soon(); };
        label.append(`plane ${plane.replace(",", "-")} `, input);
        return label;
    }));
}

// The picture as large as its half is, the view by the mouse, the pixel under it.
function fit() {
    const box = $("screen"), wide = box.clientWidth, narrow = matchMedia("(max-width: 800px)").matches;
    const high = narrow ? Infinity : box.clientHeight;
    // From three screen pixels a pixel on, squares of one size; below, the half is filled.
    let scale = Math.min(wide / canvas.width, high / canvas.height);
    if (scale >= 3) scale = Math.floor(scale);
    canvas.style.imageRendering = Number.isInteger(scale) ? "pixelated" : "auto";
    canvas.style.width = `${canvas.width * scale}px`;
    canvas.style.height = `${canvas.height * scale}px`;
}
addEventListener("resize", fit);
let drag = null, busy = false, again = false, pointed = 0;
async function soon() {
    if (busy) { again = true; return; }
    busy = true;
    do { again = false; await run(); } while (again);
    busy = false;
}
function pixel(e) {
    const box = canvas.getBoundingClientRect();
    return [Math.floor((e.clientX - box.left) / box.width * canvas.width), Math.floor((e.clientY - box.top) / box.height * canvas.height)];
}
canvas.addEventListener("pointerdown", (e) => { turning = false; drag = { x: e.clientX, y: e.clientY, moved: false }; canvas.setPointerCapture(e.pointerId); });
canvas.addEventListener("pointermove", async (e) => {
    if (drag) {
        const [dx, dy] = [e.clientX - drag.x, e.clientY - drag.y];
        if (!drag.moved && Math.hypot(dx, dy) < 4) return;
        Object.assign(drag, { x: e.clientX, y: e.clientY, moved: true });
        if (!shown || !shown.report.spatial) return;
        if (e.shiftKey) { view.right -= dx / 400; view.up += dy / 400; } else { view.yaw -= dx / 150; view.pitch = Math.max(-1.5, Math.min(1.5, view.pitch - dy / 150)); }
        return soon();
    }
    if (trace || !shown) return;
    const [x, y] = pixel(e), [width, height] = shown.size;
    if (x < 0 || y < 0 || x >= width || y >= height) return;
    const offset = (width * y + x) * 4, rgba = [...shown.pixels.slice(offset, offset + 4)];
    const hex = rgba.map((v) => v.toString(16).padStart(2, "0")).join("");
    const line = `x ${x}  y ${y}  offset ${offset}  R ${rgba[0]} G ${rgba[1]} B ${rgba[2]} A ${rgba[3]}  #${hex}`;
    const mine = ++pointed;
    const { text: more } = await ask("inspect", { x, y }).catch(() => ({ text: "" }));
    if (mine === pointed && !trace) $("inspector").textContent = `${line}\n${more.replace("\n", "   ")}`;
});
canvas.addEventListener("pointerup", (e) => {
    const clicked = drag && !drag.moved;
    drag = null;
    if (!clicked) return;
    trace = trace ? null : pixel(e);
    if (trace) run({ trace }); else $("inspector").textContent = "";
});
canvas.addEventListener("wheel", (e) => {
    if (!shown || !shown.report.spatial) return;
    e.preventDefault();
    turning = false;
    view.zoom = Math.max(0.01, Math.min(100, view.zoom * Math.exp(e.deltaY / 600)));
    soon();
}, { passive: false });

// Links: the text behind the hash, as encodeURIComponent writes it.
const linked = () => decodeURIComponent(location.hash.slice(1));
const hint = $("inspector").textContent;
function load(content) {
    stop();
    text.value = content;
    reported = [];
    $("messages").replaceChildren();
    $("inspector").textContent = hint;
    view = home(); trace = null; turns = new Map(); $("turns").dataset.dim = "";
    colour();
    return run();
}
$("examples").append(...examples.map(([title], i) => new Option(`${i + 1}  ${title}`, i)));
$("examples").onchange = () => { history.replaceState(null, "", location.pathname + location.search); load(examples[$("examples").value][1]); };
$("run").onclick = () => { stop(); run(); };
$("step").onclick = () => step(1);
$("frame").onclick = () => step(2);
$("play").onclick = play;
$("home").onclick = () => { turning = false; view = home(); turns = new Map(); $("turns").dataset.dim = ""; trace = null; run(); };
$("png").onclick = async () => {
    const { png } = await ask("png"), a = document.createElement("a");
    a.href = URL.createObjectURL(new Blob([png], { type: "image/png" }));
    a.download = "fbptr.png";
    a.click();
};
$("link").onclick = async () => {
    location.hash = encodeURIComponent(text.value);
    try { await navigator.clipboard.writeText(location.href); $("status").textContent = "the link is copied"; } catch { $("status").textContent = "the link is in the address bar"; }
};
const find = () => {
    const wanted = $("find").value.toUpperCase();
    $("list").textContent = [...verbs.values()].filter((v) => v.help.toUpperCase().includes(wanted)).map((v) => v.help).join("\n");
};
$("help").onclick = () => { find(); $("verbs").showModal(); };
$("find").oninput = find;
$("close").onclick = () => $("verbs").close();
addEventListener("hashchange", () => { if (location.hash && linked() !== text.value) load(linked()); });
addEventListener("keydown", (e) => {
    if (e.key === "Enter" && (e.ctrlKey || e.metaKey)) { e.preventDefault(); stop(); run(); }
    if (e.key === "F10") { e.preventDefault(); step(1); }
    if (e.key === "F9") { e.preventDefault(); step(2); }
});
fit();
let start = "";
try { start = linked(); } catch { start = "# this link is cut off"; }
const moving = Math.max(0, examples.findIndex(([, content]) => content.includes("MESH knot")));
opened = open().then(() => load(start || examples[moving][1])).then(() => {
    if (!start) { $("examples").value = moving; turn(); }
}).then(() => { document.body.dataset.ready = performance.now().toFixed(0); });
opened.catch((e) => { $("status").textContent = `the engine did not start: ${e.message}`; });
