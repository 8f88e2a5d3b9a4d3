// News from the gateway, as they come. A browser alone would neither notice a gateway that is silent nor try again one that
// refused, so both are done here.

const kAgain_ms = 1000;
const kSilent_ms = 15000;

export class Stream {
  /// `events`: {name: function of what came}; `link`: told "live" or "lost", whenever that changes.
  constructor(address, events, link = () => {}) {
    this.address = address;
    this.events = events;
    this.link = link;
    this.heard = performance.now();
    this.open();
  }

  open() {
    this.source = new EventSource(this.address);
    this.source.onopen = () => this.hear();
    this.source.onerror = () => this.again();
    for (const [name, act] of Object.entries(this.events)) {
      this.source.addEventListener(name, (event) => {
        this.hear();
        act(JSON.parse(event.data));
      });
    }
  }

  hear() {
    this.heard = performance.now();
    this.tell("live");
  }

  tell(link) {
    if (this.said === link) return;
    this.said = link;
    this.link(link);
  }

  /// Milliseconds since something came.
  get silence() {
    return performance.now() - this.heard;
  }

  /// To be called now and then where news come all the time.
  look() {
    if (this.silence > kSilent_ms) this.again();
  }

  again() {
    this.source.close();
    this.heard = performance.now();
    this.tell("lost");
    clearTimeout(this.timer);
    this.timer = setTimeout(() => this.open(), kAgain_ms);
  }

  close() {
    clearTimeout(this.timer);
    this.source.close();
  }
}
