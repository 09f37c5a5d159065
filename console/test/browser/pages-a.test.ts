// Alarms, event log, inspector, diagnosis, administration: in a browser against the real program.
import { readFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import type { Page } from 'playwright-core';
import { afterAll, afterEach, beforeAll, describe, expect, test } from 'vitest';
import type { Alarm, AuditEntry } from '../../src/hub/types';
import { Guarded } from './guarded';
import { able, clickUntil, drawn, go, LATE_MS, passes, placed, SOON, settled, take, until } from './page';
import { Site } from './site';

const AXE = createRequire(import.meta.url).resolve('axe-core/axe.min.js');
const LOCKED = 'M2/General/LockedOut';

let site: Site;
const pages: Page[] = [];

beforeAll(async () => {
  site = await Site.start();
});
afterAll(() => site?.stop());

afterEach(async () => {
  site.way.mend();
  for (const link of site.links) link.mend();
  for (const page of pages.splice(0)) await page.context().close();
  await site.send('M2', 'Lockout All off');
  await until(async () => (await alarm(LOCKED))?.active !== true);
  // A test that has failed leaves it there.
  await post('/api/alarms/unshelve', { id: LOCKED });
  await post('/api/alarms/ack', {});
  await until(async () => (await get<Alarm[]>('/api/alarms')).every((one) => one.active));
});

async function get<T>(path: string): Promise<T> {
  const answer = await fetch(`${site.api}${path}`);
  return (await answer.json()) as T;
}

async function post(path: string, body: unknown): Promise<Response> {
  const headers = { 'content-type': 'application/json' };
  return fetch(`${site.api}${path}`, { method: 'POST', headers, body: JSON.stringify(body) });
}

async function alarm(id: string): Promise<Alarm | undefined> {
  return (await get<Alarm[]>('/api/alarms')).find((one) => one.id === id);
}

async function open(route: string, lang = 'en', size?: { width: number; height: number }): Promise<Page> {
  const page = await site.open(route, lang, size);
  pages.push(page);
  return page;
}

/** Until it is so, without alarms of a machine on which the hub hears its monitors late: they go when they are acknowledged. */
async function quietUntil(so: () => Promise<boolean>): Promise<void> {
  await until(async () => {
    const others = (await get<Alarm[]>('/api/alarms')).filter(({ id, state }) => id !== LOCKED && state !== 'ack');
    if (others.length > 0) await post('/api/alarms/ack', { ids: others.map(({ id }) => id) });
    return so();
  }, LATE_MS);
}

/** Locks M2 out without the console, and waits for the alarm. */
async function lockOut(): Promise<void> {
  await site.send('M2', 'Lockout All on');
  await until(async () => (await alarm(LOCKED)) !== undefined);
}

describe('alarms', () => {
  test('that were never in the list are not acknowledged with the others', async () => {
    const page = await open('#/alarms');
    await quietUntil(() => page.getByText('No alarms').last().isVisible());
    await page.locator('lf-tabbar [data-tab=history]').click();
    await page.locator('lf-alarm-history').waitFor();
    await lockOut();
    const all = page.locator('#ack-all button');
    await quietUntil(async () => (await all.getAttribute('aria-description'))?.includes('not in the list') === true);
    await page.locator('lf-tabbar [data-tab=active]').click();
    await page.locator(`[data-id="${LOCKED}"]`).waitFor();
    await able(page.locator('#ack-all')).click();
    await until(async () => (await alarm(LOCKED))?.state === 'ack');
  });

  test('come, say what to do, are acknowledged at the hub, and go', async () => {
    const page = await open('#/alarms');
    await quietUntil(() => page.getByText('No alarms').last().isVisible());
    await lockOut();
    const row = page.locator(`[data-id="${LOCKED}"]`);
    await row.getByText('Unacknowledged').waitFor();
    await quietUntil(() => page.locator('lf-nav a[href="#/alarms"] .count', { hasText: /^1$/ }).isVisible());
    const more = row.getByText('Find out who locked it', { exact: false });
    await clickUntil(page, row.locator('[data-act=more]'), () => more.isVisible());
    await able(row.locator('[data-act=ack]')).click();
    await row.getByText('Acknowledged', { exact: true }).waitFor();
    expect((await alarm(LOCKED))?.state).toBe('ack');
    expect((await alarm(LOCKED))?.ack?.user).toBe('demo');
    await drawn(page);
    expect(await row.locator('[data-act=ack]').count()).toBe(0);
    await site.send('M2', 'Lockout All off');
    await row.waitFor({ state: 'detached' });
    await page.locator('lf-tabbar [data-tab=history]').click();
    for (const step of ['Raised', 'Acknowledged', 'Returned to normal']) {
      await page.locator('lf-alarm-history .step', { hasText: step }).first().waitFor();
    }
  });

  test('are shelved for a time with a reason, and come back', async () => {
    await lockOut();
    const page = await open('#/alarms');
    await able(page.locator(`[data-id="${LOCKED}"] [data-act=shelve]`)).click();
    const yes = page.locator('lf-dialogs lf-button[data-yes]');
    await yes.click();
    await page.locator('.lf-why').waitFor();
    await passes(page, 300);
    expect((await alarm(LOCKED))?.state, 'not without a reason').toBe('unack');
    await page.locator('lf-dialogs input[name=reason]').fill('The gate is being painted');
    await page.locator('lf-dialogs lf-button', { hasText: '4 h' }).click();
    await able(yes).click();
    await until(async () => (await alarm(LOCKED))?.state === 'shelved');
    const { shelved } = (await alarm(LOCKED))!;
    expect(shelved?.reason).toBe('The gate is being painted');
    const hours = (shelved!.until_ms - Date.now()) / 3_600_000;
    expect(hours).toBeGreaterThan(3.9);
    expect(hours).toBeLessThan(4.1);
    await quietUntil(() => page.getByText('No alarms').last().isVisible());
    await page.locator('lf-tabbar [data-tab=shelved]').click();
    await page.getByText('“The gate is being painted”', { exact: false }).waitFor();
    const unshelve = able(page.locator(`[data-id="${LOCKED}"] [data-act=unshelve]`));
    await clickUntil(page, unshelve, async () => (await alarm(LOCKED))?.state === 'unack');
  });

  test('do not move under a hand that aims at one', async () => {
    await lockOut();
    const page = await open('#/alarms');
    const row = page.locator(`[data-id="${LOCKED}"]`);
    await row.waitFor();
    const list = page.locator('lf-page-alarms .list > .alarm');
    await quietUntil(async () => (await list.count()) === 1);
    await settled(page);
    await row.hover();
    const [before, many] = [(await placed(row)).y, await list.count()];
    site.links[0]!.cut();
    // A pointer moves a little before a press; what is under it is read at one moment.
    let step = 0;
    let seen = { fresh: false, count: 0, y: 0 };
    await until(async () => {
      await row.hover({ position: { x: 200 + (step++ % 2), y: 20 } });
      seen = await row.evaluate((one) => {
        const root = one.getRootNode() as ShadowRoot;
        const count = root.querySelectorAll('.list > .alarm').length;
        return { fresh: root.querySelector('.fresh') !== null, count, y: one.getBoundingClientRect().y };
      });
      return seen.fresh;
    }, LATE_MS);
    expect(seen.count, 'what is new waits').toBe(many);
    expect(seen.y).toBe(before);
    await page.mouse.move(5, 400);
    await until(async () =>
      (await page.locator('lf-page-alarms .list > .alarm').first().getAttribute('class'))!.includes('high'),
    );
  });

  test('are old when the hub is lost, and nothing can be acknowledged', async () => {
    await lockOut();
    const page = await open('#/alarms');
    const ack = page.locator(`[data-id="${LOCKED}"] [data-act=ack]`);
    await ack.waitFor();
    site.way.freeze();
    await page.getByText('No connection to the hub', { exact: false }).last().waitFor();
    await until(async () => (await ack.locator('button').getAttribute('aria-disabled')) === 'true');
    await drawn(page);
    expect(await ack.locator('button').getAttribute('aria-description')).toBe('No connection to the hub');
  });
});

describe('the event log', () => {
  // A command waits 50 ms for its entry to be on the disk; on a slower one the entry has a line of its own.
  let degrees = 4;
  test('has a command with its answer and effect in one line, and the chain is intact', { retry: 2 }, async () => {
    degrees += 1;
    const page = await open('#/events');
    await page.getByText('Chain intact', { exact: false }).waitFor();
    await until(async () => (await post('/api/monitors/M1/authority', { action: 'take' })).ok);
    const move = `Move Horizontal ${degrees * 60}`;
    await post('/api/monitors/M1/requests', { request: move });
    await post('/api/monitors/M1/requests', { request: 'Wrap' });
    const line = page.locator('tr.deed', { hasText: `to ${degrees}.0°` });
    await line.locator('.effect').waitFor();
    await expect.poll(() => line.count(), SOON).toBe(1);
    await expect.poll(() => line.locator('.fate').textContent(), SOON).toContain('accepted');
    await expect.poll(() => line.locator('.effect').textContent(), SOON).toContain('°');
    await line.click();
    const inside = page.locator('tr.inside');
    await inside.getByText('2 s later').waitFor();
    await expect.poll(() => inside.locator('.entry').count(), SOON).toBe(3);
    const { entries } = await get<{ entries: AuditEntry[] }>('/api/audit?limit=50');
    const asked = entries.find((entry) => entry.what === move && entry.outcome === 'asked')!;
    expect(await inside.textContent()).toContain(asked.hash);
    await page.locator('select[name=kind]').selectOption('authority');
    await page.locator('tr.deed', { hasText: 'Took control' }).first().waitFor();
    await line.waitFor({ state: 'detached' });
    await page.locator('select[name=kind]').selectOption('');
    await page.locator('lf-find input').fill(move.slice(5).toLowerCase());
    await until(async () => (await page.locator('tr.deed').count()) === 1);
    await post('/api/monitors/M1/authority', { action: 'release' });
    await site.send('M1', 'Stop All');
  });

  test('shows what was not allowed', async () => {
    await post('/api/monitors/M2/requests', { request: 'Restart', confirm: 'wrong' });
    const page = await open('#/events');
    await page.locator('select[name=kind]').selectOption('bad');
    const line = page.locator('tr.deed', { hasText: 'Restart' }).first();
    await line.waitFor();
    await expect.poll(() => line.locator('.fate').textContent(), SOON).toContain('not allowed');
    await page.locator('select[name=kind]').selectOption('');
    const [asked] = await Promise.all([
      page.waitForRequest((request) => request.url().includes('/api/audit?') && request.url().includes('text=Restart')),
      page.locator('lf-audit-log lf-find input').fill('Restart'),
    ]);
    expect(new URL(asked.url()).searchParams.get('text')).toBe('Restart');
    await until(async () => {
      const all = await page.locator('tr.deed').allTextContents();
      return all.length > 0 && all.every((text) => text.includes('Restart'));
    });
    await line.waitFor();
  });

  test('has what happened before the page was opened, and finds it', async () => {
    site.links[1]!.cut();
    await until(async () => (await get<{ link: { state: string } }>('/api/monitors/M2')).link.state === 'down');
    site.links[1]!.mend();
    await until(async () => (await get<{ link: { state: string } }>('/api/monitors/M2')).link.state === 'up');
    const page = await open('#/events');
    await page.locator('lf-tabbar [data-tab=live]').click();
    const lines = page.locator('.live .event');
    await lines.filter({ hasText: 'M2' }).first().waitFor();
    const text = (await lines.filter({ hasText: 'M2' }).first().locator('span').last().textContent())!.trim();
    await page.locator('lf-page-events lf-find input').fill(text);
    await until(async () => {
      const all = await lines.allTextContents();
      return all.length > 0 && all.every((line) => line.includes(text));
    });
  });
});

describe('the inspector', () => {
  test('shows frames as they pass, takes one apart, and pauses', async () => {
    const page = await open('#/m/M1/inspector');
    await page.locator('.frame.in').first().waitFor();
    await page.locator('#pause').click();
    const passed = page.locator('.foot b');
    await passed.waitFor();
    const before = await page.locator('.foot span').first().textContent();
    const told = await passed.textContent();
    await until(async () => (await passed.textContent()) !== told);
    expect(await page.locator('.foot span').first().textContent()).toBe(before);
    await page.locator('.frame.in').last().click();
    await page.locator('lf-frame-decoded summary', { hasText: 'General' }).click();
    const voltage = page.locator('lf-frame-decoded .field', { hasText: 'main_voltage' });
    await expect.poll(() => voltage.locator('.value').textContent(), SOON).toContain('24 V');
    expect(await voltage.locator('.raw').textContent()).toBe('18 00');
    await page.locator('select[name=polls]').selectOption('off');
    await page.getByText('Nothing matches').waitFor();
  });

  test('completes a request by the keyboard, sends it, and shows its frame', async () => {
    const page = await open('#/m/M1/inspector');
    await page.locator('select[name=polls]').selectOption('off');
    const field = page.locator('input[name=request]');
    await field.click();
    const offered = page.locator('#offers [role=option]').first();
    await field.pressSequentially('getp');
    await offered.waitFor();
    await page.keyboard.press('Tab');
    await until(async () => (await field.inputValue()) === 'GetParam ');
    await field.pressSequentially('vert');
    await offered.waitFor();
    await page.keyboard.press('Tab');
    await until(async () => (await field.inputValue()) === 'GetParam Vertical ');
    await field.pressSequentially('minl');
    await offered.waitFor();
    await page.keyboard.press('ArrowDown');
    await page.keyboard.press('Enter');
    await until(async () => (await field.inputValue()) === 'GetParam Vertical MinLimit');
    await page.getByText('Allowed for all users', { exact: false }).waitFor();
    await able(page.locator('#send')).waitFor();
    await page.keyboard.press('Enter');
    await page.locator('.outcome', { hasText: 'Vertical GetParam → Ok: MinLimit' }).waitFor();
    await page.locator('.frame.out', { hasText: 'GetParam Vertical MinLimit' }).waitFor();
    await page.locator('.frame.in', { hasText: 'Vertical GetParam → Ok' }).click();
    await page.locator('lf-frame-decoded .value', { hasText: 'MinLimit' }).waitFor();
  });

  test('moves nothing without control, and asks for the id where the hub does', async () => {
    const page = await open('#/m/M1/inspector');
    const field = page.locator('input[name=request]');
    const send = page.locator('#send button');
    const at = await site.position('M1');
    await field.fill('Move Horizontal 1800');
    await until(async () => (await send.getAttribute('aria-description')) === 'Take control of M1 first');
    await send.click({ force: true });
    await page.locator('.lf-why', { hasText: 'Take control of M1 first' }).waitFor();
    await field.press('Escape');
    await field.press('Enter');
    await passes(page, 500);
    expect(await site.position('M1')).toBe(at);
    expect(await site.moves('M1')).toBe(false);
    await take(page);
    await field.fill('Restart All');
    await field.press('Escape');
    await send.click();
    const yes = page.locator('lf-dialogs lf-button').last();
    await expect.poll(() => yes.locator('button').getAttribute('aria-disabled'), SOON).toBe('true');
    await page.locator('lf-dialogs lf-button', { hasText: 'Cancel' }).click();
    await page.getByRole('dialog').waitFor({ state: 'detached' });
    await passes(page, 300);
    const { entries } = await get<{ entries: AuditEntry[] }>('/api/audit?limit=50&monitor=M1');
    expect(entries.filter((entry) => entry.what === 'Restart All' && entry.monitor === 'M1')).toEqual([]);
    await field.fill('Mve Horizontal 1');
    await field.press('Escape');
    await send.click();
    await page.locator('.outcome.bad .at').waitFor();
  });
});

describe('diagnosis', () => {
  test('has what is set first, with cause and remedy, and what to try', async () => {
    await lockOut();
    const page = await open('#/m/M2/diagnosis');
    const flag = page.locator('#set [data-flag="General/LockedOut"]');
    await flag.waitFor();
    await expect.poll(() => flag.textContent(), SOON).toContain('What to do');
    await expect.poll(() => page.locator('#try li').first().textContent(), SOON).toContain('Find out who locked it');
    await page.locator('lf-all-flags lf-find input').fill('PosEncoderFault');
    const known = page.locator('lf-all-flags [data-flag$="/PosEncoderFault"]');
    await known.first().waitFor();
    await expect.poll(() => known.count(), SOON).toBeGreaterThanOrEqual(4);
    await page.getByText('There has been no hardware fault.').waitFor();
  });

  test('does not say that all is well with a silent monitor', async () => {
    const page = await open('#/m/M1/diagnosis');
    await page.getByText('No faults and no warnings', { exact: true }).waitFor();
    site.links[0]!.cut();
    await page.getByText('No data since', { exact: false }).waitFor();
    await drawn(page);
    expect(await page.getByText('No faults and no warnings', { exact: true }).count()).toBe(0);
    await page.locator('#try li.urgent').first().waitFor();
    await page.locator('lf-link-stats lf-chip', { hasText: 'No connection' }).waitFor();
  });

  test('saves a report with all known data', async () => {
    const page = await open('#/m/M1/diagnosis');
    await page.getByText('There has been no hardware fault.').waitFor();
    // It takes one each second.
    await passes(page, 1500);
    const [download] = await Promise.all([page.waitForEvent('download'), able(page.locator('#report')).click()]);
    expect(download.suggestedFilename()).toMatch(/^lafet-report-M1-\d{4}-\d\d-\d\d_.*\.json$/);
    const report = JSON.parse(readFileSync(await download.path(), 'utf8'));
    expect(report.monitor.id).toBe('M1');
    expect(report.monitor.status.subsystems.General.main_voltage).toBeGreaterThan(20);
    expect(report.crash.filled).toBe(false);
    expect(report.params.values).toBeTypeOf('object');
    expect(report.link_samples.length).toBeGreaterThan(0);
  });
});

describe('administration', () => {
  test('adds a user and a token, which is shown once and works', async () => {
    const page = await open('#/admin');
    await able(page.locator('#add-user')).click();
    const yes = page.locator('lf-dialogs lf-button[data-yes]');
    await page.locator('lf-dialogs input[name=name]').fill('anna');
    await page.locator('lf-dialogs input[name=password]').fill('short');
    const why = () => yes.locator('button').getAttribute('aria-description');
    await expect.poll(why, SOON).toContain('10 characters');
    await page.locator('lf-dialogs lf-button', { hasText: 'Suggest' }).click();
    await page.locator('lf-dialogs select[name=role]').selectOption('administrator');
    await able(yes).click();
    const row = page.locator('tr[data-user=anna]');
    await row.waitFor();
    const last = row.locator('[data-act=remove] button');
    await expect.poll(() => last.getAttribute('aria-description'), SOON).toContain('last administrator');
    await page.locator('lf-tabbar [data-tab=tokens]').click();
    await able(page.locator('#add-token')).click();
    await page.locator('lf-dialogs input[name=name]').fill('SCADA');
    await able(yes).click();
    const token = await page.locator('lf-dialogs textarea[name=token]').inputValue();
    expect(token).toMatch(/^lafet_/);
    expect(await everything(page)).toContain(token);
    await able(yes).click();
    await page.locator('tr[data-token=SCADA]').waitFor();
    await page.getByRole('dialog').waitFor({ state: 'detached' });
    expect(await everything(page)).not.toContain(token);
    await able(page.locator('tr[data-token=SCADA] [data-act=remove]')).click();
    await able(page.locator('lf-dialogs lf-button', { hasText: 'Revoke' }).last()).click();
    await page.getByText('No tokens').waitFor();
    expect(await get('/api/tokens')).toEqual([]);
    await page.locator('lf-tabbar [data-tab=sessions]').click();
    const own = page.locator('tr[data-session]', { hasText: 'you' });
    await own.waitFor();
    await expect
      .poll(() => own.locator('[data-act=end] button').getAttribute('aria-description'), SOON)
      .toContain('did not log in with a password');
  });
});

describe('with login', () => {
  test('an observer reads alarms and sees why the rest is not for observers', async () => {
    const guarded = await Guarded.start();
    try {
      const page = await site.open('#/alarms', 'en', undefined);
      pages.push(page);
      await guarded.enter(page, 'olga');
      await page.locator('#ack-all').waitFor();
      await page.locator('lf-nav a[href="#/events"]').waitFor();
      expect(await page.locator('lf-nav a[href="#/admin"]').count()).toBe(0);
      await page.locator('lf-nav a[href="#/events"]').click();
      await page.locator('lf-tabbar [data-tab=log]').click();
      await page.getByText('for operators and above', { exact: false }).waitFor();
      await go(page, '#/admin');
      await page.locator('lf-admin-own').waitFor();
      expect(await page.locator('lf-tabbar [data-tab=users]').count()).toBe(0);
      await page.locator('input[name=old]').fill(guarded.password);
      await page.locator('input[name=new]').fill('another password');
      await page.locator('input[name=again]').fill('another password');
      await able(page.locator('#save-password')).click();
      await page.getByText('The password is changed').waitFor();
      expect(await guarded.login('olga', guarded.password)).toBe(401);
    } finally {
      await guarded.stop();
    }
  });
});

describe('every page', () => {
  const ROUTES = ['#/alarms', '#/events', '#/m/M2/inspector', '#/m/M2/diagnosis', '#/admin'];
  const SIZES = [
    { width: 390, height: 844 },
    { width: 1024, height: 768 },
    { width: 2560, height: 1440 },
  ];

  test.each(ROUTES)('%s: axe finds nothing, nothing is cut off, targets are 48 px', async (route) => {
    await lockOut();
    for (const [lang, theme] of [
      ['en', 'day'],
      ['ru', 'night'],
    ] as const) {
      const page = await open(route, lang);
      await page.evaluate((wanted) => (document.documentElement.dataset.theme = wanted), theme);
      await page.locator('lf-app main h1').waitFor();
      for (const size of SIZES) {
        await page.setViewportSize(size);
        await settled(page);
        const main = page.locator('lf-app main');
        const wide = await main.evaluate((el) => el.scrollWidth - el.clientWidth);
        expect(wide, `${route} ${lang} at ${size.width}`).toBeLessThanOrEqual(0);
        expect(await small(page), `${route} ${lang} at ${size.width}`).toEqual([]);
        if (size.width === 1024) expect(await axe(page), `${route} ${lang} ${theme}`).toEqual([]);
      }
    }
  });
});

/** All texts of the page and of its fields, through all shadow roots. */
function everything(page: Page): Promise<string> {
  return page.evaluate(() => {
    const told = (root: Document | ShadowRoot): string[] =>
      [...root.querySelectorAll('*')].flatMap((one) => [
        (one as HTMLInputElement).value ?? '',
        one.shadowRoot ? one.shadowRoot.innerHTML : '',
        ...(one.shadowRoot ? told(one.shadowRoot) : []),
      ]);
    return [document.documentElement.outerHTML, ...told(document)].join('\n');
  });
}

interface Found {
  violations: { id: string; nodes: { target: unknown[]; failureSummary?: string }[] }[];
  passes: unknown[];
}

async function axe(page: Page): Promise<string[]> {
  await page.evaluate(readFileSync(AXE, 'utf8'));
  const { violations, passes } = await page.evaluate(() => {
    const { axe } = window as unknown as { axe: { run: (of: object, options: object) => Promise<Found> } };
    const of = { include: [{ fromShadowDom: ['lf-app', 'main'] }] };
    return axe.run(of, { runOnly: ['wcag2a', 'wcag2aa', 'wcag21a', 'wcag21aa', 'wcag22aa'] });
  });
  expect(passes.length, 'it has looked').toBeGreaterThan(8);
  return violations.flatMap(({ id, nodes }) =>
    nodes.map((node) => `${id}: ${JSON.stringify(node.target)} ${node.failureSummary ?? ''}`),
  );
}

/** Controls of the page that are lower than 48 px, or not visible. */
function small(page: Page): Promise<string[]> {
  return page.locator('lf-app main').evaluate((main) => {
    const found: string[] = [];
    const walk = (root: Element | ShadowRoot) => {
      for (const el of root.querySelectorAll('*')) {
        if (el.shadowRoot) walk(el.shadowRoot);
        if (!el.matches('button, select, input, textarea, summary, [role=tab], [role=option], a[href]')) continue;
        const { height, width, right } = el.getBoundingClientRect();
        if (width === 0 || height === 0) continue;
        const outside = right > innerWidth && !el.closest('[role=tablist]');
        if (height < 47.5 || outside) found.push(`${el.outerHTML.slice(0, 120)} ${height} to ${right}`);
      }
    };
    walk(main);
    return found;
  });
}
