// The time of the hub since its start, as far as it is known here: not ahead of it.

/** Two clocks run apart by less than this part of the time. */
const DRIFT = 0.0002;
/** What was learnt before the last so many ms is forgotten: a clock that has stood still is learnt again. */
const WINDOW_MS = 2500;

/** Its time less ours, of the message that was under way for the shortest time; and when that came. */
interface Best {
  offset_ms: number;
  at_ms: number;
}

export class HubClock {
  private best: Best | null = null;
  /** That of the window before. */
  private former: Best | null = null;
  private since_ms = 0;

  /** A message of the hub has come. */
  heard(up_ms: number, now_ms = performance.now()): void {
    if (this.best && now_ms - this.since_ms >= WINDOW_MS) {
      this.former = this.best;
      this.best = null;
    }
    if (!this.best) this.since_ms = now_ms;
    const offset_ms = up_ms - now_ms;
    if (offset_ms >= offsetOf(this.best, now_ms)) this.best = { offset_ms, at_ms: now_ms };
  }

  /** Another connection: it may be another start of the hub. */
  forget(): void {
    this.best = null;
    this.former = null;
  }

  /** Its time now; null: nothing was heard of it. */
  now(now_ms = performance.now()): number | null {
    const offset_ms = Math.max(offsetOf(this.best, now_ms), offsetOf(this.former, now_ms));
    return Number.isFinite(offset_ms) ? Math.round(now_ms + offset_ms) : null;
  }
}

/** What was known is less certain the longer ago it was. */
function offsetOf(best: Best | null, now_ms: number): number {
  return best ? best.offset_ms - (now_ms - best.at_ms) * DRIFT : -Infinity;
}
