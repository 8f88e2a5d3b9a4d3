// Shows the details of a module: its state and the reason for it, commands, measurements, ports and properties.

import { get } from "./api.js";
import { Bar, element, Mark, setText } from "./dom.js";
import { Distributions, Facts } from "./facts.js";
import { LastFaults } from "./last_faults.js";
import { lookOfConnection, lookOfModule, useOf } from "./looks.js";
import { Commands } from "./commands.js";
import { Properties } from "./properties.js";
import { addressOf } from "./route.js";
import { TimePlot } from "./time_plot.js";
import { count, exact, instant, number } from "./words.js";

const kSpan_ms = 600000;
const kAgain_ms = 2000;
const kLines = ["p50", "p99"];

export class ModuleDetails {
  #store;
  #name = null;
  #times = [];
  #history = { jitter: [[], []], run: [[], []] };
  #ports = null;  // null: not known yet
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
    this.jitter = new TimePlot({ title: "jitter", unit: "us", lines: kLines, span_ms: kSpan_ms });
    this.run = new TimePlot({ title: "run time", unit: "us", lines: kLines, span_ms: kSpan_ms });
    this.faults = new LastFaults(store);
    this.table = element("a", { text: "runs of the module in the last macro period" });
    this.ports = element("ul", { class: "ports" });
    this.steps = element("ol", { class: "steps" });
    const part = (title, ...children) => element("section", {}, element("h3", { text: title }), ...children);
    this.element = element("div", { class: "module-details" }, this.mark.element, this.why, this.commands.element, this.faults.element,
      part("Measured", this.use.element, this.distributions.element, this.counts.element, element("p", {}, this.table)),
      part("Jitter and run time in the last ten minutes", this.jitter.element, this.run.element),
      part("Ports", this.ports), this.properties.element, part("State changes", this.steps), part("Descriptor", this.facts.element),
      part("Component", this.component.element));
  }

  show(name) {
    this.#name = name;
    [this.#times, this.#history] = [[], { jitter: [[], []], run: [[], []] }];
    const [device] = name.split(".");
    this.commands.hold(device, name);
    this.table.href = addressOf("table", { device, select: name });
    this.properties.hold(name);
    this.#askHistory();
    [this.#ports, this.#component] = [null, null];
    this.ports.replaceChildren(element("li", { class: "faint", text: "loading ..." }));
    this.#askPorts();
    this.#showAll();
  }

  hide() {
    this.#name = null;
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
    this.jitter.redraw();
    this.run.redraw();
  }

  get #module() {
    return this.#store.modules.get(this.#name);
  }

  #showAll() {
    const about = this.#module?.about;
    this.facts.show([
      ["type", about?.type], ["operation", about?.operation], ["period", about?.period_ns ? exact(about.period_ns) : ""],
      ["deadline", about?.deadline_ns ? exact(about.deadline_ns) : ""], ["priority", about?.priority],
      ["executor", about?.executor], ["budget", about?.budget_ns ? exact(about.budget_ns) : about ? "none" : ""],
    ]);
    this.#showComponent();
    this.#showState();
    this.faults.show(this.#name);
    this.#showMeasures();
    this.#showPorts();
    this.properties.update();
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
    this.#showPortHealth();
    this.jitter.show(this.#times, this.#history.jitter, this.#store.now);
    this.run.show(this.#times, this.#history.run, this.#store.now);
  }

  async #askHistory() {
    const name = this.#name;
    try {
      const history = await get("api/history", { module: name });
      if (name !== this.#name) return;
      const before = history.times_ms.findIndex((time) => time >= (this.#times[0] ?? Infinity));
      const kept = before < 0 ? history.times_ms.length : before;
      const joined = (old, now) => [...old.slice(0, kept), ...now];
      this.#times = joined(history.times_ms, this.#times);
      this.#history = {
        jitter: kLines.map((line, i) => joined(history[`jitter_${line}_us`], this.#history.jitter[i])),
        run: kLines.map((line, i) => joined(history[`run_${line}_us`], this.#history.run[i])),
      };
      this.#showMeasures();
    } catch { /* the gateway has no history yet, so the plots begin now */ }
  }

  #append() {
    const module = this.#module;
    const measures = module?.measures;
    // Add no point for a lost module, because its last measurements are out of date.
    if (!measures || !module.state || this.#store.isLost(module) || this.#store.time_ms <= (this.#times.at(-1) ?? 0)) return;
    this.#times.push(this.#store.time_ms);
    kLines.forEach((line, i) => {
      this.#history.jitter[i].push(measures.jitter_us[line]);
      this.#history.run[i].push(measures.run_us[line]);
    });
    while (this.#times[0] < this.#store.time_ms - kSpan_ms - 5000) {
      for (const values of [this.#times, ...this.#history.jitter, ...this.#history.run]) values.shift();
    }
  }

  /// Asks the device for the ports of the module. If that fails, asks once more, because a device may not answer yet when it has just
  /// reported that it runs.
  async #askPorts(again = true) {
    const name = this.#name;
    try {
      const { ports, components } = await get("api/ports", { device: name.split(".")[0] });
      if (name !== this.#name) return;
      this.#ports = ports.filter((port) => port.name.startsWith(`${name}.`));
      this.#component = components[name] ?? null;
      this.#showComponent();
      this.#showPorts();
    } catch (problem) {
      if (name !== this.#name) return;
      this.#ports = null;
      this.ports.replaceChildren(element("li", { class: "answer", "data-look": "bad", text: problem.text }));
      if (again) setTimeout(() => name === this.#name && this.#askPorts(false), kAgain_ms);
    }
  }

  /// Shows each port with its connections: the port at the other end, and the health.
  #showPorts() {
    if (this.#ports === null) return;
    if (this.#ports.length === 0) {
      this.ports.replaceChildren(element("li", { class: "faint", text: "none" }));
      return;
    }
    this.ends = [];
    this.ports.replaceChildren(...this.#ports.map((port) => {
      const connections = [...(this.#store.cell?.connections ?? []).entries()]
        .filter(([, { from, to }]) => from === port.name || to === port.name);
      const lines = connections.map(([index, connection]) => {
        const mark = new Mark();
        this.ends.push({ index, mark });
        const other = connection.from === port.name ? `\u2192 ${connection.to ?? "outside"}` : `\u2190 ${connection.from ?? "outside"}`;
        return element("div", { class: "end" }, element("a", { href: addressOf("connections", { at: index }), text: other }), mark.element);
      });
      return element("li", {}, element("a", { href: addressOf("plots", { port: port.name }), text: port.name.slice(this.#name.length + 1) }),
        element("span", { class: "faint", text: ` ${port.direction === "in" ? "reads" : "writes"} ${port.type}` }),
        ...(lines.length > 0 ? lines : [element("div", { class: "end faint", text: "not connected" })]));
    }));
    this.#showPortHealth();
  }

  #showPortHealth() {
    for (const { index, mark } of this.ends ?? []) mark.show(lookOfConnection(this.#store.connections.get(String(index))));
  }
}

function reason(state) {
  if (!state) return "";
  if (state.error && state.text?.startsWith(`${state.error}: `)) return state.text;
  return [state.error, state.text].filter(Boolean).join(": ");
}
