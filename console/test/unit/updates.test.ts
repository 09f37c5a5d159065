// Updates: what belongs together, what a run would miss, what is known of a version, and words for every state.
import { readFileSync } from 'node:fs';
import { afterEach, beforeAll, describe, expect, test, vi } from 'vitest';
import { type Dictionary, dictionary } from '../../src/hub/dictionary';
import { http } from '../../src/hub/http';
import { store } from '../../src/hub/store';
import type { MonitorUpdate, StoredImage, UpdateRun } from '../../src/hub/types';
import { placeOf, removeImage, runNow, startUpdate, stopUpdate, underUpdate, updatesNow } from '../../src/hub/updates';
import { type Lang, loadLang, setLang } from '../../src/i18n';
import {
  choicesOf,
  compareVersions,
  type Facts,
  FILE_MAX,
  faultOf,
  groupsOf,
  type Missing,
  missingOf,
  percentOf,
  resultsOf,
  slotsOf,
  versionOf,
  zonesOf,
} from '../../src/pages/updates/model';
import {
  choiceSlots,
  looksOf,
  missingWords,
  resultWords,
  slotWords,
  stageWords,
  stateWords,
  versionsWords,
} from '../../src/pages/updates/words';
import { updatingWords } from '../../src/shell/updates';

const dict = JSON.parse(readFileSync(new URL('files/dictionary.json', import.meta.url), 'utf8')) as Dictionary;

/** All states and stages of the contract: the type checker reports a missing one. */
const STATES = Object.keys({
  waiting: 0,
  checking: 0,
  locking: 0,
  updating: 0,
  unlocking: 0,
  done: 0,
  same: 0,
  failed: 0,
  skipped: 0,
} satisfies Record<MonitorUpdate['state'], number>) as MonitorUpdate['state'][];
const STAGES = Object.keys({
  sending: 0,
  verifying: 0,
  committed: 0,
  restarting: 0,
  'on-trial': 0,
  confirming: 0,
  confirmed: 0,
} satisfies Record<NonNullable<MonitorUpdate['stage']>, number>) as NonNullable<MonitorUpdate['stage']>[];

function image(digest: string, version: string, slot: StoredImage['slot'] = null, board = 'bench'): StoredImage {
  return { digest, version, slot, board, key: 0, size: 4096, by: 'anna', at_ms: 1 };
}

function one(id: string, more: Partial<MonitorUpdate> = {}): MonitorUpdate {
  const nothing = { stage: null, done: null, size: null, left_s: null, from: null, to: null, text: null };
  return { id, state: 'waiting', ...nothing, ...more };
}

function run(state: UpdateRun['state'], ...monitors: MonitorUpdate[]): UpdateRun {
  const ended_ms = state === 'running' ? null : 2;
  return { by: 'anna', began_ms: 1, ended_ms, state, images: ['aa'], version: '1.2.0.0', monitors, text: null };
}

async function speak(to: Lang): Promise<void> {
  await setLang(to);
  await loadLang();
}

beforeAll(async () => {
  const kept = new Map<string, string>();
  Object.assign(globalThis, {
    fetch: () => Promise.resolve(Response.json(dict)),
    document: { documentElement: { lang: '' } },
    localStorage: {
      getItem: (key: string) => kept.get(key) ?? null,
      setItem: (key: string, value: string) => kept.set(key, value),
    },
  });
  await dictionary();
  await speak('en');
});

afterEach(() => {
  vi.restoreAllMocks();
  store.endReplay();
  store.replace({ now_ms: 0, set: {} });
});

describe('a file', () => {
  const file = (text: string, size?: number) => {
    const blob = new Blob([text]);
    if (size !== undefined) Object.defineProperty(blob, 'size', { value: size });
    return blob;
  };

  test('that is no image is not sent', async () => {
    expect(await faultOf(file('LAFETIMG and what follows'))).toBeNull();
    expect(await faultOf(file('LAFETIMX and what follows'))).toBe('foreign');
    expect(await faultOf(file('LAFET'))).toBe('foreign');
    expect(await faultOf(file(''))).toBe('foreign');
    expect(await faultOf(file('LAFETIMG', FILE_MAX))).toBeNull();
    expect(await faultOf(file('LAFETIMG', FILE_MAX + 1))).toBe('large');
  });

  test('that cannot be read is named as such: a folder', async () => {
    const folder = file('LAFETIMG');
    const unreadable = { arrayBuffer: () => Promise.reject(new Error('NotFoundError')) } as Blob;
    vi.spyOn(folder, 'slice').mockReturnValue(unreadable);
    expect(await faultOf(folder)).toBe('unreadable');
  });
});

