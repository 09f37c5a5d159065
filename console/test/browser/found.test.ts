// A found fire spot on the page Operate: its distance, how it was computed, and that no command is
// sent with a distance that the operator has not seen.

import type { Page } from 'playwright-core';
import { afterAll, beforeAll, describe, expect, test } from 'vitest';
import { Demo } from './demo';
import { able, LATE_MS, passes, SOON, settled, take, until } from './page';

/** On the ground, 35 m from M1, which is 6 m high. */
const FIRE = [-12, 14];
const AWAY_M = 35;

interface Monitor {
  hotbeds: { list: unknown[] } | null;
  program: { request: string } | null;
  status: { subsystems: Record<string, { flags: string[] }> };
}

let demo: Demo;
const monitor = () => demo.get<Monitor>('/api/monitors/M1');

beforeAll(async () => {
  demo = await Demo.start();
  expect((await demo.post('/api/sim/fire', { at: FIRE, size: 3 })).ok).toBe(true);
  await demo.request('M1', 'StartSeek Detector -3000 3000 -900 600 analyse');
  await demo.post('/api/sim/speed', { speed: 20 });
  await until(async () => ((await monitor()).hotbeds?.list.length ?? 0) >= 2, 2 * LATE_MS);
  await until(async () => !(await monitor()).status.subsystems.Detector!.flags.includes('Searching'), 2 * LATE_MS);
  await demo.post('/api/sim/speed', { speed: 1 });
  await demo.post('/api/monitors/M1/authority', { action: 'release' });
}, 300_000);
afterAll(() => demo?.stop());

const distance = (page: Page) => page.locator('#distance').inputValue();
const why = (page: Page) => page.locator('#quench button').getAttribute('aria-description');

test('the name of a tank that burns is beside its flame, above the fire', async () => {
  const page = await demo.open('#/m/M1/operate');
  const name = page.locator('lf-plan .tank-name', { hasText: 'T-1' });
  await name.waitFor();
  await page.locator('lf-plan .flame').first().waitFor();
  await until(async () => (await page.locator('lf-plan :is(.flame, .fire-area)').count()) >= 2);
  await settled(page);
  const seen = await name.evaluate((text) => {
    const box = text.getBoundingClientRect();
    const all = [...(text.getRootNode() as ShadowRoot).querySelectorAll('.flame, .fire-area')];
    const later = all.filter((one) => text.compareDocumentPosition(one) & Node.DOCUMENT_POSITION_FOLLOWING);
    const covered = all.filter((one) => {
      const other = one.getBoundingClientRect();
      const apart =
        other.right < box.left || other.left > box.right || other.bottom < box.top + 2 || other.top > box.bottom;
      return one.classList.contains('flame') && !apart;
    });
    return { fires: all.length, later: later.length, covered: covered.length };
  });
  expect(seen).toEqual({ fires: seen.fires, later: 0, covered: 0 });
  expect(seen.fires).toBeGreaterThanOrEqual(2);
  await page.context().close();
});

describe('a found fire spot', () => {
  test('is extinguished at the distance that is shown, or that the operator enters', async () => {
    const page = await demo.open('#/m/M1/operate');
    await take(page);
    // The fire is shown on every page, also after it is acknowledged.
    const fire = page.locator('lf-topbar .fire');
    await fire.getByText('Fire · M1').waitFor();
    expect(await fire.getAttribute('class')).not.toContain('known');
    await demo.post('/api/alarms/ack', {});
    await until(async () => (await fire.getAttribute('class'))!.includes('known'));
    await able(page.locator('#draw')).click();
    await able(page.locator('#found')).click();

    // The brightest burns on a tank, whose place is on the plan.
    await page.locator('lf-found #how').getByText('T-1 is in that direction').waitFor();
    await expect.poll(() => distance(page), SOON).toBe('28');

    await able(page.locator('lf-found .which lf-button').nth(1)).click();
    const how = page.locator('lf-found #how').getByText('6.0 m above the ground');
    await how.waitFor();
    await expect.poll(async () => Math.abs(Number(await distance(page)) - AWAY_M), SOON).toBeLessThanOrEqual(2);
    const [, least, most] = /(\d+)\D+to (\d+)\D+$/.exec((await how.textContent())!.trim())!.map(Number);
    expect(least).toBeLessThan(AWAY_M);
    expect(most).toBeGreaterThan(AWAY_M);

    await page.fill('#distance', '200');
    await until(async () => (await why(page)) === 'Enter the distance first');
    await page.fill('#distance', '');
    await expect.poll(() => why(page), SOON).toBe('Enter the distance first');
    await page.locator('#quench').click();
    await page.locator('.lf-why', { hasText: 'Enter the distance first' }).waitFor();
    await passes(page, 500);
    expect((await monitor()).program).toBeNull();

    await page.fill('#distance', '33');
    await page.getByRole('button', { name: 'Extinguish at 33' }).click();
    await until(async () => (await monitor()).program?.request.includes('distance=33') === true);
    await until(async () => (await monitor()).status.subsystems.Control!.flags.includes('Quench'));
    await page.context().close();
  });
});
