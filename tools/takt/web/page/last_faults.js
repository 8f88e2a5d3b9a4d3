// Lists the last faults of a device or module, in its details.

import { element, Mark, setText } from "./dom.js";
import { lookOfSeverity } from "./looks.js";
import { addressOf } from "./route.js";
import { instant } from "./words.js";

const kShown = 3;

export class LastFaults {
  #store;
  #shown = "";

  constructor(store) {
    this.#store = store;
    this.list = element("ul", { class: "last-faults" });
    this.none = element("p", { class: "faint", text: "No recent errors or warnings." });
    this.all = element("a", { text: "all faults of the device" });
    this.element = element("section", {}, element("h3", { text: "Last faults" }), this.list, this.none, element("p", {}, this.all));
  }

  /// Shows the faults of `name`, a device or a module. For a module, the list also shows the faults that name no module of the device, such as
  /// the end of the host.
  show(name) {
    const [device, module] = name.split(".");
    this.all.href = addressOf("faults", { device, select: name });
    const concerns = (event) => event.device === device && event.severity !== "note" && (!module || !event.module || event.module === module);
    const events = this.#store.faults.filter(concerns).slice(-kShown).reverse();
    const shown = name + events.map((event) => `${instant(event.time_ms)} ${event.count}`).join();
    if (shown === this.#shown) return;
    this.#shown = shown;
    this.none.hidden = events.length > 0;
    this.list.replaceChildren(...events.map((event) => {
      const mark = new Mark();
      mark.show({ ...lookOfSeverity(event.severity), word: event.error ? `${event.kind}: ${event.error}` : event.kind });
      const of = event.module && !module ? `${event.module}: ` : "";
      const more = [event.cause, event.attachment ? `see ${event.attachment}` : ""].filter(Boolean).join("; ");
      const line = element("li", {}, element("span", { class: "faint" }), mark.element, element("p"));
      setText(line.firstChild, `${instant(event.time_ms)} `);
      setText(line.lastChild, of + more);
      return line;
    }));
  }
}
