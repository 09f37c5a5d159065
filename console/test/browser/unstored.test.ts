// Commissioning of a monitor whose memory cannot be written: nothing of it counts.
import type { Page } from 'playwright-core';
import { afterAll, afterEach, beforeAll, expect, test } from 'vitest';
import { able, holdUntil, passTo, until } from './page';
import { Site } from './site';

let site: Site;
let page: Page;

beforeAll(async () => {
  site = await Site.start('', ['flash-write']);
});
afterAll(() => site?.stop());
afterEach(() => page?.context().close());

test('a zero point that is not stored is not taken, and cannot be confirmed', async () => {
  page = await site.open('#/m/M1/commissioning');
  await passTo(page, 'zero');
  // Where zero is not yet: the same value would not be written.
  await site.send('M1', 'Move Horizontal 300');
  await until(async () => (await site.position('M1')) > 200 && (await site.stands('M1')));
  const box = page.locator('lf-step-zero .box').first();
  const unstored = box.getByText('The monitor has not stored this zero point', { exact: false });
  await able(box.locator('lf-hold')).waitFor();
  await holdUntil(page, box.locator('lf-hold'), () => unstored.isVisible());
  await page.getByText('Horizontal.ZeroPoint was not stored', { exact: false }).waitFor();
  const keep = box.locator('lf-button', { hasText: 'Zero is right already' });
  await keep.locator('button[aria-disabled=true]').waitFor();
  expect(await box.getByText('Taken: the monitor now reads zero here.').count()).toBe(0);
  await page.locator('lf-step-zero').getByText('2 still to be set or confirmed').waitFor();
});
