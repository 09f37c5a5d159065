// What the monitor has taken and not stored does not count in commissioning, and the report does not claim it.
import { readFileSync } from 'node:fs';
import { afterEach, beforeAll, beforeEach, describe, expect, test, vi } from 'vitest';
import { commands } from '../../src/hub/commands';
import { type Dictionary, dictionary, param } from '../../src/hub/dictionary';
import { HubError } from '../../src/hub/errors';
import { http } from '../../src/hub/http';
import type { Result } from '../../src/hub/types';
import { StepLimits, StepZero } from '../../src/pages/commissioning/drives';
import { writeAll } from '../../src/pages/commissioning/stored';
import { StepTune } from '../../src/pages/commissioning/tune';
import type { Ways } from '../../src/pages/params/save';

type Said = 'stored' | 'unconfirmed' | 'write_failed' | 'incomplete' | 'refused';

const [lag, speed] = ['StopLag', 'MinSpeed'] as const;
let asked: string[];
/** What the monitor says to each SetParam, by the name of the parameter; the last answer stays. */
let says: Record<string, Said[]>;

beforeAll(async () => {
  const file = readFileSync(new URL('files/dictionary.json', import.meta.url), 'utf8');
  vi.spyOn(http, 'get').mockResolvedValue(JSON.parse(file) as Dictionary);
  await dictionary();
});
beforeEach(() => {
  asked = [];
  says = {};
  vi.spyOn(commands, 'request').mockImplementation(async (_, text) => answer(text));
});
afterEach(() => vi.restoreAllMocks());

function answer(text: string): Result {
  asked.push(text);
  const [request, , name] = text.split(' ');
  const all = says[name!] ?? ['stored'];
  const said = request === 'SetParam' ? (all.length > 1 ? all.shift()! : all[0]!) : 'stored';
  const status = said === 'incomplete' ? 'IncompleteConfig' : said === 'refused' ? 'Denied' : 'Ok';
  const answers = [{ from: 'Horizontal', status, success: status === 'Ok', values: {} }];
  if (said === 'refused') throw new HubError({ code: 'refused', en: 'Denied', ru: 'Denied', answers });
  return { ok: true, answers, ...(said !== 'incomplete' && { saved: said }) } as unknown as Result;
}

describe('writing', () => {
  const ways: Ways = { send: async (text) => answer(text), save: async (text) => answer(text), pause: async () => {} };
  const items = () => [lag, speed].map((name) => ({ param: param('Horizontal', name)!, value: 5 }));

  test('is done when all is stored, or in force without a word about it', async () => {
    expect(await writeAll(ways, items())).toBe('');
    says = { [lag]: ['unconfirmed'] };
    expect(await writeAll(ways, items())).toBe('');
  });

  test('is not done when the memory cannot be written', async () => {
    says = { [lag]: ['write_failed'] };
    const took = vi.fn();
    expect(await writeAll(ways, items(), took)).toBe('commissioning.unstored_write_failed');
    expect(took).toHaveBeenCalledTimes(2);
  });

  test('is done when the last one has made the set complete, and not before', async () => {
    says = { [lag]: ['incomplete', 'stored'] };
    expect(await writeAll(ways, items())).toBe('');
    expect(asked).toEqual([
      'SetParam Horizontal StopLag 5',
      'SetParam Horizontal MinSpeed 5',
      'SetParam Horizontal StopLag 5',
    ]);
    says = { [lag]: ['incomplete'], [speed]: ['incomplete'] };
    expect(await writeAll(ways, items())).toContain('commissioning.unstored_incomplete');
  });
});

/** Parts of a step that are not for others. */
type Inside = {
  work: Record<string, unknown>;
  error: string;
  monitor: string;
  write: (drive: string, found: object) => Promise<void>;
  facts: (drives: string[]) => { key: string }[];
  zero: (drive: string) => Promise<void>;
  takeLimit: (drive: string, toward: 'min' | 'max') => Promise<void>;
  inForce: (drive: string) => Promise<void>;
  storeLost: (drive: string) => Promise<void>;
};

function made(step: StepTune | StepZero | StepLimits, at = 600): Inside {
  const inside = step as unknown as Inside;
  inside.monitor = 'M1';
  Object.assign(step, { position: () => at, has: () => false });
  return inside;
}

