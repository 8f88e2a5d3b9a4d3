// Shows the details of a connection: its health, its ends, and the values that it carries.

import { Bar, element, Mark, setText } from "./dom.js";
import { Facts } from "./facts.js";
import { ageOf, lookOfConnection } from "./looks.js";
import { PortList } from "./port_list.js";
import { linkTo } from "./route.js";
import { count, exact } from "./words.js";

export class ConnectionDetails {
  #store;

  constructor(store) {
    this.#store = store;
    this.mark = new Mark("p");
    this.facts = new Facts();
    this.age = new Bar();
    this.ends = element("p", { class: "buttons" });
    this.ports = new PortList(store);
    const part = (title, ...children) => element("section", {}, element("h3", { text: title }), ...children);
    this.title = element("p", { class: "ends" });
    this.element = element("div", {}, this.title, this.mark.element, part("Modules", this.ends, this.age.element, this.facts.element), part("Values", this.ports.element));
  }

  show(name) {
    this.index = name.split(":")[1];
    const { from, to } = this.#connection ?? {};
    const modules = [from, to].filter(Boolean).map((port) => port.split(".", 2).join("."));
    setText(this.title, `${from ?? "outside"} \u2192 ${to ?? "outside"}`);
    this.ends.replaceChildren(...[...new Set(modules)].map((module) => linkTo(module, module)));
    this.ports.hold(from?.split(".", 2).join(".") ?? "");
    this.ports.show(from ? [{ name: from, direction: "out", type: "" }] : []);
    this.update({ measures: true });
  }

  hide() {
    this.ports.hide();
  }

  get #connection() {
    return this.#store.cell?.connections?.[this.index];
  }

  update(changes) {
    if (changes.cell) this.show(`connection:${this.index}`);
    if (!changes.measures) return;
    const connection = this.#connection;
    if (!connection) {
      this.mark.show({ look: "faint", sign: "wait", word: "the cell has no such connection" });
      return;
    }
    const health = this.#store.connections.get(this.index);
    this.mark.show(lookOfConnection(health));
    const age = ageOf(connection, health);
    this.age.show(age.share, `newest value ${age.words} old${connection.deadline_ns ? `, deadline ${exact(connection.deadline_ns)}` : ""}`);
    this.facts.show([["kind", connection.text ?? connection.kind], ...["lost", "dropped", "late"].map((what) => [what, count(health?.[what])])]);
    this.ports.showHealth();
  }
}
