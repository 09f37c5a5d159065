// The captured frames, and which of them are shown.
import type { FrameSeen } from '../../hub/types';

/** A captured frame: numbered, with the time since the request it answers. */
export interface Kept extends FrameSeen {
  n: number;
  took_ms: number | null;
}

export interface FrameFilter {
  text: string;
  direction: 'both' | 'in' | 'out';
  polls: boolean;
}

const MOST = 10_000;
/** An answer this much later belongs to something else. */
const ANSWER_MS = 5000;

/** The last frames of a link. */
export class Frames {
  list: Kept[] = [];
  private next = 1;
  private lastOut: Kept | null = null;

  add(frame: FrameSeen): void {
    let took_ms: number | null = null;
    if (frame.direction === 'in' && this.lastOut && frame.verdict === 'believed') {
      const took = frame.at_ms - this.lastOut.at_ms;
      if (took >= 0 && took < ANSWER_MS && frame.src === this.lastOut.dst) took_ms = took;
    }
    const kept = { ...frame, n: this.next++, took_ms };
    if (frame.direction === 'out') this.lastOut = kept;
    if (took_ms !== null) this.lastOut = null;
    this.list.push(kept);
    if (this.list.length > MOST) this.list.splice(0, this.list.length - MOST);
  }

  get passed(): number {
    return this.next - 1;
  }

  clear(): void {
    this.list = [];
  }
}

/** Once per frame: a text of some kilobytes is not searched again at each new frame. */
let searched = { wanted: '', found: new WeakMap<Kept, boolean>() };

function finds(frame: Kept, wanted: string): boolean {
  if (searched.wanted !== wanted) searched = { wanted, found: new WeakMap() };
  const known =
    searched.found.get(frame) ?? (frame.text.toLowerCase().includes(wanted) || frame.bytes.includes(wanted));
  searched.found.set(frame, known);
  return known;
}

export function shownFrames(list: Kept[], filter: FrameFilter, isPoll: (frame: Kept) => boolean): Kept[] {
  const wanted = filter.text.trim().toLowerCase();
  if (!wanted && filter.direction === 'both' && filter.polls) return list.slice();
  return list.filter((frame) => {
    if (filter.direction !== 'both' && frame.direction !== filter.direction) return false;
    if (!filter.polls && isPoll(frame)) return false;
    return !wanted || finds(frame, wanted);
  });
}

/** Which rows of a list are visible, with some neighbours. */
export function slice(scrollTop: number, height: number, row: number, count: number): [number, number] {
  const beside = 6;
  const first = Math.max(0, Math.min(Math.floor(scrollTop / row) - beside, count - 1));
  const last = Math.min(count, Math.ceil((scrollTop + height) / row) + beside);
  return [first, Math.max(first, last)];
}

/** A line for a text file: what `lafet decode` reads, with a comment. */
export function lineOf(frame: Kept): string {
  const way = frame.direction === 'out' ? '>' : '<';
  return `${new Date(frame.at_ms).toISOString()} ${way} ${frame.src}>${frame.dst} ${frame.verdict} | ${frame.bytes} | ${frame.text}`;
}
