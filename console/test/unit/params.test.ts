import { readFileSync } from 'node:fs';
import { describe, expect, it } from 'vitest';
import type { Dictionary, DictParam } from '../../src/hub/dictionary';
import { HubError } from '../../src/hub/errors';
import type { Result } from '../../src/hub/types';
import {
  check,
  defaultOf,
  fromField,
  fromList,
  isDefault,
  matches,
  scaleOf,
  toField,
  toList,
} from '../../src/pages/params/model';
import { inOrder, type Outcome, read, save, saveAll, type Ways } from '../../src/pages/params/save';

import { toldOf } from '../../src/pages/params/words';

const dictionary = JSON.parse(readFileSync(new URL('files/dictionary.json', import.meta.url), 'utf8')) as Dictionary;
const param = (title: string): DictParam => dictionary.params.find((p) => `${p.subsystem}.${p.name}` === title)!;
const degrees = () => ({ factor: 1 / 60, digits: 1, unit: '°' });

describe('bits', () => {
  it('are named by the numbers that their meaning has, and none as none', () => {
    expect(toldOf(param('General.InputFaults'), [0])).toBe('params.bits_none');
    expect(toldOf(param('General.InputFaults'), [0b1001])).toBe('params.bits');
  });
});

describe('values', () => {
  it('are checked as the monitor does', () => {
    expect(check(param('Vertical.Speed'), [12])).toBe(null);
    expect(check(param('Vertical.Speed'), [0])).toEqual({ kind: 'range', at: 0, min: 1, max: 255 });
    expect(check(param('Vertical.Speed'), [])).toMatchObject({ kind: 'count' });
    expect(check(param('Control.Trajectory0'), [])).toBe(null);
    expect(check(param('Control.Trajectory0'), [1, 2, 3])).toMatchObject({ kind: 'count', step: 4 });
    // The distance of the second point.
    const points = [0, 0, 25, 10, 0, 0, 256, 10];
    expect(check(param('Control.Trajectory0'), points)).toMatchObject({ kind: 'range', at: 6, max: 255 });
    expect(check(param('Control.Program0'), [0, 0, 0, -1, 0, 0, 0])).toMatchObject({ at: 3, min: 0 });
  });

  it('have a default of their length', () => {
    expect(defaultOf(param('Control.Program0'))).toEqual([0, 0, 0, 0, 0, 0, 0]);
    expect(defaultOf(param('Control.Trajectory0'))).toEqual([]);
    expect(isDefault(param('Vertical.MinLimit'), [-900])).toBe(true);
  });

  it('come back from the field as they went into it, in every unit', () => {
    const scales = [
      scaleOf(param('Vertical.MinLimit'), 'en', false, degrees),
      scaleOf(param('Vertical.MinLimit'), 'en', false, () => ({ factor: 6000 / 21600, digits: 0, unit: 'mil' })),
      scaleOf(param('General.PressureRange'), 'en', false, () => ({ factor: 0.0101325, digits: 2, unit: 'MPa' })),
      scaleOf(param('General.PressureRange'), 'en', false, () => ({ factor: 1.46959, digits: 0, unit: 'psi' })),
      scaleOf(param('Valve1.TravelTime'), 'en', false, degrees),
      scaleOf(param('Vertical.MaxCurrent'), 'en', false, degrees),
      scaleOf(param('Vertical.Speed'), 'en', false, degrees),
      scaleOf(param('Vertical.MinLimit'), 'en', true, degrees),
    ];
    for (const scale of scales) {
      for (let value = -32767; value <= 32767; value += 1) {
        const text = toField(value, scale);
        if (fromField(text, scale) !== value) expect({ scale, value, text }).toBe('the same');
      }
    }
    expect(toField(-900, scales[0]!)).toBe('−15');
    expect(toField(12000, scales[4]!)).toBe('12');
    expect(toField(80, scales[5]!)).toBe('8');
    expect(scales[7]!.unit).toBe('′');
  });

  it('are typed with a comma or a point, and are no words', () => {
    const scale = scaleOf(param('Vertical.MinLimit'), 'ru', false, degrees);
    expect(fromField(' −15,5 ', scale)).toBe(-930);
    expect(fromField('.5', scale)).toBe(30);
    for (const text of ['', '-', '1e3', '1 2', 'fast', '0x10']) expect(fromField(text, scale)).toBe(null);
    expect(fromField('1.5', scaleOf(param('Vertical.Speed'), 'en', false, degrees))).toBe(null);
    expect(fromList('1800, −120; 60')).toEqual([1800, -120, 60]);
    expect(fromList('')).toEqual([]);
    expect(fromList('1, x')).toBe(null);
    expect(fromList(toList([-1, 2]))).toEqual([-1, 2]);
  });

  it('are found by any word about them', () => {
    const vertical = dictionary.subsystems.find(({ name }) => name === 'Vertical')!;
    for (const words of ['speed', 'SPEED vert', 'скорость', '0x8a4b', '']) {
      expect(matches(param('Vertical.Speed'), vertical, words), words).toBe(true);
    }
    expect(matches(param('Vertical.Speed'), vertical, 'speed nozzle')).toBe(false);
  });
});

