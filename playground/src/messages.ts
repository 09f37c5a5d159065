// What the page and the worker say to each other.
import type { Command, View, Words } from './wire';

export type ToWorker =
  | { kind: 'command'; id: number; command: Command }
  /** Simulated seconds a second; 0 stops time. */
  | { kind: 'pace'; speed: number }
  /** To the end of the recorded session. */
  | { kind: 'skip' };

export type FromWorker =
  | { kind: 'ready' }
  | { kind: 'answer'; id: number; ok?: unknown; error?: Words }
  | { kind: 'view'; view: View; speed: number }
  | { kind: 'failed'; why: string };
