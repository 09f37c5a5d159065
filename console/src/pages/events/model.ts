// The audit log for people: the entries of one command belong together.
import type { Act } from '../../hub/api';
import type { AuditEntry } from '../../hub/types';

export type Kind = 'command' | 'jog' | 'authority' | 'alarm' | 'access';
export type Fate = 'done' | 'open' | 'refused' | 'failed';

/** One action of a user: one entry, or the two or three of a command. */
export interface Deed {
  /** Number of its first entry that is known. */
  n: number;
  /** Null: an entry of another version of the hub. */
  kind: Kind | null;
  first: AuditEntry;
  /** Its outcome; null: unknown yet. */
  answer: AuditEntry | null;
  effect: AuditEntry | null;
  entries: AuditEntry[];
}

export interface LogFilter {
  text: string;
  /** `bad`: failures of any kind. */
  kind: Kind | 'bad' | '';
  from_ms: number | null;
  to_ms: number | null;
}

const GOOD = new Set(['Ok', 'Accepted', 'Cached', 'stopped', 'standing', 'replaced', 'repeated', 'effect', 'same']);
/** Version of the acts that this page supports. */
const VERSION = 1;
const ALARMS = ['acknowledge', 'shelve', 'unshelve'];

/** The typed act of an entry; null: it has only its text. */
export function actOf({ act }: AuditEntry): Act | null {
  return act?.v === VERSION ? act : null;
}

export function kindOf(entry: AuditEntry): Kind | null {
  const type = actOf(entry)?.type;
  if (type === undefined) return null;
  if (type === 'request') return 'command';
  if (type === 'jog' || type === 'authority') return type;
  return ALARMS.includes(type) ? 'alarm' : 'access';
}

function number(entry: AuditEntry, name: string): number | null {
  const value = entry.details?.[name];
  return typeof value === 'number' ? value : null;
}

/** Groups entries in any order into actions, the latest first. */
export function deedsOf(entries: AuditEntry[]): Deed[] {
  const askedBy = new Map<number, number>();
  for (const entry of entries) {
    const asked = number(entry, 'asked');
    if (asked !== null) askedBy.set(entry.n, asked);
  }
  const groups = new Map<number, AuditEntry[]>();
  const keyOf = (entry: AuditEntry): number => {
    const answered = number(entry, 'answered');
    if (answered !== null) return askedBy.get(answered) ?? answered;
    const asked = number(entry, 'asked');
    return asked ?? entry.n;
  };
  for (const entry of [...entries].sort((a, b) => a.n - b.n)) {
    const key = keyOf(entry);
    groups.set(key, [...(groups.get(key) ?? []), entry]);
  }
  return [...groups.values()].map(deed).sort((a, b) => b.n - a.n);
}

function deed(entries: AuditEntry[]): Deed {
  const first = entries[0]!;
  const effect = entries.find((entry) => entry.outcome === 'effect') ?? null;
  const answer = entries.find((entry) => entry.outcome !== 'asked' && entry.outcome !== 'effect') ?? null;
  return { n: first.n, kind: kindOf(first), first, answer, effect, entries };
}

/** A monitor that is locked out denies Stop (§3.18/2): the lockout has stopped it already. */
export function isNeedless({ first, answer }: Deed): boolean {
  const act = actOf(first);
  return act?.type === 'request' && act.request === 'Stop' && answer?.outcome === 'Denied';
}

export function fateOf(deed: Deed): Fate {
  if (!deed.answer) return 'open';
  if (isNeedless(deed)) return 'done';
  if (deed.answer.outcome === 'not allowed') return 'refused';
  return GOOD.has(deed.answer.outcome) ? 'done' : 'failed';
}

export function matches(deed: Deed, filter: LogFilter, title: string): boolean {
  const { first } = deed;
  if (filter.kind === 'bad') {
    if (!['refused', 'failed'].includes(fateOf(deed))) return false;
  } else if (filter.kind && deed.kind !== filter.kind) return false;
  if (filter.from_ms !== null && first.at_ms < filter.from_ms) return false;
  if (filter.to_ms !== null && first.at_ms > filter.to_ms) return false;
  const wanted = filter.text.trim().toLocaleLowerCase();
  if (!wanted) return true;
  const texts = [
    first.what,
    title,
    first.user,
    first.role,
    first.from,
    first.monitor,
    deed.answer?.outcome,
    `#${first.n}`,
  ];
  return (
    texts.some((text) => text?.toLocaleLowerCase().includes(wanted)) ||
    deed.entries.some((entry) => JSON.stringify(entry.details).toLocaleLowerCase().includes(wanted))
  );
}

/**
 * New entries before the known ones; null: there is a gap, everything has to be read again.
 * `filtered`: numbers are missing because of the filter.
 */
export function joined(known: AuditEntry[], latest: AuditEntry[], filtered: boolean): AuditEntry[] | null {
  const top = known[0]?.n ?? 0;
  const fresh = latest.filter((entry) => entry.n > top);
  if (fresh.length === 0) return known;
  const gap = fresh.length === latest.length && fresh.at(-1)!.n !== top + 1;
  if (gap && (known.length > 0 || !filtered)) return null;
  return [...fresh, ...known];
}

/** The value of a `datetime-local` field in ms; null: empty. */
export function fieldTime(value: string): number | null {
  const at = value ? new Date(value).getTime() : NaN;
  return Number.isFinite(at) ? at : null;
}

/** Details that are shown as name and value; those shown in another way are omitted. */
export function plainDetails(entry: AuditEntry): [string, string][] {
  const apart = new Set(['answers', 'state', 'monitors', 'asked', 'answered', 'at_ms', 'stale']);
  return Object.entries(entry.details ?? {})
    .filter(([name, value]) => !apart.has(name) && value !== null && !(Array.isArray(value) && value.length === 0))
    .map(([name, value]) => [name, inWords(value)]);
}

function inWords(value: unknown): string {
  if (Array.isArray(value)) return value.join(', ');
  return typeof value === 'object' ? JSON.stringify(value) : String(value);
}

/** Whether it is about every monitor. */
export function isOfAll(entry: AuditEntry): boolean {
  return entry.monitor === '*';
}

/** The monitors by their results, of a request to all. */
export function byResult(entry: AuditEntry): [string, string[]][] {
  const monitors = entry.details?.monitors;
  return isOfAll(entry) && monitors ? Object.entries(monitors as Record<string, string[]>) : [];
}
