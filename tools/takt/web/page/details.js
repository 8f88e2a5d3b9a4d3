// Shows all data of the selected module, device or connection. On a wide screen it is beside the view, on a narrow screen it is a
// sheet below the view.

import { element } from "./dom.js";
import { ConnectionDetails } from "./connection_details.js";
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
    this.connection = new ConnectionDetails(store);
    this.title = element("h2", { tabindex: "-1" });
    this.body = element("div");
    const close = element("button", { type: "button", class: "close", text: "Close", on: { click: () => alter({ select: null }) } });
    place.append(element("div", { class: "heading" }, this.title, close), this.body);
  }

  /// Shows the details of `name`: "device.module", "device" or "connection:INDEX". null closes the details.
  show(name) {
    this.place.hidden = name === null;
    if (name === this.name) {
      this.#shown?.ports?.showStars();
      return;
    }
    const first = this.name === null;
    this.name = name;
    this.#shown?.hide();
    this.#shown = name === null ? null : name.startsWith("connection:") ? this.connection : name.includes(".") ? this.module : this.device;
    if (!this.#shown) return;
    this.title.textContent = this.#shown === this.connection ? "connection" : name;
    this.body.replaceChildren(this.#shown.element);
    this.#shown.show(name);
    this.place.scrollTop = 0;
    // If the user opened the details with a key, move the focus to their title. If the page was loaded with this address, leave the focus.
    if (first && document.activeElement !== document.body) this.title.focus({ preventScroll: true });
  }

  update(changes) {
    this.#shown?.update(changes);
  }

  redraw() {
    this.#shown?.redraw?.();
  }
}
