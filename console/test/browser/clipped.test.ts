// Nothing that is read or pressed is cut off or covered: all pages, with scroll bars as a PC has them.
import type { Page } from 'playwright-core';
import { afterAll, beforeAll, expect, test } from 'vitest';
import type { Monitor } from '../../src/hub/types';
import { clipped } from './clipped';
import { Demo, PLAIN } from './demo';
import { takeButton, until } from './site';

const VIEWS = ['en', 'ru'].flatMap((lang) =>
  [
    { width: 1440, height: 900 },
    { width: 1024, height: 768 },
    { width: 390, height: 844 },
  ].map((size) => ({ lang, ...size })),
);

let demo: Demo;
beforeAll(async () => {
  demo = await Demo.start(PLAIN, ['--hide-scrollbars']);
});
afterAll(() => demo?.stop());

async function settled(page: Page): Promise<void> {
  await until(() => page.evaluate(() => document.querySelector('lf-app')!.shadowRoot!.querySelector('.boot') === null));
  await page.waitForTimeout(500);
}

test.each(VIEWS)('every page in $lang, $width × $height', async ({ lang, ...size }) => {
  const page = await demo.open('#/overview', lang, size);
  await page.locator('lf-page-overview').waitFor();
  await page.locator('lf-nav a').nth(8).waitFor({ state: 'attached' });
  const all = await page.locator('lf-nav a').evaluateAll((links) => links.map((link) => link.getAttribute('href')!));
  expect(all.length).toBeGreaterThan(9);
  const found: string[] = [];
  for (const href of all) {
    await page.evaluate((to) => (location.hash = to), href);
    await page.locator(`lf-page-${href.split('/').at(-1)}`).waitFor();
    await settled(page);
    for (const what of await clipped(page)) found.push(`${href} ${what}`);
  }
  expect(found).toEqual([]);
  await page.context().close();
});

/** The buttons of Operate lie within the column, and the column within the page. */
async function whole(page: Page, parts: string): Promise<void> {
  const column = (await page.locator('lf-page-operate .side').boundingBox())!;
  const bottom = Math.min(column.y + column.height, page.viewportSize()!.height);
  const all = page.locator(`lf-page-operate ${parts}`);
  expect(await all.count()).toBeGreaterThan(2);
  for (const part of await all.all()) {
    const box = (await part.boundingBox())!;
    const told = `${await part.textContent()} ${JSON.stringify([box, column])}`;
    expect(box.y, told).toBeGreaterThanOrEqual(column.y);
    expect(box.y + box.height, told).toBeLessThanOrEqual(bottom);
    expect(box.x + box.width, told).toBeLessThanOrEqual(column.x + column.width);
  }
}

test.each(VIEWS.filter(({ width }) => width > 1000))(
  'Operate shows all its tiles beside the first steps in $lang, $width × $height',
  async ({ lang, ...size }) => {
    const page = await demo.open('#/m/M1/operate', lang, size, 'normal', 'wanted');
    await page.locator('lf-automatic #draw').waitFor();
    const next = page.locator('#guide-skip, #guide-next').first();
    for (let more = true; more; ) {
      await settled(page);
      await whole(page, 'lf-automatic .tiles > lf-button');
      more = (await next.count()) > 0;
      if (more) await next.click();
    }
    await page.context().close();
  },
);

test.each(VIEWS.filter(({ width }) => width > 1000))(
  'Operate shows all its tiles in $lang, $width × $height',
  async ({ lang, ...size }) => {
    await until(async () => (await demo.get<Monitor>('/api/monitors/M1')).authority.state === 'free');
    const page = await demo.open('#/m/M1/operate', lang, size);
    await page.locator('lf-automatic #draw').waitFor();
    await whole(page, 'lf-automatic .tiles > lf-button');
    await takeButton(page).click();
    await page.locator('lf-automatic #draw button:not([aria-disabled])').click();
    await page.locator('lf-automatic .sector').waitFor();
    await whole(page, 'lf-automatic .sector :is(lf-button, p)');
    expect(await clipped(page)).toEqual([]);
    await page.context().close();
  },
);

test.each(VIEWS)('the first steps cover nothing in $lang, $width × $height', async ({ lang, ...size }) => {
  const page = await demo.open('#/m/M1/operate', lang, size, 'normal', 'wanted');
  const guide = page.locator('lf-guide .card');
  await guide.waitFor();
  for (let step = 0; step < 3; step += 1) {
    await settled(page);
    const [card, main] = [(await guide.boundingBox())!, (await page.locator('main').boundingBox())!];
    expect(card.y).toBeGreaterThanOrEqual(main.y + main.height);
    expect(main.height).toBeGreaterThan(size.height * 0.3);
    for (const part of ['#stop', '#lockout']) {
      const box = (await page.locator(part).boundingBox())!;
      expect(box.y + box.height <= card.y || box.y >= card.y + card.height).toBe(true);
    }
    expect(await clipped(page)).toEqual([]);
    await page.locator(step === 0 ? '#guide-next' : '#guide-skip').click();
  }
  await page.context().close();
});
