// `lafet demo` with the console, for pages that need a simulated site. LAFET_BIN is the program.
import { type ChildProcess, spawn } from 'node:child_process';
import { type Browser, chromium, type Page } from 'playwright-core';
import type { Monitor } from '../../src/hub/types';
import { follow, LATE_MS, shown, until } from './page';
import { consoleOf, type Served } from './served';
import { LAFET } from './site';

const CHROMIUM = process.env.CHROMIUM_BIN ?? '/usr/bin/chromium';
/** For tests of the 3D view; the others are drawn much faster without. */
export const WEBGL = ['--use-gl=angle', '--use-angle=swiftshader', '--enable-unsafe-swiftshader'];
export const PLAIN = ['--disable-gpu'];

export class Demo {
  private child!: ChildProcess;
  private browser!: Browser;
  private served?: Served;
  hub = '';
  url = '';

  static async start(drawing = PLAIN, without: string[] = []): Promise<Demo> {
    const demo = new Demo();
    demo.child = spawn(LAFET, ['demo', '--no-browser', '--port', '0'], { stdio: ['ignore', 'pipe', 'ignore'] });
    demo.hub = await new Promise<string>((resolve, reject) => {
      let told = '';
      demo.child.stdout!.on('data', (text: Buffer) => {
        told += text.toString();
        const url = /http:\/\/127\.0\.0\.1:\d+/.exec(told)?.[0];
        if (url) resolve(url);
      });
      demo.child.on('exit', (code) => reject(new Error(`lafet demo ended with ${code}: ${told}`)));
    });
    await until(() => demo.known(), LATE_MS);
    demo.served = await consoleOf(demo.hub);
    demo.url = demo.served.url;
    demo.browser = await chromium.launch({
      executablePath: CHROMIUM,
      args: ['--no-sandbox', ...drawing],
      ignoreDefaultArgs: without,
    });
    return demo;
  }

  /** Whether the hub has the state of every monitor. */
  private async known(): Promise<boolean> {
    const all = Object.values(await this.get<Record<string, Monitor>>('/api/monitors'));
    return all.length > 0 && all.every(({ status }) => status.at_ms !== null && !status.stale);
  }

  async stop(): Promise<void> {
    await this.browser?.close();
    await this.served?.close();
    this.child?.kill('SIGKILL');
  }

  async open(
    route: string,
    lang = 'en',
    size = { width: 1440, height: 1000 },
    display = 'normal',
    guide = 'done',
  ): Promise<Page> {
    const context = await this.browser.newContext({ viewport: size });
    context.setDefaultTimeout(LATE_MS);
    const wanted = { lang, display, theme: 'day', guide };
    await context.addInitScript((all) => {
      for (const [name, value] of Object.entries(all)) localStorage.setItem(`lafet.${name}`, value);
    }, wanted);
    const page = follow(await context.newPage());
    await page.goto(`${this.url}/${route}`);
    await shown(page);
    return page;
  }

  async get<T>(path: string): Promise<T> {
    const answer = await fetch(this.hub + path);
    if (!answer.ok) throw new Error(`${path}: ${answer.status}`);
    return (await answer.json()) as T;
  }

  async post(path: string, body: unknown = {}): Promise<Response> {
    return fetch(this.hub + path, {
      method: 'POST',
      headers: { 'content-type': 'application/json' },
      body: JSON.stringify(body),
    });
  }

  /** Takes control, which a page that was closed keeps for a moment, and commands. */
  async request(monitor: string, request: string): Promise<void> {
    await until(async () => (await this.post(`/api/monitors/${monitor}/authority`, { action: 'take' })).ok);
    const answer = await this.post(`/api/monitors/${monitor}/requests`, { request });
    if (!answer.ok) throw new Error(`${request}: ${await answer.text()}`);
  }
}
