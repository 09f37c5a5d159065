import { describe, expect, it } from 'vitest';
import {
  badName,
  badPassword,
  isLastAdministrator,
  metricsOf,
  RIGHTS,
  suggestPassword,
  type User,
} from '../../src/pages/admin/model';

describe('administration', () => {
  it('checks names and passwords as the hub does', () => {
    expect(badName('anna')).toBeNull();
    expect(badName('Ольга Ивановна')).toBeNull();
    expect(badName('')).toBe('name');
    expect(badName(' anna')).toBe('name');
    expect(badName('a\nb')).toBe('name');
    expect(badName('x'.repeat(65))).toBe('name');
    expect(badName('anna', ['anna'])).toBe('taken');
    expect(badPassword('123456789')).toBe('short');
    expect(badPassword('пароль-десять')).toBeNull();
    expect(badPassword('long enough 1', 'long enough 2')).toBe('differ');
  });

  it('suggests passwords of 16 letters, all equally likely', () => {
    let next = 0;
    const all = suggestPassword((count) => Uint8Array.from({ length: count }, () => next++ % 256));
    expect(all).toMatch(/^[a-zA-Z2-9]{4}(-[a-zA-Z2-9]{4}){3}$/);
    // 256 is no multiple of the letters: the highest bytes are not used.
    let calls = 0;
    const high = suggestPassword((count) => new Uint8Array(count).fill(calls++ === 0 ? 255 : 1));
    expect(high).toBe('bbbb-bbbb-bbbb-bbbb');
    expect(calls).toBe(2);
  });

  it('reads figures without labels', () => {
    const found = metricsOf('# HELP a b\nlafet_x 4\nlafet_stop_seconds_max 9.2e-5\nlafet_monitor_up{monitor="M1"} 1\n');
    expect([...found]).toEqual([
      ['lafet_x', 4],
      ['lafet_stop_seconds_max', 9.2e-5],
    ]);
  });

  it('keeps the last administrator', () => {
    const user = (name: string, role: User['role']): User => ({ user: name, role, created_ms: 0, last_login_ms: null });
    const users = [user('a', 'administrator'), user('b', 'engineer')];
    expect(isLastAdministrator(users, 'a')).toBe(true);
    expect(isLastAdministrator(users, 'b')).toBe(false);
    expect(isLastAdministrator([...users, user('c', 'administrator')], 'a')).toBe(false);
  });

  it('says that all roles may stop', () => {
    expect(RIGHTS.find(([name]) => name === 'stop')?.[1]).toBe('observer');
    expect(new Set(RIGHTS.map(([name]) => name)).size).toBe(RIGHTS.length);
  });
});
