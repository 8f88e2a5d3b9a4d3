// The view that plots the values of ports. The page's address keeps which series, which range, and whether the plots stand still.

import { get } from "./api.js";
import { element, setAttribute, setText } from "./dom.js";
import { Plot, sampleOf } from "./plot.js";
import { csvOf, download, pictureOf } from "./plot_export.js";
import { portOf } from "./ports.js";
import { adjust } from "./route.js";
import { clock, digits, duration, instant, listed } from "./words.js";

const kSpans_s = [1, 10, 60, 300, 900, 3600, 14400];
const kSpan_s = 300;
const kFields = 4;  // number of fields of a port that are shown at first
const kPorts = 8;   // limit of the ports of a page
const kLongest_ms = 4 * 3600000, kShortest_ms = 100;
const kTick_ms = 100;
const kRedraw_ms = 5000;  // curves are drawn at least this often, even if they have not yet moved by a pixel
const kValues = ["value", "minimum", "maximum", "at mark", "difference"];
const kHint = "Drag to zoom, Shift+drag or a finger to pan, Ctrl+wheel or two fingers to zoom, click to mark, double-click to follow. "
  + "Keys on a plot: \u2190 \u2192 cursor, Enter mark, Shift+\u2190 \u2192 pan, + \u2212 zoom, Space pause, Home follow.";

export class Plots {
  insists = true;
  #store;
  #ports = [];          // names of the ports
  #chosen = [];         // names of the series
  #series = [];         // those that are known
  #plots = [];
  #span_ms = kSpan_s * 1000;
  #range_ms = this.#span_ms;  // the span before the user zoomed
  #end = null;          // the time at the right edge; null: now
  #cursor = null;
  #mark = null;
  #stacked = false;
  #new = null;          // a port whose first fields are to be shown as soon as they are known
  #listed = "";

