// Lists of ten thousand rows: only visible ones are rendered, and all can be reached.

import { readFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import type { Page } from 'playwright-core';
import { afterAll, afterEach, beforeAll, expect, test } from 'vitest';
import { Demo } from './demo';
import { drawn, go, LATE_MS, SOON, settled, shown, until } from './page';

const AXE = readFileSync(createRequire(import.meta.url).resolve('axe-core/axe.min.js'), 'utf8');
const ROWS = 10_000;
const MADE_MOST = 250;
const BEGUN_MS = Date.UTC(2026, 0, 1);

let demo: Demo;
let page: Page;

beforeAll(async () => {
  demo = await Demo.start();
});
afterAll(() => demo?.stop());
afterEach(() => page.context().close());

/** Opens a page with this list as the hub's answer. */
async function opened(route: string, path: string, body: unknown): Promise<void> {
  page = await demo.open('#/overview');
  await page.route(`**${path}?**`, (asked) => asked.fulfill({ json: body }));
  await go(page, route);
}

/** Scrolls down until the last row is rendered, as a user does; returns the maximum number of rendered rows. */
async function scrolledThrough(rows: string, last: RegExp): Promise<number> {
  const made = page.locator(rows);
  let most = await made.count();
  await until(async () => {
    await page.evaluate(() => {
      const main = document.querySelector('lf-app')!.shadowRoot!.querySelector('main')!;
      main.scrollTop = main.scrollHeight;
    });
    most = Math.max(most, await made.count());
    return page.locator(rows).filter({ hasText: last }).last().isVisible();
  }, LATE_MS);
  return most;
}

async function clean(): Promise<void> {
  await settled(page);
  await page.evaluate(AXE);
  const found = await page.evaluate(async () => {
    const axe = (window as unknown as { axe: { run: (options: object) => Promise<{ violations: { id: string }[] }> } })
      .axe;
    return (await axe.run({ runOnly: ['wcag2a', 'wcag2aa', 'wcag21aa'] })).violations.map(({ id }) => id);
  });
  expect(found).toEqual([]);
}

test('the audit log of ten thousand commands', async () => {
  const entries = Array.from({ length: ROWS }, (_, index) => {
    const n = ROWS - index;
    return {
      n,
      at_ms: BEGUN_MS + n * 1000,
      user: 'anna',
      role: 'operator',
      from: '10.0.0.5',
      via: 'ws',
      seat: 's1',
      monitor: 'M1',
      what: `Move Horizontal ${n}`,
      outcome: 'not allowed',
      details: {},
      prev: '',
      hash: '',
    };
  });
  await opened('#/events', '/api/audit', { entries, next: null, waiting: 0 });
  const rows = 'lf-audit-log tr.deed';
  await page
    .locator(rows)
    .filter({ hasText: `Horizontal ${ROWS}` })
    .waitFor();
  await expect.poll(() => page.locator('lf-audit-log table').getAttribute('aria-rowcount'), SOON).toBe(`${ROWS + 1}`);
  expect(await page.locator(rows).count()).toBeLessThan(MADE_MOST);
  expect(await scrolledThrough(rows, /Horizontal 1\b/)).toBeLessThan(MADE_MOST);
  const last = page
    .locator(rows)
    .filter({ hasText: /Horizontal 1\b/ })
    .last();
  expect(await last.getAttribute('aria-rowindex')).toBe(`${ROWS + 1}`);
  await clean();

  // By the keyboard: from a row to the one above, also beyond the rendered rows.
  await last.locator('button').focus();
  const focused = () =>
    page.evaluate(() => {
      const log = document
        .querySelector('lf-app')!
        .shadowRoot!.querySelector('lf-page-events')!
        .shadowRoot!.querySelector('lf-audit-log')!;
      return log.shadowRoot!.activeElement?.closest('tr')?.getAttribute('data-n') ?? '';
    });
  // The next rows are rendered before the next key.
  for (let n = 2; n < 80; n += 1) {
    await page.keyboard.press('Shift+Tab');
    await until(async () => (await focused()) === `${n}`);
    await drawn(page);
  }
  expect(await focused()).toBe('79');
});

test('the history of ten thousand alarms', async () => {
  const steps = Array.from({ length: ROWS }, (_, index) => ({
    at_ms: BEGUN_MS + (ROWS - index) * 1000,
    id: `M${ROWS - index}/Vertical/AmperageOverload`,
    from: 'normal',
    to: 'unack',
    user: null,
    reason: null,
  }));
  await opened('#/alarms', '/api/alarms/history', steps);
  await page.getByRole('tab', { name: /History/ }).click();
  const rows = 'lf-alarm-history tr.step-row';
  await page.locator(rows).first().waitFor();
  await settled(page);
  expect(await page.locator(rows).count()).toBeLessThan(MADE_MOST);
  expect(await scrolledThrough(rows, /\bM1\b/)).toBeLessThan(MADE_MOST);
  await clean();
});

test('ten thousand things that have happened', async () => {
  const events = Array.from({ length: ROWS }, (_, index) => ({
    n: ROWS - index,
    at_ms: BEGUN_MS + (ROWS - index) * 1000,
    monitor: 'M1',
    what: { en: `thing ${ROWS - index}.`, ru: 'дело' },
  }));
  await opened('#/events', '/api/events', { events, next: null });
  await page.getByRole('tab', { name: /^Events/ }).click();
  const rows = 'lf-page-events .live .event';
  await page.locator(rows).first().waitFor();
  await settled(page);
  expect(await page.locator(rows).count()).toBeLessThan(MADE_MOST);
  expect(await scrolledThrough(rows, /thing 1\./)).toBeLessThan(MADE_MOST);
  await clean();
});

test('ten thousand frames of a link', async () => {
  page = await demo.open('#/overview');
  let say = (_: string) => {};
  await page.routeWebSocket(/api\/ws/, (ws) => {
    const hub = ws.connectToServer();
    hub.onMessage((message) => {
      // Its own frames would arrive in between.
      if (!String(message).startsWith('{"type":"frame"') && !/"type":"frame"/.test(String(message))) ws.send(message);
    });
    ws.onMessage((message) => hub.send(message));
    say = (text) => ws.send(text);
  });
  await page.goto(`${demo.url}/?again#/m/M1/inspector`);
  await shown(page);
  const list = page.locator('lf-frame-list [role=listbox]');
  for (let n = 1; n <= ROWS; n += 1) {
    const text = `thing ${n} ${'and more '.repeat(20)}`;
    const frame = {
      type: 'frame',
      monitor: 'M1',
      at_ms: BEGUN_MS + n,
      direction: 'in',
      src: 1,
      dst: 129,
      bytes: 'd4 5d',
      text,
      verdict: 'foreign',
    };
    say(JSON.stringify(frame));
    // The page takes them before the next ones: behind all of them it would find its link silent, and break it.
    if (n % 200 === 0) await drawn(page);
  }
  const rows = page.locator('lf-frame-list .frame');
  await rows.filter({ hasText: `thing ${ROWS} ` }).waitFor({ timeout: 2 * LATE_MS });
  expect(await rows.count()).toBeLessThan(60);
  await expect.poll(() => rows.first().getAttribute('aria-setsize'), SOON).toBe(`${ROWS}`);
  await list.focus();
  for (let n = 0; n < 30; n += 1) await page.keyboard.press('ArrowUp');
  const chosen = page.locator('lf-frame-list .frame[aria-selected=true]');
  await until(async () => (await chosen.getAttribute('aria-posinset')) === `${ROWS - 29}`);
  await expect.poll(() => chosen.isVisible(), SOON).toBe(true);
  await page.locator('lf-page-inspector lf-find input').fill('thing 1234 ');
  await until(async () => (await rows.count()) === 1);
  await clean();
});
