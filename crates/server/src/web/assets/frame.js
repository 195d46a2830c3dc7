// The frame: its true bytes in an array, and an opaque copy on a canvas. A canvas multiplies colours
// by their alpha and so cannot keep the bytes of a pixel that is not opaque.

/** Returns the inflated bytes of a raw deflate stream. */
async function inflate(bytes) {
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate-raw"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

export class Frame {
  /** `onShown(sequence, frame)` is called with each frame that is on the canvas whole. */
  constructor(canvas, onShown) {
    this.canvas = canvas;
    this.context = canvas.getContext("2d", { alpha: false });
    this.onShown = onShown;
    this.width = this.height = 0;
    this.bytes = new Uint8Array(0);
    this.generation = 0;
    this.queue = Promise.resolve();
  }

  /** Begins a connection, whose frame has this size. */
  begin({ width, height, tile }) {
    this.generation += 1;
    this.pending = { sequence: -1n, tiles: [] };
    this.tile = tile;
    if (this.width === width && this.height === height) return;
    [this.width, this.height] = [width, height];
    this.bytes = new Uint8Array(width * height * 4);
    [this.canvas.width, this.canvas.height] = [width, height];
  }

  /** Takes a message with tiles. Messages are handled in order. */
  take(buffer) {
    const generation = this.generation;
    this.queue = this.queue.then(async () => {
      if (generation !== this.generation) return;
      const view = new DataView(buffer);
      const count = view.getUint16(2, true);
      const bytes = await inflate(new Uint8Array(buffer, 20 + 4 * count));
      if (generation === this.generation) this.apply(view, count, bytes);
    }).catch((error) => console.error("a frame cannot be read:", error));
  }

  apply(view, count, bytes) {
    const sequence = view.getBigUint64(4, true);
    // Parts of a frame that was given up are replaced by those of a newer one.
    if (this.pending.sequence !== sequence) this.pending = { sequence, tiles: [] };
    let at = 0;
    for (let i = 0; i < count; i += 1) {
      const place = this.place(view.getUint32(20 + 4 * i, true));
      const length = place.w * place.h * 4;
      this.pending.tiles.push([place, bytes.subarray(at, at + length)]);
      at += length;
    }
    if (view.getUint8(1) !== 1) return;
    for (const [place, tile] of this.pending.tiles) this.draw(place, tile);
    this.pending.tiles = [];
    this.onShown(sequence, view.getBigUint64(12, true));
  }

  place(index) {
    const columns = Math.ceil(this.width / this.tile);
    const x = (index % columns) * this.tile;
    const y = Math.floor(index / columns) * this.tile;
    return { x, y, w: Math.min(this.tile, this.width - x), h: Math.min(this.tile, this.height - y) };
  }

  draw({ x, y, w, h }, tile) {
    const row = w * 4;
    for (let i = 0; i < h; i += 1) {
      this.bytes.set(tile.subarray(i * row, (i + 1) * row), ((y + i) * this.width + x) * 4);
    }
    const opaque = new Uint8ClampedArray(tile);
    for (let i = 3; i < opaque.length; i += 4) opaque[i] = 255;
    this.context.putImageData(new ImageData(opaque, w, h), x, y);
  }

  /** Returns the bytes of a pixel: R, G, B, A. */
  pixel(x, y) {
    const at = (y * this.width + x) * 4;
    return this.bytes.subarray(at, at + 4);
  }
}
