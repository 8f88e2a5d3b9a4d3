// Plots numbers over the last few minutes. Each line in a plot has its own dash pattern, and the legend shows its current value.

import { Canvas } from "./canvas.js";
import { drawn, element, setAttribute, setText } from "./dom.js";
import { colour } from "./theme.js";
import { clock, number } from "./words.js";

const kDashes = [[], [6, 3], [2, 3], [9, 3, 2, 3]];
const kSame = 1e-12;  // relative difference below which two values count as equal
const kTicks = 10;    // upper bound of the number of ticks; there are at most five, because steps are rounded up
const kApart = 84;    // least distance of two labels of the time axis, in pixels
const kLetters = 10, kLeft = 76, kBottom = 20, kTop = 8, kRight = 8;
const kFont = '11px ui-monospace, "DejaVu Sans Mono", Menlo, Consolas, monospace';

export class TimePlot {
  #times = [];
  #lines = [];
  #end = 0;
  #cursor = null;  // position of the cursor, as a share of the width

  /// `lines` has the names of the lines. `labels` has the enumerators for the values 0, 1, ... of an enumeration, which is drawn as steps.
  constructor({ title, unit = "", lines, span_ms, labels = null }) {
    Object.assign(this, { title, unit, span_ms, labels, names: lines, short: labels && shortened(labels) });
    this.#lines = lines.map(() => []);
    this.canvas = new Canvas((context, width, height) => this.#draw(context, width, height), {
      class: "plot", role: "img", tabindex: "0", "aria-label": title,
      on: {
        pointermove: (event) => this.#point(event.offsetX), pointerdown: (event) => this.#point(event.offsetX),
        pointerleave: () => this.#point(null), keydown: (event) => this.#press(event), blur: () => this.#point(null),
      },
    });
    this.values = lines.map(() => element("b"));
    this.at = element("span", { class: "faint" });
    const legend = lines.flatMap((name, i) => [element("span", { class: "line" }, lines.length > 1 ? sample(kDashes[i]) : null,
      lines.length > 1 ? `${name} ` : null, this.values[i])]);
    this.element = element("figure", { class: "time-plot" },
      element("figcaption", {}, element("span", { class: "title", text: title }), ...legend, this.at), this.canvas.element);
  }

  /// Shows new values. `end` is the time at the right edge.
  show(times, lines, end) {
    [this.#times, this.#lines, this.#end] = [times, lines, end];
    this.canvas.redraw();
    this.#say();
  }

  redraw() {
    this.canvas.redraw();
  }

  #point(x) {
    const width = this.canvas.element.clientWidth - kLeft - kRight;
    this.#cursor = x === null ? null : Math.max(0, Math.min((x - kLeft) / width, 1));
    this.redraw();
    this.#say();
  }

  #press(event) {
    const way = { ArrowLeft: -0.02, ArrowRight: 0.02 }[event.key];
    if (!way) return;
    event.preventDefault();
    this.#cursor = Math.max(0, Math.min((this.#cursor ?? 1) + way, 1));
    this.redraw();
    this.#say();
  }

  /// The index of the newest value at or before the cursor.
  #index() {
    if (this.#cursor === null) return this.#times.length - 1;
    return below(this.#times, this.#end - this.span_ms * (1 - this.#cursor));
  }

  #say() {
    const i = this.#index();
    this.values.forEach((node, line) => setText(node, this.#words(this.#lines[line]?.[i])));
    setText(this.at, this.#cursor === null || i < 0 ? "" : `at ${clock(this.#times[i], { thousandths: this.span_ms < 120000 })}`);
    const words = this.names.map((name, line) => `${name} ${this.#words(this.#lines[line]?.[i])}`);
    setAttribute(this.canvas.element, "aria-label", `${this.title}: ${words.join(", ")}`);
  }

  #words(value) {
    if (value === undefined || value === null) return "-";
    if (this.labels) return this.labels[value] ?? String(value);
    return this.unit ? `${number(value)} ${this.unit}` : number(value);
  }

  #draw(context, width, height) {
    const area = { left: kLeft, top: kTop, width: width - kLeft - kRight, height: height - kTop - kBottom };
    const first = Math.max(0, below(this.#times, this.#end - this.span_ms));
    const range = this.#range(first);
    const y = (value) => area.top + area.height * (1 - (value - range.low) / (range.high - range.low));
    context.font = kFont;
    context.lineWidth = 1;
    this.#drawValues(context, area, range, y);
    this.#drawTimes(context, area);
    if (this.#times.length === 0) {
      context.fillStyle = colour("faint");
      context.textAlign = "center";
      context.fillText("no values yet", area.left + area.width / 2, area.top + area.height / 2);
      return;
    }
    context.save();
    context.beginPath();
    context.rect(area.left, area.top - 2, area.width, area.height + 4);
    context.clip();
    context.strokeStyle = colour("accent");
    context.lineWidth = 1.5;
    this.#lines.forEach((values, line) => {
      context.setLineDash(kDashes[line]);
      this.#drawLine(context, area, values, first, y);
    });
    context.restore();
    if (this.#cursor === null) return;
    context.strokeStyle = colour("text");
    context.setLineDash([]);
    const x = area.left + this.#cursor * area.width;
    context.strokeRect(x, area.top, 0.5, area.height);
  }

  #range(first) {
    if (this.labels) return { low: -0.3, high: Math.max(this.labels.length - 0.7, 0.7), ticks: this.labels.map((_, i) => i) };
    let [low, high] = [Infinity, -Infinity];
    for (const values of this.#lines) {
      for (let i = first; i < values.length; ++i) {
        if (!Number.isFinite(values[i])) continue;
        low = Math.min(low, values[i]);
        high = Math.max(high, values[i]);
      }
    }
    if (low > high) [low, high] = [0, 1];
    if (low > 0 && low < high * 0.6) low = 0;
    // Draw values that differ only by rounding errors as a constant, because no tick step could separate them.
    const size = Math.max(Math.abs(low), Math.abs(high));
    if (high - low <= size * kSame) [low, high] = size === 0 ? [-1, 1] : [low - size / 10, high + size / 10];
    const step = rounded((high - low) / 3);
    const first_tick = Math.floor(low / step);
    const count = Math.min(Math.ceil(high / step - 1e-9) - first_tick, kTicks);
    const ticks = Array.from({ length: count + 1 }, (_, i) => (first_tick + i) * step);
    return { low: first_tick * step, high: (first_tick + count) * step, ticks, step };
  }

  #drawValues(context, area, range, y) {
    context.textAlign = "right";
    context.textBaseline = "middle";
    for (const tick of range.ticks) {
      context.strokeStyle = colour("lane");
      context.beginPath();
      context.moveTo(area.left, Math.round(y(tick)) + 0.5);
      context.lineTo(area.left + area.width, Math.round(y(tick)) + 0.5);
      context.stroke();
      context.fillStyle = colour("faint");
      context.fillText(this.labels ? this.short[tick] : ticked(tick, range.step), area.left - 6, y(tick));
    }
  }

  #drawTimes(context, area) {
    context.textBaseline = "alphabetic";
    context.fillStyle = colour("faint");
    const minutes = this.span_ms / 60000;
    const every = [1, 2, 5].find((step) => area.width * step / minutes >= kApart) ?? minutes;
    for (let ago = 0; ago <= minutes; ago += every) {
      const x = area.left + area.width * (1 - ago / minutes);
      context.textAlign = ago === 0 ? "right" : ago === minutes ? "left" : "center";
      context.fillText(ago === 0 ? clock(this.#end) : `\u2212${ago} min`, x, area.top + area.height + 15);
    }
  }

  /// Draws a line. If there are more values than pixels, draws the minimum and the maximum for each pixel column, so that no peak is lost.
  #drawLine(context, area, values, first, y) {
    const x = (time) => area.left + area.width * (1 - (this.#end - time) / this.span_ms);
    const thick = this.#times.length - first > 2 * area.width;
    context.beginPath();
    let before = null;
    for (let i = first; i < values.length;) {
      const at = thick ? Math.round(x(this.#times[i])) : x(this.#times[i]);
      let [low, high, last] = [values[i], values[i], values[i]];
      for (++i; thick && i < values.length && Math.round(x(this.#times[i])) === at; ++i) {
        last = values[i];
        low = Math.min(low, last);
        high = Math.max(high, last);
      }
      if (last === null || last === undefined) {
        before = null;
        continue;
      }
      if (before === null) context.moveTo(at, y(high));
      else if (this.labels) context.lineTo(at, y(before));
      context.lineTo(at, y(high));
      if (low !== high) context.lineTo(at, y(low));
      if (low !== last) context.lineTo(at, y(last));
      before = last;
    }
    // Draw a step: an enumerator is valid until the next value.
    if (before !== null && this.labels) context.lineTo(area.left + area.width, y(before));
    context.stroke();
  }
}

/// Creates the sample line of a legend. The line is SVG, so its colour changes with the theme.
function sample(dash) {
  const line = drawn("line", { x1: 0, y1: 4, x2: 24, y2: 4, "stroke-dasharray": dash.join(" ") || "none" });
  const svg = drawn("svg", { class: "dash", width: 24, height: 8, "aria-hidden": "true" });
  svg.append(line);
  return svg;
}

/// The index of the last time at or before `at`, or -1 if there is none.
function below(times, at) {
  let [low, high] = [0, times.length];
  while (low < high) {
    const middle = (low + high) >> 1;
    if (times[middle] <= at) low = middle + 1;
    else high = middle;
  }
  return low - 1;
}

/// Rounds `step` up to 1, 2 or 5 times a power of ten.
function rounded(step) {
  const power = 10 ** Math.floor(Math.log10(step));
  return [1, 2, 5, 10].find((times) => times * power >= step * 0.999) * power;
}

function ticked(value, step) {
  if (value === 0) return "0";
  if (Math.abs(value) >= 1e6 || step < 1e-4) return value.toExponential(1);
  return value.toFixed(Math.max(0, -Math.floor(Math.log10(step) + 1e-9))).replace("-", "\u2212");
}

/// Returns the labels without their common prefix (BELT_ of BELT_RUNNING), cut to the space left of the plot.
function shortened(labels) {
  const first = labels[0] ?? "";
  let common = labels.length > 1 ? first.lastIndexOf("_") + 1 : 0;
  while (common > 0 && !labels.every((label) => label.startsWith(first.slice(0, common)))) common = first.lastIndexOf("_", common - 2) + 1;
  return labels.map((label) => label.slice(common)).map((label) => (label.length > kLetters ? `${label.slice(0, kLetters - 1)}\u2026` : label));
}
