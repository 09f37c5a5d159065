import { afterEach, beforeEach, expect, test, vi } from 'vitest';
import { HubError, NOT_LINKED } from '../../src/hub/errors';
import { onHalt } from '../../src/hub/halt';
import { http } from '../../src/hub/http';
import { socket } from '../../src/hub/socket';
import { store } from '../../src/hub/store';
import { Appeared } from '../../src/hub/zones';
import { hasMoved } from '../../src/parts/moved';
import { abortZone, holding, lockZones, releaseZone, runPump } from '../../src/shell/zones';

let sent: string[];
let answers: (() => void)[];

beforeEach(() => {
  vi.useFakeTimers();
  vi.stubGlobal('window', globalThis);
  sent = [];
  answers = [];
  vi.spyOn(http, 'post').mockImplementation((path: string, body?: unknown) => {
    sent.push(
      `${path.split('/').at(-1)!.replace(/\?.*/, '')} ${(body as { on?: boolean } | undefined)?.on ?? ''}`.trim(),
    );
    return new Promise((done) => answers.push(() => done(undefined as never)));
  });
});
afterEach(() => {
  holding.forget();
  vi.useRealTimers();
  vi.unstubAllGlobals();
  vi.restoreAllMocks();
});

const passes = (ms: number) => vi.advanceTimersByTimeAsync(ms);

test('a double click on Hold does not end the hold, a later click does', async () => {
  void holding.begin('a');
  await passes(200);
  expect(await holding.letGo('a')).toBe(false);
  expect(holding.has('a')).toBe(true);
  answers.shift()!();
  await passes(900);
  void holding.letGo('a');
  await passes(10);
  expect(holding.has('a')).toBe(false);
  expect(sent).toEqual(['hold true', 'hold false']);
  void holding.begin('a');
  await passes(10);
  expect(holding.has('a'), 'nor does one on its end begin another').toBe(false);
});

test('the orders about the hold of a zone go one after another, and Abort waits for none', async () => {
  void holding.begin('b');
  await passes(1100);
  void holding.letGo('b');
  await passes(100);
  expect(sent).toEqual(['hold true']);
  void abortZone('b');
  expect(sent).toEqual(['hold true', 'abort']);
  answers[0]!();
  await passes(10);
  expect(sent).toEqual(['hold true', 'abort', 'hold false']);
});

test('an order without an answer keeps the next one back for a moment only', async () => {
  void holding.begin('c');
  await passes(1100);
  void holding.letGo('c');
  await passes(3100);
  expect(sent.at(-1)).toBe('hold false');
});

test('Abort is an end of all that is held', () => {
  const heard: string[] = [];
  const end = onHalt(({ kind }) => heard.push(kind));
  void abortZone('d');
  end();
  expect(heard).toEqual(['abort']);
});

test('an Abort into a dead network is given again every 2 s, and at once when the hub is back', async () => {
  vi.mocked(http.post).mockRejectedValue(new HubError(NOT_LINKED));
  const told = abortZone('e');
  await passes(5000);
  const given = () => vi.mocked(http.post).mock.calls.filter(([to]) => to === '/api/zones/e/abort').length;
  expect(given()).toBe(3);
  vi.mocked(http.post).mockResolvedValue(undefined);
  store.setLinked(true);
  expect(await told).toBe(true);
  expect(given()).toBe(4);
  store.setLinked(false);
});

test('rows keep the order in which they appeared', () => {
  const rows = new Appeared();
  expect(rows.inOrder(['late', 'soon'])).toEqual(['late', 'soon']);
  expect(rows.inOrder(['new', 'soon', 'late'])).toEqual(['late', 'soon', 'new']);
  expect(rows.inOrder(['new', 'late'])).toEqual(['late', 'new']);
  expect(rows.inOrder(['soon', 'new', 'late'])).toEqual(['late', 'new', 'soon']);
});

test('something has moved where something else was', () => {
  expect(hasMoved(['a', 'b'], ['a', 'b', 'c'])).toBe(false);
  expect(hasMoved(['a', 'b'], ['a'])).toBe(false);
  expect(hasMoved(['a', 'b'], ['b'])).toBe(true);
  expect(hasMoved(['a', 'b'], ['c', 'a', 'b'])).toBe(true);
});

test('what people were shown as unanswered is refused by the hub, what ends water is not', () => {
  vi.spyOn(socket, 'hubUp').mockReturnValue(1_000_000);
  void holding.begin('z');
  void releaseZone('a');
  void runPump('p', true);
  void abortZone('a');
  void lockZones(true);
  const paths = vi.mocked(http.post).mock.calls.map(([path]) => path);
  expect(paths).toEqual([
    '/api/zones/z/hold?up_ms=1000000',
    '/api/zones/a/release?up_ms=1000000',
    '/api/pumps/p?up_ms=1000000',
    '/api/zones/a/abort',
    '/api/zones/lock',
  ]);
});
