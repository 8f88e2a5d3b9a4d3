// The view that shows the graph of the cell. The view adds the current states, the health and the selection to the gateway's drawing.

import { get } from "./api.js";
import { drawn, element, setAttribute, setText } from "./dom.js";
import { drawingOf } from "./drawing.js";
import { Frame } from "./frame.js";
import { ageOf, lookOfConnection, lookOfDevice, lookOfModule, useOf } from "./looks.js";
import { adjust, alter, currentRoute } from "./route.js";
import { pathOf, trendOf } from "./spark.js";
import { duration, exact } from "./words.js";

const kSmall = 10;        // font size of the drawing's small text
const kTrend = 120;       // seconds
const kMostValues = 150;  // if more wires are visible, the page shows no values unless the user asks for them
const kMostPorts = 500;   // limit of the gateway
const kReadable = 0.5;    // at a smaller scale, nobody can read the values
const kRoom = 22;         // letters beside the arrow of a wire
const kSettled_ms = 200;
const kRanks = { good: 0, faint: 1, plain: 1, poor: 2, bad: 3 };

export class Graph {
  #store;
  #modules = new Map();      // modules by name, each as {group, mark}
  #devices = new Map();
  #wires = [];               // each as {indexes, group, wire, word, titles, port, x, y}; several indexes are those of a collapsed device
  #collapsed = "";           // the names of the collapsed devices, with commas between them
  #drawn = {};               // the cell and the collapsed devices of the drawing
  #ports = [];               // the ports whose values are wanted
  #live = false;             // the wires show their values
  #shown = false;
  #timer;
  #frame;

