// Tuning on the page of commissioning, with a drive that follows late and does not turn slowly: STOP in the middle of
// it, leaving the page, and a measurement that is written when the engineer says so.
import type { Page } from 'playwright-core';
import { afterAll, afterEach, beforeAll, expect, test } from 'vitest';
import type { Tune } from '../../src/hub/types';
import { able, go, holdUntil, LATE_MS, passes, passTo, SOON, until } from './page';
import { Site } from './site';

let site: Site;
let page: Page;

beforeAll(async () => {
  site = await Site.start('', ['horizontal-lag', 'horizontal-dead-band']);
});
afterAll(() => site?.stop());
afterEach(() => page?.context().close());

const box = () => page.locator('#tune-Horizontal');

async function open(before = async (_: Page): Promise<void> => {}): Promise<void> {
  page = await site.open('#/m/M1/commissioning');
  await before(page);
  await passTo(page, 'tune');
}

async function stored(name: string): Promise<number[]> {
  const answer = await fetch(`${site.api}/api/monitors/M1/requests`, {
    method: 'POST',
    headers: { 'content-type': 'application/json' },
    body: JSON.stringify({ request: `GetParam Horizontal ${name}` }),
  });
  const told = (await answer.json()) as { answers: { values: { values: number[] } }[] };
  return told.answers[0]!.values.values;
}

/** What the hub publishes of it. */
async function told(): Promise<Tune> {
  const answer = await fetch(`${site.api}/api/monitors/M1`);
  return ((await answer.json()) as { tune: Tune }).tune;
}

/** Measures until so many moves are done. */
async function measure(moves: number): Promise<void> {
  await holdUntil(page, box().locator('lf-hold'), () => box().locator('#tune-end').isVisible());
  await box()
    .getByText(new RegExp(`^Move ([${moves}-9]|[12]\\d) of 20$`))
    .waitFor({ timeout: 2 * LATE_MS });
}

test('STOP in the middle of it stops the drive, and the values are as before', async () => {
  await open();
  await measure(3);
  expect(await stored('StopLag')).toEqual([0]);
  await until(() => site.moves('M1'));
  await page.keyboard.press('F9');
  await box().getByText('Ended by STOP or another command to the monitor.').waitFor();
  expect(await site.stands('M1')).toBe(true);
  expect(await stored('MinSpeed')).toEqual([0]);
  // Nothing goes on by itself, and nothing was measured.
  await passes(page, 3000);
  expect(await site.moves('M1')).toBe(false);
  expect(await box().locator('.write').count()).toBe(0);
});

test('leaving the page ends it', async () => {
  await open();
  await measure(1);
  await go(page, '#/overview');
  await until(async () => (await told()).state === 'ended', LATE_MS);
  expect(await site.stands('M1')).toBe(true);
  await go(page, '#/m/M1/commissioning');
  await box().getByText('Ended by its operator.').waitFor();
});

test('leaving the page before the hub has answered ends it', async () => {
  let asked = 0;
  let answer = null as (() => void) | null;
  let beats: ReturnType<typeof setInterval> | undefined;
  await open((page) =>
    page.routeWebSocket(/api\/ws/, (ws) => {
      const hub = ws.connectToServer();
      ws.onMessage((message) => {
        const { type, id } = JSON.parse(String(message)) as { type: string; id: number };
        hub.send(message);
        if (type !== 'tune') return;
        asked = id;
        // The page cannot yet, and a slow machine takes its time.
        beats = setInterval(() => hub.send(JSON.stringify({ type: 'tune_beat', monitor: 'M1' })), 300);
      });
      hub.onMessage((message) => {
        const { type, id } = JSON.parse(String(message)) as { type: string; id: number };
        if (type === 'answer' && id === asked) answer = () => ws.send(message);
        else ws.send(message);
      });
    }),
  );
  await box().locator('lf-hold').hover();
  await page.mouse.down();
  await until(async () => answer !== null && (await told())?.state === 'running', LATE_MS);
  await page.mouse.up();
  await go(page, '#/overview');
  clearInterval(beats);
  answer!();
  await until(async () => (await told()).state === 'ended', LATE_MS);
  expect(await site.stands('M1')).toBe(true);
  await go(page, '#/m/M1/commissioning');
  await box().getByText('Ended by its operator.').waitFor();
});

test('an open valve is refused before anything moves', async () => {
  await open();
  await site.send('M1', 'Open Valve1');
  try {
    await box().locator('lf-hold button[aria-disabled=true]').waitFor();
    await box().locator('lf-hold').hover();
    await page.getByText('Close first: Valve1').waitFor();
  } finally {
    await site.send('M1', 'Close Valve1');
    await until(async () => (await site.outputs('M1')).Valve1!.flags.includes('Closed'), LATE_MS);
  }
});

test('what was measured is shown beside the present values, and is written on request', {
  timeout: 300_000,
}, async () => {
  await open();
  await measure(1);
  await until(async () => (await told()).state !== 'running', 150_000);
  expect(await told()).toMatchObject({ state: 'done', restored: true, text: null });
  await box().locator('.write').waitFor();
  expect(await stored('StopLag')).toEqual([0]);
  const lag = box().locator('tr', { hasText: 'StopLag' });
  await expect.poll(() => lag.locator('td').nth(1).textContent(), SOON).toMatch(/^0/);
  const found = (await told()).found!;
  // The fault `lag` is 300 ms; the page shows seconds.
  expect(found.stop_lag).toBeGreaterThan(240);
  expect(found.stop_lag).toBeLessThan(360);
  expect(Number.parseFloat((await lag.locator('td').nth(2).textContent())!)).toBeCloseTo(found.stop_lag / 1000, 3);
  await able(box().locator('.write')).click();
  await box().getByText('Written to the monitor').waitFor();
  expect(await stored('StopLag')).toEqual([found.stop_lag]);
  expect((await stored('MinSpeed'))[0]).toBeGreaterThanOrEqual(10);
});
