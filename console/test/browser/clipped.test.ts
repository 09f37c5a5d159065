// Nothing that is read or pressed is cut off or covered: all pages, with scroll bars as a PC has them.
import type { Page } from 'playwright-core';
import { afterAll, beforeAll, expect, test } from 'vitest';
import type { Monitor } from '../../src/hub/types';
import { clipped } from './clipped';
import { Demo, PLAIN } from './demo';
import { able, go, pagesOf, placed, settled, takeButton, until } from './page';

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

test.each(VIEWS)('every page in $lang, $width × $height', async ({ lang, ...size }) => {
  const page = await demo.open('#/overview', lang, size);
  const all = await pagesOf(page);
  expect(all.length).toBeGreaterThan(9);
  const found: string[] = [];
  for (const href of all) {
    await go(page, href);
    await settled(page);
    for (const what of await clipped(page)) found.push(`${href} ${what}`);
  }
  expect(found).toEqual([]);
  await page.context().close();
});

/** The buttons of Operate lie within the column, and the column within the page. */
async function whole(page: Page, parts: string): Promise<void> {
  await settled(page);
  await placed(page.locator('lf-page-operate .side'));
  const all = page.locator(`lf-page-operate ${parts}`);
  await until(async () => (await all.count()) > 2);
  // All at one moment.
  const { column, boxes } = await all.evaluateAll((found) => {
    const box = (one: Element) => {
      const { x, y, width, height } = one.getBoundingClientRect();
      return { x, y, width, height, text: one.textContent };
    };
    let at: Node | null = found[0]!;
    while (at && !(at instanceof Element && at.classList.contains('side'))) {
      at = (at as Element).assignedSlot ?? at.parentNode ?? (at as ShadowRoot).host ?? null;
    }
    return { column: box(at as Element), boxes: found.map(box) };
  });
  const bottom = Math.min(column.y + column.height, page.viewportSize()!.height);
  expect(boxes.length).toBeGreaterThan(2);
  for (const box of boxes) {
    const told = JSON.stringify([box, { ...column, text: '' }]);
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
    await able(page.locator('lf-automatic #draw')).click();
    await page.locator('lf-automatic .sector').waitFor();
    await whole(page, 'lf-automatic .sector :is(lf-button, p)');
    await settled(page);
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
    const [card, main] = [await placed(guide), await placed(page.locator('main'))];
    expect(card.y).toBeGreaterThanOrEqual(main.y + main.height);
    expect(main.height).toBeGreaterThan(size.height * 0.3);
    for (const part of ['#stop', '#lockout']) {
      const box = await placed(page.locator(part));
      expect(box.y + box.height <= card.y || box.y >= card.y + card.height).toBe(true);
    }
    expect(await clipped(page)).toEqual([]);
    await page.locator(step === 0 ? '#guide-next' : '#guide-skip').click();
  }
  await page.context().close();
});
