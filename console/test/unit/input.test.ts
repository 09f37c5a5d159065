import { expect, test } from 'vitest';
import { ofCodes, ofPad, together } from '../../src/pages/operate/input';

const pad = (axes: number[], pressed: number[] = []) => ({
  axes,
  buttons: Array.from({ length: 16 }, (_, n) => ({ pressed: pressed.includes(n) })),
});

test('keys: up and left are positive, opposite ones mean nothing', () => {
  expect(ofCodes(['ArrowUp', 'ArrowRight'])).toEqual({ Vertical: 'max', Horizontal: 'min' });
  expect(ofCodes(['ArrowLeft', 'ArrowRight', 'Minus'])).toEqual({ Nozzle: 'min' });
  expect(ofCodes(['KeyA'])).toEqual({});
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
