// What is asked of the gateway, and the token with which it may be told something.

const kKept = "takt-token";
// Longer than the gateway itself waits for a device: a component may take so long to stop.
const kLimits_s = { GET: 20, POST: 40, PUT: 40 };

/// What went wrong and what would help, both in words.
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

/// Takes the token out of the address, so that it is neither seen nor linked nor kept in the history. It lasts as long as the tab.
/// Whether there was one.
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
  const token = sessionStorage.getItem(kKept);
  if (token) headers.Authorization = `Bearer ${token}`;
  const limit_s = kLimits_s[options.method];
  let response;
  try {
    response = await fetch(address, { ...options, headers, cache: "no-store", signal: AbortSignal.timeout(limit_s * 1000) });
  } catch (error) {
    if (error.name !== "TimeoutError") throw new Problem("the gateway does not answer", "see whether takt web still runs");
    const done = options.method === "GET" ? "" : "; whether it was done is not known";
    throw new Problem(`no answer within ${limit_s} s${done}`);
  }
  const answer = await response.json().catch(() => ({}));
  if (!response.ok) throw new Problem(answer.what ?? `the gateway answered ${response.status}`, answer.fix, response.status);
  return answer;
}
