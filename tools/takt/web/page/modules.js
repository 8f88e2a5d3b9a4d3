// The view that lists all modules, grouped by device, with their state, jitter, and run time as a share of the budget.

import { arrows, Bar, element, Mark, setAttribute, setText } from "./dom.js";
import { lookOfDevice, lookOfModule, useOf } from "./looks.js";
import { addressOf, adjust, alter, currentRoute, linkTo } from "./route.js";
import { Spark } from "./spark.js";
import { count, exact, number, several } from "./words.js";

const kTrend = 120;
const kOrder = ["RECOVER", "lost", "none", "DESTRUCT", "IDLE", "INITIALIZE", "START", "EXECUTING"];

const kColumns = [
  { key: "name", title: "module", of: (row) => row.module.label },
  { key: "state", title: "state", of: (row) => kOrder.indexOf(row.look?.key) },
  { key: "p50", title: "jitter p50, us", of: (row) => row.module.measures?.jitter_us.p50, down: true },
  { key: "p99", title: "p99, us", of: (row) => row.module.measures?.jitter_us.p99, down: true },
  { key: "run", title: "run time p99", about: "as a share of the budget, or of the period if the module has no budget", of: (row) => useOf(row.module).share, down: true },
  { key: "overruns", title: "over\u00adruns", of: (row) => row.module.measures?.overruns, down: true },
  { key: "recoveries", title: "recov\u00aderies", of: (row) => row.module.measures?.recoveries, down: true },
  { key: "trend", title: "jitter, 2 min" },
];

class Row {
  constructor(module) {
    this.module = module;
    this.mark = new Mark();
    this.bar = new Bar();
    this.spark = new Spark(kTrend);
    this.link = linkTo(module.name, module.label, { class: "name" });
    this.about = element("span", { class: "faint small" });
    this.over = element("span", { class: "some small", title: "how often the run time exceeded the budget" });
    this.alarm = element("a", { href: addressOf("alarms"), class: "alarm" });
    const numbers = (label) => element("td", { class: "number", dataset: { label } });  // a phone shows the label with the number
    this.cells = {
      name: element("th", { scope: "row" }, this.link, this.about), state: element("td", {}, this.mark.element, this.alarm),
      p50: numbers("jitter p50, us"), p99: numbers("jitter p99, us"), run: element("td", { dataset: { label: "run time p99" } }, this.bar.element, this.over),
      overruns: numbers("overruns"), recoveries: numbers("recoveries"),
      trend: element("td", { class: "trend" }, this.spark.element),
    };
    this.element = element("tr", { dataset: { module: module.name } }, ...kColumns.map(({ key }) => this.cells[key]));
    this.seen = false;
  }

  showState(store) {
    this.look = lookOfModule(store.shown(this.module));
    this.mark.show(this.look);
    setAttribute(this.element, "data-state", this.look.key);
    setText(this.alarm, this.look.alarm ? "alarm" : "");
  }

  showAbout() {
    const about = this.module.about;
    setText(this.about, about?.period_ns ? `every ${exact(about.period_ns)}` : about?.operation ?? "");
  }

  showMeasures() {
    const measures = this.module.measures;
    if (!measures) return;
    setText(this.cells.p50, number(measures.jitter_us.p50));
    setText(this.cells.p99, number(measures.jitter_us.p99));
    const use = useOf(this.module);
    this.bar.show(use.share, use.allowed ? `${use.words} of ${exact(use.allowed)}${use.what === "budget" ? "" : ` ${use.what}`}` : use.words);
    setText(this.over, measures.over_budget > 0 ? `${count(measures.over_budget)} over` : "");
    for (const what of ["overruns", "recoveries"]) {
      setText(this.cells[what], count(measures[what]));
      this.cells[what].classList.toggle("some", measures[what] > 0);
    }
    if (this.seen) this.spark.show(this.module.trend);
  }
}

