// Pictures of the console for the pages: a demo is started, a monitor taken, deployed and
// opened, then aimed at the fire with the water on. LAFET_BIN is the program.
import { withDemo } from './demo.mjs';

const FOLDER = new URL('../../docs/images/', import.meta.url).pathname;

const WORDS = {
  en: {
    take: 'Take control',
    taken: 'You control M1',
    deploy: /^Deploy/,
    deployed: 'Deployed',
    aim: /^Aim/,
    open: /^Open/,
    scene: /3D/,
  },
  ru: {
    take: /^Взять управление/,
    taken: 'Стволом M1 управляете вы',
    deploy: /^Развернуть/,
    deployed: /В рабочем положении/,
    aim: /^Навести/,
    open: /^Открыть/,
    scene: /3D/,
  },
};

for (const lang of ['en', 'ru']) await withDemo((browser, url) => take(browser, url, lang));

async function take(browser, url, lang) {
  const words = WORDS[lang];
  const page = await browser.newPage({
    viewport: { width: 1440, height: 900 },
    locale: lang === 'ru' ? 'ru-RU' : 'en-GB',
  });
  const picture = (name) => page.screenshot({ path: `${FOLDER}console-${name}.${lang}.png` });
  await page.addInitScript(() => localStorage.setItem('lafet.guide', 'done'));
  await page.goto(`${url}/#/m/M1/operate`);
  await page.getByRole('button', { name: words.take }).first().click();
  await page.getByText(words.taken).first().waitFor();
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
