// The view that shows the graph of the cell. The view adds the current states, the health and the selection to the gateway's drawing.

import { drawn, element, setAttribute, setText } from "./dom.js";
import { drawingOf } from "./drawing.js";
import { Frame } from "./frame.js";
import { lookOfConnection, lookOfDevice, lookOfModule } from "./looks.js";
import { alter, currentRoute } from "./route.js";
import { duration } from "./words.js";

const kSmall = 10;  // font size of the drawing's small text

export class Graph {
  #store;
  #text;
  #modules = new Map();      // modules by name, each as {group, mark}
  #devices = new Map();
  #connections = new Map();  // connections by index, each as {group, wire, word, titles}
  #frame;

  constructor(store) {
    this.#store = store;
    this.#frame = new Frame();
    this.nothing = element("p", { class: "nothing" });
    this.element = element("div", { class: "graph" }, this.nothing, this.#frame.element);
    this.#frame.element.addEventListener("click", (event) => this.#choose(event.target));
    this.#frame.element.addEventListener("keydown", (event) => this.#press(event));
  }

  show() {
    this.#draw();
    this.#showAll();
    this.#mark();
  }

  update(changes) {
    if (changes.cell) this.#draw();
    if (changes.cell || changes.whole || changes.link) {
      this.#showAll();
      this.#mark();
      return;
    }
    for (const name of changes.devices) this.#showDevice(name);
    for (const name of changes.modules) this.#showModule(name);
    if (!changes.measures) return;
    for (const name of this.#modules.keys()) this.#showModule(name);
    for (const index of this.#connections.keys()) this.#showConnection(index);
  }

  focusOn(name) {
    (this.#modules.get(name) ?? this.#devices.get(name))?.group.focus();
  }

  #draw() {
    const text = this.#store.cell?.graph ?? null;
    if (text === this.#text && text !== null) return;
    this.#text = text;
    for (const known of [this.#modules, this.#devices, this.#connections]) known.clear();
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
    for (const group of drawing.querySelectorAll(".link[data-connection]")) this.#prepareConnection(group);
    const first = drawing.querySelector("[data-module], [data-device]");
    first?.setAttribute("tabindex", "0");
  }

  /// Replaces the text of the state in a module's box by a sign and a word, and shows the measured jitter on the right.
  #prepare(group, name, known) {
    const box = group.querySelector("rect");
    const state = group.querySelector("text.state");
    if (!box || !state) return;
    const [x, y, width, height] = ["x", "y", "width", "height"].map((of) => Number(box.getAttribute(of)));
    const [left, line] = ["x", "y"].map((of) => Number(state.getAttribute(of)));
    state.remove();
    const use = drawn("use", { width: kSmall, height: kSmall, x: left + 2, y: line - kSmall + 1 });
    const word = drawn("text", { "font-size": kSmall, class: "state-word", x: left + kSmall + 6, y: line });
    const measure = drawn("text", { "font-size": kSmall, class: "faint", "text-anchor": "end", x: x + width - 6, y: line });
    const strip = drawn("rect", { x, y, width: 4, height, class: "strip" });
    group.append(...(known === this.#modules ? [strip] : []), use, word, measure);
    setAttribute(group, "role", "button");
    setAttribute(group, "tabindex", "-1");
    // Remove the state from the tooltip of the box. The tooltip has the state at the time of the drawing, not the current state.
    const title = group.querySelector("title");
    known.set(name, { group, use, word, measure, title, about: title?.textContent.replace(/; [^;]*$/, "") });
  }

  #prepareConnection(group) {
    const wire = group.querySelector("path.wire");
    if (!wire) return;
    const index = group.dataset.connection;
    wire.classList.remove("good", "poor", "bad", "broken");
    const word = group.ownerSVGElement.querySelector(`.label[data-connection="${CSS.escape(index)}"] .state`);
    if (word) word.textContent = "";
    const titles = group.ownerSVGElement.querySelectorAll(`[data-connection="${CSS.escape(index)}"] > title`);
    this.#connections.set(index, { group, wire, word, titles });
  }

  #showAll() {
    for (const name of this.#devices.keys()) this.#showDevice(name);
    for (const name of this.#modules.keys()) this.#showModule(name);
    for (const index of this.#connections.keys()) this.#showConnection(index);
  }

  #showDevice(name) {
    const drawn = this.#devices.get(name);
    if (!drawn) return;
    const look = lookOfDevice(this.#store.devices.get(name));
    this.#showLook(drawn, look);
    setAttribute(drawn.group, "aria-label", `device ${name}: ${look.word}`);
    for (const module of this.#store.modulesOf(name)) this.#showModule(module.name);
  }

  #showModule(name) {
    const drawn = this.#modules.get(name);
    const module = this.#store.modules.get(name);
    if (!drawn || !module) return;
    const look = lookOfModule(this.#store.shown(module));
    this.#showLook(drawn, look);
    const p99 = module.measures?.jitter_us.p99;
    const room = look.word.length < 14 && p99 !== undefined && look.key !== "lost";
    setText(drawn.measure, room ? `p99 ${duration(p99)}` : "");
    setAttribute(drawn.group, "aria-label", `${name}: ${look.word}`);
  }

  #showLook(drawn, look) {
    setAttribute(drawn.group, "data-look", look.look);
    setAttribute(drawn.group, "data-state", look.key);
    setAttribute(drawn.use, "href", `#sign-${look.sign}`);
    setText(drawn.word, look.word);
    if (drawn.title) setText(drawn.title, `${drawn.about}; ${look.word}`);
  }

  #showConnection(index) {
    const drawn = this.#connections.get(index);
    const health = this.#store.connections.get(index);
    const look = lookOfConnection(health);
    setAttribute(drawn.wire, "data-line", look.line);
    if (drawn.word) {
      setAttribute(drawn.word, "class", `state ${look.look}-word`);
      setText(drawn.word, look.rank >= 2 ? look.short : "");
    }
    const { from, to, text } = this.#store.cell?.connections?.[index] ?? {};
    for (const title of drawn.titles) setText(title, `${from ?? "outside"} \u2192 ${to ?? "outside"}: ${text}; ${look.word}`);
  }

  #mark() {
    const selected = currentRoute().parameters.get("select");
    for (const known of [this.#devices, this.#modules]) {
      for (const [name, { group }] of known) group.classList.toggle("selected", name === selected);
    }
    this.#frame.keep((this.#modules.get(selected) ?? this.#devices.get(selected))?.group ?? null);
    for (const [index, { group }] of this.#connections) {
      const { from, to } = this.#store.cell?.connections?.[index] ?? {};
      const touches = selected !== null && [from, to].some((end) => end?.startsWith(`${selected}.`));
      group.classList.toggle("touched", touches);
    }
  }

  #choose(target) {
    if (this.#frame.moved) return;
    const group = target.closest?.("[data-module], [data-device]");
    if (group) alter({ select: group.dataset.module ?? group.dataset.device });
    else {
      const link = target.closest?.("[data-connection]");
      if (link) alter({ select: `connection:${link.dataset.connection}` });
    }
  }

  /// Handles a key: Enter selects the focused box, and an arrow key moves the focus to the nearest box in its direction.
  #press(event) {
    const group = event.target.closest("[data-module], [data-device]");
    if (!group || event.shiftKey || event.ctrlKey || event.altKey || event.metaKey) return;
    if (event.key === "Enter" || event.key === " ") {
      event.preventDefault();
      this.#choose(group);
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

