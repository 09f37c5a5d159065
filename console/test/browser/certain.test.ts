// STOP gets through whatever happens to the page and to the network, nothing is pressed by mistake, and nothing that is
// not known looks as if it were.
import type { CDPSession, Page } from 'playwright-core';
import { afterAll, afterEach, beforeAll, beforeEach, describe, expect, test } from 'vitest';
import { able, drawn, middle, passes, placed, SOON, shown, take, until } from './page';
import { Site } from './site';

const SHORT_ARCMIN = 60;

let site: Site;
let page: Page;

beforeAll(async () => {
  site = await Site.start();
});
afterAll(() => site?.stop());

beforeEach(async () => {
  page = await site.open('#/m/M1/operate');
});

afterEach(() => site.rest([page]));

async function stoppedShortOf(target: number): Promise<void> {
  expect(await site.stands('M1')).toBe(true);
  expect(Math.abs((await site.position('M1')) - target)).toBeGreaterThan(SHORT_ARCMIN);
}

const toasts = (text: string) => page.locator('lf-toasts .toast', { hasText: text });
const locked = async () => (await site.outputs('M1')).General!.flags.includes('LockedOut');

describe('STOP', () => {
  test('is the click of an assistive technology too, whatever else that says', async () => {
    const target = await site.sentAway();
    await page.locator('#stop').evaluate((it) => {
      it.dispatchEvent(new MouseEvent('click', { bubbles: true, composed: true, detail: 1 }));
    });
    await stoppedShortOf(target);
  });

  test('has its keys without its bar, and gets its bar back', async () => {
    const target = await site.sentAway();
    await page.evaluate(() => {
      const bar = document.querySelector('lf-app')!.shadowRoot!.querySelector('lf-stop')!;
      bar.remove();
      const key = { key: 'F9', code: 'F9', bubbles: true, composed: true, cancelable: true };
      document.body.dispatchEvent(new KeyboardEvent('keydown', key));
    });
    await stoppedShortOf(target);
    await page.locator('#stop').waitFor();
    const again = await site.sentAway();
    await page.locator('#stop').click();
    await stoppedShortOf(again);
  });

  test('into a dead network is said not to be confirmed, and sent again when it lives', async () => {
    site.way.freeze();
    await page.locator('#stop').click();
    await toasts('NOT CONFIRMED').waitFor();
    await page.getByText('No connection to the hub').first().waitFor();
    await passes(page, 1000);
    expect(await toasts('NOT CONFIRMED').count()).toBe(1);
    // What has not reached the hub is lost with its connections: only what is sent again can stop it.
    site.way.cut();
    const target = await site.sentAway();
    site.way.mend();
    await toasts('NOT CONFIRMED').waitFor({ state: 'detached' });
    await stoppedShortOf(target);
  });

  test('stays in sight, as large as always, when two fingers magnify the page', async () => {
    await page.context().close();
    page = await site.open('#/m/M1/operate', 'en', { width: 1024, height: 768 }, true);
    const zoom = await page.evaluate(() => getComputedStyle(document.body).touchAction);
    expect(zoom).toBe('pan-x pan-y');
    const plain = await placed(page.locator('#stop'));
    const cdp = await page.context().newCDPSession(page);
    await cdp.send('Emulation.setPageScaleFactor', { pageScaleFactor: 2 });
    await expect.poll(() => page.evaluate(() => visualViewport!.scale), SOON).toBe(2);
    const seen = () =>
      page.locator('#stop').evaluate((it) => {
        const { left, right, top, bottom, width } = it.getBoundingClientRect();
        const { offsetLeft, offsetTop, width: across, height: high, scale } = visualViewport!;
        const inside = left >= offsetLeft && right <= offsetLeft + across + 1;
        return [inside && top >= offsetTop && bottom <= offsetTop + high + 1, Math.round(width * scale)];
      });
    await expect.poll(seen, SOON).toEqual([true, Math.round(plain.width)]);
  });
});

