// The zones: what a countdown shows on every page, who may do what, and what is left without a link.
import { mkdirSync, readFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import type { Locator, Page } from 'playwright-core';
import { afterAll, afterEach, beforeAll, beforeEach, describe, expect, test } from 'vitest';
import type { ZoneState, ZonesConfigured, ZonesView } from '../../src/hub/api';
import { clipped } from './clipped';
import { Guarded } from './guarded';
import { able, drawn, go, holdUntil, LATE_MS, passes, placed, press, SOON, settled, shown, until } from './page';
import { Site } from './site';

/** The longest that the hub allows: a test of what a countdown shows is over before. */
const DELAY_S = 60;

const axe = readFileSync(createRequire(import.meta.url).resolve('axe-core/axe.min.js'), 'utf8');
const TAGS = ['wcag2a', 'wcag2aa', 'wcag21a', 'wcag21aa', 'wcag22aa'];

const detector = (id: string, zone: string) =>
  `[[detector]]\nid = "${id}"\nkind = "${id}"\nzones = ["${zone}"]\nsilent_after_s = 3600\n`;
const aim = (zone: string, monitor: string) =>
  `[[aim]]\nzone = "${zone}"\nmonitor = "${monitor}"\nhorizontal = 600\nvertical = 300\nnozzle = 60\n`;
const hall = (monitors: string[], keys: string) =>
  `[[zone]]\nid = "hall"\nvotes = "2oo2"\nwater_max_s = 600\nmonitors = ${JSON.stringify(monitors)}\n${keys}\n` +
  ['flame', 'heat'].map((id) => detector(id, 'hall')).join('') +
  monitors.map((id) => aim('hall', id)).join('');

let site: Site;
let page: Page;
const others: Page[] = [];

beforeAll(async () => {
  site = await Site.start(hall(['M1', 'M2'], `coincidence_s = 1\ndelay_s = ${DELAY_S}\nhold_max_s = 300`));
});
afterAll(() => site?.stop());

async function post(path: string, body: unknown = {}): Promise<Response> {
  const headers = { 'content-type': 'application/json' };
  return fetch(`${site.api}${path}`, { method: 'POST', headers, body: JSON.stringify(body) });
}

async function sees(signal: string, ...ids: string[]): Promise<void> {
  for (const id of ids) expect((await post(`/api/detectors/${id}`, { signal })).status).toBe(204);
}

async function view(): Promise<ZonesView> {
  return (await (await fetch(`${site.api}/api/zones`)).json()) as ZonesView;
}

async function phase(): Promise<ZoneState['phase']> {
  return (await view()).state.zones[0]!.phase;
}

/** No detector in alarm, nothing ended, both monitors ready. */
async function calm(): Promise<void> {
  await sees('quiet', 'flame', 'heat');
  await post('/api/zones/hall/abort');
  // Within two seconds after a no both are refused.
  await until(async () => (await post('/api/zones/unlock')).ok);
  await post('/api/detectors/heat/bypass', { bypass: 'none' });
  await post('/api/zones/hall/mode', { mode: 'automatic' });
  await until(async () => (await view()).state.monitors.every(({ closing }) => !closing), LATE_MS);
  await until(async () => (await post('/api/zones/reset')).ok);
  await until(async () => (await view()).state.zones[0]!.ready);
}

async function clean(on: Page, ready = settled): Promise<void> {
  await ready(on);
  await on.evaluate(axe);
  const found = await on.evaluate(async (tags) => {
    const run = (
      globalThis as unknown as {
        axe: { run: (o: object) => Promise<{ violations: { id: string; nodes: { target: unknown }[] }[] }> };
      }
    ).axe;
    return (await run.run({ runOnly: tags })).violations.map(
      ({ id, nodes }) => `${id} ${JSON.stringify(nodes.map(({ target }) => target))}`,
    );
  }, TAGS);
  expect(found).toEqual([]);
}

/** A picture for people, where ZONES_PICTURES names a folder. */
async function picture(on: Page, name: string): Promise<void> {
  const folder = process.env.ZONES_PICTURES;
  if (!folder) return;
  mkdirSync(folder, { recursive: true });
  await on.screenshot({ path: `${folder}/${name}.png` });
}

/** A click on what must be held for a time, which says so. */
async function clicked(hold: Locator): Promise<void> {
  const hint = page.locator('.lf-why', { hasText: /hold for|держите/ }).waitFor();
  await able(hold).waitFor();
  expect(await press(page, hold, 0), 'a click').toBeLessThan(2000);
  await hint;
  await passes(page, 300);
}

const strip = () => page.locator('lf-zone-alert section');
/** The seconds that the strip shows, of the first zone. */
const figure = async () =>
  parseInt(
    (
      await page
        .locator('lf-zone-alert .figure lf-zone-left')
        .first()
        .evaluate((it) => it.shadowRoot!.textContent!)
    ).trim(),
    10,
  );

describe('an installation', () => {
  beforeEach(calm);
  afterEach(async () => {
    site.way.mend();
    for (const one of [page, ...others.splice(0)]) await one.context().close();
  });

  test('one vote is shown and does nothing; two count down on every page; Hold, Abort, reset', async () => {
    page = await site.open('#/zones');
    const detail = page.locator('lf-zone-detail');
    await detail.locator('.now').getByText('Idle, ready').waitFor();
    await clean(page);
    await sees('alarm', 'flame');
    await detail.locator('.now').getByText('Alarm: 1 of 2 votes').waitFor();
    await detail.getByText('votes: 1 of 2').waitFor();
    await detail.locator('lf-zone-detectors tr', { hasText: 'flame' }).getByText('votes', { exact: true }).waitFor();
    await page.locator('lf-banners').getByText('hall: Alarm: 1 of 2 votes').waitFor();
    await settled(page);
    expect(await strip().count(), 'nothing runs').toBe(0);
    await go(page, '#/overview');
    await page.locator('lf-zone-strip').getByText('Alarm: 1 of 2 votes').waitFor();

    await go(page, '#/m/M1/params');
    await sees('alarm', 'heat');
    await strip().getByText('hall: countdown').waitFor();
    await strip().getByText('Votes: flame, heat').waitFor();
    const first = await figure();
    await until(async () => (await figure()) < first);
    expect(first).toBeLessThanOrEqual(DELAY_S + 1);
    await clean(page);

    await strip().getByRole('button', { name: 'Hold' }).click();
    await strip().getByText('hall: the release is held').waitFor();
    // The page renews it: without that it ends after 10 s.
    await page.waitForTimeout(12_000);
    expect(await phase()).toBe('held');
    const left = (await view()).state.zones[0]!.left_ms!;
    await strip().getByRole('button', { name: 'End the hold' }).click();
    await strip().getByText('countdown').waitFor();
    expect((await view()).state.zones[0]!.left_ms!).toBeLessThanOrEqual(left);

    await strip().getByRole('button', { name: 'Abort' }).click();
    await strip().waitFor({ state: 'detached' });
    expect(await phase()).toEqual({ ended: 'abort' });
    await go(page, '#/zones/hall');
    await detail.locator('.now').getByText('Ended (abort), needs a reset').waitFor();
    await page.locator('lf-zone-troubles').getByText('hall: ended (abort), needs a reset').waitFor();
    await page.locator('lf-zone-deeds').getByText('Zone hall: countdown cancelled (abort)').waitFor();
    await sees('quiet', 'flame', 'heat');
    await holdUntil(page, detail.locator('#reset-zone'), async () => (await phase()) === 'quiet');
    await detail.locator('.now').getByText('Idle, ready').waitFor();
  });

  test('a release by hand takes a held press; Close by a person takes its monitor out, and Abort the rest', async () => {
    page = await site.open('#/zones/hall', 'ru');
    const detail = page.locator('lf-zone-detail');
    await able(detail.locator('#release-zone')).click();
    const yes = page.locator('lf-dialogs lf-hold');
    await clicked(yes);
    expect(await phase(), 'a click releases nothing').toBe('quiet');
    await holdUntil(page, yes, async () => typeof (await phase()) !== 'string');
    await strip().getByText('hall: ПУСК, вода').waitFor();
    await strip()
      .getByText('Воду дают: M1, M2')
      .waitFor({ timeout: 2 * LATE_MS });
    for (const id of ['M1', 'M2']) expect((await site.outputs(id)).Valve1?.flags).toContain('Open');
    await picture(page, 'released.ru.day');
    await clean(page);

    expect((await post('/api/monitors/M1/close')).status).toBe(200);
    const monitor = (id: string) => detail.locator('lf-zone-monitors tr', { hasText: id });
    await monitor('M1').getByText('закрыт или остановлен человеком').waitFor();
    await strip().getByText('Воду дают: M2').waitFor();
    await strip().getByRole('button', { name: 'Отмена пуска' }).click();
    await strip().waitFor({ state: 'detached' });
    for (const id of ['M1', 'M2'])
      await until(async () => (await site.outputs(id)).Valve1?.flags.includes('Closed') === true, LATE_MS);
    await detail.locator('.now').getByText('Прекращено (отмена), нужен сброс').waitFor();
  });

  test('modes and masks: set here, shown as disablements, still there after the hub starts again', async () => {
    page = await site.open('#/zones/hall');
    const detail = page.locator('lf-zone-detail');
    await able(detail.locator('#mode')).click();
    await page.locator('#mode-wanted').selectOption('manual');
    await page.locator('#mode-for').selectOption('3600');
    await page.locator('lf-dialogs').getByRole('button', { name: 'Set the mode' }).click();
    await detail.getByText('Manual only; automatic again in').waitFor();
    await detail.locator('lf-zone-detectors tr', { hasText: 'heat' }).locator('.bypass').click();
    await page.locator('#bypass-masked').click();
    await detail.locator('lf-zone-detectors tr', { hasText: 'heat' }).getByText('masked by people').waitFor();
    const disabled = page.locator('lf-zone-troubles section').nth(1);
    await disabled.getByText('Detector heat: masked by people').waitFor();
    await disabled.getByText(/Zone hall: manual; automatic again in/).waitFor();

    await site.restart();
    await until(async () => (await view().catch(() => null))?.state.zones[0]?.mode === 'manual', LATE_MS);
    await disabled.getByText('Detector heat: masked by people').waitFor();
    await sees('quiet', 'flame', 'heat');
    await able(detail.locator('#mode')).click();
    await page.locator('#mode-wanted').selectOption('automatic');
    const set = page.locator('lf-dialogs lf-hold');
    await clicked(set);
    expect((await view()).state.zones[0]!.mode, 'a click does not arm it').toBe('manual');
    await holdUntil(page, set, async () => (await view()).state.zones[0]!.mode === 'automatic');
  });

  test('without a link nothing is shown as known, Abort answers, and the clock of the browser does not matter', async () => {
    page = await site.open('#/overview');
    await page.context().addInitScript(() => {
      const { now } = Date;
      Date.now = () => now() + 3_600_000;
    });
    await page.goto(`${site.url}/?wrong-clock#/zones`);
    await shown(page);
    await sees('alarm', 'flame', 'heat');
    await strip().getByText('hall: countdown').waitFor();
    const left = async () => (await view()).state.zones[0]!.left_ms! / 1000;
    // What is shown lies between what the hub has said before and after.
    const [before, seen, after] = [await left(), await figure(), await left()];
    expect(seen).toBeLessThan(before + 2);
    expect(seen).toBeGreaterThan(after - 2);
    let ages: string[] = [];
    await until(async () => {
      ages = await page.locator('lf-zone-detectors td', { hasText: 'ago' }).allInnerTexts();
      return ages.length > 0;
    });
    expect(
      ages.every((age) => /^\d+ sec ago$/.test(age)),
      ages.join(),
    ).toBe(true);

    site.way.freeze();
    await strip()
      .getByText(/hall: State unknown for/)
      .waitFor();
    await strip()
      .getByText(/Last report: Countdown, release in \d+ s/)
      .waitFor();
    expect(await page.locator('lf-zone-alert .figure').count(), 'no figure that is not known').toBe(0);
    await expect.poll(() => strip().locator('.hold button').getAttribute('aria-disabled'), SOON).toBe('true');
    await picture(page, 'lost.en.day');
    // Its queries get no answer.
    await clean(page, drawn);
    const abort = strip().getByRole('button', { name: 'Abort' });
    await abort.click();
    const told = page.locator('lf-toasts .error').getByText('hall: abort: NOT CONFIRMED');
    await told.waitFor();
    site.way.cut();
    expect(await phase()).toBe('countdown');
    site.way.mend();
    // It is given again by itself.
    await told.waitFor({ state: 'detached' });
    await until(async () => JSON.stringify(await phase()) === '{"ended":"abort"}');
  });

  test('the hub starts again while a countdown runs: it does not go on by itself, and the page follows', async () => {
    page = await site.open('#/m/M1/operate');
    await sees('alarm', 'flame', 'heat');
    await strip().getByText('hall: countdown').waitFor();
    await strip().getByRole('button', { name: 'Hold' }).click();
    await strip().getByText('held').waitFor();
    await site.restart();
    await strip().waitFor({ state: 'detached', timeout: LATE_MS });
    expect(await phase()).toBe('quiet');
  });

  test('two operators: each sees the hold of the other, and its end ends it for both', async () => {
    page = await site.open('#/overview');
    const other = await site.open('#/zones');
    others.push(other);
    await sees('alarm', 'flame', 'heat');
    await strip().getByRole('button', { name: 'Hold' }).click();
    const there = other.locator('lf-zone-alert section');
    await there.getByText('held').waitFor();
    await there.getByRole('button', { name: 'End the hold' }).click();
    await strip().getByText('countdown').waitFor();
    await passes(page, 4000);
    expect(await phase(), 'the first page does not hold again by itself').toBe('countdown');
    await there.getByRole('button', { name: 'Abort' }).click();
    await strip().waitFor({ state: 'detached' });
  });

  test('the strip is above a dialog, and Abort is one press there', async () => {
    page = await site.open('#/overview');
    await page.keyboard.press('?');
    await page.locator('lf-dialogs .dialog').waitFor();
    await sees('alarm', 'flame', 'heat');
    await strip().getByText('countdown').waitFor();
    await settled(page);
    const [bar, card] = [await placed(strip()), await placed(page.locator('lf-dialogs .dialog'))];
    expect(card.y).toBeGreaterThanOrEqual(bar.y + bar.height);
    await strip().getByRole('button', { name: 'Abort' }).click();
    await strip().waitFor({ state: 'detached' });
  });

  test('a press on what the strip has just shifted does nothing; the next one counts', async () => {
    page = await site.open('#/overview');
    await settled(page);
    // In the page, as a finger that is on its way when the strip comes; then again, when it has been seen.
    const went = page.evaluate(async () => {
      const app = document.querySelector('lf-app')!.shadowRoot!;
      const link = app.querySelector('lf-nav')!.shadowRoot!.querySelector<HTMLElement>('a[href*="events"]')!;
      const press = () => {
        const like = { bubbles: true, composed: true, cancelable: true, detail: 1 };
        link.dispatchEvent(new PointerEvent('pointerdown', like));
        link.dispatchEvent(new MouseEvent('click', like));
      };
      const strip = app.querySelector<HTMLElement>('lf-zone-alert')!;
      const frame = () => new Promise((done) => requestAnimationFrame(done));
      while (strip.offsetHeight === 0) await frame();
      press();
      const at = [location.hash];
      for (const since = performance.now(); performance.now() - since < 700; ) await frame();
      press();
      return [...at, location.hash];
    });
    await sees('alarm', 'flame', 'heat');
    expect(await went).toEqual(['#/overview', '#/events']);
  });

  const VIEWS = [
    { lang: 'en', theme: 'night', width: 1440, height: 900 },
    { lang: 'ru', theme: 'day', width: 1024, height: 768 },
    { lang: 'ru', theme: 'night', width: 390, height: 844 },
  ];
  test.each(VIEWS)('nothing is cut off: $lang, $theme, $width × $height', async ({ lang, theme, ...size }) => {
    page = await site.open('#/zones', lang, size);
    await page.evaluate((to) => (document.documentElement.dataset.theme = to), theme);
    await page.locator('lf-zone-detail .card').waitFor();
    await sees('alarm', 'flame', 'heat');
    await strip().waitFor();
    await settled(page);
    await picture(page, `zone.${lang}.${theme}.${size.width}`);
    await clean(page);
    expect(await clipped(page)).toEqual([]);
    const chips = page.locator('lf-zone-detectors td lf-chip');
    const cells = await chips.evaluateAll((all) => all.map((one) => one.closest('td')!.clientWidth));
    expect(Math.min(...cells), 'a word a line').toBeGreaterThan(130);
    await go(page, '#/overview');
    await page.locator('lf-zone-strip a').waitFor();
    await picture(page, `overview.${lang}.${theme}.${size.width}`);
    await clean(page);
    expect(await page.evaluate(() => document.documentElement.scrollWidth - innerWidth)).toBeLessThanOrEqual(0);
  });
});

describe('a large installation', () => {
  const NAME = 'Резервуарный парк северного терминала, площадка';
  const detectors = Array.from({ length: 20 }, (_, n) => `Извещатель пламени инфракрасный № ${n + 1}`);
  const monitors = Array.from({ length: 8 }, (_, n) => `M${n + 1}`);
  const zoneOf = (n: number): ZoneState => ({
    zone: `${NAME} ${n}`,
    phase: n < 5 ? 'countdown' : n % 7 === 0 ? 'alarm' : 'quiet',
    mode: n % 11 === 0 ? 'off' : 'automatic',
    switch_manual: false,
    votes: n < 5 ? detectors.slice(0, 3) : [],
    alarms: n < 5 || n % 7 === 0 ? detectors.slice(0, 3) : [],
    need: 2,
    unable: [{ detector: detectors[9]!, why: 'silent' }],
    ready: n % 11 !== 0,
    left_ms: n < 5 ? n * 9000 : null,
    hold_left_ms: 60_000,
    not_released: n < 5 ? ['delay'] : [],
    monitors: n < 5 ? monitors : [],
  });
  const many = Array.from({ length: 30 }, (_, n) => zoneOf(n));
  const state: ZonesView['state'] = {
    at_ms: 90_000,
    lockout: false,
    tone: 'countdown',
    zones: many,
    pumps: [],
    outputs: [],
    detectors: detectors.map((id, n) => ({
      detector: id,
      signal: n < 3 ? 'alarm' : 'quiet',
      unable: n === 9 ? 'silent' : null,
      stale: n === 4,
    })),
    monitors: monitors.map((monitor, n) => ({
      monitor,
      closing: n === 7,
      withheld: n === 6 ? 'unreachable' : null,
      engaged_for: n < 6 ? many[0]!.zone : null,
    })),
    troubles: [{ trouble: 'detector_silent', subject: detectors[9]!, since_ms: 30_000, active: true }],
    disablements: [
      { mode: { zone: many[0]!.zone, mode: 'off', returns_in_ms: 90_000 } },
      { delay: { zone: many[1]!.zone, delay_ms: 9000 } },
    ],
  };
  const configured: ZonesConfigured = {
    zones: many.map(({ zone }) => ({
      zone,
      detectors,
      monitors,
      votes: '2oo20',
      kinds: 1,
      coincidence_s: 5,
      delay_s: 30,
      hold_max_s: 60,
      water_max_s: 600,
      return_after_s: null,
    })),
    detectors: Object.fromEntries(detectors.map((id) => [id, 'flame' as const])),
  };

  test.each([
    { lang: 'ru', theme: 'day', width: 1440, height: 900 },
    { lang: 'ru', theme: 'night', width: 390, height: 844 },
  ])('of 30 zones, 20 detectors and 8 monitors, $width × $height', async ({ lang, theme, ...size }) => {
    page = await site.open('#/overview', lang, size);
    let more: ((topic: Record<string, unknown>) => void) | null = null;
    await page.routeWebSocket(/api\/ws/, (ws) => {
      const hub = ws.connectToServer();
      hub.onMessage((message) => {
        const said = JSON.parse(String(message)) as { type: string; set?: Record<string, unknown> };
        if (said.type === 'state')
          Object.assign(said.set!, { zones: { state, reported: {} }, 'zones/configured': configured });
        else if (said.set) delete said.set.zones;
        ws.send(JSON.stringify(said));
      });
      ws.onMessage((message) => hub.send(message));
      more = (set) => ws.send(JSON.stringify({ type: 'change', now_ms: Date.now(), set }));
    });
    await page.goto(`${site.url}/?many#/zones`);
    await shown(page);
    await page.evaluate((to) => (document.documentElement.dataset.theme = to), theme);
    await page.locator('lf-zone-list a').nth(29).waitFor();
    // A countdown of nothing is not over before the hub says so.
    await expect.poll(figure, SOON).toBe(0);
    await expect.poll(() => strip().count(), SOON).toBe(3);
    await page.locator('lf-zone-alert .more').getByText('2').waitFor();
    await page.locator('lf-banners').getByText('Зон с тревогой: 4').waitFor();
    await expect.poll(() => page.locator('lf-zone-detectors tbody tr').count(), SOON).toBe(20);
    await expect.poll(() => page.locator('lf-zone-monitors tbody tr').count(), SOON).toBe(8);
    await settled(page);
    await picture(page, `many.${theme}.${size.width}`);
    const bar = await placed(page.locator('lf-zone-alert'));
    expect(bar.height, 'half of the page is left').toBeLessThanOrEqual(size.height / 2);
    expect(await page.evaluate(() => document.documentElement.scrollWidth - innerWidth)).toBeLessThanOrEqual(0);
    await clean(page);
    // A zone that the configuration does not have.
    const unknown = { ...many[0]!, zone: 'новая' };
    more!({ zones: { state: { ...state, zones: [unknown] }, reported: {} } });
    await page.locator('lf-zone-detail h2').getByText('новая').waitFor();
    await expect.poll(() => page.locator('lf-zone-detectors tbody tr').count(), SOON).toBe(4);
    await page.context().close();
  });
});

test('an observer sees everything, may abort and lock, and no more', async () => {
  const guarded = await Guarded.start(hall(['M1'], 'coincidence_s = 0\ndelay_s = 60'));
  try {
    page = await site.open('#/overview');
    await guarded.enter(page, 'olga');
    for (const signal of ['quiet', 'alarm']) {
      for (const id of ['flame', 'heat'])
        expect((await guarded.asRoot(`/api/detectors/${id}`, { signal })).status).toBe(204);
    }
    await strip().getByText('hall: countdown').waitFor();
    await go(page, '#/zones/hall');
    await page.locator('lf-zone-detail .orders').waitFor();
    await settled(page);
    const words = async (of: string) => page.locator(`${of} :is(lf-button, lf-hold)`).allInnerTexts();
    expect([...(await words('lf-zone-alert')), ...(await words('lf-page-zones'))].map((text) => text.trim())).toEqual([
      'Abort',
      'Lock the zones',
      'Abort',
    ]);
    expect((await guarded.asRoot('/api/zones/hall/hold', { on: true })).status).toBe(200);
    await strip().getByText('held').waitFor();
    await strip().getByRole('button', { name: 'Abort' }).click();
    await strip().waitFor({ state: 'detached' });
    await page.locator('lf-zone-detail .now').getByText('Ended (abort), needs a reset').waitFor();
    await page.context().close();
  } finally {
    await guarded.stop();
  }
});
