// A Gantt chart of an executor's modules: one lane per module, with its runs over time. A mark above a run shows that the run began late.
// Even the shortest run is drawn wide enough to be visible.

import { Canvas } from "./canvas.js";
import { element, setText } from "./dom.js";
import { colour } from "./theme.js";
import { number } from "./words.js";

const kRows = 200;
const kLane = 20, kHead = 22, kLeast = 2;
const kLetter = 6.7;
const kApart = 64;  // least distance of two lines of the grid, in pixels
const kFont = '11px ui-monospace, "DejaVu Sans Mono", Menlo, Consolas, monospace';

export class Gantt {
  #from = 0;
  #to = 1;
  #row = 0;
  #cursor = null;
  #drag = null;

  constructor(executor, programs, order) {
    this.executor = executor;
    this.count = Math.min(Math.round(executor.macro_period_ns / executor.basic_period_ns), kRows);
    this.span = this.count * executor.basic_period_ns;
    this.#lay(programs, order);
    this.left = Math.min(Math.max(...this.lanes.map((name) => name.length), 4) * kLetter + 14, 180);
    this.canvas = new Canvas((context, width, height) => this.#draw(context, width, height), {
      class: "gantt", tabindex: "0", role: "img",
      "aria-label": `runs of executor ${executor.name}; plus and minus zoom, arrows move; the tables below have the same data`,
    });
    this.canvas.element.style.height = `${kHead + this.lanes.length * kLane + 6}px`;
    this.what = element("p", { class: "what faint", role: "status", text: "" });
    const button = (text, act) => element("button", { type: "button", text, on: { click: act } });
    this.element = element("div", { class: "gantt-view" }, element("div", { class: "tools" },
      button("all rows", () => this.#show(0, this.span)), button("one row", () => this.#showRow(this.#row)),
      button("busy part of the row", () => this.#showBusy(this.#row)), button("\u2039 row", () => this.#showNext(-1)),
      button("row \u203a", () => this.#showNext(1)), button("+", () => this.#zoom(0.5)), button("\u2212", () => this.#zoom(2))),
    this.what, this.canvas.element, this.#legend());
    this.#listen();
    [this.#from, this.#to] = [0, this.span];
    this.#say(null);
  }

  redraw() {
    this.canvas.redraw();
  }

  #lay(programs, order) {
    const lanes = new Map(order.map((name) => [name, []]));
    const put = (run, more) => {
      if (!lanes.has(run.module)) lanes.set(run.module, []);
      lanes.get(run.module).push({ ...run, ...more });
    };
    for (const row of this.executor.rows) for (const run of row.runs) put(run, { row: row.row });
    for (const run of programs) put(run, { program: true });
    this.lanes = [...lanes.keys()];
    this.runs = [...lanes.values()];
    for (const runs of this.runs) runs.sort((a, b) => a.begin_ns - b.begin_ns);
  }

  /// The legend: explains the colours and marks that the chart uses.
  #legend() {
    const runs = this.runs.flat();
    const entry = (look, text, holds) => (runs.some(holds) ? element("span", {}, element("span", { class: `swatch ${look}`, "aria-hidden": "true" }), text) : null);
    return element("p", { class: "legend faint small" }, entry("thread", "thread module", (run) => !run.program && !run.sporadic),
      entry("sporadic", "sporadic", (run) => run.sporadic), entry("process", "program, on another CPU", (run) => run.program),
      entry("late", "began late", (run) => run.cause));
  }

  #listen() {
    const canvas = this.canvas.element;
    canvas.addEventListener("keydown", (event) => {
      const step = (this.#to - this.#from) / 8;
      const act = {
        "+": () => this.#zoom(0.5), "=": () => this.#zoom(0.5), "-": () => this.#zoom(2), 0: () => this.#show(0, this.span),
        ArrowLeft: () => this.#show(this.#from - step, this.#to - step), ArrowRight: () => this.#show(this.#from + step, this.#to + step),
      }[event.key];
      if (!act || event.ctrlKey || event.altKey || event.metaKey) return;
      event.preventDefault();
      act();
    });
    canvas.addEventListener("wheel", (event) => {
      if (!event.ctrlKey && !event.shiftKey) return;  // without Ctrl or Shift, the wheel scrolls the page
      event.preventDefault();
      this.#zoom(Math.exp((event.deltaY || event.deltaX) / 300), this.#time(event.offsetX));
    }, { passive: false });
    canvas.addEventListener("pointerdown", (event) => { this.#drag = { x: event.offsetX, from: this.#from, to: this.#to }; });
    canvas.addEventListener("pointermove", (event) => this.#point(event));
    for (const name of ["pointerup", "pointerleave", "pointercancel"]) {
      canvas.addEventListener(name, () => {
        this.#drag = null;
        if (name !== "pointerleave") return;
        this.#cursor = null;
        this.redraw();
      });
    }
  }

  #point(event) {
    if (this.#drag && event.buttons) {
      const width = this.canvas.element.clientWidth - this.left;
      const by = (this.#drag.x - event.offsetX) / width * (this.#drag.to - this.#drag.from);
      if (Math.abs(this.#drag.x - event.offsetX) > 3) this.#show(this.#drag.from + by, this.#drag.to + by);
      return;
    }
    this.#cursor = { x: event.offsetX, y: event.offsetY };
    const lane = Math.floor((event.offsetY - kHead) / kLane);
    const at = this.#time(event.offsetX);
    const near = kLeast * 2 * (this.#to - this.#from) / Math.max(1, this.canvas.element.clientWidth - this.left);
    const run = this.runs[lane]?.find((one) => at >= one.begin_ns - near && at <= one.end_ns + near);
    this.#row = Math.max(0, Math.min(Math.floor(at / this.executor.basic_period_ns), this.count - 1));
    this.#say(run ?? null, this.lanes[lane]);
    this.redraw();
  }

  #say(run) {
    if (!run) {
      setText(this.what, `${number(this.#from / 1e6)} to ${number(this.#to / 1e6)} ms`);
      return;
    }
    const late = run.late_ns ? `, ${number(run.late_ns / 1e3)} us late` : "";
    const where = run.program ? "a program" : run.sporadic ? `sporadic, row ${run.row}` : `row ${run.row}`;
    setText(this.what, `${run.module} (${where}) at ${number(run.begin_ns / 1e6)} ms for ${number((run.end_ns - run.begin_ns) / 1e3)} us` +
      `${late}${run.cause ? `: ${run.cause}` : ""}`);
  }

  #time(x) {
    return this.#from + (x - this.left) / Math.max(1, this.canvas.element.clientWidth - this.left) * (this.#to - this.#from);
  }

  #show(from, to) {
    const width = Math.max(1000, Math.min(to - from, this.span));  // show at least 1 us
    this.#from = Math.max(0, Math.min(from, this.span - width));
    this.#to = this.#from + width;
    this.#say(null);
    this.redraw();
  }

  #zoom(factor, about = (this.#from + this.#to) / 2) {
    this.#show(about - (about - this.#from) * factor, about + (this.#to - about) * factor);
  }

  #showRow(index) {
    this.#row = Math.max(0, Math.min(index, this.count - 1));
    this.#show(this.#row * this.executor.basic_period_ns, (this.#row + 1) * this.executor.basic_period_ns);
  }

  #showNext(way) {
    if (this.#to - this.#from < this.executor.basic_period_ns * 0.99) this.#showBusy(this.#row + way);
    else this.#showRow(this.#row + way);
  }

  /// Zooms to the busy part of a row: from its release to the end of its last run.
  #showBusy(index) {
    this.#row = Math.max(0, Math.min(index, this.count - 1));
    const row = this.executor.rows.find((one) => one.row === this.#row);  // undefined if the row was missed
    if (!row || row.runs.length === 0) {
      this.#showRow(this.#row);
      return;
    }
    const begin = Math.min(row.due_ns, ...row.runs.map((run) => run.begin_ns));
    const end = Math.max(...row.runs.map((run) => run.end_ns));
    this.#show(begin - (end - begin) * 0.05, end + (end - begin) * 0.1);
  }

  #draw(context, width, height) {
    const x = (time) => this.left + (time - this.#from) / (this.#to - this.#from) * (width - this.left);
    context.font = kFont;
    this.runs.forEach((runs, lane) => {
      context.fillStyle = colour(lane % 2 === 0 ? "panel" : "odd");
      context.fillRect(0, kHead + lane * kLane, width, kLane);
    });
    this.#drawGrid(context, x, width, height);
    context.save();
    context.beginPath();
    context.rect(this.left, 0, width - this.left, height);
    context.clip();
    this.#drawLateRows(context, x);
    this.runs.forEach((runs, lane) => this.#drawRuns(context, x, runs, kHead + lane * kLane, width));
    context.restore();
    this.#drawNames(context);
    if (!this.#cursor || this.#cursor.x < this.left) return;
    context.fillStyle = colour("faint");
    context.fillRect(this.#cursor.x, kHead, 1, height - kHead);
  }

  /// Draws a line at the release of each row, or of every 2nd, 5th, 10th and so on if the lines would be too close.
  #drawGrid(context, x, width, height) {
    const period = this.executor.basic_period_ns;
    if (width <= this.left) return;
    let every = period;
    if (this.#to - this.#from < period * 1.5) every = nice((this.#to - this.#from) / 6);
    const least = kApart * (this.#to - this.#from) / (width - this.left);
    if (every < least) every *= nice(least / every);
    context.textAlign = "left";
    context.textBaseline = "middle";
    for (let at = Math.ceil(this.#from / every) * every; at <= this.#to; at += every) {
      context.fillStyle = colour("grid");
      context.fillRect(Math.round(x(at)), 4, 1, height - 4);
      context.fillStyle = colour("faint");
      const text = `${Number((at / 1e6).toPrecision(6))}${at === 0 ? " ms" : ""}`;
      if (x(at) + text.length * kLetter < width) context.fillText(text, Math.round(x(at)) + 4, 11);
    }
  }

  #drawLateRows(context, x) {
    for (const row of this.executor.rows) {
      if (!row.cause) continue;
      context.fillStyle = colour("bad");
      hatched(context, x(row.due_ns), kHead - 6, Math.max(kLeast, x(row.begin_ns) - x(row.due_ns)), 6);
    }
  }

  #drawRuns(context, x, runs, top, width) {
    let drawn = -1;
    for (const run of runs) {
      if (run.end_ns < this.#from || run.begin_ns > this.#to) continue;
      const left = Math.max(x(run.begin_ns), this.left - 2);
      const right = Math.min(Math.max(x(run.end_ns), left + kLeast), width + 2);
      const late = run.late_ns > 0 && run.cause;
      if (right - drawn < 0.5 && !late) continue;  // hidden behind the previous run
      drawn = right;
      context.fillStyle = colour(run.program ? "process" : "thread");
      if (run.sporadic) {
        context.fillRect(left, top + 3, right - left, kLane - 6);
        context.fillStyle = colour("panel");
        if (right - left > 5) context.fillRect(left + 1.5, top + 4.5, right - left - 3, kLane - 9);
      } else {
        context.fillRect(left, top + 3, right - left, kLane - 6);
      }
      if (!late) continue;
      context.fillStyle = colour("bad");
      context.beginPath();
      context.moveTo(left, top + 4);
      context.lineTo(left + 5, top - 3);
      context.lineTo(left - 5, top - 3);
      context.fill();
    }
  }

  #drawNames(context) {
    context.textAlign = "left";
    context.textBaseline = "middle";
    context.fillStyle = colour("text");
    this.lanes.forEach((name, lane) => {
      const most = Math.floor((this.left - 10) / kLetter);
      context.fillText(name.length > most ? `${name.slice(0, most - 1)}\u2026` : name, 4, kHead + lane * kLane + kLane / 2);
    });
  }
}

function hatched(context, x, y, width, height) {
  context.save();
  context.beginPath();
  context.rect(x, y, width, height);
  context.clip();
  context.fillRect(x, y, 2, height);
  for (let at = x - height; at < x + width; at += 4) {
    context.beginPath();
    context.moveTo(at, y + height);
    context.lineTo(at + height, y);
    context.lineTo(at + height + 1.5, y);
    context.lineTo(at + 1.5, y + height);
    context.fill();
  }
  context.restore();
}

function nice(step) {
  const power = 10 ** Math.floor(Math.log10(step));
  return [1, 2, 5, 10].find((times) => times * power >= step) * power;
}
