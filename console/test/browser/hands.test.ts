// What a hand holds ends with every order to stop, and with everything that hides its release; then it must be released.
import type { Page } from 'playwright-core';
import { afterAll, afterEach, beforeAll, beforeEach, describe, expect, test } from 'vitest';
import { able, drawn, go, heldUntil, middle, passes, placed, SOON, take, until } from './page';
import { Site } from './site';

let site: Site;
let page: Page;
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

afterEach(() => site.rest([page, ...others.splice(0)]));

const why = (text: string) => page.locator('.lf-why', { hasText: text });
const opens = async () => (await site.outputs('M1')).Valve1!.flags.some((flag) => flag.startsWith('Open'));

/** It has turned and is at rest now, before any limit. */
async function ended(where = ''): Promise<void> {
  expect(await site.stands('M1'), where).toBe(true);
  expect(Math.abs(await site.position('M1')), where).toBeLessThan(10_700);
}

/** What is still held, and trembles, moves nothing. */
async function stays(tremble: () => Promise<void>, where = ''): Promise<void> {
  await ended(where);
  const place = async () => [await site.position('M1'), await site.position('M1', 'Vertical')];
  const stood = await place();
  await tremble();
  await passes(page, 900);
  expect(await site.moves('M1'), where).toBe(false);
  expect(await place(), where).toEqual(stood);
}

async function turns(hold: () => Promise<void>, leave: () => Promise<void>): Promise<void> {
  const stood = await site.position('M1');
  await heldUntil(page, async () => (await site.moves('M1')) && (await site.position('M1')) !== stood, hold, leave);
}

async function presses(key: string): Promise<void> {
  await turns(
    () => page.keyboard.down(key),
    () => page.keyboard.up(key),
  );
}

/** An event of the keyboard as only some systems send it. */
function sends(type: string, init: Record<string, string | boolean> = {}): Promise<void> {
  return page.evaluate(
    ([type, init]) => {
      let at: Element = document.activeElement ?? document.body;
      while (at.shadowRoot?.activeElement) at = at.shadowRoot.activeElement;
      const event = type === 'contextmenu' ? new MouseEvent(type, { bubbles: true, composed: true }) : null;
      at.dispatchEvent(event ?? new KeyboardEvent(type, { bubbles: true, composed: true, cancelable: true, ...init }));
    },
    [type, init] as const,
  );
}

describe('a valve that is held open', () => {
  const orders: [string, () => Promise<unknown>][] = [
    ['F9', () => page.keyboard.press('F9')],
    ['STOP', () => page.evaluate(() => press('lf-stop', '#stop'))],
    ['Close', () => page.evaluate(() => press('.close-button', 'button'))],
  ];

  beforeEach(async () => {
    await page.evaluate(() => {
      // A second hand: the pointer of the test is the first.
      const find = (root: ParentNode, selector: string): Element | null => {
        const own = root.querySelector(selector);
        if (own) return own;
        for (const one of root.querySelectorAll('*')) {
          const found = one.shadowRoot && find(one.shadowRoot, selector);
          if (found) return found;
        }
        return null;
      };
      (window as unknown as Record<string, unknown>).press = (host: string, button: string) => {
        const at = find(document, host)!.shadowRoot!.querySelector(button)!;
        const init = { bubbles: true, composed: true, pointerId: 77, button: 0 };
        at.dispatchEvent(new PointerEvent('pointerdown', init));
        at.dispatchEvent(new MouseEvent('click', { ...init, detail: 1 }));
      };
    });
  });

  test.each(orders)('stays closed after %s', async (_, order) => {
    await take(page);
    const open = page.locator('#Valve1 .open-button');
    await able(open).waitFor();
    for (let n = 0; n < 4; n += 1) {
      await open.hover();
      await page.mouse.down();
      await passes(page, 500);
      if (await open.locator('button.holding').count()) break;
      await page.mouse.up();
    }
    expect(await open.locator('button.holding').count()).toBe(1);
    await order();
    await why('Press and hold again').waitFor();
    await passes(page, 1500);
    expect(await opens()).toBe(false);
    await page.mouse.up();
  });

  test('stays closed when the page has stalled while the finger was lifted', async () => {
    await take(page);
    const open = page.locator('#Valve1 .open-button');
    await able(open).waitFor();
    await open.hover();
    await page.mouse.down();
    await open.locator('button.holding').waitFor();
    await page.evaluate(() => {
      const end = performance.now() + 1300;
      while (performance.now() < end);
    });
    await why('stalled').waitFor();
    await passes(page, 1200);
    expect(await opens()).toBe(false);
    await page.mouse.up();
  });
});

declare function press(host: string, button: string): void;

