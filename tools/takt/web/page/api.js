// Requests to the gateway, and the token that commands need.

const kKept = "takt-token";
// The page waits longer than the gateway waits for a device, which may be long because a component may take long to stop.
const kLimits_s = { GET: 20, POST: 40, PUT: 40 };

/// A failed request. It says what is wrong and what to do.
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

/// Moves the token from the address to the storage of the tab, so that it does not appear on the screen, in links or in the history.
/// Returns whether the address had a token.
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
    if (error.name !== "TimeoutError") throw new Problem("the gateway does not answer", "check that takt web still runs");
    const done = options.method === "GET" ? "" : "; it may or may not have been done";
    throw new Problem(`no answer within ${limit_s} s${done}`);
  }
  const answer = await response.json().catch(() => ({}));
  if (!response.ok) throw new Problem(answer.what ?? `the gateway answered ${response.status}`, answer.fix, response.status);
  return answer;
}
