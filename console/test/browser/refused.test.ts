// Refusals of the hub are shown where the request was made: too fast, held by another, too large, no space to store it.
import type { Page } from 'playwright-core';
import { afterAll, afterEach, beforeAll, expect, test } from 'vitest';
import { Demo } from './demo';
import { able, drawn, go, SOON, shown, takeButton } from './page';

let demo: Demo;
let page: Page;

beforeAll(async () => {
  demo = await Demo.start();
});
afterAll(() => demo?.stop());
afterEach(async () => {
  await page.context().close();
  await demo.post('/api/sim/link', { monitor: 'M2', up: true });
});

const FULL = { en: 'Storage does not answer: the disk is full.', ru: 'Хранилище не отвечает: диск заполнен.' };
const FAST = { en: 'Too fast. Try again in 700 ms.', ru: 'Слишком часто. Повторите через 700 мс.' };
const HELD = { en: 'M1 is held by anna. Request control, or wait.', ru: 'M1 управляет anna.' };

/** An answer of the hub; without a code, of something between page and hub. */
async function answered(glob: string, status: number, code?: string, text = FULL): Promise<void> {
  const answer = code ? { status, json: { error: { code, ...text } } } : { status, body: '<html>' };
  await page.route(glob, (asked) => asked.fulfill(answer));
}

test('an alarm that is not acknowledged: too fast, no disk, a proxy', async () => {
  page = await demo.open('#/alarms');
  await demo.post('/api/sim/faults', { monitor: 'M1', fault: 'vertical-jam', on: true });
  await demo.post('/api/sim/link', { monitor: 'M2', up: false });
  const all = page.locator('#ack-all');
  await page.locator('li.alarm').first().waitFor();
  for (const [status, code, text, said] of [
    [429, 'slow_down', FAST, FAST.en],
    [503, 'storage', FULL, FULL.en],
    [413, undefined, FULL, 'Too large to be taken. (HTTP 413)'],
    [502, undefined, FULL, 'The hub cannot be reached behind its proxy. (HTTP 502)'],
  ] as const) {
    await page.unrouteAll();
    await answered('**/api/alarms/ack', status, code, text);
    const told = page.locator('lf-toasts .error').getByText(said).waitFor();
    await able(all).click();
    await told;
    await drawn(page);
    expect(await page.locator('li.alarm').count(), 'what was refused has changed nothing').toBeGreaterThan(0);
  }
});

test('pages that cannot be read say so, and are not waiting', async () => {
  page = await demo.open('#/overview');
  for (const [route, glob] of [
    ['#/replay', '**/api/recordings'],
    ['#/events', '**/api/audit?**'],
    ['#/admin', '**/api/users'],
    ['#/training', '**/api/sim'],
  ] as const) {
    await answered(glob, 503, 'storage');
    // Not what the page before has said.
    await go(page, route);
    await page.locator('main').getByText(FULL.en).first().waitFor();
    await drawn(page);
    expect(await page.locator('main [aria-busy=true]').count(), route).toBe(0);
  }
});

test('a file that is too large', async () => {
  page = await demo.open('#/replay');
  await answered('**/api/recordings/upload**', 413, 'too_large', { en: 'At most 64 MiB.', ru: 'Не более 64 МиБ.' });
  const file = { name: 'x.mcap', mimeType: 'application/octet-stream', buffer: Buffer.from('abc') };
  await page.locator('lf-page-replay input[type=file]').setInputFiles(file);
  await page.locator('lf-toasts .error').getByText('At most 64 MiB.').waitFor();
});

test('a monitor that another one holds, and commands that come too fast', async () => {
  page = await demo.open('#/overview');
  let refusal = { code: 'held', ...HELD };
  await page.routeWebSocket(/api\/ws/, (ws) => {
    const hub = ws.connectToServer();
    hub.onMessage((message) => ws.send(message));
    ws.onMessage((message) => {
      const said = JSON.parse(String(message)) as { type: string; id: number };
      const refused = said.type === 'authority' || said.type === 'request';
      if (refused) ws.send(JSON.stringify({ type: 'answer', id: said.id, error: refusal }));
      else hub.send(message);
    });
  });
  await page.goto(`${demo.url}/?again#/m/M1/operate`);
  await shown(page);
  await takeButton(page).click();
  await page.locator('lf-toasts .error').getByText(`Take control: ${HELD.en}`).waitFor();
  await expect.poll(() => page.locator('#take').isVisible(), SOON).toBe(true);
  await drawn(page);
  expect(await page.locator('#take').isVisible(), 'a refusal gives control to no client').toBe(true);
  refusal = { code: 'slow_down', ...FAST };
  await takeButton(page).click();
  await page.locator('lf-toasts .error').getByText(FAST.en).waitFor();
});

test('STOP of monitors that are locked out: they are at rest', async () => {
  page = await demo.open('#/m/M1/operate');
  const note = page.locator('lf-toasts .toast').last();
  await demo.post('/api/lockout');
  await page.locator('#release').waitFor();
  const one = note.getByText('M1 is locked out: the lockout has stopped it already.').waitFor();
  await page.keyboard.press('Pause');
  await one;
  await go(page, '#/overview');
  const all = page.locator('lf-toasts .toast.ok').getByText('All monitors · Stop').waitFor();
  await page.keyboard.press('Pause');
  await all;
  expect(await page.locator('lf-toasts .error').count()).toBe(0);
});
