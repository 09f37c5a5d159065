// Every page, in both languages and themes: no exception, no finding of axe (WCAG 2.2 AA), no
// horizontal overflow of text.
import { readFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { afterAll, beforeAll, expect, test } from 'vitest';
import { go, pagesOf, settled } from './page';
import { Site } from './site';

interface Violation {
  id: string;
  nodes: { target: unknown; failureSummary?: string }[];
}

const axe = readFileSync(createRequire(import.meta.url).resolve('axe-core/axe.min.js'), 'utf8');
const TAGS = ['wcag2a', 'wcag2aa', 'wcag21a', 'wcag21aa', 'wcag22aa'];

let site: Site;
beforeAll(async () => {
  site = await Site.start();
});
afterAll(() => site?.stop());

const VIEWS = [
  { lang: 'en', theme: 'day', size: { width: 1440, height: 900 } },
  { lang: 'ru', theme: 'night', size: { width: 1024, height: 768 } },
  { lang: 'ru', theme: 'day', size: { width: 390, height: 844 } },
];

for (const { lang, theme, size } of VIEWS) {
  test(`pages in ${lang}, ${theme}, ${size.width} × ${size.height}`, { timeout: 400_000 }, async () => {
    const page = await site.open('#/overview', lang, size);
    const thrown: string[] = [];
    page.on('pageerror', (error) => thrown.push(String(error)));
    await page.evaluate((to) => {
      document.documentElement.dataset.theme = to;
      localStorage.setItem('lafet.theme', to);
    }, theme);
    await page.evaluate(axe);
    const all = await pagesOf(page);
    expect(all.length).toBeGreaterThan(9);
    const found: string[] = [];
    for (const href of all) {
      await go(page, href);
      await settled(page);
      const violations = await page.evaluate(
        (tags) =>
          (globalThis as unknown as { axe: { run: (o: object) => Promise<{ violations: Violation[] }> } }).axe
            .run({ runOnly: tags })
            .then((result) => result.violations),
        TAGS,
      );
      for (const { id, nodes } of violations) {
        found.push(`${href} ${id}: ${nodes.map((n) => `${JSON.stringify(n.target)} ${n.failureSummary}`).join('; ')}`);
      }
      const wide = await page.evaluate(() => document.documentElement.scrollWidth - innerWidth);
      if (wide > 0) found.push(`${href} is ${wide} px too wide`);
    }
    expect(found).toEqual([]);
    expect(thrown).toEqual([]);
    await page.context().close();
  });
}
