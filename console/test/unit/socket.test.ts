import { expect, test, vi } from 'vitest';

const sent: { type: string; monitors?: string[] }[] = [];

class Wire {
  static readonly OPEN = 1;
  readonly readyState = 1;
  onmessage: ((event: { data: string }) => void) | null = null;
  onclose = null;
  constructor() {
    wires.push(this);
  }
  send(text: string): void {
    sent.push(JSON.parse(text));
  }
  close(): void {}
}
const wires: Wire[] = [];

test('subscribes to the monitors shown in full, also after a reconnection', async () => {
  const items = new Map<string, string>();
  vi.stubGlobal('sessionStorage', {
    getItem: (key: string) => items.get(key) ?? null,
    setItem: (key: string, value: string) => items.set(key, value),
    removeItem: (key: string) => items.delete(key),
  });
  vi.stubGlobal('location', { origin: 'http://hub' });
  vi.stubGlobal('window', { setInterval: () => 0, setTimeout: () => 0, addEventListener: () => {} });
  vi.stubGlobal('document', { addEventListener: () => {} });
  vi.stubGlobal('WebSocket', Wire);
  vi.stubGlobal('fetch', () => Promise.reject(new TypeError('Failed to fetch')));
  const { socket } = await import('../../src/hub/socket');
  const state = JSON.stringify({ type: 'state', now_ms: 1, set: { 'monitors/M1/info': {}, 'monitors/M2/info': {} } });

  socket.start();
  wires[0]!.onmessage!({ data: state });
  expect(sent).toEqual([]);
  expect(socket.hears('M2')).toBe(true);
  socket.look(['M1']);
  socket.look(['M1']);
  expect(sent).toEqual([{ type: 'subscribe', monitors: ['M1'] }]);
  expect([socket.hears('M1'), socket.hears('M2')]).toEqual([true, false]);

  sent.length = 0;
  socket.interrupt(0);
  (socket as unknown as { open(): void }).open();
  wires[1]!.onmessage!({ data: state });
  expect(sent).toEqual([{ type: 'subscribe', monitors: ['M1'] }]);

  sent.length = 0;
  socket.look(['M9']);
  socket.look(null);
  expect(sent).toEqual([{ type: 'subscribe', monitors: [] }, { type: 'subscribe' }]);
});

test('what moves or opens says when it was sent, by the time of the hub', async () => {
  const { socket } = await import('../../src/hub/socket');
  (socket as unknown as { open(): void }).open();
  const hear = (message: object) => wires.at(-1)!.onmessage!({ data: JSON.stringify(message) });
  sent.length = 0;
  hear({ type: 'state', now_ms: 1, up_ms: 70_000, set: {} });
  for (const type of ['request', 'jog', 'tune', 'stop', 'jog_end']) socket.send({ type });
  const up_ms = expect.closeTo(70_000, -2.5);
  expect(sent).toEqual([
    { type: 'request', up_ms },
    { type: 'jog', up_ms },
    { type: 'tune', up_ms },
    { type: 'stop' },
    { type: 'jog_end' },
  ]);
});

test('a seat that another window has resumed is given up; a page that reads slowly keeps its own', async () => {
  const { socket } = await import('../../src/hub/socket');
  const taken = vi.fn();
  socket.onSeatTaken = taken;
  const last = () => wires.at(-1)! as unknown as { onclose: (event: { code: number; reason: string }) => void };
  const open = () => (socket as unknown as { open(): void }).open();
  sessionStorage.setItem('lafet.resume', 'secret');
  open();
  last().onclose({ code: 4409, reason: 'too slow' });
  expect(sessionStorage.getItem('lafet.resume')).toBe('secret');
  open();
  last().onclose({ code: 4410, reason: 'resumed elsewhere' });
  expect(sessionStorage.getItem('lafet.resume')).toBeNull();
  expect(taken).toHaveBeenCalledTimes(1);
});

