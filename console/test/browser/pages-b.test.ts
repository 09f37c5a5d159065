// Parameters, programs, commissioning: the page shows what the monitor has.
import { readFileSync } from 'node:fs';
import type { Download, Locator, Page } from 'playwright-core';
import { afterAll, afterEach, beforeAll, describe, expect, test } from 'vitest';
import type { Result } from '../../src/hub/types';
import type { StepId } from '../../src/pages/commissioning/model';
import { able, drawn, heldUntil, holdUntil, passes, passTo, settled, take, until } from './page';
import { Site } from './site';

let site: Site;
let page: Page;

beforeAll(async () => {
  site = await Site.start();
});
afterAll(() => site?.stop());

afterEach(async () => {
  await page.context().close();
  await until(async () => (await site.holder('M1')) === null);
  await site.send('M1', 'Lockout All off');
  await site.send('M1', 'Stop All');
  await site.send('M1', 'SwitchLimits Horizontal reject');
  await site.send('M1', 'SetParam Horizontal MaxLimit 10800');
  await until(() => site.stands('M1'));
});

async function open(route: string, lang = 'en'): Promise<void> {
  page = await site.open(`#/m/M1/${route}`, lang);
  await take(page);
  await settled(page);
}

/** The monitor's present answer to GetParam. */
async function stored(subsystem: string, name: string): Promise<number[]> {
  const answer = await fetch(`${site.api}/api/monitors/M1/requests`, {
    method: 'POST',
    headers: { 'content-type': 'application/json' },
    body: JSON.stringify({ request: `GetParam ${subsystem} ${name}` }),
  });
  const { values } = ((await answer.json()) as Result).answers[0]!;
  return ((values.values ?? values.value) as number[] | undefined) ?? [];
}

const field = (name: string) => page.getByLabel(`Value of ${name}`, { exact: true });
const row = (name: string) => page.locator('lf-param-row').filter({ has: field(name) });
const textOf = async (download: Download) => readFileSync(await download.path(), 'utf8');

const flagged = async (subsystem: string, flag: string) =>
  (await site.outputs('M1'))[subsystem]?.flags.includes(flag) === true;
const said = (text: string | RegExp) => () => page.getByText(text).first().isVisible();
/** An enabled button with this text. */
const button = (text: string, within: Page | Locator = page) =>
  able(within.locator('lf-button', { hasText: new RegExp(`^\\s*${text}\\s*$`) }));

async function choose(name: string, text: string): Promise<void> {
  const buffer = Buffer.from(text);
  await page.locator('input[type=file]').setInputFiles({ name, mimeType: 'text/plain', buffer });
}

describe('parameters', () => {
  test('are found, checked in the field, and written until they are stored', async () => {
    await open('params');
    await page.getByPlaceholder('Name, meaning, or 0x id').fill('vertical speed');
    await field('Vertical.Speed').fill('999');
    await page.getByText('Must be between 1 and 255 °/s.').waitFor();
    await row('Vertical.Speed').getByText('Write', { exact: true }).click();
    await page.locator('.lf-why', { hasText: 'Must be between 1 and 255 °/s.' }).waitFor();
    await passes(page, 300);
    expect(await stored('Vertical', 'Speed')).toEqual([12]);
    await field('Vertical.Speed').fill('14');
    await page.getByText('Monitor: 12 °/s').waitFor();
    await button('Write', row('Vertical.Speed')).click();
    await row('Vertical.Speed').getByText('Stored', { exact: true }).waitFor();
    expect(await stored('Vertical', 'Speed')).toEqual([14]);
  });

  test('that are edited are written all at once, in the units that are shown', async () => {
    await open('params');
    await field('Horizontal.MaxLimit').fill('170.5');
    await field('Horizontal.MaxCurrent').fill('7,5');
    await field('Horizontal.Speed').fill('0');
    await page.getByText('1 cannot be written').waitFor();
    await button('Write 2').click();
    await row('Horizontal.MaxLimit').getByText('Stored').waitFor();
    await row('Horizontal.MaxCurrent').getByText('Stored').waitFor();
    expect(await stored('Horizontal', 'MaxLimit')).toEqual([10230]);
    expect(await stored('Horizontal', 'MaxCurrent')).toEqual([75]);
    expect(await stored('Horizontal', 'Speed')).toEqual([20]);
    await page.getByText('1 parameter edited').waitFor();
    await button('Discard').click();
  });

  test('go to a file and come back from it, each with its outcome', async () => {
    await open('params');
    const [download] = await Promise.all([page.waitForEvent('download'), button('Save to a file').click()]);
    expect(download.suggestedFilename()).toMatch(/^lafet-M1-params-\d{4}-\d\d-\d\d\.toml$/);
    const file = await textOf(download);
    expect(file).toContain('\n[Nozzle]\n');
    await choose('same.toml', file);
    await page.getByText('The file and M1 are identical.').waitFor();
    await choose(
      'other.toml',
      file.replace('FieldOfView = 900', 'FieldOfView = 800').replace('Threshold = 50', 'Threshold = 60'),
    );
    await page.getByText('2 parameters differ').waitFor();
    await page.getByLabel('Restore Detector.Threshold').uncheck();
    await button('Restore 1').click();
    await page.getByText('Everything selected is stored.').waitFor();
    expect(await stored('Detector', 'FieldOfView')).toEqual([800]);
    expect(await stored('Detector', 'Threshold')).toEqual([50]);
    expect(await page.evaluate(() => localStorage.getItem('lafet.restore.M1'))).toBe(null);
    await choose('wrong.toml', 'format = 1\n[Vertical]\nSped = 1\n');
    await page.getByText('wrong.toml cannot be used').waitFor();
  });

  test('a restore that was cut short is offered again', async () => {
    await open('params');
    await page.evaluate(() =>
      localStorage.setItem(
        'lafet.restore.M1',
        JSON.stringify({
          file: 'format = 1\n[Detector]\nThreshold = 70\n',
          name: 'left.toml',
          at_ms: Date.now(),
          chosen: ['Detector.Threshold'],
          begun: [],
        }),
      ),
    );
    await page.getByText('Restoring left.toml').waitFor();
    await button('Continue').click();
    await button('Restore 1').click();
    await page.getByText('Everything selected is stored.').waitFor();
    expect(await stored('Detector', 'Threshold')).toEqual([70]);
  });

  test('are not written without control', async () => {
    page = await site.open('#/m/M1/params');
    await field('Vertical.Acceleration').fill('30');
    await row('Vertical.Acceleration').getByText('Write', { exact: true }).click();
    await page.getByText('Take control of M1 first', { exact: true }).waitFor();
    await passes(page, 300);
    expect(await stored('Vertical', 'Acceleration')).toEqual([24]);
  });
});

