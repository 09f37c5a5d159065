// The time for which something is held. It counts only while the page runs: a page that has stalled has not seen
// whether the finger was lifted. At its end the page first takes what waits in its queue, a release among it.

/** Interval between two looks, ms. */
const TICK_MS = 50;
/** A longer interval, ms: the page has stalled. */
const GAP_MOST_MS = 200;

export class Steady {
  private static readonly all = new Set<Steady>();
  private timer: ReturnType<typeof setTimeout> | undefined;

  /** Something is held on this page. */
  static get busy(): boolean {
    return Steady.all.size > 0;
  }

  /** `done` at the end of the time, or `stalled`; neither after `stop`. */
  start(for_ms: number, done: () => void, stalled: () => void): void {
    this.stop();
    const began = performance.now();
    let last = began;
    const end = () => {
      this.stop();
      done();
    };
    const look = () => {
      const now = performance.now();
      if (now - last > GAP_MOST_MS) {
        this.stop();
        return stalled();
      }
      last = now;
      const left = began + for_ms - now;
      if (left > 0) this.timer = setTimeout(look, Math.min(TICK_MS, left));
      else this.timer = setTimeout(end, 0);
    };
    this.timer = setTimeout(look, TICK_MS);
    Steady.all.add(this);
  }

  stop(): void {
    clearTimeout(this.timer);
    this.timer = undefined;
    Steady.all.delete(this);
  }
}
