// Receives the gateway's events, and reconnects. An EventSource alone neither notices a silent gateway nor retries after a rejection.

import { get, put } from "./api.js";

const kCheck_ms = 500;
const kQuiet_ms = 4000;  // normally the event `measures` arrives every second
const kSilent_ms = 15000;
const kAgain_ms = 1000;
const kEvents = ["cell", "state", "measures", "trends", "faults", "alarms", "port", "points", "newest"];

export class Stream {
  ports = [];   // the ports whose values this page plots
  newest = [];  // the ports whose newest value this page shows
  #source = null;
  #id = null;  // the gateway's id for the stream
  #timer;
  #sent = Promise.resolve();
  #next = null;
  #again = new Set();  // see choose()
  #choosing = false;
  #lastEvent = 0;
  #link = "";
  #whole = null;       // the last event `faults` that was whole

  /// `take` is called with the name and the data of each event. When the connection changes, `link` is called with "connecting", "live",
  /// "quiet" or "lost". The stream is closed until rest(false).
  constructor(take, link) {
    this.take = take;
    this.link = link;
    setInterval(() => this.#check(), kCheck_ms);
  }

  /// Closes the stream while the page is hidden. When the stream opens again, the gateway sends the complete state.
  rest(hidden) {
    this.close();
    if (hidden) return;
    this.report("connecting");
    this.open();
  }

  /// Chooses the ports whose values the gateway sends: all values of a port that was not on the list, or is in `again`, and then the new
  /// ones. Returns the problems, each with `port`, `what` and `fix`.
  choose(ports, again = []) {
    this.ports = ports;
    for (const port of again) this.#again.add(port);
    this.#next ??= this.#sent.then(() => this.#put());  // one request after the other, so that the last list takes effect
    return this.#next;
  }

  /// Chooses the ports of which the gateway sends the newest value. Ports without values are left out.
  async chooseNewest(newest) {
    this.newest = newest;
    if (this.#choosing || !this.#id) return;
    this.#choosing = true;
    for (let sent; sent !== this.newest;) {
      sent = this.newest;
      await put(`api/streams/${this.#id}/ports`, { newest: sent }).catch(() => {});
    }
    this.#choosing = false;
  }

  open() {
    this.receive();
    this.#source = new EventSource("api/events");
    this.#source.onopen = () => this.report("live");
    this.#source.onerror = () => this.reconnect();
    this.#source.addEventListener("stream", (event) => { this.#id = JSON.parse(event.data).id; });
    for (const name of kEvents) {
      this.#source.addEventListener(name, (event) => {
        this.receive();
        this.report("live");
        const data = JSON.parse(event.data);
        this.take(name, data);
        if (name === "faults" && data.whole) this.#readEarlier(data);
        if (name !== "cell") return;  // otherwise the stream or the cell is new
        if (this.ports.length > 0) this.choose(this.ports);
        if (this.newest.length > 0) this.chooseNewest([...this.newest]);
      });
    }
  }

  close() {
    clearTimeout(this.#timer);
    this.#source?.close();
    [this.#source, this.#id, this.#lastEvent] = [null, null, 0];
  }

  reconnect() {
    this.close();
    this.report("lost");
    this.#timer = setTimeout(() => this.open(), kAgain_ms);
  }

  receive() {
    this.#lastEvent = performance.now();
  }

  report(link, since = Date.now()) {
    if (this.#link === link) return;
    this.#link = link;
    this.link(link, since);
  }

  #check() {
    const silence = performance.now() - this.#lastEvent;
    if (this.#lastEvent === 0) return;
    if (silence > kSilent_ms) this.reconnect();
    else if (silence > kQuiet_ms) this.report("quiet");
  }

  /// Requests the events before those that a new stream sends.
  async #readEarlier(whole) {
    this.#whole = whole;
    for (let before = whole.older; before > 0;) {
      const { events, older, complete_since_ms } = await get("api/faults", { before }).catch(() => ({ events: [], older: 0 }));
      if (this.#whole !== whole) return;
      this.take("faults", { earlier: true, events, complete_since_ms });
      before = older;
    }
  }

  async #put() {
    this.#sent = this.#next;
    this.#next = null;
    const again = [...this.#again];
    this.#again.clear();
    if (!this.#id) return [];  // open() chooses the ports again
    try {
      return (await put(`api/streams/${this.#id}/ports`, { ports: this.ports, ...again.length > 0 ? { again } : {} })).problems ?? [];
    } catch (problem) {
      return [{ what: problem.what ?? problem.message, fix: problem.fix }];
    }
  }
}
