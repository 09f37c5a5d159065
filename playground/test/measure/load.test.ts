// How long a first visit takes: from the address to the picture of the monitor. `npm run measure`.
import { chromium } from 'playwright-core';
import { expect, test } from 'vitest';
import { served } from '../served';

const VISITS = 10;

test.each([
  ['as it is', 1, undefined],
  ['a processor four times slower', 4, undefined],
  ['a line of 10 Mbit/s and 40 ms', 1, { latency: 40, downloadThroughput: 1_250_000, uploadThroughput: 125_000 }],
] as const)('first load, %s', async (name, slower, line) => {
  const files = await served();
  const browser = await chromium.launch({ executablePath: '/usr/bin/chromium', args: ['--no-sandbox'] });
  const times: number[] = [];
  try {
    for (let visit = 0; visit < VISITS; visit += 1) {
      // Nothing is in the cache of a new context.
      const context = await browser.newContext();
      const page = await context.newPage();
      const devtools = await context.newCDPSession(page);
      await devtools.send('Emulation.setCPUThrottlingRate', { rate: slower });
      await devtools.send('Network.enable');
      if (line) await devtools.send('Network.emulateNetworkConditions', { offline: false, ...line });
      await page.goto(files.url);
      await page.locator('pg-scene svg').first().waitFor();
      times.push(await page.evaluate(() => performance.now()));
      await context.close();
    }
  } finally {
    await browser.close();
    await files.end();
  }
  times.sort((a, b) => a - b);
  const [median, worst] = [times[VISITS / 2]!, times.at(-1)!];
  console.log(`${name}: median ${median.toFixed(0)} ms, at most ${worst.toFixed(0)} ms, ${VISITS} visits`);
  expect(median).toBeLessThan(10_000);
});
