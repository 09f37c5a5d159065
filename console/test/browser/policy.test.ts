// The hub's policy lets no page load anything from other servers, run a script or apply a style that is not in its files:
// every page, and every dialog of it, complies.
import { afterAll, beforeAll, expect, test } from 'vitest';
import { Demo } from './demo';
import { go, pagesOf, settled, until } from './page';

let demo: Demo;
beforeAll(async () => {
  demo = await Demo.start();
});
afterAll(() => demo?.stop());

/** Buttons to press on a page, if present: what they open has styles of its own. */
const PRESSED: Record<string, string[]> = {
  '#/overview': ['lf-topbar button.wide', 'lf-topbar button[title=Settings]'],
  '#/events': ['tr.deed'],
  '#/m/M1/operate': ['lf-automatic lf-button', '#readiness'],
};

test('no page breaks the policy', { timeout: 400_000 }, async () => {
  const policy = (await fetch(`${demo.hub}/`)).headers.get('content-security-policy');
  expect(policy).toContain("style-src 'self';");
  expect(policy).not.toContain('unsafe');

  await demo.request('M1', 'Deploy Deployer');
  const page = await demo.open('#/overview');
  await page.context().addInitScript(() => {
    const broken: string[] = [];
    Object.assign(window, { broken });
    document.addEventListener('securitypolicyviolation', (event) => {
      broken.push(
        `${location.hash} ${event.violatedDirective} ${event.blockedURI} ${event.sample} ${event.sourceFile}:${event.lineNumber}`,
      );
    });
  });
  await page.reload();
  const all = await pagesOf(page);
  expect(all.length).toBeGreaterThan(11);
  for (const href of all) {
    await go(page, href);
    await settled(page);
    for (const pressed of PRESSED[href] ?? []) {
      await page.locator(pressed).first().click();
      await settled(page);
      await page.keyboard.press('Escape');
    }
  }
  expect(await page.evaluate(() => (window as unknown as { broken: string[] }).broken)).toEqual([]);
  // The listener works: an attribute is refused.
  await page.evaluate(() => document.body.setAttribute('style', 'margin: 1px'));
  await until(() => page.evaluate(() => (window as unknown as { broken: string[] }).broken.length > 0));
  await page.context().close();
});
