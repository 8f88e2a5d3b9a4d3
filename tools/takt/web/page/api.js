// Sends requests to the gateway of `takt web`, with the token that commands need.

// The token is kept for the folder of the page, because a proxy may serve several cells under one host name.
const kKept = `takt-token ${new URL(".", location).pathname}`;
// How long the page waits for an answer, by the method of the request. The gateway waits less long for a device, which may itself have to
// wait until a component has stopped.
const kLimits_s = { GET: 20, POST: 40, PUT: 40 };

/// The error of a failed request: what is wrong, and how to fix it.
export class Problem extends Error {
  constructor(what, fix = "", status = 0) {
    super(what);
    this.what = what;
    this.fix = fix;
    this.status = status;
  }

  get text() {
    return this.fix ? `${this.what}; ${this.fix}` : this.what;
  }
}

/// Moves the token from the page's address to the storage of the browser tab, so that the token does not appear on the screen, in links or
/// in the history. Returns true if the address had a token.
export function keepToken() {
  const match = location.hash.match(/^#token=([^&]+)/);
  if (!match) return false;
  sessionStorage.setItem(kKept, decodeURIComponent(match[1]));
  history.replaceState(null, "", location.pathname + location.search);
  return true;
}

export function get(path, parameters = {}) {
  return ask(`${path}?${new URLSearchParams(parameters)}`, { method: "GET" });
}

export function post(path, body) {
  return send("POST", path, body);
}

export function put(path, body) {
  return send("PUT", path, body);
}

function send(method, path, body) {
  return ask(path, { method, body: JSON.stringify(body), headers: { "Content-Type": "application/json" } });
}

async function ask(address, options) {
  const headers = { ...options.headers };
  const token = globalThis.sessionStorage?.getItem(kKept);  // a worker has no storage, and needs no token
  if (token) headers.Authorization = `Bearer ${token}`;
  const limit_s = kLimits_s[options.method];
  let response;
  try {
    response = await fetch(address, { ...options, headers, cache: "no-store", signal: AbortSignal.timeout(limit_s * 1000) });
  } catch (error) {
    if (error.name !== "TimeoutError") throw new Problem("takt web does not answer", "check that takt web is still running");
    const done = options.method === "GET" ? "" : "; the device may still have carried out the request";
    throw new Problem(`no answer within ${limit_s} s${done}`);
  }
  const answer = await response.json().catch(() => ({}));
  if (!response.ok) throw new Problem(answer.what ?? `takt web answered with status ${response.status}`, answer.fix, response.status);
  return answer;
}