export class Modules {
  #store;
  #rows = new Map();
  #groups = new Map();  // the heading of each device: {element, mark, about}
  #order = "";

  constructor(store) {
    this.#store = store;
    this.filter = element("input", { type: "search", placeholder: "name or state", "aria-label": "filter by name or state",
      on: { input: () => this.#choose({ filter: this.filter.value }) } });
    this.only = element("select", { "aria-label": "which modules", on: { change: () => this.#choose({ only: this.only.value }) } },
      element("option", { value: "", text: "all modules" }), element("option", { value: "trouble", text: "not EXECUTING" }),
      element("option", { value: "over", text: "late, over budget or recovered" }));
    this.shown = element("span", { class: "faint", role: "status" });
    this.heads = new Map(kColumns.map((column) => [column.key, this.#head(column)]));
    this.body = element("tbody");
    this.table = element("table", { class: "list modules" },
      element("caption", { class: "unseen", text: "modules of the cell" }),
      element("thead", {}, element("tr", {}, ...this.heads.values())), this.body);
    this.element = element("div", { class: "scrolled" },
      element("div", { class: "tools" }, this.filter, this.only, this.shown), this.table);
    arrows(this.body, "a.name");
    this.body.addEventListener("click", (event) => {
      const row = event.target.closest("tr");
      if (row?.dataset.module && !event.target.closest("a")) alter({ select: row.dataset.module });
    });
    this.watcher = new IntersectionObserver((entries) => this.#see(entries), { rootMargin: "200px" });
  }

  #head({ key, title, about }) {
    if (key === "trend") return element("th", { scope: "col", class: "column-trend trend", text: title });
    return element("th", { scope: "col", "aria-sort": "none", class: `column-${key}` },
      element("button", { type: "button", title: about ?? null, on: { click: () => this.#sortBy(key) } }, title));
  }

  show(parameters) {
    this.sort = parameters.get("sort") ?? "";
    this.down = parameters.get("down") === "1";
    if (this.filter.value !== (parameters.get("filter") ?? "")) this.filter.value = parameters.get("filter") ?? "";
    this.only.value = parameters.get("only") ?? "";
    this.#rebuild();
  }

  update(changes) {
    if (changes.cell || changes.whole) {
      this.#rebuild();
      return;
    }
    for (const name of changes.devices) this.#showGroup(name);
    for (const name of changes.modules) this.#rows.get(name)?.showState(this.#store);
    if (changes.measures) {
      for (const row of this.#rows.values()) {
        row.showState(this.#store);  // the measurements say whether the module is in a safe stop
        row.showMeasures();
      }
    }
    const sorts = this.sort !== "" && this.sort !== "name";
    const measured = sorts || this.only.value === "over";
    if ((changes.modules.size > 0 && (sorts || this.#filters())) || (changes.measures && measured)) this.#arrange();
  }

  redraw() {
    for (const row of this.#rows.values()) if (row.seen) row.spark.show(row.module.trend);
  }

  focusOn(name) {
    this.#rows.get(name)?.link.focus();
  }

  #choose(parameters) {
    adjust(parameters);
    this.show(currentRoute().parameters);
  }

  #sortBy(key) {
    const column = kColumns.find((one) => one.key === key);
    const first = column.down === true;
    if (this.sort !== key) this.#choose({ sort: key, down: first ? "1" : "0" });
    else if (this.down === first) this.#choose({ sort: key, down: first ? "0" : "1" });
    else this.#choose({ sort: null, down: null });
  }

  #rebuild() {
    for (const name of [...this.#rows.keys()]) {
      if (this.#store.modules.has(name)) continue;
      this.watcher.unobserve(this.#rows.get(name).element);
      this.#rows.delete(name);
    }
    for (const [name, module] of this.#store.modules) {
      let row = this.#rows.get(name);
      if (!row) {
        row = new Row(module);
        this.#rows.set(name, row);
        this.watcher.observe(row.element);
      }
      row.module = module;
      row.showAbout();
      row.showState(this.#store);
      row.showMeasures();
    }
    this.#order = "";
    this.#arrange();
    for (const name of this.#store.deviceNames) this.#showGroup(name);
    const selected = currentRoute().parameters.get("select");
    for (const [name, row] of this.#rows) setAttribute(row.element, "aria-selected", name === selected ? "true" : null);
    for (const [key, head] of this.heads) {
      if (key !== "trend") setAttribute(head, "aria-sort", key !== this.sort ? "none" : this.down ? "descending" : "ascending");
    }
  }

  /// Rearranges the rows if their order, or the set of shown rows, has changed.
  #arrange() {
    const lines = [];
    let shown = 0;
    for (const device of this.#store.deviceNames) {
      const rows = this.#store.modulesOf(device).map((module) => this.#rows.get(module.name)).filter((row) => row && this.#takes(row));
      if (rows.length === 0 && this.#filters()) continue;
      lines.push(this.#group(device).element, ...this.#sorted(rows).map((row) => row.element));
      shown += rows.length;
    }
    const all = this.#store.modules.size;
    setText(this.shown, shown === all ? several(all, "module") : `${shown} of ${several(all, "module")}`);
    const order = lines.map((line) => line.dataset.module ?? line.dataset.device).join(" ");
    if (order === this.#order) return;
    this.#order = order;
    const focused = document.activeElement;
    this.body.replaceChildren(...lines);
    if (focused && focused !== document.activeElement && this.body.contains(focused)) focused.focus({ preventScroll: true });
    const links = [...this.body.querySelectorAll("a.name")];
    for (const link of links) setAttribute(link, "tabindex", link === links[0] ? "0" : "-1");
  }

  #filters() {
    return this.filter.value !== "" || this.only.value !== "";
  }

  #takes(row) {
    const words = this.filter.value.toLowerCase();
    if (words && !`${row.module.name} ${row.look.word}`.toLowerCase().includes(words)) return false;
    if (this.only.value === "trouble") return row.look.key !== "EXECUTING";
    if (this.only.value === "over") return ["overruns", "over_budget", "recoveries"].some((what) => row.module.measures?.[what] > 0);
    return true;
  }

  #sorted(rows) {
    const column = kColumns.find((one) => one.key === this.sort && one.of);
    if (!column) return rows;
    const sign = this.down ? -1 : 1;
    return [...rows].sort((one, other) => {
      const [a, b] = [column.of(one), column.of(other)];
      if (a === b) return 0;
      if (a === undefined || a === null) return 1;  // unknown values come last, in ascending and descending order
      if (b === undefined || b === null) return -1;
      return (a < b ? -1 : 1) * sign;
    });
  }

  #group(device) {
    let group = this.#groups.get(device);
    if (group) return group;
    const mark = new Mark();
    const about = element("span", { class: "faint" });
    group = { mark, about };
    group.link = linkTo(device, device, { class: "name" });
    group.element = element("tr", { class: "group", dataset: { device } },
      element("th", { colspan: kColumns.length - 1, scope: "rowgroup" }, group.link, mark.element, about),
      element("td", { class: "trend" }));  // hidden with its column if there is no room
    this.#groups.set(device, group);
    this.#showGroup(device);
    return group;
  }

  #showGroup(device) {
    const group = this.#groups.get(device);
    if (!group) return;
    const is = this.#store.devices.get(device);
    const look = lookOfDevice(is);
    group.mark.show(look);
    setText(group.about, is?.text ?? "");
    setAttribute(group.element, "data-state", look.key);
  }

  #see(entries) {
    for (const { target, isIntersecting } of entries) {
      const row = this.#rows.get(target.dataset.module);
      if (!row) continue;
      row.seen = isIntersecting;
      if (row.seen) row.spark.show(row.module.trend);
    }
  }
}

