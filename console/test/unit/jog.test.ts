import { afterEach, beforeEach, expect, test, vi } from 'vitest';
import { type HoldState, Jog } from '../../src/hub/jog';

interface Sent {
  type: string;
  drive: string;
  toward?: string;
}

let sent: Sent[];
let up: boolean;
let allowed: boolean;
let jog: Jog;

beforeEach(() => {
  vi.useFakeTimers();
  sent = [];
  up = true;
  allowed = true;
  jog = new Jog({
    send: (message) => {
      if (up) sent.push(message as unknown as Sent);
      return up;
    },
    now: () => 0,
    beat_ms: () => 60,
    allowed: () => allowed,
  });
});
afterEach(() => vi.useRealTimers());

const types = () => sent.map((message) => message.type);

test('sends heartbeats from the first moment until release, then one end', () => {
  const hold = jog.hold('M1', 'Vertical', 'max');
  expect(types()).toEqual(['jog']);
  vi.advanceTimersByTime(180);
  expect(types()).toEqual(['jog', 'jog', 'jog', 'jog']);
  hold.end();
  hold.end();
  vi.advanceTimersByTime(1000);
  expect(types()).toEqual(['jog', 'jog', 'jog', 'jog', 'jog_end']);
  expect(vi.getTimerCount()).toBe(0);
});

test('two drives are two streams, and end separately', () => {
  const one = jog.hold('M1', 'Vertical', 'max');
  jog.hold('M1', 'Horizontal', 'min');
  one.end();
  sent = [];
  vi.advanceTimersByTime(60);
  expect(sent.map(({ drive, toward }) => [drive, toward])).toEqual([['Horizontal', 'min']]);
});

test('a new hold of a drive takes the place of the old one, whose end then does nothing', () => {
  const old = jog.hold('M1', 'Vertical', 'max');
  jog.hold('M1', 'Vertical', 'min');
  old.end();
  sent = [];
  vi.advanceTimersByTime(60);
  expect(sent).toMatchObject([{ type: 'jog', toward: 'min' }]);
});

test('after the hub has ended it, it sends no more heartbeats', () => {
  const states: HoldState[] = [];
  const hold = jog.hold('M1', 'Vertical', 'max', (state) => states.push(state));
  const heard = { type: 'jog', monitor: 'M1', drive: 'Vertical', text: null } as const;
  jog.heard({ ...heard, state: 'moving', end: null });
  sent = [];
  jog.heard({ ...heard, state: 'ended', end: 'taken_over' });
  expect(types(), 'what is on its way begins nothing').toEqual(['jog_end']);
  sent = [];
  vi.advanceTimersByTime(600);
  expect(sent).toEqual([]);
  expect(hold.ended).toBe(true);
  expect(states.map(({ state, end }) => [state, end])).toEqual([
    ['moving', null],
    ['ended', 'taken_over'],
  ]);
});

test('ends when it cannot be sent', () => {
  const states: HoldState[] = [];
  const hold = jog.hold('M1', 'Vertical', 'max', (state) => states.push(state));
  up = false;
  vi.advanceTimersByTime(60);
  expect(hold.ended).toBe(true);
  expect(states).toMatchObject([{ state: 'ended', end: 'link' }]);
  up = true;
  vi.advanceTimersByTime(600);
  expect(types()).toEqual(['jog']);
});

test('does not begin without a link or on a hidden page', () => {
  allowed = false;
  const hold = jog.hold('M1', 'Vertical', 'max');
  expect(hold.ended).toBe(true);
  vi.advanceTimersByTime(600);
  expect(sent).toEqual([]);
});

test('one that cannot be sent at all leaves no heartbeats behind', () => {
  up = false;
  const hold = jog.hold('M1', 'Vertical', 'max');
  expect([hold.ended, jog.busy, vi.getTimerCount()]).toEqual([true, false, 0]);
  up = true;
  vi.advanceTimersByTime(600);
  expect(sent).toEqual([]);
});

test('endAll releases everything, or one monitor', () => {
  jog.hold('M1', 'Vertical', 'max');
  jog.hold('M2', 'Vertical', 'max');
  jog.endAll('left', 'M1');
  expect(jog.held('M1', 'Vertical')).toBeUndefined();
  expect(jog.held('M2', 'Vertical')).toBeDefined();
  jog.endAll();
  expect(types().filter((type) => type === 'jog_end')).toHaveLength(2);
  expect(vi.getTimerCount()).toBe(0);
});

test('the late end of a motion that was released does not end the next one', () => {
  const heard = { type: 'jog', monitor: 'M1', drive: 'Vertical', text: null } as const;
  jog.hold('M1', 'Vertical', 'max').end();
  const next = jog.hold('M1', 'Vertical', 'min');
  jog.heard({ ...heard, state: 'stopping', end: null });
  jog.heard({ ...heard, state: 'ended', end: 'stopped' });
  expect(next.ended).toBe(false);
  jog.heard({ ...heard, state: 'moving', end: null });
  jog.heard({ ...heard, state: 'stopping', end: null });
  expect(next.ended, 'now it is its own').toBe(true);
  const last = jog.hold('M1', 'Vertical', 'max');
  jog.heard({ ...heard, state: 'ended', end: 'refused' });
  expect(last.ended).toBe(true);
});
