// The rules that keep people safe, each checked at the monitor's outputs.
import type { CDPSession, Locator, Page } from 'playwright-core';
import { afterAll, afterEach, beforeAll, beforeEach, describe, expect, test } from 'vitest';
import {
  able,
  drawn,
  go,
  heldUntil,
  holdUntil,
  middle,
  pagesOf,
  passes,
  placed,
  press,
  pressUntil,
  SOON,
  take,
  until,
} from './page';
import { Site } from './site';

const PAD_STOP = 1;
const LIMIT_ARCMIN = 10_800;
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

afterEach(() => site.rest([page, ...others.splice(0)], ['M1', 'M2']));

/** Holds until the barrel moves and has turned. */
async function begun(hold: () => Promise<void>, leave: () => Promise<void>): Promise<void> {
  const stood = await site.position('M1');
  await heldUntil(page, async () => (await site.moves('M1')) && (await site.position('M1')) !== stood, hold, leave);
}

/** Takes the stick and pulls it to the left; returns where the pointer is. */
async function grab(): Promise<[x: number, y: number]> {
  const [x, y] = await middle(page.locator('lf-joystick .base'));
  await page.mouse.move(x, y);
  await page.mouse.down();
  await page.mouse.move(x - 60, y, { steps: 3 });
  return [x - 60, y];
}

