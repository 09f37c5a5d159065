// Exercises: actions on the page are checked in the simulation.
import type { Page } from 'playwright-core';
import { afterAll, afterEach, beforeAll, beforeEach, describe, expect, test } from 'vitest';
import type { Simulation } from '../../src/pages/training/model';
import { Demo } from './demo';
import { able, LATE_MS, passes, placed, SOON, settled, until } from './page';

let demo: Demo;
let page: Page;

beforeAll(async () => {
  demo = await Demo.start();
});
afterAll(() => demo?.stop());

beforeEach(async () => {
  page = await demo.open('#/training');
  await page.locator('lf-training-faults').waitFor();
});
afterEach(async () => {
  await page.context().close();
  await demo.post('/api/sim/speed', { speed: 1 });
  if ((await sim()).paused) await demo.post('/api/sim/resume');
});

const sim = async () => (await demo.get<Simulation>('/api/sim')).state;

describe('training', () => {
  test('a fault is injected and repaired', async () => {
    const jam = page.getByRole('switch', { name: /^Jammed/ }).first();
    await jam.click();
    await until(async () => (await sim()).monitors.M1!.faults.includes('vertical-jam'));
    await until(async () => (await jam.getAttribute('aria-checked')) === 'true');
    await able(page.locator('lf-button', { hasText: 'Repair all' })).click();
    await until(async () => (await sim()).monitors.M1!.faults.length === 0);
    await until(async () => (await jam.getAttribute('aria-checked')) === 'false');
  });

  test('a link is cut and restored', async () => {
    await page.getByRole('tab', { name: 'M2' }).click();
    await able(page.locator('lf-button', { hasText: 'Cut the connection' })).click();
    await until(async () => (await sim()).monitors.M2!.link === 'lost');
    await able(page.locator('lf-button', { hasText: 'Restore the connection' })).click();
    await until(async () => (await sim()).monitors.M2!.link === 'up');
  });

  test('a fire is no alarm until a detector has seen it, and the strip says so', async () => {
    const unreported = page.getByText('fire not yet reported by a detector');
    await unreported.waitFor({ timeout: LATE_MS });
    expect(await page.locator('lf-topbar .fire').count()).toBe(0);
    await demo.request('M1', 'StartSeek Detector -3000 3000 -900 600');
    await demo.post('/api/sim/speed', { speed: 20 });
    await page.locator('lf-topbar .fire').waitFor({ timeout: 2 * LATE_MS });
    await expect.poll(() => unreported.count(), SOON).toBe(0);
  });

  test('time does not run while it is paused', async () => {
    await page.locator('#pause').click();
    await until(async () => (await sim()).paused);
    const stopped = (await sim()).t_s;
    await page.getByText('Continue', { exact: true }).waitFor();
    await passes(page, 500);
    expect((await sim()).t_s).toBe(stopped);
    await page.locator('#pause').click();
    await until(async () => (await sim()).t_s > stopped);
  });

  test('a fire burns where the plan was clicked', async () => {
    const flames = page.locator('lf-plan .flame');
    await flames.first().waitFor();
    const before = await flames.count();
    await able(page.locator('lf-button', { hasText: 'Place a fire on the plan' })).click();
    await settled(page);
    const plan = await placed(page.locator('lf-plan'));
    const [x, y] = [plan.x + plan.width / 3, plan.y + plan.height * 0.8];
    await page.mouse.click(x, y);
    // The plan then shows one more fire, at the click, and its text includes it.
    await until(async () => (await flames.count()) > before);
    const away = async () => {
      const boxes = await flames.evaluateAll((all) =>
        all.map((one) => one.getBoundingClientRect().toJSON() as DOMRect),
      );
      return Math.min(...boxes.map((box) => Math.hypot(box.x + box.width / 2 - x, box.y + box.height / 2 - y)));
    };
    await expect.poll(away, SOON).toBeLessThan(12);
    const burning = () =>
      page.locator('lf-plan').evaluate((one) => {
        const root = one.shadowRoot!;
        const told = root.querySelector('#summary')!.textContent!.match(/is burning/g)?.length;
        return [told, root.querySelectorAll('.flame').length];
      });
    await expect.poll(async () => new Set(await burning()).size, SOON).toBe(1);
    expect((await burning())[1]).toBeGreaterThanOrEqual(2);
  });

  test('another exercise brings its own site', async () => {
    const { run } = await sim();
    const card = page.locator('article', { hasText: 'Two fires, one monitor' });
    await card.getByText('Start', { exact: true }).click();
    await page.locator('lf-dialogs').getByText('Start', { exact: true }).click();
    await until(async () => (await sim()).scenario === 'two-fires');
    expect((await sim()).run).toBe(run + 1);
    await page.getByRole('heading', { name: 'Two fires, one monitor', level: 2 }).waitFor();
    await until(async () => (await page.getByRole('tab').count()) === 1);
    await expect.poll(() => page.getByText('none flares up again').count(), SOON).toBe(1);
  });
});
