// The size for a wall: everything is larger, nothing leaves the screen, and presses still hit their targets.
import type { Page } from 'playwright-core';
import { afterAll, afterEach, beforeAll, expect, test } from 'vitest';
import type { Monitor } from '../../src/hub/types';
import { Demo } from './demo';
import { able, go, heldUntil, LATE_MS, middle, pagesOf, placed, SOON, settled, take, until } from './page';

const WALL = { width: 2560, height: 1440 };
let demo: Demo;
let page: Page;

beforeAll(async () => {
  demo = await Demo.start();
});
afterAll(() => demo?.stop());
afterEach(() => page.context().close());

const zoom = () => page.evaluate(() => Number(getComputedStyle(document.documentElement).getPropertyValue('--zoom')));

test('every page fits, and values are readable from a distance', async () => {
  page = await demo.open('#/overview', 'ru', WALL, 'wall');
  await page.locator('lf-page-overview lf-value').first().waitFor();
  await expect.poll(zoom, SOON).toBeGreaterThan(1.8);
  const high = (await placed(page.locator('lf-page-overview lf-value .value').first())).height;
  // On a screen of 55 inches a pixel is half a millimetre: figures of 20 mm.
  expect(high).toBeGreaterThan(56);
  for (const href of await pagesOf(page)) {
    await go(page, href);
    await settled(page);
    const main = page.locator('main');
    expect(await main.evaluate((one) => one.scrollWidth - one.clientWidth), href).toBeLessThanOrEqual(0);
    const stop = await placed(page.locator('#lockout'));
    expect(stop.x + stop.width, href).toBeLessThanOrEqual(WALL.width);
    const box = await placed(main);
    expect(box.y + box.height, href).toBeLessThanOrEqual(WALL.height + 1);
  }
});

test('is chosen in the settings, and stored', async () => {
  page = await demo.open('#/overview', 'en', { width: 1920, height: 1080 });
  expect(await zoom()).toBe(1);
  await page.locator('lf-topbar button').last().click();
  await page.locator('lf-dialogs').getByText('Wall', { exact: true }).click();
  await until(async () => (await zoom()) > 1.3);
  expect(await page.evaluate(() => localStorage.getItem('lafet.display'))).toBe('wall');
});

test('a press on the plan hits the visible place, a pulled stick moves the barrel', async () => {
  page = await demo.open('#/training', 'en', WALL, 'wall');
  await able(page.locator('lf-button', { hasText: 'Place a fire on the plan' })).click();
  await settled(page);
  const plan = await placed(page.locator('lf-plan'));
  const at = { x: plan.x + plan.width / 3, y: plan.y + plan.height * 0.8 };
  await page.mouse.click(at.x, at.y);
  const flames = page.locator('lf-plan .flame');
  const near = async () => {
    const boxes = await flames.evaluateAll((all) => all.map((one) => one.getBoundingClientRect().toJSON() as DOMRect));
    return Math.min(...boxes.map((box) => Math.hypot(box.x + box.width / 2 - at.x, box.y + box.height / 2 - at.y)));
  };
  await until(async () => (await near()) < 12 * (await zoom()));

  await go(page, '#/m/M1/operate');
  await take(page);
  await able(page.locator('#deploy')).click();
  const states = async () => (await demo.get<Monitor>('/api/monitors/M1')).status.subsystems;
  await until(async () => (await states()).Deployer!.flags.includes('Deployed'), LATE_MS);
  const moved = async () => ((await states()).Horizontal!.position as number) > 30;
  const pull = async () => {
    const [x, y] = await middle(page.locator('lf-joystick .base'));
    await page.mouse.move(x, y);
    await page.mouse.down();
    await page.mouse.move(x - 60 * (await zoom()), y, { steps: 3 });
  };
  await heldUntil(page, moved, pull, () => page.mouse.up());
  expect((await states()).Vertical!.position, 'to the left, and only there').toBe(0);
  await page.mouse.up();
});
