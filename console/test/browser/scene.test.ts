// The 3D view: it draws, it is cheap, and without WebGL the plan is shown.
import type { Page } from 'playwright-core';
import { afterAll, afterEach, beforeAll, expect, test } from 'vitest';
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
