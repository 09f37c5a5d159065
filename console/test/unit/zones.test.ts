// Zones: whose turn it is, what is left of a time, and that every state of the hub has words in both languages.
import { afterEach, beforeAll, beforeEach, describe, expect, test, vi } from 'vitest';
import type {
  Act,
  DetectorUnable,
  ZoneDisablement,
  ZoneNotReleased,
  ZoneState,
  ZonesView,
  ZoneWithheld,
} from '../../src/hub/api';
import { store } from '../../src/hub/store';
import type { AuditEntry } from '../../src/hub/types';
import { goesOn, leftOf, OLD_MS, phaseOf, runningOf, whyNotOrder, zones } from '../../src/hub/zones';
import { loadLang, setLang } from '../../src/i18n';
import { concerns } from '../../src/pages/zones/model';
import {
  doingOf,
  leftWords,
  notReady,
  orderedWords,
  phaseWords,
  signalWords,
  unableWords,
  waitsFor,
  withheldWords,
  withWater,
} from '../../src/shell/zone-words';

const HALL: ZoneState = {
  zone: 'hall',
  phase: 'quiet',
  mode: 'automatic',
  switch_manual: false,
  votes: [],
  alarms: [],
  need: 2,
  unable: [],
  ready: true,
  hold_left_ms: 60_000,
  not_released: [],
  monitors: [],
};

function zone(more: Partial<ZoneState>): ZoneState {
  return { ...HALL, ...more };
}

function view(...of: ZoneState[]): ZonesView {
  return {
    reported: {},
    fires: [],
    assigned: [],
    left_out: [],
    wind: null,
    planned_wind: { at_ms: null, from_deg: 0, speed_mps: 0, text: { en: '', ru: '' } },
    stored: true,
    state: {
      at_ms: 0,
      lockout: false,
      tone: 'off',
      zones: of,
      detectors: [],
      monitors: [],
      pumps: [],
      outputs: [],
      troubles: [],
      disablements: [],
    },
  };
}

beforeAll(async () => {
  const kept = new Map<string, string>();
  Object.assign(globalThis, {
    document: { documentElement: { lang: '' } },
    localStorage: {
      getItem: (key: string) => kept.get(key) ?? null,
      setItem: (key: string, value: string) => kept.set(key, value),
    },
  });
  await setLang('en');
  await loadLang();
});

describe('what is left of a time', () => {
  test('of a countdown falls, that of a hold only while it is held, and none below 0', () => {
    const counts = zone({ phase: 'countdown', left_ms: 7000 });
    expect([leftOf(counts, 'release', 0), leftOf(counts, 'release', 2500), leftOf(counts, 'release', 9000)]).toEqual([
      7000, 4500, 0,
    ]);
    expect(leftOf(counts, 'hold', 2500)).toBe(60_000);
    const held = zone({ phase: 'held', left_ms: 7000, hold_left_ms: 5000 });
    expect([leftOf(held, 'release', 2500), leftOf(held, 'hold', 2500)]).toEqual([7000, 2500]);
    expect(leftOf(zone({}), 'release', 0)).toBeNull();
  });

  test('in words: seconds are rounded up, 0 is the end itself', () => {
    expect(['release', 'hold'].map((time) => leftWords(1, time as 'hold'))).toEqual(['1 s', '1 s']);
    expect([leftWords(0, 'release'), leftWords(null, 'release')]).toEqual(['0 s', '—']);
    expect(leftWords(7_200_000, 'mode')).toBe('2 hr');
  });
});

