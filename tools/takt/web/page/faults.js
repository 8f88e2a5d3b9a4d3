// The view that shows the events of all fault records as they arrive, newest first; or one line for equal events, those that began last first.

import { nameOf, textOf } from "./alarms.js";
import { arrows, element, Mark, setAttribute, setText } from "./dom.js";
import { lookOfSeverity } from "./looks.js";
import { adjust, currentRoute, linkTo, linkWith } from "./route.js";
import { count, day, instant, several } from "./words.js";

const kPage = 200;  // lines shown at first, and added by each "Show older events"
const kSeverities = { all: "all severities", warning: "warnings and errors", error: "errors" };

export class Faults {
  #store;
  #shown = kPage;
  #paused = null;  // the events that the list showed when the user pressed Pause; null if the list is not paused
  #come = 0;       // the number of events that had arrived when the user pressed Pause
  #known = new Map();
  #day = "";  // the day on which the known lines were made

  constructor(store) {
    this.#store = store;
    const adjusted = (name, field) => () => {
      this.#shown = kPage;
      adjust({ [name]: field.value });
      this.#rebuild();
    };
    this.severity = element("select", { "aria-label": "severity" },
      ...Object.entries(kSeverities).map(([value, text]) => element("option", { value, text })));
    this.device = element("select", { "aria-label": "device" });
    this.text = element("input", { type: "search", placeholder: "text", "aria-label": "filter by text" });
    this.severity.addEventListener("change", adjusted("severity", this.severity));
    this.device.addEventListener("change", adjusted("device", this.device));
    this.text.addEventListener("input", adjusted("text", this.text));
    this.pause = element("button", { type: "button", text: "Pause", "aria-pressed": "false", on: { click: () => this.#pause() } });
    this.equal = element("button", { type: "button", text: "Group", title: "one line for all events of the same kind and source",
      on: { click: () => (adjust({ group: this.#grouped ? null : "on" }), this.#rebuild()) } });
    this.count = element("span", { class: "faint", role: "status" });
    this.problems = element("p", { class: "answer", "data-look": "poor" });
    this.body = element("tbody");
    this.more = element("button", { type: "button", text: "Show older events", on: { click: () => { this.#shown += kPage; this.#rebuild(); } } });
    const head = (text) => element("th", { scope: "col", text });
    this.element = element("div", { class: "scrolled" },
      element("div", { class: "tools" }, this.severity, this.device, this.text, this.equal, this.pause, this.count), this.problems,
      element("table", { class: "list faults" }, element("caption", { class: "unseen", text: "fault record, newest first" }),
        element("thead", {}, element("tr", {}, head("time"), head("severity"), head("source"), head("event"))), this.body), this.more);
    arrows(this.body, "tr");
  }

  show(parameters) {
    this.at = Number(parameters.get("at")) || Infinity;
    this.severity.value = parameters.get("severity") ?? "warning";
    this.#listDevices(parameters.get("device") ?? "");
    if (this.text.value !== (parameters.get("text") ?? "")) this.text.value = parameters.get("text") ?? "";
    this.#rebuild();
  }

  hide() {
    if (this.#paused) this.#pause();
  }

  update(changes) {
    if (changes.whole || changes.cell) this.#listDevices(this.device.value);
    if (changes.faults) this.#rebuild();
  }

  #listDevices(chosen) {
    const names = this.#store.deviceNames;
    if (chosen && !names.includes(chosen)) names.push(chosen);
    const same = [...this.device.options].slice(1).map((option) => option.value).join(" ") === names.join(" ");
    if (!same || this.device.options.length === 0) {
      this.device.replaceChildren(element("option", { value: "", text: "all devices" }),
        ...names.map((name) => element("option", { value: name, text: name })));
    }
    this.device.value = chosen;
  }

  #pause() {
    this.#paused = this.#paused ? null : [...this.#store.faults];
    this.#come = this.#store.faultsCome;
    this.pause.setAttribute("aria-pressed", String(this.#paused !== null));
    setText(this.pause, this.#paused ? "Resume" : "Pause");
    this.#rebuild();
  }

  get #grouped() {
    return currentRoute().parameters.get("group") === "on";
  }

  #takes(event) {
    if (event.time_ms > this.at) return false;
    if (this.severity.value === "error" && event.severity !== "error") return false;
    if (this.severity.value === "warning" && event.severity === "note") return false;
    if (this.device.value && event.device !== this.device.value) return false;
    const words = this.text.value.toLowerCase();
    return !words || `${event.device}.${event.module ?? ""} ${event.kind} ${event.error ?? ""} ${event.cause ?? ""}`.toLowerCase().includes(words);
  }

  #rebuild() {
    const all = this.#paused ?? this.#store.faults;
    const taken = all.filter((event) => this.#takes(event)).reverse();
    const today = day(Date.now());
    if (today !== this.#day) this.#known.clear();  // a new day: lines without a date need one now
    this.#day = today;
    setAttribute(this.equal, "aria-pressed", String(this.#grouped));
    const listed = this.#grouped ? joined(taken) : taken;
    const lines = new Map();
    for (const event of listed.slice(0, this.#shown)) {
      const line = this.#line(event, this.#known.get(event.key ?? event));
      line.classList.toggle("selected", event.time_ms === this.at);
      lines.set(event.key ?? event, line);
    }
    this.#known = lines;
    // Insert new lines at the top. Existing lines stay in the document, so that a focused line keeps the focus.
    let next = this.body.firstChild;
    const kept = new Set(lines.values());
    for (const line of lines.values()) {
      while (next && !kept.has(next)) {
        const gone = next;
        next = next.nextSibling;
        gone.remove();
      }
      if (next === line) next = next.nextSibling;
      else this.body.insertBefore(line, next);
    }
    while (next) {
      const gone = next;
      next = next.nextSibling;
      gone.remove();
    }
    if (!this.body.querySelector('[tabindex="0"]')) this.body.firstChild?.setAttribute("tabindex", "0");
    this.more.hidden = listed.length <= this.#shown;
    const filtered = taken.length < all.length ? `${taken.length} of ${several(all.length, "event")}` : several(all.length, "event");
    setText(this.count, filtered + (this.at < Infinity ? `; until ${instant(this.at)}` : "") + (this.#paused ? `; paused, ${this.#store.faultsCome - this.#come} new` : ""));
    setText(this.problems, this.#store.problems.join("; "));
    this.problems.hidden = this.#store.problems.length === 0;
  }

  /// Returns the line of an event, or of several equal ones. `known` is the line that it had before.
  #line(event, known) {
    const joins = event.key ? [event.times, event.since_ms, event.time_ms].join(" ") : "";
    if (known?.dataset.joins === joins) return known;
    const line = known ?? element("tr", { tabindex: "-1" });
    const mark = new Mark();
    mark.show(lookOfSeverity(event.severity));
    const cycle = event.kind.startsWith("log-") ? `release ${event.cycle}` : `after ${several(event.cycle, "cycle")}`;
    const more = [event.cycle ? cycle : "", event.attachment ? `see ${event.attachment}` : ""].filter(Boolean).join("; ");
    const link = (time_ms) => linkWith({ at: time_ms }, instant(time_ms), { title: "show this instant in all views" });
    Object.assign(line.dataset, { kind: event.kind, severity: event.severity, joins });
    line.replaceChildren(
      element("td", { class: "time" }, link(event.since_ms ?? event.time_ms)), element("td", {}, mark.element),
      element("td", {}, linkTo(nameOf(event), nameOf(event))),
      element("td", { class: "what" }, element("b", { text: textOf(event) }), event.cause ? `: ${event.cause}` : null,
        more ? element("span", { class: "faint small", text: ` ${more}` }) : null,
        ...event.times > 1 ? [element("p", {}, `${count(event.times)} times until `, link(event.time_ms))] : []));
    return line;
  }
}

/// Joins the warnings and errors of the same kind and source, which come newest first: the newest of them, the time of the first, and their
/// number. Returns those that began last first, so that a line stays at its place when one of its events comes again.
function joined(events) {
  const groups = new Map();
  for (const event of events) {
    const key = event.severity === "note" ? event : [event.device, event.module, event.kind, event.error].join(" ");
    const group = groups.get(key) ?? { ...event, key, count: 1, times: 0 };
    groups.set(key, Object.assign(group, { since_ms: event.time_ms, times: group.times + event.count }));
  }
  return [...groups.values()].sort((a, b) => b.since_ms - a.since_ms);
}
