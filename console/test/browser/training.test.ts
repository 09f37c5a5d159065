// Exercises: actions on the page are checked in the simulation.
import type { Page } from 'playwright-core';
import { afterAll, afterEach, beforeAll, beforeEach, describe, expect, test } from 'vitest';
import type { Simulation } from '../../src/pages/training/model';
import { Demo } from './demo';
import { until } from './site';

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
afterEach(() => page.context().close());

const sim = async () => (await demo.get<Simulation>('/api/sim')).state;

describe('training', () => {
  test('a fault is injected and repaired', async () => {
    const jam = page.getByRole('switch', { name: /^Jammed/ }).first();
    await jam.click();
    await until(async () => (await sim()).monitors.M1!.faults.includes('vertical-jam'));
    await until(async () => (await jam.getAttribute('aria-checked')) === 'true');
    await page.getByText('Repair all').click();
    await until(async () => (await sim()).monitors.M1!.faults.length === 0);
    await until(async () => (await jam.getAttribute('aria-checked')) === 'false');
  });

  test('a link is cut and restored', async () => {
    await page.getByRole('tab', { name: 'M2' }).click();
    await page.getByText('Cut the connection').click();
    await until(async () => (await sim()).monitors.M2!.link === 'lost');
    await page.getByText('Restore the connection').click();
    await until(async () => (await sim()).monitors.M2!.link === 'up');
  });

  test('a fire is no alarm until a detector has seen it, and the strip says so', async () => {
    const unreported = page.getByText('fire not yet reported by a detector');
    await unreported.waitFor({ timeout: 60_000 });
    expect(await page.locator('lf-topbar .fire').count()).toBe(0);
    await demo.request('M1', 'StartSeek Detector -3000 3000 -900 600');
    await demo.post('/api/sim/speed', { speed: 20 });
    await page.locator('lf-topbar .fire').waitFor({ timeout: 120_000 });
    expect(await unreported.count()).toBe(0);
    await demo.post('/api/sim/speed', { speed: 1 });
  });

  test('time does not run while it is paused', async () => {
    await page.locator('#pause').click();
    await until(async () => (await sim()).paused);
    const stopped = (await sim()).t_s;
    await page.getByText('Continue', { exact: true }).waitFor();
    expect((await sim()).t_s).toBe(stopped);
    await page.locator('#pause').click();
    await until(async () => (await sim()).t_s > stopped);
  });

  test('a fire burns where the plan was clicked', async () => {
    await page.getByText('Place a fire on the plan').click();
    const plan = (await page.locator('lf-plan').boundingBox())!;
    await page.mouse.click(plan.x + plan.width / 3, plan.y + plan.height * 0.8);
    // The plan then shows one more fire, at the click, and its text includes it.
    const flames = page.locator('lf-plan .flame');
    await until(async () => (await flames.count()) >= 2);
    const boxes = await Promise.all((await flames.all()).map((flame) => flame.boundingBox()));
    const away = boxes.map((box) =>
      Math.hypot(
        box!.x + box!.width / 2 - (plan.x + plan.width / 3),
        box!.y + box!.height / 2 - (plan.y + plan.height * 0.8),
      ),
    );
    expect(Math.min(...away)).toBeLessThan(12);
    const summary = await page.locator('lf-plan #summary').textContent();
    expect(summary?.match(/is burning/g)?.length).toBe(boxes.length);
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
    expect(await page.getByText('none flares up again').count()).toBe(1);
  });
});
