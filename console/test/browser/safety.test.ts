// The rules that keep people safe, each looked at where it counts: at the monitor's outputs.
import type { Page } from 'playwright-core';
import { afterAll, afterEach, beforeAll, beforeEach, describe, expect, test } from 'vitest';
import { Site, until } from './site';

const FAR_ARCMIN = 5000;

let site: Site;
let page: Page;
/** Where M1 pointed when the test began. */
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
      await until(async () => Math.abs(await site.position(id)) < 60, 15_000);
    }
    await until(async () => !(await site.moves(id)));
  }
});

async function take(on = page): Promise<void> {
  await on.locator('#take').click();
  await on.getByText('You control M1', { exact: true }).waitFor();
}

/** Moves it past the console, as another client would. */
async function sent(request: string, id = 'M1'): Promise<void> {
  await site.send(id, request);
  await until(() => site.moves(id));
}

/**
 * Holds until the barrel moves. On a busy machine the page's beats may be late, and the motion ends,
 * as it has to: then the hand lets go and holds anew.
 */
async function begun(hold: () => Promise<void>, leave: () => Promise<void>): Promise<void> {
  for (let n = 0; n < 5; n += 1) {
    await hold();
    const moved = await until(() => site.moves('M1'), 3000).then(
      () => true,
      () => false,
    );
    if (moved) return;
    await leave();
  }
  throw new Error('the barrel does not move');
}

/** Pulls the stick to the left. */
async function pull(): Promise<void> {
  const pad = (await page.locator('lf-joystick').boundingBox())!;
  const [x, y] = [pad.x + pad.width / 2, pad.y + 100];
  const hold = async () => {
    await page.mouse.move(x, y);
    await page.mouse.down();
    await page.mouse.move(x - 60, y, { steps: 3 });
  };
  await begun(hold, () => page.mouse.up());
}

async function press(key: string): Promise<void> {
  await begun(
    () => page.keyboard.down(key),
    () => page.keyboard.up(key),
  );
}

