// What the scripts work on: `lafet demo` with the console built in (LAFET_BIN names the program), and Chromium.
import { spawn } from 'node:child_process';
import { chromium } from 'playwright-core';

/** What draws in a browser without a graphics card: WebGL too, in software; or pages alone, as on a PC without a driver. */
export const WEBGL = ['--use-gl=angle', '--use-angle=swiftshader', '--enable-unsafe-swiftshader'];
export const PLAIN = ['--disable-gpu'];

/** Starts a demo and a browser, gives them to `work`, and ends both. With LAFET_URL a demo that runs already is taken. */
export async function withDemo(work, drawing = WEBGL, more = []) {
  const program = process.env.LAFET_BIN;
  if (!program && !process.env.LAFET_URL) throw new Error('LAFET_BIN must name the lafet program, with the console built in');
  const demo = process.env.LAFET_URL
    ? null
    : spawn(program, ['demo', '--no-browser', '--port', '0'], { stdio: ['ignore', 'pipe', 'inherit'] });
  let browser = null;
  try {
    const url = demo ? await address(demo) : process.env.LAFET_URL;
    browser = await chromium.launch({
      executablePath: process.env.CHROMIUM_BIN ?? '/usr/bin/chromium',
      args: ['--no-sandbox', ...drawing, ...more],
    });
    await work(browser, url);
  } finally {
    await browser?.close();
    demo?.kill('SIGINT');
  }
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
