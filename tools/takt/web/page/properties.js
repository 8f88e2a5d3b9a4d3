// Shows the properties of a module, with fields to set them. A module applies a new value between two cycles.

import { get, post } from "./api.js";
import { element, setText } from "./dom.js";
import { number } from "./words.js";

const kAgain_ms = 2000;

class Property {
  constructor(panel, property) {
    this.panel = panel;
    this.property = property;
    this.shown = String(property.value ?? "");
    this.field = this.#field();
    this.field.setAttribute("aria-label", property.name);
    this.set = element("button", { type: "submit", text: "Set" });
    this.answer = element("p", { class: "answer small", role: "status" });
    this.element = element("form", { class: "property", dataset: { property: property.name }, on: { submit: (event) => this.#submit(event) } },
      element("span", { class: "name", text: property.name }), this.field,
      element("span", { class: "faint unit", text: property.unit ?? "" }), this.set,
      element("p", { class: "faint small about", text: [property.range ?? range(property), property.text].filter(Boolean).join("; ") }), this.answer);
  }

  #field() {
    const { type, value, choices } = this.property;
    const options = type === "bool" || type === "boolean" ? ["false", "true"] : choices;
    if (options?.length > 0) {
      const select = element("select", {}, ...options.map((text) => element("option", { value: text, text })));
      select.value = String(value);
      return select;
    }
    return element("input", { type: "text", value: String(value ?? ""), spellcheck: "false", autocomplete: "off" });
  }

  /// True if `other` describes the same property; the values may differ.
  is(other) {
    const kind = ({ value, ...rest }) => JSON.stringify(rest);
    return kind(this.property) === kind(other);
  }

  /// Shows a new value, except in a field that the user is editing.
  take(value) {
    const text = String(value ?? "");
    if (this.field.value === this.shown) this.field.value = text;
    this.shown = text;
  }

  may(command) {
    this.field.disabled = this.set.disabled = !command;
  }

  async #submit(event) {
    event.preventDefault();
    const value = this.field.value;
    this.#say("setting ...", "plain");
    try {
      const answer = await post("api/property", { module: this.panel.module, property: this.property.name, value });
      this.shown = this.field.value = String(answer.value ?? value);
      this.#say(`is now ${this.shown}`, "good");
    } catch (problem) {
      this.#say(problem.text ?? problem.message, "bad");
    }
  }

  #say(text, look) {
    this.answer.dataset.look = look;
    setText(this.answer, text);
  }
}

function range({ min, max }) {
  const has = (limit) => limit !== null && limit !== undefined;
  if (has(min) && has(max)) return `${number(min)} to ${number(max)}`;
  if (has(min)) return `at least ${number(min)}`;
  return has(max) ? `at most ${number(max)}` : "";
}

export class Properties {
  #store;
  #shown = new Map();

  constructor(store) {
    this.#store = store;
    this.list = element("div");
    this.why = element("p", { class: "faint small" });
    this.element = element("section", { class: "properties" }, element("h3", {}, "Properties ",
      element("button", { type: "button", class: "quiet", text: "Refresh", on: { click: () => this.ask() } })), this.why, this.list);
  }

  hold(module) {
    this.module = module;
    this.#shown.clear();
    this.list.replaceChildren(element("p", { class: "faint", text: "loading ..." }));
    this.ask();
  }

  update() {
    const may = this.#store.rights.command && this.#store.link === "live";
    setText(this.why, may ? "" : `Read-only: ${this.#store.rights.command ? "the connection to takt web is lost" : this.#store.rights.why}.`);
    for (const property of this.#shown.values()) property.may(may);
  }

  /// Asks the device for the module's properties. If that fails, asks once more, because a device may not answer yet when it has just
  /// reported that it runs.
  async ask(again = true) {
    const module = this.module;
    try {
      const { properties } = await get("api/properties", { module });
      if (module === this.module) this.#show(properties);
    } catch (problem) {
      if (module !== this.module) return;
      this.#shown.clear();
      this.list.replaceChildren(element("p", { class: "answer", "data-look": "bad", text: problem.text ?? problem.message }));
      if (again) setTimeout(() => module === this.module && this.ask(false), kAgain_ms);
    }
  }

  #show(properties) {
    const same = properties.length === this.#shown.size && properties.every((one) => this.#shown.get(one.name)?.is(one));
    if (same && properties.length > 0) {
      for (const { name, value } of properties) this.#shown.get(name).take(value);
      return;
    }
    this.#shown = new Map(properties.map((property) => [property.name, new Property(this, property)]));
    const nothing = element("p", { class: "faint", text: "none" });
    this.list.replaceChildren(...(properties.length > 0 ? [...this.#shown.values()].map((one) => one.element) : [nothing]));
    this.update();
  }
}