  constructor(store) {
    this.#store = store;
    this.port = element("select", { on: { change: () => this.#add(this.port.value) } });
    this.status = element("p", { class: "faint", role: "status" });
    this.span = element("select", { "aria-label": "range", on: { change: () => this.#move(Number(this.span.value) * 1000, this.#end, true) } },
      ...kSpans_s.map((s) => element("option", { value: s, text: spanText(s * 1000) })), element("option", { value: "", hidden: true }));
    const button = (text, click, attributes = {}) => element("button", { type: "button", text, ...attributes, on: { click } });
    this.pause = button("pause", () => this.#move(this.#span_ms, this.#end === null ? this.#now : null));
    this.stack = button("stacked", () => this.#change(() => { this.#stacked = !this.#stacked; }));
    this.exports = [button("CSV", () => this.#export("csv"), { title: "save the values in this range as a table" }),
      button("PNG", () => this.#export("png"), { title: "save the plots as a picture" })];
    this.list = element("div", { class: "plots", on: { keydown: (event) => this.#press(event) } });
    this.at = element("p", { class: "at" });
    this.body = element("tbody");
    this.legend = element("table", { class: "legend-table" }, element("thead", {}, element("tr", {},
      ...["series", ...kValues].map((text) => element("th", { scope: "col", text })))), this.body);
    this.hint = element("p", { class: "faint small", text: kHint });
    this.choice = element("div", { class: "choice" });
    this.element = element("div", { class: "scrolled" },
      element("div", { class: "tools" }, element("label", {}, "add ", this.port), this.span, this.pause, this.stack, ...this.exports, this.status),
      this.list, this.at, this.legend, this.hint, this.choice);
    new ResizeObserver(() => this.#soon()).observe(this.list);
  }

  show(parameters) {
    this.#askPorts();
    const names = (parameters.get("series") ?? "").split(",").filter((name) => name.split(".").length > 3);
    const ports = [...new Set(names.map(portOf))].slice(0, kPorts);
    this.#chosen = names.filter((name) => ports.includes(portOf(name)));
    this.#new = parameters.get("port");
    if (this.#new && ports.length < kPorts) ports.push(this.#new);
    const span_ms = Number(parameters.get("range")) * 1000;
    this.#range_ms = this.#span_ms = span_ms >= kShortest_ms && span_ms <= kLongest_ms ? span_ms : kSpan_s * 1000;
    const at = Number(parameters.get("at")) || null;  // the instant that the user chose on the strip of time is in the middle
    this.#end = Number(parameters.get("end")) || (at && Math.min(at + this.#span_ms / 2, this.#store.now));
    this.#stacked = parameters.get("stacked") === "1";
    [this.#cursor, this.#mark] = [null, at];
    this.#follow(ports);
    clearInterval(this.timer);
    this.timer = setInterval(() => this.#tick(), kTick_ms);  // moves the time axis even if no values arrive
  }

  hide() {
    clearInterval(this.timer);
    this.#follow([]);
  }

  update(changes) {
    // If the last request for the ports failed, ask again after each change of a device, because it may answer now.
    if (changes.cell || changes.whole || (changes.devices.size > 0 && this.#listed === "")) this.#askPorts();
  }

  /// The port's fields are known.
  described(port) {
    if (port === this.#new || !this.#chosen.some((name) => portOf(name) === port)) {
      const { fields } = this.#store.ports.get(port);
      if (port === this.#new) this.#new = null;
      this.#chosen.push(...fields.slice(0, kFields).map(({ name }) => `${port}.${name}`).filter((name) => !this.#chosen.includes(name)));
      this.#save();
    }
    this.#build();
  }

  answered() {
    const name = this.#ports.find((port) => this.#store.ports.problem(port));
    const problem = this.#store.ports.problem(name) ?? this.#store.ports.problem("");
    if (this.#ports.length === 0 || !(problem || this.refused)) return;
    this.refused = Boolean(problem);
    setText(this.status, problem ? [problem.what, problem.fix].filter(Boolean).join("; ") : "waiting for values ...");
  }

  redraw() {
    for (const plot of this.#plots) plot.redraw();
  }

  async #askPorts() {
    const devices = this.#store.deviceNames;
    const key = `${devices.join(" ")} ${this.#store.cell?.deployment}`;
    if (key === this.#listed || devices.length === 0) return;
    this.#listed = key;
    const answers = await Promise.allSettled(devices.map((device) => get("api/ports", { device })));
    const groups = devices.map((device, i) => {
      const ports = answers[i].status === "fulfilled" ? answers[i].value.ports : [];
      return element("optgroup", { label: device }, ...ports.filter(({ direction }) => direction === "out").map(({ name, type }) =>
        element("option", { value: name, text: `${name.slice(device.length + 1)} (${type})` })));
    });
    const none = groups.every((group) => group.children.length === 0);
    if (none || answers.some(({ status }) => status === "rejected")) this.#listed = "";
    this.port.replaceChildren(element("option", { value: "", text: "a port ..." }), ...groups.filter((group) => group.children.length > 0));
  }

  #add(port) {
    this.port.value = "";
    if (!port || this.#ports.includes(port)) return;
    if (this.#ports.length === kPorts) setText(this.status, `A page plots at most ${kPorts} ports. Remove one first.`);
    else this.#follow([...this.#ports, port]);
  }

  #remove(port) {
    this.#chosen = this.#chosen.filter((name) => portOf(name) !== port);
    this.#follow(this.#ports.filter((one) => one !== port));
    this.#save();
  }

  /// Requests the values of these ports.
  #follow(ports) {
    const known = ports.filter((port) => !this.#ports.includes(port) && this.#store.ports.get(port)?.fields);
    this.#ports = ports;
    if (ports.length > 0) setText(this.status, "waiting for values ...");
    this.#store.ports.want(this, ports);
    this.#build();
    for (const port of known) this.described(port);  // another part of the page shows the port, too
    this.answered();
  }

  #change(change) {
    change();
    this.#save();
    this.#build();
  }

  #save() {
    adjust({ port: null, series: this.#chosen.join(",") || null, range: this.#span_ms === kSpan_s * 1000 ? null : this.#span_ms / 1000,
      end: this.#end && Math.round(this.#end), ...(this.#end ? {} : { at: null }), stacked: this.#stacked ? "1" : null });
  }

  /// Makes the plots, the legend and the choice of fields.
  #build() {
    for (const plot of this.#plots) plot.destroy();
    this.#series = this.#chosen.map((name, index) => {
      const port = portOf(name);
      const { rows, fields } = this.#store.ports.get(port) ?? {};
      const column = (fields ?? []).findIndex((field) => `${port}.${field.name}` === name);
      const { labels, unit } = fields?.[column] ?? {};
      return { name, port, index, rows, column: column + 1, labels, unit, title: unit ? `${name} (${unit})` : name };
    }).filter(({ column }) => column > 0);
    if (this.#ports.length === 0) setText(this.status, "Choose a port. The page then plots its values.");
    const unknown = this.#chosen.filter((name) => this.#store.ports.get(portOf(name))?.fields && !this.#series.some((series) => series.name === name));
    if (unknown.length > 0) setText(this.status, `${listed(unknown)}: the port has no such field`);
    const groups = this.#stacked ? this.#series.map((one) => [one]) : [this.#series].filter((all) => all.length > 0);
    this.#plots = groups.map((series) => new Plot({
      title: series.map(({ title }) => title).join(", "), series,
      moved: (from, to) => this.#move(to - from, to, false), followed: () => this.#move(this.#range_ms, null),
      pointed: (time) => this.#point(time), marked: (time) => this.#setMark(time),
    }));
    const focused = document.activeElement?.closest?.(".plot") ? ".plot" : document.activeElement?.closest?.(".choice label")?.dataset.name;
    this.list.replaceChildren(...this.#plots.map((plot) => element("figure", {},
      this.#stacked ? element("figcaption", {}, sampleOf(plot.series[0].index), plot.series[0].title) : null, plot.element)));
    setAttribute(this.list, "data-stacked", this.#stacked);
    this.cells = this.#series.map(() => kValues.map((label) => element("td", { class: "number", "data-label": label })));
    this.body.replaceChildren(...this.#series.map(({ title, index }, i) => element("tr", {},
      element("th", { scope: "row" }, sampleOf(index), title), ...this.cells[i])));
    this.choice.replaceChildren(...this.#ports.map((port) => [port, this.#store.ports.get(port) ?? {}]).map(([port, { type, fields }]) => element("fieldset", { class: "fields" },
      element("legend", {}, `${port}${type ? ` (${type})` : ""}`),
      ...(fields ?? []).map(({ name }) => element("label", { dataset: { name: `${port}.${name}` } }, element("input", {
        type: "checkbox", checked: this.#chosen.includes(`${port}.${name}`),
        on: { change: (event) => this.#change(() => this.#toggle(`${port}.${name}`, event.target.checked)) } }), name)),
      element("button", { type: "button", text: "remove", "aria-label": `remove ${port}`, on: { click: () => this.#remove(port) } }))));
    if (focused === ".plot") this.list.querySelector(".plot")?.focus();
    else if (focused) [...this.choice.querySelectorAll("label")].find((label) => label.dataset.name === focused)?.firstChild.focus();
    for (const one of [this.legend, this.hint]) one.hidden = this.#series.length === 0;
    for (const one of [...this.exports, this.pause, this.stack]) one.disabled = this.#series.length === 0;
    setAttribute(this.stack, "aria-pressed", String(this.#stacked));
    this.#showRange();
    this.#soon();
  }

  #toggle(name, on) {
    // The series of a port keep the order of its fields.
    const wanted = new Set(on ? [...this.#chosen, name] : this.#chosen.filter((one) => one !== name));
    this.#chosen = this.#ports.flatMap((port) => (this.#store.ports.get(port)?.fields ?? []).map((field) => `${port}.${field.name}`)).filter((one) => wanted.has(one));
  }

  get #now() {
    return Math.max(this.#store.now, ...this.#series.map(({ rows }) => rows.newest));
  }

  get #to() {
    return this.#end ?? this.#now;
  }

  /// Shows another range. `chosen` is true if the user chose its length from the list, and false if the user zoomed.
  #move(span_ms, end, chosen = false) {
    const middle = end === null ? null : end - this.#span_ms / 2;
    this.#span_ms = Math.max(kShortest_ms, Math.min(span_ms, kLongest_ms));
    if (chosen) this.#range_ms = this.#span_ms;
    this.#end = end === null ? null : Math.min(end, this.#now + this.#span_ms / 2);
    if (chosen && middle !== null) this.#end = Math.min(middle + this.#span_ms / 2, this.#now);
    this.#save();
    this.#showRange();
    this.#soon();
  }

  #showRange() {
    const s = this.#span_ms / 1000;
    const other = this.span.lastChild;
    if (!kSpans_s.includes(s)) setText(other, spanText(this.#span_ms));
    this.span.value = kSpans_s.includes(s) ? String(s) : "";
    setAttribute(this.pause, "aria-pressed", String(this.#end !== null));
  }

  #press(event) {
    if (!event.target.classList.contains("plot") || event.altKey || event.ctrlKey || event.metaKey) return;
    const [to, span] = [this.#to, this.#span_ms];
    const way = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
    const scale = { "+": 0.5, "=": 0.5, "-": 2 }[event.key];
    if (way && !event.shiftKey) return;  // moves the cursor
    if (way) this.#move(span, to + way * span / 10);
    else if (scale) {
      const at = this.#cursor ?? to - span / 2;
      this.#move(span * scale, this.#end === null && this.#cursor === null ? null : at + (to - at) * scale);
    } else if (event.key === "Enter") this.#setMark(this.#cursor ?? to);
    else if (event.key === " ") this.pause.click();
    else if (event.key === "Home") this.#move(this.#range_ms, null);
    else return;
    event.preventDefault();
  }

  #point(time) {
    this.#cursor = time;
    this.#say();
  }

  /// Sets the mark, or removes it if it is there already.
  #setMark(time) {
    this.#mark = this.#mark !== null && Math.abs(time - this.#mark) < this.#span_ms / 200 ? null : time;
    this.#say();
  }

  /// Draws again if new values have moved the curves by a pixel.
  #tick() {
    if (this.settled || this.#plots.some((plot) => plot.held)) return;
    const age_ms = performance.now() - (this.drawn ?? 0);
    if (age_ms >= Math.min(kRedraw_ms, this.#span_ms / 800)) this.#draw();
    else if (age_ms % 500 < kTick_ms) this.#say();
  }

  #soon() {
    if (this.asked) return;
    this.asked = true;
    requestAnimationFrame(() => {
      this.asked = false;
      this.#draw();
    });
  }

  #draw() {
    if (!this.element.isConnected) return;
    this.drawn = performance.now();
    const to = this.#to;
    this.extremes = this.#plots.flatMap((plot) => plot.show(to - this.#span_ms, to));
    this.settled = this.#end !== null && this.#series.every(({ rows }) => rows.newest > this.#end);
    if (this.#series.length > 0 && /^(waiting|no values)/.test(this.status.textContent)) setText(this.status, this.extremes.every(Boolean) ? "" : this.#missing(to));
    this.#say();
  }

  #missing(to) {
    const late = this.#series.find(({ rows }) => rows.oldest > to && rows.oldest < Infinity);
    return late ? `no values of ${late.name} before ${instant(late.rows.oldest)}` : "waiting for values ...";
  }

  /// Shows the cursor, the mark, and the values there.
  #say() {
    for (const plot of this.#plots) plot.point(this.#cursor, this.#mark);
    const at = this.#cursor ?? this.#to;
    const words = (time) => clock(time, { thousandths: this.#span_ms < 120000 });
    setText(this.at, this.#series.length === 0 ? "" : [this.#cursor === null && this.#end === null ? `now, ${words(at)}` : `at ${words(at)}`,
      ...this.#mark === null ? [] : [`mark at ${words(this.#mark)}`, `${duration((at - this.#mark) * 1e3)} between them`]].join("; "));
    setAttribute(this.legend, "data-marked", this.#mark !== null);
    this.#series.forEach(({ rows, column, labels }, i) => {
      const of = (value) => (value === undefined || value === null ? "-" : labels?.[value] ?? digits(value));
      const value = rows.at(at)?.[column];
      const marked = this.#mark === null ? null : rows.at(this.#mark)?.[column] ?? null;
      const [low, high] = this.extremes?.[i] ?? [];
      const difference = marked === null || value === null || value === undefined || labels ? null : value - marked;
      [value, low, high, marked].forEach((one, place) => setText(this.cells[i][place], of(one)));
      setText(this.cells[i][4], digits(difference));
    });
  }

  async #export(kind) {
    const to = this.#to;
    const content = kind === "csv" ? new Blob([csvOf(this.#series, to - this.#span_ms, to)], { type: "text/csv" })
      : await pictureOf(this.#plots, this.#series);
    download(content, `takt-${clock(to).replaceAll(":", "")}.${kind}`);
  }
}

function spanText(ms) {
  if (ms % 3600000 === 0) return `${ms / 3600000} h`;
  if (ms % 60000 === 0) return `${ms / 60000} min`;
  return ms < 1000 ? `${digits(ms, 3)} ms` : ms < 60000 ? `${digits(ms / 1000, 3)} s` : duration(ms * 1e3);
}
