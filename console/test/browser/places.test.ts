// Monitors whose place is not configured: beside the plan of the others, and alone on a plan of their own.
import type { Page } from 'playwright-core';
import { afterAll, afterEach, beforeAll, expect, test } from 'vitest';
import { SOON, shown } from './page';
import { Site } from './site';

/** M1 and M2 have no place; another one, which does not answer, and a tank have one. */
const PLACED = `
[[monitor]]
id = "M9"
url = "tcp://127.0.0.1:9?addr=9"
at = [0, 0]
[[tank]]
name = "T-1"
at = [20, 20]
diameter = 10
height = 8
`;
let site: Site;
let page: Page;

beforeAll(async () => {
  site = await Site.start(PLACED);
});
afterAll(() => site?.stop());
afterEach(() => page?.context().close());

const onPlan = () =>
  page.locator('lf-plan .monitor').evaluateAll((all) => all.map((one) => one.getAttribute('data-id')));
const beside = () => page.locator('lf-plan .unplaced button').allTextContents();

test('a monitor without a place is named beside the plan, and alone where it is operated', async () => {
  page = await site.open('#/overview');
  await expect.poll(onPlan, SOON).toEqual(['M9']);
  expect(await beside()).toEqual(['M1', 'M2']);
  await page.locator('lf-plan .scale').waitFor();
  await page.locator('lf-plan .unplaced').getByText('M1', { exact: true }).click();
  await shown(page);
  expect(page.url()).toContain('#/m/M1/operate');
  await page.locator('lf-plan').getByText('The place of M1 is not configured: it is shown alone.').waitFor();
  expect([await onPlan(), await beside()]).toEqual([['M1'], ['M2']]);
  expect(await page.locator('lf-plan :is(.scale, .compass, .tank)').count(), 'nothing is to scale').toBe(0);
});
