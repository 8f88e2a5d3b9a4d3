// What a module or a whole device may be told. An order that is not allowed cannot be given, and why not is written beside it.

import { post } from "./api.js";
import { element, setText } from "./dom.js";

/// The states in which each is allowed: the table of framework/lifecycle.
const kOrders = [
  { verb: "start", title: "Start", in: ["START"] },
  { verb: "stop", title: "Stop", in: ["EXECUTING"] },
  { verb: "recover", title: "Recover", in: ["RECOVER"] },
  { verb: "reset", title: "Reset", in: ["DESTRUCT"] },
  { verb: "initialize", title: "Initialize", in: ["IDLE"] },
  { verb: "destruct", title: "Destruct", in: ["IDLE", "INITIALIZE", "START", "EXECUTING", "RECOVER"], danger: true },
];

export class Orders {
  #store;
  #device = "";
  #module = null;
  #busy = new Set();  // of modules and devices: an order to it is under way, and not answered yet

  constructor(store) {
    this.#store = store;
    this.buttons = kOrders.map((order) => element("button", {
      type: "button", text: order.title, class: order.danger ? "danger" : null, "aria-describedby": "orders-why",
      dataset: { verb: order.verb }, on: { click: () => this.#give(order) },
    }));
    this.why = element("p", { class: "faint small", id: "orders-why" });
    this.answer = element("p", { class: "answer", role: "status" });
    this.element = element("section", { class: "orders" }, element("h3", { text: "Orders" }),
      element("div", { class: "buttons" }, ...this.buttons), this.why, this.answer);
  }

  /// To a module, or with null to all of the device's.
  hold(device, module) {
    [this.#device, this.#module] = [device, module];
    setText(this.answer, "");
    this.update();
  }

  update() {
    const module = this.#module === null ? null : this.#store.modules.get(this.#module);
    const state = module?.state?.state;
    const why = this.#refusal(module);
    const busy = this.#busy.has(this.#module ?? this.#device);
    kOrders.forEach((order, i) => {
      this.buttons[i].disabled = busy || why !== null || (this.#module !== null && !order.in.includes(state));
    });
    if (why !== null) setText(this.why, why);
    else if (this.#module === null) setText(this.why, `To all modules of ${this.#device} that are in a state for it.`);
    else setText(this.why, `In ${state} allowed: ${kOrders.filter((order) => order.in.includes(state)).map((order) => order.verb).join(", ")}.`);
  }

  #refusal(module) {
    if (this.#store.link === "lost" || this.#store.link === "quiet") return "Not while the connection to the gateway is lost.";
    if (!this.#store.rights.command) return `Read-only: ${this.#store.rights.why}.`.replace(/\.\.$/, ".");
    if (this.#store.devices.get(this.#device)?.alive !== true) return `Device ${this.#device} is lost: nobody would do it.`;
    if (this.#module !== null && !module?.state) return "The module has not been seen yet.";
    return null;
  }

  async #give({ verb, danger }) {
    const [device, name] = [this.#device, this.#module];
    const whom = name ?? `every module of ${device}`;
    if (danger && !(await confirmed(`Destruct ${whom}?`,
      name ? "It ends and does not run again unless it is reset." : "They end and do not run again unless they are reset."))) return;
    const about = name ?? device;
    const say = (text, look) => {
      if (device !== this.#device || name !== this.#module) return;
      this.answer.dataset.look = look;
      setText(this.answer, text);
    };
    say(`${about}: ${verb} ...`, "plain");
    this.#busy.add(about);
    this.update();
    try {
      const order = name === null ? { device, verb } : { device, module: name.slice(device.length + 1), verb };
      const answer = await post("/api/command", order);
      say([`${about}: ${verb} done`, answer.state ? `now ${answer.state}` : "", answer.text].filter(Boolean).join(", "), "good");
    } catch (problem) {
      say(`${about}: ${problem.text ?? problem.message}`, "bad");
    }
    this.#busy.delete(about);
    this.update();
  }
}

/// Asks once more; Escape is no.
export function confirmed(question, text) {
  return new Promise((answer) => {
    const no = element("button", { type: "submit", value: "no", text: "Cancel", autofocus: true });
    const yes = element("button", { type: "submit", value: "yes", class: "danger", text: "Destruct" });
    const dialog = element("dialog", { "aria-labelledby": "question" },
      element("form", { method: "dialog" }, element("h3", { id: "question", text: question }), element("p", { text }),
        element("div", { class: "buttons" }, no, yes)));
    dialog.addEventListener("close", () => {
      dialog.remove();
      answer(dialog.returnValue === "yes");
    });
    document.body.append(dialog);
    dialog.showModal();
  });
}
