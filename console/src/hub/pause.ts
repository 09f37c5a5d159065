// A program that Move has paused goes on 3 s after the last Move (§3.1/3): how long until then. The
// monitor does not tell; it is reckoned from when its drives were last seen moving or held.
import { jog } from './jog';
import { store } from './store';

export const RESUME_MS = 3000;
const DRIVES = ['Horizontal', 'Vertical', 'Nozzle'] as const;
const last = new Map<string, number>();

export function followPauses(): void {
  store.subscribe('monitors/', (topic) => {
    const [, monitor, part] = topic.split('/');
    if (part !== 'status' || !monitor) return;
    const status = store.get(`monitors/${monitor}/status`);
    if (!status?.subsystems.Control?.flags.includes('Paused')) {
      last.delete(monitor);
      return;
    }
    const moves = DRIVES.some(
      (drive) =>
        jog.held(monitor, drive) || status.subsystems[drive]?.flags.includes('Move'),
    );
    if (moves || !last.has(monitor)) last.set(monitor, store.now());
  });
}

/** Milliseconds until the program goes on; null: none is paused. */
export function resumesIn(monitor: string): number | null {
  const since = last.get(monitor);
  return since === undefined ? null : Math.max(0, RESUME_MS - (store.now() - since));
}
