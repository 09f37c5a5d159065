// A Stop, Close or Lockout that another client has sent ends what is held here, as one of this page does.
import { type HaltKind, halt } from './halt';
import { type Store, store } from './store';
import type { TopicOf } from './types';

type Counts = TopicOf<'monitors/M1/urgent'>;

const KINDS = ['stop', 'close', 'lockout'] as const satisfies readonly HaltKind[];
const TOPIC = /^monitors\/(.+)\/urgent$/;

/** Once, at the start. One of this page itself is noticed again: it has ended what was held already. */
export function followHalts(of: Store = store): void {
  const seen = new Map<string, Counts>();
  of.subscribe('monitors/', (topic) => {
    const monitor = TOPIC.exec(topic)?.[1];
    if (!monitor) return;
    const before = seen.get(monitor);
    const now = of.getLive(topic as 'monitors/M1/urgent');
    if (now) seen.set(monitor, now);
    else seen.delete(monitor);
    if (!now || !before) return;
    for (const kind of KINDS) if (now[kind] > before[kind]) halt(kind, monitor, false);
  });
}
