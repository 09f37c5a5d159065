// Does to the pages what nobody would think of: presses, pulls, types and scrolls where something is, hundreds of times a minute,
// by a seed. It fails when a page throws, when the browser complains, or when the hub does not understand what the page asks.
// `monkey [SECONDS [SEED]]`: so long for each of the four windows (default 60), beginning with this seed (default 1).
import { PLAIN, withDemo } from './demo.mjs';

const seconds = Number(process.argv[2] ?? 60);
const first = Number(process.argv[3] ?? 1);
const WINDOWS = [
  { width: 1440, height: 900, lang: 'en' },
  { width: 1024, height: 768, lang: 'ru' },
  { width: 390, height: 800, lang: 'en' },
  { width: 2560, height: 1440, lang: 'ru' },
];
const MONITORS = ['M1', 'M2', 'M3'];
const OF_SITE = ['overview', 'alarms', 'events', 'replay', 'updates', 'training', 'admin'];
const OF_MONITOR = ['operate', 'params', 'programs', 'commissioning', 'diagnosis', 'inspector'];
const ROUTES = [...OF_SITE, ...MONITORS.flatMap((monitor) => OF_MONITOR.map((page) => `m/${monitor}/${page}`))];
const KEYS = [
  'Tab',
  'Shift+Tab',
  'Escape',
  'Enter',
  'Space',
  'ArrowLeft',
  'ArrowRight',
  'ArrowUp',
  'ArrowDown',
  '?',
  'Pause',
  'Shift+Escape',
  '+',
  '-',
  '5',
  'a',
  'Delete',
  'Backspace',
  'Home',
  'End',
  'PageDown',
  'PageUp',
];
const TEXTS = ['0', '12.5', '-999999', 'abc', '1e9', 'M1', '45°', '%00', `'"<b>`, '  7 '];
const HELD_MS = 1200;
const SAID_LAST = 6;

if (!(seconds > 0) || !Number.isInteger(first) || first < 1) {
  console.error(
    `monkey ${process.argv.slice(2).join(' ')}: seconds for each window, then the seed, a whole number from 1`,
  );
  process.exit(2);
}

async function play(browser, url, seed, { width, height, lang }) {
  const context = await browser.newContext({ viewport: { width, height } });
  await context.addInitScript((wanted) => {
    localStorage.setItem('lafet.guide', 'done');
    localStorage.setItem('lafet.lang', wanted);
  }, lang);
  const page = await context.newPage();
  const hand = new Hand(page, seed, { width, height });
  const found = listen(page, hand.done);
  await page.goto(`${url}/#/overview`);
  await page.locator('lf-topbar').waitFor();
  const end = performance.now() + seconds * 1000;
  while (performance.now() < end) await hand.act();
  const alive = await page.evaluate(() =>
    Boolean(document.querySelector('lf-app')?.shadowRoot?.querySelector('main > *')),
  );
  if (!alive) found.set('the page shows nothing any more', 1);
  console.log(
    `seed ${seed}, ${width} × ${height}, ${lang}: ${hand.acts} acts, ${found.size ? `${found.size} faults` : 'no fault'}`,
  );
  await context.close();
  return found.size;
}

/** What must not come, each once, with what was done before it. */
function listen(page, done) {
  const found = new Map();
  const note = (text) => {
    const times = (found.get(text) ?? 0) + 1;
    found.set(text, times);
    if (times === 1) console.log(`! ${text}\n  after: ${done.slice(-SAID_LAST).join(' | ')}`);
  };
  page.on('pageerror', (error) => note(error.stack ?? String(error)));
  // A browser tells of each answer that is a refusal; those that matter are told below.
  page.on('console', (said) => said.type() === 'error' && !/status of \d/.test(said.text()) && note(said.text()));
  page.on('response', (answer) => {
    const asked = answer.request();
    if (answer.status() >= 500 || answer.status() === 400)
      note(`${answer.status()} ${asked.method()} ${answer.url()} ${asked.postData() ?? ''}`);
  });
  page.on('dialog', (dialog) => dialog.dismiss());
  page.on('crash', () => note('the page has crashed'));
  return found;
}

class Hand {
  acts = 0;
  done = [];

  constructor(page, seed, size) {
    this.page = page;
    this.size = size;
    this.state = (seed * 2654435761) >>> 0 || 1;
  }

  async act() {
    this.acts += 1;
    const way = this.chance();
    if (way < 0.08) return this.go(this.pick(ROUTES));
    if (way < 0.2) return this.key(this.pick(KEYS));
    if (way < 0.21) return this.again();
    const target = this.pick(await this.targets());
    if (!target) return this.page.waitForTimeout(100);
    const [x, y] = this.within(target);
    this.done.push(target.name);
    const { mouse, keyboard } = this.page;
    if (way < 0.6) return mouse.click(x, y);
    if (way < 0.65) return mouse.dblclick(x, y);
    if (way < 0.7) {
      await mouse.click(x, y);
      return keyboard.type(this.pick(TEXTS));
    }
    await mouse.move(x, y);
    if (way < 0.75) return mouse.wheel(0, (this.chance() - 0.5) * 1500);
    await mouse.down();
    if (way < 0.9) await mouse.move(x + (this.chance() - 0.5) * 300, y + (this.chance() - 0.5) * 300, { steps: 4 });
    await this.page.waitForTimeout(this.chance() < 0.5 ? HELD_MS : 150);
    return mouse.up();
  }

  async go(route) {
    this.done.push(`#/${route}`);
    await this.page.evaluate((to) => (location.hash = `#/${to}`), route);
    await this.page.waitForTimeout(300);
  }

  async key(key) {
    this.done.push(key);
    await this.page.keyboard.press(key, { delay: this.chance() < 0.3 ? HELD_MS / 2 : 20 });
  }

  async again() {
    this.done.push('reload');
    await this.page.reload();
    await this.page.locator('lf-topbar').waitFor();
  }

  /** What can be pressed and is in sight. */
  targets() {
    return this.page.evaluate(() => {
      const PRESSED = 'button, a, input, select, textarea, summary, [role], [tabindex], label, canvas, svg';
      const all = [];
      const walk = (root) => {
        for (const element of root.querySelectorAll('*')) {
          if (element.shadowRoot) walk(element.shadowRoot);
          if (!element.matches(PRESSED)) continue;
          const { x, y, width, height, right, bottom } = element.getBoundingClientRect();
          if (width < 4 || height < 4 || bottom < 0 || right < 0 || y > innerHeight || x > innerWidth) continue;
          const said = (element.getAttribute('aria-label') ?? element.textContent ?? '').trim().slice(0, 24);
          all.push({ x, y, width, height, name: `${element.localName} ${said.replace(/\s+/g, ' ')}` });
        }
      };
      walk(document);
      return all;
    });
  }

  within({ x, y, width, height }) {
    const inside = (value, most) => Math.min(Math.max(value, 1), most - 2);
    return [inside(x + width * this.chance(), this.size.width), inside(y + height * this.chance(), this.size.height)];
  }

  pick(list) {
    return list[Math.floor(this.chance() * list.length)];
  }

  /** 0 … 1, xorshift: the same for the same seed. */
  chance() {
    let { state } = this;
    state ^= state << 13;
    state ^= state >>> 17;
    state ^= state << 5;
    this.state = state >>> 0;
    return this.state / 2 ** 32;
  }
}

let wrong = 0;
await withDemo(async (browser, url) => {
  for (const [n, size] of WINDOWS.entries()) wrong += await play(browser, url, first + n, size);
}, PLAIN);
process.exitCode = wrong ? 1 : 0;