describe('the zones of the store', () => {
  let now = 0;
  beforeEach(() => {
    now = 1_000_000;
    vi.spyOn(performance, 'now').mockImplementation(() => now);
    store.setLinked(true);
  });
  afterEach(() => {
    vi.restoreAllMocks();
    vi.useRealTimers();
    store.endReplay();
    store.replace({ now_ms: 0, set: {} });
  });
  const hear = (of: ZonesView) => store.replace({ now_ms: 5, set: { zones: of } });

  test('a countdown goes on between reports, whatever is done to the clock of the browser', () => {
    hear(view(zone({ phase: 'countdown', left_ms: 9000 })));
    now += 1000;
    vi.useFakeTimers({ toFake: ['Date'], now: Date.now() + 3_600_000 });
    expect(zones.left('hall', 'release')).toBe(8000);
  });

  test('nothing is known without a link, and of a running time without reports', () => {
    hear(view(zone({ phase: 'countdown', left_ms: 9000 })));
    now += OLD_MS;
    expect(zones.unknownFor()).toBeNull();
    now += 1;
    expect([zones.unknownFor(), zones.left('hall', 'release')]).toEqual([OLD_MS + 1, null]);
    hear(view(zone({})));
    now += 3_600_000;
    expect(zones.unknownFor(), 'a quiet zone is not reported again').toBeNull();
    store.setLinked(false);
    now += 12_000;
    expect(zones.unknownFor()).toBe(12_000);
    expect(whyNotOrder()).toBe('No connection to the hub');
  });

  test('a recording does not hide them', () => {
    hear(view(zone({ phase: 'countdown', left_ms: 9000 })));
    store.beginReplay();
    expect(zones.zone('hall')?.phase).toBe('countdown');
    store.apply({ now_ms: 6, set: { zones: view(zone({ phase: 'countdown', left_ms: 8000 })) } });
    expect([zones.left('hall', 'release'), whyNotOrder()]).toEqual([8000, 'This is a recording']);
  });

  test('the hub starts again without zones, or with one that this page has never seen', () => {
    hear(view(zone({ phase: 'countdown', left_ms: 9000 })));
    store.replace({ now_ms: 9, set: {} });
    expect([zones.exist(), zones.zone('hall'), zones.left('hall', 'release'), zones.eventful()]).toEqual([
      false,
      null,
      null,
      0,
    ]);
    hear(view(zone({ zone: 'новая', phase: 'alarm', votes: ['d'] })));
    expect([zones.eventful(), zones.configured('новая')]).toEqual([1, null]);
  });
});

test('the zone that is first in a strip: the shortest countdown, then a hold, water, a test', () => {
  const wet = { released: { automatic: true, wet: true } };
  const all = view(
    zone({ zone: 'test', phase: { released: { automatic: false, wet: false } } }),
    zone({ zone: 'water', phase: wet }),
    zone({ zone: 'held', phase: 'held', left_ms: 1 }),
    zone({ zone: 'late', phase: 'countdown', left_ms: 9000 }),
    zone({ zone: 'soon', phase: 'coincidence', left_ms: 2000 }),
    zone({ zone: 'one vote', phase: 'alarm' }),
    zone({ zone: 'over', phase: { ended: 'abort' } }),
  );
  expect(runningOf(all).map(({ zone: id }) => id)).toEqual(['soon', 'late', 'held', 'water', 'test']);
  expect(runningOf(null)).toEqual([]);
});

test('a phase that this page does not know is one to look at', () => {
  expect(phaseOf(zone({ phase: 'draining' as 'quiet' }))).toBe('alarm');
});

test('a hold is renewed until another person ends it, or there is nothing to hold', () => {
  expect((['coincidence', 'countdown', 'held'] as const).map((phase) => goesOn(phase, false))).toEqual([
    true,
    true,
    true,
  ]);
  expect([goesOn('held', true), goesOn('countdown', true)]).toEqual([true, false]);
  expect((['quiet', 'alarm', 'released', 'ended', null] as const).map((phase) => goesOn(phase, false))).toEqual([
    false,
    false,
    false,
    false,
    false,
  ]);
});

const WAITS: ZoneNotReleased[] = [
  'lockout',
  'abort_pressed',
  'stop_pressed',
  { ended: 'abort' },
  { mode: 'manual' },
  { votes: { have: 1, need: 2 } },
  'kinds',
  'failed',
  'stale',
  'coincidence',
  'delay',
  'held',
  'no_monitor',
];
const UNABLE: DetectorUnable[] = [
  'never_heard',
  'silent',
  'test_stuck',
  { bypass: 'masked' },
  { bypass: 'disabled' },
  ...(['ready', 'dirty', 'fault', 'masked', 'self_test', 'starting'] as const).map((condition) => ({ condition })),
];
const WITHHELD: ZoneWithheld[] = ['lockout', 'refused', 'person', 'unreachable', 'failure'];
const DISABLED: ZoneDisablement[] = ['lockout'];

