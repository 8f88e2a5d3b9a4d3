// The last known state of the cell. Each event from the gateway updates the state at once. The store notifies the views once per frame, so
// that they draw a burst of changes only once.

import { Ports } from "./ports.js";

const kFaults = 20000;  // as many as takt web keeps
const kSlack = 1000;    // events that are removed together, so that adding one takes constant time on average
const kSteps = 50;       // per module
const kTrend = 120;      // seconds

class Changes {
  cell = false;
  link = false;
  rights = false;
  measures = false;
  newest = false;
  whole = false;         // a device or module was added or removed
  devices = new Set();
  begun = new Set();     // devices that have just started to run; the views ask these devices again
  modules = new Set();
  faults = false;
  alarms = false;
}

const runs = (device) => device?.alive === true && device.state === "running";

export class Store {
  link = "connecting";
  linkSince = Date.now();
  ports = new Ports();
  chooseNewest = () => {};
  rights = { command: false, why: "takt web has not answered yet" };
  cell = null;
  /// Devices by name, each as the gateway sends it.
  devices = new Map();
  /// Modules by "device.module", each as {name, device, label, about (from the descriptor), state, measures, steps, trend}.
  modules = new Map();
  /// The newest values of the ports that stream.chooseNewest() has chosen, by the name of the port, each as a short text.
  newest = new Map();
  executors = new Map();
  connections = new Map();
  /// Fault events in order of arrival, oldest first. The array is replaced when earlier events are added.
  faults = [];
  faultsSince = 0;       // no event since this time is missing in `faults`, in ms
  faultsCome = 0;        // number of fault events since the page was opened
  problems = [];
  alarms = [];           // the worst first
  #alarmed = new Set();  // the modules with an unacknowledged alarm
  measures = null;       // the last event `measures`
  time_ms = 0;           // the gateway's time in the last event, which arrived when this page's clock showed `seen`
  seen = 0;
  #listeners = [];
  #changes = new Changes();
  #asked = false;

  listen(listener) {
    this.#listeners.push(listener);
  }

  /// The current time by the gateway's clock. This time stops while no events arrive, so that the plots stop too.
  get now() {
    if (this.time_ms === 0) return Date.now();
    return this.time_ms + (this.link === "live" ? Math.min(performance.now() - this.seen, 2000) : 0);
  }

  /// The events that make another store equal to this one.
  get events() {
    const modules = [...this.modules.values()];
    const each = (what) => Object.fromEntries(modules.map((module) => [module.name, module[what]]));
    const events = [
      ["link", { link: this.link, since: this.linkSince }],
      ["cell", this.cell],
      ["state", { whole: true, devices: [...this.devices.values()], modules: modules.map(({ state }) => state).filter(Boolean), steps: each("steps") }],
      ["measures", this.measures],
      ["trends", { jitter_us: each("trend") }],
      ["faults", { whole: true, events: this.faults, problems: this.problems, complete_since_ms: this.faultsSince }],
      ["alarms", { alarms: this.alarms }],
    ];
    return this.cell ? events.filter(([, data]) => data) : events.slice(0, 1);
  }

  take(name, data) {
    if (name === "cell") this.takeCell(data);
    else if (name === "state") this.takeState(data);
    else if (name === "measures") this.takeMeasures(data);
    else if (name === "trends") this.takeTrends(data);
    else if (name === "faults") this.takeFaults(data);
    else if (name === "alarms") this.takeAlarms(data);
    else if (name === "newest") this.takeNewest(data.values);
    else this.ports.take(name, data);
  }

