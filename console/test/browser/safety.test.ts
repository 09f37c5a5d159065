// The rules that keep people safe, each checked at the monitor's outputs.
import type { CDPSession, Locator, Page } from 'playwright-core';
import { afterAll, afterEach, beforeAll, beforeEach, describe, expect, test } from 'vitest';
import { heldUntil, press, pressUntil, Site, take, until } from './site';

const PAD_STOP = 1;
const FAR_ARCMIN = 5000;
/** A drive that something has stopped is at least this far from its target. */
const SHORT_ARCMIN = 60;

let site: Site;
let page: Page;
/** Where M1 pointed at the start of the test. */
let began: number;
const others: Page[] = [];

beforeAll(async () => {
  site = await Site.start();
});
afterAll(() => site?.stop());

beforeEach(async () => {
  page = await site.open('#/m/M1/operate');
  began = await site.position('M1');
});

afterEach(async () => {
  site.way.mend();
  for (const link of site.links) link.mend();
  for (const one of [page, ...others.splice(0)]) await one.context().close();
  for (const id of ['M1', 'M2']) {
    await until(async () => (await site.holder(id)) === null);
    await site.send(id, 'Lockout All off');
    await site.send(id, 'Stop All');
    await site.send(id, 'Close Valve1');
    // Back, where the next motion would meet a limit.
    if (Math.abs(await site.position(id)) > FAR_ARCMIN) {
      await site.send(id, 'Move Horizontal 0');
      await until(async () => Math.abs(await site.position(id)) < 60, 40_000);
    }
    await until(async () => !(await site.moves(id)));
  }
});

/** Moves it without the console, as another client would. */
async function sent(request: string, id = 'M1'): Promise<void> {
  await site.send(id, request);
  await until(() => site.moves(id));
}

/** Holds until the barrel moves and has turned. */
async function begun(hold: () => Promise<void>, leave: () => Promise<void>): Promise<void> {
  const stood = await site.position('M1');
  await heldUntil(page, async () => (await site.moves('M1')) && (await site.position('M1')) !== stood, hold, leave);
}

/** Pulls the stick to the left; returns where the pointer is. */
async function pull(): Promise<[x: number, y: number]> {
  const stick = (await page.locator('lf-joystick .base').boundingBox())!;
  const [x, y] = [stick.x + stick.width / 2, stick.y + stick.height / 2];
  const hold = async () => {
    await page.mouse.move(x, y);
    await page.mouse.down();
    await page.mouse.move(x - 60, y, { steps: 3 });
  };
  await begun(hold, () => page.mouse.up());
  return [x - 60, y];
}

async function pressKey(key: string): Promise<void> {
  await begun(
    () => page.keyboard.down(key),
    () => page.keyboard.up(key),
  );
}

/** It is at rest, and not because it has reached its target. */
async function stoppedShortOf(target: number, id = 'M1', where = ''): Promise<void> {
  expect(await site.stands(id), where).toBe(true);
  expect(Math.abs((await site.position(id)) - target), where).toBeGreaterThan(SHORT_ARCMIN);
}

