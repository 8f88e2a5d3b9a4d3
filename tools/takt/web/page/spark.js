// A small line that shows the trend of a number over the last minutes, without a scale.

import { Canvas } from "./canvas.js";
import { colour } from "./theme.js";

/// The path of a line through pairs of a time, from 0 to `length`, and a value. NaN is a gap. The line begins at 0, or, without `zero`, at its
/// lowest value.
export function pathOf(points, length, width, height, zero) {
  const values = points.map(([, value]) => value).filter((value) => !Number.isNaN(value));
  const low = zero ? 0 : Math.min(...values);
  const range = Math.max(Math.max(...values) - low, 1e-9);  // at least 1e-9, to avoid a division by 0 if all values are equal
  return points.map(([time, value], i) => (Number.isNaN(value) ? "" : `${i > 0 && !Number.isNaN(points[i - 1][1]) ? "L" : "M"}` +
    `${(time / length * width).toFixed(1)} ${(height - 2 - (value - low) / range * (height - 4)).toFixed(1)}`)).join("");
}

/// The pairs that pathOf() takes, for one value at each of the last units of time; null is an unknown value.
export const trendOf = (values, length) => values.map((value, i) => [length - values.length + i, value ?? NaN]);

export class Spark {
  #points = [];

  /// The line shows `length` units of time.
  constructor(length, { zero = true } = {}) {
    this.canvas = new Canvas((context, width, height) => {
      context.strokeStyle = colour("accent");
      context.lineWidth = 1.25;
      context.stroke(new Path2D(pathOf(this.#points, length, width, height, zero)));
    }, { class: "spark", "aria-hidden": "true" });
    this.length = length;
    this.element = this.canvas.element;
  }

  /// Shows one value for each of the last units of time; null for an unknown value.
  show(values) {
    this.showPoints(trendOf(values, this.length));
  }

  /// Shows pairs of a time, from 0 to `length`, and a value. NaN interrupts the line.
  showPoints(points) {
    this.#points = points.filter(([, value]) => value !== null);
    this.canvas.redraw();
  }
}
