// Pan and zoom of the frame on the stage. Above 1 a frame's pixel is a whole number of the screen's.

/** Scales below 1, in pixels of the screen for one of the frame. */
const SMALL = [1 / 16, 1 / 12, 1 / 8, 1 / 6, 1 / 4, 1 / 3, 1 / 2, 2 / 3];
const LARGE = [1, 2, 3, 4, 5, 6, 8, 10, 12, 16, 20, 24, 32, 48, 64];
const STEPS = [...SMALL, ...LARGE];

export class View {
  constructor(stage, canvas, onChange) {
    Object.assign(this, { stage, canvas, onChange, scale: 1, x: 0, y: 0, isFitted: true });
    this.touches = new Map();
    new ResizeObserver(() => (this.isFitted ? this.fit() : this.show())).observe(stage);
  }

  /** Returns pixels of the screen in one of CSS. */
  get ratio() {
    return window.devicePixelRatio || 1;
  }

  /** Shows the whole frame, by a whole factor if it is smaller than the stage. */
  fit() {
    const { clientWidth, clientHeight } = this.stage;
    const factor = Math.min(clientWidth / this.canvas.width, clientHeight / this.canvas.height) * this.ratio;
    this.isFitted = true;
    this.scale = factor >= 1 ? Math.floor(factor) : factor;
    this.x = (clientWidth - this.css * this.canvas.width) / 2;
    this.y = (clientHeight - this.css * this.canvas.height) / 2;
    this.show();
  }

  /** Returns CSS pixels for one of the frame. */
  get css() {
    return this.scale / this.ratio;
  }

  /** Scales around a point of the stage. */
  zoomTo(scale, x, y) {
    const before = this.css;
    const limited = Math.min(Math.max(scale, STEPS[0]), STEPS.at(-1));
    this.scale = limited >= 1 ? Math.round(limited) : limited;
    this.x = x - ((x - this.x) * this.css) / before;
    this.y = y - ((y - this.y) * this.css) / before;
    this.isFitted = false;
    this.show();
  }

  /** Goes to the next larger or smaller scale. */
  step(direction, x = this.stage.clientWidth / 2, y = this.stage.clientHeight / 2) {
    const larger = STEPS.find((s) => s > this.scale * 1.001);
    const smaller = STEPS.findLast((s) => s < this.scale * 0.999);
    const next = direction > 0 ? larger : smaller;
    if (next) this.zoomTo(next, x, y);
  }

  pan(dx, dy) {
    [this.x, this.y, this.isFitted] = [this.x + dx, this.y + dy, false];
    this.show();
  }

  show() {
    const [w, h] = [this.canvas.width * this.css, this.canvas.height * this.css];
    // A strip of the frame stays on the stage.
    const strip = 32;
    this.x = Math.min(Math.max(this.x, strip - w), this.stage.clientWidth - strip);
    this.y = Math.min(Math.max(this.y, strip - h), this.stage.clientHeight - strip);
    const snap = (v) => Math.round(v * this.ratio) / this.ratio;
    this.canvas.style.transform = `translate(${snap(this.x)}px, ${snap(this.y)}px) scale(${this.css})`;
    this.onChange();
  }

  /** Returns the frame's pixel at a place in the window; it may be off the frame. */
  pixelAt(clientX, clientY) {
    const box = this.canvas.getBoundingClientRect();
    return [Math.floor((clientX - box.left) / this.css), Math.floor((clientY - box.top) / this.css)];
  }

  /** Puts an element over a pixel. */
  outline(element, x, y) {
    element.hidden = this.css < 4;
    element.style.width = element.style.height = `${this.css}px`;
    element.style.transform = `translate(${this.x + x * this.css}px, ${this.y + y * this.css}px)`;
  }

  /** Moves by a pointer's drag, or zooms by two of them. */
  drag(event) {
    const before = this.touches.get(event.pointerId);
    if (!before) return;
    const now = { x: event.clientX, y: event.clientY };
    const other = [...this.touches].find(([id]) => id !== event.pointerId)?.[1];
    this.touches.set(event.pointerId, now);
    if (!other) {
      this.pan(now.x - before.x, now.y - before.y);
      return;
    }
    const distance = (a, b) => Math.hypot(a.x - b.x, a.y - b.y) || 1;
    const box = this.stage.getBoundingClientRect();
    const middle = { x: (now.x + other.x) / 2 - box.left, y: (now.y + other.y) / 2 - box.top };
    // The scale as the fingers say, of which the shown one is the next whole number.
    this.pinched = (this.pinched ?? this.scale) * (distance(now, other) / distance(before, other));
    this.pan((now.x - before.x) / 2, (now.y - before.y) / 2);
    this.zoomTo(this.pinched, middle.x, middle.y);
  }

  press(event) {
    this.pinched = undefined;
    this.touches.set(event.pointerId, { x: event.clientX, y: event.clientY });
  }

  release(event) {
    this.pinched = undefined;
    this.touches.delete(event.pointerId);
  }
}