describe('a held motion', () => {
  test('ends with the release', async () => {
    await take(page);
    await pull();
    await page.mouse.up();
    expect(await site.stands('M1')).toBe(true);
    expect(await site.position('M1')).toBeGreaterThan(began);
  });

  test('is what the hand does, not what the page does under it', async () => {
    await take(page);
    const [x, y] = await pull();
    const stick = page.locator('lf-joystick .base');
    const [old, height] = [(await stick.boundingBox())!.y, await site.position('M1', 'Vertical')];
    await page.locator('lf-joystick').evaluate((it: HTMLElement) => {
      it.style.translate = '0 80px';
    });
    expect((await stick.boundingBox())!.y - old).toBeGreaterThan(60);
    const there = await site.position('M1');
    await page.mouse.move(x - 1, y);
    // Long enough for another drive to begin.
    await until(async () => (await site.position('M1')) > there + 1200);
    expect(await site.position('M1', 'Vertical')).toBe(height);
    await page.mouse.up();
    expect(await site.stands('M1')).toBe(true);
  });

  test('of a key ends with its release, and opposite keys mean nothing', async () => {
    await take(page);
    await pressKey('ArrowRight');
    await until(async () => (await site.position('M1')) < began);
    await page.keyboard.down('ArrowLeft');
    expect(await site.stands('M1')).toBe(true);
    await page.keyboard.up('ArrowLeft');
    await page.keyboard.up('ArrowRight');
    expect(await site.stands('M1')).toBe(true);
    expect(await site.position('M1')).toBeLessThan(began);
  });

  test('ends when the window loses the focus', async () => {
    await take(page);
    await pull();
    await page.evaluate(() => window.dispatchEvent(new Event('blur')));
    expect(await site.stands('M1')).toBe(true);
  });

  test('ends when the tab is left, and does not come back by itself', async () => {
    await take(page);
    await pull();
    await page.evaluate(() => {
      Object.defineProperty(document, 'hidden', { configurable: true, value: true });
      document.dispatchEvent(new Event('visibilitychange'));
    });
    expect(await site.stands('M1')).toBe(true);
    await page.evaluate(() => {
      Object.defineProperty(document, 'hidden', { configurable: true, value: false });
      document.dispatchEvent(new Event('visibilitychange'));
    });
    expect(await site.stands('M1')).toBe(true);
  });

  test('ends when the page is closed', async () => {
    await take(page);
    await pull();
    await page.close();
    expect(await site.stands('M1')).toBe(true);
  });

  test('ends when the link breaks', async () => {
    await take(page);
    await pull();
    site.way.cut();
    expect(await site.stands('M1')).toBe(true);
  });

  test('ends when the link falls silent, and late messages move nothing', async () => {
    await take(page);
    await pull();
    site.way.freeze();
    expect(await site.stands('M1')).toBe(true);
    site.way.mend();
    expect(await site.stands('M1')).toBe(true);
  });

  test('ends when the page stalls', async () => {
    await take(page);
    await pull();
    await page.evaluate(() => {
      const end = performance.now() + 900;
      while (performance.now() < end);
    });
    expect(await site.stands('M1')).toBe(true);
  });

  test('ends when a dialog opens', async () => {
    await take(page);
    await pressKey('ArrowLeft');
    await page.locator('#readiness').click();
    expect(await site.stands('M1')).toBe(true);
    await page.keyboard.up('ArrowLeft');
  });

  test('does not begin without control, and the page says why', async () => {
    await page.keyboard.down('ArrowLeft');
    await page.getByText('Take control of M1 first').first().waitFor();
    expect(await site.stands('M1')).toBe(true);
    expect(await site.position('M1')).toBe(began);
    await page.keyboard.up('ArrowLeft');
  });
});

describe('STOP', () => {
  test('stops from every page, by pointer and by key', async () => {
    const names = await page
      .locator('lf-nav a')
      .evaluateAll((all) => all.map((a) => (a as HTMLAnchorElement).getAttribute('href')!));
    expect(names.length).toBeGreaterThan(1);
    for (const [n, href] of names.entries()) {
      await page.evaluate((to) => (location.hash = to), href);
      await page.locator('main > *').first().waitFor();
      for (const [way, stop] of [
        ['pointer', () => page.locator('#stop').click()],
        ['F9', () => page.keyboard.press('F9')],
        ['Shift+Escape', () => page.keyboard.press('Shift+Escape')],
      ] as const) {
        const target = (await site.position('M1')) > 0 ? -10_000 : 10_000;
        await sent(`Move Horizontal ${target}`);
        await stop();
        await stoppedShortOf(target, 'M1', `${n} ${href} ${way}`);
      }
    }
  });

  test('stops while a dialog is open, by pointer and by key', async () => {
    await page.locator('#readiness').click();
    await page.getByRole('dialog').waitFor();
    await sent('Move Horizontal 9000');
    await page.locator('#stop').click();
    await stoppedShortOf(9000);
    await sent('Move Horizontal -9000');
    await page.keyboard.press('F9');
    await stoppedShortOf(-9000);
    await sent('Move Horizontal 9000');
    await page.keyboard.press('Pause');
    await stoppedShortOf(9000);
  });

  test('is above everything that a page puts into the top layer', async () => {
    await page.evaluate(() => {
      const cover = document.createElement('div');
      cover.popover = 'manual';
      cover.style.cssText = 'position:fixed;inset:0;width:100vw;height:100vh;margin:0';
      document.body.append(cover);
      cover.showPopover();
    });
    await sent('Move Horizontal 9000');
    await page.locator('#stop').click({ timeout: 2000 });
    expect(await site.stands('M1')).toBe(true);
  });

  test('is what the first Tab reaches', async () => {
    await page.keyboard.press('Tab');
    await sent('Move Horizontal 9000');
    await page.keyboard.press('Enter');
    expect(await site.stands('M1')).toBe(true);
  });

  test('of all stops them all, of one leaves the others alone', async () => {
    for (const id of ['M1', 'M2']) await sent('Move Horizontal 9000', id);
    await page.locator('#stop').click();
    await stoppedShortOf(9000);
    // It continues; on a busy machine it has reached its target meanwhile.
    expect((await site.moves('M2')) || (await site.position('M2')) === 9000).toBe(true);
    await sent('Move Horizontal -9000', 'M2');
    await page.locator('#stop-all').click();
    await stoppedShortOf(-9000, 'M2');
  });

  test('of a user without control stops what another one holds', async () => {
    await take(page);
    const other = await site.open('#/overview');
    others.push(other);
    await pull();
    await other.locator('#stop').click();
    expect(await site.stands('M1')).toBe(true);
    await page.mouse.up();
  });

  test('goes by HTTP when the WebSocket is dead', async () => {
    await page.evaluate(() => (WebSocket.prototype.send = () => {}));
    await sent('Move Horizontal 9000');
    await page.locator('#stop').click();
    expect(await site.stands('M1')).toBe(true);
  });
});

