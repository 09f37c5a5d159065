// The time of the hub since its start, as far as it is known here: never ahead of it.

/** Two clocks run apart by less than this part of the time. */
const DRIFT = 0.0002;

export class HubClock {
  /** Its time less ours, of the message that was under way for the shortest time so far; and when that came. */
  private best: { offset_ms: number; at_ms: number } | null = null;

  /** A message of the hub has come. */
  heard(up_ms: number, now_ms = performance.now()): void {
    const offset_ms = up_ms - now_ms;
    const known = this.offset(now_ms);
    this.best = { offset_ms: known === null ? offset_ms : Math.max(known, offset_ms), at_ms: now_ms };
  }

  /** Another connection: it may be another start of the hub. */
  forget(): void {
    this.best = null;
  }

  /** Its time now; null: nothing was heard of it. */
  now(now_ms = performance.now()): number | null {
    const offset_ms = this.offset(now_ms);
    return offset_ms === null ? null : Math.round(now_ms + offset_ms);
  }

  /** What was known is less certain the longer ago it was. */
  private offset(now_ms: number): number | null {
    return this.best && this.best.offset_ms - (now_ms - this.best.at_ms) * DRIFT;
  }
}
