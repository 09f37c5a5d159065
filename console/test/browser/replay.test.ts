// A recording plays on the same pages; nothing is sent except STOP, which reaches the live monitor.
import type { Locator, Page } from 'playwright-core';
import { afterAll, afterEach, beforeAll, beforeEach, expect, test } from 'vitest';
import type { Monitor } from '../../src/hub/types';
import { Demo, WEBGL } from './demo';
import { able, go, LATE_MS, pagesOf, passes, SOON, settled, until } from './page';

let demo: Demo;
let page: Page;

beforeAll(async () => {
  demo = await Demo.start(WEBGL);
  // Something to replay: the barrel turns for some seconds.
  await demo.request('M1', 'Deploy Deployer');
  await until(async () => (await flags('Deployer')).includes('Deployed'), LATE_MS);
  await demo.request('M1', 'Move Horizontal 1200');
  await until(async () => (await position()) === 1200, LATE_MS);
  // The history is written a little later.
  await until(async () => (await lastKept()) === 1200, LATE_MS);
}, 300_000);
afterAll(() => demo?.stop());
beforeEach(async () => {
  page = await demo.open('#/replay');
});
afterEach(() => page.context().close());

const status = async () => (await demo.get<Monitor>('/api/monitors/M1')).status.subsystems;
const flags = async (subsystem: string) => (await status())[subsystem]?.flags ?? [];
type Kept = { series: Record<string, [number, number][]> };
const lastKept = async () => {
  const now = Date.now();
  const asked = `monitor=M1&series=Horizontal.position&from_ms=${now - 120_000}&to_ms=${now}`;
  return (await demo.get<Kept>(`/api/history?${asked}`)).series['Horizontal.position']?.at(-1)?.[1];
};
const position = async () => (await status()).Horizontal?.position;

async function playHistory(): Promise<void> {
  // Until now: 15 minutes that started at a whole second end slightly earlier.
  await page.locator('lf-page-replay select').first().selectOption('60');
  await able(page.locator('#play-history')).click();
  await page.locator('lf-replay-bar #live').waitFor();
}

test('the history plays, is left for another page, and ends', async () => {
  await playHistory();
  await page.getByText('REPLAY of a recording').waitFor();
  const track = page.getByRole('slider', { name: 'Position in the recording' });
  await track.focus();
  await page.keyboard.press('End');
  await go(page, '#/m/M1/operate');
  // At the end: 20 degrees; at the start the barrel was stowed.
  const horizontal = page.locator('lf-value', { hasText: 'Traverse' }).first().locator('.value');
  await until(async () => (await horizontal.textContent())?.includes('20.0') === true);
  await expect.poll(() => page.locator('#take').count(), SOON).toBe(0);
  await page.locator('lf-replay-bar #live').click();
  await page.locator('lf-replay-bar section').waitFor({ state: 'detached' });
  await page.getByText('REPLAY of a recording').waitFor({ state: 'detached' });
});

test('no command leaves, STOP does', async () => {
  await playHistory();
  await go(page, '#/m/M1/operate');
  await page.locator('lf-joystick').waitFor();
  await page.getByText('STOP and LOCKOUT act on the live monitors').waitFor();
  // The live monitor moves while the recording plays.
  await demo.request('M1', 'Move Horizontal -10000');
  await until(async () => (await flags('Horizontal')).includes('Move'));
  await page.locator('lf-joystick').focus();
  await page.keyboard.press('ArrowLeft');
  await passes(page, 300);
  expect(await flags('Horizontal')).toContain('Move');
  await page.locator('#stop').click();
  await until(async () => !(await flags('Horizontal')).includes('Move'), 3000);
  // It would have come to its target some seconds later.
  expect(await position()).toBeGreaterThan(-9900);
});

/** Makes a recording; returns its button, which is enabled when it is done. */
async function record(seconds: number, before_s: number): Promise<Locator> {
  const answer = await demo.post('/api/recordings', { monitor: 'M1', seconds, before_s });
  const [made] = (await answer.json()) as { name: string }[];
  const play = page.getByRole('button', { name: `Play ${made!.name}` });
  const enabled = play.and(page.locator('button:not([aria-disabled=true])'));
  await enabled.waitFor();
  return enabled;
}

test('a recording is made, listed and played', async () => {
  const play = await record(1, 10);
  await play.click();
  await page.locator('lf-replay-bar #live').waitFor();
  await until(async () => (await page.locator('lf-plan .monitor').count()) > 0);
});

test('the fire of a recording is shown in the plan and in 3D', async () => {
  await demo.post('/api/sim/scenario', { id: 'tank-farm', automatic: true });
  await demo.post('/api/sim/fire', { at: [3, -4] });
  const play = await record(3, 0);
  // The live position is then a different one.
  await demo.post('/api/sim/scenario', { id: 'winter-start' });
  await play.click();
  await page.locator('lf-replay-bar #live').waitFor();
  const burning = page.locator('lf-plan .fire-area');
  await burning.first().waitFor();
  await go(page, '#/m/M1/operate');
  await burning.first().waitFor();
  await page.getByText('3D', { exact: true }).click();
  type Scene = { figures: { particles: number } | null };
  const particles = () => page.locator('lf-scene').evaluate((one) => (one as unknown as Scene).figures?.particles ?? 0);
  await until(async () => (await particles()) > 20, LATE_MS);
});

test('every page shows a recording', async () => {
  const play = await record(1, 10);
  const broken: string[] = [];
  page.on('pageerror', (error) => broken.push(error.message));
  await play.click();
  await page.locator('lf-replay-bar #live').waitFor();
  await go(page, '#/m/M1/operate');
  const pages = await pagesOf(page);
  expect(pages).toContain('#/m/M1/diagnosis');
  for (const href of pages) {
    await go(page, href);
    await settled(page);
  }
  await go(page, '#/m/M1/diagnosis');
  await page
    .locator('lf-link-stats')
    .getByText('A recording contains the state of the connection, not its figures.')
    .waitFor();
  expect(broken).toEqual([]);
});
