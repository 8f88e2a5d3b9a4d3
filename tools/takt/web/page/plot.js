// Draws series over time, with the library dygraphs. Each series has a colour and a dash pattern of its own.

import { drawn, element, setAttribute } from "./dom.js";
import { colour } from "./theme.js";
import { tableOf } from "./value_rows.js";
import { clock, digits } from "./words.js";

const kColours = 8;
const kDashes = [null, [7, 3], [2, 2], [9, 3, 2, 3]];
const kSame = 1e-12;  // relative difference below which two values count as equal
const kLetters = 10;  // room for the name of an enumerator
const { Dygraph } = window;
// The page has legends of its own. Those of the library have styles in their HTML, which the page's security policy rejects.
Dygraph.PLUGINS.splice(Dygraph.PLUGINS.indexOf(Dygraph.Plugins.Legend), 1);

export const dashOf = (index) => kDashes[(index + Math.floor(index / kColours)) % kDashes.length];
export const colourOf = (index) => `series-${index % kColours + 1}`;

/// The sample line of a series in a legend. It is SVG, so its colour changes with the theme.
export function sampleOf(index) {
  return drawn("svg", { class: "dash", width: 24, height: 8, "aria-hidden": "true" },
    drawn("line", { x1: 0, y1: 4, x2: 24, y2: 4, class: colourOf(index), "stroke-dasharray": dashOf(index)?.join(" ") ?? "none" }));
}

export class Plot {
  #window = [0, 1];
  #zoomed = null;  // the ranges of values that the user has chosen, one for each axis

