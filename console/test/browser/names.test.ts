// A monitor with a long id and a long name: STOP and the name of the page stay readable.
import type { Locator, Page } from 'playwright-core';
import { afterAll, afterEach, beforeAll, expect, test } from 'vitest';
import { Guarded } from './guarded';
import { go, placed, settled } from './page';
import { Site } from './site';

const SEEN = ['en', 'ru'].flatMap((lang) =>
  [
    { width: 390, height: 844 },
    { width: 1024, height: 768 },
    { width: 1440, height: 900 },
  ].map((size) => ({ lang, ...size })),
);

let site: Site;
let guarded: Guarded;
let page: Page;

beforeAll(async () => {
  [site, guarded] = await Promise.all([Site.start(), Guarded.start()]);
});
afterAll(async () => {
  await site?.stop();
  await guarded?.stop();
});
afterEach(() => page.context().close());

/** Whether its whole content is visible. */
const whole = (part: Locator): Promise<boolean> => part.evaluate((it) => it.scrollWidth <= it.clientWidth);

async function apart(one: Locator, other: Locator): Promise<void> {
  const [a, b] = [await placed(one), await placed(other)];
  expect(a.x + a.width).toBeLessThanOrEqual(b.x);
}

test.each(SEEN)(
  'STOP, the page and the cards say which monitor: $lang, $width × $height',
  async ({ lang, ...size }) => {
    page = await site.open('#/overview', lang, size);
    await guarded.enter(page, 'olga');
    await go(page, `#/m/${guarded.long}/operate`);
    const stop = page.locator('#stop');
    await stop.getByText('…terrace1').waitFor();
    await settled(page);
    expect(await whole(stop.locator('span'))).toBe(true);
    expect(await whole(stop.locator('small'))).toBe(true);
    await apart(stop, page.locator('#stop-all'));
    await apart(page.locator('#stop-all'), page.locator('#lockout'));
    const name = lang === 'ru' ? 'Управление' : 'Operate';
    expect(await whole(page.locator('lf-topbar .where span:visible', { hasText: name }))).toBe(true);

    await go(page, '#/overview');
    const cards = page.locator('lf-page-overview .one');
    await cards.nth(1).waitFor();
    await settled(page);
    // All at one moment.
    const found = await cards.evaluateAll((all) =>
      all.map((card) => ({
        inside: card.getBoundingClientRect().toJSON() as DOMRect,
        parts: [...card.querySelectorAll('h2 b, lf-chip, lf-value')].map((part) => {
          return part.getBoundingClientRect().toJSON() as DOMRect;
        }),
      })),
    );
    expect(found.length).toBeGreaterThanOrEqual(2);
    for (const { inside, parts } of found) {
      expect(parts.length).toBeGreaterThan(0);
      for (const box of parts) {
        expect(box.right).toBeLessThanOrEqual(inside.right);
        expect(box.x).toBeGreaterThanOrEqual(inside.x);
      }
    }
    expect(await page.evaluate(() => document.scrollingElement!.scrollWidth)).toBe(size.width);
  },
);