  change(act) {
    if (this.#listeners.length === 0) return;
    act(this.#changes);
    if (this.#asked) return;
    this.#asked = true;
    requestAnimationFrame(() => {
      this.#asked = false;
      const changes = this.#changes;
      this.#changes = new Changes();
      for (const listener of this.#listeners) listener(changes);
    });
  }

  setLink(link, since) {
    [this.link, this.linkSince] = [link, since];
    this.change((changes) => { changes.link = true; });
  }

  setRights(rights) {
    this.rights = rights;
    this.change((changes) => { changes.rights = true; });
  }

  takeCell(cell) {
    const same = JSON.stringify(cell) === JSON.stringify(this.cell);
    this.cell = cell;
    const known = this.modules;
    this.modules = new Map();
    for (const device of cell.devices ?? []) {
      for (const about of device.modules ?? []) {
        const name = `${device.name}.${about.name}`;
        this.modules.set(name, { ...this.#module(known, name), about });
      }
    }
    for (const [name, module] of known) {
      if (!this.modules.has(name) && module.state) this.modules.set(name, { ...module, about: null });
    }
    this.change((changes) => {
      changes.cell ||= !same;
      changes.whole = true;
    });
  }

  takeState(news) {
    if (news.whole) this.#forgetStates(news);
    for (const device of news.devices ?? []) this.#takeDevice(device);
    for (const state of news.modules ?? []) this.#takeModule(state);
    for (const [name, steps] of Object.entries(news.steps ?? {})) if (this.modules.has(name)) this.modules.get(name).steps = steps;
    this.change((changes) => { changes.whole ||= news.whole === true; });
  }

  #forgetStates(news) {
    this.devices = new Map();
    const named = new Set((news.modules ?? []).map((module) => module.name));
    for (const [name, module] of this.modules) {
      if (named.has(name)) continue;
      if (module.about) module.state = null;
      else this.modules.delete(name);
    }
  }

  #takeDevice(device) {
    const before = this.devices.get(device.name);
    if (device.gone) this.devices.delete(device.name);
    else this.devices.set(device.name, device);
    this.change((changes) => {
      changes.devices.add(device.name);
      if (runs(device) && !runs(before)) changes.begun.add(device.name);
      if (device.gone || !before) changes.whole = true;
      for (const [name, module] of this.modules) if (module.device === device.name) changes.modules.add(name);
    });
  }

  #takeModule(state) {
    const known = this.modules.get(state.name);
    if (state.gone) {
      if (known?.about) known.state = null;
      else this.modules.delete(state.name);
    } else {
      const module = known ?? this.#module(this.modules, state.name);
      if (!known) this.modules.set(state.name, module);
      const last = module.steps.at(-1);
      if (!last || last.sequence !== state.sequence || last.time_ms !== state.time_ms) module.steps.push(state);
      if (module.steps.length > kSteps) module.steps.shift();
      module.state = state;
    }
    this.change((changes) => {
      changes.modules.add(state.name);
      if (!known || state.gone) changes.whole = true;
    });
  }

  #module(known, name) {
    const [device, label] = name.split(".");
    return known.get(name) ?? { name, device, label, about: null, state: null, measures: null, steps: [], trend: [] };
  }

  takeMeasures(measures) {
    this.measures = measures;
    this.time_ms = measures.time_ms;
    this.seen = performance.now();
    for (const [name, module] of this.modules) {
      const of = measures.modules?.[name];
      if (!of) continue;
      module.measures = of;
      module.trend.push(of.recent_us?.jitter ?? null);
      if (module.trend.length > kTrend) module.trend.shift();
    }
    this.executors = new Map(Object.entries(measures.executors ?? {}));
    this.connections = new Map(Object.entries(measures.connections ?? {}));
    this.change((changes) => { changes.measures = true; });
  }

  takeTrends(trends) {
    for (const [name, module] of this.modules) module.trend = (trends.jitter_us?.[name] ?? module.trend).slice(-kTrend);
    this.change((changes) => { changes.measures = true; });
  }

  takeNewest(values) {
    for (const [port, text] of Object.entries(values)) this.newest.set(port, text);
    this.change((changes) => { changes.newest = true; });
  }

  takeFaults(news) {
    this.problems = news.problems ?? this.problems;
    const events = news.events ?? [];
    this.faultsSince = news.complete_since_ms ?? this.faultsSince;
    if (news.whole) this.faults = events.slice();
    else if (news.earlier) this.faults = events.concat(this.faults);
    else {
      this.faultsCome += events.length;
      this.faults.push(...events);  // do not sort by time: new events of a device whose clock is behind would appear far down
    }
    if (this.faults.length > kFaults + kSlack) {
      for (const { time_ms } of this.faults.splice(0, this.faults.length - kFaults)) this.faultsSince = Math.max(this.faultsSince, time_ms);
    }
    this.change((changes) => { changes.faults = true; });
  }

  takeAlarms({ alarms }) {
    const before = this.#alarmed;
    this.alarms = alarms;
    this.#alarmed = new Set(alarms.filter(({ acknowledged }) => !acknowledged).map(({ device, module }) => `${device}.${module}`));
    this.change((changes) => {
      changes.alarms = true;
      for (const name of [...before, ...this.#alarmed]) if (this.modules.has(name)) changes.modules.add(name);
    });
  }

  /// True if the module's device is lost. The module's state is then the last known one.
  isLost(module) {
    const device = this.devices.get(module.device);
    return module.state !== null && device?.alive === false;
  }

  /// The module as lookOfModule() takes it: with `lost`, with `alarm`, and with `stopped`, which is true if an operator stopped the module. A module that
  /// was started is in START, too, until its first release.
  shown(module) {
    const stays = module.state?.state === "START" && ["stop", "recover"].includes(module.state.event);
    return { ...module, lost: this.isLost(module), alarm: this.#alarmed.has(module.name), stopped: stays && runs(this.devices.get(module.device)) };
  }

  /// The names of all devices: first those in the descriptor, then all others.
  get deviceNames() {
    const names = new Set((this.cell?.devices ?? []).map((device) => device.name));
    for (const name of this.devices.keys()) names.add(name);
    for (const module of this.modules.values()) names.add(module.device);
    return [...names];
  }

  modulesOf(device) {
    return [...this.modules.values()].filter((module) => module.device === device);
  }
}
