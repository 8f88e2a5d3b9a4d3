// Lists of labels with values. Only the lines that have changed are written to the page.

import { element, setText } from "./dom.js";

export class Facts {
  #values = new Map();

  constructor() {
    this.element = element("dl", { class: "facts" });
  }

  /// Shows pairs of a label and a text, one per line. A line with an empty text is hidden.
  show(pairs) {
    for (const [what, text] of pairs) {
      let line = this.#values.get(what);
      if (!line) {
        line = { what: element("dt", { text: what }), value: element("dd", { dataset: { of: what } }) };
        this.#values.set(what, line);
        this.element.append(line.what, line.value);
      }
      line.what.hidden = line.value.hidden = text === "" || text === null || text === undefined;
      setText(line.value, String(text ?? ""));
    }
  }
}

/// A table of measurements. Each line has a label and the values {mean, p50, p99, p999, max}, in microseconds.
export class Distributions {
  constructor() {
    this.body = element("tbody");
    this.cells = new Map();
    const heads = ["in us", "mean", "p50", "p99", "p99.9", "max"].map((text) => element("th", { scope: "col", text }));
    this.element = element("table", { class: "numbers" }, element("thead", {}, element("tr", {}, ...heads)), this.body);
  }

  show(pairs, words) {
    for (const [what, of] of pairs) {
      let cells = this.cells.get(what);
      if (!cells) {
        cells = ["mean", "p50", "p99", "p999", "max"].map((key) => ({ key, cell: element("td", { class: "number" }) }));
        this.cells.set(what, cells);
        this.body.append(element("tr", {}, element("th", { scope: "row", text: what }), ...cells.map(({ cell }) => cell)));
      }
      for (const { key, cell } of cells) setText(cell, of ? words(of[key]) : "-");
    }
  }
}
