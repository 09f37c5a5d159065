import { readFileSync } from 'node:fs';
import { beforeAll, describe, expect, it } from 'vitest';
import type { Act, SimAct, ZoneEntry, ZoneOrder } from '../../src/hub/api';
import { type Dictionary, dictionary } from '../../src/hub/dictionary';
import type { AuditEntry } from '../../src/hub/types';
import { loadLang, setLang } from '../../src/i18n';
import { kindOf } from '../../src/pages/events/model';
import { endingWords, isOwn, learnSimulation, stateWords, userWords, wordsOf } from '../../src/pages/events/words';

const dict = JSON.parse(readFileSync(new URL('files/dictionary.json', import.meta.url), 'utf8')) as Dictionary;

const named = (name: string) => dict.subsystems.find((one) => one.name === name)!;

type Named<T> = T extends unknown ? keyof T : never;

const sims: Record<Named<SimAct>, SimAct> = {
  automatic: { automatic: true },
  pause: { pause: true },
  speed: { speed: 4 },
  fault: { fault: { monitor: 'M1', fault: 'vertical-jam', on: true } },
  fire: { fire: { at: [-12.04, 5], kind: 'pool', size: 2 } },
  ignite: { ignite: 'T-1' },
  link: { link: { monitor: 'M1', up: false } },
};
const zones: Record<Named<Exclude<ZoneEntry, string>>, ZoneEntry> = {
  started: { started: { dropped: [] } },
  detector: { detector: { detector: 'T-1', signal: 'pre_alarm', condition: 'ready' } },
  enough: { enough: { zone: 'T-1' } },
  countdown: { countdown: { zone: 'T-1', delay_ms: 10_000 } },
  cancelled: { cancelled: { zone: 'T-1', why: 'test_over' } },
  held: { held: { zone: 'T-1', on: true, left_ms: 5000 } },
  released: { released: { zone: 'T-1', automatic: true, wet: true, condition_at_ms: 1 } },
  ended: { ended: { zone: 'T-1', why: 'abort' } },
  no: { no: { scope: { monitor: 'M1' }, why: 'close' } },
  lapsed: { lapsed: { scope: { zone: 'T-1' } } },
  refused: { refused: { order: { release: { zone: 'T-1' } }, why: 'lockout' } },
  station_refused: { station_refused: { input: 'T-1', zone: 'T-1', why: 'off' } },
  mode: { mode: { zone: 'T-1', mode: 'test_outlet', returns_in_ms: null } },
  lockout: { lockout: { on: false } },
  bypass: { bypass: { detector: 'T-1', bypass: 'masked' } },
  reset: { reset: 'site' },
  trouble: { trouble: { trouble: 'no_monitor', subject: 'T-1', active: false } },
  water_found: { water_found: { monitor: 'M1', left_ms: 7000 } },
  replaced: { replaced: { zone: 'T-1', monitor: 'M1' } },
  unknown: { unknown: { name: 'T-1' } },
};
const orders: Record<Named<ZoneOrder>, ZoneOrder> = {
  prepare: { prepare: { monitor: 'M1', zone: 'T-1' } },
  engage: { engage: { monitor: 'M1', zone: 'T-1', water_max_ms: null } },
  close: { close: { monitor: 'M1' } },
  stop: { stop: { monitor: 'M1' } },
  pump: { pump: { pump: 'T-1', on: true } },
  valve: { valve: { output: 'T-1', open: true } },
  sound: { sound: { output: 'T-1', tone: 'alarm' } },
  lamp: { lamp: { output: 'T-1', lit: false } },
};
/** One of each kind: the type comes from the hub's description, so none can be forgotten. */
const acts: Record<Act['type'], Act> = {
  request: { type: 'request', request: 'Move', to: 'Vertical' },
  jog: { type: 'jog', drive: 'Vertical', toward: 'max', end: { how: 'stopped', position: 600, reason: 'released' } },
  authority: { type: 'authority', action: 'force', reason: 'fire' },
  login: { type: 'login' },
  logout: { type: 'logout' },
  set_up: { type: 'set_up', user: 'anna' },
  change_own_password: { type: 'change_own_password' },
  add_user: { type: 'add_user', user: 'boris', role: 'operator' },
  change_user: { type: 'change_user', user: 'boris', role: 'engineer', password: true },
  remove_user: { type: 'remove_user', user: 'boris' },
  add_token: { type: 'add_token', name: 'scada', role: 'observer' },
  remove_token: { type: 'remove_token', id: 3 },
  end_session: { type: 'end_session', session: 's7' },
  acknowledge: { type: 'acknowledge', alarm: 'M1/General/BadPower' },
  shelve: { type: 'shelve', alarm: 'M1/General/BadPower', minutes: 5, reason: 'ice' },
  unshelve: { type: 'unshelve', alarm: 'M1/General/BadPower' },
  export_audit: { type: 'export_audit' },
  start_recording: { type: 'start_recording', recording: 'r.mcap' },
  remove_recording: { type: 'remove_recording', recording: 'r.mcap' },
  upload_recording: { type: 'upload_recording', recording: 'r.mcap' },
  store_image: { type: 'store_image', digest: '00ff', version: '1', board: '1' },
  remove_image: { type: 'remove_image', digest: '00ff', version: '1', board: '1' },
  start_update: { type: 'start_update', version: '1', images: ['00ff'], monitors: ['M1'] },
  stop_update: { type: 'stop_update' },
  update_monitor: { type: 'update_monitor', version: '2', from: '1', to: '2' },
  end_update: { type: 'end_update', done: 1, monitors: 3 },
  sim_scenario: { type: 'sim_scenario', scenario: 'hangar' },
  sim: { type: 'sim', act: sims.fire },
  zone: { type: 'zone', entry: zones.released, cause: [] },
  zone_order: { type: 'zone_order', order: orders.engage, cause: [] },
  end: { type: 'end' },
  entries_lost: { type: 'entries_lost', entries: 7, from_ms: 1, to_ms: 2 },
  clock_step: { type: 'clock_step', by_ms: -3500 },
  state_lost: { type: 'state_lost', file: 'audit', fault: 'older', noted: 7, found: 3 },
  chain_broken: { type: 'chain_broken', n: 1201 },
};
const TEXT = '¤ the text of the entry ¤';

