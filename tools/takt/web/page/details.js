// All data of the selected module or device, beside the view or, on a narrow screen, instead of it.

import { element } from "./dom.js";
import { DeviceDetails } from "./device_details.js";
import { ModuleDetails } from "./module_details.js";
import { alter } from "./route.js";

export class Details {
  name = null;
  #shown = null;

  constructor(place, store) {
    this.place = place;
    this.module = new ModuleDetails(store);
    this.device = new DeviceDetails(store);
    this.title = element("h2", { tabindex: "-1" });
    this.body = element("div");
    const close = element("button", { type: "button", class: "close", text: "Close", on: { click: () => alter({ select: null }) } });
    place.append(element("div", { class: "heading" }, this.title, close), this.body);
  }

  /// "device.module", "device", or null.
  show(name) {
    this.place.hidden = name === null;
    if (name === this.name) return;
    const first = this.name === null;
    this.name = name;
    this.#shown?.hide();
    this.#shown = name === null ? null : name.includes(".") ? this.module : this.device;
    if (!this.#shown) return;
    this.title.textContent = name;
    this.body.replaceChildren(this.#shown.element);
    this.#shown.show(name);
    this.place.scrollTop = 0;
    // If the user opened the details by a key, the focus moves to the title. If the page was opened with this address, the focus stays.
    if (first && document.activeElement !== document.body) this.title.focus({ preventScroll: true });
  }

  update(changes) {
    this.#shown?.update(changes);
  }

  redraw() {
    this.#shown?.redraw?.();
  }
}
