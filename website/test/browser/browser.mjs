// A browser and the site below a folder of a server, as a test uses them.
import { chromium } from 'playwright-core';
import { serve } from '../../build/server.mjs';

const CHROMIUM = process.env.CHROMIUM_BIN ?? '/usr/bin/chromium';
/** Limit of what must come at some time, on a machine that is loaded several times over. */
const LATE_MS = 60_000;

/** Starts both; `open` gives a page that is ready, and takes note of what it asks and complains about. */
export async function start(prefix = '/') {
  const { url, stop } = await serve(undefined, prefix);
  const browser = await chromium.launch({ executablePath: CHROMIUM, args: ['--no-sandbox', '--disable-gpu'] });
  const open = async (name, { width = 1360, height = 850, dark = false, ...more } = {}) => {
    const context = await browser.newContext({
      viewport: { width, height },
      colorScheme: dark ? 'dark' : 'light',
      reducedMotion: 'reduce',
      ...more,
    });
    context.setDefaultTimeout(LATE_MS);
    const page = await context.newPage();
    const seen = { requests: [], errors: [] };
    page.on('request', (request) => seen.requests.push(request.url()));
    page.on('pageerror', (error) => seen.errors.push(error.message));
    page.on('console', (message) => {
      if (message.type() === 'error') seen.errors.push(message.text());
    });
    await page.goto(url + name);
    if (more.javaScriptEnabled !== false) await ready(page);
    return { page, seen, close: () => context.close() };
  };
  const end = async () => {
    await browser.close();
    await stop();
  };
  return { url, open, end };
}

/** The page is alive: its frame answers. */
export async function ready(page) {
  await page.waitForFunction(() => document.querySelector('#app')?.__vue_app__ !== undefined);
  await page.waitForLoadState('networkidle');
}