describe('LOCKOUT', () => {
  let cdp: CDPSession;
  const touch = (type: 'touchStart' | 'touchMove' | 'touchEnd', at?: [number, number]) =>
    cdp.send('Input.dispatchTouchEvent', { type, touchPoints: at ? [{ x: at[0], y: at[1] }] : [] });

  test('is offered while an old value says that it is in force', async () => {
    await site.send('M1', 'Lockout All on');
    await page.locator('#release').waitFor();
    site.links[0]!.freeze();
    await page.locator('#stale').waitFor();
    await page.locator('#lockout').waitFor();
    site.links[0]!.mend();
    await page.locator('#release').waitFor();
    site.way.cut();
    await page.locator('#lockout').waitFor();
  });

  test('is held by a finger that trembles, and not by one that slides off', async () => {
    await page.context().close();
    page = await site.open('#/m/M1/operate', 'en', { width: 1024, height: 768 }, true);
    await take(page);
    cdp = await page.context().newCDPSession(page);
    const [x, y] = await middle(page.locator('#lockout'));
    await touch('touchStart', [x, y]);
    await touch('touchMove', [x, y + 120]);
    await passes(page, 900);
    await touch('touchEnd');
    expect(await locked()).toBe(false);
    // A page that stalls while it is held ends the hold, as it must: then the finger comes again.
    for (let tries = 0; tries < 4 && !(await locked()); tries += 1) {
      await passes(page, 3200);
      await touch('touchStart', [x, y]);
      for (let n = 0; n < 16 && !(await locked()); n += 1) {
        await touch('touchMove', [x + (n % 2 ? 12 : -12), y + (n % 2 ? 14 : 0)]);
        await passes(page, 120);
      }
      await touch('touchEnd');
    }
    await until(locked, 5000);
  });
});

describe('a hand that is on its way', () => {
  test('does not hit what has just come up', async () => {
    await page.locator('#readiness').click();
    const close = page.locator('lf-dialogs header lf-button');
    const [x, y] = await middle(close);
    await passes(page, 600);
    await page.mouse.click(x, y);
    await page.getByRole('dialog').waitFor({ state: 'detached' });
    const moved = await page.locator('#readiness').evaluate(
      async (it, [x, y]) => {
        (it as HTMLElement).click();
        const dialogs = document.querySelector('lf-app')!.shadowRoot!.querySelector('lf-dialogs')!;
        while (!dialogs.shadowRoot!.querySelector('.dialog')) await new Promise(requestAnimationFrame);
        await new Promise(requestAnimationFrame);
        const hit = () => dialogs.shadowRoot!.elementFromPoint(x, y)!;
        const button = dialogs.shadowRoot!.querySelector('header lf-button')!;
        // The style keeps a pointer away; an event that has found its way all the same is stopped.
        const told = [hit() === button];
        for (const type of ['pointerdown', 'click']) {
          button.dispatchEvent(new PointerEvent(type, { bubbles: true, composed: true, detail: 1 }));
        }
        await new Promise(requestAnimationFrame);
        return [...told, dialogs.shadowRoot!.querySelector('.dialog') !== null];
      },
      [x, y] as const,
    );
    expect(moved).toEqual([false, true]);
    await passes(page, 600);
    await page.mouse.click(x, y);
    await page.getByRole('dialog').waitFor({ state: 'detached' });
  });

  test('starts no program by a click', async () => {
    await take(page);
    await able(page.locator('#program')).click();
    const rows = page.locator('lf-dialogs .body lf-hold');
    await rows.first().waitFor();
    expect(await rows.count()).toBe(8);
  });

  test('points at nothing that it has given up, or that comes too late', async () => {
    await take(page);
    let delay_ms = 3000;
    await page.route('**/api/monitors/M1/aim', async (route) => {
      await new Promise((done) => setTimeout(done, delay_ms));
      const json = { elevation_arcmin: 300, fault: null, pressure_datm: 79 };
      await route.fulfill({ json }).catch(() => {});
    });
    await able(page.locator('#aim')).click();
    await page.locator('#aim button[aria-pressed=true]').waitFor();
    await drawn(page);
    const plan = await placed(page.locator('lf-plan'));
    const point = () => page.mouse.click(plan.x + plan.width * 0.6, plan.y + plan.height * 0.5);
    const stood = await site.position('M1');
    await point();
    await toasts('took too long').waitFor();
    await passes(page, 2500);
    expect(await site.position('M1')).toBe(stood);
    delay_ms = 700;
    await point();
    await page.keyboard.press('Escape');
    await passes(page, 1500);
    expect(await site.stands('M1')).toBe(true);
    expect(await site.position('M1')).toBe(stood);
  });
});

