import { readFileSync } from 'node:fs';
import { describe, expect, it } from 'vitest';
import type { Dictionary } from '../../src/hub/dictionary';
import type { FrameSeen } from '../../src/hub/types';
import { complete, needsOf } from '../../src/pages/inspector/complete';
import { Frames, lineOf, shownFrames, slice } from '../../src/pages/inspector/frames';
import { bytesOf, decode, hexOf, isPoll } from '../../src/pages/inspector/wire';

const file = (name: string) => JSON.parse(readFileSync(new URL(`files/${name}`, import.meta.url), 'utf8'));
// Subsystems and parameters; requests, flags and answers: what `lafet schema` prints, in two parts.
const dict = file('dictionary.json') as Dictionary;
const records = (hex: string, out: boolean) => decode(bytesOf(hex), out, dict);

describe('decoded frames', () => {
  it('a request: header, and a signed value with its unit', () => {
    const [move, ...rest] = records('4d 0d 00 02 50 fb', true);
    expect(rest).toEqual([]);
    expect(move).toMatchObject({
      requestName: 'Move',
      deviceName: 'Vertical',
      layout: 'Move',
      from: 0,
      to: 6,
      broken: false,
    });
    expect(move!.fields).toMatchObject([{ name: 'destination', value: -1200, from: 4, to: 6 }]);
  });

  it('an answer to GetStatus, with the flags of the subsystem by name', () => {
    const [general, vertical] = records(
      'd4 c2 00 0a 00 00 05 00 18 00 62 00 14 00 d4 0d 00 08 00 00 01 00 78 00 0c 06',
      false,
    );
    expect(general).toMatchObject({ deviceName: 'General', statusName: 'Ok', layout: 'GeneralStatus' });
    expect(general!.fields[0]!.names).toEqual(['PressureSensorBreak', 'LockedOut']);
    expect(general!.fields.map((field) => field.value).slice(1)).toEqual([24, 98, 20]);
    expect(vertical!.from).toBe(14);
    expect(vertical!.fields[0]!.names).toEqual(['Move']);
    expect(vertical!.fields.slice(1).map(({ name, value }) => [name, value])).toEqual([
      ['position', 120],
      ['current', 12],
      ['speed', 6],
    ]);
  });

  it('flags of two bits say their state', () => {
    const [buttons] = records('d4 d4 00 04 00 00 0d 80', false);
    expect(buttons!.fields[0]!.names).toEqual([
      'LeftButtonState=Pressed',
      'RightButtonState=Open',
      'CloseButtonState=Short',
    ]);
  });

  it('a key by its name, a parameter by its subsystem, values one by one', () => {
    const keys = dict.protocol.keys as Record<string, number>;
    const open = keys.Open!;
    const hex = [open & 255, open >> 8].map((byte) => byte.toString(16).padStart(2, '0')).join(' ');
    expect(records(`21 a6 00 02 ${hex}`, true)[0]!.fields[0]!.names).toEqual(['Open']);
    const id = dict.params.find((p) => p.subsystem === 'Vertical' && p.name === 'MinLimit')!.id;
    const low = (id & 255).toString(16).padStart(2, '0');
    const high = (id >> 8).toString(16).padStart(2, '0');
    const [answer] = records(`9d 0d 00 06 ${low} ${high} 7c fc ff ff`, false);
    expect(answer!.layout).toBe('Param');
    expect(answer!.fields[0]!.names).toEqual(['MinLimit']);
    expect(answer!.fields[1]).toMatchObject({ name: 'value[0]', value: -900 });
  });

  it('a layout that is known by its first bytes', () => {
    const [hotbeds] = records('9c c8 00 02 fe 23', false);
    expect(hotbeds).toMatchObject({ requestName: 'GetHotbed', layout: 'Hotbeds' });
  });

  it('unknown, malformed and truncated frames', () => {
    const [unknown] = records('12 34 00 01 aa', true);
    expect(unknown).toMatchObject({ requestName: '0x12', deviceName: '0x34', layout: null, rest: { from: 4, to: 5 } });
    expect(records('4d 0d 00 03 01 02 03', true)[0]).toMatchObject({ layout: null, rest: { from: 4, to: 7 } });
    expect(records('4d 0d 00 02 b0', true)[0]).toMatchObject({ broken: true, fields: [], to: 5 });
    expect(records('4d 0d', true)[0]).toMatchObject({ broken: true, fields: [], to: 2 });
    expect(records('', true)).toEqual([]);
    expect(hexOf(10)).toBe('0x0a');
  });

  it('polls are those frames that only ask for the state', () => {
    expect(isPoll(bytesOf('d4 5d 00 00'), dict)).toBe(true);
    expect(isPoll(bytesOf('d4 0d 00 00 4d 0d 00 02 00 00'), dict)).toBe(false);
    expect(isPoll([], dict)).toBe(false);
  });
});

