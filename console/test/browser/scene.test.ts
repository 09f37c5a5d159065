// The 3D view: it draws, it is cheap, and without WebGL the plan is shown.
import type { Page } from 'playwright-core';
import { afterAll, afterEach, beforeAll, expect, test } from 'vitest';
import type { Monitor } from '../../src/hub/types';
import { Demo, WEBGL } from './demo';
import { go, LATE_MS, SOON, until } from './page';

interface SceneElement extends Element {
  figures: { calls: number; particles: number } | null;
}

const CALLS_MAX = 50;
let demo: Demo;
let page: Page;

beforeAll(async () => {
  demo = await Demo.start(WEBGL);
});
afterAll(() => demo?.stop());
afterEach(() => page.context().close());

const figures = () => page.locator('lf-scene').evaluate((scene) => (scene as unknown as SceneElement).figures);

test('draws the site with few calls, and stops when the page is left', async () => {
  page = await demo.open('#/m/M1/operate');
  const loaded: string[] = [];
  page.on('request', (request) => loaded.push(request.url()));
  await page.getByText('3D', { exact: true }).click();
  await until(async () => ((await figures())?.calls ?? 0) > 5, LATE_MS);
  // The fire of the demo: flames and smoke.
  await until(async () => ((await figures())?.particles ?? 0) > 20, LATE_MS);
  expect((await figures())!.calls).toBeLessThan(CALLS_MAX);
  // It is loaded only now.
  expect(loaded.some((url) => /world-.*\.js/.test(url))).toBe(true);
  const scene = await page.locator('lf-scene').elementHandle();
  await go(page, '#/overview');
  await until(() =>
    scene!.evaluate((element) => !element.isConnected && (element as unknown as SceneElement).figures === null),
  );
});

test('without WebGL the plan is shown', async () => {
  page = await demo.open('#/m/M1/operate');
  await page.evaluate(() => {
    HTMLCanvasElement.prototype.getContext = () => null;
  });
  const told = page.locator('lf-toasts').getByText('The 3D picture does not work in this browser').waitFor();
  await page.getByText('3D', { exact: true }).click();
  await told;
  await page.locator('lf-plan').waitFor();
  await expect.poll(() => page.locator('lf-scene').count(), SOON).toBe(0);
});

test('shows the water of a monitor without a valid pressure, and says what is not known', {
  timeout: 500_000,
}, async () => {
  const has = async (subsystem: 'Deployer' | 'Valve1', flag: string) =>
    (await demo.get<Monitor>('/api/monitors/M1')).status.subsystems[subsystem]!.flags.includes(flag);
  await demo.post('/api/sim/automatic', { on: false });
  await demo.request('M1', 'Deploy Deployer');
  await until(() => has('Deployer', 'Deployed'), 2 * LATE_MS);
  await demo.post('/api/sim/faults', { monitor: 'M1', fault: 'pressure-break', on: true });
  page = await demo.open('#/m/M1/operate');
  await page.getByText('3D', { exact: true }).click();
  await until(async () => ((await figures())?.calls ?? 0) > 5, LATE_MS);
  const jet = () => page.locator('lf-scene').evaluate((scene) => Reflect.get(scene, 'world').waters as string[]);
  expect(await jet()).toEqual([]);
  await demo.request('M1', 'Open Valve1');
  await until(() => has('Valve1', 'Open'), 2 * LATE_MS);
  await page.locator('lf-scene').getByText('M1: water flows; its path cannot be computed.').waitFor();
  await page.locator('lf-scene').getByText('Where the water lands is not known: no valid pressure').waitFor();
  await expect.poll(jet, SOON).toEqual(['M1']);
});
