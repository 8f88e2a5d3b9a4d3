// The view that lists the connections with their health, the worst first.

import { arrows, Bar, element, Mark, setAttribute, setText } from "./dom.js";
import { ageOf, lookOfConnection } from "./looks.js";
import { adjust, alter, linkTo } from "./route.js";
import { count, exact, several } from "./words.js";

class Row {
  constructor(index, connection) {
    this.index = index;
    this.name = `connection:${index}`;
    this.connection = connection;
    this.mark = new Mark();
    this.age = new Bar();
    this.numbers = ["lost", "dropped", "late"].map((what) => ({ what, cell: element("td", { class: "number", dataset: { label: what } }) }));
    this.link = linkTo(this.name, "", { class: "ends" });
    this.link.append(element("span", { text: connection.from ?? "outside" }), element("span", { text: `\u2192 ${connection.to ?? "outside"}` }));
    this.element = element("tr", { dataset: { connection: index } },
      element("th", { scope: "row" }, this.link, element("div", { class: "faint small", text: connection.text ?? connection.kind })),
      element("td", {}, this.mark.element), element("td", { dataset: { label: "age" } }, this.age.element), ...this.numbers.map(({ cell }) => cell));
  }

  show(health) {
    this.look = lookOfConnection(health);
    this.mark.show(this.look);
    const age = ageOf(this.connection, health);
    this.age.show(age.share, this.connection.deadline_ns ? `${age.words} of ${exact(this.connection.deadline_ns)}` : age.words);
    for (const { what, cell } of this.numbers) setText(cell, count(health?.[what]));
  }
}

export class Connections {
  #store;
  #rows = [];
  #cell = null;
  #order = "";

  constructor(store) {
    this.#store = store;
    this.filter = element("input", { type: "search", placeholder: "port or health", "aria-label": "filter by port or health",
      on: { input: () => { adjust({ filter: this.filter.value }); this.#arrange(); } } });
    this.shown = element("span", { class: "faint", role: "status" });
    this.body = element("tbody");
    const head = (text) => element("th", { scope: "col", text });
    this.element = element("div", { class: "scrolled" }, element("div", { class: "tools" }, this.filter, this.shown),
      element("table", { class: "list connections" }, element("caption", { class: "unseen", text: "connections of the cell" }),
        element("thead", {}, element("tr", {}, head("from \u2192 to"), head("health"), head("age of the newest value"), head("lost"),
          head("dropped"), head("late"))), this.body));
    arrows(this.body, "a");
    this.body.addEventListener("click", (event) => {
      const row = this.#rows.find(({ element: { dataset } }) => dataset.connection === event.target.closest("tr")?.dataset.connection);
      if (row && !event.target.closest("a")) alter({ select: row.name });
    });
  }

  show(parameters) {
    if (this.filter.value !== (parameters.get("filter") ?? "")) this.filter.value = parameters.get("filter") ?? "";
    this.#rebuild();
    for (const row of this.#rows) {
      const is = row.name === parameters.get("select");
      if (is && !row.element.classList.contains("selected")) row.element.scrollIntoView({ block: "nearest" });
      row.element.classList.toggle("selected", is);
    }
  }

  update(changes) {
    if (changes.cell) this.#rebuild();
    else if (changes.measures) this.#showHealth();
  }

  focusOn(name) {
    this.#rows.find((row) => row.name === name)?.link.focus();
  }

  #rebuild() {
    const connections = this.#store.cell?.connections ?? [];
    if (this.#cell !== connections) {
      this.#cell = connections;
      this.#rows = connections.map((connection, index) => new Row(index, connection));
      this.#order = "";
    }
    this.#showHealth();
  }

  #showHealth() {
    for (const row of this.#rows) row.show(this.#store.connections.get(String(row.index)));
    this.#arrange();
  }

  #arrange() {
    const words = this.filter.value.toLowerCase();
    const shown = this.#rows.filter((row) => `${row.connection.from} ${row.connection.to} ${row.look.word}`.toLowerCase().includes(words));
    shown.sort((a, b) => b.look.rank - a.look.rank || a.index - b.index);
    const bad = this.#rows.filter((row) => row.look.rank >= 2).length;
    const all = shown.length === this.#rows.length ? several(shown.length, "connection") : `${shown.length} of ${several(this.#rows.length, "connection")}`;
    setText(this.shown, this.#rows.length === 0 ? "no connections" : `${all}; ${bad === 0 ? "all ok" : `${bad} with problems`}`);
    const order = shown.map((row) => row.index).join(" ");
    if (order === this.#order) return;
    this.#order = order;
    const focused = document.activeElement;
    this.body.replaceChildren(...shown.map((row) => row.element));
    if (focused !== document.activeElement && this.body.contains(focused)) focused.focus({ preventScroll: true });
    shown.forEach((row, i) => setAttribute(row.link, "tabindex", i === 0 ? "0" : "-1"));
  }
}

