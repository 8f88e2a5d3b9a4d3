// One line for a field of a port: its newest value, its trend in the last minute, and a star that puts it on the watch list.

import { element, setAttribute, setText } from "./dom.js";
import { portOf } from "./ports.js";
import { alter, currentRoute } from "./route.js";
import { Spark } from "./spark.js";
import { tableOf } from "./value_rows.js";
import { digits, duration } from "./words.js";

const kTrend_ms = 60000;
const kFresh_ms = 1000;  // values arrive in groups, so a younger value has no age that a person could read

/// The fields on the watch list, as device.module.port.field. The address keeps them.
export function watched() {
  return (currentRoute().parameters.get("watch") ?? "").split(",").filter((name) => name.split(".").length > 3);
}

/// The instant that the page shows, in ms, or null for now.
export function shownInstant() {
  return Number(currentRoute().parameters.get("at")) || null;
}

export class Field {
  #drawn = 0;

  /// `name` is device.module.port.field; `text` is shown instead.
  constructor(store, name, text) {
    Object.assign(this, { store, name, port: portOf(name) });
    this.spark = new Spark(kTrend_ms, { zero: false });
    const cell = (what, ...children) => element("td", { class: what, "data-label": what }, ...children);
    this.value = cell("value");
    this.age = cell("age");
    this.star = element("button", { type: "button", class: "star", on: { click: () => this.#toggle() } });
    this.element = element("tr", { dataset: { field: name } }, element("th", { scope: "row", class: "name", text }), this.value,
      this.age, element("td", { class: "trend-of-field" }, this.spark.element), element("td", {}, this.star));
    this.showStar();
  }

  showStar() {
    const is = watched().includes(this.name);
    setText(this.star, is ? "\u2605" : "\u2606");
    setAttribute(this.star, "aria-pressed", String(is));
    setAttribute(this.star, "aria-label", `watch ${this.name}`);
  }

  show() {
    const { rows, fields } = this.store.ports.get(this.port) ?? {};
    const column = 1 + (fields ?? []).findIndex((field) => `${this.port}.${field.name}` === this.name);
    const to = shownInstant() ?? Math.max(this.store.now, rows?.newest ?? 0);
    const row = column > 0 ? rows.at(to) : undefined;
    const value = row?.[column] ?? null;
    const { labels, unit } = fields?.[column - 1] ?? {};
    setText(this.value, labels?.[value] ?? digits(value) + (unit && value !== null ? ` ${unit}` : ""));
    setText(this.age, !row ? "" : to - row[0] < kFresh_ms ? "< 1 s" : duration(Math.round((to - row[0]) / 1000) * 1e6));
    if (column === 0 || performance.now() - this.#drawn < kFresh_ms) return;
    this.#drawn = performance.now();
    this.spark.showPoints(tableOf([{ rows, column, labels }], to - kTrend_ms, to).map(([time, of]) => [time - to + kTrend_ms, of]));
  }

  #toggle() {
    const names = watched();
    alter({ watch: (names.includes(this.name) ? names.filter((one) => one !== this.name) : [...names, this.name]).join(",") || null });
  }
}
