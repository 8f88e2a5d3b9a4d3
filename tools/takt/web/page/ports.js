// The values of ports, for all parts of the page that show some. A gateway's stream has one list of ports, so this class joins the lists of
// these parts.

import { ValueRows } from "./value_rows.js";

const kMost = 32;        // limit of the ports of a stream
const kAgain_ms = 3000;
const kLeave_ms = 60000;  // a port that is not shown stays on the list for a while, because the user may return to it
const kEvery_ms = 250;   // people cannot read numbers that change faster

/// The port of a field, as device.module.port.field.
export const portOf = (field) => field.split(".", 3).join(".");

export class Ports {
  choose = async () => [];  // see Stream.choose()
  #ports = new Map();       // by name: {type, fields, rows}; no fields: not known yet
  #users = new Map();       // the list of each part of the page
  #asked = [];              // the ports that the gateway sends, those chosen last at the end
  #problems = new Map();

  get(name) {
    return this.#ports.get(name);
  }

  /// What prevents the values of a port, or undefined.
  problem(name) {
    return this.#problems.get(name);
  }

  /// Replaces the list of ports that `user` shows. Calls user.described(port) with each new description of such a port,
  /// user.arrived() at most four times a second when values have arrived, and user.answered() when the gateway has answered.
  want(user, names) {
    this.#users.set(user, names);
    const wanted = [...this.#users.values()].flat();
    const left = this.#asked.filter((name) => !wanted.includes(name));
    clearTimeout(this.leave);
    if (left.length > 0) this.leave = setTimeout(() => this.#set(wanted), kLeave_ms);
    if (!names.every((name) => this.#ports.has(name))) this.#set([...left, ...wanted]);
  }

  #set(names) {
    this.#asked = [...new Set(names)].slice(-kMost);
    for (const name of this.#ports.keys()) if (!this.#asked.includes(name)) this.#ports.delete(name);
    for (const name of this.#asked) if (!this.#ports.has(name)) this.#ports.set(name, { rows: new ValueRows() });
    this.ask();
  }

  /// Requests the values, again and again for a user with the member `insists`: the device of a port may start after this page.
  async ask() {
    clearTimeout(this.again);
    const names = this.#asked;
    if (names.length === 0 && !this.any) return;
    this.any = names.length > 0;
    const problems = await this.choose(names);
    if (names !== this.#asked) return;
    this.#problems = new Map(problems.map((problem) => [problem.port ?? "", problem]));
    let again = false;
    for (const [user, wanted] of this.#users) {
      user.answered?.();
      again ||= user.insists && (this.#problems.has("") || wanted.some((name) => this.#problems.has(name)));
    }
    if (again) this.again = setTimeout(() => this.ask(), kAgain_ms);
  }

  /// Takes the event `port`, the description of a port, or `points`, its values.
  take(name, data) {
    const port = this.#ports.get(data.port);
    if (!port || (name === "points" && !port.fields)) return;
    if (name === "port") {
      // If another tab has requested all values again, the description comes again. Until the values follow, the known ones stay.
      if (JSON.stringify(data.fields) === JSON.stringify(port.fields)) return;
      Object.assign(port, { type: data.type, fields: data.fields });
      port.rows.clear();
      for (const [user, names] of this.#users) if (names.includes(data.port)) user.described?.(data.port);
      return;
    }
    if (data.whole) port.rows.clear();
    port.rows.add(data.times_ms, data.values);
    this.timer ??= setTimeout(() => {
      this.timer = null;
      for (const user of this.#users.keys()) user.arrived?.();
    }, kEvery_ms);
  }
}
