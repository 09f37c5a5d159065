// The picture of a camera in Operate: it moves, is never old without saying so, and covers nothing that stops.
import type { Locator, Page } from 'playwright-core';
import { afterAll, afterEach, beforeAll, beforeEach, expect, test } from 'vitest';
import type { CameraNow } from '../../src/hub/api';
import { Camera } from './camera';
import { drawn, LATE_MS, placed, settled, until } from './page';
import { Site } from './site';

/** What the page says of an old picture comes within 2 s; the rest is for a busy machine. */
const OLD_MS = 2000;
const BUSY_MS = 3000;

let camera: Camera;
let site: Site;
let page: Page;

beforeAll(async () => {
  camera = await Camera.start();
  const name = '{ en = "Mast west", ru = "Мачта, запад" }';
  site = await Site.start(`[[camera]]\nid = "C1"\nname = ${name}\nurl = "${camera.url}"\nmonitors = ["M1"]\n`);
});
afterAll(async () => {
  await site?.stop();
  camera?.close();
});
beforeEach(async () => {
  page = await site.open('#/m/M1/operate');
});
afterEach(async () => {
  camera.stalled = false;
  await site.rest([page]);
});

const picture = () => page.locator('lf-camera lf-picture');
const says = () => picture().locator('.says');
const age = () => picture().locator('.age', { hasText: /\d/ });

async function state(): Promise<CameraNow> {
  const all = (await (await fetch(`${site.api}/api/cameras`)).json()) as CameraNow[];
  return all[0]!;
}

/** The colour in the middle of what is drawn. */
async function colour(): Promise<number[]> {
  return picture()
    .locator('canvas')
    .evaluate((it) => {
      const canvas = it as HTMLCanvasElement;
      return [...canvas.getContext('2d')!.getImageData(canvas.width / 2, canvas.height / 2, 1, 1).data];
    });
}

/** Whether a press in its middle is one of this element. */
async function reachable(what: Locator): Promise<boolean> {
  await placed(what);
  return what.evaluate((it) => {
    const { x, y, width, height } = it.getBoundingClientRect();
    let top = document.elementFromPoint(x + width / 2, y + height / 2);
    while (top?.shadowRoot) {
      const inner = top.shadowRoot.elementFromPoint(x + width / 2, y + height / 2);
      if (!inner || inner === top) break;
      top = inner;
    }
    for (let at: Node | null = top; at; at = at instanceof ShadowRoot ? at.host : at.parentNode) {
      if (at === it) return true;
    }
    return false;
  });
}

test('the picture is shown with its age, and an old one says that it is old', async () => {
  await age().waitFor({ timeout: LATE_MS });
  await until(async () => {
    const [red, green, blue] = await colour();
    return red! > 150 && green! < 80 && blue! < 80;
  });
  expect(await page.locator('lf-camera .name').textContent()).toBe('Mast west');
  const { codec, size, state: word, viewers } = await state();
  expect([word, size, viewers]).toEqual(['playing', [64, 48], 1]);
  expect(codec).toMatch(/^avc1\./);
  camera.stalled = true;
  const began = performance.now();
  await says()
    .getByText('Old picture')
    .waitFor({ timeout: OLD_MS + BUSY_MS });
  expect(performance.now() - began).toBeLessThan(OLD_MS + BUSY_MS);
  await says().getByText('The camera sends no new picture').waitFor();
  expect(await picture().locator('canvas.old').count()).toBe(1);
  camera.stalled = false;
  await age().waitFor({ timeout: LATE_MS });
  expect(await picture().locator('canvas.old').count()).toBe(0);
});

test('a picture is old too when the way to the hub is dead', async () => {
  await age().waitFor({ timeout: LATE_MS });
  site.way.freeze();
  await says()
    .getByText('Old picture')
    .waitFor({ timeout: OLD_MS + BUSY_MS });
  site.way.mend();
  await age().waitFor({ timeout: LATE_MS });
});

test('small, large or hidden, it covers nothing that stops', async () => {
  const stop = page.locator('#stop').first();
  await age().waitFor({ timeout: LATE_MS });
  const small = await placed(page.locator('lf-camera'));
  expect(await reachable(stop)).toBe(true);
  await page.locator('lf-camera').getByText('Larger').click();
  await settled(page);
  const large = await placed(page.locator('lf-camera'));
  expect(large.width * large.height).toBeGreaterThan(2 * small.width * small.height);
  for (const what of ['#stop', '#deploy', '#camera'])
    expect(await reachable(page.locator(what).first()), what).toBe(true);
  await site.sentAway();
  await stop.click();
  expect(await site.stands('M1')).toBe(true);
  await page.locator('lf-camera').getByText('Smaller').click();
  await page.locator('lf-camera').getByRole('button', { name: 'Hide the camera' }).click();
  await page.locator('lf-camera').waitFor({ state: 'detached' });
  await until(async () => (await state()).viewers === 0, LATE_MS);
  await page.locator('#camera').click();
  await age().waitFor({ timeout: LATE_MS });
});

test('another monitor shows none, and a camera that is gone says why, in Russian too', async () => {
  const other = await site.open('#/m/M2/operate', 'ru');
  await settled(other);
  expect(await other.locator('lf-camera, #camera').count()).toBe(0);
  await other.context().close();
  const russian = await site.open('#/m/M1/operate', 'ru');
  await russian.locator('lf-camera .name', { hasText: 'Мачта, запад' }).waitFor();
  camera.close();
  try {
    await russian.locator('lf-picture .says', { hasText: 'С камерой нет связи' }).waitFor({ timeout: LATE_MS });
    await drawn(page);
    await says().getByText('The camera cannot be reached').waitFor();
  } finally {
    await russian.context().close();
  }
});
