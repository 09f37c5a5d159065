import { describe, expect, it } from 'vitest';
import type { Alarm } from '../../src/hub/types';
import { countOf, csv, inOrder, matching, newer, partsOf, Seen, stepOf } from '../../src/pages/alarms/model';

function alarm(id: string, change: Partial<Alarm> = {}): Alarm {
  const { monitor, subsystem, flag } = partsOf(id);
  const text = (en: string, ru: string) => ({ en, ru });
  return {
    id,
    monitor,
    subsystem,
    flag,
    priority: 'high',
    state: 'unack',
    active: true,
    since_ms: 1000,
    returned_ms: null,
    count: 1,
    ack: null,
    shelved: null,
    what: text('The drive is overloaded.', 'Перегрузка привода.'),
    cause: text('Ice.', 'Лёд.'),
    consequence: text('It does not move.', 'Он не движется.'),
    remedy: text('Free it.', 'Освободите его.'),
    ...change,
  };
}

const OVERLOAD = alarm('M1/Vertical/AmperageOverload');
const LINK = alarm('M2/Link/Down', { priority: 'medium', state: 'rtn_unack', active: false });
const SHELVED = alarm('M2/Valve1/WdtFault', {
  priority: 'low',
  state: 'shelved',
  shelved: { user: 'anna', until_ms: 9, reason: 'known' },
});
const ALL = [OVERLOAD, LINK, SHELVED];

describe('alarms', () => {
  it('counts what needs action, without shelved ones', () => {
    expect(countOf(ALL)).toEqual({
      urgent: true,
      waiting: 2,
      shelved: 1,
      active: 2,
      by: { fire: 0, high: 1, medium: 1, low: 0 },
    });
    expect(countOf([{ ...OVERLOAD, state: 'ack' }]).waiting).toBe(0);
    // One that cleared by itself waits to be read, and is not urgent.
    expect(countOf([{ ...OVERLOAD, state: 'rtn_unack', active: false }])).toMatchObject({ urgent: false, waiting: 1 });
  });

  it('finds by monitor and by every text of the language that is read', () => {
    const ids = (monitor: string, text: string, lang: 'en' | 'ru') =>
      matching(ALL, { monitor, text }, lang).map((one) => one.id);
    expect(ids('M2', '', 'en')).toEqual([LINK.id, SHELVED.id]);
    expect(ids('', 'ПЕРЕГРУЗКА', 'ru')).toHaveLength(3);
    expect(ids('', 'перегрузка', 'en')).toEqual([]);
    expect(ids('', 'wdtfault', 'en')).toEqual([SHELVED.id]);
    expect(ids('M1', 'free it', 'en')).toEqual([OVERLOAD.id]);
  });

  it('keeps the order under the pointer; new ones wait, cleared ones disappear', () => {
    expect(inOrder(ALL, null)).toEqual({ shown: ALL, fresh: [] });
    const held = [LINK.id, 'M9/General/BadPower'];
    const { shown, fresh } = inOrder([OVERLOAD, LINK], held);
    expect(shown).toEqual([LINK]);
    expect(fresh).toEqual([OVERLOAD]);
  });

  it.each([
    ['normal', 'unack', 'came'],
    ['rtn_unack', 'unack', 'again'],
    ['unack', 'ack', 'acked'],
    ['unack', 'rtn_unack', 'returned'],
    ['ack', 'normal', 'cleared'],
    ['rtn_unack', 'normal', 'acked_cleared'],
    ['ack', 'shelved', 'shelved'],
    ['shelved', 'unack', 'unshelved'],
    ['shelved', 'normal', 'ended'],
  ])('%s → %s is: %s', (from, to, name) => {
    expect(stepOf({ from, to })).toBe(name);
  });

  it('takes ids apart, also those of the hub', () => {
    expect(partsOf('M1/Vertical/Move')).toEqual({ monitor: 'M1', subsystem: 'Vertical', flag: 'Move' });
    expect(partsOf('north/2/Link/Down')).toEqual({ monitor: 'north/2', subsystem: 'Link', flag: 'Down' });
    expect(partsOf('hub/Audit')).toEqual({ monitor: '', subsystem: 'Hub', flag: 'Audit' });
  });

  it('writes tables that a spreadsheet reads, and no formulas', () => {
    expect(
      csv([
        ['a', 'b,c'],
        ['say "x"', -5],
      ]),
    ).toBe('a,"b,c"\r\n"say ""x""",-5\r\n');
    expect(csv([['=1+1', '-cmd', '@x']])).toBe("'=1+1,'-cmd,'@x\r\n");
  });
});

describe('what a user may have seen', () => {
  const has = (seen: Seen, now: number) => ALL.filter((one) => seen.has(one, 500, now)).map(({ id }) => id);

  it('has been in the list for a moment; what is below its end was never seen', () => {
    const seen = new Seen();
    expect(seen.note([OVERLOAD], ALL, 1000)).toBe(true);
    expect(seen.note([OVERLOAD], ALL, 1200)).toBe(false);
    expect([has(seen, 1499), has(seen, 1500)]).toEqual([[], [OVERLOAD.id]]);
    expect(seen.note([OVERLOAD, LINK], ALL, 1600), 'one more is shown').toBe(true);
    expect([has(seen, 1700), has(seen, 2100)]).toEqual([[OVERLOAD.id], [OVERLOAD.id, LINK.id]]);
  });

  it('is another alarm when it comes again', () => {
    const seen = new Seen();
    seen.note([LINK], ALL, 0);
    const again = { ...LINK, state: 'unack', active: true, count: 2 } as const;
    expect([seen.has(LINK, 500, 1000), seen.has(again, 500, 1000)]).toEqual([true, false]);
    seen.note([again], [again], 1000);
    expect([seen.has(again, 500, 1499), seen.has(again, 500, 1500)]).toEqual([false, true]);
    seen.note([], [], 2000);
    expect(seen.has(again, 500, 3000), 'it is gone').toBe(false);
  });
});

it('the history keeps what was read beyond its first page when something new comes', () => {
  const step = (at_ms: number) => ({
    at_ms,
    id: 'M1/Vertical/Move',
    from: 'normal',
    to: 'unack',
    user: null,
    reason: null,
  });
  const known = [step(5), step(4), step(3)];
  expect(newer(known, [step(7), step(6), step(5), step(4)])).toEqual([step(7), step(6), step(5), step(4), step(3)]);
  expect(newer(known, [step(5), step(4)])).toEqual(known);
  // Too much is new for the pages to overlap: the list starts over.
  expect(newer(known, [step(9), step(8)])).toBe(null);
  expect(newer([], [step(1)])).toBe(null);
});
