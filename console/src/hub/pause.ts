// A program paused by Move resumes 3 s after the last Move (§3.1/3): the time until then, as reported by
// the hub, which sees every Move.
import { store } from './store';

/** Milliseconds until the program resumes; null: none is paused. */
export function resumesIn(monitor: string): number | null {
  const status = store.get(`monitors/${monitor}/status`);
  if (!status?.subsystems.Control?.flags.includes('Paused')) return null;
  return status.resumes_ms == null ? null : Math.max(0, status.resumes_ms - store.now());
}