test('after a sleep the link is silent by the clock of the day, though the page has not run', async () => {
  const { socket } = await import('../../src/hub/socket');
  const { store } = await import('../../src/hub/store');
  (socket as unknown as { open(): void }).open();
  store.setLinked(true);
  const listen = () => (socket as unknown as { listen(): void }).listen();
  listen();
  expect(store.linked).toBe(true);
  vi.setSystemTime(Date.now() + 60_000);
  listen();
  vi.useRealTimers();
  expect(store.linked).toBe(false);
});

/** A connection that the hub has taken, and that is heard. */
function taken(socket: unknown): { end: (code: number) => void; close: () => void } {
  (socket as { open(): void }).open();
  const wire = wires.at(-1)!;
  const hear = (message: object) => wire.onmessage!({ data: JSON.stringify(message) });
  hear({ type: 'hello', resume: 'secret', now_ms: 1, hub: { version: '1' } });
  hear({ type: 'state', now_ms: 1, set: {} });
  return { end: (code) => closed(wire, code), close: vi.spyOn(wire, 'close') };
}

function closed(wire: unknown, code: number): void {
  (wire as { onclose: (event: { code: number }) => void }).onclose({ code });
}

test('a connection that is refused: the session is queried, one query at a time, and a login follows', async () => {
  const { socket } = await import('../../src/hub/socket');
  const { http } = await import('../../src/hub/http');
  const [queries, logins] = [vi.fn(), vi.fn()];
  http.onLoginNeeded = logins;
  const refused = () => {
    (socket as unknown as { open(): void }).open();
    closed(wires.at(-1), 1006);
  };
  let answer = (_: Response) => {};
  vi.stubGlobal('fetch', (path: string) => {
    queries(path);
    return new Promise((resolve) => {
      answer = resolve;
    });
  });
  refused();
  refused();
  expect(queries.mock.calls).toEqual([['/api/session']]);
  const error = { code: 'login_needed', en: '', ru: '' };
  answer(new Response(JSON.stringify({ error }), { status: 401, headers: { 'content-type': 'application/json' } }));
  await vi.waitFor(() => expect(logins).toHaveBeenCalledTimes(1));
  await vi.waitFor(() => {
    refused();
    expect(queries).toHaveBeenCalledTimes(2);
  });
  answer(new Response(null, { status: 204 }));
  await new Promise((done) => setTimeout(done, 10));
  taken(socket).end(1006);
  expect(queries, 'not for one that the hub had taken').toHaveBeenCalledTimes(2);
});

test('where a login is asked for, the connection that is heard remains for STOP', async () => {
  const { socket } = await import('../../src/hub/socket');
  const kept = taken(socket);
  socket.rest();
  expect([socket.alive, vi.mocked(kept.close).mock.calls.length]).toEqual([true, 0]);
  sent.length = 0;
  const asked = socket.ask({ type: 'stop' }).catch(({ code }) => code);
  expect(sent).toEqual([{ type: 'stop', id: expect.any(Number) }]);

  const before = wires.length;
  socket.start();
  expect(kept.close, 'another session has another connection').toHaveBeenCalledTimes(1);
  expect(wires).toHaveLength(before + 1);
  expect(await asked).toBe('outcome_unknown');

  const last = taken(socket);
  vi.setSystemTime(Date.now() + 60_000);
  socket.rest();
  vi.useRealTimers();
  expect(last.close, 'one that is silent does not').toHaveBeenCalledTimes(1);

  socket.start();
  const left = taken(socket);
  socket.stop();
  expect(left.close, 'nor after a logout').toHaveBeenCalledTimes(1);
});

test('without a session nothing that is held is sent, but its end and STOP are', async () => {
  const { socket } = await import('../../src/hub/socket');
  socket.start();
  taken(socket);
  socket.rest();
  expect(socket.alive).toBe(true);
  sent.length = 0;
  expect(['jog', 'tune', 'jog_end', 'tune_beat'].map((type) => socket.send({ type }))).toEqual([
    false,
    false,
    true,
    true,
  ]);
  socket.ask({ type: 'stop' }).catch(() => {});
  expect(sent.map(({ type }) => type)).toEqual(['jog_end', 'tune_beat', 'stop']);
  socket.start();
  taken(socket);
  expect(socket.send({ type: 'jog' })).toBe(true);
});