/**
 * Presses shorter than `limit_ms`, by the page's own clock, so that the later effect can be checked. A
 * machine that is too busy to release in time has held long enough: that is undone, and pressed again.
 */
async function tooShort(button: Locator, for_ms: number, limit_ms: number, undo: () => Promise<void>): Promise<void> {
  for (let n = 0; n < 5; n += 1) {
    if ((await press(page, button, for_ms)) < limit_ms) return page.waitForTimeout(limit_ms);
    await undo();
  }
  throw new Error('the machine is too busy for a short press');
}

describe('valves and lockout', () => {
  test('a valve opens after a second, not before; one press closes it', async () => {
    await take(page);
    const open = page.locator('#Valve1 .open-button');
    const opens = async () => (await site.outputs('M1')).Valve1!.flags.some((flag) => flag.startsWith('Open'));
    const close = async () => {
      await page.locator('#Valve1 .close-button').click();
      await until(async () => !(await opens()), 10_000);
    };
    await tooShort(open, 400, 1000, close);
    expect(await opens()).toBe(false);
    await pressUntil(page, open, opens);
    await close();
  });

  test('LOCKOUT is held, apart from STOP, and says its name on a phone; a touch does nothing', async () => {
    await take(page);
    const locked = async () => (await site.outputs('M1')).General!.flags.includes('LockedOut');
    const lockout = page.locator('#lockout');
    for (const width of [360, 768, 1024, 1440]) {
      await page.setViewportSize({ width, height: 800 });
      const [own, all] = [(await lockout.boundingBox())!, (await page.locator('#stop-all').boundingBox())!];
      expect(own.x - (all.x + all.width)).toBeGreaterThanOrEqual(24);
      expect(own.x + own.width).toBeLessThanOrEqual(width);
      expect(await lockout.locator('span').isVisible()).toBe(true);
    }
    await lockout.click();
    await lockout.getByText('HOLD').waitFor();
    expect(await locked()).toBe(false);
  });

  test('lockout is held; its release requires the name typed and the button held', async () => {
    await take(page);
    const locked = async () => (await site.outputs('M1')).General!.flags.includes('LockedOut');
    const lockOut = async () => {
      await pressUntil(page, page.locator('#lockout'), locked);
      await page.getByText('M1 is locked out').first().waitFor();
      await page.locator('#release').click();
    };
    await lockOut();
    const release = page.locator('lf-dialogs lf-hold');
    expect(await press(page, release, 2300)).toBeGreaterThan(2000);
    expect(await locked()).toBe(true);
    const type = () => page.locator('lf-dialogs input').fill('M1');
    await type();
    await tooShort(release, 500, 2000, async () => {
      await lockOut();
      await type();
    });
    expect(await locked()).toBe(true);
    await pressUntil(page, release, async () => !(await locked()));
  });
});

