import { afterEach, beforeEach, expect, test, vi } from 'vitest';
import { HeldKeys } from '../../src/parts/held-keys';

let seen: string[][];
let keys: HeldKeys;
let page: EventTarget;

beforeEach(() => {
  vi.useFakeTimers();
  page = new EventTarget();
  vi.stubGlobal('window', page);
  seen = [];
  keys = new HeldKeys(() => seen.push(keys.values()));
});
afterEach(() => {
  keys.clear();
  vi.useRealTimers();
  vi.unstubAllGlobals();
});

/** What the window hears of a key, or of another event. */
function hears(type: string, code = '', more: Partial<KeyboardEvent> = {}): void {
  page.dispatchEvent(Object.assign(new Event(type), { code, key: code, repeat: false, metaKey: false, ...more }));
}

const event = (code: string, key: string, more = {}) =>
  ({ type: 'keydown', code, key, repeat: false, metaKey: false, ...more }) as const;

test('a release counts by the place of the key: with NumLock its name changes', () => {
  keys.press(event('Numpad8', 'ArrowUp'), 'ArrowUp');
  hears('keyup', 'Numpad8', { key: '8' });
  expect(seen).toEqual([['ArrowUp'], []]);
});

test.each([
  ['contextmenu', '', {}],
  ['keydown', 'MetaLeft', { key: 'Meta', metaKey: true }],
  ['keydown', 'AltLeft', { key: 'Alt' }],
  ['keydown', 'NumLock', { key: 'NumLock' }],
  ['keydown', 'ContextMenu', { key: 'ContextMenu' }],
  ['pointermove', '', { metaKey: true }],
])('%s %s takes the release away: nothing is held', (type, code, more) => {
  keys.press(event('ArrowRight', 'ArrowRight'));
  hears(type, code, more as Partial<KeyboardEvent>);
  expect(keys.size).toBe(0);
  keys.press(event('ArrowRight', 'ArrowRight', { repeat: true }));
  expect(keys.size, 'a key that repeats was pressed before').toBe(0);
});

test('nothing is held for ever without a sign of the key', () => {
  keys.press(event('ArrowUp', 'ArrowUp'));
  vi.advanceTimersByTime(29_000);
  expect(keys.size).toBe(1);
  vi.advanceTimersByTime(1500);
  expect(keys.size).toBe(0);
  expect(vi.getTimerCount()).toBe(0);
});

test('a key that has repeated and repeats no more was released', () => {
  keys.press(event('ArrowUp', 'ArrowUp'));
  for (let n = 0; n < 100; n += 1) {
    vi.advanceTimersByTime(400);
    hears('keydown', 'ArrowUp', { repeat: true });
  }
  expect(keys.size).toBe(1);
  vi.advanceTimersByTime(1800);
  expect(keys.size).toBe(0);
});

test('the release of another key ends the repetition, not the hold', () => {
  keys.press(event('ArrowUp', 'ArrowUp'));
  keys.press(event('ArrowRight', 'ArrowRight'));
  hears('keydown', 'ArrowRight', { repeat: true });
  hears('keyup', 'ArrowRight');
  vi.advanceTimersByTime(5000);
  expect(keys.values()).toEqual(['ArrowUp']);
});
