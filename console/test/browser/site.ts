// The set-up of the tests: simulated monitors, a hub, the console in a browser. LAFET_BIN is the path
// of the program.
import { type ChildProcess, execFile, spawn } from 'node:child_process';
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { promisify } from 'node:util';
import { type Browser, chromium, type Page } from 'playwright-core';
import type { Monitor } from '../../src/hub/types';
import { Cable } from './cable';
import { follow, LATE_MS, shown, until } from './page';
import { consoleOf, type Served } from './served';
import { type Names, type Output, Wire } from './wire';

export const LAFET = process.env.LAFET_BIN ?? 'lafet';
const CHROMIUM = process.env.CHROMIUM_BIN ?? '/usr/bin/chromium';
const run = promisify(execFile);

export type Outputs = Record<string, Output>;

/** How far a barrel may turn after its drive was switched off. */
const RUN_OUT_ARCMIN = 60;
/** A barrel farther from its middle is brought back: the next motion would meet a limit. */
const FAR_ARCMIN = 3000;
/** A motion to there takes eight seconds or more from where a test begins: whatever stops it comes before its end. */
const AWAY_ARCMIN = 10_000;

export class Site {
  private readonly children: ChildProcess[] = [];
  private readonly folder = mkdtempSync(join(tmpdir(), 'lafet-console-'));
  private served?: Served;
  private browser!: Browser;
  /** The monitors' own port: a second connection beside the hub's. */
  private monitors: number[] = [];
  private hub = 0;
  private wires: Wire[] = [];
  /** Between the hub and the monitors. */
  links: Cable[] = [];
  /** Between the browser and the hub. */
  way!: Cable;
  url = '';

  /**
   * Two deployed monitors, M1 and M2, with these faults and options of `lafet sim`; `more` is added to the hub's
   * configuration.
   */
  static async start(more = '', faults: string[] = [], options: string[] = []): Promise<Site> {
    const site = new Site();
    for (const address of [1, 2]) {
      const port = await site.program([
        'sim',
        '--listen',
        'tcp://127.0.0.1:0',
        '--addr',
        `${address}`,
        ...faults.flatMap((fault) => ['--fault', fault]),
        ...options,
      ]);
      site.monitors.push(port);
      site.links.push(await Cable.to(port));
    }
    for (const id of ['M1', 'M2']) await site.send(id, 'Deploy');
    const config = join(site.folder, 'hub.toml');
    const ports = site.links.map((link) => link.port);
    writeFileSync(
      config,
      `[server]\nlisten = "127.0.0.1:0"\nlogin = false\ndata = "${site.folder}"\n[authority]\nlost_ms = 500\n` +
        ports
          .map(
            (port, n) =>
              `[[monitor]]\nid = "M${n + 1}"\nurl = "tcp://127.0.0.1:${port}?addr=${n + 1}"\npoll_ms = 100\n`,
          )
          .join('') +
        more,
    );
    site.hub = await site.program(['serve', '--config', config]);
    site.way = await Cable.to(site.hub);
    const names = (await (await fetch(`${site.api}/api/dictionary`)).json()) as Names;
    site.wires = site.monitors.map((port, n) => new Wire(port, n + 1, names));
    site.served = await consoleOf(`http://127.0.0.1:${site.way.port}`);
    site.url = site.served.url;
    site.browser = await chromium.launch({ executablePath: CHROMIUM, args: ['--no-sandbox'] });
    for (const id of ['M1', 'M2']) {
      await until(async () => (await site.outputs(id)).Deployer?.flags.includes('Deployed') === true, 60_000);
      await until(() => site.known(id), 60_000);
    }
    return site;
  }

  /** The hub itself: the way of the browser may be cut. */
  get api(): string {
    return `http://127.0.0.1:${this.hub}`;
  }

  /** Whether the hub has the state of a monitor. */
  private async known(id: string): Promise<boolean> {
    const { link, status } = (await (await fetch(`${this.api}/api/monitors/${id}`)).json()) as Monitor;
    return link.state === 'up' && status.at_ms !== null && !status.stale;
  }

  /** Kills the hub and starts it again with the same address and storage. */
  async restart(): Promise<void> {
    const config = join(this.folder, 'hub.toml');
    const text = readFileSync(config, 'utf8').replace(/^listen = .*$/m, `listen = "127.0.0.1:${this.hub}"`);
    writeFileSync(config, text);
    const old = this.children.pop()!;
    const ended = new Promise((done) => old.once('close', done));
    old.kill('SIGKILL');
    await ended;
    await this.program(['serve', '--config', config]);
  }

  async stop(): Promise<void> {
    await this.browser?.close();
    await this.served?.close();
    this.way?.close();
    for (const wire of this.wires) wire.close();
    for (const link of this.links) link.close();
    for (const child of this.children) child.kill('SIGKILL');
    rmSync(this.folder, { recursive: true, force: true });
  }

