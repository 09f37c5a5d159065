// Every kind of page, in both languages, light and dark: nothing for axe to find, nothing wider than a narrow screen,
// no request that leaves the site, no error.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { after, before, test } from 'node:test';
import { start } from './browser.mjs';

const AXE = readFileSync(createRequire(import.meta.url).resolve('axe-core/axe.min.js'), 'utf8');
/** First pages, start pages, prose, tables, code, pictures, references, English only, no such page. */
const KINDS = [
  'index.html',
  'ru/index.html',
  'operator.html',
  'ru/operator.html',
  'tutorial.html',
  'ru/tutorial.html',
  'console.html',
  'ru/protocol.html',
  'ru/client.html',
  'cli/index.html',
  'ru/cli/param.html',
  'api/index.html',
  'api/monitors.html',
  'json-schema.html',
  'ru/parameters.html',
  'ru/performance.html',
  'no-such-page.html',
];
/** Tables of a thousand rows and names without blanks, besides. */
const WIDE = [...KINDS, 'sections.html', 'api/structures.html', 'ru/faults.html'];

let site;
before(async () => {
  site = await start('/docs/of/lafet/');
});
after(() => site?.end());

/** What axe finds, in words. */
async function findings(page) {
  await page.evaluate(AXE);
  const found = await page.evaluate(() => globalThis.axe.run(document, { resultTypes: ['violations'] }));
  return found.violations.map(({ id, nodes }) => `${id}: ${nodes.map((node) => node.html.slice(0, 120)).join(' ')}`);
}

test('axe finds nothing in the search, nor in the menus of a narrow screen', async () => {
  for (const [name, words] of [
    ['index.html', 'monitor'],
    ['ru/index.html', 'ствол'],
  ]) {
    const { page, close } = await site.open(name, { dark: name.startsWith('ru/') });
    await page.keyboard.press('/');
    await page.locator('.VPLocalSearchBox input').fill(words);
    await page.locator('.VPLocalSearchBox .result').first().waitFor();
    assert.deepEqual(await findings(page), []);
    await close();
  }
  const { page, close } = await site.open('ru/console.html', { width: 360, height: 740 });
  await page.locator('.VPNavBarHamburger').click();
  await page.locator('.VPNavScreen').waitFor();
  assert.deepEqual(await findings(page), []);
  await close();
});

for (const name of KINDS) {
  test(`axe finds nothing: ${name}`, async () => {
    for (const dark of [false, true]) {
      const { page, seen, close } = await site.open(name, { dark });
      assert.deepEqual(await findings(page), [], dark ? 'dark' : 'light');
      for (const request of seen.requests)
        assert.ok(request.startsWith(site.url) || request.startsWith('data:'), request);
      if (name !== 'no-such-page.html') assert.deepEqual(seen.errors, []);
      await close();
    }
  });
}

test('nothing is wider than a narrow screen', async () => {
  for (const name of WIDE) {
    const { page, close } = await site.open(name, { width: 360, height: 740 });
    const [wide, screen] = await page.evaluate(() => [document.documentElement.scrollWidth, innerWidth]);
    assert.ok(wide <= screen, `${name}: ${wide} > ${screen}`);
    await close();
  }
});

test('the first page is one screen', async () => {
  for (const name of ['index.html', 'ru/index.html']) {
    const { page, close } = await site.open(name);
    const bottom = await page.locator('.vp-doc ul').evaluate((list) => list.getBoundingClientRect().bottom);
    assert.ok(bottom <= 850, `${name}: ${bottom}`);
    const [width, height] = await page.locator('.vp-doc img').evaluate((it) => [it.naturalWidth, it.clientHeight]);
    assert.ok(width > 0 && height > 200, 'the picture is there');
    await close();
  }
});

test('on paper: the page alone, in black, with the addresses of other servers', async () => {
  const { page, close } = await site.open('hub-api.html', { dark: true });
  await page.emulateMedia({ media: 'print' });
  for (const gone of ['.VPNav', '.VPSidebar', '.aside', '.VPDocFooter']) {
    assert.equal(await page.locator(gone).first().isVisible(), false, gone);
  }
  const shown = await page.evaluate(() => {
    const style = (of, pseudo) => getComputedStyle(document.querySelector(of), pseudo);
    return {
      text: style('.vp-doc p').color,
      code: style('.vp-doc pre').whiteSpace,
      address: style(".vp-doc a[href^='http']", '::after').content,
      display: style(".vp-doc a[href^='http']", '::after').display,
    };
  });
  assert.equal(shown.text, 'rgb(0, 0, 0)');
  assert.equal(shown.code, 'pre-wrap');
  assert.match(shown.address, /https:/);
  assert.equal(shown.display, 'inline');
  // A4 without its margins.
  await page.setViewportSize({ width: 672, height: 985 });
  const wide = await page.locator('.vp-doc').evaluate((it) => [it.scrollWidth, it.clientWidth]);
  assert.ok(wide[0] <= wide[1] + 1, `${wide}`);
  const pdf = await page.pdf({ preferCSSPageSize: true });
  assert.ok(pdf.length > 20_000 && pdf.subarray(0, 5).toString() === '%PDF-');
  await close();
});