  /// A series has a name, `rows` and its `column` there, its `index` in the legend and, if it is an enumeration, the `labels` of 0, 1, ...
  /// Series with another `unit` than that of the first have the axis at the right.
  /// The plot calls `moved(from, to)` if the user zooms or pans, `pointed(time)` with the time under the pointer or null, and
  /// `marked(time)` after a click, and `followed()` after a double click. Without `moved`, the user cannot zoom and pan.
  constructor({ title, series, pointed, moved = null, marked = () => {}, followed = () => {} }) {
    Object.assign(this, { series, pointed, moved, held: false });
    this.canvas = element("div", { class: "canvas" });
    this.lines = ["cursor", "mark"].map((name) => element("div", { class: name, hidden: true }));
    this.element = element("div", { class: "plot", role: "img", tabindex: "0", "aria-label": title, on: {
      pointermove: (event) => { this.pointer = event; pointed(this.#time(event)); },
      pointerleave: () => { this.pointer = null; pointed(null); },
      pointerdown: (event) => {
        [this.held, this.pressed] = [true, event.clientX];
        for (const end of ["pointerup", "pointercancel"]) addEventListener(end, () => { this.held = false; }, { once: true });
      },
      click: (event) => { if (Math.abs(event.clientX - this.pressed) < 3) marked(this.#time(event)); },
      dblclick: () => { this.#zoomed = null; followed(); },
      wheel: (event) => moved && this.#turn(event), keydown: (event) => this.#press(event), blur: () => pointed(null),
    } }, this.canvas, ...this.lines);
    const labels = series[0]?.labels;
    const unit = series[0]?.unit ?? "";
    this.axes = series.map((one) => ((one.unit ?? "") === unit ? "y" : "y2"));
    const others = [...new Set(series.filter((_, i) => this.axes[i] === "y2").map((one) => one.unit ?? ""))];
    this.units = { y: unit, y2: others.length === 1 ? others[0] : "" };
    this.labels = labels && series.every((one) => String(one.labels) === String(labels)) ? labels : null;
  }

  /// Draws the values from one time to another. Returns the minimum and maximum of each series, or undefined if it has no values.
  show(from, to) {
    this.#window = [from, to];
    if (!this.element.isConnected || this.element.clientWidth === 0) return [];
    const table = tableOf(this.series, from, to);
    const extremes = this.series.map((_, i) => {
      let [low, high] = [Infinity, -Infinity];
      for (const row of table) {
        const value = row[i + 1];
        if (value === null || Number.isNaN(value) || row[0] < from || row[0] > to) continue;
        low = Math.min(low, value);
        high = Math.max(high, value);
      }
      return low <= high ? [low, high] : undefined;
    });
    const changed = { file: table.length > 0 ? table : [[from, ...this.series.map(() => null)]], dateWindow: [from, to],
      axes: Object.fromEntries(["y", "y2"].map((axis, i) => [axis, { valueRange: this.#zoomed?.[i] ?? this.#range(extremes.filter((_, k) => this.axes[k] === axis).filter(Boolean).flat()) }])) };
    this.showing = true;
    if (this.graph) this.graph.updateOptions(changed);
    else {
      this.graph = new Dygraph(this.canvas, changed.file, { ...this.#look(), ...this.#ways() });
      this.graph.updateOptions(changed);
    }
    this.showing = false;
    if (this.pointer) this.pointed(this.#time(this.pointer));  // the curves have moved under the pointer
    return extremes;
  }

  /// Shows the cursor and the mark at these times, or hides them.
  point(...times) {
    [this.cursor] = times;
    this.lines.forEach((line, i) => {
      const there = this.graph && times[i] !== null && times[i] >= this.#window[0] && times[i] <= this.#window[1];
      setAttribute(line, "hidden", !there);
      if (there) line.style.left = `${this.graph.toDomXCoord(times[i])}px`;
    });
  }

  /// Draws the plot again in the colours of the theme.
  redraw() {
    this.graph?.updateOptions(this.#look());
  }

  destroy() {
    this.graph?.destroy();
  }

  #time(event) {
    const [from, to] = this.#window;
    return this.graph ? Math.max(from, Math.min(this.graph.toDataXCoord(event.clientX - this.canvas.getBoundingClientRect().left), to)) : null;
  }

  #look() {
    return { colors: this.series.map(({ index }) => colour(colourOf(index))), gridLineColor: colour("lane"), axisLineColor: colour("grid") };
  }

  #ways() {
    const model = Dygraph.defaultInteractionModel;
    // A finger pans the time and scrolls the page, two fingers zoom the time.
    const touched = (event, graph, context) => {
      model.touchstart({ touches: event.touches, preventDefault() {} }, graph, context);
      context.touchDirections = { x: true, y: false };
    };
    return {
      labels: ["time", ...this.series.map(({ name }) => name)],
      series: Object.fromEntries(this.series.map(({ name, index, labels }, i) => [name, { strokePattern: dashOf(index), stepPlot: Boolean(labels), axis: this.axes[i] }])),
      strokeWidth: 1.5, gridLineWidth: 1, axisLineWidth: 1, axisLabelFontSize: 11, rightGap: 8, resizable: "passive",
      connectSeparatedPoints: true, highlightCircleSize: 0,
      axes: {
        x: { pixelsPerLabel: 78, axisLabelWidth: 76, ticker: Dygraph.dateTicker, axisLabelFormatter: (time, granularity) => hour(time.getTime(), granularity) },
        y: { pixelsPerLabel: 34, axisLabelWidth: 72, ticker: this.labels ? () => shortened(this.labels).map((label, v) => ({ v, label })) : this.#ticks("y") },
        y2: { pixelsPerLabel: 34, axisLabelWidth: 72, independentTicks: true, ticker: this.#ticks("y2") },
      },
      drawCallback: (graph) => {
        const [from, to] = graph.xAxisRange();
        if (!this.showing && (from !== this.#window[0] || to !== this.#window[1])) this.moved?.(from, to);
      },
      zoomCallback: (from, to, ranges) => {
        if (from === this.#window[0] && to === this.#window[1]) this.#zoomed = ranges;
      },
      interactionModel: !this.moved ? {} : { ...model, touchstart: touched, dblclick() {},
        touchend: (event, graph, context) => { if (event.touches.length > 0) touched(event, graph, context); } },
    };
  }

  /// The marks of an axis of numbers, the highest with the unit.
  #ticks(axis) {
    return (...range) => {
      const found = ticks(...range);
      const last = found.filter(({ v }) => v <= range[1]).at(-1);
      if (last && this.units[axis]) last.label += ` ${this.units[axis].replace(/[&<>]/g, "")}`;
      return found;
    };
  }

  #press(event) {
    const way = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
    if (!way || event.shiftKey || event.altKey || event.ctrlKey || event.metaKey) return;
    event.preventDefault();
    this.pointer = null;
    const [from, to] = this.#window;
    this.pointed(Math.max(from, Math.min((this.cursor ?? to) + way * (to - from) / 100, to)));
  }

  #turn(event) {
    const [from, to] = this.#window;
    if (event.ctrlKey) {
      const [at, scale] = [this.#time(event), 1.002 ** event.deltaY];
      this.moved(at - (at - from) * scale, at + (to - at) * scale);
    } else if (event.shiftKey || event.deltaX !== 0) {
      const way = (to - from) * (event.deltaX || event.deltaY) / this.element.clientWidth;
      this.moved(from + way, to + way);
    } else return;
    event.preventDefault();
  }

  /// The range of the axis of values.
  #range(values) {
    if (this.labels) return [-0.3, Math.max(this.labels.length - 0.7, 0.7)];
    if (values.length === 0) return [0, 1];
    let [low, high] = [Math.min(...values), Math.max(...values)];
    if (low > 0 && low < high * 0.6) low = 0;
    // Draw values that differ only by rounding errors as a constant, because no tick step could separate them.
    const size = Math.max(Math.abs(low), Math.abs(high));
    if (high - low <= size * kSame || size < 1e-290) return size < 1e-290 ? [-1, 1] : [low - size / 10, high + size / 10];
    const room = (high / 2 - low / 2) / 10;
    return [low === 0 ? 0 : low - room, high + room];
  }
}

/// Formats a time of the axis as exactly as the distance of the ticks requires.
function hour(time, granularity) {
  const { SECONDLY, MINUTELY } = Dygraph.Granularity;
  return granularity < SECONDLY ? clock(time, { thousandths: true }).slice(3) : granularity < MINUTELY ? clock(time) : clock(time).slice(0, 5);
}

function ticks(...range) {
  const found = Dygraph.numericTicks(...range);
  const step = found.length > 1 ? found[1].v - found[0].v : 1;
  return found.map(({ v }) => ({ v, label: ticked(v, step) }));
}

function ticked(value, step) {
  if (Math.abs(value) < step * 1e-6) return "0";
  if (Math.abs(value) >= 1e6 || step < 1e-5) return digits(value, Math.abs(value) < step * 1e3 ? 3 : 9);
  return value.toFixed(Math.max(0, -Math.floor(Math.log10(step) + 1e-9))).replace("-", "\u2212");
}

/// Returns the labels without their common prefix (BELT_ of BELT_RUNNING), cut to the space left of the plot. Dygraph takes them as HTML.
function shortened(labels) {
  const first = labels[0] ?? "";
  let common = labels.length > 1 ? first.lastIndexOf("_") + 1 : 0;
  while (common > 0 && !labels.every((label) => label.startsWith(first.slice(0, common)))) common = first.lastIndexOf("_", common - 2) + 1;
  return labels.map((label) => label.slice(common).replace(/[&<>]/g, ""))
    .map((label) => (label.length > kLetters ? `${label.slice(0, kLetters - 1)}\u2026` : label));
}
