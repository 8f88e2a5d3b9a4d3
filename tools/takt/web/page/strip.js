// The strip of time below the view: the faults, losses, commands and deployments of the last hour or 10 minutes, as marks by severity. A mark
// for several events shows their number. A click on an instant moves the faults and the values to this time.

import { nameOf, sentenceOf } from "./alarms.js";
import { Canvas } from "./canvas.js";
import { element, setAttribute, setText } from "./dom.js";
import { shownInstant } from "./fields.js";
import { lookOfSeverity } from "./looks.js";
import { alter, currentRoute, go } from "./route.js";
import { colour } from "./theme.js";
import { clock, instant, several } from "./words.js";

const kHour_ms = 3600000, kShort_ms = 600000;
const kTicks = new Map([[kHour_ms, 600000], [kShort_ms, 120000]]);
const kStep_ms = 60000;
const kNear = 8;         // pixels from a mark at which the pointer selects the mark
const kMark = 10;        // width of a mark and the space beside it, in pixels
const kDigit = 7;        // width of a digit of the number beside a mark
const kRight = 28;       // space for the number beside a mark of the present
const kLane = 12, kLanes = ["error", "warning", "note"];
const kViews = ["faults", "plots", "watch"];  // the views that show an instant

export class Strip {
  #store;
  #events = [];   // of the last hour, by their time
  #from = null;   // the store's array from which they come
  #come = 0;      // the number of events that had come then
  #groups = [];   // the events of each mark, as {lane, x, width, events}
  #pointer = null;

