import { afterEach, beforeEach, expect, test, vi } from 'vitest';
import { Steady } from '../../src/parts/steady';

let told: string[];
let clock: Steady;

beforeEach(() => {
  vi.useFakeTimers();
  told = [];
  clock = new Steady();
});
afterEach(() => {
  clock.stop();
  vi.useRealTimers();
});

const start = () =>
  clock.start(
    1000,
    () => told.push('done'),
    () => told.push('stalled'),
  );

test('is over after its time, and not before', () => {
  start();
  vi.advanceTimersByTime(990);
  expect(told).toEqual([]);
  expect(Steady.busy).toBe(true);
  vi.advanceTimersByTime(20);
  expect(told).toEqual(['done']);
  expect(Steady.busy).toBe(false);
  expect(vi.getTimerCount()).toBe(0);
});

test('a page that has stalled does not know that it was held', () => {
  start();
  vi.advanceTimersByTime(800);
  // The timers of a stalled page are late: its clock is not.
  vi.setSystemTime(Date.now() + 400);
  const now = performance.now();
  vi.spyOn(performance, 'now').mockImplementation(() => now + 400);
  vi.advanceTimersByTime(50);
  expect(told).toEqual(['stalled']);
  vi.restoreAllMocks();
  vi.advanceTimersByTime(5000);
  expect(told).toEqual(['stalled']);
});

test('a release that waits in the queue at the end comes first', () => {
  start();
  vi.advanceTimersByTime(1000);
  expect(told).toEqual([]);
  clock.stop();
  vi.advanceTimersByTime(1000);
  expect(told).toEqual([]);
});