test('what is pulled or pressed when something is stopped is not sent when it is released', async () => {
  await take(page);
  const asked: string[] = [];
  page.on('request', (one) => asked.push(one.url()));
  const nozzle = await site.position('M1', 'Nozzle');
  const slider = page.locator('lf-hand lf-slider input');
  await slider.scrollIntoViewIfNeeded();
  const box = await placed(slider);
  const [x, y] = [box.x + box.width / 2, box.y + box.height / 2];
  const pullTo = async (to: number) => {
    await page.mouse.move(x, y);
    await page.mouse.down();
    await page.mouse.move(to, y, { steps: 4 });
    await drawn(page);
  };
  await pullTo(x + box.width / 4);
  await page.keyboard.press('F9');
  await page.mouse.up();
  await passes(page, 1200);
  expect(await site.position('M1', 'Nozzle')).toBe(nozzle);
  await pullTo(x - box.width / 4);
  await page.mouse.up();
  await until(async () => (await site.position('M1', 'Nozzle')) !== nozzle);

  await able(page.locator('#aim')).click();
  await page.locator('#aim button[aria-pressed=true]').waitFor();
  await drawn(page);
  const plan = await placed(page.locator('lf-plan'));
  const aims = () => asked.filter((url) => url.endsWith('/aim')).length;
  await page.mouse.move(plan.x + plan.width * 0.6, plan.y + plan.height * 0.5);
  await page.mouse.down();
  await page.keyboard.press('F9');
  await page.mouse.up();
  await passes(page, 800);
  expect(aims()).toBe(0);
  await page.mouse.down();
  await page.mouse.up();
  await until(() => aims() > 0);
});

test('only the first button aims: the middle one moves the plan, also with the first one pressed beside it', async () => {
  await take(page);
  const asked: string[] = [];
  page.on('request', (one) => asked.push(one.url()));
  const aims = () => asked.filter((url) => url.endsWith('/aim')).length;
  await able(page.locator('#aim')).click();
  await page.locator('#aim button[aria-pressed=true]').waitFor();
  await drawn(page);
  const plan = await placed(page.locator('lf-plan'));
  await page.mouse.move(plan.x + plan.width * 0.6, plan.y + plan.height * 0.5);
  const middle = { button: 'middle' } as const;
  await page.mouse.down(middle);
  await page.mouse.up(middle);
  await page.mouse.down(middle);
  await page.mouse.down();
  await page.mouse.up(middle);
  await page.mouse.up();
  await page.mouse.down();
  await page.mouse.down(middle);
  await page.mouse.up();
  await page.mouse.up(middle);
  await passes(page, 800);
  expect(aims()).toBe(0);
  expect(await site.position('M1')).toBe(began);
  await page.mouse.down();
  await page.mouse.up();
  await until(() => aims() > 0);
});

describe('a key whose release is not reported', () => {
  const lost: [string, string, Record<string, string | boolean>][] = [
    ['Cmd', 'keydown', { key: 'Meta', code: 'MetaLeft', metaKey: true }],
    ['Alt', 'keydown', { key: 'Alt', code: 'AltLeft', altKey: true }],
    ['NumLock', 'keydown', { key: 'NumLock', code: 'NumLock' }],
    ['a menu', 'contextmenu', {}],
  ];
  for (const on of ['the page', 'the stick', 'a button of the nozzle']) {
    test(`ends with what hides it: on ${on}`, async () => {
      await take(page);
      const nozzle = on.includes('nozzle');
      const moves = async () => (await site.outputs('M1')).Nozzle!.flags.includes('Move');
      if (nozzle) {
        // From the middle both buttons move it.
        const { min, max } = await site.range('M1', 'Nozzle');
        await site.send('M1', `Move Nozzle ${Math.round((min + max) / 2)}`);
        await until(moves);
        await until(async () => !(await moves()));
      }
      for (const [name, type, init] of lost) {
        if (on === 'the stick') await page.locator('lf-joystick .base').focus();
        if (nozzle) {
          await page
            .locator('lf-hand .hold')
            .nth(lost.findIndex(([one]) => one === name) % 2)
            .focus();
          await heldUntil(
            page,
            moves,
            () => page.keyboard.down('Space'),
            () => page.keyboard.up('Space'),
          );
        } else await presses(name === 'Alt' ? 'ArrowLeft' : 'ArrowRight');
        await sends(type, init);
        if (nozzle) await until(async () => !(await moves()), 5000);
        else await stays(() => sends('keydown', { key: 'ArrowRight', code: 'ArrowRight', repeat: true }), name);
        await page.keyboard.up(nozzle ? 'Space' : name === 'Alt' ? 'ArrowLeft' : 'ArrowRight');
      }
    });
  }

  test('is released by its place: with NumLock and Shift its name changes', async () => {
    await take(page);
    await page.locator('lf-joystick .base').focus();
    const up = { key: 'ArrowLeft', code: 'Numpad4' };
    await turns(
      () => sends('keydown', up),
      () => sends('keyup', up),
    );
    await sends('keyup', { key: '4', code: 'Numpad4' });
    await ended();
    expect(await site.position('M1')).not.toBe(began);
  });
});

