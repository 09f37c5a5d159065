// The one event of everything that ends motion or water from this page: Stop, Lockout, Close, Abort. Whatever a hand
// holds at that moment ends with it, and must be held again. Parts use it: it depends on nothing of the hub.

import { guarded } from './faults';

export type HaltKind = 'stop' | 'lockout' | 'close' | 'abort';

export interface Halt {
  kind: HaltKind;
  /** Null: all monitors, or those of a zone. */
  monitor: string | null;
}

type Listener = (halt: Halt) => void;

const listeners = new Set<Listener>();

/** Called before the order is sent. Returns the function that ends it. */
export function onHalt(fn: Listener): () => void {
  listeners.add(fn);
  return () => listeners.delete(fn);
}

/** One that fails keeps neither the others nor the order back. */
export function halt(kind: HaltKind, monitor: string | null = null): void {
  for (const fn of [...listeners]) {
    guarded(() => fn({ kind, monitor }));
  }
}