describe('two operators', () => {
  test('the second asks, the first hands over and can no longer move', async () => {
    await take(page);
    const other = await site.open('#/m/M1/operate');
    others.push(other);
    await other.getByText('M1 is controlled by').waitFor();
    await other.locator('#take').click();
    // It is asked for ten seconds: the barrel moves before.
    await pull();
    await other.getByRole('dialog').getByText('Ask for control', { exact: true }).click();
    await page.getByText('Hand over').waitFor();
    await page.mouse.up();
    await page.getByText('Hand over').click();
    await other.getByText('You control M1', { exact: true }).waitFor();
    await page.getByText('M1 is controlled by').waitFor();
    expect(await site.stands('M1')).toBe(true);
    await page.keyboard.down('ArrowLeft');
    expect(await site.stands('M1')).toBe(true);
  });

  test('taken by force in the middle of a motion: it ends, and the former holder sees why', async () => {
    await take(page);
    const other = await site.open('#/m/M1/operate');
    others.push(other);
    await other.getByText('M1 is controlled by').waitFor();
    await other.locator('#take').click();
    await other.locator('lf-dialogs input').fill('fire at the other tank');
    await pull();
    await other.getByText('Take over by force').click();
    expect(await site.stands('M1')).toBe(true);
    await page.getByText('fire at the other tank').waitFor();
    await other.getByText('You control M1', { exact: true }).waitFor();
  });
});

describe('stale data', () => {
  test('of a silent monitor are shown as old, with their age, and no command is possible', async () => {
    await take(page);
    site.links[0]!.freeze();
    await page.locator('#stale').waitFor();
    expect(await page.locator('#stale').textContent()).toMatch(/Data is \d/);
    expect(await page.locator('lf-page-operate lf-value[stale]').count()).toBeGreaterThan(3);
    site.links[0]!.mend();
    await page.locator('#stale').waitFor({ state: 'detached' });
  });

  test('STOP to a silent monitor says within a second that there is no answer, and later that it was not done', async () => {
    site.links[0]!.freeze();
    const from = await page.evaluate(() => performance.now());
    await page.locator('#stop').click();
    await page.getByText('M1: sent, no answer yet').waitFor();
    // By the page's own clock; a busy machine presses and reads late.
    expect(await page.evaluate((begun) => performance.now() - begun, from)).toBeLessThan(1500);
    await page.locator('lf-toasts .toast.error', { hasText: 'M1' }).first().waitFor();
    site.links[0]!.mend();
    expect(await site.stands('M1')).toBe(true);
  });

  test('of a lost hub are shown as old, and recover automatically', async () => {
    site.way.cut();
    await page.getByText('No connection to the hub').first().waitFor();
    await until(async () => (await page.locator('lf-page-operate lf-value[stale]').count()) > 3);
    await until(async () => (await page.locator('#draw button').getAttribute('aria-disabled')) === 'true');
    site.way.mend();
    await page.locator('lf-page-operate lf-value[stale]').first().waitFor({ state: 'detached' });
  });
});

describe('other input devices', () => {
  /** A gamepad that the test holds. */
  async function pad(axes: number[], pressed: number[] = [], there = true): Promise<void> {
    await page.evaluate(
      ([axes, pressed, there]) => {
        const buttons = Array.from({ length: 17 }, (_, n) => ({
          pressed: pressed.includes(n),
          touched: false,
          value: 0,
        }));
        Object.defineProperty(navigator, 'getGamepads', {
          configurable: true,
          value: () => (there ? [{ axes, buttons }] : []),
        });
        window.dispatchEvent(new Event('gamepadconnected'));
      },
      [axes, pressed, there] as const,
    );
  }

  test('a gamepad moves while its stick is held, and not when it is disconnected', async () => {
    await take(page);
    await begun(
      () => pad([-1, 0]),
      () => pad([0, 0]),
    );
    await pad([0, 0]);
    expect(await site.stands('M1')).toBe(true);
    expect(await site.position('M1')).toBeGreaterThan(began);
    await begun(
      () => pad([-1, 0]),
      () => pad([0, 0]),
    );
    await pad([-1, 0], [], false);
    expect(await site.stands('M1')).toBe(true);
  });

  test('a button of the gamepad is STOP, without any control', async () => {
    await sent('Move Horizontal 10000');
    await pad([0, 0], [PAD_STOP]);
    await stoppedShortOf(10_000);
    await pad([0, 0]);
  });

  test('a touch that the system cancels is a release', async () => {
    await page.context().close();
    page = await site.open('#/m/M1/operate', 'en', { width: 1024, height: 1100 }, true);
    await take(page);
    const cdp = await page.context().newCDPSession(page);
    const pad = (await page.locator('lf-joystick').boundingBox())!;
    const [x, y] = [pad.x + pad.width / 2, pad.y + 100];
    const hold = async () => {
      await touch(cdp, 'touchStart', x, y);
      await touch(cdp, 'touchMove', x - 30, y);
      await touch(cdp, 'touchMove', x - 60, y);
    };
    await begun(hold, () => touch(cdp, 'touchEnd'));
    await touch(cdp, 'touchCancel');
    expect(await site.stands('M1')).toBe(true);
    expect(await site.position('M1')).toBeGreaterThan(began);
    await begun(hold, () => touch(cdp, 'touchEnd'));
    await touch(cdp, 'touchEnd');
    expect(await site.stands('M1')).toBe(true);
  });

  test('a finger holds a valve open as a mouse does, and one that slides away opens nothing', async () => {
    await page.context().close();
    page = await site.open('#/m/M1/operate', 'en', { width: 1024, height: 1100 }, true);
    await take(page);
    const cdp = await page.context().newCDPSession(page);
    const open = page.locator('#Valve1 .open-button');
    await open.scrollIntoViewIfNeeded();
    const box = (await open.boundingBox())!;
    const opens = async () => (await site.outputs('M1')).Valve1!.flags.some((flag) => flag.startsWith('Open'));
    const [x, y] = [box.x + box.width / 2, box.y + box.height / 2];
    await touch(cdp, 'touchStart', x, y);
    await touch(cdp, 'touchMove', x, y + 200);
    await page.waitForTimeout(1500);
    await touch(cdp, 'touchEnd');
    expect(await opens()).toBe(false);
    await touch(cdp, 'touchStart', x, y);
    await until(opens);
    await touch(cdp, 'touchEnd');
  });
});

