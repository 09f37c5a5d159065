import { describe, expect, it } from 'vitest';
import { NAME_PX, namePlaces, nameWidth, type Named } from '../../src/parts/plan/names';
import type { Place } from '../../src/parts/geometry';

const AWAY = 45;
const BODY = 22;

const named = (n: number, at: Place, horizontal_arcmin = 0): Named => ({
  id: `M${n}`,
  at,
  heading: 0,
  horizontal_arcmin,
});

/** Twenty of them, in rows of five. */
const crowd = (step: number, turned = 0): Named[] =>
  Array.from({ length: 20 }, (_, n) => named(n + 1, [(n % 5) * step, Math.floor(n / 5) * step], turned));

function overlap(a: Place, [wa, ha]: Place, b: Place, [wb, hb]: Place): boolean {
  return Math.abs(a[0] - b[0]) < (wa + wb) / 2 && Math.abs(a[1] - b[1]) < (ha + hb) / 2;
}

describe('names on the plan', () => {
  it('stand behind the barrel when there is room', () => {
    const places = namePlaces([named(1, [0, 0]), named(2, [400, 0], 90 * 60)], AWAY);
    const [x, y] = places.get('M1')!;
    expect([Math.round(x), Math.round(y)]).toEqual([0, AWAY]);
    expect(Math.round(places.get('M2')![0])).toBe(AWAY);
  });

  it.each([60, 80, 120])('cover no other name and no monitor, %i px apart', (step) => {
    const monitors = crowd(step);
    const places = namePlaces(monitors, AWAY);
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

  it('do not jump in a crowd while the barrels turn', () => {
    expect(namePlaces(crowd(70, 3000), AWAY)).toEqual(namePlaces(crowd(70), AWAY));
  });
});
