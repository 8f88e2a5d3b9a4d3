// The view that shows the fields on the watch list, with their newest values.

import { element, setText } from "./dom.js";
import { Field, shownInstant, watched } from "./fields.js";
import { portOf } from "./ports.js";
import { addressOf } from "./route.js";
import { clock, listed, several } from "./words.js";

const kPorts = 12;  // limit of the ports, so that the details and the plots can show ports, too

export class Watch {
  insists = true;
  #store;
  #fields = [];

  constructor(store) {
    this.#store = store;
    this.status = element("span", { class: "faint", role: "status" });
    this.plot = element("a", { text: "plot them" });
    this.body = element("tbody");
    const head = (text) => element("th", { scope: "col", text });
    this.table = element("table", { class: "list watch" }, element("caption", { class: "unseen", text: "watch list" }),
      element("thead", {}, element("tr", {}, ...["field", "value", "age", "last minute", "watch"].map(head))), this.body);
    this.element = element("div", { class: "scrolled" }, element("div", { class: "tools" }, this.plot, this.status), this.table);
  }

  show() {
    const names = watched();
    const ports = [...new Set(names.map(portOf))].slice(0, kPorts);
    if (String(names) !== String(this.#fields.map((field) => field.name))) {
      this.#fields = names.map((name) => new Field(this.#store, name, name));
      this.body.replaceChildren(...this.#fields.map((field) => field.element));
    }
    this.table.hidden = this.plot.hidden = names.length === 0;
    this.plot.href = addressOf("plots", { series: names.join(",") });
    this.#store.ports.want(this, ports);
    this.answered();
    this.arrived();
  }

  hide() {
    this.#store.ports.want(this, []);
  }

  update() {}

  redraw() {
    this.arrived();
  }

  answered() {
    const ports = [...new Set(this.#fields.map((field) => field.port))];
    const problem = ports.map((port) => this.#store.ports.problem(port)).find(Boolean) ?? this.#store.ports.problem("");
    const at = shownInstant();
    const unknown = this.#fields.filter(({ name, port }) => this.#store.ports.get(port)?.fields?.every((field) => `${port}.${field.name}` !== name));
    setText(this.status, ports.length === 0 ? "Nothing is watched. Select a module, and press the star of a value in its details."
      : ports.length > kPorts ? `Shows the first ${kPorts} of ${several(ports.length, "port")}.`
        : problem ? [problem.what, problem.fix].filter(Boolean).join("; ")
          : unknown.length > 0 ? `${listed(unknown.map(({ name }) => name))}: the port has no such field` : at ? `at ${clock(at)}` : "");
  }

  described() {
    this.answered();
    this.arrived();
  }

  arrived() {
    for (const field of this.#fields) field.show();
  }
}
