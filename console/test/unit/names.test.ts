import { describe, expect, it } from 'vitest';
import type { Place } from '../../src/parts/geometry';
import { NAME_PX, type Named, namePlaces, nameWidth } from '../../src/parts/plan/names';

const SCREEN: Place = [1200, 900];
const CLEAR = 35;
const BODY = 22;

const named = (n: number, at: Place, barrel = 0): Named => ({ id: `M${n}`, at, barrel });

/** Twenty of them, in rows of five. */
const crowd = (step: number, turned = 0): Named[] =>
  Array.from({ length: 20 }, (_, n) => named(n + 1, [100 + (n % 5) * step, 100 + Math.floor(n / 5) * step], turned));

function overlap(a: Place, [wa, ha]: Place, b: Place, [wb, hb]: Place): boolean {
  return Math.abs(a[0] - b[0]) < (wa + wb) / 2 && Math.abs(a[1] - b[1]) < (ha + hb) / 2;
}

describe('names on the plan', () => {
  it('are behind the barrel if there is room', () => {
    const places = namePlaces([named(1, [200, 200]), named(2, [600, 200], 270)], SCREEN, CLEAR);
    const [x, y] = places.get('M1')!;
    expect([Math.round(x), Math.round(y)]).toEqual([0, CLEAR + NAME_PX / 2]);
    expect(Math.round(places.get('M2')![0])).toBe(CLEAR + nameWidth('M2') / 2);
  });

  it.each([60, 80, 120])('cover no other name and no monitor, %i px apart', (step) => {
    const monitors = crowd(step);
    const places = namePlaces(monitors, SCREEN, CLEAR);
    const middle = ({ id, at }: Named): Place => [at[0] + places.get(id)![0], at[1] + places.get(id)![1]];
    const size = ({ id }: Named): Place => [nameWidth(id), NAME_PX];
    for (const a of monitors) {
      for (const b of monitors) {
        if (a === b) continue;
        expect(overlap(middle(a), size(a), middle(b), size(b)), `${a.id} over the name of ${b.id}`).toBe(false);
        expect(overlap(middle(a), size(a), b.at, [BODY, BODY]), `${a.id} over ${b.id}`).toBe(false);
      }
    }
  });

  it('stay in the picture', () => {
    const pump = { ...named(1, [20, 860]), id: 'pumphouse-north-1' };
    const [x, y] = namePlaces([pump], SCREEN, CLEAR).get(pump.id)!;
    expect(pump.at[0] + x - nameWidth(pump.id) / 2).toBeGreaterThanOrEqual(0);
    expect(pump.at[1] + y + NAME_PX / 2).toBeLessThanOrEqual(SCREEN[1]);
  });

  it('do not jump in a crowd while the barrels turn', () => {
    expect(namePlaces(crowd(70, 310), SCREEN, CLEAR)).toEqual(namePlaces(crowd(70), SCREEN, CLEAR));
  });
});