describe('programs', () => {
  const number = (name: string) => page.locator('.form').getByLabel(name);

  test('are drawn, stored and run', async () => {
    await open('programs');
    await page.locator('.entry').nth(2).click();
    for (const [name, value] of [
      ['Centre, traverse', '10'],
      ['Centre, elevation', '-4'],
      ['Width', '12'],
      ['Height', '6'],
      ['Between the lines', '2'],
      ['Nozzle', '40'],
    ] as const) {
      await number(name).fill(value);
    }
    await page.getByText('4 lines', { exact: true }).waitFor();
    const handle = page.locator('lf-aim-chart [data-what=left]');
    await handle.focus();
    await page.keyboard.press('Shift+ArrowLeft');
    await until(async () => (await number('Width').inputValue()) === '17');
    await button('Store in M1').click();
    await page.locator('.editor').getByText('Stored', { exact: true }).waitFor();
    // The left edge went out by 5°: the width grew by that, the centre by half of it.
    expect(await stored('Control', 'Program2')).toEqual([750, -240, 40, 1020, 360, 2, 0]);
    await page.getByText('The jet scans 17.0° × 6.0° in 4 lines').waitFor();
    await holdUntil(page, page.getByText('Run program 2'), () => flagged('Control', 'Quench'));
    await button('Stop the program').click();
    await until(async () => !(await flagged('Control', 'Quench')));
  });

  test('trajectories take the point where the barrel is, and a file brings them', async () => {
    await open('programs');
    await page.locator('.entry').nth(9).click();
    await button('Add the present point').click();
    await button('Add a point').click();
    await page.getByLabel('Point 2: Traverse').fill('5');
    await page.getByLabel('Point 2: Dwell').fill('2.5');
    await button('Store in M1').click();
    await page.locator('.editor').getByText('Stored', { exact: true }).waitFor();
    const values = await stored('Control', 'Trajectory1');
    expect(values).toHaveLength(8);
    expect(values[0]).toBe(await site.position('M1'));
    expect(values.slice(4)).toEqual([300, values[1], 25, 25]);
    await choose('programs.toml', 'format = 1\n[Control]\nTrajectory3 = [60, 0, 25, 10]\n[Vertical]\nSpeed = 99\n');
    await page.getByText('1 loaded from programs.toml; not stored yet.').waitFor();
    await page.locator('.entry').nth(11).click();
    await button('Store in M1').click();
    await page.locator('.editor').getByText('Stored', { exact: true }).waitFor();
    expect(await stored('Control', 'Trajectory3')).toEqual([60, 0, 25, 10]);
    expect(await stored('Vertical', 'Speed')).not.toEqual([99]);
  });

  test('wholly beyond the limits do not run', async () => {
    await open('programs');
    await page.locator('.entry').nth(6).click();
    await number('Centre, elevation').fill('-60');
    await page.getByText('Entirely beyond the limits: the monitor refuses it.').first().waitFor();
    await page.locator('lf-hold', { hasText: 'Run program 6' }).hover();
    await page.getByText('Store it first: the monitor runs what it has stored').waitFor();
  });
});

