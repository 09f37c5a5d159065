// Events: from the hub's store, then as they happen.
import { http } from '../../hub/http';
import { socket } from '../../hub/socket';
import type { EventSeen } from '../../hub/types';

/** Number of events in memory. */
const MOST = 30_000;
const LIMIT = 200;

export interface Happened {
  /** Null: just received; the store has its number. */
  n: number | null;
  at_ms: number;
  monitor: string | null;
  what: EventSeen['what'];
}

interface Wanted {
  monitor: string;
  text: string;
}

/** Searches as the hub does: in both languages, case-insensitively. */
export function fits({ monitor, what }: Happened, wanted: Wanted): boolean {
  const text = wanted.text.trim().toLocaleLowerCase();
  const found = [what.en, what.ru].some((one) => one.toLocaleLowerCase().includes(text));
  return found && (!wanted.monitor || wanted.monitor === monitor);
}

export class Happenings extends EventTarget {
  events: Happened[] = [];
  /** Where older ones start; null: there are none. */
  next: number | null = null;
  private filter: Wanted = { monitor: '', text: '' };
  private end: (() => void) | null = null;

  begin(): void {
    this.end ??= socket.on('event', ({ at_ms, monitor, what }) => {
      const heard = { n: null, at_ms, monitor, what };
      if (fits(heard, this.filter)) this.show([heard, ...this.events]);
    });
  }

  stop(): void {
    this.end?.();
    this.end = null;
  }

  /** The latest, or those before the last one. Rejects with HubError. */
  async load(filter: Wanted, on = false): Promise<void> {
    this.filter = filter;
    const query = new URLSearchParams({ limit: String(LIMIT) });
    if (filter.monitor) query.set('monitor', filter.monitor);
    if (filter.text.trim()) query.set('text', filter.text.trim());
    if (on && this.next !== null) query.set('before', String(this.next));
    const got = await http.get<{ events: Happened[]; next: number | null }>(`/api/events?${query}`);
    this.next = got.next;
    this.show(on ? [...this.events, ...got.events] : got.events);
  }

  private show(events: Happened[]): void {
    this.events = events.slice(0, MOST);
    this.dispatchEvent(new Event('change'));
  }
}
