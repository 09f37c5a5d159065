// Login, and a session that ends during work.

import { readFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import type { Page, Route } from 'playwright-core';
import { afterAll, afterEach, beforeAll, describe, expect, test } from 'vitest';
import { Guarded } from './guarded';
import { LATE_MS, placed, SOON, shown, until } from './page';
import { Site } from './site';

const AXE = createRequire(import.meta.url).resolve('axe-core/axe.min.js');
const SIZES = [
  { width: 390, height: 844 },
  { width: 1440, height: 900 },
];

let site: Site;
let guarded: Guarded;
const pages: Page[] = [];

beforeAll(async () => {
  [site, guarded] = await Promise.all([Site.start(), Guarded.start()]);
});
afterAll(async () => {
  await site?.stop();
  await guarded?.stop();
});
afterEach(async () => {
  for (const page of pages.splice(0)) await page.context().close();
});

/** A page at the guarded hub, before a login. */
async function outside(lang = 'en', size = SIZES[1]): Promise<Page> {
  const page = await site.open('#/overview', lang, size);
  pages.push(page);
  await page.goto(`${guarded.url}/#/alarms`);
  await page.waitForSelector('lf-page-login input');
  // The first field has the focus.
  await until(() => page.locator('input[name=user]').evaluate((it) => it.matches(':focus')));
  return page;
}

/** The button, and what it says of itself at one moment. */
const enter = (page: Page) =>
  page.locator('#enter button').evaluate((it) => ({
    disabled: it.getAttribute('aria-disabled'),
    description: it.getAttribute('aria-description'),
  }));

async function tryWith(page: Page, password: string): Promise<void> {
  await page.fill('input[name=password]', password);
  await page.keyboard.press('Enter');
}

describe('login', () => {
  test('says what is wrong, counts the wait down, and then allows another attempt', async () => {
    const page = await outside();
    await page.keyboard.press('Enter');
    await page.getByText('Enter your user name').waitFor();
    await page.fill('input[name=user]', 'olga');
    await tryWith(page, 'wrong');
    await page.getByText('The user name or the password is wrong').waitFor();
    // The wait may be short: what is shown in it is read at one moment.
    const waits = () =>
      page.locator('lf-page-login').evaluate((it) => {
        const root = it.shadowRoot!;
        const button = root.querySelector('#enter')!.shadowRoot!.querySelector('button')!;
        const told = root.querySelector('[role=alert]')!.textContent!.includes('Several wrong attempts');
        const [disabled, description] = ['aria-disabled', 'aria-description'].map((name) => button.getAttribute(name));
        return told && description?.startsWith('Next') ? { disabled, description } : null;
      });
    let seen: Awaited<ReturnType<typeof waits>> = null;
    await until(async () => {
      await tryWith(page, 'wrong');
      seen = await waits();
      return seen !== null;
    }, LATE_MS);
    expect(seen).toEqual({ disabled: 'true', description: expect.stringMatching(/^Next attempt in \d+ s$/) });
    await until(async () => (await enter(page)).disabled === null, 2 * LATE_MS);
    await tryWith(page, guarded.password);
    await page.waitForSelector('lf-topbar');
    expect(page.url()).toContain('#/alarms');
    await expect.poll(() => page.title(), SOON).toBe('Alarms — lafet');
    await page.locator('lf-nav a', { hasText: 'Replay' }).waitFor();
    await until(async () => (await page.locator('lf-nav a', { hasText: 'Training' }).count()) === 0);
  });

  test('after a used set-up link', async () => {
    const page = await outside();
    await page.goto(guarded.link.replace(/^.*(?=\/setup)/, guarded.url));
    await page.getByText('This link has been used').waitFor();
    expect(await page.locator('lf-page-setup').count()).toBe(0);
  });

  test.each(['en', 'ru'])('axe finds nothing, targets are 48 px, nothing is cut off: %s', async (lang) => {
    for (const size of SIZES) {
      const page = await outside(lang, size);
      await page.keyboard.press('Enter');
      await page.locator('#wrong-user:not([hidden])').waitFor();
      await page.evaluate(readFileSync(AXE, 'utf8'));
      const found = await page.evaluate(() =>
        (window as unknown as { axe: { run: () => Promise<{ violations: { id: string }[] }> } }).axe.run(),
      );
      expect(found.violations.map(({ id }) => id)).toEqual([]);
      for (const control of await page.locator('lf-page-login input, lf-page-login lf-button button').all()) {
        expect((await placed(control)).height).toBeGreaterThanOrEqual(48);
      }
      const wide = await page.evaluate(() => document.scrollingElement!.scrollWidth);
      expect(wide).toBeLessThanOrEqual(size.width);
    }
  });
});

describe('a session that ends during work', () => {
  /** M1 turns, and the page asks to log in again; `end` ends its connection, as the hub does then. */
  async function expired(): Promise<{ page: Page; end: () => Promise<void> }> {
    const page = await site.open('#/overview');
    pages.push(page);
    let end = async () => {};
    await page.routeWebSocket(/api\/ws/, (ws) => {
      ws.connectToServer();
      end = () => ws.close({ code: 4401, reason: 'session ended' });
    });
    await page.goto(`${site.url}/?again#/m/M1/operate`);
    await shown(page);
    await site.send('M1', 'Move Horizontal -1800');
    await until(async () => (await site.position('M1')) === -1800 && (await site.stands('M1')), LATE_MS);
    const expired = {
      error: { code: 'login_needed', setup_needed: false, en: 'Log in first.', ru: 'Сначала войдите.' },
    };
    await page.route('**/api/audit?*', (route) => route.fulfill({ status: 401, json: expired }));
    await page.evaluate(() => {
      location.hash = '#/events';
    });
    await page.getByText('Your session has ended').waitFor();
    await site.send('M1', 'Move Horizontal 10000');
    await until(() => site.moves('M1'));
    return { page, end: () => end() };
  }

  test('keeps STOP: a motion is stopped from the login page', async () => {
    const { page } = await expired();
    await page.getByText('STOP and LOCKOUT still work here as long as there is a connection').waitFor();
    await page.locator('#stop').click();
    expect(await site.stands('M1')).toBe(true);
    expect(await site.position('M1')).toBeLessThan(9600);
  });

  test.each(['breaks', 'answers nothing'])('sends a STOP again there, whose connection %s', async (what) => {
    const { page, end } = await expired();
    await end();
    await page.getByText('Your session has ended. Log in again').waitFor();
    let sent = 0;
    const lose = (route: Route) => (what === 'breaks' ? route.abort() : undefined);
    await page.route('**/api/stop', (route) => (++sent === 1 ? lose(route) : route.continue()));
    await page.locator('#stop').click();
    await until(() => sent > 1, LATE_MS);
    expect(await site.stands('M1')).toBe(true);
    expect(await site.position('M1')).toBeLessThan(9600);
  });

  test('while the page sleeps: a connection that is refused leads to the login', async () => {
    const page = await site.open('#/overview');
    pages.push(page);
    let wake = async () => {};
    await page.routeWebSocket(/api\/ws/, (ws) => {
      ws.connectToServer();
      wake = () => ws.close({ code: 4408, reason: 'silent' });
    });
    await guarded.enter(page, 'olga');
    await page.context().clearCookies();
    await wake();
    await page.getByText('Your session has ended').waitFor();
  });

  test('by an administrator: STOP still works, LOCKOUT is not offered, and the page says so', async () => {
    const page = await site.open('#/overview');
    pages.push(page);
    await guarded.enter(page, 'olga');
    await guarded.throwOut('olga');
    await page.getByText('Only STOP still works here, for 10 min').waitFor();
    expect(await page.locator('#lockout').count()).toBe(0);
    const stopped = page.waitForResponse((it) => it.url().endsWith('/api/stop'));
    await page.keyboard.press('F9');
    expect((await stopped).status()).toBe(200);
    await expect.poll(() => page.locator('#stop').isVisible(), SOON).toBe(true);
  });
});