/** A monitor with given answers, which records its requests. */
function monitor(
  answers: (text: string, n: number) => string | { values: number[] },
  saved: Result['saved'] = 'stored',
): Ways & { asked: string[] } {
  const asked: string[] = [];
  const ways: Ways & { asked: string[] } = {
    asked,
    send: (text) => {
      const answer = answers(text, asked.push(text));
      const status = typeof answer === 'string' ? answer : 'Ok';
      const values = typeof answer === 'string' ? {} : { value: answer.values };
      const one = { from: 'Vertical', status, code: 0, success: true, text: '', values };
      if (status === 'Ok' || status === 'Accepted') {
        return Promise.resolve({ answers: [one] } as unknown as Result);
      }
      const code = status === 'lost' ? 'not_linked' : status === 'slow' ? 'slow_down' : 'refused';
      return Promise.reject(new HubError({ code, en: status, ru: status, answers: [one] }));
    },
    save: async (text) => ({ ...(await ways.send(text)), saved }),
    pause: () => Promise.resolve(),
  };
  return ways;
}

describe('writing', () => {
  const speed = param('Vertical.Speed');

  it('reports the outcome that the hub reports', async () => {
    const ways = monitor(() => 'Ok');
    expect(await save(ways, speed, [13])).toBe('stored');
    expect(ways.asked).toEqual(['SetParam Vertical Speed 13']);
    expect(
      await save(
        monitor(() => 'Accepted', 'unconfirmed'),
        speed,
        [13],
      ),
    ).toBe('unconfirmed');
    expect(
      await save(
        monitor(() => 'Accepted', 'write_failed'),
        speed,
        [13],
      ),
    ).toBe('write_failed');
  });

  it('asks a busy monitor and a slow unit again, and gives up on a refusal', async () => {
    expect(
      await save(
        monitor((_, n) => ['Busy', 'slow', 'Cached', 'Ok'][n - 1]!),
        speed,
        [13],
      ),
    ).toBe('stored');
    await expect(
      save(
        monitor(() => 'InvalidValue'),
        speed,
        [13],
      ),
    ).rejects.toThrow('InvalidValue');
    expect(
      await save(
        monitor(() => 'IncompleteConfig'),
        speed,
        [13],
      ),
    ).toBe('incomplete');
  });

  it('reads a value, an empty list, and none', async () => {
    expect(
      await read(
        monitor(() => ({ values: [12] })),
        speed,
      ),
    ).toEqual([12]);
    expect(
      await read(
        monitor(() => 'Ok'),
        speed,
      ),
    ).toEqual([]);
    expect(
      await read(
        monitor(() => 'IncompleteConfig'),
        speed,
      ),
    ).toBe(null);
  });

  it('writes values held back by an incomplete set once more, and those that could cut the connection last', async () => {
    const items = ['General.Address', 'Vertical.Speed', 'Vertical.MinLimit'].map((title) => ({
      param: param(title),
      wanted: [5],
      before: undefined,
    }));
    expect(inOrder(items).map(({ param: p }) => p.name)).toEqual(['Speed', 'MinLimit', 'Address']);
    const stored = new Set<string>();
    const ways = monitor((text) => {
      if (text.startsWith('GetParam')) return { values: [5] };
      const held = text.includes('Speed') && !stored.has('MinLimit');
      stored.add(text.split(' ')[2]!);
      return held ? 'IncompleteConfig' : 'Ok';
    });
    const last = new Map<string, Outcome>();
    await saveAll(ways, items, (title, outcome) => last.set(title, outcome));
    expect(ways.asked.slice(0, 4)).toEqual([
      'SetParam Vertical Speed 5',
      'SetParam Vertical MinLimit 5',
      'SetParam General Address 5',
      'SetParam Vertical Speed 5',
    ]);
    expect([...last.values()].every((o) => o.state === 'saved' && o.saved === 'stored')).toBe(true);
  });

  it('reports a value that reads back differently, and stops when the connection is lost', async () => {
    const items = [{ param: speed, wanted: [13], before: [12] }];
    const told: Outcome[] = [];
    await saveAll(
      monitor((t) => (t.startsWith('Get') ? { values: [12] } : 'Ok')),
      items,
      (_, o) => told.push(o),
    );
    expect(told.at(-1)).toEqual({ state: 'other', values: [12] });
    const lost = monitor(() => 'lost');
    await saveAll(lost, [...items, { ...items[0]!, param: param('Vertical.MinLimit') }], () => {});
    expect(lost.asked).toHaveLength(1);
  });
});
