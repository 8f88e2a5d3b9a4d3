// The buttons that send commands to a module or a device. A button is disabled while its command is not allowed, and a text gives the
// reason.

import { post } from "./api.js";
import { element, setText } from "./dom.js";

/// The commands, each with the states in which it is allowed. framework/lifecycle defines the same table.
const kCommands = [
  { verb: "start", title: "Start", in: ["START"] },
  { verb: "stop", title: "Stop", in: ["EXECUTING"] },
  { verb: "recover", title: "Recover", in: ["RECOVER"] },
  { verb: "reset", title: "Reset", in: ["DESTRUCT"] },
  { verb: "initialize", title: "Initialize", in: ["IDLE"] },
  { verb: "destruct", title: "Destruct", in: ["IDLE", "INITIALIZE", "START", "EXECUTING", "RECOVER"], danger: true },
];

export class Commands {
  #store;
  #device = "";
  #module = null;
  #busy = new Set();  // modules and devices with an unanswered command

  constructor(store) {
    this.#store = store;
    this.buttons = kCommands.map((command) => element("button", {
      type: "button", text: command.title, class: command.danger ? "danger" : null, "aria-describedby": "commands-why",
      dataset: { verb: command.verb }, on: { click: () => this.#send(command) },
    }));
    this.why = element("p", { class: "faint small", id: "commands-why" });
    this.answer = element("p", { class: "answer", role: "status" });
    this.element = element("section", { class: "commands" }, element("h3", { text: "Commands" }),
      element("div", { class: "buttons" }, ...this.buttons), this.why, this.answer);
  }

  /// Sets the target of the commands: a module, or, if `module` is null, all modules of the device.
  hold(device, module) {
    [this.#device, this.#module] = [device, module];
    setText(this.answer, "");
    this.update();
  }

  update() {
    const module = this.#module === null ? null : this.#store.modules.get(this.#module);
    const state = module?.state?.state;
    const why = this.#obstacle(module);
    const busy = this.#busy.has(this.#module ?? this.#device);
    kCommands.forEach((command, i) => {
      this.buttons[i].disabled = busy || why !== null || (this.#module !== null && !command.in.includes(state));
    });
    if (why !== null) setText(this.why, why);
    else if (this.#module === null) setText(this.why, `A command goes to all modules of ${this.#device} whose state allows it.`);
    else setText(this.why, `Allowed in ${state}: ${kCommands.filter((command) => command.in.includes(state)).map((command) => command.verb).join(", ")}.`);
  }

  #obstacle(module) {
    if (this.#store.link === "lost" || this.#store.link === "quiet") return "Commands are not possible while the connection to takt web is lost.";
    if (!this.#store.rights.command) return `Read-only: ${this.#store.rights.why}.`.replace(/\.\.$/, ".");
    if (this.#store.devices.get(this.#device)?.alive !== true) return `Device ${this.#device} is lost and cannot execute commands.`;
    if (this.#module !== null && !module?.state) return "The module has not reported its state yet.";
    return null;
  }

  async #send({ verb, danger }) {
    const [device, name] = [this.#device, this.#module];
    const target = name ?? `all modules of ${device}`;
    if (danger && !(await confirmed(`Destruct ${target}?`,
      name ? "The module ends and does not run again until you reset it." : "The modules end and do not run again until you reset them."))) return;
    const about = name ?? device;
    const show = (text, look) => {
      if (device !== this.#device || name !== this.#module) return;
      this.answer.dataset.look = look;
      setText(this.answer, text);
    };
    show(`${about}: ${verb} ...`, "plain");
    this.#busy.add(about);
    this.update();
    try {
      const command = name === null ? { device, verb } : { device, module: name.slice(device.length + 1), verb };
      const answer = await post("/api/command", command);
      show([`${about}: ${verb} done`, answer.state ? `now ${answer.state}` : "", answer.text].filter(Boolean).join(", "), "good");
    } catch (problem) {
      show(`${about}: ${problem.text ?? problem.message}`, "bad");
    }
    this.#busy.delete(about);
    this.update();
  }
}

/// Asks the user to confirm a command. Escape cancels the command.
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
