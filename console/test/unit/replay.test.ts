import { afterEach, beforeEach, describe, expect, it, vi } from 'vitest';
import { difference, type Line, marksOf, PIECE_MS, parseLines, replay, stateAt } from '../../src/hub/replay';
import { store } from '../../src/hub/store';
import { type Check, type Fault, grouped, ordered } from '../../src/pages/training/model';
import { nextMark, span, within } from '../../src/parts/lf-timeline';

const START = 1_763_712_000_000;
const status = (position: number) => ({
  at_ms: START,
  stale: false,
  error: null,
  subsystems: { Horizontal: { bits: 0, flags: [], severity: 'info', position } },
});
const alarm = (active: boolean) => ({ id: 'M1/Link/Down', monitor: 'M1', active });

describe('lines of a recording', () => {
  const lines: Line[] = [
    { at_ms: 100, set: { a: 1, 'alarms/x': alarm(true) } },
    { at_ms: 200, set: { b: 2 } },
    { at_ms: 300, set: { a: 3 }, gone: ['b'] },
    { at_ms: 400, gone: ['alarms/x'] },
    { at_ms: 500, set: { 'alarms/x': alarm(true) } },
    { at_ms: 600, set: { 'alarms/x': { ...alarm(true), state: 'ack' } } },
  ];

  it('give the state of any moment', () => {
    expect([...stateAt(lines, 250)]).toEqual([
      ['a', 1],
      ['alarms/x', alarm(true)],
      ['b', 2],
    ]);
    expect(stateAt(lines, 300).has('b')).toBe(false);
    expect(stateAt(lines, 300).get('a')).toBe(3);
    // Before the first message only its state is known.
    expect(stateAt(lines, 0).get('a')).toBe(1);
  });

  it('list what has to change', () => {
    const change = difference(stateAt(lines, 250), stateAt(lines, 400));
    expect(change).toEqual({ set: { a: 3 }, gone: ['alarms/x', 'b'] });
    expect(difference(stateAt(lines, 250), stateAt(lines, 260))).toEqual({ set: {}, gone: [] });
  });

  it('mark each alarm once, and not those from before', () => {
    expect(marksOf(lines).map(({ at_ms }) => at_ms)).toEqual([500]);
  });

  it('may end in the middle of one', () => {
    expect(parseLines('{"at_ms":1}\n\n{"at_ms":2}\n{"at_')).toEqual([{ at_ms: 1 }, { at_ms: 2 }]);
  });
});

