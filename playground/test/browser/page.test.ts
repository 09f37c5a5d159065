// The page in Chromium, served below a sub-path by a server that does not know what WebAssembly is.

import { readFile } from 'node:fs/promises';
import { createRequire } from 'node:module';
import { type Browser, type BrowserContext, chromium, type Locator, type Page } from 'playwright-core';
import { afterAll, afterEach, beforeAll, expect, test } from 'vitest';
import type { Description, View } from '../../src/wire';
import { engine } from '../module';
import { type Served, served } from '../served';

const SOON = { timeout: 60_000, interval: 50 };

let browser: Browser;
let files: Served;
let context: BrowserContext | null = null;
let requests: string[] = [];
let errors: string[] = [];

beforeAll(async () => {
  browser = await chromium.launch({ executablePath: '/usr/bin/chromium', args: ['--no-sandbox'] });
  files = await served();
});
afterAll(async () => {
  await browser?.close();
  await files?.end();
});
afterEach(async () => {
  await context?.close();
  context = null;
});

interface How {
  locale?: string;
  width?: number;
  dark?: boolean;
  fragment?: string;
  from?: Served;
}

async function open({
  locale = 'en-GB',
  width = 1440,
  dark = false,
  fragment = '',
  from = files,
}: How = {}): Promise<Page> {
  await context?.close();
  context = await browser.newContext({
    locale,
    viewport: { width, height: 1000 },
    colorScheme: dark ? 'dark' : 'light',
  });
  const page = await context.newPage();
  requests = [];
  errors = [];
  page.on('request', (request) => requests.push(request.url()));
  page.on('pageerror', (error) => errors.push(String(error)));
  page.on('console', (message) => message.type() === 'error' && errors.push(message.text()));
  await page.goto(from.url + (fragment && `#${fragment}`));
  await page.locator('pg-scene svg, [role=alert]').first().waitFor();
  return page;
}

const said = async (what: Locator): Promise<string> => (await what.textContent()) ?? '';
const log = (page: Page) => page.locator('.log button');
const seconds = async (page: Page): Promise<number> => Number.parseFloat(await said(page.locator('.now')));

/** What the shared session of the address leads to, outside the browser. */
async function outcome(fragment: string): Promise<View> {
  const here = await engine();
  let view = here.call<View>({ op: 'open', fragment });
  while (view.replay_ms !== null) view = here.call<View>({ op: 'advance', ms: 1000, since: 0 });
  return here.call<View>({ op: 'advance', ms: 0, since: 0 });
}

async function ended(page: Page): Promise<View> {
  const skip = page.locator('pg-time button', { hasText: /To its end|В конец/ });
  // A session has been opened; a short one may end while the button is looked for.
  await expect.poll(() => page.evaluate(() => location.hash), SOON).not.toBe('');
  await skip.click({ timeout: 500 }).catch(() => {});
  await expect.poll(() => skip.isVisible(), SOON).toBe(false);
  return page.locator('pg-time').evaluate((part) => (part as unknown as { view: View }).view);
}

test('a first example: state, bytes of the golden vector, fields that follow the pointer', async () => {
  const page = await open();
  expect(await page.title()).toContain('lafet playground');
  await page.locator('[data-example=refused]').click();
  await ended(page);
  await log(page).filter({ hasText: 'Open Valve1' }).click();
  const walk = page.locator('pg-walk section');
  await expect.poll(() => said(walk), SOON).toContain('Denied');
  expect(await said(walk.locator('li.refused'))).toContain('Deployer');
  expect(await said(walk)).toContain('Wrapped');

  const file = await readFile(new URL('../../../conformance/vectors/requests.json', import.meta.url), 'utf8');
  const vectors = JSON.parse(file) as { requests: { text: string; bytes: string }[] };
  const golden = vectors.requests.find((one) => one.text === 'Open Valve1')!.bytes;
  const bytes = await page.locator('#sent .bytes span').allInnerTexts();
  expect(bytes.join(' ')).toContain(golden);

  const first = page.locator('#sent .bytes span').nth(4);
  await first.hover();
  expect(await said(page.locator('#sent [role=option].here'))).toContain('Open');
  await page.locator('#sent [role=option]', { hasText: 'crc' }).hover();
  expect(await page.locator('#sent .bytes span.here').count()).toBe(2);
  await page.locator('#sent [role=listbox]').focus();
  await page.keyboard.press('End');
  await page.keyboard.press('ArrowUp');
  expect(await said(page.locator('#sent [role=option].here'))).toContain('crc');
});