/** Pulls the stick to the left until the barrel turns. */
async function pull(): Promise<void> {
  await begun(
    async () => void (await grab()),
    () => page.mouse.up(),
  );
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

/** What was held has ended: it is at rest, and not because it has reached its limit. */
async function ended(): Promise<void> {
  expect(await site.stands('M1')).toBe(true);
  expect(LIMIT_ARCMIN - Math.abs(await site.position('M1'))).toBeGreaterThan(SHORT_ARCMIN);
}

const why = (text: string) => page.locator('.lf-why', { hasText: text });

describe('a held motion', () => {
  test('ends with the release', async () => {
    await take(page);
    await pull();
    await page.mouse.up();
    await ended();
    expect(await site.position('M1')).toBeGreaterThan(began);
  });

  test('is what the hand does, not what the page does under it', async () => {
    await take(page);
    const stick = page.locator('lf-joystick .base');
    const height = await site.position('M1', 'Vertical');
    const shift = (by: string) =>
      page.locator('lf-joystick').evaluate((it: HTMLElement, to) => {
        it.style.translate = to;
      }, by);
    let there = NaN;
    const hold = async () => {
      await shift('');
      const [x, y] = await grab();
      const from = await site.position('M1');
      await until(async () => (await site.position('M1')) !== from, 5000).catch(() => {});
      const old = (await placed(stick)).y;
      await shift('0 80px');
      expect((await placed(stick)).y - old).toBeGreaterThan(60);
      there = await site.position('M1');
      await page.mouse.move(x - 1, y);
    };
    // Long enough for another drive to begin.
    await heldUntil(
      page,
      async () => (await site.position('M1')) > there + 1200,
      hold,
      () => page.mouse.up(),
    );
    expect(await site.position('M1', 'Vertical')).toBe(height);
    await page.mouse.up();
    await ended();
    expect(await site.position('M1', 'Vertical')).toBe(height);
  });

  test('of a key ends with its release, and opposite keys mean nothing', async () => {
    await take(page);
    await pressKey('ArrowRight');
    await until(async () => (await site.position('M1')) < began);
    await page.keyboard.down('ArrowLeft');
    await ended();
    await page.keyboard.up('ArrowLeft');
    await page.keyboard.up('ArrowRight');
    await ended();
    expect(await site.position('M1')).toBeLessThan(began);
  });

  test('ends when the window loses the focus', async () => {
    await take(page);
    await pull();
    await page.evaluate(() => window.dispatchEvent(new Event('blur')));
    await ended();
  });

  test('ends when the tab is left, and does not come back by itself', async () => {
    await take(page);
    await pull();
    await page.evaluate(() => {
      Object.defineProperty(document, 'hidden', { configurable: true, value: true });
      document.dispatchEvent(new Event('visibilitychange'));
    });
    await ended();
    await page.evaluate(() => {
      Object.defineProperty(document, 'hidden', { configurable: true, value: false });
      document.dispatchEvent(new Event('visibilitychange'));
    });
    await passes(page, 500);
    await ended();
  });

  test('ends when the page is closed', async () => {
    await take(page);
    await pull();
    await page.close();
    await ended();
  });

  test('ends when the link breaks', async () => {
    await take(page);
    await pull();
    site.way.cut();
    await ended();
  });

  test('ends when the link falls silent, and late messages move nothing', async () => {
    await take(page);
    await pull();
    site.way.freeze();
    await ended();
    site.way.mend();
    await ended();
    // The page has its link again: what was late has arrived.
    await until(async () => (await page.locator('lf-topbar .lost').count()) === 0);
    await page.locator('lf-page-operate lf-value[stale]').first().waitFor({ state: 'detached' });
    await ended();
  });

  test('ends when the page stalls', async () => {
    await take(page);
    await pull();
    await page.evaluate(() => {
      const end = performance.now() + 900;
      while (performance.now() < end);
    });
    await ended();
    await passes(page, 500);
    await ended();
  });

  test('ends when a dialog opens', async () => {
    await take(page);
    await pressKey('ArrowLeft');
    await page.locator('#readiness').click();
    await page.getByRole('dialog').waitFor();
    await ended();
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
    const names = await pagesOf(page);
    expect(names.length).toBeGreaterThan(1);
    for (const [n, href] of names.entries()) {
      await go(page, href);
      for (const [way, stop] of [
        ['pointer', () => page.locator('#stop').click()],
        ['F9', () => page.keyboard.press('F9')],
        ['Shift+Escape', () => page.keyboard.press('Shift+Escape')],
      ] as const) {
        const target = await site.sentAway();
        await stop();
        await stoppedShortOf(target, 'M1', `${n} ${href} ${way}`);
      }
    }
  });

  test('stops while a dialog is open, by pointer and by key', async () => {
    await page.locator('#readiness').click();
    await page.getByRole('dialog').waitFor();
    for (const stop of [
      () => page.locator('#stop').click(),
      () => page.keyboard.press('F9'),
      () => page.keyboard.press('Pause'),
    ]) {
      const target = await site.sentAway();
      await stop();
      await stoppedShortOf(target);
    }
  });

  test('is above everything that a page puts into the top layer', async () => {
    await page.evaluate(() => {
      const cover = document.createElement('div');
      cover.popover = 'manual';
      cover.style.cssText = 'position:fixed;inset:0;width:100vw;height:100vh;margin:0';
      document.body.append(cover);
      cover.showPopover();
    });
    const target = await site.sentAway();
    await page.locator('#stop').click();
    await stoppedShortOf(target);
  });

  test('is what the first Tab reaches', async () => {
    await page.keyboard.press('Tab');
    const target = await site.sentAway();
    await page.keyboard.press('Enter');
    await stoppedShortOf(target);
  });

  test('of all stops them all, of one leaves the others alone', async () => {
    const [one, other] = [await site.sentAway('M1'), await site.sentAway('M2')];
    await page.locator('#stop').click();
    await stoppedShortOf(one);
    // It continues to its target.
    await until(async () => (await site.position('M2')) === other);
    const back = await site.sentAway('M2');
    await page.locator('#stop-all').click();
    await stoppedShortOf(back, 'M2');
  });

  test('of a user without control stops what another one holds', async () => {
    await take(page);
    const other = await site.open('#/overview');
    others.push(other);
    await pull();
    await other.locator('#stop').click();
    await ended();
    await page.mouse.up();
  });

  test('goes by HTTP when the WebSocket is dead', async () => {
    await page.evaluate(() => (WebSocket.prototype.send = () => {}));
    const target = await site.sentAway();
    await page.locator('#stop').click();
    await stoppedShortOf(target);
  });
});

/**
 * Presses shorter than `limit_ms`, by the page's own clock, so that the later effect can be checked. A
 * machine that is too busy to release in time has held long enough: that is undone, and pressed again.
 */
async function tooShort(button: Locator, for_ms: number, limit_ms: number, undo: () => Promise<void>): Promise<void> {
  for (let n = 0; n < 5; n += 1) {
    const held_ms = await press(page, button, for_ms);
    await passes(page, limit_ms);
    if (held_ms < limit_ms) return;
    await undo();
  }
  throw new Error('the machine is too busy for a short press');
}

describe('valves and lockout', () => {
  const locked = async () => (await site.outputs('M1')).General!.flags.includes('LockedOut');
  const unlock = async () => {
    await site.send('M1', 'Lockout All off');
    await until(async () => !(await locked()));
    await page.locator('#lockout').waitFor();
  };

  test('a valve opens after a second, not before; one press closes it', async () => {
    await take(page);
    const open = page.locator('#Valve1 .open-button');
    const opens = async () => (await site.outputs('M1')).Valve1!.flags.some((flag) => flag.startsWith('Open'));
    const close = async () => {
      await able(page.locator('#Valve1 .close-button')).click();
      await until(async () => (await site.outputs('M1')).Valve1!.flags.includes('Closed'));
    };
    await tooShort(open, 400, 1000, close);
    expect(await opens()).toBe(false);
    await holdUntil(page, open, opens);
    await close();
  });

  test('what is held for a valve ends with a STOP of another client, and must be held again', async () => {
    await take(page);
    const open = page.locator('#Valve1 .open-button');
    await able(open).hover();
    // Long enough for any machine.
    await open.evaluate((button: HTMLElement & { seconds: number }) => (button.seconds = 20));
    const holding = open.locator('button.holding');
    const held = async (id: string) => {
      await page.mouse.down();
      await holding.waitFor();
      const { ok } = await fetch(`${site.api}/api/monitors/${id}/stop`, { method: 'POST' });
      expect(ok).toBe(true);
    };
    await held('M2');
    await passes(page, 700);
    expect(await holding.count(), 'it is for another monitor').toBe(1);
    await page.mouse.up();
    await held('M1');
    await holding.waitFor({ state: 'detached' });
    await page.getByText('Ended by an order to stop or close').waitFor();
    await page.mouse.up();
    expect((await site.outputs('M1')).Valve1!.flags).toContain('Closed');
  });

  test('LOCKOUT is held, apart from STOP, and says its name on a phone; a touch does nothing', async () => {
    await take(page);
    const lockout = page.locator('#lockout');
    for (const width of [360, 768, 1024, 1440]) {
      await page.setViewportSize({ width, height: 800 });
      const [own, all] = [await placed(lockout), await placed(page.locator('#stop-all'))];
      expect(own.x - (all.x + all.width)).toBeGreaterThanOrEqual(24);
      expect(own.x + own.width).toBeLessThanOrEqual(width);
      expect(await lockout.locator('span').isVisible()).toBe(true);
    }
    // It asks for three seconds.
    const asks = lockout.getByText('HOLD').waitFor();
    await tooShort(lockout, 0, 500, unlock);
    await asks;
    await lockout.getByText('HOLD').waitFor({ state: 'detached' });
    expect(await locked()).toBe(false);
  });

  test('a key that is held is one press, and a mouse before it is none', async () => {
    await take(page);
    const lockout = page.locator('#lockout');
    const asks = lockout.getByText('HOLD');
    await lockout.focus();
    for (let times = 0; times < 4; times++) await page.keyboard.down('Enter');
    await asks.waitFor();
    await page.keyboard.up('Enter');
    await asks.waitFor({ state: 'detached' });
    expect(await locked()).toBe(false);
    await tooShort(lockout, 0, 500, unlock);
    await asks.waitFor();
    await page.keyboard.press('Enter');
    await passes(page, 500);
    expect(await locked()).toBe(false);
    await asks.waitFor({ state: 'detached' });
  });

  test('lockout is held; its release requires the name typed and the button held', async () => {
    await take(page);
    const lockOut = async () => {
      await pressUntil(page, page.locator('#lockout'), locked);
      await page.getByText('M1 is locked out').first().waitFor();
      await page.locator('#release').click();
    };
    await lockOut();
    const release = page.locator('lf-dialogs lf-hold');
    expect(await press(page, release, 2300)).toBeGreaterThan(2000);
    await passes(page, 500);
    expect(await locked()).toBe(true);
    const type = () => page.locator('lf-dialogs input').fill('M1');
    await type();
    await able(release).waitFor();
    await tooShort(release, 500, 2000, async () => {
      // Its timer may have come too late as well.
      if ((await release.count()) > 0) return;
      await until(async () => !(await locked()));
      await lockOut();
      await type();
    });
    expect(await locked()).toBe(true);
    await holdUntil(page, release, async () => !(await locked()));
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
    await ended();
    const stood = await site.position('M1');
    await page.keyboard.down('ArrowLeft');
    await page.locator('lf-toasts').getByText('controls M1').waitFor();
    await ended();
    expect(await site.position('M1')).toBe(stood);
  });

  test('taken by force in the middle of a motion: it ends, and the former holder sees why', async () => {
    await take(page);
    const other = await site.open('#/m/M1/operate');
    others.push(other);
    await other.getByText('M1 is controlled by').waitFor();
    await other.locator('#take').click();
    await other.locator('lf-dialogs input').fill('fire at the other tank');
    await pull();
    // It stays for some seconds.
    const told = page.getByText('fire at the other tank').waitFor();
    await able(other.getByText('Take over by force')).click();
    await Promise.all([ended(), told]);
    await other.getByText('You control M1', { exact: true }).waitFor();
  });
});

describe('stale data', () => {
  test('of a silent monitor are shown as old, with their age, and no command is possible', async () => {
    await take(page);
    site.links[0]!.freeze();
    await page.locator('#stale').waitFor();
    await expect.poll(() => page.locator('#stale').textContent(), SOON).toMatch(/Data is \d/);
    await expect.poll(() => page.locator('lf-page-operate lf-value[stale]').count(), SOON).toBeGreaterThan(3);
    await expect.poll(() => page.locator('#draw button').getAttribute('aria-disabled'), SOON).toBe('true');
    site.links[0]!.mend();
    await page.locator('#stale').waitFor({ state: 'detached' });
  });

  test('STOP to a silent monitor says within a second that there is no answer, and later that it was not done', async () => {
    site.links[0]!.freeze();
    // By the page's own clock, from the press to the frame that shows it: a busy machine presses and reads late.
    const took = page.locator('lf-toasts').evaluate(
      (toasts) =>
        new Promise<number>((done) => {
          let pressed = NaN;
          window.addEventListener('pointerdown', (event) => (pressed = event.timeStamp), { capture: true, once: true });
          const look = (now: number) => {
            if (toasts.shadowRoot!.textContent!.includes('M1: sent, no answer yet')) done(now - pressed);
            else requestAnimationFrame(look);
          };
          requestAnimationFrame(look);
        }),
    );
    const note = page.locator('lf-toasts .toast.error', { hasText: 'M1 · STOP: NOT CONFIRMED' });
    const repeated = note.getByText('M1 does not answer. It is sent again and again.').waitFor();
    const refused = note.getByText('act as if it had not been carried out, and shut the hand valve').waitFor();
    await drawn(page);
    await page.locator('#stop').click();
    expect(await took).toBeLessThan(1000);
    await repeated;
    await refused;
    const [plan, told] = [await placed(page.locator('lf-plan')), await placed(note)];
    expect(plan.y + plan.height, 'it covers nothing of the plan').toBeLessThanOrEqual(told.y);
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
          value: () => (there ? [{ index: 0, mapping: 'standard', axes, buttons }] : []),
        });
        window.dispatchEvent(new Event('gamepadconnected'));
      },
      [axes, pressed, there] as const,
    );
  }

  /** Two frames at rest: only then does it move anything. */
  async function rest(): Promise<void> {
    await pad([0, 0]);
    await drawn(page);
  }

  test('a gamepad moves while its stick is held, and not when it is disconnected', async () => {
    await take(page);
    await pad([-1, 0]);
    await passes(page, 700);
    expect(await site.position('M1'), 'it was connected with its stick pulled').toBe(began);
    await rest();
    await begun(
      () => pad([-1, 0]),
      () => pad([0, 0]),
    );
    await rest();
    await ended();
    expect(await site.position('M1')).toBeGreaterThan(began);
    await begun(
      () => pad([-1, 0]),
      () => rest(),
    );
    await pad([-1, 0], [], false);
    await ended();
  });

  test('a button of the gamepad is STOP, without any control', async () => {
    const target = await site.sentAway();
    await pad([0, 0], [PAD_STOP]);
    await stoppedShortOf(target);
    await pad([0, 0]);
  });

  test('on other pages too it is STOP', async () => {
    await page.evaluate(() => (location.hash = '#/alarms'));
    await page.locator('lf-page-alarms').waitFor();
    const target = await site.sentAway();
    await pad([0, 0], [PAD_STOP]);
    await stoppedShortOf(target);
    await pad([0, 0]);
  });

  test('a touch that the system cancels is a release', async () => {
    await page.context().close();
    page = await site.open('#/m/M1/operate', 'en', { width: 1024, height: 1100 }, true);
    await take(page);
    const cdp = await page.context().newCDPSession(page);
    const hold = async () => {
      const stick = page.locator('lf-joystick .base');
      await stick.scrollIntoViewIfNeeded();
      const [x, y] = await middle(stick);
      await touch(cdp, 'touchStart', x, y);
      await touch(cdp, 'touchMove', x - 30, y);
      await touch(cdp, 'touchMove', x - 60, y);
    };
    await begun(hold, () => touch(cdp, 'touchEnd'));
    await touch(cdp, 'touchCancel');
    await ended();
    expect(await site.position('M1')).toBeGreaterThan(began);
    await begun(hold, () => touch(cdp, 'touchEnd'));
    await touch(cdp, 'touchEnd');
    await ended();
  });

  test('a finger holds a valve open as a mouse does, and one that slides away opens nothing', async () => {
    await page.context().close();
    page = await site.open('#/m/M1/operate', 'en', { width: 1024, height: 1100 }, true);
    await take(page);
    const cdp = await page.context().newCDPSession(page);
    const open = page.locator('#Valve1 .open-button');
    await able(open).waitFor();
    await open.scrollIntoViewIfNeeded();
    const opens = async () => (await site.outputs('M1')).Valve1!.flags.some((flag) => flag.startsWith('Open'));
    const [x, y] = await middle(open);
    await touch(cdp, 'touchStart', x, y);
    await touch(cdp, 'touchMove', x, y + 200);
    await passes(page, 1500);
    await touch(cdp, 'touchEnd');
    expect(await opens()).toBe(false);
    await touch(cdp, 'touchStart', ...(await middle(open)));
    await touch(cdp, 'touchEnd');
    await why('Press and hold').waitFor();
    await passes(page, 1000);
    expect(await why('Press and hold').isVisible(), 'it can be read after the finger was lifted').toBe(true);
    expect(await opens()).toBe(false);
    await heldUntil(
      page,
      opens,
      async () => touch(cdp, 'touchStart', ...(await middle(open))),
      () => touch(cdp, 'touchEnd'),
    );
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
    // The pause is three seconds long: what is said in it is read as soon as it is there.
    const banner = page.getByText('Program paused, continues in');
    const told = banner.waitFor();
    const count = page.locator('lf-banners .passing .count').textContent();
    await heldUntil(
      page,
      async () => (await control()).includes('Paused'),
      () => page.keyboard.down('ArrowLeft'),
      () => page.keyboard.up('ArrowLeft'),
    );
    await page.keyboard.up('ArrowLeft');
    await told;
    const left = parseFloat((await count)!);
    expect(left).toBeGreaterThan(0);
    expect(left).toBeLessThanOrEqual(3);
    await until(async () => !(await control()).includes('Paused'));
    expect(await control()).toContain('Quench');
    await banner.waitFor({ state: 'detached' });
    await able(page.locator('#end')).click();
    await until(async () => !(await control()).includes('Quench'));
  });

  test('that limits are off, on every page', async () => {
    await site.send('M1', 'SwitchLimits Horizontal off');
    for (const route of ['#/m/M1/operate', '#/overview', '#/alarms', '#/m/M2/operate']) {
      await go(page, route);
      await page.getByText('Limits are off: M1').waitFor();
    }
    await site.send('M1', 'SwitchLimits Horizontal reject');
    await page.getByText('Limits are off: M1').waitFor({ state: 'detached' });
  });

  test('why a control does nothing, to the eye and to a reader of the screen', async () => {
    const dead = page.locator('lf-page-operate [aria-disabled="true"]');
    await until(async () => (await dead.count()) > 6);
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
    const open = page.locator('#Valve1 .open-button');
    await open.focus();
    await why('Take control of M1 first').waitFor();
    await open.locator('button').blur();
    await why('Take control of M1 first').waitFor({ state: 'hidden' });
    await open.hover();
    await why('Take control of M1 first').waitFor();
    await page.mouse.move(5, 5);
    await why('Take control of M1 first').waitFor({ state: 'hidden' });
    await page.locator('#seek').hover();
    await why('Take control of M1 first').waitFor();
  });
});
