import { describe, expect, it } from 'vitest';
import { brightest, type HotbedBox, isDoubtful, reckon, type Seen, sameOf, spotsOf } from '../../src/parts/found';
import type { Place, Tank } from '../../src/parts/geometry';

const TANK: Tank = { name: 'T-1', at: [0, 0], diameter: 10, height: 6 };
/** 6 m above the ground, looking north-east at the tank. */
const stand = (height_m: number | null) => ({ at: [-20, -20] as Place, heading: 45, height_m });
/** Seen this far down, arc-minutes; the flames reach 3° above their foot. */
const box = (foot: number, horizontal = 3000): HotbedBox => ({
  x1: horizontal + 60,
  x2: horizontal - 60,
  y1: foot,
  y2: foot + 180,
  brightness: 1,
});
const down = (height_m: number, distance_m: number) =>
  Math.round((-Math.atan2(height_m, distance_m) / Math.PI) * 180 * 60);

describe('the distance of a fire spot', () => {
  it('takes the height and the angle to the foot of the fire, not to the middle of the flames', () => {
    const of = reckon(stand(6), box(down(6, 35)), [TANK]);
    expect(of).toMatchObject({ how: 'height', height_m: 6 });
    expect('distance_m' in of && of.distance_m).toBeCloseTo(35, 0);
  });

  it('reports the effect of half a metre of height', () => {
    const angle = down(1.0, 25);
    const told = reckon(stand(1.0), box(angle), []);
    const higher = reckon(stand(1.5), box(angle), []);
    if (told.how !== 'height' || higher.how !== 'height') throw new Error('not computed');
    expect(told.distance_m).toBeCloseTo(25, 0);
    expect(higher.distance_m).toBeCloseTo(37.5, 0);
    expect(told.distance_m + told.give_m).toBeCloseTo(higher.distance_m, 5);
    expect(isDoubtful(told)).toBe(true);
    const high = reckon(stand(6), box(down(6, 25)), []);
    expect(isDoubtful(high)).toBe(false);
  });

  it('takes the tank in that direction, unless the fire is in front of it', () => {
    expect(reckon(stand(6), box(0, 0), [TANK])).toMatchObject({ how: 'tank', tank: 'T-1', give_m: 5 });
    const before = reckon(stand(6), box(down(6, 12), 0), [TANK]);
    expect(before.how).toBe('height');
    expect(reckon(stand(null), box(0, 0), [TANK])).toMatchObject({ how: 'tank' });
  });

  it('computes nothing where it cannot', () => {
    expect(reckon(stand(6), box(0), []).how).toBe('level');
    expect(reckon(stand(6), box(300), []).how).toBe('level');
    expect(reckon(stand(0), box(-300), []).how).toBe('level');
    expect(reckon(stand(null), box(-300), []).how).toBe('no_height');
    expect(reckon(stand(12), box(down(12, 200)), []).how).toBe('far');
  });
});

describe('fires on the plan of a site', () => {
  const seen = (id: string, at: [number, number], bearing: number, distance_m: number | null = null): Seen => ({
    id,
    at,
    bearing,
    distance_m,
  });

  it('are where the lines of sight of two monitors cross', () => {
    const spots = spotsOf([seen('M1', [0, 0], 45), seen('M2', [40, 0], 315)]);
    expect(spots).toEqual([{ at: [expect.closeTo(20), expect.closeTo(20)], seen_by: ['M1', 'M2'], crossed: true }]);
    // A third monitor that sees the same fire adds no new one.
    expect(spotsOf([seen('M1', [0, 0], 45), seen('M2', [40, 0], 315), seen('M3', [20, 50], 180)])).toEqual([
      { at: [expect.closeTo(20), expect.closeTo(20)], seen_by: ['M1', 'M2', 'M3'], crossed: true },
    ]);
  });

  it('are at the computed distance of one alone, and nowhere without a distance', () => {
    expect(spotsOf([seen('M1', [0, 0], 90, 25)])).toEqual([
      { at: [expect.closeTo(25), expect.closeTo(0)], seen_by: ['M1'], crossed: false },
    ]);
    expect(spotsOf([seen('M1', [0, 0], 90)])).toEqual([]);
    // Nearly parallel, or behind: two fires or none.
    expect(spotsOf([seen('M1', [0, 0], 90), seen('M2', [0, 5], 92)])).toEqual([]);
    expect(spotsOf([seen('M1', [0, 0], 270), seen('M2', [40, 0], 315)])).toEqual([]);
    // Two fires: what one monitor has as the distance contradicts the crossing.
    const two = spotsOf([seen('M1', [0, 0], 45, 80), seen('M2', [40, 0], 315, 28)]);
    expect(two.map(({ crossed }) => crossed)).toEqual([false, false]);
  });
});

describe('the fire spot that was chosen', () => {
  const at = (x: number, brightness: number): HotbedBox => ({ x1: x + 60, x2: x - 60, y1: -100, y2: 0, brightness });

  it('stays the same when another one becomes brighter, or the list another order', () => {
    const chosen = at(600, 5);
    expect(sameOf([at(-600, 9), at(610, 4)], chosen)).toBe(1);
    expect(sameOf([at(590, 4), at(-600, 9)], chosen)).toBe(0);
    expect(sameOf([at(660, 4), at(605, 4)], chosen), 'the nearer of two that overlap').toBe(1);
  });

  it('is gone when nothing is seen there', () => {
    expect(sameOf([at(-600, 9)], at(600, 5))).toBe(-1);
    expect(sameOf([], at(600, 5))).toBe(-1);
  });

  it('is the brightest at first', () => {
    expect(brightest([at(0, 3), at(600, 8), at(900, 8)])).toBe(1);
    expect(brightest([])).toBe(0);
  });
});