describe('a replay', () => {
  const asked: URL[] = [];
  const HOUR_MS = 3_600_000;

  beforeEach(() => {
    vi.useFakeTimers({ toFake: ['setInterval', 'clearInterval', 'performance'] });
    vi.stubGlobal('window', globalThis);
    vi.stubGlobal('location', { href: 'http://hub.test/' });
    vi.stubGlobal('fetch', (url: URL | string) => {
      const wanted = new URL(String(url), 'http://hub.test/');
      if (wanted.pathname === '/api/audit') return Promise.resolve(new Response('{}', { status: 403 }));
      if (wanted.pathname === '/api/alarms/history') {
        const entry = (seconds: number, to: string) => ({ at_ms: START + seconds * 1000, id: 'M1/Link/Down', to });
        return Promise.resolve(Response.json([entry(20, 'unack'), entry(25, 'ack'), entry(-5, 'unack')]));
      }
      asked.push(wanted);
      const from = Number(wanted.searchParams.get('from_ms'));
      const to = Number(wanted.searchParams.get('to_ms'));
      // A value a second: the seconds since the start.
      const rows = [];
      for (let at = from; at <= to; at += 1000) {
        rows.push(JSON.stringify({ at_ms: at, set: { 'monitors/M1/status': status((at - START) / 1000) } }));
      }
      return Promise.resolve(new Response(rows.join('\n')));
    });
    asked.length = 0;
    store.replace({
      now_ms: START + HOUR_MS,
      set: { 'monitors/M1/status': status(-1), 'monitors/M2/status': status(-2) },
    });
  });

  afterEach(() => {
    replay.close();
    vi.useRealTimers();
    vi.unstubAllGlobals();
  });

  const position = () => store.get('monitors/M1/status')?.subsystems.Horizontal?.position;
  const open = () =>
    replay.open({ title: 'test', path: '/api/history/changes', from_ms: START, to_ms: START + HOUR_MS });

  it('shows nothing that is live, and gives it back', async () => {
    await open();
    expect(store.source).toBe('replay');
    expect(store.monitors()).toEqual(['M1']);
    expect(position()).toBe(0);
    expect(store.getLive('monitors/M2/status')).toBeDefined();
    // Live values continue in the background.
    store.apply({ now_ms: START + HOUR_MS + 1, set: { 'monitors/M1/status': status(-7) } });
    expect(position()).toBe(0);
    replay.close();
    expect(store.source).toBe('live');
    expect(position()).toBe(-7);
    expect(store.monitors()).toEqual(['M1', 'M2']);
  });

  it('plays at its speed', async () => {
    await open();
    vi.advanceTimersByTime(10_000);
    expect(position()).toBe(10);
    expect(store.now()).toBe(START + 10_000);
    replay.setSpeed(5);
    vi.advanceTimersByTime(4_000);
    expect(position()).toBe(30);
    replay.pause();
    vi.advanceTimersByTime(60_000);
    expect(position()).toBe(30);
  });

  it('seeks, backwards too, and fetches only what it needs', async () => {
    await open();
    replay.pause();
    await replay.seek(START + 40 * 60_000);
    expect(position()).toBe(2400);
    await replay.seek(START + 90_000);
    expect(position()).toBe(90);
    const fetched = asked.map((url) => (Number(url.searchParams.get('from_ms')) - START) / PIECE_MS);
    expect(fetched).toEqual([0, 20]);
  });

  it('marks the alarms of the time it shows', async () => {
    await open();
    await vi.waitFor(() => expect(replay.marks).toHaveLength(1));
    expect(replay.marks[0]).toMatchObject({ at_ms: START + 20_000, kind: 'alarm', text: 'M1/Link/Down' });
  });

  it('crosses into the next piece and ends at the end', async () => {
    await open();
    await replay.seek(START + PIECE_MS - 500);
    await vi.advanceTimersByTimeAsync(2_000);
    expect(position()).toBe(PIECE_MS / 1000 + 1);
    await replay.seek(START + HOUR_MS - 1000);
    await vi.advanceTimersByTimeAsync(3_000);
    expect(replay.playing).toBe(false);
    expect(replay.at_ms).toBe(START + HOUR_MS);
  });

  it('begins where there is something', async () => {
    const [first, last] = [START + 9 * 60_000, START + 10 * 60_000];
    vi.stubGlobal('fetch', (url: URL) => {
      const [from, to] = ['from_ms', 'to_ms'].map((name) => Number(url.searchParams?.get(name)));
      const rows =
        from! <= last && to! >= first
          ? [JSON.stringify({ at_ms: Math.max(first, from!), set: { 'monitors/M1/status': status(5) } })]
          : [];
      return Promise.resolve(new Response(rows.join('')));
    });
    await replay.open({ title: '', path: '/api/history/changes', from_ms: START, to_ms: last });
    expect(replay.source?.from_ms).toBe(first);
    expect(replay.at_ms).toBe(first);
    expect(position()).toBe(5);
  });

  it('of which there is nothing is shown as such', async () => {
    vi.stubGlobal('fetch', () => Promise.resolve(new Response('')));
    await open();
    expect(store.source).toBe('replay');
    expect(store.monitors()).toEqual([]);
  });

  it('that the hub refuses leaves the live picture', async () => {
    const refusal = { error: { code: 'not_found', en: 'No such recording.', ru: 'Нет такой записи.' } };
    vi.stubGlobal('fetch', () => Promise.resolve(new Response(JSON.stringify(refusal), { status: 404 })));
    await open();
    expect(store.source).toBe('live');
    expect(replay.phase).toBe('off');
    expect(replay.error?.text('ru')).toBe('Нет такой записи.');
  });
});

describe('timeline', () => {
  it('jumps to the next mark, not to the current one', () => {
    const marks = [{ at_ms: 1000 }, { at_ms: 5000 }, { at_ms: 9000 }];
    expect(nextMark(marks, 5000, 1)).toBe(9000);
    expect(nextMark(marks, 5000, -1)).toBe(1000);
    expect(nextMark(marks, 9000, 1)).toBeNull();
  });

  it('ends at its ends', () => {
    expect([900, 1000, 4000, 9000, 9100].map((at) => within(at, 1000, 9000))).toEqual([1000, 1000, 4000, 9000, 9000]);
  });

  it('formats durations', () => {
    expect([0, 59_600, 187_000, 3_729_000].map(span)).toEqual(['0:00', '1:00', '3:07', '1:02:09']);
  });
});

describe('training', () => {
  const text = (en: string, ru: string) => ({ en, ru });
  const faults: Fault[] = [
    {
      name: 'vertical-jam',
      group: 'v',
      group_text: text('Vertical drive', 'Вертикальный привод'),
      text: text('jammed', 'заклинил'),
    },
    { name: 'low-voltage', group: 's', group_text: text('Supply', 'Питание'), text: text('low', 'низкое') },
    {
      name: 'vertical-slow',
      group: 'v',
      group_text: text('Vertical drive', 'Вертикальный привод'),
      text: text('slow', 'медленно'),
    },
  ];

  it('groups faults and finds them in either language', () => {
    expect(grouped(faults, '', 'en').map(([title, list]) => [title, list.length])).toEqual([
      ['Vertical drive', 2],
      ['Supply', 1],
    ]);
    expect(grouped(faults, 'ВЕРТ закл', 'ru').flatMap(([, list]) => list.map(({ name }) => name))).toEqual([
      'vertical-jam',
    ]);
    expect(grouped(faults, 'nothing', 'en')).toEqual([]);
  });

  it('puts what failed first', () => {
    const check = (state: Check['state'], en: string): Check => ({ text: text(en, en), state, at_s: null, came: null });
    const list = [check('passed', 'a'), check('open', 'b'), check('failed', 'c'), check('open', 'd')];
    expect(ordered(list).map((one) => one.text.en)).toEqual(['c', 'b', 'd', 'a']);
  });
});