describe('what can be chosen', () => {
  const keys = (...images: StoredImage[]) => choicesOf(images).map(({ key }) => key);

  test('both slots of one version and board are one choice', () => {
    const pair = choicesOf([image('b', '1.2.0.0', 'b'), image('a', '1.2.0.0', 'a')]);
    expect(pair.map(({ key }) => key)).toEqual(['a b']);
    expect(pair.map(slotsOf)).toEqual(['pair']);
    expect(keys(image('a', '1.2.0.0', 'a'), image('b', '1.3.0.0', 'b')), 'other versions').toEqual(['b', 'a']);
    expect(keys(image('a', '1.2.0.0', 'a', 'x'), image('b', '1.2.0.0', 'b', 'y')), 'other boards').toEqual(['a', 'b']);
    const alone = choicesOf([image('a', '1.2.0.0', 'a'), image('e', '1.2.0.0')]);
    expect(alone.map(slotsOf)).toEqual(['a', 'any']);
  });

  test('two images for one slot are two choices with the other', () => {
    expect(keys(image('a', '1.0.0.0', 'a'), image('b', '1.0.0.0', 'b'), image('c', '1.0.0.0', 'b'))).toEqual([
      'a b',
      'a c',
    ]);
  });

  test('the newest version is first, by numbers', () => {
    expect(keys(image('a', '1.9.0.0'), image('b', '1.10.0.0'), image('c', '1.9.0.1'))).toEqual(['b', 'c', 'a']);
    expect(compareVersions('1.2.0.0', '1.2.0.0')).toBe(0);
    expect(compareVersions('1.2', '1.2.0.1')).toBeLessThan(0);
  });
});

describe('monitors', () => {
  const zones = [
    { zone: 'hall', monitors: ['M2', 'M1'] },
    { zone: 'dock', monitors: ['M2', 'M3'] },
  ];

  test('are grouped by the first zone that they serve, and no one is in two groups', () => {
    expect(groupsOf(['M1', 'M2', 'M3', 'M4'], zones)).toEqual([
      { zone: 'hall', monitors: ['M1', 'M2'] },
      { zone: 'dock', monitors: ['M3'] },
      { zone: null, monitors: ['M4'] },
    ]);
    expect(groupsOf(['M1'], [])).toEqual([{ zone: null, monitors: ['M1'] }]);
    expect(zonesOf('M2', zones)).toEqual(['hall', 'dock']);
  });

  const READY: Facts = { answers: true, locked: false, posture: 'wrapped', moves: false, open: [], holder: null };
  const quiet = zones.map((zone) => ({ ...zone, quiet: true }));
  const missing = (id: string, facts: Record<string, Partial<Facts>> = {}, of = quiet) =>
    missingOf(id, (other) => ({ ...READY, ...facts[other] }), of);

  test('miss nothing when stowed, closed, free, with their zones idle and in service', () => {
    expect(missing('M2')).toEqual([]);
    expect(missing('M2', { M2: { posture: 'none' } }), 'without a deployer').toEqual([]);
    expect(missing('M2', { M2: { locked: true } }), 'the run leaves that lockout').toEqual([]);
  });

  test('miss what the run asks for, each by itself', () => {
    for (const posture of ['deployed', 'deploying', 'wrapping', 'between', 'unknown'] as const) {
      expect(missing('M1', { M1: { posture } }), posture).toEqual([{ what: 'posture' }]);
    }
    expect(missing('M1', { M1: { moves: true } })).toEqual([{ what: 'moves' }]);
    expect(missing('M1', { M1: { open: ['Valve2'] } })).toEqual([{ what: 'valve', valve: 'Valve2' }]);
    expect(missing('M1', { M1: { holder: 'boris' } })).toEqual([{ what: 'held', user: 'boris' }]);
    expect(missing('M1', { M1: { answers: false, posture: 'deployed' } }), 'nothing else is known').toEqual([
      { what: 'silent' },
    ]);
  });

  test('miss every other monitor of every zone that they serve', () => {
    expect(missing('M2', { M1: { locked: true }, M3: { answers: false } })).toEqual([
      { what: 'other', zone: 'hall', monitor: 'M1' },
      { what: 'other', zone: 'dock', monitor: 'M3' },
    ]);
    expect(missing('M1', { M3: { locked: true } }), 'of a zone that it does not serve').toEqual([]);
    const alarm = [{ ...quiet[0]!, quiet: false }, quiet[1]!];
    expect(missing('M2', {}, alarm)).toEqual([{ what: 'zone', zone: 'hall' }]);
    expect(missing('M3', {}, alarm)).toEqual([]);
  });
});

