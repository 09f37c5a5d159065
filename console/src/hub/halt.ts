// The one event of everything that ends motion or water, from this page or from another client: Stop, Lockout, Close,
// Abort. Whatever a hand holds at that moment ends with it, and must be held again. Parts use it: it depends on nothing
// of the hub.

import { guarded } from './faults';

export type HaltKind = 'stop' | 'lockout' | 'close' | 'abort';

export interface Halt {
  kind: HaltKind;
  /** Null: all monitors, or those of a zone. */
  monitor: string | null;
  /** From this page; else another client has sent it. */
  own: boolean;
}

type Listener = (halt: Halt) => void;

const listeners = new Set<Listener>();

/** Called before the order of this page is sent, and when that of another client is known. Returns the function that ends it. */
export function onHalt(fn: Listener): () => void {
  listeners.add(fn);
  return () => listeners.delete(fn);
}

/** Whether it ends what is held for a monitor; empty: for one that is not known. */
export function concerns({ own, monitor }: Halt, held: string): boolean {
  return own || !held || !monitor || monitor === held;
}

/** One that fails keeps neither the others nor the order back. */
export function halt(kind: HaltKind, monitor: string | null = null, own = true): void {
  for (const fn of [...listeners]) {
    guarded(() => fn({ kind, monitor, own }));
  }
}
