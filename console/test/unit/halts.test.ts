import { afterEach, beforeEach, expect, test } from 'vitest';
import { concerns, type Halt, onHalt } from '../../src/hub/halt';
import { followHalts } from '../../src/hub/halts';
import { Store } from '../../src/hub/store';

let heard: Halt[];
let end: () => void;
let store: Store;

beforeEach(() => {
  heard = [];
  end = onHalt((halt) => heard.push(halt));
  store = new Store();
  followHalts(store);
});
afterEach(() => end());

const counts = (stop: number, close: number, lockout: number) => ({ stop, close, lockout });
const urgent = (value: object, monitor = 'M1') =>
  store.apply({ now_ms: 0, set: { [`monitors/${monitor}/urgent`]: value } });

test('an order of another client is one event of its monitor', () => {
  urgent(counts(3, 1, 0));
  urgent(counts(0, 0, 0), 'M2');
  expect(heard, 'what was before is over').toEqual([]);
  urgent(counts(4, 1, 0));
  urgent(counts(0, 0, 1), 'M2');
  urgent(counts(9, 2, 0));
  expect(heard).toEqual([
    { kind: 'stop', monitor: 'M1', own: false },
    { kind: 'lockout', monitor: 'M2', own: false },
    { kind: 'stop', monitor: 'M1', own: false },
    { kind: 'close', monitor: 'M1', own: false },
  ]);
});

test('a hub that was started again counts from zero', () => {
  urgent(counts(5, 5, 5));
  store.replace({ now_ms: 0, set: {} });
  urgent(counts(1, 0, 0));
  urgent(counts(1, 0, 0));
  expect(heard).toEqual([]);
  urgent(counts(2, 0, 0));
  expect(heard).toHaveLength(1);
});

test('orders of others to other monitors end nothing that is held for this one', () => {
  const other = (monitor: string | null): Halt => ({ kind: 'stop', monitor, own: false });
  expect(concerns(other('M1'), 'M1')).toBe(true);
  expect(concerns(other('M2'), 'M1')).toBe(false);
  expect(concerns(other(null), 'M1')).toBe(true);
  expect(concerns(other('M2'), ''), 'it is not known for which it is held').toBe(true);
  expect(concerns({ kind: 'stop', monitor: 'M2', own: true }, 'M1')).toBe(true);
});
