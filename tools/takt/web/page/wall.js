// The view for a screen on the wall (the address ends in ?wall), legible from several metres: the worst unacknowledged
// alarm, else the last fault, and one tile per device, the worst first. The size of the text depends on the width of the screen and on the number of devices.

import { nameOf, open, sentenceOf, textOf } from "./alarms.js";
import { element, Mark, setAttribute, setText } from "./dom.js";
import { lookOfDevice, lookOfModule, lookOfSeverity, rankOf } from "./looks.js";
import { instant } from "./words.js";

const kListed = 3;   // modules that a tile names
const kTiles = 12;   // tiles that fit at full size

class Tile {
  constructor(name) {
    this.mark = new Mark();
    this.count = element("p", { class: "faint" });
    this.modules = element("ul");
    this.element = element("section", { dataset: { device: name } }, element("h2", { class: "name", text: name }), this.mark.element, this.count,
      this.modules);
  }

  show(name, store) {
    const look = lookOfDevice(store.devices.get(name));
    const modules = store.modulesOf(name).map((module) => ({ module, look: lookOfModule(store.shown(module)) }));
    const trouble = modules.filter(({ look }) => look.look !== "good").sort((a, b) => rankOf(a.look) - rankOf(b.look));
    const worst = [look, ...trouble.map((one) => one.look)].sort((a, b) => rankOf(a) - rankOf(b))[0];
    this.rank = rankOf(worst);
    this.mark.show(look);
    setAttribute(this.element, "data-look", worst.look);
    setText(this.count, `${modules.filter(({ look }) => look.key === "EXECUTING").length} of ${modules.length} EXECUTING`);
    const lost = look.key === "lost" || look.key === "none";  // one word for the device says the same about its modules
    const lines = lost ? [] : trouble.slice(0, kListed).map(({ module, look }) => ({ name: module.label, look: look.alarm ? { ...look, word: `${look.word}, alarm` } : look }));
    const more = lost ? 0 : trouble.length - lines.length;
    const shown = JSON.stringify([lines, more]);
    if (shown === this.shown) return;
    this.shown = shown;
    this.modules.replaceChildren(...lines.map(({ name, look }) => {
      const mark = new Mark();
      mark.show(look);
      return element("li", {}, element("span", { class: "name", text: name }), mark.element);
    }), more > 0 ? element("li", { text: `and ${more} more` }) : "");
  }
}

export class Wall {
  #store;
  #tiles = new Map();

  constructor(store) {
    this.#store = store;
    this.grid = element("div", { class: "tiles" });
    this.news = new Mark("p");
    this.element = element("div", { class: "wall-view" }, this.news.element, this.grid);
  }

  show() {
    this.#showAll();
  }

  update() {
    this.#showAll();
  }

  #showAll() {
    const names = this.#store.deviceNames;
    for (const name of this.#tiles.keys()) if (!names.includes(name)) this.#tiles.delete(name);
    for (const name of names) {
      if (!this.#tiles.has(name)) this.#tiles.set(name, new Tile(name));
      this.#tiles.get(name).show(name, this.#store);
    }
    const tiles = [...this.#tiles.values()].sort((a, b) => a.rank - b.rank);
    const order = tiles.map(({ element }) => element);
    if (order.some((one, i) => this.grid.children[i] !== one) || this.grid.children.length !== order.length) this.grid.replaceChildren(...order);
    this.element.style.setProperty("--shrink", Math.min(1, Math.sqrt(kTiles / Math.max(names.length, 1))));
    this.news.show(this.#newest());
  }

  /// The worst unacknowledged alarm, above the tiles. Without an alarm, the last fault, below them.
  #newest() {
    const [alarm] = open(this.#store);
    this.element.classList.toggle("alarmed", alarm !== undefined);
    if (alarm) return { ...lookOfSeverity(alarm.severity), word: `${nameOf(alarm)} ${textOf(alarm)} since ${instant(alarm.since_ms, {})}${alarm.state === "unacknowledged" ? "" : ", returned to normal"}${alarm.cause ? `: ${alarm.cause}` : ""}` };
    const last = this.#store.faults.findLast((event) => event.severity !== "note");
    if (!last) return { look: "faint", sign: "good", word: "no recent errors or warnings" };
    return { ...lookOfSeverity(last.severity), word: `${instant(last.time_ms, {})} ${nameOf(last)}: ${sentenceOf(last)}` };
  }
}
