// The site as a reader uses it: by the keyboard, by the search, from one language to the other, without scripts.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { ready, start } from './browser.mjs';

let site;
before(async () => {
  site = await start('/somewhere/below/');
});
after(() => site?.end());

/** Types into the search; the titles of what it finds. */
async function search(page, words) {
  await page.keyboard.press('/');
  await page.locator('.VPLocalSearchBox input').fill(words);
  await page.locator('.VPLocalSearchBox .result').first().waitFor();
  return page.locator('.VPLocalSearchBox .result').allInnerTexts();
}

test('a Russian word in any form is found, and Enter opens the page', async () => {
  const { page, seen, close } = await site.open('ru/index.html');
  const found = await search(page, 'лафетного ствола');
  assert.ok(
    found.some((title) => /лафетн|ствол/i.test(title)),
    found.join('\n'),
  );
  await page.keyboard.press('Enter');
  await page.waitForURL(`${site.url}ru/**`);
  await page.locator('.vp-doc h1').waitFor();
  assert.match(page.url(), /\.html/);
  for (const request of seen.requests) assert.ok(request.startsWith(site.url), request);
  assert.deepEqual(seen.errors, []);
  await close();
});

test('an English word is found; nothing is said of what is not there', async () => {
  const { page, close } = await site.open('cli/index.html');
  assert.ok((await search(page, 'held motion')).length > 0);
  await page.locator('.VPLocalSearchBox input').fill('xylophonist');
  await page.locator('.VPLocalSearchBox .no-results').waitFor();
  await page.keyboard.press('Escape');
  assert.equal(await page.locator('.VPLocalSearchBox').count(), 0);
  await close();
});

test('what a question asks for comes before its common words', async () => {
  const { page, close } = await site.open('ru/index.html');
  const [first] = await search(page, 'затвор не закрывается');
  assert.match(first, /затвор/i);
  await close();
});

test('a command is read to its end, on a phone as well', async () => {
  const { page, close } = await site.open('ru/install.html', { width: 390, height: 844 });
  const cut = await page.$$eval('.vp-doc .language-sh pre', (all) =>
    all.filter((one) => one.scrollWidth > one.clientWidth).map((one) => one.textContent),
  );
  assert.deepEqual(cut, []);
  await close();
});

test('the playground opens in the language of the page that leads to it', async () => {
  const { page, close } = await site.open('ru/index.html');
  // It need not be there for that: its address is all that counts.
  await page.evaluate(() => {
    const link = document.createElement('a');
    link.href = './playground/';
    link.addEventListener('click', (event) => event.preventDefault());
    document.body.append(link);
    link.click();
  });
  assert.equal(await page.evaluate(() => localStorage.getItem('lafet.lang')), 'ru');
  await close();
});

test('addresses stay right from page to page, whichever was opened first', async () => {
  const { page, seen, close } = await site.open('index.html');
  await page.locator('.vp-doc a', { hasText: 'Integrator' }).first().click();
  await page.locator('h1', { hasText: 'Integrator' }).waitFor();
  await page.locator('.VPSidebar a', { hasText: 'Reference' }).first().click();
  await page.locator('h1', { hasText: 'protocol' }).waitFor();
  await page.locator('.VPSidebar a', { hasText: 'HTTP API' }).first().click();
  await page.locator('h1', { hasText: 'HTTP API' }).waitFor();
  assert.equal(page.url(), `${site.url}api/`);
  // From a page in a folder, by the frame that came with a page outside of it.
  await page
    .locator('.VPSidebar a', { hasText: /^Parameters$/ })
    .first()
    .click();
  await page.locator('h1', { hasText: 'Parameters' }).waitFor();
  assert.match(page.url(), /\/somewhere\/below\/parameters\.html$/);
  assert.deepEqual(seen.errors, []);
  await close();
});

test('an anchor in Russian is reached', async () => {
  const anchor = 'удерживаемое-движение';
  const { page, close } = await site.open(`ru/client.html#${encodeURIComponent(anchor)}`);
  const top = () => page.locator(`[id="${anchor}"]`).evaluate((it) => it.getBoundingClientRect().top);
  assert.ok((await top()) < 300, `${await top()}`);
  await close();
});

test('the other language of a page is one step away, also where there is none', async () => {
  for (const [from, to] of [
    ['hub.html', 'ru/hub.html'],
    ['design.html', 'ru/design.html'],
    ['ru/cli/index.html', 'cli/'],
  ]) {
    const { page, close } = await site.open(from);
    await page.locator('.VPNavBarTranslations button').hover();
    await page.locator('.VPNavBarTranslations a').first().click();
    await page.waitForURL(`${site.url}${to}`);
    await ready(page);
    await page.locator(`html[lang=${to.startsWith('ru/') ? 'ru' : 'en'}]`).waitFor();
    assert.equal(await page.locator('.vp-doc h1').count(), 1);
    await close();
  }
});

test('everything can be reached with the keyboard', async () => {
  const { page, close } = await site.open('ru/hub-api.html', { width: 700, height: 800 });
  await page.keyboard.press('Tab');
  const focused = () => page.evaluate(() => document.activeElement.className + document.activeElement.textContent);
  assert.match(await focused(), /VPSkipLink|К содержанию/);
  const wide = await page
    .locator('.table')
    .evaluateAll((all) => all.map((box) => [box.scrollWidth > box.clientWidth, box.tabIndex]));
  for (const [scrolls, index] of wide) assert.equal(index, scrolls ? 0 : -1);
  const outline = await page.evaluate(() => {
    const link = document.querySelector('.vp-doc a[href]');
    link.focus({ focusVisible: true });
    return getComputedStyle(link).outlineStyle;
  });
  assert.notEqual(outline, 'none');
  await close();
});

test('without scripts the text, the pictures and the links are there', async () => {
  const { page, seen, close } = await site.open('ru/tutorial.html', { javaScriptEnabled: false });
  assert.ok(await page.getByText('Четверть часа с одним стволом').isVisible());
  await page.locator('.vp-doc a', { hasText: 'Пульт' }).first().click();
  await page.waitForURL(`${site.url}ru/console.html`);
  assert.ok(await page.locator('h1', { hasText: 'Пульт' }).isVisible());
  for (const request of seen.requests) assert.ok(request.startsWith(site.url), request);
  await close();
});
