// How quick the console is, and whether it stays so: first paint, shifts of the layout, frames and work of the
// main thread on live data, memory after an hour of messages. LAFET_BIN is the program with the console
// built in; with LAFET_URL a demo that runs already is measured. `throttle` (default 4) slows the browser's processor so many
// times down for first paint and for a second column of frames.
//
// Pages are drawn without WebGL: Chromium then paints them itself. Through a WebGL that is emulated each of their
// pictures would take 0.1 s, and what would be measured is the emulation.
import { readdirSync, readFileSync } from 'node:fs';
import { gzipSync } from 'node:zlib';
import { PLAIN, WEBGL, withDemo } from './demo.mjs';

const throttle = Number(process.argv[2] ?? 4);
/** `pages`, `scene` or `memory`: that alone. */
const part = process.argv[3] ?? 'all';
const wanted = (name) => part === 'all' || part === name;
if (!(throttle >= 1) || !['all', 'pages', 'scene', 'memory'].includes(part)) {
  console.error(
    `measure ${process.argv.slice(2).join(' ')}: how many times slower (1 and more), then pages, scene, memory or nothing`,
  );
  process.exit(2);
}
const PAGES = [
  'overview',
  'm/M1/operate',
  'alarms',
  'events',
  'm/M1/params',
  'm/M1/programs',
  'm/M1/commissioning',
  'm/M1/diagnosis',
  'm/M1/inspector',
  'replay',
  'training',
  'admin',
];
const LIVE_MS = 8_000;
/** A page with nothing on it: what this browser and machine give at most. */
const BLANK = 'blank';
const HOUR_MS = 3_600_000;
const LEARN_MS = 15_000;
const ROUNDS = 5;

await withDemo(
  async (browser, url) => {
    if (wanted('pages')) {
      sizes();
      await water(url);
      await pages(browser, url);
    }
    if (wanted('memory')) {
      await hour(browser, url);
      await rounds(browser, url);
    }
  },
  PLAIN,
  ['--enable-precise-memory-info'],
);
if (wanted('scene')) await withDemo(scene, WEBGL);

/** What the first page loads, and everything. */
function sizes() {
  const folder = new URL('../dist/assets/', import.meta.url).pathname;
  const all = readdirSync(folder).filter((name) => /\.(js|css)$/.test(name));
  const kib = (names) =>
    (names.reduce((sum, name) => sum + gzipSync(readFileSync(folder + name)).length, 0) / 1024).toFixed(0);
  const scene = all.filter((name) => name.startsWith('world-'));
  console.log(
    `bundle, gzip: all but 3D ${kib(all.filter((name) => !scene.includes(name)))} KiB in ${all.length - scene.length} files, 3D (when it is opened) ${kib(scene)} KiB`,
  );
}

/** The monitors work: what is measured is a fire being fought. */
async function water(url) {
  const post = (path, body) =>
    fetch(url + path, { method: 'POST', headers: { 'content-type': 'application/json' }, body: JSON.stringify(body) });
  await post('/api/sim/scenario', { id: 'tank-farm', automatic: true });
  await new Promise((done) => setTimeout(done, 20_000));
}

async function opened(browser, slow = throttle) {
  const context = await browser.newContext({ viewport: { width: 1440, height: 900 } });
  await context.addInitScript(() => {
    localStorage.setItem('lafet.guide', 'done');
    localStorage.setItem('lafet.lang', 'en');
    const seen = { shift: 0, long: 0 };
    window.measured = seen;
    new PerformanceObserver((list) => {
      for (const entry of list.getEntries()) if (!entry.hadRecentInput) seen.shift += entry.value;
    }).observe({ type: 'layout-shift', buffered: true });
  });
  const page = await context.newPage();
  const cdp = await context.newCDPSession(page);
  await cdp.send('Performance.enable', { timeDomain: 'threadTicks' });
  await cdp.send('Emulation.setCPUThrottlingRate', { rate: slow });
  return { context, page, cdp };
}

