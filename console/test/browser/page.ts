// What a hand and an eye do at a page, however slow the machine is: nothing is read before it is drawn, nothing is
// pressed before it is enabled and at rest.
import type { Locator, Page, Request } from 'playwright-core';
import { STEPS, type StepId } from '../../src/pages/commissioning/model';

/** Limit of what must come at some time, on a machine that is loaded several times over. */
export const LATE_MS = 60_000;
/** For `expect.poll`: what the page shows after an update. */
export const SOON = { timeout: LATE_MS, interval: 50 };
/** A hand holds for this time before it releases and tries again. */
const HELD_MS = 5000;

export interface Box {
  x: number;
  y: number;
  width: number;
  height: number;
}

/** Waits until the condition is true; fails on a timeout. */
export async function until(so: () => Promise<boolean> | boolean, within_ms = 30_000): Promise<void> {
  const end = performance.now() + within_ms;
  while (!(await so())) {
    if (performance.now() > end) throw new Error(`not so within ${within_ms} ms: ${so}`);
    await new Promise((done) => setTimeout(done, 20));
  }
}

/** Two frames of the screen later: what has arrived is drawn. */
export async function drawn(page: Page): Promise<void> {
  await page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))));
}

/** So much time of the page itself: it has none while it is stalled. */
export async function passes(page: Page, ms: number): Promise<void> {
  await page.evaluate((for_ms) => new Promise((done) => setTimeout(done, for_ms)), ms);
}

/** The page that the address names is there, with the hub's state, and waits for nothing. */
export async function shown(page: Page): Promise<void> {
  await until(() => page.evaluate(isShown), LATE_MS);
  await drawn(page);
}