test('a link leads to the same state in the page, in node and natively', async () => {
  const { examples } = (await engine()).call<Description>({ op: 'describe' });
  for (const { key, fragment } of examples) {
    const page = await open({ fragment });
    const [shown, there] = [await ended(page), await outcome(fragment)];
    expect([key, shown.hash, shown.at_ms]).toEqual([key, there.hash, there.at_ms]);
  }
});

test('what is done by hand is shared, and opened again', async () => {
  const page = await open();
  await page.locator('pg-request button', { hasText: 'As text' }).click();
  await page.locator('pg-request textarea').fill('Deploy');
  await page.locator('pg-request button.main').click();
  await expect.poll(() => log(page).count(), SOON).toBe(2);
  await page.locator('pg-world button', { hasText: 'Break' }).click();
  await page.locator('pg-world button', { hasText: 'Light' }).first().click();
  await expect.poll(() => log(page).count(), SOON).toBe(4);
  await page.locator('pg-request summary').click();
  await page.locator('pg-request button', { hasText: 'Send both' }).click();
  await expect.poll(() => log(page).count(), SOON).toBe(6);
  await page.locator('pg-time button', { hasText: 'Share' }).click();
  const link = await page.locator('pg-time input.link').inputValue();
  expect(link.length).toBeLessThan(400);
  const hash = await page.locator('pg-time').evaluate((part) => (part as unknown as { view: View }).view.hash);
  const again = await open({ fragment: link.split('#')[1]! });
  expect((await ended(again)).hash).toBe(hash);
  expect(await log(again).count()).toBe(6);
});

test('nothing is asked of another place, and there are no errors', async () => {
  const page = await open();
  await page.locator('[data-example=aim]').click();
  await ended(page);
  expect(requests.length).toBeGreaterThan(3);
  expect(requests.filter((url) => !url.startsWith(files.url))).toEqual([]);
  expect(files.outside).toEqual([]);
  expect(errors).toEqual([]);
});

test('links that are none: said in words, and the page works', async () => {
  const good = (await engine()).call<Description>({ op: 'describe' }).examples[1]!.fragment;
  const bad = ['2.AAAA', `${good}A`, good.slice(0, -3), '1.'.padEnd(9000, 'A'), '%00%ff<script>'];
  for (const fragment of bad) {
    const page = await open({ fragment });
    expect(await said(page.locator('[role=alert]').first()), fragment.slice(0, 40)).toContain(
      'This link cannot be opened.',
    );
    await page.locator('pg-request button.main').click();
    await expect.poll(() => log(page).count(), SOON).toBe(2);
    expect(errors).toEqual([]);
  }
});

test('Russian by the browser, and by the button', async () => {
  const page = await open({ locale: 'ru-RU' });
  expect(await said(page.locator('h1'))).toContain('Песочница');
  expect(await page.evaluate(() => document.documentElement.lang)).toBe('ru');
  await page.locator('[data-example=refused]').click();
  await ended(page);
  await log(page).filter({ hasText: 'Open Valve1' }).click();
  await expect.poll(() => said(page.locator('pg-walk section')), SOON).toContain('перехватывает');
  await page.locator('header button', { hasText: 'English' }).click();
  await expect.poll(() => said(page.locator('pg-walk section')), SOON).toContain('intercepts');
});