async function metrics(cdp) {
  return Object.fromEntries((await cdp.send('Performance.getMetrics')).metrics.map(({ name, value }) => [name, value]));
}

async function pages(browser, url) {
  console.log(
    `\n| page | first paint ÷ ${throttle}, ms | live after, ms | layout shift | main thread busy | frames/s | 95 of 100 within, ms | main thread busy ÷ ${throttle} | frames/s ÷ ${throttle} |`,
  );
  console.log('|---|---|---|---|---|---|---|---|---|');
  for (const route of [BLANK, ...PAGES]) {
    const { context, page, cdp } = await opened(browser);
    const { live, paint } = route === BLANK ? { live: NaN, paint: NaN } : await load(page, `${url}/#/${route}`);
    const slow = await watch(page, cdp);
    await cdp.send('Emulation.setCPUThrottlingRate', { rate: 1 });
    const full = await watch(page, cdp);
    const shift = await page.evaluate(() => window.measured?.shift ?? NaN);
    const cells = [
      route,
      paint.toFixed(0),
      live.toFixed(0),
      shift.toFixed(3),
      percent(full.busy),
      full.rate.toFixed(0),
      full.gap95.toFixed(0),
      percent(slow.busy),
      slow.rate.toFixed(0),
    ];
    console.log(`| ${cells.join(' | ').replaceAll('NaN', '')} |`);
    await context.close();
  }
}

function percent(share) {
  return `${(share * 100).toFixed(0)} %`;
}

async function load(page, address) {
  await page.goto(address);
  await page.waitForFunction(
    () => document.querySelector('lf-app')?.shadowRoot?.querySelector('main > :not(.boot)'),
    null,
    { polling: 20 },
  );
  const live = await page.evaluate(() => performance.now());
  const paint = await page.evaluate(
    () =>
      new Promise((resolve) => {
        const seen = (list) => {
          for (const entry of list.getEntries()) if (entry.name === 'first-contentful-paint') resolve(entry.startTime);
        };
        new PerformanceObserver(seen).observe({ type: 'paint', buffered: true });
      }),
  );
  return { live, paint };
}

/** Frames of some seconds, how far apart they came, and how much of the main thread's time was work. */
async function watch(page, cdp) {
  const before = await metrics(cdp);
  const times = await page.evaluate(
    (ms) =>
      new Promise((resolve) => {
        const seen = [performance.now()];
        const next = () => {
          seen.push(performance.now());
          if (seen.at(-1) - seen[0] < ms) requestAnimationFrame(next);
          else resolve(seen);
        };
        requestAnimationFrame(next);
      }),
    LIVE_MS,
  );
  const after = await metrics(cdp);
  const seconds = (times.at(-1) - times[0]) / 1000;
  const gaps = times
    .slice(1)
    .map((time, n) => time - times[n])
    .sort((a, b) => a - b);
  return {
    rate: gaps.length / seconds,
    gap95: gaps[Math.floor(gaps.length * 0.95)],
    busy: (after.TaskDuration - before.TaskDuration) / seconds,
  };
}

/**
 * What a picture in three dimensions costs the page. How long the card takes is not known where it is emulated; the first
 * pictures count, before the page has seen that they are slow and draws less.
 */
