// Defines how the page shows each state, severity and health: with a look (a colour), a sign (a symbol) and a word.

import { duration } from "./words.js";

const kSigns = { EXECUTING: "executing", START: "start", INITIALIZE: "initialize", IDLE: "idle", RECOVER: "recover", DESTRUCT: "destruct" };
const kWorst = ["bad", "poor", "plain", "faint", "good"];
/// The look of the rating that the gateway sends with each device and module.
const kLooks = { good: "good", idle: "plain", poor: "poor", bad: "bad" };
const kLost = { look: "bad", sign: "lost" };

/// The look of a module's state. `module` comes from Store.shown(). `key` identifies the state for sorting and filtering. `alarm` is true if
/// the module has an unacknowledged alarm, which asks for attention even if the state is good.
export function lookOfModule(module) {
  const look = lookOfState(module);
  return !module.alarm ? look : look.look === "good" ? { ...look, look: "poor", sign: "poor", alarm: true } : { ...look, alarm: true };
}

function lookOfState(module) {
  if (!module.state) return { key: "none", word: "not found", look: "faint", sign: "wait" };
  const word = module.state.state;
  if (module.lost) return { ...kLost, key: "lost", word: `lost, was ${word}` };
  if (word === "EXECUTING" && module.measures?.safe_stop) return { look: "poor", sign: "poor", key: word, word: "safe stop" };
  if (word === "EXECUTING" && module.measures?.forced) return { look: "poor", sign: "poor", key: word, word: "forced" };
  const ended = word === "DESTRUCT" && module.state.rating === "idle";
  return { key: word, word: module.stopped ? `${word} (stopped)` : word, sign: kSigns[word] ?? "poor",
    look: ended ? "faint" : kLooks[module.state.rating] ?? "poor" };
}

export function lookOfDevice(device) {
  if (!device) return { key: "none", word: "not found", look: "bad", sign: "lost" };
  if (!device.alive) return { ...kLost, key: "lost", word: "lost" };
  const look = kLooks[device.rating] ?? "plain";
  if (look === "bad") return { key: "failed", word: `${device.state}, failed`, look, sign: "recover" };
  if (look === "poor") return { key: "degraded", word: `${device.state}, degraded`, look, sign: "poor" };
  return { key: device.state, word: device.state, look, sign: look === "good" ? "executing" : "wait" };
}

/// The place of a look in the order from the worst to the best.
export function rankOf({ look }) {
  return kWorst.indexOf(look);
}

export function lookOfSeverity(severity) {
  if (severity === "error") return { look: "bad", sign: "recover", word: "error" };
  if (severity === "warning") return { look: "poor", sign: "poor", word: "warning" };
  return { look: "plain", sign: "note", word: severity };
}

const kRatings = {
  good: { rank: 0, look: "good", sign: "good", line: "good" },
  poor: { rank: 2, look: "poor", sign: "poor", line: "poor" },
  bad: { rank: 3, look: "bad", sign: "recover", line: "bad" },
  broken: { rank: 4, look: "bad", sign: "lost", line: "broken" },
};

/// The look of a connection. `health` comes from the `measures` event, or is undefined if it is not known. The page does not judge: the
/// gateway sends the rating and its reason, which `takt status`, `takt watch` and `takt graph` also show. The worse the rating, the higher
/// is `rank`.
export function lookOfConnection(health) {
  const rating = kRatings[health?.rating];
  if (!rating) return { key: "none", rank: 1, look: "faint", sign: "wait", word: "not known", line: "" };
  return { ...rating, key: health.rating, word: health.reason, short: health.word };
}

/// The look of the page's own connection to the gateway.
export function lookOfLink(link) {
  if (link === "live") return { look: "good", sign: "good", word: "live" };
  if (link === "quiet") return { look: "bad", sign: "lost", word: "no data, reconnecting" };
  if (link === "lost") return { look: "bad", sign: "lost", word: "connection lost, reconnecting" };
  return { look: "plain", sign: "wait", word: "connecting" };
}

/// The run time of a module as words, and as a share of its budget, else of its period, else of its deadline. The share is null if the
/// module has none of the three.
export function useOf(module) {
  const run = module.measures?.run_us;
  const allowed = module.about?.budget_ns ?? module.about?.period_ns ?? module.about?.deadline_ns;
  if (!run) return { share: null, words: "-" };
  if (!allowed) return { share: null, words: duration(run.p99) };
  const what = module.about.budget_ns ? "budget" : module.about.period_ns ? "period" : "deadline";
  return { share: run.p99 * 1000 / allowed, words: duration(run.p99), allowed, what };
}

/// The age of the newest value on a connection as words, and as a share of the deadline. The share is null if the connection has no
/// deadline.
export function ageOf(connection, health) {
  if (!health || health.age_us === null || health.age_us === undefined) return { share: null, words: "-" };
  if (!connection.deadline_ns) return { share: null, words: duration(health.age_us) };
  return { share: health.age_us * 1000 / connection.deadline_ns, words: duration(health.age_us) };
}

