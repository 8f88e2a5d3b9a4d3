// The ports of a module, each with its connections and their health, and the newest values of its fields. The gateway collects the values of
// outputs only, so an input shows those of the output that is connected to it.

import { arrows, element, Mark } from "./dom.js";
import { Field } from "./fields.js";
import { lookOfConnection } from "./looks.js";
import { addressOf, linkTo } from "./route.js";

const kPorts = 12;  // limit of the ports whose values are shown, so that the plots and the watch list can show ports, too
const kFields = 6;  // number of fields of a port that are shown at first

export class PortList {
  #store;
  #module = "";
  #ports = null;     // null: not known yet
  #ends = [];        // the mark of each connection
  #fields = [];

  constructor(store) {
    this.#store = store;
    this.element = element("ul", { class: "ports" });
    arrows(this.element, ".star, .values button");
  }

  hold(module) {
    [this.#module, this.#ports] = [module, null];
    this.element.replaceChildren(element("li", { class: "faint", text: "loading ..." }));
  }

  hide() {
    this.#store.ports.want(this, []);
  }

  fail(text) {
    this.#ports = null;
    this.element.replaceChildren(element("li", { class: "answer", "data-look": "bad", text }));
  }

  show(ports) {
    this.#ports = ports;
    this.rebuild();
    this.#store.ports.want(this, [...new Set(this.sources.map(({ source }) => source).filter(Boolean))].slice(0, kPorts));
    this.described();
  }

  rebuild() {
    if (this.#ports === null) return;
    this.#ends = [];
    this.#fields = [];
    this.sources = this.#ports.map((port) => this.#port(port));
    this.element.replaceChildren(...(this.sources.length > 0 ? this.sources.map(({ line }) => line) : [element("li", { class: "faint", text: "none" })]));
    this.showHealth();
    this.described();
  }

  #port({ name, direction, type }) {
    const connections = [...(this.#store.cell?.connections ?? []).entries()].filter(([, { from, to }]) => from === name || to === name);
    const source = direction === "out" ? name : connections[0]?.[1].from;
    const ends = connections.map(([index, connection]) => {
      const mark = new Mark();
      this.#ends.push({ index, mark });
      const other = connection.from === name ? `\u2192 ${connection.to ?? "outside"}` : `\u2190 ${connection.from ?? "outside"}`;
      return element("div", { class: "end" }, linkTo(`connection:${index}`, other), mark.element);
    });
    const body = element("tbody");
    const line = element("li", {}, element("a", { href: addressOf("plots", { port: source ?? name }), text: name.slice(this.#module.length + 1) }),
      type ? element("span", { class: "faint", text: ` ${direction === "in" ? "reads" : "writes"} ${type}` }) : "",
      ...(ends.length > 0 ? ends : [element("div", { class: "end faint", text: "not connected" })]), element("table", { class: "numbers values" }, body));
    return { source, line, body };
  }

  showHealth() {
    for (const { index, mark } of this.#ends) mark.show(lookOfConnection(this.#store.connections.get(String(index))));
  }

  answered() {
    for (const { source, body } of this.sources ?? []) {
      const problem = this.#store.ports.problem(source) ?? this.#store.ports.problem("");
      if (problem && !body.firstChild) body.append(element("tr", {}, element("td", { class: "faint small", text: problem.what })));
    }
  }

  /// Makes a line for each field of the ports that are known by now.
  described() {
    for (const { source, body } of this.sources ?? []) {
      const fields = this.#store.ports.get(source)?.fields;
      if (!fields || body.querySelector("[data-field]")) continue;
      body.replaceChildren();
      const make = (some) => some.forEach(({ name }) => {
        const field = new Field(this.#store, `${source}.${name}`, name);
        this.#fields.push(field);
        body.append(field.element);
      });
      make(fields.slice(0, kFields));
      const rest = fields.slice(kFields);
      if (rest.length > 0) body.append(element("tr", {}, element("td", { colspan: 5 }, element("button", { type: "button", class: "quiet", text: `${rest.length} more`,
        on: { click: (event) => {
          event.target.closest("tr").remove();
          make(rest);
          this.arrived();
          this.#fields.at(-rest.length).star.focus();
        } } }))));
    }
    this.arrived();
  }

  showStars() {
    for (const field of this.#fields) field.showStar();
  }

  arrived() {
    for (const field of this.#fields) field.show();
  }
}
