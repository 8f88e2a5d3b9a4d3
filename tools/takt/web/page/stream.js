// Receives the gateway's events, and reconnects. An EventSource alone neither notices a silent gateway nor retries after a rejection.

const kAgain_ms = 1000;
const kSilent_ms = 15000;

export class Stream {
  /// `events` has a function for each event's data, by the event's name. When the connection changes, `link` is called with "live" or
  /// "lost".
  constructor(address, events, link = () => {}) {
    this.address = address;
    this.events = events;
    this.link = link;
    this.lastEvent = performance.now();
    this.open();
  }

  open() {
    this.source = new EventSource(this.address);
    this.source.onopen = () => this.receive();
    this.source.onerror = () => this.reconnect();
    for (const [name, act] of Object.entries(this.events)) {
      this.source.addEventListener(name, (event) => {
        this.receive();
        act(JSON.parse(event.data));
      });
    }
  }

  receive() {
    this.lastEvent = performance.now();
    this.report("live");
  }

  report(link) {
    if (this.reported === link) return;
    this.reported = link;
    this.link(link);
  }

  /// The time since the last event, in milliseconds.
  get silence() {
    return performance.now() - this.lastEvent;
  }

  /// Reconnects if no event has arrived for a long time. The page calls this regularly.
  check() {
    if (this.silence > kSilent_ms) this.reconnect();
  }

  reconnect() {
    this.source.close();
    this.lastEvent = performance.now();
    this.report("lost");
    clearTimeout(this.timer);
    this.timer = setTimeout(() => this.open(), kAgain_ms);
  }

  close() {
    clearTimeout(this.timer);
    this.source.close();
  }
}
