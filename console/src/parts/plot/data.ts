// Values of a plot over time, in columns that share their times. Pure.

export type Value = number | null;

/** Without a value for this time, the line has a gap. */
export const GAP_MS = 3000;
const ROWS_MAX = 20_000;

/** Drawing of a series over a long time: a line, and the area from minimum to maximum around it. */
export interface Curve {
  value: readonly (readonly [number, Value])[];
  low: readonly (readonly [number, Value])[];
  high: readonly (readonly [number, Value])[];
}

/**
 * Intervals of the history, [begin, mean, minimum, maximum], as a curve: each over its own length; a missing
 * one is a gap.
 */
export function curveOf(spans: readonly (readonly [number, number, number, number])[], step_ms: number): Curve {
  const curve = { value: [] as [number, Value][], low: [] as [number, Value][], high: [] as [number, Value][] };
  const add = (at: number, mean: Value, least: Value, greatest: Value) => {
    curve.value.push([at, mean]);
    curve.low.push([at, least]);
    curve.high.push([at, greatest]);
  };
  let next: number | null = null;
  for (const [begin, mean, least, greatest] of spans) {
    if (next !== null && begin > next) add(next, null, null, null);
    add(begin, mean, least, greatest);
    next = begin + step_ms;
    add(next - 1, mean, least, greatest);
  }
  if (next !== null) add(next, null, null, null);
  return curve;
}

/**
 * Columns for uPlot: seconds, then a column for each series. A null is a gap; undefined is no
 * statement about that series at that time.
 */
export class Columns {
  private times: number[] = [];
  private columns: (Value | undefined)[][];

  constructor(
    count: number,
    private readonly keep_ms: number,
    private readonly gap_ms = GAP_MS,
  ) {
    this.columns = Array.from({ length: count }, () => []);
  }

  get length(): number {
    return this.times.length;
  }

  get last_ms(): number | null {
    return this.times.length ? this.times[this.times.length - 1]! * 1000 : null;
  }

  get first_ms(): number | null {
    return this.times.length ? this.times[0]! * 1000 : null;
  }

  /** Adds a row; one that is not later than the last is ignored. */
  push(at_ms: number, values: readonly (Value | undefined)[]): void {
    const last = this.last_ms;
    if (last !== null && at_ms <= last) return;
    if (last !== null && at_ms - last > this.gap_ms)
      this.row(
        last + 1,
        this.columns.map(() => null),
      );
    this.row(at_ms, values);
    this.trim(at_ms);
  }

  /** Replaces everything, from series with times of their own; each value holds until the next one. */
  fill(series: readonly (readonly (readonly [number, Value])[])[]): void {
    this.clear();
    const times = [...new Set(series.flatMap((points) => points.map(([at]) => at)))];
    times.sort((a, b) => a - b);
    const maps = series.map((points) => new Map(points.map(([at, value]) => [at, value])));
    for (const at of times) {
      this.row(
        at,
        this.columns.map((_, index) => maps[index]?.get(at)),
      );
    }
    if (times.length) this.trim(times[times.length - 1]!);
  }

  clear(): void {
    this.times = [];
    this.columns = this.columns.map(() => []);
  }

  /** The values at a time: the latest row that is not later, null in a gap. */
  at(at_ms: number): Value[] {
    let low = 0;
    let high = this.times.length;
    while (low < high) {
      const middle = (low + high) >> 1;
      if (this.times[middle]! * 1000 <= at_ms) low = middle + 1;
      else high = middle;
    }
    return this.columns.map((column) => {
      for (let row = low - 1; row >= 0; row--) {
        const value = column[row];
        if (value !== undefined) return value;
      }
      return null;
    });
  }

  /** For uPlot. */
  get table(): [number[], ...(Value | undefined)[][]] {
    return [this.times, ...this.columns];
  }

  private row(at_ms: number, values: readonly (Value | undefined)[]): void {
    this.times.push(at_ms / 1000);
    this.columns.forEach((column, index) => column.push(values[index]));
  }

  private trim(now_ms: number): void {
    const oldest = (now_ms - this.keep_ms) / 1000;
    if (this.times.length <= ROWS_MAX && (this.times[0] ?? oldest) >= oldest - 30) return;
    let from = this.times.findIndex((at) => at >= oldest);
    if (from < 0) from = this.times.length;
    from = Math.max(from, this.times.length - ROWS_MAX);
    this.times = this.times.slice(from);
    this.columns = this.columns.map((column) => column.slice(from));
  }
}