describe('tuning', () => {
  const found = { stop_lag: 300, min_speed: 10 };
  const before = { stop_lag: 0, min_speed: 0 };
  const tune = () => {
    const step = made(new StepTune());
    step.work = { Horizontal: { found, before } };
    return step;
  };
  const known = (step: Inside) => step.work.Horizontal as { outcome?: string; unstored?: boolean };

  test('is written when both values are stored', async () => {
    const step = tune();
    await step.write('Horizontal', found);
    expect([known(step), step.error]).toEqual([{ found, before, outcome: 'written', unstored: false }, '']);
    expect(step.facts(['Horizontal'])).toMatchObject([{ key: 'commissioning.fact.tune_written' }]);
  });

  test.each([
    ['write_failed', 'commissioning.unstored_write_failed'],
    ['incomplete', 'commissioning.unstored_incomplete'],
  ] as const)('is neither written nor kept: %s', async (said, words) => {
    says = { [speed]: [said] };
    const step = tune();
    await step.write('Horizontal', found);
    expect(known(step)).toMatchObject({ unstored: true });
    expect(known(step).outcome).toBeUndefined();
    expect(step.error).toBe(words);
    says = {};
    await step.write('Horizontal', found);
    expect(known(step)).toMatchObject({ outcome: 'written', unstored: false });
  });

  test('that was refused has changed nothing', async () => {
    says = { [lag]: ['refused'] };
    const step = tune();
    await step.write('Horizontal', found);
    expect(known(step)).toEqual({ found, before });
  });
});

describe('a zero point', () => {
  test.each(['write_failed', 'incomplete'] as const)(
    'does not count, nor does what was confirmed before: %s',
    async (said) => {
      says = { ZeroPoint: [said] };
      const step = made(new StepZero(), 0);
      step.work = { Horizontal: 'kept' };
      await step.zero('Horizontal');
      expect(step.work.Horizontal).toBe('unstored');
      expect(step.error).toBe(`commissioning.unstored_${said}`);
      says = {};
      await step.zero('Horizontal');
      expect(step.work.Horizontal).toBe('taken');
    },
  );

  test('that was refused leaves what was confirmed', async () => {
    says = { ZeroPoint: ['refused'] };
    const step = made(new StepZero(), 0);
    step.work = { Horizontal: 'kept' };
    await step.zero('Horizontal');
    expect(step.work.Horizontal).toBe('kept');
  });
});

describe('limits', () => {
  const known = (step: Inside) => step.work.Horizontal as { max?: number; lost?: { max?: number }; taught?: boolean };

  test('that the memory did not store do not count until it has', async () => {
    says = { MaxLimit: ['write_failed'] };
    const step = made(new StepLimits());
    await step.takeLimit('Horizontal', 'max');
    expect([known(step).max, known(step).lost?.max]).toEqual([undefined, 600]);
    expect(step.error).toBe('commissioning.unstored_write_failed');
    await step.inForce('Horizontal');
    expect(known(step)).toEqual({ lost: { max: 600 } });
    expect(step.error, 'it was tried again').toBe('commissioning.unstored_write_failed');
    says = {};
    await step.storeLost('Horizontal');
    expect([known(step).max, known(step).lost?.max, step.error]).toEqual([600, undefined, '']);
  });

  test('that are kept aside while limits are off count when they are stored', async () => {
    says = { MaxLimit: ['unconfirmed', 'write_failed'] };
    const step = made(new StepLimits());
    await step.takeLimit('Horizontal', 'max');
    await step.inForce('Horizontal');
    expect([known(step).taught, known(step).lost?.max]).toEqual([undefined, 600]);
  });

  test('of a set that becomes complete count when they are in force', async () => {
    says = { MaxLimit: ['incomplete', 'stored'] };
    const step = made(new StepLimits());
    await step.takeLimit('Horizontal', 'max');
    vi.mocked(commands.request).mockImplementation(async (_, text) => {
      const result = answer(text);
      if (text.startsWith('RetrieveLimits')) result.answers[0]!.values = { max: 600 } as never;
      return result;
    });
    await step.inForce('Horizontal');
    expect(asked.at(-2)).toBe('SetParam Horizontal MaxLimit 600');
    expect([known(step).taught, step.error]).toEqual([true, '']);
  });
});
