// What has happened: from the hub's store, and on as it happens.
import { http } from '../../hub/http';
import { socket } from '../../hub/socket';
import type { EventSeen } from '../../hub/types';

/** So many are in the page. */
const MOST = 500;

export interface Happened {
  /** Null: heard just now; the store has its number. */
  n: number | null;
  at_ms: number;
  monitor: string | null;
  what: EventSeen['what'];
}

export class Happenings extends EventTarget {
  events: Happened[] = [];
  /** Where older ones begin; null: there are none. */
  next: number | null = null;
  private end: (() => void) | null = null;

  begin(): void {
    this.end ??= socket.on('event', ({ at_ms, monitor, what }) => this.show([{ n: null, at_ms, monitor, what }, ...this.events]));
  }

  stop(): void {
    this.end?.();
    this.end = null;
  }

  /** The latest, or those before the last one. Rejects with HubError. */
  async load(filter: { monitor: string; text: string }, on = false): Promise<void> {
    const query = new URLSearchParams({ limit: '100' });
    if (filter.monitor) query.set('monitor', filter.monitor);
    if (filter.text.trim()) query.set('text', filter.text.trim());
    if (on && this.next !== null) query.set('before', String(this.next));
    const got = await http.get<{ events: Happened[]; next: number | null }>(`/api/events?${query}`);
    this.next = got.next;
    this.show(on ? [...this.events, ...got.events] : got.events);
  }

  private show(events: Happened[]): void {
    this.events = events.slice(0, MOST);
    if (events.length > MOST) this.next = null;
    this.dispatchEvent(new Event('change'));
  }
}