test('+ narrows and − widens wherever a keyboard has them, and a release counts whatever it types then', async () => {
  await take(page);
  const { min, max } = await site.range('M1', 'Nozzle');
  const moves = async () => (await site.outputs('M1')).Nozzle!.flags.includes('Move');
  const middle = Math.round((min + max) / 2);
  for (const [down, up, sign] of [
    [{ key: '+', code: 'Minus' }, { key: '+', code: 'Minus' }, 1],
    [{ key: '_', code: 'Minus', shiftKey: true }, { key: '-', code: 'Minus' }, -1],
  ] as const) {
    await site.send('M1', `Move Nozzle ${middle}`);
    await until(async () => !(await moves()) && Math.abs((await site.position('M1', 'Nozzle')) - middle) < 2);
    const from = await site.position('M1', 'Nozzle');
    await heldUntil(
      page,
      moves,
      () => sends('keydown', down),
      () => sends('keyup', up),
    );
    await until(async () => (await site.position('M1', 'Nozzle')) !== from);
    await sends('keyup', up);
    await until(async () => !(await moves()), 5000);
    expect(Math.sign((await site.position('M1', 'Nozzle')) - from), down.key).toBe(sign);
  }
});

describe('after an end that was no release', () => {
  test('a stick that is still held moves nothing, until it was released', async () => {
    await take(page);
    const pull = async () => {
      const [x, y] = await middle(page.locator('lf-joystick .base'));
      await page.mouse.move(x, y);
      await page.mouse.down();
      await page.mouse.move(x - 60, y, { steps: 3 });
    };
    const tremble = async () => {
      const [x, y] = await middle(page.locator('lf-joystick .base'));
      for (const [dx, dy] of [
        [-40, -50],
        [-60, 0],
        [0, 0],
        [40, 40],
        [-60, 0],
      ]) {
        await page.mouse.move(x + dx!, y + dy!);
        await drawn(page);
      }
    };
    const other = await site.open('#/overview');
    others.push(other);
    const orders: [string, () => Promise<unknown>][] = [
      ['STOP here', () => page.keyboard.press('F9')],
      ['STOP elsewhere', () => other.locator('#stop').click()],
    ];
    for (const [name, order] of orders) {
      await turns(pull, () => page.mouse.up());
      await order();
      await stays(tremble, name);
      await page.mouse.up();
    }
    await turns(pull, () => page.mouse.up());
    await page.mouse.up();
    await ended();
  });

  test('keys that are still held move nothing', async () => {
    await take(page);
    await presses('ArrowLeft');
    await page.keyboard.press('F9');
    await stays(async () => {
      await page.keyboard.down('ArrowLeft');
    });
    // The other key is pressed and released: the one that is still held does not take its place.
    await page.keyboard.press('ArrowRight', { delay: 400 });
    await ended();
    await stays(async () => {});
    await page.keyboard.up('ArrowLeft');
  });

  test('a gamepad that is still pulled moves nothing, until it was at rest', async () => {
    await take(page);
    const pad = (axes: number[]) =>
      page.evaluate((axes) => {
        const buttons = Array.from({ length: 17 }, () => ({ pressed: false }));
        const value = () => [{ index: 0, mapping: 'standard', axes, buttons }];
        Object.defineProperty(navigator, 'getGamepads', { configurable: true, value });
        window.dispatchEvent(new Event('gamepadconnected'));
      }, axes);
    const rest = async () => {
      await pad([0, 0]);
      await drawn(page);
    };
    await rest();
    const ends: [string, () => Promise<unknown>][] = [
      ['STOP', () => page.keyboard.press('F9')],
      ['the focus', () => page.evaluate(() => window.dispatchEvent(new Event('blur')))],
      ['another page', () => go(page, '#/m/M1/diagnosis').then(() => go(page, '#/m/M1/operate'))],
    ];
    for (const [name, end] of ends) {
      await turns(() => pad([-1, 0]), rest);
      await end();
      const tremble = async () => {
        for (const axes of [
          [-1, -1],
          [0, -1],
          [-1, 0],
        ]) {
          await pad(axes);
          await drawn(page);
        }
      };
      await stays(tremble, name);
      await rest();
    }
    await expect.poll(() => page.locator('lf-hand .state svg').count(), SOON).toBe(1);
  });
});