describe('completion', () => {
  const has = (name: string) => name !== 'Deployer';
  const offers = (text: string) => complete(text, text.length, dict, has).offers.map((offer) => offer.insert);

  it('offers requests, those that start with it before those that contain it', () => {
    expect(offers('st').slice(0, 3)).toEqual(['Stop', 'StartJustify', 'StartQuench']);
    expect(offers('st')).toContain('Restart');
    expect(offers('st').indexOf('Restart')).toBeGreaterThan(offers('st').indexOf('StartSeek'));
    expect(offers('')).not.toContain('AccessGranted');
  });

  it('offers only addressees that the request has, and the monitor', () => {
    expect(offers('Open ')).toEqual(['Valve1', 'Valve2']);
    expect(offers('Move ')).toEqual(['Vertical', 'Horizontal', 'Nozzle']);
    expect(offers('open v')).toEqual(['Valve1', 'Valve2']);
  });

  it('offers parameters of the subsystem, only those that can be set, and their range', () => {
    expect(offers('GetParam Vertical MinL')).toContain('MinLimit');
    const readOnly = dict.params.find((p) => p.access === 'read-only');
    if (readOnly)
      expect(offers(`SetParam ${readOnly.subsystem} ${readOnly.name.slice(0, 4)}`)).not.toContain(readOnly.name);
    const { offers: values } = complete('SetParam Vertical MinLimit ', 27, dict, has);
    const known = dict.params.find((p) => p.subsystem === 'Vertical' && p.name === 'MinLimit')!;
    expect(values[0]).toMatchObject({ insert: String(known.default) });
    expect(values[0]!.text!.en).toContain(`${known.min} … ${known.max}`);
  });

  it('offers words of the data once, and repeatable ones again', () => {
    expect(offers('Lockout All ')).toEqual(['on', 'off']);
    expect(offers('Lockout All on ')).toEqual([]);
    expect(offers('StartQuench Control centre=0,0 ')).not.toContain('centre=');
    expect(offers('StartTrajectory Control point=0,0,25,10 ')).toContain('point=');
  });

  it('completes the word under the caret', () => {
    const { from, offers: found } = complete('Mov Vertical 5', 3, dict, has);
    expect([from, found[0]?.insert]).toEqual([0, 'Move']);
  });

  it.each([
    ['GetStatus All', 'observer', false, false],
    ['stop all', 'observer', false, false],
    ['Lockout All on', 'observer', false, false],
    ['Lockout All off', 'operator', true, true],
    ['move vertical 5', 'operator', true, false],
    ['SetParam Vertical MinLimit 0', 'engineer', true, false],
    ['Restart', 'engineer', true, true],
    ['CleanFlash General', 'administrator', true, true],
    ['0x12 0x34', 'engineer', true, false],
  ])('%s needs %s, control %s, confirmation %s', (text, role, authority, confirm) => {
    expect(needsOf(text, dict)).toMatchObject({ role, authority, confirm });
  });
});

describe('the list', () => {
  const frame = (at_ms: number, direction: 'in' | 'out', change: Partial<FrameSeen> = {}): FrameSeen => ({
    type: 'frame',
    monitor: 'M1',
    at_ms,
    direction,
    verdict: direction === 'out' ? 'sent' : 'believed',
    dst: direction === 'out' ? 1 : 129,
    src: direction === 'out' ? 129 : 1,
    bytes: 'd4 5d 00 00',
    text: 'GetStatus All',
    ...change,
  });

  it('shows how long an answer took, and only for answers', () => {
    const frames = new Frames();
    frames.add(frame(100, 'out'));
    frames.add(frame(105, 'in', { verdict: 'foreign', src: 7 }));
    frames.add(frame(112, 'in'));
    frames.add(frame(113, 'in', { verdict: 'duplicate' }));
    expect(frames.list.map((one) => one.took_ms)).toEqual([null, null, 12, null]);
    expect(frames.passed).toBe(4);
    frames.clear();
    expect([frames.list.length, frames.passed]).toEqual([0, 4]);
  });

  it('filters by text, bytes, direction, polls', () => {
    const frames = new Frames();
    frames.add(frame(1, 'out'));
    frames.add(frame(2, 'out', { text: 'Move Vertical 1200', bytes: '4d 0d 00 02 b0 04' }));
    frames.add(frame(3, 'in'));
    const shown = (change: object) =>
      shownFrames(frames.list, { text: '', direction: 'both', polls: true, ...change }, (one) =>
        one.text.startsWith('Get'),
      ).map((one) => one.n);
    expect(shown({})).toEqual([1, 2, 3]);
    expect(shown({ text: 'vertical' })).toEqual([2]);
    expect(shown({ text: '4d 0d' })).toEqual([2]);
    expect(shown({ direction: 'in' })).toEqual([3]);
    expect(shown({ polls: false })).toEqual([2]);
    expect(lineOf(frames.list[1]!)).toContain('> 129>1 sent | 4d 0d 00 02 b0 04 | Move Vertical 1200');
  });

  it('draws visible rows', () => {
    expect(slice(0, 520, 52, 1000)).toEqual([0, 16]);
    expect(slice(5200, 520, 52, 1000)).toEqual([94, 116]);
    expect(slice(99999, 520, 52, 10)).toEqual([9, 10]);
    expect(slice(0, 520, 52, 0)).toEqual([0, 0]);
  });
});