function entry(act: Act | undefined, what = TEXT, v = 1): AuditEntry {
  return { what, outcome: 'Ok', details: {}, ...(act ? { act: { ...act, v } } : {}) } as AuditEntry;
}

beforeAll(async () => {
  Object.assign(globalThis, {
    fetch: () => Promise.resolve(Response.json(dict)),
    document: { documentElement: { lang: '' } },
    localStorage: { getItem: () => null, setItem: () => {} },
  });
  await dictionary();
  const [scenario, fault] = [
    { en: 'Hangar', ru: 'Ангар' },
    { en: 'Jammed', ru: 'Заклинило' },
  ];
  learnSimulation({
    scenarios: [{ id: 'hangar', title: scenario, about: scenario, duration_s: 1, monitors: [] }],
    faults: [{ name: 'vertical-jam', group: 'vertical', group_text: fault, text: fault }],
  });
});

describe.each(['en', 'ru'] as const)('in %s', (lang) => {
  beforeAll(async () => {
    await setLang(lang);
    await loadLang();
  });

  it.each(Object.entries(acts))('%s is said in words', (type, act) => {
    const words = wordsOf(entry(act, type === 'request' ? 'Move Vertical 1200' : TEXT));
    expect(words).not.toMatch(/¤|[{}]|events\.|request\.|undefined|NaN|_/);
    expect(words.length).toBeGreaterThan(3);
    if (lang === 'ru') expect(words.replace(/M1|r\.mcap|scada|boris|anna|T-1/g, '')).not.toMatch(/[a-z]{2}/i);
    expect(kindOf(entry(act))).not.toBeNull();
  });

  it('a step of the clock is as long as a person says', () => {
    const of = (by_ms: number) => wordsOf(entry({ type: 'clock_step', by_ms }));
    const [days, back] =
      lang === 'en'
        ? ['The clock was set forward by 30 days', 'The clock was set back by 3.5 s']
        : ['Часы переведены вперёд на 30 дн.', 'Часы переведены назад на 3,5 с'];
    expect([of(2_592_000_000), of(-3500)]).toEqual([days, back]);
  });

  it.each(Object.entries(sims))('the simulation: %s', (_, act) => {
    const words = wordsOf(entry({ type: 'sim', act }));
    expect(words).not.toMatch(/¤|[{}]|events\.|undefined|NaN|_/);
    if (lang === 'ru') expect(words.replace(/M1|T-1/g, '')).not.toMatch(/[a-z]{2}/i);
  });

  it.each([...Object.values(zones), 'silenced' as const])('the zones: %j', (zone) => {
    const words = wordsOf(entry({ type: 'zone', entry: zone, cause: [] }));
    expect(words).not.toMatch(/¤|[{}]|events\.|undefined|NaN|_/);
    if (lang === 'ru') expect(words.replace(/M1|T-1/g, '')).not.toMatch(/[a-z]{2}/i);
  });

  it.each(Object.values(orders))('an order of the zones: %j', (order) => {
    const words = wordsOf(entry({ type: 'zone_order', order, cause: [] }));
    expect(words).not.toMatch(/¤|[{}]|events\.|undefined|NaN|_/);
    if (lang === 'ru') expect(words.replace(/M1|T-1/g, '')).not.toMatch(/[a-z]{2}/i);
  });

  it.each([
    ['Lockout All on', 'LOCKOUT', 'АВАРИЙНАЯ БЛОКИРОВКА'],
    [
      'Move Nozzle 30',
      `Move: ${named('Nozzle').en}, to 30\u202fmm`,
      `Перемещение: ${named('Nozzle').ru}, до 30\u202fмм`,
    ],
    ['Open Valve1', `Open: ${named('Valve1').en}`, ''],
    ['Deploy Deployer', 'Deploy', 'Развернуть'],
    ['StartSeek Detector -1800 1800 -300 900', 'Search for fire: traverse −30.0° … 30.0°, elevation −5.0° … 15.0°', ''],
    [
      'StartQuench Control program=3 centre=1200,300 nozzle=60',
      'Extinguish: centre 20.0°; 5.0°, program 3, nozzle 60\u202fmm',
      '',
    ],
    ['StartTrajectory Control repeat stored=0,3', 'Extinguish along trajectories: stored 0; 3', ''],
    ['SetParam Vertical Speed 9', `Set parameter: ${named('Vertical').en}, Speed = 9 °/s`, ''],
    ['0x12 0x34 de ad', '0x12 0x34 de ad', '0x12 0x34 de ad'],
  ])('the request %s', (text, en, ru) => {
    const words = wordsOf(entry({ type: 'request', request: '', to: '' }, text));
    const wanted = lang === 'en' ? en : ru;
    if (wanted) expect(words).toBe(wanted);
    else expect(words).not.toBe(text);
  });
});

