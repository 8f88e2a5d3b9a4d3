// Shows the details of a module: its state and the reason for it, commands, measurements, ports and properties.

import { get } from "./api.js";
import { Bar, element, Mark, setText } from "./dom.js";
import { Distributions, Facts } from "./facts.js";
import { LastFaults } from "./last_faults.js";
import { lookOfModule, useOf } from "./looks.js";
import { Commands } from "./commands.js";
import { Properties } from "./properties.js";
import { Plot, sampleOf } from "./plot.js";
import { PortList } from "./port_list.js";
import { addressOf } from "./route.js";
import { ValueRows } from "./value_rows.js";
import { clock, count, exact, instant, number } from "./words.js";

const kSpan_ms = 600000;
const kAgain_ms = 2000;
const kRows = 10;  // rows of the table that are listed
const kLines = ["p50", "p99"];
const kMeasures = ["jitter", "run"];

export class ModuleDetails {
  #store;
  #name = null;
  #rows = new ValueRows();  // p50 and p99 of the jitter and of the run time
  #component = null;  // its file, version and hash; null: not known yet

  constructor(store) {
    this.#store = store;
    this.mark = new Mark("p");
    this.why = element("p", { class: "why" });
    this.facts = new Facts();
    this.component = new Facts();
    this.use = new Bar();
    this.counts = new Facts();
    this.distributions = new Distributions();
    this.commands = new Commands(store);
    this.properties = new Properties(store);
    this.trends = kMeasures.map((measure, i) => this.#trend(measure === "run" ? "run time" : measure, i));
    this.faults = new LastFaults(store);
    this.table = element("a", { text: "runs of the module in the last macro period" });
    this.ports = new PortList(store);
    this.steps = element("ol", { class: "steps" });
    const part = (title, ...children) => element("section", {}, element("h3", { text: title }), ...children);
    this.element = element("div", { class: "module-details" }, this.mark.element, this.why, this.commands.element, this.faults.element,
      part("Measured", this.use.element, this.distributions.element, this.counts.element, element("p", {}, this.table)),
      part("Ports", this.ports.element), this.properties.element,
      part("Jitter and run time in the last ten minutes", ...this.trends.map(({ figure }) => figure)), part("State changes", this.steps), part("Descriptor", this.facts.element),
      part("Component", this.component.element));
  }

  show(name) {
    this.#name = name;
    this.#take(new ValueRows());
    const [device] = name.split(".");
    this.commands.hold(device, name);
    this.table.href = addressOf("table", { device, select: name });
    this.properties.hold(name);
    this.#askHistory();
    this.#component = null;
    this.ports.hold(name);
    this.#askPorts();
    this.#showAll();
  }

  hide() {
    this.#name = null;
    this.ports.hide();
  }

  update(changes) {
    if (changes.cell || changes.whole || changes.modules.has(this.#name)) this.#showState();
    if (changes.cell) this.#showAll();
    if (changes.cell || changes.begun.has(this.#module?.device)) {
      this.properties.ask();
      this.#askPorts();
    }
    if (changes.faults) this.faults.show(this.#name);
    if (changes.measures) {
      this.#append();
      this.#showState();
      this.#showMeasures();
    }
    if (changes.rights || changes.link || changes.devices.size > 0) {
      this.commands.update();
      this.properties.update();
    }
  }

  redraw() {
    this.ports.arrived();
    for (const { plot } of this.trends) plot.redraw();
  }

  /// A plot of a measure, with the newest values in its legend, or those under the pointer.
  #trend(title, i) {
    const plot = new Plot({ title: `${title} in us`, pointed: (time) => this.#point(time),
      series: kLines.map((name, index) => ({ name, index, rows: this.#rows, column: 1 + i * kLines.length + index })) });
    const values = kLines.map(() => element("b"));
    const at = element("span", { class: "faint" });
    const figure = element("figure", {}, element("figcaption", {}, element("span", { class: "faint", text: title }),
      ...kLines.map((name, index) => element("span", {}, sampleOf(index), `${name} `, values[index])), at), plot.element);
    return { plot, values, at, figure };
  }

  #take(rows) {
    this.#rows = rows;
    for (const { plot } of this.trends) for (const series of plot.series) series.rows = rows;
  }

  #point(time) {
    for (const { plot, values, at } of this.trends) {
      const row = time === null ? this.#rows.last : this.#rows.at(time);
      plot.point(time, null);
      values.forEach((node, i) => setText(node, row ? `${number(row[plot.series[i].column])} us` : "-"));
      setText(at, time === null || !row ? "" : `at ${clock(row[0])}`);
    }
  }

  get #module() {
    return this.#store.modules.get(this.#name);
  }

  #showAll() {
    const about = this.#module?.about;
    this.facts.show([
      ["type", about?.type], ["operation", about?.operation], ["period", about?.period_ns ? exact(about.period_ns) : ""],
      ["deadline", about?.deadline_ns ? exact(about.deadline_ns) : ""], ["priority", about?.priority],
      ["executor", about?.executor], ["rows of the table", this.#rowsOfTable()], ["budget", about?.budget_ns ? exact(about.budget_ns) : about ? "none" : ""],
    ]);
    this.#showComponent();
    this.#showState();
    this.faults.show(this.#name);
    this.#showMeasures();
    this.ports.rebuild();
    this.properties.update();
  }

  /// The rows of the executor's table in which the module runs.
  #rowsOfTable() {
    const [device, label] = this.#name.split(".");
    const executors = this.#store.cell?.devices?.find((one) => one.name === device)?.executors ?? [];
    const rows = executors.find((one) => one.name === this.#module?.about?.executor)?.rows ?? [];
    const its = rows.flatMap((row, i) => (row.includes(label) ? [i] : []));
    if (its.length === 0) return "";
    return its.length === rows.length ? `all ${rows.length}` : `${its.slice(0, kRows).join(", ")}${its.length > kRows ? ", ..." : ""} of ${rows.length}`;
  }

  #showComponent() {
    const component = this.#component;
    this.component.show([["file", component?.file], ["version", component?.version || (component ? "not stated" : "")],
      ["hash", component?.hash]]);
  }

  #showState() {
    const module = this.#module;
    if (!module) {
      this.mark.show({ look: "faint", sign: "wait", word: "the cell has no such module" });
      setText(this.why, "");
      this.steps.replaceChildren();
    } else {
      const look = lookOfModule(this.#store.shown(module));
      const stopped = look.word === "safe stop";
      const since = module.state?.time_ms && !stopped ? ` since ${instant(module.state.time_ms)}` : "";
      const lost = look.key === "lost";
      this.mark.show({ ...look, word: lost ? look.word : look.word + since });
      setText(this.why, stopped ? "The module works as intended, and keeps its machine stopped for safety."
        : lost && since ? `Its last known state is ${module.state.state}${since}.` : reason(module.state));
      this.#showSteps(module);
    }
    this.commands.update();
  }

  #showSteps(module) {
    const lines = module.steps.slice().reverse().map((step) => {
      const from = step.previous && step.previous !== step.state ? `${step.previous} \u2192 ` : "";
      return element("li", {}, element("span", { class: "faint", text: instant(step.time_ms) }), ` ${from}${step.state}`,
        reason(step) ? element("span", { class: "faint", text: ` (${reason(step)})` }) : null);
    });
    this.steps.replaceChildren(...lines);
  }

  #showMeasures() {
    const module = this.#module;
    const measures = module?.measures;
    this.distributions.show([["jitter", measures?.jitter_us], ["run time", measures?.run_us]], number);
    const use = module ? useOf(module) : { share: null, words: "-" };
    const of = use.allowed ? ` of ${exact(use.allowed)} ${use.what}` : "";
    this.use.show(use.share, `p99 run time ${use.words}${of}`);
    this.counts.show(["cycles", "missed", "overruns", "over_budget", "errors", "recoveries"]
      .map((what) => [what.replace("_", " "), count(measures?.[what])]));
    this.ports.showHealth();
    for (const { plot } of this.trends) plot.show(this.#store.now - kSpan_ms, this.#store.now);
    this.#point(this.trends[0].plot.cursor ?? null);
  }

  async #askHistory() {
    const name = this.#name;
    try {
      const history = await get("api/history", { module: name });
      if (name !== this.#name) return;
      const rows = new ValueRows();
      const older = history.times_ms.filter((time) => time < this.#rows.oldest);
      rows.add(older, kMeasures.flatMap((measure) => kLines.map((line) => history[`${measure}_${line}_us`])));
      rows.append(this.#rows);
      this.#take(rows);
      this.#showMeasures();
    } catch { /* the gateway has no history yet, so the plots begin now */ }
  }

  #append() {
    const module = this.#module;
    const measures = module?.measures;
    // Add no point for a lost module, because its last measurements are out of date.
    if (!measures || !module.state || this.#store.isLost(module) || this.#store.time_ms <= this.#rows.newest) return;
    this.#rows.add([this.#store.time_ms], kMeasures.flatMap((measure) => kLines.map((line) => [measures[`${measure}_us`][line]])));
  }

  /// Asks the device for the ports of the module. If that fails, asks once more, because a device may not answer yet when it has just
  /// reported that it runs.
  async #askPorts(again = true) {
    const name = this.#name;
    try {
      const { ports, components } = await get("api/ports", { device: name.split(".")[0] });
      if (name !== this.#name) return;
      this.#component = components[name] ?? null;
      this.#showComponent();
      this.ports.show(ports.filter((port) => port.name.startsWith(`${name}.`)));
    } catch (problem) {
      if (name !== this.#name) return;
      this.ports.fail(problem.text);
      if (again) setTimeout(() => name === this.#name && this.#askPorts(false), kAgain_ms);
    }
  }
}

function reason(state) {
  if (!state) return "";
  if (state.error && state.text?.startsWith(`${state.error}: `)) return state.text;
  return [state.error, state.text].filter(Boolean).join(": ");
}
