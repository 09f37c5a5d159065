// What the scripts work on: `lafet demo` with the console built in (LAFET_BIN names the program), and Chromium.
import { spawn } from 'node:child_process';
import { chromium } from 'playwright-core';
import { preview } from 'vite';

/** What draws in a browser without a graphics card: WebGL too, in software; or pages alone, as on a PC without a driver. */
export const WEBGL = ['--use-gl=angle', '--use-angle=swiftshader', '--enable-unsafe-swiftshader'];
export const PLAIN = ['--disable-gpu'];

/**
 * Starts a demo and a browser, gives them to `work`, and ends both. With LAFET_URL a demo that runs already is taken, with
 * CONSOLE_DIST=1 the console in dist.
 */
export async function withDemo(work, drawing = WEBGL, more = []) {
  const program = process.env.LAFET_BIN;
  if (!program && !process.env.LAFET_URL)
    throw new Error('LAFET_BIN must name the lafet program, with the console built in');
  const demo = process.env.LAFET_URL
    ? null
    : spawn(program, ['demo', '--no-browser', '--port', '0'], { stdio: ['ignore', 'pipe', 'inherit'] });
  let browser = null;
  let served = null;
  try {
    const hub = demo ? await address(demo) : process.env.LAFET_URL;
    if (process.env.CONSOLE_DIST) served = await distBefore(hub);
    const url = served?.resolvedUrls.local[0].replace(/\/$/, '') ?? hub;
    browser = await chromium.launch({
      executablePath: process.env.CHROMIUM_BIN ?? '/usr/bin/chromium',
      args: ['--no-sandbox', ...drawing, ...more],
    });
    await work(browser, url);
  } finally {
    await browser?.close();
    await served?.close();
    demo?.kill('SIGINT');
  }
}

function distBefore(hub) {
  const api = { target: hub, ws: true, changeOrigin: true, headers: { origin: hub } };
  return preview({ logLevel: 'silent', preview: { port: 0, host: '127.0.0.1', proxy: { '/api': api } } });
}

/** The address that the demo prints first. */
function address(demo) {
  return new Promise((resolve, reject) => {
    let text = '';
    demo.stdout.on('data', (chunk) => {
      text += chunk;
      const url = /http:\/\/127\.0\.0\.1:\d+/.exec(text);
      if (url) resolve(url[0]);
    });
    demo.on('exit', () => reject(new Error(`the demo has ended: ${text}`)));
  });
}