  constructor(place, store) {
    this.#store = store;
    this.canvas = new Canvas((context, width, height) => this.#draw(context, width, height), {
      class: "marks", tabindex: "0", role: "slider", "aria-label": "instant that the page shows; the arrow keys move from event to event, Page Up and Page Down by a minute, End shows now",
      "aria-valuemin": 0,
    });
    this.caption = element("p", { class: "caption small", role: "status" });
    this.live = element("button", { type: "button", class: "live", text: "live", title: "show the present again", on: { click: () => this.#choose(null) } });
    this.span = element("button", { type: "button", class: "span", on: { click: () => alter({ span: this.#span === kHour_ms ? "10min" : null }) } });
    place.append(this.span, this.canvas.element, this.live, this.caption);
    this.canvas.element.addEventListener("pointermove", (event) => this.#point(event));
    this.canvas.element.addEventListener("pointerleave", () => this.#point(null));
    this.canvas.element.addEventListener("click", (event) => this.#click(event));
    this.canvas.element.addEventListener("keydown", (event) => this.#press(event));
  }

  show() {
    this.#showAll();
  }

  update(changes) {
    if (changes.faults || changes.measures || changes.cell) this.#showAll();
  }

  get #span() {
    return currentRoute().parameters.get("span") === "10min" ? kShort_ms : kHour_ms;
  }

  /// The events in the span that the strip shows.
  get #inSpan() {
    return this.#events.filter(({ time_ms }) => time_ms > this.#store.now - this.#span);
  }

  #showAll() {
    this.#collect();
    const hour = this.#span === kHour_ms;
    setText(this.span, hour ? "last hour" : "last 10 min");
    setAttribute(this.span, "title", hour ? "show the last 10 minutes" : "show the last hour");
    setAttribute(this.canvas.element, "aria-valuemax", this.#span / 1000);
    setAttribute(this.live, "aria-pressed", String(shownInstant() === null));
    this.canvas.redraw();
    this.#say();
  }

  /// Takes the events that have come since the last call, and drops those that are older than an hour.
  #collect() {
    const { faults, faultsCome, now } = this.#store;
    const shown = faults === this.#from ? faults.slice(faults.length - Math.min(faultsCome - this.#come, faults.length)) : faults;
    if (faults !== this.#from) this.#events = [];
    [this.#from, this.#come] = [faults, faultsCome];
    let ordered = true;
    for (const event of shown) {
      if (event.severity === "note" && event.kind.startsWith("log-")) continue;
      ordered &&= event.time_ms >= (this.#events.at(-1)?.time_ms ?? 0);
      this.#events.push(event);
    }
    if (!ordered) this.#events.sort((a, b) => a.time_ms - b.time_ms);
    const first = this.#events.findIndex(({ time_ms }) => time_ms > now - kHour_ms);
    this.#events.splice(0, first < 0 ? this.#events.length : first);
  }

  #x(time) {
    return (1 - (this.#store.now - time) / this.#span) * this.#width;
  }

  /// The width of the span.
  get #width() {
    return this.canvas.element.clientWidth - kRight;
  }

  /// Joins the events whose marks would cover each other.
  #group() {
    const last = {};
    this.#groups = [];
    const width = this.#width / this.#span;
    const left = this.#store.now - this.#span;
    for (const event of this.#inSpan) {
      const x = (event.time_ms - left) * width;
      const group = last[event.severity];
      if (group && x < group.x + group.width) {
        group.events.push(event);
        group.width = 1.5 * kMark + kDigit * String(group.events.length).length;
      } else this.#groups.push(last[event.severity] = { severity: event.severity, x, width: kMark, events: [event] });
    }
  }

  /// The mark at the pointer, or undefined.
  #groupAt({ offsetX: x, offsetY: y }) {
    const far = (group) => Math.max(group.x - x, x - group.x - group.width + kMark, 0) + Math.abs(laneOf(group) - y);
    return this.#groups.filter((group) => x >= group.x - kNear && x <= group.x + group.width - kMark + kNear)
      .reduce((best, group) => (best && far(best) < far(group) ? best : group), undefined);
  }

  /// The event at the pointer: of the nearest mark, the newest of its nearest events.
  #near(pointer) {
    const far = (event) => Math.abs(this.#x(event.time_ms) - pointer.offsetX);
    return this.#groupAt(pointer)?.events.reduce((best, event) => (far(best) < far(event) ? best : event));
  }

  #click(event) {
    const [at, near, x] = [shownInstant(), this.#near(event)?.time_ms, event.offsetX];
    const again = at !== null && (near === at || Math.abs(this.#x(at) - x) <= kNear / 2);
    this.#choose(again ? null : near ?? Math.round(this.#store.now - Math.max(0, 1 - x / this.#width) * this.#span));
  }

  focus() {
    this.canvas.element.focus();
  }

  #press(event) {
    const at = shownInstant();
    const now = this.#store.now;
    const times = this.#inSpan.map(({ time_ms }) => time_ms);
    const next = { ArrowLeft: () => times.findLast((time) => at === null || time < at), ArrowRight: () => times.find((time) => at !== null && time > at),
      PageUp: () => Math.max(now - this.#span, Math.round((at ?? now) - kStep_ms)), PageDown: () => (at !== null && at + kStep_ms < now ? at + kStep_ms : null),
      Home: () => times[0], End: () => null }[event.key];
    if (!next || event.altKey || event.ctrlKey || event.metaKey) return;
    event.preventDefault();
    const time = next();
    if (time !== undefined) this.#choose(time);
    else if (event.key === "ArrowRight") this.#choose(null);
  }

  #choose(at) {
    const { view, parameters } = currentRoute();
    const note = at !== null && this.#events.some(({ time_ms, severity }) => time_ms === at && severity === "note");
    const also = { at, end: null, ...(note && (view === "faults" || !kViews.includes(view)) ? { severity: "all" } : {}) };
    if (at === null || kViews.includes(view)) alter(also);
    else go("faults", { select: parameters.get("select"), watch: parameters.get("watch"), ...also });
  }

  #point(event) {
    this.#pointer = event;
    this.#say();
  }

  /// Describes the event under the pointer, else the one at the shown instant, else all.
  #say() {
    const at = shownInstant();
    const pointed = this.#pointer === null ? undefined : this.#near(this.#pointer);
    const event = pointed ?? this.#events.findLast(({ time_ms }) => time_ms === at);
    const others = pointed ? this.#groupAt(this.#pointer).events.length - 1 : 0;
    const kept = this.#store.faultsSince > this.#store.now - this.#span ? `; some from before ${clock(this.#store.faultsSince)} are missing` : "";
    const shown = this.#inSpan;
    const all = kLanes.map((name) => [name, shown.reduce((n, { severity }) => n + (severity === name), 0)]).filter(([, n]) => n > 0);
    const text = event ? said(event) + (others > 0 ? `; ${several(others, "more event")} here` : "")
      : at !== null ? `at ${instant(at)}` : `${all.map(([name, n]) => several(n, name)).join(", ") || "no events"}${kept}`;
    const present = at !== null && !kViews.includes(currentRoute().view) ? "; this view shows the present" : "";
    setText(this.caption, text + present);
    setAttribute(this.caption, "data-look", event ? lookOfSeverity(event.severity).look : "faint");
    setAttribute(this.canvas.element, "aria-valuenow", at === null ? 0 : Math.round(Math.min(this.#store.now - at, this.#span) / 1000));
    setAttribute(this.canvas.element, "aria-valuetext", at === null ? `now; ${text}` : text);
  }

  #draw(context, width, height) {
    const from = this.#store.now - this.#span;
    const tick = kTicks.get(this.#span);
    const lanes = kLane * kLanes.length;
    context.fillStyle = colour("odd");
    if (this.#store.faultsSince > from) context.fillRect(0, 0, this.#x(this.#store.faultsSince), lanes);
    context.font = '11px system-ui, "DejaVu Sans", sans-serif';
    for (let time = Math.ceil(from / tick) * tick; time < from + this.#span; time += tick) {
      context.fillStyle = colour("grid");
      context.fillRect(Math.round(this.#x(time)), 0, 1, height);
      context.fillStyle = colour("faint");
      if (this.#x(time) + 36 < width) context.fillText(clock(time).slice(0, 5), Math.round(this.#x(time)) + 3, height - 2);
    }
    this.#group();
    for (const { x, events, severity } of this.#groups) mark(context, x, laneOf({ severity }), severity, events.length);
    const at = shownInstant();
    if (at === null) return;
    context.fillStyle = colour("accent");
    context.fillRect(Math.max(0, Math.min(this.#x(at), width) - 1), 0, 2, height);
  }
}

/// Each severity has a lane and a shape of its own.
const laneOf = ({ severity }) => kLane * (kLanes.indexOf(severity) + 0.5);

function mark(context, x, y, severity, number) {
  context.fillStyle = colour({ error: "bad", warning: "poor" }[severity] ?? "accent");
  context.beginPath();
  if (severity === "error") context.moveTo(x, y - 5), context.lineTo(x + 5, y + 4), context.lineTo(x - 5, y + 4);
  else if (severity === "warning") context.moveTo(x, y - 5), context.lineTo(x + 4, y), context.lineTo(x, y + 5), context.lineTo(x - 4, y);
  else context.arc(x, y, 2.5, 0, 7);
  context.fill();
  if (number > 1) context.fillText(String(number), x + kMark - 3, y + 4);
}

const said = (event) => `${instant(event.time_ms)} ${nameOf(event)}: ${sentenceOf(event)}`;
