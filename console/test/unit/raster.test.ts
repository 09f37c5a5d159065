import { describe, expect, it } from 'vitest';
import { pulled } from '../../src/parts/lf-aim-chart-model';
import { areaOf, clip, isInside, lengthOf, lineCount, passOver, reach, type Sector } from '../../src/parts/raster';

const SECTOR: Sector = { centre: { h: 0, v: 0 }, width: 600, height: 300, step: 2 };
const limits = (h: [number, number], v: [number, number]) => ({
  Horizontal: { min: h[0], max: h[1] },
  Vertical: { min: v[0], max: v[1] },
});
const pairs = (sector: Sector, from: [number, number], within = limits([-9000, 9000], [-900, 4500])) =>
  passOver(sector, within, { h: from[0], v: from[1] }).map(({ h, v }) => [h, v]);

describe('the path over a sector', () => {
  // The same numbers as the device's own test of its raster.
  it('goes back and forth from the nearest corner', () => {
    expect(pairs(SECTOR, [-500, -500])).toEqual([
      [-300, -120],
      [300, -120],
      [300, 0],
      [-300, 0],
      [-300, 120],
      [300, 120],
    ]);
    expect(pairs(SECTOR, [900, 900]).slice(0, 3)).toEqual([
      [300, 120],
      [-300, 120],
      [-300, 0],
    ]);
  });

  it('is one line where the step is greater than the height, and a point without a step', () => {
    expect(pairs({ ...SECTOR, step: 10 }, [900, 900])).toEqual([
      [300, 0],
      [-300, 0],
    ]);
    expect(pairs({ ...SECTOR, step: 0 }, [0, 0])).toEqual([[0, 0]]);
  });

  it('stays inside the limits', () => {
    const half = limits([0, 900], [-900, 0]);
    expect(clip(areaOf(SECTOR), half)).toEqual({ right: 0, left: 300, bottom: -150, top: 0 });
    for (const [h, v] of pairs(SECTOR, [500, 500], half)) expect(isInside({ h: h!, v: v! }, half)).toBe(true);
    expect(pairs(SECTOR, [0, 0], limits([301, 900], [-900, 900]))).toEqual([]);
    expect(reach(SECTOR, half)).toBe('partly');
    expect(reach(SECTOR, limits([-300, 300], [-150, 150]))).toBe('inside');
    expect(reach(SECTOR, limits([-900, 900], [-900, -151]))).toBe('outside');
    expect(reach(SECTOR, null)).toBe('inside');
  });

  it('is measured', () => {
    expect(lineCount(300, 2)).toBe(3);
    expect(lineCount(0, 2)).toBe(1);
    expect(
      lengthOf([
        { h: 0, v: 0 },
        { h: 300, v: 400 },
        { h: 300, v: 0 },
      ]),
    ).toBe(900);
  });
});

describe('a dragged grip', () => {
  it('moves its edge and leaves the opposite one', () => {
    const { centre, width, height } = pulled(SECTOR, 'left', { h: 100, v: 50 });
    expect({ centre, width, height }).toEqual({ centre: { h: 50, v: 0 }, width: 700, height: 300 });
    const area = areaOf({ ...SECTOR, centre, width, height });
    expect(area.right).toBe(-300);
    expect(pulled(SECTOR, 'bottom', { h: 0, v: -50 })).toEqual({ centre: { h: 0, v: -25 }, width: 600, height: 350 });
    expect(pulled(SECTOR, 'move', { h: 7, v: -7 })).toEqual({ centre: { h: 7, v: -7 }, width: 600, height: 300 });
  });

  it('does not turn the sector inside out', () => {
    expect(pulled(SECTOR, 'top', { h: 0, v: -900 })).toEqual({ centre: { h: 0, v: -150 }, width: 600, height: 0 });
    expect(pulled(SECTOR, 'right', { h: 9000, v: 0 }).width).toBe(0);
  });
});
