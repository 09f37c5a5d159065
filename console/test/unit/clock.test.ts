import { expect, it } from 'vitest';
import { HubClock } from '../../src/hub/clock';

it('is never ahead of the hub, and as close as the quickest message was', () => {
  const clock = new HubClock();
  expect(clock.now(0)).toBeNull();
  // The hub runs 50,000 ms ahead; a message takes 400 ms, 20 ms, and 7 s.
  clock.heard(50_000, 400);
  expect(clock.now(400)).toBe(50_000);
  clock.heard(51_000, 1020);
  expect(clock.now(1020)).toBe(51_000);
  clock.heard(52_000, 9000);
  const at = clock.now(9000)!;
  expect(at).toBeLessThanOrEqual(59_000);
  expect(at).toBeGreaterThan(58_950);
});

it('does not run ahead when its own clock is the faster one', () => {
  const clock = new HubClock();
  clock.heard(0, 0);
  const hours = 10 * 3600_000;
  for (let now = 0; now <= hours; now += 60_000) clock.heard(now * 0.9999, now);
  expect(clock.now(hours)!).toBeLessThanOrEqual(Math.ceil(hours * 0.9999) + 12);
});

it('forgets a hub that was started again', () => {
  const clock = new HubClock();
  clock.heard(9_000_000, 100);
  clock.forget();
  clock.heard(30, 200);
  expect(clock.now(210)).toBe(40);
});

it('learns a hub again whose clock has stood still', () => {
  const clock = new HubClock();
  clock.heard(0, 0);
  // It is behind by 2.4 s from then on.
  for (let now = 1000; now <= 40_000; now += 1000) clock.heard(now - 2400, now);
  expect(clock.now(40_000)!).toBeLessThanOrEqual(40_000 - 2400);
  expect(clock.now(40_000)!).toBeGreaterThan(40_000 - 2450);
});