describe('a motion that is held', () => {
  test('ends with the release', async () => {
    await take();
    await pull();
    await page.mouse.up();
    expect(await site.stands('M1')).toBe(true);
    expect(await site.position('M1')).toBeGreaterThan(began);
  });

  test('of a key ends with its release, and opposite keys mean nothing', async () => {
    await take();
    await press('ArrowRight');
    await page.keyboard.down('ArrowLeft');
    expect(await site.stands('M1')).toBe(true);
    await page.keyboard.up('ArrowLeft');
    await page.keyboard.up('ArrowRight');
    expect(await site.stands('M1')).toBe(true);
    expect(await site.position('M1')).toBeLessThan(began);
  });

  test('ends when the window loses the focus', async () => {
    await take();
    await pull();
    await page.evaluate(() => window.dispatchEvent(new Event('blur')));
    expect(await site.stands('M1')).toBe(true);
  });

  test('ends when the tab is left, and does not come back by itself', async () => {
    await take();
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
    await take();
    await pull();
    await page.close();
    expect(await site.stands('M1')).toBe(true);
  });

  test('ends when the link breaks', async () => {
    await take();
    await pull();
    site.way.cut();
    expect(await site.stands('M1')).toBe(true);
  });

  test('ends when the link says nothing more, and what comes late moves nothing', async () => {
    await take();
    await pull();
    site.way.freeze();
    expect(await site.stands('M1')).toBe(true);
    site.way.mend();
    expect(await site.stands('M1')).toBe(true);
  });

  test('ends when the page stalls', async () => {
    await take();
    await pull();
    await page.evaluate(() => {
      const end = performance.now() + 900;
      while (performance.now() < end);
    });
    expect(await site.stands('M1')).toBe(true);
  });

  test('ends when a dialog opens', async () => {
    await take();
    await press('ArrowLeft');
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
  test('stops from every page', async () => {
    const names = await page
      .locator('lf-nav a')
      .evaluateAll((all) => all.map((a) => (a as HTMLAnchorElement).getAttribute('href')!));
    expect(names.length).toBeGreaterThan(1);
    for (const href of names) {
      await sent(`Move Horizontal ${names.indexOf(href) % 2 ? -9000 : 9000}`);
      await page.evaluate((to) => (location.hash = to), href);
      await page.locator('#stop').click();
      expect(await site.stands('M1'), href).toBe(true);
    }
  });

  test('stops while a dialog is open, by pointer and by key', async () => {
    await page.locator('#readiness').click();
    await page.getByRole('dialog').waitFor();
    await sent('Move Horizontal 9000');
    await page.locator('#stop').click();
    expect(await site.stands('M1')).toBe(true);
    await sent('Move Horizontal -9000');
    await page.keyboard.press('F9');
    expect(await site.stands('M1')).toBe(true);
    await sent('Move Horizontal 9000');
    await page.keyboard.press('Pause');
    expect(await site.stands('M1')).toBe(true);
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
    expect(await site.stands('M1')).toBe(true);
    expect(await site.moves('M2')).toBe(true);
    await page.locator('#stop-all').click();
    expect(await site.stands('M2')).toBe(true);
  });

  test('of somebody who holds nothing stops what another one holds', async () => {
    await take();
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

describe('valves and lockout', () => {
  test('a valve opens after a second, not before; one press closes it', async () => {
    await take();
    const open = page.locator('#Valve1 .open-button');
    const box = (await open.boundingBox())!;
    await page.mouse.move(box.x + 20, box.y + 20);
    await page.mouse.down();
    await page.waitForTimeout(400);
    await page.mouse.up();
    await page.waitForTimeout(900);
    expect((await site.outputs('M1')).Valve1!.flags).toEqual(['Closed']);
    await page.mouse.down();
    await until(async () => (await site.outputs('M1')).Valve1!.flags.includes('Opening'), 10_000);
    await page.mouse.up();
    await page.locator('#Valve1 .close-button').click();
    await until(async () => !(await site.outputs('M1')).Valve1!.flags.some((f) => f.startsWith('Open')), 10_000);
  });

  test('lockout is one press; its release wants the name typed and the button held', async () => {
    await take();
    await page.locator('#lockout').click();
    await until(async () => (await site.outputs('M1')).General!.flags.includes('LockedOut'));
    await page.getByText('M1 is locked out').first().waitFor();
    await page.locator('#release').click();
    const release = page.locator('lf-dialogs lf-hold');
    const hold = async (ms: number) => {
      const box = (await release.boundingBox())!;
      await page.mouse.move(box.x + 20, box.y + 20);
      await page.mouse.down();
      await page.waitForTimeout(ms);
      await page.mouse.up();
    };
    await hold(2300);
    expect((await site.outputs('M1')).General!.flags).toContain('LockedOut');
    await page.locator('lf-dialogs input').fill('M1');
    await hold(500);
    expect((await site.outputs('M1')).General!.flags).toContain('LockedOut');
    await hold(2300);
    await until(async () => !(await site.outputs('M1')).General!.flags.includes('LockedOut'));
  });
});

describe('two operators', () => {
  test('the second asks, the first hands over, and can move no more', async () => {
    await take();
    const other = await site.open('#/m/M1/operate');
    others.push(other);
    await other.getByText('M1 is controlled by').waitFor();
    await other.locator('#take').click();
    await other.getByRole('dialog').getByText('Ask for control', { exact: true }).click();
    await pull();
    await page.getByText('Hand over').waitFor();
    await page.mouse.up();
    await page.getByText('Hand over').click();
    await other.getByText('You control M1', { exact: true }).waitFor();
    await page.getByText('M1 is controlled by').waitFor();
    expect(await site.stands('M1')).toBe(true);
    await page.keyboard.down('ArrowLeft');
    expect(await site.stands('M1')).toBe(true);
  });

  test('taken by force in the middle of a motion: it ends, and the former holder is told why', async () => {
    await take();
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

describe('what is old', () => {
  test('of a silent monitor is shown as old, with its age, and nothing can be commanded', async () => {
    await take();
    site.links[0]!.freeze();
    await page.locator('#stale').waitFor();
    expect(await page.locator('#stale').textContent()).toMatch(/Data is \d/);
    expect(await page.locator('lf-page-operate lf-value[stale]').count()).toBeGreaterThan(3);
    site.links[0]!.mend();
    await page.locator('#stale').waitFor({ state: 'detached' });
  });

  test('of a lost hub is shown as old, and comes back by itself', async () => {
    site.way.cut();
    await page.getByText('No connection to the hub').first().waitFor();
    expect(await page.locator('lf-page-operate lf-value[stale]').count()).toBeGreaterThan(3);
    expect(await page.locator('#draw button').getAttribute('aria-disabled')).toBe('true');
    site.way.mend();
    await page.locator('lf-page-operate lf-value[stale]').first().waitFor({ state: 'detached' });
  });
});
