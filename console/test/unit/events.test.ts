import { describe, expect, it } from 'vitest';
import type { AuditEntry } from '../../src/hub/types';
import { fits } from '../../src/pages/events/live';
import { byResult, deedsOf, fateOf, fieldTime, joined, matches, plainDetails } from '../../src/pages/events/model';

function entry(
  n: number,
  what: string,
  outcome: string,
  details: Record<string, unknown> = {},
  change = {},
): AuditEntry {
  return {
    n,
    at_ms: n * 1000,
    user: 'anna',
    role: 'operator',
    from: '10.0.0.5',
    via: 'ws',
    seat: 's1',
    monitor: 'M1',
    what,
    outcome,
    details,
    prev: '',
    hash: '',
    ...change,
  };
}

const MOVE = [
  entry(1, 'Move Vertical 1200', 'asked'),
  entry(3, 'Move Vertical 1200', 'Denied', { asked: 1, answers: ['Deployer Move → Denied'], took_ms: 2 }),
  entry(6, 'Move Vertical 1200', 'effect', { answered: 3, state: { Vertical: { bits: 0, flags: [] } } }),
];
const OPENING = { act: { v: 1, type: 'request' as const, request: 'Open', to: 'Valve1' } };
const OPEN = [entry(2, 'Open Valve1', 'asked', {}, OPENING), entry(4, 'Open Valve1', 'Accepted', { asked: 2 })];
const REFUSED = entry(5, 'Restart All', 'not allowed', { code: 'confirm_needed' });
const NO_FILTER = { text: '', kind: '' as const, from_ms: null, to_ms: null };

describe('the audit log', () => {
  it('puts the entries of a command together, also where they are mixed', () => {
    const deeds = deedsOf([...MOVE, ...OPEN, REFUSED].reverse());
    expect(deeds.map((deed) => deed.entries.map((one) => one.n))).toEqual([[5], [2, 4], [1, 3, 6]]);
    const move = deeds[2]!;
    expect([move.answer?.n, move.effect?.n, fateOf(move)]).toEqual([3, 6, 'failed']);
    expect(deeds.map(fateOf)).toEqual(['refused', 'done', 'failed']);
  });

  it('a Stop denied because of a lockout has not failed', () => {
    const stop = { act: { v: 1, type: 'request' as const, request: 'Stop', to: 'All' } };
    const [deed] = deedsOf([
      entry(1, 'Stop All', 'asked', {}, stop),
      entry(2, 'Stop All', 'Denied', { asked: 1 }, stop),
    ]);
    expect(fateOf(deed!)).toBe('done');
  });

  it('a request to all has its monitors by their results', () => {
    const all = { monitor: '*' };
    const answer = entry(
      2,
      'Stop All',
      'outcome_unknown',
      { monitors: { Ok: ['M1', 'M2'], outcome_unknown: ['M3'] } },
      all,
    );
    expect(byResult(answer)).toEqual([
      ['Ok', ['M1', 'M2']],
      ['outcome_unknown', ['M3']],
    ]);
    expect(plainDetails(answer)).toEqual([]);
    const effect = entry(3, 'Stop All', 'effect', { flowing: ['M1', 'M2'], moving: [], silent: [] }, all);
    expect(plainDetails(effect)).toEqual([['flowing', 'M1, M2']]);
  });

  it('keeps an effect whose command is on an earlier page', () => {
    const [deed] = deedsOf([MOVE[2]!]);
    expect(deed?.n).toBe(6);
    expect(fateOf(deed!)).toBe('open');
  });

  it('finds by kind, outcome, time and any text, including details', () => {
    const deeds = deedsOf([...MOVE, ...OPEN, REFUSED]);
    const found = (filter: object) =>
      deeds.filter((deed) => matches(deed, { ...NO_FILTER, ...filter }, 'Moving')).map((deed) => deed.n);
    expect(found({})).toEqual([5, 2, 1]);
    expect(found({ kind: 'bad' })).toEqual([5, 1]);
    expect([found({ kind: 'jog' }), found({ kind: 'command' })]).toEqual([[], [2]]);
    expect(found({ text: 'deployer' })).toEqual([1]);
    expect(found({ text: '#2' })).toEqual([2]);
    expect(found({ from_ms: 1500, to_ms: 2500 })).toEqual([2]);
  });

  it('joins what is new, and notices a gap', () => {
    const known = [OPEN[0]!, MOVE[0]!];
    expect(joined(known, [MOVE[1]!, OPEN[0]!], false)?.map((one) => one.n)).toEqual([3, 2, 1]);
    expect(joined(known, known, false)).toBe(known);
    expect(joined(known, [MOVE[2]!, REFUSED], false)).toBeNull();
    expect(joined([], [OPEN[0]!, MOVE[0]!], false)?.length).toBe(2);
  });

  it('reads times of fields, and shows details that are not shown otherwise', () => {
    expect(fieldTime('')).toBeNull();
    expect(fieldTime('2026-11-21T12:00')).toBe(new Date(2026, 10, 21, 12).getTime());
    expect(plainDetails(entry(1, 'x', 'Ok', { minutes: 5, answers: [], reason: 'ice', code: null }))).toEqual([
      ['minutes', '5'],
      ['reason', 'ice'],
    ]);
  });
});

it('received events are searched as the hub searches', () => {
  const heard = { n: null, at_ms: 1, monitor: 'M1', what: { en: 'Water flows', ru: 'Вода идёт' } };
  expect(fits(heard, { monitor: '', text: '' })).toBe(true);
  expect(fits(heard, { monitor: 'M1', text: ' вода ' })).toBe(true);
  expect(fits(heard, { monitor: 'M2', text: '' })).toBe(false);
  expect(fits(heard, { monitor: '', text: 'foam' })).toBe(false);
});