  constructor(store) {
    this.#store = store;
    this.values = element("button", { type: "button", class: "values", text: "values", title: "show the newest value on each visible wire",
      on: { click: () => this.#switch() } });
    this.#frame = new Frame(() => this.#settle(), this.values);
    this.nothing = element("p", { class: "nothing" });
    this.element = element("div", { class: "graph" }, this.nothing, this.#frame.element);
    this.#frame.element.addEventListener("click", (event) => this.#choose(event.target));
    this.#frame.element.addEventListener("keydown", (event) => this.#press(event));
  }

  show(parameters) {
    this.#shown = true;
    this.#collapsed = parameters.get("collapsed") ?? "";
    this.#draw();
    this.#showAll();
    this.#mark();
    this.#settle();
  }

  hide() {
    this.#shown = false;
    this.#seek();
  }

  update(changes) {
    if (changes.cell) this.#draw();
    if (changes.cell || changes.begun.size > 0) this.#ports = [];  // their devices must be asked again
    if (changes.cell || changes.begun.size > 0) this.#settle();
    if (changes.cell || changes.whole || changes.link) {
      this.#showAll();
      this.#mark();
      return;
    }
    for (const name of changes.devices) this.#showDevice(name);
    for (const name of changes.modules) this.#showModule(name);
    if (changes.measures) for (const name of this.#modules.keys()) this.#showModule(name);
    if (changes.measures || changes.newest) for (const wire of this.#wires) this.#showWire(wire);
  }

  focusOn(name) {
    (this.#modules.get(name) ?? this.#devices.get(name))?.group.focus();
  }

  /// Draws the gateway's drawing, if it has changed. If devices are collapsed, the gateway makes another drawing.
  async #draw() {
    const [cell, collapsed] = [this.#store.cell, this.#collapsed];
    const whole = cell?.graph ?? null;
    if (whole !== null && this.#drawn.whole === whole && this.#drawn.collapsed === collapsed) return;
    this.#drawn = { whole, collapsed };
    if (whole === null || collapsed === "") {
      this.#hold(whole);
      return;
    }
    const answer = await get("api/graph", { collapsed }).catch(() => ({ graph: whole }));
    if (this.#drawn.whole !== whole || this.#drawn.collapsed !== collapsed) return;
    this.#hold(answer.graph);
    this.#showAll();
    this.#mark();
  }

  #hold(text) {
    this.#modules.clear();
    this.#devices.clear();
    this.#wires = [];
    const drawing = text === null ? null : drawingOf(text);
    this.nothing.hidden = drawing !== null;
    this.#frame.element.hidden = drawing === null;
    const waiting = this.#store.cell === null;
    setText(this.nothing, waiting ? "Waiting for data from takt web." :
      this.#store.modules.size > 0 ? "The graph is not available, because the cell's descriptor is not known yet. The view Modules lists the modules." :
        "No cell is deployed. Deploy one with takt deploy CELL.xml, and its graph appears here.");
    if (!drawing) return;
    setAttribute(drawing, "class", "drawing");
    this.#frame.hold(drawing);
    for (const group of drawing.querySelectorAll("[data-device]")) this.#prepare(group, group.dataset.device, this.#devices);
    for (const group of drawing.querySelectorAll("[data-module]")) this.#prepare(group, group.dataset.module, this.#modules);
    for (const group of drawing.querySelectorAll(".link[data-connection]")) this.#prepareWire(group);
    const first = drawing.querySelector("[data-module], [data-device]");
    first?.setAttribute("tabindex", "0");
  }

  /// Replaces the text of the state in a module's box by a sign and a word, and shows the measured jitter on the right.
  #prepare(group, name, known) {
    const box = group.querySelector("rect");
    const state = group.querySelector("text.state");
    if (!box || !state) return;
    const [x, y, , height] = ["x", "y", "width", "height"].map((of) => Number(box.getAttribute(of)));
    const [left, line] = ["x", "y"].map((of) => Number(state.getAttribute(of)));
    state.remove();
    const use = drawn("use", { width: kSmall, height: kSmall, x: left - 2, y: line - kSmall + 1 });
    const word = drawn("text", { "font-size": kSmall, class: "state-word", x: left + kSmall + 2, y: line });
    const strip = drawn("rect", { x, y, width: 4, height, class: "strip" });
    group.append(...(known === this.#modules ? [strip] : []), use, word);
    const [run, jitter, track, used, room] = ["run", "jitter", "track", "used", "trend"].map((part) => group.querySelector(`.${part}`));
    const at = room && ["x", "y", "width", "height"].map((of) => Number(room.getAttribute(of)));
    const trend = room && drawn("path", { class: "trend", transform: `translate(${at[0]} ${at[1]})` });
    room?.replaceWith(trend);
    setAttribute(group, "role", "button");
    setAttribute(group, "tabindex", "-1");
    // The title of the box is its tooltip and its name for assistive technology. So it has the texts down to the state, which is current.
    const title = group.querySelector("title") ?? group.insertBefore(drawn("title"), group.firstChild);
    const about = known === this.#modules ? title.textContent.replace(/; [^;]*$/, "") : `device ${name}: ${group.querySelector("text.faint").textContent}`;
    known.set(name, { group, use, word, run, jitter, track, used, trend, at, title, about });
  }

  #prepareWire(group) {
    const wire = group.querySelector("path.wire");
    if (!wire) return;
    const numbers = group.dataset.connection;
    wire.classList.remove("good", "poor", "bad", "broken");
    const of = `[data-connection="${CSS.escape(numbers)}"]`;
    const word = group.ownerSVGElement.querySelector(`.label${of} .state`);
    const titles = group.ownerSVGElement.querySelectorAll(`${of} > title`);
    const indexes = numbers.split(" ");
    const port = indexes.length === 1 ? this.#store.cell?.connections?.[indexes[0]]?.from : null;
    const [x, y] = ["x", "y"].map((at) => Number(word?.getAttribute(at)));
    this.#wires.push({ indexes, group, wire, word, titles, port, x, y });
  }

  #switch() {
    adjust({ values: this.#live ? "off" : "on" });
    this.#seek();
  }

  /// Waits until the user has stopped to move the drawing.
  #settle() {
    clearTimeout(this.#timer);
    this.#timer = setTimeout(() => this.#seek(), kSettled_ms);
  }

  /// Chooses the values of the wires whose labels are visible.
  #seek() {
    const wanted = currentRoute().parameters.get("values");
    const visible = this.#wires.filter((wire) => this.#frame.shows(wire.x, wire.y));
    const readable = this.#frame.scale >= kReadable && visible.length <= kMostValues;
    this.#live = this.#shown && (wanted === "on" || (wanted !== "off" && readable));
    setAttribute(this.values, "aria-pressed", String(this.#live));
    const ports = this.#live ? [...new Set(visible.map(({ port }) => port).filter(Boolean))].sort().slice(0, kMostPorts) : [];
    if (ports.join() === this.#ports.join()) return;
    this.#ports = ports;
    this.#store.chooseNewest(ports);
    for (const wire of this.#wires) this.#showWire(wire);
  }

  #showAll() {
    for (const name of this.#devices.keys()) this.#showDevice(name);
    for (const name of this.#modules.keys()) this.#showModule(name);
    for (const wire of this.#wires) this.#showWire(wire);
  }

  #showDevice(name) {
    const drawn = this.#devices.get(name);
    if (!drawn) return;
    const modules = this.#store.modulesOf(name);
    const collapsed = this.#drawn.collapsed.split(",").includes(name);
    let look = lookOfDevice(this.#store.devices.get(name));
    if (collapsed) {  // the worst state counts
      for (const module of modules) {
        const its = lookOfModule(this.#store.shown(module));
        if (kRanks[its.look] > Math.max(1, kRanks[look.look])) look = { ...its, word: `${module.label}: ${its.word}` };
      }
    }
    this.#showLook(drawn, look);
    setAttribute(drawn.group, "aria-description", `the space bar ${collapsed ? "expands" : "collapses"} it`);
    setAttribute(drawn.group, "aria-expanded", String(!collapsed));
    if (!collapsed) for (const module of modules) this.#showModule(module.name);
  }

  #showModule(name) {
    const drawn = this.#modules.get(name);
    const module = this.#store.modules.get(name);
    if (!drawn || !module) return;
    const look = lookOfModule(this.#store.shown(module));
    this.#showLook(drawn, look);
    if (!drawn.trend) return;
    const measures = look.key === "lost" ? null : module.measures;
    const use = measures ? useOf(module) : { share: null };
    setText(drawn.run, measures ? `run ${use.words}${use.allowed ? ` of ${exact(use.allowed)}` : ""}` : "");
    setText(drawn.jitter, look.alarm ? "alarm" : measures ? `jitter ${duration(measures.jitter_us.p99)}` : "");
    const share = Math.min(use.share ?? 0, 1);
    setAttribute(drawn.used, "width", (share * Number(drawn.track.getAttribute("width"))).toFixed(1));
    setAttribute(drawn.used, "data-look", use.share > 1 ? "bad" : use.share > 0.8 ? "poor" : "good");
    setAttribute(drawn.track, "visibility", use.share === null ? "hidden" : null);
    setAttribute(drawn.trend, "d", measures ? pathOf(trendOf(module.trend, kTrend), kTrend, drawn.at[2], drawn.at[3], true) : "");
  }

  #showLook(drawn, look) {
    setAttribute(drawn.group, "data-look", look.look);
    setAttribute(drawn.group, "data-state", look.key);
    setAttribute(drawn.use, "href", `#sign-${look.sign}`);
    setText(drawn.word, look.word);
    setText(drawn.title, `${drawn.about}; ${look.word}${look.alarm ? ", alarm" : ""}`);
  }

  /// Shows the health of a wire, the worst of its connections, and the newest value with its age.
  #showWire({ indexes, wire, word, titles, port }) {
    const all = indexes.map((index) => {
      const health = this.#store.connections.get(index);
      return { health, look: lookOfConnection(health), connection: this.#store.cell?.connections?.[index] ?? {} };
    }).sort((a, b) => b.look.rank - a.look.rank);
    const { health, look, connection } = all[0];
    setAttribute(wire, "data-line", look.line);
    if (word) {
      const value = this.#live ? this.#store.newest.get(port) : "";
      const parts = [look.rank >= 2 ? look.short : "", value, value ? ageOf(connection, health).words : ""].filter((part) => part && part !== "-");
      if (parts.join(" \u00b7 ").length > kRoom && parts.length > 1) parts.pop();
      setAttribute(word, "class", `state ${look.look}-word`);
      setText(word, parts.join(" \u00b7 ").slice(0, kRoom));
    }
    const lines = all.map(({ connection: { from, to, text }, look: its }) => `${from ?? "outside"} \u2192 ${to ?? "outside"}: ${text}; ${its.word}`);
    for (const title of titles) setText(title, lines.join("\n"));
  }

  #mark() {
    const selected = currentRoute().parameters.get("select");
    for (const known of [this.#devices, this.#modules]) {
      for (const [name, { group }] of known) group.classList.toggle("selected", name === selected);
    }
    this.#frame.keep((this.#modules.get(selected) ?? this.#devices.get(selected))?.group ?? null);
    for (const { indexes, group } of this.#wires) {
      const ends = indexes.flatMap((index) => [this.#store.cell?.connections?.[index]?.from, this.#store.cell?.connections?.[index]?.to]);
      const touches = selected !== null && ends.some((end) => end?.startsWith(`${selected}.`));
      group.classList.toggle("touched", touches || indexes.some((index) => selected === `connection:${index}`));
    }
  }

  #fold(name) {
    const names = new Set(this.#collapsed.split(",").filter(Boolean));
    if (!names.delete(name)) names.add(name);
    alter({ collapsed: [...names].join(",") || null });
  }

  #choose(target) {
    if (this.#frame.moved) return;
    const group = target.closest?.("[data-fold], [data-module], [data-device], [data-connection]");
    if (!group) return;
    const { fold, module, device, connection } = group.dataset;
    if (fold) this.#fold(fold);
    else alter({ select: module ?? device ?? `connection:${this.#worst(connection.split(" "))}` });
  }

  #worst(indexes) {
    const rank = (index) => lookOfConnection(this.#store.connections.get(index)).rank;
    return indexes.reduce((worst, index) => (rank(index) > rank(worst) ? index : worst));
  }

  /// Handles a key: Enter selects the focused box, the space bar collapses or expands a device, and an arrow key moves the focus to the nearest box in its direction.
  #press(event) {
    const group = event.target.closest("[data-module], [data-device]");
    if (!group || event.shiftKey || event.ctrlKey || event.altKey || event.metaKey) return;
    if (event.key === "Enter" || event.key === " ") {
      event.preventDefault();
      if (event.key === " " && group.dataset.device) this.#fold(group.dataset.device);
      else this.#choose(group);
      return;
    }
    const way = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }[event.key];
    if (!way) return;
    event.preventDefault();
    event.stopPropagation();
    const next = nearest(group, [...this.#devices.values(), ...this.#modules.values()].map((one) => one.group), way);
    if (!next) return;
    setAttribute(group, "tabindex", "-1");
    setAttribute(next, "tabindex", "0");
    next.focus({ preventScroll: true });
    this.#frame.reveal(next);
  }
}

/// Returns the box in `groups` that is nearest to `group` in a direction. Distances are between the top centres of the boxes; the sideways
/// part of a distance counts threefold.
function nearest(group, groups, [dx, dy]) {
  const head = (of) => {
    const box = of.querySelector("rect").getBBox();
    return { x: box.x + box.width / 2, y: box.y };
  };
  const here = head(group);
  let best = null;
  let least = Infinity;
  for (const other of groups) {
    if (other === group) continue;
    const there = head(other);
    const along = (there.x - here.x) * dx + (there.y - here.y) * dy;
    const aside = Math.abs((there.x - here.x) * dy) + Math.abs((there.y - here.y) * dx);
    if (along <= 1) continue;
    if (along + 3 * aside < least) {
      least = along + 3 * aside;
      best = other;
    }
  }
  return best;
}

