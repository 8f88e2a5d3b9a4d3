// The events of the gateway. A browser by itself does not notice a silent gateway and does not retry after a rejection, so this class
// does both.

const kAgain_ms = 1000;
const kSilent_ms = 15000;

export class Stream {
  /// `events`: {name: function of the event's data}; `link`: called with "live" or "lost" when that changes.
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

  /// Milliseconds since the last event.
  get silence() {
    return performance.now() - this.lastEvent;
  }

  /// Reconnects after a long silence. Call it regularly.
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
