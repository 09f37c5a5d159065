// The landing area on the plan: the figures of the hub, only while water flows, and what is not known is said.
import type { Page } from 'playwright-core';
import { afterAll, afterEach, beforeAll, expect, test } from 'vitest';
import type { Jet } from '../../src/hub/jets';
import type { Monitor } from '../../src/hub/types';
import { Demo } from './demo';
import { LATE_MS, SOON, settled, until } from './page';

let demo: Demo;
let page: Page;

beforeAll(async () => {
  demo = await Demo.start();
  await demo.post('/api/sim/automatic', { on: false });
});
afterAll(() => demo?.stop());
afterEach(() => page?.context().close());

const SIZE = { width: 1440, height: 900 };
const general = async () => (await demo.get<Monitor>('/api/monitors/M1')).status.subsystems.General!;
const legend = () => page.locator('lf-plan .landing-legend');
const fault = (on: boolean) => demo.post('/api/sim/faults', { monitor: 'M1', fault: 'pressure-break', on });

test('shows where the water is expected, and says what is not known', { timeout: 500_000 }, async () => {
  page = await demo.open('#/m/M1/operate', 'en', SIZE);
  // What the hub has answered, as the legend has it.
  const answers = new Set<string>();
  page.on('response', async (response) => {
    if (!response.url().endsWith('/api/jets')) return;
    for (const { throw: thrown } of (await response.json().catch(() => [])) as Jet[]) {
      if (!thrown?.wind) continue;
      answers.add(`${Math.floor(thrown.middle_m.low)}–${Math.ceil(thrown.greatest_m.high)}`);
    }
  });
  await page.locator('lf-plan').waitFor();
  await demo.request('M1', 'Deploy Deployer');
  await until(
    async () => (await demo.get<Monitor>('/api/monitors/M1')).status.subsystems.Deployer!.flags.includes('Deployed'),
    2 * LATE_MS,
  );
  await demo.request('M1', 'Move Vertical 1200');
  await until(async () =>
    (await demo.get<Monitor>('/api/monitors/M1')).status.subsystems.Vertical!.flags.includes('Move'),
  );
  await settled(page);
  expect(await legend().count()).toBe(0);
  await demo.request('M1', 'Open Valve1');
  await until(async () => {
    const { pressure, flowrate } = (await general()) as unknown as { pressure: number; flowrate: number };
    return pressure > 60 && flowrate > 10;
  }, 2 * LATE_MS);
  await until(
    async () => (await demo.get<Monitor>('/api/monitors/M1')).status.subsystems.Vertical!.position === 1200,
    2 * LATE_MS,
  );
  await until(async () => {
    const [, span] = /Water lands at (\d+–\d+)\sm/.exec((await legend().textContent()) ?? '') ?? [];
    return span !== undefined && answers.has(span);
  }, 2 * LATE_MS);
  await page.locator('lf-plan .landing-legend').getByText('with the wind').waitFor();
  await expect.poll(() => page.locator('lf-plan .landing-area .area').count(), SOON).toBe(1);

  await fault(true);
  await legend().getByText('Where the water lands is not known: no valid pressure').waitFor();
  await expect.poll(() => page.locator('lf-plan .landing-area').count(), SOON).toBe(0);
  await fault(false);
  await legend().getByText('Water lands at').waitFor();
  await page.context().close();

  page = await demo.open('#/m/M1/operate', 'ru', { width: 390, height: 844 });
  await legend()
    .getByText(/Вода падает на \d+–\d+\sм/)
    .waitFor();
  await demo.request('M1', 'Close Valve1');
  await until(async () => (await legend().count()) === 0, 2 * LATE_MS);
});