function isShown(): boolean {
  const here = document.querySelector('lf-app')?.shadowRoot?.querySelector('main > *');
  const parts = location.hash.replace(/^#\/?/, '').split('?')[0]!.split('/');
  const [name, monitor] = parts[0] === 'm' ? [parts[2], decodeURIComponent(parts[1]!)] : [parts[0], null];
  if (here?.localName !== `lf-page-${name}` || !here.shadowRoot) return false;
  if (((here as unknown as { monitor?: string | null }).monitor ?? null) !== monitor) return false;
  const waits = (root: ParentNode): boolean =>
    root.querySelector('[aria-busy=true]') !== null ||
    [...root.querySelectorAll('*')].some((one) => one.shadowRoot !== null && waits(one.shadowRoot));
  return !waits(here.shadowRoot);
}

/** Goes to another page by its address. */
export async function go(page: Page, route: string): Promise<void> {
  await page.evaluate((to) => {
    location.hash = to;
  }, route);
  await shown(page);
}

/** The addresses of all pages in the navigation. */
export async function pagesOf(page: Page): Promise<string[]> {
  await shown(page);
  const links = page.locator('lf-nav a');
  await links.and(page.locator('[href$="/inspector"]')).waitFor({ state: 'attached' });
  return links.evaluateAll((all) => all.map((one) => one.getAttribute('href')!));
}

const underway = new WeakMap<Page, Set<Request>>();

/** Takes note of the page's queries, for `settled`. */
export function follow(page: Page): Page {
  const all = new Set<Request>();
  underway.set(page, all);
  page.on('request', (one) => all.add(one));
  page.on('requestfinished', (one) => all.delete(one));
  page.on('requestfailed', (one) => all.delete(one));
  return page;
}

/** The page is shown, its queries are answered, and the answers are drawn. */
export async function settled(page: Page): Promise<void> {
  await shown(page);
  let quiet = 0;
  await until(async () => {
    await drawn(page);
    quiet = underway.get(page)!.size === 0 ? quiet + 1 : 0;
    return quiet >= 5;
  }, LATE_MS);
}

/** Where an element is, once it has stayed there for some frames. */
export function placed(of: Locator): Promise<Box> {
  return of.evaluate(async (it) => {
    const read = () => {
      const { x, y, width, height } = it.getBoundingClientRect();
      return { x, y, width, height };
    };
    let box = read();
    for (let [frames, same] = [0, 0]; same < 5; frames += 1) {
      if (!it.isConnected || frames > 600) throw new Error(`${it.localName} does not come to rest`);
      await new Promise(requestAnimationFrame);
      const now = read();
      same = JSON.stringify(now) === JSON.stringify(box) ? same + 1 : 0;
      box = now;
    }
    return box;
  });
}

export async function middle(of: Locator): Promise<[x: number, y: number]> {
  const { x, y, width, height } = await placed(of);
  return [x + width / 2, y + height / 2];
}

/** The button in an `lf-button` or `lf-hold`, enabled: late data may disable it for a moment. */
export const able = (host: Locator): Locator => host.locator('button:not([aria-disabled=true])');

/**
 * The button that takes control, as soon as it can: a page that was closed keeps its monitor for `lost_ms`, and until
 * then the same button asks its holder.
 */
export function takeButton(page: Page): Locator {
  return able(page.locator('#take', { hasText: /^\s*(Take control|Взять управление)\s*$/ }));
}

/** Takes control of M1 on one of its pages; until the page has it, its buttons are disabled. */
export async function take(page: Page): Promise<void> {
  await takeButton(page).click();
  await page
    .getByText(/^(You control M1|Стволом M1 управляете вы)$/)
    .first()
    .waitFor();
  await drawn(page);
}

/**
 * Presses a button for at least this time and releases it; returns how long the button itself has seen it
 * pressed. On a busy machine that is longer than intended, and it is what counts.
 */
export async function press(page: Page, button: Locator, for_ms: number): Promise<number> {
  await button.hover();
  await button.evaluate((it) => {
    const seen = window as unknown as { pressed: Record<string, number> };
    seen.pressed = {};
    const note = (event: Event) => (seen.pressed[event.type] = event.timeStamp);
    it.addEventListener('pointerdown', note, { capture: true, once: true });
    window.addEventListener('pointerup', note, { capture: true, once: true });
  });
  await page.mouse.down();
  if (for_ms > 0) await passes(page, for_ms);
  await page.mouse.up();
  const { pointerdown, pointerup } = await page.evaluate(
    () => (window as unknown as { pressed: Record<string, number> }).pressed,
  );
  if (pointerdown === undefined || pointerup === undefined) throw new Error('the button has not seen the press');
  return pointerup - pointerdown;
}

/**
 * Holds until the condition is true; the pointer stays where it is. On a busy machine the page's heartbeats
 * may be late, and the motion ends, as it must: then the button is released, which the page must see, and
 * held again.
 */
export async function heldUntil(
  page: Page,
  sign: () => Promise<boolean>,
  hold: () => Promise<void>,
  leave: () => Promise<void>,
): Promise<void> {
  for (let n = 0; n < 8; n += 1) {
    await hold();
    const seen = await until(sign, HELD_MS).then(
      () => true,
      () => false,
    );
    if (seen) return;
    await leave();
    await drawn(page);
  }
  throw new Error(`nothing comes of what the hand holds: ${sign}`);
}

/** Holds a button until the condition is true, then releases it. */
export async function holdUntil(page: Page, button: Locator, sign: () => Promise<boolean>): Promise<void> {
  const hold = async () => {
    await button.hover();
    await page.mouse.down();
  };
  await heldUntil(page, sign, hold, () => page.mouse.up());
  await page.mouse.up();
}

/** Presses once, until the condition is true, then releases. */
export async function pressUntil(page: Page, button: Locator, so: () => Promise<boolean>): Promise<void> {
  await button.hover();
  await page.mouse.down();
  try {
    await until(so);
  } finally {
    await page.mouse.up();
  }
}

/** Presses until it has its effect: a press on what has just come up does not count. */
export async function clickUntil(page: Page, button: Locator, so: () => Promise<boolean>): Promise<void> {
  await button.waitFor();
  await until(async () => {
    if (!(await so())) await button.click({ timeout: 1000 }).catch(() => undefined);
    await passes(page, 1000);
    return so();
  }, LATE_MS);
}

/** On M1's page of commissioning: everything before this step is passed, and the page is in control. */
export async function passTo(page: Page, step: StepId): Promise<void> {
  await page.evaluate(
    (before) => {
      const done = { state: 'passed', at_ms: 1, by: 'demo', facts: [] };
      const steps = Object.fromEntries(before.map((id) => [id, done]));
      localStorage.setItem('lafet.commissioning.M1', JSON.stringify({ begun_ms: 1, steps, work: {} }));
    },
    STEPS.slice(0, STEPS.indexOf(step)),
  );
  await page.reload();
  await settled(page);
  await take(page);
  await page.locator(`lf-step-${step}`).waitFor();
}
