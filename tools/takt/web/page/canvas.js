// A canvas that has the resolution of the screen and fills its space on the page. When either changes, the canvas redraws itself.

import { element } from "./dom.js";

export class Canvas {
  // A ResizeObserver sets this size. Reading the size from the element would force a layout each time.
  #width = 0;
  #height = 0;

  /// The canvas calls `draw(context, width, height)` to redraw itself. Sizes are in CSS pixels.
  constructor(draw, attributes = {}) {
    this.draw = draw;
    this.element = element("canvas", attributes);
    new ResizeObserver(([{ contentRect }]) => {
      [this.#width, this.#height] = [contentRect.width, contentRect.height];
      this.redraw();
    }).observe(this.element);
  }

  redraw() {
    const [width, height] = [this.#width, this.#height];
    if (width === 0 || height === 0) return;
    const sharp = window.devicePixelRatio || 1;
    const [across, down] = [Math.round(width * sharp), Math.round(height * sharp)];
    if (this.element.width !== across || this.element.height !== down) {
      this.element.width = across;
      this.element.height = down;
    }
    const context = this.element.getContext("2d");
    context.setTransform(sharp, 0, 0, sharp, 0, 0);
    context.clearRect(0, 0, width, height);
    this.draw(context, width, height);
  }
}
