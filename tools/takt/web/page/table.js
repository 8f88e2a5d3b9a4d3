// The view that shows each executor's table, and how the executor used the last complete macro period.

import { get } from "./api.js";
import { element, setText } from "./dom.js";
import { Gantt } from "./gantt.js";
import { adjust, currentRoute } from "./route.js";
import { clock, exact, number, several } from "./words.js";

const kRows = 200;
const kAgain_ms = 2000;

export class Table {
  #store;
  #device = "";
  #shown = false;
  #gantts = [];
  #asked = 0;

  constructor(store) {
    this.#store = store;
    this.device = element("select", { "aria-label": "device", on: { change: () => {
      adjust({ device: this.device.value });
      this.show(currentRoute().parameters);
    } } });
    this.again = element("button", { type: "button", text: "Refresh", on: { click: () => this.#ask() } });
    this.status = element("span", { class: "faint", role: "status" });
    this.body = element("div");
    this.element = element("div", { class: "scrolled table-view" },
      element("div", { class: "tools" }, element("label", {}, "device ", this.device), this.again, this.status), this.body);
  }

  show(parameters) {
    const names = this.#store.deviceNames;
    const wanted = parameters.get("device") ?? "";
    const device = wanted || names[0] || "";
    const options = names.includes(device) || !device ? names : [...names, device];
    this.device.replaceChildren(...options.map((name) => element("option", { value: name, text: name })));
    this.device.value = device;
    if (device === this.#device) return;
    this.#device = device;
    this.body.replaceChildren();
    this.#shown = false;
    this.#ask();
  }

  hide() {
    this.#device = "";
  }

  update(changes) {
    if (changes.cell) this.#device = "";  // the table shown belongs to another deployment
    if (changes.cell || changes.whole) this.show(currentRoute().parameters);
    if (!changes.cell && !this.#shown && changes.begun.has(this.#device)) this.#ask();
  }

  redraw() {
    for (const gantt of this.#gantts) gantt.redraw();
  }

  /// Asks the device for its tables. If that fails or the tables are empty, asks once more, because a device may not have run a row yet
  /// when it has just reported that it runs.
  async #ask(again = true) {
    const device = this.#device;
    const asked = ++this.#asked;
    if (!device) return;
    setText(this.status, "loading ...");
    this.again.disabled = true;
    try {
      const table = await get("api/table", { device });
      if (asked !== this.#asked) return;
      setText(this.status, "");
      this.#draw(table);
      this.#shown = table.executors?.some((executor) => executor.rows.length > 0) === true;
    } catch (problem) {
      if (asked !== this.#asked) return;
      setText(this.status, "");
      this.body.replaceChildren(element("p", { class: "answer", "data-look": "bad", text: problem.text ?? problem.message }));
      this.#shown = false;
    }
    this.again.disabled = false;
    if (again && !this.#shown) setTimeout(() => asked === this.#asked && device === this.#device && this.#ask(false), kAgain_ms);
  }

  #draw(table) {
    const about = new Map(this.#store.modulesOf(this.#device).map((module) => [module.label, module.about]));
    const executors = table.executors ?? [];
    this.#gantts = [];
    const parts = executors.map((executor, i) => {
      const programs = (table.programs ?? []).filter(({ module }) => {
        const of = about.get(module)?.executor;
        return of === executor.name || (i === 0 && !executors.some(({ name }) => name === of));
      });
      return this.#executor(executor, programs, about);
    });
    this.body.replaceChildren(...(parts.length > 0 ? parts :
      [element("p", { class: "nothing", text: "Nothing ran on this device in the last macro period." })]));
  }

  #executor(executor, programs, about) {
    const spec = this.#store.cell?.devices?.find(({ name }) => name === this.#device)?.executors?.find(({ name }) => name === executor.name);
    const rows = spec?.rows ?? [];
    if (executor.rows.length === 0) {
      const why = executor.text ?? "The executor missed every row of the last macro period. Refresh to see a later macro period.";
      return element("section", { class: "executor" }, element("h2", { text: `executor ${executor.name}` }),
        element("p", { class: "faint", text: why }), planned(rows, executor));
    }
    const gantt = new Gantt(executor, programs, orderOf(rows, spec, executor));
    this.#gantts.push(gantt);
    const all = executor.macro_period_ns / executor.basic_period_ns;
    const missed = Math.min(all, kRows) - executor.rows.length;
    const left_out = all > kRows ? `; the first ${kRows} are shown` : "";
    return element("section", { class: "executor" }, element("h2", { text: `executor ${executor.name}` }),
      element("p", { class: "faint", text: `${several(all, "row")} of ${exact(executor.basic_period_ns)}, a macro period of ` +
        `${exact(executor.macro_period_ns)}${left_out}${missed > 0 ? `; ${several(missed, "row")} missed` : ""}; began at ${clock(executor.begin_ms, { thousandths: true })}` }),
      gantt.element, lateness(executor, programs, this.#device), used(executor, programs, about), planned(rows, executor));
  }
}

/// The modules of an executor: first the modules in the table, in the order of its rows; then the sporadic modules; then all others that ran.
function orderOf(rows, spec, executor) {
  const names = new Set();
  for (const row of rows) for (const name of row) names.add(name);
  for (const name of spec?.sporadic ?? []) names.add(name);
  for (const row of executor.rows) for (const run of row.runs) names.add(run.module);
  return [...names];
}

function lateness(executor, programs, device) {
  const late = [];
  for (const row of executor.rows) {
    if (row.cause) late.push({ what: `row ${row.row}`, at: row.due_ns, by: row.begin_ns - row.due_ns, cause: row.cause });
    for (const run of row.runs) if (run.cause) late.push({ what: `${run.module} in row ${row.row}`, at: run.begin_ns, by: run.late_ns, cause: run.cause });
  }
  for (const run of programs) if (run.cause) late.push({ what: run.module, at: run.begin_ns, by: run.late_ns, cause: run.cause });
  if (late.length === 0) return element("p", { class: "faint", text: `No row and no thread module began late in this macro period. To see what was late in the last few seconds, and why, run takt trace ${device}` });
  const head = (text) => element("th", { scope: "col", text });
  return element("details", { open: true }, element("summary", { text: `What began late, and why: ${late.length}` }),
    element("table", { class: "numbers late" }, element("thead", {}, element("tr", {}, head("what"), head("at, ms"), head("late by, us"), head("cause"))),
      element("tbody", {}, ...late.map(({ what, at, by, cause }) => element("tr", {}, element("th", { scope: "row", text: what }),
        element("td", { class: "number", text: number(at / 1e6) }), element("td", { class: "number", text: number((by ?? 0) / 1e3) }),
        element("td", { text: cause }))))));
}

/// Shows how often each module ran, and its share of the macro period.
function used(executor, programs, about) {
  const sums = new Map();
  const add = (run, program) => {
    const sum = sums.get(run.module) ?? { runs: 0, all_ns: 0, longest_ns: 0, program };
    sum.runs += 1;
    sum.all_ns += run.end_ns - run.begin_ns;
    sum.longest_ns = Math.max(sum.longest_ns, run.end_ns - run.begin_ns);
    sums.set(run.module, sum);
  };
  for (const row of executor.rows) for (const run of row.runs) add(run, false);
  for (const run of programs) add(run, true);
  const span = Math.min(executor.macro_period_ns, kRows * executor.basic_period_ns);
  const lines = [...sums].sort(([, a], [, b]) => b.all_ns - a.all_ns);
  const busy = lines.filter(([, sum]) => !sum.program).reduce((all, [, sum]) => all + sum.all_ns, 0);
  const head = (text) => element("th", { scope: "col", text });
  return element("details", { open: true },
    element("summary", { text: `Where the time went: the executor was busy ${number(busy / span * 100)} % of the time` }),
    element("table", { class: "numbers used" }, element("thead", {}, element("tr", {}, head("module"), head("runs"), head("total, us"), head("longest, us"),
      head("budget, us"), head("share, %"))),
    element("tbody", {}, ...lines.map(([name, sum]) => element("tr", {},
      element("th", { scope: "row", text: sum.program ? `${name} (program)` : name }), ...[String(sum.runs), number(sum.all_ns / 1e3),
        number(sum.longest_ns / 1e3), about.get(name)?.budget_ns ? number(about.get(name).budget_ns / 1e3) : "-", number(sum.all_ns / span * 100)]
        .map((text) => element("td", { class: "number", text })))))));
}

function planned(rows, executor) {
  if (rows.length === 0) return null;
  return element("details", {}, element("summary", { text: "The planned table" }),
    element("table", { class: "numbers planned" }, element("tbody", {}, ...rows.map((row, i) => element("tr", {},
      element("th", { scope: "row", text: `row ${i}` }), element("td", { class: "number faint", text: exact(i * executor.basic_period_ns) }),
      element("td", { text: row.join(", ") || "-" }))))));
}
