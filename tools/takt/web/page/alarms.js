// The alarms: faults that nobody has acknowledged, or whose cause still exists. A bar above all views names the worst one, and a view lists
// them with a button to acknowledge each.

import { post } from "./api.js";
import { arrows, element, Mark, setText } from "./dom.js";
import { lookOfSeverity } from "./looks.js";
import { addressOf, linkTo } from "./route.js";
import { count, instant, several } from "./words.js";

const kLongestNote = 255;

export const nameOf = ({ device, module }) => (module ? `${device}.${module}` : device);
/// The unacknowledged alarms, the worst first.
export const open = (store) => store.alarms.filter((alarm) => !alarm.acknowledged);
export const textOf = ({ kind, error, count: times }) => (error ? `${kind}: ${error}` : kind) + (times > 1 ? ` (${count(times)} times)` : "");

/// The same with its cause.
export const sentenceOf = (event) => [textOf(event), event.cause].filter(Boolean).join(": ");

/// The bar is hidden if there is no unacknowledged alarm.
export class AlarmBar {
  #store;

  constructor(place, store) {
    this.#store = store;
    this.place = place;
    this.mark = new Mark();
    this.worst = element("span", { class: "worst" });
    place.append(element("a", { href: addressOf("alarms") }, this.mark.element, this.worst));
  }

  update() {
    const [worst, ...others] = open(this.#store);
    this.place.hidden = !worst;
    if (!worst) return;
    this.mark.show({ ...lookOfSeverity(worst.severity), word: several(others.length + 1, "unacknowledged alarm") });
    setText(this.worst, `${others.length > 0 ? "worst: " : ""}${nameOf(worst)} ${textOf(worst)}`);
  }
}

export class Alarms {
  #store;
  #shown = "";

  constructor(store) {
    this.#store = store;
    this.all = element("button", { type: "button", text: "Acknowledge all", on: { click: () => this.#acknowledge(open(this.#store)) } });
    this.why = element("span", { class: "faint" });
    this.answer = element("p", { class: "answer", role: "status" });
    this.none = element("p", { class: "nothing", text: "No alarms." });
    this.body = element("tbody");
    const head = (text) => element("th", { scope: "col", text });
    this.table = element("table", { class: "list alarms" }, element("caption", { class: "unseen", text: "alarms, the worst first" }),
      element("thead", {}, element("tr", {}, head("state"), head("since"), head("source"), head("alarm"), head("acknowledge"))), this.body);
    this.element = element("div", { class: "scrolled" }, element("div", { class: "tools" }, this.all, this.why), this.answer, this.table, this.none);
    arrows(this.body, "tr");
  }

  show() {
    this.#showAll();
  }

  update(changes) {
    if (changes.alarms || changes.rights || changes.link) this.#showAll();
  }

  #showAll() {
    const { alarms, rights, link } = this.#store;
    const why = link === "lost" || link === "quiet" ? "the connection to takt web is lost" : rights.command ? "" : `read-only: ${rights.why}`;
    this.all.disabled = why !== "" || open(this.#store).length === 0;
    setText(this.why, why);
    this.none.hidden = alarms.length > 0;
    this.table.hidden = alarms.length === 0;
    const shown = JSON.stringify([alarms, why]);
    if (shown === this.#shown) return;
    this.#shown = shown;
    const at = [...this.body.children].findIndex((row) => row.contains(document.activeElement));
    this.body.replaceChildren(...alarms.map((alarm) => this.#row(alarm, why)));
    this.body.firstChild?.setAttribute("tabindex", "0");
    if (at >= 0) (this.body.children[at] ?? this.body.lastChild ?? this.all).focus();
  }

  #row(alarm, why) {
    const { acknowledged } = alarm;
    const mark = new Mark();
    mark.show({ ...lookOfSeverity(acknowledged ? "note" : alarm.state === "unacknowledged" ? alarm.severity : "warning"), word: alarm.state });
    const by = acknowledged ? `acknowledged by ${acknowledged.by} at ${instant(acknowledged.time_ms)}${acknowledged.note ? `: ${acknowledged.note}` : ""}` : "";
    const button = acknowledged ? null : element("button", { type: "button", text: "Acknowledge", disabled: why !== "",
      "aria-label": `acknowledge ${alarm.kind} of ${nameOf(alarm)}`, on: { click: () => this.#acknowledge([alarm]) } });
    return element("tr", { tabindex: "-1", dataset: { alarm: nameOf(alarm), kind: alarm.kind } },
      element("td", {}, mark.element), element("td", { class: "time", text: instant(alarm.since_ms) }),
      element("td", {}, linkTo(nameOf(alarm), nameOf(alarm), { class: "name" })),
      element("td", { class: "what" }, element("b", { text: textOf(alarm) }), alarm.cause ? `: ${alarm.cause}` : "", by ? element("p", { text: by }) : null),
      element("td", {}, button));
  }

  async #acknowledge(alarms) {
    const note = await noteFor(alarms);
    if (note === null) return;
    setText(this.answer, "");
    for (const { device, module, number } of alarms) {
      try {
        await post("api/acknowledge", { device, ...(module ? { module } : {}), note, alarm: String(number) });
      } catch (problem) {
        this.answer.dataset.look = "bad";
        setText(this.answer, problem.text ?? problem.message);
      }
    }
  }
}

/// Asks the user for a note about these alarms. Returns null if the user cancels.
function noteFor(alarms) {
  return new Promise((answer) => {
    const note = element("input", { type: "text", id: "note", maxlength: kLongestNote, autofocus: true });
    const what = alarms.length === 1 ? `${alarms[0].kind} of ${nameOf(alarms[0])}` : several(alarms.length, "alarm");
    const dialog = element("dialog", { "aria-labelledby": "question" },
      element("form", { method: "dialog" }, element("h3", { id: "question", text: `Acknowledge ${what}?` }),
        element("p", {}, element("label", { for: "note", text: "Note for the fault record" }), note),
        element("div", { class: "buttons" }, element("button", { type: "submit", value: "yes", text: "Acknowledge" }),
          element("button", { type: "submit", value: "no", text: "Cancel" }))));
    dialog.addEventListener("close", () => {
      dialog.remove();
      answer(dialog.returnValue === "yes" ? note.value : null);
    });
    document.body.append(dialog);
    dialog.showModal();
  });
}