async function touch(
  cdp: CDPSession,
  type: 'touchStart' | 'touchMove' | 'touchEnd' | 'touchCancel',
  x = 0,
  y = 0,
): Promise<void> {
  const touchPoints = type === 'touchEnd' || type === 'touchCancel' ? [] : [{ x, y }];
  await cdp.send('Input.dispatchTouchEvent', { type, touchPoints });
}

describe('what the page says', () => {
  test('a program that a hand has paused: until when, on every page of the monitor, and then it goes on', async () => {
    const quench = 'StartQuench Control centre=0,0 nozzle=60 sector=3000,60 step=1 distance=25';
    const control = async () => (await site.outputs('M1')).Control!.flags;
    await take(page);
    await site.send('M1', quench);
    await until(async () => (await control()).includes('Quench'));
    await heldUntil(
      page,
      async () => (await control()).includes('Paused'),
      () => page.keyboard.down('ArrowLeft'),
      () => page.keyboard.up('ArrowLeft'),
    );
    await page.keyboard.up('ArrowLeft');
    const banner = page.getByText('Program paused, continues in');
    await banner.waitFor();
    const left = parseFloat((await page.locator('lf-banners .passing .count').textContent())!);
    expect(left).toBeGreaterThan(0);
    expect(left).toBeLessThanOrEqual(3);
    await until(async () => !(await control()).includes('Paused'), 10_000);
    expect(await control()).toContain('Quench');
    await banner.waitFor({ state: 'detached' });
    await page.locator('#end').click();
    await until(async () => !(await control()).includes('Quench'));
  });

  test('that limits are off, on every page', async () => {
    await site.send('M1', 'SwitchLimits Horizontal off');
    for (const route of ['#/m/M1/operate', '#/overview', '#/alarms', '#/m/M2/operate']) {
      await page.evaluate((to) => (location.hash = to), route);
      await page.getByText('Limits are off: M1').waitFor();
    }
    await site.send('M1', 'SwitchLimits Horizontal reject');
    await page.getByText('Limits are off: M1').waitFor({ state: 'detached' });
  });

  test('why a control does nothing, to the eye and to a reader of the screen', async () => {
    const dead = page.locator('lf-page-operate [aria-disabled="true"]');
    const told = await dead.evaluateAll((all) =>
      all.map((one) => {
        const by = (one.getAttribute('aria-describedby') ?? '').split(' ').filter((id) => id === 'reason');
        const root = one.getRootNode() as ShadowRoot;
        const why =
          one.getAttribute('aria-description') ?? by.map((id) => root.getElementById(id)?.textContent).join('');
        return [one.getAttribute('aria-label') ?? one.textContent?.trim() ?? '', why ?? ''] as const;
      }),
    );
    expect(told.length).toBeGreaterThan(6);
    for (const [name, why] of told) expect(why, name).not.toBe('');
    await page.locator('#Valve1 .open-button').focus();
    await page.locator('.lf-why', { hasText: 'Take control of M1 first' }).waitFor();
    await page.locator('#seek').hover();
    await page.locator('.lf-why', { hasText: 'Take control of M1 first' }).waitFor();
  });
});