  /** A page of a separate user; `close` its context at the end. */
  async open(route: string, lang = 'en', size = { width: 1440, height: 900 }, touch = false): Promise<Page> {
    const context = await this.browser.newContext({ viewport: size, hasTouch: touch });
    context.setDefaultTimeout(LATE_MS);
    await context.addInitScript((wanted) => {
      localStorage.setItem('lafet.lang', wanted);
      localStorage.setItem('lafet.theme', 'day');
      localStorage.setItem('lafet.guide', 'done');
    }, lang);
    const page = follow(await context.newPage());
    await page.goto(`${this.url}/${route}`);
    await shown(page);
    return page;
  }

  /** The monitor's own state, over a connection that is not the hub's. */
  outputs(id: string): Promise<Outputs> {
    return this.wires[Number(id.slice(1)) - 1]!.outputs();
  }

  async send(id: string, request: string): Promise<void> {
    await this.lafet(id, 'send', request);
  }

  /** What a command of the program prints about a monitor. */
  async lafet(id: string, ...words: string[]): Promise<string> {
    return (await run(LAFET, ['-c', this.address(id), ...words])).stdout;
  }

  async position(id: string, drive = 'Horizontal'): Promise<number> {
    return (await this.outputs(id))[drive]?.position ?? NaN;
  }

  /** The limits of a drive, as the hub knows them. */
  async range(id: string, drive: 'Horizontal' | 'Vertical' | 'Nozzle'): Promise<{ min: number; max: number }> {
    const { limits } = (await (await fetch(`${this.api}/api/monitors/${id}`)).json()) as Monitor;
    const range = limits?.[drive];
    if (!range) throw new Error(`no limits of ${drive}`);
    return range;
  }

  async moves(id: string): Promise<boolean> {
    const now = await this.outputs(id);
    return ['Horizontal', 'Vertical', 'Nozzle'].some((drive) => now[drive]?.flags.includes('Move'));
  }

  /** The drives are at rest, and stay so for half a second of the monitor's answers. */
  async stands(id: string, within_ms = 10_000): Promise<boolean> {
    await until(async () => !(await this.moves(id)), within_ms);
    const stopped = await this.position(id);
    let last = stopped;
    for (let n = 0; n < 10; n += 1) {
      await new Promise((done) => setTimeout(done, 50));
      if (await this.moves(id)) return false;
      const now = await this.position(id);
      // A fast drive needs time to stop.
      if (now !== last && (n > 2 || Math.abs(now - stopped) > RUN_OUT_ARCMIN)) return false;
      last = now;
    }
    return true;
  }

  /** Moves it far away without the console, as another client would; returns to where. */
  async sentAway(id = 'M1'): Promise<number> {
    const target = (await this.position(id)) > 0 ? -AWAY_ARCMIN : AWAY_ARCMIN;
    await this.send(id, `Move Horizontal ${target}`);
    await until(() => this.moves(id));
    return target;
  }

  /** After a test: its pages are closed, no client is in control, nothing moves or flows, and no line is cut. */
  async rest(pages: Page[], ids = ['M1']): Promise<void> {
    this.way.mend();
    for (const link of this.links) link.mend();
    for (const page of pages) await page.context().close();
    for (const id of ids) {
      await until(async () => (await this.holder(id)) === null);
      await this.send(id, 'Lockout All off');
      await this.send(id, 'Stop All');
      await this.send(id, 'SwitchLimits Horizontal reject');
      await this.send(id, 'Close Valve1');
      await until(async () => (await this.outputs(id)).Valve1!.flags.includes('Closed'));
      if (Math.abs(await this.position(id)) > FAR_ARCMIN) {
        await this.send(id, 'Move Horizontal 0');
        await until(async () => Math.abs(await this.position(id)) < 60, 60_000);
      }
      await until(async () => !(await this.moves(id)));
    }
  }

  /** The holder of control, as reported by the hub. */
  async holder(id: string): Promise<string | null> {
    const answer = await fetch(`${this.api}/api/monitors/${id}`);
    return ((await answer.json()) as Monitor).authority.holder?.seat ?? null;
  }

  private address(id: string): string {
    const n = Number(id.slice(1));
    return `tcp://127.0.0.1:${this.monitors[n - 1]}?addr=${n}`;
  }

  /** Starts the program and returns the port that it prints. */
  private program(args: string[]): Promise<number> {
    const child = spawn(LAFET, args, { stdio: ['ignore', 'pipe', 'pipe'] });
    this.children.push(child);
    return new Promise((resolve, reject) => {
      let [told, said] = ['', ''];
      const hear = (text: Buffer) => {
        told += text.toString();
        const port = /(?:tcp|http):\/\/127\.0\.0\.1:(\d+)/.exec(told)?.[1];
        if (port) resolve(Number(port));
      };
      child.stdout.on('data', hear);
      // It is read, as a pipe that is full would hold the program up.
      child.stderr.on('data', (text: Buffer) => (said = `${said}${text}`.slice(-4000)));
      child.once('exit', (code) => reject(new Error(`lafet ${args[0]} ended with ${code}: ${told}${said}`)));
    });
  }
}
