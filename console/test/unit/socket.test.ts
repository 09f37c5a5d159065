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
  vi.stubGlobal('WebSocket', Wire);
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
