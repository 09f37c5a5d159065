// The logic of the alarms page: filters, counts, an order that does not change under the pointer. Pure.
import type { Alarm, Priority } from '../../hub/types';

export interface Filter {
  monitor: string;
  text: string;
}

export interface AlarmStep {
  at_ms: number;
  id: string;
  from: string;
  to: string;
  user: string | null;
  reason: string | null;
}

/** Meaning of a change of an alarm's state; keys `alarms.step_…`. */
export type StepName =
  | 'came'
  | 'again'
  | 'acked'
  | 'returned'
  | 'cleared'
  | 'acked_cleared'
  | 'shelved'
  | 'unshelved'
  | 'ended';

export const PRIORITIES: readonly Priority[] = ['fire', 'high', 'medium', 'low'];

export function waits(alarm: Alarm): boolean {
  return alarm.state === 'unack' || alarm.state === 'rtn_unack';
}

/** Alarms that match; of monitor, subsystem, flag and every text that is shown. */
export function matching(alarms: Alarm[], filter: Filter, lang: 'en' | 'ru'): Alarm[] {
  const wanted = filter.text.trim().toLocaleLowerCase(lang);
  return alarms.filter((alarm) => {
    if (filter.monitor && (alarm.monitor ?? '') !== filter.monitor) return false;
    if (!wanted) return true;
    const { id, what, cause, consequence, remedy } = alarm;
    const texts = [id, what[lang], cause[lang], consequence[lang], remedy[lang]];
    return texts.some((text) => text.toLocaleLowerCase(lang).includes(wanted));
  });
}

export interface Counts {
  /** Some of those that wait have not cleared. */
  urgent: boolean;
  waiting: number;
  shelved: number;
  active: number;
  by: Record<Priority, number>;
}

export function countOf(alarms: Alarm[]): Counts {
  const counts: Counts = {
    urgent: false,
    waiting: 0,
    shelved: 0,
    active: 0,
    by: { fire: 0, high: 0, medium: 0, low: 0 },
  };
  for (const alarm of alarms) {
    if (alarm.state === 'shelved') {
      counts.shelved += 1;
      continue;
    }
    counts.active += 1;
    counts.by[alarm.priority] += 1;
    if (!waits(alarm)) continue;
    counts.waiting += 1;
    counts.urgent ||= alarm.active;
  }
  return counts;
}

/**
 * While the pointer is over the list, nothing may move under it: existing entries keep their places, new
 * ones wait. `held` is the order so far; null: the order of urgency.
 */
export function inOrder(alarms: Alarm[], held: string[] | null): { shown: Alarm[]; fresh: Alarm[] } {
  if (!held) return { shown: alarms, fresh: [] };
  const byId = new Map(alarms.map((alarm) => [alarm.id, alarm]));
  const shown = held.flatMap((id) => byId.get(id) ?? []);
  const known = new Set(held);
  return { shown, fresh: alarms.filter((alarm) => !known.has(alarm.id)) };
}

/** Which alarms a user may have seen: how long each has been in the list. One that comes again is another. */
export class Seen {
  private since = new Map<string, number>();

  /** These are in the list now; of `all` nothing else is kept. Whether some are there for the first time. */
  note(displayed: readonly Alarm[], all: readonly Alarm[], now: number): boolean {
    const known = new Set(all.map(coming));
    this.since = new Map([...this.since].filter(([one]) => known.has(one)));
    const fresh = displayed.map(coming).filter((one) => !this.since.has(one));
    for (const one of fresh) this.since.set(one, now);
    return fresh.length > 0;
  }

  /** It has been in the list for this time. */
  has(alarm: Alarm, for_ms: number, now: number): boolean {
    return now - (this.since.get(coming(alarm)) ?? Infinity) >= for_ms;
  }
}

/** An alarm, and which time it is that it has come. */
function coming({ id, since_ms, count }: Alarm): string {
  return JSON.stringify([id, since_ms, count]);
}

export function stepOf({ from, to }: Pick<AlarmStep, 'from' | 'to'>): StepName {
  if (to === 'shelved') return 'shelved';
  if (from === 'shelved') return to === 'normal' ? 'ended' : 'unshelved';
  if (to === 'unack') return from === 'rtn_unack' ? 'again' : 'came';
  if (to === 'ack') return 'acked';
  if (to === 'rtn_unack') return 'returned';
  return from === 'rtn_unack' ? 'acked_cleared' : 'cleared';
}

/** The parts of `M1/Vertical/AmperageOverload`; the monitor of the hub's own alarms is empty. */
export function partsOf(id: string): { monitor: string; subsystem: string; flag: string } {
  const parts = id.split('/');
  if (parts.length < 3) return { monitor: '', subsystem: 'Hub', flag: parts.at(-1) ?? '' };
  const [flag, subsystem] = [parts.pop()!, parts.pop()!];
  return { monitor: parts.join('/'), subsystem, flag };
}

/** Cells for a table that a spreadsheet reads; formulas stay texts. */
export function csv(rows: (string | number)[][]): string {
  const cell = (value: string | number) => {
    const text = String(value);
    const safe = /^[=+@\t\r]|^-(?!\d)/.test(text) ? `'${text}` : text;
    return /[",;\n\r]/.test(safe) ? `"${safe.replaceAll('"', '""')}"` : safe;
  };
  return `${rows.map((row) => row.map(cell).join(',')).join('\r\n')}\r\n`;
}

/** The known entries with those that came since; null: they do not overlap. */
export function newer(known: AlarmStep[], latest: AlarmStep[]): AlarmStep[] | null {
  const top = known[0];
  const met = top ? latest.findIndex(({ at_ms, id, to }) => at_ms === top.at_ms && id === top.id && to === top.to) : -1;
  return met < 0 ? null : [...latest.slice(0, met), ...known];
}
