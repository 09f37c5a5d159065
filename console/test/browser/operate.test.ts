// Operate with a simulated site: the picture fills the page, its water lands where the simulator's does, and bad
// values are marked.
import type { Page } from 'playwright-core';
import { afterAll, afterEach, beforeAll, expect, test } from 'vitest';
import type { Jet } from '../../src/hub/jets';
import type { Monitor, Scene } from '../../src/hub/types';
import { Demo, WEBGL } from './demo';
import { able, go, LATE_MS, passes, placed, settled, takeButton, until } from './page';

let demo: Demo;
let page: Page;

beforeAll(async () => {
  demo = await Demo.start(WEBGL);
  await demo.post('/api/sim/automatic', { on: false });
});
afterAll(() => demo?.stop());
afterEach(() => page?.context().close());

const status = async () => (await demo.get<Monitor>('/api/monitors/M1')).status;
const flags = async (subsystem: string) => (await status()).subsystems[subsystem]!.flags;

test('the plan is most of the page, and the controls for a fire are visible at once', async () => {
  page = await demo.open('#/m/M1/operate', 'en', { width: 1440, height: 900 });
  const box = (what: string) => placed(page.locator(what).first());
  await page.locator('#deploy').waitFor();
  for (const [width, height, least] of [
    [1440, 900, 0.5],
    [1024, 768, 0.4],
    [2560, 1440, 0.5],
  ] as const) {
    await page.setViewportSize({ width, height });
    await until(async () => {
      const plan = await box('lf-plan');
      return (plan.width * (Math.min(plan.y + plan.height, height) - plan.y)) / (width * height) >= least;
    });
    await settled(page);
    for (const what of ['#deploy', '#seek', '#draw', '#Valve1 .close-button', 'lf-joystick']) {
      const { y, height: high } = await box(what);
      expect(y + high, `${what} at ${width}`).toBeLessThanOrEqual(height);
    }
  }
});

test("the water in 3D lands where the simulator's does, at 28 m", { timeout: 500_000 }, async () => {
  const { site } = await demo.get<{
    site: { monitors: Record<string, { at: [number, number] }>; tanks: { name: string; at: [number, number] }[] };
  }>('/api/hub');
  const [from, tank] = [site.monitors.M1!.at, site.tanks.find(({ name }) => name === 'T-1')!.at];
  expect(Math.hypot(tank[0] - from[0], tank[1] - from[1])).toBeCloseTo(28.3, 0);
  await demo.request('M1', 'Deploy Deployer');
  await until(async () => (await flags('Deployer')).includes('Deployed'), 2 * LATE_MS);
  await demo.request('M1', 'Open Valve1');
  await until(async () => ((await status()).subsystems.General!.pressure as number) > 60, 2 * LATE_MS);
  // The barrel points at the tank at rest; it is raised for the jet.
  const answer = await demo.post('/api/monitors/M1/aim', { way_m: 28.3, rise_m: 0 });
  const { elevation_arcmin } = (await answer.json()) as { elevation_arcmin: number };
  expect(elevation_arcmin).toBeGreaterThan(0);
  await demo.request('M1', `Move Vertical ${elevation_arcmin}`);
  await until(
    async () =>
      !(await flags('Vertical')).includes('Move') &&
      (await status()).subsystems.Vertical!.position === elevation_arcmin,
    2 * LATE_MS,
  );
  page = await demo.open('#/m/M1/operate');
  await page.getByText('3D', { exact: true }).click();
  interface Body {
    kind: number;
    track: { at(s: number): [number, number, number]; end_s: number } | null;
  }
  const ends = () =>
    page.locator('lf-scene').evaluate((scene) => {
      const { world } = scene as unknown as {
        world: {
          particles: { bodies: Body[] };
          shown: { scene: Scene; monitors: { id: string; lands: [number, number] | null }[] };
        } | null;
      };
      const water = world?.particles.bodies.filter(({ track }) => track !== null) ?? [];
      const last = water.at(-1)?.track;
      const at = last?.at(last.end_s);
      const lands = world?.shown.monitors.find(({ id }) => id === 'M1')?.lands;
      return at && lands && { at: [at[0], -at[2]] as [number, number], lands, many: water.length };
    });
  let seen = await ends();
  await until(async () => {
    seen = await ends();
    return (seen?.many ?? 0) > 30;
  }, 2 * LATE_MS);
  const drawn = seen!;
  expect(Math.hypot(drawn.at[0] - drawn.lands[0], drawn.at[1] - drawn.lands[1])).toBeLessThan(1);
  // While a poll is late the hub has no valid pressure, and thus no jet.
  let jet: Jet | undefined;
  await until(async () => {
    [jet] = (await (await demo.post('/api/jets', { jets: [{ monitor: 'M1' }] })).json()) as Jet[];
    return Boolean(jet?.flight);
  });
  expect(jet!.flight!.lands_m).toBeGreaterThan(20);
  await demo.request('M1', 'Close Valve1');
  await demo.post('/api/monitors/M1/authority', { action: 'release' });
});

test('a broken pressure sensor is a bad value, and is not used to aim without consent', async () => {
  page = await demo.open('#/m/M1/operate');
  const fault = (on: boolean) => demo.post('/api/sim/faults', { monitor: 'M1', fault: 'pressure-break', on });
  expect((await fault(true)).ok).toBe(true);
  try {
    const pressure = page.locator('lf-page-operate .strip lf-value', { hasText: 'Pressure' });
    await pressure.getByText('not valid').waitFor();
    await takeButton(page).click();
    await able(page.locator('#aim')).click();
    await page.locator('#aim button[aria-pressed=true]').waitFor();
    await settled(page);
    const before = (await status()).subsystems.Horizontal!.position;
    const plan = await placed(page.locator('lf-plan'));
    await page.mouse.click(plan.x + plan.width * 0.6, plan.y + plan.height * 0.5);
    await page.locator('lf-dialogs').getByText('The pressure is not known').waitFor();
    await page.locator('lf-dialogs').getByText('Cancel', { exact: true }).click();
    await page.getByRole('dialog').waitFor({ state: 'detached' });
    await passes(page, 500);
    expect((await status()).subsystems.Horizontal!.position).toBe(before);
    await go(page, '#/overview');
    await page.locator('#card-M1').getByText('not valid').waitFor();
  } finally {
    await fault(false);
  }
});