describe('commissioning', () => {
  async function prepared(): Promise<void> {
    await open('commissioning');
    const boxes = page.locator('lf-step-prepare input[type=checkbox]');
    await boxes.first().waitFor();
    await drawn(page);
    for (const box of await boxes.all()) await box.check();
    await button('Passed').click();
    await page.locator('lf-step-stop').waitFor();
  }

  /** With everything before this step passed. */
  async function openAt(step: StepId): Promise<void> {
    page = await site.open('#/m/M1/commissioning');
    await passTo(page, step);
  }

  test('refuses to go on before STOP is proved', async () => {
    await prepared();
    await page.getByText('Valves', { exact: false }).first().click();
    await page.getByText('To do first: Test of STOP.').waitFor();
    await button('Go to it').click();
    await button('It cannot be passed …').click();
    await page.getByLabel('What is wrong, and what was done about it').fill('no power at the drives');
    await button('Record it').click();
    await page.getByText('no power at the drives').first().waitFor();
    await page.getByText('Limits of travel').click();
    await page.getByText('To do first: Test of STOP.').waitFor();
  });

  test('proves STOP at the monitor, by a motion that is held', async () => {
    await prepared();
    const down = async () => {
      await able(page.locator('lf-step-stop lf-move').first()).hover();
      await page.mouse.down();
    };
    const up = () => page.mouse.up();
    await heldUntil(page, said('It is moving. Press STOP now!'), down, up);
    await up();
    await page.getByText('It stopped before STOP was pressed.').waitFor();
    expect(await site.stands('M1')).toBe(true);
    // A busy machine may end the motion before the key is pressed; the page reports that this proves nothing.
    const proved = said(/STOP works: .* after \d+ ms/);
    for (let n = 0; n < 5 && !(await proved()); n += 1) {
      await heldUntil(
        page,
        async () => (await site.moves('M1')) && (await said('It is moving. Press STOP now!')()),
        down,
        up,
      );
      await page.keyboard.press('F9');
      await until(async () => (await proved()) || (await said('It stopped before STOP was pressed.')()));
      if (!(await proved())) await up();
    }
    await page.getByText(/STOP works: .* after \d+ ms/).waitFor();
    expect(await site.stands('M1')).toBe(true);
    await page.mouse.up();
    await button('Passed').click();
    await page.locator('lf-step-directions').waitFor();
    await page.reload();
    await page.locator('lf-step-directions').waitFor();
  });

  test('teaches a limit, and the report has it', async () => {
    await openAt('limits');
    const box = page.locator('lf-step-limits .box').first();
    await holdUntil(page, box.getByText('Limits off, to set them'), () => flagged('Horizontal', 'Limitless'));
    const from = await site.position('M1');
    await holdUntil(page, box.locator('lf-move').first(), async () => (await site.position('M1')) > from + 300);
    expect(await site.stands('M1')).toBe(true);
    const at = await site.position('M1');
    // The page learns later where the barrel is, and that it is at rest.
    await until(async () => Math.abs(parseFloat((await box.locator('.big').first().textContent())!) - at / 60) < 0.06);
    await able(box.locator('lf-button', { hasText: 'Set as limit: left' })).click();
    await box.getByText(/^Set: /).waitFor();
    await able(box.locator('lf-button', { hasText: 'Limits on: take effect' })).click();
    await until(async () => !(await flagged('Horizontal', 'Limitless')));
    expect(await stored('Horizontal', 'MaxLimit')).toEqual([at]);
    await box.getByText('Limits are on.').waitFor();
    const limited = box.getByText('Stopped at its limit: left');
    await holdUntil(page, box.locator('lf-move').first(), () => limited.isVisible());
    await page.locator('.steps').getByText('Report').click();
    await page.getByText('NOT FINISHED').waitFor();
    const [download] = await Promise.all([page.waitForEvent('download'), button('Save the report').click()]);
    const report = await textOf(download);
    expect(report).toContain('<h1>Commissioning report</h1>');
    expect(report).toContain(`<td>Horizontal.MaxLimit</td><td class="n">${at}</td>`);
  });

  test('lets LOCKOUT be seen to refuse', async () => {
    await openAt('lockout');
    await page.locator('lf-step-lockout').getByText('LOCKOUT', { exact: true }).click();
    await page.getByText('The monitor reports that it is locked out.').waitFor();
    await holdUntil(
      page,
      page.locator('lf-hold', { hasText: 'Try a Move' }),
      said('Refused by the monitor, and nothing moved.'),
    );
    const asked = () => page.getByLabel('Type M1 to confirm').isVisible();
    await holdUntil(page, page.locator('lf-step-lockout lf-hold', { hasText: 'Release' }), asked);
    await page.getByLabel('Type M1 to confirm').fill('M1');
    await able(page.locator('lf-dialogs').getByText('Release', { exact: true })).click();
    await page.getByText('Released: commands are accepted again').waitFor();
    expect((await site.outputs('M1')).General?.flags).not.toContain('LockedOut');
    await button('Passed').click();
    await page.getByText('PASSED', { exact: true }).waitFor();
  });
});