describe('of a run', () => {
  test('the running version is known until the new one may have been started, and after it was confirmed', () => {
    const from = '1.0.0.0';
    const to = '1.2.0.0';
    const known = (more: Partial<MonitorUpdate>) => versionOf(run('ended', one('M1', { from, ...more })), 'M1');
    expect(known({ state: 'checking' })).toBe(from);
    expect(known({ state: 'updating', stage: 'sending' })).toBe(from);
    expect(known({ state: 'failed', stage: 'verifying' })).toBe(from);
    for (const stage of ['committed', 'restarting', 'on-trial', 'confirming'] as const) {
      expect(known({ state: 'failed', stage, to }), stage).toBeNull();
    }
    expect(known({ state: 'unlocking', stage: 'confirmed', to })).toBe(to);
    expect(known({ state: 'done', stage: 'confirmed', to })).toBe(to);
    expect(known({ state: 'same', to: null })).toBe(from);
    expect(versionOf(run('done', one('M1')), 'M2')).toBeNull();
    expect(versionOf(null, 'M1')).toBeNull();
  });

  test('percent are those of the image, between 0 and 100', () => {
    const percent = (more: Partial<MonitorUpdate>) => percentOf(one('M1', { state: 'updating', ...more }));
    expect(percent({ done: 4095, size: 4096 })).toBe(99);
    expect(percent({ done: 4096, size: 4096 })).toBe(100);
    expect(percent({ done: 9000, size: 4096 })).toBe(100);
    expect(percent({ done: 0, size: 0 })).toBeNull();
    expect(percent({ done: null, size: 4096 })).toBeNull();
    expect(percent({ state: 'done', done: 1, size: 2 })).toBeNull();
  });

  test('results are counted, without those that none has', () => {
    const all = [one('M1', { state: 'done' }), one('M2', { state: 'failed' }), one('M3', { state: 'skipped' })];
    expect(resultsOf(run('ended', ...all, one('M4', { state: 'skipped' })))).toEqual([
      ['done', 1],
      ['failed', 1],
      ['skipped', 2],
    ]);
    expect(resultWords(run('ended', ...all))).toBe('1 updated · 1 failed · 1 not updated');
  });

  test('the one that it is at is found, whatever it does there', () => {
    for (const state of STATES) {
      const active = ['checking', 'locking', 'updating', 'unlocking'].includes(state);
      expect(placeOf(run('running', one('M1', { state: 'done' }), one('M2', { state }))), state).toBe(active ? 1 : -1);
    }
  });
});

describe('the strip', () => {
  const hear = (of: UpdateRun | null) => store.replace({ now_ms: 5, set: { updates: { images: [], run: of } } });
  const going = run('running', one('M1', { state: 'done' }), one('M2', { state: 'updating' }), one('M3'));

  test('names the monitor whose software changes, on its own pages with what still works', () => {
    hear(going);
    expect([underUpdate(), updatingWords(null), updatingWords('M1')]).toEqual([
      'M2',
      'Software of M2 is being updated (2 of 3)',
      'Software of M2 is being updated (2 of 3)',
    ]);
    expect(updatingWords('M2')).toBe('Software of M2 is being updated: only STOP, Close and LOCKOUT work');
    hear(run('running', one('M1', { state: 'done' }), one('M2')));
    expect(updatingWords('M2')).toBe('Software of monitors is being updated');
  });

  test('says nothing of a run that has ended, or without a report', () => {
    expect([updatesNow(), updatingWords(null)]).toEqual([null, '']);
    hear(null);
    expect(updatingWords(null)).toBe('');
    hear({ ...going, state: 'ended' });
    expect([runNow(), underUpdate(), updatingWords('M2')]).toEqual([null, null, '']);
  });

  test('is that of now, also while a recording is shown', () => {
    hear(going);
    store.beginReplay();
    expect(updatingWords('M2')).not.toBe('');
  });
});

