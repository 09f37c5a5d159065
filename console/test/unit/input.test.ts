import { describe, expect, test } from 'vitest';
import { moveOf, ofMoves, ofPad, Pads, SILENT_MOST_MS, SILENT_STICK_MS, together } from '../../src/pages/operate/input';
import { PadStop } from '../../src/shell/stop-keys';

const pad = (axes: number[], pressed: number[] = [], index = 0, mapping = 'standard') => ({
  index,
  mapping,
  axes,
  buttons: Array.from({ length: 16 }, (_, n) => ({ pressed: pressed.includes(n) })),
});

test('keys: up and left are positive, opposite ones mean nothing', () => {
  const codes = (...all: string[]) => all.map((code) => moveOf({ code, key: '', shiftKey: false }) ?? '');
  expect(ofMoves(codes('ArrowUp', 'ArrowRight'))).toEqual({ Vertical: 'max', Horizontal: 'min' });
  expect(ofMoves(codes('ArrowLeft', 'ArrowRight', 'NumpadSubtract'))).toEqual({ Nozzle: 'min' });
  expect(ofMoves(codes('KeyA'))).toEqual({});
});

test.each([
  ['US', 'Equal', '=', false, { Nozzle: 'max' }],
  ['US', 'Equal', '+', true, { Nozzle: 'max' }],
  ['US', 'Minus', '-', false, { Nozzle: 'min' }],
  ['US', 'Minus', '_', true, { Nozzle: 'min' }],
  ['Nordic', 'Minus', '+', false, { Nozzle: 'max' }],
  ['Nordic', 'Minus', '?', true, {}],
  ['Nordic', 'Equal', 'Dead', false, {}],
  ['Nordic', 'Digit0', '=', true, {}],
  ['Nordic', 'Slash', '-', false, { Nozzle: 'min' }],
  ['German', 'BracketRight', '+', false, { Nozzle: 'max' }],
  ['French', 'Digit6', '-', false, { Nozzle: 'min' }],
  ['French', 'Digit8', '_', false, {}],
  ['any', 'NumpadAdd', '+', false, { Nozzle: 'max' }],
  ['any', 'NumpadSubtract', '-', true, { Nozzle: 'min' }],
] as const)('the nozzle does what the key types: %s %s %s', (_, code, key, shiftKey, holding) => {
  expect(ofMoves([moveOf({ code, key, shiftKey }) ?? ''])).toEqual(holding);
});

test('a gamepad: stick, cross, shoulder buttons; a stick at rest does nothing', () => {
  expect(ofPad(pad([0.1, -0.1]), {})).toEqual({});
  expect(ofPad(pad([0, -1]), {})).toEqual({ Vertical: 'max' });
  expect(ofPad(pad([-1, 0]), {})).toEqual({ Horizontal: 'max' });
  expect(ofPad(pad([0, 0], [13]), {})).toEqual({ Vertical: 'min' });
  expect(ofPad(pad([0, 0], [4]), {})).toEqual({ Nozzle: 'min' });
  expect(ofPad(pad([0, 0], [4, 5]), {})).toEqual({});
});

test('the first of two sources gets the drive', () => {
  expect(together([{ Vertical: 'max' }, { Vertical: 'min', Nozzle: 'min' }])).toEqual({
    Vertical: 'max',
    Nozzle: 'min',
  });
});

test('a gamepad moves only what was at rest before, also after it was blocked', () => {
  const pads = new Pads();
  const reads = (...all: ReturnType<typeof pad>[]) => pads.read(all, {});
  const [pulled, rest] = [pad([-1, 0]), pad([0, 0])];
  expect(reads(pulled), 'it was connected with its stick pulled').toEqual({});
  expect(reads(rest)).toEqual({});
  expect(reads(pulled)).toEqual({ Horizontal: 'max' });
  pads.block();
  expect(reads(pulled)).toEqual({});
  expect(reads(pad([0.25, 0])), 'inside of the dead zone is at rest').toEqual({});
  expect(reads(pulled)).toEqual({ Horizontal: 'max' });
  expect(reads(), 'it is gone').toEqual({});
  expect(reads(pulled), 'and comes back').toEqual({});
});

