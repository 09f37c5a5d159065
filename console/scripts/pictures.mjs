// Pictures of the console for the READMEs: a demo is started, a monitor taken, deployed and
// opened, then aimed at the fire with the water on. LAFET_BIN is the program.
import { spawn } from 'node:child_process';
import { chromium } from 'playwright-core';

const FOLDER = new URL('../../docs/images/', import.meta.url).pathname;
const program = process.env.LAFET_BIN;
if (!program) throw new Error('LAFET_BIN must name the lafet program, with the console built in');

const WORDS = {
  en: { take: 'Take control', deploy: /^Deploy/, deployed: 'Deployed', aim: /^Aim/, open: /^Open/, scene: /3D/ },
  ru: { take: /^Взять управление/, deploy: /^Развернуть/, deployed: /Развёрнут/, aim: /^Навести/, open: /^Открыть/, scene: /3D/ },
};

for (const lang of ['en', 'ru']) {
  const demo = spawn(program, ['demo', '--no-browser', '--port', '0'], { stdio: ['ignore', 'pipe', 'inherit'] });
  try {
    await take(await address(demo), lang);
  } finally {
    demo.kill('SIGINT');
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

async function take(url, lang) {
  const words = WORDS[lang];
  const browser = await chromium.launch({
    executablePath: process.env.CHROMIUM ?? '/usr/bin/chromium',
    args: ['--no-sandbox', '--use-gl=angle', '--use-angle=swiftshader', '--enable-unsafe-swiftshader'],
  });
  const page = await browser.newPage({
    viewport: { width: 1440, height: 900 },
    locale: lang === 'ru' ? 'ru-RU' : 'en-GB',
  });
  const picture = (name) => page.screenshot({ path: `${FOLDER}console-${name}.${lang}.png` });
  await page.addInitScript(() => localStorage.setItem('lafet.guide', 'done'));
  await page.goto(`${url}/#/m/M1/operate`);
  await page.getByRole('button', { name: words.take }).first().click();
  await page.getByRole('button', { name: words.deploy }).first().click();
  await page.getByText(words.deployed).first().waitFor({ timeout: 60_000 });
  await hold(page, page.getByRole('button', { name: words.open }).first(), 1500);
  await page.waitForTimeout(8_000);
  await page.getByRole('button', { name: words.aim }).first().click();
  await aimAtFire(page);
  await page.waitForTimeout(9_000);
  await picture('operate');
  await page.getByRole('button', { name: words.scene }).first().click();
  await page.waitForTimeout(5_000);
  await picture('scene');
  await page.goto(`${url}/#/overview`);
  await page.waitForTimeout(1_500);
  await picture('overview');
  await browser.close();
}

/** A press on the fire in the plan. */
async function aimAtFire(page) {
  const box = await page.locator('lf-plan .fire-area').first().boundingBox();
  if (!box) throw new Error('there is no fire in the plan');
  await page.mouse.click(box.x + box.width / 2, box.y + box.height / 2);
}

async function hold(page, button, milliseconds) {
  const box = await button.boundingBox();
  if (!box) throw new Error('there is nothing to hold');
  await page.mouse.move(box.x + 20, box.y + box.height / 2);
  await page.mouse.down();
  await page.waitForTimeout(milliseconds);
  await page.mouse.up();
}
