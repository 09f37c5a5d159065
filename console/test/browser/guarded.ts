import { type ChildProcess, spawn } from 'node:child_process';
import { mkdtempSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import type { Page } from 'playwright-core';
import { shown } from './page';
import { consoleOf, type Served } from './served';
import { LAFET } from './site';

const NAME = 'Tank farm of the northern terminal, platform of the first pump house';

/** A hub that requires a login, with monitors that do not answer. */
export class Guarded {
  readonly password = 'first password';
  /** A monitor with an id of maximum length. */
  readonly long = 'pump-house-of-the-north-terrace1';
  /** Those of the administrator. */
  private headers: Record<string, string> = {};
  /** The link printed by the first start; already used. */
  link = '';
  private readonly folder = mkdtempSync(join(tmpdir(), 'lafet-guarded-'));
  private child!: ChildProcess;
  private served?: Served;
  url = '';

  static async start(more = ''): Promise<Guarded> {
    const guarded = new Guarded();
    const config = join(guarded.folder, 'hub.toml');
    writeFileSync(
      config,
      `[server]\nlisten = "127.0.0.1:0"\ndata = "${guarded.folder}"\n[[monitor]]\nid = "M1"\nurl = "tcp://127.0.0.1:9?addr=1"\n` +
        `[[monitor]]\nid = "${guarded.long}"\nname = "${NAME}"\nurl = "tcp://127.0.0.1:9?addr=2"\n` +
        more,
    );
    guarded.child = spawn(LAFET, ['serve', '--config', config], { stdio: ['ignore', 'pipe', 'pipe'] });
    const link = await new Promise<string>((resolve, reject) => {
      let told = '';
      const hear = (text: Buffer) => {
        told += text.toString();
        const found = /http:\/\/127\.0\.0\.1:\d+\/setup#\S+/.exec(told)?.[0];
        if (found) resolve(found);
      };
      guarded.child.stdout!.on('data', hear);
      guarded.child.stderr!.on('data', hear);
      guarded.child.on('exit', () => reject(new Error(told)));
    });
    const [url, token] = link.split('/setup#') as [string, string];
    guarded.url = url;
    const { password } = guarded;
    const made = await guarded.post('/api/setup', { token, user: 'root', password });
    const cookie = made.headers.get('set-cookie')!.split(';')[0]!;
    const { csrf } = (await made.json()) as { csrf: string };
    guarded.link = link;
    guarded.headers = { cookie, 'x-csrf-token': csrf };
    await guarded.post('/api/users', { user: 'olga', role: 'observer', password }, guarded.headers);
    guarded.served = await consoleOf(url);
    guarded.url = guarded.served.url;
    return guarded;
  }

  /** As the administrator. */
  asRoot(path: string, body: unknown): Promise<Response> {
    return this.post(path, body, this.headers);
  }

  async stop(): Promise<void> {
    await this.served?.close();
    this.child?.kill('SIGKILL');
    rmSync(this.folder, { recursive: true, force: true });
  }

  async login(user: string, password: string): Promise<number> {
    return (await this.post('/api/login', { user, password })).status;
  }

  /** Ends the sessions of a user, as an administrator does. */
  async throwOut(user: string): Promise<void> {
    const { headers } = this;
    const all = (await (await fetch(`${this.url}/api/sessions`, { headers })).json()) as { id: string; user: string }[];
    for (const { id } of all.filter((session) => session.user === user)) {
      await fetch(`${this.url}/api/sessions/${id}`, { method: 'DELETE', headers });
    }
  }

  /** Opens this hub in a page, and logs in. */
  async enter(page: Page, user: string): Promise<void> {
    const answer = await this.post('/api/login', { user, password: this.password });
    const [name, value] = answer.headers.get('set-cookie')!.split(';')[0]!.split('=') as [string, string];
    await page.context().addCookies([{ name, value, url: this.url, httpOnly: true, sameSite: 'Strict' }]);
    await page.goto(`${this.url}/#/alarms`);
    await shown(page);
  }

  post(path: string, body: unknown, headers: Record<string, string> = {}): Promise<Response> {
    const all = { 'content-type': 'application/json', ...headers };
    return fetch(this.url + path, { method: 'POST', headers: all, body: JSON.stringify(body) });
  }
}
