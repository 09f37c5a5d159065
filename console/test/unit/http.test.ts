import { afterEach, beforeEach, expect, test, vi } from 'vitest';
import { http } from '../../src/hub/http';

interface Sent {
  path: string;
  method: string;
  csrf: string | undefined;
  keepalive: boolean;
}

let sent: Sent[];
let user: string;
let token: string;

const json = (body: unknown, status = 200) =>
  new Response(JSON.stringify(body), { status, headers: { 'content-type': 'application/json' } });

beforeEach(() => {
  sent = [];
  [user, token] = ['anna', 'one'];
  vi.stubGlobal('fetch', async (path: string, init: RequestInit) => {
    const csrf = (init.headers as Record<string, string>)['x-csrf-token'];
    sent.push({ path, method: init.method!, csrf, keepalive: init.keepalive === true });
    if (path === '/api/session') return json({ user, csrf: token });
    if (csrf !== token) return json({ error: { code: 'csrf', en: '', ru: '' } }, 403);
    return new Response(null, { status: 204 });
  });
});
afterEach(() => {
  vi.useRealTimers();
  vi.unstubAllGlobals();
});

test('a login of the same user in another tab: the new token, and the order once more', async () => {
  await http.session();
  token = 'two';
  sent = [];
  await http.post('/api/zones/a/hold', { on: true });
  expect(sent.map(({ path, csrf }) => [path, csrf])).toEqual([
    ['/api/zones/a/hold', 'one'],
    ['/api/session', undefined],
    ['/api/zones/a/hold', 'two'],
  ]);
  await http.post('/api/zones/a/hold', { on: true });
  expect(sent.at(-1)!.csrf).toBe('two');
});

test('a login of another user: the order is not repeated under the other name', async () => {
  await http.session();
  [user, token] = ['boris', 'two'];
  sent = [];
  const others: string[] = [];
  http.onOtherUser = (name) => others.push(name);
  await expect(http.post('/api/zones/a/hold', { on: true })).rejects.toMatchObject({ code: 'csrf' });
  expect(others).toEqual(['boris']);
  expect(sent.map(({ path }) => path)).toEqual(['/api/zones/a/hold', '/api/session']);
});

test.each(['stop', 'close', 'lockout', 'abort'])('a %s in flight survives the end of the page', async (what) => {
  await http.session();
  await http.post(`/api/monitors/M1/${what}`).catch(() => {});
  expect(sent.at(-1)!.keepalive).toBe(true);
});

test('a query into a dead network ends, and an order that ends something; another order does not', async () => {
  vi.useFakeTimers();
  vi.stubGlobal('fetch', (_: string, { signal }: RequestInit) => {
    return new Promise((_, reject) => signal?.addEventListener('abort', () => reject(signal.reason)));
  });
  const ended: string[] = [];
  void http.get('/api/hub').catch(({ code }) => ended.push(`get ${code}`));
  void http.post('/api/zones/a/abort').catch(({ code, details }) => ended.push(`abort ${code} ${details.cut}`));
  void http.post('/api/zones/a/release').catch(({ code }) => ended.push(`release ${code}`));
  await vi.advanceTimersByTimeAsync(5900);
  expect(ended).toEqual([]);
  await vi.advanceTimersByTimeAsync(200);
  expect(ended, 'it may have been carried out').toEqual(['abort outcome_unknown true']);
  await vi.advanceTimersByTimeAsync(3800);
  expect(ended).toHaveLength(1);
  await vi.advanceTimersByTimeAsync(200);
  expect(ended.slice(1)).toEqual(['get not_linked']);
  await vi.advanceTimersByTimeAsync(600_000);
  expect(ended).toHaveLength(2);
});