test('time passes, stops, and goes at another speed', async () => {
  const page = await open();
  const start = await seconds(page);
  await expect.poll(() => seconds(page), SOON).toBeGreaterThan(start);
  await page.locator('pg-time button', { hasText: 'Pause' }).click();
  await page.locator('pg-time button', { hasText: 'Go' }).waitFor();
  const still = await seconds(page);
  await page.evaluate(() => new Promise((done) => setTimeout(done, 300)));
  expect(await seconds(page)).toBe(still);
  await page.locator('pg-time select').first().selectOption('16');
  await page.locator('pg-time button', { hasText: 'Go' }).click();
  await expect.poll(() => seconds(page), SOON).toBeGreaterThan(still + 8);
});

test('accessible by day and night, on screens of 1440, 900 and 360 px', async () => {
  const axe = createRequire(import.meta.url).resolve('axe-core');
  for (const [width, dark, locale] of [
    [1440, false, 'en'],
    [900, true, 'en'],
    [360, true, 'ru'],
  ] as const) {
    const page = await open({ width, dark, locale });
    await page.locator('[data-example=switch]').click();
    await ended(page);
    for (const summary of await page.locator('pg-state summary, pg-request summary, pg-time summary').all())
      await summary.click();
    const wide = await page.evaluate(() => document.documentElement.scrollWidth - document.documentElement.clientWidth);
    expect(wide, `${width} px`).toBe(0);
    await page.evaluate(await readFile(axe, 'utf8'));
    const found = await page.evaluate(async () => {
      const { axe } = window as unknown as {
        axe: { run(): Promise<{ violations: { id: string; nodes: { html: string }[] }[] }> };
      };
      return (await axe.run()).violations.map((one) => `${one.id}: ${one.nodes[0]?.html}`);
    });
    expect(found, `${width} px, ${dark ? 'dark' : 'light'}, ${locale}`).toEqual([]);
  }
});

/** A module with the exports of the simulator whose `call` is `unreachable`, as a panic ends. */
function trapping(): Uint8Array {
  const name = (text: string): number[] => [text.length, ...new TextEncoder().encode(text)];
  const section = (id: number, body: number[]): number[] => [id, body.length, ...body];
  const exported = ['buffer', 'call', 'answer', 'message', 'message_len'];
  const exports = exported.flatMap((text, index) => [...name(text), 0, index]);
  const eight = [4, 0, 0x41, 8, 0x0b];
  const trap = [3, 0, 0x00, 0x0b];
  const nought = [4, 0, 0x41, 0, 0x0b];
  return new Uint8Array([
    ...[0, 0x61, 0x73, 0x6d, 1, 0, 0, 0],
    ...section(1, [2, 0x60, 1, 0x7f, 1, 0x7f, 0x60, 0, 1, 0x7f]),
    ...section(3, [5, 0, 1, 1, 1, 1]),
    ...section(5, [1, 0, 1]),
    ...section(7, [6, ...name('memory'), 2, 0, ...exports]),
    ...section(10, [5, ...eight, ...trap, ...eight, ...eight, ...nought]),
  ]);
}

test('a simulator that fails is reported, and can be started again', async () => {
  const broken = await served({ '.wasm': trapping() });
  try {
    const page = await open({ from: broken });
    expect(await said(page.locator('[role=alert]'))).toMatch(/The simulator has failed: .*unreachable/);
    const real = await readFile(new URL('../../src/lafet.wasm', import.meta.url));
    await page.route('**/*.wasm', (route) => route.fulfill({ body: real, contentType: 'application/octet-stream' }));
    await page.locator('button', { hasText: 'Start again' }).click();
    await page.locator('pg-scene svg').first().waitFor();
    expect(await page.locator('[role=alert]').count()).toBe(0);
  } finally {
    await broken.end();
  }
});
