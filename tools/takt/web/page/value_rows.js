// Keeps the values of a port for hours in bounded memory, as takt web does (value_history.hpp). The older values are, the fewer are kept: in
// each interval, only the minimum and the maximum of each field, so no peak is lost.

const kKept_ms = 4 * 3600000;
const kStages = [{ age_ms: 1800000, every_ms: 2000 }, { age_ms: 300000, every_ms: 200 }];
const kThin_ms = 60000;
const kColumns = 1000;   // a plot shows at most two values of a series in each thousandth of its range
const kGap = 10;         // a curve is interrupted where samples are missing for this many times their usual distance,
const kGap_ms = 1000;    // and for at least this long

export class ValueRows {
  #rows = [];            // [time, value of the first field, ...], oldest first; null if a value is missing
  #thinned_ms = 0;

  add(times_ms, values) {
    times_ms.forEach((time, i) => this.#rows.push([time, ...values.map((of) => of[i])]));
    if (Math.abs(this.newest - this.#thinned_ms) < kThin_ms) return;
    this.#thinned_ms = this.newest;
    const kept = [];
    let begin = this.#after(this.newest - kKept_ms);
    for (const { age_ms, every_ms } of kStages) {
      const end = Math.max(begin, this.#after(Math.floor((this.newest - age_ms) / every_ms) * every_ms));
      kept.push(thinned(this.#rows.slice(begin, end), every_ms));
      begin = end;
    }
    this.#rows = kept.concat([this.#rows.slice(begin)]).flat();
  }

  clear() {
    [this.#rows, this.#thinned_ms] = [[], 0];
  }

  append(other) {
    this.#rows.push(...other.#rows);
  }

  get last() {
    return this.#rows.at(-1);
  }

  get oldest() {
    return this.#rows[0]?.[0] ?? Infinity;
  }

  get newest() {
    return this.#rows.at(-1)?.[0] ?? 0;
  }

  /// The newest row at or before a time.
  at(time) {
    return this.#rows[this.#after(time) - 1];
  }

  /// The rows from one time to another. With `around`, also the rows before and after them, so that a curve reaches the edges of a plot.
  between(from, to, around = 0) {
    return this.#rows.slice(Math.max(0, this.#after(from) - around), this.#after(to) + around);
  }

  /// The index of the first row after a time.
  #after(time) {
    let [low, high] = [0, this.#rows.length];
    while (low < high) {
      const middle = (low + high) >> 1;
      if (this.#rows[middle][0] <= time) low = middle + 1;
      else high = middle;
    }
    return low;
  }
}

/// Returns at most two rows for each interval. They have the minimum and the maximum of each of the columns, in the order in which they came.
function thinned(rows, every_ms, columns = rows[0]?.map((_, i) => i)) {
  const result = [];
  let [interval, first, second] = [null, null, null];
  for (const row of rows) {
    const its = Math.floor(row[0] / every_ms);
    if (its !== interval) {
      [interval, second] = [its, null];
      result.push(first = columns.map((column) => row[column]));
      continue;
    }
    if (!second) result.push(second = first.slice());
    second[0] = row[0];
    for (let i = 1; i < columns.length; ++i) {
      const value = row[columns[i]];
      if (value === null) continue;
      if (first[i] === null) first[i] = second[i] = value;
      else if (value < first[i] && value < second[i]) [first[i], second[i]] = [Math.max(first[i], second[i]), value];
      else if (value > first[i] && value > second[i]) [first[i], second[i]] = [Math.min(first[i], second[i]), value];
    }
  }
  return result;
}

/// Returns the table that Dygraph draws: rows of a time and a value per series, which is null where the series has no value, and NaN where
/// its curve is interrupted. All series share the times, because each of their intervals is a thousandth of the range.
export function tableOf(series, from, to) {
  const every = (to - from) / kColumns;
  const table = new Map();
  const put = (half, place, value) => {
    if (!table.has(half)) table.set(half, [(half / 2 + 0.25) * every, ...series.map(() => null)]);
    table.get(half)[place + 1] = value;
  };
  series.forEach(({ rows, column, labels }, place) => {
    let [half, before, apart, apartBefore] = [-1, Infinity, Infinity, Infinity];
    for (const [time, value] of thinned(rows.between(from, to, 1), every, [0, column])) {
      const first = 2 * Math.floor(time / every);
      const gap = !labels && time - before > Math.max(kGap_ms, every, kGap * Math.max(apart, apartBefore));
      if (gap && first - 1 > half) put(first - 1, place, NaN);
      half = half === first ? first + 1 : first;
      put(half, place, value ?? NaN);
      [before, apart, apartBefore] = [time, time - before, apart];
    }
  });
  return [...table.values()].sort((a, b) => a[0] - b[0]);
}
