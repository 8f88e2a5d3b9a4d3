// A viewport for a drawing. At first it shows the whole drawing, or the upper left part if the text of the whole drawing would be too small.
// The user moves and zooms the drawing by touch, mouse wheel, keys or buttons.

import { element } from "./dom.js";

const kClosest = 4;      // maximum zoom, relative to the drawing's own size
const kLegible = 1;      // at a smaller scale, the text of the drawing is too small
const kStep = 1.25;
const kAside = 60;       // pixels that an arrow key moves the drawing
const kClick = 5;        // a pointer movement up to this many pixels is a click

export class Frame {
  #drawing = null;
  #width = 1;
  #height = 1;
  #scale = 1;
  #x = 0;
  #y = 0;
  #fits = true;   // the scale follows the size of the surface
  #whole = false;  // the user asked for the whole drawing
  #kept = null;   // the part that stays visible when the size of the surface changes
  #pointers = new Map();
  #way = 0;

  /// `viewed` is called when another part of the drawing is visible. `buttons` stand beside those that zoom.
  constructor(viewed, ...buttons) {
    this.viewed = viewed;
    const button = (text, label, act) =>
      element("button", { type: "button", text, "aria-label": label, title: label, on: { click: act } });
    this.surface = element("div", {
      class: "surface", tabindex: "0", role: "group",
      "aria-label": "graph of the cell; the arrow keys move it, plus and minus zoom, 0 shows all of it",
    });
    this.element = element("div", { class: "frame" }, element("div", { class: "tools" }, ...buttons,
      button("+", "zoom in", () => this.zoom(kStep)), button("\u2212", "zoom out", () => this.zoom(1 / kStep)),
      button("fit", "fit the whole drawing", () => this.fit())), this.surface);
    this.surface.addEventListener("wheel", (event) => this.#wheel(event), { passive: false });
    this.surface.addEventListener("keydown", (event) => this.#press(event));
    this.surface.addEventListener("pointerdown", (event) => this.#down(event));
    this.surface.addEventListener("pointermove", (event) => this.#move(event));
    for (const name of ["pointerup", "pointercancel"]) this.surface.addEventListener(name, (event) => this.#up(event));
    new ResizeObserver(() => (this.#fits ? this.#adapt() : this.#place())).observe(this.surface);
  }

  /// True if the last press of the pointer dragged the drawing, and so was not a click.
  get moved() {
    return this.#way > kClick;
  }

  hold(drawing) {
    this.#drawing = drawing;
    const box = (drawing.getAttribute("viewBox") ?? "0 0 100 100").split(/[ ,]+/).map(Number);
    [this.#width, this.#height] = [box[2], box[3]];
    drawing.removeAttribute("viewBox");
    this.surface.replaceChildren(drawing);
    this.#whole = false;
    this.#kept = null;
    this.#adapt();
  }

  get scale() {
    return this.#scale;
  }

  /// True if this point of the drawing is visible.
  shows(x, y) {
    const [across, down] = [x * this.#scale + this.#x, y * this.#scale + this.#y];
    return across >= 0 && down >= 0 && across <= this.surface.clientWidth && down <= this.surface.clientHeight;
  }

  /// Keeps `node`, a part of the drawing, visible when the size of the surface changes. `node` may be null.
  keep(node) {
    this.#kept = node;
  }

  fit() {
    this.#whole = true;
    this.#adapt();
  }

  #adapt() {
    this.#fits = true;
    const across = (this.surface.clientWidth || 1) / this.#width;
    const whole = Math.min(across, (this.surface.clientHeight || 1) / this.#height, kClosest);
    this.#scale = this.#whole || whole >= kLegible ? whole : Math.max(kLegible, Math.min(across, 1));
    [this.#x, this.#y] = [0, 0];
    this.#place();
    if (!this.#kept) return;
    this.reveal(this.#kept);
    this.#fits = true;
  }

  /// Zooms by a factor. The point (x, y) of the surface stays where it is; by default this is the centre.
  zoom(factor, x = this.surface.clientWidth / 2, y = this.surface.clientHeight / 2) {
    const least = Math.min(this.surface.clientWidth / this.#width, this.surface.clientHeight / this.#height, 1) * 0.9;
    const scale = Math.max(least, Math.min(this.#scale * factor, kClosest));
    const by = scale / this.#scale;
    this.#x = x - (x - this.#x) * by;
    this.#y = y - (y - this.#y) * by;
    this.#scale = scale;
    this.#fits = false;
    this.#place();
  }

  /// Moves the drawing until `node` is visible, and no further.
  reveal(node) {
    const box = node.getBoundingClientRect();
    const here = this.surface.getBoundingClientRect();
    const over = (low, high, from, to) => (low < from ? from - low : high > to ? to - high : 0);
    this.#shift(over(box.left, box.right, here.left, here.right), over(box.top, Math.min(box.bottom, box.top + 120), here.top, here.bottom));
  }

  #shift(dx, dy) {
    if (dx === 0 && dy === 0) return;
    this.#x += dx;
    this.#y += dy;
    this.#fits = false;
    this.#place();
  }

  /// Limits the position, so that the drawing stays visible, and applies position and scale.
  #place() {
    if (!this.#drawing) return;
    const held = (at, size, of) => (size <= of ? Math.max(0, Math.min(at, of - size)) : Math.max(of - size, Math.min(at, 0)));
    const [width, height] = [this.#width * this.#scale, this.#height * this.#scale];
    this.#x = width <= this.surface.clientWidth ? (this.surface.clientWidth - width) / 2 : held(this.#x, width, this.surface.clientWidth);
    this.#y = held(this.#y, height, this.surface.clientHeight);
    this.#drawing.setAttribute("width", width);
    this.#drawing.setAttribute("height", height);
    this.#drawing.setAttribute("viewBox", `0 0 ${this.#width} ${this.#height}`);
    this.#drawing.style.transform = `translate(${this.#x}px, ${this.#y}px)`;
    this.viewed();
  }

  #wheel(event) {
    event.preventDefault();
    const here = this.surface.getBoundingClientRect();
    this.zoom(Math.exp(-event.deltaY / 500), event.clientX - here.left, event.clientY - here.top);
  }

  #press(event) {
    if (event.ctrlKey || event.altKey || event.metaKey) return;
    const act = {
      "+": () => this.zoom(kStep), "=": () => this.zoom(kStep), "-": () => this.zoom(1 / kStep), 0: () => this.fit(),
      ArrowLeft: () => this.#shift(kAside, 0), ArrowRight: () => this.#shift(-kAside, 0),
      ArrowUp: () => this.#shift(0, kAside), ArrowDown: () => this.#shift(0, -kAside),
    }[event.key];
    if (!act || (event.target !== this.surface && event.key.startsWith("Arrow"))) return;
    event.preventDefault();
    act();
  }

  #down(event) {
    if (this.#pointers.size === 0) this.#way = 0;
    this.#pointers.set(event.pointerId, { x: event.clientX, y: event.clientY });
  }

  #move(event) {
    const before = this.#pointers.get(event.pointerId);
    if (!before) return;
    const [dx, dy] = [event.clientX - before.x, event.clientY - before.y];
    this.#way += Math.hypot(dx, dy);
    if (this.moved && !this.surface.hasPointerCapture(event.pointerId)) this.surface.setPointerCapture(event.pointerId);
    const others = [...this.#pointers].filter(([id]) => id !== event.pointerId).map(([, at]) => at);
    this.#pointers.set(event.pointerId, { x: event.clientX, y: event.clientY });
    if (others.length === 0) {
      if (this.moved) this.#shift(dx, dy);
      return;
    }
    const other = others[0];
    const here = this.surface.getBoundingClientRect();
    const far = (at) => Math.max(10, Math.hypot(at.x - other.x, at.y - other.y));
    this.zoom(far({ x: event.clientX, y: event.clientY }) / far(before),
      (event.clientX + other.x) / 2 - here.left, (event.clientY + other.y) / 2 - here.top);
    this.#shift(dx / 2, dy / 2);
  }

  #up(event) {
    this.#pointers.delete(event.pointerId);
  }
}
