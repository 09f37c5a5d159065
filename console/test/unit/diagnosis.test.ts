import { readFileSync } from 'node:fs';
import { describe, expect, it } from 'vitest';
import type { Dictionary } from '../../src/hub/dictionary';
import type { LinkFigures, Readiness, Status } from '../../src/hub/types';
import { flagsOf, matchingFlags, setFlags, tries, wordHex } from '../../src/pages/diagnosis/model';
import { fromHistory, sampleOf, spanOf } from '../../src/pages/diagnosis/samples';
import { niceTop, pathOf } from '../../src/parts/lf-trend';

const file = (name: string) => JSON.parse(readFileSync(new URL(`files/${name}`, import.meta.url), 'utf8'));
const dict = file('dictionary.json') as Dictionary;

function status(flags: Record<string, string[]>): Status {
  const subsystems = Object.fromEntries(
    Object.entries(flags).map(([name, set]) => [name, { bits: 0, flags: set, severity: 'info' as const }]),
  );
  return { at_ms: 1, stale: false, error: null, subsystems };
}

const COUNTS = { sent: 100, received: 100, errors: 0, retries: 0, timeouts: 0, loss_permille: 0 };
const LINE = { sent: 100, received: 100, errors: 0, foreign: 0, collisions: 0 };
const LINK: LinkFigures = {
  endpoint: 'tcp://h?addr=1',
  state: 'up',
  since_ms: 0,
  error: null,
  poll_ms: 200,
  late: 0,
  strays: 0,
  collisions: 0,
  reconnects: 0,
  rtt_ms: 5,
  srtt_ms: 4,
  ...COUNTS,
  last: COUNTS,
  line: LINE,
  line_last: LINE,
};
const READY: Readiness = { ready: true, reasons: [] };

describe('flags', () => {
  const seen = flagsOf(
    status({
      Vertical: ['Move', 'PosEncoderFault', 'AmperageOverload'],
      Buttons: ['LeftButtonState=Pressed', 'UpButtonState=Short'],
    }),
    dict,
  );

  it('are those of the subsystems that the monitor has', () => {
    expect(new Set(seen.map((flag) => flag.subsystem))).toEqual(new Set(['Vertical', 'Buttons']));
    expect(seen.filter((flag) => flag.subsystem === 'Vertical')).toHaveLength(dict.flags.DriveFlags!.length);
  });

  it('that are set are sorted by severity; a pressed button is no fault', () => {
    expect(setFlags(seen).map((flag) => [flag.name, flag.severity])).toEqual([
      ['PosEncoderFault', 'alarm'],
      ['AmperageOverload', 'warning'],
      ['UpButtonState=Short', 'warning'],
      ['Move', 'info'],
      ['LeftButtonState=Pressed', 'info'],
    ]);
  });

  it('of a monitor that never answered are listed, and none is set', () => {
    const all = flagsOf({ at_ms: null, stale: false, error: null, subsystems: {} }, dict);
    expect(all.length).toBeGreaterThan(100);
    expect(all.some((flag) => flag.set)).toBe(false);
  });

  it('are found by what is written about them', () => {
    const some = seen.find((flag) => flag.name === 'PosEncoderFault')!;
    expect(matchingFlags(seen, some.flag.remedy.ru.slice(0, 30), 'ru')).toContain(some);
    expect(matchingFlags(seen, 'nothing like this', 'en')).toEqual([]);
    expect(matchingFlags(seen, ' ', 'en')).toBe(seen);
  });
});

describe('what to try', () => {
  it('nothing where nothing is wrong', () => {
    const well = flagsOf(status({ Vertical: ['Move'] }), dict);
    expect(tries(READY, well, LINK, false)).toEqual([]);
  });

  it('the remedies of faults first, one remedy once', () => {
    const flags = flagsOf(status({ Vertical: ['AmperageOverload', 'ConfigFault'], Horizontal: ['ConfigFault'] }), dict);
    const found = tries(READY, flags, LINK, false);
    expect(found.map((one) => one.urgent)).toEqual([true, false]);
    expect(found[0]!.from).toEqual(['Vertical ConfigFault', 'Horizontal ConfigFault']);
  });

  it('what the link statistics suggest, and the examination of the line', () => {
    const found = tries(READY, [], { ...LINK, loss_permille: 25, errors: 3, collisions: 1 }, true);
    expect(found.map((one) => one.key)).toEqual(['loss', 'errors', 'collisions', 'doctor', 'crash']);
    expect(found[0]!.from).toEqual(['2.5 %']);
    expect(found[3]!.from).toEqual([LINK.endpoint]);
    expect(tries(READY, [], { ...LINK, loss_permille: 5 }, false)).toEqual([]);
  });

  it('of a monitor without a link: its remedy is urgent', () => {
    const text = { en: 'Check the cable.', ru: 'Проверьте кабель.' };
    const reason = {
      code: 'link' as const,
      subsystem: null,
      flag: null,
      severity: 'alarm' as const,
      what: text,
      remedy: text,
    };
    const found = tries({ ready: false, reasons: [reason] }, [], { ...LINK, state: 'down' }, false);
    expect(found.map((one) => [one.key, one.urgent])).toEqual([
      [null, true],
      ['doctor', false],
    ]);
  });
});

describe('crash data', () => {
  it('words are written as listings have them', () => {
    expect(wordHex(0x08001f3c)).toBe('0x0800 1F3C');
    expect(wordHex(4294967295)).toBe('0xFFFF FFFF');
  });
});

describe('curves of the link', () => {
  it("start with the hub's history: a value holds until the next one", () => {
    const samples = fromHistory(
      {
        'Link.sent': [
          [1000, 10],
          [3000, 20],
        ],
        'Link.timeouts': [
          [1000, 0],
          [3000, 5],
        ],
        'Link.rtt_ms': [[1000, 4]],
      },
      0,
      5000,
    );
    expect(samples.map(({ t, sent, loss_percent, rtt_ms }) => [t, sent, loss_percent, rtt_ms])).toEqual([
      [1000, 10, 0, 4],
      [2000, 10, 0, 4],
      [3000, 20, 25, 4],
      [4000, 20, 25, 4],
    ]);
    expect(fromHistory({}, 0, 5000)).toEqual([]);
  });

  it('have a gap without data', () => {
    expect(sampleOf(5, LINK, true)).toMatchObject({ t: 5, rtt_ms: 4, received: 100, loss_percent: 0 });
    expect(sampleOf(5, LINK, false)).toMatchObject({ rtt_ms: null, received: 0, loss_percent: null });
    expect(sampleOf(5, { ...LINK, state: 'down' }, true).rtt_ms).toBeNull();
    const path = pathOf(
      [
        { t: 0, v: 1 },
        { t: 1, v: null },
        { t: 2, v: 1 },
        { t: 4, v: 0 },
      ],
      0,
      4,
      1,
    );
    expect(path).toBe('M0.0 4.0M150.0 4.0L300.0 54.0');
  });

  it('have a scale that does not jump with each value', () => {
    expect([0, 0.3, 1, 7, 11, 42, 180].map(niceTop)).toEqual([1, 0.5, 1, 10, 20, 50, 200]);
    expect([0, 59_000, 61_000, 400_000, 9e6].map((ms) => spanOf(ms) / 60_000)).toEqual([1, 1, 2, 10, 15]);
  });
});