async function scene(browser, url) {
  await water(url);
  const { context, page } = await opened(browser, 1);
  await page.addInitScript(() => {
    const plain = window.requestAnimationFrame.bind(window);
    window.spent = [];
    window.requestAnimationFrame = (work) =>
      plain((time) => {
        const begun = performance.now();
        work(time);
        window.spent.push(performance.now() - begun);
      });
  });
  await page.goto(`${url}/#/m/M1/operate`);
  await page.getByText('3D', { exact: true }).click();
  const element = page.locator('lf-scene');
  await page.waitForFunction(
    () =>
      document.querySelector('lf-app').shadowRoot.querySelector('lf-page-operate')?.shadowRoot.querySelector('lf-scene')
        ?.figures?.particles > 100,
    null,
    { timeout: 60_000 },
  );
  await page.evaluate(() => (window.spent.length = 0));
  await page.waitForTimeout(LIVE_MS / 2);
  const { calls, particles, share } = await element.evaluate((one) => one.figures);
  // Other work of a frame is short: what draws is the longest of each.
  const spent = (await page.evaluate(() => window.spent)).filter((ms) => ms > 0.5).sort((a, b) => a - b);
  const at = (part) => spent[Math.floor(spent.length * part)]?.toFixed(1);
  console.log(
    `\n3D: script of a picture ${at(0.5)} ms, 95 of 100 within ${at(0.95)} ms; ${calls} draw calls, ${particles} particles of ${(share * 100).toFixed(0)} %`,
  );
  await context.close();
}

async function used(cdp) {
  for (let n = 0; n < 3; n += 1) await cdp.send('HeapProfiler.collectGarbage');
  const { usedSize } = await cdp.send('Runtime.getHeapUsage');
  const { Nodes, JSEventListeners } = await metrics(cdp);
  return { mib: usedSize / 2 ** 20, nodes: Nodes, listeners: JSEventListeners };
}

function shown({ mib, nodes, listeners }) {
  return `${mib.toFixed(1)} MiB, ${nodes} nodes, ${listeners} listeners`;
}

/** An hour of messages: those of some seconds again and again, as fast as they are taken, later each time. */
async function hour(browser, url) {
  const { context, page, cdp } = await opened(browser, 1);
  let down = null;
  let live = true;
  const kept = [];
  await page.routeWebSocket(/\/api\/ws/, (ws) => {
    const hub = ws.connectToServer();
    ws.onMessage((message) => live && hub.send(message));
    hub.onMessage((message) => {
      if (!live) return;
      if (String(message).startsWith('{"type":"change"')) kept.push(JSON.parse(String(message)));
      ws.send(message);
    });
    down = ws;
  });
  await page.goto(`${url}/#/m/M1/operate`);
  await page.locator('lf-page-operate lf-value').first().waitFor();
  kept.length = 0;
  await page.waitForTimeout(LEARN_MS);
  live = false;
  const messages = kept.slice();
  const first = messages[0].now_ms;
  const span = messages.at(-1).now_ms - first + 50;
  const begun = performance.now();
  let warm = null;
  let sent = 0;
  for (let offset = span; offset < HOUR_MS; offset += span) {
    for (const message of messages) {
      down.send(
        JSON.stringify(message, (key, value) =>
          /^(now|at|since|resumes)_ms$/.test(key) && value ? value + offset : value,
        ),
      );
      sent += 1;
    }
    await page.evaluate(() => new Promise(requestAnimationFrame));
    if (!warm && offset > HOUR_MS / 4) warm = await used(cdp);
  }
  await page.waitForTimeout(1000);
  const end = await used(cdp);
  const took = ((performance.now() - begun) / 1000).toFixed(0);
  console.log(
    `\noperate, an hour of messages (${sent}, in ${took} s): after 15 min ${shown(warm)}; after 60 min ${shown(end)}`,
  );
  await context.close();
}

/** Every page again and again. */
async function rounds(browser, url) {
  const { context, page, cdp } = await opened(browser, 1);
  await page.goto(`${url}/#/overview`);
  const seen = [];
  for (let n = 0; n <= ROUNDS; n += 1) {
    for (const route of PAGES) {
      await page.evaluate((to) => (location.hash = `#/${to}`), route);
      await page.waitForTimeout(700);
    }
    await page.evaluate(() => (location.hash = '#/overview'));
    await page.waitForTimeout(1000);
    seen.push(await used(cdp));
  }
  console.log(`every page, round after round: after 1 ${shown(seen[0])}; after ${ROUNDS + 1} ${shown(seen.at(-1))}`);
  await context.close();
}
