// The first minute, done as a newcomer would: each step ends by what the monitor says.
import type { Page } from 'playwright-core';
import { afterAll, beforeAll, expect, test } from 'vitest';
import type { Monitor } from '../../src/hub/types';
import { Demo } from './demo';
import { able, LATE_MS, middle, placed, SOON, settled, takeButton, until } from './page';

let demo: Demo;
beforeAll(async () => {
  demo = await Demo.start();
});
afterAll(() => demo?.stop());

const monitor = () => demo.get<Monitor>('/api/monitors/M1');
const flags = async (subsystem: string) => (await monitor()).status.subsystems[subsystem]!.flags;

async function step(page: Page, title: string): Promise<void> {
  await page.locator('lf-guide h2', { hasText: title }).waitFor({ timeout: LATE_MS });
}

async function hold(
  page: Page,
  selector: string,
  by: [number, number],
  until_it: () => Promise<boolean>,
): Promise<void> {
  await settled(page);
  // On a busy machine the page's heartbeats may be late; then the motion ends, as it must, and is held again.
  for (let tries = 1; ; tries += 1) {
    const [x, y] = await middle(page.locator(selector));
    await page.mouse.move(x, y);
    await page.mouse.down();
    await page.mouse.move(x + by[0], y + by[1], { steps: 3 });
    const done = await until(until_it, 6000).then(
      () => true,
      () => false,
    );
    await page.mouse.up();
    if (done) return;
    if (tries === 5) throw new Error(`nothing comes of holding ${selector}`);
  }
}

test('leads from taking control to a lost link', { timeout: 400_000 }, async () => {
  const page = await demo.open('#/overview');
  await page.locator('lf-page-overview').waitFor();
  await page.getByText('SIMULATION', { exact: true }).waitFor();
  await page.keyboard.press('?');
  await able(page.locator('lf-dialogs lf-button', { hasText: 'Show the first steps' })).click();
  await step(page, 'on fire');
  await page.locator('#guide-next').click();

  await step(page, 'Take control');
  await takeButton(page).click();
  await step(page, 'Deploy');
  expect((await monitor()).authority.state).toBe('held');

  // In a smaller window too, what the step is about lies above the guide.
  for (const [width, height] of [
    [1024, 768],
    [1440, 1000],
  ] as const) {
    await page.setViewportSize({ width, height });
    await until(async () => {
      const [button, card] = [await placed(page.locator('#deploy')), await placed(page.locator('lf-guide .card'))];
      return button.y + button.height <= card.y;
    });
  }

  await able(page.locator('#deploy')).click();
  await step(page, 'Hold to move');
  expect(await flags('Deployer')).toContain('Deployed');

  const before = (await monitor()).status.subsystems.Vertical!.position as number;
  const raised = async () => ((await monitor()).status.subsystems.Vertical!.position as number) > before + 240;
  await hold(page, 'lf-joystick .base', [0, -60], raised);

  await step(page, 'Open the water');
  const opens = async () => (await flags('Valve1')).some((flag) => flag.startsWith('Open'));
  await hold(page, '#Valve1 .open-button', [0, 0], opens);
  await step(page, 'to the fire');
  expect(await flags('Valve1')).toContain('Open');

  await expect.poll(() => page.locator('lf-guide').getByText('Press Aim').count(), SOON).toBe(1);
  await page.locator('#guide-skip').click();
  await step(page, 'automatically');
  // The guide never covers the monitor of its step.
  await settled(page);
  const [card, mark] = [
    await placed(page.locator('lf-guide .card')),
    await placed(page.locator('lf-plan [data-id="M1"]').first()),
  ];
  const apart =
    card.x + card.width <= mark.x ||
    mark.x + mark.width <= card.x ||
    card.y + card.height <= mark.y ||
    mark.y + mark.height <= card.y;
  expect(apart, JSON.stringify([card, mark])).toBe(true);
  await able(page.locator('#draw')).click();
  await page.locator('lf-automatic .sector').waitFor();
  await settled(page);
  const plan = await placed(page.locator('lf-plan'));
  const fire = [plan.x + plan.width * 0.48, plan.y + plan.height * 0.45] as const;
  await page.mouse.move(fire[0] - 25, fire[1] - 20);
  await page.mouse.down();
  await page.mouse.move(fire[0] + 25, fire[1] + 20, { steps: 4 });
  await page.mouse.up();
  await able(page.locator('#quench')).click();
  await step(page, 'connection is lost');
  expect(await flags('Control')).toContain('Quench');

  // It is lost for some seconds.
  const lost = page.getByText('No connection to the hub').first().waitFor();
  await page.locator('#guide-break').click();
  await lost;
  await until(async () => (await monitor()).authority.state === 'free', 6000);
  expect(await flags('Control')).toContain('Quench');
  await step(page, 'First steps completed');
  await page.locator('lf-guide').getByText('Done', { exact: true }).click();
  await page.locator('lf-guide').waitFor({ state: 'detached' });
  await page.context().close();
});
