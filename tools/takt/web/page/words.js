// Formats numbers and times for the page, with three significant digits and a suitable unit.

const kMinus = "\u2212";

const two = (n) => String(n).padStart(2, "0");

export function number(value) {
  if (value === null || value === undefined || !Number.isFinite(value)) return "-";
  const size = Math.abs(value);
  if (Number.isInteger(value) && size < 1e9) return (value < 0 ? kMinus : "") + size;
  const digits = size >= 100 ? 0 : size >= 10 ? 1 : size >= 1 ? 2 : 3;
  const text = size < 0.001 || size >= 1e7 ? size.toExponential(2) : size.toFixed(digits);
  return (value < 0 ? kMinus : "") + text;
}

/// Formats a value with up to this many significant digits.
export function digits(value, most = 6) {
  if (value === null || value === undefined || !Number.isFinite(value)) return "-";
  const size = Math.abs(value);
  const text = size !== 0 && (size < 1e-4 || size >= 1e15) ? Number(size.toPrecision(most)).toExponential() : String(Number(size.toPrecision(Math.max(most, Math.ceil(Math.log10(size + 1))))));
  return (value < 0 ? kMinus : "") + text;
}

export function count(value) {
  return value === null || value === undefined ? "-" : String(value);
}

/// Formats a duration that is given in microseconds. From two minutes on, the duration is rounded to seconds, and from two hours on to minutes.
export function duration(us) {
  if (us === null || us === undefined) return "-";
  const size = Math.abs(us);
  if (size < 1000) return `${number(us)} us`;
  if (size < 1e6) return `${number(us / 1000)} ms`;
  const seconds = Math.round(us / 1e6);
  const minutes = Math.round(us / 6e7);
  if (seconds < 120) return `${number(us / 1e6)} s`;
  return minutes < 120 ? `${Math.floor(seconds / 60)} min ${seconds % 60} s` : `${Math.floor(minutes / 60)} h ${minutes % 60} min`;
}

/// Formats a time from the descriptor without rounding: 1 ms, not 1.00 ms.
export function exact(ns) {
  for (const [unit, of] of [["s", 1e9], ["ms", 1e6], ["us", 1e3]]) {
    if (ns >= of) return `${Number((ns / of).toPrecision(6))} ${unit}`;
  }
  return `${ns} ns`;
}

export function clock(time_ms, { thousandths = false } = {}) {
  if (!time_ms) return "-";
  const at = new Date(time_ms);
  const text = `${two(at.getHours())}:${two(at.getMinutes())}:${two(at.getSeconds())}`;
  return thousandths ? `${text}.${String(at.getMilliseconds()).padStart(3, "0")}` : text;
}

/// Formats the date of a time, in local time.
export function day(time_ms) {
  const at = new Date(time_ms);
  return `${at.getFullYear()}-${two(at.getMonth() + 1)}-${two(at.getDate())}`;
}

/// Formats the time of day, with the date if it is not today.
export function instant(time_ms, precision = { thousandths: true }) {
  const text = clock(time_ms, precision);
  return !time_ms || day(time_ms) === day(Date.now()) ? text : `${day(time_ms)} ${text}`;
}

export function several(n, what) {
  return `${n} ${what}${n === 1 ? "" : "s"}`;
}

/// Lists names for a sentence: up to three names; if there are more, two names and the number of the others.
export function listed(names) {
  if (names.length === 3) return `${names[0]}, ${names[1]} and ${names[2]}`;
  if (names.length < 3) return names.join(" and ");
  return `${names.slice(0, 2).join(", ")} and ${names.length - 2} more`;
}
