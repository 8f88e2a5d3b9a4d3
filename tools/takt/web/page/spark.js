// A small line that shows the trend of a number over the last minutes, without a scale.

import { Canvas } from "./canvas.js";
import { colour } from "./theme.js";

export class Spark {
  #points = [];

  /// The line shows `length` units of time. It begins at 0, or, without `zero`, at the least value.
  constructor(length, { zero = true } = {}) {
    Object.assign(this, { length, zero });
    this.canvas = new Canvas((context, width, height) => this.#draw(context, width, height),
      { class: "spark", "aria-hidden": "true" });
    this.element = this.canvas.element;
  }

  /// Shows one value for each of the last units of time; null for an unknown value.
  show(values) {
    this.showPoints(values.map((value, i) => [this.length - values.length + i, value ?? NaN]));
  }

  /// Shows pairs of a time, from 0 to `length`, and a value. NaN interrupts the line.
  showPoints(points) {
    this.#points = points.filter(([, value]) => value !== null);
    this.canvas.redraw();
  }

  #draw(context, width, height) {
    const values = this.#points.map(([, value]) => value).filter((value) => !Number.isNaN(value));
    if (values.length < 2) return;
    const low = this.zero ? 0 : Math.min(...values);
    const range = Math.max(Math.max(...values) - low, 1e-9);  // at least 1e-9, to avoid a division by 0 if all values are equal
    context.strokeStyle = colour("accent");
    context.lineWidth = 1.25;
    context.beginPath();
    let drawn = false;
    for (const [time, value] of this.#points) {
      const [x, y] = [time / this.length * width, height - 2 - (value - low) / range * (height - 4)];
      if (drawn && !Number.isNaN(value)) context.lineTo(x, y);
      else if (!Number.isNaN(value)) context.moveTo(x, y);
      drawn = !Number.isNaN(value);
    }
    context.stroke();
  }
}
