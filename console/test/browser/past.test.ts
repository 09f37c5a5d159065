// Hours, days and a month of pressure and flow: the query to the hub, and the plot of its answer.
import type { Page } from 'playwright-core';
import { afterAll, beforeAll, expect, test } from 'vitest';
import { LATE_MS, SOON, until } from './page';
import { Site } from './site';

const HOUR_MS = 3_600_000;
const SPANS: [string, number][] = [
  ['1 h', HOUR_MS],
  ['8 h', 8 * HOUR_MS],
  ['24 h', 24 * HOUR_MS],
  ['7 d', 7 * 24 * HOUR_MS],
  ['31 d', 31 * 24 * HOUR_MS],
];
/** Parts of the generated history, from its start; between them nothing is known. */
const GAP = [0.5, 0.6] as const;

let site: Site;
let page: Page;
let asked: URLSearchParams[] = [];

beforeAll(async () => {
  site = await Site.start();
  page = await site.open('#/m/M1/operate');
  await page.route('**/api/history?*', (route) => {
    const query = new URL(route.request().url()).searchParams;
    asked.push(query);
    return route.fulfill({ json: made(query) });
  });
});
afterAll(() => site?.stop());

/** As the hub answers: changes up to two hours, else intervals with minimum and maximum; 0.4 MPa with a peak to 0.9 and a dip to 0.1. */
function made(query: URLSearchParams) {
  const [from, to] = [Number(query.get('from_ms')), Number(query.get('to_ms'))];
  const long = to - from;
  const names = query.get('series')!.split(',');
  const raw = long <= 2 * HOUR_MS;
  const step = raw ? 1000 : Math.max(Math.ceil(long / 600 / 60_000), 1) * 60_000;
  const points: (number | null)[][] = [];
  for (let at = Math.ceil(from / step) * step; at < to; at += step) {
    const part = (at - from) / long;
    if (part > GAP[0] && part < GAP[1]) {
      if (raw && points.at(-1)?.[1] !== null) points.push([at, null]);
    } else points.push(raw ? [at, 40] : [at, 40, 10, 90]);
  }
  return {
    resolution_ms: raw ? 0 : step,
    series: Object.fromEntries(names.map((name) => [name, name === 'General.pressure' ? points : []])),
  };
}

/** Values of the plot at a part of its width: mean, minimum, maximum; MPa. */
const at = (part: number) =>
  page
    .locator('lf-past lf-plot')
    .first()
    .evaluate((plot, share) => {
      const own = plot as unknown as { span: [number, number]; columns: { at(ms: number): (number | null)[] } };
      const [from, to] = own.span;
      return own.columns.at(from + (to - from) * share);
    }, part);

/** The time that the plot shows, ms. */
const spanned = () =>
  page
    .locator('lf-past lf-plot')
    .first()
    .evaluate((plot) => {
      const [from, to] = (plot as unknown as { span: [number, number] }).span;
      return to - from;
    });

/** Coloured share of a part of the canvas. */
const painted = (from: number, to: number) =>
  page
    .locator('lf-past lf-plot')
    .first()
    .evaluate(
      (plot, [low, high]) => {
        const canvas = plot.shadowRoot!.querySelector('canvas')!;
        const over = plot.shadowRoot!.querySelector<HTMLElement>('.u-over')!;
        const scale = canvas.width / canvas.clientWidth;
        const [left, wide] = [over.offsetLeft * scale, over.offsetWidth * scale];
        const data = canvas
          .getContext('2d')!
          .getImageData(
            left + wide * low!,
            over.offsetTop * scale,
            wide * (high! - low!),
            over.offsetHeight * scale,
          ).data;
        let coloured = 0;
        for (let n = 0; n < data.length; n += 4) {
          const [r, g, b, a] = [data[n]!, data[n + 1]!, data[n + 2]!, data[n + 3]!];
          if (a > 20 && Math.max(r, g, b) - Math.min(r, g, b) > 40) coloured += 1;
        }
        return coloured / (data.length / 4);
      },
      [from, to],
    );

test.each(SPANS)('%s are asked for and drawn, with the gap', async (name, span_ms) => {
  asked = [];
  await page.getByLabel('Time shown').first().selectOption({ label: name });
  await page.locator('lf-trends').scrollIntoViewIfNeeded();
  const mine = () => asked.filter((query) => Number(query.get('to_ms')) - Number(query.get('from_ms')) === span_ms);
  await until(() => mine().length >= 2, LATE_MS);
  for (const query of mine()) expect(query.get('points')).toBe(span_ms > 2 * HOUR_MS ? '600' : '2400');
  const band = span_ms > 2 * HOUR_MS;
  // The plot still shows what was chosen before, until the answer is drawn.
  await until(async () => (await spanned()) === span_ms && typeof (await at(0.2))[0] === 'number');
  await until(async () => (typeof (await at(0.2))[2] === 'number') === band);
  const [mean, , least, , greatest] = await at(0.2);
  expect(mean).toBeCloseTo(0.4, 1);
  if (band) expect([least, greatest].map((one) => Math.round(one! * 10))).toEqual([1, 9]);
  else expect([least, greatest]).toEqual([null, null]);
  expect((await at(0.55))[0]).toBeNull();
  expect((await at(0.8))[0]).toBeCloseTo(0.4, 1);
  await until(async () => (await painted(0.1, 0.4)) > (band ? 0.3 : 0.003));
  expect(await painted(0.52, 0.58)).toBe(0);
  expect(await painted(0.65, 0.9)).toBeGreaterThan(band ? 0.3 : 0.003);
  const legend = page.getByText(/^Line: mean/).first();
  await expect.poll(() => legend.isVisible(), SOON).toBe(band);
});

test('a failed read is reported, and the last minutes continue', async () => {
  await page.unroute('**/api/history?*');
  await page.route('**/api/history?*', (route) =>
    route.fulfill({ status: 503, json: { error: { code: 'storage', text: { en: 'x', ru: 'x' } } } }),
  );
  await page.getByLabel('Time shown').first().selectOption({ label: '24 h' });
  await page
    .getByText(/^The history could not be read/)
    .first()
    .waitFor();
  await page.getByLabel('Time shown').first().selectOption({ label: '5 min' });
  await page.locator('lf-past').first().waitFor({ state: 'detached' });
  const rows = () =>
    page
      .locator('lf-plot#water')
      .evaluate((plot) => (plot as unknown as { columns: { length: number } }).columns.length);
  const before = await rows();
  await until(async () => (await rows()) > before);
});

test("the hub's own history has this shape", async () => {
  await page.unroute('**/api/history?*');
  const to = Date.now();
  for (const long of [HOUR_MS, 31 * 24 * HOUR_MS]) {
    const answer = await fetch(
      `${site.api}/api/history?monitor=M1&series=General.pressure&from_ms=${to - long}&to_ms=${to}&points=600`,
    );
    const told = (await answer.json()) as { resolution_ms: number; series: Record<string, number[][]> };
    expect(told.resolution_ms > 0).toBe(long > 2 * HOUR_MS);
    expect(Object.keys(told.series)).toEqual(['General.pressure']);
    for (const point of told.series['General.pressure']!) expect(point.length).toBe(long > 2 * HOUR_MS ? 4 : 2);
  }
});