it('an entry of another version of the hub is its text', () => {
  expect(wordsOf(entry(undefined))).toBe(TEXT);
  expect(wordsOf(entry(acts.login, TEXT, 2))).toBe(TEXT);
  expect(kindOf(entry(undefined))).toBeNull();
});

it('says what became of the software of a monitor, and why', async () => {
  const text = { en: 'It is not stowed.', ru: 'Не свёрнут: сверните.' };
  const wanted = {
    en: [
      'Software updated: 1.0 → 1.2',
      'Software 1.2 confirmed',
      'Has software 1.2 already',
      'Not updated to 1.2. It is not stowed.',
    ],
    ru: [
      'ПО обновлено: 1.0 → 1.2',
      'ПО 1.2 подтверждено',
      'ПО 1.2 уже есть',
      'Не обновлено до 1.2. Не свёрнут: сверните.',
    ],
  } as const;
  for (const lang of ['ru', 'en'] as const) {
    await setLang(lang);
    await loadLang();
    const said = (more: object) => wordsOf(entry({ type: 'update_monitor', version: '1.2', ...more }));
    const all = [{ from: '1.0', to: '1.2' }, { to: '1.2' }, { from: '1.2', to: '1.2' }, { text }].map(said);
    expect(all).toEqual(wanted[lang]);
  }
});

it('says how a motion ended, and of a bad value that it is', async () => {
  const text = { en: 'No answer.', ru: 'Нет ответа.' };
  for (const lang of ['ru', 'en'] as const) {
    await setLang(lang);
    await loadLang();
    for (const how of ['refused', 'unknown'] as const) {
      const said = (end: object) => endingWords(entry({ ...acts.jog, end } as typeof acts.jog));
      expect(said({ how, error: text.en, text })).toBe(text[lang]);
      expect(said({ how, error: text.en })).toBe('');
    }
  }
  expect(endingWords(entry(acts.jog))).toBe('released, 10.0°');
  const state = {
    bits: 0,
    flags: [],
    severity: 'alarm' as const,
    pressure: 0,
    bad: { pressure: 'PressureSensorBreak' },
  };
  expect(stateWords('General', state)).toMatch(/^0\.00\u202fMPa \(not valid: .*pressure/i);
});

describe('who', () => {
  it('is named as people say it, in the filter as in the table', async () => {
    const wanted = { en: ['Hub', 'Zones'], ru: ['Сервер объекта', 'Зоны'] } as const;
    for (const lang of ['en', 'ru'] as const) {
      await setLang(lang);
      expect(['hub', 'zones'].map(userWords)).toEqual(wanted[lang]);
    }
    expect([userWords('anna'), isOwn('anna'), isOwn('toString')]).toEqual(['anna', false, false]);
  });
});
