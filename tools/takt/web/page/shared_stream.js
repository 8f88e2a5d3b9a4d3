// The page's end of the stream that all tabs of a browser share (shared_worker.js).

import { Stream } from "./stream.js";

/// A stream that the worker reads. It also notices a worker that has ended.
export class SharedStream extends Stream {
  #port;
  #hidden = true;
  #request = 0;  // the number of the last request of choose(), which #answer() answers
  #answer = () => {};

  /// `fail` is called if the browser cannot run the worker.
  constructor(take, link, fail) {
    super(take, link);
    this.fail = fail;
    this.#connect();
    addEventListener("pagehide", () => this.#tell({ hidden: true, ports: [], left: true }));
  }

  rest(hidden) {
    this.#hidden = hidden;
    this.#tell({ hidden });
    if (hidden) this.close();
    else this.receive();
  }

  choose(ports) {
    this.ports = ports;
    this.#answer([]);
    return new Promise((answer) => {
      this.#answer = answer;
      this.#tell({ ports, request: ++this.#request });
    });
  }

  chooseNewest(newest) {
    this.newest = newest;
    this.#tell({ newest });
  }

  reconnect() {
    this.#port.close();
    this.#answer([]);
    this.#connect();
    this.rest(this.#hidden);
    this.#tell({ newest: this.newest });
    if (this.ports.length > 0) this.#tell({ ports: this.ports });
  }

  #connect() {
    const worker = new SharedWorker("shared_worker.js", { type: "module" });
    worker.onerror = () => {
      this.close();
      this.fail();
    };
    this.#port = worker.port;
    this.#port.onmessage = ({ data: [name, data] }) => {
      if (!this.#hidden) this.receive();
      if (name === "link") this.report(data.link, data.since);
      else if (name !== "problems") this.take(name, data);
      else if (data.request === this.#request) this.#answer(data.problems);
    };
  }

  #tell(news) {
    this.#port.postMessage(news);
  }
}