test('the hub is asked as its contract says', async () => {
  const sent: unknown[] = [];
  const note = (method: string) => (path: string, body?: unknown) => {
    sent.push([method, path, body]);
    return Promise.resolve(undefined as never);
  };
  vi.spyOn(http, 'post').mockImplementation(note('POST'));
  vi.spyOn(http, 'delete').mockImplementation(note('DELETE'));
  const wanted = { images: ['aa'], monitors: ['M1'], pace: null };
  await startUpdate(wanted);
  await stopUpdate();
  await removeImage('aa');
  expect(sent).toEqual([
    ['POST', '/api/updates', wanted],
    ['POST', '/api/updates/stop', undefined],
    ['DELETE', '/api/updates/images/aa', undefined],
  ]);
});

describe.each(['en', 'ru'] as const)('words: %s', (lang) => {
  beforeAll(() => speak(lang));

  test('every state and stage, slot and missing condition has its own', () => {
    const missing: Missing[] = [
      { what: 'silent' },
      { what: 'posture' },
      { what: 'moves' },
      { what: 'valve', valve: 'Valve1' },
      { what: 'held', user: 'М' },
      { what: 'zone', zone: '1' },
      { what: 'other', zone: '1', monitor: 'М2' },
    ];
    const words = [
      ...STATES.map((state) => stateWords(one('M1', { state }))),
      ...STAGES.map((stage) => stageWords(one('M1', { state: 'updating', stage }))),
      ...missing.map(missingWords),
      ...(['a', 'b', null] as const).map((slot) => slotWords({ slot })),
    ];
    for (const text of words) expect(text).not.toMatch(/updates\.|[{}]|^$/);
    expect(new Set(words).size).toBe(words.length);
    if (lang === 'ru') for (const text of words) expect(text).not.toMatch(/[a-z]{2}/i);
    expect(choiceSlots({ key: '', images: [image('a', '1.0.0.0', 'a')] })).toMatch(/A$/);
  });

  test('every state has a sign that is not its colour', () => {
    for (const state of STATES) expect(looksOf(one('M1', { state })).icon).toBeTruthy();
    const later = one('M1', { state: 'thinking' as MonitorUpdate['state'] });
    expect(looksOf(later)).toEqual(looksOf(one('M1', { state: 'checking' })));
  });

  test('percent and time left only while data are sent', () => {
    const sending = one('M1', { state: 'updating', stage: 'sending', done: 1024, size: 4096, left_s: 40 });
    expect(stageWords(sending)).toMatch(
      lang === 'en' ? /^Sending · 25 % · 40 sec left$/ : /^Передача · 25 % · осталось 40.с$/,
    );
    expect(stageWords({ ...sending, left_s: null })).toMatch(/25 %$/);
    expect(stageWords({ ...sending, stage: 'verifying' })).not.toMatch(/\d/);
    expect(stageWords({ ...sending, state: 'failed' })).toBe('');
  });

  test('from and to, as far as they are known', () => {
    const words = (from: string | null, to: string | null) => versionsWords(one('M1', { from, to }));
    expect(words('1.0.0.0', '1.2.0.0')).toBe('1.0.0.0 → 1.2.0.0');
    expect(words('1.0.0.0', null)).toBe('1.0.0.0');
    expect(words(null, '1.2.0.0')).toBe('1.2.0.0');
    expect(words('1.2.0.0', '1.2.0.0')).toBe('1.2.0.0');
    expect(words(null, null)).toBe('');
  });
});
