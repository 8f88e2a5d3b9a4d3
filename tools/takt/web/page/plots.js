// The view that plots the values of a port over the last five minutes, one plot for each selected field.

import { get } from "./api.js";
import { element, setText } from "./dom.js";
import { adjust, alter, currentRoute } from "./route.js";
import { TimePlot } from "./time_plot.js";

const kSpan_ms = 300000;
const kFields = 4;  // number of fields that are shown at first
const kAgain_ms = 3000;

export class Plots {
  #store;
  #port = null;
  #fields = [];
  #times = [];
  #values = [];
  #plots = new Map();  // the plot of each shown field, by its name
  #asked = false;
  #listed = "";

  constructor(store) {
    this.#store = store;
    this.port = element("select", { "aria-label": "port", on: { change: () => alter({ port: this.port.value, fields: null }) } });
    this.status = element("p", { class: "faint", role: "status" });
    this.choice = element("fieldset", { class: "fields" }, element("legend", { text: "fields" }));
    this.list = element("div", { class: "plots" });
    this.span = element("select", { "aria-label": "time span", on: { change: () => this.#span() } },
      ...[["5", "5 minutes"], ["1", "1 minute"]].map(([value, text]) => element("option", { value, text })));
    this.element = element("div", { class: "scrolled" },
      element("div", { class: "tools" }, element("label", {}, "port ", this.port), this.span, this.status), this.choice, this.list);
  }

  show(parameters) {
    this.#askPorts();
    this.span.value = parameters.get("minutes") === "1" ? "1" : "5";
    const port = parameters.get("port");
    if (port && port === this.#port) {
      this.#build();
      return;
    }
    this.hide();
    this.#port = port;
    this.#fields = [];
    this.#build();
    this.#showPort();
    if (!port) {
      setText(this.status, "Choose a port. The page then plots its values.");
      return;
    }
    setText(this.status, "waiting for values ...");
    this.#ask();
    this.timer = setInterval(() => this.#draw(), 250);  // moves the time axis even if no values arrive
  }

  hide() {
    clearInterval(this.timer);
    clearTimeout(this.again);
    if (this.#port) this.#select([]);
    this.#port = null;
    [this.#times, this.#values] = [[], this.#fields.map(() => [])];  // an animation frame that was requested earlier may still draw these arrays
  }

  update(changes) {
    // If the last request for the ports failed, ask again after each change of a device, because it may answer now.
    if (changes.cell || changes.whole || (changes.devices.size > 0 && this.#listed === "")) this.#askPorts();
    if (changes.cell && this.#port) this.#ask();  // a new cell: the gateway has dropped the chosen port
  }

  /// Handles the stream's event `port`, the description of a port. takePoints() handles the event `points`, its values.
  takePort(type) {
    if (type.port === this.#port) this.#takeType(type);
  }

  takePoints(points) {
    if (points.port === this.#port) this.#takePoints(points);
  }

  redraw() {
    for (const plot of this.#plots.values()) plot.redraw();
  }

  async #askPorts() {
    const devices = this.#store.deviceNames;
    const key = `${devices.join(" ")} ${this.#store.cell?.deployment}`;
    if (key === this.#listed || devices.length === 0) return;
    this.#listed = key;
    const answers = await Promise.allSettled(devices.map((device) => get("api/ports", { device })));
    const groups = devices.map((device, i) => {
      const ports = answers[i].status === "fulfilled" ? answers[i].value.ports : [];
      return element("optgroup", { label: device }, ...ports.map(({ name, direction, type }) =>
        element("option", { value: name, text: `${name.slice(device.length + 1)} (${direction === "out" ? "writes" : "reads"} ${type})` })));
    });
    const none = groups.every((group) => group.children.length === 0);
    if (none || answers.some(({ status }) => status === "rejected")) this.#listed = "";
    this.port.replaceChildren(element("option", { value: "", text: "choose ..." }), ...groups.filter((group) => group.children.length > 0));
    this.#showPort();
  }

  #showPort() {
    const port = this.#port ?? "";
    if (port && ![...this.port.options].some(({ value }) => value === port)) this.port.append(element("option", { value: port, text: port }));
    this.port.value = port;
  }

  #takeType({ type, fields }) {
    this.#fields = fields;
    [this.#times, this.#values] = [[], fields.map(() => [])];
    setText(this.status, type);
    this.#build();
  }

  #takePoints({ whole, times_ms, values }) {
    if (whole) [this.#times, this.#values] = [[], this.#fields.map(() => [])];
    this.#times.push(...times_ms);
    values.forEach((of, i) => this.#values[i]?.push(...of));
    const old = this.#times.findIndex((time) => time >= (this.#times.at(-1) ?? 0) - kSpan_ms - 10000);
    if (old > 500) {
      this.#times.splice(0, old);
      for (const of of this.#values) of.splice(0, old);
    }
    if (this.#asked) return;
    this.#asked = true;
    requestAnimationFrame(() => {
      this.#asked = false;
      this.#draw();
    });
  }

  /// Requests the values of the port until the gateway accepts: the port's device may start after this page.
  async #ask() {
    const port = this.#port;
    clearTimeout(this.again);
    const problem = await this.#select([port]);
    if (!problem || port !== this.#port) return;
    setText(this.status, problem);
    clearTimeout(this.again);
    this.again = setTimeout(() => this.#ask(), kAgain_ms);
  }

  /// Chooses the ports whose values the gateway sends. Returns the problem, or null.
  async #select(ports) {
    const [problem] = await this.#store.choose(ports);
    return problem ? [problem.what, problem.fix].filter(Boolean).join("; ") : null;
  }

  get #chosen() {
    const given = currentRoute().parameters.get("fields");
    if (given !== null) return new Set(given.split(",").filter(Boolean));
    return new Set(this.#fields.slice(0, kFields).map(({ name }) => name));
  }

  #build() {
    const chosen = this.#chosen;
    const boxes = this.#fields.map(({ name }) => element("label", {}, element("input", {
      type: "checkbox", checked: chosen.has(name), on: { change: (event) => this.#toggle(name, event.target.checked) } }), name));
    const focused = document.activeElement?.closest?.("fieldset.fields label")?.textContent;
    this.choice.replaceChildren(this.choice.firstChild, ...boxes);
    if (focused) boxes.find((box) => box.textContent === focused)?.firstChild.focus();
    this.choice.hidden = this.#fields.length < 2;
    this.#plots = new Map(this.#fields.filter(({ name }) => chosen.has(name)).map((field) => [field.name, new TimePlot({
      title: field.name, unit: field.unit ?? "", labels: field.labels?.length > 0 ? field.labels : null, lines: ["value"],
      span_ms: Number(this.span.value) * 60000,
    })]));
    this.list.replaceChildren(...[...this.#plots.values()].map((plot) => plot.element));
    this.#draw();
  }

  #toggle(name, on) {
    const chosen = this.#chosen;
    if (on) chosen.add(name);
    else chosen.delete(name);
    adjust({ fields: this.#fields.map((field) => field.name).filter((field) => chosen.has(field)).join(",") || "," });
    this.#build();
  }

  #span() {
    adjust({ minutes: this.span.value });
    this.#build();
  }

  #draw() {
    const end = Math.max(this.#store.now, this.#times.at(-1) ?? 0);
    this.#fields.forEach(({ name }, i) => this.#plots.get(name)?.show(this.#times, [this.#values[i]], end));
  }
}