describe('a gamepad whose radio is dead', () => {
  const sends = (timestamp: number | undefined, axes: number[], pressed: number[] = []) => ({
    ...pad(axes, pressed),
    timestamp,
  });
  let silent = 0;
  /** Reads at these times; `[at, timestamp]`. */
  const reads = (pads: Pads, axes: number[], pressed: number[], times: [number, number | undefined][]) =>
    times.map(([at, timestamp]) => pads.read([sends(timestamp, axes, pressed)], {}, at));
  const fresh = (timestamp: number | undefined = 1) => {
    silent = 0;
    const pads = new Pads(() => {
      silent += 1;
    });
    pads.read([sends(timestamp, [0, 0])], {}, 0);
    return pads;
  };
  const left = { Horizontal: 'max' };

  test.each([
    ['a stick', [-0.6, 0], [], SILENT_STICK_MS],
    ['a stick at its end', [-1, 0], [], SILENT_MOST_MS],
    ['a held cross', [0, 0], [14], SILENT_MOST_MS],
  ] as const)('moves nothing any more: %s', (_, axes, pressed, most) => {
    const pads = fresh();
    const [at, later] = [100, 100 + most];
    expect(
      reads(
        pads,
        [...axes],
        [...pressed],
        [
          [at, 2],
          [later, 2],
          [later + 1, 2],
          [later + 2, 2],
        ],
      ),
    ).toEqual([left, left, {}, {}]);
    expect(silent, 'the operator is informed once').toBe(1);
    // The radio is back, and it is still pulled: it was not at rest.
    expect(reads(pads, [...axes], [...pressed], [[later + 100, 3]])).toEqual([{}]);
    expect(reads(pads, [0, 0], [], [[later + 200, 4]])).toEqual([{}]);
    expect(reads(pads, [...axes], [...pressed], [[later + 300, 5]])).toEqual([left]);
  });

  test('is none as long as it sends anything', () => {
    const pads = fresh();
    const times = Array.from({ length: 40 }, (_, n): [number, number] => [100 + n * 1000, 2 + n]);
    expect(new Set(reads(pads, [-0.6, 0], [], times).map(({ Horizontal }) => Horizontal))).toEqual(new Set(['max']));
    expect(silent).toBe(0);
  });

  test.each([0, undefined, 7])('is not assumed where a browser has no times: %s', (timestamp) => {
    const pads = fresh(timestamp);
    expect(
      reads(
        pads,
        [-0.6, 0],
        [],
        [
          [100, timestamp],
          [60_000, timestamp],
        ],
      ),
    ).toEqual([left, left]);
    expect(silent).toBe(0);
  });

  test('at rest it may be silent for as long as it likes', () => {
    const pads = fresh();
    expect(
      reads(
        pads,
        [0, 0],
        [],
        [
          [100, 2],
          [60_000, 2],
        ],
      ),
    ).toEqual([{}, {}]);
    expect(reads(pads, [-1, 0], [], [[60_100, 3]])).toEqual([left]);
    expect(silent).toBe(0);
  });
});

test('a gamepad of an unknown kind moves nothing, and its buttons are not STOP', () => {
  const pads = new Pads();
  const odd = (axes: number[], pressed: number[] = []) => pad(axes, pressed, 0, '');
  expect(pads.read([odd([0, 0])], {})).toEqual({});
  expect(pads.read([odd([-1, 0], [1])], {})).toEqual({});
  expect(new PadStop().read([odd([0, 0], [1])])).toBe(false);
});

test('STOP is a button of every gamepad, once for each press', () => {
  const pads = new PadStop();
  const stop = (pressed: number[]) => pads.read([pad([0, 0], [], 0), pad([0, 0], pressed, 3)]);
  expect([stop([]), stop([1]), stop([1]), stop([]), stop([1])]).toEqual([false, true, false, false, true]);
});
