// Shows the details of a connection: its health, its ends, and the values that it carries.

import { Bar, element, Mark } from "./dom.js";
import { Facts } from "./facts.js";
import { ageOf, lookOfConnection } from "./looks.js";
import { PortList } from "./port_list.js";
import { linkTo, nameOfConnection } from "./route.js";
import { count, exact } from "./words.js";

export class ConnectionDetails {
  #store;
  #name = null;

  constructor(store) {
    this.#store = store;
    this.mark = new Mark("p");
    this.facts = new Facts();
    this.age = new Bar();
    this.ends = element("p", { class: "buttons" });
    this.ports = new PortList(store);
    const part = (title, ...children) => element("section", {}, element("h3", { text: title }), ...children);
    this.element = element("div", {}, this.mark.element, part("Connection", this.ends, this.age.element, this.facts.element), part("Values", this.ports.element));
  }

  show(name) {
    this.#name = name;
    const { from, to } = this.#connection ?? {};
    const modules = [from, to].filter(Boolean).map((port) => port.split(".", 2).join("."));
    this.ends.replaceChildren(...[...new Set(modules)].map((module) => linkTo(module, module)));
    this.ports.hold(from?.split(".", 2).join(".") ?? "");
    this.ports.show(from ? [{ name: from, direction: "out", type: "" }] : []);
    this.update({ measures: true });
  }

  hide() {
    this.#name = null;
    this.ports.hide();
  }

  get #connection() {
    return this.#store.cell?.connections?.find((one) => nameOfConnection(one) === this.#name);
  }

  update(changes) {
    if (changes.cell) this.show(this.#name);
    if (!changes.measures) return;
    const connection = this.#connection;
    if (!connection) {
      this.mark.show({ look: "faint", sign: "wait", word: "the cell has no such connection" });
      return;
    }
    const health = this.#store.connections.get(String(this.#store.cell.connections.indexOf(connection)));
    this.mark.show(lookOfConnection(health));
    const age = ageOf(connection, health);
    this.age.show(age.share, `newest value ${age.words} old${connection.deadline_ns ? `, deadline ${exact(connection.deadline_ns)}` : ""}`);
    this.facts.show([["kind", connection.text ?? connection.kind], ...["lost", "dropped", "late"].map((what) => [what, count(health?.[what])])]);
    this.ports.showHealth();
  }
}