describe.each(['en', 'ru'] as const)('words in %s', (lang) => {
  beforeAll(async () => setLang(lang));
  const monitor = { monitor: 'M1', closing: false };

  test('of every state, without a key or a name that is not filled in', () => {
    const phases: ZoneState['phase'][] = [
      'quiet',
      'alarm',
      'coincidence',
      'countdown',
      'held',
      { ended: 'duration' },
      { released: { automatic: true, wet: true } },
      { released: { automatic: true, wet: false } },
    ];
    const said = [
      ...phases.map((phase) => phaseWords(zone({ phase }))),
      phaseWords(zone({ ready: false })),
      phaseWords(zone({ phase: 'alarm', need: null })),
      ...waitsFor(zone({ not_released: WAITS })),
      ...UNABLE.map(unableWords),
      ...WITHHELD.map((withheld) => withheldWords({ ...monitor, withheld })),
      ...(['quiet', 'pre_alarm', 'alarm'] as const).map((signal) =>
        signalWords({ detector: 'd', signal, stale: false }),
      ),
      signalWords({ detector: 'd', stale: false }),
      signalWords({ detector: 'd', signal: 'alarm', stale: true }),
      orderedWords({ ...monitor, closing: true }, HALL),
      orderedWords(monitor, HALL),
      orderedWords({ ...monitor, engaged_for: 'other' }, HALL),
      orderedWords({ ...monitor, engaged_for: 'hall' }, HALL),
      orderedWords({ ...monitor, engaged_for: 'hall' }, zone({ phase: phases[6] })),
    ];
    for (const text of said) expect(text).toMatch(/^[^{}]*$/);
    expect(said.filter((text) => /^(zones|events)\./.test(text) || text === '')).toEqual([]);
    expect(new Set(said).size).toBeGreaterThan(said.length - 4);
  });

  test('of why a quiet zone would release nothing', () => {
    const state = view().state;
    const none = {
      ...state,
      lockout: true,
      disablements: DISABLED,
      monitors: [{ ...monitor, withheld: 'failure' as const }],
    };
    const many = notReady(zone({ ready: false, mode: 'off', need: null, switch_manual: true }), none, ['M1']);
    expect(many).toHaveLength(5);
    expect(notReady(zone({}), none, ['M1']), 'the hub says whether it is ready').toEqual([]);
  });
});

test('what a monitor does comes from what it reports now', async () => {
  await setLang('en');
  const status = (flags: Record<string, string[]>) => ({
    at_ms: 1,
    stale: false,
    error: null,
    subsystems: Object.fromEntries(
      Object.entries(flags).map(([name, of]) => [name, { bits: 0, flags: of, severity: 'info' }]),
    ),
  });
  store.replace({
    now_ms: 0,
    set: {
      'monitors/M1/status': status({ Valve1: ['Open'], Deployer: ['Deployed'] }),
      'monitors/M2/status': status({ Valve1: ['Closed'], Deployer: ['Deploying'] }),
      'monitors/M3/status': status({ Valve1: ['Open'] }),
      'monitors/M3/link': { state: 'down' },
    },
  });
  const does = (id: string) => doingOf(id).map(({ text }) => text);
  expect(does('M1')).toEqual(['WATER', 'Deployed']);
  expect(does('M2')).toEqual(['Deploying…']);
  expect([does('M3'), does('M9')]).toEqual([['does not answer'], ['does not answer']]);
  expect(withWater(['M1', 'M2', 'M9'])).toEqual(['M1']);
});

test('entries of the audit log about a zone, its detectors and its monitors', () => {
  const entry = (act: Act) => ({ n: 1, act: { v: 1, ...act } }) as unknown as AuditEntry;
  const about = (act: Act) => concerns(entry(act), 'hall', ['flame'], ['M1']);
  const zoned = (of: Extract<Act, { type: 'zone' }>['entry']) => about({ type: 'zone', entry: of, cause: [] });
  const ordered = (order: Extract<Act, { type: 'zone_order' }>['order']) =>
    about({ type: 'zone_order', order, cause: [] });
  expect([
    zoned({ released: { zone: 'hall', automatic: true, wet: true, condition_at_ms: 1 } }),
    zoned({ lockout: { on: true } }),
    zoned({ bypass: { detector: 'flame', bypass: 'masked' } }),
    zoned({ no: { scope: 'site', why: 'stop' } }),
    zoned({ no: { scope: { monitor: 'M1' }, why: 'close' } }),
    zoned({ refused: { order: { release: { zone: 'hall' } }, why: 'off' } }),
    zoned({ reset: { zone: 'hall' } }),
    ordered({ prepare: { zone: 'hall', monitor: 'M1' } }),
    ordered({ close: { monitor: 'M1' } }),
  ]).not.toContain(false);
  expect([
    zoned({ released: { zone: 'deck', automatic: true, wet: true, condition_at_ms: 1 } }),
    zoned({ reset: { zone: 'deck' } }),
    zoned({ bypass: { detector: 'heat', bypass: 'none' } }),
    ordered({ engage: { zone: 'deck', monitor: 'M1' } }),
    ordered({ stop: { monitor: 'M2' } }),
    zoned({ refused: { order: { release: { zone: 'deck' } }, why: 'off' } }),
    concerns({ n: 1 } as AuditEntry, 'hall', ['flame'], ['M1']),
  ]).not.toContain(true);
});
