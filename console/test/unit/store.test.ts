import { expect, test, vi } from 'vitest';
import { LINKED, SECOND, Store } from '../../src/hub/store';
import type { Alarm, Hello } from '../../src/hub/types';

function filled(): Store {
  const store = new Store();
  store.replace({ now_ms: 1000, set: { 'monitors/M10/info': { id: 'M10' }, 'monitors/M2/info': { id: 'M2' } } });
  store.setLinked(true);
  return store;
}

test('monitors are in the order of their numbers', () => {
  expect(filled().monitors()).toEqual(['M2', 'M10']);
});

test('a change replaces whole topics, removes what is gone, and notifies its subscribers', () => {
  const store = filled();
  const told: string[] = [];
  const end = store.subscribe('monitors/M2/', (topic) => told.push(topic));
  store.apply({ now_ms: 1100, set: { 'monitors/M2/info': { id: 'M2', address: 2 }, 'monitors/M10/info': {} } });
  store.apply({ now_ms: 1200, set: {}, gone: ['monitors/M2/info'] });
  end();
  store.apply({ now_ms: 1300, set: { 'monitors/M2/info': {} } });
  expect(told).toEqual(['monitors/M2/info', 'monitors/M2/info']);
  expect(store.get('monitors/M10/info')).toEqual({});
});

test('a new state forgets what is not in it', () => {
  const store = filled();
  const told: string[] = [];
  store.subscribe('monitors/M10/', (topic) => told.push(topic));
  store.replace({ now_ms: 2000, set: { 'monitors/M2/info': {} } });
  expect(store.get('monitors/M10/info')).toBeUndefined();
  expect(told).toEqual(['monitors/M10/info']);
});

test('what is stale: by its own word, without any value yet, or without the link', () => {
  const store = filled();
  const status = { at_ms: 900, stale: false, error: null, subsystems: {} };
  expect(store.stale('M2')).toBe(true);
  store.apply({ now_ms: 1000, set: { 'monitors/M2/status': status } });
  expect(store.stale('M2')).toBe(false);
  store.setLinked(false);
  expect(store.stale('M2')).toBe(true);
  store.setLinked(true);
  store.apply({ now_ms: 1000, set: { 'monitors/M2/status': { ...status, stale: true } } });
  expect(store.stale('M2')).toBe(true);
  store.apply({ now_ms: 1000, set: { 'monitors/M2/status': { ...status, at_ms: null } } });
  expect(store.stale('M2')).toBe(true);
});

test('the clock is that of the hub', () => {
  vi.useFakeTimers({ now: 500_000 });
  const store = new Store();
  store.setHello({ now_ms: 900_000 } as Hello);
  vi.advanceTimersByTime(5000);
  expect(store.now()).toBe(905_000);
  vi.useRealTimers();
});

test('a second is notified once', () => {
  const store = filled();
  let seconds = 0;
  store.subscribe(SECOND, () => (seconds += 1));
  for (const now_ms of [2000, 2100, 2900, 3000]) store.apply({ now_ms, set: {} });
  expect(seconds).toBe(2);
});

test('a replay hides what is live, which is kept aside and comes back', () => {
  const store = filled();
  let changes = 0;
  store.subscribe(LINKED, () => (changes += 1));
  store.beginReplay();
  expect(store.source).toBe('replay');
  expect(store.monitors()).toEqual([]);
  store.apply({ now_ms: 4000, set: { 'monitors/M3/info': { id: 'M3' } } });
  expect(store.monitors()).toEqual([]);
  store.replay({ now_ms: 77, set: { 'monitors/M1/info': { id: 'M1' } } });
  expect(store.monitors()).toEqual(['M1']);
  expect(store.now()).toBe(77);
  store.endReplay();
  expect(store.source).toBe('live');
  expect(store.monitors()).toEqual(['M2', 'M3', 'M10']);
  expect(changes).toBe(2);
});

test('alarms: the most urgent first, shelved ones last', () => {
  const store = filled();
  const alarm = (id: string, rest: Partial<Alarm>) => ({ id, monitor: 'M2', since_ms: 0, ...rest });
  store.apply({
    now_ms: 1,
    set: {
      'alarms/a': alarm('a', { priority: 'low', state: 'unack' }),
      'alarms/b': alarm('b', { priority: 'high', state: 'ack' }),
      'alarms/c': alarm('c', { priority: 'high', state: 'unack' }),
      'alarms/d': alarm('d', { priority: 'high', state: 'shelved' }),
      'alarms/e': alarm('e', { priority: 'high', state: 'unack', monitor: 'M1' }),
    },
  });
  expect(store.alarms('M2').map(({ id }) => id)).toEqual(['c', 'b', 'a', 'd']);
  expect(store.alarms()).toHaveLength(5);
});

test('a summary renews what it has of a state, and leaves the rest', () => {
  const store = filled();
  const vertical = { bits: 1, flags: ['Move'], severity: 'info', position: 5, current: 9, bad: { position: 'Fault' } };
  const subsystems = { Vertical: vertical, Radio: { bits: 0, flags: [], severity: 'info' } };
  store.apply({ now_ms: 1000, set: { 'monitors/M2/status': { at_ms: 900, stale: false, error: null, subsystems } } });
  const told: string[] = [];
  store.subscribe('monitors/M2/status', (topic) => told.push(topic));
  const now = { Vertical: { bits: 0, flags: [], position: 6 } };
  store.apply({
    now_ms: 2000,
    set: { 'monitors/M2/summary': { at_ms: 1900, stale: true, error: null, subsystems: now } },
  });
  const status = store.get('monitors/M2/status')!;
  expect(told).toEqual(['monitors/M2/status']);
  expect(store.get('monitors/M2/summary')).toBeUndefined();
  expect([status.at_ms, store.stale('M2')]).toEqual([1900, true]);
  expect(status.subsystems.Vertical).toEqual({ ...vertical, bits: 0, flags: [], position: 6, bad: undefined });
  expect(status.subsystems.Radio).toBeDefined();
});
