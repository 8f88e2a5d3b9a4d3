// A small line that shows the trend of a number over the last two minutes, without a scale.

import { Canvas } from "./canvas.js";
import { colour } from "./theme.js";

export class Spark {
  #values = [];

  constructor(length) {
    this.length = length;
    this.canvas = new Canvas((context, width, height) => this.#draw(context, width, height),
      { class: "spark", "aria-hidden": "true" });
    this.element = this.canvas.element;
  }

  show(values) {
    this.#values = values;
    this.canvas.redraw();
  }

  #draw(context, width, height) {
    const values = this.#values;
    if (values.length < 2) return;
    const top = Math.max(...values, 1e-9);  // at least 1e-9, to avoid a division by 0 if all values are 0 or unknown
    const step = width / (this.length - 1);
    const from = this.length - values.length;
    context.strokeStyle = colour("accent");
    context.lineWidth = 1.25;
    context.beginPath();
    let drawn = false;
    values.forEach((value, i) => {
      const [x, y] = [(from + i) * step, height - 2 - (value / top) * (height - 4)];
      if (value !== null && drawn) context.lineTo(x, y); else if (value !== null) context.moveTo(x, y);
      drawn = value !== null;
    });
    context.stroke();
  }
}
