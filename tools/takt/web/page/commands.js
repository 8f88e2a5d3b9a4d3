// The buttons that send commands to a module or a device. A button is disabled while its command is not allowed, and a text gives the
// reason.

import { post } from "./api.js";
import { element, setText } from "./dom.js";

const kAny = ["IDLE", "INITIALIZE", "START", "EXECUTING", "RECOVER"];

/// The commands, each with the states in which it is allowed. framework/lifecycle defines the same table. The page asks before it sends a
/// command with a `warning`: the first text is for a module, the second for all modules of a device. Like `takt restart`, the command
/// restart consists of several commands to one module.
const kCommands = [
  { verb: "start", title: "Start", in: ["START"] },
  { verb: "stop", title: "Stop", in: ["EXECUTING"],
    warning: ["The module does not run until you start it.", "The modules do not run until you start them."] },
  { verb: "recover", title: "Recover", in: ["RECOVER"] },
  { verb: "reset", title: "Reset", in: ["DESTRUCT"] },
  { verb: "initialize", title: "Initialize", in: ["IDLE"] },
  { verb: "restart", title: "Restart", in: [...kAny, "DESTRUCT"], only: "module",
    warning: ["The module ends, and begins again without its saved state."] },
  { verb: "destruct", title: "Destruct", in: kAny, danger: true,
    warning: ["The module ends and does not run again until you reset it.", "The modules end and do not run again until you reset them."] },
];

/// The commands of which a restart consists, if the module is in this state.
function stepsOfRestart(state) {
  if (state === "IDLE") return ["initialize", "start"];
  if (state === "DESTRUCT") return ["reset", "initialize", "start"];
  return ["destruct", "reset", "initialize", "start"];
}

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
    const active = document.activeElement;
    this.focused = this.buttons.includes(active) || (this.focused && active === document.body);
    kCommands.forEach((command, i) => {
      const possible = this.#module === null ? command.only !== "module" : command.in.includes(state);
      this.buttons[i].disabled = busy || why !== null || !possible;
    });
    // A disabled button loses the focus. The first button that can be pressed gets it, so that Start follows Stop.
    if (this.focused && (active === document.body || active.disabled)) this.buttons.find((button) => !button.disabled)?.focus({ preventScroll: true });
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

  async #send({ verb, title, warning }) {
    const [device, name] = [this.#device, this.#module];
    const state = name === null ? null : this.#store.modules.get(name)?.state?.state;
    const target = name ?? `all modules of ${device}`;
    if (warning && !(await confirmed(`${title} ${target}?`, warning[name ? 0 : 1], title))) return;
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
      let answer;
      for (const step of verb === "restart" ? stepsOfRestart(state) : [verb]) {
        const command = name === null ? { device, verb: step } : { device, module: name.slice(device.length + 1), verb: step };
        answer = await post("api/command", command);
      }
      show([`${about}: ${verb} done`, answer.state ? `now ${answer.state}` : "", answer.text].filter(Boolean).join(", "), "good");
    } catch (problem) {
      show(`${about}: ${problem.text ?? problem.message}`, "bad");
    }
    this.#busy.delete(about);
    this.update();
  }
}

/// Asks the user to confirm a command, with a button that has this title. Escape cancels the command.
export function confirmed(question, text, title) {
  return new Promise((answer) => {
    const no = element("button", { type: "submit", value: "no", text: "Cancel", autofocus: true });
    const yes = element("button", { type: "submit", value: "yes", class: "danger", text: title });
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
