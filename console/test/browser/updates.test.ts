// Updating the software of monitors: from a file to the new version, by the page alone.
import { execFile } from 'node:child_process';
import { mkdirSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { tmpdir } from 'node:os';
import { basename, join } from 'node:path';
import { promisify } from 'node:util';
import type { Page } from 'playwright-core';
import { afterAll, afterEach, beforeAll, beforeEach, describe, expect, test } from 'vitest';
import type { Updates } from '../../src/hub/types';
import { clipped } from './clipped';
import { Guarded } from './guarded';
import { able, go, LATE_MS, press, settled, until } from './page';
import { LAFET, Site } from './site';

const run = promisify(execFile);
const axe = readFileSync(createRequire(import.meta.url).resolve('axe-core/axe.min.js'), 'utf8');
const TAGS = ['wcag2a', 'wcag2aa', 'wcag21a', 'wcag21aa', 'wcag22aa'];
const SIZES = [
  { width: 1440, height: 900 },
  { width: 1024, height: 768 },
  { width: 390, height: 844 },
  { width: 2560, height: 1440 },
];
const BOTH = ['M1', 'M2'];
/** An image that takes a while, and one that does not, bytes. */
const LONG = 120_000;
const SHORT = 4096;

const HALL =
  `[[zone]]\nid = "hall"\nvotes = "2oo2"\nwater_max_s = 600\nmonitors = ["M1", "M2"]\n` +
  ['flame', 'heat']
    .map((kind) => `[[detector]]\nid = "${kind}"\nkind = "${kind}"\nzones = ["hall"]\nsilent_after_s = 3600\n`)
    .join('') +
  BOTH.map((id) => `[[aim]]\nzone = "hall"\nmonitor = "${id}"\nhorizontal = 600\nvertical = 300\nnozzle = 60\n`).join(
    '',
  );

/** Who makes images for the board `bench`, with key 0. */
class Maker {
  readonly folder = mkdtempSync(join(tmpdir(), 'lafet-images-'));
  private made = 0;

  static async start(): Promise<Maker> {
    const maker = new Maker();
    await run(LAFET, ['image', 'key', maker.path('key')]);
    await run(LAFET, ['image', 'public', '0', maker.path('key'), maker.path('key.pub')]);
    return maker;
  }

  path(name: string): string {
    return join(this.folder, name);
  }

  /** A version that is newer than every one before, and its files: one for either slot, or those for A and B. */
  async image(size: number, slots: readonly string[] = ['']): Promise<{ version: string; files: string[] }> {
    const version = `1.${++this.made}.0.0`;
    const files = slots.map((slot) => this.path(`${version}${slot}.image`));
    for (const [n, file] of files.entries()) {
      const program = this.path('program');
      writeFileSync(program, Buffer.alloc(size, `${version}${slots[n]}`));
      const slot = slots[n] ? ['--slot', slots[n]] : [];
      const about = ['--key', `0=${this.path('key')}`, '--board', 'bench', '--version', version, '--layouts', '1-1'];
      await run(LAFET, ['image', 'sign', ...about, ...slot, program, file]);
    }
    return { version, files };
  }
}

let maker: Maker;
let site: Site;
let page: Page;

beforeAll(async () => {
  maker = await Maker.start();
  site = await Site.start(HALL, [], ['--board', 'bench', '--update-key', `0=${maker.path('key.pub')}`]);
});
afterAll(async () => {
  await site?.stop();
  rmSync(maker.folder, { recursive: true, force: true });
});

async function updates(): Promise<Updates> {
  return (await (await fetch(`${site.api}/api/updates`)).json()) as Updates;
}

/** Whether a monitor itself reports that it is locked out. */
async function isLocked(id: string): Promise<boolean> {
  return (await site.outputs(id)).General?.flags.includes('LockedOut') === true;
}

async function stow(): Promise<void> {
  for (const id of BOTH) {
    if ((await site.outputs(id)).Deployer?.flags.includes('Wrapped')) continue;
    await site.send(id, 'Wrap');
  }
  for (const id of BOTH) {
    await until(async () => (await site.outputs(id)).Deployer?.flags.includes('Wrapped') === true, LATE_MS);
  }
}

/** No run, no image, no lockout. */
beforeEach(async () => {
  await fetch(`${site.api}/api/updates/stop`, { method: 'POST' });
  await until(async () => (await updates()).run?.state !== 'running', LATE_MS);
  for (const { digest } of (await updates()).images) {
    await fetch(`${site.api}/api/updates/images/${digest}`, { method: 'DELETE' });
  }
  for (const id of BOTH) if (await isLocked(id)) await site.send(id, 'Lockout All off');
});
afterEach(() => page?.context().close());

/** A picture for people, where UPDATES_PICTURES names a folder. */
async function picture(on: Page, name: string): Promise<void> {
  const folder = process.env.UPDATES_PICTURES;
  if (!folder) return;
  mkdirSync(folder, { recursive: true });
  await on.screenshot({ path: `${folder}/${name}.png` });
}

async function clean(on: Page): Promise<void> {
  await settled(on);
  await on.evaluate(axe);
  const found = await on.evaluate(async (tags) => {
    const it = globalThis as unknown as {
      axe: { run: (o: object) => Promise<{ violations: { id: string; nodes: { target: unknown }[] }[] }> };
    };
    return (await it.axe.run({ runOnly: tags })).violations.map(
      ({ id, nodes }) => `${id} ${JSON.stringify(nodes.map(({ target }) => target))}`,
    );
  }, TAGS);
  expect(found).toEqual([]);
}

const rows = () => page.locator('lf-update-images tbody tr');
const row = (id: string) => page.locator(`lf-update-run li[data-monitor="${id}"]`);
const pick = (id: string) => page.locator(`lf-update-start .pick:has([data-monitor="${id}"])`);

async function choose(...files: string[]): Promise<void> {
  await page.locator('lf-update-images input[type=file]').setInputFiles(files);
}

/** The state of each monitor, as the page has it. */
async function states(): Promise<(string | null)[]> {
  return page
    .locator('lf-update-run li[data-monitor]')
    .evaluateAll((all) => all.map((one) => one.getAttribute('data-state')));
}

/** Stores an image on the page, chooses it and the monitors. */
async function prepared(files: string[], ids: readonly string[] = BOTH): Promise<void> {
  page = await site.open('#/updates');
  await choose(...files);
  await until(async () => (await rows().count()) === files.length, LATE_MS);
  await page.locator('#versions input').first().check();
  for (const id of ids) await page.locator(`#monitors input[data-monitor="${id}"]`).check();
}

/** Confirms what is chosen. */
async function start(): Promise<void> {
  await able(page.locator('#update-start')).click();
  const yes = able(page.locator('#update-yes'));
  await yes.waitFor();
  // A dialog that has just come up takes no press.
  await page.waitForTimeout(700);
  await press(page, yes, 2400);
  await page.locator('lf-update-run').waitFor();
}

describe('images', () => {
  test('are stored from files that are chosen or dropped, and others are refused with their reason', async () => {
    const { version, files } = await maker.image(SHORT);
    writeFileSync(maker.path('notes.txt'), 'no image');
    const torn = maker.path('torn.image');
    writeFileSync(torn, readFileSync(files[0]!).subarray(0, 1000));
    page = await site.open('#/updates');
    await page.getByText('No image is stored').waitFor();
    await choose(maker.path('notes.txt'), torn, files[0]!);
    const refused = page.locator('lf-update-images .refused');
    await refused.getByText('notes.txt: It is not an image').waitFor();
    expect(await refused.locator('li', { hasText: 'torn.image' }).textContent()).toMatch(/incomplete|whole|1000/);
    await expect.poll(() => rows().count()).toBe(1);
    expect(await rows().first().textContent()).toContain(version);
    expect(await rows().first().textContent()).toContain('bench');

    const bytes = [...readFileSync(files[0]!)];
    const dropped = await page.evaluateHandle(
      ([name, content]) => {
        const data = new DataTransfer();
        data.items.add(new File([new Uint8Array(content as number[])], name as string));
        return data;
      },
      [basename(files[0]!), bytes] as const,
    );
    await page.locator('lf-update-images .drop').dispatchEvent('drop', { dataTransfer: dropped });
    await page.getByText('was stored before').waitFor();
    expect(await rows().count()).toBe(1);

    const kept = await page.evaluate(() => {
      const drop = new DragEvent('drop', { bubbles: true, cancelable: true, composed: true });
      document.body.dispatchEvent(drop);
      return drop.defaultPrevented;
    });
    expect(kept, 'a file that misses the field does not replace the page').toBe(true);

    await able(rows().first().locator('[data-act=remove]')).click();
    await page.waitForTimeout(700);
    await able(page.locator('lf-dialogs lf-button', { hasText: /^\s*Remove\s*$/ })).click();
    await page.getByText('No image is stored').waitFor();
    expect((await updates()).images).toEqual([]);
  });

  test('for both slots are chosen together', async () => {
    const { files, version } = await maker.image(SHORT, ['a', 'b']);
    page = await site.open('#/updates');
    await choose(files[0]!);
    await page.locator('#versions').getByText('needs the image for slot B too').waitFor();
    await choose(files[1]!);
    await page.locator('#versions').getByText('slots A and B').waitFor();
    expect(await page.locator('#versions input').count()).toBe(1);
    expect(await page.locator('#versions').textContent()).toContain(version);
  });
});

describe('a run', () => {
  test('does not start without a version and monitors; what is missing is named, and nothing is changed', async () => {
    for (const id of BOTH) await site.send(id, 'Deploy');
    for (const id of BOTH) {
      await until(async () => (await site.outputs(id)).Deployer?.flags.includes('Deployed') === true, LATE_MS);
    }
    page = await site.open('#/updates');
    const says = () => page.locator('#update-start button').getAttribute('aria-description');
    await until(async () => (await says()) === 'Choose a version first');
    await page.context().close();
    const { files } = await maker.image(SHORT);
    await prepared(files, []);
    await until(async () => (await says()) === 'Choose monitors first');
    await pick('M1').getByText('it is not stowed').waitFor();
    await page.locator('#monitors input[data-all=""]').check();
    await page.getByText('As things are, the run ends at M1').waitFor();
    await start();
    await until(async () => (await states()).join() === 'failed,skipped', LATE_MS);
    expect((await row('M1').locator('.why').textContent())!.length).toBeGreaterThan(10);
    await page.locator('lf-update-run').getByText('ended early').waitFor();
    for (const id of BOTH) expect(await isLocked(id)).toBe(false);
    expect(await site.lafet('M1', 'update', '--state')).toContain('1.0.0.0');
  });

  test('updates one monitor after the other, each locked out meanwhile, and every page says so', async () => {
    await stow();
    const { version, files } = await maker.image(SHORT);
    await prepared(files);
    await until(async () => (await page.locator('lf-update-start .missing').count()) === 0, LATE_MS);
    const other = await site.open('#/m/M2/operate');
    await start();
    await other.locator('lf-banners .updating').waitFor();
    const seen = new Set<string>();
    await until(async () => {
      const [one, two] = await states();
      const locked = await Promise.all(BOTH.map(isLocked));
      expect(locked, 'never both').not.toEqual([true, true]);
      if (one === 'updating' || two === 'updating') seen.add(`${one},${two}`);
      return one === 'done' && two === 'done';
    }, 3 * LATE_MS);
    expect([...seen].every((both) => both === 'updating,waiting' || both === 'done,updating')).toBe(true);
    expect(await row('M1').locator('.versions').textContent()).toBe(`1.0.0.0 → ${version}`);
    await page.locator('lf-update-run').getByText('2 updated', { exact: true }).waitFor();
    await other.locator('lf-banners .updating').waitFor({ state: 'detached' });
    await other.context().close();
    for (const id of BOTH) {
      expect(await isLocked(id)).toBe(false);
      expect(await site.lafet(id, 'update', '--state')).toContain(version);
    }
    await pick('M1').getByText(`Runs ${version}`).waitFor();

    await page.locator('#monitors input[data-monitor="M1"]').check();
    await start();
    await until(async () => (await states()).join() === 'same', LATE_MS);
  });

  test('is stopped by an operator, and the same update goes on from there', async () => {
    await stow();
    const { version, files } = await maker.image(LONG);
    await prepared(files, ['M1']);
    await page.locator('#pace').selectOption('10');
    await start();
    await row('M1')
      .locator('.stage', { hasText: /Sending · [1-9]\d* %/ })
      .waitFor();
    await able(page.locator('#update-stop')).click();
    await page.locator('lf-update-run').getByText('ended early').waitFor();
    const { done } = (await updates()).run!.monitors[0]!;
    expect(await site.lafet('M1', 'update', '--state')).not.toContain(version);
    await page.locator('#monitors input[data-monitor="M1"]').check();
    await page.locator('#pace').selectOption('100');
    await start();
    await until(async () => (await states()).join() === 'done', 3 * LATE_MS);
    expect(done).toBeGreaterThan(0);
    expect(await site.lafet('M1', 'update', '--state')).toContain(version);
  });
});

test('an observer sees it, without buttons', async () => {
  const guarded = await Guarded.start();
  try {
    page = await site.open('#/overview');
    await guarded.enter(page, 'olga');
    await page.locator('lf-nav a[href="#/updates"]').waitFor();
    await go(page, '#/updates');
    await page.getByText('No image is stored').waitFor();
    await settled(page);
    expect(await page.locator('lf-page-updates :is(button, input, select)').count()).toBe(0);
    await clean(page);
  } finally {
    await guarded.stop();
  }
});

test.each(['en', 'ru'])('axe finds nothing, and nothing is cut off, in four sizes: %s', async (lang) => {
  await stow();
  const { files } = await maker.image(LONG);
  await prepared(files);
  await page.locator('#pace').selectOption('10');
  await start();
  await row('M1').locator('progress').waitFor();
  for (const size of SIZES) {
    const one = await site.open('#/updates', lang, size);
    await one.locator('lf-update-run progress').waitFor();
    await clean(one);
    expect(await clipped(one)).toEqual([]);
    expect(await one.evaluate(() => document.documentElement.scrollWidth - innerWidth)).toBeLessThanOrEqual(0);
    await picture(one, `updates-${lang}-${size.width}`);
    await one.context().close();
  }
  await able(page.locator('#update-start')).waitFor({ state: 'detached' });
  await fetch(`${site.api}/api/updates/stop`, { method: 'POST' });
  await page.locator('lf-update-run').getByText('ended early').waitFor();
  await clean(page);
});
