// The tree of the devices and modules, the worst first, with a field to find one by its name or state.

import { arrows, element, Mark, setAttribute, setText } from "./dom.js";
import { lookOfDevice, lookOfModule, rankOf } from "./looks.js";
import { currentRoute, linkTo } from "./route.js";
import { several } from "./words.js";

class Item {
  constructor(name, label, level) {
    this.mark = new Mark();
    this.element = linkTo(name, "", { role: "treeitem", "aria-level": level, dataset: { item: name } });
    this.element.append(this.mark.element, element("span", { class: "name", text: label }), this.word = element("span", { class: "small state" }));
  }

  show(name, look) {
    this.look = look;
    this.mark.show({ ...look, word: "" });
    setText(this.word, ` ${look.key === "lost" ? "lost" : look.alarm && look.key === "EXECUTING" ? "alarm" : look.word}`);
    setAttribute(this.word, "data-look", look.look);
    this.word.classList.toggle("unseen", look.look === "good");
    this.text = `${name} ${look.word}${look.alarm ? " alarm" : ""}`.toLowerCase();
    setAttribute(this.element, "aria-selected", String(name === currentRoute().parameters.get("select")));
  }
}

export class Tree {
  #store;
  #items = new Map();
  #order = "";

  constructor(place, store) {
    this.#store = store;
    this.filter = element("input", { type: "search", placeholder: "find  ( / )", "aria-label": "find a device or module by name or state",
      on: { input: () => this.#showAll(), keydown: (event) => this.#press(event) } });
    this.list = element("div", { role: "tree", "aria-label": "devices and modules" });
    this.count = element("p", { class: "faint small", role: "status" });
    place.append(this.filter, this.list, this.count);
    arrows(this.list, "[role=treeitem]");
    // No line moves away below the mouse.
    this.list.addEventListener("pointerenter", ({ pointerType }) => { this.held = pointerType === "mouse"; });
    this.list.addEventListener("pointerleave", () => { this.held = false; this.#showAll(); });
  }

  show() {
    this.#showAll();
  }

  update(changes) {
    if (changes.cell || changes.whole || changes.measures || changes.devices.size > 0 || changes.modules.size > 0) this.#showAll();
  }

  #press(event) {
    const first = this.list.firstChild;
    if (event.key === "ArrowDown" && first) {
      event.preventDefault();
      first.focus();
    }
    const chosen = event.key === "Enter" ? this.list.querySelector("[aria-level='2']") ?? first : null;
    if (event.key === "Escape" && this.filter.value !== "") event.stopPropagation();  // this Escape does not close the details
    else if (!chosen) return;
    this.filter.value = "";
    this.#showAll();
    chosen?.click();
  }

  #item(name, label, level, look) {
    if (!this.#items.has(name)) this.#items.set(name, new Item(name, label, level));
    const item = this.#items.get(name);
    item.show(name, look);
    return item;
  }

  #showAll() {
    const words = this.filter.value.toLowerCase();
    const byRank = (a, b) => a.rank - b.rank;
    const found = ({ text }) => text.includes(words);
    const known = new Set();
    let shown = 0;
    const groups = this.#store.deviceNames.map((name) => {
      const device = this.#item(name, name, 1, lookOfDevice(this.#store.devices.get(name)));
      const modules = this.#store.modulesOf(name).map((module) => this.#item(module.name, module.label, 2, lookOfModule(this.#store.shown(module))));
      for (const { element: { dataset } } of [device, ...modules]) known.add(dataset.item);
      const some = modules.map((item) => ({ item, rank: rankOf(item.look) })).filter(({ item }) => found(item)).sort(byRank);
      shown += some.length;
      return { rank: Math.min(...[device, ...modules].map(({ look }) => rankOf(look))), items: some.length > 0 || found(device) ? [device, ...some.map(({ item }) => item)] : [] };
    });
    for (const name of this.#items.keys()) if (!known.has(name)) this.#items.delete(name);
    const lines = groups.sort(byRank).flatMap(({ items }) => items.map((item) => item.element));
    setText(this.count, words ? `${shown} of ${several(this.#store.modules.size, "module")}` : "");
    const order = lines.map((line) => line.dataset.item).join(" ");
    if (order === this.#order) return;
    if (this.held && lines.length === this.list.children.length && lines.every((line) => line.parentNode === this.list)) return;
    this.#order = order;
    const focused = document.activeElement;
    this.list.replaceChildren(...lines);
    if (focused !== document.activeElement && this.list.contains(focused)) focused.focus({ preventScroll: true });
    lines.forEach((line, i) => setAttribute(line, "tabindex", i === 0 ? "0" : "-1"));
  }
}
