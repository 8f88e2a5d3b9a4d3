// Shows the details of a device: its state and health, commands to all of its modules, and its executors.

import { element, Mark, setText } from "./dom.js";
import { Distributions, Facts } from "./facts.js";
import { LastFaults } from "./last_faults.js";
import { lookOfDevice } from "./looks.js";
import { Commands } from "./commands.js";
import { addressOf } from "./route.js";
import { count, exact, number } from "./words.js";

export class DeviceDetails {
  #store;
  #name = null;
  #executors = new Map();

  constructor(store) {
    this.#store = store;
    this.mark = new Mark("p");
    this.why = element("p", { class: "why" });
    this.facts = new Facts();
    this.commands = new Commands(store);
    this.executors = element("div");
    this.table = element("a", { text: "table and timing of the last macro period" });
    this.faults = new LastFaults(store);
    const part = (title, ...children) => element("section", {}, element("h3", { text: title }), ...children);
    this.element = element("div", {}, this.mark.element, this.why, this.commands.element, this.faults.element,
      part("Executors", this.executors, element("p", {}, this.table)), part("Node", this.facts.element));
  }

  show(name) {
    this.#name = name;
    this.#forgetExecutors();
    this.commands.hold(name, null);
    this.table.href = addressOf("table", { device: name });
    this.#showAll();
  }

  hide() {
    this.#name = null;
  }

  update(changes) {
    if (changes.cell) this.#forgetExecutors();
    if (changes.cell || changes.whole || changes.devices.has(this.#name) || changes.modules.size > 0) this.#showAll();
    else if (changes.measures) this.#showExecutors();
    if (changes.faults) this.faults.show(this.#name);
    if (changes.rights || changes.link) this.commands.update();
  }

  #showAll() {
    const device = this.#store.devices.get(this.#name);
    this.mark.show(lookOfDevice(device));
    setText(this.why, device?.text ?? "");
    this.facts.show([
      ["machine", device?.machine], ["real time", device ? (device.real_time ? "yes" : "no: the system denies real-time scheduling") : ""],
      ["takt-node", device ? `process ${device.process_id}` : ""],
      ["takt-host", device?.host_process_id ? `process ${device.host_process_id}` : device ? "none" : ""],
      ["host restarts", count(device?.host_restarts)],
      ["wall clock", this.#clock(device?.clock_ms)],
    ]);
    this.commands.update();
    this.faults.show(this.#name);
    this.#showExecutors();
  }

  #clock(of) {
    const first = this.#store.cell?.devices?.[0]?.name;
    return of && first ? `${Math.abs(of.offset)} ms ${of.offset < 0 ? "behind" : "ahead of"} that of ${first} (±${of.error} ms)` : "";
  }

  #forgetExecutors() {
    this.#executors.clear();
    this.executors.replaceChildren();
  }

  #showExecutors() {
    for (const about of this.#store.cell?.devices?.find((one) => one.name === this.#name)?.executors ?? []) {
      let shown = this.#executors.get(about.name);
      if (!shown) {
        shown = { facts: new Facts(), distributions: new Distributions() };
        this.#executors.set(about.name, shown);
        this.executors.append(element("h4", { text: about.name }), shown.distributions.element, shown.facts.element);
      }
      const measures = this.#store.executors.get(`${this.#name}.${about.name}`);
      shown.distributions.show([["jitter", measures?.jitter_us]], number);
      shown.facts.show([
        ["period", about.basic_period_ns ? `${exact(about.basic_period_ns)}; macro period ${exact(about.macro_period_ns)}` : ""],
        ["cycles", count(measures?.cycles)], ["missed", count(measures?.missed)], ["late", count(measures?.late)],
        ["wakes up before a release", measures ? `${number(measures.margin_us)} us` : ""],
      ]);
    }
  }
}
