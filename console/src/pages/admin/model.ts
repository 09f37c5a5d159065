// The logic of the administration page. Pure.
import type { Role, Session } from '../../hub/types';

export const ROLES: readonly Role[] = ['observer', 'operator', 'engineer', 'administrator'];
export const PASSWORD_LEAST = 10;
const NAME_MOST = 64;

export interface User {
  user: string;
  role: Role;
  created_ms: number;
  last_login_ms: number | null;
}

export interface Token {
  id: string;
  name: string;
  role: Role;
  created_ms: number;
  last_used_ms: number | null;
}

/** Who is signed in. */
export interface SessionSeen {
  id: string;
  user: string;
  role: Role;
  kind: Session['kind'];
  created_ms: number | null;
  used_ms: number | null;
  expires_ms: number | null;
  own: boolean;
  /** Open pages. */
  seats: { seat: string; from: string; since_ms: number }[];
}

/** Permissions, as in docs/hub-api.md; keys `admin.may_…`, with the lowest sufficient role. */
export const RIGHTS: readonly (readonly [string, Role])[] = [
  ['stop', 'observer'],
  ['read', 'observer'],
  ['inspect', 'observer'],
  ['authority', 'operator'],
  ['operate', 'operator'],
  ['unlock', 'operator'],
  ['alarms', 'operator'],
  ['audit', 'operator'],
  ['stop_update', 'operator'],
  ['setup', 'engineer'],
  ['restart', 'engineer'],
  ['force', 'engineer'],
  ['export', 'engineer'],
  ['update', 'engineer'],
  ['erase', 'administrator'],
  ['users', 'administrator'],
];

/** What is wrong with a name and a password for the hub; a key `admin.bad_…`, or null. */
export function badName(name: string, taken: string[] = []): 'name' | 'taken' | null {
  const length = [...name].length;
  const control = [...name].some((char) => char < ' ' || char === '\u007f');
  if (length < 1 || length > NAME_MOST || name.trim() !== name || control) return 'name';
  return taken.includes(name) ? 'taken' : null;
}

export function badPassword(password: string, again?: string): 'short' | 'differ' | null {
  if ([...password].length < PASSWORD_LEAST) return 'short';
  return again !== undefined && again !== password ? 'differ' : null;
}

const LETTERS = 'abcdefghjkmnpqrstuvwxyzABCDEFGHJKLMNPQRSTUVWXYZ23456789';

/** A password that can be read out: groups of four without letters that look alike. */
export function suggestPassword(random: (count: number) => Uint8Array): string {
  const letters: string[] = [];
  // Bytes that would make some letters more likely are discarded.
  const limit = 256 - (256 % LETTERS.length);
  while (letters.length < 16) {
    for (const byte of random(32))
      if (byte < limit && letters.length < 16) letters.push(LETTERS[byte % LETTERS.length]!);
  }
  return letters.join('').replace(/(.{4})(?=.)/g, '$1-');
}

/** Figures of /metrics without labels. */
export function metricsOf(text: string): Map<string, number> {
  const found = new Map<string, number>();
  for (const line of text.split('\n')) {
    const match = /^([a-z_]+) ([-+0-9.eE]+|NaN)$/.exec(line.trim());
    if (match) found.set(match[1]!, Number(match[2]));
  }
  return found;
}

/** The administrators that there are: the last one stays. */
export function isLastAdministrator(users: User[], user: string): boolean {
  const all = users.filter((one) => one.role === 'administrator');
  return all.length === 1 && all[0]!.user === user;
}