describe('what is not known', () => {
  test('the state of a valve that is old says so, and has no colour', async () => {
    await site.send('M1', 'Open Valve1');
    const valve = page.locator('#Valve1');
    await valve.and(page.locator('.open')).waitFor();
    site.links[0]!.freeze();
    const was = valve.filter({ hasText: /was: open, \d+ s(ec)? ago/ });
    await was.and(page.locator(':not(.open)')).waitFor();
    site.links[0]!.mend();
    await valve.and(page.locator('.open')).waitFor();
    await site.send('M1', 'Close Valve1');
    await until(async () => (await site.outputs('M1')).Valve1!.flags.includes('Closed'));
  });

  /** The page again, with what the hub says changed on its way, and what the page says lost on it. */
  async function between(
    change: (message: string) => string,
    loses: (message: string) => boolean = () => false,
  ): Promise<{ close: (code: number, reason: string) => void }> {
    const last = { close: (_code: number, _reason: string) => {} };
    await page.routeWebSocket(/api\/ws/, (ws) => {
      const hub = ws.connectToServer();
      last.close = (code, reason) => void ws.close({ code, reason });
      hub.onMessage((message) => ws.send(change(String(message))));
      ws.onMessage((message) => loses(String(message)) || hub.send(message));
    });
    await page.goto(`${site.url}/?again#/m/M1/operate`);
    await shown(page);
    await page.evaluate(() => Object.assign(window, { old: true }));
    return last;
  }
  const isOld = () => page.evaluate(() => 'old' in window).catch(() => true);

  test('a hub that was updated: the page says so, and is loaded again once no dialog is open', async () => {
    let version = '1.0.0';
    const link = await between((message) => message.replace(/("version":)"[^"]*"/, `$1"${version}"`));
    await page.locator('#readiness').click();
    await page.getByRole('dialog').waitFor();
    version = '2.0.0';
    link.close(4408, 'silent');
    await page.getByText('The hub has been updated').waitFor();
    await passes(page, 4500);
    expect(await isOld()).toBe(true);
    await page.keyboard.press('Escape');
    await until(async () => !(await isOld()));
    await shown(page);
    expect(await page.getByText('The hub has been updated').count()).toBe(0);
  });

  test('a hub that was updated: what is not confirmed stays, and the page is loaded again after it', async () => {
    let version = '1.0.0';
    let lost = true;
    const link = await between(
      (message) => message.replace(/("version":)"[^"]*"/, `$1"${version}"`),
      (message) => lost && message.includes('"type":"stop"'),
    );
    await page.route('**/stop', (route) => (lost ? route.abort() : route.continue()));
    await page.keyboard.press('F9');
    await toasts('NOT CONFIRMED').waitFor();
    version = '2.0.0';
    link.close(4408, 'silent');
    await page.getByText('The hub has been updated').waitFor();
    await passes(page, 4500);
    expect(await isOld()).toBe(true);
    expect(await toasts('NOT CONFIRMED').count()).toBe(1);
    lost = false;
    link.close(4408, 'silent');
    await until(async () => !(await isOld()));
    await shown(page);
  });

  test('a seat that another window has resumed: the page takes a new one, and says where control is', async () => {
    const seats: string[] = [];
    const link = await between((message) => {
      const seat = /"type":"hello".*?"seat":"([^"]+)"/.exec(message)?.[1];
      if (seat) seats.push(seat);
      return message;
    });
    link.close(4410, 'resumed elsewhere');
    await toasts('Control is in the other window').waitFor();
    await until(() => seats.length === 2);
    expect(seats[1]).not.toBe(seats[0]);
  });

  test('an error of the page itself: it says that its values may be old', async () => {
    await page.evaluate(() => void Promise.reject(new Error('odd')));
    await page.locator('lf-banners').getByText('what it shows may be old').waitFor();
    expect(await page.evaluate(() => document.documentElement.translate)).toBe(false);
  });
});
