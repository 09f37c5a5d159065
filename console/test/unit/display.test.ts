import { expect, test } from 'vitest';
import { magnification } from '../../src/theme/display';

test('what is normal is never magnified', () => {
  expect(magnification('normal', 3840, 2160)).toBe(1);
});

test('a wall is filled, as far as the layout of a desk has its room', () => {
  expect(magnification('wall', 2560, 1440)).toBe(1.88);
  expect(magnification('wall', 1920, 1080)).toBe(1.41);
  expect(magnification('wall', 3840, 2160)).toBe(2.82);
  // A portrait screen is limited by its width.
  expect(magnification('wall', 1440, 2560)).toBe(1.05);
  expect(magnification('wall', 8000, 4000)).toBe(3);
});

test('large is a quarter more, where there is the room', () => {
  expect(magnification('large', 1920, 1080)).toBe(1.25);
  expect(magnification('large', 1440, 900)).toBe(1.05);
});

test('tablets and phones do not change', () => {
  for (const wanted of ['large', 'wall'] as const) {
    expect(magnification(wanted, 1024, 768)).toBe(1);
    expect(magnification(wanted, 390, 844)).toBe(1);
  }
});
